//! A law with history: tractions that have no energy, their Jacobian, and the new state.

use diffuse_contact_codegen::ElementModel;
use diffuse_contact_codegen::expr::Vec3;

/// Damage grows with the largest opening so far and does not heal.
pub fn exponential(m: &ElementModel<'_>) {
    m.title("A cohesive law with damage.");
    let opening: Vec3<'_> = m.variable("opening");
    let [stiffness, length, before] = m.parameters(["stiffness", "length", "damage_before"]);
    let damage = m.define("damage", (1.0 - (-opening.norm() / length).exp()).max(before));
    m.residual("traction", (1.0 - damage) * stiffness * opening);
    m.value("damage", damage);
    m.product();
}
