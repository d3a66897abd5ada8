//! The compiled kernels against automatic differentiation of the energy, written once more for dual numbers.

use diffuse_contact_kernels::support::{Isa, Mode};
use num_dual::{DualNum, HyperDual};

use super::{
    Inputs, Results, VARIABLES, batch, cohesive, evaluate, hex8_neo_hooke, stretched, tangent_error,
};

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

/// Largest difference relative to the largest entry, of the energy, the gradient and the Hessian.
fn difference(found: &Results, expected: &Results) -> f64 {
    let of = |found: &[f64], expected: &[f64]| {
        let largest = expected.iter().fold(f64::MIN_POSITIVE, |largest: f64, x| largest.max(x.abs()));
        let pairs = found.iter().zip(expected);
        // A NaN is larger than anything.
        pairs.fold(0.0, |worst: f64, (x, y)| {
            let difference = (x - y).abs() / largest;
            if difference <= worst { worst } else { difference }
        })
    };
    let energy = of(&[found.values.energy], &[expected.values.energy]);
    energy.max(of(&found.gradient, &expected.gradient)).max(of(&found.hessian, &expected.hessian))
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

/// The hexahedron with trilinear x(ξ): the energy of eight points for numbers of any kind.
fn hexahedron<D: DualNum<Primitive = f64> + Copy>(
    x: &[[D; 3]; 8],
    inputs: &hex8_neo_hooke::Inputs<f64>,
) -> D {
    let corner = |k: usize| {
        // Around the lower face, then around the upper.
        let [a, b] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]][k % 4];
        [a, b, if k < 4 { -1.0 } else { 1.0 }]
    };
    let at = 1.0 / 3_f64.sqrt();
    let mut sum = D::from(0.0);
    for point in 0..8 {
        let xi = corner(point).map(|x| x * at);
        // The tangents are those of a tetrahedron with these edges, which has a sixth of their volume.
        let tetrahedron = |x: &[[D; 3]; 8]| {
            let mut vertices = [[D::from(0.0); 3]; 4];
            for (k, direction, axis) in (0..8).flat_map(|k| (0..9).map(move |n| (k, n / 3, n % 3))) {
                let c = corner(k);
                let factor = |i: usize| if i == direction { c[i] } else { 1.0 + c[i] * xi[i] };
                vertices[direction + 1][axis] += x[k][axis] * (factor(0) * factor(1) * factor(2) / 8.0);
            }
            vertices
        };
        let X = tetrahedron(&inputs.X.map(|v| v.map(D::from))).map(|v| v.map(|x| x.re()));
        let one = Inputs { x: X, X, lambda: inputs.lambda, mu: inputs.mu };
        sum += energy(&tetrahedron(x), &one) * 6.0;
    }
    sum
}

#[test]
fn a_sum_over_points_is_what_automatic_differentiation_says_with_all_instructions() {
    use hex8_neo_hooke::{Results, VARIABLES, batch, evaluate};
    let element = |k: i32| {
        let X = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
        let bent = |[x, y, z]: [f64; 3], by: f64| [x + by * y * z, y - 0.5 * by * x * x, z * (1.0 + by * x)];
        let X = X.map(|v| bent(v.map(f64::from), 0.1));
        let by = 0.05 * f64::from(k);
        hex8_neo_hooke::Inputs { x: X.map(|v| bent(v, by)), X, lambda: 1.2, mu: 0.8 }
    };
    let elements: Vec<_> = (1..=5).map(element).collect();
    let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    for element in &elements[..2] {
        let found = evaluate(Mode::Hessian, element);
        for (row, column) in (0..VARIABLES).flat_map(|row| (0..=row).map(move |column| (row, column))) {
            let is = |k: usize, other: usize| f64::from(u8::from(k == other));
            let seeded = |k: usize| HyperDual::new(element.x[k / 3][k % 3], is(k, row), is(k, column), 0.0);
            let x = std::array::from_fn(|node| [0, 1, 2].map(|axis| seeded(3 * node + axis)));
            let expected = hexahedron(&x, element);
            close(found.hessian_at(row, column), expected.eps1eps2);
            close(found.gradient[row], expected.eps1);
            close(found.values.energy, expected.re);
        }
    }
    for isa in Isa::available() {
        let mut results = vec![Results::ZERO; elements.len()];
        batch(isa, Mode::Hessian, &elements, &mut results);
        for (found, element) in results.iter().zip(&elements) {
            let expected = evaluate(Mode::Hessian, element);
            let pairs = found.gradient.iter().zip(&expected.gradient);
            pairs.chain(found.hessian.iter().zip(&expected.hessian)).for_each(|(x, y)| close(*x, *y));
            close(found.values.energy, expected.values.energy);
        }
    }
}

/// Traction (1 − d) k δ with the damage d = max(1 − exp(−|δ|/l), d before), with one of its components.
fn traction(opening: [HyperDual<f64>; 3], axis: usize, before: f64) -> (HyperDual<f64>, HyperDual<f64>) {
    let norm = (opening[0] * opening[0] + opening[1] * opening[1] + opening[2] * opening[2]).sqrt();
    let now = -(-norm / 0.7).exp() + 1.0;
    let damage = if now.re < before { HyperDual::from(before) } else { now };
    ((-damage + 1.0) * opening[axis] * 3.0, damage)
}

#[test]
fn a_cohesive_law_has_its_jacobian_and_its_new_state_in_all_lanes() {
    let law = |k: i32| {
        let opening = [0.1 * f64::from(k), -0.2, 0.05 * f64::from(k)];
        cohesive::Inputs { opening, stiffness: 3.0, length: 0.7, damage_before: 0.5 }
    };
    let laws: Vec<_> = (0..11).map(law).collect();
    for isa in Isa::available() {
        let mut results = vec![cohesive::Results::ZERO; laws.len()];
        // There is no Hessian: all derivatives there are.
        cohesive::batch(isa, Mode::Hessian, &laws, &mut results);
        for (law, found) in laws.iter().zip(&results) {
            for (row, column) in (0..3).flat_map(|row| (0..3).map(move |column| (row, column))) {
                let seeded =
                    |k: usize| HyperDual::new(law.opening[k], f64::from(u8::from(k == column)), 0.0, 0.0);
                let (traction, damage) = traction([0, 1, 2].map(seeded), row, law.damage_before);
                assert!((found.values.traction[row] - traction.re).abs() < 1e-14);
                assert!((found.values.damage - damage.re).abs() < 1e-15);
                assert!((found.traction_jacobian[3 * row + column] - traction.eps1).abs() < 1e-12);
            }
        }
    }
    let damages: Vec<f64> =
        laws.iter().map(|law| cohesive::evaluate(Mode::Value, law).values.damage).collect();
    assert!(damages[0] == 0.5 && damages[10] > 0.5, "both branches");
}
