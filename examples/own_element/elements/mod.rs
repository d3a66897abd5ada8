//! Elements from their formulas, one file each. The build script generates their kernels; the tests interpret the same formulas.

pub mod arm;
pub mod cloud;
pub mod cohesive;
pub mod contact;
pub mod joint;
pub mod neo_hooke;
pub mod surface;
pub mod tanks;

use diffuse_contact_codegen::{Config, ConfigError};

/// All of them.
#[allow(dead_code, reason = "the tests take them one by one")]
pub fn all(config: Config) -> Result<Config, ConfigError> {
    config
        .element("tet4_neo_hooke", neo_hooke::tet4)?
        .element("tet10_neo_hooke", neo_hooke::tet10)?
        .element("hex8_neo_hooke", neo_hooke::hex8)?
        .element("hex20_neo_hooke", neo_hooke::hex20)?
        .element("cohesive", cohesive::exponential)?
        .element("bezier_contact", contact::bezier)?
        .element("fitted_contact", surface::moving_least_squares)?
        .element("average", surface::average)?
        .element("co_rotated", cloud::co_rotated)?
        .element("seven_axes", arm::seven_axes)?
        .element("chain", joint::chain)?
        .element("four_tanks", tanks::four_tanks)
}
