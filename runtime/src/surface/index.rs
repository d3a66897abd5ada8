//! The surface at the positions of the moment: normals, and the closest facet by an R*-tree.

use crate::vector::Vector3;
use rayon::prelude::*;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, PointDistance, RTree, SelectionFunction};

use super::checks::LARGEST;
use super::shape::Foot;
use super::topology::NONE;
use super::{MasterSurface, Shape};
use crate::Point;

/// Facets as close as the closest to this fraction of its distance and extent are closest, too: on a common
/// edge or node.
const TIE: f64 = 1e-9;

/// A facet's bounding box and its index.
type Boxed = GeomWithData<Rectangle<Point>, u32>;

/// The boxes that a ray meets, a little larger than they are.
struct Along {
    from: Vector3,
    along: Vector3,
    margin: f64,
}

impl SelectionFunction<Boxed> for Along {
    fn should_unpack_parent(&self, envelope: &AABB<Point>) -> bool {
        let (lower, upper) = (envelope.lower(), envelope.upper());
        let (mut first, mut last) = (0.0_f64, f64::INFINITY);
        for axis in 0..3 {
            let ways = [lower[axis] - self.margin, upper[axis] + self.margin]
                .map(|end| (end - self.from[axis]) / self.along[axis]);
            // Not a number: along a side of the box, which then is no bound.
            if !ways[0].is_nan() && !ways[1].is_nan() {
                first = first.max(ways[0].min(ways[1]));
                last = last.min(ways[0].max(ways[1]));
            }
        }
        first <= last
    }
}

/// A [`MasterSurface`] at given positions.
#[derive(Debug)]
pub struct SurfaceIndex<'a> {
    surface: &'a MasterSurface,
    /// Of the surface's nodes, in their order.
    positions: Vec<Point>,
    /// Unit normals of the facets, outward; zero where there is none.
    normals: Vec<Vector3>,
    tree: RTree<Boxed>,
    /// The largest extent of a facet.
    extent: f64,
}

/// The point of a surface closest to another point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestPoint {
    /// The facet. If several share the closest point, the one whose plane is farthest from the other point,
    /// which tells the sides of the surface apart; of several such the one with the lowest index.
    pub facet: usize,
    /// The point, global axes.
    pub point: Point,
    /// Its natural coordinates on the facet: from −1 to 1 on a quadrilateral, (ξ, η) of
    /// x = (1 − ξ − η) x₁ + ξ x₂ + η x₃ on a triangle.
    pub natural: [f64; 2],
    /// Its distance, length.
    pub distance: f64,
    /// Whether it lies on an edge of only one facet.
    pub on_border: bool,
}

/// As [`ClosestPoint`], with the edges that the point lies on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Closest {
    pub facet: u32,
    pub natural: [f64; 2],
    pub point: Vector3,
    pub distance: f64,
    /// Bit k for the edge from corner k to the next.
    pub edges: u8,
}

impl<'a> SurfaceIndex<'a> {
    /// The positions have been checked.
    pub(super) fn new(surface: &'a MasterSurface, positions: &[Point]) -> Self {
        let own: Vec<Point> = surface.nodes().iter().map(|&node| positions[node as usize]).collect();
        let shape = |facet: usize| surface.shape_by(facet, |place| own[place as usize]);
        let facets = 0..surface.facet_count();
        let normals = facets.clone().into_par_iter().map(|facet| shape(facet).normal()).collect();
        let boxes: Vec<Boxed> = facets
            .clone()
            .into_par_iter()
            .map(|facet| {
                let (lower, upper) = shape(facet).bounds();
                let bounds = AABB::from_corners(lower.into(), upper.into());
                GeomWithData::new(Rectangle::from_aabb(bounds), facet as u32)
            })
            .collect();
        let extent = facets.into_par_iter().map(|facet| shape(facet).extent()).reduce(|| 0.0, f64::max);
        Self { surface, positions: own, normals, tree: RTree::bulk_load(boxes), extent }
    }

    /// The connectivity.
    pub const fn surface(&self) -> &'a MasterSurface {
        self.surface
    }

    /// Positions of the nodes in the order of [`MasterSurface::nodes`].
    pub fn positions(&self) -> &[Point] {
        &self.positions
    }

    /// Unit normal of a facet in its middle, outward; zero if the facet has no area at these positions.
    ///
    /// # Panics
    /// If there is no such facet.
    pub fn normal(&self, facet: usize) -> Point {
        self.normals[facet].into()
    }

    /// The closest point of the surface; `None` if `point` is not finite (or beyond ±10⁷⁵).
    pub fn closest(&self, point: Point) -> Option<ClosestPoint> {
        let mut ties = Vec::new();
        let found = self.closest_among_ties(point, &mut ties)?;
        let facet = found.facet as usize;
        let on_border = ties.iter().any(|tie| {
            let mut across = self.surface.across(tie.facet as usize).iter().enumerate();
            let is_border = |edge, other| other == NONE && !self.surface.is_cut(tie.facet as usize, edge);
            across.any(|(edge, &other)| is_border(edge, other) && tie.edges >> edge & 1 == 1)
        });
        let Closest { natural, distance, .. } = found;
        Some(ClosestPoint { facet, point: found.point.into(), natural, distance, on_border })
    }

    /// The closest point; `ties` gets the facets that share it, in ascending order.
    pub(crate) fn closest_among_ties(&self, point: Point, ties: &mut Vec<Closest>) -> Option<Closest> {
        self.closest_where(point, f64::INFINITY, ties, |_, _| true)
    }

    /// The same among the facets that `may` says so of, first without and then with the closest point of the facet, and that are no
    /// farther away than the limit.
    pub(crate) fn closest_where(
        &self,
        point: Point,
        limit: f64,
        ties: &mut Vec<Closest>,
        may: impl Fn(u32, Option<&Foot>) -> bool,
    ) -> Option<Closest> {
        ties.clear();
        if !point.iter().all(|x| x.abs() <= LARGEST) {
            return None;
        }
        let x = Vector3::from(point);
        let mut least = f64::INFINITY;
        let reach = |least: f64| least + TIE * (least + self.extent);
        for (boxed, square) in self.tree.nearest_neighbor_iter_with_distance_2(point) {
            if square.sqrt() > reach(least).min(limit) {
                break;
            }
            if !may(boxed.data, None) {
                continue;
            }
            let shape = self.shape(boxed.data);
            // Boxes around facets across the axes reach far towards the point.
            if shape.at_least(x) > reach(least).min(limit) {
                continue;
            }
            let foot = shape.closest(x);
            if foot.distance <= reach(least).min(limit) && may(boxed.data, Some(&foot)) {
                let Foot { natural, point, distance, edges } = foot;
                ties.push(Closest { facet: boxed.data, natural, point, distance, edges });
                least = least.min(foot.distance);
            }
        }
        let extent = |tie: &Closest| self.shape(tie.facet).extent();
        let own_reach = |tie: &Closest| least + TIE * (least + extent(tie));
        ties.retain(|tie| tie.distance <= own_reach(tie));
        ties.sort_unstable_by_key(|tie| tie.facet);
        let height = |tie: &Closest| self.normals[tie.facet as usize].dot(&(x - tie.point)).abs();
        let highest = ties.iter().map(height).fold(0.0, f64::max);
        let decided = |tie: &&Closest| height(tie) >= highest - TIE * (least + extent(tie));
        ties.iter().find(decided).or_else(|| ties.first()).copied()
    }

    /// The facets whose boxes are no farther from a point than a limit, with that distance, in no order.
    pub(crate) fn within(&self, point: Point, limit: f64) -> impl Iterator<Item = (u32, f64)> {
        let boxes = self.tree.locate_within_distance(point, limit * limit);
        boxes.map(move |boxed| (boxed.data, boxed.distance_2(&point).sqrt()))
    }

    /// The facets whose boxes meet a box, ascending.
    pub(crate) fn facets_near(&self, lower: Point, upper: Point, found: &mut Vec<u32>) {
        found.clear();
        let bounds = AABB::from_corners(lower, upper);
        found.extend(self.tree.locate_in_envelope_intersecting(bounds).map(|boxed| boxed.data));
        found.sort_unstable();
    }

    /// Hands over the facets whose boxes lie along a direction, in no order.
    pub(crate) fn for_each_along(&self, from: Vector3, along: Vector3, mut f: impl FnMut(u32)) {
        let margin = TIE * self.extent;
        let boxes = self.tree.locate_with_selection_function(Along { from, along, margin });
        boxes.for_each(|boxed| f(boxed.data));
    }

    /// The largest extent of a facet.
    pub(crate) const fn extent(&self) -> f64 {
        self.extent
    }

    /// A facet in space.
    pub(crate) fn shape(&self, facet: u32) -> Shape {
        self.surface.shape_by(facet as usize, |place| self.positions[place as usize])
    }

    /// Unit normals of all facets.
    pub(crate) fn normals(&self) -> &[Vector3] {
        &self.normals
    }
}
