//! Lists that are kept from one refresh to the next: the pairing is that which the positions alone have.

use std::f64::consts::{PI, TAU};

use diffuse_contact::interface::{ContactElement, InterfaceOptions, Outcome};
use diffuse_contact::neighbourhood::{NeighbourRule, SearchOptions};
use diffuse_contact::surface::{Facet, SymmetryPlane};
use diffuse_contact::{Mode, Point};

use crate::common::{Mesh, Scene, Uniform};
use crate::self_contact::both;

/// How the slaves fare, and their gaps; 0 without contact.
fn all_found(scene: &mut Scene) -> Vec<(Outcome, f64)> {
    let contacts = scene.interface.evaluate(Mode::Value).unwrap().iter();
    let gap = |is_contact: bool, gap: f64| if is_contact { gap } else { 0.0 };
    contacts.map(|contact| (contact.outcome, gap(contact.outcome.is_contact(), contact.point.gap))).collect()
}

/// The first of them.
fn found(scene: &mut Scene) -> (Outcome, f64) {
    all_found(scene)[0]
}

/// Slaves walk about, by less than lists last, in boxes around what they meet. Returns how many lists were kept, and how many were made.
fn walk(mesh: &Mesh, options: InterfaceOptions, centre: Point, half: Point, step: f64) -> [usize; 2] {
    walk_within(0.0, mesh, options, (centre, half), step)
}

/// The same, with gaps that are equal to this.
fn walk_within(
    rounding: f64,
    mesh: &Mesh,
    options: InterfaceOptions,
    (centre, half): (Point, Point),
    step: f64,
) -> [usize; 2] {
    let mut random = Uniform(21);
    let mut counts = [0; 2];
    let start = |random: &mut Uniform| [0, 1, 2].map(|axis| centre[axis] + half[axis] * random.signed());
    let mut slaves: Vec<Point> = (0..40).map(|_| start(&mut random)).collect();
    let [mut kept, mut anew] = [(); 2].map(|()| mesh.paired(&slaves, options));
    for _ in 0..60 {
        for x in &mut slaves {
            let way = [(); 3].map(|()| step * random.signed());
            *x = [0, 1, 2].map(|axis| {
                (x[axis] + way[axis] - centre[axis]).clamp(-half[axis], half[axis]) + centre[axis]
            });
        }
        kept.move_slaves(&slaves);
        anew.move_slaves(&slaves);
        let report = kept.refresh();
        counts[0] += report.kept;
        counts[1] += report.paired - report.kept;
        anew.interface.renew_pairing(&anew.positions).unwrap();
        let [ones, others] = [&mut kept, &mut anew].map(all_found);
        for ((x, one), other) in slaves.iter().zip(ones).zip(others) {
            assert!(one.0 == other.0 && (one.1 - other.1).abs() <= rounding, "{x:?} {one:?} {other:?}");
        }
    }
    counts
}

/// On the bisector of a groove either side is the closest, at every place: only the slave there is listed in each iteration.
#[test]
fn lists_of_others_stay_where_one_slave_has_two_sheets() {
    let groove = Mesh::grid([9, 9], [false; 2], |s, t| [8.0 * s - 4.0, 8.0 * t - 4.0, (8.0 * s - 4.0).abs()]);
    let mut scene = groove.paired(&[[0.0, 0.1, 0.5], [3.0, 0.2, 3.3]], InterfaceOptions::default());
    let report = scene.refresh();
    assert_eq!((report.rebuilt, report.paired, report.kept, report.renewed), (true, 2, 1, 1));
    assert!(!scene.interface.follow(&scene.positions).unwrap(), "the lists are the same");
}

#[test]
fn at_sharp_edges_the_face_is_that_of_the_place() {
    let block = Mesh::block([8; 3], [4.0; 3]);
    let [kept, made] = walk(&block, InterfaceOptions::default(), [4.0, 0.3, 4.0], [0.2, 0.5, 0.2], 0.03);
    assert!(kept > made && made > 100, "{kept} {made}");
    // At a corner, and over nodes.
    let [kept, made] = walk(&block, InterfaceOptions::default(), [4.0; 3], [0.2; 3], 0.03);
    assert!(kept > 600 && made > 100, "{kept} {made}");
}

/// Facets that meet at up to 40°: a slave's place leaves the skin of its list before the slave has moved as far.
#[test]
fn on_coarse_rollers_it_is_that_of_the_place() {
    for sides in [9, 12, 16] {
        let roller = Mesh::grid([sides, 7], [true, false], |s, t| {
            let (sin, cos) = (TAU * s).sin_cos();
            [cos, sin, PI * t]
        });
        let [kept, _] = walk(&roller, InterfaceOptions::default(), [0.95, 0.0, 0.1], [0.08, 0.5, 0.1], 0.01);
        assert_eq!(kept > 0, sides == 16, "{sides}: {kept}");
    }
}

/// So it is where facets meet only their images, as those of a roof that is cut along its ridge.
#[test]
fn on_coarse_facets_beside_a_plane_of_symmetry_it_is_that_of_the_place() {
    for (slope, lists_are_kept) in [(0.3, false), (0.1, true)] {
        let roof = Mesh::grid([6, 6], [false; 2], |s, t| [6.0 * s, 6.0 * t, -6.0 * slope * s]);
        let mut scene = roof.paired(&[[0.3, 3.1, 0.05]], InterfaceOptions::default());
        scene.interface.set_symmetry(&[SymmetryPlane::across(0, [0.0; 3])]).unwrap();
        assert_eq!(scene.refresh().paired, 1);
        scene.move_slaves(&[[0.301, 3.1, 0.05]]);
        assert_eq!(scene.refresh().kept > 0, lists_are_kept, "{slope}");
    }
}

/// The same bits, whatever nodes took part on the way to a slave's place.
#[test]
fn over_moved_nodes_it_is_that_of_the_place() {
    let mut random = Uniform(4);
    let mut mesh = Mesh::grid([9, 9], [false; 2], |s, t| {
        let [x, y] = [8.0 * s, 8.0 * t];
        [x, y, 0.1 * x.sin() * (0.7 * y).cos()]
    });
    mesh.positions.iter_mut().for_each(|x| (0..2).for_each(|axis| x[axis] += 0.15 * random.signed()));
    let [kept, made] = walk(&mesh, InterfaceOptions::default(), [4.0, 3.4, 0.0], [2.5, 2.5, 0.1], 0.01);
    assert!(kept > 1000 && made > 10, "{kept} {made}");
}

#[test]
fn between_two_walls_the_wall_is_that_of_the_place() {
    let low = Mesh::plane(8.0, 8.0, 1.0);
    let mut high = low.clone();
    high.positions.iter_mut().for_each(|x| x[2] += 0.2);
    high.facets = high.facets.iter().map(|facet| facet.flipped()).collect();
    let [x, y, _] = low.positions[40];
    let half = [0.5, 0.5, 0.3];
    let [kept, made] = walk(&both(&low, &high), InterfaceOptions::default(), [x, y, 0.1], half, 0.02);
    assert!(kept > 600 && made > 200, "{kept} {made}");
}

#[test]
fn where_a_basis_carries_it_is_that_of_the_place() {
    // A square, and at its side one long facet, which carries no quadratic surface.
    let height = |x: f64| 0.1 * (0.8 * x).sin();
    let mut mesh = Mesh::grid([9, 9], [false; 2], |s, t| [8.0 * s, 8.0 * t, height(8.0 * s)]);
    let next = [0, 1].map(|row| mesh.positions.len() + row);
    mesh.positions.extend([3.0, 4.0].map(|y| [16.0, y, height(16.0)]));
    mesh.facets.push(Facet::Quadrilateral([8 + 9 * 3, next[0], next[1], 8 + 9 * 4]));
    for falls_back in [true, false] {
        let search =
            SearchOptions::default().with_rule(NeighbourRule::Domains).with_linear_fallback(falls_back);
        let options = InterfaceOptions::default().with_element(ContactElement::diffuse(search));
        let [kept, made] = walk_within(1e-15, &mesh, options, ([9.0, 3.5, 0.0], [2.5, 0.4, 0.4]), 0.05);
        assert!(kept > 300 && made > 100, "{kept} {made}");
    }
}

/// A slave that was pushed into a thin plate stays below the side from which it came, and every node within reach is listed.
#[test]
fn a_slave_that_follows_below_a_side_has_the_gap_to_that_side() {
    let wave = |[x, y, z]: Point| [x, y, z + 0.2 * (0.7 * x).sin() * (0.6 * y).cos()];
    let mut plate = Mesh::block([16, 16, 1], [8.0, 8.0, 0.05]);
    let is_above: Vec<bool> = plate.positions.iter().map(|x| x[2] > 0.0).collect();
    plate.positions = plate.positions.into_iter().map(wave).collect();
    let mut side = plate.clone();
    side.facets.retain(|facet| facet.corners().iter().all(|&node| is_above[node]));
    let place = |depth: f64, x: f64| wave([x, 0.4 * x, 0.05 - depth]);
    let options = InterfaceOptions::default();
    let [mut of_plate, mut of_side] = [&plate, &side].map(|mesh| mesh.paired(&[place(-0.01, -2.0)], options));
    for step in 0..=100 {
        let slave = place(0.07, -2.0 + 0.04 * f64::from(step));
        for scene in [&mut of_plate, &mut of_side] {
            scene.move_slaves(&[slave]);
            scene.interface.follow(&scene.positions).unwrap();
        }
        let [one, other] = [&mut of_plate, &mut of_side].map(found);
        assert!(one.0.is_contact(), "{slave:?} {:?}", one.0);
        assert!((one.1 - other.1).abs() < 1e-12, "{slave:?} {one:?} {other:?}");
    }
    // Paired anew, it has come out below.
    let slave = place(0.07, 2.0);
    of_plate.move_slaves(&[slave]);
    let report = of_plate.refresh();
    let jump = report.largest_gap_jump.expect("it is on another sheet");
    assert!((jump.before + 0.07).abs() < 0.005 && (jump.after + 0.03).abs() < 0.005, "{jump:?}");
    let gap = of_plate.interface.evaluate(Mode::Value).unwrap().get(0).point.gap;
    assert!((gap + 0.03).abs() < 0.005, "{gap}");
}
