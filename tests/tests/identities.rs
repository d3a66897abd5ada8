//! What every implementation of the element must satisfy, whatever it is compared with: the generated kernels
//! on random elements.

use diffuse_contact::{Backend, Basis, Gap, Generated, Mode, Point, SymmetricMatrix};
use diffuse_contact_kernels::cubic::Cubic;
use diffuse_contact_kernels::support::{FrameRule, Isa, KernelSet, Status};
use diffuse_contact_tests::{
    Case, Quadric, Random, add, cases, cross, difference, dot, fixed, largest, length, scale, turn,
    turned_rows, turned_vector,
};
use proptest::prelude::*;

/// Rounding of one evaluation, relative to the largest entry, on the elements of [`cases`]: M loses up to 1e-13.
const ROUNDING: f64 = 2e-13;

fn gap(case: &Case) -> Gap {
    Generated.gap(&case.element(), Mode::Hessian).expect("a well-conditioned element")
}

/// The part of a vector that belongs to one node.
fn part(vector: &[f64], node: usize) -> Point {
    std::array::from_fn(|axis| vector[3 * node + axis])
}

/// A paraboloid with a slave above or below the surface point (a, b), nearer than half the smallest radius of
/// curvature.
fn on_quadrics() -> impl Strategy<Value = (Quadric, [f64; 2], f64, Case)> {
    (6usize..=14, any::<u64>()).prop_map(|(n, seed)| {
        let mut random = Random::new(seed);
        let surface = Quadric::random(&mut random);
        let foot = [0.3 * random.signed(), 0.3 * random.signed()];
        let distance = 0.5 * random.signed();
        (surface, foot, distance, Case::on_quadric(&surface, foot, distance, n, seed))
    })
}

proptest! {
    #![proptest_config(fixed(1000))]

    #[test]
    fn a_translation_of_everything_changes_nothing(case in cases()) {
        let gap = gap(&case);
        let size = largest(&gap.gradient);
        for axis in 0..3 {
            let sum: f64 = gap.gradient.iter().skip(axis).step_by(3).sum();
            prop_assert!(sum.abs() <= ROUNDING * size, "Σ N_i = {sum:e}");
        }
        let size = largest(gap.hessian.packed());
        for (i, row) in gap.hessian.to_rows().iter().enumerate() {
            for axis in 0..3 {
                let sum: f64 = row.iter().skip(axis).step_by(3).sum();
                prop_assert!(sum.abs() <= ROUNDING * size, "row {i} of M sums to {:e}", sum / size);
            }
        }
    }

    #[test]
    fn raising_all_masters_along_the_frame_normal_lowers_the_gap_by_its_cosine(case in cases()) {
        // f + c solves the same fit: Σ ∂g/∂z_i over the masters is −1/ℓ, 1/ℓ = ν·n̂.
        let gap = gap(&case);
        let sum: f64 = (1..=case.masters.len()).map(|i| dot(part(&gap.gradient, i), case.frame.normal)).sum();
        let cosine = dot(gap.normal, case.frame.normal);
        prop_assert!((sum + cosine).abs() <= ROUNDING, "{sum} {cosine}");
        prop_assert!((length(gap.normal) - 1.0).abs() <= 1e-15);
    }

    #[test]
    fn the_slave_lies_on_the_normal_through_its_foot(case in cases()) {
        let gap = gap(&case);
        let line = add(gap.foot, scale(gap.gap, gap.normal));
        prop_assert!(length(add(line, scale(-1.0, case.slave))) <= 1e-14 * case.support_radius);
        // (13), (22): the foot lies on the fitted surface and ν is normal to it.
        let [a, b, z] = case.local_offset(gap.foot);
        let mut alpha = [0.0; 6];
        alpha[..gap.coefficients.len()].copy_from_slice(&gap.coefficients);
        let surface = Quadric(alpha);
        prop_assert!((surface.height(a, b) - z).abs() <= 1e-14);
        prop_assert!(difference(&gap.normal, &case.global(surface.normal(a, b))) <= 1e-14);
    }

    #[test]
    fn turning_all_nodes_about_the_frame_normal_changes_nothing(case in cases()) {
        // The fit does not depend on the directions of t1 and t2: Σ x_i × N_i has no component along n̂ although
        // the frame is held.
        let gap = gap(&case);
        let nodes = std::iter::once(&case.slave).chain(&case.masters);
        let moment = nodes.enumerate().map(|(i, x)| {
            let arm = add(*x, scale(-1.0, case.slave));
            dot(cross(arm, part(&gap.gradient, i)), case.frame.normal)
        });
        let moment: f64 = moment.sum();
        prop_assert!(moment.abs() <= ROUNDING * largest(&gap.gradient), "{moment:e}");
    }

    #[test]
    fn the_unit_of_length_scales_the_results(case in cases(), exponent in -9..=9) {
        // Powers of ten round the input.
        let factor = 10f64.powi(exponent);
        let (here, there) = (gap(&case), gap(&case.scaled(factor)));
        prop_assert!((there.gap - factor * here.gap).abs() <= ROUNDING * factor, "g");
        prop_assert!(difference(&there.gradient, &here.gradient) <= ROUNDING, "N");
        let expected: Vec<f64> = here.hessian.packed().iter().map(|m| m / factor).collect();
        prop_assert!(difference(there.hessian.packed(), &expected) <= ROUNDING, "M");
        prop_assert!(difference(&there.normal, &here.normal) <= ROUNDING, "normal");
    }

    #[test]
    fn a_power_of_two_scales_every_bit(case in cases(), exponent in -40..=40) {
        let factor = 2f64.powi(exponent);
        let (here, there) = (gap(&case), gap(&case.scaled(factor)));
        prop_assert_eq!(there.gap, factor * here.gap);
        prop_assert_eq!(there.gradient, here.gradient);
        for (m, expected) in there.hessian.packed().iter().zip(here.hessian.packed()) {
            prop_assert_eq!(*m, expected / factor);
        }
    }

    #[test]
    fn a_rotation_of_everything_turns_the_results(case in cases(), seed: u64) {
        let q = Random::new(seed).rotation();
        let (here, there) = (gap(&case), gap(&case.turned(&q)));
        prop_assert!((here.gap - there.gap).abs() <= ROUNDING, "g");
        prop_assert!(difference(&there.foot, &turn(&q, here.foot)) <= ROUNDING, "foot");
        prop_assert!(difference(&there.normal, &turn(&q, here.normal)) <= ROUNDING, "normal");
        prop_assert!(difference(&there.gradient, &turned_vector(&q, &here.gradient)) <= ROUNDING, "N");
        let (found, expected) = (there.hessian.to_rows().concat(), turned_rows(&q, &here.hessian).concat());
        prop_assert!(difference(&found, &expected) <= ROUNDING, "M");
    }

    #[test]
    fn the_directions_of_t1_and_t2_do_not_matter(case in cases(), angle in 0.1..6.0f64) {
        let (s, c) = angle.sin_cos();
        let [t1, t2, _] = case.frame.rows();
        let mut other = case.clone();
        other.frame.t1 = add(scale(c, t1), scale(s, t2));
        other.frame.t2 = add(scale(-s, t1), scale(c, t2));
        let (here, there) = (gap(&case), gap(&other));
        prop_assert!((here.gap - there.gap).abs() <= ROUNDING, "g");
        prop_assert!(difference(&there.gradient, &here.gradient) <= ROUNDING, "N");
        prop_assert!(difference(there.hessian.packed(), here.hessian.packed()) <= ROUNDING, "M");
    }

    #[test]
    fn seen_from_the_other_side_everything_changes_sign(case in cases()) {
        let mut other = case.clone();
        (other.frame.t1, other.frame.t2) = (case.frame.t2, case.frame.t1);
        other.frame.normal = scale(-1.0, case.frame.normal);
        let (here, there) = (gap(&case), gap(&other));
        let minus = |x: &[f64]| x.iter().map(|x| -x).collect::<Vec<f64>>();
        prop_assert!((here.gap + there.gap).abs() <= ROUNDING, "g");
        prop_assert!(difference(&there.foot, &here.foot) <= ROUNDING, "foot");
        prop_assert!(difference(&minus(&there.normal), &here.normal) <= ROUNDING, "normal");
        prop_assert!(difference(&minus(&there.gradient), &here.gradient) <= ROUNDING, "N");
        prop_assert!(difference(&minus(there.hessian.packed()), here.hessian.packed()) <= ROUNDING, "M");
    }

    #[test]
    fn the_order_of_the_masters_does_not_matter(case in cases()) {
        let mut other = case.clone();
        other.masters.reverse();
        other.radii.reverse();
        let (here, there) = (gap(&case), gap(&other));
        let count = case.masters.len();
        let position = |x: usize| if x < 3 { x } else { 3 * (count + 1 - x / 3) + x % 3 };
        prop_assert!((here.gap - there.gap).abs() <= ROUNDING, "g");
        let gradient: Vec<f64> = (0..here.gradient.len()).map(|i| there.gradient[position(i)]).collect();
        prop_assert!(difference(&gradient, &here.gradient) <= ROUNDING, "N");
        let rows = here.hessian.to_rows();
        let entry = |i, j| there.hessian.get(position(i), position(j));
        let entries: Vec<f64> =
            (0..rows.len()).flat_map(|i| (0..rows.len()).map(move |j| (i, j))).map(|(i, j)| entry(i, j)).collect();
        prop_assert!(difference(&entries, &rows.concat()) <= ROUNDING, "M");
    }

    #[test]
    fn data_on_a_quadric_reproduce_it((surface, foot, distance, case) in on_quadrics()) {
        let gap = gap(&case);
        let [a, b] = foot;
        prop_assert!((gap.gap - distance).abs() <= ROUNDING, "{} {distance}", gap.gap);
        let normal = case.global(surface.normal(a, b));
        prop_assert!(difference(&gap.normal, &normal) <= ROUNDING, "normal");
        let expected = add(case.slave, scale(-distance, normal));
        prop_assert!(length(add(gap.foot, scale(-1.0, expected))) <= ROUNDING, "foot");
        // Whatever the weights do when the slave moves: ∂g/∂x^c is the gradient of the distance to the quadric.
        prop_assert!(difference(&gap.gradient[..3], &normal) <= ROUNDING, "∂g/∂x^c");
    }

    #[test]
    fn on_a_quadric_a_master_that_slides_along_it_changes_nothing((surface, foot, distance, case) in on_quadrics()) {
        // To first order it stays on the quadric, which the fit reproduces: N_i is normal to the surface at x_i.
        let gap = gap(&case);
        let [a, b] = foot;
        let slave = add([a, b, surface.height(a, b)], scale(distance, surface.normal(a, b)));
        let size = largest(&gap.gradient);
        for (i, master) in case.masters.iter().enumerate() {
            let [a, b, _] = add(case.local_offset(*master), slave);
            let normal = case.global(surface.normal(a, b));
            let sideways = length(cross(part(&gap.gradient, i + 1), normal));
            prop_assert!(sideways <= ROUNDING * size, "{sideways:e}");
        }
    }

    #[test]
    fn on_a_quadric_the_slave_has_the_hessian_of_the_distance((surface, foot, distance, case) in on_quadrics()) {
        let gap = gap(&case);
        let expected = distance_hessian(&surface, foot, distance);
        let axes = [0, 1, 2].map(|k| case.global(std::array::from_fn(|l| f64::from(k == l))));
        let found = |x: Point, y: Point| -> f64 {
            (0..3).map(|i| (0..3).map(|j| x[i] * gap.hessian.get(i, j) * y[j]).sum::<f64>()).sum()
        };
        let size = largest(gap.hessian.packed());
        for k in 0..3 {
            for l in 0..3 {
                let error = found(axes[k], axes[l]) - expected[k][l];
                prop_assert!(error.abs() <= ROUNDING * size, "({k}, {l}): {error:e}");
            }
        }
    }
}

proptest! {
    #![proptest_config(fixed(1000))]

    #[test]
    fn with_a_co_moving_frame_a_rotation_of_everything_changes_nothing(case in cases(), seed: u64) {
        let (gradient, hessian) = co_moving(&case);
        let omega = Random::new(seed).vector(1.0);
        // About the slave, so that the arms are of the size of the element.
        let nodes = std::iter::once(&case.slave).chain(&case.masters);
        let arms: Vec<Point> = nodes.map(|x| add(*x, scale(-1.0, case.slave))).collect();
        let rotation: Vec<f64> = arms.iter().flat_map(|arm| cross(omega, *arm)).collect();
        let size = largest(&gradient);
        let rate: f64 = gradient.iter().zip(&rotation).map(|(n, x)| n * x).sum();
        prop_assert!(rate.abs() <= CO_MOVING_ROUNDING * size, "g changes by {rate:e}");
        // N turns with the nodes: Σ_j M_ij (ω × x_j) = ω × N_i.
        let size = largest(hessian.packed());
        for i in 0..arms.len() {
            let turned = cross(omega, part(&gradient, i));
            for axis in 0..3 {
                let row = 3 * i + axis;
                let rate: f64 = (0..rotation.len()).map(|j| hessian.get(row, j) * rotation[j]).sum();
                let error = rate - turned[axis];
                prop_assert!(error.abs() <= CO_MOVING_ROUNDING * size, "row {row}: {:e}", error / size);
            }
        }
    }

    #[test]
    fn with_a_co_moving_frame_a_translation_of_everything_changes_nothing(case in cases()) {
        let (gradient, hessian) = co_moving(&case);
        let size = largest(&gradient);
        for axis in 0..3 {
            let sum: f64 = gradient.iter().skip(axis).step_by(3).sum();
            prop_assert!(sum.abs() <= CO_MOVING_ROUNDING * size, "Σ N_i = {sum:e}");
        }
        let size = largest(hessian.packed());
        for (i, row) in hessian.to_rows().iter().enumerate() {
            for axis in 0..3 {
                let sum: f64 = row.iter().skip(axis).step_by(3).sum();
                prop_assert!(sum.abs() <= CO_MOVING_ROUNDING * size, "row {i} of M sums to {:e}", sum / size);
            }
        }
    }
}

/// As [`ROUNDING`], with three nodes in a plane that may be a narrow triangle.
const CO_MOVING_ROUNDING: f64 = 1e-12;

/// N and M with a frame that is the average plane of the masters and moves with them.
fn co_moving(case: &Case) -> (Vec<f64>, SymmetricMatrix) {
    let case = case.clone().co_moving();
    let freedoms = case.element().degrees_of_freedom();
    let (mut gradient, mut hessian) = (vec![0.0; freedoms], SymmetricMatrix::zeros(freedoms));
    let kernel = (case.basis, FrameRule::CoMoving, Mode::Hessian);
    let values = Cubic::gap(Isa::best(), kernel, &case.inputs(), &mut gradient, hessian.packed_mut());
    assert_eq!(values.status(), Status::Ok);
    (gradient, hessian)
}

/// Second derivatives of the distance to a surface z = q(a, b), at `distance` from its point over (a, b): with
/// the tangents E, the metric G = EᵀE and the second form B = q_kl/ℓ,
/// −E G⁻¹ B (1 − d G⁻¹ B)⁻¹ G⁻¹ Eᵀ.
fn distance_hessian(surface: &Quadric, [a, b]: [f64; 2], distance: f64) -> [[f64; 3]; 3] {
    type Matrix = [[f64; 2]; 2];
    let product = |x: Matrix, y: Matrix| -> Matrix {
        std::array::from_fn(|i| std::array::from_fn(|j| x[i][0] * y[0][j] + x[i][1] * y[1][j]))
    };
    let inverse = |[[a, b], [c, d]]: Matrix| -> Matrix {
        let determinant = a * d - b * c;
        [[d / determinant, -b / determinant], [-c / determinant, a / determinant]]
    };
    let [q_1, q_2] = surface.slopes(a, b);
    let ell = (1.0 + q_1 * q_1 + q_2 * q_2).sqrt();
    let [q_11, q_12, q_22] = surface.curvatures().map(|q| q / ell);
    let metric = [[1.0 + q_1 * q_1, q_1 * q_2], [q_1 * q_2, 1.0 + q_2 * q_2]];
    let shape = product(inverse(metric), [[q_11, q_12], [q_12, q_22]]);
    let offset = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(i == j) - distance * shape[i][j]));
    let inner = product(product(shape, inverse(offset)), inverse(metric));
    let tangents: [[f64; 2]; 3] = [[1.0, 0.0], [0.0, 1.0], [q_1, q_2]];
    std::array::from_fn(|k| {
        std::array::from_fn(|l| {
            let entry = |i: usize, j: usize| tangents[k][i] * inner[i][j] * tangents[l][j];
            -(entry(0, 0) + entry(0, 1) + entry(1, 0) + entry(1, 1))
        })
    })
}

#[test]
fn the_gap_over_the_vertex_of_a_paraboloid_is_the_height() {
    // z = κ (a² + b²)/2, slave on the axis: g = d, ∂²g/∂x^c∂x^c = −κ/(1 − κd) across the axis.
    let kappa = 0.4;
    for distance in [1.0, 0.3, 0.0, -0.3, -1.0] {
        let surface = Quadric([0.0, 0.0, 0.0, 0.5 * kappa, 0.0, 0.5 * kappa]);
        let case = Case::on_quadric(&surface, [0.0; 2], distance, 9, 1);
        assert_eq!(case.basis, Basis::Quadratic);
        let gap = gap(&case);
        assert!((gap.gap - distance).abs() <= 1e-14, "{}", gap.gap);
        let expected = -kappa / (1.0 - kappa * distance);
        for i in 0..3 {
            for j in 0..3 {
                let across = f64::from(i == j) - case.frame.normal[i] * case.frame.normal[j];
                assert!((gap.hessian.get(i, j) - expected * across).abs() <= 1e-13);
            }
        }
    }
}
