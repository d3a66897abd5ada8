//! Generates the tetrahedron that is compared with one written by hand.
#![allow(non_snake_case)]

use diffuse_contact_codegen::expr::{Mat3, Vec3};
use diffuse_contact_codegen::{Config, ConfigError};

fn main() -> Result<(), ConfigError> {
    Config::new()
        .element("tet4", |m| {
            let (x, X): ([Vec3; 4], [Vec3; 4]) = (m.variable("x"), m.parameter("X"));
            let [lambda, mu] = m.parameters(["lambda", "mu"]);
            let [d, D] = [x, X].map(|x| Mat3::from_columns([1, 2, 3].map(|k| x[k] - x[0])));
            let F = m.define("F", d * D.inverse());
            let J = m.define("J", F.determinant());
            let W = 0.5 * mu * (F.double_dot(F) - 3.0) - mu * J.ln() + 0.5 * lambda * J.ln().powi(2);
            m.energy(D.determinant() / 6.0 * W);
        })?
        .compile()?;
    Ok(())
}
