//! Functions that are stationary in unknowns whose values are known, by the interpreter, against automatic differentiation: of the formulas,
//! and of the same function found in another way.

use diffuse_contact_codegen::emit::emit_element_kernel;
use diffuse_contact_codegen::expr::{Vec2, Vec3, Vector};
use diffuse_contact_codegen::interpret::{element_derivatives, element_products, element_results};
use diffuse_contact_codegen::{
    Config, ConfigError, ElementError, ElementKernels, ElementModel, Expr, FacetShape,
};
use num_dual::{DualNum as _, HyperDual};

use crate::witnesses::{Number, by_hyper_dual, difference, numbers, sum};

/// Function, gradient, Hessian and its product with a vector of the graph, and the derivatives by expansions, against a function of all
/// variables.
fn check(
    element: &ElementKernels,
    inputs: &[&[f64]],
    variables: usize,
    f: impl Fn(&[HyperDual<f64>]) -> HyperDual<f64>,
) {
    let x = inputs[..variables].concat();
    let (gradient, hessian) = by_hyper_dual(&x, f);
    let all = element_results(element.kernels.last().unwrap(), inputs, &[]);
    for (name, found) in all.into_iter().chain(element_derivatives(element, inputs, &[])) {
        let expected = match name.as_str() {
            "gradient" => &gradient,
            "hessian" => &hessian,
            _ => continue,
        };
        let worst = difference(&found, expected);
        assert!(worst < 1e-12, "{name}: {worst:e}");
    }
    let Some(product) = &element.product else { return };
    let direction = numbers(x.len(), 0.23);
    let entry = |i: usize, j: usize| hessian[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)];
    let row = |i: usize| (0..x.len()).map(|j| entry(i, j) * direction[j]).sum();
    let expected: Vec<f64> = (0..x.len()).map(row).collect();
    let found = element_products(product, inputs, &[], &direction);
    let found = &found.iter().find(|(name, _)| name == "hessian_product").unwrap().1;
    assert!(difference(found, &expected) < 1e-12);
}

/// ½ (x − e)² for the place e on an ellipse that is nearest to x, found elsewhere: u is an input.
fn nearest_on_ellipse<'g>(m: &ElementModel<'g>, of: impl Fn(Expr<'g>) -> Expr<'g>) {
    let x: Vec2<'g> = m.variable("x");
    let axes: Vec2<'g> = m.variable("axes");
    let found: Expr<'g> = m.parameter("found");
    let u = m.stationary_at("u", Vector([found]), |u| {
        let away = Vector([x[0] - axes[0] * u[0].cos(), x[1] - axes[1] * u[0].sin()]);
        Vector([away.dot(away.by(u[0]))])
    });
    let away = Vector([x[0] - axes[0] * u[0].cos(), x[1] - axes[1] * u[0].sin()]);
    // What is made of the unknown stays stationary in it.
    m.function("energy", of(m.define("half_square", 0.5 * away.dot(away))));
    m.product();
}

/// The same by Newton's iteration.
fn half_square_of_ellipse<D: Number>(x: &[D], start: f64) -> (D, D) {
    let mut u = D::from(start);
    let away = |u: D| [x[0] - x[2] * u.cos(), x[1] - x[3] * u.sin()];
    for _ in 0..8 {
        let ([a, b], slope) = (away(u), [x[2] * u.sin(), -x[3] * u.cos()]);
        let curvature = [x[2] * u.cos(), x[3] * u.sin()];
        let residual = a * slope[0] + b * slope[1];
        let by_u = slope[0] * slope[0] + slope[1] * slope[1] + a * curvature[0] + b * curvature[1];
        u -= residual / by_u;
    }
    let [a, b] = away(u);
    (u, (a * a + b * b) * 0.5)
}

#[test]
fn a_value_that_is_stationary_at_what_is_known() {
    let x = [0.7, 1.1, 1.9, 1.3];
    let (found, _) = half_square_of_ellipse(&x, 1.2);
    let inputs: [&[f64]; 3] = [&x[..2], &x[2..], &[found]];
    let plain = ElementKernels::new("plain", |m| nearest_on_ellipse(m, |e| e)).unwrap();
    check(&plain, &inputs, 2, |x| half_square_of_ellipse(x, found).1);
    let function =
        ElementKernels::new("function", |m| nearest_on_ellipse(m, |e| (e + 0.3).ln() * e)).unwrap();
    check(&function, &inputs, 2, |x| {
        let e = half_square_of_ellipse(x, found).1;
        (e + 0.3).ln() * e
    });
}

/// A sum over the nodes that is held is a number for all of them.
#[test]
fn a_sum_over_nodes_is_held() {
    let element = |is_held: bool| {
        let formulas = |m: &ElementModel<'_>| {
            let x: Vec2<'_> = m.node_variable("x");
            let scale = x.dot(x).sum().sqrt();
            let scale = if is_held { m.held("scale", scale) } else { 1.5 * scale / scale };
            m.energy((x[0] * x[0] * x[1]).sum() * scale);
        };
        let element = ElementKernels::new("of_nodes", formulas).unwrap();
        // |(0.7, 1.1, 0.5, 0.55)| is 1.5 to rounding.
        let (a, b) = ([0.7, 1.1], [0.5, 0.3_f64.sqrt()]);
        let nodes: [&[f64]; 2] = [&a, &b];
        let found = element_results(element.kernels.last().unwrap(), &[], &nodes);
        (found, element_derivatives(&element, &[], &nodes))
    };
    let ((held, by_expansions), (constant, _)) = (element(true), element(false));
    for (name, expected) in constant {
        let found = held.iter().chain(&by_expansions).filter(|(other, _)| *other == name);
        for (_, found) in found {
            assert!(difference(found, &expected) < 1e-12, "{name}");
        }
    }
}

/// What is held has no part in derivatives.
#[test]
fn what_is_held_does_not_change() {
    let element = ElementKernels::new("held", |m| {
        let x: Vec2<'_> = m.variable("x");
        let scale = m.held("scale", x.norm());
        m.energy(scale * x[0].powi(2) + (scale * x[1]).exp());
    });
    let x = [0.3, 0.4];
    check(&element.unwrap(), &[&x], 1, |x| x[0] * x[0] * 0.5 + (x[1] * 0.5).exp());
}

/// The distance from a facet along its normal at the foot, which is found by Newton's iteration from `start`.
fn gap<D: Number>(x: &[D], start: [f64; 2]) -> D {
    let node = |k: usize| [x[3 * k], x[3 * k + 1], x[3 * k + 2]];
    let dot = |a: [D; 3], b: [D; 3]| sum((0..3).map(|k| a[k] * b[k]));
    let count = x.len() / 3 - 1;
    // Place, both tangents and the twist at (ξ, η).
    let surface = |u: [D; 2]| {
        let one = D::from(1.0);
        let coefficients: Vec<[D; 4]> = if count == 3 {
            let zero = D::from(0.0);
            vec![[one - u[0] - u[1], -one, -one, zero], [u[0], one, zero, zero], [u[1], zero, one, zero]]
        } else {
            [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
                .map(|[s, t]| {
                    let (a, b) = (one + u[0] * s, one + u[1] * t);
                    [a * b * 0.25, b * (0.25 * s), a * (0.25 * t), one * (0.25 * s * t)]
                })
                .to_vec()
        };
        [0, 1, 2, 3]
            .map(|d| [0, 1, 2].map(|axis| sum((0..count).map(|k| coefficients[k][d] * node(k + 1)[axis]))))
    };
    let mut u = start.map(D::from);
    for _ in 0..8 {
        let [place, t1, t2, twist] = surface(u);
        let away = [0, 1, 2].map(|k| place[k] - node(0)[k]);
        let r = [dot(away, t1), dot(away, t2)];
        let (a, b, c) = (dot(t1, t1), dot(t1, t2) + dot(away, twist), dot(t2, t2));
        let determinant = a * c - b * b;
        u[0] -= (c * r[0] - b * r[1]) / determinant;
        u[1] -= (a * r[1] - b * r[0]) / determinant;
    }
    let [place, t1, t2, _] = surface(u);
    let normal = [1, 2, 0].map(|k: usize| {
        let l = (k + 1) % 3;
        t1[k] * t2[l] - t1[l] * t2[k]
    });
    let away = [0, 1, 2].map(|k| node(0)[k] - place[k]);
    dot(away, normal) / dot(normal, normal).sqrt()
}

#[test]
fn the_gap_over_a_facet_is_differentiated() {
    let corners = [[0.0, 0.1, 0.2], [1.1, -0.1, 0.0], [0.9, 1.2, 0.3], [-0.1, 0.9, -0.1]];
    let slaves = [[0.4, 0.3, 0.5], [0.5, 0.4, -0.3], [0.8, 0.7, 0.1]];
    for shape in FacetShape::ALL {
        let element = ElementKernels::facet(shape);
        let corners = corners[..shape.corners()].concat();
        for slave in slaves {
            let inputs: [&[f64]; 2] = [&slave, &corners];
            let start = if shape == FacetShape::Triangle { [0.3; 2] } else { [0.0; 2] };
            check(&element, &inputs, 2, |x| gap(x, start));
        }
        let operations = element.kernels.iter().map(|kernel| emit_element_kernel(kernel).counts.total());
        let most = [[105, 125, 330], [304, 338, 830]][shape as usize];
        for (operations, most) in operations.zip(most) {
            assert!(operations <= most, "{}: {operations} instead of {most}", shape.name());
        }
    }
}

#[test]
fn unknowns_of_known_values_and_functions_have_their_places() {
    let error = |formulas: fn(&ElementModel<'_>)| {
        let ConfigError::Element { source, .. } = Config::new().element("e", formulas).unwrap_err() else {
            panic!("no error of an element")
        };
        source
    };
    let with_nodes = error(|m| {
        let x: Vec3<'_> = m.node_variable("x");
        let u = m.stationary_at("u", Vector([m.sheet().zero()]), |u| u);
        m.energy(x.dot(x).sum() + u[0]);
    });
    assert_eq!(with_nodes, ElementError::KnownWithNodes { unknowns: "u".to_owned() });
    let twice = error(|m| {
        let x: Expr<'_> = m.variable("x");
        m.energy(x * x);
        m.function("other", x * x);
    });
    assert_eq!(twice, ElementError::TwoFunctions { function: "other".to_owned() });
    let many = error(|m| {
        let x: Vector<'_, 9> = m.variable("x");
        m.energy(m.stationary_at("u", x, |u| u).dot(x));
    });
    assert_eq!(many, ElementError::Root { root: "u".to_owned(), equations: 9 });
}
