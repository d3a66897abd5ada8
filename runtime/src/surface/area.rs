//! The area that belongs to each node of a faceted surface.

use super::checks::check_facets;
use super::shape::shape_of;
use super::{Facet, Shape, SurfaceError};
use crate::Point;

/// Gauss points and weights on [−1, 1], exact for polynomials of degree 5.
const GAUSS: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];

/// Tributary area of every node: the integral of its shape function over the facets at it; 0 for nodes of no facet.
///
/// A triangle's area goes to its corners in equal shares. On a quadrilateral the bilinear shape functions are
/// integrated with 3 × 3 Gauss points, exactly if it is plane. The areas sum up to the area of the surface.
/// With them a penalty per area gives a pressure that does not depend on the mesh.
///
/// # Errors
/// [`SurfaceError::NodeOutOfRange`], [`SurfaceError::RepeatedNode`], [`SurfaceError::NonFinitePosition`],
/// [`SurfaceError::NoArea`], [`SurfaceError::NotConvex`], [`SurfaceError::TooMany`].
pub fn tributary_areas(positions: &[Point], facets: &[Facet]) -> Result<Vec<f64>, SurfaceError> {
    check_facets(positions, facets)?;
    let mut areas = vec![0.0; positions.len()];
    for facet in facets {
        for (&node, share) in facet.corners().iter().zip(shape_of(facet, positions).shares()) {
            areas[node] += share;
        }
    }
    Ok(areas)
}

impl Shape {
    /// ∫ N_k dA of each corner, length².
    pub(crate) fn shares(&self) -> [f64; 4] {
        if let Self::Triangle(_) = self {
            let share = self.area_vector().norm() / 3.0;
            return [share, share, share, 0.0];
        }
        let mut shares = [0.0; 4];
        for (xi, weight_xi) in GAUSS {
            for (eta, weight_eta) in GAUSS {
                let area = weight_xi * weight_eta * self.area_element([xi, eta]).norm();
                for (share, n) in shares.iter_mut().zip(self.functions([xi, eta])) {
                    *share += n * area;
                }
            }
        }
        shares
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_shares_equally_and_a_trapezium_by_its_shape_functions() {
        let square = [[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [2.0, 2.0, 1.0], [0.0, 2.0, 1.0], [9.0, 9.0, 9.0]];
        let facet = Facet::Quadrilateral([0, 1, 2, 3]);
        let areas = tributary_areas(&square, &[facet]).unwrap();
        for (found, expected) in areas.iter().zip([1.0, 1.0, 1.0, 1.0, 0.0]) {
            assert!((found - expected).abs() < 1e-15);
        }
        // Width 3 − η on |x| ≤ width/2, η from −1 to 1: J = (3 − η)/2, ∫ N over ξ gives J (1 ∓ η)/2 per corner.
        let trapezium = [[-2.0, -1.0, 0.0], [2.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
        let areas = tributary_areas(&trapezium, &[facet]).unwrap();
        let (lower, upper) = (5.0 / 3.0, 4.0 / 3.0);
        for (found, expected) in areas.iter().zip([lower, lower, upper, upper]) {
            assert!((found - expected).abs() < 1e-14, "{areas:?}");
        }
    }

    #[test]
    fn bad_facets_are_refused() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let error = tributary_areas(&positions, &[Facet::Triangle([0, 1, 3])]).unwrap_err();
        assert_eq!(error.code(), "node-out-of-range");
        assert_eq!(tributary_areas(&positions, &[]).unwrap(), [0.0; 3]);
    }
}
