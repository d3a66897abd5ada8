//! Time of a whole interface per slave: its pairing; gap, N and M; pattern and values of its tangent.
//!
//! ```text
//! RAYON_NUM_THREADS=1 cargo run --release -p diffuse-contact-benches --example interface [slaves along a side] [rounds]
//! ```
//!
//! The scene is that of `cargo lab study throughput`: a wavy surface of quadrilaterals, and as many slaves on a grid that
//! is shifted and a little finer, just above and below it. Times are of the processor where the system tells them, which other work on
//! the machine disturbs less. `benches/interface.py` runs this beside the same program of an older commit, so it uses nothing that is new.

use std::time::Instant;

use diffuse_contact::assembly::{ContactLaw, CsrPattern, DofMap};
use diffuse_contact::interface::{ContactInterface, InterfaceOptions};
use diffuse_contact::surface::{Facet, MasterSurface};
use diffuse_contact::{Mode, Point};

type Failure = Box<dyn std::error::Error>;

/// Length of the waves, in cells; their height is 1.
const WAVELENGTH: f64 = 16.0;
/// The slaves' grid begins and ends so many cells inside the master's.
const INSET: f64 = 1.3;
/// How far slaves lie off the surface, in cells.
const DISTANCE: f64 = 0.05;
/// How far slaves slide before they are paired once more, in cells.
const SLIDE: f64 = 1e-3;

fn main() -> Result<(), Failure> {
    let argument = |k: usize, otherwise: usize| {
        std::env::args().nth(k).map_or(Ok(otherwise), |argument| argument.parse::<usize>())
    };
    let (side, rounds) = (argument(1, 317)?, argument(2, 5)?);
    let (mut positions, slaves, facets) = scene(side);
    let count = slaves.len();
    let loads = vec![1e4; count];
    let master = MasterSurface::new(&positions, facets)?;
    let mut interface = ContactInterface::new(master, slaves, &[], &positions, InterfaceOptions::default())?;
    let clock = Clock::new();
    let per_slave = |start: f64| 1e6 * (clock.seconds() - start) / count as f64;
    let start = clock.seconds();
    interface.refresh_pairing(&positions)?;
    println!("rebuilt {:.3}", per_slave(start));
    // A small slide, as between two iterations.
    positions[side * side..].iter_mut().for_each(|position| position[0] += SLIDE);
    for _ in 0..rounds {
        let start = clock.seconds();
        interface.refresh_pairing(&positions)?;
        println!("kept {:.3}", per_slave(start));
    }
    for (mode, rounds) in [(Mode::Value, 1), (Mode::Gradient, 1), (Mode::Hessian, rounds)] {
        for _ in 0..rounds {
            let (mut contacts, mut nodes, mut sum) = (0, 0, 0.0);
            let start = clock.seconds();
            interface.for_each(mode, |contact| {
                contacts += usize::from(contact.outcome.is_contact());
                nodes += contact.nodes.len();
                sum += contact.point.gap.abs();
            })?;
            println!("{mode:?} {:.3}", per_slave(start));
            assert_eq!(contacts, count, "every slave has a contact");
            assert!(sum.is_finite() && nodes > 0);
        }
    }
    // Every slave carries force.
    let dofs = DofMap::standard(positions.len());
    // The field, not its builder: older commits have no other.
    let mut law = ContactLaw::penalty(1e3);
    law.multipliers = Some(&loads);
    let contacts = interface.evaluate(Mode::Hessian)?;
    for _ in 0..rounds {
        let start = clock.seconds();
        let pattern = CsrPattern::union(contacts, &dofs)?;
        println!("pattern {:.3}", per_slave(start));
        // Memory is touched for the first time by the first of them.
        let mut values = vec![0.0; pattern.entries()];
        for _ in 0..2 {
            let start = clock.seconds();
            assert_eq!(pattern.fill(contacts, &law, &mut values)?, count);
            println!("fill {:.3}", per_slave(start));
        }
    }
    Ok(())
}

/// Time of the processor for this process, or where the system does not tell, that of the wall.
struct Clock(Instant);

impl Clock {
    fn new() -> Self {
        Self(Instant::now())
    }

    fn seconds(&self) -> f64 {
        Self::of_threads().unwrap_or_else(|| self.0.elapsed().as_secs_f64())
    }

    /// As Linux counts it, in nanoseconds.
    fn of_threads() -> Option<f64> {
        let mut total = 0.0;
        for thread in std::fs::read_dir("/proc/self/task").ok()? {
            let counted = std::fs::read_to_string(thread.ok()?.path().join("schedstat")).ok()?;
            total += counted.split_whitespace().next()?.parse::<f64>().ok()?;
        }
        Some(1e-9 * total)
    }
}

/// Positions of masters and, behind them, slaves; indices of the slaves; facets of the master.
fn scene(side: usize) -> (Vec<Point>, Vec<usize>, Vec<Facet>) {
    let wave = std::f64::consts::TAU / WAVELENGTH;
    let height = |x: f64, y: f64| (wave * x).sin() * (wave * y).cos();
    let place = |k: usize| [(k % side) as f64, (k / side) as f64];
    let mut positions: Vec<Point> = (0..side * side).map(place).map(|[x, y]| [x, y, height(x, y)]).collect();
    let corners = (0..side - 1).flat_map(|j| (0..side - 1).map(move |i| i + side * j));
    let facets = corners.map(|k| Facet::Quadrilateral([k, k + 1, k + 1 + side, k + side])).collect();
    let width = (side - 1) as f64;
    let step = (width - 2.0 * INSET) / width;
    let slaves = (0..side * side).map(|k| {
        let [x, y] = place(k).map(|x| INSET + step * x);
        positions.push([x, y, height(x, y) + if k % 2 == 0 { DISTANCE } else { -DISTANCE }]);
        positions.len() - 1
    });
    let slaves = slaves.collect();
    (positions, slaves, facets)
}
