//! The coordinates a sum over nodes depends on: global, local, and local in a frame that moves.

use super::follower::Follower;
use crate::graph::{ExprId, Graph, Scope, SymbolId};

/// How local node coordinates depend on the global ones. The map is linear in the nodes' positions relative
/// to the slave, so all quantities are invariant under translation and the slave's derivatives are the negative
/// sums of the masters'.
#[derive(Clone, Debug)]
pub struct CoordinateMap {
    /// Bound symbols of the local coordinates, with what moves with them.
    local: Vec<Follower>,
    /// Variables of node scope that are functions of the local coordinates and of unknowns.
    moving: Vec<(SymbolId, ExprId)>,
    /// ∂(local coordinate)/∂(global coordinate), element expressions.
    jacobian: Vec<[ExprId; 3]>,
}

impl CoordinateMap {
    /// Derives the map from the definitions of the `local` coordinates.
    ///
    /// # Panics
    /// If a local coordinate is not bound, is not linear in the positions, or changes when node and slave move
    /// together.
    #[must_use]
    pub fn new(g: &mut Graph, local: &[ExprId], node: &[ExprId; 3], slave: &[ExprId; 3]) -> Self {
        let local: Vec<SymbolId> = local.iter().map(|&x| g.symbol_of(x)).collect();
        let jacobian = local
            .iter()
            .map(|&coordinate| {
                let data = g.symbol_data(coordinate).clone();
                let definition = data.definition.expect("a local coordinate has a definition");
                std::array::from_fn(|axis| {
                    let (node, slave) = (g.symbol_of(node[axis]), g.symbol_of(slave[axis]));
                    let by_node = g.derivative(definition, node);
                    let by_slave = g.derivative(definition, slave);
                    assert_eq!(
                        g.scope(by_node),
                        Scope::Element,
                        "{} is not linear in the positions",
                        data.name
                    );
                    assert_eq!(g.neg(by_slave), by_node, "{} is not invariant under translation", data.name);
                    by_node
                })
            })
            .collect();
        let local = local.into_iter().map(Follower::new).collect();
        Self { local, moving: Vec::new(), jacobian }
    }

    /// Adds variables that move: node variables X = X(local coordinates, unknowns) that expressions may contain in
    /// place of the local coordinates. Derivatives by X are taken once, and their chain rule is the same for
    /// coordinates and unknowns. `values` are those of the unknowns, where everything is evaluated.
    #[must_use]
    pub fn with_moving(
        mut self,
        g: &mut Graph,
        moving: &[(SymbolId, ExprId)],
        values: &[(SymbolId, ExprId)],
    ) -> Self {
        self.moving = moving.to_vec();
        for coordinate in &mut self.local {
            for &(variable, position) in moving {
                let change = g.derivative(position, coordinate.parameter());
                let change = g.substitute(change, values);
                coordinate.follow([(variable, change)]);
            }
        }
        self
    }

    /// Number of local coordinates.
    pub(super) fn dimension(&self) -> usize {
        self.local.len()
    }

    /// The variables that move.
    pub(super) fn moving_variables(&self) -> Vec<SymbolId> {
        self.moving.iter().map(|&(variable, _)| variable).collect()
    }

    /// An unknown, with the variables that move with it.
    pub(super) fn follower(&self, g: &mut Graph, unknown: ExprId) -> Follower {
        let unknown = g.symbol_of(unknown);
        let mut follower = Follower::new(unknown);
        for &(variable, position) in &self.moving {
            let change = g.derivative(position, unknown);
            follower.follow([(variable, change)]);
        }
        follower
    }

    /// Derivatives of a node expression by the local coordinates.
    pub(super) fn partial_derivatives(&self, g: &mut Graph, expr: ExprId) -> Vec<ExprId> {
        self.local.iter().map(|coordinate| coordinate.total_derivative(g, expr)).collect()
    }

    /// Global gradient of a node expression of the local coordinates.
    pub(super) fn gradient(&self, g: &mut Graph, expr: ExprId) -> [ExprId; 3] {
        let partial = self.partial_derivatives(g, expr);
        self.pull_back(g, &partial)
    }

    /// Jᵀ v for a vector v of derivatives by the local coordinates.
    pub(super) fn pull_back(&self, g: &mut Graph, partial: &[ExprId]) -> [ExprId; 3] {
        std::array::from_fn(|axis| {
            let column: Vec<ExprId> = self.jacobian.iter().map(|row| row[axis]).collect();
            g.dot(&column, partial)
        })
    }

    /// Global Hessian of a node expression of the local coordinates.
    pub(super) fn hessian(&self, g: &mut Graph, expr: ExprId) -> [[ExprId; 3]; 3] {
        // One order of differentiation for both of a pair of mixed derivatives, so that they are one expression.
        let second = |g: &mut Graph, i: usize, j: usize| {
            let first = self.local[i.min(j)].total_derivative(g, expr);
            self.local[i.max(j)].total_derivative(g, first)
        };
        let half: Vec<[ExprId; 3]> = (0..self.local.len())
            .map(|i| {
                let partial: Vec<ExprId> = (0..self.local.len()).map(|j| second(g, i, j)).collect();
                self.pull_back(g, &partial)
            })
            .collect();
        let mut hessian = [[g.zero(); 3]; 3];
        for row in 0..3 {
            for column in 0..=row {
                let left: Vec<ExprId> = self.jacobian.iter().map(|j| j[row]).collect();
                let right: Vec<ExprId> = half.iter().map(|h| h[column]).collect();
                hessian[row][column] = g.dot(&left, &right);
                hessian[column][row] = hessian[row][column];
            }
        }
        hessian
    }
}
