//! The solids that are compared with their rivals, as formulas: for the build script, and for whoever times their generation.

use diffuse_contact_codegen::ElementModel;
use diffuse_contact_codegen::expr::{Mat3, Vec3, total};

/// Four nodes.
pub fn tet4(m: &ElementModel<'_>) {
    let (x, X): ([Vec3<'_>; 4], [Vec3<'_>; 4]) = (m.variable("x"), m.parameter("X"));
    let [lambda, mu] = m.parameters(["lambda", "mu"]);
    let [d, D] = [x, X].map(|x| Mat3::from_columns([1, 2, 3].map(|k| x[k] - x[0])));
    let F = m.define("F", d * D.inverse());
    let J = m.define("J", F.determinant());
    let W = 0.5 * mu * (F.double_dot(F) - 3.0) - mu * J.ln() + 0.5 * lambda * J.ln().powi(2);
    m.energy(D.determinant() / 6.0 * W);
}

/// Corners of the cube in natural coordinates.
const CORNERS: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// Eight nodes, eight points.
pub fn hex8(m: &ElementModel<'_>) {
    let (x, X): ([Vec3<'_>; 8], [Vec3<'_>; 8]) = (m.variable("x"), m.parameter("X"));
    let [lambda, mu] = m.parameters(["lambda", "mu"]);
    let xi: Vec3<'_> = m.points("xi", &CORNERS.map(|corner| corner.map(|x| x / 3_f64.sqrt())));
    let N = CORNERS.map(|c| 0.125 * (1.0 + c[0] * xi[0]) * (1.0 + c[1] * xi[1]) * (1.0 + c[2] * xi[2]));
    let [d, D] = [x, X].map(|x| Mat3::from_fn(|i, j| total((0..8).map(|k| x[k][i] * N[k].by(xi[j])))));
    let F = m.define("F", d * D.inverse());
    let J = m.define("J", F.determinant());
    let W = 0.5 * mu * (F.double_dot(F) - 3.0) - mu * J.ln() + 0.5 * lambda * J.ln().powi(2);
    m.energy(D.determinant() * W);
}
