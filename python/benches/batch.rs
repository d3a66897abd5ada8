//! Nanoseconds per element of the Rust library on the elements of `overhead.py`, as `nodes mode nanoseconds` per line.
//! One thread; the best of many rounds; results are written to memory that is reused.
#![forbid(unsafe_code)]

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use diffuse_contact::{
    Basis, BatchScratch, Element, ElementError, Frame, GapSlot, Generated, Mode, Point, Weight,
};

/// Elements of a batch.
const ELEMENTS: usize = 10_000;
/// Elements made and handed to the library at once.
const PIECE: usize = 64;

fn main() -> Result<(), Box<dyn Error>> {
    let rounds = std::env::args().nth(1).map_or(Ok(60), |rounds| rounds.parse())?;
    for nodes in [9, 12, 16] {
        let (slaves, masters) = scene(nodes);
        for (mode, name) in [(Mode::Value, "value"), (Mode::Gradient, "gradient"), (Mode::Hessian, "hessian")]
        {
            let freedoms = 3 * (nodes + 1);
            let packed = freedoms * (freedoms + 1) / 2;
            let mut gradients = vec![0.0; if mode >= Mode::Gradient { ELEMENTS * freedoms } else { 0 }];
            let mut hessians = vec![0.0; if mode >= Mode::Hessian { ELEMENTS * packed } else { 0 }];
            let (mut gaps, mut feet, mut normals) =
                (vec![0.0; ELEMENTS], vec![[0.0; 3]; ELEMENTS], vec![[0.0; 3]; ELEMENTS]);
            let mut scratch = BatchScratch::default();
            let mut best = f64::INFINITY;
            for _ in 0..rounds {
                let start = Instant::now();
                for piece in (0..ELEMENTS).step_by(PIECE) {
                    let range = piece..(piece + PIECE).min(ELEMENTS);
                    let elements = range
                        .clone()
                        .map(|k| {
                            let masters = &masters[k * nodes..(k + 1) * nodes];
                            let frame = Frame::average_plane(masters, [0.0, 0.0, 1.0])?;
                            let (basis, weight) = (Basis::Quadratic, Weight::Cubic);
                            Ok(Element {
                                slave: slaves[k],
                                masters,
                                frame,
                                support_radius: 1.6,
                                basis,
                                weight,
                            })
                        })
                        .collect::<Result<Vec<_>, ElementError>>()?;
                    let mut n = if mode >= Mode::Gradient {
                        gradients[range.start * freedoms..range.end * freedoms].chunks_mut(freedoms)
                    } else {
                        [].chunks_mut(1)
                    };
                    let mut m = if mode >= Mode::Hessian {
                        hessians[range.start * packed..range.end * packed].chunks_mut(packed)
                    } else {
                        [].chunks_mut(1)
                    };
                    let slots = elements.iter().map(|_| GapSlot {
                        gradient: n.next().unwrap_or_default(),
                        hessian: m.next().unwrap_or_default(),
                    });
                    let points = Generated.gap_batch(&elements, mode, slots, &mut scratch);
                    for (k, point) in range.zip(points) {
                        let point = point?;
                        (gaps[k], feet[k], normals[k]) = (point.gap, point.foot, point.normal);
                    }
                }
                black_box((&gaps, &feet, &normals, &gradients, &hessians));
                best = best.min(start.elapsed().as_secs_f64());
            }
            println!("{nodes} {name} {:.2}", 1e9 * best / ELEMENTS as f64);
        }
    }
    Ok(())
}

/// The same numbers as in `overhead.py`, up to rounding.
fn scene(nodes: usize) -> (Vec<Point>, Vec<Point>) {
    let mut slaves = Vec::with_capacity(ELEMENTS);
    let mut masters = Vec::with_capacity(ELEMENTS * nodes);
    for element in 0..ELEMENTS {
        let shift = element as f64 / ELEMENTS as f64;
        slaves.push([0.2 * shift, 0.1, 0.05 - 0.1 * shift]);
        for k in 0..nodes {
            let angle = 2.4 * k as f64 + shift;
            let r = ((k as f64 + 0.5) / nodes as f64).sqrt();
            let [x, y] = [r * angle.cos(), r * angle.sin()];
            masters.push([x, y, 0.1 * x - 0.1 * x * x + 0.05 * x * y]);
        }
    }
    (slaves, masters)
}
