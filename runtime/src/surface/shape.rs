//! One facet in space: its point at natural coordinates, its normal, and its point closest to another.

use super::Facet;
use crate::vector::Vector3;
use crate::{FacetElement, Generated, Point};

/// A natural coordinate this close to the end of its range lies on the edge.
const ON_EDGE: f64 = 1e-12;

/// Rounding of a lower bound of a distance, over the distance of the farthest corner.
const BOUND_ROUNDING: f64 = 1e-12;

/// Natural coordinates of the corners. A triangle's are its area coordinates: x = (1 − ξ − η) x₁ + ξ x₂ + η x₃.
const TRIANGLE: [[f64; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
const QUADRILATERAL: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

/// A facet with the positions of its corners.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// Plane.
    Triangle([Vector3; 3]),
    /// Bilinear.
    Quadrilateral([Vector3; 4]),
}

/// A facet in space.
pub(crate) fn shape_of(facet: &Facet, positions: &[Point]) -> Shape {
    match facet {
        Facet::Triangle(corners) => Shape::Triangle(corners.map(|node| positions[node].into())),
        Facet::Quadrilateral(corners) => Shape::Quadrilateral(corners.map(|node| positions[node].into())),
    }
}

/// The point of a facet closest to another point.
#[derive(Clone, Copy, Debug)]
pub struct Foot {
    /// Natural coordinates.
    pub natural: [f64; 2],
    /// In space.
    pub point: Vector3,
    /// From the other point.
    pub distance: f64,
    /// Bit k is set if the foot lies on the edge from corner k to the next; on a corner two bits are.
    pub edges: u8,
}

/// A point and the box around a facet.
#[derive(Clone, Copy, Debug)]
pub struct Near {
    /// Distance from the box: a lower bound of that from the facet.
    pub at_least: f64,
    /// Diagonal of the box: an upper bound of the facet's extent, but for rounding.
    pub extent: f64,
}

impl Shape {
    pub fn corners(&self) -> &[Vector3] {
        match self {
            Self::Triangle(corners) => corners,
            Self::Quadrilateral(corners) => corners,
        }
    }

    /// The lowest and the highest corner of the box around it.
    pub fn bounds(&self) -> (Vector3, Vector3) {
        let first = self.corners()[0];
        self.corners().iter().fold((first, first), |(low, high), x| (low.lower(x), high.upper(x)))
    }

    /// The ends of the edge from corner `edge` to the next.
    pub fn edge(&self, edge: usize) -> [Vector3; 2] {
        let corners = self.corners();
        [corners[edge], corners[(edge + 1) % corners.len()]]
    }

    /// The mean of the corners.
    pub fn middle(&self) -> Vector3 {
        let corners = self.corners();
        corners.iter().copied().sum::<Vector3>() / corners.len() as f64
    }

    /// The point at natural coordinates, which may lie outside their range.
    pub fn point(&self, [xi, eta]: [f64; 2]) -> Vector3 {
        match self {
            Self::Triangle([a, b, c]) => a + (b - a) * xi + (c - a) * eta,
            Self::Quadrilateral([a, b, c, d]) => {
                let lower = a + (b - a) * (0.5 * (1.0 + xi));
                let upper = d + (c - d) * (0.5 * (1.0 + xi));
                lower + (upper - lower) * (0.5 * (1.0 + eta))
            }
        }
    }

    /// Area vector: outward, of the length of the area (of a quadrilateral: of its projection on its middle plane).
    pub fn area_vector(&self) -> Vector3 {
        match self {
            Self::Triangle([a, b, c]) => (b - a).cross(&(c - a)) * 0.5,
            Self::Quadrilateral([a, b, c, d]) => (c - a).cross(&(d - b)) * 0.5,
        }
    }

    /// ∂x/∂ξ × ∂x/∂η at natural coordinates: area by natural area, along the normal.
    ///
    /// A quadrilateral is ruled by two families of straight lines on which the point moves evenly: over natural coordinates 2 long it
    /// goes the whole chord.
    pub fn area_element(&self, [xi, eta]: [f64; 2]) -> Vector3 {
        match self {
            Self::Triangle(_) => self.area_vector() * 2.0,
            Self::Quadrilateral(_) => {
                let chord_xi = self.point([1.0, eta]) - self.point([-1.0, eta]);
                let chord_eta = self.point([xi, 1.0]) - self.point([xi, -1.0]);
                (chord_xi * 0.5).cross(&(chord_eta * 0.5))
            }
        }
    }

    /// N_k at natural coordinates, one per corner; of a triangle the last is 0.
    pub fn functions(&self, [xi, eta]: [f64; 2]) -> [f64; 4] {
        match self {
            Self::Triangle(_) => [1.0 - xi - eta, xi, eta, 0.0],
            Self::Quadrilateral(_) => {
                let [left, right, lower, upper] = [1.0 - xi, 1.0 + xi, 1.0 - eta, 1.0 + eta].map(|x| 0.5 * x);
                [left * lower, right * lower, right * upper, left * upper]
            }
        }
    }

    /// Unit normal in the middle, outward; zero if there is none.
    pub fn normal(&self) -> Vector3 {
        let scale = 1.0 / self.extent();
        let area = self.scaled(scale).area_vector();
        area.try_normalize().filter(Vector3::is_finite).unwrap_or_default()
    }

    /// The least height over an edge of a triangle; of a quadrilateral its area over its longest edge. Length.
    pub fn least_height(&self) -> f64 {
        let edges = (0..self.corners().len()).map(|edge| self.edge(edge));
        let longest = edges.map(|[from, to]| (to - from).norm()).fold(0.0, f64::max);
        let part = if self.corners().len() == 3 { 2.0 } else { 1.0 };
        part * self.area_vector().norm() / longest
    }

    /// The longest edge, however it lies.
    pub fn extent(&self) -> f64 {
        let unit = self.largest_difference();
        let edges = (0..self.corners().len()).map(|edge| self.edge(edge));
        let longest = edges.map(|[from, to]| ((to - from) / unit).norm()).fold(0.0, f64::max);
        if unit > 0.0 { longest * unit } else { unit }
    }

    /// Largest coordinate difference between two corners.
    fn largest_difference(&self) -> f64 {
        let along = |axis: usize| {
            let coordinates = self.corners().iter().map(|corner| corner[axis]);
            let [low, high] = [f64::INFINITY, f64::NEG_INFINITY];
            coordinates.fold([low, high], |[low, high], x| [low.min(x), high.max(x)])
        };
        [0, 1, 2].map(along).into_iter().fold(0.0, |extent, [low, high]| (high - low).max(extent))
    }

    /// Offsets from the first corner times a factor.
    pub fn scaled(&self, factor: f64) -> Self {
        let first = self.corners()[0];
        match self {
            Self::Triangle(corners) => Self::Triangle(corners.map(|x| (x - first) * factor)),
            Self::Quadrilateral(corners) => Self::Quadrilateral(corners.map(|x| (x - first) * factor)),
        }
    }

    /// How far `x` is from the box around the corners, which holds the facet.
    pub fn near(&self, x: Vector3) -> Near {
        let corners = self.corners();
        let (mut square, mut diagonal) = (0.0, 0.0);
        for axis in 0..3 {
            let (mut low, mut high) = (corners[0][axis], corners[0][axis]);
            for corner in &corners[1..] {
                low = low.min(corner[axis]);
                high = high.max(corner[axis]);
            }
            let outside = (low - x[axis]).max(x[axis] - high).max(0.0);
            square += outside * outside;
            diagonal += (high - low) * (high - low);
        }
        Near { at_least: square.sqrt(), extent: f64::sqrt(diagonal) }
    }

    /// A lower bound of the distance that [`closest`](Self::closest) finds, smaller than that by rounding at least: how far all corners lie
    /// along the way to their middle. Not a number where there is no way.
    pub fn at_least(&self, x: Vector3) -> f64 {
        let way = self.middle() - x;
        let (mut least, mut largest) = (f64::INFINITY, 0.0_f64);
        for corner in self.corners() {
            let offset = *corner - x;
            least = least.min(way.dot(&offset));
            largest = largest.max(offset.dot(&offset));
        }
        least / way.norm() - BOUND_ROUNDING * largest.sqrt()
    }

    /// The square of the distance from the edges, no larger than that from any corner.
    pub fn square_from_edges(&self, x: Vector3) -> f64 {
        let count = self.corners().len();
        let nearest = (0..count).map(|edge| (on_segment(self.edge(edge), x).1 - x).norm_squared());
        // By rounding a corner may be nearer than the point that is found.
        let corners = self.corners().iter().map(|corner| (*corner - x).norm_squared());
        nearest.chain(corners).fold(f64::INFINITY, f64::min)
    }

    /// The closest point. Exact for triangles and plane convex quadrilaterals; on a warped or folded one the best of
    /// its edges and of the foot of the facet element.
    pub fn closest(&self, x: Vector3) -> Foot {
        match self {
            Self::Triangle(corners) => inside_triangle(corners, x).unwrap_or_else(|| on_edges(self, x)),
            Self::Quadrilateral(corners) => {
                let edge = on_edges(self, x);
                let inside = inside_quadrilateral(self, corners, x);
                inside.filter(|foot| foot.distance < edge.distance).unwrap_or(edge)
            }
        }
    }

    /// How far `offset` reaches outward across an edge in the plane of the facet, over the facet's height over
    /// that edge; 0 if the facet has no area.
    pub fn reach_across(&self, edge: usize, offset: Vector3) -> f64 {
        // In extents of the facet: the cubes of lengths below must neither overflow nor underflow.
        let scale = 1.0 / self.extent();
        let shape = self.scaled(scale);
        let [from, to] = shape.edge(edge);
        let along = to - from;
        let area = shape.area_vector();
        let height = match self {
            Self::Triangle(_) => 2.0 * area.norm(),
            Self::Quadrilateral(_) => area.norm(),
        } / along.norm();
        let outward = along.cross(&area).normalize();
        let reach = outward.dot(&(offset * scale)) / height;
        if reach.is_finite() { reach } else { 0.0 }
    }
}

/// The foot straight below, if it lies within the triangle.
fn inside_triangle(corners: &[Vector3; 3], x: Vector3) -> Option<Foot> {
    let [a, b, c] = corners;
    let (along, across, offset) = (b - a, c - a, x - a);
    let area = along.cross(&across);
    let square = area.norm_squared();
    if !(square > 0.0) {
        return None;
    }
    let xi = offset.cross(&across).dot(&area) / square;
    let eta = along.cross(&offset).dot(&area) / square;
    let zeta = 1.0 - xi - eta;
    if !(xi >= 0.0 && eta >= 0.0 && zeta >= 0.0) {
        return None;
    }
    let point = a + along * xi + across * eta;
    let edges = [eta, zeta, xi].map(|distance| distance <= ON_EDGE);
    Some(Foot { natural: [xi, eta], point, distance: (x - point).norm(), edges: bits(edges) })
}

/// The foot of the facet element, if it has one and it lies within the quadrilateral.
fn inside_quadrilateral(shape: &Shape, corners: &[Vector3; 4], x: Vector3) -> Option<Foot> {
    let corners = corners.map(Point::from);
    let element = FacetElement { slave: x.into(), corners: &corners };
    // No foot, or a facet folded over: the edges are left.
    let natural = Generated.facet_point(&element).ok()?.natural;
    if !element.contains(natural, 0.0) {
        return None;
    }
    let [xi, eta] = natural;
    let point = shape.point(natural);
    let edges = [1.0 + eta, 1.0 - xi, 1.0 - eta, 1.0 + xi].map(|distance| distance <= ON_EDGE);
    Some(Foot { natural, point, distance: (x - point).norm(), edges: bits(edges) })
}

/// The closest point between two, and how far it is from the first to the second, 0 to 1.
fn on_segment([start, end]: [Vector3; 2], x: Vector3) -> (f64, Vector3) {
    let along = end - start;
    let square = along.norm_squared();
    let t = if square > 0.0 { ((x - start).dot(&along) / square).clamp(0.0, 1.0) } else { 0.0 };
    (t, if t == 1.0 { end } else { start + along * t })
}

/// The closest point of the edges.
fn on_edges(shape: &Shape, x: Vector3) -> Foot {
    let naturals: &[[f64; 2]] = match shape {
        Shape::Triangle(_) => &TRIANGLE,
        Shape::Quadrilateral(_) => &QUADRILATERAL,
    };
    let count = naturals.len();
    let mut best = Foot { natural: naturals[0], point: x, distance: f64::INFINITY, edges: 0 };
    for (edge, from) in naturals.iter().enumerate() {
        let to = naturals[(edge + 1) % count];
        let (t, point) = on_segment(shape.edge(edge), x);
        let distance = (x - point).norm();
        if distance < best.distance {
            let before = u8::from(t <= ON_EDGE) << ((edge + count - 1) % count);
            let after = u8::from(1.0 - t <= ON_EDGE) << ((edge + 1) % count);
            let natural = [0, 1].map(|k| from[k] + t * (to[k] - from[k]));
            best = Foot { natural, point, distance, edges: 1 << edge | before | after };
        }
    }
    best
}

/// Flags as bits, the first the lowest.
fn bits<const N: usize>(flags: [bool; N]) -> u8 {
    flags.iter().enumerate().map(|(k, &flag)| u8::from(flag) << k).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Smallest distance over a fine grid of the facet's points.
    fn sampled(shape: &Shape, x: Vector3) -> f64 {
        let n = 100;
        let range = |k: usize| f64::from(k as u32) / f64::from(n as u32);
        (0..=n)
            .flat_map(|i| (0..=n).map(move |j| [range(i), range(j)]))
            .filter_map(|[s, t]| match shape {
                Shape::Triangle(_) => (s + t <= 1.0).then_some([s, t]),
                Shape::Quadrilateral(_) => Some([2.0 * s - 1.0, 2.0 * t - 1.0]),
            })
            .map(|natural| (shape.point(natural) - x).norm())
            .fold(f64::INFINITY, f64::min)
    }

    fn uniform(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (*state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }

    #[test]
    fn no_sampled_point_is_closer_than_the_closest() {
        let mut state = 7;
        let mut point = |size: f64| Vector3::from([(); 3].map(|()| size * uniform(&mut state)));
        for round in 0..150 {
            let triangle = Shape::Triangle([(); 3].map(|()| point(2.0)));
            let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            let quadrilateral =
                Shape::Quadrilateral(square.map(|[a, b]| Vector3::new(a, b, 0.0) + point(0.7)));
            let x = point(if round % 2 == 0 { 3.0 } else { 8.0 });
            for shape in [triangle, quadrilateral] {
                let foot = shape.closest(x);
                assert!((shape.point(foot.natural) - foot.point).norm() < 1e-12);
                assert!(((x - foot.point).norm() - foot.distance).abs() < 1e-12);
                let near = shape.near(x);
                assert!(near.at_least <= foot.distance * (1.0 + 1e-14), "{shape:?} {x:?}");
                assert!(shape.at_least(x) < foot.distance, "{shape:?} {x:?}");
                assert!(near.extent >= shape.extent() * (1.0 - 1e-14), "{shape:?}");
                let best = sampled(&shape, x);
                assert!(foot.distance <= best + 1e-12, "{shape:?} {x:?}: {} > {best}", foot.distance);
                assert!(foot.distance > best - 0.04, "a point that is not on the facet");
            }
        }
    }

    #[test]
    fn the_edges_of_a_foot_are_those_it_lies_on() {
        let [a, b, c, d] =
            [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(|[x, y]| Vector3::new(x, y, 0.0));
        let (triangle, square) = (Shape::Triangle([a, b, c]), Shape::Quadrilateral([a, b, c, d]));
        let edges = |shape: &Shape, x: f64, y: f64| shape.closest(Vector3::new(x, y, 1.0)).edges;
        assert_eq!(edges(&triangle, 1.5, 0.5), 0);
        assert_eq!(edges(&triangle, 1.5, -0.5), 0b001);
        assert_eq!(edges(&triangle, 2.5, 1.0), 0b010);
        assert_eq!(edges(&triangle, 0.5, 1.5), 0b100);
        assert_eq!(edges(&triangle, 1.0, 1.0), 0b100, "on the edge itself");
        assert_eq!(edges(&triangle, 3.0, -1.0), 0b011);
        assert_eq!(edges(&square, 1.0, 1.0), 0);
        assert_eq!(edges(&square, 2.0, 1.0), 0b0010, "on the edge itself");
        assert_eq!(edges(&square, -1.0, 1.0), 0b1000);
        assert_eq!(edges(&square, -1.0, 3.0), 0b1100);
        assert_eq!(edges(&square, 0.0, 0.0), 0b1001);
    }

    #[test]
    fn reach_across_an_edge_is_in_heights_of_the_facet() {
        let [a, b, c, d] =
            [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [0.0, 2.0]].map(|[x, y]| Vector3::new(x, y, 0.0));
        let offset = Vector3::new(0.3, -0.5, 7.0);
        assert_eq!(Shape::Quadrilateral([a, b, c, d]).reach_across(0, offset), 0.25);
        assert_eq!(Shape::Triangle([a, b, d]).reach_across(0, offset), 0.25);
        assert_eq!(Shape::Quadrilateral([a, b, c, d]).reach_across(1, offset), 0.075);
        assert_eq!(Shape::Triangle([a, b, b]).reach_across(0, offset), 0.0);
        for unit in [1e-75, 1e-60, 1e60, 1e75] {
            let [a, b, c, d] = [a, b, c, d].map(|x| x * unit);
            for shape in [Shape::Quadrilateral([a, b, c, d]), Shape::Triangle([a, b, d])] {
                let reach = shape.reach_across(0, offset * unit);
                assert!((reach - 0.25).abs() < 1e-14, "{unit:e} {reach}");
            }
        }
    }

    #[test]
    fn a_facet_without_area_still_has_a_closest_point() {
        let [a, b] = [Vector3::zeros(), Vector3::new(1.0, 0.0, 0.0)];
        let x = Vector3::new(0.25, 1.0, 0.0);
        for shape in [Shape::Triangle([a, b, a]), Shape::Quadrilateral([a, b, b, a])] {
            assert_eq!(shape.closest(x).distance, 1.0);
            assert_eq!(shape.normal(), Vector3::zeros());
        }
        let point = Shape::Quadrilateral([a; 4]);
        assert_eq!((point.closest(b).distance, point.normal()), (1.0, Vector3::zeros()));
    }
}
