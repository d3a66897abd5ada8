//! Shapes of facets: parametric coordinates and shape functions.

use crate::graph::{ExprId, Graph, SymbolId};

/// Shape of a facet with corner nodes only.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum FacetShape {
    /// Three corners, linear.
    Triangle,
    /// Four corners, bilinear.
    Quadrilateral,
}

impl FacetShape {
    /// All shapes.
    pub const ALL: [Self; 2] = [Self::Triangle, Self::Quadrilateral];

    /// Name in emitted code.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Triangle => "triangle",
            Self::Quadrilateral => "quadrilateral",
        }
    }

    /// Number of corners n.
    #[must_use]
    pub const fn corners(self) -> usize {
        match self {
            Self::Triangle => 3,
            Self::Quadrilateral => 4,
        }
    }

    /// Exponents of u in the monomials 1, u_1, u_2 and, for the quadrilateral, u_1 u_2: the shape functions' span, which
    /// contains their derivatives.
    pub(super) fn monomials(self) -> &'static [(usize, usize)] {
        &[(0, 0), (1, 0), (0, 1), (1, 1)][..self.corners()]
    }

    /// Parametric coordinates of the corners, with the centre at 0 and edges of length 1.
    pub(super) fn parametric_corners(self) -> &'static [[f64; 2]] {
        const THIRD: f64 = 1.0 / 3.0;
        match self {
            Self::Triangle => &[[-THIRD, -THIRD], [2.0 * THIRD, -THIRD], [-THIRD, 2.0 * THIRD]],
            Self::Quadrilateral => &[[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]],
        }
    }

    /// N_i(u)
    pub(super) fn shape_functions(self, g: &mut Graph, u: [ExprId; 2]) -> Vec<ExprId> {
        match self {
            Self::Triangle => {
                let third = g.constant(1.0 / 3.0);
                let rest = g.sub(third, u[0]);
                vec![g.sub(rest, u[1]), g.add(third, u[0]), g.add(third, u[1])]
            }
            Self::Quadrilateral => {
                let half = g.constant(0.5);
                self.parametric_corners()
                    .iter()
                    .map(|corner| {
                        // 1 at the side of the corner, 0 at the other.
                        let [a, b] = [0, 1].map(|k| {
                            let away = if corner[k] < 0.0 { g.neg(u[k]) } else { u[k] };
                            g.add(half, away)
                        });
                        g.mul(a, b)
                    })
                    .collect()
            }
        }
    }

    /// (ξ, η) as usual: area coordinates 0 … 1 of a triangle, −1 … 1 of a quadrilateral.
    pub(super) fn natural(self, g: &mut Graph, u: [ExprId; 2]) -> [ExprId; 2] {
        match self {
            Self::Triangle => {
                let third = g.constant(1.0 / 3.0);
                u.map(|u| g.add(u, third))
            }
            Self::Quadrilateral => {
                let two = g.constant(2.0);
                u.map(|u| g.mul(two, u))
            }
        }
    }

    /// φ(u)
    pub(super) fn evaluate_monomials(self, g: &mut Graph, u: [ExprId; 2]) -> Vec<ExprId> {
        let one = g.one();
        self.monomials()
            .iter()
            .map(|&(i, j)| {
                let a = if i == 1 { u[0] } else { one };
                let b = if j == 1 { u[1] } else { one };
                g.mul(a, b)
            })
            .collect()
    }

    /// Coefficients of a function in the span of the monomials when these have their origin at `at`: its derivatives
    /// there.
    pub(super) fn taylor_coefficients(
        self,
        g: &mut Graph,
        function: ExprId,
        u: [SymbolId; 2],
        at: [ExprId; 2],
    ) -> Vec<ExprId> {
        let at = [(u[0], at[0]), (u[1], at[1])];
        self.monomials()
            .iter()
            .map(|&(i, j)| {
                let by_first = (0..i).fold(function, |f, _| g.derivative(f, u[0]));
                let derivative = (0..j).fold(by_first, |f, _| g.derivative(f, u[1]));
                g.substitute(derivative, &at)
            })
            .collect()
    }
}
