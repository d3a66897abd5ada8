//! Who is paired with whom: refresh reports, tributary areas.

use crate::common::{Mesh, Scene, Uniform, distance, hull_layers};
use diffuse_contact::interface::{
    ContactElement, ContactInterface, GapJump, InterfaceError, InterfaceOptions, NoContact, Outcome,
    RefreshReport, SlaveGap,
};
use diffuse_contact::neighbourhood::{NeighbourRule, SearchOptions};
use diffuse_contact::surface::{Facet, tributary_areas};
use diffuse_contact::{FrameDerivative, Mode, Point};

/// A bumpy floor of 20 × 20 cells.
fn floor() -> Mesh {
    Mesh::grid([21, 21], [false; 2], |s, t| {
        let [x, y] = [20.0 * s, 20.0 * t];
        [x, y, 0.3 * (0.7 * x).sin() * (0.5 * y).cos()]
    })
}

/// Slaves over the inner part of the floor.
fn over_floor(count: usize) -> Vec<Point> {
    let mut random = Uniform(2);
    (0..count).map(|_| [3.0 + 12.0 * random.next(), 3.0 + 12.0 * random.next(), 0.4]).collect()
}

fn gaps(scene: &mut Scene) -> Vec<Option<f64>> {
    let contacts = scene.interface.evaluate(Mode::Value).unwrap();
    contacts.iter().map(|contact| contact.outcome.is_contact().then_some(contact.point.gap)).collect()
}

#[test]
fn a_report_counts_every_slave() {
    let options = hull_layers().with_distance_limit(Some(2.0));
    let slaves = [over_floor(50), vec![[9.0, 9.0, 5.0], [-7.0, 9.0, 0.0], [30.0, 5.0, 0.1]]].concat();
    let mut scene = floor().scene(&slaves, options);
    assert_eq!(scene.interface.evaluate(Mode::Value).err(), Some(InterfaceError::NotRefreshed));
    assert_eq!(scene.interface.for_each(Mode::Value, |_| ()), Err(InterfaceError::NotRefreshed));
    let report = scene.refresh();
    assert_eq!((report.paired, report.gained, report.lost), (50, 50, 0));
    assert_eq!(report.without.iter().collect::<Vec<_>>(), [(&"too-far", &3)]);
    assert_eq!(report.fallbacks.none, 50);
    assert_eq!(report.largest_gap_jump, None);

    let again = scene.refresh();
    assert_eq!((again.paired, again.renewed, again.gained), (50, 50, 0));
    assert_eq!(again.largest_gap_jump, None);

    // One leaves, one comes.
    scene.positions[scene.first] = [4.0, 4.0, 7.0];
    scene.positions[scene.first + 50] = [9.0, 9.0, 0.5];
    let moved = scene.refresh();
    assert_eq!((moved.paired, moved.renewed, moved.gained, moved.lost), (50, 49, 1, 1));
    let outcome = scene.interface.evaluate(Mode::Value).unwrap().get(0).outcome;
    assert!(matches!(outcome, Outcome::None(NoContact::TooFar { limit: 2.0, distance }) if distance > 6.0));
}

/// Where no slave has a list, or others have larger domains around them, a slave that comes near is paired as soon as it is.
#[test]
fn a_slave_without_a_list_gets_one_as_soon_as_it_is_near() {
    let mesh = Mesh::plane(10.0, 10.0, 1.0);
    let limited = InterfaceOptions::default().with_distance_limit(Some(1.0));
    for (options, away) in [(limited, [5.0, 5.0, 5.0]), (InterfaceOptions::default(), [13.0, 5.0, -0.1])] {
        let mut scene = mesh.paired(&[away], options);
        assert_eq!(scene.interface.refresh_pairing(&scene.positions).unwrap().paired, 0);
        scene.move_slaves(&[[5.0, 5.0, -0.1]]);
        assert_eq!(scene.interface.refresh_pairing(&scene.positions).unwrap().paired, 1, "{away:?}");
        scene.move_slaves(&[away]);
        assert!(scene.interface.follow(&scene.positions).unwrap());
        scene.move_slaves(&[[5.0, 5.0, -0.1]]);
        assert!(scene.interface.follow(&scene.positions).unwrap());
        assert!((gaps(&mut scene)[0].unwrap() + 0.1).abs() < 1e-12);
    }
    let mut scene = mesh.paired(&[[3.0, 3.0, 0.1], [5.0, 5.0, 1.005]], limited);
    scene.move_slaves(&[[3.0, 3.0, 0.1], [5.0, 5.0, 1.001]]);
    assert!(!scene.interface.follow(&scene.positions).unwrap());
    scene.move_slaves(&[[3.0, 3.0, 0.1], [5.0, 5.0, 0.999]]);
    assert!(scene.interface.follow(&scene.positions).unwrap());
    assert!((gaps(&mut scene)[1].unwrap() - 0.999).abs() < 1e-12);
}

/// Nobody is told where the master's outside is: a refresh counts those that lie deep inside.
#[test]
fn slaves_of_a_master_inside_out_are_deep() {
    let slaves = [[3.0, 3.0, 0.3], [4.5, 3.2, 0.05], [6.0, 5.0, -0.05], [7.0, 5.0, -0.3]];
    let mut mesh = Mesh::plane(10.0, 10.0, 1.0);
    for (rule, options) in [("domains", InterfaceOptions::default()), ("hull layers", hull_layers())] {
        let mut scene = mesh.paired(&slaves, options);
        // Triangles are smaller than squares: a tenth of their size is 0.07.
        assert_eq!(scene.refresh().deep, 1, "{rule}");
    }
    mesh.facets.iter_mut().for_each(|facet| *facet = facet.flipped());
    let mut scene = mesh.paired(&slaves, InterfaceOptions::default());
    let kept = scene.refresh();
    assert_eq!((kept.kept, kept.deep), (4, 1), "as of the pairing");
    scene.move_slaves(&slaves.map(|[x, y, z]| [x, y, z + 1.0]));
    assert_eq!(scene.refresh().deep, 4, "all of them now");
}

#[test]
fn the_gap_jump_of_a_refresh_is_the_largest_there_was() {
    let slaves = over_floor(200);
    let mut scene = floor().paired(&slaves, hull_layers());
    let slid: Vec<Point> = slaves.iter().map(|[x, y, z]| [x + 0.6, y + 0.45, *z]).collect();
    scene.move_slaves(&slid);
    scene.update();
    let before = gaps(&mut scene);
    let report = scene.refresh();
    let after = gaps(&mut scene);
    assert_eq!(report.paired, report.kept + report.renewed + report.changed + report.gained);
    assert!(report.changed > 100, "{report:?}");
    let jumps = before.iter().zip(&after).enumerate().filter_map(|(k, (before, after))| {
        Some(GapJump { slave: scene.first + k, before: (*before)?, after: (*after)? })
    });
    let largest = jumps.max_by(|a, b| a.size().total_cmp(&b.size())).unwrap();
    assert_eq!(report.largest_gap_jump, Some(largest));
    assert!(largest.size() > 1e-4 && largest.size() < 0.05, "{largest:?}");
}

#[test]
fn a_refresh_in_place_pairs_everybody_as_before() {
    let mut scene = floor().paired(&over_floor(80), hull_layers());
    let before = gaps(&mut scene);
    let report = scene.refresh();
    assert_eq!((report.kept, report.renewed, report.changed), (0, 80, 0));
    assert_eq!(report.largest_gap_jump, None);
    assert_eq!(gaps(&mut scene), before);
}

#[test]
fn a_held_frame_is_that_of_the_last_refresh() {
    let search = SearchOptions::default();
    let element = ContactElement::diffuse(search).with_frame(FrameDerivative::Held);
    let options = hull_layers().with_element(element);
    let mut scene = floor().paired(&over_floor(1), options);
    let before = gaps(&mut scene)[0].unwrap();
    // Turned by 20° about x, the held frame is not the average plane any more, and the gap not quite the same.
    let (s, c) = 20f64.to_radians().sin_cos();
    for x in &mut scene.positions {
        *x = [x[0], c * x[1] - s * x[2], s * x[1] + c * x[2]];
    }
    scene.update();
    let held = gaps(&mut scene)[0].unwrap();
    let report = scene.refresh();
    assert_eq!(report.renewed, 1);
    let renewed = gaps(&mut scene)[0].unwrap();
    assert!((held - before).abs() > 1e-6 && (renewed - before).abs() < 1e-12, "{before} {held} {renewed}");
    let jump = report.largest_gap_jump.unwrap();
    assert_eq!((jump.before, jump.after), (held, renewed));
}

#[test]
fn areas_are_those_of_the_slave_facets() {
    let mut positions = floor().positions;
    let first = positions.len();
    let plate = Mesh::plane(6.0, 4.0, 0.5);
    positions.extend(plate.positions.iter().map(|[x, y, _]| [x + 4.0, y + 4.0, 0.5]));
    let facets: Vec<Facet> = plate
        .facets
        .iter()
        .map(|facet| match facet {
            Facet::Triangle(corners) => Facet::Triangle(corners.map(|k| k + first)),
            Facet::Quadrilateral(corners) => Facet::Quadrilateral(corners.map(|k| k + first)),
        })
        .collect();
    let slaves: Vec<usize> = (first..positions.len()).collect();
    let interface = |areas: bool, facets: &[Facet], slaves: &[usize]| {
        let options = hull_layers().with_areas(areas);
        ContactInterface::new(floor().surface(), slaves.to_vec(), facets, &positions, options)
    };
    let mut with = interface(true, &facets, &slaves).unwrap();
    with.refresh_pairing(&positions).unwrap();
    let contacts = with.evaluate(Mode::Value).unwrap();
    let total: f64 = contacts.iter().map(|contact| contact.area).sum();
    assert!((total - 24.0).abs() < 1e-12, "{total}");
    let nodal = tributary_areas(&positions, &facets).unwrap();
    assert!(contacts.iter().all(|contact| contact.area == nodal[contact.slave]));
    let mut without = interface(false, &facets, &slaves).unwrap();
    without.refresh_pairing(&positions).unwrap();
    assert!(without.evaluate(Mode::Value).unwrap().iter().all(|contact| contact.area == 1.0));
    assert_eq!(interface(true, &[], &slaves).unwrap_err().code(), "slave-without-area");
    assert_eq!(interface(true, &facets[1..], &slaves).err().map(|error| error.code()), None);
}

#[test]
fn a_slave_moves_on_with_masters_that_move() {
    // The floor is drawn to the side under the slave, which changes partners from refresh to refresh.
    let mut scene = floor().paired(&[[10.0, 10.0, 0.4]], hull_layers());
    let (mut changed, mut last) = (0, gaps(&mut scene)[0].unwrap());
    for _ in 0..40 {
        for x in &mut scene.positions[..scene.first] {
            x[0] -= 0.1;
        }
        let report = scene.refresh();
        changed += report.changed;
        let gap = gaps(&mut scene)[0].unwrap();
        assert!((gap - last).abs() < 0.05);
        last = gap;
    }
    assert!((3..40).contains(&changed), "{changed}");
    let nodes = scene.interface.evaluate(Mode::Value).unwrap().get(0).nodes;
    assert!(nodes.iter().all(|&node| distance(scene.positions[node as usize], [10.0, 10.0, 0.0]) < 4.0));
}

#[test]
fn a_pairing_learns_that_its_patch_has_come_to_end() {
    // Unit squares over 0 ≤ x, y ≤ 20. The slave's masters end at some x, and there the plate is folded down by 60°:
    // neither they nor the fit change. Three layers carry a fit from the fold, too.
    let search = SearchOptions::default().with_rule(NeighbourRule::hull_radius(Some(3)));
    let frame = FrameDerivative::CoMoving;
    let element = ContactElement::diffuse(search).with_frame(frame);
    let options = hull_layers().with_element(element);
    let mut scene = Mesh::plane(20.0, 20.0, 1.0).paired(&[[9.6, 9.6, -0.1]], options);
    let nodes = scene.interface.evaluate(Mode::Value).unwrap().get(0).nodes.to_vec();
    let fold = nodes.iter().map(|&node| scene.positions[node as usize][0]).fold(0.0, f64::max);
    assert!(fold < 16.0);
    let (s, c) = 60f64.to_radians().sin_cos();
    for x in &mut scene.positions[..scene.first] {
        let past = (x[0] - fold).max(0.0);
        *x = [x[0].min(fold) + c * past, x[1], -s * past];
    }
    assert_eq!(scene.refresh().renewed, 1);
    assert!((gaps(&mut scene)[0].unwrap() + 0.1).abs() < 1e-12);
    for (past, expected) in [(-0.1, "contact"), (0.1, "beyond-border")] {
        scene.move_slaves(&[[fold + past, 9.6, -0.1]]);
        scene.update();
        let outcome = scene.interface.evaluate(Mode::Value).unwrap().get(0).outcome;
        assert_eq!(outcome.code(), expected, "{past} {outcome:?}");
    }
}

#[test]
fn a_contact_that_a_refresh_loses_or_gains_is_reported() {
    let mut scene = Mesh::cube(8)
        .scene(&[[0.9, 0.1, 0.97], [0.2, 0.3, 0.95]], hull_layers().with_distance_limit(Some(0.5)));
    let report = scene.refresh();
    assert_eq!((report.contacts_gained, report.contacts_lost), (2, 0));
    let deepest = report.smallest_gap_gained.unwrap();
    assert!(deepest.slave == scene.first + 1 && (deepest.gap + 0.05).abs() < 1e-12, "{deepest:?}");
    let report = scene.refresh();
    assert_eq!((report.renewed, report.contacts_gained, report.contacts_lost), (2, 0, 0));
    assert_eq!((report.smallest_gap_gained, report.smallest_gap_lost), (None, None));

    // One loses its pairing, at a gap of 1 by the old one; the other keeps a pairing that is no contact.
    scene.move_slaves(&[[1.02, 0.1, 1.02], [0.2, 0.3, 2.0]]);
    scene.update();
    let before = gaps(&mut scene);
    assert!(before[0].is_none() && (before[1].unwrap() - 1.0).abs() < 1e-12, "{before:?}");
    let report = scene.refresh();
    assert_eq!((report.paired, report.lost, report.contacts_lost, report.contacts_gained), (1, 1, 1, 0));
    assert_eq!(report.smallest_gap_lost, Some(SlaveGap { slave: scene.first + 1, gap: before[1].unwrap() }));
}

/// Lists that follow lose contacts between two refreshes, and nobody else tells of them.
#[test]
fn contacts_that_following_loses_are_in_the_next_report() {
    let options = InterfaceOptions::default().with_distance_limit(Some(1.0));
    let places = [[5.0, 5.0, -0.1], [3.0, 3.0, -0.1], [7.0, 4.0, -0.2]];
    let [below, deeper] = [1.2, 1.5].map(|depth| [[5.0, 5.0, -depth], [3.0, 3.0, -0.1], [7.0, 4.0, -1.1]]);
    let mut scene = Mesh::plane(10.0, 10.0, 1.0).paired(&places, options);
    let first = scene.first;
    let follow = |scene: &mut Scene, slaves: &[Point]| {
        scene.move_slaves(slaves);
        scene.interface.follow(&scene.positions).unwrap()
    };
    let counts = |report: &RefreshReport| (report.contacts_lost, report.contacts_gained, report.lost);
    for renews in [false, true] {
        assert!(follow(&mut scene, &below));
        follow(&mut scene, &deeper);
        let report = match renews {
            true => scene.interface.renew_pairing(&scene.positions).unwrap(),
            false => scene.refresh(),
        };
        assert_eq!(counts(&report), (2, 0, 0));
        assert_eq!(report.smallest_gap_lost.map(|lost| lost.slave), Some(first));
        assert!((report.smallest_gap_lost.unwrap().gap + 1.2).abs() < 1e-12);
        let again = scene.refresh();
        assert_eq!((counts(&again), again.smallest_gap_lost), ((0, 0, 0), None), "once");

        // What came back is not lost, whether it came back before the refresh or by it.
        scene.move_slaves(&places);
        assert_eq!(counts(&scene.refresh()), (0, 2, 0));
        follow(&mut scene, &below);
        follow(&mut scene, &places);
        assert_eq!(counts(&scene.refresh()), (0, 0, 0));
        follow(&mut scene, &below);
        scene.move_slaves(&[places[0], places[1], below[2]]);
        assert_eq!(counts(&scene.refresh()), (1, 1, 0));
        scene.move_slaves(&places);
        scene.refresh();
    }
    // What an attempt gained and lost again was not there at the refresh.
    let apart = [[5.0, 5.0, 1.4], places[1], places[2]];
    scene.move_slaves(&apart);
    scene.refresh();
    follow(&mut scene, &places);
    follow(&mut scene, &[[5.0, 5.0, -1.2], places[1], places[2]]);
    scene.move_slaves(&apart);
    assert_eq!(counts(&scene.refresh()), (0, 0, 0));
    scene.move_slaves(&places);
    scene.refresh();
    // A refused refresh reports nothing, so that the next one does.
    follow(&mut scene, &below);
    assert!(scene.interface.refresh_pairing(&scene.positions[1..]).is_err());
    assert_eq!(scene.refresh().contacts_lost, 2);
}

#[test]
fn a_contact_that_a_new_crease_takes_away_is_reported() {
    // The plate is folded by 60° at x = 6 below a slave that has slid on past it, seen as penetrating by the old pairing.
    let mut scene = Mesh::plane(12.0, 12.0, 1.0).paired(&[[5.6, 5.6, -0.3]], hull_layers());
    let (s, c) = 60f64.to_radians().sin_cos();
    for x in &mut scene.positions[..scene.first] {
        let past = (x[0] - 6.0).max(0.0);
        *x = [x[0].min(6.0) + c * past, x[1], s * past];
    }
    // Outside is above: the fold is concave, and the slave beneath both sides.
    scene.move_slaves(&[[6.3, 5.6, -0.3]]);
    scene.update();
    let before = gaps(&mut scene)[0];
    let report = scene.refresh();
    let after = gaps(&mut scene)[0];
    assert!(before.is_some_and(|gap| gap < 0.0) && after.is_none(), "{before:?} {after:?}");
    assert_eq!((report.contacts_lost, report.largest_gap_jump), (1, None));
    assert_eq!(report.smallest_gap_lost, before.map(|gap| SlaveGap { slave: scene.first, gap }));
}

#[test]
fn a_refresh_that_fails_leaves_everything_as_it_was() {
    let mut scene = floor().paired(&over_floor(40), hull_layers());
    let before = gaps(&mut scene);
    let nodes = |scene: &mut Scene| {
        let contacts = scene.interface.evaluate(Mode::Value).unwrap();
        contacts.iter().map(|contact| contact.nodes.to_vec()).collect::<Vec<_>>()
    };
    let paired = nodes(&mut scene);
    let moved: Vec<Point> = scene.positions.iter().map(|[x, y, z]| [x + 3.0, 0.5 * y, *z]).collect();
    for (node, code) in [(7, "non-finite-position"), (scene.first + 39, "non-finite-position")] {
        let mut positions = moved.clone();
        positions[node][1] = f64::NAN;
        assert_eq!(scene.interface.refresh_pairing(&positions).unwrap_err().code(), code);
        assert_eq!((gaps(&mut scene), nodes(&mut scene)), (before.clone(), paired.clone()));
    }
    let error = scene.interface.refresh_pairing(&moved[1..]).unwrap_err();
    assert_eq!(error.code(), "wrong-number-of-positions");
    assert_eq!((gaps(&mut scene), nodes(&mut scene)), (before, paired));
}
