//! What derivatives are asked of: unknowns defined by sums over nodes, quantities of them, and the derivatives that come out.

use super::coordinates::CoordinateMap;
use super::elimination::Elimination;
use super::factors::{ScaledVector, common_factor};
use super::point::PointDependence;
use crate::expr::{Expr, Values};
use crate::graph::ExprId;

/// Unknowns y defined by a sum over nodes, Σ ρ(y, …; xᵢ) = 0.
#[derive(Clone, Debug)]
pub struct Block<'g> {
    /// The unknowns, symbols.
    pub unknowns: Vec<Expr<'g>>,
    /// A node's term ρ in the residuals.
    pub residual: Vec<Expr<'g>>,
    /// Numbers of consecutive residuals, those of a group along one vector: common factors are sought within groups.
    pub groups: Vec<usize>,
    /// A = −∂r/∂y.
    pub system: Elimination<'g>,
}

impl<'g> Block<'g> {
    /// A vector of residuals' length as the sum of its groups' parts.
    pub(super) fn split(&self, vector: &[Expr<'g>]) -> Vec<ScaledVector<'g>> {
        let mut start = 0;
        let part = |&size: &usize| {
            let rows = start..start + size;
            start += size;
            let ScaledVector { scale, direction: part } = common_factor(&vector[rows.clone()]);
            let mut direction = vec![scale.sheet().zero(); vector.len()];
            direction[rows].copy_from_slice(&part);
            ScaledVector { scale, direction }
        };
        self.groups.iter().map(part).collect()
    }
}

/// Unknowns defined by sums over nodes.
#[derive(Clone, Debug)]
pub struct NodeProblem<'g> {
    /// The unknowns α that the quantities of interest are functions of.
    pub block: Block<'g>,
    /// The unknowns θ that the residuals of the first ones depend on.
    pub outer: Option<Block<'g>>,
    /// The coordinates the residuals depend on.
    pub coordinates: CoordinateMap<'g>,
    /// Values of symbols that are variables while differentiating, put in afterwards.
    pub values: Values<'g>,
}

/// A quantity G(α), or G(α, y), of a [`NodeProblem`]'s unknowns.
#[derive(Clone, Debug)]
pub struct Functional<'g> {
    /// Name, used for the adjoint solution and the derivatives.
    pub name: String,
    /// ∂G/∂α.
    pub first: Vec<Expr<'g>>,
    /// ∂²G/∂α², of which the lower triangle is read.
    pub second: Vec<Vec<Expr<'g>>>,
    /// The point y that G depends on besides, if it does.
    pub point: Option<PointDependence<'g>>,
}

/// dG/dx by global coordinates.
#[derive(Clone, Debug)]
pub struct Gradient {
    /// By the slave's coordinates.
    pub slave: [ExprId; 3],
    /// By a master node's coordinates.
    pub node: [ExprId; 3],
    /// By the coordinates of the point that G depends on besides, if it does.
    pub point: Option<[ExprId; 3]>,
}

/// Λ = Λ₁ + Λ₂, a node expression in which the unknowns and the adjoint ones are variables of their own.
pub(super) struct Lagrangian<'g> {
    /// Λ₁ = λ·ρ₁
    pub inner: Expr<'g>,
    /// Λ₁ + μ·ρ₂
    pub total: Expr<'g>,
    /// μ·ρ₂
    pub outer: Expr<'g>,
}
