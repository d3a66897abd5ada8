//! Slaves that lose their contact under load.

use diffuse_contact::Point;
use diffuse_contact::interface::NoContact;
use diffuse_contact::surface::{Facet, MasterSurface, SurfaceIndex};

use super::ContactError;

/// Of each slave of a pass: whether it carried force in the increment on its way or right before it, and whether it may go
/// without its element from there on.
#[derive(Clone, Debug, Default)]
pub struct Losses {
    /// Who carried force right before the increment.
    before: Vec<bool>,
    carried: Vec<bool>,
    excused: Vec<bool>,
    /// Whether the slaves are the master's own nodes.
    is_own: bool,
}

/// A slave that carried force and has no contact, although it has not left its master.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LostContact {
    /// The slave node.
    pub node: usize,
    /// How it was lost.
    pub loss: Loss,
    /// Whether it had none as soon as it was paired at the increment's start: no shorter increment helps.
    pub from_start: bool,
}

/// How a slave that carried force comes to have no contact.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Loss {
    /// Its element has no result.
    #[error("{0}")]
    Element(NoContact),
    /// It went through the master, deeper than masters are looked for.
    #[error(
        "it went through the master and lies {depth:e} below the facet that it was over when the increment began"
    )]
    Through {
        /// How deep it lies below the plane of that facet, length.
        depth: f64,
    },
}

/// Positions of all nodes when an increment began, and now.
#[derive(Clone, Copy, Debug)]
pub struct Way<'a> {
    /// When the increment began.
    pub from: &'a [Point],
    /// Now.
    pub to: &'a [Point],
}

/// How a slave that has nothing over it any more has moved against the facet that it was over when the increment began.
enum Parted {
    /// It rose from it, or there is no such facet.
    Opened,
    /// It lies below its plane, but moved along it, or by little.
    Along,
    /// It went down, by more than along it and by more than half of a facet or half of how far masters are looked for.
    Through { depth: f64 },
}

/// The part of a facet's extent, or of how far masters are looked for if that is less, that nobody penetrates and stays on his side.
const THROUGH: f64 = 0.5;

/// Whether an element that should be there is not: a slave too far away or beyond a border has none by right, unless it went through.
pub const fn is_failure(reason: NoContact) -> bool {
    !matches!(
        reason,
        NoContact::TooFar { .. } | NoContact::BeyondBorder { .. } | NoContact::NothingOver { .. }
    )
}

impl Losses {
    /// `is_own`: whether the slaves are the master's own nodes.
    pub fn new(is_own: bool) -> Self {
        Self { is_own, ..Self::default() }
    }

    /// At the beginning of an increment. `loaded`: places of the slaves that carry force there.
    ///
    /// # Errors
    /// [`ContactError::OtherPasses`] if there is no such slave.
    pub fn begin(&mut self, slaves: usize, loaded: &[u32]) -> Result<(), ContactError> {
        if let Some(&last) = loaded.iter().max().filter(|&&last| last as usize >= slaves) {
            return Err(ContactError::OtherPasses { found: last as usize + 1, expected: slaves });
        }
        self.before.clear();
        self.before.resize(slaves, false);
        for &k in loaded {
            self.before[k as usize] = true;
        }
        self.carried.clone_from(&self.before);
        self.excused.clear();
        self.excused.resize(slaves, false);
        Ok(())
    }

    /// The slave in place `k` carries force.
    pub fn note(&mut self, k: usize) {
        if let Some(carried) = self.carried.get_mut(k) {
            *carried = true;
        }
    }

    /// The slave in place `k` has no element for this reason at the increment's start.
    pub fn excuse(&mut self, k: usize, reason: NoContact) {
        if let Some(excused) = self.excused.get_mut(k) {
            *excused = is_failure(reason);
        }
    }

    /// Where slaves were over this master when the increment began.
    pub fn tracks<'a>(&self, master: &'a MasterSurface, way: Way<'a>) -> Tracks<'a> {
        Tracks { way, master, is_own: self.is_own, start: None }
    }

    /// Whether the slave in place `k` carries force or did so since the increment began.
    fn carried(&self, k: usize) -> bool {
        self.carried.get(k).copied().unwrap_or(false)
    }

    /// Whether the slave in place `k`, which has no element for this reason, is one that was lost.
    pub fn judge(
        &self,
        k: usize,
        node: usize,
        reason: NoContact,
        tracks: &mut Tracks<'_>,
    ) -> Option<LostContact> {
        if !self.carried(k) {
            return None;
        }
        let loss = if is_failure(reason) {
            Loss::Element(reason)
        } else if let Parted::Through { depth } = tracks.parted(node, reason) {
            Loss::Through { depth }
        } else {
            return None;
        };
        Some(LostContact { node, loss, from_start: self.excused[k] })
    }

    /// Whether the slave in place `k` carried force when the increment began, has nothing over it now for this reason, and has not risen
    /// from its master.
    pub fn vanished(&self, k: usize, node: usize, reason: NoContact, tracks: &mut Tracks<'_>) -> bool {
        let before = self.before.get(k).copied().unwrap_or(false);
        before && (is_failure(reason) || !matches!(tracks.parted(node, reason), Parted::Opened))
    }
}

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
                let normal = normals[master.nodes().binary_search(&(node as u32)).ok()?];
                let opposite = planes.iter().enumerate().filter(|(_, plane)| dot(plane.normal, normal) < 0.0);
                let distance = |plane: &Plane| norm(between(plane.middle, slave));
                let closest = opposite.min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b)));
                closest?.0
            }
        };
        Some(master.facet(facet))
    }

    fn parted(&mut self, node: usize, reason: NoContact) -> Parted {
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
        let along = norm(between(at_first, at_last));
        let is_through = -now > least && before - now > along;
        if is_through { Parted::Through { depth: -now } } else { Parted::Along }
    }
}

/// That of a facet.
#[derive(Clone, Copy, Debug)]
struct Plane {
    middle: Point,
    /// Of length one; no numbers without an area.
    normal: Point,
}

impl Plane {
    fn of(facet: &Facet, positions: &[Point]) -> Self {
        let corners = facet.corners();
        let at = |k: usize| positions[corners[k % corners.len()]];
        let mut middle = [0.0; 3];
        for k in 0..corners.len() {
            (0..3).for_each(|axis| middle[axis] += at(k)[axis] / corners.len() as f64);
        }
        // Of the diagonals, one of which is an edge on a triangle.
        let (a, b) = (between(at(0), at(2)), between(at(1), at(3)));
        let normal = [0, 1, 2].map(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3]);
        let size = norm(normal);
        Self { middle, normal: normal.map(|x| x / size) }
    }

    /// How high above the plane a point lies, and its offset from the middle along it.
    fn split(&self, x: Point) -> (f64, Point) {
        let offset = between(self.middle, x);
        let height = dot(offset, self.normal);
        (height, [0, 1, 2].map(|axis| offset[axis] - height * self.normal[axis]))
    }
}

fn between(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|axis| b[axis] - a[axis])
}

fn dot(a: Point, b: Point) -> f64 {
    (0..3).map(|axis| a[axis] * b[axis]).sum()
}

fn norm(a: Point) -> f64 {
    dot(a, a).sqrt()
}

/// The longest edge of the box around a facet.
fn extent(facet: &Facet, positions: &[Point]) -> f64 {
    let width = |axis: usize| {
        let along = || facet.corners().iter().map(|&node| positions[node][axis]);
        along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
    };
    (0..3).map(width).fold(0.0, f64::max)
}
