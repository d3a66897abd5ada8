//! Points that are affine combinations of nodes.
//!
//! The anchor of a contact with friction is a material point of the master: it is where the slave stuck, in terms of the nodes
//! that carried its foot. Assembly spreads what belongs to the point over its nodes.

use std::collections::BTreeMap;

use crate::Point;

/// A node, or its image behind planes of symmetry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Carrier {
    /// The node.
    pub node: u32,
    /// The number of the image, if it is one of it.
    pub image: Option<u32>,
}

impl From<u32> for Carrier {
    fn from(node: u32) -> Self {
        Self { node, image: None }
    }
}

/// A point Σ w_k x_k with Σ w_k = 1, carried along by nodes and their images.
#[derive(Clone, Debug, PartialEq)]
pub struct AffinePoint {
    /// Carriers, ascending, with their weights.
    terms: Vec<(Carrier, f64)>,
}

/// Weights that do not add up to one, to rounding.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the weights of an affine combination have to add up to 1, not {sum}")]
pub struct NotAffine {
    /// Σ w_k.
    pub sum: f64,
}

impl AffinePoint {
    /// Weights below this part of one are given to the carrier of the largest weight.
    pub const SMALLEST_WEIGHT: f64 = 1e-12;
    /// How far from 1 the weights may add up.
    const TOLERANCE: f64 = 1e-9;
    /// What rounding leaves of 1 in a sum of weights, by the sum of their sizes: it stays, so that a point that was written and read again is
    /// the same.
    const ROUNDING: f64 = 1e-14;

    /// The combination of nodes, or of carriers, with these weights; weights of the same one are added.
    ///
    /// # Errors
    /// [`NotAffine`], also for weights of which one is not a number.
    pub fn new<C: Into<Carrier>>(terms: impl IntoIterator<Item = (C, f64)>) -> Result<Self, NotAffine> {
        let sum = collected(terms.into_iter().map(|(carrier, weight)| (carrier.into(), weight)));
        let total: f64 = sum.values().sum();
        if !((total - 1.0).abs() <= Self::TOLERANCE) {
            return Err(NotAffine { sum: total });
        }
        Ok(Self::of(sum))
    }

    /// What is missing to 1, small weights included, goes to the carrier of the largest weight.
    fn of(weights: BTreeMap<Carrier, f64>) -> Self {
        let mut terms: Vec<(Carrier, f64)> = weights.into_iter().collect();
        terms.retain(|(_, weight)| weight.abs() >= Self::SMALLEST_WEIGHT);
        let rest = 1.0 - terms.iter().map(|(_, weight)| weight).sum::<f64>();
        let size: f64 = terms.iter().map(|(_, weight)| weight.abs()).sum();
        if rest.abs() < Self::ROUNDING * size {
            return Self { terms };
        }
        let largest = terms.iter_mut().max_by(|x, y| x.1.abs().total_cmp(&y.1.abs()));
        if let Some((_, weight)) = largest {
            *weight += rest;
        }
        Self { terms }
    }

    /// Carriers, ascending, with their weights.
    pub fn terms(&self) -> &[(Carrier, f64)] {
        &self.terms
    }

    /// Where it is when `place` says where its carriers are.
    pub fn position(&self, place: impl Fn(Carrier) -> Point) -> Point {
        // From one of its carriers: digits are those of the distances between them.
        let Some(&(first, _)) = self.terms.first() else { return [f64::NAN; 3] };
        let origin = place(first);
        let mut point = origin;
        for &(carrier, weight) in &self.terms {
            let x = place(carrier);
            for axis in 0..3 {
                point[axis] += weight * (x[axis] - origin[axis]);
            }
        }
        point
    }

    /// (1 − t) of this point and t of the other one, for a finite t. Of another one the point has no terms, and no position.
    #[must_use]
    pub fn towards(&self, other: &Self, t: f64) -> Self {
        Self::combined(&[(self, 1.0 - t), (other, t)])
    }

    /// Σ f_k p_k of points p_k with factors f_k that add up to 1.
    pub(crate) fn combined(points: &[(&Self, f64)]) -> Self {
        let part = |&(point, factor): &(&Self, f64)| {
            point.terms.iter().map(move |&(carrier, weight)| (carrier, factor * weight)).collect::<Vec<_>>()
        };
        Self::of(collected(points.iter().flat_map(part)))
    }
}

/// Weights by carrier.
fn collected(terms: impl Iterator<Item = (Carrier, f64)>) -> BTreeMap<Carrier, f64> {
    let mut weights = BTreeMap::new();
    for (carrier, weight) in terms {
        *weights.entry(carrier).or_insert(0.0) += weight;
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_nodes(terms: &[(u32, f64)]) -> Vec<(Carrier, f64)> {
        terms.iter().map(|&(node, weight)| (node.into(), weight)).collect()
    }

    #[test]
    fn a_point_is_carried_along_by_its_nodes() {
        let point = AffinePoint::new([(4, 0.5), (1, -0.25), (2, 0.5), (4, 0.25)]).unwrap();
        assert_eq!(point.terms(), of_nodes(&[(1, -0.25), (2, 0.5), (4, 0.75)]));
        let x = |node: u32| [f64::from(node), 1.0, f64::from(node * node)];
        assert_eq!(point.position(|carrier| x(carrier.node)), [-0.25 + 1.0 + 3.0, 1.0, -0.25 + 2.0 + 12.0]);
        // Far from the origin nothing is lost.
        let far = |x: Point| x.map(|x| x + 2f64.powi(40));
        assert_eq!(
            point.position(|carrier| far(x(carrier.node))),
            far(point.position(|carrier| x(carrier.node)))
        );
    }

    #[test]
    fn a_point_from_the_terms_of_another_is_the_same() {
        let weight = |k: u32| 1.0 + (f64::from(k) + 0.3).sin();
        let sum: f64 = (0..40).map(weight).sum();
        let point = AffinePoint::new((0..40).map(|k| (k, weight(k) / sum * (1.0 + 1e-11)))).unwrap();
        assert_eq!(AffinePoint::new(point.terms().iter().copied()), Ok(point));
    }

    #[test]
    fn weights_that_cancel_are_the_same_when_they_are_read_again() {
        for size in [1.0, 1e3, 1e5] {
            for case in 0..100 {
                let weight = |k: u32| size * (f64::from(k + 17 * case) * 0.7).sin();
                let rest = 1.0 - (1..25).map(weight).sum::<f64>();
                let weights = (1..25).map(|k| (k, weight(k))).chain([(0, rest)]);
                let Ok(point) = AffinePoint::new(weights) else { panic!("{size} {case}") };
                assert_eq!(AffinePoint::new(point.terms().iter().copied()), Ok(point), "{size} {case}");
            }
        }
    }

    #[test]
    fn an_image_is_a_carrier_of_its_own() {
        let image = Carrier { node: 1, image: Some(0) };
        let point = AffinePoint::new([(image, 0.5), (Carrier::from(1), 0.5)]).unwrap();
        assert_eq!(point.terms(), [(Carrier::from(1), 0.5), (image, 0.5)]);
        let x = |carrier: Carrier| if carrier.image.is_some() { [-1.0, 2.0, 3.0] } else { [1.0, 2.0, 3.0] };
        assert_eq!(point.position(x), [0.0, 2.0, 3.0]);
    }

    #[test]
    fn points_blend_and_drop_what_does_not_count() {
        let here = AffinePoint::new([(0, 1.0)]).unwrap();
        let there = AffinePoint::new([(0, 0.5), (7, 0.5)]).unwrap();
        assert_eq!(here.towards(&there, 0.25).terms(), of_nodes(&[(0, 0.875), (7, 0.125)]));
        assert_eq!(here.towards(&there, 1.0), there);
        assert_eq!(here.towards(&there, 1e-13).terms(), of_nodes(&[(0, 1.0)]));
        assert_eq!(here.towards(&there, 0.0), here);
    }

    #[test]
    fn weights_that_do_not_add_up_to_one_are_refused() {
        assert_eq!(AffinePoint::new([(0, 0.5), (1, 0.25)]), Err(NotAffine { sum: 0.75 }));
        assert!(AffinePoint::new([(0, f64::NAN), (1, 1.0)]).is_err());
        assert!(AffinePoint::new::<u32>([]).is_err());
    }
}
