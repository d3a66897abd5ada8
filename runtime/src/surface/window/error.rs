//! Why there is no window.

use crate::surface::SurfaceError;

/// Why numbers are no window, or windows do not go together.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum WindowError {
    /// A number is out of its range, or an order is not kept. `what` is what the number should be, `place` its place among those.
    #[error("{what} {place} of the window is none")]
    Invalid { what: &'static str, place: usize },
    /// There are no windows to be joined.
    #[error(
        "there is no window to join: of each owner of a part of the surface there has to be one, without facets if need be"
    )]
    None,
    /// Two windows have the same node or facet with other data: they are of different surfaces, or of different options.
    #[error("two windows differ in {what} {number}")]
    Differs { what: &'static str, number: u64 },
    /// A facet that slaves may be closest to has not all that it needs around it.
    #[error("facet {facet} of the window needs all facets at node {node}, and one of them is not there")]
    Incomplete { facet: u64, node: u64 },
    /// The facets are no surface; they are named by their place in the window.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// A box is none, or the skin is negative: a number of them is not finite, or a lowest corner is above the highest.
    #[error("box {place} is none, or the skin {skin:?} is negative or not finite")]
    InvalidBox { place: usize, skin: f64 },
    /// Extents said to be of the whole surface are not finite, or do not hold the own facets. `along` is `"x"`, `"y"`, `"z"`, or
    /// `"a facet"` for the largest extent of one, which begins with 0.
    #[error(
        "extents along {along}, {given:?}, are not finite, or do not hold those of the own facets, {own:?}"
    )]
    InvalidExtents { along: &'static str, given: [f64; 2], own: [f64; 2] },
    /// Windows are for slaves whose masters are found by domains of influence.
    #[error(
        "windows need the diffuse element with the neighbour rule \"domains\", not facets or another rule"
    )]
    NeedsDomains,
    /// A part of a surface was not wide enough around some of its facets.
    #[error(
        "the part of the surface does not reach far enough around {count} of its own facets, such as facet {facet}"
    )]
    TooNarrow { count: usize, facet: u64 },
}

impl WindowError {
    /// Stable machine-readable code.
    pub const fn code(&self) -> &'static str {
        match self {
            Self::Invalid { .. } | Self::None => "invalid-window",
            Self::Differs { .. } => "different-windows",
            Self::Incomplete { .. } => "incomplete-window",
            Self::Surface(error) => error.code(),
            Self::InvalidBox { .. } => "invalid-box",
            Self::InvalidExtents { .. } => "invalid-extents",
            Self::NeedsDomains => "window-needs-domains",
            Self::TooNarrow { .. } => "part-too-narrow",
        }
    }
}
