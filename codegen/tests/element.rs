//! Elements of the caller's: their graphs against automatic differentiation of energies written independently, their
//! operations, their mistakes, and the checked-in text of a small one.
#![allow(non_snake_case)]

use diffuse_contact_codegen::emit::MOST_STATEMENTS;
use diffuse_contact_codegen::emit::emit_element_kernel;
use diffuse_contact_codegen::expr::{Expr, Mat3, Matrix, Vec2, Vec3, Vector, total};
use diffuse_contact_codegen::graph::{Limits, Scope};
use diffuse_contact_codegen::interpret::{element_derivatives, element_results};
use diffuse_contact_codegen::{
    Config, ConfigError, ElementError, ElementKernels, ElementModel, Mode, Polynomial,
};
use num_dual::{DualNum as _, HyperDual};

use crate::witnesses::{Number, by_hyper_dual, difference, interpreted, numbers, spring, sum, tet4};

const GOLDEN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../generated/golden/element_spring.rs");

/// SymX's count for the Hessian of the same element, ACM TOG 45(1):5, 2026.
const SYMX_OPERATIONS: usize = 1_833;

/// The same without names for what it is made of.
fn tet4_unnamed(m: &ElementModel<'_>) {
    let (x, X): ([Vec3<'_>; 4], [Vec3<'_>; 4]) = (m.variable("x"), m.parameter("X"));
    let [lambda, mu] = m.parameters(["lambda", "mu"]);
    let [d, D] = [x, X].map(|x| Mat3::from_columns([1, 2, 3].map(|k| x[k] - x[0])));
    let F = d * D.inverse();
    let L = F.determinant().ln();
    let W = 0.5 * mu * ((F.transpose() * F).trace() - 3.0 - 2.0 * L) + 0.5 * lambda * L * L;
    m.energy(D.determinant() / 6.0 * W);
}

/// The energy of the tetrahedron once more, from volumes: F_ij det D = det(D with its column j replaced), columns over edges.
fn tet4_energy<D: Number>(x: &[D], X: &[f64], [lambda, mu]: [f64; 2]) -> D {
    let det = |a: [[D; 3]; 3]| {
        let minor = |i: usize, j: usize| a[1][i] * a[2][j] - a[1][j] * a[2][i];
        a[0][0] * minor(1, 2) - a[0][1] * minor(0, 2) + a[0][2] * minor(0, 1)
    };
    let edges = |x: &dyn Fn(usize) -> D| [1, 2, 3].map(|k| [0, 1, 2].map(|i| x(3 * k + i) - x(i)));
    let (now, before) = (edges(&|k| x[k]), edges(&|k| D::from(X[k])));
    let F = [0, 1, 2].map(|i| {
        [0, 1, 2].map(|j| {
            let mut replaced = before;
            (0..3).for_each(|edge| replaced[edge][j] = now[edge][i]);
            det(replaced) / det(before)
        })
    });
    let trace = sum(F.as_flattened().iter().map(|&f| f * f));
    let L = (det(now) / det(before)).ln();
    det(before) / 6.0 * ((trace - 3.0) * (0.5 * mu) - L * mu + L * L * (0.5 * lambda))
}

fn kernels(formulas: impl Fn(&ElementModel<'_>)) -> ElementKernels {
    ElementKernels::new("test", formulas).unwrap()
}

#[test]
fn a_tetrahedron_has_the_derivatives_of_automatic_differentiation() {
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].concat();
    let mut worst = 0.0_f64;
    for formulas in [tet4, tet4_unnamed] {
        let element = kernels(formulas);
        for seed in [0.31, 0.57, 0.83] {
            let moved = |by: f64, seed: f64| -> Vec<f64> {
                corners.iter().zip(numbers(12, seed)).map(|(x, random)| x + by * random).collect()
            };
            let (X, x, constants) = (moved(0.3, seed), moved(0.6, seed + 0.01), [1.7, 0.9]);
            let inputs: [&[f64]; 4] = [&x, &X, &constants[..1], &constants[1..]];
            let energy = tet4_energy(&x, &X, constants);
            let (gradient, hessian) = by_hyper_dual(&x, |x| tet4_energy(x, &X, constants));
            for mode in Mode::ALL {
                let found = interpreted(&element, mode, &inputs, &[]);
                worst = worst.max(difference(&found("energy"), &[energy]));
                if mode >= Mode::Gradient {
                    worst = worst.max(difference(&found("gradient"), &gradient));
                }
                if mode == Mode::Hessian {
                    worst = worst.max(difference(&found("hessian"), &hessian));
                }
            }
        }
    }
    println!("largest relative difference {worst:.1e}");
    assert!(worst < 1e-12, "{worst:e}");
}

#[test]
fn a_tetrahedron_takes_a_third_of_the_operations_of_other_generators() {
    for (formulas, most) in [(tet4 as fn(&ElementModel<'_>), 580), (tet4_unnamed, 620)] {
        let emitted = kernels(formulas).kernels.iter().map(emit_element_kernel).collect::<Vec<_>>();
        let operations: Vec<usize> = emitted.iter().map(|kernel| kernel.counts.total()).collect();
        println!("value, gradient, Hessian: {operations:?} operations");
        assert!(operations[2] <= most && 3 * operations[2] < SYMX_OPERATIONS, "{operations:?}");
        assert!(3 * operations[1] < operations[2], "{operations:?}");
    }
}

/// Values of an element with one number as its input.
fn values_at(x: f64, formulas: impl Fn(&ElementModel<'_>)) -> impl Fn(&str) -> Vec<f64> {
    let element = kernels(formulas);
    interpreted(&element, Mode::Value, &[&[x]], &[])
}

#[test]
fn a_vector_of_one_entry_has_its_absolute_value_as_norm() {
    let formulas = |m: &ElementModel<'_>| {
        let x: Expr<'_> = m.variable("x");
        m.energy((Vector([x]).norm() - 1.0).powi(2));
        m.value("square", Vector([x]).norm().powi(2));
    };
    let found = values_at(-1.5, formulas);
    assert_eq!((found("energy"), found("square")), (vec![0.25], vec![2.25]));
}

#[test]
fn other_values_go_through_definitions() {
    let found = values_at(0.5, |m| {
        let x: Expr<'_> = m.variable("x");
        let stretch = m.define("stretch", 2.0 * x);
        let square = m.define("square", stretch * stretch + x);
        m.energy(square);
        m.value("at_three", (square + x).at(&[(x, m.sheet().number(3.0))]));
        m.value("of_stretch", square.at(&[(stretch, m.sheet().number(3.0))]));
    });
    assert_eq!((found("energy")[0], found("at_three")[0], found("of_stretch")[0]), (1.5, 42.0, 9.5));
}

#[test]
#[should_panic(expected = "unknowns of equations change with `x`")]
fn unknowns_have_no_other_values() {
    kernels(|m| {
        let x: Expr<'_> = m.variable("x");
        let root = m.root("u", |u: Vector<'_, 1>| u - Vector([x]));
        m.energy(root.unknowns[0].at(&[(x, m.sheet().number(3.0))]));
    });
}

/// A cohesive law with damage that grows with the largest opening.
fn cohesive(m: &ElementModel<'_>) {
    let opening: Vec3<'_> = m.variable("opening");
    let [stiffness, length, before] = m.parameters(["stiffness", "length", "damage_before"]);
    let damage = m.define("damage", (1.0 - (-opening.norm() / length).exp()).max(before));
    m.residual("traction", (1.0 - damage) * stiffness * opening);
    m.value("damage", damage);
}

#[test]
fn a_law_with_history_has_its_jacobian_and_its_new_state() {
    let element = kernels(cohesive);
    assert_eq!(element.kernels.len(), 2);
    let opening = [0.2, -0.3, 0.4];
    for before in [0.1, 0.9] {
        let damage = |x: &[HyperDual<f64>]| {
            let norm = sum(x.iter().map(|&x| x * x)).sqrt();
            let now = -(-norm / 0.7).exp() + 1.0;
            if now.re < before { HyperDual::from(before) } else { now }
        };
        let found = interpreted(&element, Mode::Gradient, &[&opening, &[3.0], &[0.7], &[before]], &[]);
        let values: Vec<f64> = found("traction");
        for i in 0..3 {
            let traction = |x: &[HyperDual<f64>]| (-damage(x) + 1.0) * x[i] * 3.0;
            let (gradient, _) = by_hyper_dual(&opening, traction);
            assert!(difference(&found("traction_jacobian")[3 * i..3 * i + 3], &gradient) < 1e-12);
            let expected = traction(&opening.map(HyperDual::from)).re;
            assert!((values[i] - expected).abs() < 1e-14 * expected.abs());
        }
        let expected = damage(&opening.map(HyperDual::from)).re;
        assert!((found("damage")[0] - expected).abs() < 1e-15);
    }
}

/// A root is differentiated by the implicit function theorem, also through what it depends on.
#[test]
fn a_root_of_two_equations_is_part_of_an_energy() {
    let element = kernels(|m| {
        let x: Vec2<'_> = m.variable("x");
        let q = m.define("q", x.dot(x));
        let u = m.sheet().variables(["u", "v"]);
        let equations = Vector([u[0] + 0.1 * u[1] * u[1] - q, u[1] + 0.2 * u[0] * u[1] - x[0]]);
        let (_, u) = m.sheet().root("point", u, equations);
        m.energy(u[0] * u[1]);
    });
    let x = [0.4, -0.3];
    let (gradient, hessian) = by_hyper_dual(&x, |x| {
        let q = x[0] * x[0] + x[1] * x[1];
        let (mut u, mut v) = (HyperDual::from(0.0), HyperDual::from(0.0));
        for _ in 0..200 {
            (u, v) = (q - v * v * 0.1, x[0] / (u * 0.2 + 1.0));
        }
        u * v
    });
    let found = interpreted(&element, Mode::Hessian, &[&x], &[]);
    assert!(difference(&found("gradient"), &gradient) < 1e-12);
    assert!(difference(&found("hessian"), &hessian) < 1e-12);
    let source = Config::new().element("root", |m| m.energy(m.variable::<Expr<'_>>("x").sin())).unwrap();
    assert!(!source.source().unwrap().contains("TwoEquations"));
    let text = emit_element_kernel(&element.kernels[2]).tokens.to_string();
    assert!(text.contains("TwoEquations"), "{text}");
}

/// The same with [`ElementModel::root`], whose unknowns are never differentiated twice: the equations are, weighted by their multipliers.
/// The energy depends on the root in three ways, the equations on the variables and on what is made of them.
#[test]
fn a_root_takes_the_second_derivatives_of_its_equations() {
    let element = kernels(|m| {
        let x: Vec3<'_> = m.variable("x");
        let q = m.define("q", x.dot(x));
        let root = m.root("point", |u| {
            Vector([u[0] + 0.1 * u[1] * u[1] * x[2] - q, u[1] + 0.2 * u[0] * u[1] - x[0] * x[1]])
        });
        let [u, v] = root.unknowns.0;
        let shifted = m.define("shifted", (u + x[1]) * v);
        m.energy(u * v + shifted.exp() * x[2] + u.sin());
        m.value("residual", root.residual);
    });
    let x = [0.4, -0.3, 0.7];
    let (gradient, hessian) = by_hyper_dual(&x, |x| {
        let q = x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
        let (mut u, mut v) = (HyperDual::from(0.0), HyperDual::from(0.0));
        for _ in 0..200 {
            (u, v) = (q - v * v * x[2] * 0.1, x[0] * x[1] / (u * 0.2 + 1.0));
        }
        u * v + ((u + x[1]) * v).exp() * x[2] + u.sin()
    });
    for mode in [Mode::Gradient, Mode::Hessian] {
        let found = interpreted(&element, mode, &[&x], &[]);
        assert!(difference(&found("gradient"), &gradient) < 1e-12);
        assert!(mode == Mode::Gradient || difference(&found("hessian"), &hessian) < 1e-12);
        assert!(found("residual")[0] < 1e-12);
    }
}

/// A quantity in a root's equations that is itself made of others: a length, which the derivatives go through by a symbol of its own.
#[test]
fn a_root_depends_on_quantities_that_are_rewritten() {
    let element = kernels(|m| {
        let x: Vec2<'_> = m.variable("x");
        let direction = m.define("direction", x.unit());
        let u = m.sheet().variables(["u", "v"]);
        let equations =
            Vector([u[0] + 0.1 * u[1] * u[1] - direction[0], u[1] + 0.2 * u[0] * u[1] - direction[1]]);
        let (_, u) = m.sheet().root("point", u, equations);
        m.residual("force", u[0] * direction);
    });
    let x = [0.4, -0.3];
    let found = interpreted(&element, Mode::Gradient, &[&x], &[]);
    for i in 0..2 {
        let (gradient, _) = by_hyper_dual(&x, |x| {
            let norm = (x[0] * x[0] + x[1] * x[1]).sqrt();
            let d = [x[0] / norm, x[1] / norm];
            let (mut u, mut v) = (HyperDual::from(0.0), HyperDual::from(0.0));
            for _ in 0..200 {
                (u, v) = (d[0] - v * v * 0.1, d[1] / (u * 0.2 + 1.0));
            }
            u * d[i]
        });
        assert!(difference(&found("force_jacobian")[2 * i..2 * i + 2], &gradient) < 1e-12);
    }
}

/// Outside mechanics: how far a plane arm of three links is from a point, by its angles.
#[test]
fn an_arm_has_the_hessian_of_its_distance() {
    let element = kernels(|m| {
        let (angles, target): ([Expr<'_>; 3], Vec2<'_>) = (m.variable("angle"), m.parameter("target"));
        let (mut tip, mut sum) = (-target, m.sheet().zero());
        for angle in angles {
            sum += angle;
            tip[0] += sum.cos();
            tip[1] += sum.sin();
        }
        m.energy(tip.norm());
    });
    let (angles, target) = ([0.3, 0.5, -0.9], [0.4, 1.1]);
    let (gradient, hessian) = by_hyper_dual(&angles, |angles| {
        let (mut tip, mut sum) = (target.map(|x| HyperDual::from(-x)), HyperDual::from(0.0));
        for &angle in angles {
            sum += angle;
            tip = [tip[0] + sum.cos(), tip[1] + sum.sin()];
        }
        (tip[0] * tip[0] + tip[1] * tip[1]).sqrt()
    });
    let found = interpreted(&element, Mode::Hessian, &[&angles, &target], &[]);
    assert!(difference(&found("gradient"), &gradient) < 1e-12);
    assert!(difference(&found("hessian"), &hessian) < 1e-12);
}

/// Formulas end with a statement.
fn discard<T>(_: T) {}

/// The error of an element's formulas, with the element's name.
fn error_of(name: &str, formulas: impl Fn(&ElementModel<'_>)) -> (ElementError, String) {
    let error = Config::new().element(name, formulas).and_then(|config| config.source()).unwrap_err();
    let text = error.to_string();
    assert!(text.contains(&format!("\"{name}\"")), "{text}");
    let ConfigError::Element { source, .. } = error else { panic!("{text}") };
    (source, text)
}

#[test]
fn mistakes_name_the_element_and_the_expression() {
    let scalar = |m: &ElementModel<'_>, name: &str| m.energy(m.variable::<Expr<'_>>(name).powi(2));
    for name in ["r#type", "gen", "fn", "4", "mu ", " mu", "mu /* shear */"] {
        assert_eq!(error_of("test", |m| scalar(m, name)).0, ElementError::Name { name: name.to_owned() });
    }
    // Both are fields of the inputs.
    let (error, _) = error_of("test", |m| {
        let x: Vec3<'_> = m.variable("x");
        let y: Expr<'_> = m.parameter("x");
        m.energy(x.norm() * y);
    });
    assert_eq!(error, ElementError::Duplicate { name: "x".to_owned() });
    let check = |(found, text): (ElementError, String), expected: ElementError, word: &str| {
        assert_eq!(found, expected);
        assert!(text.contains(word), "{text}");
    };
    let named = |name: &str| name.to_owned();
    for name in ["tet 4", "4", "fn", ""] {
        check(error_of(name, |m| scalar(m, "x")), ElementError::Name { name: named(name) }, name);
    }
    check(error_of("a", |m| scalar(m, "x y")), ElementError::Name { name: named("x y") }, "x y");
    let twice = |m: &ElementModel<'_>| discard((scalar(m, "x"), m.parameter::<Expr<'_>>("x")));
    check(error_of("a", twice), ElementError::Duplicate { name: named("x") }, "\"x\"");
    let energies = |m: &ElementModel<'_>| discard((scalar(m, "x"), m.energy(m.parameter("y"))));
    check(error_of("a", energies), ElementError::Duplicate { name: named("energy") }, "energy");
    let defined = |m: &ElementModel<'_>| {
        discard((scalar(m, "x"), m.define("x", m.sheet().one() + m.sheet().input("y", Scope::Element))))
    };
    check(error_of("a", defined), ElementError::Duplicate { name: named("x") }, "\"x\"");
    let taken = |m: &ElementModel<'_>| discard((scalar(m, "x"), m.value("hessian", m.sheet().one())));
    check(error_of("a", taken), ElementError::DerivativeName { name: named("hessian") }, "hessian");
    let empty = |m: &ElementModel<'_>| m.value("one", m.sheet().one());
    check(error_of("a", empty), ElementError::NoInput, "input");
    let count = |m: &ElementModel<'_>| {
        let x: Expr<'_> = m.node_variable("x");
        let c = m.define("node_count", x.less(1.0).select(1.0, 0.0).sum());
        m.energy((x * x).sum() / c);
    };
    check(error_of("a", count), ElementError::Reserved { name: named("node_count") }, "node_count");
    for (longest_step, evaluations) in [(f64::NAN, 9), (-1.0, 9), (0.0, 9), (1.0, 0)] {
        let endless = |m: &ElementModel<'_>| {
            let x: Expr<'_> = m.variable("x");
            let limits = Limits { longest_step, evaluations };
            let root = m.root_from("u", Vector([x]), limits, |u| Vector([u[0] * u[0] - x]));
            m.residual("r", root.unknowns);
        };
        let longest_step = longest_step.to_string();
        let expected = ElementError::Limits { root: named("u"), longest_step, evaluations };
        check(error_of("a", endless), expected, "`u`");
    }
    check(error_of("a", |m| discard(m.variable::<Expr<'_>>("x"))), ElementError::NoOutput, "energy");
    let fixed = |m: &ElementModel<'_>| m.energy(m.parameter::<Expr<'_>>("k").sqrt());
    check(error_of("a", fixed), ElementError::NoVariables { output: named("energy") }, "`energy`");
    let constant = |m: &ElementModel<'_>| {
        let _: Expr<'_> = m.variable("x");
        m.residual("force", m.parameter::<Vec3<'_>>("k"));
    };
    check(error_of("a", constant), ElementError::Constant { output: named("force") }, "`force`");
    let node = |m: &ElementModel<'_>| m.value("height", m.sheet().input("z", Scope::Node));
    let expected = ElementError::Scope { output: named("height") };
    check(error_of("a", node), expected, "`height`");
    let unknown = |m: &ElementModel<'_>| m.value("height", m.sheet().input("z", Scope::Element));
    let expected = ElementError::Undeclared { output: named("height"), symbol: named("z") };
    check(error_of("a", unknown), expected, "`z`");
    let root = |m: &ElementModel<'_>| {
        let (x, u): (Expr<'_>, _) = (m.variable("x"), m.sheet().variables(["u"]));
        let (_, u_root) = m.sheet().root("cube_root", u, u.map(|u| u * u * u - x));
        m.energy(u_root[0]);
    };
    let expected = ElementError::Root { root: named("cube_root"), equations: 1 };
    check(error_of("a", root), expected, "`cube_root`");
    let described = |m: &ElementModel<'_>| discard((scalar(m, "x"), m.describe("y", "length")));
    check(error_of("a", described), ElementError::Unknown { name: named("y") }, "`y`");
    let held = |m: &ElementModel<'_>| discard((scalar(m, "x"), m.held("x", m.parameter::<Expr<'_>>("y"))));
    check(error_of("a", held), ElementError::Duplicate { name: named("x") }, "\"x\"");
    for number in [f64::NAN, f64::INFINITY] {
        let points = |m: &ElementModel<'_>| m.energy(m.points::<Expr<'_>>("xi", &[[0.5], [number]]).powi(2));
        check(error_of("a", points), ElementError::Points { name: named("xi") }, "finite");
    }
}

#[test]
fn formulas_that_are_never_finite_are_refused() {
    type Formula = for<'g> fn(Expr<'g>) -> Expr<'g>;
    let never: [Formula; 8] = [
        |x| x * x * f64::NAN,
        |x| x * x + f64::INFINITY,
        |x| x * x / 0.0,
        |x| x * x + (0.0 * x).powi(-1),
        |x| x * x + x.sheet().number(0.0).ln(),
        |x| x * x + x.sheet().number(-2.0).sqrt() * x,
        |x| x * x + x.sheet().number(-2.0).powf(0.5),
        |x| x.less(0.0).select(x * f64::NAN, x * x),
    ];
    for (k, formula) in never.into_iter().enumerate() {
        let found = Config::new().element("a", |m| m.energy(formula(m.variable("x"))));
        let Err(ConfigError::Element { source, .. }) = found else { panic!("formula {k}") };
        assert_eq!(source, ElementError::NeverFinite { output: "energy".into() }, "{k}");
    }
    for coefficients in [vec![1.0, f64::NAN, 2.0], vec![1.0, f64::INFINITY]] {
        let polynomial = Polynomial::new(coefficients);
        let found = Config::new()
            .element("a", |m| m.energy(m.variable::<Expr<'_>>("x").polynomial(polynomial.clone())));
        assert!(found.is_err());
    }
    // A choice and its condition may begin at infinity.
    let found = Config::new().element("a", |m| {
        let x: Expr<'_> = m.variable("x");
        m.energy(x.less(f64::INFINITY).select(x * x, f64::INFINITY));
    });
    assert!(found.is_ok());
}

/// The exponent of the derivative is no 32-bit number.
#[test]
fn the_least_power_has_a_derivative() {
    let element = kernels(|m| m.energy(m.variable::<Expr<'_>>("x").powi(i32::MIN)));
    let results = element_results(element.kernels.last().unwrap(), &[&[-1.0]], &[]);
    let of = |name: &str| results.iter().find(|(found, _)| found == name).unwrap().1[0];
    assert_eq!((of("energy"), of("gradient")), (1.0, 2.0_f64.powi(31)));
}

/// A name in the formulas need not be one in the code.
#[test]
fn any_name_may_be_given_to_an_expression() {
    let config = Config::new().element("test", |m| {
        let x: Expr<'_> = m.variable("x");
        let sum = (x + 2.0).named("my sum");
        m.energy((sum * sum.sin().named("match")).named("gen").exp());
    });
    let config = config.unwrap();
    assert!(config.source().is_ok_and(|text| !text.contains("my sum")) && config.c_source().is_ok());
}

/// Derivatives that formulas ask for go through what has a name, and not through what is held.
#[test]
fn derivatives_in_formulas_go_through_definitions() {
    let element = kernels(|m| {
        let x: Expr<'_> = m.variable("x");
        let y = m.define("y", x * x);
        let z = m.define("z", y * y + 3.0 * y + x);
        let held = m.held("w", x);
        let f = z * y + held * x;
        m.value("slope", f.by(x));
        m.value("curvature", f.by(x).by(x));
        m.energy(y.by(x));
    });
    let all = element_results(element.kernels.last().unwrap(), &[&[2.0]], &[]);
    let value = |name: &str| all.iter().find(|(other, _)| other == name).unwrap().1[0];
    // x⁶ + 3 x⁴ + x³ + w x
    assert_eq!((value("slope"), value("curvature")), (192.0 + 96.0 + 12.0 + 2.0, 480.0 + 144.0 + 12.0));
    assert_eq!((value("energy"), value("gradient")), (4.0, 2.0));
}

/// Long products are not taken apart without end.
#[test]
fn a_product_of_products_stays_short() {
    let element = kernels(|m| {
        let x: Expr<'_> = m.variable("x");
        m.energy((0..40).fold(x + 1.0, |p, _| p * p));
    });
    assert!(!element.kernels.is_empty());
    let power = kernels(|m| m.energy((0..7).fold(m.variable::<Expr<'_>>("x"), |p, _| p * p)));
    let all = element_results(power.kernels.last().unwrap(), &[&[1.0]], &[]);
    let value = |name: &str| all.iter().find(|(other, _)| other == name).unwrap().1[0];
    assert_eq!((value("energy"), value("gradient"), value("hessian")), (1.0, 128.0, 128.0 * 127.0));
}

#[test]
fn an_element_that_is_too_long_to_compile_is_named() {
    let (error, text) = error_of("long", |m| {
        let x: [Expr<'_>; 120] = m.variable("x");
        m.energy(total(x.windows(2).map(|x| x[0].sin() * x[1])));
    });
    let ElementError::TooLong { function, statements } = error else { panic!("{text}") };
    assert!(function == "hessian" && statements > MOST_STATEMENTS && text.contains("`hessian`"), "{text}");
}

#[test]
fn an_element_has_a_name_of_its_own() {
    let square = |m: &ElementModel<'_>| m.energy(m.variable::<Expr<'_>>("x").powi(2));
    let twice = Config::new().element("a", square).unwrap().element("a", square).unwrap();
    let weight = Config::new().cubic().element("cubic", square).unwrap();
    let facet = Config::new().facets().element("gap_over_triangle", square).unwrap();
    for (config, expected) in [(twice, "a"), (weight, "cubic"), (facet, "gap_over_triangle")] {
        for error in [config.source().unwrap_err(), config.c_source().unwrap_err()] {
            let ConfigError::DuplicateElement { name } = &error else { panic!("{error}") };
            assert_eq!(name, expected);
        }
    }
    let tested =
        Config::new().element("a", square).unwrap().test("a", &[&[1.0]], &[]).test("a", &[&[2.0]], &[]);
    assert!(matches!(tested.source().unwrap_err(), ConfigError::DuplicateTest { name } if name == "a"));
}

#[test]
fn a_test_that_cannot_be_is_refused() {
    let logarithm = |m: &ElementModel<'_>| m.energy(m.variable::<Expr<'_>>("x").ln());
    let config = Config::new().element("a", logarithm).unwrap();
    let error = |name, inputs: &[&[f64]]| config.clone().test(name, inputs, &[]).source().unwrap_err();
    assert!(matches!(error("b", &[&[1.0]]), ConfigError::UnknownElement { name } if name == "b"));
    let lengths =
        |input: &str, expected, found| ElementError::TestInputs { input: input.to_owned(), expected, found };
    let not_finite = ElementError::TestResult { result: "energy".to_owned() };
    let all: [(&[&[f64]], ElementError); 3] =
        [(&[], lengths("inputs", 1, 0)), (&[&[1.0, 2.0]], lengths("x", 1, 2)), (&[&[-1.0]], not_finite)];
    for (inputs, expected) in all {
        let error = error("a", inputs);
        let ConfigError::Element { source, .. } = &error else { panic!("{error}") };
        assert_eq!(*source, expected);
    }
    let number = config.clone().test("a", &[&[f64::NAN]], &[]).source().unwrap_err();
    let ConfigError::Element { source: ElementError::TestNumber { input }, .. } = &number else {
        panic!("{number}")
    };
    assert_eq!(input, "x");
    assert!(config.test("a", &[&[2.0]], &[]).source().unwrap().contains("mod a_tests"));
}

/// Energies that are finite where their derivatives are not.
#[test]
fn a_test_whose_derivatives_are_not_finite_is_refused() {
    type Formulas = fn(&ElementModel<'_>);
    let all: [(Formulas, &[f64]); 4] = [
        (|m| m.energy(m.variable::<Vec3<'_>>("x").norm()), &[0.0; 3]),
        (|m| m.energy(m.variable::<Expr<'_>>("x").sqrt()), &[0.0]),
        (|m| m.energy(m.variable::<Expr<'_>>("x").powf(0.5)), &[0.0]),
        (|m| m.energy((m.variable::<Vec3<'_>>("x").norm() - 1.0).powi(2)), &[0.0; 3]),
    ];
    for (formulas, x) in all {
        let config = Config::new().element("a", formulas).unwrap();
        let error = config.test("a", &[x], &[]).source().unwrap_err();
        let ConfigError::Element { source, .. } = &error else { panic!("{error}") };
        let (ElementError::TestResult { result } | ElementError::TestDerivative { result }) = source else {
            panic!("{error}")
        };
        assert!(["gradient", "hessian"].contains(&result.as_str()), "{error}");
    }
}

#[test]
fn a_test_where_a_norm_is_zero_is_refused() {
    let length = |m: &ElementModel<'_>| {
        let x: Vec2<'_> = m.variable("x");
        m.residual("length", Vector([x[0].hypot(x[1])]));
    };
    let config = Config::new().element("a", length).unwrap();
    let error = config.clone().test("a", &[&[0.0, 0.0]], &[]).source().unwrap_err();
    let ConfigError::Element { source, .. } = &error else { panic!("{error}") };
    assert_eq!(*source, ElementError::TestDerivative { result: "length_jacobian".to_owned() });
    assert!(error.to_string().contains("`length_jacobian`"), "{error}");
    assert!(config.test("a", &[&[0.3, 0.4]], &[]).source().is_ok());
}

/// A spring along the third axis: the first two components of its norm are a norm of zero.
#[test]
fn a_norm_has_derivatives_where_two_components_are_zero() {
    let spring = |m: &ElementModel<'_>| {
        let x: [Vec3<'_>; 2] = m.variable("x");
        m.energy(0.5 * ((x[1] - x[0]).norm() - 0.7).powi(2));
    };
    let config = Config::new().element("a", spring).unwrap();
    for end in [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]] {
        let x = [[0.0; 3], end].concat();
        config.clone().test("a", &[&x], &[]).source().unwrap();
    }
}

#[test]
fn the_curvature_that_a_saddle_lacks_is_missed() {
    let saddle = |m: &ElementModel<'_>| {
        let [x, y] = m.parameters(["x", "y"]);
        let at = m.stationary("c", |c: Vec2<'_>| c[0] * c[1] - x * c[0] - y * c[1]);
        m.value("at", at.unknowns);
    };
    assert_eq!(error_of("test", saddle).0, ElementError::NoCurvature { unknowns: "c".to_owned() });
}

/// What follows a mistake does not hide it, nor end in a panic.
#[test]
fn unknowns_that_change_with_those_sought_are_refused() {
    let (error, _) = error_of("test", |m| {
        let k: Expr<'_> = m.variable("k");
        let at = m.stationary("c", |c: Vector<'_, 1>| {
            let v = m.solve("v", Matrix([[k]]), Vector([c[0]])).unknowns[0];
            0.5 * c[0] * c[0] - c[0] * v
        });
        m.energy(at.unknowns[0].by(k) + at.unknowns[0].powi(2).by(at.unknowns[0]));
    });
    assert!(matches!(error, ElementError::Sought { .. }), "{error:?}");
}

/// Of length zero, and of names that are words of the code around them.
#[test]
fn odd_sizes_and_names_are_taken() {
    let config = Config::new().element("a", |m| {
        let (x, none): (Expr<'_>, Expr<'_>) = (m.variable("x"), m.parameter("None"));
        let _: [Vec3<'_>; 0] = m.parameter("internal");
        let error = m.define("Err", x.exp() * none);
        m.energy(error.powi(2) + x.sin());
        m.residual("forces", Vector::<0>([]));
        // An exponent that is a number in the end.
        let two = m.define("two", none + 2.0);
        m.value("power", x.powf(two - none));
    });
    let text = config.unwrap().source().unwrap();
    assert!(text.contains("let None_v2 = inputs.None;") && text.contains("let Err_v2 = "), "{text}");
}

/// A rule of differentiation that is wrong: interpreter and kernel agree on it, expansions do not know it.
#[test]
fn a_mistake_in_a_derivative_of_the_graph_does_not_reach_automatic_differentiation() {
    let mut element = kernels(tet4);
    let inputs: [&[f64]; 4] = [&numbers(12, 0.3), &numbers(12, 0.9), &[1.2], &[0.8]];
    let interpreted = |element: &ElementKernels| {
        let all = element_results(element.kernels.last().unwrap(), &inputs, &[]);
        all.into_iter().find(|(name, _)| name == "gradient").unwrap().1
    };
    let expanded = |element: &ElementKernels| element_derivatives(element, &inputs, &[])[0].1.clone();
    let right = expanded(&element);
    assert!(difference(&interpreted(&element), &right) < 1e-12);
    let gradient = |kernel: &mut diffuse_contact_codegen::kernel::Kernel<_>| {
        kernel
            .values
            .iter_mut()
            .filter(|value| value.name == "gradient")
            .for_each(|value| value.components.swap(0, 1));
    };
    element.kernels.iter_mut().for_each(gradient);
    assert!(difference(&interpreted(&element), &right) > 1e-2);
    assert_eq!(expanded(&element), right);
}

/// What is used through definitions and sums over the nodes is not among them.
#[test]
fn inputs_that_no_output_depends_on_are_named() {
    let of = |formulas: fn(&ElementModel<'_>)| {
        let element = ElementKernels::new("own", formulas).unwrap();
        element.unused_inputs().into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    assert!(of(spring).is_empty() && of(tet4).is_empty());
    let unused = of(|m| {
        let (x, _): (Vec3<'_>, Vec3<'_>) = (m.variable("x"), m.variable("y"));
        let [k, load, old] = m.parameters(["k", "load", "old"]);
        let (r, _): (Expr<'_>, Expr<'_>) = (m.node_parameter("r"), m.node_parameter("s"));
        let mean = m.define("mean", (k * r).sum());
        m.energy(mean * x[0] + 0.0 * old);
        m.value("level", load);
    });
    assert_eq!(unused, ["y", "old", "s"]);
}

#[test]
fn the_golden_element_is_what_the_generator_emits() {
    let config = Config::new().element("spring", spring);
    let text = config.unwrap().source().unwrap();
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(GOLDEN, &text).unwrap();
    }
    let golden = std::fs::read_to_string(GOLDEN).unwrap_or_default();
    assert!(
        text == golden,
        "the emitted text has changed; refresh the excerpt and review the difference:\n    \
         UPDATE_GOLDEN=1 cargo test -p diffuse-contact-codegen --test all -- golden"
    );
}
