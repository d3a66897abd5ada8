//! The decks of problems with known answers, on coarse meshes, with both elements.
//!
//! Bounds stand a little above what is measured on these meshes; `docs/verification.md` has the figures of the decks as they are.

use std::path::Path;

use diffuse_contact_solver::deck::{Contact, Deck, PartSource};
use diffuse_contact_solver::model::shape::{RigidPlane, Shape};
use diffuse_contact_solver::verification::{
    LineContact, Oscillation, PointContact, PressureProfile, Trace, Uniformity, trace,
};

const ELEMENTS: [Contact; 2] = [Contact::NodeToFacet, Contact::Diffuse];

/// A deck of `examples/` with this element.
fn deck(name: &str, element: Contact) -> Deck {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples").join(name);
    Deck { contact: element, ..Deck::read(path).unwrap() }
}

fn divide(deck: &mut Deck, part: &str, divisions: &[usize]) {
    deck.shape_mut(part).unwrap().divisions_mut().copy_from_slice(divisions);
}

fn run<T>(
    deck: &Deck,
    measure: impl FnMut(
        &diffuse_contact_solver::verification::Snapshot<'_>,
    ) -> Result<T, diffuse_contact_solver::solid::SolidError>,
) -> Trace<T> {
    let trace = trace(deck, Path::new(""), 1, measure).unwrap();
    println!(
        "{} increments, {} iterations, {:.1} s",
        trace.measures.len(),
        trace.iterations,
        trace.wall.as_secs_f64()
    );
    trace
}

/// Uniformity and contact force at the end.
fn pressed(deck: &Deck) -> (Uniformity, f64) {
    let run = run(deck, |snapshot| Ok((Uniformity::of(snapshot, 2, 100.0)?, snapshot.contact_force()[2])));
    println!("{:?}", run.measures.last());
    *run.measures.last().unwrap()
}

/// One point force a slave node cannot pass a uniform pressure where meshes do not match, but the sum arrives.
#[test]
fn patch_test() {
    for (element, one_pass, two_pass) in [(Contact::NodeToFacet, 0.42, 0.011), (Contact::Diffuse, 0.40, 0.16)]
    {
        let mut deck = deck("patch_test.toml", element);
        let (uniformity, force) = pressed(&deck);
        assert!(uniformity.stress < one_pass && uniformity.stress > 0.1, "{uniformity:?}");
        assert!((force / 1e4 - 1.0).abs() < 1e-5, "{force}");
        deck.interfaces[0].two_pass = true;
        let (uniformity, force) = pressed(&deck);
        assert!(uniformity.stress < two_pass, "{uniformity:?}");
        assert!((force / 1e4 - 1.0).abs() < 1e-5, "{force}");
    }
}

/// Where meshes match, facets pass it exactly.
#[test]
fn patch_test_with_matching_meshes() {
    for (element, bound) in [(Contact::NodeToFacet, 1e-4), (Contact::Diffuse, 0.3)] {
        let mut deck = deck("patch_test.toml", element);
        divide(&mut deck, "lower", &[4, 4, 2]);
        divide(&mut deck, "upper", &[4, 4, 2]);
        let (uniformity, _) = pressed(&deck);
        assert!(uniformity.stress < bound, "{uniformity:?}");
    }
}

const MODULUS: f64 = 200_000.0 / 0.91;

/// Makes the curved body the master, and the floor's nodes the slaves.
fn press_floor(deck: &mut Deck, floor_size: [f64; 2], floor_divisions: [usize; 2]) {
    deck.interfaces[0].exchange = true;
    let floor = deck.parts.iter_mut().find(|part| part.name == "floor").unwrap();
    floor.translation = [0.0; 3];
    let PartSource::Shape(Shape::RigidPlane(RigidPlane { size, divisions, .. })) = &mut floor.source else {
        panic!("the floor is a plane");
    };
    (*size, *divisions) = (floor_size, floor_divisions);
}

/// Force and largest pressure at the end.
fn peak(deck: &Deck) -> (f64, f64) {
    let run = run(deck, |snapshot| {
        let profile = PressureProfile::of(snapshot, |x| x[0].hypot(x[1]));
        Ok((snapshot.contact_force()[2].abs(), profile.largest()))
    });
    *run.measures.last().unwrap()
}

#[test]
fn hertz_cylinder() {
    for element in ELEMENTS {
        for (curved_master, bound) in [(false, 0.02), (true, 0.03)] {
            let mut deck = deck("hertz_cylinder.toml", element);
            divide(&mut deck, "cylinder", &[12, 10, if curved_master { 2 } else { 1 }]);
            if curved_master {
                press_floor(&mut deck, [0.8, 0.5], [12, 2]);
            }
            let (force, largest) = peak(&deck);
            // Half of the cylinder, 0.5 long.
            let exact = LineContact { force: 2.0 * force / 0.5, radius: 10.0, modulus: MODULUS };
            let error = largest / exact.peak_pressure() - 1.0;
            println!("{element:?} {curved_master} {error}");
            assert!(error.abs() < bound, "{element:?} {error}");
        }
    }
}

#[test]
fn hertz_sphere() {
    for element in ELEMENTS {
        for (curved_master, bound) in [(false, 0.05), (true, 0.05)] {
            let mut deck = deck("hertz_sphere.toml", element);
            divide(&mut deck, "ball", &[5, 4]);
            if curved_master {
                press_floor(&mut deck, [1.2, 1.2], [8, 8]);
            }
            let (force, largest) = peak(&deck);
            // A quarter of the ball.
            let exact = PointContact { force: 4.0 * force, radius: 10.0, modulus: MODULUS };
            let error = largest / exact.peak_pressure() - 1.0;
            println!("{element:?} {curved_master} {error}");
            assert!(error.abs() < bound, "{element:?} {error}");
        }
    }
}

/// Largest torque while the shaft turns, over R Σ f.
fn torque(deck: &Deck) -> f64 {
    let run = run(deck, |snapshot| {
        let force: f64 = snapshot.slaves().map(|slave| slave.force).sum();
        Ok(snapshot.moment("shaft.inner", [0.0; 3]).unwrap()[2] / (50.0 * force))
    });
    Oscillation::of(run.measures).unwrap().amplitude()
}

#[test]
fn coaxial_cylinders() {
    let [classic, diffuse] = ELEMENTS.map(|element| {
        let mut deck = deck("coaxial_cylinders.toml", element);
        divide(&mut deck, "shaft", &[36, 1, 2]);
        divide(&mut deck, "ring", &[40, 1, 2]);
        // 2 degrees: after one, nodes face each other as before.
        deck.time.end = 0.1;
        torque(&deck)
    });
    println!("{classic} {diffuse}");
    assert!(diffuse < 2e-3, "{diffuse}");
    assert!(classic > 10.0 * diffuse, "{classic} {diffuse}");
}

/// Peak to peak of the forces across and along the turn, over the mean force.
fn sliding(deck: &Deck) -> [f64; 2] {
    let run = run(deck, |snapshot| Ok((snapshot.record.time, snapshot.contact_force())));
    let of = |axis: usize| {
        let turning = run.measures.iter().filter(|(time, _)| *time > 0.2 + 1e-9);
        Oscillation::of(turning.map(|(_, force)| force[axis])).unwrap()
    };
    [2, 0].map(|axis| of(axis).peak_to_peak() / of(2).mean)
}

#[test]
fn sliding_block() {
    let [classic, diffuse] = ELEMENTS.map(|element| {
        let mut deck = deck("sliding_block.toml", element);
        divide(&mut deck, "block", &[4, 4, 2]);
        // 4 degrees: more than a facet.
        (deck.time.end, deck.time.increment, deck.time.maximum) = (0.36, 0.02, 0.02);
        sliding(&deck)
    });
    println!("{classic:?} {diffuse:?}");
    for (classic, diffuse) in classic.into_iter().zip(diffuse) {
        assert!(diffuse < 1e-3, "{diffuse}");
        assert!(classic > 20.0 * diffuse, "{classic} {diffuse}");
    }
}

#[test]
fn ring_block() {
    for (element, most) in [(Contact::NodeToFacet, 200), (Contact::Diffuse, 150)] {
        let mut deck = deck("ring_block.toml", element);
        divide(&mut deck, "ring", &[16, 1, 1]);
        divide(&mut deck, "block", &[10, 3, 2]);
        let run = run(&deck, |snapshot| Ok(snapshot.contact_force()[1]));
        println!("{:?} {} {} {:?}", element, run.iterations, run.cutbacks, run.measures.last());
        assert!(run.iterations < most, "{element:?}: {} iterations", run.iterations);
    }
}
