//! Why a slave has no neighbourhood.

use crate::{Basis, ElementError};

/// Every reason for which a search yields no nodes. Each carries the figures that led to it.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NeighbourhoodError {
    /// Fewer nodes than the smallest fit needs: no contact candidate.
    #[error("{found} master nodes within reach, but even the linear basis needs {needed}")]
    NoCandidate {
        /// Number of nodes found.
        found: usize,
        /// Number of nodes the smallest admitted fit needs.
        needed: usize,
    },
    /// Domains of influence belong to a surface, not to a cloud of nodes.
    #[error(
        "domains of influence belong to the nodes of a surface: a search in a cloud of nodes needs another rule"
    )]
    NeedsSurface,
    /// A coordinate is NaN or infinite.
    #[error("{what} {index} has a coordinate that is not a finite number")]
    NonFiniteInput {
        /// `"slave"`, `"master"` or `"outward"`.
        what: &'static str,
        /// Which one, counted from 0.
        index: usize,
    },
    /// More nodes than 32-bit indices can name.
    #[error("{found} master nodes are more than a search tree can name")]
    TooManyNodes {
        /// Number of nodes given.
        found: usize,
    },
    /// The nearest nodes lie (nearly) on a line or a point, or are as thick as they are wide.
    #[error(
        "the {nodes} nearest nodes have no average plane: the two smallest principal moments are {smallest:e} and {middle:e} of the largest"
    )]
    NoAveragePlane {
        /// Number of nodes.
        nodes: usize,
        /// Smallest principal moment over the largest.
        smallest: f64,
        /// Middle principal moment over the largest.
        middle: f64,
    },
    /// The outward direction is zero or lies in the average plane.
    #[error(
        "the outward direction does not tell the sides of the plane apart: its cosine with the normal is {cosine:e}"
    )]
    AmbiguousOutward {
        /// Cosine of the angle between the outward direction and the plane's normal.
        cosine: f64,
    },
    /// No admitted number of nodes carries an admitted fit.
    #[error(
        "none of the sets of up to {nodes} nodes carries the {} fit and has an average plane and sound pivots: regularity {regularity:.1e} at best, wanted {wanted:.1e}",
        .basis.name()
    )]
    IllConditioned {
        /// Number of nodes in the largest set tried.
        nodes: usize,
        /// The last basis tried.
        basis: Basis,
        /// Its [regularity](super::Neighbourhood::regularity), the best of all sets tried.
        regularity: f64,
        /// The bound it has to exceed.
        wanted: f64,
    },
    /// The search judges nodes for the built-in bases only.
    #[error(
        "no neighbours are sought for the basis \"{basis}\": ask for those of the quadratic or linear one"
    )]
    UnsupportedBasis {
        /// Name of the basis.
        basis: &'static str,
    },
    /// An option is outside its range.
    #[error("the option {name} must be {range}, not {value}")]
    InvalidOption {
        /// Name of the option.
        name: &'static str,
        /// What it may be.
        range: &'static str,
        /// What it was.
        value: f64,
    },
    /// The numbers overflowed although the input was finite (coordinates beyond about 1e150).
    #[error("the search overflows: a {what} is not a finite number")]
    Overflow {
        /// What was not finite.
        what: &'static str,
    },
}

impl NeighbourhoodError {
    /// Stable machine-readable code, the same as [`ElementError::code`] where the reason is the same.
    #[must_use]
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
    #[must_use]
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
