//! The average plane of the master nodes, which a co-moving frame follows.

use crate::expr::{Expr, System, Values, Vec2, Vec3, Vector};
use crate::graph::{Scope, SymmetricSystem};
use crate::structure::{Block, Elimination};

/// The average plane as unknowns of the nodes.
pub(super) struct AveragePlane<'g> {
    pub block: Block<'g>,
    /// The system of the plane's turn and height.
    pub system: System<'g>,
    /// A node's offset (a, b, z) in the frame that turns with the plane, as variables.
    pub position: Vec3<'g>,
    /// The same variables as functions of the offset in the frame that is held, and of the turn.
    pub moving: Values<'g>,
    /// No turn, the plane's height over the slave, and the offsets there.
    pub values: Values<'g>,
}

impl<'g> AveragePlane<'g> {
    /// The plane n(θ)·x = c through the nodes minimises Σ ½ ω (z(θ) − c)² over its turn θ and its height c: [T14] with
    /// the plane's height as an unknown, so that all is a sum over nodes. The weight ω of a node does not depend on the
    /// turn; `values` are those of variables it depends on. The frame in use is that plane, θ = 0.
    pub fn declare(offset: Vec3<'g>, omega: Expr<'g>, values: Values<'g>) -> Self {
        let sheet = omega.sheet();
        let theta = sheet.variables(["theta_1", "theta_2"]);
        let turned = turned_back(theta, offset);
        let position =
            Vector(["a_turned", "b_turned", "z_turned"].map(|name| sheet.input(name, Scope::Node)));

        let c = sheet.variable("plane_height");
        let energy = 0.5 * omega * (turned[2] - c).powi(2);
        let unknowns = Vector([theta[0], theta[1], c]);

        let omega = omega.at(&values);
        let mean = ((omega * offset[2]).sum() / omega.sum()).bind("mean_height");
        let no_turn = Vector([sheet.zero(), sheet.zero(), mean]);
        let values = [values, unknowns.set_to(no_turn), position.set_to(offset)].concat();

        let derivatives = energy.gradient(unknowns);
        let residual = (-derivatives).to_vec();
        let entry = |i: usize, j: usize| {
            derivatives[i].by(unknowns[j]).at(&values).sum().named(&format!("plane_{i}_{j}"))
        };
        let matrix: Vec<Vec<_>> = (0..3).map(|i| (0..=i).map(|j| entry(i, j)).collect()).collect();
        // The height first: the fit does not depend on it, which leaves a zero column in the coupling.
        let system = sheet.system(SymmetricSystem::of("plane_l", &matrix, vec![2, 0, 1]));
        let elimination = Elimination::Symmetric(system);
        let block = Block { unknowns: unknowns.to_vec(), residual, groups: vec![3], system: elimination };
        Self { block, system, position, moving: position.set_to(turned), values }
    }
}

/// Coordinates in a frame turned by θ about (t1, t2): X → exp(−[θ]) X, to second order in θ, which is all that first
/// and second derivatives at θ = 0 see.
pub(super) fn turned_back<'g>(theta: Vec2<'g>, x: Vec3<'g>) -> Vec3<'g> {
    let axis = Vector([theta[0], theta[1], theta[0].sheet().zero()]);
    let once = axis.cross(x);
    let twice = axis.cross(once);
    x - once + 0.5 * twice
}
