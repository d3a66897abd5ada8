//! The decks of problems with known answers, on coarse meshes, with both elements.
//!
//! Bounds stand a little above what is measured on these meshes; `docs/results/verification.md` has the figures of the decks as they are.

use std::path::Path;

use diffuse_contact::Weight;
use diffuse_contact::faces::{FacePressures, FaceRule};
use diffuse_contact::interface::ContactElement;
use diffuse_contact::neighbourhood::SearchOptions;
use diffuse_contact_solver::contact::{Integration, SlaveState};
use diffuse_contact_solver::deck::{Boundary, Contact, Deck, PartSource, Reference};
use diffuse_contact_solver::model::Motion;
use diffuse_contact_solver::model::shape::{
    Axis, Block, Facets, HalfSpace, KINDS, RigidCylinder, RigidSphere, Shape, Side,
};
use diffuse_contact_solver::solid::SolidError;
use diffuse_contact_solver::verification::{
    LineContact, Oscillation, PointContact, PressureProfile, Snapshot, Trace, Uniformity, trace,
};

use crate::common::worse;

const ELEMENTS: [Contact; 2] = [Contact::NodeToFacet, Contact::Diffuse];

/// A deck of `examples/` with this element.
fn deck(name: &str, element: Contact) -> Deck {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples").join(name);
    Deck { contact: element, ..Deck::read(path).unwrap() }
}

fn divide(deck: &mut Deck, part: &str, divisions: &[usize]) {
    deck.shape_mut(part).unwrap().divisions_mut().copy_from_slice(divisions);
}

fn run<T>(deck: &Deck, measure: impl FnMut(&Snapshot<'_>) -> Result<T, SolidError>) -> Trace<T> {
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

/// Integrated over faces a uniform pressure passes, whatever the meshes, the weight, the penalty and the roles.
#[test]
fn patch_test_over_faces() {
    let meshes = [([5, 5, 2], [3, 4, 2]), ([4, 4, 2], [4, 4, 2]), ([3, 3, 2], [7, 5, 2])];
    let smooth = Weight::ALL.map(|weight| ContactElement::default().with_weight(weight));
    let elements = smooth.into_iter().chain([ContactElement::NodeToFacet]);
    // The last of the meshes has all elements, the default among them.
    let default = meshes[..2].iter().map(|&mesh| (ContactElement::default(), mesh));
    for (element, (lower, upper)) in elements.map(|element| (element, meshes[2])).chain(default) {
        for (exchange, rule, penalty) in
            [(false, FaceRule::Second, 5e3), (true, FaceRule::Second, 5e6), (false, FaceRule::Fourth, 5e5)]
        {
            let mut deck = deck("patch_test.toml", Contact::Diffuse);
            divide(&mut deck, "lower", &lower);
            divide(&mut deck, "upper", &upper);
            deck.newton.tolerance = 1e-13;
            let interface = &mut deck.interfaces[0];
            interface.surface = interface.surface.with_element(element);
            interface.integration = Integration::Faces { rule, pressures: FacePressures::Nodes };
            (interface.exchange, interface.penalty) = (exchange, Some(penalty));
            let (Uniformity { stress, other_stress, contact, .. }, force) = pressed(&deck);
            for error in [stress, other_stress, contact] {
                assert!(error < 1e-9, "{error:e} {element:?} {lower:?} {upper:?} {exchange} {penalty:e}");
            }
            assert!((force.abs() / 1e4 - 1.0).abs() < 1e-9, "{force}");
        }
    }
}

/// So do elements of all kinds, at three ratios of the meshes and with either side as slave: faces of second order carry forces by their
/// own shape functions.
#[test]
fn patch_test_over_faces_of_all_kinds() {
    let kinds = KINDS.map(|(_, kind)| kind);
    let meshes = [([3, 2, 1], [2, 3, 1]), ([2, 2, 1], [2, 2, 1]), ([2, 1, 1], [4, 3, 1])];
    for (k, upper) in kinds.into_iter().enumerate() {
        for (mesh, (below, above)) in meshes.into_iter().enumerate() {
            for exchange in [false, true] {
                // Against itself and another kind, soft and stiff, by one weight and the next, turn and turn about.
                let turn = k + mesh + usize::from(exchange);
                let lower = kinds[(k + turn % 2) % kinds.len()];
                let (penalty, weight) = ([5e3, 5e6][mesh % 2], Weight::ALL[turn % Weight::ALL.len()]);
                let mut deck = deck("patch_test.toml", Contact::Diffuse);
                divide(&mut deck, "lower", &below);
                divide(&mut deck, "upper", &above);
                for part in &mut deck.parts {
                    part.element = if part.name == "lower" { lower } else { upper };
                }
                deck.newton.tolerance = 1e-13;
                let interface = &mut deck.interfaces[0];
                interface.surface.element = interface.surface.element.with_weight(weight);
                interface.integration = Integration::FACES;
                (interface.exchange, interface.penalty) = (exchange, Some(penalty));
                let (Uniformity { stress, other_stress, .. }, force) = pressed(&deck);
                let error = worse(stress, other_stress);
                assert!(
                    error < 1e-9,
                    "{error:e} {upper:?} on {lower:?} {below:?} {above:?} {exchange} {weight:?}"
                );
                assert!((force.abs() / 1e4 - 1.0).abs() < 1e-9, "{force}");
            }
        }
    }
}

/// Nor do surfaces have to end at faces of the other side, whichever is the slave: a face is covered in part by each of two others.
#[test]
fn patch_test_with_partial_overlap() {
    for element in ELEMENTS {
        for roles in [[false, false], [true, true], [false, true]] {
            let mut deck =
                Deck { contact: element, ..Deck::parse(include_str!("partial_overlap.toml")).unwrap() };
            deck.newton.tolerance = 1e-12;
            deck.interfaces
                .iter_mut()
                .zip(roles)
                .for_each(|(interface, exchange)| interface.exchange = exchange);
            let measured = run(&deck, |snapshot| Uniformity::of(snapshot, 2, 10.0));
            let Uniformity { stress, other_stress, .. } = *measured.measures.last().unwrap();
            println!("{element:?} {roles:?}: {stress:e} {other_stress:e}");
            let error = worse(stress, other_stress);
            assert!(error < 1e-9, "{element:?} {roles:?}: {stress:e} {other_stress:e}");
        }
    }
}

/// Lamé's pressure and displacement on coarse rings that do not match.
#[test]
fn shrink_fit() {
    let deck = deck("shrink_fit.toml", Contact::Diffuse);
    let measured = run(&deck, |snapshot| {
        let pressure = |slave: SlaveState| {
            let along: f64 = (0..3).map(|axis| slave.nodal_force[axis] * slave.normal[axis]).sum();
            along / slave.area / 40.384_615 - 1.0
        };
        let worst = snapshot.slaves().map(pressure).map(f64::abs).fold(0.0, worse);
        let radius = |x: &[f64; 3]| x[0].hypot(x[1]);
        let outside: Vec<f64> = snapshot
            .problem
            .start_positions()
            .iter()
            .zip(&snapshot.state.positions)
            .filter(|(start, _)| (radius(start) - 45.0).abs() < 1e-9)
            .map(|(start, end)| radius(end) - radius(start))
            .collect();
        let mean = outside.iter().sum::<f64>() / outside.len() as f64;
        Ok((worst, mean / 0.013_846_154 - 1.0))
    });
    let (pressure, displacement) = *measured.measures.last().unwrap();
    assert!(pressure < 0.012 && displacement.abs() < 1e-3, "{pressure} {displacement}");
}

/// The deck of the tutorial, with the forces of its table.
#[test]
fn the_first_contact_problem() {
    let page = include_str!("../../docs/tutorial/first-problem.md");
    let text = page.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    for (element, label) in
        [(Contact::Diffuse, "| smooth surface, facets of 10° |"), (Contact::NodeToFacet, "| facets of 10° |")]
    {
        let row = page.lines().find_map(|line| line.strip_prefix(label)).unwrap();
        let expected: f64 = row.split('|').next().unwrap().trim().replace(',', "").parse().unwrap();
        let deck = Deck { contact: element, ..Deck::parse(text).unwrap() };
        let force = run(&deck, |snapshot| Ok(snapshot.contact_force()[2])).measures.pop().unwrap();
        assert!((force / expected - 1.0).abs() < 1e-4, "{force}");
    }
}

/// Where meshes match, facets pass it exactly.
#[test]
fn patch_test_with_matching_meshes() {
    for (element, bound) in [(Contact::NodeToFacet, 1e-6), (Contact::Diffuse, 0.18)] {
        let mut deck = deck("patch_test.toml", element);
        divide(&mut deck, "lower", &[4, 4, 2]);
        divide(&mut deck, "upper", &[4, 4, 2]);
        let (uniformity, _) = pressed(&deck);
        assert!(uniformity.stress < bound, "{uniformity:?}");
    }
}

const MODULUS: f64 = 200_000.0 / 0.91;

/// Makes the cylinder the master of an elastic block, whose nodes are the slaves.
fn soften_floor(deck: &mut Deck, cells: usize) {
    let materials = deck.parts[0].materials.clone();
    let floor = deck.parts.iter_mut().find(|part| part.name == "floor").unwrap();
    floor.source = PartSource::Shape(Shape::Block(Block {
        origin: [0.0, 0.0, -10.0],
        size: [10.0, 0.5, 10.0],
        divisions: [cells, 2, cells],
        grading: [80.0, 1.0, 1.0 / 80.0],
    }));
    (floor.materials, floor.translation) = (materials, [0.0; 3]);
    let named = |name: &str| vec![Reference { name: name.into(), line: 0 }];
    deck.boundaries[0].nodes = named("floor.z-");
    for (nodes, axes) in [
        ("floor.x-", [true, false, false]),
        ("floor.y-", [false, true, false]),
        ("floor.y+", [false, true, false]),
    ] {
        deck.boundaries.push(Boundary { line: 0, nodes: named(nodes), axes, motion: Motion::fixed() });
    }
    let interface = &mut deck.interfaces[0];
    interface.master = std::mem::replace(&mut interface.slave, named("floor.z+"));
}

/// Force and pressures at the end.
fn press(deck: &Deck, distance: fn([f64; 3]) -> f64) -> (f64, PressureProfile) {
    let mut run = run(deck, |snapshot| {
        let profile = PressureProfile::of(snapshot, distance);
        Ok((snapshot.contact_force()[2].abs(), profile))
    });
    run.measures.pop().unwrap()
}

/// Half of the cylinder, 0.5 long.
fn line_contact(force: f64, modulus: f64) -> LineContact {
    LineContact { force: 2.0 * force / 0.5, radius: 10.0, modulus }
}

#[test]
fn hertz_cylinder() {
    for element in ELEMENTS {
        let mut deck = deck("hertz_cylinder.toml", element);
        divide(&mut deck, "cylinder", &[12, 10, 1]);
        let (force, profile) = press(&deck, |x| x[0].abs());
        let error = profile.largest() / line_contact(force, MODULUS).peak_pressure() - 1.0;
        assert!(error.abs() < 0.005, "{element:?} {error}");
    }
}

/// The curved body carries the contact surface; nodal pressures scatter, their fit is Hertz'.
#[test]
fn hertz_cylinder_as_master() {
    for (element, bound) in [(Contact::NodeToFacet, 0.005), (Contact::Diffuse, 0.035)] {
        let mut deck = deck("hertz_cylinder.toml", element);
        divide(&mut deck, "cylinder", &[10, 8, 2]);
        soften_floor(&mut deck, 12);
        // Cells are graded: domains reach farther than layers here.
        deck.interfaces[0].surface.element = ContactElement::diffuse(SearchOptions::default());
        let (force, profile) = press(&deck, |x| x[0].abs());
        let exact = line_contact(force, 0.5 * MODULUS).peak_pressure();
        let [peak, _] = profile.ellipse().unwrap();
        println!("{element:?} {}", peak / exact - 1.0);
        assert!((peak / exact - 1.0).abs() < bound, "{element:?} {peak} {exact}");
    }
}

#[test]
fn hertz_sphere() {
    for element in ELEMENTS {
        let mut deck = deck("hertz_sphere.toml", element);
        divide(&mut deck, "ball", &[8, 8]);
        let (force, profile) = press(&deck, |x| x[0].hypot(x[1]));
        // A quarter of the ball.
        let exact = PointContact { force: 4.0 * force, radius: 10.0, modulus: MODULUS };
        let error = profile.largest() / exact.peak_pressure() - 1.0;
        println!("{element:?} {error}");
        assert!(error.abs() < 0.02, "{element:?} {error}");
    }
}

/// A cylinder of the same radius, rigid and of facets as wide as the contact, in place of the floor. The smooth surface is round, so that
/// Hertz' pressure is that of half the radius; the facets have an edge where the bodies touch first.
#[test]
fn hertz_cylinder_on_a_faceted_cylinder() {
    let errors = ELEMENTS.map(|element| {
        let mut deck = deck("hertz_cylinder.toml", element);
        let floor = deck.parts.iter_mut().find(|part| part.name == "floor").unwrap();
        floor.source = PartSource::Shape(Shape::RigidCylinder(RigidCylinder {
            axis: Axis::Y,
            radius: 10.0,
            angles: [-20.0, 20.0],
            length: 2.5,
            divisions: [8, 5],
            facets: Facets::Quadrilaterals,
            side: Side::Outside,
        }));
        floor.translation = [0.0, -1.0, -10.0];
        let (force, profile) = press(&deck, |x| x[0].abs());
        let exact = LineContact { radius: 5.0, ..line_contact(force, MODULUS) }.peak_pressure();
        profile.largest() / exact - 1.0
    });
    println!("{errors:?}");
    let [classic, diffuse] = errors.map(f64::abs);
    assert!(diffuse < 0.015, "{diffuse}");
    assert!(classic > 0.2, "{classic}");
}

/// The same of a ball, whose own mesh is good for 3 %.
#[test]
fn hertz_sphere_on_a_faceted_sphere() {
    let errors = ELEMENTS.map(|element| {
        let mut deck = deck("hertz_sphere.toml", element);
        divide(&mut deck, "ball", &[7, 6]);
        let floor = deck.parts.iter_mut().find(|part| part.name == "floor").unwrap();
        floor.source = PartSource::Shape(Shape::RigidSphere(RigidSphere {
            radius: 10.0,
            keep: vec![HalfSpace { axis: Axis::Z, positive: true }],
            divisions: 12,
            grading: [1.0; 3],
            facets: Facets::Quadrilaterals,
            side: Side::Outside,
        }));
        floor.translation = [0.0, 0.0, -10.0];
        let (force, profile) = press(&deck, |x| x[0].hypot(x[1]));
        let exact = PointContact { force: 4.0 * force, radius: 5.0, modulus: MODULUS }.peak_pressure();
        profile.largest() / exact - 1.0
    });
    println!("{errors:?}");
    let [classic, diffuse] = errors.map(f64::abs);
    assert!(diffuse < 0.035, "{diffuse}");
    assert!(classic > 0.2, "{classic}");
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
    assert!(diffuse < 1e-3, "{diffuse}");
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
        assert!(classic > 100.0 * diffuse, "{classic} {diffuse}");
    }
}

/// The ring snaps through at about 43 mm. Up to there the force is that of the ring's shape, the same for both elements; what is left of it at
/// the end is a matter of the few nodes that touch then.
#[test]
fn ring_block() {
    // Iterations of the two increments that facets cut back are counted, too.
    let runs = [(Contact::NodeToFacet, 170), (Contact::Diffuse, 105)].map(|(element, most)| {
        let mut deck = deck("ring_block.toml", element);
        divide(&mut deck, "ring", &[16, 1, 1]);
        divide(&mut deck, "block", &[10, 3, 2]);
        let run = run(&deck, |snapshot| Ok((snapshot.record.time, snapshot.contact_force()[1].abs())));
        println!("{:?} {} {}", element, run.iterations, run.cutbacks);
        assert!(run.iterations < most, "{element:?}: {} iterations", run.iterations);
        run.measures
    });
    // The increments are the same up to the peak.
    let [classic, diffuse] = &runs;
    let rise = classic.iter().zip(diffuse).take_while(|((time, _), _)| *time < 0.72);
    assert_eq!(rise.clone().count(), 15);
    for ((time, classic), (same, diffuse)) in rise {
        assert_eq!(time, same);
        assert!((classic / diffuse - 1.0).abs() < 0.025, "{time}: {classic} {diffuse}");
    }
    for run in &runs {
        let peak = run.iter().map(|(_, force)| *force).fold(0.0, f64::max);
        let (_, end) = *run.last().unwrap();
        assert!((peak / 3e4 - 1.0).abs() < 0.02, "{peak}");
        assert!((0.2..0.3).contains(&(end / peak)), "{end} after {peak}");
    }
}

/// Nodal domains on the ring: slaves of the block above its ends, beyond the border, have no contact with it, however the fit of the
/// nodes on one side goes on.
#[test]
fn a_ring_with_nodal_domains_snaps_through() {
    let mut deck = deck("ring_block.toml", Contact::Diffuse);
    deck.interfaces[0].exchange = true;
    let run = run(&deck, |snapshot| Ok(snapshot.contact_force()[1].abs()));
    assert_eq!((run.measures.len(), run.cutbacks), (21, 0));
    let peak = run.measures.iter().copied().fold(0.0, f64::max);
    assert!((0.2..0.35).contains(&(run.measures.last().unwrap() / peak)), "{:?}", run.measures);
}
