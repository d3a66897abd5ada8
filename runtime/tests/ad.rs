//! The automatic differentiation backend against finite differences, closed forms and the identities of the
//! element.

use diffuse_contact::ad::Ad;
use diffuse_contact::{Backend, Basis, Element, ElementError, Frame, Mode, Point, SymmetricMatrix};

use crate::common::{Uniform, cross, dot, rotate};

/// A frame in general position.
fn tilted_frame() -> Frame {
    let turn = |x| rotate(x, [0.3, -1.0, 0.4], 0.7);
    let (t1, t2) = (turn([1.0, 0.0, 0.0]), turn([0.0, 1.0, 0.0]));
    Frame::given([0.0; 3], t1, t2, cross(t1, t2), None).unwrap()
}

/// Local components to global axes.
fn global(frame: &Frame, local: Point) -> Point {
    let [t1, t2, n] = frame.rows();
    std::array::from_fn(|k| t1[k] * local[0] + t2[k] * local[1] + n[k] * local[2])
}

/// An element that owns its nodes.
#[derive(Clone)]
struct Case {
    nodes: Vec<Point>,
    frame: Frame,
    radius: f64,
    basis: Basis,
}

impl Case {
    /// `n` scattered masters on a bumpy surface in a general frame, the slave near their middle.
    fn scattered(n: usize, basis: Basis, radius: f64, seed: u64) -> Self {
        let mut random = Uniform(seed);
        let frame = tilted_frame();
        let mut nodes = vec![global(&frame, [0.1 * radius, -0.05 * radius, 0.2 * radius])];
        // Spirals fill the disc of 0.95 R without putting the nodes on a conic.
        for i in 0..n {
            let r = 0.95 * radius * ((i as f64 + 0.6) / n as f64).sqrt();
            let angle = 2.4 * i as f64 + 0.2 * random.signed();
            let (a, b) = (r * angle.cos(), r * angle.sin());
            let z = 0.3 * a * a / radius - 0.2 * a * b / radius + 0.05 * radius * random.signed();
            nodes.push(global(&frame, [a, b, z]));
        }
        let shift = random.point().map(|x| 3.0 * radius * x);
        for node in &mut nodes {
            *node = std::array::from_fn(|k| node[k] + shift[k]);
        }
        Self { nodes, frame, radius, basis }
    }

    /// Masters on z = q(a, b) and a slave at local coordinates `slave`.
    fn on_quadratic(q: impl Fn(f64, f64) -> f64, slave: Point, radius: f64) -> Self {
        let frame = tilted_frame();
        let mut nodes = vec![global(&frame, slave)];
        for i in -2..=2 {
            for j in -2..=2 {
                let (a, b) = (0.4 * f64::from(i), 0.4 * f64::from(j) + 0.03 * f64::from(i * i));
                nodes.push(global(&frame, [a, b, q(a, b)]));
            }
        }
        Self { nodes, frame, radius, basis: Basis::Quadratic }
    }

    fn element(&self) -> Element<'_> {
        Element::new(self.nodes[0], &self.nodes[1..], self.frame, self.radius).with_basis(self.basis)
    }

    fn freedoms(&self) -> usize {
        3 * self.nodes.len()
    }

    /// The case with coordinate `freedom` moved by `step`.
    fn moved(&self, freedom: usize, step: f64) -> Self {
        let mut case = self.clone();
        case.nodes[freedom / 3][freedom % 3] += step;
        case
    }

    /// Central difference of a vector-valued function with respect to one coordinate.
    fn difference(&self, freedom: usize, f: impl Fn(&Element<'_>) -> Vec<f64>) -> Vec<f64> {
        let step = 1e-5 * self.radius;
        let plus = f(&self.moved(freedom, step).element());
        let minus = f(&self.moved(freedom, -step).element());
        plus.iter().zip(minus).map(|(plus, minus)| (plus - minus) / (2.0 * step)).collect()
    }
}

/// Largest entry by size.
fn largest<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().fold(0.0, |size, x| x.abs().max(size))
}

#[track_caller]
fn assert_close(found: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!((found - expected).abs() <= tolerance, "{what}, entry {i}: {found} {expected}");
    }
}

fn row(matrix: &SymmetricMatrix, i: usize) -> Vec<f64> {
    (0..matrix.size()).map(|j| matrix.get(i, j)).collect()
}

fn scattered_cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (seed, radius) in [(1, 1.0), (2, 1e-3), (3, 2.5e3)] {
        for n in [6, 9, 14] {
            cases.push(Case::scattered(n, Basis::Quadratic, radius, seed));
        }
        cases.push(Case::scattered(3, Basis::Linear, radius, seed));
        cases.push(Case::scattered(7, Basis::Linear, radius, seed));
    }
    cases
}

#[test]
fn gap_derivatives_are_those_of_finite_differences() {
    for case in scattered_cases() {
        let gap = Ad.gap(&case.element(), Mode::Hessian).unwrap();
        assert!(gap.gap.is_finite() && gap.hessian.size() == case.freedoms());
        let size = largest(gap.hessian.packed()).max(1.0 / case.radius);
        for j in 0..case.freedoms() {
            let slope = case.difference(j, |element| vec![Ad.gap(element, Mode::Value).unwrap().gap]);
            assert_close(&slope, &[gap.gradient[j]], 2e-7, "gradient");
            let column = case.difference(j, |element| Ad.gap(element, Mode::Gradient).unwrap().gradient);
            assert_close(&row(&gap.hessian, j), &column, 1e-6 * size, "Hessian");
        }
    }
}

#[test]
fn surface_derivatives_are_those_of_finite_differences() {
    for case in scattered_cases() {
        let point = [0.11 * case.radius, 0.23 * case.radius];
        let surface = Ad.surface(&case.element(), point, Mode::Hessian).unwrap();
        let size = largest(surface.hessian.packed()).max(1.0 / case.radius);
        for j in 0..case.freedoms() {
            let slopes = case.difference(j, |element| {
                let surface = Ad.surface(element, point, Mode::Value).unwrap();
                vec![surface.value, surface.slopes[0] * case.radius, surface.slopes[1] * case.radius]
            });
            let found = [
                surface.gradient[j],
                surface.slope_gradients[0][j] * case.radius,
                surface.slope_gradients[1][j] * case.radius,
            ];
            assert_close(&found, &slopes, 1e-6, "surface gradients");
            let column =
                case.difference(j, |element| Ad.surface(element, point, Mode::Gradient).unwrap().gradient);
            assert_close(&row(&surface.hessian, j), &column, 1e-6 * size, "surface Hessian");
        }
        // Slopes and curvatures are the derivatives of the value in the plane.
        let step = 1e-3 * case.radius;
        let value = |a: f64, b: f64| {
            let at = [point[0] + a * step, point[1] + b * step];
            Ad.surface(&case.element(), at, Mode::Value).unwrap()
        };
        let slope = (value(1.0, 0.0).value - value(-1.0, 0.0).value) / (2.0 * step);
        assert!((slope - surface.slopes[0]).abs() < 1e-11);
        let curvature = (value(0.0, 1.0).slopes[1] - value(0.0, -1.0).slopes[1]) / (2.0 * step);
        assert!((curvature - surface.curvatures[2]).abs() * case.radius < 1e-11);
        let twist = (value(0.0, 1.0).slopes[0] - value(0.0, -1.0).slopes[0]) / (2.0 * step);
        assert!((twist - surface.curvatures[1]).abs() * case.radius < 1e-11);
    }
}

#[test]
fn coefficient_derivatives_are_those_of_finite_differences() {
    for case in [
        Case::scattered(8, Basis::Quadratic, 1.0, 11),
        Case::scattered(8, Basis::Quadratic, 40.0, 12),
        Case::scattered(5, Basis::Linear, 0.02, 13),
    ] {
        let fit = Ad.coefficients(&case.element(), Mode::Hessian).unwrap();
        assert_eq!(fit.values, Ad.gap(&case.element(), Mode::Value).unwrap().coefficients);
        for j in 0..case.freedoms() {
            let slopes = case.difference(j, |element| Ad.coefficients(element, Mode::Value).unwrap().values);
            for (k, slope) in slopes.iter().enumerate() {
                let size = largest(&fit.gradients[k]);
                assert!((fit.gradients[k][j] - slope).abs() < 1e-6 * size, "gradient of α_{k}");
                let column = case.difference(j, |element| {
                    Ad.coefficients(element, Mode::Gradient).unwrap().gradients.swap_remove(k)
                });
                let size = largest(fit.hessians[k].packed());
                assert_close(&row(&fit.hessians[k], j), &column, 1e-6 * size, "Hessian of α");
            }
        }
    }
}

#[test]
fn each_mode_contains_the_ones_before_it() {
    let case = Case::scattered(9, Basis::Quadratic, 1.7, 5);
    let [value, gradient, hessian] =
        [Mode::Value, Mode::Gradient, Mode::Hessian].map(|mode| Ad.gap(&case.element(), mode).unwrap());
    assert!(value.gradient.is_empty() && value.hessian.size() == 0 && gradient.hessian.size() == 0);
    assert_eq!((value.gap, value.foot, value.normal), (hessian.gap, hessian.foot, hessian.normal));
    assert_eq!(gradient.gradient, hessian.gradient);
    let fit = Ad.coefficients(&case.element(), Mode::Value).unwrap();
    assert!(fit.gradients.is_empty() && fit.hessians.is_empty());
    let surface = Ad.surface(&case.element(), [0.1, 0.2], Mode::Value).unwrap();
    assert!(surface.gradient.is_empty() && surface.slope_gradients.iter().all(Vec::is_empty));
    assert_eq!(surface.hessian.size(), 0);
    assert_eq!(Ad.surface(&case.element(), [0.1, 0.2], Mode::Gradient).unwrap().hessian.size(), 0);
}

#[test]
fn translations_change_nothing() {
    for case in scattered_cases() {
        let gap = Ad.gap(&case.element(), Mode::Hessian).unwrap();
        let size = largest(gap.hessian.packed());
        for axis in 0..3 {
            let sum: f64 = gap.gradient.iter().skip(axis).step_by(3).sum();
            assert!(sum.abs() < 1e-12, "Σ N_i = {sum:e}");
            for i in 0..case.freedoms() {
                let sum: f64 = row(&gap.hessian, i).iter().skip(axis).step_by(3).sum();
                assert!(sum.abs() < 1e-12 * size, "Σ_j M_ij = {:e}", sum / size);
            }
        }
    }
}

#[test]
fn everything_turns_together() {
    let turn = |x| rotate(x, [1.0, 0.2, -0.5], 1.3);
    let case = Case::scattered(10, Basis::Quadratic, 1.2, 21);
    let mut turned = case.clone();
    turned.nodes.iter_mut().for_each(|x| *x = turn(*x));
    let [t1, t2, n] = case.frame.rows().map(turn);
    turned.frame = Frame::given([0.0; 3], t1, t2, n, None).unwrap();
    let gap = Ad.gap(&case.element(), Mode::Hessian).unwrap();
    let other = Ad.gap(&turned.element(), Mode::Hessian).unwrap();
    assert!((gap.gap - other.gap).abs() < 1e-13);
    assert_close(&turn(gap.foot), &other.foot, 1e-13, "foot");
    assert_close(&turn(gap.normal), &other.normal, 1e-13, "normal");
    let rows =
        |vector: &[f64]| -> Vec<f64> { vector.chunks(3).flat_map(|x| turn([x[0], x[1], x[2]])).collect() };
    assert_close(&rows(&gap.gradient), &other.gradient, 1e-12, "gradient");
    // Q M Qᵀ: turn the columns, then the rows.
    let half: Vec<Vec<f64>> = gap.hessian.to_rows().iter().map(|row| rows(row)).collect();
    let size = largest(gap.hessian.packed());
    for j in 0..case.freedoms() {
        let column: Vec<f64> = half.iter().map(|row| row[j]).collect();
        assert_close(&rows(&column), &row(&other.hessian, j), 1e-12 * size, "Hessian");
    }
}

#[test]
fn a_plane_gives_the_signed_distance() {
    for basis in [Basis::Linear, Basis::Quadratic] {
        for height in [0.4, -0.4] {
            let mut case = Case::on_quadratic(|a, b| 0.3 + 0.2 * a - 0.1 * b, [0.0; 3], 1.3);
            case.basis = basis;
            let normal = global(&case.frame, [-0.2, 0.1, 1.0].map(|x| x / 1.05f64.sqrt()));
            let foot = global(&case.frame, [0.1, 0.2, 0.3 + 0.02 - 0.02]);
            case.nodes[0] = std::array::from_fn(|k| foot[k] + height * normal[k]);
            let gap = Ad.gap(&case.element(), Mode::Hessian).unwrap();
            assert!((gap.gap - height).abs() < 1e-14);
            assert_eq!(gap.is_penetrating(), height < 0.0);
            assert_close(&gap.foot, &foot, 1e-14, "foot");
            assert_close(&gap.normal, &normal, 1e-14, "normal");
            assert_close(&gap.gradient[..3], &normal, 1e-13, "∂g/∂x^c");
            for i in 0..3 {
                assert_close(&row(&gap.hessian, i)[..3], &[0.0; 3], 1e-12, "∂²g/∂x^c∂x^c");
            }
        }
    }
}

/// A quadratic surface is reproduced exactly whatever the weights: the gap is the distance to it, its
/// derivatives with respect to the slave are the normal and the Hessian of the distance.
#[test]
fn a_quadratic_surface_is_reproduced() {
    let c = [0.05, 0.1, -0.2, 0.3, 0.15, -0.25];
    let q = |a: f64, b: f64| c[0] + c[1] * a + c[2] * b + c[3] * a * a + c[4] * a * b + c[5] * b * b;
    let slopes = |a: f64, b: f64| [c[1] + 2.0 * c[3] * a + c[4] * b, c[2] + c[4] * a + 2.0 * c[5] * b];
    for distance in [0.5, 0.0, -0.3] {
        let (a, b) = (0.17, -0.09);
        let [f_1, f_2] = slopes(a, b);
        let length = (1.0 + f_1 * f_1 + f_2 * f_2).sqrt();
        let nu = [-f_1 / length, -f_2 / length, 1.0 / length];
        let slave = [a + distance * nu[0], b + distance * nu[1], q(a, b) + distance * nu[2]];
        let case = Case::on_quadratic(q, slave, 1.4);
        let gap = Ad.gap(&case.element(), Mode::Hessian).unwrap();
        assert!((gap.gap - distance).abs() < 1e-13, "{} {distance}", gap.gap);
        assert_close(&gap.foot, &global(&case.frame, [a, b, q(a, b)]), 1e-13, "foot");
        let normal = global(&case.frame, nu);
        assert_close(&gap.normal, &normal, 1e-13, "normal");
        assert_close(&gap.gradient[..3], &normal, 1e-12, "∂g/∂x^c");

        // q about the slave's projection.
        let [a, b, z] = slave;
        let [q_1, q_2] = slopes(a, b);
        let expected = [q(a, b) - z, q_1, q_2, c[3], c[4], c[5]];
        assert_close(&gap.coefficients, &expected, 1e-13, "coefficients");
        let surface = Ad.surface(&case.element(), [0.2, 0.3], Mode::Value).unwrap();
        assert!((surface.value - (q(a + 0.2, b + 0.3) - z)).abs() < 1e-13);
        assert_close(&surface.slopes, &slopes(a + 0.2, b + 0.3), 1e-13, "slopes");
        assert_close(&surface.curvatures, &[2.0 * c[3], c[4], 2.0 * c[5]], 1e-12, "curvatures");

        // The ∂/∂z part of the masters' N sums to −1/ℓ.
        let n = case.frame.normal;
        let sum: f64 = gap.gradient[3..].chunks(3).map(|x| dot([x[0], x[1], x[2]], n)).sum();
        assert!((sum + 1.0 / length).abs() < 1e-12);
    }
}

#[test]
fn distance_to_a_paraboloid_has_the_known_hessian() {
    // z = κ(a² + b²)/2, slave on the axis at height d: −κ/(1 − κd) in the two directions of the plane.
    let kappa = 0.8;
    for d in [0.5, -0.7] {
        let case = Case::on_quadratic(|a, b| 0.5 * kappa * (a * a + b * b), [0.0, 0.0, d], 1.4);
        let gap = Ad.gap(&case.element(), Mode::Hessian).unwrap();
        assert!((gap.gap - d).abs() < 1e-14);
        let expected = -kappa / (1.0 - kappa * d);
        let n = case.frame.normal;
        for i in 0..3 {
            for j in 0..3 {
                let projector = f64::from(i == j) - n[i] * n[j];
                assert!((gap.hessian.get(i, j) - expected * projector).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn a_slave_on_the_centre_of_curvature_has_no_gap() {
    let case = Case::on_quadratic(|a, b| 0.4 * (a * a + b * b), [0.0, 0.0, 1.25], 1.4);
    let error = Ad.gap(&case.element(), Mode::Value).unwrap_err();
    assert!(matches!(error, ElementError::CentreOfCurvature { .. }), "{error:?}");
    // One principal curvature is enough.
    let case = Case::on_quadratic(|a, b| 0.4 * a * a + 0.1 * b * b, [0.0, 0.0, 1.25], 1.4);
    let error = Ad.gap(&case.element(), Mode::Hessian).unwrap_err();
    assert!(matches!(error, ElementError::CentreOfCurvature { .. }), "{error:?}");
    // The surface itself exists.
    assert!(Ad.surface(&case.element(), [0.0; 2], Mode::Hessian).is_ok());
}

#[test]
fn a_foot_outside_the_support_is_reported() {
    let case = Case::on_quadratic(|a, _| a, [0.0, 0.0, 4.0], 1.4);
    let error = Ad.gap(&case.element(), Mode::Value).unwrap_err();
    let ElementError::FootOutside { distance } = error else { panic!("{error:?}") };
    assert!((distance - 2.0 / 1.4).abs() < 1e-12);
}

#[test]
fn input_is_checked_first() {
    let case = Case::scattered(9, Basis::Quadratic, 1.0, 1);
    for (freedom, what, index) in [(2, "slave", 0), (3, "master", 0), (3 * 9, "master", 8)] {
        for bad in [f64::NAN, f64::INFINITY] {
            let error = Ad.gap(&case.moved(freedom, bad).element(), Mode::Hessian).unwrap_err();
            assert_eq!(error, ElementError::NonFiniteInput { what, index });
        }
    }
    let error = Ad.surface(&case.element(), [0.0, f64::NAN], Mode::Value).unwrap_err();
    assert_eq!(error, ElementError::NonFiniteInput { what: "point", index: 1 });
    let few = Case { nodes: case.nodes[..6].to_vec(), ..case.clone() };
    let error = Ad.coefficients(&few.element(), Mode::Value).unwrap_err();
    assert_eq!(error, ElementError::TooFewNodes { found: 5, needed: 6 });
    let point = Case { radius: 0.0, ..case };
    let error = Ad.gap(&point.element(), Mode::Value).unwrap_err();
    assert_eq!(error, ElementError::InvalidSupportRadius { value: 0.0 });
}

#[test]
fn what_overflows_is_an_error() {
    let case = Case::scattered(9, Basis::Quadratic, 1.0, 1);
    // A master so high that the height's square overflows; a radius so small that 1/R² does.
    let high = case.moved(5, 1e300);
    let far = case.moved(4, 1.7e308);
    let scale = |factor: f64| {
        let mut scaled = case.clone();
        scaled.nodes.iter_mut().for_each(|x| *x = x.map(|x| x * factor));
        scaled.radius *= factor;
        scaled
    };
    for mode in [Mode::Value, Mode::Gradient, Mode::Hessian] {
        for case in [&high, &far] {
            if let Ok(gap) = Ad.gap(&case.element(), mode) {
                assert!(gap.gap.is_finite() && gap.hessian.packed().iter().all(|x| x.is_finite()));
            }
        }
    }
    let error = Ad.coefficients(&scale(1e-160).element(), Mode::Hessian).unwrap_err();
    assert!(matches!(error, ElementError::Overflow { .. }));
    // Lengths of any ordinary size are no reason.
    for factor in [1e-90, 1e90] {
        let gap = Ad.gap(&scale(factor).element(), Mode::Hessian).unwrap();
        let reference = Ad.gap(&case.element(), Mode::Hessian).unwrap();
        assert!((gap.gap / factor - reference.gap).abs() < 1e-13);
        assert_close(&gap.gradient, &reference.gradient, 1e-12, "gradient");
    }
}

#[test]
fn a_slave_straight_above_a_node() {
    let case = Case::scattered(12, Basis::Quadratic, 1.0, 31);
    let [t1, t2, n] = case.frame.rows();
    // The slave over master 3, moved in the plane by r.
    let above = |r: f64| {
        let mut case = case.clone();
        let node = case.nodes[3];
        case.nodes[0] = std::array::from_fn(|k| node[k] + r * (0.6 * t1[k] + 0.8 * t2[k]) + 0.2 * n[k]);
        case
    };
    let at_node = Ad.gap(&above(0.0).element(), Mode::Hessian).unwrap();
    let size = largest(at_node.hessian.packed());
    for r in [1e-150, 1e-12, 1e-8, 1e-5] {
        let near = Ad.gap(&above(r).element(), Mode::Hessian).unwrap();
        assert_close(&near.gradient, &at_node.gradient, 1e2 * r + 1e-13, "gradient");
        assert_close(near.hessian.packed(), at_node.hessian.packed(), (1e3 * r + 1e-12) * size, "Hessian");
    }
    // The same weight in a form whose slope cancels at small r, on both sides of where the series ends.
    let factored = Ad::with_weight_formula("(1 - r)^2 * (1 + 2*r)").unwrap();
    for r in [0.0, 1e-9, 1e-4, 9.9e-3, 1.01e-2, 0.1] {
        let case = above(r);
        let reference = Ad.gap(&case.element(), Mode::Hessian).unwrap();
        let found = factored.gap(&case.element(), Mode::Hessian).unwrap();
        assert_close(&found.gradient, &reference.gradient, 1e-12, "gradient");
        assert_close(found.hessian.packed(), reference.hessian.packed(), 1e-12 * size, "Hessian");
    }
}

#[test]
fn weights_of_ones_own() {
    let case = Case::scattered(9, Basis::Quadratic, 1.0, 41);
    for formula in [
        "(1 - r)^4 * (1 + 4*r)",
        "exp(-4*r^2) * (1 - r^2)^2",
        "if r < 0.5 { 1 - 6*r^2 + 6*r^3 } else { 2*(1 - r)^3 }",
        "sqrt(1 - r^2)^3 / (1 + r^2)",
    ] {
        let ad = Ad::with_weight_formula(formula).unwrap();
        let gap = ad.gap(&case.element(), Mode::Hessian).unwrap();
        let size = largest(gap.hessian.packed());
        for j in 0..case.freedoms() {
            let slope = case.difference(j, |element| vec![ad.gap(element, Mode::Value).unwrap().gap]);
            assert_close(&slope, &[gap.gradient[j]], 2e-7, formula);
            let column = case.difference(j, |element| ad.gap(element, Mode::Gradient).unwrap().gradient);
            assert_close(&row(&gap.hessian, j), &column, 1e-6 * size, formula);
        }
    }
    // A weight that is no number inside the support yields an error, never a NaN.
    let ad = Ad::with_weight_formula("sqrt(0.2 - r^2)").unwrap();
    let error = ad.gap(&case.element(), Mode::Hessian).unwrap_err();
    assert_eq!(error, ElementError::Overflow { what: "weight" });
}

#[test]
fn many_masters() {
    let case = Case::scattered(70, Basis::Quadratic, 1.0, 51);
    let gap = Ad.gap(&case.element(), Mode::Hessian).unwrap();
    assert_eq!(gap.hessian.size(), 3 * 71);
    let size = largest(gap.hessian.packed());
    for i in [0, 100, 212] {
        let sum: f64 = row(&gap.hessian, i).iter().skip(1).step_by(3).sum();
        assert!(sum.abs() < 1e-12 * size);
    }
}

/// The three outputs of an element with masters in the plane z = 0 and a slave a little above it, or the
/// errors they end in.
fn outcomes(
    masters: &[[f64; 2]],
    slave: [f64; 2],
    basis: Basis,
    mode: Mode,
) -> [Result<(), ElementError>; 3] {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let masters: Vec<_> = masters.iter().map(|[a, b]| [*a, *b, 0.0]).collect();
    let element = Element::new(
        [slave[0], slave[1], 0.1],
        &masters,
        Frame::given([0.0; 3], axes[0], axes[1], axes[2], None).unwrap(),
        3.0,
    )
    .with_basis(basis);
    [
        Ad.gap(&element, mode).map(|_| ()),
        Ad.coefficients(&element, mode).map(|_| ()),
        Ad.surface(&element, [0.0; 2], mode).map(|_| ()),
    ]
}

#[test]
fn degenerate_layouts_are_singular() {
    let hexagon: Vec<_> = (0..6)
        .map(|i| {
            let (s, c) = (f64::from(i) * std::f64::consts::FRAC_PI_3).sin_cos();
            [c, s]
        })
        .collect();
    let strip: Vec<_> = (0..8).map(|i| [0.5 * f64::from(i % 4), f64::from(i / 4)]).collect();
    let line: Vec<_> = (0..5).map(|i| [0.3 * f64::from(i), 0.1 + 0.2 * f64::from(i)]).collect();
    for (masters, basis) in [
        (&hexagon, Basis::Quadratic),
        (&strip, Basis::Quadratic),
        (&line, Basis::Linear),
        (&vec![[10.0, 0.0]; 6], Basis::Quadratic),
        (&vec![[0.2, 0.1]; 4], Basis::Linear),
    ] {
        for slave in [[0.0, 0.0], [0.31, 0.17]] {
            for mode in [Mode::Value, Mode::Hessian] {
                for outcome in outcomes(masters, slave, basis, mode) {
                    let Err(ElementError::SingularFit { pivot_ratio, tolerance }) = outcome else {
                        panic!("{outcome:?}")
                    };
                    assert!(pivot_ratio.abs() < 1e-13 && tolerance == 1e-7);
                }
            }
        }
    }
    // The same nodes carry the linear basis.
    for masters in [hexagon, strip] {
        let outcomes = outcomes(&masters, [0.1, 0.2], Basis::Linear, Mode::Hessian);
        assert!(outcomes.iter().all(Result::is_ok));
    }
}
