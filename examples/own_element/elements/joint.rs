//! A chain of links in equilibrium: five angles at which its energy is stationary, and its tip's compliance.

use diffuse_contact_codegen::expr::{Expr, Vec2, Vector, total};
use diffuse_contact_codegen::{ElementModel, Limits};

/// Links of length l with springs of a stiffness in the joints between them, under a force F at the tip: V(θ) = Σ ½ k (θ_i − θ_{i−1})² − F·x(θ),
/// stationary in θ. The derivatives of that value by F are minus the tip's position and minus its compliance.
pub fn chain<'g>(m: &ElementModel<'g>) {
    m.title("A chain of five links with springs in its joints, in equilibrium.");
    let force: Vec2<'g> = m.variable("force");
    let (length, stiffness, start): (Expr<'g>, Vector<'g, 5>, Vector<'g, 5>) =
        (m.parameter("length"), m.parameter("stiffness"), m.parameter("start"));
    let energy = |angle: Vector<'g, 5>| {
        let turn = |k: usize| if k == 0 { angle[0] } else { angle[k] - angle[k - 1] };
        let springs = total((0..5).map(|k| 0.5 * stiffness[k] * turn(k).powi(2)));
        let tip = Vector([total(angle.map(Expr::cos).0), total(angle.map(Expr::sin).0)]) * length;
        springs - force.dot(tip)
    };
    let found = m.stationary_from("angle", start, Limits::default(), energy);
    m.energy(energy(found.unknowns));
    m.value("angles", found.unknowns);
    m.value("angles_residual", found.residual);
    m.describe("start", "Angles near the equilibrium, such as those under a force before.");
    m.describe("angles_residual", "Below 1e-12, or there is no equilibrium near the start.");
}
