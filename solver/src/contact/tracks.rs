//! How slaves have moved against the facets that they were over when an increment began.

use diffuse_contact::Point;
use diffuse_contact::faces::{FaceCover, FaceInterface};
use diffuse_contact::interface::NoContact;
use diffuse_contact::surface::{Facet, MasterSurface, SurfaceIndex};
use nalgebra::Vector3;

/// Positions of all nodes when an increment began, and now.
#[derive(Clone, Copy, Debug)]
pub struct Way<'a> {
    /// When the increment began.
    pub from: &'a [Point],
    /// Now.
    pub to: &'a [Point],
}

/// How a slave that has nothing over it any more has moved against the facet that it was over when the increment began, or of its faces the
/// place that went deepest.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub enum Parted {
    /// It rose from it, or there is no such facet.
    Opened,
    /// It lies below its plane, but moved along it, or by little.
    Along,
    /// It went down, by more than along it and by more than half of the least of a facet, of how far masters are looked for, and of how deep
    /// slaves are found below the facet.
    Through {
        /// How deep it lies below the facet's plane, length.
        depth: f64,
    },
}

impl Parted {
    /// The same of what moved along.
    const fn at_most_along(self) -> Self {
        if let Self::Through { .. } = self { Self::Along } else { self }
    }
}

/// The part of a facet's extent, of how far masters are looked for, or of how deep slaves are found below the facet, whichever is least, that
/// nobody penetrates and stays on his side. It is a part of the last, too: over faces their points are found, which may lie deeper than nodes.
const THROUGH: f64 = 0.5;

/// How what a slave was over is found.
#[derive(Clone, Copy)]
pub enum Finder<'a> {
    /// It is the closest facet.
    Closest,
    /// The slaves are the master's own nodes: it is the closest facet that looks against the slave.
    ClosestOwn,
    /// By what its faces lay over.
    Faces(&'a FaceInterface, &'a FaceCover),
}

/// What slaves of a pass were over when the increment began; looked up when the first one asks.
pub struct Tracks<'a> {
    way: Way<'a>,
    master: &'a MasterSurface,
    finder: Finder<'a>,
    start: Option<Option<Start<'a>>>,
}

/// What is asked of the surfaces as they were when the increment began.
enum Start<'a> {
    Closest(SurfaceIndex<'a>),
    Own(Own),
    Faces(&'a FaceInterface, &'a FaceCover, SurfaceIndex<'a>),
}

impl<'a> Start<'a> {
    fn at(positions: &[Point], master: &'a MasterSurface, finder: Finder<'a>) -> Option<Self> {
        Some(match finder {
            Finder::Closest => Self::Closest(master.at(positions).ok()?),
            Finder::ClosestOwn => Self::Own(Own::at(master, positions)?),
            Finder::Faces(interface, cover) => Self::Faces(interface, cover, master.at(positions).ok()?),
        })
    }
}

impl<'a> Tracks<'a> {
    /// The slaves are those of this master.
    pub const fn new(way: Way<'a>, master: &'a MasterSurface, finder: Finder<'a>) -> Self {
        Self { way, master, finder, start: None }
    }

    /// How the slave in place `k` has moved, if it has no contact for this reason; over faces, how those around it have that lie over
    /// nothing any more.
    pub fn parted(&mut self, k: usize, node: usize, reason: Option<NoContact>) -> Parted {
        let Self { way, master, finder, ref mut start } = *self;
        let reach = match reason {
            Some(NoContact::TooFar { limit, .. } | NoContact::NothingOver { limit }) => limit,
            _ => f64::INFINITY,
        };
        // Most faces have their contact, and looking for what was below takes time.
        if let Finder::Faces(interface, cover) = finder
            && interface.uncovered(cover, k).next().is_none()
        {
            return Parted::Opened;
        }
        let start = start.get_or_insert_with(|| Start::at(way.from, master, finder));
        let (Some(start), Some(&slave)) = (start.as_ref(), way.from.get(node)) else { return Parted::Opened };
        let facet = match start {
            Start::Closest(index) => index.closest(slave).map(|closest| closest.facet),
            Start::Own(own) => {
                let place = master.nodes().binary_search(&(node as u32)).ok();
                place.and_then(|place| own.closest(slave, own.normals[place]))
            }
            Start::Faces(interface, cover, index) => {
                let moved = interface.uncovered(cover, k).map(|place| {
                    let at = [way.from, way.to].map(|positions| interface.position_of(&place, positions));
                    let facet = master.facet(place.facet);
                    // A face that slides over the top of a flank, or off it, comes below the flank's plane, too, but not as it looks.
                    let outwards = Vector3::from(interface.normal_of(&place, way.from));
                    let [first, last] =
                        [way.from, way.to].map(|positions| Plane::of(&facet, positions).middle);
                    let moved = Vector3::from(at[1]) - Vector3::from(at[0]) - (last - first);
                    let ahead = moved.dot(&outwards);
                    if !(ahead > (moved - outwards * ahead).norm()) {
                        return parted_from(&facet, way, at, || f64::INFINITY).at_most_along();
                    }
                    parted_from(&facet, way, at, || reach.min(interface.deepest(&place, index)))
                });
                let worst = |one: Parted, other: Parted| if other > one { other } else { one };
                return moved.fold(Parted::Opened, worst);
            }
        };
        let at = [way.from, way.to].map(|positions| positions[node]);
        facet.map_or(Parted::Opened, |facet| parted_from(&master.facet(facet), way, at, || reach))
    }
}

/// How a point has moved against a facet that it was over, on its way between two positions. `deepest`: how deep it may lie below and
/// still be found, length.
fn parted_from(facet: &Facet, way: Way<'_>, at: [Point; 2], deepest: impl FnOnce() -> f64) -> Parted {
    let Way { from, to } = way;
    let [(before, at_first), (now, at_last)] =
        [(from, at[0]), (to, at[1])].map(|(positions, x)| Plane::of(facet, positions).split(x));
    if !(now < 0.0) {
        return Parted::Opened;
    }
    let along = (at_last - at_first).norm();
    let is_through = before - now > along && -now > THROUGH * extent(facet, to).min(deepest());
    if is_through { Parted::Through { depth: -now } } else { Parted::Along }
}

/// A surface in contact with itself.
struct Own {
    /// Unit normals of its nodes.
    normals: Vec<Point>,
    /// The axis along which it is longest.
    axis: usize,
    /// The planes of the facets and their numbers, by their middles along the axis.
    planes: Vec<(Plane, usize)>,
}

impl Own {
    fn at(master: &MasterSurface, positions: &[Point]) -> Option<Self> {
        let normals = master.node_normals(positions).ok()?;
        let mut planes: Vec<(Plane, usize)> = (0..master.facet_count())
            .map(|facet| (Plane::of(&master.facet(facet), positions), facet))
            .collect();
        let axis = edges(planes.iter().map(|(plane, _)| plane.middle)).imax();
        planes.sort_by(|(one, _), (other, _)| one.middle[axis].total_cmp(&other.middle[axis]));
        Some(Self { normals, axis, planes })
    }

    /// The facet that looks against this normal and whose middle is closest: those around come first, and no other is farther along the
    /// axis than the closest is away.
    fn closest(&self, x: Point, normal: Point) -> Option<usize> {
        let (x, normal) = (Vector3::from(x), Vector3::from(normal));
        let offset = |(plane, _): &&(Plane, usize)| (plane.middle[self.axis] - x[self.axis]).abs();
        let (before, after) = self
            .planes
            .split_at(self.planes.partition_point(|(plane, _)| plane.middle[self.axis] < x[self.axis]));
        let (mut before, mut after) = (before.iter().rev().peekable(), after.iter().peekable());
        let mut closest: Option<(f64, usize)> = None;
        loop {
            let is_after = match (before.peek(), after.peek()) {
                (Some(one), Some(other)) => offset(other) < offset(one),
                (one, _) => one.is_none(),
            };
            let next = if is_after { after.next() } else { before.next() };
            let Some(entry @ (plane, facet)) = next else { break };
            if closest.is_some_and(|(distance, _)| offset(&entry) > distance) {
                break;
            }
            if plane.normal.dot(&normal) < 0.0 {
                let found = ((x - plane.middle).norm(), *facet);
                closest = Some(closest.map_or(found, |best| if found < best { found } else { best }));
            }
        }
        closest.map(|(_, facet)| facet)
    }
}

/// How many slaves lie behind the master at these positions, if all of them do but for those that lie beside it.
pub fn all_behind(slaves: &[usize], master: &MasterSurface, positions: &[Point]) -> usize {
    let Ok(index) = master.at(positions) else { return 0 };
    let mut count = 0;
    for &node in slaves {
        let Some(closest) = index.closest(positions[node]).filter(|closest| !closest.on_border) else {
            continue;
        };
        let (height, _) = Plane::of(&master.facet(closest.facet), positions).split(positions[node]);
        if !(height < 0.0) {
            return 0;
        }
        count += 1;
    }
    count
}

/// That of a facet.
#[derive(Clone, Copy, Debug)]
struct Plane {
    middle: Vector3<f64>,
    /// Of length one; no numbers without an area.
    normal: Vector3<f64>,
}

/// Twice the area vector of a facet, outward: the product of its diagonals, one of which is an edge on a triangle.
pub(super) fn twice_area_vector(facet: &Facet, positions: &[Point]) -> Vector3<f64> {
    let corners = facet.corners();
    let at = |k: usize| Vector3::from(positions[corners[k % corners.len()]]);
    (at(2) - at(0)).cross(&(at(3) - at(1)))
}

impl Plane {
    fn of(facet: &Facet, positions: &[Point]) -> Self {
        let corners = facet.corners();
        let at = |k: usize| Vector3::from(positions[corners[k % corners.len()]]);
        let middle = (0..corners.len()).map(at).sum::<Vector3<f64>>() / corners.len() as f64;
        Self { middle, normal: twice_area_vector(facet, positions).normalize() }
    }

    /// How high above the plane a point lies, and its offset from the middle along it.
    fn split(&self, x: Point) -> (f64, Vector3<f64>) {
        let offset = Vector3::from(x) - self.middle;
        let height = offset.dot(&self.normal);
        (height, offset - height * self.normal)
    }
}

/// The longest edge of the box around a facet.
fn extent(facet: &Facet, positions: &[Point]) -> f64 {
    edges(facet.corners().iter().map(|&node| Vector3::from(positions[node]))).max()
}

/// The edges of the box around some points.
fn edges(points: impl Iterator<Item = Vector3<f64>>) -> Vector3<f64> {
    let start = Vector3::repeat(f64::INFINITY);
    let (lower, upper) = points.fold((start, -start), |(lower, upper), x| (lower.inf(&x), upper.sup(&x)));
    upper - lower
}
