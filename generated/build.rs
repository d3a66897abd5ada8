//! Generates the kernels from the formulas.

#[cfg(feature = "contact")]
mod elements;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("cargo::rustc-check-cfg=cfg(unoptimised)");
    // As the generator does, which then compiles them number by number.
    if std::env::var("OPT_LEVEL").is_ok_and(|level| level == "0" || level == "1") {
        println!("cargo::rustc-cfg=unoptimised");
    }
    #[cfg(feature = "contact")]
    contact()?;
    Ok(())
}

/// The kernels of the contact elements, and of the laws around them.
#[cfg(feature = "contact")]
fn contact() -> Result<(), diffuse_contact_codegen::ConfigError> {
    let config = diffuse_contact_codegen::Config::new().cubic().wendland_c2();
    // A weight that is infinite at a node has kernels of its own: half of all.
    let config = if cfg!(feature = "interpolating") { config.cubic_interpolating() } else { config };
    let config = elements::all(config.share_kernels().facets().support("crate::support"))?;
    let config = if cfg!(feature = "fit") { config.fit() } else { config };
    let config = if cfg!(feature = "friction") { config.friction() } else { config };
    config.compile()?;
    Ok(())
}
