//! Elements with nodes of a number that is open: sums, fits and roots of sums, by the interpreter, against automatic differentiation of
//! the same functions written once more.
#![allow(non_snake_case)]

use diffuse_contact_codegen::emit::emit_element_kernel;
use diffuse_contact_codegen::expr::{Expr, Matrix, Vec2, Vec3, Vector, dot};
use diffuse_contact_codegen::interpret::{element_derivatives, element_results};
use diffuse_contact_codegen::lower::lower;
use diffuse_contact_codegen::{
    Config, ConfigError, ElementError, ElementKernels, ElementModel, Limits, Mode,
};
use num_dual::{DualNum as _, HyperDual};

use crate::witnesses::{Number, by_hyper_dual, difference, interpreted, numbers, sum};

/// Energy, gradient and Hessian of all modes against a function of all variables, the element's first.
fn check(
    formulas: impl Fn(&ElementModel<'_>),
    inputs: &[&[f64]],
    nodes: &[&[f64]],
    (variables, of_node): (usize, usize),
    f: impl Fn(&[HyperDual<f64>]) -> HyperDual<f64>,
) {
    let element = ElementKernels::new("test", formulas).unwrap();
    let mut x: Vec<f64> = inputs.concat()[..variables].to_vec();
    nodes.iter().for_each(|node| x.extend(&node[..of_node]));
    let energy = f(&x.iter().map(|&x| HyperDual::from(x)).collect::<Vec<_>>()).re;
    let (gradient, hessian) = by_hyper_dual(&x, f);
    for (name, found) in element_derivatives(&element, inputs, nodes) {
        let worst = difference(&found, if name == "gradient" { &gradient } else { &hessian });
        assert!(worst < 1e-12, "{name} by expansions: {worst:e}");
    }
    for mode in Mode::ALL {
        let found = interpreted(&element, mode, inputs, nodes);
        assert!(difference(&found("energy"), &[energy]) < 1e-12, "{:?} {energy}", found("energy"));
        if mode >= Mode::Gradient {
            let worst = difference(&found("gradient"), &gradient);
            assert!(worst < 1e-12, "gradient: {worst:e}");
        }
        if mode == Mode::Hessian {
            let worst = difference(&found("hessian"), &hessian);
            assert!(worst < 1e-12, "Hessian: {worst:e}");
        }
    }
}

/// Positions around the origin, with a weight each.
fn cloud(count: usize) -> Vec<Vec<f64>> {
    let cloud = |k: usize| {
        let random = numbers(4, 0.31 + 0.05 * k as f64);
        let angle = 2.4 * k as f64;
        let radius = 0.3 + 0.07 * k as f64;
        vec![
            radius * angle.cos() + 0.1 * random[0],
            radius * angle.sin() + 0.1 * random[1],
            0.4 * random[2],
            1.0 + random[3],
        ]
    };
    (0..count).map(cloud).collect()
}

fn slices(nodes: &[Vec<f64>]) -> Vec<&[f64]> {
    nodes.iter().map(Vec::as_slice).collect()
}

/// ½ k |x − Σ w x_k / Σ w|², a spring to a weighted average, with a moment of fourth order about it: sums of sums.
#[test]
fn sums_of_what_other_sums_are_in() {
    let formulas = |m: &ElementModel<'_>| {
        let (x, stiffness): (Vec3<'_>, Expr<'_>) = (m.variable("x"), m.parameter("stiffness"));
        let (X, w): (Vec3<'_>, Expr<'_>) = (m.node_variable("X"), m.node_parameter("w"));
        let mean = m.define("mean", X.map(|X| (w * X).sum() / w.sum()));
        let scatter = (w * (X - mean).dot(X - mean).powi(2)).sum();
        m.energy(0.5 * stiffness * (x - mean).dot(x - mean) + 0.3 * scatter.sqrt() * x[0]);
    };
    for count in [2, 7] {
        let nodes = cloud(count);
        let of = |x: &[HyperDual<f64>]| {
            let (w, X): (Vec<f64>, &[HyperDual<f64>]) = (nodes.iter().map(|n| n[3]).collect(), &x[3..]);
            let total: f64 = w.iter().sum();
            let mean = [0, 1, 2].map(|k| sum((0..count).map(|i| X[3 * i + k] * w[i])) / total);
            let square = |i: usize| sum((0..3).map(|k| (X[3 * i + k] - mean[k]) * (X[3 * i + k] - mean[k])));
            let scatter = sum((0..count).map(|i| square(i) * square(i) * w[i]));
            let distance = sum((0..3).map(|k| (x[k] - mean[k]) * (x[k] - mean[k])));
            distance * 0.5 * 1.7 + scatter.sqrt() * 0.3 * x[0]
        };
        check(formulas, &[&[0.2, -0.4, 0.9], &[1.7]], &slices(&nodes), (3, 3), of);
    }
}

/// Σ_k (∂E/∂X_k)² of E = Σ w (X − Σ w X / Σ w)³, whose inner sums have a name or none.
#[test]
fn derivatives_by_a_node_go_through_sums_without_names() {
    let of = |is_named: bool, exponent: i32| {
        let formulas = move |m: &ElementModel<'_>| {
            let (x, w): (Expr<'_>, Expr<'_>) = (m.node_variable("x"), m.node_parameter("w"));
            let mean = (w * x).sum() / w.sum();
            let mean = if is_named { m.define("mean", mean) } else { mean };
            let moment = (w * (x - mean).powi(exponent)).sum();
            m.value("square", moment.by(x).powi(2).sum());
        };
        let nodes: Vec<[f64; 2]> = numbers(5, 0.3).iter().map(|x| [*x, 1.0 + x * x]).collect();
        let nodes: Vec<&[f64]> = nodes.iter().map(|node| &node[..]).collect();
        let element = ElementKernels::new("test", formulas).unwrap();
        interpreted(&element, Mode::Value, &[], &nodes)("square")[0]
    };
    let [named, unnamed] = [true, false].map(|is_named| of(is_named, 3));
    assert!((named - unnamed).abs() < 1e-14 * named && named > 1e-3, "{named} {unnamed}");
    // The first moment about the mean is zero wherever the nodes are.
    assert!(of(false, 1) < 1e-30);
}

/// Conditions that say nothing, or the same, leave more than one place, or none.
#[test]
fn conditions_that_determine_nothing_show_in_the_pivots() {
    let ratio = |p: f64, q: f64, is_twice: bool| {
        let element = ElementKernels::new("test", |m| {
            let [p, q] = m.parameters(["p", "q"]);
            let x: Expr<'_> = m.variable("x");
            let fit = m.stationary("c", |c: Vector<'_, 4>| {
                let other = if is_twice { 2.0 * (p * c[0] + q * c[1]) } else { c[0] };
                let least = 0.5 * (c[0] - x).powi(2) + 0.5 * c[1] * c[1];
                least + c[2] * (p * c[0] + q * c[1] - 1.0) + c[3] * other
            });
            m.energy(fit.unknowns[0]);
            m.value("pivot_ratio", fit.pivot_ratio);
        });
        interpreted(&element.unwrap(), Mode::Value, &[&[p], &[q], &[0.3]], &[])("pivot_ratio")[0]
    };
    assert!(ratio(0.6, 0.8, false) > 0.3);
    for ratio in [ratio(0.0, 0.0, false), ratio(1.0, 0.0, false), ratio(0.6, 0.8, true)] {
        assert!(ratio.abs() < 1e-14, "{ratio:e}");
    }
}

/// (1 − r²)³, a weight whose radius is large enough for the cloud.
fn weight<'g>(a: Expr<'g>, b: Expr<'g>) -> Expr<'g> {
    (1.0 - (a * a + b * b) / 4.0).powi(3)
}

/// Solves A x = b without a search for pivots.
fn eliminated<D: Number>(mut A: Vec<Vec<D>>, mut b: Vec<D>) -> Vec<D> {
    let n = b.len();
    for k in 0..n {
        for i in k + 1..n {
            let factor = A[i][k] / A[k][k];
            let pivot = A[k].clone();
            A[i].iter_mut().zip(pivot).skip(k).for_each(|(x, y)| *x -= factor * y);
            let known = b[k];
            b[i] -= factor * known;
        }
    }
    for k in (0..n).rev() {
        let known = sum((k + 1..n).map(|j| A[k][j] * b[j]));
        b[k] = (b[k] - known) / A[k][k];
    }
    b
}

/// Coefficients of z over (1, a, b) by weighted least squares.
fn plane<D: Number>(local: &[[D; 3]], weights: &[f64]) -> Vec<D> {
    let w = |k: usize| {
        let [a, b, _] = local[k];
        (-(a * a + b * b) / 4.0 + 1.0).powi(3) * weights[k]
    };
    let p = |k: usize| [D::from(1.0), local[k][0], local[k][1]];
    let all = 0..local.len();
    let A = (0..3).map(|i| (0..3).map(|j| sum(all.clone().map(|k| w(k) * p(k)[i] * p(k)[j]))).collect());
    let b = (0..3).map(|i| sum(all.clone().map(|k| w(k) * p(k)[i] * local[k][2]))).collect();
    eliminated(A.collect(), b)
}

/// The height of a moving least squares plane over a node, and the slope: a fit as `stationary`.
#[test]
fn a_fit_of_moving_least_squares() {
    let formulas = |m: &ElementModel<'_>| {
        let x: Vec3<'_> = m.variable("x");
        let (X, scale): (Vec3<'_>, Expr<'_>) = (m.node_variable("X"), m.node_parameter("scale"));
        let [a, b, z] = m.define("local", X - x).0;
        let w = m.define("w", scale * weight(a, b));
        let fit = m.stationary("alpha", |alpha: Vec3<'_>| {
            let e = z - dot([m.sheet().one(), a, b], alpha.0);
            0.5 * w * e * e
        });
        let [height, slope, _] = fit.unknowns.0;
        m.energy(0.5 * height * height + 0.2 * slope.exp());
        m.value("pivot_ratio", fit.pivot_ratio);
    };
    let nodes = cloud(7);
    let of = |x: &[HyperDual<f64>]| {
        let local: Vec<_> = (1..8).map(|i| [0, 1, 2].map(|k| x[3 * i + k] - x[k])).collect();
        let alpha = plane(&local, &nodes.iter().map(|node| node[3]).collect::<Vec<f64>>());
        alpha[0] * alpha[0] * 0.5 + alpha[1].exp() * 0.2
    };
    check(formulas, &[&[0.02, -0.05, 0.3]], &slices(&nodes), (3, 3), of);

    let element = ElementKernels::new("test", formulas).unwrap();
    let found = interpreted(&element, Mode::Value, &[&[0.02, -0.05, 0.3]], &slices(&nodes));
    assert!(found("pivot_ratio")[0] > 0.1, "{:?}", found("pivot_ratio"));
    // Three nodes in a row, whose plane may turn about it, and none: of the formulas, and of what the kernels are written from.
    let row: Vec<Vec<f64>> = [-0.5, 0.1, 0.7].map(|a| vec![a, 0.0, 0.2, 1.0]).to_vec();
    let kernel = &element.kernels[0];
    for kernel in [kernel, &lower(kernel)] {
        for nodes in [&row[..], &[]] {
            let all = element_results(kernel, &[&[0.0, 0.0, 0.3]], &slices(nodes));
            let ratio = &all.iter().find(|(name, _)| name == "pivot_ratio").unwrap().1;
            assert_eq!(ratio[..], [0.0]);
        }
    }
    // The sums of the system have no rows: three unknowns, three products.
    let [_, per_pair] = emit_element_kernel(&element.kernels[2]).per_node;
    assert_eq!(per_pair.fused, 3 * 2 * 9);
}

/// A condition by a multiplier: coefficients that are least squares with their sum prescribed by a sum over the nodes.
#[test]
fn a_fit_under_a_condition() {
    let formulas = |m: &ElementModel<'_>| {
        let (x, w): (Vec2<'_>, Expr<'_>) = (m.node_variable("x"), m.node_parameter("w"));
        let mass = m.define("mass", (w * x[0] * x[0]).sum());
        let fit = m.stationary("c", |c: Vec3<'_>| {
            let e = x[1] - c[0] - c[1] * x[0];
            (0.5 * w * e * e).sum() + 0.05 * c[0] * c[0] + c[2] * (c[0] + c[1] - mass)
        });
        m.energy(fit.unknowns[0] * fit.unknowns[1] + mass.ln());
    };
    let nodes: Vec<Vec<f64>> = cloud(5).into_iter().map(|node| vec![node[0], node[1], node[3]]).collect();
    let of = |x: &[HyperDual<f64>]| {
        let of = |f: &dyn Fn(usize) -> HyperDual<f64>| sum((0..5).map(|k| f(k) * nodes[k][2]));
        let mass = of(&|k| x[2 * k] * x[2 * k]);
        let one = HyperDual::from(1.0);
        let (a01, a11) = (of(&|k| x[2 * k]), of(&|k| x[2 * k] * x[2 * k]));
        let A = vec![
            vec![of(&|_| one) + 0.1, a01, one],
            vec![a01, a11, one],
            vec![one, one, HyperDual::from(0.0)],
        ];
        let b = vec![of(&|k| x[2 * k + 1]), of(&|k| x[2 * k] * x[2 * k + 1]), mass];
        let c = eliminated(A, b);
        c[0] * c[1] + mass.ln()
    };
    check(formulas, &[], &slices(&nodes), (0, 2), of);
}

/// Where a node's distance from a fitted surface is least: a root whose equations have the coefficients of a fit in them.
#[test]
fn a_root_of_what_is_fitted() {
    let formulas = |m: &ElementModel<'_>| {
        let (x, k): (Vec3<'_>, Expr<'_>) = (m.variable("x"), m.parameter("k"));
        let (X, scale): (Vec3<'_>, Expr<'_>) = (m.node_variable("X"), m.node_parameter("scale"));
        let [a, b, z] = (X - x).0;
        let w = scale * weight(a, b);
        let alpha = m.stationary("alpha", |alpha: Vec3<'_>| {
            let e = z - dot([m.sheet().one(), a, b], alpha.0);
            w * e * e
        });
        let [c, s, t] = alpha.unknowns.0;
        // (u, f(u)) with f = c + s u + t v + u² v/5: the foot of the origin.
        let foot = m.root("foot", |u| {
            let f = c + s * u[0] + t * u[1] + 0.2 * u[0] * u[0] * u[1];
            Vector([u[0] + f * f.by(u[0]), u[1] + f * f.by(u[1])])
        });
        let u = foot.unknowns;
        let f = c + s * u[0] + t * u[1] + 0.2 * u[0] * u[0] * u[1];
        m.energy(0.5 * k * (u.dot(u) + f * f) + (scale * X[2]).sum() * u[0]);
    };
    let nodes = cloud(6);
    let of = |x: &[HyperDual<f64>]| {
        let local: Vec<_> = (1..7).map(|i| [0, 1, 2].map(|k| x[3 * i + k] - x[k])).collect();
        let alpha = plane(&local, &nodes.iter().map(|node| node[3]).collect::<Vec<f64>>());
        let (mut u, mut v) = (HyperDual::from(0.0), HyperDual::from(0.0));
        let f =
            |u: HyperDual<f64>, v: HyperDual<f64>| alpha[0] + alpha[1] * u + alpha[2] * v + u * u * v * 0.2;
        for _ in 0..200 {
            let (slope_u, slope_v) = (alpha[1] + u * v * 0.4, alpha[2] + u * u * 0.2);
            (u, v) = (-f(u, v) * slope_u, -f(u, v) * slope_v);
        }
        let height = f(u, v);
        let moment = sum((0..6).map(|i| x[3 * i + 5] * nodes[i][3]));
        (u * u + v * v + height * height) * 0.5 * 2.3 + moment * u
    };
    check(formulas, &[&[0.02, -0.05, 0.1], &[2.3]], &slices(&nodes), (3, 3), of);
}

/// A root of N equations with means of the nodes in them, u_k + 0.1 u_{k+1}² = s_k + Σ w X_k / Σ w, k counted round.
fn ring_of_means<const N: usize>() {
    let formulas = |m: &ElementModel<'_>| {
        let s: Vector<'_, N> = m.variable("s");
        let (X, w): (Vec3<'_>, Expr<'_>) = (m.node_variable("X"), m.node_parameter("w"));
        let root = m.root("u", |u: Vector<'_, N>| {
            Vector::from_fn(|k| {
                let mean = (w * X[k % 3].powi(2)).sum() / w.sum();
                u[k] + 0.1 * u[(k + 1) % N].powi(2) - 0.3 * s[k] - 0.1 * f64::from(k as u8 + 1) * mean
            })
        });
        let u = root.unknowns;
        let own = u.iter().skip(1).fold(u[0].exp(), |sum, &u| sum + u * u * u);
        m.energy(own + (w * X[0] * X[1]).sum() * u[N - 1]);
    };
    let nodes = cloud(4);
    let of = |x: &[HyperDual<f64>]| {
        let (s, X) = x.split_at(N);
        let total: f64 = nodes.iter().map(|node| node[3]).sum();
        let mean = |k: usize| sum((0..4).map(|i| X[3 * i + k] * X[3 * i + k] * nodes[i][3])) / total;
        let known: Vec<_> = (0..N).map(|k| s[k] * 0.3 + mean(k % 3) * 0.1 * (k as f64 + 1.0)).collect();
        let mut u = known.clone();
        for _ in 0..200 {
            u = (0..N).map(|k| known[k] - u[(k + 1) % N] * u[(k + 1) % N] * 0.1).collect();
        }
        let product = sum((0..4).map(|i| X[3 * i] * X[3 * i + 1] * nodes[i][3]));
        u[0].exp() + sum(u[1..].iter().map(|&u| u * u * u)) + product * u[N - 1]
    };
    let s: Vec<f64> = numbers(N, 0.43);
    check(formulas, &[&s], &slices(&nodes), (N, 3), of);
}

#[test]
fn a_root_of_one_to_eight_equations_with_sums() {
    ring_of_means::<1>();
    ring_of_means::<3>();
    ring_of_means::<4>();
    ring_of_means::<8>();
}

/// Linear equations and a stationary point of more than three unknowns with sums over the nodes in them.
#[test]
fn linear_equations_and_a_stationary_point_with_sums() {
    let formulas = |m: &ElementModel<'_>| {
        let (X, w): (Vec3<'_>, Expr<'_>) = (m.node_variable("X"), m.node_parameter("w"));
        let [a, b, c] = [0, 1, 2].map(|k| (w * X[k].powi(2)).sum());
        let [zero, one] = [m.sheet().zero(), m.sheet().one()];
        // Pivots are zero in the order of the rows.
        let matrix = Matrix([[zero, a, one, b], [c, zero, a, one], [one, b, zero, c], [b, one, a, zero]]);
        let solution = m.solve("v", matrix, Vector([a, one, c, b]));
        let v = solution.unknowns;
        let limits = Limits { longest_step: 1.0, evaluations: 40 };
        let found = m.stationary_from("u", Vector([zero; 4]), limits, |u| {
            let own = (0..4).fold(zero, |sum, k| sum + 0.5 * u[k] * u[k] + 0.05 * u[k].powi(4) - v[k] * u[k]);
            own + 0.1 * a * u[0] * u[3]
        });
        m.energy(found.unknowns.dot(v) + found.unknowns[0].powi(2));
    };
    let nodes = cloud(5);
    let of = |x: &[HyperDual<f64>]| {
        let [a, b, c] = [0, 1, 2].map(|k| sum((0..5).map(|i| x[3 * i + k] * x[3 * i + k] * nodes[i][3])));
        let [zero, one] = [0.0, 1.0].map(HyperDual::from);
        // The same rows in an order with pivots.
        let rows = [[c, zero, a, one], [zero, a, one, b], [b, one, a, zero], [one, b, zero, c]];
        let v = eliminated(rows.iter().map(|row| row.to_vec()).collect(), vec![one, a, b, c]);
        let mut u = vec![zero; 4];
        for _ in 0..300 {
            let coupling = [a * u[3] * -0.1, zero, zero, a * u[0] * -0.1];
            u = (0..4).map(|k| (v[k] + coupling[k]) / (u[k] * u[k] * 0.2 + 1.0)).collect();
        }
        sum((0..4).map(|k| u[k] * v[k])) + u[0] * u[0]
    };
    check(formulas, &[], &slices(&nodes), (0, 3), of);
}

/// A sum of a sum that an unknown stands in: u with ½ u² + Σᵢ wᵢ Σⱼ u xⱼ least, −Σ w Σ x.
#[test]
fn a_sum_within_a_sum_of_an_unknown() {
    let formulas = |m: &ElementModel<'_>| {
        let (x, w): (Expr<'_>, Expr<'_>) = (m.node_variable("x"), m.node_parameter("w"));
        let fit = m.stationary("u", |u: Vector<'_, 1>| {
            let inner = (u[0] * x).sum();
            0.5 * u[0].powi(2) + (w * inner).sum()
        });
        m.energy(fit.unknowns[0].powi(3) + (x * x).sum());
    };
    let nodes = [[0.4, 2.0], [-0.3, 1.0], [0.9, 0.5]];
    let nodes: Vec<&[f64]> = nodes.iter().map(|node| &node[..]).collect();
    let of = |x: &[HyperDual<f64>]| {
        let all = sum(x.iter().copied()) * -3.5;
        all * all * all + sum(x.iter().map(|&x| x * x))
    };
    check(formulas, &[], &nodes, (0, 1), of);
}

/// Conditions with a Jacobian, and a count of nodes: a node held by the weighted average of others.
#[test]
fn conditions_with_their_jacobian() {
    let element = ElementKernels::new("test", |m| {
        let (x, w): (Vec2<'_>, Expr<'_>) = (m.variable("x"), m.node_parameter("w"));
        let X: Vec2<'_> = m.node_variable("X");
        let count = m.sheet().one().sum();
        m.residual("gap", X.map(|X| (w * X).sum() / w.sum()) - x + Vector([count, count]) * x[0]);
    })
    .unwrap();
    let nodes = [[2.0, 0.1, 0.2], [1.0, -0.3, 0.4], [0.5, 0.7, 0.9]];
    let nodes: Vec<&[f64]> = nodes.iter().map(|node| &node[..]).collect();
    let found = interpreted(&element, Mode::Gradient, &[&[0.5, 0.25]], &nodes);
    let of_node = |w: f64, row: usize| [0, 1].map(|k| if k == row { w / 3.5 } else { 0.0 });
    let row = |row: usize, first: [f64; 2]| {
        [first, of_node(2.0, row), of_node(1.0, row), of_node(0.5, row)].concat()
    };
    let expected = [row(0, [2.0, 0.0]), row(1, [3.0, -1.0])].concat();
    assert!(difference(&found("gap_jacobian"), &expected) < 1e-15, "{:?}", found("gap_jacobian"));
    assert_eq!(element.kernels.len(), 2);
}

fn error_of(formulas: impl Fn(&ElementModel<'_>)) -> ElementError {
    let error = Config::new().element("test", formulas).and_then(|config| config.source()).unwrap_err();
    let ConfigError::Element { source, .. } = error else { panic!("{error}") };
    source
}

/// Sums without a name make way for quantities of the name that they have inside.
#[test]
fn a_sum_without_a_name_takes_no_name() {
    let element = ElementKernels::new("test", |m| {
        let X: Vec2<'_> = m.node_variable("X");
        let w: Expr<'_> = m.node_parameter("w");
        let mean = m.define("mean", X.map(|X| (w * X).sum() / w.sum()));
        let total = m.define("total", w.sum());
        m.energy(mean.dot(mean) * total);
    });
    let element = element.unwrap();
    assert_eq!(
        element.kernels[0].spec.quantities.iter().map(|own| own.name.as_str()).collect::<Vec<_>>(),
        ["mean", "total"]
    );
    // Two of the caller's own are one too many.
    let twice = |m: &ElementModel<'_>| {
        let w: Expr<'_> = m.node_parameter("w");
        let total = m.define("total", w.sum());
        m.energy(total * m.define("total", (w * w).sum()));
    };
    assert_eq!(error_of(twice), ElementError::Duplicate { name: "total".to_owned() });
}

#[test]
fn mistakes_with_nodes_name_the_expression() {
    let named = |name: &str| name.to_owned();
    let node = |m: &ElementModel<'_>| m.energy(m.node_variable::<Expr<'_>>("x"));
    assert!(matches!(error_of(node), ElementError::Scope { .. }));
    let points = |m: &ElementModel<'_>| {
        let (x, xi): (Expr<'_>, Expr<'_>) = (m.node_variable("x"), m.points("xi", &[[0.5]]));
        m.energy((x * x).sum() * xi);
    };
    assert_eq!(error_of(points), ElementError::NodesAndPoints);
    let taken = |m: &ElementModel<'_>| {
        let (x, nodes): (Expr<'_>, Expr<'_>) = (m.node_variable("x"), m.variable("nodes"));
        m.energy((x * x).sum() * nodes);
    };
    assert_eq!(error_of(taken), ElementError::Reserved { name: named("nodes") });
    let cubic = |m: &ElementModel<'_>| {
        let x: Expr<'_> = m.node_variable("x");
        let fit = m.stationary("c", |c: Vector<'_, 1>| (x - c[0]).powi(4));
        m.energy(fit.unknowns[0]);
    };
    assert_eq!(error_of(cubic), ElementError::NotQuadratic { unknowns: named("c") });
    let in_sum = |m: &ElementModel<'_>| {
        let x: Vec2<'_> = m.node_variable("x");
        let root = m.root("foot", |u| (x - u).map(|x| (x * x * x).sum()));
        m.energy(root.unknowns[0]);
    };
    assert_eq!(error_of(in_sum), ElementError::RootInSum { root: named("foot") });
    // A root of the sheet's: its equations hide the sums in them.
    let hidden = |m: &ElementModel<'_>| {
        let x: Vec2<'_> = m.node_variable("x");
        let u = m.sheet().variables(["u", "v"]);
        let (_, u) = m.sheet().root("foot", u, u - x.map(|x| (x * x).sum()));
        m.energy(u[0] * u[1]);
    };
    assert_eq!(error_of(hidden), ElementError::NoSum { quantity: named("energy") });
    for name in ["node_count", "node_index"] {
        let taken = |m: &ElementModel<'_>| {
            let (x, other): (Expr<'_>, Expr<'_>) = (m.node_variable("x"), m.parameter(name));
            m.energy((x * x).sum() * other);
        };
        assert_eq!(error_of(taken), ElementError::Reserved { name: named(name) });
    }
    // Equations of a node are not those of an element.
    let of_node = |m: &ElementModel<'_>| {
        let (x, z): (Vec2<'_>, Expr<'_>) = (m.node_variable("x"), m.variable("z"));
        let root = m.root("u", |u: Vector<'_, 1>| Vector([u[0].powi(3) + u[0] - x[0]]));
        m.energy(root.unknowns[0] * z + (x[1] * x[1]).sum());
    };
    assert!(matches!(error_of(of_node), ElementError::Scope { output, .. } if output == "u"));
    // The unknown stands in a sum within a sum, and stays there.
    let nested = |m: &ElementModel<'_>| {
        let (x, w): (Expr<'_>, Expr<'_>) = (m.node_variable("x"), m.node_variable("w"));
        let fit = m.stationary("u", |u: Vector<'_, 1>| {
            let inner = (u[0] * x).sum();
            0.5 * u[0].powi(2) + (w * inner * inner).sum() - u[0]
        });
        m.energy(fit.unknowns[0].powi(2));
    };
    assert!(matches!(error_of(nested), ElementError::NoSum { .. }));
    let twice = |m: &ElementModel<'_>| {
        let x: Expr<'_> = m.node_variable("x");
        let _: Expr<'_> = m.variable("x");
        m.energy((x * x).sum());
    };
    assert_eq!(error_of(twice), ElementError::Duplicate { name: named("x") });
}
