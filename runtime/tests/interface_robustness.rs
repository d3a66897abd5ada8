//! Whatever comes in: an error for the caller, a named outcome, or finite numbers, the same for any number of
//! threads.

use crate::common::{Mesh, Scene, Uniform, worse};
use diffuse_contact::ad::Ad;
use diffuse_contact::interface::{
    ContactElement, ContactInterface, ContactRef, InterfaceError, InterfaceOptions, NoContact, Outcome,
    PairedElement, RefreshReport,
};
use diffuse_contact::neighbourhood::{NeighbourRule, SearchOptions};
use diffuse_contact::pairing::Pairing;
use diffuse_contact::surface::{Facet, MasterSurface, SurfaceError};
use diffuse_contact::{
    Backend, ContactPoint, Element, ElementError, FacetElement, Frame, FrameDerivative, Gap, Generated, Mode,
    Point, SymmetricMatrix, Weight,
};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// Half a torus, waves on it, and slaves near it, over and beyond its borders.
fn scene(slaves: usize, options: InterfaceOptions) -> Scene {
    let mesh = Mesh::grid([24, 40], [false; 2], |s, t| {
        let (around, tube) = (3.0 * t, 5.0 * (1.0 - s));
        let tube_radius = 1.0 + 0.05 * (7.0 * around).sin();
        let radius = 2.5 + tube_radius * tube.cos();
        [radius * around.cos(), radius * around.sin(), tube_radius * tube.sin()]
    });
    let mut random = Uniform(17);
    let slaves: Vec<Point> = (0..slaves)
        .map(|_| {
            let (around, tube) = (3.2 * random.next() - 0.1, 5.4 * random.next() - 0.2);
            let tube_radius = 1.0 + 0.1 * random.signed();
            let radius = 2.5 + tube_radius * tube.cos();
            [radius * around.cos(), radius * around.sin(), tube_radius * tube.sin()]
        })
        .collect();
    mesh.scene(&slaves, options)
}

/// All numbers of a result, as bits.
fn bits(contact: &ContactRef<'_>) -> Vec<u64> {
    let point = &contact.point;
    let values = std::iter::once(&point.gap).chain(&point.foot).chain(&point.normal);
    values.chain(contact.gradient).chain(contact.hessian).map(|x| x.to_bits()).collect()
}

type Everything = (RefreshReport, RefreshReport, Vec<(String, Vec<u32>, Vec<u64>)>);

/// Refresh, move, refresh again, evaluate.
fn everything(threads: usize, options: InterfaceOptions) -> Everything {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let mut scene = scene(1500, options);
        let first = scene.refresh();
        for x in &mut scene.positions[scene.first..] {
            x[0] += 0.03;
        }
        let second = scene.refresh();
        let contacts = scene.interface.evaluate(Mode::Hessian).unwrap();
        let results = contacts
            .iter()
            .map(|contact| (format!("{:?}", contact.outcome), contact.nodes.to_vec(), bits(&contact)));
        (first, second, results.collect())
    })
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let search = SearchOptions::default().with_rule(NeighbourRule::hull_radius(Some(2)));
    let with = |weight, frame, search| {
        InterfaceOptions::default()
            .with_element(ContactElement::diffuse(search).with_weight(weight).with_frame(frame))
    };
    let held = with(Weight::Cubic, FrameDerivative::Held, search);
    let interpolating = with(Weight::CubicInterpolating, FrameDerivative::CoMoving, SearchOptions::default());
    for options in [InterfaceOptions::default(), held, interpolating, InterfaceOptions::node_to_facet()] {
        let one = everything(1, options);
        // With nodal domains no refresh changes a gap.
        let is_nodal = options == InterfaceOptions::default();
        assert!(one.1.changed > 40 && one.1.largest_gap_jump.is_some() != is_nodal, "{:?}", one.1);
        assert!(one.1.rebuilt && (is_nodal || one.1.renewed > 100), "{:?}", one.1);
        assert!(one.0.paired > 1000 && one.2.iter().any(|(outcome, ..)| outcome.contains("BeyondBorder")));
        assert!(everything(3, options) == one);
    }
}

#[test]
fn streaming_gives_the_same_as_holding_everything() {
    let mut scene = scene(700, InterfaceOptions::default());
    scene.refresh();
    for mode in [Mode::Value, Mode::Gradient, Mode::Hessian] {
        let mut streamed = Vec::new();
        let record = |contact: ContactRef<'_>| (contact.slave, contact.outcome, bits(&contact));
        scene.interface.for_each(mode, |contact| streamed.push(record(contact))).unwrap();
        let contacts = scene.interface.evaluate(mode).unwrap();
        assert_eq!(contacts.mode(), mode);
        assert_eq!(streamed, contacts.iter().map(record).collect::<Vec<_>>());
    }
}

#[test]
fn an_interface_without_slaves_has_nothing_to_say() {
    for options in [InterfaceOptions::default(), InterfaceOptions::node_to_facet()] {
        let mut scene = scene(0, options);
        // As with slaves.
        assert_eq!(scene.interface.evaluate(Mode::Value).unwrap_err().code(), "not-refreshed");
        assert_eq!(scene.refresh(), RefreshReport { rebuilt: true, ..RefreshReport::default() });
        assert!(scene.interface.evaluate(Mode::Hessian).unwrap().is_empty());
        scene.interface.for_each(Mode::Hessian, |_| panic!("no slave")).unwrap();
    }
}

#[test]
fn what_the_caller_has_to_mend_is_an_error() {
    let mesh = Mesh::plane(2.0, 2.0, 1.0);
    let positions = [mesh.positions.clone(), vec![[1.0, 1.0, 0.1], [0.5, 0.5, 0.1]]].concat();
    let new = |slaves: &[usize], options: InterfaceOptions| {
        ContactInterface::new(mesh.surface(), slaves.to_vec(), &[], &positions, options)
    };
    let refused = |slaves: &[usize]| new(slaves, InterfaceOptions::default()).unwrap_err();
    assert_eq!(refused(&[9, 11]), InterfaceError::SlaveOutOfRange { index: 1, node: 11, count: 11 });
    assert_eq!(refused(&[9, 10, 9]), InterfaceError::RepeatedSlave { node: 9 });
    assert_eq!(refused(&[9, 4]), InterfaceError::SlaveOnMaster { node: 4 });
    let default = InterfaceOptions::default();
    for options in [
        default.with_feature_angle_degrees(-1.0),
        default.with_feature_angle_degrees(f64::NAN),
        default.with_border_tolerance(-0.1),
        default.with_border_tolerance(f64::INFINITY),
        default.with_distance_limit(Some(0.0)),
        default.with_distance_limit(Some(f64::NAN)),
        default.with_element(ContactElement::diffuse(SearchOptions::default().with_candidates(1))),
    ] {
        assert_eq!(new(&[9], options).unwrap_err().code(), "invalid-option", "{options:?}");
    }

    let mut interface = new(&[9, 10], default).unwrap();
    interface.refresh_pairing(&positions).unwrap();
    let before = bits(&interface.evaluate(Mode::Gradient).unwrap().get(0));
    let wrong = interface.update(&positions[1..]).unwrap_err();
    assert_eq!(wrong, InterfaceError::WrongNumberOfPositions { found: 10, expected: 11 });
    for node in [0, 10] {
        let mut broken = positions.clone();
        broken[node][2] = f64::NAN;
        for error in [interface.update(&broken).unwrap_err(), interface.refresh_pairing(&broken).unwrap_err()]
        {
            assert!(
                matches!(error, InterfaceError::Surface(SurfaceError::NonFinitePosition { node: k, .. }) if k == node)
            );
        }
    }
    assert_eq!(
        bits(&interface.evaluate(Mode::Gradient).unwrap().get(0)),
        before,
        "bad positions are not taken"
    );
}

#[test]
fn a_facet_element_is_paired_with_the_corners_of_the_closest_facet() {
    let mesh = Mesh::plane(6.0, 6.0, 1.0);
    let options = InterfaceOptions::node_to_facet().with_distance_limit(Some(1.0));
    let slaves = [[2.3, 1.6, 0.1], [2.6, 2.6, -0.2], [3.0, 3.0, 1.5], [6.8, 3.0, 0.1], [7.4, 3.0, 0.1]];
    let mut scene = mesh.scene(&slaves, options);
    let report = scene.refresh();
    assert_eq!((report.paired, report.gained), (3, 3));
    assert_eq!(report.without.iter().collect::<Vec<_>>(), [(&"too-far", &2)]);
    let surface = mesh.surface();
    let index = surface.at(&mesh.positions).unwrap();
    let contacts = scene.interface.evaluate(Mode::Hessian).unwrap();
    for k in [0, 1, 3] {
        let closest = index.closest(slaves[k]).unwrap();
        let facet = surface.facet(closest.facet);
        let nodes: Vec<usize> = contacts.get(k).nodes.iter().map(|&node| node as usize).collect();
        assert_eq!(nodes, facet.corners());
    }
    assert!([2, 4].into_iter().all(|k| contacts.get(k).nodes.is_empty()));
}

#[test]
fn coincident_masters_and_slaves_on_them_have_an_outcome() {
    // Two nodes of a flat grid coincide in the deformed state, and slaves sit on them and on every third node.
    let mesh = Mesh::plane(6.0, 6.0, 1.0);
    let has_slave = |node: &usize| node.is_multiple_of(3) || (23..27).contains(node);
    let slaves: Vec<Point> =
        (0..mesh.positions.len()).filter(has_slave).map(|node| mesh.positions[node]).collect();
    let mut scene = mesh.paired(&slaves, InterfaceOptions::default());
    assert!(
        scene
            .interface
            .evaluate(Mode::Hessian)
            .unwrap()
            .iter()
            .all(|contact| contact.point.gap.abs() < 1e-14)
    );
    scene.positions[24] = scene.positions[25];
    scene.update();
    check(&mut scene, Mode::Hessian);
    scene.refresh();
    check(&mut scene, Mode::Hessian);
    // Everything in one point, and on one line.
    for flatten in [[0.0, 0.0], [1.0, 0.0]] {
        for x in &mut scene.positions {
            *x = [x[0] * flatten[0], x[1] * flatten[1], 0.0];
        }
        scene.update();
        check(&mut scene, Mode::Hessian);
        scene.refresh();
        check(&mut scene, Mode::Hessian);
        assert!(scene.interface.evaluate(Mode::Value).unwrap().iter().all(|c| !c.outcome.is_contact()));
    }
}

/// Contact with finite numbers, or a reason and no numbers; not for values alone.
fn check(scene: &mut Scene, mode: Mode) {
    let elements: Vec<_> = (0..scene.interface.slaves().len()).map(|k| scene.interface.element(k)).collect();
    let contacts = scene.interface.evaluate(mode).unwrap();
    for (place, contact) in contacts.iter().enumerate() {
        let point = &contact.point;
        let mut values = std::iter::once(&point.gap).chain(&point.foot).chain(&point.normal);
        assert!(values.all(|x| x.is_finite()), "{contact:?}");
        if contact.outcome.is_contact() {
            let freedoms = 3 * (contact.nodes.len() + 1);
            let entries = if mode == Mode::Hessian { freedoms * (freedoms + 1) / 2 } else { 0 };
            assert_eq!((contact.gradient.len(), contact.hessian.len()), (freedoms, entries));
            assert!(contact.gradient.iter().chain(contact.hessian).all(|x| x.is_finite()), "{contact:?}");
            confirmed_by_ad(elements[place].as_ref().unwrap(), &contact);
        } else {
            assert!(contact.gradient.is_empty() && contact.hessian.is_empty());
            assert!(!contact.outcome.code().is_empty());
            if let (Outcome::None(NoContact::Element { error }), Ok(element)) =
                (contact.outcome, &elements[place])
            {
                refused_by_ad(element, error, mode);
            }
        }
    }
}

/// What comes with a contact is what automatic differentiation of the same element says.
///
/// Of surfaces steeper than 1000, which lose digits by the square of their slope, it is asked nothing, nor of slaves 1000
/// facets away. A surface may have several
/// feet: where AD finds another one, or one that is no nearest point, the kernel's has to be a foot of AD's surface.
fn confirmed_by_ad(element: &PairedElement, contact: &ContactRef<'_>) {
    let mode = if contact.hessian.is_empty() { Mode::Gradient } else { Mode::Hessian };
    let (expected, size) = match element {
        PairedElement::Diffuse { slave, pairing } => {
            let (element, size) = (pairing.element(*slave), pairing.support_radius);
            if largest_offset(&pairing.positions, *slave) > 1e3 * size {
                return;
            }
            let error = foot_error(&element, &contact.point);
            assert!(error < 1e-9, "{error:e} {contact:?}");
            let expected = Ad.gap(&element, mode).map(|gap| of_listed(gap, pairing, contact.nodes));
            (expected, size)
        }
        PairedElement::Facet { slave, corners } => {
            let facet = FacetElement { slave: *slave, corners };
            let size = (0..3).map(|k| (corners[0][k] - corners[1][k]).powi(2)).sum::<f64>().sqrt();
            if largest_offset(corners, *slave) > 1e3 * size {
                return;
            }
            let natural = Generated.facet_point(&facet).unwrap().natural;
            let expected = Ad.facet_gap_near(&facet, natural, mode).unwrap();
            assert!(distance(expected.foot, contact.point.foot) <= 1e-6 * size, "{contact:?}");
            (Ok(expected), size)
        }
    };
    let Ok(expected) = expected else { return };
    if distance(expected.foot, contact.point.foot) > 1e-6 * size {
        return;
    }
    let largest = |x: &[f64]| x.iter().map(|x| x.abs()).fold(0.0, crate::common::worse);
    let difference = |x: &[f64], y: &[f64]| {
        x.iter().zip(y).map(|(x, y)| (x - y).abs()).fold(0.0, crate::common::worse)
            / largest(y).max(f64::MIN_POSITIVE)
    };
    let gap = (contact.point.gap - expected.gap).abs() / size;
    let n = difference(contact.gradient, &expected.gradient);
    let m = difference(contact.hessian, expected.hessian.packed());
    assert!(gap < 1e-9 && n < 1e-9 && m < 1e-9, "{gap:e} {n:e} {m:e} {element:?}");
}

/// The derivatives by an element's points as those by all nodes that are listed: zero by the others, parts of those by auxiliary points.
pub(crate) fn of_listed(mut gap: Gap, pairing: &Pairing, listed: &[u32]) -> Gap {
    let place =
        |node: usize| 1 + listed.iter().position(|&own| own as usize == node).expect("a listed master");
    // Of each coordinate of the element those that carry it, with their parts.
    let rows = |own: usize| match (own / 3).checked_sub(1) {
        None => vec![(own, 1.0)],
        Some(point) => {
            let master = pairing.masters[point];
            let (other, part) = pairing.others.get(point).copied().unwrap_or((master, 0.0));
            let both = [(master, 1.0 - part), (other, part)].into_iter().filter(|(_, part)| *part != 0.0);
            both.map(|(node, part)| (3 * place(node) + own % 3, part)).collect()
        }
    };
    let freedoms = 3 * (listed.len() + 1);
    let mut gradient = vec![0.0; freedoms];
    for (own, &n) in gap.gradient.iter().enumerate() {
        rows(own).iter().for_each(|&(row, part)| gradient[row] += part * n);
    }
    let has_hessian = !gap.hessian.packed().is_empty();
    let mut hessian = SymmetricMatrix::zeros(if has_hessian { freedoms } else { 0 });
    for i in (0..gap.gradient.len()).filter(|_| has_hessian) {
        for (j, (row, part)) in
            (0..gap.gradient.len()).flat_map(|j| rows(i).into_iter().map(move |row| (j, row)))
        {
            for (column, other) in rows(j).into_iter().filter(|&(column, _)| column <= row) {
                hessian.packed_mut()[row * (row + 1) / 2 + column] += part * other * gap.hessian.get(i, j);
            }
        }
    }
    (gap.gradient, gap.hessian) = (gradient, hessian);
    gap
}

/// Where the kernel has no result automatic differentiation of the same element has none either.
///
/// As in the converse nothing is asked of slaves 1000 support radii from a master.
fn refused_by_ad(element: &PairedElement, error: ElementError, mode: Mode) {
    let found = match element {
        PairedElement::Diffuse { slave, pairing } => {
            let far = 1e3 * pairing.support_radius;
            if largest_offset(&pairing.positions, *slave) > far {
                return;
            }
            Ad.gap(&pairing.element(*slave), mode)
        }
        PairedElement::Facet { slave, corners } => {
            Ad.facet_gap(&FacetElement { slave: *slave, corners }, mode)
        }
    };
    assert!(found.is_err(), "{error} {element:?} {found:?}");
}

/// Largest coordinate difference between a slave and its masters.
fn largest_offset(nodes: &[Point], slave: Point) -> f64 {
    nodes.iter().flat_map(|x| (0..3).map(|k| (x[k] - slave[k]).abs())).fold(0.0, f64::max)
}

fn distance(x: Point, y: Point) -> f64 {
    (0..3).map(|k| (x[k] - y[k]).powi(2)).sum::<f64>().sqrt()
}

/// How far the foot is from one of AD's surface: its height, and the slave's distance from the normal there, over the
/// support radius and the surface's slope.
fn foot_error(element: &Element<'_>, point: &ContactPoint) -> f64 {
    let along = |axis: Point| (0..3).map(|k| (point.foot[k] - element.slave[k]) * axis[k]).sum::<f64>();
    let Frame { t1, t2, normal, .. } = element.frame;
    let u = [along(t1), along(t2)];
    let surface = Ad.surface(element, u, Mode::Value).unwrap();
    let [f_1, f_2] = surface.slopes;
    let steepness = 1.0 + f_1.abs() + f_2.abs();
    let residuals = [along(normal) - surface.value, u[0] + surface.value * f_1, u[1] + surface.value * f_2];
    residuals.into_iter().map(|r| r.abs() / (steepness * steepness)).fold(0.0, worse) / element.support_radius
}

/// Any finite number, more often an ordinary one.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -3.0..3.0,
        3 => (-3i32..=3).prop_map(f64::from),
        1 => prop_oneof![Just(0.0), Just(1e-300), Just(1e74), Just(-1e74), Just(1e-20), Just(1e12)],
    ]
}

fn point() -> impl Strategy<Value = Point> {
    [coordinate(), coordinate(), coordinate()]
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 100,
        rng_seed: RngSeed::Fixed(2008),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// The surface is sound when it is connected; then everything moves anywhere.
    #[test]
    fn garbage_positions_end_in_a_number_or_a_reason(
        garbage in prop::collection::vec(point(), 45),
        share in 0.0..1.0,
        held in any::<bool>(),
        facets in any::<bool>(),
        feature_angle in prop_oneof![Just(45.0), Just(180.0)],
        weight in prop::sample::select(&Weight::ALL[..]),
    ) {
        let frame = if held { FrameDerivative::Held } else { FrameDerivative::CoMoving };
        let element = if facets {
            ContactElement::NodeToFacet
        } else {
            ContactElement::diffuse(SearchOptions::default()).with_weight(weight).with_frame(frame)
        };
        let options = InterfaceOptions::default().with_element(element).with_feature_angle_degrees(feature_angle);
        let mesh = Mesh::plane(5.0, 5.0, 1.0);
        let slaves: Vec<Point> = (0..9).map(|k| [0.7 + 0.5 * f64::from(k), 2.3, 0.1]).collect();
        let mut scene = mesh.paired(&slaves, options);
        check(&mut scene, Mode::Hessian);
        let at_rest = scene.positions.clone();
        // A part of the nodes, or all, go astray.
        let count = (share * 50.0) as usize;
        for (k, x) in garbage.iter().enumerate().take(count) {
            scene.positions[(7 * k) % at_rest.len()] = *x;
        }
        scene.update();
        check(&mut scene, Mode::Hessian);
        let report = scene.refresh();
        let without: usize = report.without.values().sum();
        prop_assert_eq!(report.paired + without, 9);
        prop_assert_eq!(report.paired, report.kept + report.renewed + report.changed + report.gained);
        check(&mut scene, Mode::Hessian);
        scene.positions = at_rest;
        scene.refresh();
        check(&mut scene, Mode::Gradient);
    }

    /// Facets at random: refused by name, or a surface that can be used.
    #[test]
    fn garbage_facets_are_refused_or_work(
        positions in prop::collection::vec(point(), 12),
        corners in prop::collection::vec(([0usize..11, 0usize..11, 0usize..11, 0usize..11], any::<bool>()), 1..6),
    ) {
        let facets: Vec<Facet> = corners
            .iter()
            .map(|&([a, b, c, d], quad)| if quad { Facet::Quadrilateral([a, b, c, d]) } else { Facet::Triangle([a, b, c]) })
            .collect();
        if let Ok(surface) = MasterSurface::new(&positions, facets) {
            let made = ContactInterface::new(surface, vec![11], &[], &positions, InterfaceOptions::default());
            let mut scene = Scene { first: 11, interface: made.unwrap(), positions };
            scene.refresh();
            check(&mut scene, Mode::Hessian);
        }
    }
}
