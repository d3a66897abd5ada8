//! faer's sparse factorisations behind one shape each: a symbolic part made once, a numeric part for each matrix, solutions.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, IntranodeLbltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::linalg::lu::{LuRef, LuSymbolicParams, NumericLu, SymbolicLu, factorize_symbolic_lu};
use faer::sparse::linalg::{LuError, SupernodalThreshold};
use faer::sparse::{FaerError, SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side, Spec};

/// Memory that grows to the largest request.
#[derive(Default)]
struct Workspace {
    buffer: Option<(MemBuffer, StackReq)>,
}

/// P (A) Pᵀ = L B Lᵀ with blocks of B of size 1 and 2, pivots chosen by Bunch and Kaufman among the columns of a supernode.
pub(super) struct SymmetricFactor {
    symbolic: SymbolicCholesky<u32>,
    values: Vec<f64>,
    subdiagonal: Vec<f64>,
    /// The order of pivots within the supernodes.
    forward: Vec<u32>,
    inverse: Vec<u32>,
    workspace: Workspace,
}

/// A block of B.
enum Pivot {
    One(f64),
    /// The determinant is that of the block over its largest entry.
    Two {
        first: f64,
        determinant: f64,
        largest: f64,
    },
}

/// P A Q = L U with partial pivoting.
pub(super) struct GeneralFactor {
    symbolic: SymbolicLu<u32>,
    numeric: NumericLu<u32, f64>,
    workspace: Workspace,
}

impl Workspace {
    fn stack(&mut self, request: StackReq) -> Result<&mut MemStack, FaerError> {
        let fits = |(_, held): &(MemBuffer, StackReq)| {
            held.size_bytes() >= request.size_bytes() && held.align_bytes() >= request.align_bytes()
        };
        if !self.buffer.as_ref().is_some_and(fits) {
            // The old one goes first: the two need not exist side by side.
            self.buffer = None;
            let buffer = MemBuffer::try_new(request).map_err(|_| FaerError::OutOfMemory)?;
            self.buffer = Some((buffer, request));
        }
        let (buffer, _) = self.buffer.as_mut().ok_or(FaerError::OutOfMemory)?;
        Ok(MemStack::new(buffer))
    }
}

impl SymmetricFactor {
    pub fn new(pattern: SymbolicSparseColMatRef<'_, u32>) -> Result<Self, FaerError> {
        // The simplicial variant does not pivot.
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..CholeskySymbolicParams::default()
        };
        let symbolic = factorize_symbolic_cholesky(pattern, Side::Lower, SymmetricOrdering::Amd, parameters)?;
        let size = symbolic.nrows();
        Ok(Self {
            values: Vec::new(),
            subdiagonal: vec![0.0; size],
            forward: vec![0; size],
            inverse: vec![0; size],
            symbolic,
            workspace: Workspace::default(),
        })
    }

    /// Gives the memory of the factors back; their structure stays.
    pub fn release(&mut self) {
        self.values = Vec::new();
        self.workspace = Workspace::default();
    }

    /// Factorises the lower triangle. A singular matrix is no error: [`SymmetricFactor::smallest_pivot`] tells.
    pub fn factorise(&mut self, matrix: SparseColMatRef<'_, u32, f64>, par: Par) -> Result<(), FaerError> {
        let length = self.symbolic.len_val();
        self.values.try_reserve_exact(length - self.values.len()).map_err(|_| FaerError::OutOfMemory)?;
        self.values.resize(length, 0.0);
        let request = self.symbolic.factorize_numeric_intranode_lblt_scratch::<f64>(par, Spec::default());
        self.symbolic.factorize_numeric_intranode_lblt(
            &mut self.values,
            &mut self.subdiagonal,
            &mut self.forward,
            &mut self.inverse,
            matrix,
            Side::Lower,
            par,
            self.workspace.stack(request)?,
            Spec::default(),
        );
        Ok(())
    }

    /// The smallest ratio of a pivot to a reference for its row, such as the matrix's diagonal entry; 0 if one is not finite. Rounding makes
    /// it the machine's precision where it should be zero. Of a pivot of two rows the smaller eigenvalue is meant, about.
    pub fn smallest_pivot(&self, references: &[f64]) -> f64 {
        let order = self.symbolic.perm();
        let reference_at = |column: usize| {
            let ordered = self.forward[column] as usize;
            let original = order.map_or(ordered, |order| order.arrays().0[ordered] as usize);
            references[original].abs()
        };
        let mut smallest = f64::INFINITY;
        let is_known = self.for_each_pivot(|column, pivot| {
            let (pivot, reference) = match pivot {
                Pivot::One(pivot) => (pivot.abs(), reference_at(column)),
                Pivot::Two { determinant, largest, .. } => {
                    (determinant.abs() * largest, reference_at(column).max(reference_at(column + 1)))
                }
            };
            let ratio = pivot / reference;
            smallest = if ratio.is_nan() || pivot.is_infinite() { 0.0 } else { smallest.min(ratio) };
        });
        if is_known { smallest } else { 0.0 }
    }

    /// How many eigenvalues are negative: by Sylvester's law of inertia as many as of B.
    pub fn negative(&self) -> Option<usize> {
        let mut count = 0;
        let is_known = self.for_each_pivot(|_, pivot| {
            count += match pivot {
                Pivot::One(pivot) => usize::from(pivot < 0.0),
                Pivot::Two { determinant, .. } if determinant < 0.0 => 1,
                Pivot::Two { first, .. } => 2 * usize::from(first < 0.0),
            };
        });
        is_known.then_some(count)
    }

    /// Hands over the pivots with their first columns; whether they are known, which those of diagonal matrices are not.
    fn for_each_pivot(&self, mut f: impl FnMut(usize, Pivot)) -> bool {
        let SymbolicCholeskyRaw::Supernodal(supernodes) = self.symbolic.raw() else { return false };
        for s in 0..supernodes.n_supernodes() {
            let begin = supernodes.supernode_begin()[s] as usize;
            let end = supernodes.supernode_end()[s] as usize;
            let first = supernodes.col_ptr_for_val()[s] as usize;
            let entries = supernodes.col_ptr_for_val()[s + 1] as usize - first;
            let rows = entries.checked_div(end - begin).unwrap_or(0);
            let pivot_at = |column: usize| self.values[first + (column - begin) * (rows + 1)];
            let mut column = begin;
            while column < end {
                let (pivot, width) = match self.subdiagonal[column] {
                    0.0 => (Pivot::One(pivot_at(column)), 1),
                    beside => {
                        let (x, y) = (pivot_at(column), pivot_at(column + 1));
                        let largest = x.abs().max(y.abs()).max(beside.abs());
                        let determinant = (x / largest) * (y / largest) - (beside / largest).powi(2);
                        (Pivot::Two { first: x, determinant, largest }, 2)
                    }
                };
                f(column, pivot);
                column += width;
            }
        }
        true
    }

    pub fn solve(&mut self, x: &mut [f64], par: Par) -> Result<(), FaerError> {
        let size = x.len();
        let request = self.symbolic.solve_in_place_scratch::<f64>(1, par);
        let pivots = PermRef::new_checked(&self.forward, &self.inverse, size);
        IntranodeLbltRef::new(&self.symbolic, &self.values, &self.subdiagonal, pivots)
            .solve_in_place_with_conj(
                Conj::No,
                MatMut::from_column_major_slice_mut(x, size, 1),
                par,
                self.workspace.stack(request)?,
            );
        Ok(())
    }
}

impl GeneralFactor {
    pub fn new(pattern: SymbolicSparseColMatRef<'_, u32>) -> Result<Self, FaerError> {
        let symbolic = factorize_symbolic_lu(pattern, LuSymbolicParams::default())?;
        Ok(Self { symbolic, numeric: NumericLu::new(), workspace: Workspace::default() })
    }

    /// Gives the memory of the factors back; their structure stays.
    pub fn release(&mut self) {
        (self.numeric, self.workspace) = (NumericLu::new(), Workspace::default());
    }

    pub fn factorise(&mut self, matrix: SparseColMatRef<'_, u32, f64>, par: Par) -> Result<(), LuError> {
        let request = self.symbolic.factorize_numeric_lu_scratch::<f64>(par, Spec::default());
        let stack = self.workspace.stack(request).map_err(LuError::Generic)?;
        self.symbolic.factorize_numeric_lu(&mut self.numeric, matrix, par, stack, Spec::default())?;
        Ok(())
    }

    pub fn solve(&mut self, x: &mut [f64], par: Par) -> Result<(), FaerError> {
        let size = x.len();
        let request = self.symbolic.solve_in_place_scratch::<f64>(1, par);
        LuRef::new_unchecked(&self.symbolic, &self.numeric).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(x, size, 1),
            par,
            self.workspace.stack(request)?,
        );
        Ok(())
    }
}
