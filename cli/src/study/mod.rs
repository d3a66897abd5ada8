//! The `study` job: what contact surfaces achieve on meshes of known shape. Its figures stand in
//! `docs/contact-surface.md`, those of [`paper`] in `docs/paper.md`.
//!
//! * [`accuracy`]: error of gap and normal, and its order;
//! * [`sweep`]: smoothness along a path over many facets;
//! * [`throughput`]: time and memory;
//! * [`paper`]: the examples of the paper, solved with both elements.

mod accuracy;
mod arguments;
mod error;
mod markdown;
mod paper;
mod patch;
mod sweep;
mod throughput;

pub use arguments::StudyArguments;
pub use error::StudyError;

use crate::error::CliError;

use arguments::Study;

/// Makes the study.
pub fn run(arguments: &StudyArguments) -> Result<(), CliError> {
    match &arguments.study {
        Study::Accuracy(arguments) => accuracy::run(arguments),
        Study::Sweep(arguments) => sweep::run(arguments),
        Study::Throughput(arguments) => throughput::run(arguments),
        Study::Paper(arguments) => paper::run(arguments),
    }
}
