//! Contact with the curved patch.

use diffuse_contact_kernels::support::{Isa, Mode};

use super::elements::contact;
use super::witnesses::{
    Found, Function, Number, check_by_hyper_dual, check_by_interpreter, difference, random,
};
use crate::bezier_contact::{Inputs, Results, batch, evaluate};

const STIFFNESS: f64 = 7.0;

/// The energy by Bernstein's polynomials, x first, then P. The foot is found by numbers; two further Newton steps give its derivatives.
struct Contact;

/// B, B′ and B″ of degree two on [−1, 1].
fn bernstein<D: Number>(xi: D) -> [[D; 3]; 3] {
    let (s, t) = ((D::from(1.0) - xi) * 0.5, (D::from(1.0) + xi) * 0.5);
    [[s * s, s * t * 2.0, t * t], [-s, s - t, t], [D::from(0.5), D::from(-1.0), D::from(0.5)]]
}

/// The derivative of s, so often by ξ₁ and by ξ₂.
fn derivative<D: Number>(p: &[D], xi: [D; 2], by: [usize; 2]) -> [D; 3] {
    let [a, b] = [0, 1].map(|k| bernstein(xi[k])[by[k]]);
    [0, 1, 2].map(|axis| (0..9).fold(D::from(0.0), |sum, k| sum + p[3 * k + axis] * a[k % 3] * b[k / 3]))
}

fn dot<D: Number>(a: [D; 3], b: [D; 3]) -> D {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn newton_step<D: Number>(x: &[D], xi: [D; 2]) -> [D; 2] {
    let (slave, p) = x.split_at(3);
    let point = derivative(p, xi, [0, 0]);
    let d = [0, 1, 2].map(|axis| slave[axis] - point[axis]);
    let [s1, s2] = [[1, 0], [0, 1]].map(|by| derivative(p, xi, by));
    let [s11, s12, s22] = [[2, 0], [1, 1], [0, 2]].map(|by| derivative(p, xi, by));
    let (r1, r2) = (dot(s1, d), dot(s2, d));
    let (a, b, c) = (dot(s11, d) - dot(s1, s1), dot(s12, d) - dot(s1, s2), dot(s22, d) - dot(s2, s2));
    let determinant = a * c - b * b;
    [xi[0] - (c * r1 - b * r2) / determinant, xi[1] - (a * r2 - b * r1) / determinant]
}

fn foot(x: &[f64]) -> [f64; 2] {
    (0..50).fold([0.0; 2], |xi, _| newton_step(x, xi))
}

impl Function for Contact {
    fn at<D: Number>(&self, x: &[D]) -> D {
        let start = foot(&x.iter().map(|x| x.re()).collect::<Vec<f64>>()).map(D::from);
        let xi = newton_step(x, newton_step(x, start));
        let (slave, p) = x.split_at(3);
        let point = derivative(p, xi, [0, 0]);
        let [a, b] = [[1, 0], [0, 1]].map(|by| derivative(p, xi, by));
        let normal = [0, 1, 2].map(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3]);
        let gap = dot(normal, [0, 1, 2].map(|k| slave[k] - point[k])) / dot(normal, normal).sqrt();
        if gap.re() < 0.0 { gap * gap * (0.5 * STIFFNESS) } else { D::from(0.0) }
    }
}

/// A node `height` over a patch that bulges.
fn element(height: f64, seed: f64) -> Inputs<f64> {
    let mut random = random(seed);
    let P = std::array::from_fn(|k| {
        let [x, y] = [k % 3, k / 3].map(|k| k as f64 - 1.0);
        [x + 0.1 * random(), y + 0.1 * random(), 0.3 - 0.2 * (x * x + 0.5 * y * y) + 0.1 * random()]
    });
    Inputs { x: [0.4 * random(), 0.4 * random(), 0.15 + height], P, stiffness: STIFFNESS }
}

#[test]
fn a_node_inside_has_the_derivatives_of_both_witnesses() {
    let mut elements = Vec::new();
    for seed in [0.23, 0.47, 0.81] {
        let inputs = element(-0.3, seed);
        let results = evaluate(Mode::Hessian, &inputs);
        assert!(results.values.gap < -0.01 && results.values.foot_residual < 1e-12);
        let x = [&inputs.x, inputs.P.as_flattened()].concat();
        assert!(difference(&results.values.xi, &foot(&x)) < 1e-12);
        let found =
            Found { value: results.values.energy, gradient: &results.gradient, hessian: &results.hessian };
        check_by_hyper_dual(&found, &x, &Contact);
        elements.push(inputs);
        // It takes a second.
        if elements.len() == 1 {
            check_by_interpreter(
                &found,
                contact::bezier,
                &[&inputs.x, inputs.P.as_flattened(), &[STIFFNESS]],
                &[],
            );
        }
    }
    let mut batched = vec![Results::ZERO; elements.len()];
    for isa in Isa::available() {
        batch(isa, Mode::Hessian, &elements, &mut batched);
        for (found, element) in batched.iter().zip(&elements) {
            let worst = difference(&found.hessian, &evaluate(Mode::Hessian, element).hessian);
            assert!(worst < 1e-12, "{isa}: {worst:e}");
        }
    }
}

#[test]
fn forces_of_a_contact_balance_and_end_where_it_opens() {
    let inside = evaluate(Mode::Gradient, &element(-0.3, 0.47));
    for axis in 0..3 {
        let sum: f64 = inside.gradient.iter().skip(axis).step_by(3).sum();
        assert!(sum.abs() < 1e-13, "{sum:e}");
    }
    let outside = evaluate(Mode::Hessian, &element(0.3, 0.47));
    assert!(outside.values.gap > 0.01 && outside.values.energy == 0.0);
    assert!(outside.gradient.iter().chain(&outside.hessian).all(|&x| x == 0.0));
}

#[test]
fn a_node_without_a_foot_is_reported() {
    let mut lost = element(-0.3, 0.47);
    lost.P = [[0.0; 3]; 9];
    assert!(!(evaluate(Mode::Value, &lost).values.foot_residual < 1e-12));
}
