//! The work of contact around a closed path: a rigid pad is carried around over waves, with its nodes or its faces as slaves.
//!
//! Over nodes the force on the pad is the gradient of an energy, over faces it is none: what that costs is the work of a closed loop.
//! `docs/how-to/pressures.md` has the table that the test prints with `--nocapture`; `CLOSED_PATH_STEPS` sets the number of steps.

use diffuse_contact::assembly::{ContactLaw, DofMap};
use diffuse_contact::faces::{FaceInterface, FaceOptions};
use diffuse_contact::interface::{ContactInterface, InterfaceOptions};
use diffuse_contact::surface::Facet;
use diffuse_contact::{Mode, Point};

use super::common::Mesh;

const LENGTH: f64 = 12.0;

fn wave(x: f64, y: f64) -> f64 {
    let k = std::f64::consts::TAU / LENGTH;
    (k * x).sin() * (k * y).sin()
}

/// The pad's lowest point: a figure that crosses facets in all directions, 0.05 below the exact surface.
fn path(turn: f64) -> Point {
    let tau = std::f64::consts::TAU;
    let [x, y] = [2.0 * tau * turn + 0.3, 3.0 * tau * turn].map(|angle| 12.0 + 7.0 * angle.sin());
    [x, y, wave(x, y) - 0.05]
}

/// Of a pad of 14 × 14 cells of 0.41 whose lower side is z = r²/2.
fn pad() -> Mesh {
    Mesh::grid([15, 15], [false; 2], |s, t| {
        let [x, y] = [s, t].map(|part| 0.41 * 14.0 * (part - 0.5));
        [x, y, 0.5 * (x * x + y * y)]
    })
}

enum Contact {
    Nodes(Box<ContactInterface>),
    Faces(Box<FaceInterface>),
}

/// ∮ F·dx by the trapezoidal rule over ∮ ‖F‖ ‖dx‖ with all steps and with every other one, and the least and the largest ‖F‖.
fn around(options: InterfaceOptions, over_faces: bool, steps: usize) -> ([f64; 2], [f64; 2]) {
    let waves = Mesh::grid([25, 25], [false; 2], |s, t| [24.0 * s, 24.0 * t, wave(24.0 * s, 24.0 * t)]);
    let first = waves.positions.len();
    let pad = pad();
    let at = |place: Point| -> Vec<Point> {
        let moved = pad.positions.iter().map(|x| [0, 1, 2].map(|axis| x[axis] + place[axis]));
        waves.positions.iter().copied().chain(moved).collect()
    };
    let facet = |facet: &Facet| match *facet {
        Facet::Triangle(corners) => Facet::Triangle(corners.map(|k| k + first)).flipped(),
        Facet::Quadrilateral(corners) => Facet::Quadrilateral(corners.map(|k| k + first)).flipped(),
    };
    let facets: Vec<Facet> = pad.facets.iter().map(facet).collect();
    let start = at(path(0.0));
    let mut contact = if over_faces {
        let made = FaceInterface::new(waves.surface(), &facets, &start, FaceOptions::new(options));
        Contact::Faces(Box::new(made.unwrap()))
    } else {
        let slaves = (first..start.len()).collect();
        let options = options.with_areas(true);
        let made = ContactInterface::new(waves.surface(), slaves, &facets, &start, options);
        Contact::Nodes(Box::new(made.unwrap()))
    };
    let (law, dofs) = (ContactLaw::penalty(1.0), DofMap::standard(start.len()));
    let mut force = |place: Point| -> Point {
        let positions = at(place);
        let mut forces = vec![0.0; dofs.equations()];
        match &mut contact {
            Contact::Nodes(interface) => {
                interface.renew_pairing(&positions).unwrap();
                let contacts = interface.evaluate(Mode::Gradient).unwrap();
                diffuse_contact::add_forces(contacts, &law, &dofs, &mut forces).unwrap();
            }
            Contact::Faces(interface) => {
                interface.refresh(&positions).unwrap();
                let contacts = interface.evaluate(&law, Mode::Gradient).unwrap();
                contacts.add_forces(&dofs, &mut forces).unwrap();
            }
        }
        let of_pad = forces[3 * first..].as_chunks::<3>().0;
        [0, 1, 2].map(|axis| of_pad.iter().map(|force| force[axis]).sum())
    };
    let places: Vec<Point> = (0..steps).map(|step| path(step as f64 / steps as f64)).collect();
    let forces: Vec<Point> = places.iter().map(|&place| force(place)).collect();
    let dot = |a: Point, b: Point| (0..3).map(|axis| a[axis] * b[axis]).sum::<f64>();
    let size = |a: Point| dot(a, a).sqrt();
    let work = |every: usize| {
        let (mut work, mut effort) = (0.0, 0.0);
        for from in (0..steps).step_by(every) {
            let to = (from + every) % steps;
            let along = [0, 1, 2].map(|axis| places[to][axis] - places[from][axis]);
            work += 0.5 * (dot(forces[from], along) + dot(forces[to], along));
            effort += 0.5 * (size(forces[from]) + size(forces[to])) * size(along);
        }
        work / effort
    };
    let sizes = forces.iter().map(|&force| size(force));
    let range = |[low, high]: [f64; 2], size: f64| [low.min(size), high.max(size)];
    ([work(1), work(2)], sizes.fold([f64::INFINITY, f64::NEG_INFINITY], range))
}

/// Little in all ways; how little is a matter of steps.
#[test]
fn contact_does_next_to_no_work_around_a_closed_path() {
    let smooth = InterfaceOptions::default();
    let ways = [
        ("smooth, nodes", smooth, false),
        ("smooth, faces", smooth, true),
        ("facets, nodes", InterfaceOptions::node_to_facet(), false),
        ("facets, faces", InterfaceOptions::node_to_facet(), true),
    ];
    let steps = std::env::var("CLOSED_PATH_STEPS").ok().and_then(|steps| steps.parse().ok()).unwrap_or(400);
    // What is left is mostly the rule's: the work falls with the square of the step.
    for (name, options, over_faces) in ways {
        let ([work, coarse], [least, largest]) = around(options, over_faces, steps);
        println!("| {name} | {least:.3} to {largest:.3} | {work:+.1e} | {coarse:+.1e} |");
        assert!(largest > 0.03 && work.abs() < 5e-4, "{name}: {largest} {work:e}");
    }
}
