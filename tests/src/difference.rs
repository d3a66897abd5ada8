//! The measure of a difference: relative to the largest entry of the block, or to the support radius for
//! lengths. A NaN in either makes the difference NaN, which no bound accepts.

use diffuse_contact::{Coefficients, Gap, Surface};

use crate::Case;
use crate::geometry::{add, scale};

/// The larger of two sizes; NaN if one is.
#[must_use]
pub fn worse(x: f64, y: f64) -> f64 {
    if x.is_nan() || x > y { x } else { y }
}

/// Largest size of an entry.
#[must_use]
pub fn largest(values: &[f64]) -> f64 {
    values.iter().map(|x| x.abs()).fold(0.0, worse)
}

/// Largest difference over the largest entry of `expected`; 0 if both are zero.
///
/// # Panics
/// If the lengths differ.
#[must_use]
pub fn difference(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let difference = found.iter().zip(expected).map(|(x, y)| (x - y).abs()).fold(0.0, worse);
    if difference == 0.0 { 0.0 } else { difference / largest(expected) }
}

/// g and foot relative to R, ν, α (dimensionless with R), N and M relative to their largest entries.
///
/// # Panics
/// If one of them exceeds `tolerance`. The foot is a sum with the slave's position, whose rounding is allowed
/// for.
#[track_caller]
pub fn assert_same_gap(case: &Case, found: &Gap, expected: &Gap, tolerance: f64) {
    let radius = case.support_radius;
    let offset = |foot| add(foot, scale(-1.0, case.slave));
    let foot = largest(&add(offset(found.foot), scale(-1.0, offset(expected.foot)))) / radius;
    let rounding = 2.0 * f64::EPSILON * largest(&case.slave) / radius;
    check(&[
        ("g", (found.gap - expected.gap).abs() / radius, tolerance),
        ("foot", foot, tolerance + rounding),
        ("normal", difference(&found.normal, &expected.normal), tolerance),
        (
            "coefficients",
            difference(
                &without_units(&found.coefficients, case),
                &without_units(&expected.coefficients, case),
            ),
            tolerance,
        ),
        ("N", difference(&found.gradient, &expected.gradient), tolerance),
        ("M", difference(found.hessian.packed(), expected.hessian.packed()), tolerance),
    ]);
}

/// α over R, and each coefficient's derivatives relative to their own largest entry.
///
/// # Panics
/// If one of them exceeds `tolerance`.
#[track_caller]
pub fn assert_same_coefficients(case: &Case, found: &Coefficients, expected: &Coefficients, tolerance: f64) {
    let values = |x: &Coefficients| without_units(&x.values, case);
    let mut blocks = vec![("coefficients", difference(&values(found), &values(expected)), tolerance)];
    assert_eq!(found.gradients.len(), expected.gradients.len());
    for (x, y) in found.gradients.iter().zip(&expected.gradients) {
        blocks.push(("gradient of a coefficient", difference(x, y), tolerance));
    }
    assert_eq!(found.hessians.len(), expected.hessians.len());
    for (x, y) in found.hessians.iter().zip(&expected.hessians) {
        blocks.push(("Hessian of a coefficient", difference(x.packed(), y.packed()), tolerance));
    }
    check(&blocks);
}

/// f, slopes and curvatures over powers of R, ∇f, T_l and H_f relative to their largest entries.
///
/// # Panics
/// If one of them exceeds `tolerance`.
#[track_caller]
pub fn assert_same_surface(case: &Case, found: &Surface, expected: &Surface, tolerance: f64) {
    let radius = case.support_radius;
    let values = |x: &Surface| {
        let [f_11, f_12, f_22] = x.curvatures.map(|f| f * radius);
        [x.value / radius, x.slopes[0], x.slopes[1], f_11, f_12, f_22]
    };
    let slopes = |x: &Surface| x.slope_gradients.concat();
    check(&[
        ("f, slopes, curvatures", difference(&values(found), &values(expected)), tolerance),
        ("gradient of f", difference(&found.gradient, &expected.gradient), tolerance),
        ("gradients of slopes", difference(&slopes(found), &slopes(expected)), tolerance),
        ("Hessian of f", difference(found.hessian.packed(), expected.hessian.packed()), tolerance),
    ]);
}

/// Whether all numbers of a result are finite.
///
/// # Panics
/// If one is not.
#[track_caller]
pub fn assert_finite_gap(gap: &Gap) {
    let blocks: [&[f64]; 6] =
        [&[gap.gap], &gap.foot, &gap.normal, &gap.coefficients, &gap.gradient, gap.hessian.packed()];
    for (name, block) in ["g", "foot", "normal", "coefficients", "N", "M"].into_iter().zip(blocks) {
        assert!(block.iter().all(|x| x.is_finite()), "{name} holds what is no finite number");
    }
}

/// α with lengths over R.
fn without_units(coefficients: &[f64], case: &Case) -> Vec<f64> {
    let degrees = case.basis.monomials().iter().map(|&(i, j)| i32::from(i + j));
    coefficients.iter().zip(degrees).map(|(alpha, d)| alpha * case.support_radius.powi(d - 1)).collect()
}

#[track_caller]
fn check(blocks: &[(&str, f64, f64)]) {
    for (name, difference, tolerance) in blocks {
        assert!(difference <= tolerance, "{name} differs by {difference:e}, bound {tolerance:e}");
    }
}
