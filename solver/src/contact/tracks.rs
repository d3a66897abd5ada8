//! How slaves have moved against the facets that they were over when an increment began.

use diffuse_contact::Point;
use diffuse_contact::faces::FaceInterface;
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

/// How a slave that has nothing over it any more has moved against the facet that it was over when the increment began.
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
    /// By what its faces may touch, and how deep.
    Faces(&'a FaceInterface),
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
    Faces(&'a FaceInterface, SurfaceIndex<'a>),
}

impl<'a> Start<'a> {
    fn at(positions: &[Point], master: &'a MasterSurface, finder: Finder<'a>) -> Option<Self> {
        Some(match finder {
            Finder::Closest => Self::Closest(master.at(positions).ok()?),
            Finder::ClosestOwn => Self::Own(Own::at(master, positions)?),
            Finder::Faces(interface) => Self::Faces(interface, master.at(positions).ok()?),
        })
    }
}

impl<'a> Tracks<'a> {
    /// The slaves are those of this master.
    pub const fn new(way: Way<'a>, master: &'a MasterSurface, finder: Finder<'a>) -> Self {
        Self { way, master, finder, start: None }
    }

    /// The facet that the slave in place `k` was over, and how deep below it slaves are found, length.
    fn over(&mut self, k: usize, node: usize) -> Option<(usize, f64)> {
        let Self { way: Way { from, .. }, master, finder, ref mut start } = *self;
        let start = start.get_or_insert_with(|| Start::at(from, master, finder)).as_ref()?;
        let &slave = from.get(node)?;
        match start {
            Start::Closest(index) => Some((index.closest(slave)?.facet, f64::INFINITY)),
            Start::Own(own) => {
                let place = master.nodes().binary_search(&(node as u32)).ok()?;
                Some((own.closest(slave, own.normals[place])?, f64::INFINITY))
            }
            Start::Faces(interface, index) => interface.facet_over(k, index, from),
        }
    }

    /// How the slave in place `k`, which has no contact for this reason, has moved.
    pub fn parted(&mut self, k: usize, node: usize, reason: NoContact) -> Parted {
        let Some((facet, deepest)) = self.over(k, node) else { return Parted::Opened };
        let facet = self.master.facet(facet);
        let Way { from, to } = self.way;
        let [(before, at_first), (now, at_last)] =
            [from, to].map(|positions| Plane::of(&facet, positions).split(positions[node]));
        if !(now < 0.0) {
            return Parted::Opened;
        }
        let reach = match reason {
            NoContact::TooFar { limit, .. } | NoContact::NothingOver { limit } => limit,
            _ => f64::INFINITY,
        };
        let least = THROUGH * reach.min(deepest).min(extent(&facet, to));
        let along = (at_last - at_first).norm();
        let is_through = -now > least && before - now > along;
        if is_through { Parted::Through { depth: -now } } else { Parted::Along }
    }
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
        let start = Vector3::repeat(f64::INFINITY);
        let middles = || planes.iter().map(|(plane, _)| plane.middle);
        let lower = middles().fold(start, |lower, x| lower.inf(&x));
        let upper = middles().fold(-start, |upper, x| upper.sup(&x));
        let axis = (upper - lower).imax();
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

impl Plane {
    fn of(facet: &Facet, positions: &[Point]) -> Self {
        let corners = facet.corners();
        let at = |k: usize| Vector3::from(positions[corners[k % corners.len()]]);
        let middle = (0..corners.len()).map(at).sum::<Vector3<f64>>() / corners.len() as f64;
        // Of the diagonals, one of which is an edge on a triangle.
        let normal = (at(2) - at(0)).cross(&(at(3) - at(1))).normalize();
        Self { middle, normal }
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
    let corners = || facet.corners().iter().map(|&node| Vector3::from(positions[node]));
    let start = Vector3::repeat(f64::INFINITY);
    let lower = corners().fold(start, |lower, x| lower.inf(&x));
    let upper = corners().fold(-start, |upper, x| upper.sup(&x));
    (upper - lower).max()
}
