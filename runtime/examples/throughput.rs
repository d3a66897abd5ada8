//! How long a refresh and an evaluation of a whole interface take, and how much memory.
//!
//! ```sh
//! cargo run --release -p diffuse-contact --example throughput -- 100000
//! ```
//!
//! The argument is the number of slave nodes and, roughly, of master nodes (default 10000): a wavy surface of
//! quadrilaterals, cells a little distorted, with as many slaves scattered closely over and under it. Prints
//! seconds for each step and the peak memory of the process. A second argument `facets` takes the node-to-facet
//! element.

use std::error::Error;
use std::time::Instant;

use diffuse_contact::interface::{ContactInterface, InterfaceOptions};
use diffuse_contact::pairing::NearestNodes;
use diffuse_contact::surface::{Facet, MasterSurface};
use diffuse_contact::{Mode, Point};

/// A small deterministic generator of numbers in [0, 1).
struct Uniform(u64);

impl Uniform {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let wanted: usize = arguments.next().map_or(Ok(10_000), |text| text.parse())?;
    let options = match arguments.next().as_deref() {
        Some("facets") => InterfaceOptions::node_to_facet(),
        _ => InterfaceOptions::default(),
    };
    let side = (wanted as f64).sqrt().ceil().max(2.0) as usize;
    let mut random = Uniform(1);
    let height = |x: f64, y: f64| 2.0 * (0.3 * x).sin() * (0.2 * y).cos();
    let mut positions: Vec<Point> = (0..side * side)
        .map(|k| {
            let x = (k % side) as f64 + 0.3 * (random.next() - 0.5);
            let y = (k / side) as f64 + 0.3 * (random.next() - 0.5);
            [x, y, height(x, y)]
        })
        .collect();
    let facets: Vec<Facet> = (0..(side - 1) * (side - 1))
        .map(|k| k % (side - 1) + side * (k / (side - 1)))
        .map(|k| Facet::Quadrilateral([k, k + 1, k + side + 1, k + side]))
        .collect();
    let slaves: Vec<usize> = (0..wanted)
        .map(|_| {
            let [x, y] = [random.next(), random.next()].map(|s| 0.5 + s * (side - 2) as f64);
            positions.push([x, y, height(x, y) + 0.2 * (random.next() - 0.5)]);
            positions.len() - 1
        })
        .collect();
    println!("{} slaves, {} facets, {} threads", wanted, facets.len(), rayon::current_num_threads());

    let master = timed("connect the master surface", || MasterSurface::new(&positions, facets))?;
    // The parts of a refresh by themselves.
    let index = timed("index of the facets", || master.at(&positions))?;
    let tree = timed("k-d tree of the nodes", || NearestNodes::new(index.positions().to_vec()))?;
    drop((index, tree));
    let mut interface =
        timed("new interface", || ContactInterface::new(master, slaves, &[], &positions, options))?;
    let report = timed("refresh, first", || interface.refresh_pairing(&positions))?;
    println!("    {} paired, without {:?}, {:?}", report.paired, report.without, report.fallbacks);
    let report = timed("refresh, pairings kept", || interface.refresh_pairing(&positions))?;
    println!("    {} kept", report.kept);
    for (name, mode) in [("values", Mode::Value), ("gradients", Mode::Gradient), ("Hessians", Mode::Hessian)]
    {
        let (mut masters, mut sum) = (0, 0.0);
        timed(&format!("stream {name}"), || {
            interface.for_each(mode, |contact| {
                masters += contact.nodes.len();
                sum += contact.point.gap;
            })
        })?;
        println!("    {:.2} masters a slave, sum of gaps {sum:.6e}", masters as f64 / wanted as f64);
    }
    if wanted <= 100_000 {
        timed("evaluate Hessians", || interface.evaluate(Mode::Hessian).map(|_| ()))?;
        timed("evaluate Hessians again", || interface.evaluate(Mode::Hessian).map(|_| ()))?;
    }
    println!("peak memory {}", peak_memory().unwrap_or_else(|| "unknown".to_owned()));
    Ok(())
}

/// Runs a step and prints how long it took.
fn timed<T>(name: &str, step: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = step();
    println!("{name:28} {:9.3} s", start.elapsed().as_secs_f64());
    result
}

/// As the system counts it; only on Linux.
fn peak_memory() -> Option<String> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: f64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(format!("{:.0} MiB", kibibytes / 1024.0))
}
