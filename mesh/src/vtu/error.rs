//! Why a grid was not written.

use std::path::PathBuf;

use thiserror::Error;

/// Why a grid was not written. Cells and points count from 0.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum VtuError {
    /// The file cannot be written; if there was a file of this name before, it is unchanged.
    #[error("{path}: cannot write the file: {cause}")]
    Write { path: PathBuf, cause: std::io::Error },
    /// The writer given refused the output.
    #[error("cannot write the grid: {cause}")]
    Output { cause: std::io::Error },
    /// An array has not one value for each point or cell.
    #[error("{name:?} has {found} values for {expected} {attached}")]
    LengthMismatch { name: String, attached: Attached, expected: usize, found: usize },
    /// Two arrays on the points, or two on the cells, share a name.
    #[error("the {attached} have two arrays named {name:?}")]
    DuplicateName { name: String, attached: Attached },
    /// A name is empty or contains control characters that XML cannot express.
    #[error("{name:?} cannot be the name of an array: it is empty or has characters that XML does not allow")]
    InvalidName { name: String },
    /// A cell has the wrong number of nodes.
    #[error("cell {cell}, a {kind}, has {found} nodes in place of {expected}")]
    CellNodeCount { cell: usize, kind: &'static str, expected: usize, found: usize },
    /// A cell refers to a point that does not exist.
    #[error("cell {cell} refers to point {node}, but there are only {points} points")]
    NodeOutOfRange { cell: usize, node: usize, points: usize },
    /// A coordinate is NaN or infinite.
    #[error("point {point} has a coordinate that is not a finite number")]
    NonFinitePoint { point: usize },
}

/// What an array belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Attached {
    /// The points.
    Points,
    /// The cells.
    Cells,
}

impl std::fmt::Display for Attached {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Attached::Points => "points",
            Attached::Cells => "cells",
        })
    }
}
