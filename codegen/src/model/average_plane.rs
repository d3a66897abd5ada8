//! The average plane of the master nodes, which a co-moving frame follows.

use crate::graph::{ExprId, Graph, SymbolId, SymmetricSystem};
use crate::structure::Block;

/// The average plane as unknowns of the nodes.
pub(super) struct AveragePlane {
    pub block: Block,
    /// No turn, and the plane's height over the slave.
    pub values: Vec<(SymbolId, ExprId)>,
}

impl AveragePlane {
    /// The plane n(θ)·x = c through the nodes minimises Σ ½ (z(θ) − c)² over its turn θ and its height c: [T9] with the
    /// plane's height as an unknown, so that all is a sum over nodes. The frame in use is that plane, θ = 0.
    pub fn declare(g: &mut Graph, theta: [ExprId; 2], height: ExprId, turned_height: ExprId) -> Self {
        let c = g.variable("plane_height");
        let distance = g.sub(turned_height, c);
        let square = g.mul(distance, distance);
        let half = g.constant(0.5);
        let energy = g.mul(half, square);
        let unknowns = vec![theta[0], theta[1], c];
        let symbols: Vec<SymbolId> = unknowns.iter().map(|&x| g.symbol_of(x)).collect();

        let (sum, count) = (g.sum(height), g.node_count());
        let mean = g.div(sum, count);
        let mean = g.bind("mean_height", mean);
        let zero = g.zero();
        let values = vec![(symbols[0], zero), (symbols[1], zero), (symbols[2], mean)];

        let derivatives: Vec<ExprId> = symbols.iter().map(|&x| g.derivative(energy, x)).collect();
        let residual = derivatives.iter().map(|&x| g.neg(x)).collect();
        let matrix = (0..symbols.len())
            .map(|i| {
                (0..=i)
                    .map(|j| {
                        let second = g.derivative(derivatives[i], symbols[j]);
                        let second = g.substitute(second, &values);
                        let sum = g.sum(second);
                        g.name(sum, &format!("plane_{i}_{j}"))
                    })
                    .collect()
            })
            .collect();
        // The height first: the fit does not depend on it, which leaves a zero column in the coupling.
        let system = g.add_system(SymmetricSystem::new("plane_l", matrix, vec![2, 0, 1]));
        let groups = vec![unknowns.len()];
        Self { block: Block { unknowns, residual, groups, system }, values }
    }
}

/// Coordinates in a frame turned by θ about (t1, t2): X → exp(−[θ]) X, to second order in θ, which is all that first
/// and second derivatives at θ = 0 see.
pub(super) fn turned_back(g: &mut Graph, theta: [ExprId; 2], x: [ExprId; 3]) -> [ExprId; 3] {
    let zero = g.zero();
    let axis = [theta[0], theta[1], zero];
    let once = cross(g, axis, x);
    let twice = cross(g, axis, once);
    let half = g.constant(0.5);
    std::array::from_fn(|k| {
        let first = g.sub(x[k], once[k]);
        let second = g.mul(half, twice[k]);
        g.add(first, second)
    })
}

pub(super) fn cross(g: &mut Graph, x: [ExprId; 3], y: [ExprId; 3]) -> [ExprId; 3] {
    std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let (left, right) = (g.mul(x[i], y[j]), g.mul(x[j], y[i]));
        g.sub(left, right)
    })
}
