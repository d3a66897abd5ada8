//! Time of contact over faces per integration point, by one thread: gap and first derivatives with forces, and the tangent besides.
//!
//! ```text
//! RAYON_NUM_THREADS=1 cargo run --release -p diffuse-contact-benches --example faces [faces along a side] [rounds]
//! ```
//!
//! Faces a little finer than the facets of a wavy surface, all of them pressed in.

use std::time::Instant;

use diffuse_contact::assembly::ContactLaw;
use diffuse_contact::faces::{FaceInterface, FaceOptions};
use diffuse_contact::surface::{Facet, MasterSurface};
use diffuse_contact::{InterfaceOptions, Mode, Point};

type Failure = Box<dyn std::error::Error>;

/// Length of the waves, in cells; their height is 1.
const WAVELENGTH: f64 = 16.0;
/// The faces begin and end so many cells inside the master.
const INSET: f64 = 2.3;
/// How deep they lie, in cells.
const DEPTH: f64 = 0.01;

fn main() -> Result<(), Failure> {
    let argument = |k: usize, otherwise: usize| {
        std::env::args().nth(k).map_or(Ok(otherwise), |argument| argument.parse::<usize>())
    };
    let (side, rounds) = (argument(1, 100)?, argument(2, 5)?);
    let wave = std::f64::consts::TAU / WAVELENGTH;
    let height = |x: f64, y: f64| (wave * x).sin() * (wave * y).cos();
    let nodes = side + 1;
    let place = |k: usize| [(k % nodes) as f64, (k / nodes) as f64];
    let mut positions: Vec<Point> =
        (0..nodes * nodes).map(place).map(|[x, y]| [x, y, height(x, y)]).collect();
    let step = (side as f64 - 2.0 * INSET) / side as f64;
    positions.extend((0..nodes * nodes).map(|k| {
        let [x, y] = place(k).map(|x| INSET + step * x);
        [x, y, height(x, y) - DEPTH]
    }));
    let corners = |first: usize| (0..side * side).map(move |k| first + k % side + nodes * (k / side));
    let master = corners(0).map(|k| Facet::Quadrilateral([k, k + 1, k + 1 + nodes, k + nodes]));
    // They look down.
    let faces = corners(nodes * nodes).map(|k| Facet::Quadrilateral([k, k + nodes, k + 1 + nodes, k + 1]));
    let faces: Vec<Facet> = faces.collect();

    let master = MasterSurface::new(&positions, master.collect())?;
    let options = FaceOptions::new(InterfaceOptions::default());
    let mut interface = FaceInterface::new(master, &faces, &positions, options)?;
    let report = interface.update(&positions)?;
    assert_eq!(report.points, report.paired, "every point has masters");
    println!("{} points over {} faces, µs per point", report.points, report.faces);
    let law = ContactLaw::penalty(100.0);
    for (name, mode) in [("forces", Mode::Gradient), ("forces and tangent", Mode::Hessian)] {
        let mut best = f64::INFINITY;
        for _ in 0..rounds {
            let start = Instant::now();
            interface.evaluate(&law, mode)?;
            best = best.min(start.elapsed().as_secs_f64());
        }
        println!("{name} {:.3}", 1e6 * best / report.points as f64);
    }
    Ok(())
}
