//! Contact of a node with a curved patch: its foot point is the root of two equations, its gap the distance along the normal there.

use diffuse_contact_codegen::ElementModel;
use diffuse_contact_codegen::expr::{Expr, Vec2, Vec3, Vector};

/// A biquadratic Bézier patch with control points P, nine of them, row by row, at ξ in [−1, 1]², by de Casteljau's algorithm.
fn patch<'g>(P: &[Vec3<'g>; 9], xi: Vec2<'g>) -> Vec3<'g> {
    let [s, t] = xi.0.map(|xi| 0.5 * (1.0 + xi));
    let between = |a: Vec3<'g>, b: Vec3<'g>, t: Expr<'g>| a + t * (b - a);
    let curve = |a, b, c, t| between(between(a, b, t), between(b, c, t), t);
    let [a, b, c] = [0, 3, 6].map(|row| curve(P[row], P[row + 1], P[row + 2], s));
    curve(a, b, c, t)
}

/// Penalty energy ½ ε ⟨−g⟩², g = ν·(x − x̄), of a slave node x with the foot x̄ = s(ξ), where s,₁·(x − s) = s,₂·(x − s) = 0.
pub fn bezier<'g>(m: &ElementModel<'g>) {
    m.title("Contact of a node with a biquadratic Bézier patch.");
    let (x, P): (Vec3<'g>, [Vec3<'g>; 9]) = (m.variable("x"), m.variable("P"));
    let stiffness = m.parameter::<Expr<'_>>("stiffness");
    let tangents = |xi: Vec2<'g>| [patch(&P, xi).by(xi[0]), patch(&P, xi).by(xi[1])];

    let foot = m.root("foot", |xi| Vector(tangents(xi).map(|tangent| tangent.dot(x - patch(&P, xi)))));
    let xi = foot.unknowns;
    let [t1, t2] = m.define("tangent", tangents(xi));
    let distance = m.define("distance", x - patch(&P, xi));
    let gap = m.define("gap", t1.cross(t2).unit().dot(distance));
    m.energy(0.5 * stiffness * gap.min(0.0).powi(2));

    m.value("gap", gap);
    m.value("xi", xi);
    m.value("foot_residual", foot.residual);
    m.describe("P", "Control points, ξ₁ running fastest.");
    m.describe("gap", "Negative when the node is inside, length.");
    m.describe("xi", "The foot; outside [−1, 1]² it belongs to a neighbour.");
    m.describe("foot_residual", "Below 1e-12, or there is no foot.");
}
