//! The command-line program of the diffuse contact element, as a library: the binary only calls [`main`].
//!
//! ```sh
//! diffuse-contact                                             # the demonstration on the shipped mesh
//! diffuse-contact surface contact.msh -o interface.vtu        # every slave node of a mesh
//! diffuse-contact evaluate in.json -o out.json                # single elements
//! diffuse-contact neighbours in.json                          # the master nodes around a slave
//! ```
//!
//! Other jobs take longer to build, since they need more than the element. They are those of two other programs, which this one runs if
//! they are there: `solve` and `report` of the solver; `emit`, `check`, `study` and `bench` of the laboratory.
#![forbid(unsafe_code)]

mod args;
mod contact_mesh;
pub mod contact_options;
mod content;
mod demo;
mod elsewhere;
pub mod evaluate;
mod json;
mod neighbours;
mod outcome;
mod surface;

use std::process::ExitCode;

use diffuse_contact_program::{arguments, error, input, output, progress, threads, words};

use args::{Arguments, Command};
use demo::DemoArguments;
use error::CliError;

/// Does what the command line says.
#[must_use]
pub fn main() -> ExitCode {
    diffuse_contact_program::main(|arguments: Arguments| {
        run(arguments.command.unwrap_or_else(|| Command::Demo(DemoArguments::default())))
    })
}

fn run(command: Command) -> Result<ExitCode, CliError> {
    let done = |()| ExitCode::SUCCESS;
    match command {
        Command::Demo(arguments) => {
            threads::start();
            demo::run(&arguments).map(done)
        }
        Command::Evaluate(arguments) => evaluate::run(&arguments),
        Command::Surface(arguments) => {
            if arguments.threads.is_none() {
                threads::start();
            }
            surface::run(&arguments).map(done)
        }
        Command::Neighbours(arguments) => neighbours::run(&arguments),
        Command::Solve(_) | Command::Report(_) => elsewhere::run(elsewhere::SOLVER),
        Command::Emit(_) | Command::Check(_) | Command::Study(_) | Command::Bench(_) => {
            elsewhere::run(elsewhere::LABORATORY)
        }
    }
}
