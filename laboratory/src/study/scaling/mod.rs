//! What each rank holds and sends with windows of a surface, past the machines at hand: counted for a regular surface, rank by rank, by
//! the rules of the library and of the host in `hosts/dolfinx`; no facet is looked at. A stated cost model makes times of the counts.
//!
//! * [`stencil`]: what a facet needs around it, asked of the library;
//! * [`partition`]: which rank owns what;
//! * [`count`]: facets, nodes, bytes and messages of each rank, compared with the library's windows in its tests;
//! * [`rects`]: sets of cells.

mod count;
mod partition;
mod rects;
mod stencil;

use std::fmt;

use serde::Serialize;

use super::StudyError;
use super::arguments::{Costs, ScalingArguments};
use super::markdown::{Table, cells};
use crate::error::CliError;
use crate::output;

use count::{BOXES, Rank, Scene};
use partition::{Kind, Partition};
use rects::Rect;
use stencil::Stencil;

/// Least facets of a rank.
const LEAST: u64 = 64;

/// Of all ranks.
#[derive(Clone, Copy, Debug, Serialize)]
struct Spread {
    mean: f64,
    max: f64,
}

impl Spread {
    fn of(ranks: &[Rank], what: impl Fn(&Rank) -> u64) -> Self {
        let sum: u64 = ranks.iter().map(&what).sum();
        let max = ranks.iter().map(&what).max().unwrap_or(0);
        Self { mean: sum as f64 / ranks.len() as f64, max: max as f64 }
    }

    /// 1 where all have the same.
    fn balance(self) -> f64 {
        self.max / self.mean
    }
}

/// What was counted for so many ranks.
#[derive(Debug, Serialize)]
struct Case {
    partition: Kind,
    /// Whether slaves are dealt out evenly, instead of staying where they are owned.
    dealt: bool,
    ranks: usize,
    facets: Spread,
    /// Facets known in the first phase.
    part_facets: Spread,
    slaves: Spread,
    /// Facets of a window.
    window_facets: Spread,
    window_nodes: Spread,
    /// Bytes of surface.
    bytes: Spread,
    /// The largest over the bytes of one rank, divided by the number of ranks.
    bytes_over_share: f64,
    /// Ranks that something comes from in an iteration.
    neighbours: Spread,
    /// Bytes of an iteration, without the tangent and with the rows of others.
    iteration_bytes: [Spread; 2],
    /// Bytes of windows made anew, …
    window_bytes: Spread,
    /// … and of the boxes that each gathers of all for that.
    box_bytes: u64,
    /// Seconds of an iteration, without the tangent and with the rows of others.
    iteration_s: [f64; 2],
    renewal_s: f64,
    efficiency: [f64; 2],
}

/// Everything that is printed.
#[derive(Debug, Serialize)]
struct Scaling {
    facets: u64,
    slaves: u64,
    /// Nodes listed at a facet, and those that carry the fit of a slave.
    listed: u64,
    masters: u64,
    /// Bytes of surface on one rank.
    whole_bytes: f64,
    limit: f64,
    skin: f64,
    every: u32,
    costs: Costs,
    cases: Vec<Case>,
}

/// Counts and prints.
pub fn run(arguments: &ScalingArguments) -> Result<(), CliError> {
    if let Some(path) = &arguments.output {
        output::check_target(path)?;
    }
    let found = Scaling::new(arguments)?;
    if arguments.json {
        return output::write_json(&found);
    }
    let Some(path) = &arguments.output else {
        return output::write_stdout(|writer| write!(writer, "{found}"));
    };
    let document = format!(
        "# Scaling\n\n\
         Written by `cargo lab study scaling -o docs/results/scaling.md`; do not edit.\n\n\
         {}\n## Simulated\n\n{found}\n{}",
        include_str!("measured.txt"),
        include_str!("model.txt"),
    );
    output::write_file(path, |writer| writer.write_all(document.as_bytes()))
}

impl Scaling {
    fn new(arguments: &ScalingArguments) -> Result<Self, StudyError> {
        let side = (arguments.facets as f64).sqrt().ceil() as i64;
        let facets = Rect::square(side).count();
        if let Some(&ranks) = arguments.ranks.iter().find(|ranks| u64::from(**ranks) * LEAST > facets) {
            return Err(StudyError::TooManyRanks { ranks, facets, least: LEAST });
        }
        let width = (arguments.contact * side as f64).round() as i64;
        let from = (side - width) / 2;
        let contact = Rect([[from, from + width]; 2]);
        let stencil = Stencil::new()?;
        let scene = Scene { side, contact, limit: arguments.limit, skin: arguments.skin, stencil };
        let whole = Partition::new(Kind::Strips, side, 1).map_or(0.0, |whole| {
            Spread::of(&scene.count(&whole, &scene.slaves_owned(&whole)), |rank| rank.bytes).max
        });
        let mut found = Self {
            facets,
            slaves: contact.count(),
            listed: scene.stencil.listed,
            masters: scene.stencil.carried,
            whole_bytes: whole,
            limit: arguments.limit,
            skin: arguments.skin,
            every: arguments.every,
            costs: arguments.costs,
            cases: Vec::new(),
        };
        for kind in Kind::ALL {
            for dealt in [false, true] {
                for &ranks in &arguments.ranks {
                    let Some(partition) = Partition::new(kind, side, ranks as usize) else { continue };
                    let slaves =
                        if dealt { scene.slaves_dealt(&partition) } else { scene.slaves_owned(&partition) };
                    let counted = scene.count(&partition, &slaves);
                    let case = found.case(kind, dealt, &counted);
                    found.cases.push(case);
                }
            }
        }
        Ok(found)
    }

    fn case(&self, partition: Kind, dealt: bool, ranks: &[Rank]) -> Case {
        let of = |what: &dyn Fn(&Rank) -> u64| Spread::of(ranks, what);
        let (count, slaves, bytes) = (ranks.len() as f64, of(&|rank| rank.slaves), of(&|rank| rank.bytes));
        let iteration_s = [0, 1].map(|with| self.iteration_s(ranks, with));
        let box_bytes = 48 * (BOXES * (ranks.len() - 1)) as u64;
        let renewal_s = self.renewal_s(ranks, box_bytes);
        let Costs { evaluation, search, .. } = self.costs;
        let every = f64::from(self.every);
        // As the times are summed up: one rank has 1, to the last digit.
        let [evaluation, search] = [evaluation, search].map(|work| 1e-6 * (work * slaves.mean));
        let ideal = evaluation + search / every;
        Case {
            partition,
            dealt,
            ranks: ranks.len(),
            facets: of(&|rank| rank.own),
            part_facets: of(&|rank| rank.part),
            slaves,
            window_facets: of(&|rank| rank.window.facets),
            window_nodes: of(&|rank| rank.window.nodes),
            bytes,
            bytes_over_share: bytes.max * count / self.whole_bytes,
            neighbours: of(&|rank| rank.neighbours),
            iteration_bytes: [0, 1].map(|with| of(&|rank| rank.iteration_bytes()[with])),
            window_bytes: of(&Rank::window_bytes),
            box_bytes,
            iteration_s,
            renewal_s,
            efficiency: iteration_s.map(|iteration| ideal / (iteration + renewal_s / every)),
        }
    }

    /// Seconds of the slowest rank, each with so much work for a slave, so many messages and bytes.
    fn slowest(&self, ranks: &[Rank], work: f64, of: impl Fn(&Rank) -> [u64; 2]) -> f64 {
        let Costs { latency, bandwidth, .. } = self.costs;
        let seconds = |rank: &Rank| {
            let [messages, bytes] = of(rank).map(|count| count as f64);
            1e-6 * (work * rank.slaves as f64 + latency * messages) + 1e-9 * bytes / bandwidth
        };
        ranks.iter().map(seconds).fold(0.0, f64::max)
    }

    /// Seconds of a reduction or gather over all ranks, bytes apart.
    fn collective_s(&self, ranks: usize) -> f64 {
        1e-6 * self.costs.latency * (ranks as f64).log2().ceil()
    }

    fn iteration_s(&self, ranks: &[Rank], with: usize) -> f64 {
        let of = |rank: &Rank| [rank.iteration_messages()[with], rank.iteration_bytes()[with]];
        // The largest movement, and whether a slave is beyond its window.
        2.0 * self.collective_s(ranks.len()) + self.slowest(ranks, self.costs.evaluation, of)
    }

    fn renewal_s(&self, ranks: &[Rank], box_bytes: u64) -> f64 {
        let of = |rank: &Rank| [rank.window_messages(), rank.window_bytes() + box_bytes];
        // Boxes, and the barrier that tells when all messages have come.
        2.0 * self.collective_s(ranks.len()) + self.slowest(ranks, self.costs.search, of)
    }
}

impl Case {
    fn row(&self, numbers: impl IntoIterator<Item = String>) -> String {
        let slaves = if self.dealt { "dealt out" } else { "kept" };
        let (partition, ranks) = (self.partition.name(), grouped(self.ranks as u64));
        format!("{partition}, {slaves} | {ranks} | {}", cells(numbers))
    }
}

/// With a comma after each three digits.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Three digits, or a whole number.
fn number(x: f64) -> String {
    match x {
        x if x >= 100.0 => grouped(x.round() as u64),
        x if x >= 10.0 => format!("{x:.1}"),
        x if x >= 0.1 => format!("{x:.2}"),
        x => format!("{x:.4}"),
    }
}

impl Scaling {
    fn surface(&self) -> Table {
        let columns = "partition, slaves | ranks | own facets, mean | part, largest | slaves, mean | \
                       largest over mean | window's facets, largest | its nodes | MB, mean | largest | \
                       over 1/P of the whole";
        let mut table = Table::new("Surface that a rank holds:", columns);
        for case in &self.cases {
            table.row(case.row([
                number(case.facets.mean),
                number(case.part_facets.max),
                number(case.slaves.mean),
                format!("{:.2}", case.slaves.balance()),
                number(case.window_facets.max),
                number(case.window_nodes.max),
                number(1e-6 * case.bytes.mean),
                number(1e-6 * case.bytes.max),
                format!("{:.2}", case.bytes_over_share),
            ]));
        }
        table
    }

    fn messages(&self) -> Table {
        let columns = "partition, slaves | ranks | neighbours, mean | largest | an iteration, kB, mean | \
                       largest | with rows of the tangent, kB, mean | largest | windows, kB, mean | \
                       largest | boxes, kB";
        let heading = "Bytes of a rank, the larger of what comes and what goes; boxes come from all ranks:";
        let mut table = Table::new(heading, columns);
        for case in &self.cases {
            let [vectors, rows] = case.iteration_bytes;
            let bytes = [vectors, rows, case.window_bytes].into_iter().flat_map(|own| [own.mean, own.max]);
            let bytes = bytes.chain([case.box_bytes as f64]).map(|bytes| number(1e-3 * bytes));
            let neighbours = [format!("{:.1}", case.neighbours.mean), format!("{:.0}", case.neighbours.max)];
            table.row(case.row(neighbours.into_iter().chain(bytes)));
        }
        table
    }

    fn times(&self) -> Table {
        let Costs { evaluation, search, latency, bandwidth } = self.costs;
        let heading = format!(
            "Time of the slowest rank by the model. A slave takes {evaluation} µs for g, N and M, and {search} µs for its search in a \
             new window every {} iterations. A message takes {latency} µs, and {bandwidth} GB/s come to a rank and go from it.",
            self.every
        );
        let columns = "partition, slaves | ranks | iteration, ms | with rows of the tangent, ms | \
                       windows anew, ms | efficiency, % | with rows, %";
        let mut table = Table::new(heading, columns);
        for case in &self.cases {
            let [vectors, rows] = case.iteration_s;
            let times = [vectors, rows, case.renewal_s].map(|seconds| number(1e3 * seconds));
            let shares = case.efficiency.map(|share| format!("{:.1}", 100.0 * share));
            table.row(case.row(times.into_iter().chain(shares)));
        }
        table
    }
}

impl fmt::Display for Scaling {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} master facets, {} slaves. The limit of the distance is {} of a facet's side, the skin {}. A facet has \
             {} listed nodes, and {} masters carry the fit of a slave. One rank holds {:.2} GB.\n",
            grouped(self.facets),
            grouped(self.slaves),
            self.limit,
            self.skin,
            self.listed,
            self.masters,
            1e-9 * self.whole_bytes
        )?;
        write!(f, "{}\n{}\n{}", self.surface(), self.messages(), self.times())
    }
}
