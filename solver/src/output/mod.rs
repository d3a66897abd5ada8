//! Results on disk.
//!
//! | file | what it is |
//! | --- | --- |
//! | `deck.toml` | the deck as it was read |
//! | `history.csv` | a line per increment: iterations, penetration, contact forces, reactions and where their supports are |
//! | `iterations.csv` | a line per residual |
//! | `results.pvd`, `results/*.vtu` | for ParaView: displacement, stress, plastic strain, contact gap and pressure |
//! | `points.pvd`, `points/*.vtu` | the same for integration points, of interfaces over faces: gap, pressure, normal, friction |
//! | `skins/*.json` | the skin of the bodies with the same fields, for the report |
//! | `state.json` | what a restart goes on from |
//! | `summary.json` | how the run ended |
//! | `failed.json` | of a run that ended early the increment that failed: residuals, worst nodes, shape |
//!
//! **An increment is on disk before the next begins**: pictures and tables first, then `state.json`, which takes the place of its
//! predecessor in one step. So whatever stops the run, `state.json` is whole, and every increment it counts is there; a restart
//! takes back what the others wrote after it. A disk that is full stops the run with the name of the file.

use std::fs;
use std::path::Path;

use serde::Deserialize;

mod directory;
mod error;
mod failed;
mod fields;
mod history;
mod loads;
mod picture;
mod points;
mod recorder;
mod saved;
mod seal;
mod skin;
mod summary;

pub use directory::Claim;
pub use error::OutputError;
pub use failed::{Failed, WorstNode};
pub use fields::{ContactStatus, Fields, SlaveFields, Stresses};
pub use history::{History, HistoryRow, read_history};
pub use recorder::{Recorder, RecorderOptions, SKIN, Watcher};
pub use saved::Saved;
pub use skin::{Skin, SkinFrame};
pub use summary::{ContactSummary, FrictionSummary, PartSummary, Summary};

/// Reads a document of a directory of results.
pub(crate) fn read_json<T: for<'a> Deserialize<'a>>(path: &Path) -> Result<T, OutputError> {
    parse_json(path, &fs::read_to_string(path).map_err(OutputError::read(path))?)
}

/// Reads the text of one.
fn parse_json<T: for<'a> Deserialize<'a>>(path: &Path, text: &str) -> Result<T, OutputError> {
    serde_json::from_str(text).map_err(|error| OutputError::Content {
        path: path.to_path_buf(),
        line: error.line(),
        // Its own mention of line and column would be the second.
        problem: error.to_string().split(" at line ").next().unwrap_or_default().to_owned(),
    })
}

/// Whether `path` is a file of the results in `directory`, or would be one, the report apart: others must not replace it.
pub fn is_result(directory: &Path, path: &Path) -> bool {
    directory::Directory::new(directory).owns(path)
}

/// Names of the files in a directory of results.
pub mod names {
    /// The deck as it was read.
    pub const DECK: &str = "deck.toml";
    /// A line per increment.
    pub const HISTORY: &str = "history.csv";
    /// A line per residual.
    pub const ITERATIONS: &str = "iterations.csv";
    /// The series for ParaView.
    pub const SERIES: &str = "results.pvd";
    /// Its pictures.
    pub const PICTURES: &str = "results";
    /// The series of the integration points.
    pub const POINT_SERIES: &str = "points.pvd";
    /// Their pictures.
    pub const POINTS: &str = "points";
    /// Skins for the report.
    pub const SKINS: &str = "skins";
    /// What a restart goes on from.
    pub const STATE: &str = "state.json";
    /// How the run ended.
    pub const SUMMARY: &str = "summary.json";
    /// The increment that the run ended with, if it failed.
    pub const FAILED: &str = "failed.json";
    /// The report.
    pub const REPORT: &str = "report.html";
}
