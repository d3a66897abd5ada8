//! Why a slave has no neighbourhood.

use crate::{Basis, ElementError};

/// Every reason for which a search yields no nodes. Each carries the figures that led to it.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum NeighbourhoodError {
    /// Fewer nodes than the smallest fit needs: no contact candidate.
    #[error("{found} master nodes within reach, but even the linear basis needs {needed}")]
    NoCandidate { found: usize, needed: usize },
    /// Domains of influence belong to a surface, not to a cloud of nodes.
    #[error(
        "domains of influence belong to the nodes of a surface: a search in a cloud of nodes needs another rule"
    )]
    NeedsSurface,
    /// A coordinate is NaN or infinite. `what` is `"slave"`, `"master"` or `"outward"`; `index` counts from 0.
    #[error("{what} {index} has a coordinate that is not a finite number")]
    NonFiniteInput { what: &'static str, index: usize },
    /// More nodes than 32-bit indices can name.
    #[error("{found} master nodes are more than a search tree can name")]
    TooManyNodes { found: usize },
    /// The nearest nodes lie (nearly) on a line or a point, or are as thick as they are wide.
    #[error(
        "the {nodes} nearest nodes have no average plane: the two smallest principal moments are {smallest:e} and {middle:e} of the largest"
    )]
    NoAveragePlane { nodes: usize, smallest: f64, middle: f64 },
    /// The outward direction is zero or lies in the average plane.
    #[error(
        "the outward direction does not tell the sides of the plane apart: its cosine with the normal is {cosine:e}"
    )]
    AmbiguousOutward { cosine: f64 },
    /// No admitted number of nodes carries an admitted fit. `nodes` is the size of the largest set tried, `basis` the last one tried.
    /// `regularity` is the best [regularity](super::Neighbourhood::regularity) of all sets; it has to exceed `wanted`.
    #[error(
        "none of the sets of up to {nodes} nodes carries the {} fit and has an average plane and sound pivots: regularity {regularity:.1e} at best, wanted {wanted:.1e}",
        .basis.name()
    )]
    IllConditioned { nodes: usize, basis: Basis, regularity: f64, wanted: f64 },
    /// The search judges nodes for the built-in bases only.
    #[error(
        "no neighbours are sought for the basis \"{basis}\": ask for those of the quadratic or linear one"
    )]
    UnsupportedBasis { basis: &'static str },
    /// An option is outside its range.
    #[error("the option {name} must be {range}, not {value:?}")]
    InvalidOption { name: &'static str, range: &'static str, value: f64 },
    /// The numbers overflowed although the input was finite (coordinates beyond about 1e150).
    #[error("the search overflows: a {what} is not a finite number")]
    Overflow { what: &'static str },
}

impl NeighbourhoodError {
    /// Stable machine-readable code, the same as [`ElementError::code`] where the reason is the same.
    pub const fn code(&self) -> &'static str {
        match self {
            Self::NoCandidate { .. } => "no-candidate",
            Self::NeedsSurface => "needs-surface",
            Self::NonFiniteInput { .. } => "non-finite-input",
            Self::TooManyNodes { .. } => "too-many-nodes",
            Self::NoAveragePlane { .. } => "no-average-plane",
            Self::AmbiguousOutward { .. } => "ambiguous-outward",
            Self::IllConditioned { .. } => "ill-conditioned",
            Self::UnsupportedBasis { .. } | Self::InvalidOption { .. } => "invalid-option",
            Self::Overflow { .. } => "overflow",
        }
    }

    /// The reason why [`NearestNodes::new`](crate::pairing::NearestNodes::new) refused a set of nodes.
    pub const fn of_nodes(error: &ElementError) -> Self {
        match *error {
            ElementError::NonFiniteInput { what, index } => Self::NonFiniteInput { what, index },
            ElementError::TooManyNodes { found } => Self::TooManyNodes { found },
            _ => Self::Overflow { what: "master node" },
        }
    }

    /// The reason why `nodes` nodes have no frame.
    pub(super) fn of_plane(error: &ElementError, nodes: usize) -> Self {
        match *error {
            ElementError::NoAveragePlane { smallest, middle } => {
                Self::NoAveragePlane { nodes, smallest, middle }
            }
            ElementError::AmbiguousOutward { cosine } => Self::AmbiguousOutward { cosine },
            ElementError::NonFiniteInput { what, index } => Self::NonFiniteInput { what, index },
            _ => Self::Overflow { what: "average plane" },
        }
    }
}
