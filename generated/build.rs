//! Generates the kernels from the formulas.

use diffuse_contact_codegen::Config;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    Config::new()
        .cubic()
        .wendland_c2()
        .cubic_interpolating()
        .share_kernels()
        .facets()
        .support("crate::support")
        .compile()?;
    Ok(())
}
