//! Generates the kernels from the formulas.

use std::path::PathBuf;

use diffuse_contact_codegen::Config;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    Config::new().cubic().facets().support("crate::support").compile()?;

    // The paper's weight has kernels of fixed size; the others compile quicker without.
    let folder = PathBuf::from(std::env::var_os("OUT_DIR").ok_or("OUT_DIR is not set")?).join("compact");
    std::fs::create_dir_all(&folder)?;
    Config::new()
        .cubic_interpolating()
        .wendland_c2()
        .compact()
        .support("crate::support")
        .output_folder(folder)
        .compile()?;
    Ok(())
}
