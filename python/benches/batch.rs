//! The other side of `overhead.py`: for each line `elements nodes mode` of the input it evaluates the elements once with the Rust
//! library and answers with nanoseconds per element. One thread; results are written to memory that is reused.
#![forbid(unsafe_code)]

use std::collections::HashMap;
use std::error::Error;
use std::hint::black_box;
use std::io::{self, BufRead, Write};
use std::time::Instant;

use diffuse_contact::{
    Basis, BatchScratch, ContactPoint, Element, ElementError, Frame, GapSlot, Generated, Mode, Point, Weight,
};

/// Elements made and handed to the library at once.
const PIECE: usize = 64;

fn main() -> Result<(), Box<dyn Error>> {
    let mut batches = HashMap::new();
    for line in io::stdin().lock().lines() {
        let line = line?;
        let words: Vec<&str> = line.split(' ').collect();
        let [elements, nodes, mode] = words[..] else {
            return Err("a line has elements, nodes and mode".into());
        };
        let (elements, nodes) = (elements.parse()?, nodes.parse()?);
        let mode = match mode {
            "value" => Mode::Value,
            "gradient" => Mode::Gradient,
            "hessian" => Mode::Hessian,
            _ => return Err(format!("no mode {mode}").into()),
        };
        let batch = batches.entry(line.clone()).or_insert_with(|| Batch::new(elements, nodes, mode));
        let start = Instant::now();
        batch.evaluate()?;
        println!("{:.2}", start.elapsed().as_secs_f64() * 1e9 / f64::from(elements));
        io::stdout().flush()?;
    }
    Ok(())
}

/// Elements and their results.
struct Batch {
    nodes: usize,
    mode: Mode,
    slaves: Vec<Point>,
    masters: Vec<Point>,
    points: Vec<ContactPoint>,
    gradients: Vec<f64>,
    hessians: Vec<f64>,
    scratch: BatchScratch,
}

impl Batch {
    /// The same numbers as in `overhead.py`, up to rounding.
    fn new(elements: u32, nodes: usize, mode: Mode) -> Self {
        let count = elements as usize;
        let mut slaves = Vec::with_capacity(count);
        let mut masters = Vec::with_capacity(count * nodes);
        for element in 0..count {
            let shift = element as f64 / count as f64;
            slaves.push([0.2 * shift, 0.1, 0.05 - 0.1 * shift]);
            for k in 0..nodes {
                let angle = 2.4 * k as f64 + shift;
                let r = ((k as f64 + 0.5) / nodes as f64).sqrt();
                let [x, y] = [r * angle.cos(), r * angle.sin()];
                masters.push([x, y, 0.1 * x - 0.1 * x * x + 0.05 * x * y]);
            }
        }
        let freedoms = 3 * (nodes + 1);
        let gradient = if mode >= Mode::Gradient { freedoms } else { 0 };
        let hessian = if mode >= Mode::Hessian { freedoms * (freedoms + 1) / 2 } else { 0 };
        Self {
            nodes,
            mode,
            slaves,
            masters,
            points: vec![ContactPoint::default(); count],
            gradients: vec![0.0; count * gradient],
            hessians: vec![0.0; count * hessian],
            scratch: BatchScratch::default(),
        }
    }

    fn evaluate(&mut self) -> Result<(), ElementError> {
        let Self { nodes, mode, slaves, masters, points, gradients, hessians, scratch } = self;
        let (gradient, hessian) = (gradients.len() / slaves.len(), hessians.len() / slaves.len());
        let (mut n, mut m) = (gradients.chunks_mut(gradient.max(1)), hessians.chunks_mut(hessian.max(1)));
        let pieces = slaves.chunks(PIECE).zip(masters.chunks(PIECE * *nodes)).zip(points.chunks_mut(PIECE));
        for ((slaves, masters), points) in pieces {
            let elements = slaves.iter().zip(masters.chunks(*nodes)).map(|(&slave, masters)| {
                let frame = Frame::average_plane(masters, [0.0, 0.0, 1.0])?;
                let (basis, weight) = (Basis::Quadratic, Weight::Cubic);
                Ok(Element::new(slave, masters, frame, 1.6).with_basis(basis).with_weight(weight))
            });
            let elements = elements.collect::<Result<Vec<_>, ElementError>>()?;
            let slots = elements.iter().map(|_| GapSlot {
                gradient: n.next().unwrap_or_default(),
                hessian: m.next().unwrap_or_default(),
            });
            let results = Generated.gap_batch(&elements, *mode, slots, scratch);
            for (point, result) in points.iter_mut().zip(results) {
                *point = result?;
            }
        }
        black_box((&*points, &*gradients, &*hessians));
        Ok(())
    }
}
