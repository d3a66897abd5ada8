//! Generates the kernels from the formulas.

use diffuse_contact_codegen::Config;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    Config::new().cubic().cubic_interpolating().wendland_c2().facets().support("crate::support").compile()?;
    Ok(())
}
