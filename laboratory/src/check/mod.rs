//! The `check` job: every kernel, of the held and of the co-moving frame, against automatic differentiation and
//! against the interpreter of its graph.
//!
//! [`elements`] makes the random elements, [`blocks`] says which numbers of a result belong together and how their
//! differences are measured, [`balance`] adds N and its moments up, [`compare()`] runs the backends, [`facets`] does the same for the kernels of contact on facets,
//! [`report`] prints what was found.
//!
//! ```
//! use diffuse_contact_laboratory::check::{Plan, compare};
//! use diffuse_contact_codegen::Basis;
//!
//! let plan = Plan::default().nodes(Basis::Linear, 4..=4).nodes(Basis::Quadratic, 7..=7);
//! let report = compare(&plan, || {})?;
//! assert!(report.passes());
//! # Ok::<(), diffuse_contact_laboratory::check::CompareError>(())
//! ```

mod arguments;
pub mod balance;
pub mod blocks;
mod compare;
pub mod elements;
pub mod facets;
mod nodes;
mod plan;
pub mod report;

use std::process::ExitCode;

use diffuse_contact_codegen::Basis;

use crate::emit::EmitError;
use crate::error::CliError;
use crate::output;
use crate::progress::progress;
use crate::weight::{Weight, WeightArgument};

pub use arguments::CheckArguments;
pub use compare::{CompareError, compare};
pub use elements::NoElement;
pub use nodes::NodeCounts;
pub use plan::{Against, ELEMENTS, Plan, TOLERANCE};
pub use report::Report;

/// Exit code if a kernel does not pass.
const FAILED: u8 = 1;

/// Compares what the arguments ask for and prints the report.
pub(crate) fn run(arguments: &CheckArguments) -> Result<ExitCode, CliError> {
    let plans = plans(arguments)?;
    let bar = progress("elements", plans.iter().map(Plan::elements).sum());
    let reports: Result<Vec<Report>, CompareError> =
        plans.iter().map(|plan| compare(plan, || bar.inc(1))).collect();
    bar.finish_and_clear();
    let reports = reports.map_err(|error| match error {
        formula @ CompareError::Ad { .. } => CliError::job(WeightArgument(formula)),
        CompareError::NoElement(reason) => CliError::job(reason),
    })?;
    let passes = reports.iter().all(Report::passes);
    let written = output::write_stdout(|writer| {
        if arguments.json {
            let document = serde_json::json!({ "passes": passes, "reports": reports });
            serde_json::to_writer_pretty(&mut *writer, &document)?;
            return writeln!(writer);
        }
        for (k, report) in reports.iter().enumerate() {
            let separator = if k > 0 { "\n\n" } else { "" };
            write!(writer, "{separator}{report}")?;
        }
        Ok(())
    });
    match written {
        // The verdict stands, whether somebody reads it or not.
        Err(error) if !error.is_closed_pipe() => return Err(error),
        _ => {}
    }
    Ok(if passes { ExitCode::SUCCESS } else { ExitCode::from(FAILED) })
}

/// One plan for each weight: the one asked for, or all that kernels are compiled for.
fn plans(arguments: &CheckArguments) -> Result<Vec<Plan>, CliError> {
    let plan = plan(arguments)?;
    let weights = match arguments.fit.weight()? {
        Some(weight) => vec![weight],
        None => diffuse_contact::Weight::ALL.map(Weight::BuiltIn).to_vec(),
    };
    Ok(weights.into_iter().map(|weight| Plan { weight, ..plan.clone() }).collect())
}

/// A range given without a basis is for both, as far as they can use it.
fn plan(arguments: &CheckArguments) -> Result<Plan, CliError> {
    let mut plan = Plan { ranges: Vec::new(), seed: arguments.seed, ..Plan::default() };
    let bases = arguments.fit.basis.map_or(Basis::ALL.to_vec(), |basis| vec![basis]);
    for &basis in &bases {
        let Some(counts) = &arguments.nodes else {
            plan = plan.nodes(basis, Plan::default_nodes(basis));
            continue;
        };
        let smallest = bases.iter().map(|basis| basis.size()).min().unwrap_or_default();
        let (first, last) = (*counts.range().start(), *counts.range().end());
        if first < smallest {
            let basis = if bases.len() == 1 { basis } else { Basis::Linear };
            return Err(EmitError::TooFewNodes { nodes: counts.to_string(), basis }.into());
        }
        if last >= basis.size() {
            plan = plan.nodes(basis, first.max(basis.size())..=last);
        }
    }
    Ok(plan)
}
