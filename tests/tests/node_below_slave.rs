//! Places where the derivative of a weight needs care: the slave straight above a node, r = 0, where w'' is
//! infinite as a function of r² while its products are not, and a node on the border of the support, r = 1.

use diffuse_contact::ad::{Ad, RadialWeight};
use diffuse_contact::{Backend, Basis, Gap, Generated, GeneratedWith, Mode, Point};
use diffuse_contact_kernels::support::KernelSet;
use diffuse_contact_tests::weights::{matern, spline, wendland};
use diffuse_contact_tests::{
    Case, Quadric, Random, assert_finite_gap, assert_same_coefficients, assert_same_gap, assert_same_surface,
    difference,
};

/// Support radius of the elements in here.
const RADIUS: f64 = 1.3;
/// Direction in which the slave leaves the node: no axis, of unit length in floating point.
const ASIDE: [f64; 2] = [0.6, 0.8];
/// In-plane distances over R, down to the smallest normal numbers.
const DISTANCES: [f64; 14] =
    [1e-300, 1e-200, 1e-160, 1e-150, 1e-100, 1e-50, 1e-30, 1e-20, 1e-16, 1e-12, 1e-8, 1e-5, 1e-3, 1e-2];

/// An element with a master at the origin of the global axes and the slave at in-plane distance `r` R from it.
/// The frame is that of the axes, so that the offset is what it says to the last bit.
fn above_node(basis: Basis, r: f64, direction: [f64; 2]) -> Case {
    let n = if basis == Basis::Quadratic { 9 } else { 6 };
    let mut nodes = local_nodes(n, 7);
    let [x, y, _] = nodes[3];
    for node in &mut nodes {
        *node = [node[0] - x, node[1] - y, node[2]];
    }
    nodes[0] = [r * RADIUS * direction[0], r * RADIUS * direction[1], 0.35];
    Case::axis_aligned(&nodes, RADIUS, basis)
}

/// Slave and masters in local coordinates.
fn local_nodes(n: usize, seed: u64) -> Vec<Point> {
    let case = Case::random(n, Basis::Quadratic, seed);
    let mut nodes = vec![[0.0, 0.0, 0.3]];
    nodes.extend(case.masters.iter().map(|x| case.local_offset(*x)));
    nodes
}

/// All outputs of a backend against another on one element.
#[track_caller]
fn compare(case: &Case, found: &impl Backend, expected: &impl Backend, tolerance: f64) {
    let element = case.element();
    let gaps =
        [found.gap(&element, Mode::Hessian), expected.gap(&element, Mode::Hessian)].map(Result::unwrap);
    assert_finite_gap(&gaps[0]);
    assert_same_gap(case, &gaps[0], &gaps[1], tolerance);
    let fits = (found.coefficients(&element, Mode::Hessian), expected.coefficients(&element, Mode::Hessian));
    assert_same_coefficients(case, &fits.0.unwrap(), &fits.1.unwrap(), tolerance);
    let point = [0.1 * case.support_radius, -0.2 * case.support_radius];
    let surfaces =
        (found.surface(&element, point, Mode::Hessian), expected.surface(&element, point, Mode::Hessian));
    assert_same_surface(case, &surfaces.0.unwrap(), &surfaces.1.unwrap(), tolerance);
}

fn gap(backend: &impl Backend, case: &Case) -> Gap {
    backend.gap(&case.element(), Mode::Hessian).unwrap()
}

/// On the node and near it: as automatic differentiation has it, and continuous.
#[track_caller]
fn node_below_slave(backend: &impl Backend, reference: &impl Backend, tolerance: f64) {
    for basis in [Basis::Quadratic, Basis::Linear] {
        let on_node = above_node(basis, 0.0, ASIDE);
        compare(&on_node, backend, reference, tolerance);
        let limit = gap(backend, &on_node);
        for (k, r) in DISTANCES.into_iter().enumerate() {
            // Turn and turn about.
            for direction in [[ASIDE, [0.0, -1.0]], [[1.0, 0.0], [-0.8, 0.6]]][k % 2] {
                let case = above_node(basis, r, direction);
                compare(&case, backend, reference, tolerance);
                // N and M are Lipschitz functions of the position.
                let near = gap(backend, &case);
                let change = difference(&near.gradient, &limit.gradient);
                assert!(change <= 20.0 * r + 1e-13, "N jumps by {change:e} at r = {r:e}");
                let change = difference(near.hessian.packed(), limit.hessian.packed());
                assert!(change <= 40.0 * r + 1e-12, "M jumps by {change:e} at r = {r:e}");
            }
        }
    }
}

/// The same for a weight of one's own.
#[track_caller]
fn node_below_slave_with<K: KernelSet + Sync>(tolerance: f64) {
    let reference = Ad::with_weight_formula(K::WEIGHT).unwrap();
    node_below_slave(&GeneratedWith::<K>::new(), &reference, tolerance);
}

#[test]
fn cubic() {
    node_below_slave(&Generated, &Ad, 3e-13);
}

#[test]
fn wendland() {
    node_below_slave_with::<wendland::Wendland>(2e-12);
}

#[test]
fn matern() {
    node_below_slave_with::<matern::Matern>(3e-13);
}

#[test]
fn spline() {
    node_below_slave_with::<spline::Spline>(3e-13);
}

/// In a rotated frame the offset is not exactly zero but of the size of the rounding.
#[test]
fn straight_above_a_node_in_any_direction() {
    let mut random = Random::new(11);
    for size in [1e-3, 1.0, 1e3] {
        for basis in [Basis::Quadratic, Basis::Linear] {
            let case = above_node(basis, 0.0, ASIDE).turned(&random.rotation()).scaled(size);
            compare(&case, &Generated, &Ad, 3e-13);
        }
    }
}

/// Second derivatives with respect to the slave are limits of difference quotients of N, across the node too.
#[test]
fn the_hessian_on_the_node_is_the_derivative_of_the_gradient() {
    let limit = gap(&Generated, &above_node(Basis::Quadratic, 0.0, ASIDE));
    let step = 1e-6;
    for (axis, direction) in [[1.0, 0.0], [0.0, 1.0]].into_iter().enumerate() {
        let side = |r: f64| gap(&Generated, &above_node(Basis::Quadratic, r, direction)).gradient;
        let (plus, minus) = (side(step / RADIUS), side(-step / RADIUS));
        let column: Vec<f64> = plus.iter().zip(&minus).map(|(p, m)| (p - m) / (2.0 * step)).collect();
        let expected: Vec<f64> = (0..column.len()).map(|i| limit.hessian.get(i, axis)).collect();
        // w''' jumps on the node: the central difference is of first order in the step there.
        let error = difference(&column, &expected);
        assert!(error <= 1e-5, "{error:e}");
    }
}

/// Ten masters, the last at in-plane distance `r` R from the slave.
fn at_border(r: f64) -> Case {
    let mut nodes = local_nodes(9, 21);
    nodes[0] = [0.0, 0.0, 0.3];
    nodes.push([r * RADIUS * ASIDE[0], r * RADIUS * ASIDE[1], 0.2]);
    Case::axis_aligned(&nodes, RADIUS, Basis::Quadratic)
}

/// Offsets of a node from the border of the support, as fractions of R.
const FROM_BORDER: [f64; 6] = [1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 2.3e-16];

#[test]
fn a_node_crosses_the_border_without_a_jump_of_the_gradient() {
    let outside = gap(&Generated, &at_border(1.5));
    for step in FROM_BORDER {
        for r in [1.0 - step, 1.0, 1.0 + step] {
            let near = gap(&Generated, &at_border(r));
            assert_finite_gap(&near);
            // w is of order (1 − r)², its slope of order 1 − r.
            let change = (near.gap - outside.gap).abs();
            assert!(change <= 20.0 * step * step + 1e-14, "g jumps by {change:e} at {r}");
            let change = difference(&near.gradient, &outside.gradient);
            assert!(change <= 20.0 * step + 1e-13, "N jumps by {change:e} at {r}");
        }
    }
}

#[test]
fn a_node_outside_the_support_counts_for_nothing() {
    for r in [1.0 + 1e-12, 1.5, 1e3, 1e30] {
        let with = at_border(r);
        let mut without = with.clone();
        without.masters.pop();
        let (with, without) = (gap(&Generated, &with), gap(&Generated, &without));
        assert_eq!(with.gap, without.gap, "at {r}");
        let freedoms = without.gradient.len();
        assert_eq!(with.gradient[..freedoms], without.gradient[..]);
        assert_eq!(with.gradient[freedoms..], [0.0; 3]);
        let packed = without.hessian.packed().len();
        assert_eq!(with.hessian.packed()[..packed], *without.hessian.packed());
        assert!(with.hessian.packed()[packed..].iter().all(|m| *m == 0.0));
    }
}

#[test]
fn the_hessian_jumps_at_the_border_as_the_weight_says() {
    /// M just inside the border differs from M just outside by this, relative.
    fn jump(backend: &impl Backend) -> f64 {
        let [inside, outside] =
            [1.0 - 1e-9, 1.0 + 1e-9].map(|r| gap(backend, &at_border(r)).hessian.packed().to_vec());
        difference(&inside, &outside)
    }
    // The cubic weight has w''(1) = 6, Wendland's has w''(1) = 0.
    assert!(jump(&Generated) > 1e-2);
    assert!(jump(&GeneratedWith::<wendland::Wendland>::new()) < 1e-6);
    for r in [1.0 - 1e-6, 1.0 - 1e-9, 1.0 + 1e-9, 1.0 + 1e-6] {
        compare(&at_border(r), &Generated, &Ad, 3e-13);
    }
}

/// A formula in factors loses digits of its slope at small r; as a weight of one's own it must not.
#[test]
fn the_cubic_weight_in_either_form() {
    struct Factored;
    impl RadialWeight for Factored {
        fn evaluate<D: diffuse_contact::ad::DualNum<Primitive = f64> + Copy>(&self, r: D) -> D {
            (-r + 1.0) * (-r + 1.0) * (r * 2.0 + 1.0)
        }
    }
    let reference = Ad::with_weight(Factored).unwrap();
    for r in [0.0, 1e-12, 1e-8, 1e-4, 1e-2, 0.1] {
        compare(&above_node(Basis::Quadratic, r, ASIDE), &Generated, &reference, 3e-13);
    }
}

/// Masters on a quadric: the slave on a node has the gap of the quadric.
#[test]
fn a_slave_on_its_node_has_no_gap() {
    let surface = Quadric([0.1, 0.2, -0.1, 0.1, 0.05, -0.1]);
    let mut nodes: Vec<Point> =
        local_nodes(9, 31).iter().map(|[a, b, _]| [*a, *b, surface.height(*a, *b)]).collect();
    nodes[0] = nodes[4];
    let gap = gap(&Generated, &Case::axis_aligned(&nodes, RADIUS, Basis::Quadratic));
    assert!(gap.gap.abs() <= 1e-15, "{:e}", gap.gap);
    assert!(difference(&gap.foot, &nodes[0]) <= 1e-15);
    assert!(difference(&gap.normal, &surface.normal(nodes[0][0], nodes[0][1])) <= 1e-14);
}
