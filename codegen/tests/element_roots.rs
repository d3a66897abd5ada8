//! Roots, linear equations and stationary points of one to eight unknowns, by the interpreter, against automatic differentiation of the
//! same quantities found in another way.
#![allow(non_snake_case)]

use diffuse_contact_codegen::expr::{Expr, Matrix, Vec2, Vec3, Vector, dot, total};
use diffuse_contact_codegen::interpret::{element_derivatives, element_results};
use diffuse_contact_codegen::{Config, ConfigError, ElementError, ElementKernels, ElementModel, Limits};
use num_dual::{DualNum as _, HyperDual};

use crate::witnesses::{Number, by_hyper_dual, difference, numbers, sum};

/// Energy, gradient and Hessian of the graph, and the derivatives by expansions, against a function of all variables.
fn check(
    formulas: impl Fn(&ElementModel<'_>),
    x: &[f64],
    f: impl Fn(&[HyperDual<f64>]) -> HyperDual<f64>,
) -> Vec<(String, Vec<f64>)> {
    let element = ElementKernels::new("test", formulas).unwrap();
    let all = element_results(element.kernels.last().unwrap(), &[x], &[]);
    let value = |name: &str| &all.iter().find(|(other, _)| other == name).unwrap().1;
    let energy = f(&x.iter().map(|&x| HyperDual::from(x)).collect::<Vec<_>>()).re;
    let (gradient, hessian) = by_hyper_dual(x, f);
    let worst = difference(value("energy"), &[energy])
        .max(difference(value("gradient"), &gradient))
        .max(difference(value("hessian"), &hessian));
    assert!(worst < 1e-12, "{worst:e}");
    for (name, found) in element_derivatives(&element, &[x], &[]) {
        let worst = difference(&found, if name == "gradient" { &gradient } else { &hessian });
        assert!(worst < 1e-12, "{name} by expansions: {worst:e}");
    }
    all
}

/// u_k + u_{k+1}²/10 = x_k, all around, for N unknowns: by Newton's iteration, and by one that only repeats.
fn ring<const N: usize>() {
    let formulas = |m: &ElementModel<'_>| {
        let x: Vector<'_, N> = m.variable("x");
        let root =
            m.root("u", |u: Vector<'_, N>| Vector::from_fn(|k| u[k] + 0.1 * u[(k + 1) % N].powi(2) - x[k]));
        let u = root.unknowns;
        m.energy(total((0..N).map(|k| (u[k] + f64::from(k as u8) * u[0]).powi(2) * u[N - 1].exp())));
        m.value("residual", root.residual);
    };
    let of = |x: &[HyperDual<f64>]| {
        let mut u = x.to_vec();
        for _ in 0..100 {
            u = (0..N).map(|k| x[k] - u[(k + 1) % N] * u[(k + 1) % N] * 0.1).collect();
        }
        sum((0..N).map(|k| {
            let term = u[k] + u[0] * k as f64;
            term * term * u[N - 1].exp()
        }))
    };
    let x: Vec<f64> = numbers(N, 0.31).iter().map(|x| x + 0.8).collect();
    let all = check(formulas, &x, of);
    assert!(all.iter().any(|(name, x)| name == "residual" && x[0] < 1e-12));
}

#[test]
fn a_root_of_one_to_eight_equations() {
    ring::<1>();
    ring::<2>();
    ring::<3>();
    ring::<4>();
    ring::<6>();
    ring::<8>();
}

/// x u² = y by a start that is far from the root at −u, with unknowns of order hundred.
#[test]
fn a_root_from_a_start_within_limits() {
    let formulas = |m: &ElementModel<'_>| {
        let x: Vec2<'_> = m.variable("x");
        let start = Vector([100.0 * x[0] / x[0], 60.0 + x[1] / 1e3]);
        let limits = Limits { longest_step: 50.0, evaluations: 40 };
        let root = m.root_from("u", start, limits, |u| {
            Vector([x[0] * u[0] * u[0] - x[1], u[1] + 0.01 * u[0] - x[0]])
        });
        m.energy(root.unknowns[0] * root.unknowns[1].powi(2));
    };
    let of = |x: &[HyperDual<f64>]| {
        let u = (x[1] / x[0]).sqrt();
        let v = x[0] - u * 0.01;
        u * v * v
    };
    check(formulas, &[2.5, 7e3], of);
}

/// Linear equations with zeros where elimination in the order of the rows looks for pivots.
#[test]
fn linear_equations_without_symmetry() {
    let formulas =
        |m: &ElementModel<'_>| {
            let x: Vector<'_, 5> = m.variable("x");
            let A = Matrix::from_fn(|i, j| {
                if i == j { m.sheet().zero() } else { x[i] * (1.0 + j as f64) + x[j].powi(2) }
            });
            let b: Vector<'_, 5> = Vector::from_fn(|i| x[i].exp());
            let solution = m.solve("u", A, b);
            m.energy(dot(solution.unknowns.0, b.0) + solution.unknowns[2].powi(2));
            m.value("residual", solution.residual);
        };
    let of = |x: &[HyperDual<f64>]| {
        let entry = |i: usize, j: usize| {
            if i == j { HyperDual::from(0.0) } else { x[i] * (1.0 + j as f64) + x[j] * x[j] }
        };
        let b: Vec<HyperDual<f64>> = x.iter().map(|x| x.exp()).collect();
        let u = pivoted((0..5).map(|i| (0..5).map(|j| entry(i, j)).collect()).collect(), b.clone());
        sum((0..5).map(|i| u[i] * b[i])) + u[2] * u[2]
    };
    let all = check(formulas, &[0.3, 0.9, -0.7, 0.4, 1.1], of);
    assert!(all.iter().any(|(name, x)| name == "residual" && x[0] < 1e-12));
}

/// A⁻¹ b with the largest pivots.
fn pivoted<D: Number>(mut A: Vec<Vec<D>>, mut b: Vec<D>) -> Vec<D> {
    let n = b.len();
    for k in 0..n {
        let largest = (k..n).max_by(|&i, &j| A[i][k].re().abs().total_cmp(&A[j][k].re().abs())).unwrap();
        A.swap(k, largest);
        b.swap(k, largest);
        for i in 0..n {
            if i != k {
                let (factor, pivot, known) = (A[i][k] / A[k][k], A[k].clone(), b[k]);
                A[i].iter_mut().zip(pivot).for_each(|(x, y)| *x -= factor * y);
                b[i] -= factor * known;
            }
        }
    }
    (0..n).map(|k| b[k] / A[k][k]).collect()
}

/// Where Σ (cosh-like) energies of four unknowns are stationary, from a start; two of them at a saddle.
#[test]
fn a_stationary_point_of_a_function_that_is_not_quadratic() {
    let formulas = |m: &ElementModel<'_>| {
        let x: Vector<'_, 4> = m.variable("x");
        let limits = Limits { longest_step: 1.0, evaluations: 60 };
        let start: Vector<'_, 4> = Vector::from_fn(|k| 0.9 * x[k]);
        let found = m.stationary_from("u", start, limits, |u| {
            let own = total((0..4).map(|k| {
                let sign = if k < 2 { 1.0 } else { -1.0 };
                sign * (0.5 * u[k] * u[k] + 0.05 * u[k].powi(4)) - sign * x[k] * u[k]
            }));
            own + 0.1 * u[0] * u[3]
        });
        let u = found.unknowns;
        m.energy(u[0] * u[1] + u[2].sin() * u[3]);
        m.value("residual", found.residual);
    };
    let of = |x: &[HyperDual<f64>]| {
        let mut u = x.to_vec();
        for _ in 0..300 {
            let coupling = [u[3] * -0.1, x[0] * 0.0, x[0] * 0.0, u[0] * 0.1];
            u = (0..4).map(|k| (x[k] + coupling[k]) / (u[k] * u[k] * 0.2 + 1.0)).collect();
        }
        u[0] * u[1] + u[2].sin() * u[3]
    };
    let all = check(formulas, &[0.7, -0.4, 0.9, 0.5], of);
    assert!(all.iter().any(|(name, x)| name == "residual" && x[0] < 1e-12));
}

/// A spring to a point on a fixed obstacle that follows the second node alone: the energy changes when both nodes move together.
#[test]
fn equations_that_do_not_contain_the_first_node() {
    let root = |m: &ElementModel<'_>| {
        let x: [Vec2<'_>; 2] = m.variable("x");
        let foot = m.root("foot", |u: Vector<'_, 1>| Vector([u[0] + u[0].powi(3) - x[1][0]])).unknowns[0];
        m.energy((x[1] - x[0]).dot(x[1] - x[0]) + foot.powi(2));
        m.product();
    };
    let of_root = |x: &[HyperDual<f64>]| {
        let mut u = x[2] * 0.5;
        for _ in 0..60 {
            u = u - (u + u * u * u - x[2]) / (u * u * 3.0 + 1.0);
        }
        let way = [x[2] - x[0], x[3] - x[1]];
        way[0] * way[0] + way[1] * way[1] + u * u
    };
    let x = [0.1, -0.2, 0.7, 0.4];
    check(root, &x, of_root);
    // Linear equations and a function to be made stationary as well.
    let linear = |m: &ElementModel<'_>| {
        let x: [Vec2<'_>; 2] = m.variable("x");
        let u = m.solve("u", Matrix([[x[1][0] + 2.0]]), Vector([x[1][1]])).unknowns[0];
        let v = m.stationary("v", |v: Vector<'_, 1>| {
            0.5 * (x[1][0] * x[1][0] + 1.0) * v[0].powi(2) - x[1][1] * v[0]
        });
        m.energy((x[1] - x[0]).dot(x[1] - x[0]) + u.powi(2) + v.unknowns[0].powi(3));
    };
    let of_linear = |x: &[HyperDual<f64>]| {
        let (u, v) = (x[3] / (x[2] + 2.0), x[3] / (x[2] * x[2] + 1.0));
        let way = [x[2] - x[0], x[3] - x[1]];
        way[0] * way[0] + way[1] * way[1] + u * u + v * v * v
    };
    check(linear, &x, of_linear);
}

/// Near a maximum the interpreter goes down, as kernels do.
#[test]
fn the_interpreter_finds_the_roots_that_kernels_find() {
    let formulas = |m: &ElementModel<'_>| {
        let c: Expr<'_> = m.variable("c");
        let well = m.minimum("u", |u: Vec2<'_>| {
            (u[0].powi(2) - 1.0).powi(2) + c * u[0] + u[1].powi(2) + 0.1 * u[0] * u[1]
        });
        m.energy(well.unknowns[0]);
    };
    let element = ElementKernels::new("test", formulas).unwrap();
    let of = |c: f64, name: &str| {
        let all = element_results(element.kernels.first().unwrap(), &[&[c]], &[]);
        all.into_iter().find(|(other, _)| other == name).unwrap().1[0]
    };
    for c in [0.1, 1e-3, -0.1] {
        let u = of(c, "energy");
        assert!(u * c < 0.0 && (0.9..1.1).contains(&u.abs()), "{c} {u}");
    }
}

/// Derivatives of how an iteration went are refused; conditions on it are not.
#[test]
fn figures_of_an_iteration_have_no_derivatives() {
    let with = |state: for<'g> fn(&ElementModel<'g>, Expr<'g>, Expr<'g>)| {
        ElementKernels::new("test", |m| {
            let x: Expr<'_> = m.variable("x");
            let root = m.root("u", |u: Vector<'_, 1>| Vector([u[0] + u[0].powi(3) - x]));
            state(m, x, root.residual);
        })
    };
    let error = |state: for<'g> fn(&ElementModel<'g>, Expr<'g>, Expr<'g>)| with(state).err();
    let figure = |output: &str| Some(ElementError::Figure { output: output.to_owned() });
    assert_eq!(error(|m, _, residual| m.residual("r", residual)), figure("r"));
    assert_eq!(error(|m, x, residual| m.energy(x * m.define("size", residual + 1.0))), figure("energy"));
    assert_eq!(error(|m, x, residual| m.energy(residual.less(1e-12).select(x * x, 2.0 * x))), None);
    // Only the residual is used: the equations are solved all the same.
    let solved = with(|m, x, residual| {
        m.energy(x * x);
        m.value("size", residual);
    });
    let config = Config::new().element("test", |m| {
        let x: Expr<'_> = m.variable("x");
        let root = m.root("u", |u: Vector<'_, 1>| Vector([u[0] + u[0].powi(3) - x]));
        m.energy(x * x);
        m.value("size", root.residual);
    });
    assert!(config.unwrap().source().is_ok());
    let all = element_results(solved.unwrap().kernels.first().unwrap(), &[&[0.7]], &[]);
    assert!(all.iter().any(|(name, x)| name == "size" && x[0] < 1e-12));
}

#[test]
fn too_many_equations_are_refused() {
    let error_of = |formulas: fn(&ElementModel<'_>)| {
        let error = Config::new().element("test", formulas).unwrap_err();
        let ConfigError::Element { source, .. } = error else { panic!("{error}") };
        source
    };
    let nine = |m: &ElementModel<'_>| {
        let x: Vector<'_, 9> = m.variable("x");
        m.energy(m.root("u", |u| u - x).unknowns[0]);
    };
    assert_eq!(error_of(nine), ElementError::Root { root: "u".to_owned(), equations: 9 });
    let minimum = |m: &ElementModel<'_>| {
        let x: Vec3<'_> = m.variable("x");
        m.energy(m.minimum("u", |u: Vec3<'_>| (u - x).dot(u - x)).unknowns[0]);
    };
    assert_eq!(error_of(minimum), ElementError::Root { root: "u".to_owned(), equations: 3 });
}

/// The number of Hessian's statements stays small: multipliers are found once, not for each variable twice.
#[test]
fn derivatives_of_a_root_solve_few_equations() {
    let element = ElementKernels::new("test", |m: &ElementModel<'_>| {
        let x: Vector<'_, 6> = m.variable("x");
        let root =
            m.root("u", |u: Vector<'_, 6>| Vector::from_fn(|k| u[k] + 0.1 * u[(k + 1) % 6].powi(2) - x[k]));
        m.energy(root.unknowns.dot(root.unknowns));
    })
    .unwrap();
    let text = diffuse_contact_codegen::emit::emit_element_kernel(&element.kernels[2]).tokens.to_string();
    let solves = text.matches("within").count();
    println!("{solves} systems");
    assert!(solves <= 8, "{solves}: {text}");
}

/// What contains unknowns that are sought under a name would not change with them.
#[test]
fn a_definition_of_what_is_sought_is_refused() {
    type Formulas = fn(&ElementModel<'_>);
    let all: [(&str, Formulas); 6] = [
        ("way", |m| {
            let x: Vec2<'_> = m.variable("x");
            m.energy(m.minimum("u", |u: Vec2<'_>| m.define("way", (u - x).dot(u - x))).unknowns[0]);
        }),
        ("way", |m| {
            let x: Vec2<'_> = m.variable("x");
            m.energy(m.stationary("u", |u: Vec2<'_>| m.define("way", (u - x).dot(u - x))).unknowns[0]);
        }),
        ("way", |m| {
            let x: Vec2<'_> = m.variable("x");
            let limits = Limits::default();
            let root = m.stationary_from("u", x, limits, |u: Vec2<'_>| m.define("way", u.dot(u)));
            m.energy(root.unknowns[0]);
        }),
        ("way_1", |m| {
            let x: Vec2<'_> = m.variable("x");
            m.energy(m.root("u", |u: Vec2<'_>| m.define("way", u - x)).unknowns[0]);
        }),
        ("way", |m| {
            let x: Vec2<'_> = m.variable("x");
            m.energy(m.minimum("u", |u: Vec2<'_>| m.held("way", u[0]) * u.dot(x)).unknowns[0]);
        }),
        ("inner_2", |m| {
            let x: Vec2<'_> = m.variable("x");
            let least = m.minimum("u", |u: Vec2<'_>| {
                m.root("inner", |v: Vec2<'_>| v + v.dot(v) * u - x).unknowns.dot(u)
            });
            m.energy(least.unknowns[0]);
        }),
    ];
    for (name, formulas) in all {
        let error = ElementKernels::new("test", formulas).unwrap_err();
        let ElementError::Sought { quantity, unknown } = &error else { panic!("{name}: {error}") };
        assert!(quantity == name && unknown.contains("unknown_"), "{name}: {error}");
    }
}

/// Kernel and interpreter count other things in an iteration: tests ask for convergence, and compare everything else.
#[test]
fn a_test_does_not_compare_how_an_iteration_went() {
    let config = Config::new().element("test", |m| {
        let x: Vec2<'_> = m.variable("x");
        let root = m.root("u", |u: Vec2<'_>| u + 0.1 * u.dot(u) * u - x);
        m.energy(root.unknowns.dot(root.unknowns));
        m.value("steps", root.iterations);
        m.value("figures", Vector([root.residual, x[0]]));
    });
    let text = config.unwrap().test("test", &[&[0.3, 0.4]], &[]).source().unwrap();
    let tests: String = text[text.find("mod test_tests").unwrap()..].split_whitespace().collect();
    assert!(!tests.contains(r#"agree("steps""#), "{tests}");
    assert!(tests.contains("assert!(found.values.figures[0]<") && tests.contains("showsnoroot"), "{tests}");
    assert!(tests.contains(r#"agree("figures",&[found.values.figures[1]][..],&[0.3"#), "{tests}");
}

/// A name in the formulas may be the one that an unknown has: the code gives the unknown another one.
#[test]
fn an_unknown_has_a_name_of_its_own_in_the_code() {
    let config = Config::new().element("named", |m| {
        let x: Vec3<'_> = m.variable("x");
        let length = x.norm().named("foot_unknown_1");
        let foot =
            m.root("foot", |u| Vector([u[0] + 0.3 * u[1] * u[1] - length, u[1] + 0.2 * u[0] * u[1] - x[0]]));
        m.energy(length * foot.unknowns[0] * foot.unknowns[1]);
    });
    let source = config.unwrap().source().unwrap();
    assert!(source.contains("let foot_unknown_1 = "), "{source}");
    assert!(source.contains("let [foot_unknown_1_v2, foot_unknown_2] = foot_iteration.point();"), "{source}");
    // In the equations the unknown, not the length.
    assert!(
        source.contains("foot_unknown_1_v2 * foot_unknown_2")
            || source.contains("foot_unknown_1_v2.mul_add(")
    );
}
