//! Time of contact over faces per integration point, by one thread: gap and first derivatives with forces, and the tangent besides.
//!
//! ```text
//! RAYON_NUM_THREADS=1 cargo run --release -p diffuse-contact-benches --example faces [faces along a side] [rounds]
//! ```
//!
//! Faces a little finer than the facets of a wavy surface, all of them pressed in. Before them the kernel of a point by itself, with nine
//! masters.

use std::hint::black_box;
use std::time::Instant;

use diffuse_contact::assembly::ContactLaw;
use diffuse_contact::faces::{FaceInterface, FaceOptions};
use diffuse_contact::surface::{Facet, MasterSurface};
use diffuse_contact::{
    Basis, BatchScratch, Domains, Element, ElementError, FootSlot, Frame, GapSlot, Generated,
    InterfaceOptions, MaterialDomain, MaterialNode, MaterialPlace, Mode, Point, Weight,
};
use diffuse_contact_benches::generated::inputs;
use diffuse_contact_benches::peak::fma_per_ns;
use diffuse_contact_kernels::cubic::Cubic;
use diffuse_contact_kernels::support::{
    BatchElement, FrameRule, GapValues, KernelSet, SecondKind, Status, Workspace,
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
    let patches = Patches::new()?;
    let peak = fma_per_ns(Cubic::best_isa());
    println!(
        "{peak:.1} fused multiply-adds a nanosecond; a point of nine masters in a batch, µs, in brackets at 56 of them"
    );
    for (name, kind) in [
        ("kernel: gap, foot, normal, N, ∂ν/∂x, φ", SecondKind::FactorsAndFoot),
        ("kernel: gap, foot, normal, N and the slave's rows of M, as faces have them", SecondKind::SlaveRows),
    ] {
        let time = patches.kernel(kind, rounds);
        println!("{name} {time:.3} ({:.3})", time * peak / ASKED_PEAK);
    }
    println!("the first with ∂x^d/∂x, elements checked {:.3}", patches.checked(rounds)?);
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

/// Points whose kernels are timed, of nine masters in patches that are curved and uneven.
struct Patches {
    masters: Vec<Vec<Point>>,
    nodes: Vec<Vec<MaterialNode>>,
    slaves: Vec<(Point, Frame)>,
}

const MASTERS: usize = 9;
/// Fused multiply-adds a nanosecond of the machine that goals in µs are for, see benches/rivals/reach.py.
const ASKED_PEAK: f64 = 56.0;
const ELEMENTS: usize = 512;
/// As in `benches/src/batch.rs`: results stay in the cache.
const BATCH: usize = 16;

impl Patches {
    fn new() -> Result<Self, ElementError> {
        let ripple = |k: usize| 0.1 * (1.7 * k as f64).sin();
        let (mut all, up) =
            (Self { masters: Vec::new(), nodes: Vec::new(), slaves: Vec::new() }, [0.0, 0.0, 1.0]);
        for element in 0..ELEMENTS {
            let at = |k: usize, shift: usize| (k as f64) - 1.0 + ripple(MASTERS * element + k + shift);
            let masters: Vec<Point> =
                (0..MASTERS).map(|k| [at(k % 3, k), at(k / 3, 5 + k), ripple(3 * element + k)]).collect();
            let sphere = [[6.0, 0.0, 0.0], [0.0, 6.0, 0.0], [0.0, 0.0, 6.0]];
            let domains: Vec<MaterialDomain> =
                masters.iter().filter_map(|&x| MaterialDomain::of_ellipsoid(x, sphere)).collect();
            let slave = [ripple(element), ripple(element + 1), -0.05];
            let place = MaterialPlace::find(slave, &masters, &domains, |r| Weight::Cubic.fitting(r), up)?;
            all.nodes.push(place.nodes(&domains));
            all.slaves.push((slave, place.frame));
            all.masters.push(masters);
        }
        Ok(all)
    }

    fn element(&self, k: usize) -> Element<'_> {
        let (slave, frame) = self.slaves[k];
        Element::new(slave, &self.masters[k], frame, 1.0).with_domains(Domains::Material(&self.nodes[k]))
    }

    /// µs of a point for gap, foot, normal, N and what `kind` says.
    fn kernel(&self, kind: SecondKind, rounds: usize) -> f64 {
        let (of, freedoms) = ((Basis::Quadratic, FrameRule::Material), 3 * (MASTERS + 1));
        let form = Cubic::gap_form(of, MASTERS);
        let numbers = match kind {
            SecondKind::SlaveRows => form.slave_rows(),
            _ => form.foot_numbers(),
        };
        let (isa, mut workspace) = (Cubic::best_isa(), Workspace::default());
        let (mut gradients, mut seconds) = (vec![0.0; freedoms * BATCH], vec![0.0; numbers * BATCH]);
        let mut best = f64::INFINITY;
        for _ in 0..20 * rounds {
            let start = Instant::now();
            for first in (0..ELEMENTS).step_by(BATCH) {
                let slots = gradients.chunks_exact_mut(freedoms).zip(seconds.chunks_exact_mut(numbers));
                let mut elements: Vec<BatchElement<'_>> = (first..)
                    .zip(slots)
                    .map(|(k, (gradient, hessian))| BatchElement {
                        inputs: inputs(&self.element(k), [0.0; 2]),
                        values: GapValues::NONE,
                        gradient,
                        hessian,
                        places: &[],
                    })
                    .collect();
                Cubic::gap_factors_batch(isa, of, kind, &mut elements, &mut workspace);
                assert!(elements.iter().all(|element| element.values.status() == Status::Ok));
                black_box(elements);
            }
            best = best.min(start.elapsed().as_secs_f64());
        }
        1e6 * best / ELEMENTS as f64
    }

    /// µs of a point for all first derivatives, its element checked before and ∂x^d/∂x made of N and ∂ν/∂x after.
    fn checked(&self, rounds: usize) -> Result<f64, Failure> {
        let elements: Vec<Element<'_>> = (0..ELEMENTS).map(|k| self.element(k)).collect();
        let form = Generated.hessian_form(&elements[0])?;
        let freedoms = form.degrees_of_freedom();
        let mut gradients = vec![0.0; freedoms * ELEMENTS];
        let mut numbers = vec![0.0; form.foot_numbers() * ELEMENTS];
        let (mut weights, mut rows) =
            (vec![0.0; MASTERS], [vec![0.0; 3 * freedoms], vec![0.0; 3 * freedoms]]);
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
}
