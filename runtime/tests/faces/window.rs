//! Windows of both surfaces: nodes that know a part have the results of the whole, bit for bit, or say that they cannot know.

use std::collections::HashMap;

use diffuse_contact::Coulomb;
use diffuse_contact::friction::FrictionState;
use diffuse_contact::interface::{ContactInterface, NoContact, Outcome, split_history};
use diffuse_contact::surface::SymmetryPlane;
use diffuse_contact::surface::window::{Box3, Window, boxes_around};

use super::*;

const LIMIT: f64 = 0.5;
/// No face of the slave is wider.
const WIDE: f64 = 0.8;
/// How far the master moves at most before windows are made anew.
const SKIN: f64 = 0.1;

/// Wavy surfaces of irregular cells, one a little below the other.
fn pair(cells: Cells) -> (Pair, [Vec<QuadraticFace>; 2]) {
    let height = |x: f64, y: f64| 0.25 * (0.9 * x).sin() * (0.7 * y).cos();
    let inner = |x: f64| if x > 0.0 && x < 6.0 { 0.07 } else { 0.0 };
    let low = move |x: f64, y: f64| {
        let (x, y) = (x + inner(x) * (5.0 * y).sin(), y + inner(y) * (7.0 * x).cos());
        [x, y, height(x, y)]
    };
    let rise = |x: f64| if cells == Cells::Ridge { 1.1 * (x - 3.0).max(0.0) - 0.03 } else { 0.0 };
    let high = move |x: f64, y: f64| {
        let rise = rise(x);
        let (x, y) = (0.9 * x + 0.2 + inner(x) * (3.0 * y).cos(), 0.9 * y + 0.25);
        [x, y, height(x, y) - 0.02 + 0.04 * (2.0 * x).sin() + rise]
    };
    let Cells::Second(second) = cells else {
        return (Pair::new([11, 13], cells == Cells::Triangles, low, high), Default::default());
    };
    let mut pair = Pair::new([10, 14], false, low, high);
    let (master, below) = second.grid(10, 0, true);
    let (slave, above) = second.grid(14, pair.first_slave, false);
    (pair.master, pair.slave) = (master, slave);
    (pair, [below, above])
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cells {
    Quadrilaterals,
    Triangles,
    Second(Second),
    /// Quadrilaterals, those of the slave rise beyond a sharp edge.
    Ridge,
}

struct Whole {
    pair: Pair,
    /// Of second order, of the master and of the slave.
    quadratic: [Vec<QuadraticFace>; 2],
    options: FaceOptions,
    /// Of the whole surfaces, to cut windows from.
    master: ContactInterface,
    slave: ContactInterface,
    /// Where everything is.
    moved: Vec<Point>,
    interface: FaceInterface,
}

impl Whole {
    fn new(cells: Cells, planes: &[SymmetryPlane]) -> Self {
        let (pair, quadratic) = pair(cells);
        let options = InterfaceOptions::default().with_distance_limit(Some(LIMIT));
        let (options, positions) = (FaceOptions::new(options), &pair.positions);
        let surface = |facets: &[Facet]| {
            let surface = MasterSurface::new(positions, facets.to_vec()).unwrap();
            let mut made =
                ContactInterface::new(surface, Vec::new(), &[], positions, options.interface).unwrap();
            made.set_symmetry(planes).unwrap();
            made
        };
        let (master, slave) = (surface(&pair.master), surface(&pair.slave));
        let surface = MasterSurface::new(positions, pair.master.clone()).unwrap();
        let mut interface = FaceInterface::new(surface, &pair.slave, positions, options).unwrap();
        interface.set_symmetry(planes).unwrap();
        let [below, above] = &quadratic;
        interface.set_quadratic_faces_by_number(below, above).unwrap();
        let move_a_little = |(k, x): (usize, &Point)| {
            let t = 0.3 * k as f64;
            [x[0] + 0.03 * t.sin(), x[1] + 0.03 * t.cos(), x[2] + 0.03 * (2.0 * t).sin()]
        };
        let moved: Vec<Point> = positions.iter().enumerate().map(move_a_little).collect();
        interface.refresh(&moved).unwrap();
        Self { pair, quadratic, options, master, slave, moved, interface }
    }

    /// With pressures of these from here on, and so have its parts.
    fn set_pressures(&mut self, pressures: FacePressures) {
        self.options.pressures = pressures;
        self.interface.set_pressures(pressures);
    }

    /// Whether a face of the slave has both nodes.
    fn share_a_face(&self, one: usize, other: usize) -> bool {
        let faces = self.pair.slave.iter().map(|face| face.corners());
        let mut all = faces.chain(self.quadratic[1].iter().map(|face| face.nodes()));
        all.any(|nodes| nodes.contains(&one) && nodes.contains(&other))
    }

    fn evaluate(&mut self, mode: Mode) -> FaceContacts {
        self.interface.evaluate(&ContactLaw::penalty(100.0), mode).unwrap().clone()
    }

    /// An interface of these nodes of the slave, with numbers of the whole for its nodes. Boxes of the master reach `reach` beyond.
    fn part(&self, nodes: &[usize], reach: f64) -> (FaceInterface, Vec<usize>) {
        let place = |x: &Vec<Point>| nodes.iter().map(|&node| x[node]).collect::<Vec<_>>();
        let sent = |window: Window| {
            let (integers, reals) = window.to_numbers();
            Window::from_numbers(&integers, &reals).unwrap()
        };
        let boxes: Vec<Box3> = boxes_around(&place(&self.pair.positions), WIDE, 4);
        let slave = sent(self.slave.window(&boxes, 0.0).unwrap());
        let boxes = boxes_around(&place(&self.moved), reach, 4);
        let master = sent(self.master.window(&boxes, SKIN).unwrap());
        let numbers: Vec<usize> = master.nodes().chain(slave.nodes()).map(|node| node as usize).collect();
        let at = |positions: &[Point]| numbers.iter().map(|&node| positions[node]).collect::<Vec<_>>();
        let positions = at(&self.pair.positions);
        let mut interface = FaceInterface::in_window(&master, &slave, &positions, self.options).unwrap();
        assert!(interface.is_in_window());
        let [below, above] = &self.quadratic;
        interface.set_quadratic_faces_by_number(below, above).unwrap();
        interface.refresh(&at(&self.moved)).unwrap();
        (interface, numbers)
    }
}

/// The partitions that a kind of surface is compared for: all of the plainest, of others quarters, which have every kind of end.
fn compared(whole: &Whole, cells: Cells, planes: &[SymmetryPlane]) -> Vec<(usize, Vec<Vec<usize>>)> {
    let is_plain = cells == Cells::Quadrilaterals && planes.is_empty();
    let all = partitions(&whole.pair).into_iter().enumerate();
    all.filter(|&(which, _)| is_plain || which == 1).collect()
}

/// The nodes of the slave in four parts: strips, quarters, and by number.
fn partitions(pair: &Pair) -> [Vec<Vec<usize>>; 3] {
    let mut nodes: Vec<usize> = pair.slave.iter().flat_map(|face| face.corners()).copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    let by = |part: &dyn Fn(usize) -> usize| {
        (0..4).map(|k| nodes.iter().copied().filter(|&node| part(node) == k).collect()).collect()
    };
    let x = |node: usize, axis: usize| pair.positions[node][axis];
    [
        by(&|node| ((x(node, 0) / 6.0 * 4.0) as usize).min(3)),
        by(&|node| usize::from(x(node, 0) > 3.0) + 2 * usize::from(x(node, 1) > 3.0)),
        by(&|node| node % 4),
    ]
}

/// Everything that a node has, in bits.
fn bits(node: &NodeContact) -> (Outcome, Vec<u64>) {
    let of_pressure = [node.gap, node.smallest_gap, node.area, node.pressure, node.stiffness, node.slip];
    let numbers = [&of_pressure[..], &node.normal, &node.friction].concat();
    (node.outcome, numbers.into_iter().map(f64::to_bits).collect())
}

/// Slips of the test are 0.01 to 0.03, pressures about 5.
fn friction() -> ContactLaw<'static> {
    ContactLaw::penalty(100.0).with_friction(Some(Coulomb::new(0.2, 25.0).unwrap()))
}

/// The slaves by the numbers of their nodes in the whole, each with the number of its sheet at the node.
fn names(interface: &FaceInterface, numbers: &[usize]) -> Vec<(usize, usize)> {
    let slaves = interface.slaves();
    // Few nodes are in two sheets.
    let sheet = |k: usize| slaves[..k].iter().rev().take_while(|&&node| node == slaves[k]).count();
    (0..slaves.len()).map(|k| (numbers[slaves[k]], sheet(k))).collect()
}

/// The contact of each slave by its name in the whole.
fn by_name(
    interface: &FaceInterface,
    numbers: &[usize],
    contacts: &[NodeContact],
) -> HashMap<(usize, usize), NodeContact> {
    names(interface, numbers).into_iter().zip(contacts.iter().copied()).collect()
}

/// The history of each slave by its name in the whole.
fn histories(interface: &FaceInterface, numbers: &[usize]) -> HashMap<(usize, usize), Vec<f64>> {
    let history = interface.history();
    let parts = split_history(&history).unwrap();
    let (pairs, []) = parts.as_chunks::<2>() else { unreachable!("two points of each node") };
    names(interface, numbers).into_iter().zip(pairs).map(|(name, pair)| (name, pair.concat())).collect()
}

fn is_known(history: &[f64], numbers: &[usize]) -> bool {
    let points = split_history(history).unwrap();
    let carriers = points.iter().flat_map(|point| point.get(2..).unwrap_or_default().chunks(3));
    carriers.map(|carrier| carrier[0] as usize).all(|node| numbers.contains(&node))
}

/// Hands over what nodes have stuck to, as far as the windows have it.
fn go_on(part: &mut FaceInterface, numbers: &[usize], histories: &HashMap<(usize, usize), Vec<f64>>) {
    let of_slave = |name: (usize, usize)| {
        let own = &histories[&name];
        if is_known(own, numbers) { own.clone() } else { vec![-1.0, -1.0] }
    };
    let history: Vec<f64> = names(part, numbers).into_iter().flat_map(of_slave).collect();
    part.set_history(&history).unwrap();
}

/// The slave slides, by less than the skin.
fn slid(whole: &Whole) -> Vec<Point> {
    let slide = |(k, &[x, y, z]): (usize, &Point)| {
        if k < whole.pair.first_slave {
            return [x, y, z];
        }
        let way = 0.02 * (1.0 + (0.4 * x).sin());
        [x + way, y - 0.3 * way, z - 0.005]
    };
    whole.moved.iter().enumerate().map(slide).collect()
}

#[test]
fn any_partition_of_the_nodes_goes_on_with_friction_as_the_whole() {
    let across = SymmetryPlane::across(0, [0.0; 3]);
    let second = Cells::Second(Second::Quadrilateral8);
    for (cells, planes) in [
        (Cells::Quadrilaterals, vec![]),
        (Cells::Triangles, vec![across]),
        (second, vec![]),
        (Cells::Ridge, vec![]),
    ] {
        let mut whole = Whole::new(cells, &planes);
        let all: Vec<usize> = (0..whole.pair.positions.len()).collect();
        whole.interface.accept(&friction()).unwrap();
        let before = histories(&whole.interface, &all);
        let slid = slid(&whole);
        whole.interface.refresh(&slid).unwrap();
        let expected = whole.interface.evaluate(&friction(), Mode::Value).unwrap().nodes().to_vec();
        let of_whole = by_name(&whole.interface, &all, &expected);
        let count = |state| expected.iter().filter(|node| node.friction_state == state).count();
        let (stick, slip) = (count(FrictionState::Stick), count(FrictionState::Slip));
        assert!(stick > 5 && slip > 20, "{cells:?} {stick} {slip}");
        whole.interface.accept(&friction()).unwrap();
        let after = histories(&whole.interface, &all);
        for (which, parts) in &compared(&whole, cells, &planes) {
            for own in parts {
                let (mut part, numbers) = whole.part(own, WIDE + LIMIT + SKIN);
                go_on(&mut part, &numbers, &before);
                let at: Vec<Point> = numbers.iter().map(|&node| slid[node]).collect();
                part.refresh(&at).unwrap();
                let found = part.evaluate(&friction(), Mode::Value).unwrap().nodes().to_vec();
                for (name @ (number, _), node) in by_name(&part, &numbers, &found) {
                    if own.contains(&number) {
                        let exact = &of_whole[&name];
                        assert_eq!(node.friction_state, exact.friction_state);
                        assert_eq!(bits(&node), bits(exact), "node {name:?}, partition {which} {planes:?}");
                    }
                }
                part.accept(&friction()).unwrap();
                let found = histories(&part, &numbers);
                for (name, after) in after.iter().filter(|((number, _), _)| own.contains(number)) {
                    assert_eq!(found[name], *after, "node {name:?}, partition {which}");
                }
            }
        }
    }
}

#[test]
fn a_history_of_nodes_beyond_the_windows_is_refused() {
    let mut whole = Whole::new(Cells::Quadrilaterals, &[]);
    let all: Vec<usize> = (0..whole.pair.positions.len()).collect();
    whole.interface.accept(&friction()).unwrap();
    let histories = histories(&whole.interface, &all);
    let own = &partitions(&whole.pair)[1][0];
    let (mut part, numbers) = whole.part(own, WIDE + LIMIT + SKIN);
    go_on(&mut part, &numbers, &histories);
    let kept = part.history();
    let foreign = histories.values().find(|own| !is_known(own, &numbers)).unwrap();
    let of_node = |k: usize| if k == 0 { foreign.clone() } else { vec![-1.0, -1.0] };
    let history: Vec<f64> = (0..part.slaves().len()).flat_map(of_node).collect();
    assert_eq!(part.set_history(&history).unwrap_err().code(), "foreign-carrier");
    assert_eq!(part.history(), kept);
}

#[test]
fn any_partition_of_the_nodes_has_the_bits_of_the_whole() {
    let across = SymmetryPlane::across(0, [0.0; 3]);
    let plain = [Cells::Quadrilaterals, Cells::Triangles, Cells::Ridge].map(|cells| (cells, vec![]));
    let of_second = Second::ALL.map(|second| (Cells::Second(second), vec![]));
    let symmetric =
        [Cells::Quadrilaterals, Cells::Second(Second::Triangle6)].map(|cells| (cells, vec![across]));
    let all = plain.into_iter().chain(of_second).chain(symmetric).map(|own| (own, FacePressures::Nodes));
    let by_points = ((Cells::Triangles, vec![]), FacePressures::Points);
    for ((cells, planes), pressures) in all.chain([by_points]) {
        let mut whole = Whole::new(cells, &planes);
        whole.set_pressures(pressures);
        let expected = whole.evaluate(Mode::Value);
        let all: Vec<usize> = (0..whole.pair.positions.len()).collect();
        let of_whole = by_name(&whole.interface, &all, expected.nodes());
        let pressed = expected.nodes().iter().filter(|node| node.pressure > 0.0).count();
        assert!(pressed > 60, "{cells:?} {pressed}");
        for (which, parts) in &compared(&whole, cells, &planes) {
            for own in parts {
                let (mut part, numbers) = whole.part(own, WIDE + LIMIT + SKIN);
                let found = part.evaluate(&ContactLaw::penalty(100.0), Mode::Value).unwrap().nodes().to_vec();
                let mut count = 0;
                for (name @ (number, _), node) in by_name(&part, &numbers, &found) {
                    let is_own = own.contains(&number);
                    count += usize::from(is_own);
                    let is_beyond = matches!(node.outcome, Outcome::None(NoContact::BeyondWindow { .. }));
                    assert!(!(is_own && is_beyond), "{:?}: node {number}, partition {which}", node.outcome);
                    if is_beyond {
                        assert_eq!((node.pressure, node.area), (0.0, 0.0));
                    } else {
                        let exact = &of_whole[&name];
                        assert_eq!(bits(&node), bits(exact), "node {name:?}, partition {which} {planes:?}");
                    }
                }
                assert_eq!(count, of_whole.keys().filter(|(number, _)| own.contains(number)).count());
            }
        }
    }
}

/// Rows of nodes whose neighbours are known have the forces and the tangent of the whole.
#[test]
fn rows_inside_a_part_are_those_of_the_whole() {
    for law in [ContactLaw::penalty(100.0), friction()] {
        for pressures in FacePressures::ALL {
            assert_rows(&law, Cells::Quadrilaterals, pressures);
        }
        let second = Second::ALL.into_iter().map(Cells::Second);
        second.for_each(|cells| assert_rows(&law, cells, FacePressures::Nodes));
    }
}

fn assert_rows(law: &ContactLaw<'_>, cells: Cells, pressures: FacePressures) {
    let mut whole = Whole::new(cells, &[]);
    whole.set_pressures(pressures);
    let own = &partitions(&whole.pair)[1][0];
    let (mut part, numbers) = whole.part(own, 2.0 * WIDE + LIMIT + SKIN);
    whole.interface.accept(law).unwrap();
    let all: Vec<usize> = (0..whole.pair.positions.len()).collect();
    if law.friction.is_some() {
        go_on(&mut part, &numbers, &histories(&whole.interface, &all));
    }
    let slid = slid(&whole);
    whole.interface.refresh(&slid).unwrap();
    part.refresh(&numbers.iter().map(|&node| slid[node]).collect::<Vec<_>>()).unwrap();
    let expected = whole.interface.evaluate(law, Mode::Hessian).unwrap().clone();
    let contacts = part.evaluate(law, Mode::Hessian).unwrap().clone();
    let is_beyond = |contact: &NodeContact| contact.outcome.code() == "beyond-window";
    let beyond: Vec<usize> =
        contacts.nodes().iter().filter(|node| is_beyond(node)).map(|node| node.slave).collect();
    let is_known =
        |node: usize| !beyond.iter().any(|&other| whole.share_a_face(numbers[other], numbers[node]));
    let (all, here) = (whole.pair.positions.len(), numbers.len());
    let v = |number: usize, axis: usize| (0.7 * (3 * number + axis) as f64).sin();
    let of_whole: Vec<f64> = (0..3 * all).map(|k| v(k / 3, k % 3)).collect();
    let of_part: Vec<f64> = (0..3 * here).map(|k| v(numbers[k / 3], k % 3)).collect();
    let results = |contacts: &FaceContacts, v: &[f64]| {
        let dofs = DofMap::standard(v.len() / 3);
        let (mut forces, mut product) = (vec![0.0; v.len()], vec![0.0; v.len()]);
        contacts.add_forces(&dofs, &mut forces).unwrap();
        contacts.add_product(Tangent::Exact, &dofs, v, &mut product).unwrap();
        [forces, product]
    };
    let (exact, found) = (results(&expected, &of_whole), results(&contacts, &of_part));
    let mut compared = 0;
    for &node in part.slaves().iter().filter(|&&node| own.contains(&numbers[node]) && is_known(node)) {
        for (exact, found) in exact.iter().zip(&found) {
            let largest = exact.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
            for axis in 0..3 {
                let error = (exact[3 * numbers[node] + axis] - found[3 * node + axis]).abs();
                assert!(error <= 1e-14 * largest, "{error:e} of {largest:e}");
            }
        }
        compared += 1;
    }
    assert!(compared > 20, "{compared}");
}

#[test]
fn narrow_boxes_say_so_and_give_no_other_number() {
    let mut whole = Whole::new(Cells::Quadrilaterals, &[]);
    let expected = whole.evaluate(Mode::Value);
    let of_whole: HashMap<usize, NodeContact> =
        expected.nodes().iter().map(|node| (node.slave, *node)).collect();
    let mut seen = [0; 2];
    for own in &partitions(&whole.pair)[1] {
        let (mut part, numbers) = whole.part(own, 0.6);
        for node in part.evaluate(&ContactLaw::penalty(100.0), Mode::Value).unwrap().nodes() {
            if let Outcome::None(NoContact::BeyondWindow { needed, known }) = node.outcome {
                assert!(needed > known && node.pressure == 0.0, "{needed} {known}");
                seen[0] += 1;
            } else {
                assert_eq!(bits(node), bits(&of_whole[&numbers[node.slave]]));
                seen[1] += 1;
            }
        }
        // Older than its skin a window knows nothing.
        let mut far: Vec<Point> = numbers.iter().map(|&node| whole.moved[node]).collect();
        far[0][2] -= 2.0 * SKIN;
        part.update(&far).unwrap();
        let found = part.evaluate(&ContactLaw::penalty(100.0), Mode::Value).unwrap();
        let is_beyond = |node: &NodeContact| node.outcome.code() == "beyond-window";
        assert!(found.nodes().iter().all(is_beyond));
    }
    assert!(seen[0] > 50 && seen[1] > 50, "{seen:?}");
}

/// What is not known of a node ends no history.
#[test]
fn nodes_beyond_their_window_keep_their_history() {
    let whole = Whole::new(Cells::Quadrilaterals, &[]);
    let own = &partitions(&whole.pair)[1][0];
    let (mut part, numbers) = whole.part(own, WIDE + LIMIT + SKIN);
    assert!(part.accept(&friction()).unwrap().unanchored > 10);
    let history = part.history();
    let mut far: Vec<Point> = numbers.iter().map(|&node| whole.moved[node]).collect();
    far[0][2] -= 2.0 * SKIN;
    part.update(&far).unwrap();
    for law in [friction(), ContactLaw::penalty(100.0)] {
        let report = part.accept(&law).unwrap();
        assert_eq!((report.dropped, part.history()), (0, history.clone()));
    }
}

/// A face of second order with a node that nobody has is known to be one: no force goes by its facets instead.
#[test]
fn faces_of_second_order_beyond_the_window_say_so() {
    for side in [0, 1] {
        let mut whole = Whole::new(Cells::Second(Second::Quadrilateral9), &[]);
        let expected = whole.evaluate(Mode::Value);
        let of_whole: HashMap<usize, NodeContact> =
            expected.nodes().iter().map(|node| (node.slave, *node)).collect();
        let own = &partitions(&whole.pair)[1][0];
        // The outermost node of the face at the corner of the surface: three of four facets do not have it.
        let face = &mut whole.quadratic[side][0];
        let (centre, rest) = (face.nodes()[8], &face.nodes()[1..]);
        *face = QuadraticFace::new(&[&[1_000_000], rest].concat()).unwrap();
        let place = Vector3::from(whole.moved[centre]);
        let (mut part, numbers) = whole.part(own, WIDE + LIMIT + SKIN);
        let found = part.evaluate(&ContactLaw::penalty(100.0), Mode::Value).unwrap();
        let (mut near, mut far) = (0, 0);
        for node in found.nodes().iter().filter(|node| own.contains(&numbers[node.slave])) {
            if let Outcome::None(NoContact::BeyondWindow { needed, known }) = node.outcome {
                let distance = (Vector3::from(whole.moved[numbers[node.slave]]) - place).norm();
                assert!(needed > known && node.pressure == 0.0 && distance < 2.0, "{distance}");
                near += 1;
            } else {
                assert_eq!(bits(node), bits(&of_whole[&numbers[node.slave]]));
                far += 1;
            }
        }
        assert!(near >= 8 && far > 20, "{side}: {near} {far}");
        let twice = QuadraticFace::new(&[0, 1, 2, 3, 4, 1]).unwrap();
        let error = part.set_quadratic_faces_by_number(&[], &[twice]).unwrap_err();
        assert!(matches!(error, InterfaceError::Surface(_)), "{error}");
    }
}

#[test]
fn what_takes_the_whole_is_refused() {
    let whole = Whole::new(Cells::Quadrilaterals, &[]);
    let own = &partitions(&whole.pair)[1][0];
    let (mut part, _) = whole.part(own, 2.0);
    let refused = |error: InterfaceError| assert_eq!(error.code(), "in-window");
    refused(part.set_symmetry(&[]).unwrap_err());
    refused(part.set_quadratic_faces(&[]).unwrap_err());

    let place = |k: usize| whole.pair.positions[k];
    let boxes = boxes_around(&own.iter().map(|&k| place(k)).collect::<Vec<_>>(), 1.0, 4);
    let [master, slave] = [&whole.master, &whole.slave].map(|side| side.window(&boxes, SKIN).unwrap());
    let positions: Vec<Point> = master.nodes().chain(slave.nodes()).map(|k| place(k as usize)).collect();
    let made = |positions: &[Point], options: FaceOptions| {
        FaceInterface::in_window(&master, &slave, positions, options).map(drop).unwrap_err().code()
    };
    assert_eq!(made(&positions[1..], whole.options), "wrong-number-of-positions");
    let unlimited = FaceOptions::new(InterfaceOptions::default());
    assert_eq!(made(&positions, unlimited), "invalid-option");
    let element = ContactElement::diffuse(diffuse_contact::neighbourhood::SearchOptions::domains());
    let other = element.with_weight(Weight::WendlandC2);
    let other = FaceOptions::new(whole.options.interface.with_element(other));
    assert_eq!(made(&positions, other), "other-than-window");
    let facets = FaceOptions::new(whole.options.interface.with_element(ContactElement::NodeToFacet));
    assert_eq!(made(&positions, facets), "window-needs-domains");
}
