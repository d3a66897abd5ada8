//! The average plane of the master nodes, which a co-moving frame follows.

use crate::graph::{ExprId, Graph, Scope, SymbolId, SymmetricSystem};
use crate::structure::Block;

/// The average plane as unknowns of the nodes.
pub(super) struct AveragePlane {
    pub block: Block,
    /// A node's offset (a, b, z) in the frame that turns with the plane, as variables.
    pub position: [ExprId; 3],
    /// The same variables as functions of the offset in the frame that is held, and of the turn.
    pub moving: Vec<(SymbolId, ExprId)>,
    /// No turn, the plane's height over the slave, and the offsets there.
    pub values: Vec<(SymbolId, ExprId)>,
}

impl AveragePlane {
    /// The plane n(θ)·x = c through the nodes minimises Σ ½ ω (z(θ) − c)² over its turn θ and its height c: [T9] and [T14]
    /// with the plane's height as an unknown, so that all is a sum over nodes. The weight ω of a node is a function of its
    /// offset, but not of the turn. The frame in use is that plane, θ = 0.
    pub fn declare(g: &mut Graph, offset: [ExprId; 3], weight: ExprId) -> Self {
        let theta = [g.variable("theta_1"), g.variable("theta_2")];
        let turned = turned_back(g, theta, offset);
        let position = ["a_turned", "b_turned", "z_turned"].map(|name| g.input(name, Scope::Node));
        let moving = position.iter().zip(turned).map(|(&x, turned)| (g.symbol_of(x), turned)).collect();

        let c = g.variable("plane_height");
        let distance = g.sub(turned[2], c);
        let square = g.mul(distance, distance);
        let half = g.constant(0.5);
        let half_weight = g.mul(half, weight);
        let energy = g.mul(half_weight, square);
        let unknowns = vec![theta[0], theta[1], c];
        let symbols: Vec<SymbolId> = unknowns.iter().map(|&x| g.symbol_of(x)).collect();

        let weighted = g.mul(weight, offset[2]);
        let (sum, total) = (g.sum(weighted), g.sum(weight));
        let mean = g.div(sum, total);
        let mean = g.bind("mean_height", mean);
        let zero = g.zero();
        let mut values = vec![(symbols[0], zero), (symbols[1], zero), (symbols[2], mean)];
        values.extend(position.iter().zip(offset).map(|(&x, offset)| (g.symbol_of(x), offset)));

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
        Self { block: Block { unknowns, residual, groups, system }, position, moving, values }
    }
}

/// Coordinates in a frame turned by θ about (t1, t2): X → exp(−[θ]) X, to second order in θ, which is all that first
/// and second derivatives at θ = 0 see.
fn turned_back(g: &mut Graph, theta: [ExprId; 2], x: [ExprId; 3]) -> [ExprId; 3] {
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
