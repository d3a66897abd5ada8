//! Points that are affine combinations of nodes.
//!
//! The anchor of a contact with friction is a material point of the master: it is where the slave stuck, in terms of the nodes
//! that carried its foot. Assembly spreads what belongs to the point over its nodes.

use std::collections::BTreeMap;

use crate::Point;

/// A point Σ w_k x_k with Σ w_k = 1, carried along by its nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AffinePoint {
    /// Node numbers, ascending, with their weights.
    terms: Vec<(u32, f64)>,
}

/// Weights that do not add up to one, to rounding.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the weights of an affine combination have to add up to 1, not {sum}")]
pub struct NotAffine {
    /// Σ w_k.
    pub sum: f64,
}

impl AffinePoint {
    /// Weights below this part of one are given to the node of the largest weight.
    pub const SMALLEST_WEIGHT: f64 = 1e-12;
    /// How far from 1 the weights may add up.
    const TOLERANCE: f64 = 1e-9;

    /// The combination of nodes with these weights; weights of one node are added.
    ///
    /// # Errors
    /// [`NotAffine`], also for weights of which one is not a number.
    pub fn new(terms: impl IntoIterator<Item = (u32, f64)>) -> Result<Self, NotAffine> {
        let mut weights = BTreeMap::new();
        for (node, weight) in terms {
            *weights.entry(node).or_insert(0.0) += weight;
        }
        let sum: f64 = weights.values().sum();
        if !((sum - 1.0).abs() <= Self::TOLERANCE) {
            return Err(NotAffine { sum });
        }
        let mut point = Self { terms: weights.into_iter().collect() };
        point.drop_small_weights();
        Ok(point)
    }

    /// Gives what is missing to 1, small weights included, to the node of the largest weight.
    fn drop_small_weights(&mut self) {
        self.terms.retain(|(_, weight)| weight.abs() >= Self::SMALLEST_WEIGHT);
        let rest = 1.0 - self.terms.iter().map(|(_, weight)| weight).sum::<f64>();
        let largest = self.terms.iter_mut().max_by(|x, y| x.1.abs().total_cmp(&y.1.abs()));
        if let Some((_, weight)) = largest {
            *weight += rest;
        }
    }

    /// Node numbers, ascending, with their weights.
    #[must_use]
    pub fn terms(&self) -> &[(u32, f64)] {
        &self.terms
    }

    /// Where it is when the nodes are there.
    ///
    /// # Panics
    /// If a node has no position.
    #[must_use]
    pub fn position(&self, positions: &[Point]) -> Point {
        // From one of its nodes: digits are those of the distances between them.
        let Some(&(first, _)) = self.terms.first() else { return [f64::NAN; 3] };
        let origin = positions[first as usize];
        let mut point = origin;
        for &(node, weight) in &self.terms {
            for axis in 0..3 {
                point[axis] += weight * (positions[node as usize][axis] - origin[axis]);
            }
        }
        point
    }

    /// (1 − t) of this point and t of the other one.
    #[must_use]
    pub fn towards(&self, other: &Self, t: f64) -> Self {
        let part = |terms: &[(u32, f64)], factor: f64| -> Vec<(u32, f64)> {
            terms.iter().map(|&(node, weight)| (node, factor * weight)).collect()
        };
        let mut weights = BTreeMap::new();
        for (node, weight) in part(&self.terms, 1.0 - t).into_iter().chain(part(&other.terms, t)) {
            *weights.entry(node).or_insert(0.0) += weight;
        }
        let mut point = Self { terms: weights.into_iter().collect() };
        point.drop_small_weights();
        point
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_carried_along_by_its_nodes() {
        let point = AffinePoint::new([(4, 0.5), (1, -0.25), (2, 0.5), (4, 0.25)]).unwrap();
        assert_eq!(point.terms(), [(1, -0.25), (2, 0.5), (4, 0.75)]);
        let positions: Vec<Point> = (0..5).map(|k| [f64::from(k), 1.0, f64::from(k * k)]).collect();
        assert_eq!(point.position(&positions), [-0.25 + 1.0 + 3.0, 1.0, -0.25 + 2.0 + 12.0]);
        // Far from the origin nothing is lost.
        let moved: Vec<Point> = positions.iter().map(|x| x.map(|x| x + 2f64.powi(40))).collect();
        assert_eq!(point.position(&moved), point.position(&positions).map(|x| x + 2f64.powi(40)));
    }

    #[test]
    fn points_blend_and_drop_what_does_not_count() {
        let here = AffinePoint::new([(0, 1.0)]).unwrap();
        let there = AffinePoint::new([(0, 0.5), (7, 0.5)]).unwrap();
        assert_eq!(here.towards(&there, 0.25).terms(), [(0, 0.875), (7, 0.125)]);
        assert_eq!(here.towards(&there, 1.0), there);
        assert_eq!(here.towards(&there, 1e-13).terms(), [(0, 1.0)]);
        assert_eq!(here.towards(&there, 0.0), here);
    }

    #[test]
    fn weights_that_do_not_add_up_to_one_are_refused() {
        assert_eq!(AffinePoint::new([(0, 0.5), (1, 0.25)]), Err(NotAffine { sum: 0.75 }));
        assert!(AffinePoint::new([(0, f64::NAN), (1, 1.0)]).is_err());
        assert!(AffinePoint::new([]).is_err());
    }
}
