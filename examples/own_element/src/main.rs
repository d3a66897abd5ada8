//! A finite element of one's own, from its energy.
//!
//! Solves: energy, forces and tangent of a tetrahedron of compressible neo-Hooke material, by kernels that the build script
//! generated from W = μ/2 (tr C − 3) − μ ln J + λ/2 (ln J)². One element, then a row of them with the machine's vector instructions.
//!
//! Run: `cargo run --release -p own-element`
//!
//! Expect: forces that add up to nothing, a tangent that agrees with differences of the forces (around 1e-9), and the same
//! numbers from the batch as from single elements (around 1e-15).
#![forbid(unsafe_code)]
#![allow(non_snake_case)]

use diffuse_contact_kernels::support::Mode;

// 1. The generated module `tet4_neo_hooke`: `Inputs` with the fields x, X, lambda and mu, `Results`, and the kernels.
include!(concat!(env!("OUT_DIR"), "/diffuse_contact_kernels.rs"));
use tet4_neo_hooke::{Inputs, Results, VARIABLES, batch, best_isa, evaluate};

fn main() {
    // 2. One element: −gradient are the forces on its nodes, the Hessian is its tangent.
    let element = stretched(0.1);
    let Results { values, gradient, .. } = evaluate(Mode::Hessian, &element);
    println!("energy        {:.6}", values.energy);
    for (node, force) in gradient.as_chunks::<3>().0.iter().enumerate() {
        println!("force, node {} {:9.6} {:9.6} {:9.6}", node + 1, -force[0], -force[1], -force[2]);
    }
    println!("tangent off by {:.0e} from differences of forces", tangent_error(&element));

    // 3. Many elements side by side.
    let elements: Vec<Inputs<f64>> = (0..1000).map(|k| stretched(2e-4 * f64::from(k))).collect();
    let mut results = vec![Results::ZERO; elements.len()];
    batch(best_isa(), Mode::Hessian, &elements, &mut results);
    let single = elements.iter().map(|element| evaluate(Mode::Hessian, element));
    let off = results
        .iter()
        .zip(single)
        .map(|(found, expected)| (found.values.energy - expected.values.energy).abs());
    println!("batch of {} with {}, off by {:.0e}", elements.len(), best_isa(), off.fold(0.0, f64::max));
}

/// A tetrahedron at the origin, sheared and stretched.
fn stretched(by: f64) -> Inputs<f64> {
    let X = [[0.0, 0.0, 0.0], [1.0, 0.1, 0.0], [0.2, 1.1, 0.0], [0.1, 0.0, 0.9]];
    let x = X.map(|[x, y, z]| [(1.0 + by) * x + by * y, y - 0.3 * by * z, (1.0 - 0.4 * by) * z]);
    Inputs { x, X, lambda: 1.2, mu: 0.8 }
}

/// Largest difference of the tangent to central differences of the gradient.
fn tangent_error(element: &Inputs<f64>) -> f64 {
    let tangent = evaluate(Mode::Hessian, element);
    let step = 1e-5;
    let moved = |column: usize, by: f64| {
        let mut element = *element;
        element.x[column / 3][column % 3] += by;
        evaluate(Mode::Gradient, &element).gradient
    };
    let mut worst = 0.0_f64;
    for column in 0..VARIABLES {
        let (after, before) = (moved(column, step), moved(column, -step));
        for row in 0..VARIABLES {
            let difference = (after[row] - before[row]) / (2.0 * step);
            worst = worst.max((tangent.hessian_at(row, column) - difference).abs());
        }
    }
    worst
}

#[cfg(test)]
mod tests;
