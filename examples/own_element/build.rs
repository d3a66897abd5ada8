//! Generates the kernels of solids of compressible neo-Hooke material, of a cohesive law with history, of contact with a curved patch and
//! with a surface fitted to nodes, and of a robot's arm. Each is one function of `elements/`. Two have a
//! generated test.
#![allow(non_snake_case)]

use diffuse_contact_codegen::{Config, ConfigError};

mod elements;
use elements::{arm, cohesive, contact, neo_hooke, surface};

/// Positions of a tetrahedron's nodes, at rest and after.
const AT_REST: [f64; 12] = [0.0, 0.0, 0.0, 1.0, 0.1, 0.0, 0.2, 1.1, 0.0, 0.1, 0.0, 0.9];
const STRETCHED: [f64; 12] = [0.0, 0.0, 0.0, 1.1, 0.1, -0.1, 0.3, 1.2, 0.1, 0.1, -0.1, 0.8];
/// Positions and weights.
const NODES: [&[f64]; 3] = [&[0.0, 0.1, 0.0, 1.0], &[1.0, -0.1, 0.2, 0.7], &[0.2, 0.9, -0.3, 1.6]];

fn main() -> Result<(), ConfigError> {
    Config::new()
        .element("tet4_neo_hooke", neo_hooke::tet4)?
        .element("tet10_neo_hooke", neo_hooke::tet10)?
        .element("hex8_neo_hooke", neo_hooke::hex8)?
        .element("hex20_neo_hooke", neo_hooke::hex20)?
        .element("cohesive", cohesive::exponential)?
        .element("bezier_contact", contact::bezier)?
        .element("fitted_contact", surface::moving_least_squares)?
        .element("average", surface::average)?
        .element("seven_axes", arm::seven_axes)?
        .test("tet4_neo_hooke", &[&STRETCHED, &AT_REST, &[1.2], &[0.8]], &[])
        .test("average", &[&[0.3, 0.2, 0.1], &[0.5]], &NODES)
        .compile()?;
    Ok(())
}
