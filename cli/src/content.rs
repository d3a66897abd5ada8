//! What is wrong with a JSON file that follows its schema.

use crate::error::CliError;

/// A file without meaning.
#[derive(Debug, thiserror::Error)]
pub enum ContentError {
    /// A list of master nodes is too short for any basis.
    #[error("{file}: {place}: {found} nodes, but a surface needs at least 3")]
    TooFewMasters {
        /// The file, or `standard input`.
        file: String,
        /// The field that lists them.
        place: String,
        /// Their number.
        found: usize,
    },
    /// A field has no meaning beside another one.
    #[error("{file}: {place}: has no meaning {beside}")]
    MeaninglessField {
        /// The file, or `standard input`.
        file: String,
        /// The field.
        place: String,
        /// Beside what.
        beside: &'static str,
    },
}

impl From<ContentError> for CliError {
    fn from(error: ContentError) -> Self {
        Self::job(error)
    }
}
