//! What is wrong with a JSON file that follows its schema.

use crate::error::CliError;

/// A file, or `standard input`, without meaning.
#[derive(Debug, thiserror::Error)]
pub enum ContentError {
    #[error("{file}: {place}: {found} nodes, but a surface needs at least 3")]
    TooFewMasters { file: String, place: String, found: usize },
    #[error("{file}: {place}: has no meaning {beside}")]
    MeaninglessField { file: String, place: String, beside: &'static str },
}

impl From<ContentError> for CliError {
    fn from(error: ContentError) -> Self {
        Self::job(error)
    }
}
