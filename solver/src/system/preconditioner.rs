//! What stands for K⁻¹ in an iterative solution.

use super::contact_rows::ContactRows;
use super::multigrid::{Geometry, Multigrid, norm};
use super::stiff::{StiffContact, softened, softening};
use super::{BlockMatrix, Equations, Symmetry, SystemError};

/// Multigrid, and beside it the factors of what stiff contact couples.
pub struct Preconditioner {
    stiff: Option<(BlockMatrix, StiffContact)>,
    multigrid: Multigrid,
}

impl Preconditioner {
    /// For a matrix with at least one equation.
    ///
    /// # Errors
    /// Those of [`Multigrid`] and [`StiffContact`].
    pub fn new(
        matrix: &BlockMatrix,
        equations: &Equations,
        symmetry: Symmetry,
        geometry: Geometry<'_>,
    ) -> Result<Self, SystemError> {
        let active = equations.free();
        let rows = ContactRows::new(matrix.view(), geometry.before, &active);
        let stiff = match softening(&rows) {
            Some(factors) => {
                let stiff = StiffContact::new(&rows, &factors, symmetry, equations)?;
                Some((softened(matrix, &rows, &factors), stiff))
            }
            None => None,
        };
        let soft = stiff.as_ref().map_or(matrix, |(soft, _)| soft);
        let multigrid = Multigrid::new(soft, equations, symmetry, geometry)?;
        Ok(Self { stiff, multigrid })
    }

    /// About K⁻¹ r, 0 where prescribed; of the matrix that it was made for.
    ///
    /// # Errors
    /// No memory.
    pub fn apply(
        &mut self,
        matrix: &BlockMatrix,
        equations: &Equations,
        right: &[[f64; 3]],
    ) -> Result<Vec<[f64; 3]>, SystemError> {
        let Self { stiff, multigrid } = self;
        match stiff {
            Some((soft, stiff)) => stiff.apply(equations, right, |left| multigrid.apply(soft, left)),
            None => multigrid.apply(matrix, right),
        }
    }

    /// The norm of what is left of a right-hand side once stiff contact has taken up its part.
    ///
    /// # Errors
    /// No memory.
    pub fn left(&mut self, equations: &Equations, right: &[[f64; 3]]) -> Result<f64, SystemError> {
        match &mut self.stiff {
            Some((_, stiff)) => Ok(norm(&stiff.take_up(equations, right)?.1)),
            None => Ok(norm(right)),
        }
    }

    /// Levels of multigrid.
    pub fn levels(&self) -> usize {
        self.multigrid.levels()
    }

    /// Memory without that of factors, bytes.
    pub fn bytes(&self) -> usize {
        let stiff = self.stiff.as_ref().map_or(0, |(soft, stiff)| soft.bytes() + stiff.bytes());
        stiff + self.multigrid.bytes()
    }
}
