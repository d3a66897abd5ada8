//! What a host gets at the foot: φ, ∂x^d/∂x and ∂ν/∂x, against automatic differentiation and against what the theory says of them.

use diffuse_contact::ad::Ad;
use diffuse_contact::{
    Backend, Basis, BatchScratch, ContactPoint, FootDerivatives, FootSlot, GapSlot, Generated, Mode, Weight,
};
use diffuse_contact_kernels::support::FrameRule;
use diffuse_contact_tests::{Case, GAP_KERNELS, Random, difference, facet_cases, largest};
use proptest::prelude::*;

use crate::lanes::{BASES, FRAMES, sound};

/// Relative to the largest entry, against another implementation.
const TOLERANCE: f64 = 1e-12;
/// Sums that are known, relative to the largest entry.
const ROUNDING: f64 = 1e-13;

/// Well-conditioned elements of all built-in weights, bases and frames.
fn all(n: usize) -> impl Iterator<Item = (Case, FrameRule)> {
    let weights = [Weight::Cubic, Weight::CubicInterpolating, Weight::WendlandC2];
    let sets = GAP_KERNELS.into_iter().zip(weights);
    sets.flat_map(move |(set, weight)| {
        let kernels =
            BASES.into_iter().flat_map(|basis: Basis| FRAMES.map(|frame| (basis, frame, Mode::Hessian)));
        kernels.map(move |kernel| (sound(&set, kernel, n, 700).with_weight(weight), kernel.1))
    })
}

fn assert_close(found: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let worst = difference(found, expected);
    assert!(worst <= tolerance, "{what}: {worst:e}");
}

fn assert_same(found: &FootDerivatives, expected: &FootDerivatives, what: &str) {
    assert_close(&found.weights, &expected.weights, TOLERANCE, &format!("φ, {what}"));
    assert_close(&found.foot, &expected.foot, TOLERANCE, &format!("∂x^d/∂x, {what}"));
    assert_close(&found.normal, &expected.normal, TOLERANCE, &format!("∂ν/∂x, {what}"));
    assert_close(&found.point.normal, &expected.point.normal, TOLERANCE, &format!("ν, {what}"));
}

#[test]
fn derivatives_at_the_foot_are_those_of_automatic_differentiation() {
    for n in [8, 13] {
        for (case, frame) in all(n) {
            let [found, expected] =
                [&Generated as &dyn Backend, &Ad].map(|b| b.foot_derivatives(&case.element()).unwrap());
            assert_same(&found, &expected, &format!("{:?} {:?} {frame:?} {n}", case.weight, case.basis));
        }
    }
}

/// Σ φ = 1 and x^d = Σ φ x; ν stays a unit vector; a rigid motion moves the foot and turns the normal, where the frame moves.
#[test]
fn weights_and_derivatives_are_what_rigid_motions_say() {
    for (case, frame) in all(11) {
        let at_foot = Generated.foot_derivatives(&case.element()).unwrap();
        let FootDerivatives { point: ContactPoint { foot, normal, .. }, weights, .. } = &at_foot;
        let what = format!("{:?} {:?} {frame:?}", case.weight, case.basis);
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < ROUNDING * largest(weights).max(1.0), "{what}");
        let combined = |axis: usize| weights.iter().zip(&case.masters).map(|(w, x)| w * x[axis]).sum::<f64>();
        assert_close(&[0, 1, 2].map(combined), foot, TOLERANCE, &what);

        let freedoms = 3 * (case.masters.len() + 1);
        let nodes: Vec<[f64; 3]> = std::iter::once(case.slave).chain(case.masters.iter().copied()).collect();
        let axis = Random::new(7).vector(1.0);
        let turned = |[x, y, z]: [f64; 3]| {
            let [a, b, c] = axis;
            [b * z - c * y, c * x - a * z, a * y - b * x]
        };
        let rotation: Vec<f64> = nodes.iter().flat_map(|&x| turned(x)).collect();
        let along = |rows: &[f64], v: &[f64]| -> Vec<f64> {
            rows.chunks(freedoms).map(|row| row.iter().zip(v).map(|(x, v)| x * v).sum()).collect()
        };
        let translation: Vec<f64> = axis.iter().copied().cycle().take(freedoms).collect();
        let scale = largest(&at_foot.normal) * largest(&rotation);
        assert_close(&along(&at_foot.foot, &translation), &axis, TOLERANCE, &what);
        assert!(largest(&along(&at_foot.normal, &translation)) <= ROUNDING * scale, "{what}");
        let unit: Vec<f64> = (0..freedoms)
            .map(|k| (0..3).map(|row| normal[row] * at_foot.normal[row * freedoms + k]).sum())
            .collect();
        assert!(largest(&unit) <= TOLERANCE * largest(&at_foot.normal), "{what}");
        if frame != FrameRule::Held {
            assert_close(&along(&at_foot.normal, &rotation), &turned(*normal), 10.0 * TOLERANCE, &what);
            assert_close(&along(&at_foot.foot, &rotation), &turned(*foot), 10.0 * TOLERANCE, &what);
        }
    }
}

/// Side by side they are what they are alone, to rounding, with the gap and N that others have.
#[test]
fn batches_have_the_derivatives_of_single_elements() {
    let cases: Vec<Case> = all(9).map(|(case, _)| case).collect();
    let elements: Vec<_> = cases.iter().map(Case::element).collect();
    let forms: Vec<_> = elements.iter().map(|element| Generated.hessian_form(element).unwrap()).collect();
    let mut rooms: Vec<[Vec<f64>; 2]> = forms
        .iter()
        .map(|form| [vec![0.0; form.degrees_of_freedom()], vec![0.0; form.foot_numbers()]])
        .collect();
    let slots = rooms.iter_mut().map(|[gradient, hessian]| GapSlot { gradient, hessian });
    let mut scratch = BatchScratch::default();
    let points = Generated.gap_foot_batch(&elements, slots, &mut scratch);
    let mut factors: Vec<Vec<f64>> = forms.iter().map(|form| vec![0.0; form.numbers()]).collect();
    let mut gradients = vec![[0.0; 30]; cases.len()];
    let slots = factors.iter_mut().zip(&mut gradients);
    let slots = slots.map(|(hessian, gradient)| GapSlot { gradient, hessian });
    let without = Generated.gap_factors_batch(&elements, slots, &mut scratch);
    assert_eq!(points, without);
    for (k, element) in elements.iter().enumerate() {
        let ([gradient, numbers], point) = (&rooms[k], points[k].unwrap());
        assert_eq!(gradient[..], gradients[k]);
        let mut found = FootDerivatives {
            point,
            weights: vec![f64::NAN; 9],
            foot: vec![f64::NAN; 90],
            normal: vec![f64::NAN; 90],
        };
        let FootDerivatives { weights, foot, normal, .. } = &mut found;
        let mut slot = FootSlot { weights, foot, normal };
        forms[k].foot_derivatives(&point, gradient, numbers, &mut slot).unwrap();
        assert_same(&found, &Generated.foot_derivatives(element).unwrap(), "side by side");
    }
}

#[test]
fn an_element_without_a_gap_has_no_derivatives_at_its_foot() {
    let (mut case, _) = all(9).next().unwrap();
    case.masters[3][1] = f64::NAN;
    let refused = Generated.foot_derivatives(&case.element()).unwrap_err();
    assert_eq!(Generated.gap(&case.element(), Mode::Hessian).unwrap_err(), refused);
}

proptest! {
    #![proptest_config(diffuse_contact_tests::fixed(64))]

    #[test]
    fn on_facets_too(case in facet_cases()) {
        let element = case.element();
        let found = Generated.facet_foot_derivatives(&element).unwrap();
        assert_same(&found, &Ad.facet_foot_derivatives(&element).unwrap(), "on a facet");
    }
}
