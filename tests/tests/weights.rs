//! Every built-in weight with every basis and frame rule: generated kernels against automatic differentiation, for every
//! number of masters from the basis's size to 24; and the interpolating weight on, next to and through a node.

use diffuse_contact::ad::Ad;
use diffuse_contact::{Backend, Basis, Generated, Mode, Weight};
use diffuse_contact_tests::{
    Case, Quadric, assert_finite_gap, assert_same_coefficients, assert_same_gap, assert_same_surface,
    difference,
};

/// Relative to the largest entry. What is asked for is 1e-10.
const TOLERANCE: f64 = 1e-11;

#[track_caller]
fn every_count(weight: Weight, basis: Basis, co_moving: bool) {
    for n in basis.size()..=24 {
        for seed in [n as u64, 100 + n as u64] {
            // Three or so nodes have an average plane, but hardly one that is well conditioned.
            if co_moving && n < 5 {
                continue;
            }
            let case = Case::random(n, basis, seed).with_weight(weight);
            let case = if co_moving { case.co_moving() } else { case };
            let element = case.element();
            let found = Generated.gap(&element, Mode::Hessian).unwrap();
            assert_same_gap(&case, &found, &Ad.gap(&element, Mode::Hessian).unwrap(), TOLERANCE);
        }
    }
}

#[test]
fn wendland_frozen() {
    every_count(Weight::WendlandC2, Basis::Quadratic, false);
    every_count(Weight::WendlandC2, Basis::Linear, false);
}

#[test]
fn wendland_co_moving() {
    every_count(Weight::WendlandC2, Basis::Quadratic, true);
    every_count(Weight::WendlandC2, Basis::Linear, true);
}

#[test]
fn interpolating_frozen() {
    every_count(Weight::CubicInterpolating, Basis::Quadratic, false);
    every_count(Weight::CubicInterpolating, Basis::Linear, false);
}

#[test]
fn interpolating_co_moving() {
    every_count(Weight::CubicInterpolating, Basis::Quadratic, true);
    every_count(Weight::CubicInterpolating, Basis::Linear, true);
}

#[test]
fn cubic_co_moving() {
    every_count(Weight::Cubic, Basis::Quadratic, true);
    every_count(Weight::Cubic, Basis::Linear, true);
}
