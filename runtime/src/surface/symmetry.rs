//! Symmetry planes: the master surface goes on beyond them as its own mirror image.

use std::f64::consts::PI;

use super::SurfaceError;
use super::extents::Extents;
use crate::Point;
use crate::vector::{Vector3, squared_distance};

/// Images of the surface are kept as far from it as so many of its largest facets.
const IMAGES_REACH: f64 = 8.0;
/// Images that a set of planes may have within reach.
const MOST_IMAGES: usize = 512;
/// Nodes may lie as far behind a plane as this fraction of the smallest facet there.
const BEHIND: f64 = 0.01;
/// Planes may be as far as this off 180° over a whole number, radians.
const ANGLE_TOLERANCE: f64 = 1e-6;
/// Two images are one if their rotations differ by less than this, as those of planes within the tolerance do after so many reflections.
/// Others differ by more: of so many images around a line neighbours are 0.7° apart. Far from the line they must be off by less, so that
/// shifts agree as well.
const SAME_ROTATION: f64 = MOST_IMAGES as f64 * ANGLE_TOLERANCE;
/// A unit normal may be as long as this off 1.
const UNIT_TOLERANCE: f64 = 1e-9;
/// The square of a unit normal in double precision is as near to 1 as this.
const UNIT_ROUNDING: f64 = 8.0 * f64::EPSILON;

/// A plane in which everything is mirrored. The model lies on the side the normal points to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SymmetryPlane {
    /// A point of the plane.
    pub point: Point,
    /// Unit normal in nine digits or more, towards the model.
    pub normal: Point,
}

impl SymmetryPlane {
    /// The plane through `point` across a global axis, 0 to 2; the model lies on the side of larger coordinates.
    ///
    /// # Panics
    /// If there is no such axis.
    pub fn across(axis: usize, point: Point) -> Self {
        Self { point, normal: Vector3::axis(axis).into() }
    }

    /// Distance of a point, positive on the side of the model.
    fn distance(&self, x: Point) -> f64 {
        Vector3::from(self.normal).dot(&(Vector3::from(x) - Vector3::from(self.point)))
    }

    /// Where nodes with facets of these extents lie.
    fn heights(&self, nodes: &[Point], extents: &[f64]) -> Heights {
        let mut all = Heights::NONE;
        let mut least = f64::INFINITY;
        for (&x, &extent) in nodes.iter().zip(extents) {
            let height = self.distance(x);
            (all.low, all.high) = (all.low.min(height), all.high.max(height));
            let little = BEHIND * extent;
            all.is_below |= height < -little;
            all.is_above |= height > little;
            if height.abs() <= little {
                all.extent = all.extent.min(extent);
            }
            least = least.min(height.abs());
        }
        if all.extent.is_infinite() {
            // Of several that are as near the smallest, whatever their numbers.
            let nodes = nodes.iter().zip(extents);
            let nearest = nodes.filter(|&(&x, &extent)| self.distance(x).abs() <= least + ON_PLANE * extent);
            all.extent = nearest.map(|(_, &extent)| extent).fold(f64::INFINITY, f64::min);
        }
        let is_behind = if all.is_below == all.is_above { all.low + all.high < 0.0 } else { all.is_below };
        all.side = if is_behind { -1.0 } else { 1.0 };
        all
    }

    /// The least and the largest distance of the image of a box from `low` to `high`.
    fn interval(&self, image: &Image, [low, high]: [Point; 2]) -> (f64, f64) {
        let corner = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 0 { low[axis] } else { high[axis] });
        let distances = (0..8).map(|k| self.distance(image.of(corner(k))));
        distances.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
    }

    /// With a unit normal in all digits. One that is a unit vector but for rounding stays as it is.
    fn normalised(mut self) -> Self {
        let normal = Vector3::from(self.normal);
        if !((normal.norm_squared() - 1.0).abs() <= UNIT_ROUNDING) {
            self.normal = normal.normalize().into();
        }
        self
    }

    /// The same plane seen from another origin.
    fn seen_from(self, origin: Point) -> Self {
        Self { point: (Vector3::from(self.point) - Vector3::from(origin)).into(), ..self }
    }

    /// The reflection x → x − 2 (n·(x − p)) n. The normal has to be a unit vector in all digits.
    fn reflection(&self) -> Image {
        let n = self.normal;
        let along = Vector3::from(n).dot(&Vector3::from(self.point));
        let entry = |i: usize, j: usize| f64::from(u8::from(i == j)) - 2.0 * n[i] * n[j];
        Image { rows: [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j))), shift: n.map(|n| 2.0 * along * n) }
    }
}

/// Where the nodes of a surface lie, seen from a plane.
struct Heights {
    /// The least distance, positive on the side that the normal points to, and the largest one.
    low: f64,
    high: f64,
    /// Whether any is farther behind than nodes in the plane may be, …
    is_below: bool,
    /// … or as far in front.
    is_above: bool,
    /// 1 for a surface on the side that the normal points to, −1 for one on the other side.
    side: f64,
    /// The smallest extent of a facet at the plane, or else at the nearest node, length.
    extent: f64,
}

impl Heights {
    /// Of no node.
    const NONE: Self = Self {
        low: f64::INFINITY,
        high: f64::NEG_INFINITY,
        is_below: false,
        is_above: false,
        side: 1.0,
        extent: f64::INFINITY,
    };
}

/// An isometry x → Q x + t that maps the model on one of its images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Image {
    /// Q by rows.
    pub rows: [Point; 3],
    shift: Point,
}

impl Image {
    const IDENTITY: Self =
        Self { rows: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], shift: [0.0; 3] };

    /// Q x + t
    pub fn of(&self, x: Point) -> Point {
        [0, 1, 2].map(|i| Vector3::from(self.rows[i]).dot(&Vector3::from(x)) + self.shift[i])
    }

    /// x → self(other(x))
    fn after(&self, other: &Self) -> Self {
        let column = |j: usize| Vector3::from(other.rows.map(|row| row[j]));
        let entry = |i: usize, j: usize| Vector3::from(self.rows[i]).dot(&column(j));
        Self { rows: [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j))), shift: self.of(other.shift) }
    }

    /// Whether the two differ by no more than this, length, at the origin.
    fn is_same(&self, other: &Self, tolerance: f64) -> bool {
        let rows = self.rows.as_flattened().iter().zip(other.rows.as_flattened());
        let shifts = self.shift.iter().zip(&other.shift);
        rows.into_iter().all(|(x, y)| (x - y).abs() <= SAME_ROTATION)
            && shifts.into_iter().all(|(x, y)| (x - y).abs() <= tolerance)
    }
}

/// The planes of an interface with the images of the model in them, and in images of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Symmetry {
    planes: Vec<SymmetryPlane>,
    /// Without the model itself.
    images: Vec<Image>,
    /// Images farther away are left out, length.
    reach: f64,
    /// Points as near to a plane as this lie in it, length.
    tolerance: f64,
}

/// Points as near to a plane as this fraction of the largest radius lie in it.
const ON_PLANE: f64 = 1e-6;

impl Symmetry {
    /// The images that come within `reach` of the model, all of which lies in the box from `low` to `high`.
    ///
    /// # Errors
    /// [`SurfaceError::InvalidSymmetry`] for a plane whose normal is no unit vector; [`SurfaceError::TooManyImages`] for planes that are too
    /// near to one another.
    pub fn new(planes: &[SymmetryPlane], reach: f64, [low, high]: [Point; 2]) -> Result<Self, SurfaceError> {
        let (planes, tolerance) = (checked(planes)?, ON_PLANE * reach);
        // Which images are near, and which are one, is seen from the middle of the model. Far from the origin shifts lose their digits.
        let middle = [0, 1, 2].map(|axis| 0.5 * low[axis] + 0.5 * high[axis]);
        let around = [low, high].map(|x| [0, 1, 2].map(|axis| x[axis] - middle[axis]));
        let seen: Vec<SymmetryPlane> = planes.iter().map(|plane| plane.seen_from(middle)).collect();
        // Seen along the normal of any plane, the image has to be near the model.
        let is_near = |image: &Image| {
            seen.iter().all(|plane| {
                let [model, image] = [&Image::IDENTITY, image].map(|image| plane.interval(image, around));
                image.0 - model.1 <= reach && model.0 - image.1 <= reach
            })
        };
        let reflections: Vec<[Image; 2]> =
            planes.iter().zip(&seen).map(|(plane, seen)| [plane.reflection(), seen.reflection()]).collect();
        let mut all = vec![[Image::IDENTITY; 2]];
        let mut next = 0;
        while let Some(&[image, image_seen]) = all.get(next) {
            next += 1;
            for [reflection, reflection_seen] in &reflections {
                let other = reflection_seen.after(&image_seen);
                if is_near(&other) && !all.iter().any(|[_, known]| known.is_same(&other, tolerance)) {
                    all.push([reflection.after(&image), other]);
                }
            }
            if all.len() > MOST_IMAGES {
                return Err(SurfaceError::TooManyImages { images: MOST_IMAGES, reach });
            }
        }
        let images = all[1..].iter().map(|[image, _]| *image).collect();
        Ok(Self { planes, images, reach, tolerance })
    }

    /// The planes with the images near a whole surface.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn of_surface(planes: &[SymmetryPlane], extents: &Extents) -> Result<Self, SurfaceError> {
        if planes.is_empty() {
            return Ok(Self::default());
        }
        Self::new(planes, IMAGES_REACH * extents.facet, [extents.low, extents.high])
    }

    /// Refuses what cannot be planes of symmetry of a surface with these nodes: normals that are no unit vectors, nodes on both sides of a
    /// plane, and planes that do not meet at 180° over a whole number on the side of the nodes. Images would lie among the nodes. `extents`:
    /// of the smallest facet at each node.
    ///
    /// # Errors
    /// [`SurfaceError::InvalidSymmetry`], [`SurfaceError::CutBySymmetry`], [`SurfaceError::SymmetryAngle`].
    pub fn check_model(
        planes: &[SymmetryPlane],
        nodes: &[Point],
        extents: &[f64],
    ) -> Result<(), SurfaceError> {
        // Where all nodes lie in a plane, either side may be that of the model.
        let mut sides: Vec<(Vector3, bool)> = Vec::new();
        for (plane, symmetry) in checked(planes)?.iter().enumerate() {
            let Heights { low, high, is_below, is_above, side, .. } = symmetry.heights(nodes, extents);
            if is_below && is_above {
                return Err(SurfaceError::CutBySymmetry { plane, low, high });
            }
            sides.push((Vector3::from(symmetry.normal) * side, is_below || is_above));
        }
        for (second, (n, is_known)) in sides.iter().enumerate() {
            for (first, (m, is_other_known)) in sides[..second].iter().enumerate() {
                let angle = m.cross(n).norm().atan2(-m.dot(n));
                let is_one = |angle: f64| (angle - PI / (PI / angle).round()).abs() <= ANGLE_TOLERANCE;
                let is_parallel = angle.min(PI - angle) <= ANGLE_TOLERANCE;
                let is_certain = *is_known && *is_other_known;
                if !is_parallel && !is_one(angle) && (is_certain || !is_one(PI - angle)) {
                    let (planes, degrees) = ([first, second], angle.to_degrees());
                    return Err(SurfaceError::SymmetryAngle { planes, degrees });
                }
            }
        }
        Ok(())
    }

    /// The plane that one of these points is farthest behind, seen from a surface with these nodes: plane, place of the point and distance.
    /// `None` if all lie on the surface's side of all planes. `extents`: of the smallest facet at each node.
    ///
    /// # Errors
    /// [`SurfaceError::InvalidSymmetry`].
    pub fn farthest_behind(
        planes: &[SymmetryPlane],
        nodes: &[Point],
        extents: &[f64],
        points: impl Iterator<Item = Point> + Clone,
    ) -> Result<Option<(usize, usize, f64)>, SurfaceError> {
        let planes = checked(planes)?;
        let behind = planes.iter().enumerate().flat_map(|(number, plane)| {
            let Heights { side, extent, .. } = plane.heights(nodes, extents);
            let distances = points.clone().map(move |x| -plane.distance(x) * side);
            let all = distances.enumerate().map(move |(place, distance)| (number, place, distance));
            all.filter(move |&(.., distance)| distance > BEHIND * extent)
        });
        Ok(behind.max_by(|x, y| x.2.total_cmp(&y.2)))
    }

    /// The planes alone, for a surface whose largest facet has this extent: facets need no images.
    ///
    /// # Errors
    /// [`SurfaceError::InvalidSymmetry`].
    pub fn of_planes(planes: &[SymmetryPlane], facet: f64) -> Result<Self, SurfaceError> {
        let reach = IMAGES_REACH * facet;
        Ok(Self { planes: checked(planes)?, images: Vec::new(), reach, tolerance: ON_PLANE * reach })
    }

    pub fn is_none(&self) -> bool {
        self.planes.is_empty()
    }

    /// How far from the model its images may lie, length; infinite without planes.
    pub fn reach(&self) -> f64 {
        if self.is_none() { f64::INFINITY } else { self.reach }
    }

    /// Points nearer to one another than this are one.
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Images of a point, planes and their intersections together.
    pub fn count(&self) -> u32 {
        self.images.len() as u32
    }

    pub fn image(&self, number: u32) -> &Image {
        &self.images[number as usize]
    }

    /// The images of `node` that are other points than it and nearer to `centre` than `reach`, each once.
    pub fn images_near(&self, node: Point, centre: Point, reach: f64, mut found: impl FnMut(u32, Point)) {
        if self.planes.iter().all(|plane| plane.distance(centre) > reach) {
            return;
        }
        let near = |x: Point, y: Point, reach: f64| squared_distance(x, y) < reach * reach;
        for (number, image) in self.images.iter().enumerate() {
            let x = image.of(node);
            // A node in a plane is its own image there, and images in two planes may be one point.
            let is_new = || {
                let earlier = self.images[..number].iter().map(|image| image.of(node));
                std::iter::once(node).chain(earlier).all(|other| !near(x, other, self.tolerance))
            };
            if near(x, centre, reach) && is_new() {
                found(number as u32, x);
            }
        }
    }

    /// The images, other than the model itself, in which a node is where it is.
    pub fn images_at(&self, node: Point) -> impl Iterator<Item = &Image> {
        let near = self.tolerance * self.tolerance;
        self.images.iter().filter(move |image| squared_distance(image.of(node), node) < near)
    }

    /// The direction without what points out of the planes that hold `point`: that of the surface with its images there.
    pub fn within_planes(&self, point: Point, direction: Vector3) -> Vector3 {
        let holding = self.planes.iter().filter(|plane| plane.distance(point).abs() <= self.tolerance);
        // Planes meet at any whole part of 180°: their normals are made orthogonal first.
        let mut axes: Vec<Vector3> = Vec::new();
        let without = |axes: &[Vector3], x: Vector3| axes.iter().fold(x, |x, axis| x - *axis * axis.dot(&x));
        for plane in holding {
            let rest = without(&axes, Vector3::from(plane.normal));
            if rest.norm() > SAME_ROTATION {
                axes.push(rest.normalize());
            }
        }
        without(&axes, direction)
    }

    /// The cosine of the angle between a facet and its image across a plane that holds an edge of it; 1 without one.
    pub fn cosine_across(&self, ends: [Point; 2], normal: Vector3) -> f64 {
        let is_in = |plane: &&SymmetryPlane| ends.iter().all(|&x| plane.distance(x).abs() <= self.tolerance);
        let out_of = |plane: &SymmetryPlane| normal.dot(&Vector3::from(plane.normal));
        self.planes.iter().filter(is_in).map(|plane| 1.0 - 2.0 * out_of(plane).powi(2)).fold(1.0, f64::min)
    }

    /// Whether both ends of an edge lie in one of the planes: the surface does not end there.
    pub fn holds_edge(&self, ends: [Point; 2]) -> bool {
        self.planes.iter().any(|plane| ends.iter().all(|&x| plane.distance(x).abs() <= self.tolerance))
    }
}

/// The planes with unit normals in all digits. Refuses those whose normal is no unit vector.
fn checked(planes: &[SymmetryPlane]) -> Result<Vec<SymmetryPlane>, SurfaceError> {
    for (plane, symmetry) in planes.iter().enumerate() {
        let length = Vector3::from(symmetry.normal).norm();
        if !((length - 1.0).abs() <= UNIT_TOLERANCE && symmetry.point.iter().all(|x| x.is_finite())) {
            return Err(SurfaceError::InvalidSymmetry { plane, length });
        }
    }
    Ok(planes.iter().map(|plane| plane.normalised()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn images(planes: &[SymmetryPlane], node: Point, centre: Point, reach: f64) -> Vec<Point> {
        let symmetry = Symmetry::new(planes, reach, [[0.0; 3], [1.0; 3]]).unwrap();
        let mut all = Vec::new();
        symmetry.images_near(node, centre, reach, |_, x| all.push(x));
        all.sort_by(|x, y| x.partial_cmp(y).unwrap());
        all
    }

    #[test]
    fn directions_lie_in_all_planes_that_hold_a_point() {
        let (sin, cos) = 1.1_f64.sin_cos();
        let planes = [
            SymmetryPlane::across(0, [0.0; 3]),
            SymmetryPlane { point: [0.0; 3], normal: [cos, sin, 0.0] },
            SymmetryPlane::across(0, [5.0, 0.0, 0.0]),
        ];
        let symmetry = Symmetry::of_planes(&planes, 0.125).unwrap();
        let at = |point: Point| symmetry.within_planes(point, Vector3::from([0.3, -0.7, 0.2]));
        assert!((at([0.0, 0.0, 4.0]) - Vector3::from([0.0, 0.0, 0.2])).norm() < 1e-15);
        assert_eq!(at([0.0, 2.0, 4.0]), Vector3::from([0.0, -0.7, 0.2]));
        assert_eq!(at([3.0, 2.0, 4.0]), Vector3::from([0.3, -0.7, 0.2]));
    }

    #[test]
    fn planes_across_each_other_have_three_images() {
        let planes = [SymmetryPlane::across(0, [0.0; 3]), SymmetryPlane::across(1, [0.0; 3])];
        let found = images(&planes, [0.3, 0.2, 0.7], [0.1, 0.1, 0.7], 2.0);
        assert_eq!(found, [[-0.3, -0.2, 0.7], [-0.3, 0.2, 0.7], [0.3, -0.2, 0.7]]);
        // A node in one of the planes has one image, in the other; one in both has none.
        assert_eq!(images(&planes, [0.0, 0.2, 0.7], [0.1, 0.1, 0.7], 2.0), [[0.0, -0.2, 0.7]]);
        assert!(images(&planes, [0.0, 0.0, 0.7], [0.1, 0.1, 0.7], 2.0).is_empty());
    }

    #[test]
    fn between_parallel_planes_there_are_images_of_images() {
        let opposite = SymmetryPlane { point: [1.0, 0.0, 0.0], normal: [-1.0, 0.0, 0.0] };
        let planes = [SymmetryPlane::across(0, [0.0; 3]), opposite];
        let found = images(&planes, [0.25, 0.0, 0.0], [0.5, 0.0, 0.0], 2.6);
        let expected = [-1.75, -0.25, 1.75, 2.25];
        let all: Vec<f64> = found.iter().map(|x| x[0]).collect();
        assert_eq!(all.len(), expected.len(), "{all:?}");
        for (x, y) in all.iter().zip(expected) {
            assert!((x - y).abs() < 1e-15);
        }
    }

    /// Numbers that were written with so few digits are accepted, and leave no images that are almost the model.
    #[test]
    fn normals_of_few_digits_have_the_images_of_unit_vectors() {
        let rounded =
            |x: Point, digits: i32| x.map(|x| (x * 10_f64.powi(digits)).round() / 10_f64.powi(digits));
        let oblique = |degrees: f64| [degrees.to_radians().cos(), degrees.to_radians().sin(), 0.0];
        let model = |at: Point| [at.map(|x| x + 1.0), at.map(|x| x + 9.0)];
        for degrees in [45.0, 36.87, 71.3] {
            let n = oblique(degrees);
            for (digits, away) in [(9, 0.0), (9, 1.0), (9, 1e3), (10, 1e3), (11, 1e3), (15, 1e8), (17, 1e8)] {
                let at = n.map(|x| away * x);
                let plane = SymmetryPlane { point: at, normal: rounded(n, digits) };
                let symmetry = Symmetry::new(&[plane], 8.0, model(at)).unwrap();
                assert_eq!(symmetry.count(), 1, "{degrees} {digits} {away}");
                let mirrored = symmetry.image(0).of(at.map(|x| x + 1.0));
                let back = symmetry.image(0).of(mirrored);
                assert!(squared_distance(back, at.map(|x| x + 1.0)).sqrt() <= 1e-14 * (1.0 + away));
            }
        }
        for (parts, digits) in (2..12).flat_map(|parts| [(parts, 9), (parts, 10), (parts, 16)]) {
            let angle = PI / f64::from(parts);
            let other =
                SymmetryPlane { point: [0.0; 3], normal: rounded([angle.sin(), -angle.cos(), 0.0], digits) };
            let (sin, cos) = (0.5 * angle).sin_cos();
            let model = [[20.0 * cos, 20.0 * sin, 0.0], [20.0 * cos + 0.1, 20.0 * sin + 0.1, 1.0]];
            let planes = [SymmetryPlane::across(1, [0.0; 3]), other];
            let symmetry = Symmetry::new(&planes, 80.0, model).unwrap();
            assert_eq!(symmetry.count(), 2 * parts - 1, "{parts} {digits}");
        }
    }

    #[test]
    fn planes_at_another_angle_or_too_near_are_refused() {
        // Two planes with the model between them, at an angle in degrees.
        let at = |degrees: f64| {
            let (s, c) = degrees.to_radians().sin_cos();
            let other = SymmetryPlane { point: [0.0; 3], normal: [s, -c, 0.0] };
            let (s, c) = (0.5 * degrees).to_radians().sin_cos();
            let model = [[5.0 * c, 5.0 * s, 0.0], [5.0 * c + 0.1, 5.0 * s + 0.1, 1.0]];
            let planes = [SymmetryPlane::across(1, [0.0; 3]), other];
            Symmetry::check_model(&planes, &model, &[1.0; 2])?;
            Symmetry::new(&planes, 20.0, model)
        };
        for parts in 2..20 {
            let symmetry = at(180.0 / f64::from(parts)).unwrap();
            assert_eq!(symmetry.images.len(), 2 * parts as usize - 1, "{parts}");
        }
        for degrees in [17.0, 50.0, 72.0, 100.0, 120.0, 135.0] {
            let error = at(degrees).unwrap_err();
            let SurfaceError::SymmetryAngle { planes: [0, 1], degrees: found } = error else {
                panic!("{error}");
            };
            assert!((found - degrees).abs() < 1e-9);
        }
        // The normals may point away from the model.
        let flipped = |k: f64| SymmetryPlane { point: [0.0; 3], normal: [k, 0.0, 0.0] };
        let model = [[1.0, 1.0, 0.0], [2.0; 3]];
        let planes = [flipped(-1.0), SymmetryPlane { point: [0.0; 3], normal: [-0.6, 0.8, 0.0] }];
        let error = Symmetry::check_model(&planes, &model, &[1.0; 2]).unwrap_err();
        assert!(error.to_string().contains("53.13"), "{error}");
        // Wedges, given by their corners, with normals towards them and away.
        for degrees in [22.5, 30.0, 45.0, 60.0_f64] {
            let (s, c) = degrees.to_radians().sin_cos();
            for side in [-1.0, 1.0] {
                let other = SymmetryPlane { point: [0.0; 3], normal: [side * s, -side * c, 0.0] };
                let planes = [SymmetryPlane::across(1, [0.0; 3]), other];
                let wedge = [[0.0; 3], [40.0, 0.0, 0.0], [40.0, 40.0 * s / c + 1e-7, 1.0]];
                assert_eq!(Symmetry::check_model(&planes, &wedge, &[1.0; 3]), Ok(()), "{degrees}");
            }
        }
        // The middle of the box around a thin plate lies on the other side of the plane that it ends in.
        let third = 1.0 / 3.0_f64.sqrt();
        let along = [2.0, -1.0, -1.0].map(|x: f64| x / 6.0_f64.sqrt());
        let sin = 60.0_f64.to_radians().sin();
        let planes = [
            SymmetryPlane { point: [0.0; 3], normal: [third; 3] },
            SymmetryPlane {
                point: [0, 1, 2].map(|axis| 3.5 * along[axis]),
                normal: along.map(|x| 0.5 * third - sin * x),
            },
        ];
        let corners = [[2.0, -1.0, -1.0], [-1.0, 2.0, -1.0], [-1.0, -1.0, 2.0]];
        let plate: Vec<Point> = corners.into_iter().chain(corners.map(|x| x.map(|x| x - 0.1))).collect();
        assert_eq!(Symmetry::check_model(&planes, &plate, &[1.0; 6]), Ok(()));
        let thin = SymmetryPlane { point: [0.001, 0.0, 0.0], normal: [-1.0, 0.0, 0.0] };
        let error = Symmetry::new(&[flipped(1.0), thin], 1.0, [[0.0; 3], [0.001, 1.0, 1.0]]).unwrap_err();
        assert!(matches!(error, SurfaceError::TooManyImages { images: MOST_IMAGES, .. }));
        let long = SymmetryPlane { point: [0.0; 3], normal: [0.0, 2.0, 0.0] };
        let error = Symmetry::new(&[long], 1.0, [[0.0; 3], [1.0; 3]]).unwrap_err();
        assert_eq!(error, SurfaceError::InvalidSymmetry { plane: 0, length: 2.0 });
    }
}
