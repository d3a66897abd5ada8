//! What became of a slave node.

use crate::ElementError;
use crate::neighbourhood::{Fallback, NeighbourhoodError};

/// Whether a slave node has a contact element with a result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// It has: gap, foot and normal are finite numbers, and so are the derivatives asked for. Whether it
    /// touches is for the sign of the gap to say.
    Contact {
        /// What the neighbour search had to give up for it.
        fallback: Fallback,
    },
    /// It has none.
    None(NoContact),
}

/// Why a slave node has no contact.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum NoContact {
    /// No facet was found for the slave in the last refresh.
    #[error("no facet was found for the slave")]
    NotPaired,
    /// The closest facet is farther away than the distance limit. `distance` is infinite where that facet is not in the window that the
    /// slave knows.
    #[error("the closest facet is {distance:e} away, beyond the limit of {limit:e}")]
    TooFar { distance: f64, limit: f64 },
    /// The slave has a [window](crate::surface::window) of the surface only, and its result may depend on what is not in it: a ball that
    /// has to be known around the slave leaves the boxes of the window. Make a new one. `needed` is the ball's radius: the distance of the
    /// closest facet in the window, or the limit of the distance if that is smaller. It is infinite for an empty window without a limit.
    /// `known` is the radius of the ball that is known; it is negative outside of the boxes, and minus infinity where a node of the window
    /// has moved by more than its skin.
    #[error(
        "the surface has to be known within {needed:e} of the slave, but the window holds that within {known:e} only"
    )]
    BeyondWindow { needed: f64, known: f64 },
    /// No facet lies over the faces around the node, seen along their normals, within the limit; of a surface in contact with itself, none
    /// that the node may touch. Over faces the limit is the largest of those faces, length.
    #[error("no facet of the master lies over the faces around the node within its reach, {limit:e} at most")]
    NothingOver { limit: f64 },
    /// No set of master nodes on the slave's side of sharp edges carries a fit.
    #[error("no candidate: {reason}")]
    NoCandidate { reason: NeighbourhoodError },
    /// The foot lies beyond the border of the master surface, or beyond a sharp edge that ends the sheet. The same is said, at a
    /// refresh, of a slave that lies beyond it by more than a facet, and of one that lies beyond it and whose element has no result.
    /// `distance` is measured in the plane of the facet.
    #[error("the foot lies {distance:e} heights of a facet beyond the border, tolerance {tolerance:e}")]
    BeyondBorder { distance: f64, tolerance: f64 },
    /// The element has no result.
    #[error("{error}")]
    Element { error: ElementError },
}

impl Outcome {
    /// Whether there is a result.
    pub const fn is_contact(&self) -> bool {
        matches!(self, Self::Contact { .. })
    }

    /// Stable machine-readable code: `"contact"` or that of [`NoContact`].
    pub const fn code(&self) -> &'static str {
        match self {
            Self::Contact { .. } => "contact",
            Self::None(reason) => reason.code(),
        }
    }
}

impl NoContact {
    /// Stable machine-readable code; for [`Element`](Self::Element) that of the [`ElementError`].
    pub const fn code(&self) -> &'static str {
        match self {
            Self::NotPaired => "not-paired",
            Self::TooFar { .. } => "too-far",
            Self::BeyondWindow { .. } => "beyond-window",
            Self::NothingOver { .. } => "nothing-over",
            Self::NoCandidate { .. } => "no-candidate",
            Self::BeyondBorder { .. } => "beyond-border",
            Self::Element { error } => error.code(),
        }
    }
}

impl From<ElementError> for NoContact {
    fn from(error: ElementError) -> Self {
        Self::Element { error }
    }
}
