//! The nearest master nodes and their offsets from the slave in their average plane.

use crate::vector::Vector3;

use super::hull::Point2;
use super::{NeighbourhoodError, Outward, TOLERANCE};
use crate::pairing::NearestNodes;
use crate::{Frame, Point};

/// Nodes asked of the tree beyond those wanted, so that ties at the last place are seen.
const TIE_MARGIN: usize = 8;
/// Nodes looked at for each candidate wanted, when most are not admitted or all are equally far.
const SCAN_FACTOR: usize = 16;

/// A slave, the cloud of master nodes, and which of them may take part.
#[derive(Clone, Copy)]
pub struct Query<'a, F> {
    pub nodes: &'a NearestNodes,
    pub slave: Point,
    pub outward: Outward<'a>,
    pub admits: F,
}

/// Candidates of one slave, nearest first.
#[derive(Clone, Debug, Default)]
pub struct Candidates {
    /// Their indices in the cloud.
    pub nodes: Vec<usize>,
    /// Their positions.
    pub positions: Vec<Point>,
    /// Euclidean distance from the slave below which there is no other admitted node; infinite if there is none.
    beyond: f64,
}

impl Candidates {
    /// The `wanted` nearest admitted nodes, and those as far as the last of them to the tolerance: which nodes are
    /// candidates must not depend on the order of the nodes nor, on a regular grid, on rounding.
    pub fn gather<F: Fn(usize) -> bool>(&mut self, query: &Query<'_, F>, wanted: usize) {
        let points = query.nodes.points();
        let slave = Vector3::from(query.slave);
        let distance = |k: usize| (Vector3::from(points[k]) - slave).norm();
        let most = wanted.saturating_mul(SCAN_FACTOR);
        let mut asked = wanted.saturating_add(TIE_MARGIN);
        loop {
            self.nodes.clear();
            let mut nearest = query.nodes.masters(query.slave, asked);
            let last = nearest.last().map_or(0.0, |&k| distance(k));
            let all = nearest.len() == points.len();
            nearest.retain(|&k| (query.admits)(k));
            self.nodes = nearest;
            self.beyond = if all { f64::INFINITY } else { last };
            let cut = match wanted.checked_sub(1).and_then(|k| self.nodes.get(k)) {
                Some(&k) => distance(k) * (1.0 + TOLERANCE),
                None => f64::INFINITY,
            };
            if let Some(excluded) = (wanted..self.nodes.len()).find(|&k| distance(self.nodes[k]) > cut) {
                self.beyond = distance(self.nodes[excluded]);
                self.nodes.truncate(excluded);
                break;
            }
            if all || asked >= most {
                break;
            }
            asked = asked.saturating_mul(2);
        }
        self.positions.clear();
        self.positions.extend(self.nodes.iter().map(|&k| points[k]));
    }

    /// Whether every admitted node of the cloud is a candidate.
    pub const fn are_all(&self) -> bool {
        self.beyond == f64::INFINITY
    }

    /// Indices in the cloud of some of them, in ascending order.
    pub fn sorted_nodes(&self, candidates: &[usize]) -> Vec<usize> {
        let mut nodes: Vec<usize> = candidates.iter().map(|&k| self.nodes[k]).collect();
        nodes.sort_unstable();
        nodes
    }
}

/// Offsets of candidates in their average plane, divided by the largest of them.
#[derive(Clone, Debug)]
pub struct Projection {
    /// The average plane of the candidates.
    pub plane: Frame,
    /// Largest in-plane distance from the slave.
    pub scale: f64,
    /// Difference of the candidates' heights over the largest in-plane distance; infinite if the plane does not face outward.
    pub steepness: f64,
    /// In-plane distance from the slave, divided by the scale, below which there is no other admitted node, provided
    /// that those others are no higher over or deeper under the slave than the candidates.
    pub reach: f64,
}

/// Cosine between outward and the normal of a plane below which it is no plane of the surface at the slave: that of the nodes of a
/// narrow strip that bends is normal to the strip's width.
const FACING: f64 = 0.5;

impl Projection {
    /// Projects the candidates; their offsets go to `offsets`.
    pub fn new<F>(
        query: &Query<'_, F>,
        candidates: &Candidates,
        offsets: &mut Vec<Point2>,
    ) -> Result<Self, NeighbourhoodError> {
        let plane = average_plane(query, &candidates.nodes, &candidates.positions)?;
        let mut heights = [f64::INFINITY, f64::NEG_INFINITY];
        offsets.clear();
        for &position in &candidates.positions {
            let [a, b, z] = local_offset(&plane, query.slave, position);
            heights = [heights[0].min(z), heights[1].max(z)];
            offsets.push([a, b]);
        }
        let scale = offsets.iter().map(|[a, b]| a.hypot(*b)).fold(0.0, f64::max);
        // Squares of what follows must not underflow.
        if !(scale > f64::MIN_POSITIVE.sqrt() && scale.is_finite()) {
            return Err(NeighbourhoodError::Overflow { what: "in-plane distance" });
        }
        for offset in offsets.iter_mut() {
            *offset = offset.map(|x| x / scale);
        }
        let [lowest, highest] = heights;
        let height = lowest.abs().max(highest.abs()) / scale;
        let beyond = candidates.beyond / scale;
        let reach = ((beyond - height).max(0.0) * (beyond + height)).sqrt();
        // Outward is the way the surface faces at the slave.
        let outward = Vector3::from(query.outward.of(&candidates.nodes));
        let cosine = outward.dot(&Vector3::from(plane.normal)) / outward.norm();
        let steepness = if cosine < FACING { f64::INFINITY } else { (highest - lowest) / scale };
        Ok(Self { plane, scale, steepness, reach })
    }
}

/// Average plane of some nodes.
pub fn average_plane<F>(
    query: &Query<'_, F>,
    nodes: &[usize],
    positions: &[Point],
) -> Result<Frame, NeighbourhoodError> {
    let outward = query.outward.of(nodes);
    if !outward.iter().all(|x| x.is_finite()) {
        return Err(NeighbourhoodError::NonFiniteInput { what: "outward", index: 0 });
    }
    Frame::average_plane(positions, outward)
        .map_err(|error| NeighbourhoodError::of_plane(&error, nodes.len()))
}

/// Components of `point − from` along t1, t2 and n̂.
pub fn local_offset(frame: &Frame, from: Point, point: Point) -> Point {
    let offset = Vector3::from(point) - Vector3::from(from);
    frame.rows().map(|axis| offset.dot(&Vector3::from(axis)))
}

/// Components of `point − from` along t1 and t2.
pub fn in_plane(frame: &Frame, from: Point, point: Point) -> Point2 {
    let [a, b, _] = local_offset(frame, from, point);
    [a, b]
}
