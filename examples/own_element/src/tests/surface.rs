//! Elements with nodes of a number that is open.

use diffuse_contact_kernels::support::{Isa, Mode};

use super::elements::surface;
use super::witnesses::{
    Found, Function, Number, check_by_hyper_dual, check_by_interpreter, difference, interpreted, random,
};
use crate::{average, fitted_contact};

const STIFFNESS: f64 = 7.0;

/// Two directions in a plane and their normal, turned a little.
const AXES: [[f64; 3]; 3] = [[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, 1.0]];

/// The energy by normal equations, x first, then the nodes.
struct Contact<'a>(&'a [fitted_contact::Node<f64>]);

fn sum<D: Number>(terms: impl Iterator<Item = D>) -> D {
    terms.fold(D::from(0.0), |sum, term| sum + term)
}

/// A⁻¹ b without a search for pivots.
fn solved<D: Number>(mut a: Vec<Vec<D>>, mut b: Vec<D>) -> Vec<D> {
    let n = b.len();
    for k in 0..n {
        for i in k + 1..n {
            let (factor, pivot, known) = (a[i][k] / a[k][k], a[k].clone(), b[k]);
            a[i].iter_mut().zip(pivot).skip(k).for_each(|(x, y)| *x -= factor * y);
            b[i] -= factor * known;
        }
    }
    for k in (0..n).rev() {
        b[k] = (b[k] - sum((k + 1..n).map(|j| a[k][j] * b[j]))) / a[k][k];
    }
    b
}

impl Function for Contact<'_> {
    fn at<D: Number>(&self, x: &[D]) -> D {
        let (slave, nodes) = x.split_at(3);
        let along =
            |node: usize, axis: usize| sum((0..3).map(|k| (nodes[3 * node + k] - slave[k]) * AXES[axis][k]));
        let count = self.0.len();
        let local: Vec<[D; 3]> = (0..count).map(|k| [0, 1, 2].map(|axis| along(k, axis))).collect();
        let weight = |k: usize| {
            let [a, b, _] = local[k];
            let r = (a * a + b * b).sqrt() / self.0[k].radius;
            if r.re() < 1.0 { (D::from(1.0) - r).powi(4) * (r * 4.0 + 1.0) } else { D::from(0.0) }
        };
        let p = |k: usize| {
            let [a, b, _] = local[k];
            [D::from(1.0), a, b, a * a, a * b, b * b]
        };
        let moment = |i: usize, j: usize| sum((0..count).map(|k| weight(k) * p(k)[i] * p(k)[j]));
        let a = (0..6).map(|i| (0..6).map(|j| moment(i, j)).collect()).collect();
        let b = (0..6).map(|i| sum((0..count).map(|k| weight(k) * p(k)[i] * local[k][2]))).collect();
        let height = -solved(a, b)[0];
        if height.re() < 0.0 { height * height * (0.5 * STIFFNESS) } else { D::from(0.0) }
    }
}

/// Nodes around the origin, the last of which is out of reach.
fn nodes(count: usize, seed: f64) -> Vec<fitted_contact::Node<f64>> {
    let mut random = random(seed);
    let node = |k: usize| {
        let (angle, radius) = (2.4 * k as f64, 0.5 * (k as f64 + 0.3).sqrt());
        let [x, y] = [radius * angle.cos() + 0.1 * random(), radius * angle.sin() + 0.1 * random()];
        let reach = if k + 1 == count { 0.1 } else { 2.5 + random() };
        fitted_contact::Node { X: [x, y, 0.2 * x * x - 0.1 * x * y + 0.1 * random()], radius: reach }
    };
    (0..count).map(node).collect()
}

fn element(nodes: &[fitted_contact::Node<f64>], height: f64) -> fitted_contact::Inputs<'_, f64> {
    fitted_contact::Inputs { x: [0.05, -0.03, height], axes: AXES, stiffness: STIFFNESS, nodes }
}

#[test]
fn contact_with_a_fitted_surface_has_the_derivatives_of_both_witnesses() {
    for count in [9, 13] {
        let nodes = nodes(count, 0.1 * count as f64);
        let inputs = element(&nodes, -0.3);
        let results = fitted_contact::evaluate(Mode::Hessian, &inputs);
        assert!(results.values.height < -0.1 && results.values.pivot_ratio > 1e-2, "{:?}", results.values);
        let x: Vec<f64> = inputs.x.into_iter().chain(nodes.iter().flat_map(|node| node.X)).collect();
        assert_eq!(x.len(), fitted_contact::variables(count));
        let found =
            Found { value: results.values.energy, gradient: &results.gradient, hessian: &results.hessian };
        check_by_hyper_dual(&found, &x, &Contact(&nodes));
        let of_nodes: Vec<Vec<f64>> =
            nodes.iter().map(|node| [&node.X[..], &[node.radius]].concat()).collect();
        let of_nodes: Vec<&[f64]> = of_nodes.iter().map(Vec::as_slice).collect();
        let inputs: [&[f64]; 3] = [&inputs.x, AXES.as_flattened(), &[STIFFNESS]];
        check_by_interpreter(&found, surface::moving_least_squares, &inputs, &of_nodes);
    }
}

#[test]
fn a_batch_of_elements_with_different_numbers_of_nodes() {
    let clouds: Vec<_> = (0..11_usize).map(|k| nodes(8 + k % 3, 0.1 + 0.07 * k as f64)).collect();
    let elements: Vec<_> = clouds.iter().map(|nodes| element(nodes, -0.25)).collect();
    for isa in Isa::available() {
        let mut results = vec![fitted_contact::Results::default(); elements.len()];
        fitted_contact::batch(isa, Mode::Hessian, &elements, &mut results);
        for (found, element) in results.iter().zip(&elements) {
            let single = fitted_contact::evaluate(Mode::Hessian, element);
            assert!(difference(&found.gradient, &single.gradient) < 1e-12, "{isa}");
            assert!(difference(&found.hessian, &single.hessian) < 1e-12, "{isa}");
        }
    }
    // Memory that held more is used again.
    let (mut scratch, mut results) = (Vec::new(), fitted_contact::Results::default());
    for count in [10, 8] {
        let nodes = nodes(count, 0.4);
        fitted_contact::evaluate_into(Mode::Hessian, &element(&nodes, -0.2), &mut scratch, &mut results);
        let fresh = fitted_contact::evaluate(Mode::Hessian, &element(&nodes, -0.2));
        assert_eq!((&results.gradient, &results.hessian), (&fresh.gradient, &fresh.hessian));
    }
}

#[test]
fn forces_of_a_fitted_contact_balance_and_too_few_nodes_are_reported() {
    let nodes = nodes(10, 0.3);
    let found = fitted_contact::evaluate(Mode::Gradient, &element(&nodes, -0.3));
    for axis in 0..3 {
        let sum: f64 = found.gradient.iter().skip(axis).step_by(3).sum();
        assert!(sum.abs() < 1e-13, "{sum:e}");
    }
    let few = fitted_contact::evaluate(Mode::Value, &element(&nodes[..4], -0.3));
    assert!(!(few.values.pivot_ratio > 1e-9), "{:?}", few.values);
}

#[test]
fn a_weighted_average_has_the_derivatives_of_the_interpreter() {
    let mut random = random(0.6);
    let nodes: Vec<average::Node<f64>> =
        (0..5).map(|_| average::Node { X: [random(), random(), random()], w: 1.0 + random() }).collect();
    let inputs = average::Inputs { x: [0.3, 0.1, -0.2], compliance: 0.4, nodes: &nodes };
    let found = average::evaluate(Mode::Hessian, &inputs);
    let of_nodes: Vec<Vec<f64>> = nodes.iter().map(|node| [&node.X[..], &[node.w]].concat()).collect();
    let of_nodes: Vec<&[f64]> = of_nodes.iter().map(Vec::as_slice).collect();
    let arguments: [&[f64]; 2] = [&inputs.x, &[0.4]];
    let results = Found { value: found.values.energy, gradient: &found.gradient, hessian: &found.hessian };
    check_by_interpreter(&results, surface::average, &arguments, &of_nodes);
    let expected = interpreted(surface::average, &arguments, &of_nodes);
    assert!(difference(&found.gap_jacobian, &expected("gap_jacobian")) < 1e-14);

    // The gap is linear: its Jacobian is known.
    let total: f64 = nodes.iter().map(|node| node.w).sum();
    let freedoms = average::variables(nodes.len());
    for (row, column) in (0..3).flat_map(|row| (0..freedoms).map(move |column| (row, column))) {
        let slope = if column < 3 { 1.0 } else { -nodes[column / 3 - 1].w / total };
        let slope = if column % 3 == row { slope } else { 0.0 };
        assert!((found.gap_jacobian[row * freedoms + column] - slope).abs() < 1e-15, "{row} {column}");
        for other in 0..freedoms {
            let slopes = [0, 1, 2].map(|k| {
                found.gap_jacobian[k * freedoms + column] * found.gap_jacobian[k * freedoms + other]
            });
            let second: f64 = slopes.iter().sum::<f64>() / 0.4;
            assert!((found.hessian_at(column, other) - second).abs() < 1e-14, "{column} {other}");
        }
    }
}
