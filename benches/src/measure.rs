//! Rounds and medians.

use std::time::Instant;

use diffuse_contact_kernels::support::Isa;

use crate::contender::{Contender, Evaluation, NoResult, Run};
use crate::contenders::CONTENDERS;
use crate::generated::{compiled_for, operations, reference};
use crate::report::{Absent, Report, Row};
use crate::{Elements, ElementsError, peak};

/// Largest difference from the generated kernels with which a contender takes part, relative to the largest entry of
/// the block, or to the support radius for lengths.
pub const TOLERANCE: f64 = 1e-10;
/// A contender runs at least so long in each round, unless one element takes longer.
const SHORTEST_ROUND: f64 = 3e-3;
/// Dual numbers of second order with 75 variables are large, and live on the stack.
const STACK: usize = 256 << 20;

/// What is measured.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Numbers of master nodes.
    pub nodes: Vec<usize>,
    /// Rounds of which the median is taken.
    pub rounds: usize,
    /// Different elements for each number of nodes.
    pub elements: usize,
    /// The contenders whose names contain one of these texts; all if there are none.
    pub kernels: Vec<String>,
    /// The vector instructions that the generated kernels are run with.
    pub isa: Isa,
}

impl Default for Plan {
    fn default() -> Self {
        let nodes = vec![8, 12, 16, 20];
        Self { nodes, rounds: 7, elements: 256, kernels: Vec::new(), isa: Isa::best() }
    }
}

/// Why nothing was measured.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum MeasureError {
    #[error("a median takes at least one round")]
    NoRounds,
    #[error("no kernel has a name with {}; there are {}", .asked.join(" or "), .known.join(", "))]
    NoContender { asked: Vec<String>, known: Vec<&'static str> },
    #[error(transparent)]
    Elements(#[from] ElementsError),
    #[error("{kernel}, {nodes} nodes: {reason}")]
    NoResult { kernel: &'static str, nodes: usize, reason: NoResult },
    /// A contender computes something else. `difference` is relative to the generated kernel.
    #[error(
        "{kernel}, {nodes} nodes, element {element}: {what} differs by {difference:e}, bound {TOLERANCE:e}"
    )]
    Disagreement { kernel: &'static str, nodes: usize, element: usize, what: &'static str, difference: f64 },
    #[error("no thread to measure in: {0}")]
    Thread(std::io::Error),
}

/// Compares all contenders, then runs them in turn and takes medians. `progress` hears of every number of nodes.
pub fn measure(plan: &Plan, progress: impl Fn(&str) + Sync) -> Result<Report, MeasureError> {
    if plan.rounds == 0 {
        return Err(MeasureError::NoRounds);
    }
    let chosen: Vec<Contender> = CONTENDERS.into_iter().filter(|x| plan.takes(x.kernel)).collect();
    if chosen.is_empty() {
        let mut known: Vec<_> = CONTENDERS.iter().map(|x| x.kernel).collect();
        known.dedup();
        return Err(MeasureError::NoContender { asked: plan.kernels.clone(), known });
    }
    let mut report = Report::new(compiled_for(), plan);
    let mut peaks = Vec::new();
    std::thread::scope(|scope| {
        let work = || -> Result<(), MeasureError> {
            for &nodes in &plan.nodes {
                measure_nodes(plan, &chosen, nodes, &mut report, &mut peaks, &progress)?;
            }
            Ok(())
        };
        let builder = std::thread::Builder::new().stack_size(STACK);
        let thread = builder.spawn_scoped(scope, work).map_err(MeasureError::Thread)?;
        thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })?;
    report.set_peak(median(&mut peaks));
    Ok(report)
}

impl Plan {
    fn takes(&self, kernel: &str) -> bool {
        self.kernels.is_empty() || self.kernels.iter().any(|text| kernel.contains(text.as_str()))
    }
}

/// A contender in the ring.
struct Entrant<'a> {
    contender: Contender,
    run: Box<dyn Run + 'a>,
    /// Elements in a round.
    count: usize,
    /// Nanoseconds an element, one for each round.
    times: Vec<f64>,
}

fn measure_nodes(
    plan: &Plan,
    chosen: &[Contender],
    nodes: usize,
    report: &mut Report,
    peaks: &mut Vec<f64>,
    progress: &(impl Fn(&str) + Sync),
) -> Result<(), MeasureError> {
    let elements = Elements::new(nodes, plan.elements)?;
    let mut entrants = Vec::new();
    for &contender in chosen {
        let Some(mut run) = (contender.prepare)(&elements, contender.output, plan.isa) else {
            report.absent.push(Absent { nodes, kernel: contender.kernel, output: contender.output });
            continue;
        };
        progress(&format!("{nodes} nodes: comparing {contender:?}"));
        compare(&contender, run.as_mut(), &elements)?;
        let failed = |reason| MeasureError::NoResult { kernel: contender.kernel, nodes, reason };
        let count = calibrate(run.as_mut()).map_err(failed)?;
        entrants.push(Entrant { contender, run, count, times: Vec::with_capacity(plan.rounds) });
    }
    for round in 0..plan.rounds {
        progress(&format!("{nodes} nodes: round {} of {}", round + 1, plan.rounds));
        peaks.push(peak::fma_per_ns(plan.isa));
        // Nobody is always the one after the heaviest.
        let shift = round % entrants.len().max(1);
        entrants.rotate_left(shift);
        for entrant in &mut entrants {
            let kernel = entrant.contender.kernel;
            let seconds = time(entrant.run.as_mut(), entrant.count)
                .map_err(|reason| MeasureError::NoResult { kernel, nodes, reason })?;
            entrant.times.push(1e9 * seconds / entrant.count as f64);
        }
        entrants.rotate_right(shift);
    }
    for Entrant { contender, mut times, .. } in entrants {
        report.rows.push(Row {
            nodes,
            kernel: contender.kernel,
            output: contender.output,
            ns_per_element: median(&mut times),
            fma_per_element: contender.counted.then(|| operations(contender.output, &elements)),
            fraction_of_peak: None,
        });
    }
    Ok(())
}

/// Holds a contender against the generated kernels. The slow ones see fewer elements.
fn compare(contender: &Contender, run: &mut dyn Run, elements: &Elements) -> Result<(), MeasureError> {
    let &Contender { kernel, output, .. } = contender;
    let nodes = elements.nodes();
    let no_result = |reason| MeasureError::NoResult { kernel, nodes, reason };
    let start = Instant::now();
    for element in 0..elements.len() {
        let found = run.evaluation(element).map_err(no_result)?;
        let expected = reference(elements, output, element).map_err(no_result)?;
        for (what, difference) in differences(&found, &expected, elements.held(element).support_radius) {
            if !(difference <= TOLERANCE) {
                return Err(MeasureError::Disagreement { kernel, nodes, element, what, difference });
            }
        }
        if element >= 8 && start.elapsed().as_secs_f64() > 0.5 {
            break;
        }
    }
    Ok(())
}

/// Differences of value, gradient and Hessian, relative to the support radius or the largest entry.
fn differences(found: &Evaluation, expected: &Evaluation, radius: f64) -> [(&'static str, f64); 3] {
    let relative = |found: &[f64], expected: &[f64]| {
        if found.len() != expected.len() {
            return f64::INFINITY;
        }
        // A NaN comes through.
        let larger = |x: f64, y: f64| if y <= x || x.is_nan() { x } else { y };
        let size = expected.iter().map(|x| x.abs()).fold(f64::MIN_POSITIVE, f64::max);
        found.iter().zip(expected).map(|(x, y)| (x - y).abs() / size).fold(0.0, larger)
    };
    [
        ("value", (found.value - expected.value).abs() / radius),
        ("gradient", relative(&found.gradient, &expected.gradient)),
        ("Hessian", relative(&found.hessian, &expected.hessian)),
    ]
}

/// How many elements fill a round.
fn calibrate(run: &mut dyn Run) -> Result<usize, NoResult> {
    let mut count = 1;
    loop {
        let seconds = time(run, count)?;
        if seconds >= SHORTEST_ROUND {
            return Ok(count);
        }
        count = if seconds * 10.0 > SHORTEST_ROUND {
            (count as f64 * SHORTEST_ROUND / seconds).ceil() as usize + 1
        } else {
            8 * count
        };
    }
}

fn time(run: &mut dyn Run, count: usize) -> Result<f64, NoResult> {
    let start = Instant::now();
    run.run(count)?;
    Ok(start.elapsed().as_secs_f64())
}

/// The middle one, or the mean of the two in the middle; NaN of nothing.
fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let half = values.len() / 2;
    match values.len() {
        0 => f64::NAN,
        length if length % 2 == 1 => values[half],
        _ => 0.5 * (values[half - 1] + values[half]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&mut [4.0, 1.0, 2.0, 3.0]), 2.5);
    }

    #[test]
    fn all_contenders_agree() {
        for nodes in [6, 9] {
            let elements = Elements::new(nodes, 4).unwrap();
            for contender in CONTENDERS {
                let mut run = (contender.prepare)(&elements, contender.output, Isa::best())
                    .expect("compiled for 6 and 9 nodes");
                compare(&contender, run.as_mut(), &elements).unwrap();
                run.run(6).unwrap();
            }
        }
    }

    /// More elements than a batch has, and not a multiple.
    #[test]
    fn the_generated_kernels_agree_with_any_instructions() {
        let elements = Elements::new(8, 21).unwrap();
        for isa in Isa::available() {
            for contender in CONTENDERS.into_iter().filter(|x| x.kernel.starts_with("generated")) {
                let mut run =
                    (contender.prepare)(&elements, contender.output, isa).expect("for any number of nodes");
                compare(&contender, run.as_mut(), &elements).unwrap();
                run.run(50).unwrap();
            }
        }
    }

    #[test]
    fn a_wrong_result_does_not_take_part() {
        let expected = Evaluation { value: 1.0, gradient: vec![1.0, 2.0], hessian: vec![4.0] };
        let wrong = |found: &Evaluation| {
            differences(found, &expected, 2.0).into_iter().any(|(_, difference)| !(difference <= TOLERANCE))
        };
        assert!(!wrong(&expected));
        assert!(wrong(&Evaluation { value: 1.0 + 1e-9, ..expected.clone() }));
        assert!(wrong(&Evaluation { gradient: vec![1.0, f64::NAN], ..expected.clone() }));
        assert!(wrong(&Evaluation { gradient: vec![f64::NAN, 2.0], ..expected.clone() }));
        assert!(wrong(&Evaluation { hessian: vec![], ..expected.clone() }));
        assert!(wrong(&Evaluation { hessian: vec![4.0 + 1e-8], ..expected.clone() }));
    }

    #[test]
    fn what_cannot_be_measured_is_said() {
        let plan = Plan { nodes: vec![6], rounds: 0, ..Plan::default() };
        assert!(matches!(measure(&plan, |_| {}), Err(MeasureError::NoRounds)));
        let plan = Plan { kernels: vec!["no such".into()], ..Plan::default() };
        assert!(matches!(measure(&plan, |_| {}), Err(MeasureError::NoContender { .. })));
        let plan = Plan { nodes: vec![5], ..Plan::default() };
        assert!(matches!(measure(&plan, |_| {}), Err(MeasureError::Elements(_))));
    }
}
