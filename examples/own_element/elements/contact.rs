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
///
/// With ξ + δ in the place of ξ, g does not change to first order with δ, as x − s is normal to the patch there, nor with the direction
/// ν, as x − s is along it. So both have known values, and their rates are needed for second derivatives only.
pub fn bezier<'g>(m: &ElementModel<'g>) {
    m.title("Contact of a node with a biquadratic Bézier patch.");
    let (x, P): (Vec3<'g>, [Vec3<'g>; 9]) = (m.variable("x"), m.variable("P"));
    let stiffness = m.parameter::<Expr<'_>>("stiffness");
    let tangents = |xi: Vec2<'g>| xi.0.map(|u| patch(&P, xi).by(u));

    let foot = m.root("foot", |xi| Vector(tangents(xi).map(|tangent| tangent.dot(x - patch(&P, xi)))));
    let xi = m.held("xi_held", foot.unknowns);
    let distance = m.define("distance", x - patch(&P, xi));
    let tangent = m.define("tangent", tangents(xi));
    let curvature = m.define("curvature", [(0, 0), (0, 1), (1, 1)].map(|(k, l)| tangents(xi)[k].by(xi[l])));

    // x − s and s,ₖ at ξ + δ, to the order that second derivatives see.
    let slopes =
        |delta: Vec2<'g>| [0, 1].map(|k| tangent[k] + delta[0] * curvature[k] + delta[1] * curvature[k + 1]);
    let away = |delta: Vec2<'g>| {
        let [s1, s2] = slopes(0.5 * delta);
        distance - delta[0] * s1 - delta[1] * s2
    };
    let zero = Vector::zero(m.sheet());
    let delta = m.stationary_at("delta", zero, |delta| Vector(slopes(delta).map(|t| t.dot(away(delta)))));
    let normal = tangent[0].cross(tangent[1]).unit();
    let nu = m.stationary_at("nu", normal, |nu| {
        let [t1, t2] = slopes(delta);
        Vector([nu.dot(t1), nu.dot(t2), 0.5 * (nu.dot(nu) - 1.0)])
    });
    let gap = m.define("gap", nu.dot(away(delta)));
    m.energy(0.5 * stiffness * gap.min(0.0).powi(2));

    m.value("gap", gap);
    m.value("xi", xi);
    m.value("foot_residual", foot.residual);
    m.describe("P", "Control points, ξ₁ running fastest.");
    m.describe("gap", "Negative when the node is inside, length.");
    m.describe("xi", "The foot; outside [−1, 1]² it belongs to a neighbour.");
    m.describe("foot_residual", "Below 1e-12, or there is no foot.");
}
