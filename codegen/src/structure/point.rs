//! A point besides the nodes that a quantity depends on, such as the anchor of a contact with friction.
//!
//! The residuals of the unknowns do not depend on it: its rows of B are zero. Otherwise it takes part in the Lagrangian as a
//! node does, with G in the place of λ·ρ, and moves with the outer unknowns as a node does.

use super::coordinates::CoordinateMap;
use super::node_problem::{Block, Functional};
use crate::expr::{Expr, Mat3, Values, Vec3};

/// How a quantity G(α, y) depends on a point y. Everything is of element scope.
#[derive(Clone, Debug)]
pub struct PointDependence<'g> {
    /// G as a function of the point's local coordinates, α held.
    pub value: Expr<'g>,
    /// ∂G/∂α as functions of the point's local coordinates.
    pub by_unknowns: Vec<Expr<'g>>,
    /// The point's coordinates, with what moves with them.
    pub coordinates: CoordinateMap<'g>,
    /// Values of symbols that are variables while differentiating.
    pub values: Values<'g>,
}

/// The point's part of a Hessian of low rank; its rows of B̂ are zero.
pub(super) struct PointRows<'g> {
    /// Rows of Ĉ.
    pub c: Vec<Vec3<'g>>,
    /// ∂²G/∂y².
    pub own: Mat3<'g>,
}

impl<'g> PointDependence<'g> {
    /// dG/dy, named.
    pub(super) fn gradient(&self, functional: &Functional<'g>) -> Vec3<'g> {
        let gradient = self.coordinates.gradient(self.value).at(&self.values);
        gradient.named(&format!("d{}_dpoint", functional.name))
    }

    /// df/dθ of an expression in the point's coordinates, which θ moves.
    pub(super) fn total_derivative(&self, f: Expr<'g>, theta: Expr<'g>) -> Expr<'g> {
        self.coordinates.follower(theta).total_derivative(f)
    }

    /// The same at the values.
    pub(super) fn change(&self, f: Expr<'g>, theta: Expr<'g>) -> Expr<'g> {
        self.total_derivative(f, theta).at(&self.values)
    }

    /// The point's rows of a block of the unknowns of interest.
    pub(super) fn rows(&self, block: &Block<'g>) -> PointRows<'g> {
        let own = self.coordinates.hessian(self.value).at(&self.values);
        PointRows { c: self.factor(block, &self.by_unknowns), own: own.named("point_own") }
    }

    /// S L⁻¹C of a block for C = ∂v/∂y, as of a node; C where the block has no symmetric system.
    pub(super) fn factor(&self, block: &Block<'g>, v: &[Expr<'g>]) -> Vec<Vec3<'g>> {
        let gradients: Vec<Vec3<'g>> =
            v.iter().map(|&v| self.coordinates.gradient(v).at(&self.values)).collect();
        let columns: [Vec<Expr<'g>>; 3] = [0, 1, 2].map(|axis| {
            let column: Vec<Expr<'g>> = gradients.iter().map(|row| row[axis]).collect();
            block.system.right(&column)
        });
        let row = |k: usize| Vec3::from_fn(|axis| block.system.signed(k, columns[axis][k]));
        (0..v.len()).map(|k| row(k).named("c_point")).collect()
    }
}
