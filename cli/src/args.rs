//! What can be asked for on the command line.

use clap::{Args, Parser, Subcommand};

use crate::demo::DemoArguments;
use crate::evaluate::EvaluateArguments;
use crate::neighbours::NeighboursArguments;
use crate::surface::SurfaceArguments;

/// Smooth 3D contact surfaces: gap, exact gradient and exact Hessian of the diffuse contact element.
///
/// Without a subcommand: the demonstration on the mesh that comes with the program.
#[derive(Debug, Parser)]
#[command(name = "diffuse-contact", version, propagate_version = true)]
pub struct Arguments {
    /// The job; `demo` if none is named.
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// The jobs of the program.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Evaluate the contact of two surfaces of a mesh and write it for ParaView.
    Demo(DemoArguments),
    /// Evaluate the elements of a JSON file and print gap, normal, N, M, force and tangent as JSON.
    Evaluate(EvaluateArguments),
    /// Evaluate all slave nodes of a mesh's contact interface and write their gaps for ParaView.
    Surface(SurfaceArguments),
    /// Search the master nodes around the slaves of a JSON file by convex hulls and print them as JSON.
    Neighbours(NeighboursArguments),
    /// Solve a deck: finite-strain statics with contact, from a TOML file to results and a report.
    Solve(Elsewhere),
    /// Write one page for the results of several runs.
    Report(Elsewhere),
    /// Print a kernel's source and its operation counts.
    Emit(Elsewhere),
    /// Compare the generated kernels with automatic differentiation and with the interpreter of their graph.
    Check(Elsewhere),
    /// Measure accuracy, smoothness and speed of contact surfaces on meshes of known shape.
    Study(Elsewhere),
    /// Measure the generated kernels against the element written by hand and over dual numbers.
    Bench(Elsewhere),
}

/// Arguments of a job that another program does: whatever that program takes.
#[derive(Args, Clone, Debug)]
#[command(disable_help_flag = true, disable_version_flag = true)]
pub struct Elsewhere {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    _arguments: Vec<std::ffi::OsString>,
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    /// Without debug assertions in clap the tests of arguments find nothing.
    #[test]
    #[should_panic(expected = "Short option names must be unique")]
    fn arguments_that_clash_are_found() {
        let twice = [clap::Arg::new("one").short('o'), clap::Arg::new("other").short('o')];
        clap::Command::new("clash").args(twice).debug_assert();
    }

    #[test]
    fn the_arguments_are_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn no_subcommand_means_the_defaults_of_demo() {
        let Some(Command::Demo(parsed)) =
            Arguments::try_parse_from(["diffuse-contact", "demo"]).unwrap().command
        else {
            panic!("not a demo");
        };
        assert_eq!(format!("{parsed:?}"), format!("{:?}", DemoArguments::default()));
    }
}
