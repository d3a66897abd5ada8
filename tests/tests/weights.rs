//! Every built-in weight with every basis and frame rule: generated kernels against automatic differentiation, for every
//! number of masters from the basis's size to 24; and the interpolating weight on, next to and through a node.

use diffuse_contact::ad::Ad;
use diffuse_contact::{Backend, Basis, Generated, Mode, Weight};
use diffuse_contact_kernels::cubic_interpolating::CubicInterpolating;
use diffuse_contact_kernels::support::{ElementInputs, FrameRule, Isa, KernelSet, Status};
use diffuse_contact_tests::{
    Case, Random, add, assert_finite_gap, assert_same_coefficients, assert_same_gap, assert_same_surface,
    cross, difference, instructions, length, scale, turned_rows, turned_vector,
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
fn wendland_held() {
    every_count(Weight::WendlandC2, Basis::Quadratic, false);
    every_count(Weight::WendlandC2, Basis::Linear, false);
}

#[test]
fn wendland_co_moving() {
    every_count(Weight::WendlandC2, Basis::Quadratic, true);
    every_count(Weight::WendlandC2, Basis::Linear, true);
}

#[test]
fn interpolating_held() {
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

/// An element whose slave stands at the in-plane distance `r` R from master number 2, by a frame along the axes so that
/// the offset is what it says to the last bit.
fn beside_node(basis: Basis, r: f64) -> Case {
    const RADIUS: f64 = 1.3;
    let random = Case::random(if basis == Basis::Quadratic { 9 } else { 6 }, basis, 7);
    let mut nodes = vec![[0.6 * r * RADIUS, 0.8 * r * RADIUS, 0.3]];
    let local: Vec<_> = random.masters.iter().map(|x| random.local_offset(*x)).collect();
    let [a, b, _] = local[2];
    nodes.extend(local.iter().map(|x| [x[0] - a, x[1] - b, x[2]]));
    Case::axis_aligned(&nodes, RADIUS, basis).with_weight(Weight::CubicInterpolating)
}

#[test]
fn interpolating_on_and_next_to_a_node() {
    // What is asked for is 1e-7 below 1e-6 R.
    let distances =
        [0.0, 1e-300, 1e-160, 1e-100, 1e-20, 1e-12, 1e-10, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1];
    for basis in [Basis::Quadratic, Basis::Linear] {
        for r in distances {
            let case = beside_node(basis, r);
            for case in [case.clone(), case.co_moving()] {
                let element = case.element();
                let found = Generated.gap(&element, Mode::Hessian).unwrap();
                assert_finite_gap(&found);
                assert_same_gap(&case, &found, &Ad.gap(&element, Mode::Hessian).unwrap(), TOLERANCE);
            }
            let case = beside_node(basis, r);
            let element = case.element();
            let found = Generated.coefficients(&element, Mode::Hessian).unwrap();
            assert_same_coefficients(
                &case,
                &found,
                &Ad.coefficients(&element, Mode::Hessian).unwrap(),
                TOLERANCE,
            );
            let point = [0.1, -0.2];
            let found = Generated.surface(&element, point, Mode::Hessian).unwrap();
            assert_same_surface(
                &case,
                &found,
                &Ad.surface(&element, point, Mode::Hessian).unwrap(),
                TOLERANCE,
            );
        }
    }
}

#[test]
fn the_surface_passes_through_the_node_below_the_slave() {
    for basis in [Basis::Quadratic, Basis::Linear] {
        let case = beside_node(basis, 0.0);
        let surface = Generated.surface(&case.element(), [0.0; 2], Mode::Gradient).unwrap();
        assert!((surface.value - case.local_offset(case.masters[2])[2]).abs() < 1e-15);
        // Its height there follows that node alone: ∂f/∂z is 1 at the node and 0 at the others.
        for (k, gradient) in surface.gradient.chunks_exact(3).enumerate() {
            let expected = [-1.0, 0.0, 0.0, 1.0][if k == 0 {
                0
            } else if k == 3 {
                3
            } else {
                1
            }];
            assert!((gradient[2] - expected).abs() < 1e-14, "{k}: {gradient:?}");
        }
    }
}

#[test]
fn any_node_can_be_the_pole() {
    for seed in 0..10 {
        let case = Case::random(9, Basis::Quadratic, seed).with_weight(Weight::CubicInterpolating);
        let element = case.element();
        let expected = Generated.gap(&element, Mode::Hessian).unwrap();
        for pole in 0..case.masters.len() {
            let inputs = ElementInputs { pole, ..case.inputs() };
            let freedoms = element.degrees_of_freedom();
            let (mut gradient, mut hessian) = (vec![0.0; freedoms], vec![0.0; freedoms * (freedoms + 1) / 2]);
            let kernel = (case.basis, FrameRule::Held, Mode::Hessian);
            let values = CubicInterpolating::gap(Isa::best(), kernel, &inputs, &mut gradient, &mut hessian);
            assert_eq!(values.status(), Status::Ok);
            assert!((values.gap - expected.gap).abs() < 1e-13);
            assert!(difference(&gradient, &expected.gradient) < 1e-11);
            assert!(difference(&hessian, expected.hessian.packed()) < 1e-11);
        }
    }
}

/// Vectors of nodes are filled up with copies of the last node: where it is the pole and has the slave on it, its plain
/// weight is infinite.
#[test]
fn the_slave_on_any_node_with_all_instructions() {
    for nodes in 9..=12 {
        let mut case = Case::random(nodes, Basis::Quadratic, 3).with_weight(Weight::CubicInterpolating);
        for pole in 0..nodes {
            case.slave = case.masters[pole];
            let inputs = ElementInputs { pole, ..case.inputs() };
            let freedoms = case.element().degrees_of_freedom();
            let evaluate = |isa: Isa| {
                let (mut gradient, mut hessian) =
                    (vec![f64::NAN; freedoms], vec![f64::NAN; freedoms * (freedoms + 1) / 2]);
                let kernel = (case.basis, FrameRule::Held, Mode::Hessian);
                let values = CubicInterpolating::gap(isa, kernel, &inputs, &mut gradient, &mut hessian);
                (values, gradient, hessian)
            };
            let (expected, gradient, hessian) = evaluate(Isa::SCALAR);
            assert_eq!(expected.status(), Status::Ok, "node {pole} of {nodes}");
            for isa in instructions() {
                let (found, found_gradient, found_hessian) = evaluate(isa);
                assert_eq!(found.status(), Status::Ok, "{isa}, node {pole} of {nodes}");
                assert!((found.gap - expected.gap).abs() < 1e-13 * case.support_radius);
                // Over a node at the rim the fit loses digits in proportion to its pivots.
                let bound = 1e-13 / expected.pivot_ratio;
                let (n, m) = (difference(&found_gradient, &gradient), difference(&found_hessian, &hessian));
                assert!(n < bound && m < 10.0 * bound, "{isa}, {pole} of {nodes}: {n:e} {m:e}, {bound:e}");
            }
        }
    }
}

#[test]
fn derivatives_are_continuous_through_a_node() {
    // N of neighbouring positions along a line through the node differs by M times the step, at every scale.
    let at = |r: f64| {
        let case = beside_node(Basis::Quadratic, r);
        let gap = Generated.gap(&case.element(), Mode::Hessian).unwrap();
        (case, gap)
    };
    for step in [1e-3, 1e-4, 1e-5] {
        let (before, after) = (at(-step / 2.0), at(step / 2.0));
        let (_, middle) = at(0.0);
        let moved = add(after.0.slave, scale(-1.0, before.0.slave));
        let predicted: Vec<f64> = (0..middle.gradient.len())
            .map(|row| (0..3).map(|axis| middle.hessian.get(row, axis) * moved[axis]).sum())
            .collect();
        let found: Vec<f64> = after.1.gradient.iter().zip(&before.1.gradient).map(|(x, y)| x - y).collect();
        assert!(
            difference(&found, &predicted) < 30.0 * step,
            "{step:e}: {:e}",
            difference(&found, &predicted)
        );
    }
}

/// Σ N_i = 0 and Σ x_i × N_i = 0, and everything turns with the element.
#[test]
fn a_co_moving_frame_conserves_both_momenta_and_turns_with_the_element() {
    for weight in Weight::ALL {
        for (basis, seed) in [(Basis::Quadratic, 0..12), (Basis::Linear, 12..24)]
            .into_iter()
            .flat_map(|(b, s)| s.map(move |s| (b, s)))
        {
            let case = Case::random(6 + seed as usize % 9, basis, seed).with_weight(weight).co_moving();
            let gap = |case: &Case| Generated.gap(&case.element(), Mode::Hessian).unwrap();
            let here = gap(&case);
            let forces = here.gradient.chunks_exact(3).map(|n| [n[0], n[1], n[2]]);
            let arms = std::iter::once(case.slave).chain(case.masters.iter().copied());
            let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
            for (n, x) in forces.zip(arms) {
                force = add(force, n);
                moment = add(moment, cross(x, n));
            }
            assert!(length(force) < 1e-12 && length(moment) < 1e-12, "{weight:?}: {force:?} {moment:?}");

            let q = Random::new(seed).rotation();
            // The frame is found anew: an average plane does not know its in-plane directions.
            let there = gap(&case.turned(&q).co_moving());
            assert!((there.gap - here.gap).abs() < 1e-11);
            assert!(difference(&there.gradient, &turned_vector(&q, &here.gradient)) < 1e-11);
            let expected = turned_rows(&q, &here.hessian).concat();
            assert!(difference(&there.hessian.to_rows().concat(), &expected) < 1e-11);
        }
    }
}

/// Where everything is symmetric about the slave, or nearly so, the foot is straight below it or nearly so.
#[test]
fn a_foot_almost_below_the_slave_is_found() {
    let offsets = [0.0, 1e-300, 1e-17, 1e-15, 1e-13, 1e-10, 1e-8, 1e-6, 1e-4, 1e-3];
    for weight in Weight::ALL {
        for (curvature, height) in
            [(0.05, 0.02), (-0.05, 0.3), (0.2, -0.4), (-0.3, 0.1), (1e-3, 0.5), (0.0, 0.2)]
        {
            for (offset, turn) in
                offsets.iter().flat_map(|&offset| [0.0, 0.7, 2.0].map(|turn| (offset, turn)))
            {
                let (sin, cos) = f64::sin_cos(turn);
                let mut nodes = vec![[offset * cos, offset * sin, height]];
                nodes.extend((0..16).map(|k| {
                    let (a, b) = (f64::from(k % 4) / 3.0 - 0.5, f64::from(k / 4) / 3.0 - 0.5);
                    [a, b, 0.5 * curvature * (a * a + b * b)]
                }));
                let case = Case::axis_aligned(&nodes, 0.9, Basis::Quadratic).with_weight(weight);
                let element = case.element();
                let found = Generated.gap(&element, Mode::Gradient);
                let found = found
                    .unwrap_or_else(|error| panic!("{weight:?} {curvature} {height} {offset:e}: {error}"));
                assert_same_gap(&case, &found, &Ad.gap(&element, Mode::Gradient).unwrap(), TOLERANCE);
            }
        }
    }
}
