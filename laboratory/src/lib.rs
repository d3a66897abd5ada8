//! The laboratory: what the element and its surfaces are examined with. None of it is needed to use them.
//!
//! * [`check`]: every kernel against the other two witnesses, automatic differentiation and the interpreter of its graph;
//! * `study`: accuracy, smoothness and speed of contact surfaces, and the solver on problems with known answers;
//! * `bench`: the kernels against their rivals;
//! * `emit`: the source of a kernel and its operation counts;
//! * `evaluate`: as in the program `diffuse-contact`, and by automatic differentiation, too.
//!
//! Two parts are of use to other programs: [`interpreted`], the third backend of the element, which evaluates the
//! formulas' expression graph as it stands (for facets: [`interpreted_facets`]), and [`check`], which compares the
//! backends with each other. Exit codes are those of `diffuse_contact_program`; 1 is left to `check`, when the kernels do not pass.
//!
//! ```
//! use diffuse_contact::{Backend, Basis, Element, Frame, Mode};
//! use diffuse_contact_laboratory::interpreted::Interpreted;
//!
//! let masters = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
//! let frame = Frame::average_plane(&masters, [0.0, 0.0, 1.0])?;
//! let element = Element::new([0.4, 0.6, 0.25], &masters, frame, 2.0).with_basis(Basis::Linear);
//! let contact = Interpreted::default().gap(&element, Mode::Hessian)?;
//! assert!((contact.gap - 0.25).abs() < 1e-14);
//! # Ok::<(), diffuse_contact::ElementError>(())
//! ```
#![forbid(unsafe_code)]

mod bench;
pub mod check;
mod emit;
pub mod interpreted;
pub mod interpreted_facets;
mod study;
pub mod weight;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use diffuse_contact::Generated;
use diffuse_contact::ad::Ad;
use diffuse_contact_cli::evaluate::{self, BackendKind, EvaluateArguments};
use diffuse_contact_program::{error, output, progress, threads, words};

use error::CliError;

/// Witnesses, studies and rivals of the diffuse contact element.
#[derive(Debug, Parser)]
#[command(name = "diffuse-contact-laboratory", version, propagate_version = true)]
struct Arguments {
    /// The job.
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Print a kernel's source and its operation counts.
    Emit(emit::EmitArguments),
    /// Compare the generated kernels with automatic differentiation and with the interpreter of their graph.
    Check(check::CheckArguments),
    /// Measure accuracy, smoothness and speed of contact surfaces on meshes of known shape.
    Study(study::StudyArguments),
    /// Measure the generated kernels against the element written by hand and over dual numbers.
    Bench(bench::BenchArguments),
    /// Evaluate the elements of a JSON file, also by automatic differentiation.
    Evaluate(EvaluateArguments),
}

/// Does what the command line says.
#[must_use]
pub fn main() -> ExitCode {
    diffuse_contact_program::main(|arguments: Arguments| run(&arguments.command))
}

fn run(command: &Command) -> Result<ExitCode, CliError> {
    let done = |()| ExitCode::SUCCESS;
    match command {
        Command::Emit(arguments) => emit::run(arguments).map(done),
        Command::Check(arguments) => {
            threads::start();
            check::run(arguments)
        }
        Command::Study(arguments) => {
            threads::start();
            study::run(arguments).map(done)
        }
        Command::Bench(arguments) => bench::run(arguments).map(done),
        Command::Evaluate(arguments) => match arguments.backend {
            BackendKind::Generated => evaluate::run_with(arguments, &Generated),
            BackendKind::Ad => evaluate::run_with(arguments, &Ad),
        },
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_arguments_are_consistent() {
        Arguments::command().debug_assert();
    }
}
