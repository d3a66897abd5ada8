//! Elements without a result: always a typed error, or a number that automatic differentiation confirms.

use std::f64::consts::TAU;

use diffuse_contact::ad::Ad;
use diffuse_contact::{Backend, Basis, ElementError, Gap, Generated, Mode};
use diffuse_contact_kernels::cubic::Cubic;
use diffuse_contact_kernels::support::{FrameRule, Isa, KernelSet, Status, Workspace};
use diffuse_contact_tests::{
    Case, Found, GAP_KERNELS, Quadric, Random, add, assert_finite_gap, assert_same_gap, difference, fixed,
    instructions, largest, scale,
};
use proptest::prelude::*;

const MODES: [Mode; 3] = [Mode::Value, Mode::Gradient, Mode::Hessian];

/// The errors of all outputs in all modes.
fn errors(backend: &impl Backend, case: &Case) -> Vec<Option<ElementError>> {
    let element = case.element();
    MODES
        .into_iter()
        .flat_map(|mode| {
            [
                backend.gap(&element, mode).err(),
                backend.coefficients(&element, mode).err(),
                backend.surface(&element, [0.1 * case.support_radius, 0.0], mode).err(),
            ]
        })
        .collect()
}

/// A flat layout in general position, the slave a little above, in units of `size`.
fn flat(layout: &[[f64; 2]], slave: [f64; 2], basis: Basis, size: f64) -> Case {
    let mut nodes = vec![[slave[0], slave[1], 0.1]];
    nodes.extend(layout.iter().map(|[a, b]| [*a, *b, 0.05 * a]));
    Case::from_local(&nodes, 3.0, basis, &mut Random::new(layout.len() as u64)).scaled(size)
}

/// Layouts without a fit: on a conic for the quadratic basis, on a line for the linear one.
fn degenerate_layouts() -> Vec<(&'static str, Vec<[f64; 2]>, Basis)> {
    let ring = |n: usize, b: f64| -> Vec<[f64; 2]> {
        (0..n).map(|i| (TAU * i as f64 / n as f64).sin_cos()).map(|(s, c)| [c, b * s]).collect()
    };
    let strip = (0..10).map(|i| [0.5 * f64::from(i / 2) - 1.0, f64::from(i % 2)]);
    let hyperbola = (1..=8).map(|i| [0.3 * f64::from(i), 0.5 / f64::from(i)]);
    let parabola = (-3..=4).map(|i| [0.4 * f64::from(i), 0.09 * f64::from(i * i)]);
    let line = (0..7).map(|i| [0.3 * f64::from(i), 0.1 - 0.2 * f64::from(i)]);
    vec![
        ("hexagon", ring(6, 1.0), Basis::Quadratic),
        ("circle", ring(13, 1.0), Basis::Quadratic),
        ("ellipse", ring(9, 0.5), Basis::Quadratic),
        ("strip", strip.collect(), Basis::Quadratic),
        ("hyperbola", hyperbola.collect(), Basis::Quadratic),
        ("parabola", parabola.collect(), Basis::Quadratic),
        ("line", line.clone().collect(), Basis::Quadratic),
        ("line", line.collect(), Basis::Linear),
        ("point", vec![[0.3, 0.2]; 8], Basis::Linear),
    ]
}

/// Every degenerate layout seen from two slaves, in three units of length.
fn degenerate_cases() -> Vec<(&'static str, Case)> {
    let mut cases = Vec::new();
    for (name, layout, basis) in degenerate_layouts() {
        for slave in [[0.0, 0.0], [0.31, 0.17]] {
            for size in [1e-3, 1.0, 1e3] {
                cases.push((name, flat(&layout, slave, basis, size)));
            }
        }
    }
    cases
}

#[test]
fn degenerate_layouts_are_singular_fits() {
    for (name, case) in degenerate_cases() {
        for error in errors(&Generated, &case).into_iter().chain(errors(&Ad, &case)) {
            assert!(
                matches!(error, Some(ElementError::SingularFit { tolerance: 1e-7, .. })),
                "{name}: {error:?}"
            );
        }
    }
}

#[test]
fn a_singular_fit_says_how_singular_it_is() {
    for (name, case) in degenerate_cases() {
        for error in errors(&Generated, &case) {
            let Some(ElementError::SingularFit { pivot_ratio, .. }) = error else { panic!("{error:?}") };
            assert!(pivot_ratio.abs() < 1e-11, "{name}: pivot ratio {pivot_ratio:e}");
        }
    }
}

/// However unlucky the layout is: rounding must not pass for rank.
#[test]
fn no_degenerate_layout_passes_for_a_sound_one() {
    let mut random = Random::new(1);
    for kind in ["five nodes inside", "ellipse", "parabola", "two lines"] {
        let mut accepted = Vec::new();
        for _ in 0..20_000 {
            let n = 6 + (4.0 * (1.0 + random.signed())) as usize;
            let mut nodes = vec![[0.4 * random.signed(), 0.4 * random.signed(), 0.3]];
            let [c, d, e] = random.vector(1.0);
            for i in 0..n {
                let [x, y] = [0.9 * random.signed(), 0.9 * random.signed()];
                let (sine, cosine) = (TAU * x).sin_cos();
                let [a, b] = match kind {
                    "five nodes inside" => [if i < 5 { x } else { 5.0 }, y],
                    "ellipse" => [0.95 * cosine, (0.3 + 0.7 * c.abs()) * sine],
                    "parabola" => [x, 0.5 * c * x * x + 0.3 * d * x + 0.1],
                    _ => [x, if i % 2 == 0 { d } else { e }],
                };
                nodes.push([a, b, 0.1 * random.signed()]);
            }
            let case = Case::from_local(&nodes, 1.5, Basis::Quadratic, &mut random);
            if Generated.coefficients(&case.element(), Mode::Value).is_ok() {
                accepted.push(pivot_ratio(&case));
            }
        }
        assert!(
            accepted.is_empty(),
            "{kind}: {} of 20000 accepted, pivot ratio up to {:e}",
            accepted.len(),
            largest(&accepted)
        );
    }
}

/// Where M, which is one over a length, is about as large as a number can be: entries of pairs of nodes overflow before
/// those of the slave do.
#[test]
fn a_hessian_that_overflows_is_not_ok() {
    let mut workspace = Workspace::default();
    for isa in instructions() {
        let (mut sound, mut overflown) = (0, 0);
        let mut check = |found: &Found, what: &str| {
            let is_finite = found.gradient.iter().chain(&found.hessian).all(|x| x.is_finite());
            if found.status() == Status::Ok {
                sound += 1;
                assert!(is_finite, "{isa}, {what}: Ok with entries that are not finite");
            } else if !is_finite {
                assert_eq!(found.status(), Status::NotFinite, "{isa}, {what}");
                overflown += 1;
            }
        };
        for set in GAP_KERNELS {
            for basis in [Basis::Quadratic, Basis::Linear] {
                let kernel = (basis, FrameRule::Held, Mode::Hessian);
                for n in 7..=12 {
                    let case = Case::random(n, basis, n as u64);
                    let cases: Vec<Case> =
                        (0..40).map(|k| case.scaled(10f64.powf(-305.0 - 0.08 * f64::from(k)))).collect();
                    for case in &cases {
                        check(&set.single(isa, kernel, case, 0), "single");
                    }
                    let together: Vec<&Case> = cases.iter().collect();
                    for found in set.batch(isa, kernel, &together, &mut workspace, 0) {
                        check(&found, "batch");
                    }
                }
            }
        }
        assert!(sound > 100 && overflown > 100, "{isa}: {sound} sound, {overflown} overflown");
    }
}

#[test]
fn nodes_outside_the_support_do_not_make_a_fit() {
    // Nine nodes, of which five are inside; then none, so that the moment matrix vanishes.
    let mut five = Case::random(9, Basis::Quadratic, 1);
    for k in 5..9 {
        five.masters[k] = add(five.masters[k], five.global([10.0, 0.0, 0.0]));
    }
    let none = Case { masters: five.masters.iter().map(|x| add(*x, [20.0; 3])).collect(), ..five.clone() };
    for case in [five, none] {
        for error in errors(&Generated, &case) {
            assert!(matches!(error, Some(ElementError::SingularFit { .. })), "{error:?}");
        }
    }
}

#[test]
fn coincident_nodes_are_no_reason_if_enough_are_left() {
    let mut case = Case::random(9, Basis::Quadratic, 2);
    case.masters[3] = case.masters[5];
    case.masters[4] = case.slave;
    let [found, expected] =
        [Generated.gap(&case.element(), Mode::Hessian), Ad.gap(&case.element(), Mode::Hessian)];
    assert_same_gap(&case, &found.unwrap(), &expected.unwrap(), 1e-12);
    // Of six, two in one place are five.
    let mut case = Case::random(6, Basis::Quadratic, 2);
    case.masters[3] = case.masters[5];
    assert!(errors(&Generated, &case).iter().all(|e| matches!(e, Some(ElementError::SingularFit { .. }))));
}

/// Masters on a quadric whose axis is n̂, the slave at height `distance` over its vertex.
fn over_vertex(c: [f64; 3], distance: f64) -> Case {
    Case::on_quadric(&Quadric([0.0, 0.0, 0.0, c[0], c[1], c[2]]), [0.0; 2], distance, 12, 5)
}

/// Bowls and saddles with a principal centre of curvature on the axis, and its height.
const BOWLS: [([f64; 3], f64); 5] = [
    ([0.4, 0.0, 0.4], 1.25),
    ([-0.4, 0.0, -0.4], -1.25),
    // One principal curvature is enough.
    ([0.4, 0.0, 0.1], 1.25),
    ([0.4, 0.0, 0.0], 1.25),
    ([0.0, 0.8, 0.0], 1.25),
];

#[test]
fn a_slave_on_a_centre_of_curvature_has_no_gap() {
    for (c, height) in BOWLS {
        for size in [1.0, 1e-3, 1e3] {
            let case = over_vertex(c, height).scaled(size);
            for mode in MODES {
                match Generated.gap(&case.element(), mode) {
                    Err(ElementError::CentreOfCurvature { determinant }) => {
                        assert!(determinant.abs() <= 1e-7, "{determinant:e}");
                    }
                    Err(error) => panic!("{c:?}, size {size:e}, {mode:?}: {error:?}"),
                    Ok(gap) => panic!(
                        "{c:?}, size {size:e}, {mode:?}: gap {:e}, foot {:?} R from the slave",
                        gap.gap,
                        case.local_offset(gap.foot).map(|x| x / case.support_radius)
                    ),
                }
            }
            // The surface itself exists.
            assert!(Generated.surface(&case.element(), [0.0; 2], Mode::Hessian).is_ok());
        }
    }
}

#[test]
fn below_a_centre_of_curvature_there_is_a_gap_and_beyond_it_none() {
    for (c, height) in BOWLS {
        let below = over_vertex(c, height * 0.99);
        let found = Generated.gap(&below.element(), Mode::Hessian);
        let expected = Ad.gap(&below.element(), Mode::Hessian);
        // M has the condition 1/0.01² there.
        assert_same_gap(&below, &found.unwrap(), &expected.unwrap(), 1e-10);

        // The vertex is still a stationary point of the distance, but no longer the nearest.
        let beyond = over_vertex(c, height * 1.01);
        for backend in [&Generated as &dyn Backend, &Ad] {
            let error = backend.gap(&beyond.element(), Mode::Value).unwrap_err();
            let ElementError::BeyondCentreOfCurvature { determinant, trace } = error else {
                panic!("{error}")
            };
            assert!(determinant < 0.0 || trace > 0.0, "{determinant:e} {trace:e}");
        }
    }
}

/// Ever nearer to a centre of curvature: an error, or a gap whose foot is one.
#[test]
fn a_foot_near_a_centre_of_curvature_is_a_foot_or_an_error() {
    for (c, height) in BOWLS {
        for exponent in 1..=16 {
            for side in [-1.0, 1.0] {
                let case = over_vertex(c, height * (1.0 + side * 10f64.powi(-exponent)));
                if let Ok(gap) = Generated.gap(&case.element(), Mode::Value) {
                    let error = distance_from_normal(&case, &gap);
                    assert!(error <= 1e-11, "{c:?}, {side}e-{exponent}: the foot is off by {error:e} R");
                }
            }
        }
    }
}

/// How far the slave is from the point at the gap's distance over the foot, along ν, over R.
fn distance_from_normal(case: &Case, gap: &Gap) -> f64 {
    let above_foot = add(gap.foot, scale(gap.gap, gap.normal));
    largest(&add(above_foot, scale(-1.0, case.slave))) / case.support_radius
}

/// The accuracy does not depend on R being of the size of the element: the weights are then all near one.
#[test]
fn a_support_radius_much_larger_than_the_element() {
    for exponent in [1, 2, 4, 6, 8, 10, 12] {
        for seed in 0..10 {
            let mut case = Case::random(9, Basis::Quadratic, 50 + seed);
            case.support_radius = 10f64.powi(exponent);
            let [found, expected] =
                [&Generated as &dyn Backend, &Ad].map(|b| b.gap(&case.element(), Mode::Gradient).unwrap());
            let worst = difference(&found.gradient, &expected.gradient);
            assert!(worst <= 1e-11, "R = 1e{exponent}: N differs by {worst:e}");
        }
    }
}

#[test]
fn a_foot_outside_the_support_is_an_error_with_its_distance() {
    // Over a plane of slope 1 at height d, the foot is d/2 away in the plane.
    let plane = Quadric([0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    let height = |d: f64| {
        let mut case = Case::on_quadric(&plane, [0.0; 2], 0.0, 12, 6);
        case.slave = add(case.slave, case.global([0.0, 0.0, d]));
        case
    };
    for basis in [Basis::Quadratic, Basis::Linear] {
        for d in [4.0, -4.0, 40.0] {
            let case = Case { basis, ..height(d) };
            for mode in MODES {
                let error = Generated.gap(&case.element(), mode).unwrap_err();
                let ElementError::FootOutside { distance } = error else { panic!("{error:?}") };
                assert!((distance - 0.5 * d.abs() / case.support_radius).abs() <= 1e-12 * d.abs());
            }
        }
        // Just inside and just outside.
        let border = 2.0 * height(0.0).support_radius;
        assert!(Generated.gap(&Case { basis, ..height(0.999 * border) }.element(), Mode::Hessian).is_ok());
        assert!(Generated.gap(&Case { basis, ..height(1.001 * border) }.element(), Mode::Hessian).is_err());
    }
}

#[test]
fn input_is_checked_first() {
    let sound = Case::random(9, Basis::Quadratic, 3);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for axis in 0..3 {
            let mut case = sound.clone();
            case.slave[axis] = bad;
            for error in errors(&Generated, &case) {
                assert_eq!(error, Some(ElementError::NonFiniteInput { what: "slave", index: 0 }));
            }
            let mut case = sound.clone();
            case.masters[8][axis] = bad;
            for error in errors(&Generated, &case) {
                assert_eq!(error, Some(ElementError::NonFiniteInput { what: "master", index: 8 }));
            }
        }
        for point in [[bad, 0.0], [0.0, bad]] {
            let error = Generated.surface(&sound.element(), point, Mode::Hessian).unwrap_err();
            assert!(matches!(error, ElementError::NonFiniteInput { what: "point", .. }), "{error:?}");
        }
    }
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let case = Case { support_radius: radius, ..sound.clone() };
        for error in errors(&Generated, &case) {
            assert!(matches!(error, Some(ElementError::InvalidSupportRadius { .. })), "{error:?}");
        }
    }
    for (basis, n) in [(Basis::Quadratic, 5), (Basis::Quadratic, 0), (Basis::Linear, 2), (Basis::Linear, 0)] {
        let few = Case { masters: sound.masters[..n].to_vec(), basis, ..sound.clone() };
        for error in errors(&Generated, &few) {
            assert_eq!(error, Some(ElementError::TooFewNodes { found: n, needed: basis.size() }));
        }
    }
}

#[test]
fn both_backends_name_the_same_coordinate_of_a_point() {
    let case = Case::random(9, Basis::Quadratic, 3);
    for point in [[f64::NAN, 0.0], [0.0, f64::NAN]] {
        let [found, expected] = [&Generated as &dyn Backend, &Ad]
            .map(|backend| backend.surface(&case.element(), point, Mode::Value).unwrap_err());
        assert_eq!(found, expected);
    }
}

/// On surfaces with radii of curvature down to R/3 and heights up to 0.3 R the slave may lie near centres of
/// curvature, but a foot exists; automatic differentiation finds it in all cases.
#[test]
fn a_foot_is_found_wherever_there_is_one() {
    for i in 1..=500 {
        let part = |k: i32| 2.0 * (f64::from(i) * f64::from(k).sqrt()).fract() - 1.0;
        let surface = Quadric([0.3 * part(2), 0.5 * part(3), 0.5 * part(5), part(7), part(11), part(13)]);
        let mut case = Case::on_quadric(&surface, [0.0; 2], 0.0, 12, i as u64);
        // The slave at the origin of the quadric's axes, all lengths in units of R.
        case.slave = add(case.slave, scale(-surface.height(0.0, 0.0), case.frame.normal));
        let case = case.with_radius_as_unit();
        let found = Generated.gap(&case.element(), Mode::Gradient);
        let expected = Ad.gap(&case.element(), Mode::Gradient);
        match (found, expected) {
            (Ok(found), Ok(expected)) => assert_same_gap(&case, &found, &expected, 1e-9),
            (found, expected) => panic!("surface {i}: {:?}, AD {:?}", found.err(), expected.err()),
        }
    }
}

/// Numbers of any size, and what is no number.
fn wild() -> impl Strategy<Value = f64> {
    let powers = (-1.0..1.0f64, -323..309i32).prop_map(|(x, exponent)| x * 10f64.powi(exponent));
    let special = prop::sample::select(vec![
        0.0,
        -0.0,
        1.0,
        f64::MIN_POSITIVE,
        5e-324,
        f64::MAX,
        f64::MIN,
        1e300,
        -1e300,
        1e-300,
        1e154,
        1e77,
        f64::INFINITY,
        f64::NAN,
    ]);
    prop_oneof![4 => powers, 2 => special, 2 => -2.0..2.0f64]
}

/// A sound element of which some coordinates, the radius or the unit of length are wild.
fn wild_cases() -> impl Strategy<Value = Case> {
    let wild_coordinates = prop::collection::vec((0usize..30, wild()), 0..4);
    let factor = prop_oneof![3 => Just(1.0), 1 => (-320..300i32).prop_map(|e| 10f64.powi(e))];
    let radius = prop_oneof![3 => Just(None), 1 => wild().prop_map(Some)];
    let basis = prop_oneof![Just(Basis::Quadratic), Just(Basis::Linear)];
    (2usize..=9, basis, any::<u64>(), wild_coordinates, factor, radius).prop_map(
        |(n, basis, seed, coordinates, factor, radius)| {
            let mut case = Case::random(n, basis, seed);
            for (k, value) in coordinates {
                match k / 3 {
                    0 => case.slave[k % 3] = value,
                    node if node <= n => case.masters[node - 1][k % 3] = value,
                    _ => {}
                }
            }
            if let Some(radius) = radius {
                case.support_radius = radius;
            }
            case.scaled(factor)
        },
    )
}

proptest! {
    #![proptest_config(fixed(20_000))]

    #[test]
    fn no_input_makes_a_number_that_is_none(case in wild_cases()) {
        let element = case.element();
        for mode in MODES {
            if let Ok(gap) = Generated.gap(&element, mode) {
                assert_finite_gap(&gap);
            }
            if let Ok(fit) = Generated.coefficients(&element, mode) {
                let hessians = fit.hessians.iter().flat_map(|x| x.packed().to_vec());
                let all = fit.values.into_iter().chain(fit.gradients.concat()).chain(hessians);
                prop_assert!(all.into_iter().all(f64::is_finite), "coefficients, {mode:?}");
            }
            let point = [0.3 * case.support_radius, -0.1 * case.support_radius];
            if let Ok(surface) = Generated.surface(&element, point, mode) {
                let mut all = vec![surface.value];
                all.extend(surface.slopes);
                all.extend(surface.curvatures);
                all.extend(surface.gradient);
                all.extend(surface.slope_gradients.concat());
                all.extend(surface.hessian.packed());
                prop_assert!(all.into_iter().all(f64::is_finite), "surface, {mode:?}");
            }
        }
    }

    #[test]
    fn a_foot_is_a_foot(case in wild_cases()) {
        if let Ok(gap) = Generated.gap(&case.element(), Mode::Value) {
            let height = case.local_offset(gap.foot)[2] / case.support_radius;
            let size = height.abs().max(largest(&case.slave) / case.support_radius).max(1.0);
            let error = distance_from_normal(&case, &gap);
            prop_assert!(error <= 1e-12 * size, "off by {error:e} R, {size:e} R away");
        }
    }

    #[test]
    fn errors_about_the_input_do_not_depend_on_the_backend(case in wild_cases()) {
        if let Err(expected) = case.element().validate() {
            for error in errors(&Generated, &case).into_iter().chain(errors(&Ad, &case)) {
                // A NaN in an error is not equal to itself.
                prop_assert_eq!(format!("{:?}", error), format!("{:?}", Some(&expected)));
            }
        }
    }

    #[test]
    fn automatic_differentiation_confirms_the_numbers(case in wild_cases()) {
        let element = case.element();
        let Ok(found) = Generated.gap(&element, Mode::Gradient) else { return Ok(()) };
        let expected = match Ad.gap(&element, Mode::Gradient) {
            Ok(expected) => expected,
            // Seeded with R, its derivatives overflow earlier.
            Err(ElementError::Overflow { .. }) => return Ok(()),
            Err(error) => panic!("gap {:e}, but {error:?}", found.gap),
        };
        // Fourth powers of lengths over R: beyond this the dual numbers of AD underflow, the kernels' do not yet.
        let nearest = case.masters.iter().map(|x| largest(&add(*x, scale(-1.0, case.slave)))).fold(f64::MAX, f64::min);
        if nearest < 1e-60 * case.support_radius {
            return Ok(());
        }
        // What a nearly singular fit loses.
        let tolerance = 1e-11 / pivot_ratio(&case);
        // Heights are rounded on the scale of the far nodes, so coefficients are compared over R, where they are
        // slopes of the dimensionless fit.
        let (x, y) = (over_radius(&found.coefficients, &case), over_radius(&expected.coefficients, &case));
        let worst = largest(&differences(&x, &y)) / largest(&y).max(1.0);
        prop_assert!(worst <= tolerance, "coefficients differ by {worst:e}, bound {tolerance:e}");
        if same_foot(&case, &found, &expected) {
            let error = (found.gap - expected.gap).abs();
            let size = found.gap.abs().max(case.support_radius);
            prop_assert!(error <= tolerance * size, "g differs by {error:e}");
            let worst = difference(&found.gradient, &expected.gradient);
            prop_assert!(worst <= tolerance, "N differs by {worst:e}, bound {tolerance:e}");
        }
    }
}

/// Smallest relative pivot of an element's fit.
fn pivot_ratio(case: &Case) -> f64 {
    let kernel = (case.basis, FrameRule::Held, Mode::Value);
    Cubic::gap(Isa::best(), kernel, &case.inputs(), &mut [], &mut []).pivot_ratio
}

/// Coefficients of the fit in units of R: heights over R as a polynomial of offsets over R.
fn over_radius(coefficients: &[f64], case: &Case) -> Vec<f64> {
    const DEGREES: [i32; 6] = [0, 1, 1, 2, 2, 2];
    coefficients.iter().zip(DEGREES).map(|(c, degree)| c * case.support_radius.powi(degree - 1)).collect()
}

/// x − y
fn differences(x: &[f64], y: &[f64]) -> Vec<f64> {
    x.iter().zip(y).map(|(x, y)| x - y).collect()
}

/// Whether two backends found one foot: on a strongly curved surface there are several, and which is found
/// depends on how the steps are bounded. That each is one is a test of its own.
fn same_foot(case: &Case, found: &Gap, expected: &Gap) -> bool {
    largest(&add(found.foot, scale(-1.0, expected.foot))) <= 1e-3 * case.support_radius
}
