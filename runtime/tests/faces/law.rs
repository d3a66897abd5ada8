//! Laws of the user's own over faces, and augmented friction.

use super::*;
use diffuse_contact::assembly::{AssemblyError, NormalLaw, NormalPressure, TabulatedPressure};
use diffuse_contact::friction::{CoefficientValue, Coulomb, FrictionCoefficient, FrictionState};

const STIFFNESS: f64 = 60.0;
const DURATION: f64 = 0.5;

/// p = a g² of penetrating gaps.
#[derive(Debug)]
struct Quadratic(f64);

impl NormalLaw for Quadratic {
    fn pressure(&self, _slave: usize, gap: f64) -> NormalPressure {
        let depth = (-gap).max(0.0);
        NormalPressure { pressure: self.0 * depth * depth, by_gap: -2.0 * self.0 * depth }
    }
}

/// A coefficient that falls with the pressure and the rate.
#[derive(Debug)]
struct Falling;

impl FrictionCoefficient for Falling {
    fn coefficient(&self, pressure: f64, rate: f64) -> CoefficientValue {
        let (a, b) = (1.0 + 0.2 * pressure, 1.0 + 0.5 * rate);
        let value = 0.4 / (a * b);
        CoefficientValue { value, by_pressure: -value * 0.2 / a, by_rate: -value * 0.5 / b }
    }
}

#[derive(Debug)]
struct Bad;

impl NormalLaw for Bad {
    fn pressure(&self, _slave: usize, _gap: f64) -> NormalPressure {
        NormalPressure { pressure: f64::NAN, by_gap: 0.0 }
    }
}

/// Pressure that begins nowhere.
#[derive(Debug)]
struct Nowhere;

impl NormalLaw for Nowhere {
    fn pressure(&self, _slave: usize, _gap: f64) -> NormalPressure {
        NormalPressure { pressure: 0.0, by_gap: 0.0 }
    }

    fn onset(&self, _slave: usize) -> f64 {
        f64::NAN
    }
}

/// A coefficient of rest alone.
#[derive(Debug)]
struct BadInMotion;

impl FrictionCoefficient for BadInMotion {
    fn coefficient(&self, _pressure: f64, rate: f64) -> CoefficientValue {
        let value = if rate == 0.0 { 0.3 } else { f64::NAN };
        CoefficientValue { value, by_pressure: 0.0, by_rate: 0.0 }
    }
}

impl FrictionCoefficient for Bad {
    fn coefficient(&self, _pressure: f64, _rate: f64) -> CoefficientValue {
        CoefficientValue { value: -0.1, by_pressure: 0.0, by_rate: 0.0 }
    }
}

/// A flat block on a flat plate, pressed 0.02 deep and moved along x since it was accepted.
fn block(law: &ContactLaw<'_>, by: f64) -> (Pair, FaceInterface, Vec<Point>) {
    closing_block(law, -0.02, [by, 0.0])
}

/// The same at a gap when it was accepted, moved along x and z.
fn closing_block(law: &ContactLaw<'_>, gap: f64, by: [f64; 2]) -> (Pair, FaceInterface, Vec<Point>) {
    let pair = Pair::new([6, 5], false, |x, y| [x, y, 0.0], |x, y| [1.0 + 0.6 * x, 1.0 + 0.5 * y, gap]);
    let mut own = pair.interface(ContactElement::default(), FaceRule::Second);
    own.refresh(&pair.positions).unwrap();
    own.accept(law).unwrap();
    let first = pair.first_slave;
    let moved =
        |(k, &[x, y, z]): (usize, &Point)| if k < first { [x, y, z] } else { [x + by[0], y, z + by[1]] };
    let moved: Vec<Point> = pair.positions.iter().enumerate().map(moved).collect();
    own.refresh(&moved).unwrap();
    (pair, own, moved)
}

#[test]
fn laws_of_ones_own_have_their_pressures_tractions_and_tangents() {
    let quadratic = Quadratic(2500.0);
    assert!(
        quadratic.derivative_error(0, -0.02, 1e-4) < 1e-9 && quadratic.derivative_error(0, 0.3, 1e-4) == 0.0
    );
    let friction = Coulomb::variable(&Falling, DURATION, STIFFNESS).unwrap();
    let law = ContactLaw::penalty(50.0).with_normal(Some(&quadratic)).with_friction(Some(friction));
    // Some stick, some slide: the slip is 0.01 x at most.
    for (by, state) in [(1e-3, FrictionState::Stick), (0.05, FrictionState::Slip)] {
        let (pair, mut own, moved) = block(&law, by);
        let nodes = own.evaluate(&law, Mode::Value).unwrap().nodes().to_vec();
        for node in nodes {
            assert!((node.pressure - 1.0).abs() < 1e-12 && (node.stiffness - 100.0).abs() < 1e-9, "{node:?}");
            assert_eq!(node.friction_state, state);
            let traction = Vector3::from(node.friction).norm();
            let rate = (by - traction / STIFFNESS) / DURATION;
            let allowed = Falling.coefficient(node.pressure, rate).value * node.pressure;
            let expected = if state == FrictionState::Slip { allowed } else { STIFFNESS * by };
            assert!((traction - expected).abs() < 1e-12, "{traction} {expected}");
        }
        for pressures in FacePressures::ALL {
            own.set_pressures(pressures);
            assert_tangent_at(&pair, &mut own, &law, &moved, 11);
        }
    }
}

#[test]
fn a_table_of_the_penalty_is_the_penalty() {
    let pair = bumps(false);
    let mut own = pair.interface(ContactElement::default(), FaceRule::Second);
    own.refresh(&pair.positions).unwrap();
    let table = TabulatedPressure::new(&[-1.0, -0.01, 0.0, 1.0], &[50.0, 0.5, 0.0, -50.0]).unwrap();
    let expected = pair.forces(own.evaluate(&ContactLaw::penalty(50.0), Mode::Gradient).unwrap());
    let law = ContactLaw::penalty(50.0).with_normal(Some(&table));
    let found = pair.forces(own.evaluate(&law, Mode::Gradient).unwrap());
    for (found, expected) in found.as_flattened().iter().zip(expected.as_flattened()) {
        assert!((found - expected).abs() < 1e-13, "{found} {expected}");
    }
    for (gaps, pressures, place) in [
        (&[0.0][..], &[1.0][..], 1),
        (&[0.0, 0.0], &[1.0, 0.0], 1),
        (&[0.0, 1.0], &[1.0, f64::NAN], 3),
        (&[0.0, 1.0], &[1.0], 3),
    ] {
        assert_eq!(TabulatedPressure::new(gaps, pressures), Err(AssemblyError::InvalidTable { place }));
    }
}

#[test]
fn laws_that_give_no_numbers_are_refused() {
    let refused = |law: &ContactLaw<'_>, code: &str| {
        let (_, mut own, _) =
            block(&ContactLaw::penalty(50.0).with_friction(Coulomb::new(0.3, 1.0).ok()), 0.05);
        let history = own.history();
        assert_eq!(own.evaluate(law, Mode::Gradient).unwrap_err().code(), code);
        assert_eq!(own.accept(law).err().map(|error| error.code()), Some(code));
        assert_eq!(own.history(), history);
    };
    let plain = ContactLaw::penalty(50.0);
    refused(&plain.with_normal(Some(&Bad)), "invalid-pressure");
    refused(&plain.with_normal(Some(&Bad)).with_multipliers(Some(&[])), "multipliers-of-own-law");
    let friction = Coulomb::variable(&Bad, DURATION, STIFFNESS).ok();
    refused(&plain.with_friction(friction), "invalid-coefficient");
    let friction = Coulomb::variable(&BadInMotion, DURATION, 1e9).ok();
    refused(&plain.with_friction(friction), "invalid-coefficient");
    let (_, mut own, _) = block(&plain.with_friction(Coulomb::new(0.3, 1.0).ok()), 0.05);
    assert_eq!(own.accept(&plain.with_normal(Some(&Nowhere))).unwrap_err().code(), "invalid-onset");
    for duration in [0.0, f64::NAN] {
        let error = Coulomb::variable(&Falling, duration, STIFFNESS).unwrap_err();
        assert_eq!(error.code(), "invalid-duration");
    }
}

/// A pressure that begins at a gap of 0.03: a contact that closes has touched there.
#[test]
fn contacts_close_where_their_pressure_begins() {
    let table = TabulatedPressure::new(&[-0.07, 0.03], &[5.0, 0.0]).unwrap();
    let friction = Coulomb::new(0.9, STIFFNESS).unwrap();
    let law = ContactLaw::penalty(50.0).with_normal(Some(&table)).with_friction(Some(friction));
    // From a gap of 0.05 to one of 0.02: a third of the way was in touch.
    let (pair, mut own, moved) = closing_block(&law, 0.05, [3e-3, -0.03]);
    for node in own.evaluate(&law, Mode::Value).unwrap().nodes() {
        assert!((node.pressure - 0.5).abs() < 1e-12, "{node:?}");
        assert!((node.slip - 1e-3).abs() < 1e-12, "{node:?}");
        assert!((node.friction[0] + STIFFNESS * 1e-3).abs() < 1e-11, "{node:?}");
    }
    assert_tangent_at(&pair, &mut own, &law, &moved, 11);
}

/// A contact that closes at a constant rate has that rate from its touch on, but for its elastic slip.
#[test]
fn contacts_that_close_slide_at_the_rate_of_their_time_in_touch() {
    let friction = Coulomb::variable(&Falling, DURATION, STIFFNESS).unwrap();
    let law = ContactLaw::penalty(50.0).with_friction(Some(friction));
    // A quarter of the way and of the time was in touch.
    let (pair, mut own, moved) = closing_block(&law, 0.03, [0.2, -0.04]);
    for node in own.evaluate(&law, Mode::Value).unwrap().nodes() {
        assert_eq!(node.friction_state, FrictionState::Slip);
        let traction = Vector3::from(node.friction).norm();
        let rate = (0.25 * 0.2 - traction / STIFFNESS) / (0.25 * DURATION);
        let expected = Falling.coefficient(node.pressure, rate).value * node.pressure;
        assert!((traction - expected).abs() < 1e-12, "{traction} {expected}");
    }
    assert_tangent_at(&pair, &mut own, &law, &moved, 11);
}

/// With the motion given, each round adds ε_T s to the traction of what sticks, until it slides.
#[test]
fn augmentation_raises_tractions_until_they_slide() {
    let friction = Coulomb::new(0.3, STIFFNESS).unwrap().with_augmentation(true);
    let law = ContactLaw::penalty(50.0).with_friction(Some(friction));
    let by = 1.5e-3;
    let (pair, mut own, moved) = block(&law, by);
    let traction = |own: &mut FaceInterface| {
        let nodes = own.evaluate(&law, Mode::Value).unwrap().nodes();
        let (first, state) = (nodes[0].friction, nodes[0].friction_state);
        for node in nodes {
            let difference = (Vector3::from(node.friction) - Vector3::from(first)).norm();
            assert!(difference < 1e-12, "{difference:e} {node:?}");
        }
        (-first[0], state)
    };
    let without = Coulomb::new(0.3, STIFFNESS).ok();
    let refused = own.slip_errors(&ContactLaw::penalty(50.0).with_friction(without)).unwrap_err();
    assert_eq!(refused.code(), "no-augmentation");
    // Without friction there is nothing to take over.
    let none = ContactLaw::penalty(50.0);
    assert_eq!(own.slip_errors(&none), Ok(vec![0.0; own.slaves().len()]));
    own.augment(&none, |_| true).unwrap();
    assert_eq!(own.augmented_history(), own.history());
    let (history, before) = (own.history(), own.evaluate(&law, Mode::Gradient).unwrap().clone());
    for round in 1..=3 {
        let (found, state) = traction(&mut own);
        assert!((found - f64::from(round) * STIFFNESS * by).abs() < 1e-12, "{round} {found}");
        assert_eq!(state, FrictionState::Stick);
        assert!(own.slip_errors(&law).unwrap().iter().all(|error| (error - by).abs() < 1e-14));
        // A multiplier is no slip.
        let contacts = own.evaluate(&law, Mode::Value).unwrap();
        assert!(contacts.nodes().iter().all(|node| (node.slip - by).abs() < 1e-14));
        own.augment(&law, |_| true).unwrap();
        own.update(&moved).unwrap();
        assert_eq!(own.history(), history);
    }
    assert_tangent_at(&pair, &mut own, &law, &moved, 13);
    own.update(&moved).unwrap();
    // μ p = 0.3 is less than four times 0.09: from here on it slides, as it should.
    assert_eq!(traction(&mut own), (traction(&mut own).0, FrictionState::Slip));
    assert!((traction(&mut own).0 - 0.3).abs() < 1e-13);
    assert!(own.slip_errors(&law).unwrap().iter().all(|&error| error < 1e-14));
    own.augment(&law, |_| true).unwrap();
    assert!((traction(&mut own).0 - 0.3).abs() < 1e-13);
    let forces = pair.forces(own.evaluate(&law, Mode::Gradient).unwrap());
    let at = Pair { positions: moved.clone(), master: Vec::new(), slave: Vec::new(), ..pair };
    at.assert_balance(&forces);

    // The step is given up: nothing is left of it.
    let mut again = block(&law, by).1;
    again.augment(&law, |_| true).unwrap();
    again.roll_back();
    again.refresh(&moved).unwrap();
    let forces_before = at.forces(&before);
    assert_eq!(at.forces(again.evaluate(&law, Mode::Gradient).unwrap()), forces_before);

    // Accepted and saved, it goes on bit for bit: a little back it sticks again.
    own.accept(&law).unwrap();
    let history = own.history();
    let mut other = block(&law, by).1;
    other.set_history(&history).unwrap();
    let back: Vec<Point> = moved
        .iter()
        .enumerate()
        .map(|(k, &[x, y, z])| [x - if k < at.first_slave { 0.0 } else { 1e-3 }, y, z])
        .collect();
    for interface in [&mut own, &mut other] {
        interface.refresh(&back).unwrap();
        let (found, state) = traction(interface);
        assert!((found - (0.3 - STIFFNESS * 1e-3)).abs() < 1e-12 && state == FrictionState::Stick, "{found}");
        let errors = interface.slip_errors(&law).unwrap();
        assert!(errors.iter().all(|error| (error - 1e-3).abs() < 1e-13), "{errors:?}");
        interface.augment(&law, |_| true).unwrap();
        interface.accept(&law).unwrap();
    }
    assert_eq!(own.history(), other.history());
}
