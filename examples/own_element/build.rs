//! Generates the kernels of a tetrahedron of compressible neo-Hooke material from its energy.
#![allow(non_snake_case)]

use diffuse_contact_codegen::expr::{Mat3, Vec3};
use diffuse_contact_codegen::{Config, ConfigError};

fn main() -> Result<(), ConfigError> {
    Config::new()
        .element("tet4_neo_hooke", |m| {
            let (x, X): ([Vec3; 4], [Vec3; 4]) = (m.variable("x"), m.parameter("X"));
            let [lambda, mu] = m.parameters(["lambda", "mu"]);
            let edges = |x: [Vec3<'_>; 4]| Mat3::from_columns([1, 2, 3].map(|k| x[k] - x[0]));
            let F = m.define("F", edges(x) * edges(X).inverse());
            let J = m.define("J", F.determinant());
            let W = 0.5 * mu * ((F.transpose() * F).trace() - 3.0) - mu * J.ln() + 0.5 * lambda * J.ln().powi(2);
            m.energy(edges(X).determinant() / 6.0 * W);
        })?
        .compile()?;
    Ok(())
}
