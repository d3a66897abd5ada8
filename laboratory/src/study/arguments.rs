//! What can be asked of `study`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use serde::Serialize;

use crate::threads;

/// Arguments of `study`.
#[derive(Args, Clone, Debug)]
pub struct StudyArguments {
    /// The study.
    #[command(subcommand)]
    pub study: Study,
}

/// The studies.
#[derive(Subcommand, Clone, Debug)]
pub enum Study {
    /// Error of gap and normal on meshes of a cylinder, a sphere and a torus, with the observed orders, and all over whole bodies.
    Accuracy(AccuracyArguments),
    /// Masters of a slave, conditioning and error of its fit on regular, irregular, stretched and graded meshes.
    Domains(DomainsArguments),
    /// Errors of the heights in the gap, and slaves on a linear basis, by the least regularity of a fit, on irregular meshes.
    Regularity(RegularityArguments),
    /// Sweep a slave node along a closed path: jumps of the gap, kinks of the normal, work around the loop.
    Sweep(SweepArguments),
    /// Carry a rigid pad around a closed path over waves: work of contact over nodes and over faces, smooth and on facets.
    ClosedPath(ClosedPathArguments),
    /// Count what ranks hold and send with windows of a large surface, and estimate how well that scales.
    Scaling(ScalingArguments),
    /// Time and memory of a large interface.
    Throughput(ThroughputArguments),
    /// The examples of the paper with both elements: penetration, Newton iterations, tangents. Takes some minutes.
    Paper(PaperArguments),
    /// Press a cylinder and a ball on a block, all elastic, over faces: nodal pressures against Hertz, and their orders.
    Hertz(HertzArguments),
    /// Solve decks with known answers with both elements: patch test, Hertz, turning and sliding.
    Verification(VerificationArguments),
}

/// Arguments of `study paper`.
#[derive(Args, Clone, Debug)]
pub struct PaperArguments {
    /// Markdown to write, with its figures in `pictures/` beside it [default: standard output, without figures]
    #[arg(short, long, value_name = "FILE.md")]
    pub output: Option<PathBuf>,
    /// Directory for the figures alone, by the runs that they need
    #[arg(long, value_name = "DIR", conflicts_with = "output")]
    pub pictures: Option<PathBuf>,
    /// Directory for the decks that are run, to be run with `solve`
    #[arg(long, value_name = "DIR")]
    pub decks: Option<PathBuf>,
    /// Coarse mesh, one penalty and a few increments only: shows that everything works
    #[arg(long)]
    pub quick: bool,
}

/// Arguments of `study accuracy`.
#[derive(Args, Clone, Debug)]
pub struct AccuracyArguments {
    /// Print JSON instead of Markdown tables
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `study domains`.
#[derive(Args, Clone, Debug)]
pub struct DomainsArguments {
    /// Slave nodes on each mesh
    #[arg(long, value_name = "N", default_value_t = 10_000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub slaves: u32,
    /// Print JSON instead of a Markdown table
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `study regularity`.
#[derive(Args, Clone, Debug)]
pub struct RegularityArguments {
    /// Meshes of each kind
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub meshes: u32,
    /// Print JSON instead of a Markdown table
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `study sweep`.
#[derive(Args, Clone, Debug)]
pub struct SweepArguments {
    /// Plot of gap and force to write
    #[arg(short, long, value_name = "FILE.svg")]
    pub output: Option<PathBuf>,
    /// All curves to write
    #[arg(long, value_name = "FILE.csv")]
    pub csv: Option<PathBuf>,
    /// Make the cells so many times smaller, 1 to 8
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=8))]
    pub refine: u32,
    /// Move the nodes within the surface by up to this part of a cell, at random, 0 to 0.35
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = moved)]
    pub moved: f64,
    /// Steps around the loop, 100 to 1000000
    #[arg(long, value_name = "N", default_value_t = 4800, value_parser = clap::value_parser!(u32).range(100..=1_000_000))]
    pub steps: u32,
}

/// Arguments of `study closed-path`.
#[derive(Args, Clone, Debug)]
pub struct ClosedPathArguments {
    /// Steps around the loop, 100 to 100000, rounded up to an even number
    #[arg(long, value_name = "N", default_value_t = 400, value_parser = clap::value_parser!(u32).range(100..=100_000))]
    pub steps: u32,
}

/// Arguments of `study scaling`.
#[derive(Args, Clone, Debug)]
pub struct ScalingArguments {
    /// Markdown to write [default: standard output]
    #[arg(short, long, value_name = "FILE.md", conflicts_with = "json")]
    pub output: Option<PathBuf>,
    /// Print JSON instead
    #[arg(long)]
    pub json: bool,
    /// Master facets, rounded up to a square
    #[arg(long, value_name = "N", default_value_t = 100_000_000, value_parser = clap::value_parser!(u64).range(4_096..=1_000_000_000_000))]
    pub facets: u64,
    /// Numbers of ranks; at least 64 facets for each
    #[arg(long, value_name = "P,P,…", value_delimiter = ',', default_values_t = [64, 256, 1024, 4096, 10_000], value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub ranks: Vec<u32>,
    /// How much of each side of the surface, in its middle, has slaves, 0.1 to 0.8
    #[arg(long, value_name = "SHARE", default_value_t = 0.5, value_parser = between::<1, 8>)]
    pub contact: f64,
    /// Limit of the distance over the side of a facet
    #[arg(long, value_name = "X", default_value_t = 0.7, value_parser = positive)]
    pub limit: f64,
    /// Skin of windows over the side of a facet
    #[arg(long, value_name = "X", default_value_t = 0.4, value_parser = positive)]
    pub skin: f64,
    /// Iterations until windows are made anew
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..))]
    pub every: u32,
    #[command(flatten)]
    pub costs: Costs,
}

/// What things cost.
#[derive(Args, Clone, Copy, Debug, Serialize)]
pub struct Costs {
    /// Gap, N and M of a slave, µs
    #[arg(long, value_name = "µs", default_value_t = 2.62, value_parser = positive)]
    pub evaluation: f64,
    /// Search and pairing of a slave in a new window, µs
    #[arg(long, value_name = "µs", default_value_t = 18.9, value_parser = positive)]
    pub search: f64,
    /// Of a message, µs
    #[arg(long, value_name = "µs", default_value_t = 5.0, value_parser = positive)]
    pub latency: f64,
    /// Of a rank, in each direction, GB/s
    #[arg(long, value_name = "GB/s", default_value_t = 1.0, value_parser = positive)]
    pub bandwidth: f64,
}

/// A finite number above zero.
fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 && number.is_finite() => Ok(number),
        Ok(_) => Err("it has to be above zero".into()),
        Err(reason) => Err(reason.to_string()),
    }
}

/// A number between so many tenths.
fn between<const LEAST: u8, const MOST: u8>(text: &str) -> Result<f64, String> {
    let (least, most) = (f64::from(LEAST) / 10.0, f64::from(MOST) / 10.0);
    match positive(text)? {
        number if (least..=most).contains(&number) => Ok(number),
        _ => Err(format!("it has to be between {least} and {most}")),
    }
}

/// A part of a cell by which nodes may be moved.
fn moved(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if (0.0..=0.35).contains(&share) => Ok(share),
        Ok(_) => Err("it has to be between 0 and 0.35".into()),
        Err(reason) => Err(reason.to_string()),
    }
}

/// Arguments of `study throughput`.
#[derive(Args, Clone, Debug)]
pub struct ThroughputArguments {
    /// Slave nodes, and as many master nodes: 64 to 10000000, rounded up to a square
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(64..=10_000_000))]
    pub nodes: u64,
    /// Number of threads [default: one for each processor]
    #[arg(long, value_name = "K", value_parser = threads::parse)]
    pub threads: Option<usize>,
    /// Also make the pattern of the tangent and fill it; N and M of all slaves are held for that, some 7 kB each
    #[arg(long)]
    pub assembly: bool,
    /// Also deal the slaves out to so many windows of the surface, and compare all that they have with the whole, bit for bit
    #[arg(long, value_name = "P", conflicts_with = "assembly", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub windows: Option<u32>,
    /// Print JSON instead of a table
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `study hertz`.
#[derive(Args, Clone, Debug)]
pub struct HertzArguments {
    /// Bodies on the block [default: all]
    #[arg(value_enum, value_name = "BODY")]
    pub bodies: Vec<HertzBody>,
    /// Cells of the curved body within the half width of the contact, on the finest of the meshes; the time grows with its fourth power
    /// or so for the ball
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(4..=32))]
    pub finest: u32,
    /// Meshes, each with two thirds of the cells of the next
    #[arg(long, value_name = "K", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=3))]
    pub meshes: u32,
    /// About the half width of the contact over the radius of the curved body
    #[arg(long, value_name = "A/R", default_value_t = 0.005, value_parser = positive)]
    pub slenderness: f64,
    /// Penalty over E/h of the curved body's cells
    #[arg(long, value_name = "F", default_value_t = 5.0, value_parser = positive)]
    pub penalty: f64,
    /// Pressures of integration points, in place of those averaged to nodes
    #[arg(long)]
    pub points: bool,
    /// How much of both bodies there is, half widths, more than the 1.3 or so of equally long cells [default: 20 of a cylinder, 10 of a
    /// ball]
    #[arg(long, value_name = "W", value_parser = positive)]
    pub extent: Option<f64>,
    /// Number of threads [default: one for each processor, but for the linear solver, which has one]
    #[arg(long, value_name = "K", value_parser = threads::parse)]
    pub threads: Option<usize>,
}

/// What is pressed on the block.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum HertzBody {
    /// A long cylinder, a slice of which is solved in plane strain
    Cylinder,
    /// A ball, a quarter of which is solved
    Ball,
}

/// Arguments of `study verification`.
#[derive(Args, Clone, Debug)]
pub struct VerificationArguments {
    /// Problems [default: all]
    #[arg(value_enum, value_name = "PROBLEM")]
    pub problems: Vec<VerificationProblem>,
    /// Directory of the decks
    #[arg(long, value_name = "DIR", default_value = "examples")]
    pub decks: PathBuf,
    /// The finer meshes of the Hertz problems, of cattaneo_mindlin and of pipe_pinch, which take minutes, in place of the others
    #[arg(long, conflicts_with = "pictures")]
    pub fine: bool,
    /// Directory to write a picture of each problem to that has one
    #[arg(long, value_name = "DIR")]
    pub pictures: Option<PathBuf>,
    /// Number of threads [default: one for each processor, but for the linear solver, which has one]
    #[arg(long, value_name = "K", value_parser = threads::parse)]
    pub threads: Option<usize>,
}

/// A problem with a known answer, by the name of its deck.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
#[value(rename_all = "snake_case")]
pub enum VerificationProblem {
    /// A uniform pressure through an interface
    PatchTest,
    /// A cylinder on a plane
    HertzCylinder,
    /// A ball on a plane
    HertzSphere,
    /// A cylinder on a block, both elastic
    ElasticCylinder,
    /// One ring turned in another
    CoaxialCylinders,
    /// A block on a cylinder that turns
    SlidingBlock,
    /// A ring pressed on a block
    RingBlock,
    /// A pipe pinched by a plate
    PipePinch,
    /// Two cylinders that stick in the middle, with friction
    CattaneoMindlin,
    /// Walls of a tube in contact with one another
    SqueezedTube,
    /// Legs of a serpentine in contact with one another
    CrushedSerpentine,
    /// Coils of a spring in contact with one another
    CoilSpring,
}

impl VerificationProblem {
    /// Whether it is also solved on meshes that take minutes.
    pub const fn has_fine_meshes(self) -> bool {
        matches!(self, Self::HertzCylinder | Self::HertzSphere | Self::CattaneoMindlin | Self::PipePinch)
    }
}

/// Its name on the command line.
pub fn name(choice: impl ValueEnum) -> String {
    choice.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}
