//! Why results could not be written or read.

use std::io;
use std::path::{Path, PathBuf};

use diffuse_contact_mesh::file::reason;
use thiserror::Error;

/// Why results could not be written or read. Lines count from 1.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum OutputError {
    #[error("{}: cannot be written: {}", path.display(), reason(source))]
    Write { path: PathBuf, source: io::Error },
    #[error("{}: cannot be read: {}", path.display(), reason(source))]
    Read { path: PathBuf, source: io::Error },
    /// A file holds something else.
    #[error("{}, line {line}: {problem}", path.display())]
    Content { path: PathBuf, line: usize, problem: String },
    /// A file does not fit the others.
    #[error("{}: {problem}", path.display())]
    Inconsistent { path: PathBuf, problem: String },
    #[error("{} is a file: results go to a directory, such as {}.results", path.display(), path.display())]
    NoDirectory { path: PathBuf },
    #[error("{} holds results already: go on from them with --restart, or replace them with --overwrite", path.display())]
    Occupied { path: PathBuf },
    #[error(
        "{} holds files of a run, but no state to go on from: replace them with --overwrite, or name another directory",
        path.display()
    )]
    Remains { path: PathBuf },
    /// The directory holds a deck that would be replaced by another, and no results that it belongs to: none at all, or those of the deck as
    /// it was before it was changed.
    #[error(
        "{} is another deck than the one to be solved, and belongs to no results: it is not replaced, name another directory",
        path.display()
    )]
    ForeignDeck { path: PathBuf },
    #[error(
        "{} is a link, and files that it leads to are not removed: remove the link or the files, or name another directory",
        path.display()
    )]
    Linked { path: PathBuf },
    #[error("{}: another run is writing there; wait for its end, or name another directory", path.display())]
    Busy { path: PathBuf },
    #[error("{} holds no results to go on from: begin without --restart", path.display())]
    NothingToRestart { path: PathBuf },
    #[error("{} holds results of another deck: it differs from line {line} on", path.display())]
    OtherDeck { path: PathBuf, line: usize },
    #[error(
        "{} holds results of this deck as it was before it was changed: go on with it as it was, or replace them with --overwrite",
        path.display()
    )]
    ChangedDeck { path: PathBuf },
    #[error(
        "{} holds results of another mesh: nodes, elements or sets in a file that the deck names are not what they were",
        path.display()
    )]
    OtherModel { path: PathBuf },
}

impl OutputError {
    /// Whether there was no space left, on the disk or in what the user may have of it.
    pub fn is_full_disk(&self) -> bool {
        use io::ErrorKind::{FileTooLarge, QuotaExceeded, StorageFull};
        matches!(self, Self::Write { source, .. } if matches!(source.kind(), StorageFull | QuotaExceeded | FileTooLarge))
    }

    pub(crate) fn write(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::Write { path, source }
    }

    pub(crate) fn read(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::Read { path, source }
    }
}
