//! Small and large lengths, any direction, far from the origin: the accuracy is that of the rounded input, which
//! the generated kernels and automatic differentiation both see.

use diffuse_contact::ad::Ad;
use diffuse_contact::{Backend, Basis, Generated, Mode};
use diffuse_contact_tests::{
    Case, Random, add, assert_same_coefficients, assert_same_gap, assert_same_surface, difference,
};

/// Relative to the largest entry. What is asked for is 1e-11; no block differs by more than 4e-14.
const TOLERANCE: f64 = 2e-13;

fn random_cases() -> impl Iterator<Item = Case> {
    [
        (Basis::Quadratic, 6),
        (Basis::Quadratic, 9),
        (Basis::Quadratic, 13),
        (Basis::Linear, 3),
        (Basis::Linear, 8),
    ]
    .into_iter()
    .zip(0..)
    .map(|((basis, n), seed)| Case::random(n, basis, 100 + seed))
}

#[track_caller]
fn compare(case: &Case) {
    let element = case.element();
    let (found, expected) = (Generated.gap(&element, Mode::Hessian), Ad.gap(&element, Mode::Hessian));
    assert_same_gap(case, &found.unwrap(), &expected.unwrap(), TOLERANCE);
    let (found, expected) =
        (Generated.coefficients(&element, Mode::Hessian), Ad.coefficients(&element, Mode::Hessian));
    assert_same_coefficients(case, &found.unwrap(), &expected.unwrap(), TOLERANCE);
    let point = [0.2 * case.support_radius, -0.3 * case.support_radius];
    let (found, expected) =
        (Generated.surface(&element, point, Mode::Hessian), Ad.surface(&element, point, Mode::Hessian));
    assert_same_surface(case, &found.unwrap(), &expected.unwrap(), TOLERANCE);
}

#[test]
fn any_unit_of_length() {
    for case in random_cases() {
        for factor in [1e-60, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e60] {
            compare(&case.scaled(factor));
        }
    }
}

#[test]
fn far_from_the_origin() {
    let mut random = Random::new(5);
    for case in random_cases() {
        for size in [1e-6, 1e-3, 1.0, 1e3, 1e6] {
            for distance in [1e3, 1e6, 1e9] {
                let shift = random.vector(distance * size);
                compare(&case.scaled(size).mapped(|x| add(x, shift)));
            }
        }
    }
}

#[test]
fn rotated_and_far_from_the_origin() {
    let mut random = Random::new(6);
    for case in random_cases() {
        for size in [1e-3, 1e3] {
            let q = random.rotation();
            let shift = random.vector(1e6 * size);
            compare(&case.scaled(size).turned(&q).mapped(|x| add(x, shift)));
        }
    }
}

/// What the rounding of the input costs: a shift by 1e6 sizes leaves ten digits of every offset.
#[test]
fn a_shift_changes_no_more_than_it_rounds() {
    for case in random_cases() {
        for size in [1e-3, 1e3] {
            let near = case.scaled(size);
            let far = near.mapped(|x| add(x, [1e6 * size, -7e5 * size, 3e5 * size]));
            let [near, far] = [near, far].map(|case| Generated.gap(&case.element(), Mode::Hessian).unwrap());
            assert!((near.gap - far.gap).abs() <= 1e-9 * size);
            assert!(difference(&far.gradient, &near.gradient) <= 1e-8);
            assert!(difference(far.hessian.packed(), near.hessian.packed()) <= 1e-8);
        }
    }
}
