//! The solver's program: decks to results, results to a page.
#![forbid(unsafe_code)]

mod solve;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use diffuse_contact_program::{error, input, output, threads, words};

use solve::{ReportArguments, SolveArguments};

/// Finite-strain statics with smooth contact.
#[derive(Debug, Parser)]
#[command(name = "diffuse-contact-solve", version, propagate_version = true)]
struct Arguments {
    /// The job.
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Solve a deck: finite-strain statics with contact, from a TOML file to results and a report.
    Solve(SolveArguments),
    /// Write one page for the results of several runs.
    Report(ReportArguments),
}

fn main() -> ExitCode {
    diffuse_contact_program::main(|arguments: Arguments| match &arguments.command {
        Command::Solve(arguments) => {
            if arguments.threads.is_none() {
                threads::start();
            }
            solve::run(arguments)
        }
        Command::Report(arguments) => solve::report(arguments).map(|()| ExitCode::SUCCESS),
    })
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
