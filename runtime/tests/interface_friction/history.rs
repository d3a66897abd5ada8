//! What friction remembers: when its history changes, and what of it a restart needs.

use std::f64::consts::TAU;

use diffuse_contact::affine::{AffinePoint, Carrier};
use diffuse_contact::assembly::{AssemblyError, ContactLaw, DofMap, add_forces, slave_friction};
use diffuse_contact::friction::Coulomb;
use diffuse_contact::interface::{Anchor, ContactElement, FrictionReport, InterfaceError, InterfaceOptions};
use diffuse_contact::neighbourhood::SearchOptions;
use diffuse_contact::{Mode, Point, Weight};

use super::{DEPTH, PENALTY, Pressed, STIFFNESS, assert_balance, assert_tangent, law, length};
use crate::common::{Mesh, distance, hull_layers};

#[test]
fn nothing_of_the_history_changes_before_a_step_is_accepted() {
    let mut pressed = Pressed::new(0.1, Weight::Cubic, &[]);
    let (anchors, start) = (pressed.interface.anchors().unwrap().to_vec(), pressed.positions.clone());
    pressed.slide_and_deform([0.03, 0.02, 0.001]);
    let forces = pressed.forces();
    // A try that goes far, and is given up.
    pressed.slide_and_deform([0.9, -0.4, 0.0]);
    pressed.forces();
    assert_eq!(pressed.interface.anchors().unwrap(), anchors);
    pressed.positions = start;
    pressed.interface.refresh_pairing(&pressed.positions).unwrap();
    pressed.slide_and_deform([0.03, 0.02, 0.001]);
    assert_eq!(pressed.forces(), forces);

    // A restart from the numbers of the history alone has the same bits.
    let kept = pressed.interface.history();
    let mut other = Pressed::new(0.1, Weight::Cubic, &[]);
    other.interface.set_history(&[]).unwrap();
    assert!(other.interface.anchors().is_none() && other.interface.history().is_empty());
    other.interface.set_history(&kept).unwrap();
    assert_eq!(other.interface.anchors(), pressed.interface.anchors());
    other.positions = pressed.positions.clone();
    other.interface.refresh_pairing(&other.positions).unwrap();
    assert_eq!(other.forces(), forces);
}

/// The gradient of the slip is shorter than the slip where the surface turns: the force is μ p cos Δθ.
#[test]
fn what_friction_lacks_on_a_surface_that_turns_is_told() {
    let roller = Mesh::grid([48, 9], [true, false], |s, t| {
        let (sin, cos) = (TAU * s).sin_cos();
        [cos, sin, t]
    });
    let at = |angle: f64| [0.999 * angle.cos(), 0.999 * angle.sin(), 0.5];
    for turn in [0.05_f64, 0.3, 0.8] {
        let element = ContactElement::diffuse(SearchOptions::domains());
        let mut pressed = Pressed::over(&roller, &[at(0.1)], 0.1, element, &[]);
        let slave = pressed.slaves[0];
        pressed.positions[slave] = at(0.1 + turn);
        pressed.follow();
        let report = pressed.accept();
        assert!(report.sliding == 1 && report.limit > 0.0, "{report:?}");
        let part = report.short / report.limit;
        assert!((part - (1.0 - turn.cos())).abs() < 2e-3, "{turn}: {part}");
    }
}

#[test]
fn a_slave_that_slides_draws_its_anchor_along() {
    let mut pressed = Pressed::new(0.1, Weight::Cubic, &[]);
    let mut work = 0.0;
    for _ in 0..20 {
        pressed.slide([0.05, 0.0, 0.0]);
        let before: Vec<Point> = (0..4).map(|k| pressed.traction(k)).collect();
        let report = pressed.accept();
        assert!(report.sliding >= 4 && report.dissipated > 0.0, "{report:?}");
        work += report.dissipated;
        for (k, before) in before.into_iter().enumerate() {
            let after = pressed.traction(k);
            // What remains of the slip has the same traction, but for the turn of the normal along it.
            assert!(distance(before, after) < 0.02 * length(before), "{before:?} {after:?}");
        }
        for anchor in pressed.interface.anchors().unwrap().iter().flatten() {
            assert!(anchor.point.terms().len() <= 40, "{}", anchor.point.terms().len());
        }
    }
    assert!(work > 0.0);
    // A short way back, and it sticks.
    pressed.slide([-1e-4, 0.0, 0.0]);
    let report = pressed.accept();
    assert_eq!((report.sliding, report.dissipated), (0, 0.0));
    assert!(report.stuck >= 4);
}

/// Slaves that slid freely have no slip behind them when there is friction again.
#[test]
fn a_step_without_friction_leaves_no_slip_behind() {
    let free = [ContactLaw::penalty(PENALTY), law(0.0)];
    let elements = [ContactElement::diffuse(SearchOptions::domains()), ContactElement::NodeToFacet];
    for (element, free) in elements.into_iter().flat_map(|element| free.map(|free| (element, free))) {
        let mut pressed = Pressed::on(0.3, element, &[]);
        pressed.slide([2e-3, 1e-3, 0.0]);
        let report = pressed.accept();
        assert!(report.stuck + report.sliding >= 4, "{report:?}");
        pressed.slide([0.04, 0.03, 0.0]);
        pressed.law = free;
        let forces = pressed.forces();
        assert_eq!(pressed.accept(), FrictionReport::default());
        pressed.interface.refresh_pairing(&pressed.positions).unwrap();
        assert_eq!(pressed.forces(), forces);
        pressed.law = law(0.3);
        for k in 0..4 {
            assert!(length(pressed.traction(k)) < 1e-10, "{element:?} {:?}", pressed.traction(k));
        }
        // From here on the slip counts.
        pressed.slide([1e-3, 0.0, 0.0]);
        for k in 0..4 {
            let ratio = length(pressed.traction(k)) / (STIFFNESS * 1e-3);
            assert!((0.8..1.2).contains(&ratio), "{element:?} {ratio}");
        }
    }
    // Without a history there is nothing to begin from, and none begins.
    let mut scene = Mesh::plane(4.0, 4.0, 1.0).scene(&[[2.2, 2.1, -0.1]], InterfaceOptions::default());
    assert_eq!(scene.interface.accept(&free[0]), Ok(FrictionReport::default()));
    assert!(!scene.interface.has_history());
}

#[test]
fn an_open_contact_drops_its_anchor_and_closes_with_a_new_one() {
    let mut pressed = Pressed::new(0.5, Weight::Cubic, &[]);
    let slave = pressed.slaves[1];
    let stuck = pressed.interface.anchors().unwrap()[1].clone().unwrap();
    assert_eq!(stuck.opening, 0.0);
    pressed.positions[slave][2] += 3.0 * DEPTH;
    pressed.interface.follow(&pressed.positions).unwrap();
    pressed.accept();
    let open = pressed.interface.anchors().unwrap()[1].clone().unwrap();
    assert!((open.opening / (2.0 * DEPTH) - 1.0).abs() < 0.1, "{}", open.opening);
    assert_ne!(open.point, stuck.point);
    // It slides while it comes down along the normal: half of the way in touch, the traction is that of half of the slip.
    pressed.forces();
    let normal = pressed.interface.contacts().get(1).point.normal;
    let along = [normal[2], 0.0, -normal[0]];
    for axis in 0..3 {
        let step = 4e-3 * along[axis] / length(along) - 2.0 * open.opening * normal[axis];
        pressed.positions[slave][axis] += step;
    }
    pressed.interface.follow(&pressed.positions).unwrap();
    let traction = length(pressed.traction(1));
    assert!((traction / (0.5 * STIFFNESS * 4e-3) - 1.0).abs() < 0.02, "{traction}");
    pressed.accept();
    assert_eq!(pressed.interface.anchors().unwrap()[1].as_ref().unwrap().opening, 0.0);
    assert!((length(pressed.traction(1)) / traction - 1.0).abs() < 0.02);
    // Far from the surface there is no anchor, and right after it no friction, which is said.
    let back = pressed.positions.clone();
    pressed.positions[slave] = [30.0, 0.0, 0.0];
    pressed.interface.refresh_pairing(&pressed.positions).unwrap();
    let report = pressed.accept();
    assert_eq!(pressed.interface.anchors().unwrap()[1], None);
    assert_eq!((report.dropped, report.unanchored), (1, 0));
    pressed.positions = back;
    pressed.interface.refresh_pairing(&pressed.positions).unwrap();
    assert_eq!(pressed.traction(1), [0.0; 3]);
    let report = pressed.accept();
    assert_eq!((report.dropped, report.unanchored), (0, 1));
    assert!(pressed.interface.anchors().unwrap()[1].is_some());
}

#[test]
fn a_history_with_large_weights_is_the_same_when_it_is_read_again() {
    let mut pressed = Pressed::new(0.1, Weight::Cubic, &[]);
    for case in 0..20 {
        let weight = |node: u32| 1e3 * (0.7 * f64::from(node + 17 * case)).sin();
        let rest = 1.0 - (1..25).map(weight).sum::<f64>();
        let point = AffinePoint::new((1..25).map(|node| (node, weight(node))).chain([(0, rest)])).unwrap();
        let anchors = vec![Some(Anchor::new(point)), None, None, None, None];
        pressed.interface.set_anchors(Some(anchors.clone())).unwrap();
        let history = pressed.interface.history();
        pressed.interface.set_history(&history).unwrap();
        assert_eq!(pressed.interface.anchors().unwrap(), anchors, "{case}");
        assert_eq!(pressed.interface.history(), history, "{case}");
    }
}

#[test]
fn what_is_no_history_is_refused() {
    let mut pressed = Pressed::new(0.1, Weight::Cubic, &[]);
    let kept = pressed.interface.anchors().unwrap().to_vec();
    let anchor = |carrier: Carrier| {
        let point = AffinePoint::new([(carrier, 1.0)]).unwrap();
        Some(vec![Some(Anchor::new(point)), None, None, None, None])
    };
    let with = |opening: f64, limit: f64| {
        let mut anchors = kept.clone();
        let first = anchors[0].as_mut().unwrap();
        (first.opening, first.limit) = (opening, limit);
        Some(anchors)
    };
    let slave = pressed.slaves[0] as u32;
    for (anchors, code) in [
        (Some(vec![None; 4]), "anchor-count"),
        (anchor(slave.into()), "foreign-carrier"),
        (anchor(Carrier { node: 0, image: Some(0) }), "foreign-carrier"),
        (with(f64::NAN, 0.0), "invalid-opening"),
        (with(-1e-3, 0.0), "invalid-opening"),
        (with(0.0, -1e-3), "invalid-opening"),
        (with(1e-3, 1e-3), "invalid-opening"),
    ] {
        assert_eq!(pressed.interface.set_anchors(anchors).unwrap_err().code(), code);
        assert_eq!(pressed.interface.anchors().unwrap(), kept);
    }
    let numbers = pressed.interface.history();
    let changed = |place: usize, value: f64| {
        let mut numbers = numbers.clone();
        numbers[place] = value;
        numbers
    };
    for (history, code) in [
        (numbers[..numbers.len() - 1].to_vec(), "invalid-history"),
        (changed(0, 0.5), "invalid-history"),
        (changed(0, f64::NAN), "invalid-history"),
        (changed(1, f64::NEG_INFINITY), "invalid-opening"),
        (changed(2, 1e12), "invalid-history"),
        (changed(4, 7.0), "invalid-history"),
        (vec![-1.0; 4], "anchor-count"),
    ] {
        assert_eq!(pressed.interface.set_history(&history).unwrap_err().code(), code);
        assert_eq!(pressed.interface.history(), numbers);
    }
    for law in [ContactLaw::penalty(f64::NAN), ContactLaw::penalty(1.0).with_multipliers(Some(&[0.0; 4]))] {
        let law = law.with_friction(Some(Coulomb::new(0.1, STIFFNESS).unwrap()));
        assert!(matches!(pressed.interface.accept(&law), Err(InterfaceError::Law(_))));
        assert_eq!(pressed.interface.history(), numbers);
    }
    // Without a history the law asks for one, and other anchors end the pairing.
    pressed.interface.set_anchors(None).unwrap();
    assert_eq!(pressed.interface.evaluate(Mode::Gradient).err(), Some(InterfaceError::NotRefreshed));
    pressed.interface.refresh_pairing(&pressed.positions).unwrap();
    let contacts = pressed.interface.evaluate(Mode::Gradient).unwrap();
    let mut forces = vec![0.0; 3 * pressed.positions.len()];
    let dofs = DofMap::standard(pressed.positions.len());
    let refused = add_forces(contacts, &pressed.law, &dofs, &mut forces);
    assert_eq!(refused, Err(AssemblyError::NoSlip { element: 0 }));

    // Before the first refresh there is nothing to begin from.
    let plane = Mesh::plane(4.0, 4.0, 1.0);
    let mut scene = plane.scene(&[[2.2, 2.1, -0.1]], InterfaceOptions::default());
    assert_eq!(scene.interface.accept(&law(0.1)), Err(InterfaceError::NotRefreshed));
    scene.refresh();
    assert_eq!(scene.interface.accept(&law(0.1)).unwrap().unanchored, 1);

    // Hull layers have no anchors.
    let mut scene = plane.paired(&[[2.2, 2.1, -0.1]], hull_layers());
    assert_eq!(scene.interface.accept(&law(0.1)), Err(AssemblyError::NoAnchors.into()));
}

/// Rounds of augmentation with the motion given: tractions rise by ε_T s each time, up to μ p.
#[test]
fn augmented_friction_forgets_its_stiffness_and_is_accepted_or_rolled_back() {
    let friction = Coulomb::new(0.3, STIFFNESS).unwrap().with_augmentation(true);
    let law = ContactLaw::penalty(PENALTY).with_friction(Some(friction));
    let pressed = || {
        let mut pressed = Pressed { law, ..Pressed::new(0.3, Weight::Cubic, &[]) };
        pressed.slide_and_deform([1.6e-3, 0.8e-3, 0.0]);
        pressed
    };
    let mut own = pressed();
    let (history, forces) = (own.interface.history(), own.forces());
    let first: Vec<Point> = (0..4).map(|k| own.traction(k)).collect();
    let errors = own.interface.slip_errors(&law).unwrap();
    for (traction, error) in first.iter().zip(&errors) {
        assert!((length(*traction) / (STIFFNESS * error) - 1.0).abs() < 0.02, "{traction:?} {error}");
    }
    let slips = |own: &mut Pressed| -> Vec<f64> {
        let contacts = own.interface.evaluate(Mode::Gradient).unwrap();
        slave_friction(contacts, &law).unwrap().iter().map(|slave| slave.slip).collect()
    };
    assert_eq!(own.interface.augmented_history(), history);
    own.interface.augment(&law, |k| k != 1).unwrap();
    assert_eq!(own.interface.history(), history);
    assert_ne!(own.interface.augmented_history(), history);
    // A multiplier is no slip.
    for (slip, error) in slips(&mut own).iter().zip(&errors) {
        assert!((slip - error).abs() < 1e-12, "{slip} {error}");
    }
    for (k, before) in first.iter().enumerate() {
        let after = own.traction(k);
        let factor = if k == 1 { 1.0 } else { 2.0 };
        let error = distance(after, before.map(|x| factor * x));
        assert!(error < 0.02 * length(*before), "{k} {after:?} {before:?}");
    }
    assert_tangent(&mut own, true);
    own.slide([0.0; 3]);
    // Up to the limit, where nothing is left to do.
    for _ in 0..20 {
        own.interface.augment(&law, |_| true).unwrap();
    }
    for k in 0..4 {
        let ratio = length(own.traction(k)) / own.normal_force(k);
        assert!((ratio - 0.3).abs() < 0.003, "{ratio}");
    }
    assert!(own.interface.slip_errors(&law).unwrap().iter().all(|&error| error < 1e-5));
    assert_balance(&mut own);

    // Rolled back, the step begins anew, bit for bit.
    let mut other = pressed();
    other.interface.augment(&law, |_| true).unwrap();
    other.interface.roll_back();
    other.interface.refresh_pairing(&other.positions).unwrap();
    assert_eq!(other.forces(), forces);
    // Accepted and saved, it goes on.
    let report = own.accept();
    assert!(report.sliding >= 4, "{report:?}");
    let history = own.interface.history();
    other.interface.set_history(&history).unwrap();
    other.positions = own.positions.clone();
    other.interface.refresh_pairing(&other.positions).unwrap();
    for interface in [&mut own, &mut other] {
        interface.slide([-1e-3, 0.0, 0.0]);
        interface.interface.augment(&law, |_| true).unwrap();
    }
    assert_eq!(own.forces(), other.forces());
    assert!(own.accept().stuck >= 4 && other.accept().stuck >= 4);
    assert_eq!(own.interface.history(), other.interface.history());
    let plain = ContactLaw::penalty(PENALTY).with_friction(Coulomb::new(0.3, STIFFNESS).ok());
    assert_eq!(own.interface.slip_errors(&plain).unwrap_err().code(), "no-augmentation");
    // Without friction there is nothing to take over.
    let (none, forces) = (ContactLaw::penalty(PENALTY), own.forces());
    assert_eq!(own.interface.slip_errors(&none), Ok(vec![0.0; own.slaves.len()]));
    own.interface.augment(&none, |_| true).unwrap();
    assert_eq!((own.interface.augmented_history(), own.forces()), (own.interface.history(), forces));
}
