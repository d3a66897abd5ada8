//! Generates kernels for the weight (1 − r)³ (1 + 3r), for it as an interpolating weight, and for a bilinear basis.

use diffuse_contact_codegen::Config;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    Config::new()
        .weight("quartic", "(1 - r)^3 * (1 + 3*r)")?
        .interpolating("through_nodes", "(1 - r)^4 * (1 + 4*r)")?
        .basis("bilinear", &[(0, 0), (1, 0), (0, 1), (1, 1)])? // 1, a, b, ab
        .compile()?;
    Ok(())
}
