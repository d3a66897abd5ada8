//! Why a set of facets is no surface.

/// Every reason for which facets and positions are refused. Facets and nodes are named by the caller's indices.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// No facet at all.
    #[error("the surface has no facets")]
    Empty,
    /// More nodes, facets or edges than 32-bit indices can name.
    #[error("{count} {what} are more than 32-bit indices can name")]
    TooMany {
        /// `"nodes"` or `"facets"`.
        what: &'static str,
        /// How many there are.
        count: usize,
    },
    /// A corner is not among the positions.
    #[error("facet {facet} has node {node} for a corner, but there are {count} positions")]
    NodeOutOfRange {
        /// The facet.
        facet: usize,
        /// Its corner.
        node: usize,
        /// Number of positions.
        count: usize,
    },
    /// A facet names a node twice.
    #[error("facet {facet} has node {node} for two of its corners")]
    RepeatedNode {
        /// The facet.
        facet: usize,
        /// The corner named twice.
        node: usize,
    },
    /// A coordinate is NaN or infinite, or beyond ±10⁷⁵, where areas squared overflow.
    #[error("node {node} has a coordinate that is not a finite number below 1e75: {value}")]
    NonFinitePosition {
        /// The node.
        node: usize,
        /// The coordinate.
        value: f64,
    },
    /// The corners of a quadrilateral are not in cyclic order: its outline crosses itself.
    #[error(
        "the outline of facet {facet} crosses itself: give its corners in cyclic order, such as {order:?} or the reverse, whichever \
         faces outwards"
    )]
    NotCyclic {
        /// The facet.
        facet: usize,
        /// Its corners in an order in which it is convex.
        order: [usize; 4],
    },
    /// The corners of a facet lie on a line or a point.
    #[error("facet {facet} has no area: {area:e} of the square of its extent {extent:e}")]
    NoArea {
        /// The facet.
        facet: usize,
        /// Area over the square of the extent.
        area: f64,
        /// Largest coordinate difference between corners, length.
        extent: f64,
    },
    /// A quadrilateral has a corner that points inwards or is straight: its normal turns over somewhere on it.
    #[error(
        "facet {facet} is not convex: the sine at its corner {corner} (node {node}) is {sine:e}, seen along its normal; mend it or split it into triangles"
    )]
    NotConvex {
        /// The facet.
        facet: usize,
        /// The worst corner, 0 to 3.
        corner: usize,
        /// The node there.
        node: usize,
        /// Area spanned by the two edges at the corner, in the facet's middle plane, over the product of their lengths.
        sine: f64,
    },
    /// More than two facets meet in one edge.
    #[error("facets {facets:?}, and perhaps more, share the edge between nodes {nodes:?}")]
    BranchingEdge {
        /// The ends of the edge.
        nodes: [usize; 2],
        /// Three of the facets.
        facets: [usize; 3],
    },
    /// Two facets run through their common edge in the same direction: one of them shows its inside.
    #[error("facets {facets:?} run through the edge from node {} to node {} in the same direction: one is flipped, or there twice", nodes[0], nodes[1])]
    InconsistentOrientation {
        /// The facets.
        facets: [usize; 2],
        /// The ends of the edge in that direction.
        nodes: [usize; 2],
    },
    /// Too few positions for the nodes of the surface.
    #[error("{found} positions, but the surface needs {needed}")]
    TooFewPositions {
        /// Number of positions given.
        found: usize,
        /// The highest index of a corner, plus 1.
        needed: usize,
    },
    /// A symmetry plane's normal is no unit vector, or its point is not finite.
    #[error(
        "symmetry plane {plane} has a normal of length {length}, not a unit vector, or a point that is not finite"
    )]
    InvalidSymmetry {
        /// The plane, counted from 0.
        plane: usize,
        /// Length of its normal.
        length: f64,
    },
    /// Symmetry planes have too many images near the surface.
    #[error(
        "the symmetry planes have more than {images} images within {reach:e} of the surface: planes have to be parallel or at 180 degrees \
         over a whole number, and parallel ones no nearer to one another than a thirtieth of the largest facet"
    )]
    TooManyImages {
        /// Images found before the search was given up.
        images: usize,
        /// How far from the surface they are looked for, length: eight of its largest facets.
        reach: f64,
    },
    /// The surface lies on both sides of a symmetry plane.
    #[error(
        "the surface reaches from {low:e} to {high:e} across symmetry plane {plane}: it has to lie on one side of it"
    )]
    CutBySymmetry {
        /// The plane, counted from 0.
        plane: usize,
        /// Lowest height of a node over the plane, length.
        low: f64,
        /// Highest height, length.
        high: f64,
    },
}

impl SurfaceError {
    /// Stable machine-readable code.
    #[must_use]
    pub const fn code(&self) -> &'static str {
        match self {
            Self::Empty => "empty-surface",
            Self::TooMany { .. } => "too-many",
            Self::NodeOutOfRange { .. } => "node-out-of-range",
            Self::RepeatedNode { .. } => "repeated-node",
            Self::NonFinitePosition { .. } => "non-finite-position",
            Self::NotCyclic { .. } => "not-cyclic",
            Self::NoArea { .. } => "no-area",
            Self::NotConvex { .. } => "not-convex",
            Self::BranchingEdge { .. } => "branching-edge",
            Self::InconsistentOrientation { .. } => "inconsistent-orientation",
            Self::TooFewPositions { .. } => "too-few-positions",
            Self::InvalidSymmetry { .. } => "invalid-symmetry",
            Self::TooManyImages { .. } => "too-many-images",
            Self::CutBySymmetry { .. } => "cut-by-symmetry",
        }
    }
}
