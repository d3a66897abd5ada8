//! Generates the kernels from the formulas.

mod elements;

use diffuse_contact_codegen::Config;
use elements::{
    carried_by_quadrilateral, carried_by_quadrilateral8, carried_by_quadrilateral9, carried_by_triangle,
    carried_by_triangle6, coulomb, coulomb_sliding, decaying_coefficient, direction, foot_of_gap,
    interpolated, slip_over_quadrilateral, slip_over_triangle, traction, traction_sliding,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("cargo::rustc-check-cfg=cfg(unoptimised)");
    // As the generator does, which then compiles them number by number.
    if std::env::var("OPT_LEVEL").is_ok_and(|level| level == "0" || level == "1") {
        println!("cargo::rustc-cfg=unoptimised");
    }
    let config = Config::new().cubic().wendland_c2();
    // A weight that is infinite at a node has kernels of its own: half of all.
    let config = if cfg!(feature = "interpolating") { config.cubic_interpolating() } else { config };
    let config = config
        .share_kernels()
        .facets()
        .element("coulomb", coulomb)?
        .element("traction", traction)?
        .element("coulomb_sliding", coulomb_sliding)?
        .element("traction_sliding", traction_sliding)?
        .element("decaying_coefficient", decaying_coefficient)?
        .element("interpolated", interpolated)?
        .element("direction", direction)?
        .element("foot_of_gap", foot_of_gap)?
        .element("slip_over_triangle", slip_over_triangle)?
        .element("slip_over_quadrilateral", slip_over_quadrilateral)?
        .element("carried_by_triangle", carried_by_triangle)?
        .element("carried_by_quadrilateral", carried_by_quadrilateral)?
        .element("carried_by_triangle6", carried_by_triangle6)?
        .element("carried_by_quadrilateral8", carried_by_quadrilateral8)?
        .element("carried_by_quadrilateral9", carried_by_quadrilateral9)?
        .support("crate::support");
    let config = if cfg!(feature = "friction") { config.friction() } else { config };
    config.compile()?;
    Ok(())
}
