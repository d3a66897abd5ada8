//! The gap whose frame is the average plane of the masters and moves with them: automatic differentiation
//! against finite differences and against what rigid motions demand, the generated kernels against automatic
//! differentiation.

use diffuse_contact::ad::Ad;
use diffuse_contact::{
    Backend, Basis, Element, ElementError, Frame, FrameDerivative, Gap, Generated, Mode, Point,
    SymmetricMatrix,
};

use crate::common::{Uniform, cross, rotate};

fn subtract(x: Point, y: Point) -> Point {
    std::array::from_fn(|k| x[k] - y[k])
}

/// An element that owns its nodes; its frame is their average plane.
#[derive(Clone)]
struct Case {
    nodes: Vec<Point>,
    outward: Point,
    frame: Frame,
    radius: f64,
    basis: Basis,
}

impl Case {
    /// `n` scattered masters on a bumpy surface turned at random, the slave above their middle, all within a
    /// radius of the origin shifted by `shift` radii.
    fn scattered(n: usize, basis: Basis, radius: f64, shift: f64, seed: u64) -> Self {
        let mut random = Uniform(seed);
        random.signed();
        let (axis, angle) = (random.point(), 3.0 * random.signed());
        let offset = random.point();
        let global = |local: Point| {
            let x = rotate(local, axis, angle);
            std::array::from_fn(|k| radius * (x[k] + shift * offset[k]))
        };
        let part = std::array::from_fn::<f64, 3, _>(|_| random.signed());
        let mut nodes =
            vec![global([0.15 * part[0], 0.15 * part[1], (0.2 + 0.05 * part[2]) * random.signed().signum()])];
        // Spirals fill the disc of 0.75 R, all inside the support, without putting the nodes on a conic.
        for i in 0..n {
            let r = 0.75 * ((i as f64 + 0.6) / n as f64).sqrt();
            let turn = 2.4 * i as f64 + 0.2 * random.signed();
            let (a, b) = (r * turn.cos(), r * turn.sin());
            let z = 0.5 * part[0] * a * a + 0.5 * part[1] * a * b + 0.12 * random.signed();
            nodes.push(global([a, b, z]));
        }
        let outward = rotate([0.1, -0.1, 1.0], axis, angle);
        let frame = Frame::average_plane(&nodes[1..], outward).unwrap();
        Self { nodes, outward, frame, radius, basis }
    }

    fn element(&self) -> Element<'_> {
        Element::new(self.nodes[0], &self.nodes[1..], self.frame, self.radius).with_basis(self.basis)
    }

    fn held(&self) -> Self {
        Self { frame: self.frame.held(), ..self.clone() }
    }

    fn freedoms(&self) -> usize {
        3 * self.nodes.len()
    }

    /// The case with every node mapped and the frame made anew.
    fn mapped(&self, map: impl Fn(usize, Point) -> Point) -> Self {
        let nodes: Vec<Point> = self.nodes.iter().enumerate().map(|(i, x)| map(i, *x)).collect();
        let frame = Frame::average_plane(&nodes[1..], self.outward).unwrap();
        Self { nodes, frame, ..self.clone() }
    }

    /// The case with coordinate `freedom` moved by `step`.
    fn moved(&self, freedom: usize, step: f64) -> Self {
        self.mapped(|i, mut x| {
            if i == freedom / 3 {
                x[freedom % 3] += step;
            }
            x
        })
    }

    /// Central difference of fourth order of a vector-valued function with respect to one coordinate.
    fn difference(&self, freedom: usize, f: impl Fn(&Element<'_>) -> Vec<f64>) -> Vec<f64> {
        let step = 1e-3 * self.radius;
        let at = |steps: f64| f(&self.moved(freedom, steps * step).element());
        let [far_minus, minus, plus, far_plus] = [-2.0, -1.0, 1.0, 2.0].map(at);
        (0..plus.len())
            .map(|k| (8.0 * (plus[k] - minus[k]) - (far_plus[k] - far_minus[k])) / (12.0 * step))
            .collect()
    }

    /// ω × x about the slave, over R, by degree of freedom.
    fn spin(&self, omega: Point) -> Vec<f64> {
        let velocity = |x: &Point| cross(omega, subtract(*x, self.nodes[0]).map(|x| x / self.radius));
        self.nodes.iter().flat_map(velocity).collect()
    }
}

/// Sizes with the bases they carry.
fn sizes() -> impl Iterator<Item = (usize, Basis)> {
    (3..=24).map(|n| (n, Basis::Linear)).chain((6..=24).map(|n| (n, Basis::Quadratic)))
}

/// Elements of a few sizes at three scales, at the origin and far from it.
fn few_cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (n, basis) in sizes().filter(|(n, _)| [3, 4, 6, 9, 13].contains(n)) {
        for (seed, (radius, shift)) in [(1.0, 0.0), (1e-3, 2.0), (1e3, 5.0)].into_iter().enumerate() {
            cases.push(Case::scattered(n, basis, radius, shift, 100 + seed as u64));
        }
    }
    cases
}

/// Largest entry by size; NaN if one is.
fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |size: f64, x| if x.abs() > size || x.is_nan() { x.abs() } else { size })
}

fn difference(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    largest(&found.iter().zip(expected).map(|(x, y)| x - y).collect::<Vec<_>>())
}

/// Fails unless `error` is at most `bound`; a NaN is not.
#[track_caller]
fn assert_below(error: f64, bound: f64, what: &str) {
    assert!(error <= bound, "{what}: {error:e} > {bound:e}");
}

fn rows(matrix: &SymmetricMatrix) -> Vec<Vec<f64>> {
    matrix.to_rows()
}

fn blocks(vector: &[f64]) -> impl Iterator<Item = Point> + '_ {
    vector.chunks_exact(3).map(|x| [x[0], x[1], x[2]])
}

fn hessian(backend: &dyn Backend, case: &Case) -> Gap {
    backend.gap(&case.element(), Mode::Hessian).unwrap()
}

#[test]
fn derivatives_are_those_of_finite_differences() {
    for case in few_cases() {
        let gap = hessian(&Ad, &case);
        let size = largest(gap.hessian.packed()).max(1.0 / case.radius);
        for (j, row) in rows(&gap.hessian).iter().enumerate() {
            let slope = case.difference(j, |element| vec![Ad.gap(element, Mode::Value).unwrap().gap]);
            assert_below((slope[0] - gap.gradient[j]).abs(), 1e-8, "N");
            let column = case.difference(j, |element| Ad.gap(element, Mode::Gradient).unwrap().gradient);
            assert_below(difference(row, &column) / size, 1e-7, "M");
        }
    }
}

/// Rigid motions leave the gap alone: g(x + δ) = g(x) and g(Qx) = g(x), whence N(Qx) = Q N(x). The derivatives at
/// rest are Σ N_i = 0, Σ x_i × N_i = 0, and M (ω × x) = ω × N block by block.
#[track_caller]
fn assert_rigid_motions_are_free(case: &Case, gap: &Gap) {
    let hessian = rows(&gap.hessian);
    let size = largest(gap.hessian.packed()) * case.radius;
    for axis in 0..3 {
        let sum = |row: &[f64]| row.iter().skip(axis).step_by(3).sum::<f64>();
        assert_below(sum(&gap.gradient).abs(), 1e-12, "Σ N_i");
        for row in &hessian {
            assert_below(sum(row).abs() * case.radius, 1e-12 * size, "Σ_j M_ij");
        }
        let omega = std::array::from_fn(|k| if k == axis { 1.0 } else { 0.0 });
        let spin = case.spin(omega);
        let product = |row: &[f64]| row.iter().zip(&spin).map(|(x, y)| x * y).sum::<f64>();
        assert_below(product(&gap.gradient).abs(), 1e-12, "Σ x_i × N_i");
        let turned: Vec<f64> = blocks(&gap.gradient).flat_map(|n| cross(omega, n)).collect();
        let found: Vec<f64> = hessian.iter().map(|row| product(row) * case.radius).collect();
        assert_below(difference(&found, &turned), 1e-12 * size.max(1.0), "M (ω × x) − ω × N");
    }
}

#[test]
fn rigid_motions_are_free() {
    for case in few_cases() {
        assert_rigid_motions_are_free(&case, &hessian(&Ad, &case));
        assert_rigid_motions_are_free(&case, &hessian(&Generated, &case));
    }
}

#[test]
fn everything_turns_together() {
    for (k, case) in few_cases().into_iter().enumerate() {
        let turn = |x| rotate(x, [1.0, 0.2, -0.5], 0.7 + k as f64);
        let outward = turn(case.outward);
        let turned = Case { outward, ..case.clone() }.mapped(|_, x| turn(x));
        let turned_blocks = |x: &[f64]| -> Vec<f64> { blocks(x).flat_map(turn).collect() };
        let (gap, other) = (hessian(&Ad, &case), hessian(&Ad, &turned));
        assert_below((gap.gap - other.gap).abs() / case.radius, 1e-11, "g");
        let (expected, size) = (turned_blocks(&gap.gradient), largest(&gap.gradient));
        assert_below(difference(&other.gradient, &expected) / size, 1e-11, "N");
        // Q M Qᵀ: turn the rows, then the columns.
        let half: Vec<Vec<f64>> = rows(&gap.hessian).iter().map(|row| turned_blocks(row)).collect();
        let (other, size) = (rows(&other.hessian), largest(gap.hessian.packed()));
        for j in 0..case.freedoms() {
            let column: Vec<f64> = half.iter().map(|row| row[j]).collect();
            assert_below(difference(&other[j], &turned_blocks(&column)) / size, 1e-11, "M");
        }
    }
}

/// g over R, N and M over their largest entries.
#[track_caller]
fn assert_backends_agree(case: &Case, tolerance: f64) {
    let what = format!("n = {}, {:?}, R = {:e}", case.nodes.len() - 1, case.basis, case.radius);
    let (found, expected) = (hessian(&Generated, case), hessian(&Ad, case));
    assert_below((found.gap - expected.gap).abs() / case.radius, tolerance, &format!("g, {what}"));
    let error = difference(&found.gradient, &expected.gradient) / largest(&expected.gradient);
    assert_below(error, tolerance, &format!("N, {what}"));
    let [found, expected] = [&found, &expected].map(|gap| gap.hessian.packed());
    assert_below(difference(found, expected) / largest(expected), tolerance, &format!("M, {what}"));
}

#[test]
fn the_generated_kernels_agree_in_units_of_the_element() {
    for (n, basis) in sizes() {
        for seed in 0..3 {
            assert_backends_agree(&Case::scattered(n, basis, 1.0, 1.0, 1000 * seed + n as u64), 1e-10);
        }
    }
}

#[test]
fn the_generated_kernels_agree_in_millimetres_and_kilometres() {
    for (n, basis) in sizes().filter(|(n, _)| [3, 5, 6, 8, 12, 17].contains(n)) {
        for (radius, seed) in [(1e-3, 1), (1e-6, 2), (1e3, 3), (1e6, 4)] {
            assert_backends_agree(&Case::scattered(n, basis, radius, 1.0, seed), 1e-10);
        }
    }
}

#[test]
fn the_generated_kernels_agree_far_from_the_origin() {
    for (n, basis) in sizes().filter(|(n, _)| [3, 5, 6, 8, 12, 17].contains(n)) {
        for (radius, shift, seed) in [(1.0, 1e4, 5), (1e-3, 1e6, 6), (1e3, 1e8, 7)] {
            let case = Case::scattered(n, basis, radius, shift, seed);
            assert_backends_agree(&case, 1e-10);
            assert_rigid_motions_are_free(&case, &hessian(&Ad, &case));
        }
    }
}

#[test]
fn a_held_frame_has_the_same_gap_and_other_derivatives() {
    for case in few_cases() {
        let held = case.held();
        assert_eq!(case.frame.derivative, FrameDerivative::CoMoving);
        assert_eq!(held.frame.derivative, FrameDerivative::Held);
        for backend in [&Ad as &dyn Backend, &Generated] {
            let (moving, held) = (hessian(backend, &case), hessian(backend, &held));
            assert_below((moving.gap - held.gap).abs() / case.radius, 1e-15, "g");
            // Two kernels: the same but for rounding.
            assert_below(difference(&moving.foot, &held.foot) / case.radius, 1e-15, "foot");
            assert_below(difference(&moving.normal, &held.normal), 1e-15, "normal");
            // With three nodes the linear fit interpolates: no frame changes its plane.
            if case.nodes.len() == 4 {
                assert_below(difference(&moving.gradient, &held.gradient), 1e-12, "N");
                continue;
            }
            assert!(difference(&moving.gradient, &held.gradient) > 1e-6);
            assert!(difference(moving.hessian.packed(), held.hessian.packed()) * case.radius > 1e-4);
            let torque = |gap: &Gap| {
                let moments: Vec<Point> = blocks(&gap.gradient)
                    .zip(&case.nodes)
                    .map(|(n, x)| cross(subtract(*x, case.nodes[0]), n))
                    .collect();
                let sum: Point = std::array::from_fn(|k| moments.iter().map(|m| m[k]).sum());
                largest(&sum) / case.radius
            };
            assert!(torque(&held) > 1e-6 && torque(&moving) < 1e-12);
        }
    }
}

#[test]
fn coefficients_and_surfaces_hold_the_frame() {
    let case = Case::scattered(9, Basis::Quadratic, 1.3, 1.0, 7);
    let held = case.held();
    for backend in [&Ad as &dyn Backend, &Generated] {
        let coefficients = |case: &Case| backend.coefficients(&case.element(), Mode::Hessian).unwrap();
        assert_eq!(coefficients(&case), coefficients(&held));
        let surface = |case: &Case| backend.surface(&case.element(), [0.1, 0.2], Mode::Hessian).unwrap();
        assert_eq!(surface(&case), surface(&held));
    }
}

#[test]
fn each_mode_contains_the_ones_before_it() {
    let case = Case::scattered(9, Basis::Quadratic, 1.7, 1.0, 5);
    let [value, gradient, hessian] =
        [Mode::Value, Mode::Gradient, Mode::Hessian].map(|mode| Ad.gap(&case.element(), mode).unwrap());
    assert!(value.gradient.is_empty() && value.hessian.size() == 0 && gradient.hessian.size() == 0);
    assert_eq!((value.gap, value.foot, value.normal), (hessian.gap, hessian.foot, hessian.normal));
    assert_eq!(value.gap, Ad.gap(&case.held().element(), Mode::Value).unwrap().gap);
    assert_eq!(gradient.gradient, hessian.gradient);
}

/// Neither the in-plane axes nor their handedness matter.
#[test]
fn axes_in_the_plane_are_free() {
    let case = Case::scattered(10, Basis::Quadratic, 1.0, 1.0, 9);
    let expected = hessian(&Ad, &case);
    let Frame { t1, t2, normal, .. } = case.frame;
    let turned = |x| rotate(x, normal, 1.1);
    for (t1, t2) in [(turned(t1), turned(t2)), (t2, t1), (t1, t2.map(|x| -x))] {
        let found = hessian(&Ad, &Case { frame: Frame { t1, t2, ..case.frame }, ..case.clone() });
        assert_below((found.gap - expected.gap).abs(), 1e-14, "g");
        assert_below(difference(&found.foot, &expected.foot), 1e-14, "foot");
        assert_below(difference(&found.gradient, &expected.gradient), 1e-12, "N");
        let size = largest(expected.hessian.packed());
        assert_below(difference(found.hessian.packed(), expected.hessian.packed()) / size, 1e-12, "M");
    }
}

#[test]
fn weights_of_ones_own_move_too() {
    let case = Case::scattered(9, Basis::Quadratic, 1.0, 1.0, 41);
    let same = hessian(&Ad::with_weight_formula("1 - 3*r^2 + 2*r^3").unwrap(), &case);
    let expected = hessian(&Ad, &case);
    assert_below(difference(&same.gradient, &expected.gradient), 1e-12, "N");
    let size = largest(expected.hessian.packed());
    assert_below(difference(same.hessian.packed(), expected.hessian.packed()) / size, 1e-12, "M");
    let ad = Ad::with_weight_formula("(1 - r)^4 * (1 + 4*r)").unwrap();
    assert_rigid_motions_are_free(&case, &hessian(&ad, &case));
}

/// A plane of nodes: the frame follows it, and the gap is the distance to it.
#[test]
fn a_plane_gives_the_signed_distance() {
    for basis in [Basis::Linear, Basis::Quadratic] {
        for height in [0.4, -0.4] {
            let slope = |a: f64, b: f64| 0.3 + 0.2 * a - 0.1 * b;
            let normal = [-0.2, 0.1, 1.0].map(|x| x / 1.05f64.sqrt());
            let mut nodes = vec![std::array::from_fn(|k| [0.1, 0.2, 0.3][k] + height * normal[k])];
            for i in -2..=2 {
                for j in -2..=2 {
                    let (a, b) = (0.4 * f64::from(i), 0.4 * f64::from(j) + 0.03 * f64::from(i * i));
                    nodes.push([a, b, slope(a, b)]);
                }
            }
            let outward = [0.0, 0.0, 1.0];
            let frame = Frame::average_plane(&nodes[1..], outward).unwrap();
            let case = Case { nodes, outward, frame, radius: 1.3, basis };
            let gap = hessian(&Ad, &case);
            assert_below((gap.gap - height).abs(), 1e-14, "g");
            assert_below(difference(&gap.gradient[..3], &normal), 1e-13, "∂g/∂x^c");
            assert_rigid_motions_are_free(&case, &gap);
            assert_backends_agree(&case, 1e-10);
        }
    }
}

#[test]
fn a_frame_that_is_not_the_average_plane_is_refused() {
    let case = Case::scattered(9, Basis::Quadratic, 1.0, 1.0, 3);
    let tilted = |angle: f64| {
        let turn = |x| rotate(x, case.frame.t1, angle);
        let Frame { t1, t2, normal, .. } = case.frame;
        Case { frame: Frame { t1, t2: turn(t2), normal: turn(normal), ..case.frame }, ..case.clone() }
    };
    for backend in [&Ad as &dyn Backend, &Generated] {
        for mode in [Mode::Value, Mode::Gradient, Mode::Hessian] {
            let error = backend.gap(&tilted(1e-3).element(), mode).unwrap_err();
            let ElementError::NotAveragePlane { angle } = error else { panic!("{error:?}") };
            assert!(angle > 1e-4 && angle < 1e-2, "{angle:e}");
            assert!(backend.gap(&tilted(1e-9).element(), mode).is_ok());
            assert!(backend.gap(&tilted(1e-3).held().element(), mode).is_ok());
        }
    }
}

#[test]
fn an_unstable_plane_is_an_error() {
    // As thick as wide: the corners of a cube.
    let masters: Vec<Point> =
        (0..8).map(|i| std::array::from_fn(|k| if i >> k & 1 == 1 { 0.5 } else { -0.5 })).collect();
    let error = Frame::average_plane(&masters, [0.0, 0.0, 1.0]).unwrap_err();
    assert!(matches!(error, ElementError::NoAveragePlane { .. }), "{error:?}");
    let [t1, t2, normal] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let frame = Frame::given([0.0; 3], t1, t2, normal, None).unwrap();
    let element = Element::new(
        [0.05, 0.1, 0.2],
        &masters,
        Frame { derivative: FrameDerivative::CoMoving, ..frame },
        1.5,
    )
    .with_basis(Basis::Linear);
    for backend in [&Ad as &dyn Backend, &Generated] {
        // Whether there is a result does not depend on how many derivatives are asked for.
        for mode in [Mode::Value, Mode::Gradient, Mode::Hessian] {
            let outcome = backend.gap(&element, mode).map(|gap| gap.gap);
            assert!(
                matches!(outcome, Err(ElementError::UnstableAveragePlane { .. })),
                "{mode:?}: {outcome:?}"
            );
            let held = element.with_frame(frame);
            assert!(backend.gap(&held, mode).is_ok());
        }
    }
}
