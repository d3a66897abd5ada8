//! Weight functions and a basis of one's own.
//!
//! Solves: the gap between a slave node and a wavy patch of nine master nodes, by kernels that the build script generated:
//! with the weight (1 − r)³ (1 + 3r) instead of the paper's cubic one, with the C² weight (1 − r)⁴ (1 + 4r) made
//! interpolating, and with the bilinear basis (1, a, b, ab).
//!
//! Run: `cargo run --release -p custom-weight`
//!
//! Expect: the four gaps, and for each of the three own kernels the largest difference of its gradient and Hessian to
//! automatic differentiation of the same formula (around 1e-15).
#![forbid(unsafe_code)]

use diffuse_contact::ad::Ad;
use diffuse_contact::{Backend, Element, Frame, Gap, Generated, GeneratedWith, Mode};

// 1. The generated kernels: one module per weight, here `quartic` with the kernel set `Quartic` and `through_nodes` with
//    `ThroughNodes`; and the constant `BILINEAR`, the basis.
include!(concat!(env!("OUT_DIR"), "/diffuse_contact_kernels.rs"));

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("kernels                                gap      against AD");
    for Row { name, gap, difference } in compare()? {
        println!("{name:<36} {gap:.6}   {difference:.1e}");
    }
    Ok(())
}

struct Row {
    name: &'static str,
    gap: f64,
    /// Largest difference of N and M to automatic differentiation.
    difference: f64,
}

fn compare() -> Result<[Row; 4], Box<dyn std::error::Error>> {
    // 2. Nine master nodes on a wavy surface, a slave above them.
    let masters: Vec<[f64; 3]> = (0..9)
        .map(|k| {
            let (x, y) = (f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0);
            [x, y, 0.1 * (1.7 * x).sin() * (1.3 * y).cos()]
        })
        .collect();
    let element =
        Element::new([0.15, 0.1, 0.2], &masters, Frame::average_plane(&masters, [0.0, 0.0, 1.0])?, 2.0);
    // A basis without a² and b² depends on the directions of the frame, which is therefore held.
    let bilinear = element.with_frame(element.frame.held()).with_basis(BILINEAR);

    // 3. Backends with the kernels, and the independent witness for each.
    let quartic = GeneratedWith::<quartic::Quartic>::new();
    let through_nodes = GeneratedWith::<through_nodes::ThroughNodes>::new();
    let quartic_ad = Ad::with_weight_formula("(1 - r)^3 * (1 + 3*r)")?;
    let through_nodes_ad = Ad::with_interpolating_formula("(1 - r)^4 * (1 + 4*r)")?;
    Ok([
        row("cubic, built in", &Generated, &Ad, &element)?,
        row("(1 - r)^3 (1 + 3 r)", &quartic, &quartic_ad, &element)?,
        row("through the nodes", &through_nodes, &through_nodes_ad, &element)?,
        row("(1 - r)^3 (1 + 3 r), basis 1 a b ab", &quartic, &quartic_ad, &bilinear)?,
    ])
}

fn row(
    name: &'static str,
    kernels: &impl Backend,
    witness: &impl Backend,
    element: &Element<'_>,
) -> Result<Row, diffuse_contact::ElementError> {
    let [found, expected] = [kernels.gap(element, Mode::Hessian)?, witness.gap(element, Mode::Hessian)?];
    let entries = |gap: &Gap| [&gap.gradient[..], gap.hessian.packed()].concat();
    let pairs = entries(&found).into_iter().zip(entries(&expected));
    Ok(Row { name, gap: found.gap, difference: pairs.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max) })
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_example_gives_its_numbers() {
        let rows = super::compare().unwrap();
        for (row, expected) in rows.iter().zip([0.184_552, 0.183_602, 0.186_135, 0.189_124]) {
            assert!((row.gap - expected).abs() < 1e-6, "{}: {}", row.name, row.gap);
            assert!(row.difference < 1e-12, "{}: {:e}", row.name, row.difference);
        }
    }
}
