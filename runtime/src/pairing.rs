//! A slave node's master nodes and what stays fixed with them, and what finds these: the nearest nodes ([`NearestNodes`]), the outward side
//! of the facets around them ([`node_normals`], [`outward`]), the support radius ([`support_radius`]).
//!
//! [`neighbourhood`](crate::neighbourhood) pairs with them.

use rstar::RTree;
use rstar::primitives::GeomWithData;

use crate::neighbourhood::in_plane;
use crate::vector::{Vector3, squared_distance};
use crate::{Basis, Domains, Element, ElementError, Frame, MaterialNode, Point, Weight};

/// The support radius is this factor times the largest in-plane distance of a master node from the slave.
///
/// Above 1, so that the farthest node keeps some weight (10 % with the cubic weight) and the radius does not kink
/// the gap when the farthest node changes (see [`support_radius`]).
pub const SUPPORT_RADIUS_FACTOR: f64 = 1.25;
/// Master nodes a pairing starts from: twice what the quadratic fit needs.
pub const DEFAULT_NEIGHBOURS: usize = 12;
/// Master nodes beyond which no search looks for a regular fit.
pub const MAX_NEIGHBOURS: usize = 24;

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
        ElementError::check_points("master", &points)?;
        let count =
            u32::try_from(points.len()).map_err(|_| ElementError::TooManyNodes { found: points.len() })?;
        let named = points.iter().zip(0..count).map(|(&point, index)| GeomWithData::new(point, index));
        let tree = RTree::bulk_load(named.collect());
        Ok(Self { points, tree })
    }

    /// The master nodes, in the order given.
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

/// The master nodes of one slave node and all that stays fixed with them.
#[derive(Clone, Debug, PartialEq)]
pub struct Pairing {
    /// Indices of the master nodes, nearest first.
    pub masters: Vec<usize>,
    /// Of an auxiliary point, which lies on the line through its master node and another one, that one and its part of the point; of others
    /// the master node itself and 0. Empty if all points are nodes, or images of nodes.
    pub others: Vec<(usize, f64)>,
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
    pub fn element(&self, slave: Point) -> Element<'_> {
        let domains =
            if self.material.is_empty() { Domains::Shared } else { Domains::Material(&self.material) };
        Element::new(slave, &self.positions, self.frame, self.support_radius)
            .with_domains(domains)
            .with_basis(self.basis)
            .with_weight(self.weight)
    }
}

/// Default support radius: [`SUPPORT_RADIUS_FACTOR`] × the largest in-plane distance of a master from the slave.
///
/// 0 if all masters lie straight above or below the slave, which no element accepts.
pub fn support_radius(frame: &Frame, slave: Point, masters: &[Point]) -> f64 {
    let farthest =
        masters.iter().map(|&x| in_plane(frame, slave, x)).map(|[a, b]| a.hypot(b)).fold(0.0, f64::max);
    SUPPORT_RADIUS_FACTOR * farthest
}

/// Outward normals of the master nodes: the sum of the area vectors of the facets at each node, not normalised.
///
/// `facets` are closed polygons of indices into `points`, counter-clockwise seen from outside; only corner nodes
/// are expected. Nodes of no facet get a zero vector.
///
/// # Panics
/// If a facet names a node that is not in `points`.
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
pub fn outward(normals: &[Point], masters: &[usize]) -> Point {
    masters.iter().filter_map(|&k| Vector3::from(normals[k]).try_normalize()).sum::<Vector3>().into()
}
