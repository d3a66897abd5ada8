//! The elements of a fixed size that the kernels are made of: emitted kernel, interpreter and automatic differentiation of models
//! written independently.

#[path = "../../generated/elements.rs"]
#[allow(dead_code, reason = "the configuration is for the build script")]
pub mod formulas;

use diffuse_contact::ad::Ad;
use diffuse_contact::{FacetElement, Generated, Slip};
use diffuse_contact_codegen::interpret::{Interpreter, NodeInputs};
use diffuse_contact_codegen::{ElementKernels, ElementModel, Mode};
use diffuse_contact_kernels::{
    carried_by_quadrilateral, carried_by_quadrilateral8, carried_by_quadrilateral9, carried_by_triangle,
    carried_by_triangle6, coulomb, coulomb_sliding, decaying_coefficient, direction, foot_of_gap,
    friction_over_pressure, interpolated, load_of_point, support, traction, traction_sliding,
};
use num_dual::{Dual64, DualNum};

/// Relative difference that is rounding.
const ROUNDING: f64 = 1e-12;

/// Entries of a value and of its Jacobian by the interpreter, at inputs in the order of their declaration.
fn interpreted(formulas: impl Fn(&ElementModel<'_>), inputs: &[f64], value: &str) -> [Vec<f64>; 2] {
    results_of_graph(formulas, Mode::Gradient, inputs, [value, &format!("{value}_jacobian")])
}

/// Entries of results by the interpreter.
pub fn results_of_graph<const N: usize>(
    formulas: impl Fn(&ElementModel<'_>),
    mode: Mode,
    inputs: &[f64],
    names: [&str; N],
) -> [Vec<f64>; N] {
    let element = ElementKernels::new("test", formulas).unwrap();
    let mut nodes = NodeInputs::new(0);
    let symbols = element.signature.inputs.iter().flat_map(|input| &input.symbols);
    symbols.zip(inputs).for_each(|(name, &x)| nodes.set_element(name, x));
    let kernel = element.kernels.iter().find(|kernel| kernel.spec.mode == mode).unwrap();
    let mut interpreter = Interpreter::new(&kernel.graph, &nodes);
    names.map(|name| {
        let value = kernel.values.iter().find(|v| v.name == name).unwrap();
        value.components.iter().map(|x| interpreter.element(*x)).collect()
    })
}

/// Values of a function and their derivatives by its first `variables` arguments.
fn by_duals(inputs: &[f64], variables: usize, f: impl Fn(&[Dual64]) -> Vec<Dual64>) -> [Vec<f64>; 2] {
    let seeded = |variable: usize| {
        let dual = |(k, &x): (usize, &f64)| Dual64::new(x, f64::from(u8::from(k == variable)));
        f(&inputs.iter().enumerate().map(dual).collect::<Vec<_>>())
    };
    let by_variable: Vec<Vec<Dual64>> = (0..variables).map(seeded).collect();
    let rows = 0..by_variable[0].len();
    let jacobian = rows.flat_map(|row| by_variable.iter().map(move |values| values[row].eps)).collect();
    [by_variable[0].iter().map(|x| x.re).collect(), jacobian]
}

pub fn assert_close(found: &[f64], expected: &[f64], what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let largest = expected.iter().fold(1.0, |largest: f64, x| largest.max(x.abs()));
    for (k, (x, y)) in found.iter().zip(expected).enumerate() {
        assert!((x - y).abs() < ROUNDING * largest, "{what}, entry {k}: {x} {y}");
    }
}

/// What the corners of a facet carry of a force, by Newton's iteration for the place and the distance along the line together.
fn parts(x: &[Dual64], functions: impl Fn(Dual64, Dual64) -> Vec<Dual64>) -> Vec<Dual64> {
    let number = Dual64::from;
    let (point, force, corners) = (&x[..3], &x[3..6], &x[6..]);
    let count = corners.len() / 3;
    let position = |s, t| {
        let n = functions(s, t);
        [0, 1, 2].map(|i| (0..count).fold(number(0.0), |sum, k| sum + n[k] * corners[3 * k + i]))
    };
    let (mut s, mut t, mut distance) = (number(0.3), number(0.3), number(0.0));
    for _ in 0..60 {
        // Facets are at most quadratic in either coordinate: central differences are derivatives.
        let here = position(s, t);
        let half = number(0.5);
        let difference = |after: [Dual64; 3], before: [Dual64; 3]| [0, 1, 2].map(|i| after[i] - before[i]);
        let columns = [
            difference(position(s + half, t), position(s - half, t)),
            difference(position(s, t + half), position(s, t - half)),
            [0, 1, 2].map(|i| -force[i]),
        ];
        let right = [0, 1, 2].map(|i| point[i] + distance * force[i] - here[i]);
        let det = |a: [[Dual64; 3]; 3]| {
            let minor = |i: usize, j: usize| a[1][i] * a[2][j] - a[1][j] * a[2][i];
            a[0][0] * minor(1, 2) - a[0][1] * minor(0, 2) + a[0][2] * minor(0, 1)
        };
        let step = [0, 1, 2].map(|k| {
            let mut replaced = columns;
            replaced[k] = right;
            det(replaced) / det(columns)
        });
        (s, t, distance) = (s + step[0], t + step[1], distance + step[2]);
    }
    functions(s, t).into_iter().flat_map(|n| [0, 1, 2].map(|i| n * force[i])).collect()
}

fn numbers(count: usize, seed: f64) -> Vec<f64> {
    (0..count).map(|k| (12.9898 * (k as f64 + seed)).sin()).collect()
}

/// A line above a square, all of it shaken.
fn line_and_corners(corners: &[[f64; 3]], seed: f64) -> Vec<f64> {
    let all = [&[[0.4, 0.3, 0.8], [0.1, -0.2, 0.9]], corners].concat();
    let numbers = numbers(3 * all.len(), seed);
    all.as_flattened().iter().zip(numbers).map(|(x, random)| x + 0.1 * random).collect()
}

/// Runs an emitted kernel: values and Jacobian of the parts.
macro_rules! emitted {
    ($kernel:ident, $inputs:expr) => {{
        let mut inputs = $kernel::Inputs { point: [0.0; 3], force: [0.0; 3], corners: Default::default() };
        let rows = $inputs.as_chunks::<3>().0;
        (inputs.point, inputs.force) = (rows[0], rows[1]);
        inputs.corners.copy_from_slice(&rows[2..]);
        let results = $kernel::evaluate(support::Mode::Gradient, &inputs);
        [results.values.parts.as_flattened().to_vec(), results.parts_jacobian.to_vec()]
    }};
}

#[test]
fn forces_carried_by_facets_have_three_witnesses() {
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [1.1, 1.0, 0.3], [0.0, 0.9, -0.1]];
    for seed in [0.31, 0.57, 0.83] {
        let inputs = line_and_corners(&square, seed);
        let one = |x: Dual64| Dual64::from(1.0) - x;
        let bilinear = |s: Dual64, t: Dual64| vec![one(s) * one(t), s * one(t), s * t, one(s) * t];
        let expected = by_duals(&inputs, 18, |x| parts(x, bilinear));
        let of_graph = interpreted(formulas::carried_by_quadrilateral, &inputs, "parts");
        let of_kernel = emitted!(carried_by_quadrilateral, inputs);
        for (k, what) in ["parts of a quadrilateral", "their derivatives"].into_iter().enumerate() {
            assert_close(&of_graph[k], &expected[k], what);
            assert_close(&of_kernel[k], &expected[k], what);
        }

        let inputs = line_and_corners(&square[..3], seed);
        let linear = |s: Dual64, t: Dual64| vec![one(s) - t, s, t];
        let expected = by_duals(&inputs, 15, |x| parts(x, linear));
        let of_graph = interpreted(formulas::carried_by_triangle, &inputs, "parts");
        let of_kernel = emitted!(carried_by_triangle, inputs);
        for (k, what) in ["parts of a triangle", "their derivatives"].into_iter().enumerate() {
            assert_close(&of_graph[k], &expected[k], what);
            assert_close(&of_kernel[k], &expected[k], what);
        }
    }
}

/// Nodes of a face of second order: corners, middles of its edges, centre.
fn with_middles(corners: &[[f64; 3]], count: usize) -> Vec<[f64; 3]> {
    let mean = |of: &[[f64; 3]]| [0, 1, 2].map(|i| of.iter().map(|x| x[i]).sum::<f64>() / of.len() as f64);
    let mut nodes = corners.to_vec();
    for k in 0..corners.len() {
        nodes.push(mean(&[corners[k], corners[(k + 1) % corners.len()]]));
    }
    nodes.push(mean(corners));
    nodes.truncate(count);
    nodes
}

#[test]
fn forces_carried_by_faces_of_second_order_have_three_witnesses() {
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [1.1, 1.0, 0.3], [0.0, 0.9, -0.1]];
    let number = Dual64::from;
    /// Compares the witnesses of a kernel.
    macro_rules! compare {
        ($kernel:ident, $inputs:expr, $start:expr, $functions:expr) => {{
            let inputs: &[f64] = $inputs;
            let expected = by_duals(inputs, inputs.len(), |x| parts(x, $functions));
            let all = [inputs, &$start[..]].concat();
            let of_graph = interpreted(formulas::$kernel, &all, "parts");
            let mut of_kernel = $kernel::Inputs {
                point: [0.0; 3],
                force: [0.0; 3],
                corners: Default::default(),
                start_xi: $start[0],
                start_eta: $start[1],
            };
            let rows = inputs.as_chunks::<3>().0;
            (of_kernel.point, of_kernel.force) = (rows[0], rows[1]);
            of_kernel.corners.copy_from_slice(&rows[2..]);
            let results = $kernel::evaluate(support::Mode::Gradient, &of_kernel);
            let of_kernel = [results.values.parts.as_flattened().to_vec(), results.parts_jacobian.to_vec()];
            for (k, what) in [stringify!($kernel), "its derivatives"].into_iter().enumerate() {
                assert_close(&of_graph[k], &expected[k], what);
                assert_close(&of_kernel[k], &expected[k], what);
            }
        }};
    }
    for seed in [0.31, 0.57, 0.83] {
        let shaken = |count: usize, corners: usize| {
            let nodes = with_middles(&square[..corners], count);
            let all = [&[[0.4, 0.3, 0.8], [0.1, -0.2, 0.9]], &nodes[..]].concat();
            let random = numbers(3 * all.len(), seed);
            all.as_flattened().iter().zip(random).map(|(x, random)| x + 0.05 * random).collect::<Vec<f64>>()
        };
        let (one, two, four) = (number(1.0), number(2.0), number(4.0));
        let of_triangle = |s: Dual64, t: Dual64| {
            let r = one - s - t;
            let corner = |x: Dual64| x * (two * x - one);
            vec![corner(r), corner(s), corner(t), four * r * s, four * s * t, four * t * r]
        };
        compare!(carried_by_triangle6, &shaken(6, 3), [0.35, 0.25], of_triangle);
        // As products of the quadratic functions of a line, of which one without a centre takes a quarter's and two quarters' share.
        let line = |x: Dual64| [(x * x - x) / two, one - x * x, (x * x + x) / two];
        let places = [[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1], [1, 1]];
        let nine = |s: Dual64, t: Dual64| {
            let (of_s, of_t) = (line(s), line(t));
            places.iter().map(|&[i, j]| of_s[i] * of_t[j]).collect::<Vec<_>>()
        };
        let eight = |s: Dual64, t: Dual64| {
            let all = nine(s, t);
            let share = |k: usize| if k < 4 { -all[8] / four } else { all[8] / two };
            (0..8).map(|k| all[k] + share(k)).collect::<Vec<_>>()
        };
        compare!(carried_by_quadrilateral8, &shaken(8, 4), [-0.2, -0.4], eight);
        compare!(carried_by_quadrilateral9, &shaken(9, 4), [-0.2, -0.4], nine);
    }
}

/// With the slave over the facet and beyond an edge, and without any slip.
#[test]
fn the_slip_over_a_facet_has_three_witnesses() {
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [1.1, 1.0, 0.3], [0.0, 0.9, -0.1]];
    let cases = [([0.4, 0.3, -0.1], [0.5, 0.1, 0.4]), ([1.2, 0.4, 0.3], [-0.4, 0.9, 0.0])];
    for (slave, anchor) in cases.into_iter().chain([([0.3, 0.2, 0.1], [0.3, 0.2, 0.1])]) {
        for corners in [&square[..3], &square] {
            let element = FacetElement { slave, corners };
            let points = [&[slave], corners, &[anchor]].concat();
            let inputs = points.as_flattened();
            let names = ["energy", "gradient", "hessian"];
            let of_graph = if corners.len() == 3 {
                results_of_graph(formulas::slip_over_triangle, Mode::Hessian, inputs, names)
            } else {
                results_of_graph(formulas::slip_over_quadrilateral, Mode::Hessian, inputs, names)
            };
            let entries = |Slip { half_square, gradient, hessian, .. }: Slip| {
                [vec![half_square], gradient, hessian.packed().to_vec()]
            };
            let of_kernel = entries(Generated.facet_slip(&element, anchor, support::Mode::Hessian).unwrap());
            let expected = entries(Ad.facet_slip(&element, anchor, support::Mode::Hessian).unwrap());
            for (k, what) in ["q", "∇q", "∇²q"].into_iter().enumerate() {
                assert_close(&of_graph[k], &expected[k], what);
                assert_close(&of_kernel[k], &expected[k], what);
            }
        }
    }
}

/// In stick, in slip, at the shear limit, and since the place of touch.
#[test]
fn the_factor_of_friction_has_three_witnesses() {
    let [coefficient, stiffness] = [0.3, 50.0];
    for (half_square, pressure, opening, shear_limit) in [
        (1e-4, 9.0, 0.0, f64::MAX),
        (2e-2, 9.0, 0.0, f64::MAX),
        (2e-2, 9.0, 0.0, 2.0),
        (2e-4, 5.0, 3.0, f64::MAX),
        (1e-1, 0.2, 3.0, 1.0),
    ] {
        let inputs = [half_square, pressure, coefficient, stiffness, opening, shear_limit];
        let expected = by_duals(&inputs, 2, |x| {
            let slip = (x[0] + x[0]).sqrt();
            let share = if opening > 0.0 { x[1] / (x[1] + x[4]) } else { Dual64::from(1.0) };
            let (elastic, limit) = (share * x[3], x[2] * x[1]);
            let limit = if limit.re < shear_limit { limit } else { Dual64::from(shear_limit) };
            vec![if (elastic * slip).re > limit.re { limit / slip } else { elastic }]
        });
        let kernel = coulomb::Inputs { half_square, pressure, coefficient, stiffness, opening, shear_limit };
        let results = coulomb::evaluate(support::Mode::Gradient, &kernel);
        let of_kernel = [vec![results.values.factor], results.factor_jacobian.to_vec()];
        let of_graph = interpreted(formulas::coulomb, &inputs, "factor");
        for (k, what) in ["factor", "its derivatives"].into_iter().enumerate() {
            assert_close(&of_graph[k], &expected[k], what);
            assert_close(&of_kernel[k], &expected[k], what);
        }
    }
}

/// −c P_n d with a factor of its own, in stick, in slip, since the place of touch, and without any slip.
#[test]
fn the_traction_over_faces_has_three_witnesses() {
    let [coefficient, stiffness] = [0.3, 50.0];
    for (way, pressure, opening, shear_limit) in [
        ([0.01, -0.02, 0.3], 9.0, 0.0, f64::MAX),
        ([0.2, 0.1, 0.3], 9.0, 0.0, f64::MAX),
        ([0.2, 0.1, 0.3], 9.0, 0.0, 2.0),
        ([0.01, 0.02, -0.1], 5.0, 3.0, f64::MAX),
        ([0.4, -0.2, 0.1], 0.2, 3.0, 1.0),
        ([0.0; 3], 9.0, 0.0, f64::MAX),
    ] {
        let normal = [0.2, -0.3, 1.7];
        let inputs = [&way[..], &normal, &[pressure, coefficient, stiffness, opening, shear_limit]].concat();
        let expected = by_duals(&inputs, 7, |x| {
            let (d, n) = (&x[..3], &x[3..6]);
            let norm = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
            let n = [0, 1, 2].map(|i| n[i] / norm);
            // P d = (n × d) × n
            let cross = |a: [Dual64; 3], b: [Dual64; 3]| {
                [0, 1, 2].map(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
            };
            let slip = cross(cross(n, [d[0], d[1], d[2]]), n);
            let share = if opening > 0.0 { x[6] / (x[6] + opening) } else { Dual64::from(1.0) };
            let (elastic, limit) = (share * stiffness, x[6] * coefficient);
            let limit = if limit.re < shear_limit { limit } else { Dual64::from(shear_limit) };
            let square = slip[0] * slip[0] + slip[1] * slip[1] + slip[2] * slip[2];
            let slides = elastic.re * square.re.sqrt() > limit.re;
            let factor = if slides { limit / square.sqrt() } else { elastic };
            slip.map(|slip| -factor * slip).to_vec()
        });
        let kernel = traction::Inputs { way, normal, pressure, coefficient, stiffness, opening, shear_limit };
        let results = traction::evaluate(support::Mode::Gradient, &kernel);
        let of_kernel = [results.values.traction.to_vec(), results.traction_jacobian.to_vec()];
        let of_graph = interpreted(formulas::traction, &inputs, "traction");
        for (k, what) in ["traction", "its derivatives"].into_iter().enumerate() {
            assert_close(&of_graph[k], &expected[k], what);
            assert_close(&of_kernel[k], &expected[k], what);
        }
    }
}

/// The traction t = μ(p, v) p with v = (w s − t/ε_T)/(w Δt), for a μ that is linear in both, by fixed-point iteration.
fn sliding_strength(
    slip: Dual64,
    pressure: Dual64,
    [mu, by_p, by_v, p_0, v_0]: [f64; 5],
    law: [f64; 3],
) -> Dual64 {
    let [stiffness, opening, duration] = law;
    let share = if opening > 0.0 { pressure / (pressure + opening) } else { Dual64::from(1.0) };
    let mut strength = pressure * mu;
    for _ in 0..200 {
        let rate = (share * slip - strength / stiffness) / (share * duration);
        strength = pressure * (Dual64::from(mu) + (pressure - p_0) * by_p + (rate - v_0) * by_v);
    }
    strength
}

#[test]
fn sliding_at_a_coefficient_that_varies_has_three_witnesses() {
    for (half_square, way, pressure, opening) in
        [(2e-2, [0.2, 0.1, 0.3], 9.0, 0.0), (0.3, [-0.4, 0.5, 0.1], 4.0, 3.0)]
    {
        let normal = [0.2, -0.3, 1.7];
        let model = [0.3, -0.01, -0.2, 8.7, 0.4];
        let law = [50.0, opening, 0.7];
        let [coefficient, coefficient_by_pressure, coefficient_by_rate, at_pressure, at_rate] = model;
        let [stiffness, opening, duration] = law;
        let inputs = [&[half_square, pressure][..], &model, &law].concat();
        let expected = by_duals(&inputs, 2, |x| {
            let slip = (x[0] + x[0]).sqrt();
            vec![sliding_strength(slip, x[1], model, law) / slip]
        });
        let kernel = coulomb_sliding::Inputs {
            half_square,
            pressure,
            coefficient,
            coefficient_by_pressure,
            coefficient_by_rate,
            at_pressure,
            at_rate,
            stiffness,
            opening,
            duration,
        };
        let results = coulomb_sliding::evaluate(support::Mode::Gradient, &kernel);
        let of_kernel = [vec![results.values.factor], results.factor_jacobian.to_vec()];
        let of_graph = interpreted(formulas::coulomb_sliding, &inputs, "factor");
        for (k, what) in ["factor", "its derivatives"].into_iter().enumerate() {
            assert_close(&of_graph[k], &expected[k], what);
            assert_close(&of_kernel[k], &expected[k], what);
        }

        let inputs = [&way[..], &normal, &[pressure], &model, &law].concat();
        let expected = by_duals(&inputs, 7, |x| {
            let dot = |a: &[Dual64], b: &[Dual64]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            let (d, n) = (&x[..3], &x[3..6]);
            let along = dot(d, n) / dot(n, n);
            let slip: Vec<Dual64> = (0..3).map(|i| d[i] - along * n[i]).collect();
            let length = dot(&slip, &slip).sqrt();
            let strength = sliding_strength(length, x[6], model, law);
            slip.iter().map(|&slip| -strength * slip / length).collect()
        });
        let kernel = traction_sliding::Inputs {
            way,
            normal,
            pressure,
            coefficient,
            coefficient_by_pressure,
            coefficient_by_rate,
            at_pressure,
            at_rate,
            stiffness,
            opening,
            duration,
        };
        let results = traction_sliding::evaluate(support::Mode::Gradient, &kernel);
        let of_kernel = [results.values.traction.to_vec(), results.traction_jacobian.to_vec()];
        let of_graph = interpreted(formulas::traction_sliding, &inputs, "traction");
        for (k, what) in ["traction", "its derivatives"].into_iter().enumerate() {
            assert_close(&of_graph[k], &expected[k], what);
            assert_close(&of_kernel[k], &expected[k], what);
        }
    }
}

#[test]
fn coefficients_and_tables_have_three_witnesses() {
    let [rate, at_rest, in_motion, decay] = [0.7, 0.5, 0.2, 1.3];
    let inputs = [rate, at_rest, in_motion, decay];
    let expected = by_duals(&inputs, 1, |x| vec![x[2] + (x[1] - x[2]) / (x[3] * x[0]).exp()]);
    let kernel = decaying_coefficient::Inputs { rate, at_rest, in_motion, decay };
    let results = decaying_coefficient::evaluate(support::Mode::Gradient, &kernel);
    let of_kernel = [vec![results.values.coefficient], results.coefficient_jacobian.to_vec()];
    let of_graph = interpreted(formulas::decaying_coefficient, &inputs, "coefficient");
    for k in 0..2 {
        assert_close(&of_graph[k], &expected[k], "decaying coefficient");
        assert_close(&of_kernel[k], &expected[k], "decaying coefficient");
    }
    let inputs = [1.3, 0.4, 1.0, 3.0, -1.0, 2.0, 0.5, 0.7, -0.2, 0.9];
    let expected = by_duals(&inputs, 2, |x| {
        // Along y at both ends, then along x.
        let s = (x[1] - x[4]) / (x[5] - x[4]);
        let [first, last] = [x[6] + (x[9] - x[6]) * s, x[7] + (x[8] - x[7]) * s];
        vec![first + (last - first) * (x[0] - x[2]) / (x[3] - x[2])]
    });
    let [x, y, first_x, last_x, first_y, last_y, value_00, value_10, value_11, value_01] = inputs;
    let kernel = interpolated::Inputs {
        x,
        y,
        first_x,
        last_x,
        first_y,
        last_y,
        value_00,
        value_10,
        value_11,
        value_01,
    };
    let results = interpolated::evaluate(support::Mode::Gradient, &kernel);
    let of_kernel = [vec![results.values.value], results.value_jacobian.to_vec()];
    let of_graph = interpreted(formulas::interpolated, &inputs, "value");
    for k in 0..2 {
        assert_close(&of_graph[k], &expected[k], "table");
        assert_close(&of_kernel[k], &expected[k], "table");
    }
}

#[test]
fn the_unit_vector_has_three_witnesses() {
    let along = [0.3, -1.2, 0.7];
    let expected = by_duals(&along, 3, |x| {
        let norm = (x[0] * x[0] + x[1] * x[1] + x[2] * x[2]).sqrt();
        x.iter().map(|x| x / norm).collect()
    });
    let results = direction::evaluate(support::Mode::Gradient, &direction::Inputs { along });
    let of_kernel = [results.values.direction.to_vec(), results.direction_jacobian.to_vec()];
    let of_graph = interpreted(formulas::direction, &along, "direction");
    for (k, what) in ["direction", "its derivatives"].into_iter().enumerate() {
        assert_close(&of_graph[k], &expected[k], what);
        assert_close(&of_kernel[k], &expected[k], what);
    }
}

#[test]
fn the_force_of_a_point_with_friction_has_three_witnesses() {
    let inputs = [0.3, -1.2, 0.7, 0.2, 0.1, -0.4];
    let expected = by_duals(&inputs, 6, |x| {
        let square = x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
        let part = (x[0] * x[3] + x[1] * x[4] + x[2] * x[5]) / square;
        (0..3).map(|k| x[k] / square.sqrt() + x[3 + k] - part * x[k]).collect()
    });
    let [along, ratio] = [0, 3].map(|first| [0, 1, 2].map(|k| inputs[first + k]));
    let results = load_of_point::evaluate(support::Mode::Gradient, &load_of_point::Inputs { along, ratio });
    let of_kernel = [results.values.load.to_vec(), results.load_jacobian.to_vec()];
    let of_graph = interpreted(formulas::load_of_point, &inputs, "load");
    for (k, what) in ["load", "its derivatives"].into_iter().enumerate() {
        assert_close(&of_graph[k], &expected[k], what);
        assert_close(&of_kernel[k], &expected[k], what);
    }
}

#[test]
fn friction_over_pressure_has_three_witnesses() {
    let inputs = [0.3, -1.2, 0.7, 2.5];
    let expected = by_duals(&inputs, 4, |x| (0..3).map(|k| x[k] / x[3]).collect());
    let kernel = friction_over_pressure::Inputs { traction: [0.3, -1.2, 0.7], pressure: 2.5 };
    let results = friction_over_pressure::evaluate(support::Mode::Gradient, &kernel);
    let of_kernel = [results.values.ratio.to_vec(), results.ratio_jacobian.to_vec()];
    let of_graph = interpreted(formulas::friction_over_pressure, &inputs, "ratio");
    for (k, what) in ["ratio", "its derivatives"].into_iter().enumerate() {
        assert_close(&of_graph[k], &expected[k], what);
        assert_close(&of_kernel[k], &expected[k], what);
    }
}

#[test]
fn the_foot_of_a_gap_with_its_derivatives() {
    let inputs = [0.3, -1.7, 2.1, -0.4, 0.36, 0.48, 0.8];
    let expected = by_duals(&inputs, 7, |x| (0..3).map(|k| x[k] + x[3] * -x[4 + k]).collect());
    let [x, y, z, gap, a, b, c] = inputs;
    let of = foot_of_gap::Inputs { slave: [x, y, z], gap, normal: [a, b, c] };
    let results = foot_of_gap::evaluate(support::Mode::Gradient, &of);
    let of_kernel = [results.values.foot.to_vec(), results.foot_jacobian.to_vec()];
    let of_graph = interpreted(formulas::foot_of_gap, &inputs, "foot");
    for (k, what) in ["foot", "its derivatives"].into_iter().enumerate() {
        assert_close(&of_graph[k], &expected[k], what);
        assert_close(&of_kernel[k], &expected[k], what);
    }
}
