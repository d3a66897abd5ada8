//! Generates the kernels from the formulas.

use diffuse_contact_codegen::expr::Expr;
use diffuse_contact_codegen::{Config, ElementModel};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("cargo::rustc-check-cfg=cfg(unoptimised)");
    if std::env::var("OPT_LEVEL").as_deref() == Ok("0") {
        println!("cargo::rustc-cfg=unoptimised");
    }
    let config = Config::new()
        .cubic()
        .wendland_c2()
        .cubic_interpolating()
        .share_kernels()
        .facets()
        .element("coulomb", coulomb)?
        .support("crate::support");
    let config = if cfg!(feature = "friction") { config.friction() } else { config };
    config.compile()?;
    Ok(())
}

/// The factor c of Coulomb's friction, R = −c ∇q.
fn coulomb(m: &ElementModel<'_>) {
    m.title("Coulomb's friction with a penalty for stick: the factor c of R = −c ∇q (docs/equations.md, section 17).");
    let [q, pressure]: [Expr<'_>; 2] = ["half_square", "pressure"].map(|name| m.variable(name));
    let [mu, stiffness, opening] = m.parameters(["coefficient", "stiffness", "opening"]);
    let slip = (2.0 * q).sqrt();
    // Of a contact that was open, the slip since the place of touch; of another all of it, to the last bit.
    let (zero, one) = (m.sheet().zero(), m.sheet().one());
    let share = zero.less(opening).select(pressure / (pressure + opening), one);
    let (limit, stuck) = (mu * pressure, share * stiffness);
    let slides = limit.less(stuck * slip);
    m.value("share", share);
    m.value("slides", slides.select(one, zero));
    m.residual("factor", slides.select(limit / slip, stuck));
}
