//! A weight function of one's own.
//!
//! Solves: the gap between a slave node and a wavy patch of nine master nodes, with the weight (1 − r)³ (1 + 3r)
//! instead of the paper's cubic one, by kernels that the build script generated from that formula.
//!
//! Run: `cargo run --release -p custom-weight`
//!
//! Expect: the gap, its gradient's and Hessian's difference to automatic differentiation of the same formula
//! (around 1e-15), and the gap with the cubic weight for comparison.

use diffuse_contact::ad::Ad;
use diffuse_contact::{Backend, Basis, Element, Frame, Generated, GeneratedWith, Mode, Weight};

// 1. The generated kernels: one module per weight, here `quartic` with the kernel set `Quartic`.
include!(concat!(env!("OUT_DIR"), "/diffuse_contact_kernels.rs"));

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let [gap, cubic, worst] = compare()?;
    println!("gap with (1 - r)^3 (1 + 3 r)      {gap:.6}");
    println!("gap with the cubic weight         {cubic:.6}");
    println!("worst difference to AD (N and M)  {worst:.1e}");
    Ok(())
}

/// The gap with the quartic and with the cubic weight, and the worst difference to AD.
fn compare() -> Result<[f64; 3], Box<dyn std::error::Error>> {
    // 2. Nine master nodes on a wavy surface, a slave above them.
    let masters: Vec<[f64; 3]> = (0..9)
        .map(|k| {
            let (x, y) = (f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0);
            [x, y, 0.1 * (1.7 * x).sin() * (1.3 * y).cos()]
        })
        .collect();
    let element = Element {
        slave: [0.15, 0.1, 0.2],
        masters: &masters,
        frame: Frame::average_plane(&masters, [0.0, 0.0, 1.0])?,
        support_radius: 2.0,
        basis: Basis::Quadratic,
        weight: Weight::Cubic, // what `Generated` uses; a backend with a weight of its own ignores it
    };

    // 3. The same element with three backends.
    let quartic = GeneratedWith::<quartic::Quartic>::new().gap(&element, Mode::Hessian)?;
    let cubic = Generated.gap(&element, Mode::Hessian)?;
    let witness = Ad::with_weight_formula("(1 - r)^3 * (1 + 3*r)")?.gap(&element, Mode::Hessian)?;

    let differences = quartic.gradient.iter().zip(&witness.gradient);
    let differences = differences.chain(quartic.hessian.packed().iter().zip(witness.hessian.packed()));
    let worst = differences.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    Ok([quartic.gap, cubic.gap, worst])
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_example_gives_its_numbers() {
        let [gap, cubic, worst] = super::compare().unwrap();
        assert!((gap - 0.183_602).abs() < 1e-6, "{gap}");
        assert!((gap - cubic).abs() > 1e-5, "the weights differ");
        assert!(worst < 1e-12, "{worst:e}");
    }
}
