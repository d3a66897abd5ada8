//! Whether positions are finite, and facets have an area and are convex.

use super::topology::NONE;
use super::{Facet, Shape, SurfaceError, shape_of};
use crate::Point;
use crate::vector::Vector3;

/// An area below this fraction of the square of the facet's extent is none.
const SMALLEST_AREA: f64 = 1e-12;
/// A corner of a quadrilateral whose sine is below this is straight or points inwards.
const SMALLEST_SINE: f64 = 1e-9;
/// Smallest extent of a facet: areas squared do not underflow.
const SMALLEST: f64 = 1e-75;
/// Largest coordinate: areas squared do not overflow.
pub(crate) const LARGEST: f64 = 1e75;

/// A position that exists has to be finite, and its squares too.
pub(crate) fn check_position(positions: &[Point], node: usize) -> Result<(), SurfaceError> {
    match positions[node].iter().find(|x| !(x.abs() <= LARGEST)) {
        Some(&value) => Err(SurfaceError::NonFinitePosition { node, value }),
        None => Ok(()),
    }
}

/// Checks each facet by itself.
pub(crate) fn check_facets(positions: &[Point], facets: &[Facet]) -> Result<(), SurfaceError> {
    let most = NONE as usize;
    for (what, count, most) in [("nodes", positions.len(), most), ("facets", facets.len(), most / 4)] {
        if count >= most {
            return Err(SurfaceError::TooMany { what, count });
        }
    }
    facets.iter().enumerate().try_for_each(|(facet, corners)| check_facet(positions, facet, corners))
}

fn check_facet(positions: &[Point], index: usize, facet: &Facet) -> Result<(), SurfaceError> {
    let corners = facet.corners();
    for (k, &node) in corners.iter().enumerate() {
        if node >= positions.len() {
            return Err(SurfaceError::NodeOutOfRange { facet: index, node, count: positions.len() });
        }
        if corners[..k].contains(&node) {
            return Err(SurfaceError::RepeatedNode { facet: index, node });
        }
        check_position(positions, node)?;
    }
    let outline = check_outline(index, corners, &shape_of(facet, positions));
    if let (Err(_), &Facet::Quadrilateral([a, b, c, d])) = (&outline, facet) {
        // Of four corners in convex position there are two orders besides, in either of which the outline crosses itself.
        let is_sound = |order: &[usize; 4]| {
            check_outline(index, order, &shape_of(&Facet::Quadrilateral(*order), positions)).is_ok()
        };
        if let Some(order) = [[a, b, d, c], [a, c, b, d]].into_iter().find(is_sound) {
            return Err(SurfaceError::NotCyclic { facet: index, order });
        }
    }
    outline
}

/// Whether a facet with these corners has an area and is convex.
fn check_outline(index: usize, corners: &[usize], shape: &Shape) -> Result<(), SurfaceError> {
    let extent = shape.extent();
    // Below the smallest extent the factor may be infinite.
    let unit = shape.scaled(1.0 / extent.max(SMALLEST));
    let area = if extent > SMALLEST { unit.area_vector().norm() } else { 0.0 };
    if !(area > SMALLEST_AREA) {
        return Err(SurfaceError::NoArea { facet: index, area, extent });
    }
    // A triangle with an area is convex.
    let Shape::Quadrilateral(places) = unit else { return Ok(()) };
    let sines = corner_sines(&places, unit.area_vector() / area);
    let worst = (0..4).min_by(|&a, &b| sines[a].total_cmp(&sines[b])).map(|corner| (corner, sines[corner]));
    match worst {
        Some((corner, sine)) if !(sine > SMALLEST_SINE) => {
            Err(SurfaceError::NotConvex { facet: index, corner, node: corners[corner], sine })
        }
        _ => Ok(()),
    }
}

/// The sine of the angle at each corner, seen along the unit normal: positive if the corner points outwards; 0 at
/// a corner that coincides with the next.
fn corner_sines(corners: &[Vector3; 4], normal: Vector3) -> [f64; 4] {
    [0, 1, 2, 3].map(|k| {
        let (next, before) = (corners[(k + 1) % 4] - corners[k], corners[(k + 3) % 4] - corners[k]);
        let lengths = next.norm() * before.norm();
        if lengths > 0.0 { next.cross(&before).dot(&normal) / lengths } else { 0.0 }
    })
}
