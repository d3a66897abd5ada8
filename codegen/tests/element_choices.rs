//! Derivatives of formulas where a part of them has none: choices that leave it out, and squares of norms.
#![allow(non_snake_case)]

use diffuse_contact_codegen::emit::emit_element_kernel;
use diffuse_contact_codegen::expr::{Expr, Mat3, Vec2, Vec3, Vector};
use diffuse_contact_codegen::graph::Polynomial;
use diffuse_contact_codegen::interpret::{element_products, element_results};
use diffuse_contact_codegen::{Config, ElementKernels, ElementModel};

use crate::witnesses::difference;

fn kernels(formulas: impl Fn(&ElementModel<'_>)) -> ElementKernels {
    ElementKernels::new("test", formulas).unwrap()
}

/// Results of the kernel with all derivatives, and the products with a direction, by name.
fn results(
    element: &ElementKernels,
    inputs: &[&[f64]],
    direction: &[f64],
) -> impl Fn(&str) -> Vec<f64> + use<> {
    let mut all = element_results(element.kernels.last().unwrap(), inputs, &[]);
    if let Some(product) = &element.product {
        all.extend(element_products(product, inputs, &[], direction));
    }
    move |name| all.iter().find(|(other, _)| other == name).unwrap().1.clone()
}

/// A logarithm of 0 under a name is not multiplied where it is not chosen; a maximum may begin at −∞.
#[test]
fn values_that_are_not_finite_are_not_chosen() {
    let element = kernels(|m| {
        let [d, h] = [m.variable::<Expr<'_>>("d"), m.parameter("h")];
        let l = m.define("l", (d / h).ln());
        m.value("damped", l.max(0.0));
        m.value("largest", m.sheet().number(f64::NEG_INFINITY).max(d).max(h));
        m.value("held", m.held("l_held", (d / h).ln()).max(0.0));
        // A polynomial of what has an infinite derivative.
        m.energy(d * d + d.less(0.5).select(0.0, d.ln().polynomial(Polynomial::new(vec![0.0, 1.0, 3.0]))));
    });
    let all = element_results(element.kernels.last().unwrap(), &[&[0.0], &[2.0]], &[]);
    let value = |name: &str| all.iter().find(|(other, _)| other == name).unwrap().1[0];
    assert_eq!((value("damped"), value("largest"), value("held")), (0.0, 2.0, 0.0));
    assert_eq!((value("gradient"), value("hessian")), (0.0, 2.0));
    let config = Config::new().element("test", |m| {
        let d: Expr<'_> = m.variable("d");
        m.energy(m.sheet().number(f64::NEG_INFINITY).max(d) + m.sheet().number(f64::INFINITY).min(d));
    });
    let config = config.unwrap();
    assert!(config.source().unwrap().contains("splat(-f64::INFINITY)"));
    assert!(config.c_source().unwrap().contains("(-INFINITY)"));
}

/// At d = 0 each of these has an infinite derivative, or none, and a choice leaves it out.
#[test]
fn a_choice_leaves_out_the_derivatives_of_what_has_a_name() {
    type Quantity = for<'g> fn(Expr<'g>, Expr<'g>) -> Expr<'g>;
    let quantities: [Quantity; 7] = [
        |d, h| (d / h).ln(),
        |d, _| d.sqrt(),
        |d, h| (d * h).cbrt(),
        |d, h| d.powf(h),
        |d, _| 1.0 / d,
        |d, h| d.atan2(h - 1.0),
        |d, h| (h - 1.0 + d.sqrt() + d.cbrt()).sqrt(),
    ];
    for (k, quantity) in quantities.into_iter().enumerate() {
        let element = kernels(|m| {
            let (x, h): (Vec2<'_>, Expr<'_>) = (m.variable("x"), m.parameter("h"));
            let d = m.define("d", x[0] + x[1]);
            let q = m.define("q", quantity(d, h));
            // What is made of it is left out with it.
            let square = m.define("square", q * q + d);
            let chosen = d.less(0.5).select(d * d, q.exp() + square * q);
            m.energy(chosen);
            m.residual("force", Vector([d.less(0.5).select(d, q), d.less(0.5).select(0.0, square) + x[0]]));
            m.value("slope", chosen.by(x[1]));
            m.value("of_quantity", (q * q).by(q) - 2.0 * q);
            let root = m.root("u", |u: Vector<'_, 1>| Vector([u[0] - d.less(0.5).select(0.3 * d, q)]));
            m.residual("root", root.unknowns);
            m.product();
        });
        let at_zero = results(&element, &[&[0.25, -0.25], &[1.0]], &[1.0, 2.0]);
        assert_eq!(at_zero("gradient"), [0.0, 0.0], "{k}");
        assert_eq!(at_zero("hessian"), [2.0; 3], "{k}");
        assert_eq!(at_zero("force_jacobian"), [1.0, 1.0, 1.0, 0.0], "{k}");
        assert_eq!(at_zero("slope"), [0.0], "{k}");
        assert!(difference(&at_zero("root_jacobian"), &[0.3, 0.3]) < 1e-15, "{k}");
        assert_eq!(at_zero("hessian_product"), [6.0, 6.0], "{k}");
        assert!(difference(&at_zero("root_jacobian_product"), &[0.9]) < 1e-15, "{k}");
        let elsewhere = results(&element, &[&[0.5, 0.4], &[1.5]], &[1.0, 2.0]);
        assert_eq!(elsewhere("of_quantity"), [0.0], "{k}");
        assert_eq!(elsewhere("slope")[0], elsewhere("gradient")[1], "{k}");
        assert_ne!(elsewhere("gradient")[0], 2.0 * 0.9, "{k}");
    }
}

/// The same without names, where the generator makes names of its own.
#[test]
fn a_choice_leaves_out_the_derivatives_of_what_the_generator_names() {
    let element = kernels(|m| {
        let (x, h): (Vec2<'_>, Expr<'_>) = (m.variable("x"), m.parameter("h"));
        let d = x[0].sqrt() + x[1].cbrt();
        let image = (x[0] - x[1]) / h;
        let left_out = (1.0 + d).sqrt() + (1.0 + d).ln() + image.exp() * image.powi(3);
        m.energy(x[0].less(0.5).select(x[0] * x[1], left_out));
        m.product();
    });
    let at_zero = results(&element, &[&[0.0, 0.0], &[0.0]], &[1.0, 2.0]);
    assert_eq!(at_zero("gradient"), [0.0, 0.0]);
    assert_eq!(at_zero("hessian"), [0.0, 1.0, 0.0]);
    assert_eq!(at_zero("hessian_product"), [2.0, 1.0]);
}

/// A norm that is left out is no quantity of its own either.
#[test]
fn a_choice_leaves_out_norms_of_what_has_no_derivatives() {
    let element = kernels(|m| {
        let [d, y] = ["d", "y"].map(|name| m.variable::<Expr<'_>>(name));
        m.energy(d.less(0.5).select(d * y, d.ln().hypot(y).cos() + (d.sqrt() + y).hypot(y).exp()));
        m.product();
    });
    let at_zero = results(&element, &[&[0.0], &[2.0]], &[1.0, 3.0]);
    assert_eq!(at_zero("hessian"), [0.0, 1.0, 0.0]);
    assert_eq!(at_zero("hessian_product"), [3.0, 1.0]);
}

/// Sums over the nodes keep their names; what is in their terms is written out.
#[test]
fn terms_of_sums_leave_out_derivatives() {
    let element = kernels(|m| {
        let (s, X): (Expr<'_>, Expr<'_>) = (m.variable("s"), m.node_variable("X"));
        let root = m.define("root", s.sqrt());
        let total = m.define("total", s.less(0.5).select(X * s, root * X).sum());
        m.energy(total * total + total);
    });
    let nodes: [&[f64]; 3] = [&[1.0], &[2.0], &[4.0]];
    let all = element_results(element.kernels.last().unwrap(), &[&[0.0]], &nodes);
    let value = |name: &str| all.iter().find(|(other, _)| other == name).unwrap().1.clone();
    assert_eq!(value("gradient")[0], 7.0);
    assert_eq!(value("hessian")[0], 2.0 * 49.0);
}

/// Under a guard the deformation gradient, which is a quotient, is written out; what it is made of still has derivatives of its own.
#[test]
fn a_guard_takes_half_as_many_operations_again() {
    let operations = |is_guarded: bool| {
        let element = kernels(|m| {
            let (x, X): ([Vec3<'_>; 4], [Vec3<'_>; 4]) = (m.variable("x"), m.parameter("X"));
            let [d, D] = [x, X].map(|x| Mat3::from_columns([1, 2, 3].map(|k| x[k] - x[0])));
            let F = m.define("F", d * D.inverse());
            let J = m.define("J", F.determinant());
            let W = F.double_dot(F) - 2.0 * J.ln() + 0.7 * J.ln().powi(2);
            m.energy(if is_guarded { J.less(1e-3).select(1e6, W) } else { W });
        });
        emit_element_kernel(element.kernels.last().unwrap()).counts.total()
    };
    let [guarded, plain] = [true, false].map(operations);
    assert!(guarded < plain + plain / 2, "{guarded} {plain}");
}

/// A choice between parts of norms whose components are divided, or have roots: what is taken has its Hessian where the norm is zero, as in
/// a split of strains into tension and pressure.
#[test]
fn norms_in_choices_have_their_hessian_where_they_are_zero() {
    type Part = for<'g> fn(Vec2<'g>, Expr<'g>) -> Expr<'g>;
    let parts: [Part; 5] = [
        |v, _| (v[0] / 3.0).hypot(v[1] / 3.0),
        |v, p| (v[0] / p).hypot(v[1] / p),
        |v, p| (v[0] / p.powi(2).sqrt()).hypot(v[1] / p.powf(1.0)),
        |v, p| (v[0] * p.sqrt() / p.powf(1.5)).hypot(v[1] * p.powi(-1)),
        |v, p| (v / p).norm(),
    ];
    for part in parts {
        let element = kernels(|m| {
            let (v, p) = (m.variable::<Vec2<'_>>("v"), m.parameter("p"));
            let r = part(v, p);
            m.energy((1.0 + r).max(0.0).powi(2) + (1.0 - r).max(0.0).powi(2));
            m.product();
        });
        let ninth = 4.0 / 9.0;
        for (v, tolerance) in [([0.0, 0.0], 1e-15), ([1e-3, -2e-3], 1e-12)] {
            let at = results(&element, &[&v, &[3.0]], &[1.0, 2.0]);
            assert!(difference(&at("hessian"), &[ninth, 0.0, ninth]) < tolerance, "{:?}", at("hessian"));
            assert!(difference(&at("hessian_product"), &[ninth, 2.0 * ninth]) < tolerance);
        }
    }
}

/// What such a norm is divided by may be zero where it is left out, also by a choice around another one.
#[test]
fn norms_that_choices_leave_out_are_not_divided() {
    let element = kernels(|m| {
        let (v, p) = (m.variable::<Vec2<'_>>("v"), m.parameter::<Expr<'_>>("p"));
        let r = (v / p).norm();
        let inner = p.less(10.0).select(r.cos(), r * r + 2.0 * r.cos());
        m.energy(v[0] * v[1] + v[1].powi(2) + p.less(0.5).select(0.0, inner));
        m.product();
    });
    // r² + 2 cos r has no second derivative at 0.
    for (p, by_norm) in [(0.0, 0.0), (3.0, -1.0 / 9.0), (20.0, 0.0)] {
        let at = results(&element, &[&[0.0, 0.0], &[p]], &[1.0, 3.0]);
        assert!(difference(&at("hessian"), &[by_norm, 1.0, 2.0 + by_norm]) < 1e-15, "{p}");
        assert!(difference(&at("hessian_product"), &[3.0 + by_norm, 7.0 + 3.0 * by_norm]) < 1e-14, "{p}");
        assert_eq!(at("gradient"), [0.0, 0.0]);
    }
}

/// A table of choices has a copy of the norm for each; where choices multiply them beyond that, the norm stays one.
#[test]
fn norms_in_many_choices_are_copied_within_limits() {
    let table = |knots: u8| {
        kernels(|m| {
            let (v, p) = (m.variable::<Vec2<'_>>("v"), m.parameter::<Expr<'_>>("p"));
            let r = (v / p).norm();
            let step = |rest, k| p.less(f64::from(k)).select((f64::from(k) * r).cos(), rest);
            m.energy((1..=knots).rev().fold((100.0 * r).cos(), step));
        })
    };
    for (knots, expected) in [(20, -16.0 / 12.25), (60, 0.0)] {
        let at = results(&table(knots), &[&[0.0, 0.0], &[3.5]], &[]);
        assert!(
            difference(&at("hessian"), &[expected, 0.0, expected]) < 1e-15,
            "{knots}: {:?}",
            at("hessian")
        );
        let at = results(&table(knots), &[&[3.5e-3, 0.0], &[3.5]], &[]);
        assert!((at("hessian")[0] + 16.0 * 4e-3_f64.cos() / 12.25).abs() < 1e-9);
    }
    let doubled = kernels(|m| {
        let (v, p) = (m.variable::<Vec2<'_>>("v"), m.parameter::<Expr<'_>>("p"));
        m.energy((0..30).fold((v / p).norm(), |a, k| p.less(f64::from(k)).select(a.sin(), a.cos())));
    });
    assert!(results(&doubled, &[&[1.0, 2.0], &[3.5]], &[])("hessian").iter().all(|x| x.is_finite()));
}

/// A spring of length zero: no norm of a part, and no norm at the origin, takes its stiffness.
#[test]
fn a_squared_norm_has_its_hessian_everywhere() {
    let squares: [fn(Vec3<'_>) -> Expr<'_>; 10] = [
        |x| 0.5 * x.norm().powi(2),
        |x| 0.5 * x.norm() * x.norm(),
        |x| 0.25 * x.norm().powi(2) + 0.25 * (x.norm() * x[2]).powi(2) / x[2].powi(2),
        |x| 0.5 * x.norm().powf(2.0) + x.norm().powi(4) - x.norm() * x.norm().powi(3),
        // Over a radius, as weights have it.
        |x| 4.5 * (x.norm() / 3.0).powi(2),
        |x| 4.5 * (x.norm() / 3.0) * (x.norm() / 3.0),
        |x| (x.norm() / 3.0).polynomial(Polynomial::new(vec![0.0, 0.0, 4.5])),
        |x| (0.25 * x.norm()).polynomial(Polynomial::new(vec![1.0, 0.0, 8.0])),
        |x| 4.5 * (0.5 * x.norm() / 1.5).powi(2),
        |x| 0.5 * x.dot(x).sqrt().powi(2),
    ];
    for (k, square) in squares.into_iter().enumerate() {
        let element = kernels(|m| {
            let (x, stiffness): (Vec3<'_>, Expr<'_>) = (m.variable("x"), m.parameter("k"));
            m.energy(stiffness * square(x));
        });
        for at in [[0.0, 0.0, 1.0], [0.0; 3]].into_iter().filter(|x| k != 2 || x[2] != 0.0) {
            let all = element_results(element.kernels.last().unwrap(), &[&at, &[7.0]], &[]);
            let hessian = &all.iter().find(|(name, _)| name == "hessian").unwrap().1;
            assert!(difference(hessian, &[7.0, 0.0, 7.0, 0.0, 0.0, 7.0]) < 1e-14, "{k} {at:?}: {hessian:?}");
        }
    }
}

/// So has that of a norm with a name.
#[test]
fn a_squared_norm_with_a_name_has_its_hessian_everywhere() {
    let element = kernels(|m| {
        let (x, k): (Vec3<'_>, Expr<'_>) = (m.variable("x"), m.parameter("k"));
        let length = m.define("length", x.norm());
        m.value("length_itself", length);
        m.energy(0.5 * k * length.powi(2));
        m.product();
    });
    let found = results(&element, &[&[0.0; 3], &[7.0]], &[1.0, 2.0, 3.0]);
    assert!(difference(&found("hessian"), &[7.0, 0.0, 7.0, 0.0, 0.0, 7.0]) < 1e-14);
    assert!(difference(&found("hessian_product"), &[7.0, 14.0, 21.0]) < 1e-14);
}

/// Functions of a norm that are smooth where it is zero: n² or about that.
#[test]
fn a_smooth_function_of_a_norm_has_its_hessian_where_the_norm_is_zero() {
    type Smooth = (for<'g> fn(Expr<'g>, Expr<'g>) -> Expr<'g>, f64);
    let functions: [Smooth; 13] = [
        (|n, _| n.cos(), -1.0),
        (|n, _| n.sin().powi(2), 2.0),
        (|n, one| n.atan2(one).powi(2), 2.0),
        (|n, _| n.exp() + (-n).exp(), 2.0),
        (|n, _| (1.0 - n) * (1.0 + n), -2.0),
        (|n, k| (k - n).powi(2) - k * k + 2.0 * k * n, 2.0),
        (|n, one| 0.5 * (n - (one - 1.0)).powi(2), 1.0),
        (|n, _| (n + n.powi(2)).powi(2), 2.0),
        (|n, _| (1.0 + n).powf(2.7) + (1.0 - n).powf(2.7), 2.0 * 2.7 * 1.7),
        (|n, _| n.powi(2) * n.cos() + n.cos() * 3.0, 2.0 - 3.0),
        // Matérn's and Wendland's functions.
        (|n, _| n.polynomial(Polynomial::new(vec![1.0, 1.0, 1.0 / 3.0])) * (-n).exp(), -1.0 / 3.0),
        (|n, _| (1.0 - n).powi(4) * n.polynomial(Polynomial::new(vec![1.0, 4.0])), -20.0),
        (|n, _| n.polynomial(Polynomial::new(vec![1.0, 0.0, 3.0])) * n.cos(), 5.0),
    ];
    for (k, (function, curvature)) in functions.into_iter().enumerate() {
        for is_named in [false, true] {
            let element = kernels(|m| {
                let (x, one): (Vec3<'_>, Expr<'_>) = (m.variable("x"), m.parameter("one"));
                let n = x.norm();
                m.energy(function(if is_named { m.define("n", n) } else { n }, one));
                m.product();
            });
            let found = results(&element, &[&[0.0; 3], &[1.0]], &[1.0, 2.0, 3.0]);
            let c = curvature;
            assert!(difference(&found("gradient"), &[0.0; 3]) < 1e-15, "{k}: {:?}", found("gradient"));
            assert!(
                difference(&found("hessian"), &[c, 0.0, c, 0.0, 0.0, c]) < 1e-14,
                "{k}: {:?}",
                found("hessian")
            );
            let product = found("hessian_product");
            assert!(difference(&product, &[c, 2.0 * c, 3.0 * c]) < 1e-14, "{k}: {product:?}");
            // Squares of such a norm are no numbers.
            let next_to = results(&element, &[&[0.0, 1e-160, 0.0], &[1.0]], &[1.0, 2.0, 3.0]);
            assert!(
                difference(&next_to("hessian"), &found("hessian")) < 1e-14,
                "{k}: {:?}",
                next_to("hessian")
            );
            assert!(difference(&next_to("hessian_product"), &product) < 1e-14, "{k}");
            // Beside it the limit is reached.
            let beside = results(&element, &[&[1e-6, 0.0, 0.0], &[1.0]], &[1.0, 2.0, 3.0]);
            assert!(difference(&beside("hessian"), &found("hessian")) < 1e-4, "{k}: {:?}", beside("hessian"));
            assert!(difference(&beside("hessian_product"), &product) < 1e-4, "{k}");
        }
    }
}

/// A straight rod resists bending, and a body at rest in its plane has the stiffness of a body that is not quite at rest.
#[test]
fn rods_and_principal_stretches_have_their_stiffness_at_rest() {
    let rod = kernels(|m| {
        let x: [Vec3<'_>; 3] = m.variable("x");
        let [e, f] = [x[1] - x[0], x[2] - x[1]];
        m.energy(0.5 * e.cross(f).norm().atan2(e.dot(f)).powi(2));
        m.product();
    });
    let straight = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0];
    let across = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let found = results(&rod, &[&straight], &across);
    let expected = [0.0, 1.0, 0.0, 0.0, -2.0, 0.0, 0.0, 1.0, 0.0];
    assert!(difference(&found("hessian_product"), &expected) < 1e-14, "{:?}", found("hessian_product"));
    let bent = results(&rod, &[&[0.0, 0.0, 0.0, 1.0, 1e-5, 0.0, 2.0, 0.0, 0.0]], &across);
    assert!(difference(&found("hessian"), &bent("hessian")) < 1e-4);

    let ogden = kernels(|m| {
        let F: [[Expr<'_>; 2]; 2] = m.variable("F");
        let c = |i: usize, j: usize| F[0][i] * F[0][j] + F[1][i] * F[1][j];
        let (half, radius) = (0.5 * (c(0, 0) + c(1, 1)), (0.5 * (c(0, 0) - c(1, 1))).hypot(c(0, 1)));
        let [first, second] = [half + radius, half - radius].map(|square| square.powf(1.35));
        let J = F[0][0] * F[1][1] - F[0][1] * F[1][0];
        m.energy(1.3 / 2.7 * (first + second) - 1.3 * J.ln() + 5.0 * (J - 1.0).powi(2));
    });
    let hessian = |F: [f64; 4]| results(&ogden, &[&F], &[])("hessian");
    let (at_rest, beside) = (hessian([1.0, 0.0, 0.0, 1.0]), hessian([1.0 + 1e-5, 0.0, 0.0, 1.0]));
    assert!(difference(&at_rest, &beside) < 1e-3, "{at_rest:?} {beside:?}");
    assert!((at_rest[0] - 13.51).abs() < 1e-10 && (at_rest[2] - 1.755).abs() < 1e-10, "{at_rest:?}");
}

/// Norms of what is summed over the nodes.
#[test]
fn norms_of_sums_have_their_hessian_where_they_are_zero() {
    let element = kernels(|m| {
        let (x, w, X): (Vec3<'_>, Expr<'_>, Vec3<'_>) =
            (m.variable("x"), m.node_parameter("w"), m.node_variable("X"));
        let away = m.define("away", x - X.map(|X| (w * X).sum() / w.sum()));
        m.energy(1.0 - away.norm().cos());
        m.product();
    });
    let nodes: [&[f64]; 3] = [&[1.0, 1.0, 0.0, 0.0], &[2.0, 0.0, 1.0, 0.0], &[1.0, 0.0, 0.0, 1.0]];
    let at = [0.25, 0.5, 0.25];
    let all = element_results(element.kernels.last().unwrap(), &[&at], &nodes);
    let value = |name: &str| all.iter().find(|(other, _)| other == name).unwrap().1.clone();
    assert!(difference(&value("gradient"), &[0.0; 12]) < 1e-15);
    let hessian = value("hessian");
    // By x it is the identity; by x and a node −w/Σw of it.
    let entry = |i: usize, j: usize| hessian[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)];
    let parts = [1.0, -0.25, -0.5, -0.25];
    for (i, j) in (0..12).flat_map(|i| (0..12).map(move |j| (i, j))) {
        let expected = if i % 3 == j % 3 { parts[i / 3] * parts[j / 3] } else { 0.0 };
        assert!((entry(i, j) - expected).abs() < 1e-14, "{i} {j}: {}", entry(i, j));
    }
    let direction: Vec<f64> = (0..12).map(|k| f64::from(k % 5) - 1.5).collect();
    let products = element_products(element.product.as_ref().unwrap(), &[&at], &nodes, &direction);
    let product = &products.iter().find(|(name, _)| name == "hessian_product").unwrap().1;
    let expected: Vec<f64> = (0..12).map(|i| (0..12).map(|j| entry(i, j) * direction[j]).sum()).collect();
    assert!(difference(product, &expected) < 1e-14, "{product:?} {expected:?}");
}
