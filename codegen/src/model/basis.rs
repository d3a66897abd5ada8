//! Polynomial bases of the fit.

use crate::graph::{ExprId, Graph};

/// A polynomial basis p(a, b) (Chamoret et al. 2008, eq. 13).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Basis {
    /// (1, a, b, a², ab, b²)
    Quadratic,
    /// (1, a, b)
    Linear,
}

/// Exponents of (a, b), degrees ascending.
const MONOMIALS: [(i32, i32); 6] = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)];

impl Basis {
    /// All bases.
    pub const ALL: [Self; 2] = [Self::Quadratic, Self::Linear];

    /// Number of basis functions, the smallest number of master nodes too.
    #[must_use]
    pub const fn size(self) -> usize {
        match self {
            Self::Quadratic => 6,
            Self::Linear => 3,
        }
    }

    /// Name in emitted code.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Quadratic => "quadratic",
            Self::Linear => "linear",
        }
    }

    /// Exponents of (a, b) of every basis function. With a function, all its derivatives are in the basis, so
    /// the fit does not depend on where the basis has its origin.
    #[must_use]
    pub fn monomials(self) -> &'static [(i32, i32)] {
        &MONOMIALS[..self.size()]
    }

    /// p(a, b)
    pub fn evaluate(self, g: &mut Graph, a: ExprId, b: ExprId) -> Vec<ExprId> {
        self.monomials()
            .iter()
            .map(|&(i, j)| {
                let (a, b) = (g.power(a, i), g.power(b, j));
                g.mul(a, b)
            })
            .collect()
    }

    /// Order in which the moment matrix is eliminated: highest degree first. The rows of the factorisation that
    /// belong to 1, a, b then come last, and a functional of those three alone has a 3 × 3 second derivative in
    /// the factor's coordinates.
    #[must_use]
    pub fn elimination_order(self) -> Vec<usize> {
        (0..self.size()).rev().collect()
    }
}
