//! Generates the kernels from the formulas.

fn main() -> Result<(), Box<dyn std::error::Error>> {
    diffuse_contact_codegen::Config::new()
        .cubic()
        .cubic_interpolating()
        .wendland_c2()
        .facets()
        .support("crate::support")
        .compile()?;
    Ok(())
}
