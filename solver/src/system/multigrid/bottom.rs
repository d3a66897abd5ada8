//! Small systems, solved directly: the coarsest level, and what stiff contact couples.

use faer::Par;
use faer::sparse::linalg::LuError;
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};

use super::sparse::Sparse;
use crate::system::condition::weakness;
use crate::system::factor::{GeneralFactor, SymmetricFactor};
use crate::system::{Symmetry, SystemError};

/// A pivot below this part of its diagonal entry is zero to rounding: a rigid motion costs nothing.
const SMALL_PIVOT: f64 = 1e-12;
/// So is one below this part of what its diagonal entry was made of. A body that nothing holds may have come down to one node, whose own
/// entries are rounding.
const ROUNDING: f64 = 1e-14;

/// Factors of a matrix.
pub struct Bottom<const N: usize> {
    factor: Factor,
    /// The unknowns: node and axis of each.
    places: Vec<(u32, u8)>,
    nodes: usize,
    equations: usize,
}

enum Factor {
    Symmetric(SymmetricFactor),
    General(GeneralFactor),
}

impl<const N: usize> Bottom<N> {
    /// Factorises. `scale`: what entries on the diagonal were made of, if that may be more than they are. `equations`: those of the finest level, for
    /// messages.
    ///
    /// # Errors
    /// A pivot that is zero to rounding, or a condition that leaves no digit; factors that do not fit into memory.
    pub fn new(
        matrix: &Sparse<N, N>,
        (active, scale): (&[[bool; N]], Option<&[[f64; N]]>),
        symmetry: Symmetry,
        equations: usize,
    ) -> Result<Self, SystemError> {
        let mut numbers = vec![[u32::MAX; N]; active.len()];
        let mut places = Vec::new();
        for (node, axes) in active.iter().enumerate() {
            for mode in (0..N).filter(|&mode| axes[mode]) {
                numbers[node][mode] = places.len() as u32;
                places.push((node as u32, mode as u8));
            }
        }
        // Columns of the matrix are rows of its transpose.
        let transposed = matrix.view().transposed();
        let (mut starts, mut rows, mut values) = (vec![0_u32], Vec::new(), Vec::new());
        let mut diagonal = vec![0.0; places.len()];
        for (column, &(node, mode)) in places.iter().enumerate() {
            for (other, block) in transposed.view().row(node as usize) {
                for (axis, &row) in numbers[other].iter().enumerate().filter(|&(_, &row)| row != u32::MAX) {
                    rows.push(row);
                    values.push(block[mode as usize][axis]);
                    if row as usize == column {
                        diagonal[column] = block[mode as usize][axis];
                    }
                }
            }
            starts.push(rows.len() as u32);
        }
        let too_large = SystemError::TooLarge { equations };
        let size = places.len();
        let symbolic = SymbolicSparseColMatRef::new_checked(size, size, &starts, None, &rows);
        let csc = SparseColMatRef::new(symbolic, &values[..]);
        let factor = match symmetry {
            Symmetry::Symmetric => {
                let mut factor = SymmetricFactor::new(symbolic).map_err(|_| too_large)?;
                factor.factorise(csc, Par::Seq).map_err(|_| too_large)?;
                let at = |scale: &[[f64; N]]| -> Vec<f64> {
                    places.iter().map(|&(node, mode)| scale[node as usize][mode as usize]).collect()
                };
                let scale = scale.map(|scale| (at(scale), ROUNDING));
                for (reference, least) in scale.into_iter().chain([(diagonal, SMALL_PIVOT)]) {
                    let pivot = factor.smallest_pivot(&reference);
                    if size > 0 && !(pivot > least) {
                        return Err(SystemError::Singular {
                            equations,
                            residual: 1.0,
                            condition: 1.0 / pivot,
                        });
                    }
                }
                Factor::Symmetric(factor)
            }
            Symmetry::General => Factor::General(general(csc, equations)?),
        };
        Ok(Self { factor, places, nodes: active.len(), equations })
    }

    /// The solution. Memory for it was there when the factors were made.
    ///
    /// # Errors
    /// No memory.
    pub fn solve(&mut self, right: &[[f64; N]]) -> Result<Vec<[f64; N]>, SystemError> {
        let too_large = SystemError::TooLarge { equations: self.equations };
        let mut x: Vec<f64> =
            self.places.iter().map(|&(node, mode)| right[node as usize][mode as usize]).collect();
        match &mut self.factor {
            Factor::Symmetric(factor) => factor.solve(&mut x, Par::Seq),
            Factor::General(factor) => factor.solve(&mut x, Par::Seq),
        }
        .map_err(|_| too_large)?;
        let mut solution = vec![[0.0; N]; self.nodes];
        for (&(node, mode), value) in self.places.iter().zip(x) {
            solution[node as usize][mode as usize] = value;
        }
        Ok(solution)
    }
}

/// Factors of a matrix. Of their pivots nothing is known: its weakest direction tells whether they are of use.
fn general(matrix: SparseColMatRef<'_, u32, f64>, equations: usize) -> Result<GeneralFactor, SystemError> {
    let too_large = SystemError::TooLarge { equations };
    let singular = |condition| SystemError::Singular { equations, residual: 1.0, condition };
    let mut factor = GeneralFactor::new(matrix.symbolic()).map_err(|_| too_large)?;
    factor.factorise(matrix, Par::Seq).map_err(|error| match error {
        LuError::SymbolicSingular { .. } => singular(f64::INFINITY),
        LuError::Generic(_) => too_large,
    })?;
    if matrix.ncols() > 0 {
        let least = weakness(matrix, |x| factor.solve(x, Par::Seq)).map_err(|_| too_large)?;
        if !(least > ROUNDING && least.is_finite()) {
            return Err(singular(if least.is_finite() { 1.0 / least } else { f64::INFINITY }));
        }
    }
    Ok(factor)
}
