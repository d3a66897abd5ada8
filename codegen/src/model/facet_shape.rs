//! Shapes of facets: parametric coordinates and shape functions.

use crate::expr::{Expr, Vec2};

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
    pub(super) fn shape_functions(self, u: Vec2<'_>) -> Vec<Expr<'_>> {
        match self {
            Self::Triangle => {
                let third = u[0].sheet().number(1.0 / 3.0);
                vec![third - u[0] - u[1], third + u[0], third + u[1]]
            }
            Self::Quadrilateral => {
                let corners = self.parametric_corners().iter();
                // Of the two factors, each is 1 at the side of the corner, 0 at the other.
                let factor = |corner: &[f64; 2], k: usize| 0.5 + if corner[k] < 0.0 { -u[k] } else { u[k] };
                corners.map(|corner| factor(corner, 0) * factor(corner, 1)).collect()
            }
        }
    }

    /// (ξ, η) as usual: area coordinates 0 … 1 of a triangle, −1 … 1 of a quadrilateral.
    pub(super) fn natural(self, u: Vec2<'_>) -> Vec2<'_> {
        match self {
            Self::Triangle => u.map(|u| u + 1.0 / 3.0),
            Self::Quadrilateral => 2.0 * u,
        }
    }

    /// φ(u)
    pub(super) fn evaluate_monomials(self, u: Vec2<'_>) -> Vec<Expr<'_>> {
        let one = u[0].sheet().one();
        let factor = |exponent, u| if exponent == 1 { u } else { one };
        self.monomials().iter().map(|&(i, j)| factor(i, u[0]) * factor(j, u[1])).collect()
    }

    /// Coefficients of a function in the span of the monomials when these have their origin at `at`: its derivatives
    /// there.
    pub(super) fn taylor_coefficients<'g>(self, f: Expr<'g>, u: Vec2<'g>, at: Vec2<'g>) -> Vec<Expr<'g>> {
        let at = u.set_to(at);
        let times = |f: Expr<'g>, count, u| (0..count).fold(f, |f, _| f.by(u));
        self.monomials().iter().map(|&(i, j)| times(times(f, i, u[0]), j, u[1]).at(&at)).collect()
    }
}
