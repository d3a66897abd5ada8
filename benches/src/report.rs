//! What was found, as JSON and as a table.

use std::fmt;

use serde::Serialize;

use crate::contender::Output;
use crate::measure::Plan;

/// Figures of one run.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The processor, if the system tells.
    pub machine: Option<String>,
    /// Vector instructions of the generated kernels, and of the loop that measures the peak.
    pub isa: &'static str,
    /// Instruction set the program is compiled for, which all others use, and the kernel of the surface.
    pub compiled_for: &'static str,
    /// Fused multiply-adds a nanosecond in one thread, measured in the same run.
    pub peak_fma_per_ns: f64,
    /// Rounds of which times are medians.
    pub rounds: usize,
    /// Different elements for each number of nodes.
    pub elements: usize,
    /// The figures.
    pub rows: Vec<Row>,
    /// Contenders that are not compiled for a number of nodes.
    pub absent: Vec<Absent>,
}

/// Figures of one contender for one number of nodes.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Master nodes.
    pub nodes: usize,
    /// The contender.
    pub kernel: &'static str,
    /// What it computes.
    pub output: Output,
    /// Time, median over the rounds.
    pub ns_per_element: f64,
    /// Operations, a fused multiply-add counting one; none for a contender whose operations nobody counts.
    pub fma_per_element: Option<f64>,
    /// Operations a second over those of the loop that does nothing but fused multiply-adds.
    pub fraction_of_peak: Option<f64>,
}

/// A contender that is not compiled for a number of nodes.
#[derive(Clone, Debug, Serialize)]
pub struct Absent {
    /// Master nodes.
    pub nodes: usize,
    /// The contender.
    pub kernel: &'static str,
    /// What it would compute.
    pub output: Output,
}

impl Report {
    pub(crate) fn new(compiled_for: &'static str, plan: &Plan) -> Self {
        Self {
            machine: machine(),
            isa: plan.isa.name(),
            compiled_for,
            peak_fma_per_ns: f64::NAN,
            rounds: plan.rounds,
            elements: plan.elements,
            rows: Vec::new(),
            absent: Vec::new(),
        }
    }

    pub(crate) fn set_peak(&mut self, fma_per_ns: f64) {
        self.peak_fma_per_ns = fma_per_ns;
        for row in &mut self.rows {
            row.fraction_of_peak = row.fma_per_element.map(|fma| fma / row.ns_per_element / fma_per_ns);
        }
    }
}

/// The processor as Linux names it.
fn machine() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "machine    {}", self.machine.as_deref().unwrap_or("unknown"))?;
        writeln!(f, "kernels    {}, {:.2} fused multiply-adds/ns at most", self.isa, self.peak_fma_per_ns)?;
        writeln!(f, "the others {}", self.compiled_for)?;
        writeln!(f, "times      one thread, median of {} rounds, {} elements\n", self.rounds, self.elements)?;
        writeln!(
            f,
            "{:>5}  {:<20} {:<22} {:>14} {:>10} {:>8}",
            "nodes", "kernel", "output", "ns per element", "operations", "of peak"
        )?;
        for row in &self.rows {
            let operations = row.fma_per_element.map_or("-".into(), |fma| format!("{fma:.0}"));
            let fraction = row.fraction_of_peak.map_or("-".into(), |x| format!("{:.1} %", 100.0 * x));
            let digits = usize::from(row.ns_per_element < 1000.0);
            writeln!(
                f,
                "{:>5}  {:<20} {:<22} {:>14.digits$} {operations:>10} {fraction:>8}",
                row.nodes,
                row.kernel,
                row.output.name(),
                row.ns_per_element,
            )?;
        }
        for Absent { nodes, kernel, .. } in &self.absent {
            writeln!(f, "{nodes:>5}  {kernel:<20} not compiled for this number of nodes")?;
        }
        Ok(())
    }
}
