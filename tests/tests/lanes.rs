//! The kernels are generic over the number they compute with: four elements side by side, each the same as alone.

use std::ops::{Add, Div, Mul, Neg, Sub};

use diffuse_contact::Basis;
use diffuse_contact_kernels::cubic::{linear, quadratic};
use diffuse_contact_kernels::facet::quadrilateral_hessian;
use diffuse_contact_kernels::support::{FacetInputs, FacetValues, GapValues, Inputs, Lane, Status};
use diffuse_contact_tests::{Case, FacetCase, Quadric, add, weights};

/// Four numbers, one element each.
#[derive(Clone, Copy, Debug)]
struct Lanes4([f64; 4]);

impl Lanes4 {
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self(self.0.map(f))
    }

    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|k| f(self.0[k], other.0[k])))
    }
}

impl Add for Lanes4 {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.zip(other, |x, y| x + y)
    }
}

impl Sub for Lanes4 {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.zip(other, |x, y| x - y)
    }
}

impl Mul for Lanes4 {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        self.zip(other, |x, y| x * y)
    }
}

impl Div for Lanes4 {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        self.zip(other, |x, y| x / y)
    }
}

impl Neg for Lanes4 {
    type Output = Self;
    fn neg(self) -> Self {
        self.map(|x| -x)
    }
}

impl Lane for Lanes4 {
    const ZERO: Self = Self([0.0; 4]);
    const ONE: Self = Self([1.0; 4]);

    fn splat(value: f64) -> Self {
        Self([value; 4])
    }

    fn mul_add(self, factor: Self, term: Self) -> Self {
        Self(std::array::from_fn(|k| Lane::mul_add(self.0[k], factor.0[k], term.0[k])))
    }

    fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }

    fn exp(self) -> Self {
        self.map(f64::exp)
    }

    fn abs(self) -> Self {
        self.map(f64::abs)
    }

    fn select_less(x: Self, y: Self, then: Self, otherwise: Self) -> Self {
        Self(std::array::from_fn(|k| if x.0[k] < y.0[k] { then.0[k] } else { otherwise.0[k] }))
    }

    fn all_less(x: Self, y: Self) -> bool {
        (0..4).all(|k| x.0[k] < y.0[k])
    }
}

/// A kernel for any number type.
trait GapKernel {
    fn run<T: Lane>(inputs: &Inputs<'_, T>, gradients: &mut [T], hessians: &mut [T]) -> GapValues<T>;
}

struct Quadratic;
struct Linear;
struct Matern;
struct Spline;

impl GapKernel for Quadratic {
    fn run<T: Lane>(inputs: &Inputs<'_, T>, gradients: &mut [T], hessians: &mut [T]) -> GapValues<T> {
        let mut scratch = vec![quadratic::GapHessianNode::ZERO; inputs.masters.len()];
        quadratic::gap_hessian(inputs, &mut scratch, gradients, hessians)
    }
}

impl GapKernel for Linear {
    fn run<T: Lane>(inputs: &Inputs<'_, T>, gradients: &mut [T], hessians: &mut [T]) -> GapValues<T> {
        let mut scratch = vec![linear::GapHessianNode::ZERO; inputs.masters.len()];
        linear::gap_hessian(inputs, &mut scratch, gradients, hessians)
    }
}

impl GapKernel for Matern {
    fn run<T: Lane>(inputs: &Inputs<'_, T>, gradients: &mut [T], hessians: &mut [T]) -> GapValues<T> {
        let mut scratch = vec![weights::matern::linear::GapHessianNode::ZERO; inputs.masters.len()];
        weights::matern::linear::gap_hessian(inputs, &mut scratch, gradients, hessians)
    }
}

impl GapKernel for Spline {
    fn run<T: Lane>(inputs: &Inputs<'_, T>, gradients: &mut [T], hessians: &mut [T]) -> GapValues<T> {
        let mut scratch = vec![weights::spline::linear::GapHessianNode::ZERO; inputs.masters.len()];
        weights::spline::linear::gap_hessian(inputs, &mut scratch, gradients, hessians)
    }
}

fn inputs(case: &Case) -> Inputs<'_, f64> {
    Inputs {
        slave: case.slave,
        masters: &case.masters,
        t1: case.frame.t1,
        t2: case.frame.t2,
        normal: case.frame.normal,
        support_radius: case.support_radius,
        point: [0.0; 2],
        anchor: 0.0,
    }
}

/// Values, N and M of a kernel; what it does not write stays NaN.
fn run<K: GapKernel, T: Lane>(inputs: &Inputs<'_, T>) -> (GapValues<T>, Vec<T>, Vec<T>) {
    let freedoms = 3 * (inputs.masters.len() + 1);
    let mut gradient = vec![T::splat(f64::NAN); freedoms];
    let mut hessian = vec![T::splat(f64::NAN); freedoms * (freedoms + 1) / 2];
    let values = K::run(inputs, &mut gradient, &mut hessian);
    (values, gradient, hessian)
}

/// The same fields of four elements, lane by lane.
fn gather<const N: usize>(of: impl Fn(usize) -> [f64; N]) -> [Lanes4; N] {
    let lanes: [[f64; N]; 4] = std::array::from_fn(of);
    std::array::from_fn(|i| Lanes4(lanes.map(|lane| lane[i])))
}

/// Everything a kernel returned as bits; NaNs are one whatever their sign and payload.
fn bits(values: &GapValues<f64>, gradient: &[f64], hessian: &[f64]) -> Vec<u64> {
    let mut all = vec![
        values.gap,
        values.pivot_ratio,
        values.plane_pivot_ratio,
        values.foot_residual,
        values.foot_iterations,
        values.foot_distance,
        values.jacobian_determinant,
        values.jacobian_trace,
        values.checksum,
    ];
    all.extend(values.foot);
    all.extend(values.normal);
    all.extend(values.coefficients);
    all.extend(gradient);
    all.extend(hessian);
    all.into_iter().map(|x| if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() }).collect()
}

/// Runs four elements side by side and each alone, compares bit for bit, and returns what each is alone.
#[track_caller]
fn lanes_are_elements<K: GapKernel>(cases: &[Case; 4]) -> [GapValues<f64>; 4] {
    let count = cases[0].masters.len();
    let masters: Vec<[Lanes4; 3]> = (0..count).map(|i| gather(|k| cases[k].masters[i])).collect();
    let [support_radius] = gather(|k| [cases[k].support_radius]);
    let (values, gradient, hessian) = run::<K, Lanes4>(&Inputs {
        slave: gather(|k| cases[k].slave),
        masters: &masters,
        t1: gather(|k| cases[k].frame.t1),
        t2: gather(|k| cases[k].frame.t2),
        normal: gather(|k| cases[k].frame.normal),
        support_radius,
        point: [Lanes4::ZERO; 2],
        anchor: Lanes4::ZERO,
    });
    std::array::from_fn(|k| {
        let lane = |x: &[Lanes4]| x.iter().map(|x| x.0[k]).collect::<Vec<f64>>();
        let in_lane = GapValues {
            gap: values.gap.0[k],
            foot: values.foot.map(|x| x.0[k]),
            normal: values.normal.map(|x| x.0[k]),
            coefficients: values.coefficients.map(|x| x.0[k]),
            pivot_ratio: values.pivot_ratio.0[k],
            plane_pivot_ratio: values.plane_pivot_ratio.0[k],
            foot_residual: values.foot_residual.0[k],
            foot_iterations: values.foot_iterations.0[k],
            foot_distance: values.foot_distance.0[k],
            jacobian_determinant: values.jacobian_determinant.0[k],
            jacobian_trace: values.jacobian_trace.0[k],
            checksum: values.checksum.0[k],
        };
        let (alone, alone_gradient, alone_hessian) = run::<K, f64>(&inputs(&cases[k]));
        assert_eq!(
            bits(&in_lane, &lane(&gradient), &lane(&hessian)),
            bits(&alone, &alone_gradient, &alone_hessian),
            "lane {k}: {in_lane:?} alone {alone:?}"
        );
        alone
    })
}

/// Nine masters in a plane: the foot is found at once.
fn flat() -> Case {
    Case::on_quadric(&Quadric([0.0; 6]), [0.0; 2], 0.25, 9, 1)
}

/// A strongly curved surface.
fn curved(seed: u64) -> Case {
    let surface = Quadric([0.1, 0.5, -0.3, 0.5, 0.4, -0.3]);
    Case::on_quadric(&surface, [0.2, -0.1], 0.6, 9, seed)
}

fn random(seed: u64) -> Case {
    Case::random(9, Basis::Quadratic, seed)
}

#[test]
fn sound_lanes_converge_each_in_its_own_time() {
    let values = lanes_are_elements::<Quadratic>(&[flat(), random(1), curved(2), random(3).scaled(1e3)]);
    assert!(values.iter().all(|v| v.status() == Status::Ok));
    let iterations = values.map(|v| v.foot_iterations);
    // On a flat surface the start is the foot, but for rounding.
    assert!(iterations[0] <= 2.0, "{iterations:?}");
    assert!(iterations[0] < iterations[1] && iterations[1] < iterations[2], "{iterations:?}");
}

#[test]
fn bad_lanes_do_not_disturb_the_others() {
    let mut singular = random(4);
    singular.masters = vec![singular.masters[0]; 9];
    let mut not_a_number = random(5);
    not_a_number.masters[6][1] = f64::NAN;
    let values =
        lanes_are_elements::<Quadratic>(&[random(6), singular.clone(), not_a_number.clone(), curved(7)]);
    assert_eq!([values[0].status(), values[3].status()], [Status::Ok; 2]);
    assert!(matches!(values[1].status(), Status::SingularFit { .. }), "{:?}", values[1].status());
    assert_ne!(values[2].status(), Status::Ok);
}

#[test]
fn overflow_and_lost_feet_stay_in_their_lanes() {
    let mut overflowing = random(8);
    overflowing.masters[2] = add(overflowing.masters[2], overflowing.global([0.0, 0.0, 1e300]));
    // A foot far outside, and a slave on a centre of curvature.
    let mut outside = Case::on_quadric(&Quadric([0.0, 1.0, 0.0, 0.0, 0.0, 0.0]), [0.0; 2], 0.0, 9, 9);
    outside.slave = add(outside.slave, outside.global([0.0, 0.0, 10.0]));
    let bowl = Quadric([0.0, 0.0, 0.0, 0.4, 0.0, 0.4]);
    let centre = Case::on_quadric(&bowl, [0.0; 2], 1.25, 9, 10);
    let values = lanes_are_elements::<Quadratic>(&[outside, overflowing, random(11), centre]);
    assert!(matches!(values[0].status(), Status::FootOutside { .. }), "{:?}", values[0].status());
    assert_ne!(values[1].status(), Status::Ok);
    assert_eq!(values[2].status(), Status::Ok);
    assert!(matches!(values[3].status(), Status::CentreOfCurvature { .. }), "{:?}", values[3].status());
}

#[test]
fn a_slave_on_a_node_in_one_lane() {
    let nodes = |above: bool| {
        let mut nodes = vec![[if above { 0.0 } else { 0.01 }, 0.0, 0.3]];
        nodes
            .extend((0..9).map(|i| [f64::from(i % 3) - 1.0, f64::from(i / 3) - 1.0, 0.1 * f64::from(i % 2)]));
        Case::axis_aligned(&nodes, 1.9, Basis::Quadratic)
    };
    let cases = [nodes(false), nodes(true), random(12), nodes(true).scaled(1e-3)];
    let values = lanes_are_elements::<Quadratic>(&cases);
    assert!(values.iter().all(|v| v.status() == Status::Ok));
    // An expansion near r = 0 in one lane, the formula in another.
    lanes_are_elements::<Matern>(&cases);
    // One branch of the weight in one lane, the other in another.
    lanes_are_elements::<Spline>(&cases);
}

#[test]
fn the_linear_basis() {
    let linear = |seed| Case::random(5, Basis::Linear, seed);
    let mut collinear = linear(13);
    for (i, master) in collinear.masters.iter_mut().enumerate() {
        *master = [i as f64, 0.0, 0.0];
    }
    let values = lanes_are_elements::<Linear>(&[linear(14), collinear, linear(15), linear(16)]);
    assert!(matches!(values[1].status(), Status::SingularFit { .. }), "{:?}", values[1].status());
    assert!([0, 2, 3].into_iter().all(|k| values[k].status() == Status::Ok));
}

fn facet<T: Lane>(inputs: &FacetInputs<T, 4>) -> (FacetValues<T>, Vec<T>) {
    let (mut gradient, mut hessian) = ([T::ZERO; 15], [T::ZERO; 120]);
    let values = quadrilateral_hessian(inputs, &mut gradient, &mut hessian);
    (values, [&gradient[..], &hessian[..]].concat())
}

#[test]
fn facets_converge_each_in_its_own_lane() {
    let flat = FacetCase { natural: [0.0; 2], ..FacetCase::random(4, 0.0, 1) };
    let mut degenerate = FacetCase::random(4, 0.2, 2);
    degenerate.corners[1] = degenerate.corners[0];
    let mut not_a_number = FacetCase::random(4, 0.2, 3);
    not_a_number.corners[2][1] = f64::NAN;
    let cases = [flat, degenerate, not_a_number, FacetCase::random(4, 0.3, 4)];
    let corner = |i| gather(|k| cases[k].corners[i]);
    let inputs = FacetInputs { slave: gather(|k| cases[k].slave), corners: [0, 1, 2, 3].map(corner) };
    let (values, derivatives) = facet(&inputs);
    for (k, case) in cases.iter().enumerate() {
        let corners: [[f64; 3]; 4] = case.corners[..].try_into().unwrap();
        let (alone, alone_derivatives) = facet(&FacetInputs { slave: case.slave, corners });
        assert_eq!(alone.status() == Status::Ok, k % 3 == 0, "{alone:?}");
        let in_lane: Vec<f64> = derivatives.iter().map(|x| x.0[k]).collect();
        let figures =
            |x: &FacetValues<f64>| [x.gap, x.natural[0], x.foot_iterations, x.foot_residual, x.corner_area];
        let lane = FacetValues {
            gap: values.gap.0[k],
            foot: values.foot.map(|x| x.0[k]),
            normal: values.normal.map(|x| x.0[k]),
            natural: values.natural.map(|x| x.0[k]),
            corner_area: values.corner_area.0[k],
            foot_area: values.foot_area.0[k],
            foot_residual: values.foot_residual.0[k],
            foot_iterations: values.foot_iterations.0[k],
            jacobian_determinant: values.jacobian_determinant.0[k],
            checksum: values.checksum.0[k],
        };
        let bits = |values: &[f64], more: &[f64]| -> Vec<u64> {
            let all = values.iter().chain(more);
            all.map(|x| if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() }).collect()
        };
        assert_eq!(bits(&figures(&lane), &in_lane), bits(&figures(&alone), &alone_derivatives), "lane {k}");
    }
}
