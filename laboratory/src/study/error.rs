//! Why a study ends without figures.

use diffuse_contact::assembly::AssemblyError;
use diffuse_contact::interface::{InterfaceError, NoContact};
use diffuse_contact::surface::SurfaceError;
use diffuse_contact_solver::deck::DeckError;
use diffuse_contact_solver::solve::SolveError;

use crate::error::CliError;

/// The mesh of a study is no surface, or a node of it has no contact: no figures are better than some.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    #[error("the mesh of the study: {0}")]
    Surface(#[from] SurfaceError),
    #[error("the interface of the study: {0}")]
    Interface(#[from] InterfaceError),
    #[error("the tangent of the study: {0}")]
    Assembly(#[from] AssemblyError),
    #[error("{case}: slave {slave} has no contact: {reason}")]
    NoContact { case: String, slave: usize, reason: NoContact },
    #[error("{facets} facets are too few for {ranks} ranks, which need {least} each")]
    TooManyRanks { ranks: u32, facets: u64, least: u64 },
    /// A part of a cylinder or a ball that is wider than the whole.
    #[error(
        "the curved body would reach {widest} from its axis with a radius of {radius}: take a smaller --extent or --slenderness"
    )]
    WideBody { widest: f64, radius: f64 },
    /// Less of two bodies than their equally long cells fill. Both figures are half widths.
    #[error("--extent {extent}: it has to be above {least:.3}, where the equally long cells end")]
    NarrowBody { extent: f64, least: f64 },
    #[error("--fine has no meaning beside {problem}")]
    NoFineMeshes { problem: String },
    #[error("the plot cannot be drawn: {reason}")]
    Plot { reason: String },
    #[error(
        "{0}; it is one of the repository's: run the study at the root of the repository, or name the directory with --decks"
    )]
    NoDeck(SolveError),
}

impl From<StudyError> for CliError {
    fn from(error: StudyError) -> Self {
        Self::job(error)
    }
}

/// The error of a deck of the repository: if it is not there, where it would be.
pub fn of_deck(error: SolveError) -> CliError {
    match error {
        missing @ SolveError::Deck(DeckError::Read { .. }) => StudyError::NoDeck(missing).into(),
        other => CliError::job(other),
    }
}
