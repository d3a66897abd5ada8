//! What an interface of a window knows of the whole surface.

use super::{Box3, Window, core_places};
use crate::Point;
use crate::vector::Vector3;

/// Rounding, and facets that have grown since the first configuration, in the ball that a slave looks at.
const BALL_MARGIN: f64 = 1e-6;

/// What is known where there is a window only.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Known {
    boxes: Vec<Box3>,
    skin: f64,
    /// What is added to the radius of a ball, length.
    margin: f64,
    /// Of each facet.
    is_core: Vec<bool>,
    /// Of the nodes in the whole surface, ascending.
    numbers: Vec<u64>,
    /// Of the nodes, when the window was made.
    start: Vec<Point>,
}

impl Known {
    /// Whether no node of the window has moved by more than its skin.
    pub fn holds_at(&self, positions: &[Point]) -> bool {
        let moved = |(x, start): (&Point, &Point)| (Vector3::from(*x) - Vector3::from(*start)).norm();
        self.start.iter().zip(positions).all(|(start, x)| moved((x, start)) <= self.skin)
    }

    /// The radius of the ball around a slave that everything has to be known in, for a closest facet at this distance.
    pub fn needed(&self, distance: f64) -> f64 {
        distance + BALL_MARGIN * distance + self.margin
    }

    /// The largest distance of a closest facet that a ball of this radius is enough for.
    pub fn radius(&self, ball: f64) -> f64 {
        (ball - self.margin) / (1.0 + BALL_MARGIN)
    }

    /// The radius of the largest ball around a point that lies in one of the boxes; negative outside of all.
    pub fn around(&self, point: Point) -> f64 {
        self.around_box([point; 2])
    }

    /// By how much a box may be widened to lie in one of the boxes; negative where it does not lie in any.
    pub fn around_box(&self, own: Box3) -> f64 {
        let within = |[low, high]: &Box3| {
            (0..3).map(|k| (own[0][k] - low[k]).min(high[k] - own[1][k])).fold(f64::INFINITY, f64::min)
        };
        self.boxes.iter().map(within).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Whether slaves may be closest to this facet.
    pub fn is_core(&self, facet: u32) -> bool {
        self.is_core[facet as usize]
    }

    /// The number of a node in the whole surface.
    pub fn number_of(&self, node: u32) -> Option<u64> {
        self.numbers.get(node as usize).copied()
    }

    /// How many nodes the window has.
    pub fn node_count(&self) -> u32 {
        self.numbers.len() as u32
    }

    /// The node with this number.
    pub fn node_of(&self, number: u64) -> Option<u32> {
        self.numbers.binary_search(&number).ok().map(|place| place as u32)
    }
}

impl Window {
    /// What an interface of this window, made at these positions, knows of. Its core has moved since the window was made.
    pub(crate) fn known(&self, positions: &[Point]) -> Known {
        let mut start = positions[..self.nodes.len()].to_vec();
        core_places(&self.facets).zip(&self.cut).for_each(|(place, x)| start[place as usize] = *x);
        Known {
            boxes: self.boxes.clone(),
            skin: self.skin,
            margin: BALL_MARGIN * self.setup.extents.facet,
            is_core: self.facets.iter().map(|facet| facet.core.is_some()).collect(),
            numbers: self.nodes().collect(),
            start,
        }
    }
}
