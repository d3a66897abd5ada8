//! A surface in contact with itself over its faces: what a face may touch, pressures of both sides, balance.

use diffuse_contact::assembly::{ContactLaw, DofMap};
use diffuse_contact::faces::{FaceContacts, FaceInterface, FaceOptions};
use diffuse_contact::interface::{InterfaceError, InterfaceOptions};
use diffuse_contact::surface::tributary_areas;
use diffuse_contact::{Mode, Point};

use super::common::{Mesh, Uniform};
use super::self_contact::{both, elements, hairpin};

/// Half of it is the law's: both sides push.
const PENALTY: f64 = 100.0;

fn law() -> ContactLaw<'static> {
    ContactLaw::penalty(0.5 * PENALTY)
}

fn own(mesh: &Mesh, options: InterfaceOptions) -> FaceInterface {
    FaceInterface::self_contact(mesh.surface(), &mesh.positions, FaceOptions::new(options)).unwrap()
}

/// The node of each slave, its gap if there is something over all of its faces, and the part of its area over others.
fn gaps(interface: &mut FaceInterface, positions: &[Point]) -> Vec<(usize, Option<f64>, f64)> {
    interface.refresh(positions).unwrap();
    let areas = interface.areas().to_vec();
    let contacts = interface.evaluate(&law(), Mode::Value).unwrap();
    let gap = |(node, area): (&diffuse_contact::faces::NodeContact, f64)| {
        (node.slave, node.outcome.is_contact().then_some(node.gap), node.area / area)
    };
    contacts.nodes().iter().zip(areas).map(gap).collect()
}

fn forces(contacts: &FaceContacts, nodes: usize) -> Vec<Point> {
    let mut forces = vec![0.0; 3 * nodes];
    contacts.add_forces(&DofMap::standard(nodes), &mut forces).unwrap();
    forces.as_chunks::<3>().0.to_vec()
}

#[test]
fn legs_of_a_fold_touch_one_another_and_not_themselves() {
    for options in elements() {
        let mesh = hairpin(8.0, 1.0, 22);
        let mut interface = own(&mesh, options);
        for (node, gap, covered) in &gaps(&mut interface, &mesh.positions) {
            let [x, _, z] = &mesh.positions[*node];
            if *x < -3.0 && *x > -7.0 {
                assert!((gap.unwrap() - 1.0).abs() < 0.05 && *covered > 0.99, "{x} {z} {gap:?} {covered}");
            }
        }
        let mut pressed = mesh.clone();
        pressed.positions.iter_mut().filter(|x| x[0] < 0.0).for_each(|x| x[2] *= -0.05);
        for (node, gap, _) in &gaps(&mut interface, &pressed.positions) {
            let [x, ..] = &mesh.positions[*node];
            if *x < -3.0 && *x > -7.0 {
                assert!((gap.unwrap() + 0.05).abs() < 1e-3, "{x} {gap:?}");
            }
        }
    }
}

#[test]
fn the_back_of_a_thin_wall_is_never_touched() {
    for options in elements() {
        let mesh = Mesh::block([8, 8, 1], [4.0, 4.0, 0.1]);
        let mut interface = own(&mesh, options);
        assert!(gaps(&mut interface, &mesh.positions).iter().all(|(_, gap, _)| gap.is_none()));
        let mut dented = mesh.positions.clone();
        dented.iter_mut().filter(|x| x[2] > 0.0).for_each(|x| x[2] -= 0.05);
        assert!(gaps(&mut interface, &dented).iter().all(|(_, gap, _)| gap.is_none()));
    }
}

/// Each penetrates the next one by the same depth. The meshes do not match: every node carries what its shape function has of the
/// pressure on either side, and the plates do not see through one another.
#[test]
fn a_uniform_pressure_passes_through_plates_on_one_another() {
    let depth = 0.02;
    for options in elements() {
        let plate = |z: f64, cells: usize| {
            let mut plate = Mesh::block([cells, cells, 1], [4.0, 4.0, 0.1]);
            plate.positions.iter_mut().for_each(|x| x[2] += z);
            plate
        };
        let mesh = both(&both(&plate(0.0, 8), &plate(0.2 - depth, 7)), &plate(0.4 - 2.0 * depth, 9));
        let mut interface = own(&mesh, options);
        for (node, gap, covered) in &gaps(&mut interface, &mesh.positions) {
            let [x, y, z] = &mesh.positions[*node];
            if x.abs().max(y.abs()) < 3.0 {
                let is_outside = !(-0.05..=0.41).contains(z);
                assert_eq!(gap.is_none(), is_outside, "{x} {y} {z} {gap:?}");
                assert!(gap.is_none_or(|gap| (gap + depth).abs() < 1e-9 && (covered - 1.0).abs() < 1e-9));
            }
        }
        let contacts = interface.evaluate(&law(), Mode::Gradient).unwrap();
        assert_eq!(contacts.missed(), 0);
        let areas = tributary_areas(&mesh.positions, &mesh.facets).unwrap();
        for ((force, [x, y, z]), area) in
            forces(contacts, mesh.positions.len()).iter().zip(&mesh.positions).zip(areas)
        {
            if x.abs().max(y.abs()) > 2.5 {
                continue;
            }
            // Of the faces that are pressed, those on top are pushed down.
            let sign = match *z {
                z if !(-0.05..=0.41).contains(&z) => 0.0,
                z if [0.1, 0.3 - depth].iter().any(|top| (z - top).abs() < 1e-9) => -1.0,
                _ => 1.0,
            };
            let expected = sign * PENALTY * depth * area;
            assert!(
                (force[2] - expected).abs() < 1e-9 && force[0].hypot(force[1]) < 1e-9,
                "{force:?} {expected}"
            );
        }
    }
}

/// Two blocks whose faces lie on one another in the beginning; then the upper one rises and slides.
#[test]
fn bodies_in_touch_from_the_start_have_surfaces_of_their_own() {
    for options in elements() {
        let lower = Mesh::block([4, 4, 2], [2.0, 2.0, 0.5]);
        let mut upper = lower.clone();
        upper.positions.iter_mut().for_each(|x| x[2] += 1.0);
        let mesh = both(&lower, &upper);
        let mut interface = own(&mesh, options);
        let mut lifted = mesh.positions.clone();
        lifted[lower.positions.len()..].iter_mut().for_each(|x| *x = [x[0] + 0.3, x[1], x[2] + 0.1]);
        let mut seen = 0;
        for (node, gap, _) in &gaps(&mut interface, &lifted) {
            let [x, y, z] = &lifted[*node];
            if x.abs().max(y.abs()) < 1.5 && [0.5, 0.6].iter().any(|face| (z - face).abs() < 1e-9) {
                assert!((gap.unwrap() - 0.1).abs() < 1e-9, "{x} {y} {z} {gap:?}");
                seen += 1;
            }
        }
        assert!(seen >= 15, "{seen}");
    }
}

/// A tube squeezed to less than nothing, its nodes moved at random.
fn squeezed() -> (Mesh, Vec<Point>) {
    let mut random = Uniform(7);
    let mesh = Mesh::grid([24, 6], [true, false], |s, t| {
        let (sine, cosine) = (std::f64::consts::TAU * s).sin_cos();
        // Seen from inside.
        [-3.0 * sine, 4.0 * t, 3.0 * cosine]
    });
    let mut positions = mesh.positions.clone();
    for x in &mut positions {
        x[2] *= -0.02;
        x.iter_mut().for_each(|x| *x += 1e-2 * random.signed());
    }
    (mesh, positions)
}

#[test]
fn forces_of_a_surface_on_itself_are_in_balance() {
    for options in elements() {
        let (mesh, positions) = squeezed();
        let mut interface = own(&mesh, options);
        interface.refresh(&positions).unwrap();
        let found = forces(interface.evaluate(&law(), Mode::Gradient).unwrap(), positions.len());
        let size: f64 = found.iter().flatten().map(|force| force.abs()).sum();
        assert!(size > 10.0, "{size}");
        for axis in 0..3 {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            let sum: f64 = found.iter().map(|force| force[axis]).sum();
            let moment = |(x, force): (&Point, &Point)| x[next] * force[last] - x[last] * force[next];
            let moment: f64 = positions.iter().zip(&found).map(moment).sum();
            assert!(sum.abs() < 1e-13 * size && moment.abs() < 1e-12 * size, "{sum} {moment} {size}");
        }
    }
}

/// Numbers of nodes and facets give nobody a role.
#[test]
fn no_side_has_a_role() {
    for options in elements() {
        let (mesh, positions) = squeezed();
        let count = positions.len();
        let turned = |facet: &diffuse_contact::surface::Facet| {
            let corners: Vec<usize> = facet.corners().iter().map(|&node| count - 1 - node).collect();
            match *corners {
                [a, b, c] => diffuse_contact::surface::Facet::Triangle([a, b, c]),
                [a, b, c, d] => diffuse_contact::surface::Facet::Quadrilateral([a, b, c, d]),
                _ => unreachable!("facets have three or four corners"),
            }
        };
        let backward = Mesh {
            positions: mesh.positions.iter().rev().copied().collect(),
            facets: mesh.facets.iter().rev().map(turned).collect(),
        };
        let at = |mesh: &Mesh, positions: &[Point]| {
            let mut interface = own(mesh, options);
            interface.refresh(positions).unwrap();
            forces(interface.evaluate(&law(), Mode::Gradient).unwrap(), count)
        };
        let reversed: Vec<Point> = positions.iter().rev().copied().collect();
        let (one, other) = (at(&mesh, &positions), at(&backward, &reversed));
        assert!(one.iter().map(|force| force[2].abs()).sum::<f64>() > 10.0);
        for (one, other) in one.iter().zip(other.iter().rev()) {
            let error = (0..3).map(|axis| (one[axis] - other[axis]).abs()).fold(0.0, crate::common::worse);
            assert!(error < 1e-9, "{one:?} {other:?}");
        }
    }
}

#[test]
fn what_is_no_surface_is_refused() {
    let mesh = Mesh::plane(4.0, 4.0, 1.0);
    let options = FaceOptions::new(InterfaceOptions::default());
    assert!(FaceInterface::self_contact(mesh.surface(), &mesh.positions[..5], options).is_err());
    let bad = FaceOptions::new(InterfaceOptions::default().with_distance_limit(Some(-1.0)));
    let error = FaceInterface::self_contact(mesh.surface(), &mesh.positions, bad).unwrap_err();
    assert!(matches!(error, InterfaceError::InvalidOption { name: "distance_limit", .. }), "{error}");
    let other = FaceOptions::new(super::common::hull_layers());
    let error = FaceInterface::self_contact(mesh.surface(), &mesh.positions, other).unwrap_err();
    assert_eq!(error, InterfaceError::FacesNeedDomains);
}
