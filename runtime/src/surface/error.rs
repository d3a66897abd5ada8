//! Why a set of facets is no surface.

/// Every reason for which facets and positions are refused. Facets and nodes are named by the caller's indices, symmetry planes from 0.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum SurfaceError {
    /// No facet at all.
    #[error("the surface has no facets")]
    Empty,
    /// More nodes, facets or edges than 32-bit indices can name.
    #[error("{count} {what} are more than 32-bit indices can name")]
    TooMany { what: &'static str, count: usize },
    /// A corner is not among the positions.
    #[error("facet {facet} has node {node} for a corner, but there are {count} positions")]
    NodeOutOfRange { facet: usize, node: usize, count: usize },
    /// A facet names a node twice.
    #[error("facet {facet} has node {node} for two of its corners")]
    RepeatedNode { facet: usize, node: usize },
    /// A coordinate is NaN or infinite, or beyond ±10⁷⁵, where areas squared overflow.
    #[error("node {node} has a coordinate that is not a finite number below 1e75: {value:?}")]
    NonFinitePosition { node: usize, value: f64 },
    /// The corners of a quadrilateral are not in cyclic order: its outline crosses itself. The facet is convex in the `order` given.
    #[error(
        "the outline of facet {facet} crosses itself: give its corners in cyclic order, such as {order:?} or the reverse, whichever \
         faces outwards"
    )]
    NotCyclic { facet: usize, order: [usize; 4] },
    /// The corners of a facet lie on a line or a point. `extent` is the longest edge.
    #[error("facet {facet} has no area: {area:e} of the square of its extent {extent:e}")]
    NoArea { facet: usize, area: f64, extent: f64 },
    /// A quadrilateral has a corner that points inwards or is straight: its normal turns over somewhere on it. The worst corner is named,
    /// from 0 to 3. Its `sine` is the area spanned by its two edges, in the facet's middle plane, over the product of their lengths.
    #[error(
        "facet {facet} is not convex: the sine at its corner {corner} (node {node}) is {sine:e}, seen along its normal; mend it or split it into triangles"
    )]
    NotConvex { facet: usize, corner: usize, node: usize, sine: f64 },
    /// More than two facets meet in one edge. `facets` are three of them.
    #[error("facets {facets:?}, and perhaps more, share the edge between nodes {nodes:?}")]
    BranchingEdge { nodes: [usize; 2], facets: [usize; 3] },
    /// Two facets run through their common edge in the same direction: one of them shows its inside.
    #[error("facets {facets:?} run through the edge from node {} to node {} in the same direction: one is flipped, or there twice", nodes[0], nodes[1])]
    InconsistentOrientation { facets: [usize; 2], nodes: [usize; 2] },
    /// Too few positions for the nodes of the surface. `needed` is the highest index of a corner, plus 1.
    #[error("{found} positions, but the surface needs {needed}")]
    TooFewPositions { found: usize, needed: usize },
    /// A symmetry plane's normal is no unit vector, or its point is not finite.
    #[error(
        "symmetry plane {plane} has a normal of length {length:?}, not a unit vector, or a point that is not finite"
    )]
    InvalidSymmetry { plane: usize, length: f64 },
    /// Two symmetry planes meet at an angle in the surface at which their images do not fill all round.
    #[error(
        "symmetry planes {} and {} meet at {degrees} degrees on the side of the surface: it has to be 180 degrees over a whole number, or they \
         are parallel", planes[0], planes[1]
    )]
    SymmetryAngle { planes: [usize; 2], degrees: f64 },
    /// Symmetry planes have too many images near the surface. `images` were found before the search was given up; `reach` is the length of
    /// eight of the largest facets.
    #[error(
        "the symmetry planes have more than {images} images within {reach:e} of the surface: parallel ones may be no nearer to one another \
         than a thirtieth of the largest facet, and those at an angle may need normals of more digits"
    )]
    TooManyImages { images: usize, reach: f64 },
    /// The surface lies on both sides of a symmetry plane, by more than 1 % of the smallest facet at a node on either side.
    #[error(
        "the surface reaches from {low:e} to {high:e} across symmetry plane {plane}: it has to lie on one side of it"
    )]
    CutBySymmetry { plane: usize, low: f64, high: f64 },
}

impl SurfaceError {
    /// Stable machine-readable code.
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
            Self::SymmetryAngle { .. } => "invalid-symmetry-angle",
            Self::TooManyImages { .. } => "too-many-images",
            Self::CutBySymmetry { .. } => "cut-by-symmetry",
        }
    }
}
