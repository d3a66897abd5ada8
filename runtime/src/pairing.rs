//! Pairing a slave node with its master nodes: the m nearest, the frame and the support radius they imply.
//!
//! A pairing is the data an [`Element`] holds fixed between updates. It is found in three steps: the master
//! nodes nearest to the slave in Euclidean distance ([`NearestNodes`]), their average plane turned to the
//! outward side of the facets around them ([`node_normals`], [`outward`]), and the support radius
//! ([`support_radius`]). On structured meshes the nearest 6 to 9 nodes often lie on one conic, which makes the
//! quadratic fit singular (a hexagon ring, a 2×k strip);
//! [`pair`] therefore starts from more nodes than the fit needs and adds further ones until it is regular.
//!
//! ```
//! use diffuse_contact::pairing::{NearestNodes, PairingRule, node_normals, pair};
//! use diffuse_contact::{Backend, Generated, Mode};
//!
//! // A flat 5 × 5 grid of nodes, its facets seen from above, and a slave 0.25 over it.
//! let masters: Vec<[f64; 3]> = (0..25).map(|k| [f64::from(k % 5), f64::from(k / 5), 0.0]).collect();
//! let facets: Vec<[usize; 4]> =
//!     (0..16).map(|k| k % 4 + 5 * (k / 4)).map(|k| [k, k + 1, k + 6, k + 5]).collect();
//! let normals = node_normals(&masters, &facets);
//! let nodes = NearestNodes::new(masters)?;
//!
//! let slave = [2.1, 1.8, 0.25];
//! let pairing = pair(&Generated, &nodes, &normals, slave, &PairingRule::default())?;
//! assert_eq!(pairing.masters[0], 12);
//! let gap = Generated.gap(&pairing.element(slave), Mode::Value)?;
//! assert!((gap.gap - 0.25).abs() < 1e-14);
//! # Ok::<(), diffuse_contact::ElementError>(())
//! ```

use rstar::RTree;
use rstar::primitives::GeomWithData;

use crate::vector::Vector3;
use crate::{Backend, Basis, Domains, Element, ElementError, Frame, MaterialNode, Mode, Point, Weight};

/// The support radius is this factor times the largest in-plane distance of a master node from the slave.
///
/// Above 1, so that the farthest node keeps some weight (10 % with the cubic weight) and the radius does not kink
/// the gap when the farthest node changes (see [`support_radius`]).
pub const SUPPORT_RADIUS_FACTOR: f64 = 1.25;
/// Master nodes a pairing starts from: twice what the quadratic fit needs.
pub const DEFAULT_NEIGHBOURS: usize = 12;
/// Master nodes beyond which [`pair`] no longer looks for a regular fit.
pub const MAX_NEIGHBOURS: usize = 24;

/// A pairing that sees its masters within 180° and this much more, in radians, lies beyond their border.
const BORDER_ANGLE: f64 = 0.05;
/// Closer to a master node than this fraction of the farthest, a point counts as on it.
const ON_NODE: f64 = 0.02;
/// Two distances closer than this, relatively, are compared again in one and the same arithmetic.
const DISTANCE_ROUNDING: f64 = 1e-12;

/// The master nodes in a tree, for searching the nearest ones.
#[derive(Debug)]
pub struct NearestNodes {
    points: Vec<Point>,
    tree: RTree<GeomWithData<Point, u32>>,
}

impl NearestNodes {
    /// Sorts the master nodes into a tree. Nodes are named by their index in `points`.
    ///
    /// # Errors
    /// [`ElementError::NonFiniteInput`] if a coordinate is NaN or infinite; [`ElementError::TooManyNodes`] if the tree
    /// cannot name all nodes.
    pub fn new(points: Vec<Point>) -> Result<Self, ElementError> {
        for (index, point) in points.iter().enumerate() {
            if !point.iter().all(|x| x.is_finite()) {
                return Err(ElementError::NonFiniteInput { what: "master", index });
            }
        }
        let count =
            u32::try_from(points.len()).map_err(|_| ElementError::TooManyNodes { found: points.len() })?;
        let named = points.iter().zip(0..count).map(|(&point, index)| GeomWithData::new(point, index));
        let tree = RTree::bulk_load(named.collect());
        Ok(Self { points, tree })
    }

    /// The master nodes, in the order given.
    #[must_use]
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// The `m` master nodes nearest to `slave` in Euclidean distance, nearest first; of two at equal distance the
    /// one with the lower index comes first. All of them if there are no more than `m`. Nodes that coincide are
    /// all kept: each carries its own share of the contact force.
    ///
    /// ```
    /// use diffuse_contact::pairing::NearestNodes;
    ///
    /// let nodes = NearestNodes::new(vec![[3.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])?;
    /// assert_eq!(nodes.masters([0.0; 3], 2), [1, 2]);
    /// # Ok::<(), diffuse_contact::ElementError>(())
    /// ```
    #[must_use]
    pub fn masters(&self, slave: Point, m: usize) -> Vec<usize> {
        let mut found = self.candidates(slave, m);
        found.sort_by(|&i, &j| {
            let distance = |k: usize| squared_distance(self.points[k], slave);
            distance(i).total_cmp(&distance(j)).then(i.cmp(&j))
        });
        found.truncate(m);
        found
    }

    /// A set that contains the `m` nearest nodes and every node as near as the last of them, in any order.
    fn candidates(&self, slave: Point, m: usize) -> Vec<usize> {
        if m >= self.points.len() || !slave.iter().all(|x| x.is_finite()) {
            return (0..self.points.len()).collect();
        }
        let mut found = Vec::with_capacity(m);
        let mut farthest = f64::NEG_INFINITY;
        for (node, square) in self.tree.nearest_neighbor_iter_with_distance_2(slave) {
            if found.len() < m {
                farthest = square * (1.0 + DISTANCE_ROUNDING);
            } else if square > farthest {
                break;
            }
            found.push(node.data as usize);
        }
        found
    }
}

/// How [`pair`] chooses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct PairingRule {
    /// Number of nearest master nodes to start from; raised to the basis's size if it is below.
    pub neighbours: usize,
    /// Number of nearest master nodes to stop at; raised to `neighbours` if it is below.
    pub max_neighbours: usize,
    /// Polynomial basis of the fit.
    pub basis: Basis,
    /// Weight function of the fit.
    pub weight: Weight,
}

impl Default for PairingRule {
    /// [`DEFAULT_NEIGHBOURS`] to [`MAX_NEIGHBOURS`] nodes, quadratic basis, cubic weight.
    fn default() -> Self {
        Self {
            neighbours: DEFAULT_NEIGHBOURS,
            max_neighbours: MAX_NEIGHBOURS,
            basis: Basis::Quadratic,
            weight: Weight::default(),
        }
    }
}

impl PairingRule {
    /// With this number of nodes to start from.
    #[must_use]
    pub const fn with_neighbours(self, neighbours: usize) -> Self {
        Self { neighbours, ..self }
    }

    /// With this number of nodes to stop at.
    #[must_use]
    pub const fn with_max_neighbours(self, max_neighbours: usize) -> Self {
        Self { max_neighbours, ..self }
    }

    /// With this basis.
    #[must_use]
    pub const fn with_basis(self, basis: Basis) -> Self {
        Self { basis, ..self }
    }

    /// With this weight function.
    #[must_use]
    pub const fn with_weight(self, weight: Weight) -> Self {
        Self { weight, ..self }
    }
}

/// The master nodes of one slave node and all that stays fixed with them.
#[derive(Clone, Debug, PartialEq)]
pub struct Pairing {
    /// Indices of the master nodes, nearest first.
    pub masters: Vec<usize>,
    /// Their positions when they were paired.
    pub positions: Vec<Point>,
    /// Average plane of the masters, n̂ outward.
    pub frame: Frame,
    /// Radius of the domain of influence.
    pub support_radius: f64,
    /// Where the masters are in the first configuration, with their domains there; none: all have the support radius.
    pub material: Vec<MaterialNode>,
    /// Polynomial basis of the fit.
    pub basis: Basis,
    /// Weight function of the fit.
    pub weight: Weight,
}

impl Pairing {
    /// The element of this pairing with the slave at `slave`.
    #[must_use]
    pub fn element(&self, slave: Point) -> Element<'_> {
        let domains =
            if self.material.is_empty() { Domains::Shared } else { Domains::Material(&self.material) };
        Element::new(slave, &self.positions, self.frame, self.support_radius)
            .with_domains(domains)
            .with_basis(self.basis)
            .with_weight(self.weight)
    }

    /// Whether `point` lies beyond the border of the masters, where the fit extrapolates and there is no contact.
    ///
    /// Seen from the point, in the plane of the frame, the masters then leave free an angle of more than 180° and
    /// a tolerance of 3°. A point on a master node (to 2 % of the farthest distance) is not beyond the border.
    #[must_use]
    pub fn is_beyond_border(&self, point: Point) -> bool {
        let offsets: Vec<[f64; 2]> =
            self.positions.iter().map(|&x| in_plane_offset(&self.frame, point, x)).collect();
        let length = |offset: &[f64; 2]| offset[0].hypot(offset[1]);
        let farthest = offsets.iter().map(length).fold(0.0, f64::max);
        if offsets.iter().any(|offset| length(offset) <= ON_NODE * farthest) {
            return false;
        }
        let mut angles: Vec<f64> = offsets.iter().map(|[a, b]| b.atan2(*a)).collect();
        angles.sort_by(f64::total_cmp);
        let (Some(first), Some(last)) = (angles.first(), angles.last()) else { return true };
        let around = first + std::f64::consts::TAU - last;
        let free = angles.windows(2).map(|pair| pair[1] - pair[0]).fold(around, f64::max);
        free > std::f64::consts::PI + BORDER_ANGLE
    }
}

/// Pairs a slave node with the nearest master nodes for which the fit is regular.
///
/// Starts from `rule.neighbours` nodes and adds the next nearest one by one, up to `rule.max_neighbours`, while the
/// nodes have no average plane or `backend` finds the fit singular. `normals` are those of the master nodes, see
/// [`node_normals`].
///
/// # Errors
/// [`ElementError::TooFewNodes`] if there are fewer master nodes than the basis needs; the last reason met if no
/// admissible number of nodes makes the fit regular; any other [`ElementError`] as soon as it occurs.
pub fn pair<B: Backend + ?Sized>(
    backend: &B,
    nodes: &NearestNodes,
    normals: &[Point],
    slave: Point,
    rule: &PairingRule,
) -> Result<Pairing, ElementError> {
    let needed = rule.basis.size();
    let fewest = rule.neighbours.max(needed);
    let nearest = nodes.masters(slave, rule.max_neighbours.max(fewest));
    if nearest.len() < needed {
        return Err(ElementError::TooFewNodes { found: nearest.len(), needed });
    }
    let mut count = fewest.min(nearest.len());
    loop {
        match pair_with(backend, nodes, normals, slave, &nearest[..count], rule) {
            Err(ElementError::SingularFit { .. } | ElementError::NoAveragePlane { .. })
                if count < nearest.len() =>
            {
                count += 1;
            }
            outcome => return outcome,
        }
    }
}

/// The pairing with exactly these masters, if its fit is regular.
fn pair_with<B: Backend + ?Sized>(
    backend: &B,
    nodes: &NearestNodes,
    normals: &[Point],
    slave: Point,
    masters: &[usize],
    rule: &PairingRule,
) -> Result<Pairing, ElementError> {
    let positions: Vec<Point> = masters.iter().map(|&k| nodes.points[k]).collect();
    let frame = Frame::average_plane(&positions, outward(normals, masters))?;
    let support_radius = support_radius(&frame, slave, &positions);
    let pairing = Pairing {
        masters: masters.to_vec(),
        positions,
        frame,
        support_radius,
        material: Vec::new(),
        basis: rule.basis,
        weight: rule.weight,
    };
    backend.coefficients(&pairing.element(slave), Mode::Value)?;
    Ok(pairing)
}

/// Default support radius: [`SUPPORT_RADIUS_FACTOR`] × the largest in-plane distance of a master from the slave.
///
/// 0 if all masters lie straight above or below the slave, which no element accepts.
#[must_use]
pub fn support_radius(frame: &Frame, slave: Point, masters: &[Point]) -> f64 {
    let farthest = masters
        .iter()
        .map(|&x| in_plane_offset(frame, slave, x))
        .map(|[a, b]| a.hypot(b))
        .fold(0.0, f64::max);
    SUPPORT_RADIUS_FACTOR * farthest
}

/// Outward normals of the master nodes: the sum of the area vectors of the facets at each node, not normalised.
///
/// `facets` are closed polygons of indices into `points`, counter-clockwise seen from outside; only corner nodes
/// are expected. Nodes of no facet get a zero vector.
///
/// # Panics
/// If a facet names a node that is not in `points`.
#[must_use]
pub fn node_normals<F: AsRef<[usize]>>(points: &[Point], facets: &[F]) -> Vec<Point> {
    let mut normals = vec![Vector3::zeros(); points.len()];
    for facet in facets {
        let facet = facet.as_ref();
        let Some(&first) = facet.first() else { continue };
        let corner = |k: usize| Vector3::from(points[k]) - Vector3::from(points[first]);
        let area: Vector3 = facet.windows(2).map(|edge| corner(edge[0]).cross(&corner(edge[1]))).sum();
        for &node in facet {
            normals[node] += area * 0.5;
        }
    }
    normals.into_iter().map(Point::from).collect()
}

/// Outward direction for a set of masters: the mean of their [`node_normals`], each scaled to the same length so
/// that a few large facets do not outweigh the others.
#[must_use]
pub fn outward(normals: &[Point], masters: &[usize]) -> Point {
    masters.iter().filter_map(|&k| Vector3::from(normals[k]).try_normalize()).sum::<Vector3>().into()
}

/// Components of `point − from` along t1 and t2.
fn in_plane_offset(frame: &Frame, from: Point, point: Point) -> [f64; 2] {
    let offset = Vector3::from(point) - Vector3::from(from);
    [frame.t1, frame.t2].map(|axis| offset.dot(&Vector3::from(axis)))
}

/// Square of the Euclidean distance.
fn squared_distance(a: Point, b: Point) -> f64 {
    (Vector3::from(a) - Vector3::from(b)).norm_squared()
}
