//! Elements with nodes of a number that is open: contact with a surface that is fitted to nodes, and a condition on them.

use diffuse_contact_codegen::ElementModel;
use diffuse_contact_codegen::expr::{Expr, Vec3, dot};
use diffuse_contact_codegen::graph::Polynomial;

/// (1 − r)⁴ (1 + 4 r): a polynomial of a norm has derivatives at r = 0 too, and keeps its digits at r = 1.
const WENDLAND: [f64; 6] = [1.0, 0.0, -10.0, 20.0, -15.0, 4.0];

/// Penalty energy ½ ε ⟨−h⟩² of a slave node x at the height h over a surface z = α·(1, a, b, a², ab, b²) along an axis: moving least squares
/// with Wendland's weight of r = √(a² + b²)/R_k, R_k the radius of node k.
pub fn moving_least_squares<'g>(m: &ElementModel<'g>) {
    m.title("Contact of a node with a surface fitted to nodes by moving least squares.");
    let (x, axes): (Vec3<'g>, [Vec3<'g>; 3]) = (m.variable("x"), m.parameter("axes"));
    let stiffness: Expr<'g> = m.parameter("stiffness");
    let (X, radius): (Vec3<'g>, Expr<'g>) = (m.node_variable("X"), m.node_parameter("radius"));

    let [a, b, z] = m.define("local", axes.map(|axis| axis.dot(X - x)));
    let r = (a / radius).hypot(b / radius);
    let w = m.define("w", r.less(1.0).select(r.polynomial(Polynomial::new(WENDLAND.to_vec())), 0.0));
    let p = [m.sheet().one(), a, b, a * a, a * b, b * b];
    let fit = m.stationary::<6>("alpha", |alpha| 0.5 * w * (z - dot(p, alpha.0)).powi(2));
    let height = m.define("height", -fit.unknowns[0]);
    m.energy(0.5 * stiffness * height.min(0.0).powi(2));
    m.product();

    m.value("height", height);
    m.value("pivot_ratio", fit.pivot_ratio);
    m.describe(
        "axes",
        "Two directions in the plane of the fit, and the one that heights are measured along.",
    );
    m.describe("height", "Of x over the surface, negative inside, length.");
    m.describe("pivot_ratio", "0 where the nodes in reach do not determine the fit.");
}

/// A node held by the weighted average of others: x − Σ w X / Σ w, with its Jacobian, and half its square over a compliance.
pub fn average<'g>(m: &ElementModel<'g>) {
    m.title("A node held by the weighted average of others.");
    let (x, compliance): (Vec3<'g>, Expr<'g>) = (m.variable("x"), m.parameter("compliance"));
    let (X, w): (Vec3<'g>, Expr<'g>) = (m.node_variable("X"), m.node_parameter("w"));
    let gap = m.define("gap_vector", x - X.map(|X| (w * X).sum() / w.sum()));
    m.residual("gap", gap);
    m.energy(gap.dot(gap) / (2.0 * compliance));
    m.product();
}
