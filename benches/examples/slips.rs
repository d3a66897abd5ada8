//! Time of g, N, M and the slip q with its gradient and Hessian over that of g, N and M, in batches:
//!
//! ```text
//! cargo run --release -p diffuse-contact-benches --features friction --example slips
//! ```

use std::hint::black_box;
use std::time::Instant;

use diffuse_contact::{Basis, Domains, Element, Frame, Mode, Point};
use diffuse_contact_benches::generated::inputs;
use diffuse_contact_kernels::cubic::Cubic;
use diffuse_contact_kernels::support::{
    BatchElement, ElementInputs, FrameRule, GapValues, KernelSet, MaterialNode, Status, Workspace, packed_row,
};

type Failure = Box<dyn std::error::Error>;

const ELEMENTS: usize = 256;
/// As in `benches/src/batch.rs`: results stay in the cache.
const BATCH: usize = 16;
const ROUNDS: usize = 200;
const SLAVE: Point = [0.05, -0.03, 0.1];
const SUPPORT_RADIUS: f64 = 1.3;

fn main() -> Result<(), Failure> {
    println!("one element of a batch, ns: g, N, M; g, N, M and q, ∇q, ∇²q; the ratio");
    for rule in [FrameRule::Held, FrameRule::CoMoving, FrameRule::Material] {
        for nodes in [9, 16] {
            let [gap, slip] = measure(nodes, rule)?;
            println!("n = {nodes:2}, {rule:?}: {gap:6.0} {slip:6.0} {:.2}", slip / gap);
        }
    }
    Ok(())
}

/// The masters of the k-th element about the origin, in rings.
fn patch(nodes: usize, k: usize) -> Vec<Point> {
    let masters = (0..nodes).map(|i| {
        let noise = ((7 * i + 13 * k) as f64).sin();
        let radius = ((i as f64 + 0.5) / nodes as f64).sqrt();
        let angle = 2.399_963 * i as f64 + 0.1 * noise;
        let (x, y) = (radius * angle.cos(), radius * angle.sin());
        [x, y, 0.1 * x * x - 0.07 * x * y + 0.01 * noise]
    });
    masters.collect()
}

/// A domain of the support radius in the first configuration.
fn domain(master: &Point) -> MaterialNode {
    let scale = 1.0 / SUPPORT_RADIUS;
    let offset = std::array::from_fn(|axis| master[axis] - SLAVE[axis]);
    MaterialNode { offset, metric: [scale, 0.0, 0.0, scale, 0.0, scale] }
}

/// Nanoseconds, the least of all rounds, which take turns.
fn measure(nodes: usize, rule: FrameRule) -> Result<[f64; 2], Failure> {
    let patches: Vec<Vec<Point>> = (0..ELEMENTS).map(|k| patch(nodes, k)).collect();
    let is_material = rule == FrameRule::Material;
    let domains: Vec<Vec<MaterialNode>> =
        patches.iter().map(|masters| masters.iter().map(domain).collect()).collect();
    let mut all = Vec::with_capacity(ELEMENTS);
    for (masters, domains) in patches.iter().zip(&domains) {
        let frame = Frame::average_plane(masters, [0.0, 0.0, 1.0])?;
        let domains = if is_material { Domains::Material(domains) } else { Domains::Shared };
        all.push(Element::new(SLAVE, masters, frame, SUPPORT_RADIUS).with_domains(domains));
    }
    let freedoms = 3 * (nodes + 1);
    let sizes = [
        (freedoms, packed_row(freedoms)),
        (2 * freedoms + 3 + nodes, packed_row(freedoms) + packed_row(freedoms + 3)),
    ];
    let kernel = (Basis::Quadratic, rule, Mode::Hessian);
    let (isa, mut workspace) = (Cubic::best_isa(), Workspace::default());
    // Memory of the system's is slow when it is touched first.
    let mut numbers = sizes.map(|(gradients, hessians)| vec![0.0; BATCH * (gradients + hessians)]);
    let mut best = [f64::INFINITY; 2];
    for _ in 0..ROUNDS {
        for (what, (gradients, hessians)) in sizes.into_iter().enumerate() {
            let start = Instant::now();
            for batch in all.chunks(BATCH) {
                let mut rest = numbers[what].chunks_exact_mut(gradients + hessians);
                let elements = batch.iter().filter_map(|element| {
                    let (gradient, hessian) = rest.next()?.split_at_mut(gradients);
                    let inputs = ElementInputs { anchor: [0.02, 0.01, 0.0], ..inputs(element, [0.0; 2]) };
                    Some(BatchElement { inputs, values: GapValues::NONE, gradient, hessian, places: &[] })
                });
                let mut elements: Vec<BatchElement<'_>> = elements.collect();
                match what {
                    0 => Cubic::gap_batch(isa, kernel, &mut elements, &mut workspace),
                    _ => Cubic::slip_batch(isa, kernel, &mut elements, &mut workspace),
                }
                assert!(elements.iter().all(|element| element.values.status() == Status::Ok));
                black_box(elements);
            }
            best[what] = best[what].min(start.elapsed().as_secs_f64());
        }
    }
    Ok(best.map(|time| 1e9 * time / ELEMENTS as f64))
}
