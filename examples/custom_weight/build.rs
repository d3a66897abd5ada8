//! Generates kernels for the weight (1 − r)³ (1 + 3r).

use diffuse_contact_codegen::{Basis, Config};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    Config::new()
        .weight("quartic", "(1 - r)^3 * (1 + 3*r)")?
        .nodes(Basis::Quadratic, 6..=12)?
        .nodes(Basis::Linear, 3..=12)?
        .compile()?;
    Ok(())
}
