//! The neighbours of a slave node by convex hulls, section 5.1 of Chamoret, Rassineux and Bergheau (2008).
//!
//! Which master nodes surround a slave? Project the nearest ones on their average plane, put the origin at the
//! slave's projection, and invert: q → q/|q|². The nodes whose images lie on the boundary of the images' convex hull
//! are the first layer of neighbours; with these removed the next hull gives the second layer, and so on. The first
//! layer is the ring of nodes the slave would be joined to if it were inserted into the Delaunay triangulation of the
//! nodes. Unlike the nearest nodes, it reaches in every direction, however the mesh is stretched or graded.
//!
//! # What a search promises
//!
//! * **Well conditioned.** Layers are added until the [regularity](Neighbourhood::regularity) of the fit exceeds
//!   [`SearchOptions::smallest_regularity`], not until there are six nodes: on every structured mesh there are
//!   slaves whose first ring of 6 to 10 nodes lies on a conic. If no admitted set carries the quadratic basis the search may
//!   fall back to the linear one; [`Neighbourhood::fallback`] says so. Otherwise there is a [`NeighbourhoodError`].
//! * **Independent of rounding on regular grids.** Orientation tests are exact, and nodes within [`TOLERANCE`] of the
//!   hull's boundary belong to the layer. The eight nodes around a grid node form one layer although the
//!   diagonal ones lie on the edges of the hull of the others, for any rotation and position of the grid.
//! * **Independent of the order of the nodes**, as sets (for the hull rules; [`NeighbourRule::Nearest`] prefers the
//!   lower index among nodes equally far away).
//! * **Node on the slave.** A node whose in-plane distance is at most [`TOLERANCE`] times that of the farthest
//!   candidate is left out of the inversion and belongs to the set: [`Neighbourhood::at_slave`].
//! * **Coincident nodes** are all kept, in the same layer: each carries its share of the contact force.
//! * **Complete.** An edge of the hull is the image of an empty circle through the slave. If one of these circles
//!   leaves the disc that the candidates cover, a farther node might belong to the layer: the number of candidates is
//!   doubled, up to [`SearchOptions::max_candidates`] and as long as they lie near a plane.
//!   [`Neighbourhood::complete`] tells whether it was enough.
//! * **Border.** A slave on or beyond the border of the node cloud is not surrounded: the angle free of nodes is 180° or
//!   more, or less by at most 1e-3. The hull of the images does not hold the origin, and the Delaunay ring would be all
//!   border nodes in sight. A fictitious node then closes the ring, in the middle of the free angle and as far away as the
//!   third nearest node; it takes no further part. A slave on a border of a grid so gets the four or five nodes of the
//!   cells it touches.
//! * **Border that bows inward.** There the slave sees border nodes all around, the far ones under next to no angle. The
//!   ring counts as open where an empty circle is more than twice as wide as the farthest node of the layer is away and the
//!   angle free of all nodes is above 135°. Rings inside the nodes stay what they are, however stretched or irregular.
//!   A slave over a hole whose whole rim it sees is enclosed by the rim.
//! * **Far nodes.** Where a fictitious node closes the ring, a node farther than three times the median distance of its
//!   layer waits for a later one. No layer on a border of a square, graded or 3:1 grid has such a node. Inside the nodes
//!   there is no such bound: rings of stretched and stepped meshes reach far.
//! * **Enclosed.** [`Neighbourhood::encloses_slave`] is false on the border and beyond, [`Neighbourhood::on_border`] tells the
//!   two apart. Both look at the first layer: an angle free of nodes within 1e-3 of 180° is the border.
//!
//! Only positions count here. Nodes on the far face of a thin plate or around a sharp edge are kept out
//! by [`NeighbourSearch::find_among`].
//!
//! ```
//! use diffuse_contact::neighbourhood::{NeighbourSearch, SearchOptions};
//! use diffuse_contact::pairing::NearestNodes;
//! use diffuse_contact::{Backend, Basis, Generated, Mode, Weight};
//!
//! // A flat 9 × 9 grid of nodes and a slave 0.25 over one of them.
//! let grid = (0..81).map(|k| [f64::from(k % 9), f64::from(k / 9), 0.0]).collect();
//! let nodes = NearestNodes::new(grid)?;
//! let slave = [4.0, 4.0, 0.25];
//!
//! let mut search = NeighbourSearch::new(SearchOptions::default())?;
//! let found = search.find(&nodes, slave, [0.0, 0.0, 1.0])?;
//! assert_eq!(found.at_slave, [40]);
//! assert_eq!(found.layers[0], [30, 31, 32, 39, 41, 48, 49, 50]);
//! assert_eq!(found.basis, Basis::Quadratic);
//!
//! let pairing = found.pairing(&nodes, Weight::Cubic);
//! let gap = Generated.gap(&pairing.element(slave), Mode::Value)?;
//! assert!((gap.gap - 0.25).abs() < 1e-14);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod attempts;
mod candidates;
mod conditioning;
mod error;
mod hull;
mod inversion;
mod options;
mod search;

pub use error::NeighbourhoodError;
pub use options::{
    DEFAULT_CANDIDATES, MAX_CANDIDATES, MAX_LAYERS, NeighbourRule, Outward, SMALLEST_REGULARITY,
    SearchOptions,
};
pub use search::{NeighbourSearch, hull_layers};

pub(crate) use candidates::in_plane;
pub(crate) use conditioning::{regularity, weighted_regularity};

use crate::pairing::{NearestNodes, Pairing};
use crate::{Basis, Domains, Element, Frame, Point, Weight};

/// Relative tolerance of every geometric decision: a node this close to a hull's edge (over the distance of its
/// image from the origin), to the slave (over the distance of the farthest candidate) or to the distance of the last
/// candidate counts as on it.
///
/// Well above rounding, so that a grid of unit spacing a million units from the origin still is regular, and about
/// what mesh files of seven digits leave of a regular grid; well below any distortion that is meant.
pub const TOLERANCE: f64 = 1e-6;

/// What a search had to give up to find nodes that carry the fit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Fallback {
    /// Nothing: the basis and the number of layers or nodes asked for.
    #[default]
    None,
    /// More layers or nodes than asked for.
    Extended {
        /// How many more.
        by: usize,
    },
    /// The linear instead of the quadratic basis.
    Linear {
        /// Regularity of the quadratic fit, the best of all sets tried; 0 if there were never six nodes, or if domains of
        /// influence do not carry it.
        quadratic_regularity: f64,
    },
}

/// The master nodes of one slave node, and what follows from the choice.
#[derive(Clone, Debug, PartialEq)]
pub struct Neighbourhood {
    /// Nodes straight above or below the slave, in ascending order; they belong to no layer.
    pub at_slave: Vec<usize>,
    /// The layers, innermost first, each in ascending order. One layer for [`NeighbourRule::Nearest`].
    pub layers: Vec<Vec<usize>>,
    /// The nodes that take part, by in-plane distance from the slave: `at_slave`, the layers, and with
    /// [`NeighbourRule::HullRadius`] the other nodes inside the support radius.
    pub nodes: Vec<usize>,
    /// Radius of the domain of influence: [`SearchOptions::radius_factor`] × the in-plane distance of the farthest
    /// node, or of the farthest layer node with [`NeighbourRule::HullRadius`]. Measured in `frame`, but
    /// with [`NeighbourRule::HullRadius`] in `plane`.
    pub support_radius: f64,
    /// Polynomial basis that the nodes carry.
    pub basis: Basis,
    /// Average plane of `nodes`, n̂ outward: the frame of an element that moves with its masters.
    pub frame: Frame,
    /// Average plane of the candidates, in which the layers were found. An element that holds its frame may take this
    /// one: it does not move when a node enters or leaves.
    pub plane: Frame,
    /// How well the nodes carry the fit, from 0 (on one conic, or line) to 1, in `frame` and with the cubic weight.
    ///
    /// The smallest eigenvalue of the moment matrix (eq. 13) in coordinates in which the weighted nodes have unit
    /// second moments about the slave, its constant, linear and quadratic block each divided by their mean
    /// diagonal. It does not depend on rotation, size and uniform stretch of the mesh.
    pub regularity: f64,
    /// Condition number of the moment matrix of `basis` as it is: offsets divided by the support radius, cubic
    /// weight, `frame`. Stretched meshes have large ones. Infinite if the matrix is singular to rounding.
    pub condition: f64,
    /// Smallest pivot of the same matrix over the diagonal entry it came from, as a [`Backend`](crate::Backend)
    /// judges it.
    pub pivot_ratio: f64,
    /// Whether the nodes of the first layer surround the slave: the largest angle in which it sees none is below 180° by more
    /// than 1e-3. False on the border, and beyond it, where the fit extrapolates.
    pub encloses_slave: bool,
    /// Whether the slave lies on the border: that angle is 180° to 1e-3, or the slave is on a node that the others do not
    /// surround.
    pub on_border: bool,
    /// Whether the candidates sufficed to be sure of the layers. It cannot be so on the border of a cloud that has
    /// more than [`SearchOptions::max_candidates`] nodes.
    pub complete: bool,
    /// What had to be given up.
    pub fallback: Fallback,
}

/// How well the masters of an element carry its fit, from 0 to 1: [`Neighbourhood::regularity`] in the element's own frame and support
/// radius, or domains in the first configuration. Where it is below [`SMALLEST_REGULARITY`], no search would choose them, and derivatives
/// may be large. `None` for a basis of one's own.
pub fn element_regularity(element: &Element<'_>) -> Option<f64> {
    let Element { slave, masters, frame, support_radius, domains, basis, .. } = element;
    let offsets = masters.iter().map(|&master| in_plane(frame, *slave, master));
    let found = match domains {
        Domains::Material(nodes) => {
            let scaled = offsets.map(|offset| offset.map(|x| x / support_radius));
            weighted_regularity(nodes.iter().zip(scaled).map(|(node, [a, b])| (node.distance(), a, b)))
        }
        _ => regularity(offsets, *support_radius),
    };
    (!matches!(basis, Basis::Custom(_))).then(|| found.of(*basis))
}

impl Neighbourhood {
    /// The pairing of these nodes at their present positions. `nodes` is the cloud in which they were found.
    ///
    /// # Panics
    /// If `nodes` is another cloud with too few nodes.
    pub fn pairing(&self, nodes: &NearestNodes, weight: Weight) -> Pairing {
        let positions: Vec<Point> = self.nodes.iter().map(|&k| nodes.points()[k]).collect();
        Pairing {
            masters: self.nodes.clone(),
            others: Vec::new(),
            positions,
            frame: self.frame,
            support_radius: self.support_radius,
            material: Vec::new(),
            basis: self.basis,
            weight,
        }
    }
}
