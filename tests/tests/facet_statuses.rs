//! Facets that are none, slaves without a unique foot, and strongly warped quadrilaterals: a named error, or numbers that
//! automatic differentiation confirms.

use diffuse_contact::ad::Ad;
use diffuse_contact::{ElementError, FacetElement, Generated, Mode, Point};
use diffuse_contact_tests::{Random, difference, fixed, turn};
use proptest::prelude::*;

const MODES: [Mode; 3] = [Mode::Value, Mode::Gradient, Mode::Hessian];

/// The code of the error of both backends in all modes.
#[track_caller]
fn code(slave: Point, corners: &[Point]) -> &'static str {
    let element = FacetElement { slave, corners };
    let mut codes: Vec<&str> = MODES
        .iter()
        .flat_map(|&mode| [Generated.facet_gap(&element, mode), Ad.facet_gap(&element, mode)])
        .map(|outcome| outcome.expect_err("no sound facet").code())
        .collect();
    codes.dedup();
    assert_eq!(codes.len(), 1, "{codes:?} {element:?}");
    codes[0]
}

const TRIANGLE: [Point; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
const SQUARE: [Point; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
const SLAVE: Point = [0.3, 0.2, 0.1];

#[test]
fn facets_without_area_are_degenerate() {
    let [a, b, c, d] = SQUARE;
    let middle = [0.5, 0.5, 0.0];
    for corners in [
        vec![a, a, c],
        vec![a, b, b],
        vec![a, a, a],
        vec![a, middle, c],
        vec![a, b, [7.0, 0.0, 0.0]],
        vec![a, a, a, a],
        vec![a, b, b, d],
        vec![a, a, c, d],
        vec![a, b, a, b],
        vec![a, b, c, c],
        // A corner of 180 degrees.
        vec![a, b, middle, d],
        // All on a line.
        vec![a, b, [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]],
    ] {
        for size in [1.0, 1e-60, 1e60] {
            for seed in 0..4 {
                let mut random = Random::new(seed);
                let (q, centre) = (random.rotation(), random.vector(3.0));
                let place = |x: Point| {
                    let turned = turn(&q, x);
                    std::array::from_fn(|k| size * (turned[k] + centre[k]))
                };
                let corners: Vec<Point> = corners.iter().map(|x| place(*x)).collect();
                assert_eq!(code(place(SLAVE), &corners), "degenerate-facet", "{corners:?}");
            }
        }
    }
}

#[test]
fn folded_and_concave_quadrilaterals_are_degenerate() {
    let [a, b, c, d] = SQUARE;
    for corners in [
        // Bow-ties, symmetric and not.
        [a, b, d, c],
        [a, c, b, d],
        [a, [1.2, 0.1, 0.05], [0.1, 1.1, 0.0], [0.8, 0.9, 0.1]],
        // An inward corner.
        [a, b, [0.3, 0.3, 0.0], d],
        [[0.7, 0.6, 0.1], b, c, d],
    ] {
        assert_eq!(code(SLAVE, &corners), "degenerate-facet", "{corners:?}");
    }
}

#[test]
fn what_is_not_a_number_or_not_a_facet_is_named() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for axis in 0..3 {
            let mut slave = SLAVE;
            slave[axis] = bad;
            assert_eq!(code(slave, &TRIANGLE), "non-finite-input");
            assert_eq!(code(slave, &SQUARE), "non-finite-input");
            for corner in 0..4 {
                let mut corners = SQUARE;
                corners[corner][axis] = bad;
                let element = FacetElement { slave: SLAVE, corners: &corners };
                let error = Generated.facet_gap(&element, Mode::Hessian).unwrap_err();
                assert_eq!(error, ElementError::NonFiniteInput { what: "corner", index: corner });
                assert_eq!(code(SLAVE, &corners), "non-finite-input");
            }
        }
    }
    for count in [0, 1, 2, 5, 9] {
        let corners = vec![[0.0; 3]; count];
        assert_eq!(code(SLAVE, &corners), "facet-corners");
        let error = Generated.facet_point(&FacetElement { slave: SLAVE, corners: &corners }).unwrap_err();
        assert_eq!(error, ElementError::FacetCorners { found: count });
    }
}

#[test]
fn results_beyond_the_range_of_numbers_are_named() {
    let far = |x: Point| x.map(|x| 1e308 * (x - 0.5) * 3.0);
    for (slave, corners) in
        [(far(SLAVE), SQUARE.map(far)), ([0.0, 0.0, 1e308], SQUARE.map(|x| x.map(|x| 1e-300 * x)))]
    {
        let element = FacetElement { slave, corners: &corners };
        for mode in MODES {
            let error = Generated.facet_gap(&element, mode).unwrap_err();
            assert!(["overflow", "foot-diverged"].contains(&error.code()), "{error}");
            assert!(Ad.facet_gap(&element, mode).is_err());
        }
    }
}

/// z = ½ w (x² − y²) has centres of curvature at ±1/w over the middle.
fn saddle(w: f64) -> [Point; 4] {
    // Bilinear along the diagonals.
    [[-1.0, 0.0, 0.5 * w], [0.0, -1.0, -0.5 * w], [1.0, 0.0, 0.5 * w], [0.0, 1.0, -0.5 * w]]
}

#[test]
fn centres_of_curvature_are_named() {
    for w in [0.5, 1.0, 2.0] {
        for side in [1.0, -1.0] {
            for height in [1.0, 1.5, 4.0] {
                let slave = [0.0, 0.0, side * height / w];
                assert_eq!(code(slave, &saddle(w)), "centre-of-curvature", "{w} {height}");
            }
            let element = FacetElement { slave: [0.0, 0.0, side * 0.75 / w], corners: &saddle(w) };
            assert_eq!(Generated.facet_point(&element).unwrap().natural, [0.0; 2]);
        }
    }
}

/// An error with a name and numbers in it.
fn is_named(error: &ElementError) -> bool {
    match error {
        ElementError::DegenerateFacet { area } => area.is_finite(),
        ElementError::CentreOfCurvature { determinant } => determinant.is_finite(),
        ElementError::FootDiverged { residual, iterations } => !residual.is_nan() && *iterations > 0,
        _ => false,
    }
}

proptest! {
    #![proptest_config(fixed(3000))]

    /// Warped by up to three times the edges, the slave up to three edges away: up to several feet, folds, centres of
    /// curvature.
    #[test]
    fn a_warped_quadrilateral_has_a_confirmed_gap_or_a_named_error(
        seed: u64,
        warp in 0.0..3.0f64,
        reach in 0.5..3.0f64,
    ) {
        let mut random = Random::new(seed);
        let q = random.rotation();
        let corners: Vec<Point> = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]
            .into_iter()
            .map(|[x, y]| [x + 0.3 * random.signed(), y + 0.3 * random.signed(), warp * random.signed()])
            .map(|x| turn(&q, x))
            .collect();
        let element = FacetElement { slave: random.vector(reach), corners: &corners };
        match Generated.facet_gap(&element, Mode::Hessian) {
            Err(error) => prop_assert!(is_named(&error), "{error:?}"),
            Ok(found) => {
                // Next to a bound the backends may differ, and near a centre of curvature digits are lost.
                let natural = Generated.facet_point(&element).unwrap().natural;
                let Ok(expected) = Ad.facet_gap_near(&element, natural, Mode::Hessian) else {
                    let values = figures(&element);
                    prop_assert!(values.iter().any(|x| *x < 1e-6), "{values:?} {element:?}");
                    return Ok(());
                };
                let lost = figures(&element).into_iter().fold(1.0, f64::min).powi(3);
                prop_assert!((found.gap - expected.gap).abs() <= 1e-13 / lost, "{} {}", found.gap, expected.gap);
                prop_assert!(difference(&found.gradient, &expected.gradient) <= 1e-12 / lost);
                prop_assert!(difference(found.hessian.packed(), expected.hessian.packed()) <= 1e-12 / lost);
            }
        }
    }

    /// Within the facet and at a moderate gap nothing stands in the way.
    #[test]
    fn a_slave_near_a_sound_facet_always_has_a_gap(seed: u64) {
        let mut random = Random::new(seed);
        let q = random.rotation();
        let corners: Vec<Point> = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]
            .into_iter()
            .map(|[x, y]| [x + 0.15 * random.signed(), y + 0.15 * random.signed(), 0.3 * random.signed()])
            .map(|x| turn(&q, x))
            .collect();
        let local = [0.6 * random.signed(), 0.6 * random.signed(), 0.5 * random.signed()];
        let element = FacetElement { slave: turn(&q, local), corners: &corners };
        let outcome = Generated.facet_gap(&element, Mode::Hessian);
        prop_assert!(outcome.is_ok(), "{outcome:?} {element:?}");
    }
}

/// Corner area, foot area and Jacobian determinant of an element's kernel.
fn figures(element: &FacetElement<'_>) -> [f64; 3] {
    use diffuse_contact_kernels::gap_over_quadrilateral::{Inputs, evaluate_to};

    let corners: [Point; 4] = element.corners.try_into().expect("a quadrilateral");
    let values = evaluate_to(Mode::Value, &Inputs { slave: element.slave, corners }, &mut [], &mut []);
    [values.corner_area, values.foot_area, values.jacobian_determinant]
}
