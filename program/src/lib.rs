//! What the command-line programs share: how they answer and end, files that appear whole, progress, threads.
//!
//! A program is its arguments and a job; [`main`] does the rest:
//!
//! ```no_run
//! use clap::Parser;
//! use std::process::ExitCode;
//!
//! #[derive(Parser)]
//! struct Arguments {
//!     file: std::path::PathBuf,
//! }
//!
//! fn main() -> ExitCode {
//!     diffuse_contact_program::main(|arguments: Arguments| {
//!         println!("{}", arguments.file.display());
//!         Ok(ExitCode::SUCCESS)
//!     })
//! }
//! ```
//!
//! Bad input ends a program with exit code 2 and one sentence on standard error that names the place. Results go to
//! standard output or to a file that appears only when it is complete. [`CliError`] knows files, JSON and threads; a job's
//! own errors stay with the job.
#![forbid(unsafe_code)]

pub mod arguments;
pub mod error;
pub mod input;
pub mod output;
pub mod progress;
pub mod threads;
pub mod words;

use std::process::ExitCode;
#[cfg(unix)]
use std::sync::{Arc, atomic::AtomicBool};

use clap::Parser;
use diffuse_contact_kernels::support::Isa;

use error::CliError;

/// Exit code for input the program cannot use, the same as for arguments it does not know.
pub const BAD_INPUT: u8 = 2;

/// Reads the arguments, does the job, and says how it ended.
#[must_use]
pub fn main<A: Parser>(job: impl FnOnce(A) -> Result<ExitCode, CliError>) -> ExitCode {
    let arguments = match A::try_parse() {
        Ok(arguments) => arguments,
        Err(answer) => return arguments::answer(&answer),
    };
    outlive_limits_of_files();
    match check_instructions().and_then(|()| job(arguments)) {
        Ok(code) => code,
        // Whoever reads the output has seen enough: no reason to complain.
        Err(error) if error.is_closed_pipe() => ExitCode::SUCCESS,
        Err(error) => {
            error::report(&error);
            ExitCode::from(BAD_INPUT)
        }
    }
}

/// The library passes over names that it does not know; whoever starts a program wants to be told.
fn check_instructions() -> Result<(), CliError> {
    let Some(name) = std::env::var_os("DIFFUSE_CONTACT_ISA").filter(|name| !name.is_empty()) else {
        return Ok(());
    };
    let name = name.to_string_lossy().into_owned();
    match Isa::named(&name) {
        Some(_) => Ok(()),
        None => Err(CliError::NoInstructions { name, available: Isa::available().map(Isa::name).collect() }),
    }
}

/// A file that grows beyond what the user may write (`ulimit -f`) is an error of writing, as a full disk is, and not the program's end.
fn outlive_limits_of_files() {
    #[cfg(unix)]
    {
        // That the signal came is known from the error.
        let came = Arc::new(AtomicBool::new(false));
        let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, came);
    }
}
