//! What the command-line programs share: how they answer and end, files that appear whole, progress, threads.
//!
//! Bad input ends a program with exit code 2 and one sentence on standard error that names the place. Results go to
//! standard output or to a file that appears only when it is complete.
#![forbid(unsafe_code)]

pub mod arguments;
pub mod error;
pub mod output;
pub mod progress;
pub mod threads;
pub mod words;

use std::process::ExitCode;

use clap::Parser;

use error::CliError;

/// Exit code for input the program cannot use, the same as for arguments it does not know.
pub const BAD_INPUT: u8 = 2;

/// Reads the arguments, does the job, and says how it ended.
#[must_use]
pub fn main<A: Parser>(job: impl FnOnce(A) -> Result<ExitCode, CliError>) -> ExitCode {
    match A::try_parse().map(job) {
        Err(answer) => arguments::answer(&answer),
        Ok(Ok(code)) => code,
        // Whoever reads the output has seen enough: no reason to complain.
        Ok(Err(error)) if error.is_closed_pipe() => ExitCode::SUCCESS,
        Ok(Err(error)) => {
            error::report(&error);
            ExitCode::from(BAD_INPUT)
        }
    }
}
