//! The distance from a facet: the generated kernels against automatic differentiation, against what is known of the
//! foot, and against the identities every gap satisfies.

use diffuse_contact::ad::Ad;
use diffuse_contact::{FacetElement, Gap, Generated, Mode, Point};
use diffuse_contact_tests::{
    FacetCase, Random, add, cross, difference, dot, facet_cases, fixed, largest, length, scale, turn,
    turned_rows, turned_vector,
};
use proptest::prelude::*;

/// Rounding of one evaluation on the facets of [`facet_cases`], relative to the largest entry.
const ROUNDING: f64 = 2e-13;
/// Difference of two backends, relative to the largest entry.
const AGREEMENT: f64 = 1e-12;

fn gap(case: &FacetCase) -> Gap {
    Generated.facet_gap(&case.element(), Mode::Hessian).expect("a sound facet")
}

fn part(vector: &[f64], node: usize) -> Point {
    std::array::from_fn(|axis| vector[3 * node + axis])
}

fn minus(x: Point, y: Point) -> Point {
    add(x, scale(-1.0, y))
}

/// g over the size of the facet, N and M over their largest entries.
fn assert_agree(case: &FacetCase, size: f64, tolerance: f64) {
    let found = gap(case);
    let expected = Ad.facet_gap(&case.element(), Mode::Hessian).expect("a sound facet");
    let lengths = [found.gap, expected.gap].map(|g| g / size);
    assert!((lengths[0] - lengths[1]).abs() <= tolerance, "g: {lengths:?} {case:?}");
    let error = difference(&found.normal, &expected.normal);
    assert!(error <= tolerance, "ν: {error:e} {case:?}");
    let error = difference(&found.gradient, &expected.gradient);
    assert!(error <= tolerance, "N: {error:e} {case:?}");
    let error = difference(found.hessian.packed(), expected.hessian.packed());
    assert!(error <= tolerance, "M: {error:e} {case:?}");
}

proptest! {
    #![proptest_config(fixed(1000))]

    #[test]
    fn the_foot_is_the_one_the_slave_was_put_over(case in facet_cases()) {
        let element = case.element();
        let found = Generated.facet_point(&element).unwrap();
        prop_assert!((found.point.gap - case.distance).abs() <= 1e-14, "{found:?}");
        prop_assert!(difference(&found.natural, &case.natural) <= ROUNDING, "{found:?}");
        let [foot, ..] = case.surface(found.natural);
        prop_assert!(length(minus(found.point.foot, foot)) <= 1e-14);
        prop_assert!((length(found.point.normal) - 1.0).abs() <= 1e-15);
        let along = add(found.point.foot, scale(found.point.gap, found.point.normal));
        prop_assert!(length(minus(along, case.slave)) <= 1e-14);
        let ad = Ad.facet_point(&element).unwrap();
        prop_assert!(difference(&ad.natural, &case.natural) <= ROUNDING, "{ad:?}");
    }

    #[test]
    fn automatic_differentiation_agrees(case in facet_cases()) {
        assert_agree(&case, 1.0, AGREEMENT);
    }

    #[test]
    fn automatic_differentiation_agrees_in_any_unit(case in facet_cases(), exponent in -60..=60) {
        let factor = 10f64.powi(exponent);
        assert_agree(&case.scaled(factor), factor, AGREEMENT);
    }

    #[test]
    fn automatic_differentiation_agrees_far_from_the_origin(case in facet_cases(), seed: u64, exponent in 1..=9) {
        // The positions are rounded there: another facet, but the same for both.
        let shift = scale(10f64.powi(exponent), Random::new(seed).vector(1.0));
        assert_agree(&case.mapped(|x| add(x, shift)), 1.0, AGREEMENT);
    }

    #[test]
    fn slips_agree_in_any_unit_and_balance(case in facet_cases(), seed: u64, exponent in -60..=60) {
        let mut random = Random::new(seed);
        let factor = 10f64.powi(exponent);
        let anchor = scale(factor, add(case.slave, random.vector(0.5)));
        let case = case.scaled(factor);
        let found = Generated.facet_slip(&case.element(), anchor, Mode::Hessian).unwrap();
        let expected = Ad.facet_slip(&case.element(), anchor, Mode::Hessian).unwrap();
        prop_assert!((found.half_square - expected.half_square).abs() <= AGREEMENT * factor * factor);
        let close = |found: &[f64], expected: &[f64]| difference(found, expected) <= AGREEMENT;
        prop_assert!(close(&found.gradient, &expected.gradient), "∇q: {found:?} {expected:?}");
        prop_assert!(close(found.hessian.packed(), expected.hessian.packed()), "∇²q: {found:?} {expected:?}");
        prop_assert!(close(&found.foot_weights, &expected.foot_weights), "φ: {found:?} {expected:?}");
        // Rigid motions of all points change no slip.
        let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
        let points = [&[case.slave], &case.corners[..], &[anchor]].concat();
        for (node, x) in points.into_iter().enumerate() {
            let by = part(&found.gradient, node);
            force = add(force, by);
            moment = add(moment, cross(scale(1.0 / factor, minus(x, case.slave)), by));
        }
        let size = largest(&found.gradient);
        prop_assert!(length(force) <= ROUNDING * size && length(moment) <= ROUNDING * size, "{force:?} {moment:?}");
    }

    #[test]
    fn slivers_agree_too(seed: u64, exponent in -2.0..0.0f64) {
        // Up to a hundred times as long as wide: the square of that is lost.
        let thickness = 10f64.powf(exponent);
        let flatten = |[x, y, z]: Point| [x, thickness * y, thickness * z];
        let mut random = Random::new(seed);
        for count in [3, 4] {
            let corners: Vec<Point> = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]][..count]
                .iter()
                .map(|[x, y]| [x + 0.1 * random.signed(), y + 0.1 * random.signed(), 0.2 * random.signed()])
                .map(flatten)
                .collect();
            let slave = flatten([0.5 * random.signed(), 0.5 * random.signed(), 0.4 * random.signed()]);
            let q = random.rotation();
            let case = FacetCase { slave, corners, natural: [0.0; 2], distance: 0.0 };
            assert_agree(&case.mapped(|x| turn(&q, x)), 1.0, AGREEMENT / (thickness * thickness));
        }
    }

    #[test]
    fn a_translation_of_everything_changes_nothing(case in facet_cases()) {
        let gap = gap(&case);
        let size = largest(gap.hessian.packed());
        for axis in 0..3 {
            let sum: f64 = gap.gradient.iter().skip(axis).step_by(3).sum();
            prop_assert!(sum.abs() <= 1e-15, "Σ N_i = {sum:e}");
            for row in gap.hessian.to_rows() {
                let sum: f64 = row.iter().skip(axis).step_by(3).sum();
                prop_assert!(sum.abs() <= ROUNDING * size, "a row of M sums to {:e}", sum / size);
            }
        }
    }

    #[test]
    fn a_rotation_of_everything_changes_nothing(case in facet_cases()) {
        // Σ x_i × N_i = 0 and M (ω × x) = ω × N.
        let gap = gap(&case);
        let arms: Vec<Point> = case.nodes().iter().map(|x| minus(*x, case.slave)).collect();
        let moment = arms.iter().enumerate().fold([0.0; 3], |sum, (i, x)| add(sum, cross(*x, part(&gap.gradient, i))));
        prop_assert!(length(moment) <= ROUNDING, "{moment:?}");
        let size = largest(gap.hessian.packed()).max(1.0);
        for axis in 0..3 {
            let omega: Point = std::array::from_fn(|k| f64::from(u8::from(k == axis)));
            let spin: Vec<f64> = arms.iter().flat_map(|x| cross(omega, *x)).collect();
            let expected: Vec<f64> =
                (0..arms.len()).flat_map(|i| cross(omega, part(&gap.gradient, i))).collect();
            for (row, expected) in gap.hessian.to_rows().iter().zip(expected) {
                let product: f64 = row.iter().zip(&spin).map(|(m, x)| m * x).sum();
                prop_assert!((product - expected).abs() <= ROUNDING * size);
            }
        }
    }

    #[test]
    fn what_is_turned_has_turned_results(case in facet_cases(), seed: u64) {
        let q = Random::new(seed).rotation();
        let (here, there) = (gap(&case), gap(&case.mapped(|x| turn(&q, x))));
        prop_assert!((here.gap - there.gap).abs() <= ROUNDING, "g");
        prop_assert!(difference(&there.normal, &turn(&q, here.normal)) <= ROUNDING, "ν");
        prop_assert!(difference(&there.gradient, &turned_vector(&q, &here.gradient)) <= ROUNDING, "N");
        let (found, expected) = (there.hessian.to_rows().concat(), turned_rows(&q, &here.hessian).concat());
        prop_assert!(difference(&found, &expected) <= AGREEMENT, "M");
    }

    #[test]
    fn a_power_of_two_scales_every_bit(case in facet_cases(), exponent in -200..=200) {
        let factor = 2f64.powi(exponent);
        let (here, there) = (gap(&case), gap(&case.scaled(factor)));
        prop_assert_eq!(there.gap, factor * here.gap);
        prop_assert_eq!(there.gradient, here.gradient);
        for (m, expected) in there.hessian.packed().iter().zip(here.hessian.packed()) {
            prop_assert_eq!(*m, expected / factor);
        }
    }

    /// The first corner is any; the other way round is the other side.
    #[test]
    fn corners_count_from_any_of_them(case in facet_cases(), first in 1usize..4) {
        let here = gap(&case);
        let count = case.corners.len();
        for (order, sign) in [
            ((0..count).map(|k| (k + first) % count).collect::<Vec<usize>>(), 1.0),
            ((0..count).rev().collect(), -1.0),
        ] {
            let corners = order.iter().map(|&k| case.corners[k]).collect();
            let there = gap(&FacetCase { corners, ..case.clone() });
            prop_assert!((there.gap - sign * here.gap).abs() <= ROUNDING);
            let node = |i: usize| if i == 0 { 0 } else { 1 + order[i - 1] };
            let freedom = |i: usize| 3 * node(i / 3) + i % 3;
            let gradient: Vec<f64> = (0..here.gradient.len()).map(|i| sign * here.gradient[freedom(i)]).collect();
            prop_assert!(difference(&there.gradient, &gradient) <= ROUNDING, "N");
            let entry = |i: usize, j: usize| sign * here.hessian.get(freedom(i), freedom(j));
            let expected: Vec<f64> =
                (0..gradient.len()).flat_map(|i| (0..=i).map(move |j| (i, j))).map(|(i, j)| entry(i, j)).collect();
            prop_assert!(difference(there.hessian.packed(), &expected) <= AGREEMENT, "M");
        }
    }

    #[test]
    fn a_flat_quadrilateral_is_the_plane_of_its_triangles(seed: u64) {
        let case = FacetCase::random(4, 0.0, seed);
        let found = gap(&case);
        for corners in [[0, 1, 2], [2, 3, 0]] {
            let corners = corners.map(|k| case.corners[k]);
            let plane = Generated.facet_gap(&FacetElement { slave: case.slave, corners: &corners }, Mode::Hessian);
            let plane = plane.unwrap();
            prop_assert!((found.gap - plane.gap).abs() <= 1e-14);
            prop_assert!(difference(&found.normal, &plane.normal) <= 1e-14);
            prop_assert!(difference(&found.foot, &plane.foot) <= 1e-14);
        }
    }

    #[test]
    fn the_slave_s_part_is_the_curvature_of_the_offset_surface(case in facet_cases()) {
        // ∂g/∂x^c = ν, and ∂²g/∂x^c∂x^c does not see the direction of the normal.
        let gap = gap(&case);
        prop_assert!(difference(&gap.gradient[..3], &gap.normal) <= 1e-15);
        let rows = gap.hessian.to_rows();
        let along: Vec<f64> = (0..3).map(|i| dot([rows[i][0], rows[i][1], rows[i][2]], gap.normal)).collect();
        prop_assert!(largest(&along) <= ROUNDING * largest(gap.hessian.packed()).max(1.0), "{along:?}");
        if case.corners.len() == 3 {
            prop_assert!((0..3).all(|i| rows[i][..3].iter().all(|m| m.abs() <= ROUNDING)));
        }
    }

    #[test]
    fn modes_and_forms_give_the_same_numbers(case in facet_cases()) {
        let element = case.element();
        let freedoms = element.degrees_of_freedom();
        let full = gap(&case);
        let point = Generated.facet_point(&element).unwrap();
        for mode in [Mode::Value, Mode::Gradient, Mode::Hessian] {
            let (mut gradient, mut hessian) = (vec![7.0; freedoms], vec![7.0; freedoms * (freedoms + 1) / 2]);
            let found = Generated.facet_gap_into(&element, mode, &mut gradient, &mut hessian).unwrap();
            prop_assert!((found.point.gap - point.point.gap).abs() <= 1e-15);
            prop_assert!(difference(&found.natural, &point.natural) <= 1e-14);
            if mode == Mode::Value {
                prop_assert!(gradient.iter().all(|&x| x == 7.0));
            } else {
                prop_assert!(difference(&gradient, &full.gradient) <= 1e-15);
            }
            if mode == Mode::Hessian {
                prop_assert_eq!(&hessian[..], full.hessian.packed());
            } else {
                prop_assert!(hessian.iter().all(|&x| x == 7.0));
            }
        }
        let value = Generated.facet_gap(&element, Mode::Value).unwrap();
        prop_assert!(value.gradient.is_empty() && value.hessian.size() == 0 && value.coefficients.is_empty());
    }
}

/// Feet on triangles may lie as far outside as they like, on parallelograms too: there is nothing but a plane.
#[test]
fn a_far_foot_on_a_plane_is_found() {
    for corners in [
        vec![[0.0, 0.0, 0.0], [1.0, 0.25, 0.0], [0.125, 1.0, 0.0]],
        vec![[0.0, 0.0, 0.0], [1.0, 0.25, 0.0], [1.125, 1.25, 0.0], [0.125, 1.0, 0.0]],
    ] {
        for distance in [10.0, 1e3, 1e6] {
            let slave = [distance, -2.0 * distance, -0.5];
            let found = Generated.facet_point(&FacetElement { slave, corners: &corners }).unwrap();
            assert!((found.point.gap + 0.5).abs() <= 1e-15 * distance, "{found:?}");
            assert!(
                length(minus(found.point.foot, [slave[0], slave[1], 0.0])) <= 1e-14 * distance,
                "{found:?}"
            );
            assert!(!FacetElement { slave, corners: &corners }.contains(found.natural, 0.1));
        }
    }
}

/// Slave and corners on springs, the slave pushed through the facet: Newton's method with R = −ε g N and K = ε (g M + N Nᵀ)
/// converges quadratically.
#[test]
fn newton_s_method_converges_quadratically() {
    for (count, warp, seed) in [(3, 0.0, 1), (4, 0.2, 2), (4, 0.2, 3)] {
        let start = FacetCase { distance: -0.3, ..FacetCase::random(count, warp, seed) };
        let rest: Vec<f64> = start.nodes().into_iter().flatten().collect();
        let (penalty, spring) = (5.0, 1.0);
        let push = gap(&start).normal;
        let mut x = rest.clone();
        let mut sizes = Vec::new();
        for _ in 0..12 {
            let nodes: Vec<Point> = x.chunks_exact(3).map(|x| [x[0], x[1], x[2]]).collect();
            let gap = gap(&FacetCase { slave: nodes[0], corners: nodes[1..].to_vec(), ..start.clone() });
            let mut force = gap.contact_force(penalty);
            let mut matrix = gap.tangent(penalty).to_rows();
            for i in 0..x.len() {
                force[i] -= spring * (x[i] - rest[i]) + if i < 3 { 0.5 * push[i] } else { 0.0 };
                matrix[i][i] += spring;
            }
            sizes.push(largest(&force));
            let step = solve(matrix, force);
            for (x, step) in x.iter_mut().zip(step) {
                *x += step;
            }
        }
        let last = sizes.iter().position(|&size| size < 1e-13);
        let last = last.unwrap_or_else(|| panic!("no convergence: {sizes:?}"));
        // A tangent that is not the derivative leaves a part of the error that does not get squared.
        let near = sizes.iter().position(|&size| size < 1e-2).unwrap_or(last);
        assert!(last <= near + 4, "{sizes:?}");
        for pair in sizes[near..=last].windows(2) {
            assert!(pair[1] <= 50.0 * pair[0] * pair[0] + 1e-13, "{sizes:?}");
        }
    }
}

/// Gaussian elimination of a diagonally dominant enough system.
fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for k in 0..n {
        for i in k + 1..n {
            let factor = a[i][k] / a[k][k];
            for j in k..n {
                a[i][j] -= factor * a[k][j];
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - known) / a[k][k];
    }
    b
}
