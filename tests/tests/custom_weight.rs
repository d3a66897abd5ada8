//! Kernels that `build.rs` generated from formulas of its own, against automatic differentiation with the same
//! text; and what the build API says about formulas and ranges it does not take.

use diffuse_contact::ad::Ad;
use diffuse_contact::{
    Backend, Basis, BatchScratch, Element, GapSlot, Generated, GeneratedWith, Mode, Weight,
};
use diffuse_contact_codegen::formula::FormulaError;
use diffuse_contact_codegen::model::WeightError;
use diffuse_contact_codegen::{Config, ConfigError};
use diffuse_contact_kernels::support::{Isa, KernelSet};
use diffuse_contact_tests::weights::{matern, spline, wendland};
use diffuse_contact_tests::{
    Case, assert_same_coefficients, assert_same_gap, assert_same_surface, difference, largest, output_sizes,
};

/// Relative to the largest entry; what is asked for.
const TOLERANCE: f64 = 1e-11;
/// Of weights that leave even six nodes a well-conditioned fit.
const TIGHT_TOLERANCE: f64 = 1e-12;
/// Numbers of nodes of a quadratic fit, and below of a linear one: the fewest, and more.
const QUADRATIC: [usize; 5] = [6, 7, 8, 12, 25];
const LINEAR: [usize; 5] = [3, 4, 5, 9, 25];

#[track_caller]
fn matches_automatic_differentiation<K: KernelSet + Sync>(tolerance: f64) {
    let (generated, ad) = (GeneratedWith::<K>::new(), Ad::with_weight_formula(K::WEIGHT).unwrap());
    let sizes =
        QUADRATIC.map(|n| (Basis::Quadratic, n)).into_iter().chain(LINEAR.map(|n| (Basis::Linear, n)));
    for ((basis, n), seed) in sizes.zip(0..) {
        let case = Case::random(n, basis, 300 + seed);
        let element = case.element();
        let (found, expected) = (generated.gap(&element, Mode::Hessian), ad.gap(&element, Mode::Hessian));
        assert_same_gap(&case, &found.unwrap(), &expected.unwrap(), tolerance);
        let (found, expected) = (
            generated.surface(&element, [0.2, 0.1], Mode::Hessian),
            ad.surface(&element, [0.2, 0.1], Mode::Hessian),
        );
        assert_same_surface(&case, &found.unwrap(), &expected.unwrap(), tolerance);
        if n <= 12 {
            let (found, expected) =
                (generated.coefficients(&element, Mode::Hessian), ad.coefficients(&element, Mode::Hessian));
            assert_same_coefficients(&case, &found.unwrap(), &expected.unwrap(), tolerance);
        }
    }
}

/// All with the one weight, whatever an element says; each as by itself.
#[test]
fn a_batch_of_elements_with_a_weight_of_ones_own() {
    let backend = GeneratedWith::<matern::Matern>::new();
    let sizes = [(Basis::Quadratic, 9), (Basis::Linear, 7), (Basis::Quadratic, 9), (Basis::Quadratic, 7)];
    let mut cases: Vec<Case> = (0..12)
        .map(|k| {
            let (basis, n) = sizes[k % sizes.len()];
            let case = Case::random(n, basis, 40 + k as u64).with_weight(Weight::ALL[k % Weight::ALL.len()]);
            // A plane with weighted nodes would have to have the weight of the backend.
            if k % 3 == 0 { Case { radii: Vec::new(), ..case }.co_moving() } else { case }
        })
        .collect();
    cases[5].support_radius = -1.0;
    let elements: Vec<Element<'_>> = cases.iter().map(Case::element).collect();
    let mut room: Vec<[Vec<f64>; 2]> =
        cases.iter().map(|case| output_sizes(Mode::Hessian, case).map(|size| vec![0.0; size])).collect();
    let mut scratch = BatchScratch::default();
    for _ in 0..2 {
        let slots = room.iter_mut().map(|[gradient, hessian]| GapSlot { gradient, hessian });
        let found = backend.gap_batch(&elements, Mode::Hessian, slots, &mut scratch);
        assert_eq!(found.len(), cases.len());
        for (k, found) in found.into_iter().enumerate() {
            let Ok(expected) = backend.gap(&elements[k], Mode::Hessian) else {
                assert!(k == 5 && found.is_err(), "{k}");
                continue;
            };
            let (found, [gradient, hessian]) = (found.unwrap(), &room[k]);
            assert!((found.gap - expected.gap).abs() < 1e-12, "{k}");
            assert!(difference(gradient, &expected.gradient) < TOLERANCE, "{k}");
            let expected = expected.hessian.packed();
            assert!(difference(hessian, expected) < TOLERANCE, "{k}");
        }
    }
}

/// Kernels made in a crate that is not optimised, as this one by default, are compiled without vectors. How the crate `diffuse-contact-kernels` is compiled makes no difference.
#[test]
fn unoptimised_kernels_are_run_number_by_number() {
    let is_optimised = !["0", "1"].contains(&env!("KERNELS_OPT_LEVEL"));
    assert_eq!(wendland::Wendland::OPTIMISED, is_optimised);
    assert_eq!(matern::Matern::OPTIMISED, is_optimised);
    let isa = if is_optimised { Isa::best() } else { Isa::SCALAR };
    assert_eq!(wendland::Wendland::best_isa(), isa);
}

#[test]
fn wendland() {
    matches_automatic_differentiation::<wendland::Wendland>(TOLERANCE);
}

#[test]
fn matern() {
    matches_automatic_differentiation::<matern::Matern>(TIGHT_TOLERANCE);
}

#[test]
fn spline() {
    matches_automatic_differentiation::<spline::Spline>(TIGHT_TOLERANCE);
}

/// The tests above could pass with three copies of one weight.
#[test]
fn weights_make_a_difference() {
    let case = Case::random(9, Basis::Quadratic, 1);
    let hessian = |backend: &dyn Backend| {
        backend.gap(&case.element(), Mode::Hessian).unwrap().hessian.packed().to_vec()
    };
    let all = [
        hessian(&Generated),
        hessian(&GeneratedWith::<wendland::Wendland>::new()),
        hessian(&GeneratedWith::<matern::Matern>::new()),
        hessian(&GeneratedWith::<spline::Spline>::new()),
    ];
    for (i, x) in all.iter().enumerate() {
        for y in &all[..i] {
            assert!(difference(x, y) > 1e-4);
        }
    }
}

/// Where the branches of the spline meet it is twice differentiable: N and M are continuous.
#[test]
fn the_spline_has_no_jump_where_its_branches_meet() {
    let generated = GeneratedWith::<spline::Spline>::new();
    let at = |r: f64| {
        let case = Case::random(8, Basis::Quadratic, 3);
        let mut nodes = vec![[0.0, 0.0, 0.3]];
        nodes.extend(case.masters.iter().map(|x| case.local_offset(*x)));
        nodes[5] = [0.6 * r * case.support_radius, 0.8 * r * case.support_radius, 0.1];
        generated_gap(
            &generated,
            &Case::axis_aligned(&nodes, case.support_radius, Basis::Quadratic).element(),
        )
    };
    let [below, meeting, above] = [0.5 - 1e-9, 0.5, 0.5 + 1e-9].map(at);
    for side in [below, above] {
        assert!(difference(&side.0, &meeting.0) < 1e-7);
        assert!(difference(&side.1, &meeting.1) < 1e-7);
    }
}

fn generated_gap(backend: &impl Backend, element: &Element<'_>) -> (Vec<f64>, Vec<f64>) {
    let gap = backend.gap(element, Mode::Hessian).unwrap();
    assert!(largest(gap.hessian.packed()).is_finite());
    (gap.gradient, gap.hessian.packed().to_vec())
}

fn weight_error(formula: &str) -> WeightError {
    match Config::new().weight("test", formula) {
        Err(ConfigError::Weight(error)) => error,
        other => panic!("{formula}: {other:?}"),
    }
}

#[test]
fn an_unreadable_formula_is_an_error_at_its_character() {
    for (formula, column, says) in [
        ("(1 - r)^2 * (1 + 2*q)", 19, "`q` is unknown"),
        ("(1 - r)^2.5", 8, "integer"),
        ("(1 - r)^", 7, ""),
        ("(1 - r)^2 (1 + 2*r)", 10, "operator"),
        ("1 - r^2 + $", 10, ""),
        ("log(r)", 0, "`log` is unknown"),
        ("(1 - r)^99", 8, "-64 and 64"),
        ("if r { 1 } else { 0 }", 5, "comparison"),
        ("1 -", 3, ""),
        ("", 0, "empty"),
    ] {
        let WeightError::Formula(error) = weight_error(formula) else { panic!("{formula}") };
        let FormulaError { formula: shown, message, column: found, .. } = &error;
        assert_eq!(shown, formula);
        assert_eq!(*found, column, "{formula}: {error}");
        assert!(message.contains(says), "{message}");
        // The sentence counts from one, and a mark stands under the character.
        let text = error.to_string();
        assert!(text.contains(&format!("character {}", column + 1)), "{text}");
        let mark = text.lines().last().unwrap();
        assert_eq!(mark.find('^'), Some(4 + column), "{text}");
    }
}

#[test]
fn a_formula_that_is_no_weight_is_an_error_with_the_reason() {
    assert!(matches!(weight_error("1 - r"), WeightError::Kink { slope, .. } if slope == -1.0));
    assert!(
        matches!(weight_error("exp(-r)"), WeightError::Kink { slope, .. } if (slope + 1.0).abs() < 1e-15)
    );
    assert!(matches!(weight_error("1/r"), WeightError::NotSmooth { order: 0, .. }));
    assert!(matches!(weight_error("1 - sqrt(r)"), WeightError::NotSmooth { .. }));
    assert!(matches!(weight_error("1 - 4*r^2"), WeightError::NotPositive { r, .. } if r == 0.5));
    assert!(matches!(weight_error("r^2"), WeightError::NotPositive { r, .. } if r == 0.0));
    assert!(matches!(
        weight_error("exp(1000 + r^2)"),
        WeightError::NotPositive { .. } | WeightError::NotSmooth { .. }
    ));
}

#[test]
fn names_are_checked() {
    for name in ["", "Cubic", "my weight", "9th", "r-2", "größe"] {
        let error = Config::new().weight(name, "(1 - r^2)^2").unwrap_err();
        assert!(matches!(error, ConfigError::Weight(WeightError::Name { .. })), "{name}: {error}");
        assert!(error.to_string().contains(name));
    }
    let twice = Config::new().cubic().weight("cubic", "(1 - r^2)^2").unwrap();
    let error = twice.source().unwrap_err();
    assert!(matches!(&error, ConfigError::DuplicateWeight { name } if name == "cubic"), "{error}");
}

/// A keyword passes for a name in snake case, but no module can have it.
#[test]
fn a_keyword_names_no_weight() {
    for name in ["fn", "mod", "type", "self", "super", "crate"] {
        assert!(Config::new().weight(name, "(1 - r^2)^2").is_err(), "{name}");
    }
}

#[test]
fn paths_are_checked() {
    let error = Config::new().support("not a path").source().unwrap_err();
    assert!(matches!(&error, ConfigError::SupportPath { path } if path == "not a path"), "{error}");
    let folder = std::env::temp_dir().join("diffuse-contact-tests").join("no such folder");
    let error = Config::new().output_folder(&folder).compile().unwrap_err();
    let ConfigError::Write { path, .. } = &error else { panic!("{error}") };
    assert!(path.starts_with(&folder) && error.to_string().contains("no such folder"));
}
