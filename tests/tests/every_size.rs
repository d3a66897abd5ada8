//! Every number of master nodes up to that of the largest pairings, and some beyond: generated kernels against automatic
//! differentiation, and the lower modes against the Hessian mode.

use diffuse_contact::ad::Ad;
use diffuse_contact::{Backend, Basis, Generated, Mode, SymmetricMatrix};
use diffuse_contact_tests::{
    Case, assert_same_coefficients, assert_same_gap, assert_same_surface, difference,
};

/// Relative to the largest entry. What is asked for is 1e-11; g, N and M differ by no more than 1e-14.
const TOLERANCE: f64 = 1e-13;
/// The same for the surface, also where it extrapolates, and for each single coefficient.
const TOLERANCE_OF_FIT: f64 = 1e-12;
/// Numbers of nodes beyond.
const BEYOND: [usize; 3] = [25, 40, 70];

#[track_caller]
fn gap_matches(n: usize, basis: Basis, seed: u64) {
    let case = Case::random(n, basis, seed);
    let element = case.element();
    let (found, expected) = (Generated.gap(&element, Mode::Hessian), Ad.gap(&element, Mode::Hessian));
    assert_same_gap(&case, &found.unwrap(), &expected.unwrap(), TOLERANCE);
}

#[test]
fn gap_with_the_quadratic_basis() {
    for n in 6..=24 {
        gap_matches(n, Basis::Quadratic, 1000 + n as u64);
        gap_matches(n, Basis::Quadratic, 2000 + n as u64);
    }
}

#[test]
fn gap_with_the_linear_basis() {
    for n in 3..=24 {
        gap_matches(n, Basis::Linear, 3000 + n as u64);
        gap_matches(n, Basis::Linear, 4000 + n as u64);
    }
}

#[test]
fn gap_of_more_nodes() {
    for n in BEYOND {
        gap_matches(n, Basis::Quadratic, 5000 + n as u64);
        gap_matches(n, Basis::Linear, 6000 + n as u64);
    }
}

#[test]
fn surface_and_coefficients() {
    let quadratic = (6..=24).step_by(3).chain([25]).map(|n| (Basis::Quadratic, n));
    let linear = (3..=24).step_by(3).chain([25]).map(|n| (Basis::Linear, n));
    for (basis, n) in quadratic.chain(linear) {
        let case = Case::random(n, basis, 7000 + n as u64);
        let element = case.element();
        let (found, expected) =
            (Generated.coefficients(&element, Mode::Hessian), Ad.coefficients(&element, Mode::Hessian));
        assert_same_coefficients(&case, &found.unwrap(), &expected.unwrap(), TOLERANCE_OF_FIT);
        for point in [[0.0, 0.0], [0.3, -0.2], [-0.9, 0.8]] {
            let (found, expected) = (
                Generated.surface(&element, point, Mode::Hessian),
                Ad.surface(&element, point, Mode::Hessian),
            );
            assert_same_surface(&case, &found.unwrap(), &expected.unwrap(), TOLERANCE_OF_FIT);
        }
    }
}

/// Kernels of different modes are different programs: the same numbers to rounding.
#[test]
fn lower_modes_give_the_values_of_the_hessian_mode() {
    const ROUNDING: f64 = 3e-14;
    let quadratic = (6..=24).chain(BEYOND).map(|n| (Basis::Quadratic, n));
    let linear = (3..=24).chain(BEYOND).map(|n| (Basis::Linear, n));
    for (basis, n) in quadratic.chain(linear) {
        let case = Case::random(n, basis, 8000 + n as u64);
        let element = case.element();
        let [value, gradient, hessian] =
            [Mode::Value, Mode::Gradient, Mode::Hessian].map(|mode| Generated.gap(&element, mode).unwrap());
        for lower in [&value, &gradient] {
            assert!((lower.gap - hessian.gap).abs() <= ROUNDING);
            assert!(difference(&lower.foot, &hessian.foot) <= ROUNDING);
            assert!(difference(&lower.normal, &hessian.normal) <= ROUNDING);
            assert!(difference(&lower.coefficients, &hessian.coefficients) <= ROUNDING);
            assert_eq!(lower.hessian, SymmetricMatrix::default());
        }
        assert!(value.gradient.is_empty());
        assert!(difference(&gradient.gradient, &hessian.gradient) <= ROUNDING);

        let [value, gradient, hessian] = [Mode::Value, Mode::Gradient, Mode::Hessian]
            .map(|mode| Generated.coefficients(&element, mode).unwrap());
        assert!(value.gradients.is_empty() && value.hessians.is_empty() && gradient.hessians.is_empty());
        assert!(difference(&value.values, &hessian.values) <= ROUNDING);
        assert!(difference(&gradient.values, &hessian.values) <= ROUNDING);
        assert!(difference(&gradient.gradients.concat(), &hessian.gradients.concat()) <= ROUNDING);

        let [value, gradient, hessian] = [Mode::Value, Mode::Gradient, Mode::Hessian]
            .map(|mode| Generated.surface(&element, [0.2, 0.3], mode).unwrap());
        assert!(value.gradient.is_empty() && value.slope_gradients.iter().all(Vec::is_empty));
        assert_eq!(gradient.hessian, SymmetricMatrix::default());
        for lower in [&value, &gradient] {
            assert!((lower.value - hessian.value).abs() <= ROUNDING);
            assert!(difference(&lower.slopes, &hessian.slopes) <= ROUNDING);
            assert!(difference(&lower.curvatures, &hessian.curvatures) <= ROUNDING);
        }
        assert!(difference(&gradient.gradient, &hessian.gradient) <= ROUNDING);
        let slopes = [&gradient, &hessian].map(|surface| surface.slope_gradients.concat());
        assert!(difference(&slopes[0], &slopes[1]) <= ROUNDING);
    }
}
