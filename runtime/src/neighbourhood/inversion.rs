//! Hull layers in the inverted plane: who surrounds the slave, ring after ring.

use std::f64::consts::{PI, TAU};

use super::TOLERANCE;
use super::hull::{Point2, convex_hull, turn};

/// An edge of the inverted hull seen from the slave under more than 180° less this, in radians, does not close the
/// ring: the slave lies on the line that joins two border nodes, or beyond it.
const OPEN_ANGLE: f64 = 1e-3;
/// On a border that bows inward, far border nodes close the ring under a wide empty circle. It counts as open where that circle is more
/// than this many times as wide as the ring's farthest node is away …
const EMPTY_CIRCLE: f64 = 2.0;
/// … and the slave sees no node at all under this angle. Inside the nodes it sees some.
const EMPTY_ANGLE: f64 = 0.75 * PI;
/// Where the ring is open, no node of a layer is farther than this many median distances of the layer. On borders and in corners
/// of square, graded and 3:1 grids no node is.
const FARTHEST: f64 = 3.0;
/// Stands for the fictitious node that closes an open ring.
const GHOST: usize = usize::MAX;

/// What a layer says about the slave's position among the nodes it was taken from.
#[derive(Clone, Copy, Debug)]
pub struct Ring {
    /// Diameter of the largest circle through the slave and two consecutive nodes of the layer. No node lies inside
    /// these circles, and no node farther away than this diameter can belong to the layer. Infinite if the
    /// nodes do not surround the slave.
    pub diameter: f64,
    /// The largest angle under which the slave sees no node of the layer; 0 stands for anything clearly below 180°.
    pub free_angle: f64,
}

/// Where a slave lies among nodes that leave this angle free at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Site {
    /// They surround it.
    Inside,
    /// It is in line with two of them, and all are on one side.
    Border,
    /// It is farther out.
    Beyond,
}

impl Site {
    pub fn of(free_angle: f64) -> Self {
        if free_angle < PI - OPEN_ANGLE {
            Self::Inside
        } else if free_angle <= PI + OPEN_ANGLE {
            Self::Border
        } else {
            Self::Beyond
        }
    }
}

/// Takes layer after layer off a set of nodes.
///
/// The m images are sorted once; a layer with h vertices then costs m for the hull and m h for the boundary test, with
/// h about six wherever the nodes are not on a circle.
#[derive(Clone, Debug, Default)]
pub struct Peeler {
    /// The nodes not yet taken, sorted by the x, then the y of their images.
    remaining: Vec<Image>,
    /// The images alone, in the same order.
    points: Vec<Point2>,
    hull: Vec<usize>,
    in_layer: Vec<bool>,
    /// Directions or distances, to be sorted.
    sorted: Vec<f64>,
}

/// A node and its image q = x/|x|² under the inversion at the slave.
#[derive(Clone, Copy, Debug)]
struct Image {
    point: Point2,
    node: usize,
}

impl Peeler {
    /// Starts over with the nodes `(k, x_k)`, x the in-plane offset from the slave: not zero, and of a size whose
    /// square neither overflows nor underflows.
    pub fn start(&mut self, nodes: impl Iterator<Item = (usize, Point2)>) {
        self.remaining.clear();
        self.remaining.extend(nodes.map(|(node, [a, b])| {
            let square = a * a + b * b;
            Image { point: [a / square, b / square], node }
        }));
        self.remaining.sort_unstable_by(|p, q| compare(p.point, q.point).then(p.node.cmp(&q.node)));
    }

    /// Whether every node has been taken.
    pub fn is_empty(&self) -> bool {
        self.remaining.is_empty()
    }

    /// Takes the next layer, appended to `layer`; nothing if no node remains.
    pub fn peel(&mut self, layer: &mut Vec<usize>) -> Ring {
        self.points.clear();
        self.points.extend(self.remaining.iter().map(|image| image.point));
        convex_hull(&self.points, &mut self.hull);
        let closed = self.is_closed().then(|| self.largest_circle());
        let is_wide = closed.is_some_and(|diameter| diameter > EMPTY_CIRCLE * self.farthest());
        let outside = (is_wide || closed.is_none()).then(|| self.free_angle(|_| true));
        let ring = match (closed, outside) {
            (Some(diameter), outside) if outside.is_none_or(|(angle, _)| angle <= EMPTY_ANGLE) => {
                self.mark_layer();
                Ring { diameter, free_angle: 0.0 }
            }
            (_, outside) => {
                self.close_with_ghost(outside.map_or(0.0, |(_, middle)| middle));
                self.mark_layer();
                self.leave_far_nodes();
                Ring { diameter: f64::INFINITY, free_angle: self.free_angle_of_layer() }
            }
        };
        let mut in_layer = self.in_layer.iter();
        self.remaining.retain(|image| {
            let taken = *in_layer.next().unwrap_or(&false);
            if taken && image.node != GHOST {
                layer.push(image.node);
            }
            !taken && image.node != GHOST
        });
        ring
    }

    /// The largest angle between the directions of consecutive nodes of all that remain, in radians.
    pub fn largest_free_angle(&mut self) -> f64 {
        self.free_angle(|_| true).0
    }

    /// The same of the nodes marked as the layer.
    fn free_angle_of_layer(&mut self) -> f64 {
        let in_layer = std::mem::take(&mut self.in_layer);
        let (angle, _) = self.free_angle(|k| in_layer[k]);
        self.in_layer = in_layer;
        angle
    }

    /// The largest angle between the directions of consecutive nodes among those counted, and the direction of its middle.
    fn free_angle(&mut self, counts: impl Fn(usize) -> bool) -> (f64, f64) {
        self.sort_measures(counts, |[x, y]| y.atan2(x));
        let (Some(&first), Some(&last)) = (self.sorted.first(), self.sorted.last()) else {
            return (TAU, 0.0);
        };
        let around = (first + TAU - last, last);
        let between = self.sorted.windows(2).map(|pair| (pair[1] - pair[0], pair[0]));
        let (angle, from) = between.fold(around, |best, gap| if gap.0 > best.0 { gap } else { best });
        (angle, from + 0.5 * angle)
    }

    /// Whether the origin, the slave, lies inside the hull and off its edges.
    fn is_closed(&self) -> bool {
        self.hull.len() > 2
            && edges(&self.points, &self.hull).all(|(a, b)| {
                let nearly_straight = dot(a, b) < 0.0 && cross(a, b) <= OPEN_ANGLE * norm(a) * norm(b);
                turn(a, b, [0.0; 2]) > 0.0 && !nearly_straight
            })
    }

    /// The edge at distance d from the origin is the image of the circle of diameter 1/d.
    fn largest_circle(&self) -> f64 {
        edges(&self.points, &self.hull).map(|(a, b)| norm(minus(b, a)) / cross(a, b)).fold(0.0, f64::max)
    }

    /// Distance of the hull's farthest node.
    fn farthest(&self) -> f64 {
        self.hull.iter().map(|&vertex| distance(self.points[vertex])).fold(0.0, f64::max)
    }

    /// Takes nodes that are too far away out of the layer. They wait for their turn.
    fn leave_far_nodes(&mut self) {
        let in_layer = std::mem::take(&mut self.in_layer);
        self.sort_measures(|k| in_layer[k], distance);
        self.in_layer = in_layer;
        let Some(median) = self.sorted.get(self.sorted.len() / 2) else { return };
        let farthest = FARTHEST * median * (1.0 + TOLERANCE);
        for (&q, in_layer) in self.points.iter().zip(&mut self.in_layer) {
            *in_layer &= norm(q) * farthest >= 1.0;
        }
    }

    /// Sorts what there is to measure of the images counted.
    fn sort_measures(&mut self, counts: impl Fn(usize) -> bool, measure: impl Fn(Point2) -> f64) {
        self.sorted.clear();
        let counted =
            self.remaining.iter().enumerate().filter(|(k, image)| counts(*k) && image.node != GHOST);
        self.sorted.extend(counted.map(|(_, image)| measure(image.point)));
        self.sorted.sort_unstable_by(f64::total_cmp);
    }

    /// Finds the hull with one fictitious node more: in the given direction, as far away as the third nearest.
    fn close_with_ghost(&mut self, direction: f64) {
        self.sort_measures(|_| true, distance);
        let third = 2.min(self.sorted.len().saturating_sub(1));
        let Some(distance) = self.sorted.get(third) else { return };
        let point = [direction.cos() / distance, direction.sin() / distance];
        let place = self.points.partition_point(|&q| compare(q, point).is_lt());
        self.points.insert(place, point);
        self.remaining.insert(place, Image { point, node: GHOST });
        convex_hull(&self.points, &mut self.hull);
    }

    /// Marks the hull's vertices, and the nodes that to the tolerance lie on an edge or a vertex.
    ///
    /// An edge through the origin collects nothing: a node on it is hidden behind the nearer one at its end. For the
    /// same reason, if such an edge has both ends on one side of the slave, the farther node waits for its turn.
    fn mark_layer(&mut self) {
        self.in_layer.clear();
        self.in_layer.resize(self.points.len(), false);
        for &vertex in &self.hull {
            self.in_layer[vertex] = true;
        }
        for (a, b) in edges(&self.points, &self.hull) {
            let along = minus(b, a);
            let length = norm(along);
            let collects = cross(a, b) > TOLERANCE * length * norm(a).max(norm(b));
            for (&q, in_layer) in self.points.iter().zip(&mut self.in_layer) {
                let close = TOLERANCE * norm(q);
                let inward = minus(q, a);
                *in_layer |= (collects && cross(along, inward) <= length * close) || norm(inward) <= close;
            }
        }
        for (&at_a, &at_b) in self.hull.iter().zip(self.hull.iter().cycle().skip(1)) {
            let (a, b) = (self.points[at_a], self.points[at_b]);
            let in_line = dot(a, b) > 0.0 && cross(a, b).abs() <= TOLERANCE * norm(a) * norm(b);
            if in_line && (norm(a) - norm(b)).abs() > TOLERANCE * norm(a).min(norm(b)) {
                self.in_layer[if norm(a) < norm(b) { at_a } else { at_b }] = false;
            }
        }
    }
}

/// The edges of a polygon of points, in its order.
fn edges<'a>(points: &'a [Point2], polygon: &'a [usize]) -> impl Iterator<Item = (Point2, Point2)> + 'a {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().zip(next).map(|(&a, &b)| (points[a], points[b]))
}

/// By x, then by y.
fn compare(p: Point2, q: Point2) -> std::cmp::Ordering {
    p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1]))
}

fn minus(p: Point2, q: Point2) -> Point2 {
    [p[0] - q[0], p[1] - q[1]]
}

fn dot(p: Point2, q: Point2) -> f64 {
    p[0] * q[0] + p[1] * q[1]
}

fn cross(p: Point2, q: Point2) -> f64 {
    p[0] * q[1] - p[1] * q[0]
}

fn norm(p: Point2) -> f64 {
    dot(p, p).sqrt()
}

/// Of the node that is inverted to this image.
fn distance(image: Point2) -> f64 {
    norm(image).recip()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    /// The layers of nodes at these offsets, each in ascending order, and what the first says.
    fn layers(offsets: &[Point2]) -> (Vec<Vec<usize>>, Ring) {
        let mut peeler = Peeler::default();
        peeler.start(offsets.iter().copied().enumerate());
        let mut layers = Vec::new();
        let mut first = None;
        while !peeler.is_empty() {
            let mut layer = Vec::new();
            let ring = peeler.peel(&mut layer);
            assert!(!layer.is_empty(), "a layer takes at least the nearest node");
            first.get_or_insert(ring);
            layer.sort_unstable();
            layers.push(layer);
        }
        (layers, first.unwrap())
    }

    /// Offsets of the nodes of a unit grid, the origin left out.
    fn grid(columns: std::ops::RangeInclusive<i32>, rows: std::ops::RangeInclusive<i32>) -> Vec<Point2> {
        let row = |y: i32| columns.clone().map(move |x| [f64::from(x), f64::from(y)]);
        rows.flat_map(row).filter(|x| *x != [0.0; 2]).collect()
    }

    fn at(offsets: &[Point2], nodes: &[usize]) -> Vec<Point2> {
        nodes.iter().map(|&k| offsets[k]).collect()
    }

    #[test]
    fn around_a_grid_node_the_first_layer_is_the_eight_nodes_around() {
        let offsets = grid(-3..=3, -3..=3);
        let (layers, ring) = layers(&offsets);
        assert_eq!(at(&offsets, &layers[0]), grid(-1..=1, -1..=1));
        assert!((ring.diameter - 2.0_f64.sqrt()).abs() < 1e-15);
        assert_eq!(ring.free_angle, 0.0);
    }

    #[test]
    fn on_a_straight_border_the_next_nodes_hide_those_behind() {
        let offsets = grid(-4..=4, 0..=4);
        let (layers, ring) = layers(&offsets);
        assert_eq!(at(&offsets, &layers[0]), grid(-1..=1, 0..=1));
        assert_eq!(ring.diameter, f64::INFINITY);
        assert!((ring.free_angle - PI).abs() < 1e-15);
    }

    #[test]
    fn in_a_corner_the_three_next_nodes_are_the_layer() {
        let offsets = grid(0..=4, 0..=4);
        let (layers, ring) = layers(&offsets);
        assert_eq!(at(&offsets, &layers[0]), grid(0..=1, 0..=1));
        assert!((ring.free_angle - 3.0 * FRAC_PI_2).abs() < 1e-15);
    }

    #[test]
    fn just_outside_a_border_the_layer_is_that_of_the_border() {
        for outside in [1e-12, 1e-6, 1e-3, 0.1] {
            let offsets: Vec<Point2> =
                (0..40).map(|k| [f64::from(k % 8) - 3.7, f64::from(k / 8) + outside]).collect();
            let (layers, _) = layers(&offsets);
            assert_eq!(layers[0], [3, 4, 11, 12], "{outside}");
        }
    }

    /// The ends of the border are seen under next to no angle, 20 cells away.
    #[test]
    fn a_border_that_bows_inward_has_the_layer_of_a_straight_one() {
        for radius in [30.0_f64, 60.0, 200.0, 1e4, 1e8] {
            for outside in [-1e-2, -1e-6, 0.0, 1e-6, 1e-2, 0.1] {
                let node = |k: i32| {
                    let (angle, r) = ((f64::from(k % 41 - 20) - 0.3) / radius, radius + f64::from(k / 41));
                    [r * angle.sin(), r * angle.cos() - radius + outside]
                };
                let offsets: Vec<Point2> = (0..41 * 4).map(node).collect();
                let (layers, _) = layers(&offsets);
                assert_eq!(layers[0], [20, 21, 61, 62], "{radius} {outside}");
                assert_eq!(layers[1][..2], [19, 22], "{radius} {outside}");
            }
        }
    }

    #[test]
    fn in_an_open_ring_a_far_node_waits_for_its_turn() {
        // The last lies across a gap, in a direction of its own.
        let offsets = [[-1.0, 0.2], [-0.5, 1.0], [0.5, 1.0], [0.6, 0.2], [9.0, 0.1]];
        let (layers, ring) = layers(&offsets);
        assert_eq!(layers, [vec![0, 1, 2, 3], vec![4]]);
        assert_eq!(Site::of(ring.free_angle), Site::Beyond);
    }

    #[test]
    fn coincident_nodes_share_a_layer() {
        let once = grid(-2..=2, -2..=2);
        let twice: Vec<Point2> = once.iter().chain(&once).copied().collect();
        let (layers, _) = layers(&twice);
        assert_eq!(layers[0].len(), 16);
    }

    #[test]
    fn nodes_on_one_ray_come_one_by_one() {
        let ray: Vec<Point2> = (1..=4).map(|k| [0.3 * f64::from(k), 0.1 * f64::from(k)]).collect();
        assert_eq!(layers(&ray).0, [[0], [1], [2], [3]]);
        let doubled = [[1.0, 2.0], [1.0, 2.0], [2.0, 4.0]];
        assert_eq!(layers(&doubled).0, [vec![0, 1], vec![2]]);
        let line = [[-2.0, 0.0], [-1.0, 0.0], [1.0, 0.0], [3.0, 0.0]];
        assert_eq!(layers(&line).0, [[1, 2], [0, 3]]);
    }

    #[test]
    fn nodes_on_one_circle_are_one_layer() {
        let around = |centre: f64| -> Vec<Point2> {
            (0..50).map(|k| f64::from(k) * TAU / 50.0).map(|t| [centre + t.cos(), t.sin()]).collect()
        };
        for centre in [0.0, 0.3, 0.9] {
            assert_eq!(layers(&around(centre)).0.len(), 1);
        }
    }
}
