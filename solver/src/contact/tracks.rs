//! How slaves have moved against the facets that they were over when an increment began.

use diffuse_contact::Point;
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
    /// It went down, by more than along it and by more than half of a facet or half of how far masters are looked for.
    Through {
        /// How deep it lies below the facet's plane, length.
        depth: f64,
    },
}

/// The part of a facet's extent, or of how far masters are looked for if that is less, that nobody penetrates and stays on his side.
const THROUGH: f64 = 0.5;

/// What slaves of a pass were over when the increment began; looked up when the first one asks.
pub struct Tracks<'a> {
    way: Way<'a>,
    master: &'a MasterSurface,
    /// Whether the slaves are the master's own nodes.
    is_own: bool,
    start: Option<Option<Start<'a>>>,
}

enum Start<'a> {
    OfOthers(SurfaceIndex<'a>),
    /// Unit normals of the master's nodes, and the plane of each facet.
    OfOwn(Vec<Point>, Vec<Plane>),
}

impl<'a> Tracks<'a> {
    /// `is_own`: whether the slaves are the master's own nodes.
    pub fn new(way: Way<'a>, master: &'a MasterSurface, is_own: bool) -> Self {
        Self { way, master, is_own, start: None }
    }

    /// The facet that a slave was over: the closest one, of a surface in contact with itself the closest that looks against the slave.
    fn facet(&mut self, node: usize) -> Option<Facet> {
        let Self { way: Way { from, .. }, master, is_own, ref mut start } = *self;
        let begin = || {
            if !is_own {
                return master.at(from).ok().map(Start::OfOthers);
            }
            let facets = 0..master.facet_count();
            let planes = facets.map(|facet| Plane::of(&master.facet(facet), from)).collect();
            Some(Start::OfOwn(master.node_normals(from).ok()?, planes))
        };
        let &slave = from.get(node)?;
        let facet = match start.get_or_insert_with(begin).as_ref()? {
            Start::OfOthers(index) => index.closest(slave)?.facet,
            Start::OfOwn(normals, planes) => {
                let normal = Vector3::from(normals[master.nodes().binary_search(&(node as u32)).ok()?]);
                let opposite = planes.iter().enumerate().filter(|(_, plane)| plane.normal.dot(&normal) < 0.0);
                let distance = |plane: &Plane| (Vector3::from(slave) - plane.middle).norm();
                let closest = opposite.min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b)));
                closest?.0
            }
        };
        Some(master.facet(facet))
    }

    /// How a slave that has no contact for this reason has moved.
    pub fn parted(&mut self, node: usize, reason: NoContact) -> Parted {
        let Some(facet) = self.facet(node) else { return Parted::Opened };
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
        let least = THROUGH * reach.min(extent(&facet, to));
        let along = (at_last - at_first).norm();
        let is_through = -now > least && before - now > along;
        if is_through { Parted::Through { depth: -now } } else { Parted::Along }
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
