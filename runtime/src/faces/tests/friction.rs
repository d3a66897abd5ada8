//! Friction over faces.

use super::*;
use crate::Coulomb;
use crate::friction::FrictionState;

/// Pressures of the bumps are about 5 at this penalty, slips 0.02.
const STIFFNESS: f64 = 60.0;

fn law() -> ContactLaw<'static> {
    ContactLaw::penalty(50.0).with_friction(Some(Coulomb::new(0.3, STIFFNESS).unwrap()))
}

/// The bumps after the slave has moved, turned and partly closed, since the last accepted step.
fn moved(pair: &Pair, by: f64) -> Vec<Point> {
    let moved = |(k, &[x, y, z]): (usize, &Point)| {
        if k < pair.first_slave {
            return [x, y, z];
        }
        let (a, b) = (x - 3.0, y - 3.0);
        [x + by * (0.005 + 0.02 * b), y - by * 0.015 * a, z - by * (0.03 + 0.005 * y)]
    };
    pair.positions.iter().enumerate().map(moved).collect()
}

/// An interface with a history, moved: contacts stick, slide, and have closed.
fn interface(pair: &Pair, element: ContactElement, faces: &[QuadraticFace]) -> FaceInterface {
    let mut interface = pair.interface(element, FaceRule::Second);
    interface.set_quadratic_faces(faces).unwrap();
    assert_eq!(interface.accept(&law()), Err(InterfaceError::NotRefreshed));
    interface.refresh(&pair.positions).unwrap();
    assert!(interface.history().is_empty());
    let report = interface.accept(&law()).unwrap();
    assert!(report.unanchored > 8 && report.stuck + report.sliding == 0);
    interface.refresh(&moved(pair, 1.0)).unwrap();
    let nodes = interface.evaluate(&law(), Mode::Value).unwrap().nodes();
    let count = |state| nodes.iter().filter(|node| node.friction_state == state).count();
    let [stick, slip, closed] = [
        count(FrictionState::Stick),
        count(FrictionState::Slip),
        nodes.iter().filter(|node| node.pressure > 0.0).count() - report.unanchored,
    ];
    assert!(stick > 0 && slip > 4 && closed > 1, "{stick} {slip} {closed}");
    interface
}

#[test]
fn forces_and_moments_balance_with_friction() {
    for element in elements() {
        for triangles in [false, true] {
            let pair = bumps(triangles);
            let mut interface = interface(&pair, element, &[]);
            let without = interface.evaluate(&ContactLaw::penalty(50.0), Mode::Gradient).unwrap().clone();
            let contacts = interface.evaluate(&law(), Mode::Gradient).unwrap();
            let forces = pair.forces(contacts);
            let friction: f64 =
                forces.iter().zip(pair.forces(&without)).map(|(x, y)| (x[0] - y[0]).abs()).sum();
            assert!(friction > 5.0);
            let moved = Pair { positions: moved(&pair, 1.0), ..pair };
            moved.assert_balance(&forces);
        }
    }
}

#[test]
fn the_tangent_with_friction_is_exact_with_the_points_held() {
    for (element, triangles) in elements().into_iter().zip([false, true, false, true]) {
        let pair = bumps(triangles);
        assert_tangent(&pair, interface(&pair, element, &[]));
    }
    for second in Second::ALL {
        let (pair, faces) = bumps_of_second_order(second);
        assert_tangent(&pair, interface(&pair, ContactElement::default(), &faces));
    }
}

fn assert_tangent(pair: &Pair, mut interface: FaceInterface) {
    let positions = moved(pair, 1.0);
    let dofs = DofMap::standard(positions.len());
    let size = dofs.equations();
    let mut dense = vec![0.0; size * size];
    let contacts = interface.evaluate(&law(), Mode::Hessian).unwrap();
    for (row, column, value) in contacts.triplets(Tangent::Exact, &dofs).unwrap().iter() {
        dense[row * size + column] += value;
    }
    let largest = dense.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    for column in (0..size).step_by(19) {
        let mut at = |step: f64| {
            let mut positions = positions.clone();
            positions[column / 3][column % 3] += step;
            interface.move_points(&positions).unwrap();
            let forces = pair.forces(interface.evaluate(&law(), Mode::Gradient).unwrap());
            forces.as_flattened().to_vec()
        };
        let (after, before) = (at(1e-6), at(-1e-6));
        for row in 0..size {
            let expected = -(after[row] - before[row]) / 2e-6;
            let found = dense[row * size + column];
            assert!((found - expected).abs() < 2e-7 * largest, "{row} {column}: {found} {expected}");
        }
    }
}

/// Uniform pressure and traction arrive at both sides, away from the edges of the master.
#[test]
fn a_uniform_traction_arrives_at_both_sides() {
    let friction = Coulomb::new(0.3, 1000.0).unwrap();
    let law = ContactLaw::penalty(50.0).with_friction(Some(friction));
    for triangles in [false, true] {
        let pair = Pair::new([6, 8], triangles, |x, y| [x, y, 0.0], |x, y| [0.1 + 0.9 * x, y, -0.02]);
        let areas = |facets: &[Facet]| crate::surface::tributary_areas(&pair.positions, facets).unwrap();
        for element in elements() {
            let mut interface = pair.interface(element, FaceRule::Second);
            interface.refresh(&pair.positions).unwrap();
            interface.accept(&law).unwrap();
            let slid: Vec<Point> = (0..pair.positions.len())
                .map(|k| {
                    let [x, y, z] = pair.positions[k];
                    if k < pair.first_slave { [x, y, z] } else { [x + 0.3, y, z] }
                })
                .collect();
            interface.refresh(&slid).unwrap();
            let forces = pair.forces(interface.evaluate(&law, Mode::Gradient).unwrap());
            let (of_slave, of_master) = (areas(&pair.slave), areas(&pair.master));
            for (node, &[x, y, _]) in pair.positions.iter().enumerate() {
                if node < pair.first_slave && !(x > 1.5 && x < 4.5 && y > 0.5 && y < 5.5) {
                    continue;
                }
                let (pressure, area) = (1.0, of_slave[node] - of_master[node]);
                let expected = [-0.3 * pressure * area, 0.0, pressure * area];
                for axis in 0..3 {
                    let error = (forces[node][axis] - expected[axis]).abs();
                    assert!(error < 1e-12, "{node} {:?} {expected:?} {element:?}", forces[node]);
                }
            }
        }
    }
}

/// Both bodies turned by 90° with their history: so are the forces.
#[test]
fn forces_turn_with_the_bodies() {
    for element in elements() {
        let pair = bumps(false);
        let mut interface = interface(&pair, element, &[]);
        let expected = pair.forces(interface.evaluate(&law(), Mode::Gradient).unwrap());
        let turn = |[x, y, z]: Point| [-y, x, z];
        let turned: Vec<Point> = moved(&pair, 1.0).into_iter().map(turn).collect();
        interface.refresh(&turned).unwrap();
        let forces = pair.forces(interface.evaluate(&law(), Mode::Gradient).unwrap());
        let largest = expected.as_flattened().iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
        for (found, expected) in forces.iter().zip(expected) {
            let error = (Vector3::from(*found) - Vector3::from(turn(expected))).norm();
            assert!(error < 1e-12 * largest, "{found:?} {expected:?} {element:?}");
        }
    }
}

/// An accepted step keeps the tractions; what slid is work; and what was saved goes on bit for bit.
#[test]
fn an_accepted_step_leaves_the_tractions_of_its_end() {
    for element in elements() {
        let pair = bumps(false);
        let mut own = interface(&pair, element, &[]);
        let expected = own.evaluate(&law(), Mode::Value).unwrap().nodes().to_vec();
        let slid: f64 = expected
            .iter()
            .filter(|node| node.friction_state == FrictionState::Slip)
            .map(|node| 0.3 * node.force() * (node.slip - 0.3 * node.pressure / STIFFNESS))
            .sum();
        let report = own.accept(&law()).unwrap();
        assert!(slid > 0.1 && (report.dissipated - slid).abs() < 1e-13, "{slid} {}", report.dissipated);
        assert!(report.sliding > 4 && report.stuck > 0);

        own.refresh(&moved(&pair, 1.0)).unwrap();
        let nodes = own.evaluate(&law(), Mode::Value).unwrap().nodes();
        for (node, before) in nodes.iter().zip(&expected) {
            let change = (Vector3::from(node.friction) - Vector3::from(before.friction)).norm();
            // Rounding of positions times the stiffness.
            assert!(change <= 1e-12, "{node:?} {before:?}");
        }

        let history = own.history();
        let mut other = pair.interface(element, FaceRule::Second);
        other.set_history(&history).unwrap();
        assert_eq!(other.history(), history);
        for interface in [&mut own, &mut other] {
            interface.refresh(&moved(&pair, 1.5)).unwrap();
            interface.accept(&law()).unwrap();
            interface.refresh(&moved(&pair, 2.0)).unwrap();
            interface.evaluate(&law(), Mode::Gradient).unwrap();
        }
        assert_eq!(own.history(), other.history());
        assert_eq!(pair.forces(own.contacts()), pair.forces(other.contacts()));
    }
}

#[test]
fn histories_of_others_are_refused() {
    let pair = bumps(false);
    let mut own = interface(&pair, ContactElement::default(), &[]);
    let history = own.history();
    let slaves = own.slaves().len();
    let mut refused = |change: &dyn Fn(&mut Vec<f64>)| {
        let mut numbers = history.clone();
        change(&mut numbers);
        let error = own.set_history(&numbers).unwrap_err();
        assert_eq!(own.history(), history);
        error
    };
    let first = history.iter().position(|&x| x != -1.0).unwrap();
    assert!(matches!(refused(&|numbers| numbers[first] = 0.5), InterfaceError::InvalidHistory { .. }));
    let error = refused(&|numbers| numbers.extend([-1.0, -1.0]));
    assert_eq!(error, InterfaceError::AnchorCount { found: slaves + 1, expected: slaves });
    let error = refused(&|numbers| numbers[first + 2] = 1e6);
    assert!(matches!(error, InterfaceError::ForeignCarrier { node: 1_000_000, .. }));
    own.set_history(&[]).unwrap();
    assert!(own.history().is_empty());
}

/// One edge of a face in a plane of symmetry: nothing there points out of it.
#[test]
fn tractions_stay_within_planes_of_symmetry() {
    let bowl = |sign: f64, depth: f64| move |x: f64, y: f64| [x, y, sign * 0.02 * (x * x + y * y) - depth];
    let pair = Pair::new([6, 5], false, bowl(1.0, 0.0), bowl(1.0, 0.02));
    let mut own = pair.interface(ContactElement::default(), FaceRule::Second);
    own.set_symmetry(&[SymmetryPlane::across(0, [0.0; 3])]).unwrap();
    own.refresh(&pair.positions).unwrap();
    own.accept(&law()).unwrap();
    // Stretched along x, so that faces beside the plane slide away from it, and moved along it.
    let stretched: Vec<Point> = (0..pair.positions.len())
        .map(|k| {
            let [x, y, z] = pair.positions[k];
            if k < pair.first_slave { [x, y, z] } else { [1.01 * x, y + 0.005, z] }
        })
        .collect();
    own.refresh(&stretched).unwrap();
    let contacts = own.evaluate(&law(), Mode::Value).unwrap();
    let (mut there, mut elsewhere) = (0, 0);
    for node in contacts.nodes().iter().filter(|node| node.friction_state != FrictionState::Open) {
        if pair.positions[node.slave][0] == 0.0 {
            assert!(node.friction[0].abs() < 1e-14 && node.friction[1] < -0.1, "{node:?}");
            there += 1;
        } else {
            elsewhere += usize::from(node.friction[0] < -0.1);
        }
    }
    assert!(there > 3 && elsewhere > 10, "{there} {elsewhere}");
}
