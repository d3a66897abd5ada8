//! Generates the kernels of a tetrahedron and of a hexahedron of compressible neo-Hooke material from their energies, and those of a
//! cohesive law with history.
#![allow(non_snake_case)]

use diffuse_contact_codegen::expr::{Mat3, Vec3, total};
use diffuse_contact_codegen::{Config, ConfigError};

/// Corners of the hexahedron in natural coordinates, √3 times its points.
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

fn main() -> Result<(), ConfigError> {
    Config::new()
        .element("tet4_neo_hooke", |m| {
            let (x, X): ([Vec3; 4], [Vec3; 4]) = (m.variable("x"), m.parameter("X"));
            let [lambda, mu] = m.parameters(["lambda", "mu"]);
            let [d, D] = [x, X].map(|x| Mat3::from_columns([1, 2, 3].map(|k| x[k] - x[0])));
            let F = m.define("F", d * D.inverse());
            let J = m.define("J", F.determinant());
            let tr_C = F.double_dot(F);
            let W = 0.5 * mu * (tr_C - 3.0) - mu * J.ln() + 0.5 * lambda * J.ln().powi(2);
            m.energy(D.determinant() / 6.0 * W);
        })?
        .element("hex8_neo_hooke", |m| {
            let (x, X): ([Vec3; 8], [Vec3; 8]) = (m.variable("x"), m.parameter("X"));
            let [lambda, mu] = m.parameters(["lambda", "mu"]);
            let xi: Vec3 = m.points("xi", &CORNERS.map(|corner| corner.map(|x| x / 3_f64.sqrt())));
            let N =
                CORNERS.map(|c| 0.125 * (1.0 + c[0] * xi[0]) * (1.0 + c[1] * xi[1]) * (1.0 + c[2] * xi[2]));
            let [d, D] =
                [x, X].map(|x| Mat3::from_fn(|i, j| total((0..8).map(|k| x[k][i] * N[k].by(xi[j])))));
            let F = m.define("F", d * D.inverse());
            let J = m.define("J", F.determinant());
            let W = 0.5 * mu * (F.double_dot(F) - 3.0) - mu * J.ln() + 0.5 * lambda * J.ln().powi(2);
            m.energy(D.determinant() * W);
        })?
        .element("cohesive", |m| {
            let opening: Vec3 = m.variable("opening");
            let [stiffness, length, before] = m.parameters(["stiffness", "length", "damage_before"]);
            let damage = m.define("damage", (1.0 - (-opening.norm() / length).exp()).max(before));
            m.residual("traction", (1.0 - damage) * stiffness * opening);
            m.value("damage", damage);
        })?
        .compile()?;
    Ok(())
}
