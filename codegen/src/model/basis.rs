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

    /// What the pivots of the moment matrix are compared with, from its diagonal: the diagonal entries, but at least
    /// 10⁻⁴ (degree 1) or 10⁻⁸ (degree 2) of their sum over the degree. For nodes on one or two lines along the axes
    /// a diagonal entry is nothing but rounding, and no measure for the pivot.
    pub(super) fn pivot_references(self, g: &mut Graph, diagonal: &[ExprId]) -> Vec<ExprId> {
        let monomials = self.monomials();
        let degree = |k: usize| monomials[k].0 + monomials[k].1;
        (0..monomials.len())
            .map(|k| {
                if degree(k) == 0 {
                    return diagonal[k];
                }
                let same: Vec<ExprId> =
                    (0..monomials.len()).filter(|&j| degree(j) == degree(k)).map(|j| diagonal[j]).collect();
                let sum = g.total(&same);
                let part = g.constant(1e-4_f64.powi(degree(k)));
                let floor = g.mul(part, sum);
                g.name(floor, &format!("smallest_reference_{}", degree(k)));
                g.select_less(diagonal[k], floor, floor, diagonal[k])
            })
            .collect()
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
