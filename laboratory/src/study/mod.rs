//! The `study` job: what contact surfaces achieve on meshes of known shape, and the solver on the paper's examples and on
//! problems with known answers. The figures stand in `docs/results/`.
//!
//! * [`accuracy`]: error of gap and normal, and its order;
//! * [`closed_path`]: work of contact over nodes and over faces around a closed path;
//! * [`domains`]: masters, conditioning and error on stretched, graded and irregular meshes;
//! * [`sweep`]: smoothness along a path over many facets;
//! * [`hertz`]: pressures at the nodes of an elastic cylinder and an elastic ball on an elastic block, and their orders;
//! * [`regularity`]: what the least regularity of a fit costs and gains on irregular, bumpy meshes;
//! * [`scaling`]: what ranks hold and send with windows of a large surface, counted;
//! * [`throughput`]: time and memory;
//! * [`paper`]: the examples of the paper, solved with both elements.
//! * [`verification`]: patch test, Hertz, torque and force of what ought to turn and slide evenly.

mod accuracy;
mod arguments;
mod closed_path;
mod domains;
mod error;
mod hertz;
mod markdown;
mod paper;
mod patch;
mod plot;
mod regularity;
mod scaling;
mod sweep;
mod throughput;
mod verification;

pub use arguments::StudyArguments;
pub use error::StudyError;

use diffuse_contact::Point;
use diffuse_contact::interface::{ContactInterface, InterfaceOptions};
use diffuse_contact::surface::{Facet, MasterSurface};

use crate::error::CliError;

use arguments::Study;

fn dot(a: Point, b: Point) -> f64 {
    (0..3).map(|axis| a[axis] * b[axis]).sum()
}

fn norm(a: Point) -> f64 {
    dot(a, a).sqrt()
}

/// The smallest and the largest value.
fn extremes(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
}

/// An interface of a master and of slaves at these points, paired, and positions of all nodes: those of the slaves come last.
fn paired(
    mut positions: Vec<Point>,
    facets: Vec<Facet>,
    slaves: impl IntoIterator<Item = Point>,
    options: InterfaceOptions,
) -> Result<(ContactInterface, Vec<Point>), StudyError> {
    let master = MasterSurface::new(&positions, facets)?;
    let first = positions.len();
    positions.extend(slaves);
    let slaves = (first..positions.len()).collect();
    let mut interface = ContactInterface::new(master, slaves, &[], &positions, options)?;
    interface.refresh_pairing(&positions)?;
    Ok((interface, positions))
}

/// Makes the study.
pub fn run(arguments: &StudyArguments) -> Result<(), CliError> {
    match &arguments.study {
        Study::Accuracy(arguments) => accuracy::run(arguments),
        Study::Domains(arguments) => domains::run(arguments),
        Study::Regularity(arguments) => regularity::run(arguments),
        Study::Sweep(arguments) => sweep::run(arguments),
        Study::Scaling(arguments) => scaling::run(arguments),
        Study::Throughput(arguments) => throughput::run(arguments),
        Study::Paper(arguments) => paper::run(arguments),
        Study::ClosedPath(arguments) => closed_path::run(arguments),
        Study::Hertz(arguments) => hertz::run(arguments),
        Study::Verification(arguments) => verification::run(arguments),
    }
}
