//! Kernels for weights of one's own, see `tests/custom_weight.rs`, and for bases, see `tests/custom_basis.rs`.
use std::error::Error;
use std::path::PathBuf;

use diffuse_contact_codegen::Config;

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rustc-env=KERNELS_OPT_LEVEL={}", std::env::var("OPT_LEVEL")?);
    if cfg!(feature = "bases") {
        bases()?;
    }
    with_fit(Config::new())
        .weight("wendland", "(1 - r)^4 * (1 + 4*r)")?
        .weight("matern", "exp(-r) * (1 + r) * (1 - r^2)^2 / sqrt(1 + 3*r^2)")?
        .weight("spline", "if r < 0.5 { 2/3 - 4*r^2 + 4*r^3 } else { 4/3*(1 - r)^3 }")?
        // A third of the code to compile; weights with kernels of their own are those of the bases.
        .share_kernels()
        .compile()?;
    Ok(())
}

fn with_fit(config: Config) -> Config {
    if cfg!(feature = "fit") { config.fit() } else { config }
}

fn bases() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::var_os("OUT_DIR").ok_or("OUT_DIR is not set")?).join("bases");
    std::fs::create_dir_all(&folder)?;
    with_fit(Config::new())
        .cubic()
        .cubic_interpolating()
        .basis("bilinear", &[(0, 0), (1, 0), (0, 1), (1, 1)])?
        .basis(
            "third_degree",
            &[(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3)],
        )?
        .output_folder(folder)
        .compile()?;
    Ok(())
}
