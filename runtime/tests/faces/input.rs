//! Faces and positions that are refused, and shapes that are hard to cut.

use diffuse_contact::assembly::ContactLaw;
use diffuse_contact::faces::*;
use diffuse_contact::interface::{ContactElement, InterfaceError};
use diffuse_contact::surface::{Facet, SurfaceError, SymmetryPlane};
use diffuse_contact::{Mode, Point};

use super::{Pair, Second, bumps, bumps_of_second_order, elements};

/// Faces that stand there twice would carry twice the force.
#[test]
fn a_face_that_stands_there_twice_is_refused() {
    let both = [ContactElement::default(), ContactElement::NodeToFacet];
    for element in both {
        let mut pair = bumps(false);
        let again = pair.slave[3];
        for twin in [again, again.flipped()] {
            pair.slave.push(twin);
            let refused = pair.try_interface(element, FaceRule::Second).unwrap_err();
            assert!(matches!(refused, InterfaceError::Surface(_)), "{refused}");
            pair.slave.pop();
        }
    }
}

/// Of a rank that has none.
#[test]
fn without_faces_there_is_no_contact() {
    let mut pair = bumps(false);
    pair.slave.clear();
    for element in [ContactElement::default(), ContactElement::NodeToFacet] {
        let mut none = pair.interface(element, FaceRule::Second);
        none.set_symmetry(&[SymmetryPlane::across(0, [-0.1, 0.0, 0.0])]).unwrap();
        assert_eq!(none.refresh(&pair.positions).unwrap(), FaceReport::default());
        let contacts = none.evaluate(&ContactLaw::penalty(50.0), Mode::Hessian).unwrap();
        assert!(contacts.nodes().is_empty() && contacts.missed() == 0);
        assert_eq!(none.cliques().count(), 0);
    }
}

/// A node has moved over the diagonal of a facet, which is a dart then: facets still cover the plane.
#[test]
fn a_facet_that_has_become_concave_carries_its_whole_area() {
    let pair = Pair::new([6, 4], false, |x, y| [x, y, 0.0], |x, y| [x, y, -0.01]);
    let mut interface = pair.interface(ContactElement::default(), FaceRule::Second);
    for moved in [[-0.6, -0.6], [-0.6, 0.6], [0.6, -0.6], [0.6, 0.6]] {
        let mut positions = pair.positions.clone();
        let middle = 3 + 7 * 3;
        assert_eq!(positions[middle], [3.0, 3.0, 0.0]);
        (0..2).for_each(|axis| positions[middle][axis] += moved[axis]);
        interface.refresh(&positions).unwrap();
        let contacts = interface.evaluate(&ContactLaw::penalty(100.0), Mode::Gradient).unwrap();
        let force: f64 = contacts.nodes().iter().map(NodeContact::force).sum();
        assert!((force - 36.0).abs() < 1e-10 && contacts.missed() == 0, "{moved:?}: {force}");
    }
}

/// Nodes have moved over the next ones: points there have no result, while the faces over them stay loaded.
#[test]
fn points_of_loaded_faces_without_a_result_are_counted() {
    let pair = Pair::new([6, 4], false, |x, y| [x, y, 0.0], |x, y| [x, y, -0.01]);
    let mut interface = pair.interface(ContactElement::default(), FaceRule::Second);
    let force = |interface: &FaceInterface| -> f64 {
        interface.contacts().nodes().iter().map(NodeContact::force).sum()
    };
    // A facet that is folded onto an edge has no place for a point; where several are, the fit has no result.
    let one = vec![3 + 7 * 3];
    let three = [2, 3, 4].map(|row| 3 + 7 * row).to_vec();
    for (nodes, moved, expected) in [(&one, 0.9, 0), (&one, 1.0, 3), (&three, 1.3, 2)] {
        let mut positions = pair.positions.clone();
        nodes.iter().for_each(|&node| positions[node][0] -= moved);
        interface.refresh(&positions).unwrap();
        for mode in [Mode::Value, Mode::Gradient] {
            let missed = interface.evaluate(&ContactLaw::penalty(100.0), mode).unwrap().missed();
            assert_eq!((missed, force(&interface) < 35.9), (expected, expected > 0), "{moved}");
        }
    }
}

#[test]
fn nodes_between_corners_of_second_order_are_looked_at() {
    // Of facets between the corners alone, the middles are nodes of no facet.
    let (mut pair, faces) = bumps_of_second_order(Second::Quadrilateral8);
    let corners = |face: &QuadraticFace, is_slave: bool| {
        let facet = Facet::Quadrilateral(face.nodes()[..4].try_into().unwrap());
        if is_slave { facet.flipped() } else { facet }
    };
    let is_slave = |face: &&QuadraticFace| face.nodes()[0] >= pair.first_slave;
    let slave = faces.iter().filter(is_slave).map(|face| corners(face, true)).collect();
    let master = faces.iter().filter(|face| !is_slave(face)).map(|face| corners(face, false)).collect();
    (pair.slave, pair.master) = (slave, master);
    let mut interface = pair.interface(ContactElement::NodeToFacet, FaceRule::Second);
    interface.set_quadratic_faces(&faces).unwrap();
    interface.refresh(&pair.positions).unwrap();
    for face in [faces[0], *faces.last().unwrap()] {
        let middle = face.nodes()[4];
        let mut positions = pair.positions.clone();
        positions[middle][1] = f64::NAN;
        let refused = interface.update(&positions).unwrap_err();
        let expected = SurfaceError::NonFinitePosition { node: middle, value: f64::NAN };
        assert_eq!(format!("{refused:?}"), format!("{:?}", InterfaceError::Surface(expected)));
        // What is cut anew at a middle that has moved is what a refresh finds there.
        let mut positions: Vec<Point> = pair.positions.clone();
        positions[middle][0] += 0.1;
        interface.update(&positions).unwrap();
        let forces = |interface: &mut FaceInterface| {
            pair.forces(interface.evaluate(&ContactLaw::penalty(50.0), Mode::Gradient).unwrap())
        };
        let updated = forces(&mut interface);
        interface.refresh(&positions).unwrap();
        assert_eq!(updated, forces(&mut interface));
        interface.refresh(&pair.positions).unwrap();
        assert_ne!(updated, forces(&mut interface));
    }
}

#[test]
fn nodes_that_carry_pressure_are_counted_without_derivatives_too() {
    let pair = bumps(false);
    let mut interface = pair.interface(elements()[0], FaceRule::Second);
    interface.refresh(&pair.positions).unwrap();
    let [values, derived] = [Mode::Value, Mode::Gradient]
        .map(|mode| interface.evaluate(&ContactLaw::penalty(50.0), mode).unwrap().active());
    assert!(values == derived && values > 8, "{values} {derived}");
}
