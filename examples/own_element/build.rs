//! Generates the kernels of solids of compressible neo-Hooke material, of a cohesive law with history, of contact with a curved patch and
//! with a surface fitted to nodes, and of a robot's arm. Each is one function of `elements/`.
#![allow(non_snake_case)]

use diffuse_contact_codegen::{Config, ConfigError};

mod elements;
use elements::{arm, cohesive, contact, neo_hooke, surface};

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
        .compile()?;
    Ok(())
}
