//! The tetrahedron of four nodes, entry by entry, against automatic differentiation of its energy, written once more.

use diffuse_contact_kernels::support::{Isa, Mode};
use num_dual::{DualNum, HyperDual};

use crate::{Inputs, Results, VARIABLES, batch, evaluate, stretched, tangent_error};

/// Entries of the packed Hessian.
const PACKED: usize = VARIABLES * (VARIABLES + 1) / 2;

/// The energy from the edges as rows: nowᵀ = F beforeᵀ, the inverse by cofactors, J as a quotient of volumes.
fn energy<D: DualNum<Primitive = f64> + Copy>(x: &[[D; 3]; 4], inputs: &Inputs<f64>) -> D {
    let det = |a: &[[D; 3]; 3]| {
        let minor = |i: usize, j: usize| a[1][i] * a[2][j] - a[1][j] * a[2][i];
        a[0][0] * minor(1, 2) - a[0][1] * minor(0, 2) + a[0][2] * minor(0, 1)
    };
    let (X, one) = (inputs.X.map(|v| v.map(D::from)), D::from(1.0));
    let edges = |x: &[[D; 3]; 4]| [1, 2, 3].map(|k| [0, 1, 2].map(|i| x[k][i] - x[0][i]));
    let (now, before) = (edges(x), edges(&X));
    let inverse = [0, 1, 2].map(|i| {
        [0, 1, 2].map(|j| {
            let (a, b, c, d) = ((j + 1) % 3, (j + 2) % 3, (i + 1) % 3, (i + 2) % 3);
            (before[a][c] * before[b][d] - before[a][d] * before[b][c]) / det(&before)
        })
    });
    let mut trace = D::from(0.0);
    for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
        let f = (0..3).fold(D::from(0.0), |f, k| f + inverse[i][k] * now[k][j]);
        trace += f * f;
    }
    let log = (det(&now) / det(&before)).ln();
    let density =
        (trace - one * 3.0) * (0.5 * inputs.mu) - log * inputs.mu + log * log * (0.5 * inputs.lambda);
    density * det(&before) / 6.0
}

/// Energy, gradient and packed Hessian by hyper-dual numbers.
fn by_hyper_dual(inputs: &Inputs<f64>) -> Results {
    let at = |i: usize, j: usize| {
        let is = |k: usize, other: usize| f64::from(u8::from(k == other));
        let seeded = |node: usize, axis: usize| {
            let k = 3 * node + axis;
            HyperDual::new(inputs.x[node][axis], is(k, i), is(k, j), 0.0)
        };
        energy(&[0, 1, 2, 3].map(|node| [0, 1, 2].map(|axis| seeded(node, axis))), inputs)
    };
    let mut results = Results::ZERO;
    results.values.energy = at(0, 0).re;
    let mut place = 0;
    for i in 0..VARIABLES {
        results.gradient[i] = at(i, i).eps1;
        for j in 0..=i {
            results.hessian[place] = at(i, j).eps1eps2;
            place += 1;
        }
    }
    results
}

/// The larger of two sizes; NaN if one is.
fn worse(x: f64, y: f64) -> f64 {
    if x.is_nan() || x > y { x } else { y }
}

/// Largest difference relative to the largest entry, of the energy, the gradient and the Hessian.
fn difference(found: &Results, expected: &Results) -> f64 {
    let of = |found: &[f64], expected: &[f64]| {
        let largest = expected.iter().fold(f64::MIN_POSITIVE, |largest: f64, x| largest.max(x.abs()));
        found.iter().zip(expected).map(|(x, y)| (x - y).abs() / largest).fold(0.0, worse)
    };
    let energy = of(&[found.values.energy], &[expected.values.energy]);
    let derivatives = [of(&found.gradient, &expected.gradient), of(&found.hessian, &expected.hessian)];
    derivatives.into_iter().fold(energy, worse)
}

fn elements() -> Vec<Inputs<f64>> {
    (1..=19).map(|k| stretched(0.05 * f64::from(k))).collect()
}

#[test]
fn a_single_element_is_what_automatic_differentiation_says() {
    for element in elements() {
        let expected = by_hyper_dual(&element);
        let worst = difference(&evaluate(Mode::Hessian, &element), &expected);
        assert!(worst < 1e-12, "{worst:e}");
        let first = evaluate(Mode::Gradient, &element);
        assert!(first.hessian == [0.0; PACKED]);
        let worst = difference(&Results { hessian: expected.hessian, ..first }, &expected);
        assert!(worst < 1e-12, "{worst:e}");
        let value = evaluate(Mode::Value, &element).values.energy;
        assert!((value - expected.values.energy).abs() < 1e-13 * expected.values.energy.abs());
    }
}

#[test]
fn a_batch_is_what_automatic_differentiation_says_with_all_instructions() {
    let elements = elements();
    let expected: Vec<Results> = elements.iter().map(by_hyper_dual).collect();
    for isa in Isa::available() {
        // Also fewer elements than lanes, and none.
        for count in [0, 1, 2, 3, 5, 8, 19] {
            let mut results = vec![Results::ZERO; count];
            batch(isa, Mode::Hessian, &elements[..count], &mut results);
            for (found, expected) in results.iter().zip(&expected) {
                let worst = difference(found, expected);
                assert!(worst < 1e-12, "{isa}, {count} elements: {worst:e}");
            }
        }
        let mut results = vec![Results::ZERO; elements.len()];
        batch(isa, Mode::Gradient, &elements, &mut results);
        for (found, expected) in results.iter().zip(&expected) {
            assert!(found.hessian == [0.0; PACKED]);
            let worst = difference(&Results { hessian: expected.hessian, ..*found }, expected);
            assert!(worst < 1e-12, "{isa}: {worst:e}");
        }
    }
}

#[test]
fn the_tangent_is_the_derivative_of_the_forces() {
    assert!(tangent_error(&stretched(0.1)) < 1e-8);
    let mut element = stretched(0.1);
    element.x[1] = element.x[2];
    assert!(!evaluate(Mode::Value, &element).values.energy.is_finite(), "no volume");
}

#[test]
#[should_panic(expected = "as many results as inputs")]
fn a_batch_needs_a_place_for_each_result() {
    batch(Isa::SCALAR, Mode::Value, &elements(), &mut [Results::ZERO]);
}
