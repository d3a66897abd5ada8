//! Windows of a surface: slaves that know a part of it have the results of the whole, bit for bit, or say that they cannot know.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_6};

use diffuse_contact::interface::{
    ContactInterface, InterfaceError, InterfaceOptions, NoContact, Outcome, PartFacets, SurfacePart,
};
use diffuse_contact::surface::window::{Box3, Extents, Window, WindowError, boxes_around};
use diffuse_contact::surface::{Facet, MasterSurface, SymmetryPlane};
use diffuse_contact::{Mode, Point};

#[cfg(feature = "friction")]
use diffuse_contact::{assembly::ContactLaw, friction::Coulomb, interface::split_history};

use crate::common::{Mesh, Scene, Uniform, hull_layers};

const LIMIT: f64 = 0.6;

/// A wavy surface of irregular cells, 16 × 9, with a ridge sharper than the feature angle along x = 11; some slaves over it, above and
/// below, some beyond its border and some out of reach.
struct Case {
    mesh: Mesh,
    slaves: Vec<Point>,
    planes: Vec<SymmetryPlane>,
    options: InterfaceOptions,
}

fn height(x: f64, y: f64) -> f64 {
    0.4 * (x * FRAC_PI_6).sin() * (y * FRAC_PI_6).cos() + 1.3 * (x - 11.0).max(0.0)
}

impl Case {
    fn new(planes: &[SymmetryPlane]) -> Self {
        let mut random = Uniform(3);
        let moved: Vec<f64> = (0..400).map(|_| 0.15 * random.signed()).collect();
        let mesh = Mesh::grid([17, 10], [false; 2], |s, t| {
            let (x, y) = (16.0 * s, 9.0 * t);
            let k = (17.0 * y + x).round() as usize;
            let inner = |x: f64, end: f64| if x > 0.0 && x < end && x != 11.0 { 1.0 } else { 0.0 };
            let (x, y) = (x + inner(x, 16.0) * moved[2 * k], y + inner(y, 9.0) * moved[2 * k + 1]);
            [x, y, height(x, y)]
        });
        let slaves = (0..220).map(|k| {
            let (x, y) = (17.0 * random.next() - 0.5, 10.0 * random.next() - 0.5);
            let (x, y) = if k % 10 == 0 { (x.round(), y.round()) } else { (x, y) };
            let z = if k % 17 == 0 { 2.0 } else { 0.2 * random.signed() };
            let within = |x: f64, low: f64| if planes.is_empty() { x } else { x.max(low) };
            let (x, y) = (within(x, 0.0), within(y, 0.0));
            [x, y, height(x, y) + z]
        });
        let slaves = slaves.collect();
        let options = InterfaceOptions::default().with_distance_limit(Some(LIMIT));
        Self { mesh, slaves, planes: planes.to_vec(), options }
    }

    /// One row of cells, 40 × 1.5.
    fn strip() -> Self {
        let mut random = Uniform(7);
        let height = |x: f64| 0.4 * (0.6 * x).sin();
        let slave = |_: i32| {
            let (x, y) = (40.0 * random.next(), 1.5 * random.next());
            [x, y, height(x) + 0.2 * random.signed()]
        };
        let slaves = (0..120).map(slave).collect();
        let place = |s: f64, t: f64| [40.0 * s, 1.5 * t, height(40.0 * s)];
        let options = InterfaceOptions::default().with_distance_limit(Some(LIMIT));
        Self { mesh: Mesh::grid([41, 2], [false; 2], place), slaves, planes: Vec::new(), options }
    }

    fn whole(&self) -> Scene {
        let mut scene = self.mesh.scene(&self.slaves, self.options);
        scene.interface.set_symmetry(&self.planes).unwrap();
        scene.refresh();
        scene.interface.evaluate(Mode::Hessian).unwrap();
        scene
    }
}

/// The places of points in so many parts, by three partitioners: strips, recursive bisection, and by number.
fn partitions(points: &[Point], parts: usize) -> [Vec<Vec<usize>>; 3] {
    let mut along: Vec<usize> = (0..points.len()).collect();
    along.sort_by(|&i, &j| points[i][0].total_cmp(&points[j][0]));
    let strips = along.chunks(points.len().div_ceil(parts)).map(<[usize]>::to_vec).collect();
    let mut bisected = vec![along];
    for level in 0..parts.ilog2() {
        let axis = (level % 2) as usize;
        let halved = |mut part: Vec<usize>| {
            part.sort_by(|&i, &j| points[i][axis].total_cmp(&points[j][axis]));
            let other = part.split_off(part.len() / 2);
            [part, other]
        };
        bisected = bisected.into_iter().flat_map(halved).collect();
    }
    let by_number = (0..parts).map(|part| (part..points.len()).step_by(parts).collect()).collect();
    [strips, bisected, by_number]
}

/// What slaves of one part know.
struct Part {
    window: Window,
    interface: ContactInterface,
    /// Of the nodes of the window, and of the slaves.
    positions: Vec<Point>,
}

/// The interface of some slaves, with a window that has been sent as numbers.
fn part(window: &Window, slaves: &[Point], all: &[Point], options: InterfaceOptions) -> Part {
    let (integers, reals) = window.to_numbers();
    assert_eq!(window.count_numbers(), (integers.len(), reals.len()));
    let window = Window::from_numbers(&integers, &reals).unwrap();
    let mut positions: Vec<Point> = window.nodes().map(|number| all[number as usize]).collect();
    let first = positions.len();
    positions.extend(slaves);
    let own = (first..positions.len()).collect();
    let interface = ContactInterface::in_window(&window, own, &[], &positions, options).unwrap();
    Part { window, interface, positions }
}

/// All that a slave has, by numbers of the whole surface: outcome, gap, foot and normal, N and M by pairs of nodes (slave: `None`).
type Found = (Outcome, Vec<u64>, BTreeMap<Option<u64>, Vec<u64>>, Vec<u64>);

fn found(interface: &ContactInterface, k: usize, number: impl Fn(u32) -> u64) -> Found {
    let contact = interface.contacts().get(k);
    let bits = |numbers: &[f64]| numbers.iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
    let point = [&[contact.point.gap], &contact.point.foot[..], &contact.point.normal[..]].concat();
    let nodes = std::iter::once(None).chain(contact.nodes.iter().map(|&node| Some(number(node))));
    let gradient = nodes.zip(contact.gradient.as_chunks::<3>().0).map(|(node, n)| (node, bits(n)));
    (contact.outcome, bits(&point), gradient.collect(), bits(contact.hessian))
}

/// Compares the slaves of a part with the whole. Returns how many cannot know.
fn compare(whole: &Scene, part: &Part, slaves: &[usize]) -> usize {
    let numbers: Vec<u64> = part.window.nodes().collect();
    let mut beyond = 0;
    for (own, &k) in slaves.iter().enumerate() {
        let expected = found(&whole.interface, k, u64::from);
        let result = found(&part.interface, own, |node| numbers[node as usize]);
        match (result.0, expected.0) {
            (Outcome::None(NoContact::BeyondWindow { needed, known }), _) => {
                assert!(needed > known, "{needed} {known}");
                beyond += 1;
            }
            (
                Outcome::None(NoContact::TooFar { distance, .. }),
                Outcome::None(NoContact::TooFar { distance: exact, .. }),
            ) => assert!(distance == exact || distance == f64::INFINITY),
            _ => assert_eq!(result, expected, "slave {k}"),
        }
        let listed = |interface: &ContactInterface, k: usize| interface.contacts().get(k).nodes.to_vec();
        if result.0.is_contact() {
            let here = listed(&part.interface, own).into_iter().map(|node| numbers[node as usize]);
            let there = listed(&whole.interface, k).into_iter().map(u64::from);
            assert!(here.eq(there), "the pairing of slave {k}");
        }
    }
    beyond
}

fn chosen(points: &[Point], places: &[usize]) -> Vec<Point> {
    places.iter().map(|&k| points[k]).collect()
}

#[test]
fn any_partition_of_the_slaves_has_the_bits_of_the_whole() {
    let across = |axis| SymmetryPlane::across(axis, [0.0; 3]);
    for planes in [vec![], vec![across(0), across(1)]] {
        let case = Case::new(&planes);
        let whole = case.whole();
        let outcomes: BTreeMap<&str, usize> =
            whole.interface.contacts().iter().fold(BTreeMap::new(), |mut all, contact| {
                *all.entry(contact.outcome.code()).or_default() += 1;
                all
            });
        assert!(outcomes["contact"] > 150 && outcomes["too-far"] > 5, "{outcomes:?}");
        assert!(!planes.is_empty() || outcomes["beyond-border"] > 5, "{outcomes:?}");
        let counts: &[usize] = if planes.is_empty() { &[2, 4, 8] } else { &[4] };
        for &parts in counts {
            for (partitioner, partition) in partitions(&case.slaves, parts).iter().enumerate() {
                let mut facets = 0;
                for slaves in partition {
                    let part = check_slaves(&case, &whole, slaves);
                    facets += part.window.facets().len();
                    assert!(part.interface.master().border_edges().count() <= 50);
                }
                // Compact parts need a part of the surface, although domains are wide on one so small.
                assert!(partitioner == 2 || parts < 8 || facets < 5 * case.mesh.facets.len());
            }
        }
    }
}

/// One row of cells has auxiliary points between its nodes.
#[test]
fn slaves_of_a_strip_have_the_bits_of_the_whole() {
    let case = Case::strip();
    let whole = case.whole();
    let contacts = whole.interface.contacts().iter().filter(|contact| contact.outcome.is_contact()).count();
    assert!(contacts > 80, "{contacts}");
    for partition in partitions(&case.slaves, 4) {
        partition.iter().for_each(|slaves| drop(check_slaves(&case, &whole, slaves)));
    }
    // Auxiliary points are ascending, and have ends and a kind.
    let window = whole.interface.window(&boxes_around(&case.slaves, 0.5, 1), 0.0).unwrap();
    let (integers, reals) = window.to_numbers();
    let first = 10 + (integers[5] + integers[6]) as usize;
    assert!(integers[7] > 30, "{}", integers[7]);
    let [from, to] = [0, 1].map(|k| integers[first + k]);
    for (place, point) in [(0, [to, from, 0]), (0, [from, to, 65]), (1, [0, 1, 0]), (2, [3, integers[6], 0])]
    {
        let mut wrong = integers.clone();
        wrong[first + 3 * place..][..3].copy_from_slice(&point);
        let error = WindowError::Invalid { what: "auxiliary point", place };
        assert_eq!(Window::from_numbers(&wrong, &reals), Err(error));
    }
}

/// The slaves of a part, which have the results of the whole.
fn check_slaves(case: &Case, whole: &Scene, slaves: &[usize]) -> Part {
    let own = chosen(&case.slaves, slaves);
    let window = whole.interface.window(&boxes_around(&own, 1.01 * LIMIT, 6), 0.0).unwrap();
    let mut part = part(&window, &own, &whole.positions, case.options);
    part.interface.refresh_pairing(&part.positions).unwrap();
    part.interface.evaluate(Mode::Hessian).unwrap();
    assert_eq!(compare(whole, &part, slaves), 0);
    part
}

/// A window knows where its core was: positions that an interface begins with do not make it a new one.
#[test]
fn an_old_window_says_so() {
    let case = Case::new(&[]);
    let mut whole = case.whole();
    let slave = chosen(&case.slaves, &[3]);
    let boxes = boxes_around(&slave, 2.0 * LIMIT, 1);
    let old = whole.interface.window(&boxes, 0.05).unwrap();
    let code = |window: &Window, all: &[Point]| {
        let mut part = part(window, &slave, all, case.options);
        part.interface.refresh_pairing(&part.positions).unwrap();
        part.interface.evaluate(Mode::Value).unwrap().get(0).outcome.code()
    };
    assert_eq!(code(&old, &whole.positions), "contact");
    for (by, expected) in [(0.04, "contact"), (0.06, "beyond-window")] {
        let moved: Vec<Point> = whole.positions.iter().map(|&[x, y, z]| [x, y, z + by]).collect();
        assert_eq!(code(&old, &moved), expected);
    }
    // Nor do windows of different moments go together.
    whole.positions.iter_mut().for_each(|x| x[2] += 0.01);
    whole.update();
    let new = whole.interface.window(&boxes, 0.05).unwrap();
    let differs =
        |error: &WindowError| matches!(error, WindowError::Differs { what: "the position of node", .. });
    assert!(differs(&Window::joined(&[old, new]).unwrap_err()));
}

#[test]
fn a_window_too_narrow_says_so_and_gives_no_other_number() {
    let case = Case::new(&[]);
    let whole = case.whole();
    let slaves: Vec<usize> = (0..case.slaves.len()).collect();
    let mut counts = Vec::new();
    for reach in [0.1, 0.5, 1.5, 4.0, 9.0] {
        let boxes = boxes_around(&[[7.0, 4.0, height(7.0, 4.0)]], reach, 1);
        let window = whole.interface.window(&boxes, 0.0).unwrap();
        let mut part = part(&window, &case.slaves, &whole.positions, case.options);
        let report = part.interface.refresh_pairing(&part.positions).unwrap();
        part.interface.evaluate(Mode::Hessian).unwrap();
        let beyond = compare(&whole, &part, &slaves);
        assert_eq!(report.without.get("beyond-window").copied().unwrap_or(0), beyond);
        counts.push(beyond);
    }
    assert!(counts.is_sorted_by(|a, b| a >= b) && counts[0] == slaves.len(), "{counts:?}");
    assert!(counts[3] > 0 && counts[3] < counts[1] && counts[4] < 20, "{counts:?}");
    // Far from everything there is no facet at all, and no limit tells that none is near.
    let empty = whole.interface.window(&boxes_around(&[[90.0; 3]], 1.0, 1), 0.0).unwrap();
    assert_eq!((empty.nodes().len(), empty.facets().len()), (0, 0));
    let mut part = part(&empty, &[[90.0; 3], [7.0, 4.0, 0.5]], &whole.positions, case.options);
    part.interface.refresh_pairing(&part.positions).unwrap();
    let codes = |interface: &mut ContactInterface| {
        let contacts = interface.evaluate(Mode::Value).unwrap();
        contacts.iter().map(|contact| contact.outcome.code()).collect::<Vec<_>>()
    };
    assert_eq!(codes(&mut part.interface), ["too-far", "beyond-window"]);
    // Older than its skin: what is not in the window may have come near.
    let boxes = boxes_around(&case.slaves, LIMIT, 1);
    let window = whole.interface.window(&boxes, 0.1).unwrap();
    let mut part = self::part(&window, &case.slaves[..3], &whole.positions, case.options);
    for (moved, expected) in [(0.09, 0), (0.11, 3)] {
        let mut positions = part.positions.clone();
        positions[40][2] += moved;
        let report = part.interface.refresh_pairing(&positions).unwrap();
        assert_eq!(report.without.get("beyond-window").copied().unwrap_or(0), expected);
        part.interface.follow(&positions).unwrap();
        let contacts = part.interface.evaluate(Mode::Value).unwrap();
        let beyond = |outcome| matches!(outcome, Outcome::None(NoContact::BeyondWindow { .. }));
        assert_eq!(contacts.iter().filter(|contact| beyond(contact.outcome)).count(), expected);
    }
}

/// Slaves slide over the ridge and the border while the surface breathes, in windows that are made anew every other step.
#[test]
fn a_slide_across_all_parts_is_that_of_the_whole() {
    let case = Case::new(&[]);
    let mut whole = case.mesh.scene(&case.slaves, case.options);
    let partition = &partitions(&case.slaves, 4)[1];
    let mut parts: Vec<Part> = Vec::new();
    for step in 0..8 {
        let time = f64::from(step);
        for (node, x) in whole.positions.iter_mut().enumerate() {
            if node < whole.first {
                x[2] += 0.02 * (time + x[0]).sin();
            } else {
                (x[0], x[1]) = (x[0] + 0.31, x[1] - 0.13);
                x[2] = height(x[0], x[1]) + 0.05 * (time + f64::from(node as u32)).sin();
            }
        }
        whole.interface.renew_pairing(&whole.positions).unwrap();
        whole.interface.evaluate(Mode::Hessian).unwrap();
        let slaves = &whole.positions[whole.first..];
        if step % 2 == 0 {
            let part = |places: &Vec<usize>| {
                let own = chosen(slaves, places);
                // The slaves move by 0.34, the surface by 0.02 until the windows are made anew.
                let window = whole.interface.window(&boxes_around(&own, 1.2, 4), 0.025).unwrap();
                part(&window, &own, &whole.positions, case.options)
            };
            parts = partition.iter().map(part).collect();
        }
        for (part, places) in parts.iter_mut().zip(partition) {
            let numbers: Vec<u64> = part.window.nodes().collect();
            part.positions = numbers.iter().map(|&number| whole.positions[number as usize]).collect();
            part.positions.extend(chosen(slaves, places));
            part.interface.renew_pairing(&part.positions).unwrap();
            part.interface.evaluate(Mode::Hessian).unwrap();
            assert_eq!(compare(&whole, part, places), 0);
        }
    }
}

/// Lists that are kept, in a window as of the whole: slaves come nearer to what lies beyond the limit and beyond the window.
#[test]
fn lists_kept_in_a_window_have_the_bits_of_the_whole() {
    let case = Case::new(&[]);
    let mut random = Uniform(5);
    let mut whole = case.mesh.scene(&case.slaves, case.options);
    let mut kept = 0;
    let alone = |k: usize| {
        let [x, y, z] = case.slaves[k];
        let slave = [x, y, z + LIMIT];
        let window = whole.interface.window(&boxes_around(&[slave], 1.05 * LIMIT, 1), 0.01).unwrap();
        (k, slave, part(&window, &[slave], &whole.positions, case.options))
    };
    // Each in a window of its own.
    let mut parts: Vec<_> = (0..case.slaves.len()).step_by(5).map(alone).collect();
    for _ in 0..40 {
        for (k, slave, part) in &mut parts {
            *slave = [slave[0] + 0.02 * random.signed(), slave[1] + 0.02 * random.signed(), slave[2] - 0.01];
            let last = part.positions.len() - 1;
            part.positions[last] = *slave;
            whole.positions[whole.first + *k] = *slave;
        }
        whole.interface.renew_pairing(&whole.positions).unwrap();
        whole.interface.evaluate(Mode::Value).unwrap();
        for (k, slave, part) in &mut parts {
            kept += usize::from(!part.interface.refresh_pairing(&part.positions).unwrap().rebuilt);
            let [found, expected] =
                [part.interface.evaluate(Mode::Value).unwrap().get(0), whole.interface.contacts().get(*k)]
                    .map(|contact| (contact.outcome, contact.point.gap.to_bits()));
            let is_same = match (found.0, expected.0) {
                (Outcome::None(NoContact::BeyondWindow { .. }), _) => true,
                (Outcome::None(NoContact::TooFar { .. }), Outcome::None(NoContact::TooFar { .. })) => true,
                _ => found == expected,
            };
            assert!(is_same, "{k} {slave:?} {found:?} {expected:?}");
        }
    }
    assert!(kept > 300, "{kept}");
}

/// Slaves with multipliers of friction change windows and parts between two steps.
#[cfg(feature = "friction")]
#[test]
fn an_augmented_history_goes_with_its_slaves_to_other_windows() {
    let friction = Coulomb::new(0.3, 300.0).unwrap().with_augmentation(true);
    let law = ContactLaw::penalty(400.0).with_friction(Some(friction));
    let step = |interface: &mut ContactInterface, positions: &[Point]| {
        interface.renew_pairing(positions).unwrap();
        interface.evaluate(Mode::Gradient).unwrap();
        if interface.anchors().is_some() {
            interface.augment(&law, |_| true).unwrap();
            interface.evaluate(Mode::Gradient).unwrap();
        }
        interface.accept(&law).unwrap();
    };
    let case = Case::new(&[]);
    let mut whole = case.whole();
    let slide = |positions: &mut [Point]| {
        positions.iter_mut().for_each(|x| (x[0], x[1]) = (x[0] + 0.02, x[1] - 0.01))
    };
    step(&mut whole.interface, &whole.positions);
    slide(&mut whole.positions[whole.first..]);
    step(&mut whole.interface, &whole.positions);
    let history = whole.interface.history();
    let rows = split_history(&history).unwrap();
    // Those of slaves with multipliers begin with −2.
    assert!(rows.iter().filter(|row| row[0] == -2.0).count() > 50);
    let mut parts = Vec::new();
    for slaves in partitions(&case.slaves, 4).into_iter().flatten() {
        let own = chosen(&whole.positions[whole.first..], &slaves);
        let window = whole.interface.window(&boxes_around(&own, LIMIT + 0.1, 6), 0.0).unwrap();
        let mut part = part(&window, &own, &whole.positions, case.options);
        let own: Vec<f64> = slaves.iter().flat_map(|&k| rows[k]).copied().collect();
        part.interface.set_history(&own).unwrap();
        assert_eq!(part.interface.history(), own);
        // A node that is not in the window carries none.
        let first = slaves.iter().take_while(|&&k| rows[k] == [-1.0]).count();
        let mut foreign = own.clone();
        foreign[first + 2] = 1e6;
        let error = part.interface.set_history(&foreign).unwrap_err();
        assert_eq!(error, InterfaceError::CarrierBeyondWindow { index: first, node: 1_000_000 });
        assert_eq!((error.code(), part.interface.history()), ("foreign-carrier", own));
        parts.push((part, slaves));
    }
    slide(&mut whole.positions[whole.first..]);
    step(&mut whole.interface, &whole.positions);
    let next = whole.interface.history();
    assert_ne!(next, history);
    let next = split_history(&next).unwrap();
    for (part, slaves) in &mut parts {
        let first = part.window.nodes().len();
        slide(&mut part.positions[first..]);
        step(&mut part.interface, &part.positions);
        let found = part.interface.history();
        let found = split_history(&found).unwrap();
        assert!(found.into_iter().eq(slaves.iter().map(|&k| next[k])));
    }
}

/// What is not known of a slave ends no history.
#[cfg(feature = "friction")]
#[test]
fn slaves_beyond_their_window_keep_their_anchors() {
    let law = ContactLaw::penalty(400.0).with_friction(Coulomb::new(0.3, 300.0).ok());
    let case = Case::new(&[]);
    let whole = case.whole();
    let window = whole.interface.window(&boxes_around(&case.slaves, LIMIT, 1), 0.1).unwrap();
    let mut part = part(&window, &case.slaves, &whole.positions, case.options);
    part.interface.renew_pairing(&part.positions).unwrap();
    assert!(part.interface.accept(&law).unwrap().unanchored > 10);
    let history = part.interface.history();
    // The window is older than its skin.
    part.positions[40][2] += 0.11;
    part.interface.renew_pairing(&part.positions).unwrap();
    for law in [law, ContactLaw::penalty(400.0)] {
        let report = part.interface.accept(&law).unwrap();
        assert_eq!((report.dropped, part.interface.history()), (0, history.clone()));
    }
}

#[test]
fn windows_of_one_surface_join_and_others_are_refused() {
    let case = Case::new(&[]);
    let whole = case.whole();
    let boxes = boxes_around(&[[3.0, 4.0, height(3.0, 4.0)]], LIMIT, 3);
    let one = whole.interface.window(&boxes, 0.0).unwrap();
    assert_eq!(Window::joined(&[one.clone(), one.clone()]), Ok(one.clone()));
    let wider = whole.interface.window(&boxes, 0.1).unwrap();
    assert!(matches!(Window::joined(&[one.clone(), wider]), Err(WindowError::Differs { .. })));
    // A piece that is not there is missed.
    let (mut integers, reals) = one.to_numbers();
    assert!(Window::from_numbers(&integers[1..], &reals).is_err());
    assert!(Window::from_numbers(&integers, &reals[1..]).is_err());
    // Lists are searched: the last two nodes of one change places, or are the same.
    let last = integers.len() - 1;
    for pair in [[1, 0], [0, 0]] {
        let mut wrong = integers.clone();
        [wrong[last - 1], wrong[last]] = pair.map(|k| integers[last - 1 + k]);
        let Err(WindowError::Invalid { what: "listed node", .. }) = Window::from_numbers(&wrong, &reals)
        else {
            panic!("{pair:?}")
        };
    }
    // Both have a list of as many nodes, in order.
    let listed = |number: &i64| *number & i64::from(u32::MAX);
    let mut other = integers.clone();
    let gap =
        (integers.len() - 20..last).rev().find(|&k| listed(&integers[k]) + 1 < listed(&integers[k + 1]));
    other[gap.unwrap()] += 1;
    let other = Window::from_numbers(&other, &reals).unwrap();
    assert!(matches!(Window::joined(&[one.clone(), other]), Err(WindowError::Differs { what: "facet", .. })));
    // An extent that is no number does not hide a domain that is none.
    for place in [3, reals.len() - 1] {
        let mut wrong = reals.clone();
        (wrong[place], wrong[reals.len() - 2]) = (f64::NAN, f64::NAN);
        let place = place.min(reals.len() - 2);
        let error = WindowError::Invalid { what: "floating-point number", place };
        assert_eq!(Window::from_numbers(&integers, &wrong), Err(error));
    }
    let nodes = integers[5] as usize;
    assert_eq!(integers[5], integers[6], "no sharp edge");
    let mut wrong = integers.clone();
    wrong[10 + nodes + 1] = 2;
    let missed = WindowError::Invalid { what: "sheet node", place: 1 };
    assert_eq!(Window::from_numbers(&wrong, &reals), Err(missed));
    integers[10] = integers[11];
    assert_eq!(Window::from_numbers(&integers, &reals), Err(WindowError::Invalid { what: "node", place: 1 }),);
    // A window is for the options that it was made with, and the whole cannot be had from it.
    let mut part = part(&one, &case.slaves[..1], &whole.positions, case.options);
    let other = case.options.with_feature_angle_degrees(30.0);
    let slave = vec![part.positions.len() - 1];
    let made = |options| ContactInterface::in_window(&one, slave.clone(), &[], &part.positions, options);
    assert_eq!(made(other).unwrap_err(), InterfaceError::OtherThanWindow { what: "feature angle" });
    assert_eq!(made(hull_layers()).unwrap_err().code(), "window-needs-domains");
    let master: MasterSurface = part.interface.master().clone();
    assert!(master.is_part() && master.cut_edges().count() > 0);
    let again = ContactInterface::new(master, slave.clone(), &[], &part.positions, case.options);
    assert_eq!(again.unwrap_err().code(), "in-window");
    assert_eq!(part.interface.set_symmetry(&[]).unwrap_err().code(), "in-window");
    assert_eq!(part.interface.window(&boxes, 0.0).unwrap_err().code(), "in-window");
    let bad = [[0.0, 0.0, 0.0], [1.0, -1.0, 1.0]];
    assert_eq!(whole.interface.window(&[bad], 0.0).unwrap_err().code(), "invalid-box");
    assert_eq!(whole.interface.window(&boxes, f64::NAN).unwrap_err().code(), "invalid-box");
}

/// What a rank has of a surface: the facets that meet a box, with numbers of its own.
struct Rank {
    known: Box3,
    positions: Vec<Point>,
    node_numbers: Vec<u64>,
    facets: Vec<Facet>,
    facet_numbers: Vec<u64>,
    owned: Vec<bool>,
}

impl Rank {
    /// Nodes and facets of a whole surface are called by `name`, which keeps their order; here they come in the order against it.
    fn new(mesh: &Mesh, own: &[usize], width: f64, name: impl Fn(usize) -> u64) -> Self {
        let bounds = |corners: &[usize]| {
            let points: Vec<Point> = corners.iter().map(|&node| mesh.positions[node]).collect();
            boxes_around(&points, 0.0, 1)[0]
        };
        let corners: Vec<usize> =
            own.iter().flat_map(|&facet| mesh.facets[facet].corners()).copied().collect();
        let [low, high] = bounds(&corners);
        let known = [low.map(|x| x - width), high.map(|x| x + width)];
        let meets = |facet: &&usize| {
            let [low, high] = bounds(mesh.facets[**facet].corners());
            (0..3).all(|k| low[k] <= known[1][k] && known[0][k] <= high[k])
        };
        let mut all: Vec<usize> = (0..mesh.facets.len()).collect();
        all.retain(|facet| meets(&facet));
        all.reverse();
        let mut nodes: Vec<usize> =
            all.iter().flat_map(|&facet| mesh.facets[facet].corners()).copied().collect();
        nodes.sort_unstable_by(|x, y| y.cmp(x));
        nodes.dedup();
        let place = |node: usize| nodes.iter().position(|&own| own == node).unwrap();
        let facets = all.iter().map(|&facet| match mesh.facets[facet] {
            Facet::Triangle(corners) => Facet::Triangle(corners.map(place)),
            Facet::Quadrilateral(corners) => Facet::Quadrilateral(corners.map(place)),
        });
        Self {
            known,
            positions: nodes.iter().map(|&node| mesh.positions[node]).collect(),
            node_numbers: nodes.iter().map(|&node| name(node)).collect(),
            facets: facets.collect(),
            facet_numbers: all.iter().map(|&facet| name(facet)).collect(),
            owned: all.iter().map(|facet| own.contains(facet)).collect(),
        }
    }

    fn facets(&self, extents: Extents) -> PartFacets<'_> {
        let Self { known, positions, node_numbers, facets, facet_numbers, owned } = self;
        PartFacets { positions, node_numbers, facets, facet_numbers, owned, known: *known, extents }
    }

    fn is_beside(&self, other: &Self) -> bool {
        let ([low, high], [lower, upper]) = (self.known, other.known);
        (0..3).all(|k| low[k] <= upper[k] && lower[k] <= high[k])
    }
}

/// Nobody has the whole surface: domains are found part by part, and windows come from the owners of facets.
#[test]
fn windows_of_parts_are_those_of_the_whole() {
    let wide = |s: f64, t: f64| {
        let (x, y) = (40.0 * s, 5.0 * t);
        [x + 0.2 * (3.0 * x + y).sin() * (0.3 * x).sin(), y, 0.5 * height(0.6 * x, y)]
    };
    let mesh = Mesh::grid([41, 6], [false; 2], wide);
    check_parts(&mesh, [0, 130, 200]);
    let narrow = Rank::new(&mesh, &[100, 101], 1.5, |k| k as u64);
    let extents = narrow.facets(Extents::NONE).own_extents().unwrap();
    let error = SurfacePart::new(&narrow.facets(extents), &InterfaceOptions::default(), &[]).unwrap_err();
    assert_eq!(error, InterfaceError::Window(WindowError::TooNarrow { count: 2, facet: 100 }));
}

/// One row of cells has auxiliary points between its nodes.
#[test]
fn windows_of_parts_of_a_strip_are_those_of_the_whole() {
    let strip = |s: f64, t: f64| {
        let (x, y) = (40.0 * s, 1.5 * t);
        [x + 0.2 * (3.0 * x + y).sin() * (0.3 * x).sin(), y, 0.5 * height(0.6 * x, y)]
    };
    check_parts(&Mesh::grid([41, 2], [false; 2], strip), [0, 50, 70]);
}

/// `near`: nodes around which windows are cut.
fn check_parts(mesh: &Mesh, near: [usize; 3]) {
    let middle = |facet: &Facet| mesh.positions[facet.corners()[0]];
    let middles: Vec<Point> = mesh.facets.iter().map(middle).collect();
    for planes in [vec![], vec![SymmetryPlane::across(1, [0.0; 3])]] {
        let options = InterfaceOptions::default();
        let mut whole = mesh.scene(&[[3.0, 2.0, 1.0]], options);
        whole.interface.set_symmetry(&planes).unwrap();
        // As the surface has become, windows are cut out of it.
        let mut positions = whole.positions.clone();
        positions.iter_mut().for_each(|x| x[2] += 0.3 * x[0].sin());
        whole.interface.update(&positions).unwrap();
        let boxes = boxes_around(&near.map(|node| positions[node]), 0.7, 3);
        let expected = whole.interface.window(&boxes, 0.05).unwrap();
        for partition in &partitions(&middles, 4) {
            // Strips are long: the longest domain that a walk meets says how far it goes.
            let ranks: Vec<Rank> =
                partition.iter().map(|own| Rank::new(mesh, own, 16.0, |k| k as u64)).collect();
            let extents = ranks.iter().map(|rank| rank.facets(Extents::NONE).own_extents().unwrap());
            let extents = extents.fold(Extents::NONE, Extents::joined);
            let parts = ranks.iter().map(|rank| SurfacePart::new(&rank.facets(extents), &options, &planes));
            let mut parts: Vec<SurfacePart> = parts.map(Result::unwrap).collect();
            let here = |rank: &Rank| -> Vec<Point> {
                rank.node_numbers.iter().map(|&node| positions[node as usize]).collect()
            };
            for round in [false, true] {
                let demands: Vec<_> = parts.iter().map(SurfacePart::demands).collect();
                for (part, rank) in parts.iter_mut().zip(&ranks) {
                    let early = part.window(&here(rank), &boxes, 0.05).unwrap_err();
                    assert_eq!(early.code(), "invalid-window");
                    let beside = ranks.iter().zip(&demands).filter(|(other, _)| rank.is_beside(other));
                    let others: Vec<_> = beside.map(|(_, demands)| demands.clone()).collect();
                    assert_eq!(part.settle(&others).unwrap(), round);
                }
            }
            let windows = parts.iter().zip(&ranks).map(|(part, rank)| part.window(&here(rank), &boxes, 0.05));
            let windows: Vec<Window> = windows.map(Result::unwrap).collect();
            assert_eq!(Window::joined(&windows).unwrap(), expected);
        }
    }
}

#[test]
fn a_part_refuses_extents_that_are_not_of_the_whole_and_planes_that_cut_it() {
    let mesh = Mesh::grid([9, 9], [false; 2], |s, t| [8.0 * s, 8.0 * t, 0.0]);
    let options = InterfaceOptions::default();
    let all: Vec<usize> = (0..mesh.facets.len()).collect();
    let rank = Rank::new(&mesh, &all, 1.0, |k| k as u64);
    let own = rank.facets(Extents::NONE).own_extents().unwrap();
    let made = |extents, planes: &[SymmetryPlane]| {
        SurfacePart::new(&rank.facets(extents), &options, planes).map(drop)
    };
    assert_eq!(made(own, &[SymmetryPlane::across(0, [0.0; 3])]), Ok(()));
    let cut = made(own, &[SymmetryPlane::across(0, [4.0, 0.0, 0.0])]);
    assert_eq!(cut.unwrap_err().code(), "cut-by-symmetry");
    let low = [f64::NAN, 0.0, 0.0];
    let high = [8.0, 7.5, 0.0];
    for (given, expected) in [
        (Extents::NONE, "x"),
        (Extents { low, ..own }, "x"),
        (Extents { high, ..own }, "y"),
        (Extents { facet: 0.5, ..own }, "a facet"),
    ] {
        let error = made(given, &[]).unwrap_err();
        let InterfaceError::Window(WindowError::InvalidExtents { along, .. }) = error else {
            panic!("{error}")
        };
        assert_eq!(along, expected);
    }
    let nothing = PartFacets { facets: &[], facet_numbers: &[], owned: &[], ..rank.facets(Extents::NONE) };
    assert!(SurfacePart::new(&nothing, &options, &[]).is_ok());
}

#[test]
fn extents_are_those_of_sound_facets() {
    let mesh = Mesh::grid([3, 3], [false; 2], |s, t| [s, t, 0.0]);
    let mut rank = Rank::new(&mesh, &[0, 1, 2, 3], 1.0, |k| k as u64);
    let extents = rank.facets(Extents::NONE).own_extents();
    assert_eq!(extents, Ok(Extents { low: [0.0; 3], high: [1.0, 1.0, 0.0], facet: FRAC_1_SQRT_2 }));
    rank.positions[4][1] = f64::NAN;
    let error = rank.facets(Extents::NONE).own_extents().unwrap_err();
    assert_eq!(error.code(), "non-finite-position");
    rank.positions.truncate(4);
    let error = rank.facets(Extents::NONE).own_extents().unwrap_err();
    assert_eq!(error.code(), "node-out-of-range");
}
