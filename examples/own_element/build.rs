//! Generates the kernels of solids of compressible neo-Hooke material, of a cohesive law with history, of contact with a curved patch and
//! with a surface fitted to nodes, of elastic matter without cells, of a robot's arm, of a chain in equilibrium and of coupled tanks. Each is
//! one function of `elements/`. Nine have generated tests.
#![allow(non_snake_case)]

use diffuse_contact_codegen::{Config, ConfigError};

mod elements;

/// Positions of a tetrahedron's nodes, at rest and after.
const AT_REST: [f64; 12] = [0.0, 0.0, 0.0, 1.0, 0.1, 0.0, 0.2, 1.1, 0.0, 0.1, 0.0, 0.9];
const STRETCHED: [f64; 12] = [0.0, 0.0, 0.0, 1.1, 0.1, -0.1, 0.3, 1.2, 0.1, 0.1, -0.1, 0.8];
/// Control points of a patch that bulges.
const PATCH: [f64; 27] = [
    -1.0, -1.0, 0.1, 0.1, -1.1, 0.3, 1.0, -0.9, 0.0, -1.1, 0.1, 0.2, 0.0, 0.0, 0.6, 1.2, 0.0, 0.3, -0.9, 1.0,
    -0.1, 0.0, 1.1, 0.2, 1.0, 1.0, 0.1,
];
/// Directions in a plane, and its normal.
const AXES: [f64; 9] = [0.8, 0.6, 0.0, -0.6, 0.8, 0.0, 0.0, 0.0, 1.0];
/// Positions and weights.
const NODES: [&[f64]; 3] = [&[0.0, 0.1, 0.0, 1.0], &[1.0, -0.1, 0.2, 0.7], &[0.2, 0.9, -0.3, 1.6]];
/// Positions on a surface, and radii.
const SURFACE: [&[f64]; 8] = [
    &[0.1, 0.2, 0.05, 2.5],
    &[1.0, -0.1, 0.2, 2.2],
    &[0.2, 0.9, -0.1, 2.6],
    &[-0.9, 0.1, 0.15, 2.3],
    &[-0.1, -1.0, 0.1, 2.4],
    &[0.8, 0.7, 0.3, 2.5],
    &[-0.7, 0.8, 0.1, 2.7],
    &[-0.8, -0.7, 0.2, 2.1],
];
/// Positions after and at rest, and weights.
const CLOUD: [&[f64]; 5] = [
    &[0.1, -0.1, 0.0, 0.0, 0.0, 0.0, 1.0],
    &[0.9, 0.6, 0.1, 1.0, 0.0, 0.1, 0.8],
    &[-0.5, 0.9, 0.2, 0.1, 1.0, 0.0, 1.3],
    &[0.2, -0.2, 1.2, 0.0, 0.1, 1.0, 0.9],
    &[0.4, 0.7, 1.0, 0.8, 0.7, 0.9, 0.6],
];
/// Cross sections of tanks and of their outlets, m².
const AREAS: [f64; 4] = [2.8e-3, 3.2e-3, 2.8e-3, 3.2e-3];
/// Levels that are wanted, m.
const TARGETS: [f64; 4] = [0.14, 0.12, 0.03, 0.02];
const OUTLETS: [f64; 4] = [7.1e-6, 5.7e-6, 7.1e-6, 5.7e-6];
const ANGLES: [f64; 7] = [0.3, -0.7, 1.1, 0.9, -0.4, 0.6, 0.2];

fn main() -> Result<(), ConfigError> {
    elements::all(Config::new())?
        .test("tet4_neo_hooke", &[&STRETCHED, &AT_REST, &[1.2], &[0.8]], &[])
        .test("cohesive", &[&[0.4, -0.2, 0.1], &[3.0], &[0.7], &[0.2]], &[])
        .test("bezier_contact", &[&[0.1, -0.2, 0.1], &PATCH, &[7.0]], &[])
        .test("fitted_contact", &[&[0.05, -0.03, -0.3], &AXES, &[7.0]], &SURFACE)
        .test("average", &[&[0.3, 0.2, 0.1], &[0.5]], &NODES)
        .test("co_rotated", &[&[1.2], &[0.8]], &CLOUD)
        .test("seven_axes", &[&ANGLES, &[0.3, -0.8, 0.5]], &[])
        .test("chain", &[&[0.4, 0.7], &[0.3], &[2.0, 1.5, 1.0, 0.7, 0.5], &[0.1; 5]], &[])
        .test(
            "four_tanks",
            &[&[0.12, 0.13, 0.02, 0.014], &[3e-6, 2.5e-6], &AREAS, &OUTLETS, &TARGETS, &[0.7, 0.6], &[20.0]],
            &[],
        )
        .compile()?;
    Ok(())
}
