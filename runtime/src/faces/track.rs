//! The history of a node: x_A and y_A as combinations of nodes.

use crate::interface::Anchor;
use crate::vector::Vector3;
use crate::{AffinePoint, Point};

/// Carriers of an anchor on a line, to this part of their spread, do not tell how to move it across.
const ON_A_LINE: f64 = 1e-10;

/// The history of one node.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Track {
    /// x_A of the last accepted step.
    pub own: AffinePoint,
    /// y_A of then, and what it was open by.
    pub anchor: Anchor,
}

impl Track {
    /// Nodes of both combinations with what they have of d.
    pub fn terms(&self) -> impl Iterator<Item = (u32, f64)> + '_ {
        let own = self.own.terms().iter().map(|&(carrier, weight)| (carrier.node, weight));
        own.chain(self.anchor.point.terms().iter().map(|&(carrier, weight)| (carrier.node, -weight)))
    }

    /// Nodes that augmentation within the step may couple.
    pub fn nodes(&self) -> impl Iterator<Item = u32> + '_ {
        let origin = self.anchor.origin.iter().flat_map(AffinePoint::terms);
        self.terms().map(|(node, _)| node).chain(origin.map(|&(carrier, _)| carrier.node))
    }

    /// d
    pub fn way(&self, positions: &[Point]) -> Vector3 {
        self.way_from(&self.anchor.point, positions)
    }

    /// d from where it stuck, without what a multiplier is worth.
    pub fn way_since_stuck(&self, positions: &[Point]) -> Vector3 {
        self.way_from(self.anchor.stuck_at(), positions)
    }

    fn way_from(&self, anchor: &AffinePoint, positions: &[Point]) -> Vector3 {
        let at = |point: &AffinePoint| point.position(|carrier| positions[carrier.node as usize]);
        Vector3::from(at(&self.own)) - Vector3::from(at(anchor))
    }

    /// (1 − t) of this and t of another one.
    pub fn towards(&self, other: &Self, t: f64) -> Self {
        let point = self.anchor.point.towards(&other.anchor.point, t);
        let anchor = Anchor { point, origin: None, ..self.anchor };
        Self { own: self.own.towards(&other.own, t), anchor }
    }

    pub fn with_origin(mut self, origin: Option<AffinePoint>) -> Self {
        self.anchor.origin = origin;
        self
    }

    /// Measured from where it stuck.
    pub fn at_origin(mut self) -> Self {
        if let Some(origin) = self.anchor.origin.take() {
            self.anchor.point = origin;
        }
        self
    }

    pub fn with_opening(mut self, opening: f64) -> Self {
        self.anchor.opening = opening;
        self
    }

    pub fn with_limit(mut self, limit: f64, slid: bool) -> Self {
        (self.anchor.limit, self.anchor.slid) = (limit, slid);
        self
    }

    /// The anchor moved along the master until the slip is this one: the faces of a curved body lie at different distances from their
    /// facets, whose mean is not along the mean normal.
    pub fn with_slip(mut self, slip: Vector3, normal: Vector3, positions: &[Point]) -> Self {
        let Some(normal) = normal.try_normalize() else { return self };
        let first = normal.cross(&Vector3::axis(normal.smallest_axis())).normalize();
        let axes = [first, normal.cross(&first)];
        let terms = self.anchor.point.terms();
        let place = |node: u32| Vector3::from(positions[node as usize]);
        let Some(&(origin, _)) = terms.first() else { return self };
        let origin = place(origin.node);
        let total: f64 = terms.iter().map(|(_, weight)| weight.abs()).sum();
        let offset = |node: u32| place(node) - origin;
        let centre = terms.iter().fold(Vector3::zeros(), |sum, &(carrier, weight)| {
            sum + offset(carrier.node) * (weight.abs() / total)
        });
        let seen = |x: Vector3| axes.map(|axis| axis.dot(&x));
        let arms: Vec<([f64; 2], f64)> = terms
            .iter()
            .map(|&(carrier, weight)| (seen(offset(carrier.node) - centre), weight.abs()))
            .collect();
        let moment =
            |i: usize, j: usize| arms.iter().map(|(arm, weight)| weight * arm[i] * arm[j]).sum::<f64>();
        let (xx, xy, yy) = (moment(0, 0), moment(0, 1), moment(1, 1));
        let determinant = xx * yy - xy * xy;
        if !(determinant > ON_A_LINE * (xx + yy) * (xx + yy)) {
            return self;
        }
        let [a, b] = seen(self.way(positions) - slip);
        let by_arm = [(yy * a - xy * b) / determinant, (xx * b - xy * a) / determinant];
        let moved = terms.iter().zip(&arms).map(|(&(carrier, weight), (arm, size))| {
            (carrier, weight + size * (arm[0] * by_arm[0] + arm[1] * by_arm[1]))
        });
        if let Ok(point) = AffinePoint::new(moved) {
            self.anchor.point = point;
        }
        self
    }
}
