//! Kernels for weights of one's own, see `tests/custom_weight.rs`, and for bases, see `tests/custom_basis.rs`; elements with names that
//! generated code has itself, which have to compile.
use std::error::Error;
use std::path::PathBuf;

use diffuse_contact_codegen::expr::{Expr, total};
use diffuse_contact_codegen::{Config, ElementModel};

/// Names of what surrounds a kernel.
const NAMES: [&str; 20] = [
    "batch",
    "count",
    "direction",
    "evaluate",
    "first",
    "form",
    "gradient",
    "hessian",
    "index",
    "inputs",
    "kept",
    "lane",
    "lanes",
    "mode",
    "point",
    "points",
    "product",
    "scratch",
    "value",
    "values",
];

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rustc-env=KERNELS_OPT_LEVEL={}", std::env::var("OPT_LEVEL")?);
    if cfg!(feature = "bases") {
        bases()?;
    }
    with_fit(Config::new())
        .weight("wendland", "(1 - r)^4 * (1 + 4*r)")?
        .weight("matern", "exp(-r) * (1 + r) * (1 - r^2)^2 / sqrt(1 + 3*r^2)")?
        .weight("spline", "if r < 0.5 { 2/3 - 4*r^2 + 4*r^3 } else { 4/3*(1 - r)^3 }")?
        .element("with_names", |m| {
            let x = NAMES.map(|name| m.variable::<Expr<'_>>(name));
            m.energy(products(&x));
            m.product();
        })?
        .test("with_names", &NAMES.map(|_| &[0.3][..]), &[])
        .element("with_names_of_nodes", of_nodes)?
        .test("with_names_of_nodes", &[&[0.7]], &[&[0.3; NAMES.len()], &[-0.2; NAMES.len()]])
        // A third of the code to compile; weights with kernels of their own are those of the bases.
        .share_kernels()
        .compile()?;
    Ok(())
}

fn products<'g>(x: &[Expr<'g>]) -> Expr<'g> {
    total((1..x.len()).map(|k| x[k].powi(2) * x[k - 1].exp()))
}

fn of_nodes(m: &ElementModel<'_>) {
    let (z, x) = (m.variable::<Expr<'_>>("z"), NAMES.map(|name| m.node_variable::<Expr<'_>>(name)));
    m.energy(z * products(&x).sum());
    m.product();
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
