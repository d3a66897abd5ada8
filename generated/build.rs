//! Generates the kernels from the formulas.

fn main() -> Result<(), Box<dyn std::error::Error>> {
    diffuse_contact_codegen::Config::new().cubic().facets().support("crate::support").compile()?;
    Ok(())
}
