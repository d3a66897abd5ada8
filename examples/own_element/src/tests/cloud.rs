//! Elastic matter of nodes without cells: six equations in an element with nodes.

use diffuse_contact_kernels::support::{Isa, Mode};

use super::elements::cloud;
use super::witnesses::{
    Found, Function, Number, check_by_hyper_dual, check_by_interpreter, difference, interpreted, random,
};
use crate::co_rotated::{self, Inputs, Node, Results};

const LAMBDA: f64 = 1.2;
const MU: f64 = 0.8;

/// The energy with U by the iteration U ← ½ (U + U⁻¹ C), which takes derivatives along.
struct Cloud<'a>(&'a [Node<f64>]);

type Mat3<D> = [[D; 3]; 3];

fn from_fn<D>(entry: impl Fn(usize, usize) -> D) -> Mat3<D> {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j)))
}

fn product<D: Number>(a: &Mat3<D>, b: &Mat3<D>) -> Mat3<D> {
    from_fn(|i, j| a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j])
}

fn inverse<D: Number>(a: &Mat3<D>) -> Mat3<D> {
    let cofactor = |i: usize, j: usize| {
        a[(i + 1) % 3][(j + 1) % 3] * a[(i + 2) % 3][(j + 2) % 3]
            - a[(i + 1) % 3][(j + 2) % 3] * a[(i + 2) % 3][(j + 1) % 3]
    };
    let determinant = a[0][0] * cofactor(0, 0) + a[0][1] * cofactor(0, 1) + a[0][2] * cofactor(0, 2);
    from_fn(|i, j| cofactor(j, i) / determinant)
}

impl Function for Cloud<'_> {
    fn at<D: Number>(&self, x: &[D]) -> D {
        let sum = |term: &dyn Fn(usize) -> D| (0..self.0.len()).fold(D::from(0.0), |sum, k| sum + term(k));
        let total: f64 = self.0.iter().map(|node| node.w).sum();
        let centre = [0, 1, 2].map(|i| sum(&|k| x[3 * k + i] * self.0[k].w) / total);
        let at_rest = [0, 1, 2].map(|i| self.0.iter().map(|node| node.w * node.X[i]).sum::<f64>() / total);
        let rest = |k: usize, i: usize| self.0[k].X[i] - at_rest[i];
        let moved = |k: usize, i: usize| x[3 * k + i] - centre[i];
        let of_rest = from_fn(|i, j| sum(&|k| D::from(self.0[k].w * rest(k, i) * rest(k, j))));
        let mixed = from_fn(|i, j| sum(&|k| moved(k, i) * (self.0[k].w * rest(k, j))));
        let f = product(&mixed, &inverse(&of_rest));
        let c = product(&from_fn(|i, j| f[j][i]), &f);
        let mut u = from_fn(|i, j| D::from(f64::from(u8::from(i == j))));
        for _ in 0..60 {
            let other = product(&inverse(&u), &c);
            u = from_fn(|i, j| (u[i][j] + other[i][j]) * 0.5);
        }
        let strain = from_fn(|i, j| u[i][j] - f64::from(u8::from(i == j)));
        let squares = strain.as_flattened().iter().fold(D::from(0.0), |sum, &e| sum + e * e);
        let trace = strain[0][0] + strain[1][1] + strain[2][2];
        squares * MU + trace * trace * (0.5 * LAMBDA)
    }
}

/// Nodes that were turned by nearly a right angle and stretched.
fn nodes(count: usize, seed: f64) -> Vec<Node<f64>> {
    let mut random = random(seed);
    let node = |_| {
        let X = [2.0 * random(), 2.0 * random(), 2.0 * random()];
        let x = [-1.2 * X[1] + 0.1 * X[2], 0.9 * X[0] + 0.2 * X[1], 1.3 * X[2] - 0.1 * X[0]];
        Node { x: x.map(|x| x + 0.1 * random()), X, w: 1.0 + random() }
    };
    (0..count).map(node).collect()
}

#[test]
fn the_energy_of_a_cloud_has_the_derivatives_of_both_witnesses() {
    for count in [5, 9] {
        let nodes = nodes(count, 0.13 * count as f64);
        let inputs = Inputs { lambda: LAMBDA, mu: MU, nodes: &nodes };
        let results = co_rotated::evaluate(Mode::Hessian, &inputs);
        assert!(results.values.residual < 1e-12 && results.values.energy > 0.05, "{:?}", results.values);
        let x: Vec<f64> = nodes.iter().flat_map(|node| node.x).collect();
        assert_eq!(x.len(), co_rotated::variables(count));
        let found =
            Found { value: results.values.energy, gradient: &results.gradient, hessian: &results.hessian };
        check_by_hyper_dual(&found, &x, &Cloud(&nodes));
        let of_nodes: Vec<Vec<f64>> =
            nodes.iter().map(|node| [&node.x[..], &node.X, &[node.w]].concat()).collect();
        let of_nodes: Vec<&[f64]> = of_nodes.iter().map(Vec::as_slice).collect();
        check_by_interpreter(&found, cloud::co_rotated, &[&[LAMBDA], &[MU]], &of_nodes);
        let stretch = interpreted(cloud::co_rotated, &[&[LAMBDA], &[MU]], &of_nodes)("stretch");
        assert!(difference(&results.values.stretch, &stretch) < 1e-12);
    }
}

#[test]
fn a_cloud_that_turns_has_the_energy_it_had() {
    let nodes = nodes(7, 0.3);
    let turned: Vec<Node<f64>> = nodes
        .iter()
        .map(|node| {
            let [x, y, z] = node.x;
            Node { x: [0.6 * x - 0.8 * y + 3.0, 0.8 * x + 0.6 * y, z - 1.0], ..*node }
        })
        .collect();
    let energy = |nodes: &[Node<f64>]| {
        co_rotated::evaluate(Mode::Value, &Inputs { lambda: LAMBDA, mu: MU, nodes }).values.energy
    };
    assert!((energy(&nodes) - energy(&turned)).abs() < 1e-13);
}

#[test]
fn clouds_side_by_side_are_what_each_is_alone() {
    let clouds: Vec<_> = (0..11_usize).map(|k| nodes(5 + k % 3, 0.1 + 0.07 * k as f64)).collect();
    let elements: Vec<_> =
        clouds.iter().map(|nodes| Inputs { lambda: LAMBDA, mu: MU, nodes: &nodes[..] }).collect();
    for isa in Isa::available() {
        let mut results = vec![Results::default(); elements.len()];
        co_rotated::batch(isa, Mode::Hessian, &elements, &mut results);
        for (found, element) in results.iter().zip(&elements) {
            let single = co_rotated::evaluate(Mode::Hessian, element);
            assert!(difference(&found.gradient, &single.gradient) < 1e-12, "{isa}");
            assert!(difference(&found.hessian, &single.hessian) < 1e-12, "{isa}");
        }
    }
}
