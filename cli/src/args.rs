//! What can be asked for on the command line.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, value_parser};
use diffuse_contact_codegen::{Basis, FrameRule, Mode, Output};

use crate::backend::BackendKind;
use crate::bench::BenchArguments;
use crate::check::NodeCounts;
use crate::demo::status;
use crate::error::report;
use crate::solve::{ReportArguments, SolveArguments};
use crate::study::StudyArguments;
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
    /// Evaluate the elements of a JSON file and print gap, normal, N, M, residual and tangent as JSON.
    Evaluate(EvaluateArguments),
    /// Evaluate all slave nodes of a mesh's contact interface and write their gaps for ParaView.
    Surface(SurfaceArguments),
    /// Search the master nodes around the slaves of a JSON file by convex hulls and print them as JSON.
    Neighbours(NeighboursArguments),
    /// Solve a deck: finite-strain statics with contact, from a TOML file to results and a report.
    Solve(SolveArguments),
    /// Write one page for the results of several runs.
    Report(ReportArguments),
    /// Print a kernel's source and its operation counts.
    Emit(EmitArguments),
    /// Compare the generated kernels with automatic differentiation and with the interpreter of their graph.
    Check(CheckArguments),
    /// Measure accuracy, smoothness and speed of contact surfaces on meshes of known shape.
    Study(StudyArguments),
    /// Measure the generated kernels against the element written by hand and over dual numbers (with the feature `bench`).
    Bench(BenchArguments),
}

impl Command {
    /// Whether the work is shared among as many threads as the machine has.
    pub fn shares_threads(&self) -> bool {
        match self {
            Self::Demo(_) | Self::Study(_) => true,
            Self::Surface(arguments) => arguments.threads.is_none(),
            Self::Solve(arguments) => arguments.threads.is_none(),
            Self::Evaluate(_)
            | Self::Neighbours(_)
            | Self::Report(_)
            | Self::Emit(_)
            | Self::Check(_)
            | Self::Bench(_) => false,
        }
    }
}

/// Arguments of `demo`.
#[derive(Args, Clone, Debug)]
#[command(after_help = status::table())]
pub struct DemoArguments {
    /// Mesh file, Gmsh `.msh` 4.1 or Abaqus `.inp` [default: the plate on a cylinder that comes with the program]
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,
    /// The two sets of the mesh.
    #[command(flatten)]
    pub sets: SetArguments,
    /// VTU file to write
    #[arg(short, long, value_name = "OUT.vtu", default_value = DemoArguments::OUTPUT)]
    pub output: PathBuf,
    /// Master nodes per element to start from, 6 to 24; more are taken where the fit needs them
    #[arg(long, value_name = "M", default_value_t = diffuse_contact::pairing::DEFAULT_NEIGHBOURS, value_parser = neighbours)]
    pub neighbours: usize,
}

impl DemoArguments {
    const OUTPUT: &str = "diffuse-contact.vtu";
}

impl Default for DemoArguments {
    fn default() -> Self {
        Self {
            mesh: None,
            sets: SetArguments::default(),
            output: Self::OUTPUT.into(),
            neighbours: diffuse_contact::pairing::DEFAULT_NEIGHBOURS,
        }
    }
}

/// The two sets of a mesh that touch each other.
#[derive(Args, Clone, Debug)]
pub struct SetArguments {
    /// Facet set that carries the smooth surface
    #[arg(long, value_name = "SET", default_value = SetArguments::MASTER)]
    pub master: String,
    /// Set whose nodes touch it
    #[arg(long, value_name = "SET", default_value = SetArguments::SLAVE)]
    pub slave: String,
}

impl SetArguments {
    const MASTER: &str = "master";
    const SLAVE: &str = "slave";
}

impl Default for SetArguments {
    fn default() -> Self {
        Self { master: Self::MASTER.into(), slave: Self::SLAVE.into() }
    }
}

/// The formats of `evaluate`, for its help.
const JSON_FORMATS: &str = r#"IN.json:
  {"elements": [{
    "slave": [x, y, z],
    "masters": [[x, y, z], ...],     at least 3, or the file is refused
    "outward": [x, y, z],            direction to the outside of the master, any length;
                                     may be left out if a frame is given
    "frame": "average-plane",        the default, or
             {"origin": [x, y, z], "t1": [x, y, z], "t2": [x, y, z], "normal": [x, y, z]}
    "frame_derivative": "co-moving", the average plane moves with the nodes while differentiating: N and M are
                                     exact; the default, but not for a given frame, which cannot move
                        "frozen",    the frame is held; the default for a given frame
    "support_radius": R,             default 1.25 x the farthest in-plane distance of a master; held while
                                     differentiating: give it explicitly to compare with differences
    "basis": "quadratic",            or "linear"; default quadratic from 6 masters on
    "weight": "cubic",               the default, (1 - r)^2 (1 + 2 r), or
              "cubic-interpolating", the same made interpolating: the surface passes through the masters, or
              "wendland-c2",         (1 - r)^4 (1 + 4 r)
    "penalty": 1.0                   the default
  }, ...]}

OUT.json, in the same order; vectors and rows over slave, master 1, ... master n, global axes:
  {"elements": [
    {"status": "ok", "active": gap < 0, "gap": g, "foot": [3], "normal": [3], "coefficients": [6 or 3],
     "frame": {...}, "frame_derivative": "...", "support_radius": R, "regularity": r, "n": [3(n+1)],
     "m": [[...], ...], "residual": [...], "tangent": [[...], ...]},
    {"status": "error", "code": "singular-fit", "message": "..."}
  ]}
A file that does not follow this form is refused: exit code 2, nothing written. An element whose geometry or parameters have
no result is an entry with status "error", and the exit code is 0.
regularity: how well the masters carry the fit, 0 on one conic (linear basis: on one line), at most 1; near 0 the entries
of n and m may be large. An element has 1000 masters at most.
Residual -penalty g N and tangent penalty (g M + N N^T) are given for either sign of the gap."#;

/// Arguments of `evaluate`.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = JSON_FORMATS)]
pub struct EvaluateArguments {
    /// Elements as JSON; `-` reads standard input
    #[arg(value_name = "IN.json")]
    pub input: PathBuf,
    /// File to write [default: standard output]
    #[arg(short, long, value_name = "OUT.json")]
    pub output: Option<PathBuf>,
    /// What computes the derivatives
    #[arg(long, value_enum, default_value_t = BackendKind::Generated)]
    pub backend: BackendKind,
}

/// The formats of `neighbours`, for its help.
const NEIGHBOUR_FORMATS: &str = r#"IN.json, one search, a list [...] of them, or the same file as for evaluate, {"elements": [...]}:
  {"slave": [x, y, z],
   "masters": [[x, y, z], ...],     at least 3, or the file is refused
   "outward": [x, y, z],            direction to the outside of the master, any length
   "rule": "hull-layers",           the nodes of the first layers of convex hulls around the slave; the default
           "hull-radius",           the layers set the support radius, all nodes within take part
           "nearest",               the nearest nodes
   "layers": L,                     hull-layers: exactly so many, however well they carry the fit; hull-radius: at
                                    least so many. Default: as many as the fit needs to be well conditioned
   "count": C,                      nearest: at least so many nodes; default 12
   "basis": "quadratic"             or "linear": what the nodes have to carry; default quadratic, and linear where
                                    no nodes carry that; not with hull-layers and a number of layers
  }

OUT.json, laid out as IN.json, in the same order; nodes are places in "masters", counted from 0:
  {"status": "ok", "rule": "...", "at_slave": [...], "layers": [[...], ...], "nodes": [...],
   "support_radius": R, "basis": "...", "condition": c, "regularity": r, "pivot_ratio": p,
   "encloses_slave": true, "complete": true, "fallback": null, "frame": {...}}
  {"status": "error", "code": "no-average-plane", "message": "..."}
at_slave         nodes straight above or below the slave; they belong to no layer
layers           innermost first; fewer than asked for if the nodes run out; one for "nearest"
nodes            those that take part, by in-plane distance from the slave
condition        condition number of the moment matrix; null if it is singular to rounding
regularity       how well the nodes carry the fit: 0 on one conic (linear basis: on one line), at most 1
encloses_slave   whether the slave lies within the nodes; if not, the fit extrapolates
complete         whether the nodes looked at sufficed to be sure of the layers
fallback         null, {"kind": "extended", "by": layers or nodes more than asked for}, or
                 {"kind": "linear", "quadratic_regularity": of the best nodes tried}"#;

/// Arguments of `neighbours`.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = NEIGHBOUR_FORMATS)]
pub struct NeighboursArguments {
    /// Slave and master nodes as JSON; `-` reads standard input
    #[arg(value_name = "IN.json")]
    pub input: PathBuf,
    /// File to write [default: standard output]
    #[arg(short, long, visible_alias = "out", value_name = "OUT.json")]
    pub output: Option<PathBuf>,
}

/// How a weight is written, for the help of `emit` and `check`.
const FORMULAS: &str = "\
FORMULA is a weight w(r) for 0 <= r < 1, r = in-plane distance over the support radius; it is 0 beyond.
It may contain r, numbers, + - * /, ^ with an integer exponent, ( ), exp(...), sqrt(...) and
if r < 0.5 { ... } else { ... }. It must be positive and flat at r = 0.
The cubic weight of the paper is \"(1 - r)^2 * (1 + 2*r)\". Built-in weights have names: cubic, cubic-interpolating,
wendland-c2. With --interpolating the weight is w/(1 - w): the surface passes through the master nodes.";

/// Most nodes that operations are counted for: their pairs are as many as half the square.
const MOST_NODES: i64 = 1_000;

/// Arguments of `emit`.
#[derive(Args, Clone, Debug)]
#[command(after_help = FORMULAS)]
pub struct EmitArguments {
    /// Master nodes that operations are counted for; the kernel serves any number
    #[arg(long, value_name = "N", required_unless_present = "counts", value_parser = value_parser!(u32).range(1..=MOST_NODES))]
    pub nodes: Option<u32>,
    /// What the kernel computes
    #[arg(long, value_parser = named(Output::ALL, Output::name), required_unless_present = "counts")]
    pub output: Option<Output>,
    /// With how many derivatives
    #[arg(long, value_parser = named(Mode::ALL, Mode::name), required_unless_present = "counts")]
    pub mode: Option<Mode>,
    /// Basis of the fit [default: quadratic; both with --counts]
    #[arg(long, value_parser = named(Basis::ALL, Basis::name))]
    pub basis: Option<Basis>,
    /// Weight of the fit, by name or formula [default: cubic]
    #[arg(long, value_name = "FORMULA")]
    pub weight: Option<String>,
    /// Make the weight of the formula interpolating
    #[arg(long, requires = "weight")]
    pub interpolating: bool,
    /// What the local frame does while differentiating the gap [default: frozen; both with --counts]
    #[arg(long, value_parser = named([FrameRule::Frozen, FrameRule::CoMoving], frame_name))]
    pub frame_derivative: Option<FrameRule>,
    /// Instead of a kernel, print the operation counts of all kernels
    #[arg(long, conflicts_with_all = ["nodes", "output", "mode", "frame_derivative"])]
    pub counts: bool,
    /// File to write [default: standard output]
    #[arg(short = 'o', value_name = "FILE")]
    pub file: Option<PathBuf>,
}

/// Arguments of `check`.
#[derive(Args, Clone, Debug)]
#[command(after_help = FORMULAS)]
pub struct CheckArguments {
    /// Numbers of master nodes: 9, 6..=12 or 6..12 [default: 6..=24 quadratic, 3..=24 linear]
    #[arg(long, value_name = "A..=B")]
    pub nodes: Option<NodeCounts>,
    /// Basis of the fit [default: both]
    #[arg(long, value_parser = named(Basis::ALL, Basis::name))]
    pub basis: Option<Basis>,
    /// Weight of the fit, by name or formula [default: all that kernels are compiled for]. Of a formula there are no
    /// kernels in the program: the interpreter is compared with automatic differentiation
    #[arg(long, value_name = "FORMULA")]
    pub weight: Option<String>,
    /// Make the weight of the formula interpolating
    #[arg(long, requires = "weight")]
    pub interpolating: bool,
    /// Seed of the random elements
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// Print JSON instead of a table
    #[arg(long)]
    pub json: bool,
}

/// Name of a frame rule, the same as in the JSON of `evaluate`.
pub const fn frame_name(frame: FrameRule) -> &'static str {
    match frame {
        FrameRule::Frozen => "frozen",
        FrameRule::CoMoving => "co-moving",
    }
}

/// Parser for a choice by name.
pub fn named<T: Copy + Send + Sync + 'static, const COUNT: usize>(
    all: [T; COUNT],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(all.map(name)).map(move |given| {
        let found = all.into_iter().find(|&choice| name(choice) == given);
        found.expect("clap lets no other name through")
    })
}

/// Number of neighbours the quadratic basis can use.
fn neighbours(text: &str) -> Result<usize, String> {
    let allowed = diffuse_contact::Basis::Quadratic.size()..=diffuse_contact::pairing::MAX_NEIGHBOURS;
    match text.parse() {
        Ok(count) if allowed.contains(&count) => Ok(count),
        _ => Err(format!("not a whole number from {} to {}", allowed.start(), allowed.end())),
    }
}

/// Prints help and version as clap lays them out, and a wrong argument as one sentence.
pub fn answer(answer: &clap::Error) -> ExitCode {
    if !answer.use_stderr() {
        // A closed pipe is no reason to complain.
        let _ = answer.print();
        return ExitCode::SUCCESS;
    }
    report(&one_sentence(&answer.render().to_string()));
    ExitCode::from(crate::BAD_INPUT)
}

/// The statement of a clap message: everything before the usage, on one line, without the leading `error:`.
fn one_sentence(message: &str) -> String {
    let lines = message
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more information"))
        .filter(|line| !line.is_empty());
    let mut statement = String::new();
    for line in lines {
        let separator = if statement.is_empty() {
            ""
        } else if line.starts_with("tip:") {
            "; "
        } else {
            " "
        };
        statement.push_str(separator);
        statement.push_str(line);
    }
    format!("{} (see --help)", statement.strip_prefix("error: ").unwrap_or(&statement))
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

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

    #[test]
    fn a_wrong_argument_is_one_sentence() {
        let error =
            Arguments::try_parse_from(["diffuse-contact", "evaluate", "a", "--backend", "x"]).unwrap_err();
        assert_eq!(
            one_sentence(&error.render().to_string()),
            "invalid value 'x' for '--backend <BACKEND>' [possible values: generated, ad] (see --help)"
        );
        let error =
            Arguments::try_parse_from(["diffuse-contact", "evaluate", "a", "--bakend", "ad"]).unwrap_err();
        assert_eq!(
            one_sentence(&error.render().to_string()),
            "unexpected argument '--bakend' found; tip: a similar argument exists: '--backend' (see --help)"
        );
    }
}
