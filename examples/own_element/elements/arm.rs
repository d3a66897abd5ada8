//! Outside mechanics of solids: where the tip of a robot's arm with seven axes is, with all first and second derivatives.

use diffuse_contact_codegen::ElementModel;
use diffuse_contact_codegen::expr::{Expr, Vec3};

/// Denavit and Hartenberg's parameters of each axis: offset d along it, in metres, and a quarter of a turn towards the next, by its sign.
const AXES: [(f64, f64); 7] =
    [(0.34, -1.0), (0.0, 1.0), (0.4, 1.0), (0.0, -1.0), (0.4, -1.0), (0.0, 1.0), (0.126, 0.0)];

/// The tip's position by the seven angles, and the Hessian of its component in a direction: with multipliers as the direction that is
/// what an optimiser under the constraint "the tip is there" adds to its own.
pub fn seven_axes(m: &ElementModel<'_>) {
    m.title("Position of the tip of an arm with seven axes.");
    let (angles, direction): ([Expr<'_>; 7], Vec3<'_>) = (m.variable("angle"), m.parameter("direction"));
    let mut tip = Vec3::zero(m.sheet());
    for (&(d, turn), angle) in AXES.iter().zip(angles).rev() {
        let [x, y, z] = if turn == 0.0 { tip.0 } else { [tip[0], -turn * tip[2], turn * tip[1]] };
        let (c, s) = (angle.cos(), angle.sin());
        tip = Vec3::from_fn(|k| [c * x - s * y, s * x + c * y, z + d][k]);
    }
    m.residual("position", tip);
    m.energy(direction.dot(tip));
    m.product();
    m.describe("direction", "Weights of the components that the Hessian is of.");
    m.describe("position", "The tip, metres.");
}
