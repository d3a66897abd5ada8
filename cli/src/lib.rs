//! The command-line program of the diffuse contact element, as a library: the binary only calls [`main`].
//!
//! Without a subcommand the program runs the demonstration on the shipped mesh. Bad input ends it with exit code 2
//! and one sentence on standard error that names the place; results go to standard output or to a file that
//! appears only when it is complete. Exit code 1 is left to `check`, when the kernels do not pass.
//!
//! Two parts are of use to other programs: [`interpreted`], the third backend of the element, which evaluates the
//! formulas' expression graph as it stands (for facets: [`interpreted_facets`]), and [`check`], which compares the
//! backends with each other.
//!
//! ```
//! use diffuse_contact::{Backend, Basis, Element, Frame, Mode, Weight};
//! use diffuse_contact_cli::interpreted::Interpreted;
//!
//! let masters = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
//! let element = Element {
//!     slave: [0.4, 0.6, 0.25],
//!     masters: &masters,
//!     frame: Frame::average_plane(&masters, [0.0, 0.0, 1.0])?,
//!     support_radius: 2.0,
//!     basis: Basis::Linear,
//!     weight: Weight::Cubic,
//! };
//! let contact = Interpreted::default().gap(&element, Mode::Hessian)?;
//! assert!((contact.gap - 0.25).abs() < 1e-14);
//! # Ok::<(), diffuse_contact::ElementError>(())
//! ```
#![forbid(unsafe_code)]

mod args;
mod backend;
#[cfg(feature = "bench")]
mod bench;
#[cfg(not(feature = "bench"))]
#[path = "no_bench.rs"]
mod bench;
pub mod check;
mod contact_mesh;
mod contact_options;
mod demo;
mod emit;
mod error;
mod evaluate;
pub mod interpreted;
pub mod interpreted_facets;
mod json;
mod neighbours;
mod outcome;
mod output;
mod progress;
mod solve;
mod study;
mod surface;
mod threads;
pub mod weight;
mod words;

use std::process::ExitCode;
#[cfg(unix)]
use std::sync::{Arc, atomic::AtomicBool};

use clap::Parser;
use diffuse_contact_kernels::support::Isa;

use args::{Arguments, Command, DemoArguments};
use error::CliError;

/// The page on contact surfaces, whose example is run with the documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../../docs/contact-surface.md")]
pub struct ContactSurfacePage;

/// The page on other solvers, whose Rust program is run with the documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../../docs/integrate.md")]
pub struct IntegratePage;

/// Exit code for input the program cannot use, the same as for arguments it does not know.
const BAD_INPUT: u8 = 2;

/// Does what the command line says.
#[must_use]
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(answer) => return args::answer(&answer),
    };
    outlive_limits_of_files();
    if let Err(error) = check_instructions() {
        error::report(&error);
        return ExitCode::from(BAD_INPUT);
    }
    if arguments.command.as_ref().is_none_or(Command::shares_threads) {
        threads::start();
    }
    let done = |()| ExitCode::SUCCESS;
    let outcome = match arguments.command {
        None => demo::run(&DemoArguments::default()).map(done),
        Some(Command::Demo(arguments)) => demo::run(&arguments).map(done),
        Some(Command::Evaluate(arguments)) => evaluate::run(&arguments).map(done),
        Some(Command::Surface(arguments)) => surface::run(&arguments).map(done),
        Some(Command::Neighbours(arguments)) => neighbours::run(&arguments).map(done),
        Some(Command::Solve(arguments)) => solve::run(&arguments),
        Some(Command::Report(arguments)) => solve::report(&arguments).map(done),
        Some(Command::Emit(arguments)) => emit::run(&arguments).map(done),
        Some(Command::Check(arguments)) => check::run(&arguments),
        Some(Command::Study(arguments)) => study::run(&arguments).map(done).map_err(CliError::of_study),
        Some(Command::Bench(arguments)) => bench::run(&arguments).map(done),
    };
    match outcome {
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
