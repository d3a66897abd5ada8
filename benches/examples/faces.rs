//! Time of contact over faces per integration point, by one thread: gap and first derivatives with forces, and the tangent besides.
//!
//! ```text
//! RAYON_NUM_THREADS=1 cargo run --release -p diffuse-contact-benches --example faces [faces along a side] [rounds]
//! ```
//!
//! Faces a little finer than the facets of a wavy surface, all of them pressed in. Before them the kernel of a point by itself, with nine
//! masters.

use std::time::Instant;

use diffuse_contact::assembly::ContactLaw;
use diffuse_contact::faces::{FaceInterface, FaceOptions};
use diffuse_contact::surface::{Facet, MasterSurface};
use diffuse_contact::{
    BatchScratch, Domains, Element, ElementError, FootSlot, Frame, GapSlot, Generated, InterfaceOptions,
    MaterialDomain, MaterialNode, MaterialPlace, Mode, Point, Weight,
};

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
    println!("kernel of a point, nine masters, in a batch: {:.3} µs", kernel(rounds)?);
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

/// The kernel of a point by itself, of nine masters in a patch that is curved and uneven: µs for gap, foot, normal, N and first derivatives of
/// the last two.
fn kernel(rounds: usize) -> Result<f64, Failure> {
    const MASTERS: usize = 9;
    const ELEMENTS: usize = 512;
    let ripple = |k: usize| 0.1 * (1.7 * k as f64).sin();
    let patches: Vec<(Vec<Point>, Vec<MaterialNode>, Point, Frame)> = (0..ELEMENTS)
        .map(|element| {
            let at = |k: usize, shift: usize| (k as f64) - 1.0 + ripple(MASTERS * element + k + shift);
            let masters: Vec<Point> =
                (0..MASTERS).map(|k| [at(k % 3, k), at(k / 3, 5 + k), ripple(3 * element + k)]).collect();
            let domains: Vec<MaterialDomain> = masters
                .iter()
                .filter_map(|&x| {
                    MaterialDomain::of_ellipsoid(x, [[6.0, 0.0, 0.0], [0.0, 6.0, 0.0], [0.0, 0.0, 6.0]])
                })
                .collect();
            let slave = [ripple(element), ripple(element + 1), -0.05];
            let up = [0.0, 0.0, 1.0];
            let place = MaterialPlace::find(slave, &masters, &domains, |r| Weight::Cubic.fitting(r), up)?;
            Ok((masters, place.nodes(&domains), slave, place.frame))
        })
        .collect::<Result<_, ElementError>>()?;
    let elements: Vec<Element<'_>> = patches
        .iter()
        .map(|(masters, nodes, slave, frame)| {
            Element::new(*slave, masters, *frame, 1.0).with_domains(Domains::Material(nodes))
        })
        .collect();
    let form = Generated.hessian_form(&elements[0])?;
    let freedoms = form.degrees_of_freedom();
    let mut gradients = vec![0.0; freedoms * ELEMENTS];
    let mut numbers = vec![0.0; form.foot_numbers() * ELEMENTS];
    let (mut weights, mut rows) = (vec![0.0; MASTERS], [vec![0.0; 3 * freedoms], vec![0.0; 3 * freedoms]]);
    let mut scratch = BatchScratch::default();
    let mut best = f64::INFINITY;
    for _ in 0..20 * rounds {
        let start = Instant::now();
        let slots = gradients.chunks_mut(freedoms).zip(numbers.chunks_mut(form.foot_numbers()));
        let slots = slots.map(|(gradient, hessian)| GapSlot { gradient, hessian });
        let points = Generated.gap_foot_batch(&elements, slots, &mut scratch);
        for (k, point) in points.into_iter().enumerate() {
            let [foot, normal] = &mut rows;
            let mut target = FootSlot { weights: &mut weights, foot, normal };
            let own = &numbers[form.foot_numbers() * k..][..form.foot_numbers()];
            form.foot_derivatives(&point?, &gradients[freedoms * k..][..freedoms], own, &mut target)?;
        }
        best = best.min(start.elapsed().as_secs_f64());
    }
    Ok(1e6 * best / ELEMENTS as f64)
}
