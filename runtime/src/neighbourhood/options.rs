//! Which nodes a search takes, and when it is content.

use super::NeighbourhoodError;
use crate::pairing::{DEFAULT_NEIGHBOURS, MAX_NEIGHBOURS, SUPPORT_RADIUS_FACTOR, outward};
use crate::with::with;
use crate::{Basis, Point};

/// Nodes a hull search starts from. On square grids and random clouds two complete layers are among the 48 nearest
/// nodes in all but a few per cent of cases; where they are not the search doubles the number.
pub const DEFAULT_CANDIDATES: usize = 48;
/// Nodes a hull search stops at: two doublings, enough for quadrilaterals 6:1 and for a step of 1:4 in mesh size.
pub const MAX_CANDIDATES: usize = 192;
/// Layers a search stops at. On the border of quadrilaterals 3:1 it takes four until three columns of nodes take part,
/// just beyond it five; nodes that carry no quadratic in six layers lie on two lines or another conic.
pub const MAX_LAYERS: usize = 6;
/// The regularity of the nodes has to exceed this.
///
/// An error in the heights of the nodes reaches the surface at the slave enlarged by about 0.6/√regularity: at this
/// bound by no more than seven. Two layers of a regular grid have 0.2 to 0.3, of a random cloud at least
/// 0.013, on the border or in a corner of a grid at least 0.014. A single ring has anything: on a random cloud half of
/// them pass, the others take a second layer. `study regularity` of the laboratory measures what other bounds gain and lose.
pub const SMALLEST_REGULARITY: f64 = 0.01;

/// Which nodes take part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum NeighbourRule {
    /// All nodes of the slave's sheet within whose domain of influence it lies. Domains belong to the nodes of a surface
    /// (`docs/equations.md`, \[T18\]): nothing else is chosen, so the gap does not jump. Only whole interfaces have
    /// it; a [`NeighbourSearch`](super::NeighbourSearch) in a cloud of nodes has none.
    Domains,
    /// The nodes of the first hull layers.
    HullLayers {
        /// How many to start with; `None` for as many as make the fit well conditioned, at least one.
        layers: Option<usize>,
        /// How many to stop at; raised to `layers` if it is below.
        max_layers: usize,
    },
    /// The hull layers set the support radius, and all nodes inside it take part: a node that comes into reach
    /// enters with weight zero. Those in the outermost tenth of the radius do not count for
    /// [`smallest_regularity`](SearchOptions::smallest_regularity).
    HullRadius {
        /// How many to start with; `None` for as many as make the fit well conditioned, at least one.
        layers: Option<usize>,
        /// How many to stop at; raised to `layers` if it is below.
        max_layers: usize,
    },
    /// The nearest nodes in Euclidean distance; of two at equal distance the one with the lower index.
    Nearest {
        /// How many to start with; raised to the size of the basis if it is below.
        count: usize,
        /// How many to stop at; raised to `count` if it is below.
        max_count: usize,
    },
}

impl NeighbourRule {
    /// [`HullLayers`](Self::HullLayers), up to [`MAX_LAYERS`].
    pub const fn hull_layers(layers: Option<usize>) -> Self {
        Self::HullLayers { layers, max_layers: MAX_LAYERS }
    }

    /// [`HullRadius`](Self::HullRadius), up to [`MAX_LAYERS`].
    pub const fn hull_radius(layers: Option<usize>) -> Self {
        Self::HullRadius { layers, max_layers: MAX_LAYERS }
    }

    /// [`Nearest`](Self::Nearest), up to [`MAX_NEIGHBOURS`].
    pub const fn nearest(count: usize) -> Self {
        Self::Nearest { count, max_count: MAX_NEIGHBOURS }
    }
}

impl Default for NeighbourRule {
    /// As many hull layers as make the fit well conditioned.
    fn default() -> Self {
        Self::hull_layers(None)
    }
}

/// How a search chooses.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SearchOptions {
    /// Which nodes take part.
    pub rule: NeighbourRule,
    /// Polynomial basis the nodes have to carry.
    pub basis: Basis,
    /// Whether the linear basis may stand in where no admitted set carries the quadratic one.
    pub linear_fallback: bool,
    /// The [regularity](super::Neighbourhood::regularity) of the nodes has to exceed this; at least 0 and below 1.
    pub smallest_regularity: f64,
    /// Support radius over the in-plane distance of the farthest node; above 1.
    pub radius_factor: f64,
    /// Nearest nodes among which hull layers are sought, at least 3.
    pub candidates: usize,
    /// Number up to which `candidates` is doubled while they do not determine the layers; raised to `candidates` if
    /// it is below.
    pub max_candidates: usize,
}

impl Default for SearchOptions {
    fn default() -> Self {
        Self {
            rule: NeighbourRule::default(),
            basis: Basis::Quadratic,
            linear_fallback: true,
            smallest_regularity: SMALLEST_REGULARITY,
            radius_factor: SUPPORT_RADIUS_FACTOR,
            candidates: DEFAULT_CANDIDATES,
            max_candidates: MAX_CANDIDATES,
        }
    }
}

impl SearchOptions {
    /// The default number of nearest nodes by [`NeighbourRule::Nearest`].
    pub fn nearest() -> Self {
        Self { rule: NeighbourRule::nearest(DEFAULT_NEIGHBOURS), ..Self::default() }
    }

    /// Nodal domains of influence, for interfaces.
    pub fn domains() -> Self {
        Self { rule: NeighbourRule::Domains, ..Self::default() }
    }

    with! {
        /// With this rule.
        with_rule(rule: NeighbourRule);
        /// With this basis.
        with_basis(basis: Basis);
        /// With the linear basis to fall back on or without.
        with_linear_fallback(linear_fallback: bool);
        /// With this bound of the regularity.
        with_smallest_regularity(smallest_regularity: f64);
        /// With this support radius over the distance of the farthest node.
        with_radius_factor(radius_factor: f64);
        /// With this number of nodes to start from.
        with_candidates(candidates: usize);
        /// With this number of nodes to stop at.
        with_max_candidates(max_candidates: usize);
    }

    /// Checks that every option is in its range.
    ///
    /// # Errors
    /// [`NeighbourhoodError::InvalidOption`], [`NeighbourhoodError::UnsupportedBasis`].
    pub fn check(&self) -> Result<(), NeighbourhoodError> {
        let invalid = |name, range, value| Err(NeighbourhoodError::InvalidOption { name, range, value });
        if let Basis::Custom(basis) = self.basis {
            return Err(NeighbourhoodError::UnsupportedBasis { basis: basis.name });
        }
        if !(0.0..1.0).contains(&self.smallest_regularity) {
            return invalid("smallest_regularity", "at least 0 and below 1", self.smallest_regularity);
        }
        if !(self.radius_factor > 1.0 && self.radius_factor.is_finite()) {
            return invalid("radius_factor", "above 1 and finite", self.radius_factor);
        }
        if self.candidates < 3 {
            return invalid("candidates", "at least 3", self.candidates as f64);
        }
        match self.rule {
            NeighbourRule::HullLayers { layers: Some(0), .. }
            | NeighbourRule::HullRadius { layers: Some(0), .. } => invalid("layers", "at least 1", 0.0),
            NeighbourRule::HullLayers { layers: None, max_layers: 0 }
            | NeighbourRule::HullRadius { layers: None, max_layers: 0 } => {
                invalid("max_layers", "at least 1", 0.0)
            }
            _ => Ok(()),
        }
    }
}

/// The side of the master surface from which it is touched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outward<'a> {
    /// One direction for all nodes.
    Direction(Point),
    /// The normals of all master nodes, see [`node_normals`](crate::pairing::node_normals); those of the nodes
    /// found are averaged.
    NodeNormals(&'a [Point]),
}

impl From<Point> for Outward<'_> {
    fn from(direction: Point) -> Self {
        Self::Direction(direction)
    }
}

impl Outward<'_> {
    /// The direction for these nodes.
    pub(super) fn of(&self, nodes: &[usize]) -> Point {
        match *self {
            Self::Direction(direction) => direction,
            Self::NodeNormals(normals) => outward(normals, nodes),
        }
    }

    /// Checks that there is one normal for each of the `masters` nodes, and that a direction is finite.
    pub(super) fn check(&self, masters: usize) -> Result<(), NeighbourhoodError> {
        match *self {
            Self::NodeNormals(normals) if normals.len() != masters => {
                Err(NeighbourhoodError::InvalidOption {
                    name: "number of node normals",
                    range: "the number of master nodes",
                    value: normals.len() as f64,
                })
            }
            Self::Direction(direction) if !direction.iter().all(|x| x.is_finite()) => {
                Err(NeighbourhoodError::NonFiniteInput { what: "outward", index: 0 })
            }
            _ => Ok(()),
        }
    }
}
