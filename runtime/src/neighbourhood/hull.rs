//! The convex hull of points in the plane, with exact orientation tests.

use robust::{Coord, orient2d};

/// A point or a vector in the plane.
pub type Point2 = [f64; 2];

/// Writes to `hull` the indices of the hull's vertices, counter-clockwise, without points inside an edge.
///
/// `points` are sorted by x, then y. Of points that coincide one is named. Fewer than three indices if the points
/// lie on a line. Andrew's monotone chain: linear in the number of points.
pub fn convex_hull(points: &[Point2], hull: &mut Vec<usize>) {
    hull.clear();
    for next in 0..points.len() {
        extend(points, hull, 1, next);
    }
    let lower = hull.len();
    for next in (0..points.len().saturating_sub(1)).rev() {
        extend(points, hull, lower, next);
    }
    if hull.len() > 1 {
        hull.pop();
    }
}

/// Takes `next` into the chain that begins with the `base`-th entry, dropping what it leaves behind.
fn extend(points: &[Point2], hull: &mut Vec<usize>, base: usize, next: usize) {
    while let &[.., before, last] = hull.as_slice()
        && hull.len() > base
        && turn(points[before], points[last], points[next]) <= 0.0
    {
        hull.pop();
    }
    hull.push(next);
}

/// Positive if a, b, c turn left, negative if they turn right, zero if they lie on a line; the sign is exact.
pub fn turn(a: Point2, b: Point2, c: Point2) -> f64 {
    let coord = |[x, y]: Point2| Coord { x, y };
    orient2d(coord(a), coord(b), coord(c))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hull_of(points: &[Point2]) -> Vec<usize> {
        let mut hull = Vec::new();
        convex_hull(points, &mut hull);
        hull
    }

    #[test]
    fn the_hull_of_a_grid_is_its_four_corners() {
        let grid: Vec<Point2> = (0..25).map(|k| [f64::from(k / 5), f64::from(k % 5)]).collect();
        assert_eq!(hull_of(&grid), [0, 20, 24, 4]);
    }

    #[test]
    fn degenerate_sets_have_degenerate_hulls() {
        assert!(hull_of(&[]).is_empty());
        assert_eq!(hull_of(&[[1.0, 2.0]]), [0]);
        assert_eq!(hull_of(&[[1.0, 2.0], [3.0, 4.0]]), [0, 1]);
        assert_eq!(hull_of(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [3.0, 3.0]]), [0, 3]);
        assert_eq!(hull_of(&[[1.0, 2.0]; 5]).len(), 2, "coincident points keep two of themselves");
        let doubled = [[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, 1.0]];
        assert_eq!(hull_of(&doubled).len(), 3);
    }

    #[test]
    fn a_bend_of_one_unit_in_the_last_place_is_seen() {
        let bent = [[0.0, 0.0], [0.5, 0.5 - f64::EPSILON / 4.0], [1.0, 1.0]];
        assert_eq!(hull_of(&bent), [0, 1, 2]);
    }
}
