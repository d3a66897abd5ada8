//! `diffuse-contact`: the command-line program of the diffuse contact element.
//!
//! Without a subcommand it runs the demonstration on the shipped mesh. Bad input ends the program with exit code 2
//! and one sentence on standard error that names the place; results go to standard output or to a file that
//! appears only when it is complete.
#![forbid(unsafe_code)]

mod args;
mod backend;
mod demo;
mod error;
mod evaluate;
mod output;

use std::process::ExitCode;

use clap::Parser;

use args::{Arguments, Command, DemoArguments};
use error::CliError;

/// Exit code for input the program cannot use, the same as for arguments it does not know.
const BAD_INPUT: u8 = 2;

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(answer) => return args::answer(&answer),
    };
    let outcome = match arguments.command {
        None => demo::run(&DemoArguments::default()),
        Some(Command::Demo(arguments)) => demo::run(&arguments),
        Some(Command::Evaluate(arguments)) => evaluate::run(&arguments),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        // Whoever reads the output has seen enough: no reason to complain.
        Err(error) if error.is_closed_pipe() => ExitCode::SUCCESS,
        Err(error) => {
            error::report(&error);
            ExitCode::from(BAD_INPUT)
        }
    }
}

impl CliError {
    /// Whether the reader of standard output has gone away.
    fn is_closed_pipe(&self) -> bool {
        matches!(self, Self::Stdout(reason) if reason.kind() == std::io::ErrorKind::BrokenPipe)
    }
}
