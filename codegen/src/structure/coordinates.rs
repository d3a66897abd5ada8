//! The coordinates a sum over nodes depends on: global, local, and local in a frame that moves.

use super::follower::Follower;
use crate::expr::{Expr, Mat3, Values, Vec3, Vector, dot};
use crate::graph::Scope;

/// How local node coordinates depend on the global ones. The map is linear in the nodes' positions relative
/// to the slave, so all quantities are invariant under translation and the slave's derivatives are the negative
/// sums of the masters'.
#[derive(Clone, Debug)]
pub struct CoordinateMap<'g> {
    /// Bound symbols of the local coordinates, with what moves with them.
    local: Vec<Follower<'g>>,
    /// Variables of node scope that are functions of the local coordinates and of unknowns.
    moving: Values<'g>,
    /// J = ∂(local coordinate)/∂(global coordinate), element expressions.
    jacobian: Vec<Vec3<'g>>,
}

impl<'g> CoordinateMap<'g> {
    /// Derives the map from the definitions of the `local` coordinates.
    ///
    /// # Panics
    /// If a local coordinate is not bound, is not linear in the positions, or changes when node and slave move
    /// together.
    pub fn new(local: &[Expr<'g>], node: Vec3<'g>, slave: Vec3<'g>) -> Self {
        let jacobian = local.iter().map(|&x| {
            let definition = x.definition().expect("a local coordinate has a definition");
            Vector::from_fn(|axis| {
                let (by_node, by_slave) = (definition.by(node[axis]), definition.by(slave[axis]));
                assert_eq!(by_node.scope(), Scope::Element, "{x:?} is not linear in the positions");
                assert_eq!(-by_slave, by_node, "{x:?} is not invariant under translation");
                by_node
            })
        });
        let jacobian = jacobian.collect();
        Self { local: local.iter().copied().map(Follower::new).collect(), moving: Vec::new(), jacobian }
    }

    /// Adds variables that move: node variables X = X(local coordinates, unknowns) that expressions may contain in
    /// place of the local coordinates. Derivatives by X are taken once, and their chain rule is the same for
    /// coordinates and unknowns. `values` are those of the unknowns, where everything is evaluated.
    #[must_use]
    pub fn with_moving(mut self, moving: &[(Expr<'g>, Expr<'g>)], values: &[(Expr<'g>, Expr<'g>)]) -> Self {
        self.moving = moving.to_vec();
        for x in &mut self.local {
            let symbol = x.parameter();
            x.follow(moving.iter().map(|&(variable, position)| (variable, position.by(symbol).at(values))));
        }
        self
    }

    /// Number of local coordinates.
    pub(super) fn dimension(&self) -> usize {
        self.local.len()
    }

    /// The variables that move.
    pub(super) fn moving_variables(&self) -> impl Iterator<Item = Expr<'g>> {
        self.moving.iter().map(|&(variable, _)| variable)
    }

    /// An unknown, with the variables that move with it.
    pub(super) fn follower(&self, unknown: Expr<'g>) -> Follower<'g> {
        let mut follower = Follower::new(unknown);
        follower.follow(self.moving.iter().map(|&(variable, position)| (variable, position.by(unknown))));
        follower
    }

    /// Derivatives of a node expression by the local coordinates.
    pub(super) fn partial_derivatives(&self, f: Expr<'g>) -> Vec<Expr<'g>> {
        self.local.iter().map(|x| x.total_derivative(f)).collect()
    }

    /// Global gradient of a node expression of the local coordinates.
    pub(super) fn gradient(&self, f: Expr<'g>) -> Vec3<'g> {
        self.pull_back(&self.partial_derivatives(f))
    }

    /// Jᵀ v for a vector v of derivatives by the local coordinates.
    pub(super) fn pull_back(&self, partial: &[Expr<'g>]) -> Vec3<'g> {
        Vector::from_fn(|axis| dot(self.column(axis), partial))
    }

    fn column(&self, axis: usize) -> impl Iterator<Item = Expr<'g>> {
        self.jacobian.iter().map(move |row| row[axis])
    }

    /// Global Hessian of a node expression of the local coordinates.
    pub(super) fn hessian(&self, f: Expr<'g>) -> Mat3<'g> {
        let x = &self.local;
        // One order of differentiation for both of a pair of mixed derivatives, so that they are one expression.
        let second = |i: usize, j: usize| x[i.max(j)].total_derivative(x[i.min(j)].total_derivative(f));
        let row = |i: usize| -> Vec<Expr<'g>> { (0..x.len()).map(|j| second(i, j)).collect() };
        let half: Vec<Vec3<'g>> = (0..x.len()).map(|i| self.pull_back(&row(i))).collect();
        Mat3::symmetric(|row, column| dot(self.column(row), half.iter().map(|h| h[column])))
    }
}
