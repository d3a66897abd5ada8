//! Time and memory of a large interface: a wavy master surface of quadrilaterals, and as many slave nodes on a grid that
//! is shifted and a little finer, just above and below it.
//!
//! * [`windows`]: the same slaves again, each group with a window of the surface only, compared with the whole to the bit;
//! * [`bits`]: hashes of what slaves have;
//! * [`memory`]: of this process.

mod bits;
mod memory;
mod windows;

use std::fmt;
use std::time::Instant;

use diffuse_contact::assembly::{ContactLaw, CsrPattern, DofMap};
use diffuse_contact::interface::{ContactInterface, InterfaceOptions, NoContact, Outcome};
use diffuse_contact::surface::{Facet, MasterSurface};
use diffuse_contact::{Mode, Point};
use serde::Serialize;

use super::StudyError;
use super::arguments::ThroughputArguments;
use super::patch::Patch;
use crate::error::CliError;
use crate::output;
use crate::progress::logged;
use crate::threads::with_threads;
use crate::words::row;

use windows::Windowed;

/// Height of the waves, in cells.
const AMPLITUDE: f64 = 1.0;
/// Length of the waves, in cells.
const WAVELENGTH: f64 = 16.0;
/// The slaves' grid begins and ends so many cells inside the master's.
const INSET: f64 = 1.3;
/// How far slaves lie off the exact surface at most, in cells.
const DISTANCE: f64 = 0.05;

/// What was found.
#[derive(Debug, Serialize)]
struct Throughput {
    /// Slave nodes, and master nodes.
    nodes: usize,
    threads: usize,
    /// Slaves with a gap.
    contacts: usize,
    /// Mean number of masters of a slave with a gap.
    masters: f64,
    /// Connecting the facets and checking the surface.
    connect_s: f64,
    /// Domains of influence of all master nodes, once for all positions.
    domains_s: f64,
    /// Index, search and pairing of all slaves.
    refresh_s: f64,
    /// Check of all slaves, all lists of nodes kept.
    refresh_kept_s: f64,
    /// Gap, N and M of all slaves, streamed.
    evaluate_s: f64,
    /// The tangent in compressed sparse rows, if that is asked for.
    #[serde(flatten)]
    assembly: Option<Assembly>,
    /// Peak memory of the process, if the system tells.
    peak_memory_mib: Option<f64>,
}

/// The tangent of all slaves in compressed sparse rows. Those below the surface, half of them, carry force.
#[derive(Debug, Serialize)]
struct Assembly {
    /// Pattern of all slaves.
    pattern_s: f64,
    /// Its values, with the memory of which they are the first use.
    fill_s: f64,
    /// The same values again.
    refill_s: f64,
    /// Entries of the matrix for each slave.
    entries: f64,
}

/// Measures and prints.
pub fn run(arguments: &ThroughputArguments) -> Result<(), CliError> {
    let side = (arguments.nodes as f64).sqrt().ceil() as usize;
    match arguments.windows {
        Some(count) => print(arguments, || Windowed::measure(side, count as usize, windows::REACH)),
        None => print(arguments, || measure(side, arguments.assembly)),
    }
}

/// Measures on so many threads and prints.
fn print<T>(
    arguments: &ThroughputArguments,
    measure: impl FnOnce() -> Result<T, StudyError> + Send,
) -> Result<(), CliError>
where
    T: fmt::Display + Serialize + Send,
{
    let found = with_threads(arguments.threads, || Ok(measure()?))?;
    if arguments.json {
        return output::write_json(&found);
    }
    output::write_stdout(|writer| write!(writer, "{found}"))
}

/// The interface of `side`² slaves and `side`² masters.
fn measure(side: usize, with_assembly: bool) -> Result<Throughput, StudyError> {
    let (mut positions, slaves, facets) = scene(side);
    let (master, connect_s) = timed(|| MasterSurface::new(&positions, facets))?;
    let nodes = slaves.len();
    let options = InterfaceOptions::default();
    let (mut interface, domains_s) =
        timed(|| ContactInterface::new(master, slaves, &[], &positions, options))?;
    let (_, refresh_s) = timed(|| interface.refresh_pairing(&positions))?;
    // A small slide, as between two iterations.
    for position in &mut positions[side * side..] {
        position[0] += 1e-3;
    }
    let (_, refresh_kept_s) = timed(|| interface.refresh_pairing(&positions))?;
    let all = positions.len();
    drop(positions);
    let bar = logged("slave nodes", nodes);
    let (mut contacts, mut masters, mut reason) = (0, 0, None::<(usize, NoContact)>);
    let streamed = timed(|| {
        interface.for_each(Mode::Hessian, |contact| {
            match contact.outcome {
                Outcome::Contact { .. } => {
                    contacts += 1;
                    masters += contact.nodes.len();
                }
                Outcome::None(why) => reason = reason.or(Some((contact.slave, why))),
            }
            bar.inc(1);
        })
    });
    bar.finish_and_clear();
    let ((), evaluate_s) = streamed?;
    // Times of slaves without contact would be too good.
    if let Some((slave, reason)) = reason {
        return Err(StudyError::NoContact { case: format!("{nodes} nodes"), slave, reason });
    }
    let assembly = with_assembly.then(|| assemble(&mut interface, all)).transpose()?;
    Ok(Throughput {
        nodes,
        threads: rayon::current_num_threads(),
        contacts,
        masters: masters as f64 / contacts as f64,
        connect_s,
        domains_s,
        refresh_s,
        refresh_kept_s,
        evaluate_s,
        assembly,
        peak_memory_mib: memory::peak_mib(),
    })
}

/// The tangent of an interface among so many nodes.
fn assemble(interface: &mut ContactInterface, nodes: usize) -> Result<Assembly, StudyError> {
    let contacts = interface.evaluate(Mode::Hessian)?;
    let (law, dofs) = (ContactLaw::penalty(1.0), DofMap::standard(nodes));
    let (pattern, pattern_s) = timed(|| CsrPattern::union(contacts, &dofs))?;
    let (mut values, fill_s) = timed(|| {
        let mut values = vec![0.0; pattern.entries()];
        pattern.fill(contacts, &law, &mut values).map(|_| values)
    })?;
    let (_, refill_s) = timed(|| pattern.fill(contacts, &law, &mut values))?;
    Ok(Assembly { pattern_s, fill_s, refill_s, entries: pattern.entries() as f64 / contacts.len() as f64 })
}

/// Positions of masters and, behind them, slaves; indices of the slaves; facets of the master.
fn scene(side: usize) -> (Vec<Point>, Vec<usize>, Vec<Facet>) {
    let wave = std::f64::consts::TAU / WAVELENGTH;
    let height = |x: f64, y: f64| AMPLITUDE * (wave * x).sin() * (wave * y).cos();
    let Patch { mut positions, facets } = Patch::new([side - 1; 2], |x, y| [x, y, height(x, y)]);
    let width = (side - 1) as f64;
    let step = (width - 2.0 * INSET) / width;
    let slaves = (0..side * side).map(|k| {
        let [x, y] = [k % side, k / side].map(|place| INSET + step * place as f64);
        let above = if k % 2 == 0 { DISTANCE } else { -DISTANCE };
        positions.push([x, y, height(x, y) + above]);
        positions.len() - 1
    });
    let slaves = slaves.collect();
    (positions, slaves, facets)
}

/// What a step returns, and how long it took in seconds.
fn timed<T, E>(step: impl FnOnce() -> Result<T, E>) -> Result<(T, f64), E> {
    let start = Instant::now();
    let result = step()?;
    Ok((result, start.elapsed().as_secs_f64()))
}

/// A time, and that of one of so many slaves.
fn each(seconds: f64, slaves: usize) -> String {
    let micro = 1e6 * seconds / slaves as f64;
    format!("{seconds:.3} s, {micro:.2} µs for each slave")
}

impl fmt::Display for Throughput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let each = |seconds: f64| each(seconds, self.nodes);
        row(f, "slave, master nodes", &format!("{0}, {0}", self.nodes))?;
        row(f, "threads", &self.threads.to_string())?;
        row(f, "contacts", &format!("{}, {:.1} master nodes each", self.contacts, self.masters))?;
        row(f, "connect the surface", &each(self.connect_s))?;
        row(f, "domains of influence", &each(self.domains_s))?;
        row(f, "refresh, all paired", &each(self.refresh_s))?;
        row(f, "refresh, all lists kept", &each(self.refresh_kept_s))?;
        row(f, "gap, N and M", &each(self.evaluate_s))?;
        if let Some(Assembly { pattern_s, fill_s, refill_s, entries }) = &self.assembly {
            row(f, "pattern of the tangent", &format!("{}, {entries:.0} entries", each(*pattern_s)))?;
            row(f, "fill, into new memory", &each(*fill_s))?;
            row(f, "fill again", &each(*refill_s))?;
        }
        row(f, "peak memory", &memory::in_words(self.peak_memory_mib))
    }
}
