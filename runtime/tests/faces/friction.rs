//! Friction over faces.

use super::*;
use diffuse_contact::Coulomb;
use diffuse_contact::friction::FrictionState;
use diffuse_contact::interface::split_history;
use diffuse_contact::surface::SymmetryPlane;

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
    assert_eq!(interface.evaluate(&law(), Mode::Value).err(), Some(InterfaceError::NotRefreshed));
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
    for (element, pressures) in pairs(elements(), FacePressures::ALL) {
        for triangles in [false, true] {
            let pair = bumps(triangles);
            let mut interface = interface(&pair, element, &[]);
            interface.set_pressures(pressures);
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
    let all = elements().into_iter().enumerate().map(|(k, element)| (element, k % 2 == 1));
    for (element, triangles) in all.chain([(ContactElement::NodeToFacet, false)]) {
        let pair = bumps(triangles);
        let mut own = interface(&pair, element, &[]);
        for pressures in FacePressures::ALL {
            own.set_pressures(pressures);
            assert_tangent_at(&pair, &mut own, &law(), &moved(&pair, 1.0), 43);
        }
    }
    for second in Second::ALL {
        let (pair, faces) = bumps_of_second_order(second);
        let mut own = interface(&pair, ContactElement::default(), &faces);
        for pressures in FacePressures::ALL {
            own.set_pressures(pressures);
            assert_tangent_at(&pair, &mut own, &law(), &moved(&pair, 1.0), 43);
        }
    }
}

/// Slaves that stick to what they have left: the history has nodes that nothing else couples.
#[test]
fn the_tangent_reaches_to_where_slaves_stuck() {
    let law = ContactLaw::penalty(50.0).with_friction(Some(Coulomb::new(100.0, 0.5).unwrap()));
    let flat = |z: f64| move |x: f64, y: f64| [x, y, z];
    let pair = Pair::new([8, 4], false, flat(0.0), |x, y| [0.4 * x, 1.0 + 0.4 * y, -0.02 + 0.003 * x]);
    for element in [ContactElement::default(), ContactElement::NodeToFacet] {
        let mut own = pair.interface(element, FaceRule::Second);
        own.refresh(&pair.positions).unwrap();
        own.accept(&law).unwrap();
        let first = pair.first_slave;
        let slid: Vec<Point> = (0..pair.positions.len())
            .map(|k| {
                let [x, y, z] = pair.positions[k];
                if k < first { [x, y, z] } else { [x + 3.4, y, z] }
            })
            .collect();
        own.refresh(&slid).unwrap();
        let nodes = own.evaluate(&law, Mode::Value).unwrap().nodes();
        assert!(nodes.iter().all(|node| node.friction_state == FrictionState::Stick));
        assert_tangent_at(&pair, &mut own, &law, &slid, 5);
        // One that forgot them when it was refreshed couples less.
        own.set_history(&[]).unwrap();
        own.refresh(&slid).unwrap();
        assert!(own.cliques().flatten().all(|&node| node as usize >= first || slid[node as usize][0] > 0.0));
    }
}

/// μ = 0 leaves every bit, without a history and with that of a step that had friction.
#[test]
fn without_a_coefficient_every_bit_is_frictionless() {
    let none = law().with_friction(Some(Coulomb::new(0.0, STIFFNESS).unwrap()));
    let bits = |numbers: &[f64]| numbers.iter().map(|number| number.to_bits()).collect::<Vec<u64>>();
    for element in elements() {
        let pair = bumps(false);
        let dofs = DofMap::standard(pair.positions.len());
        let of = |own: &mut FaceInterface, law: &ContactLaw<'_>| {
            let contacts = own.evaluate(law, Mode::Hessian).unwrap();
            let size = dofs.equations();
            let mut matrix = vec![0.0; size * size];
            let triplets = contacts.triplets(Tangent::Exact, &dofs).unwrap();
            triplets.iter().for_each(|(row, column, value)| matrix[row * size + column] += value);
            (bits(pair.forces(contacts).as_flattened()), bits(&matrix))
        };
        let mut never = pair.interface(element, FaceRule::Second);
        never.refresh(&pair.positions).unwrap();
        never.accept(&none).unwrap();
        never.refresh(&moved(&pair, 1.0)).unwrap();
        let expected = of(&mut never, &ContactLaw::penalty(50.0));
        let mut own = interface(&pair, element, &[]);
        assert!(of(&mut own, &law()) != expected);
        assert!(own.has_history() && of(&mut own, &none) == expected, "{element:?}");
        assert!(of(&mut never, &none) == expected, "{element:?}");
    }
}

/// A step that is given up leaves no trace.
/// What slid freely is no slip of the next step with friction.
#[test]
fn a_step_without_friction_leaves_no_slip_behind() {
    let none = law().with_friction(Some(Coulomb::new(0.0, STIFFNESS).unwrap()));
    for free in [ContactLaw::penalty(50.0), none] {
        let pair = bumps(false);
        let mut own = interface(&pair, ContactElement::default(), &[]);
        assert_eq!(own.accept(&free), Ok(Default::default()));
        own.refresh(&moved(&pair, 1.0)).unwrap();
        let nodes = own.evaluate(&law(), Mode::Value).unwrap().nodes();
        let loaded = nodes.iter().filter(|node| node.pressure > 0.0);
        assert!(loaded.clone().count() > 8);
        for node in loaded {
            assert!(node.slip < 1e-12 && Vector3::from(node.friction).norm() < 1e-10, "{node:?}");
        }
    }
}

#[test]
fn a_step_that_is_given_up_changes_nothing() {
    let pair = bumps(false);
    let mut own = interface(&pair, ContactElement::default(), &[]);
    let expected = pair.forces(own.evaluate(&law(), Mode::Gradient).unwrap());
    let history = own.history();
    own.update(&moved(&pair, 4.0)).unwrap();
    assert_ne!(pair.forces(own.evaluate(&law(), Mode::Gradient).unwrap()), expected);
    own.refresh(&moved(&pair, 1.0)).unwrap();
    assert_eq!(pair.forces(own.evaluate(&law(), Mode::Gradient).unwrap()), expected);
    assert_eq!(own.history(), history);
}

/// Without what turns it is the same whatever the evaluation was for.
#[test]
fn the_tangent_of_gauss_and_newton_does_not_depend_on_the_mode() {
    let pair = bumps(false);
    let mut own = interface(&pair, ContactElement::default(), &[]);
    let dofs = DofMap::standard(pair.positions.len());
    let mut of = |mode| own.evaluate(&law(), mode).unwrap().triplets(Tangent::GaussNewton, &dofs).unwrap();
    let (short, long) = (of(Mode::Gradient), of(Mode::Hessian));
    assert_eq!((short.rows(), short.columns()), (long.rows(), long.columns()));
    // Kernels with and without second derivatives are different code, whose roundings are their own.
    let largest = long.values().iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let differences = short.values().iter().zip(long.values()).map(|(short, long)| (short - long).abs());
    assert!(largest > 0.0 && differences.fold(0.0, crate::common::worse) <= 1e-14 * largest);
}

/// Slaves slide at a limit that no pressure raises.
#[test]
fn a_shear_limit_is_kept() {
    let pair = bumps(false);
    let mut own = interface(&pair, ContactElement::default(), &[]);
    let limited = Coulomb::new(0.3, STIFFNESS).unwrap().with_shear_limit(Some(0.5)).unwrap();
    let law = ContactLaw::penalty(50.0).with_friction(Some(limited));
    let nodes = own.evaluate(&law, Mode::Value).unwrap().nodes().to_vec();
    let sizes = nodes.iter().map(|node| Vector3::from(node.friction).norm());
    assert!(sizes.clone().all(|size| size < 0.5 + 1e-14));
    assert!(sizes.zip(&nodes).filter(|(size, node)| *size > 0.5 - 1e-14 && node.pressure > 2.0).count() > 4);
    assert_tangent_at(&pair, &mut own, &law, &moved(&pair, 1.0), 37);
}

/// A wide face touches along one of its edges and is stretched away from there: what touches slides by a tenth of what its mean does.
#[test]
fn what_slides_of_a_face_with_pressures_of_points_is_what_touches() {
    let pair =
        Pair::new([12, 1], false, |x, y| [1.5 * x - 1.5, 1.5 * y - 1.5, 0.0], |x, y| [x, y, 0.02 * x - 0.01]);
    let mut interface = pair.interface(ContactElement::default(), FaceRule::Second);
    interface.set_pressures(FacePressures::Points);
    interface.refresh(&pair.positions).unwrap();
    interface.accept(&law()).unwrap();
    let mut moved = pair.positions.clone();
    moved[pair.first_slave..].iter_mut().for_each(|x| x[0] *= 1.1);
    interface.refresh(&moved).unwrap();
    let nodes = interface.evaluate(&law(), Mode::Gradient).unwrap().nodes().to_vec();
    // Two points of the piece of the face that touches are pressed, at the same distance from the edge.
    let place = 0.75 * 0.5 * (1.0 - 1.0 / 3.0_f64.sqrt());
    for node in nodes {
        assert!(
            node.friction_state == FrictionState::Slip && (node.slip / (0.1 * place) - 1.0).abs() < 1e-3,
            "{node:?}"
        );
    }
}

/// Uniform pressure and traction arrive at both sides, away from the edges of the master.
#[test]
fn a_uniform_traction_arrives_at_both_sides() {
    let friction = Coulomb::new(0.3, 1000.0).unwrap();
    let law = ContactLaw::penalty(50.0).with_friction(Some(friction));
    for triangles in [false, true] {
        let pair = Pair::new([6, 8], triangles, |x, y| [x, y, 0.0], |x, y| [0.1 + 0.9 * x, y, -0.02]);
        let areas =
            |facets: &[Facet]| diffuse_contact::surface::tributary_areas(&pair.positions, facets).unwrap();
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

/// Both bodies turned with their history, by 90° about z and by 120° about the diagonal: so are the forces.
#[test]
fn forces_turn_with_the_bodies() {
    for element in elements() {
        let pair = bumps(false);
        let mut interface = interface(&pair, element, &[]);
        let expected = pair.forces(interface.evaluate(&law(), Mode::Gradient).unwrap());
        let turns: [fn(Point) -> Point; 2] = [|[x, y, z]| [-y, x, z], |[x, y, z]| [z, x, y]];
        for turn in turns {
            let turned: Vec<Point> = moved(&pair, 1.0).into_iter().map(turn).collect();
            interface.refresh(&turned).unwrap();
            let forces = pair.forces(interface.evaluate(&law(), Mode::Gradient).unwrap());
            let largest = expected.as_flattened().iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
            for (found, &expected) in forces.iter().zip(&expected) {
                let error = (Vector3::from(*found) - Vector3::from(turn(expected))).norm();
                assert!(error < 1e-12 * largest, "{found:?} {expected:?} {element:?}");
            }
        }
    }
}

/// The bodies after the slave was lifted and carried away.
fn carried(pair: &Pair) -> Vec<Point> {
    let mut carried = moved(pair, 1.0);
    carried[pair.first_slave..].iter_mut().for_each(|x| (x[0], x[2]) = (x[0] + 0.02, x[2] + 0.3));
    carried
}

#[test]
fn what_stuck_and_is_carried_away_does_no_work() {
    let sticky = ContactLaw::penalty(50.0).with_friction(Some(Coulomb::new(50.0, STIFFNESS).unwrap()));
    for element in elements() {
        let pair = bumps(false);
        let mut interface = interface(&pair, element, &[]);
        let report = interface.accept(&sticky).unwrap();
        assert!((report.sliding, report.dissipated) == (0, 0.0) && report.stuck > 4, "{report:?}");
        interface.refresh(&carried(&pair)).unwrap();
        assert_eq!(interface.evaluate(&sticky, Mode::Value).unwrap().active(), 0);
        assert_eq!(interface.accept(&sticky).unwrap().dissipated, 0.0);
    }
}

/// An accepted step keeps the tractions; what slid is work; and what was saved goes on bit for bit.
#[test]
fn an_accepted_step_leaves_the_tractions_of_its_end() {
    let of_second_order =
        Second::ALL.map(|second| (ContactElement::default(), bumps_of_second_order(second)));
    let of_first = elements().into_iter().map(|element| (element, (bumps(false), Vec::new())));
    for (element, (pair, faces)) in of_first.chain(of_second_order) {
        let mut own = interface(&pair, element, &faces);
        let expected = own.evaluate(&law(), Mode::Value).unwrap().nodes().to_vec();
        // How far each node was open at the end of the step before, and its largest traction.
        let before = |history: &[f64]| -> Vec<[f64; 2]> {
            let parts = split_history(history).unwrap();
            let anchors = parts.iter().skip(1).step_by(2).map(|anchor| match anchor[..] {
                [_, x, ..] => x,
                _ => 0.0,
            });
            anchors.map(|x| [x.max(0.0), (-x).max(0.0)]).collect()
        };
        let slid: f64 = expected
            .iter()
            .zip(before(&own.history()))
            .filter(|(node, _)| node.friction_state == FrictionState::Slip)
            .map(|(node, [opening, before])| {
                let now = 0.3 * node.pressure;
                let way = node.slip * (1.0 + 50.0 * opening / node.pressure);
                0.5 * (before + now) * node.area * (way - now / STIFFNESS)
            })
            .sum();
        let report = own.accept(&law()).unwrap();
        assert!(slid > 0.1 && (report.dissipated - slid).abs() < 1e-13, "{slid} {}", report.dissipated);
        for (node, [_, limit]) in expected.iter().zip(before(&own.history())) {
            assert!((limit - 0.3 * node.pressure).abs() <= 1e-12 * limit, "{node:?} {limit}");
        }

        // Lifted and carried away, what slid has half of its traction over the way.
        let mut lifted = interface(&pair, element, &faces);
        lifted.set_history(&own.history()).unwrap();
        lifted.refresh(&carried(&pair)).unwrap();
        assert_eq!(lifted.evaluate(&law(), Mode::Value).unwrap().active(), 0);
        let slid: f64 = expected
            .iter()
            .map(|node| f64::from(node.friction_state == FrictionState::Slip) * 0.3 * node.force())
            .sum();
        let work = lifted.accept(&law()).unwrap().dissipated;
        assert!(work > 0.5 * slid * 0.01 && work < 0.5 * slid * 0.04, "{work} {slid}");
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
        other.set_quadratic_faces(&faces).unwrap();
        other.set_history(&history).unwrap();
        assert_eq!(other.history(), history);
        for interface in [&mut own, &mut other] {
            interface.refresh(&moved(&pair, 1.5)).unwrap();
            interface.accept(&law()).unwrap();
            interface.refresh(&moved(&pair, 2.0)).unwrap();
            interface.evaluate(&law(), Mode::Gradient).unwrap();
        }
        let now = Pair { positions: moved(&pair, 2.0), master: Vec::new(), slave: Vec::new(), ..pair };
        now.assert_balance(&pair.forces(own.contacts()));
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
    // Half of a pair; a pair of which one is gone.
    let error = refused(&|numbers| numbers.extend([-1.0]));
    assert_eq!(error, InterfaceError::InvalidHistory { place: history.len() + 1 });
    let end = first + 2 + 3 * history[first] as usize;
    let error = refused(&|numbers| {
        numbers.splice(first..end, [-1.0]);
    });
    assert_eq!(error, InterfaceError::InvalidHistory { place: first + 1 });
    let error = refused(&|numbers| numbers[first + 1] = 0.5);
    assert!(matches!(error, InterfaceError::InvalidOpening { value: 0.5, .. }));
    // A master where a slave has to be.
    let error = refused(&|numbers| numbers[first + 2] = 0.0);
    assert!(matches!(error, InterfaceError::ForeignCarrier { node: 0, .. }));
    let error = refused(&|numbers| numbers.extend([-1.0, -1.0]));
    assert_eq!(error, InterfaceError::AnchorCount { found: slaves + 1, expected: slaves });
    let error = refused(&|numbers| numbers[first + 2] = 1e6);
    assert!(matches!(error, InterfaceError::ForeignCarrier { node: 1_000_000, .. }));
    own.set_history(&[]).unwrap();
    assert!(own.history().is_empty());
}

/// A history is of a step that ended; how far from the law faces are is of positions, which they have none of yet.
#[test]
fn rounds_of_augmentation_need_a_refresh() {
    let pair = bumps(false);
    let history = interface(&pair, ContactElement::default(), &[]).history();
    let surface = MasterSurface::new(&pair.positions, pair.master.clone()).unwrap();
    let options = FaceOptions::new(InterfaceOptions::default());
    let mut own = FaceInterface::new(surface, &pair.slave, &pair.positions, options).unwrap();
    own.set_history(&history).unwrap();
    let law = law();
    let law = law.with_friction(law.friction.map(|friction| friction.with_augmentation(true)));
    assert_eq!(own.slip_errors(&law).unwrap_err(), InterfaceError::NotRefreshed);
    assert_eq!(own.augment(&law, |_| true).unwrap_err(), InterfaceError::NotRefreshed);
}

/// One edge of a face in a plane of symmetry: nothing there points out of it.
#[test]
fn tractions_stay_within_planes_of_symmetry() {
    let bowl = |sign: f64, depth: f64| move |x: f64, y: f64| [x, y, sign * 0.02 * (x * x + y * y) - depth];
    let pair = Pair::new([6, 5], false, bowl(1.0, 0.0), bowl(1.0, 0.02));
    for element in elements() {
        let mut own = pair.interface(element, FaceRule::Second);
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
                assert!(node.friction[0].abs() < 1e-14 && node.friction[1] < -0.1, "{node:?} {element:?}");
                there += 1;
            } else {
                elsewhere += usize::from(node.friction[0] < -0.1);
            }
        }
        assert!(there > 3 && elsewhere > 10, "{there} {elsewhere}");
        assert_tangent_at(&pair, &mut own, &law(), &stretched, 29);
        // The history is that of the planes of then.
        let (history, planes) = (own.history(), [SymmetryPlane::across(0, [0.0; 3])]);
        own.set_symmetry(&planes).unwrap();
        assert_eq!(own.history(), history);
        own.set_symmetry(&[]).unwrap();
        assert!(!own.has_history());
    }
}
