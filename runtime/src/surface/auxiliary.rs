//! Auxiliary points, which fits along a strip of one row of cells take beside nodes.
//!
//! Two rows of nodes carry no quadratic surface across. A third row is on the *rungs*: the edges across the strip. It is as straight between
//! the nodes as the facets are. Where the strip is wide it is in the middles of rungs. Along a strip that is narrow for its bend, nodes would
//! spread more along the normal than across, and their average plane would be none of the strip. So there two rows of ghost nodes lie outside,
//! beyond each end of a rung, at about the length of a facet. Ghost nodes have to stay beside their strip: where it turns
//! in its own surface, at corners and forks and along the inside of narrow rings, the third row is in the middles.
//!
//! A rung is an edge inside a sheet around which all corners lie on the end of the sheet. A triangle has such edges along diagonals, too: of
//! them only that counts which is the shortest of one of its triangles. The edge at which a strip ends is one as well.

use super::sheet_nodes::SheetNodes;
use super::topology::NONE;
use super::{Creases, Image, SurfaceIndex, Symmetry};
use crate::Point;
use crate::vector::Vector3;

/// What is as large as a bound to this fraction reaches it: meshes often have lengths that are equal, but for rounding.
const EQUAL: f64 = 1e-6;
/// Where a rung is so many times as long as a facet along the strip, or so many times as long as the strip drops over such a length, the strip
/// is wide.
const WIDE: f64 = 2.5;
const WIDE_FOR_ITS_BEND: f64 = 9.0;
/// Ghost nodes of neighbouring rungs keep this part of the distance between the nodes.
const APART: f64 = 0.5;
/// Borders along a strip lean towards its rungs by no more than 60°.
const ALONG: f64 = 0.5;
/// Ghost nodes are at most so many lengths of a rung beyond its ends.
const FARTHEST: u32 = 64;

/// An auxiliary point, on the line through the ends of a rung.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Auxiliary {
    /// The sheet nodes at the ends. Of a middle the lower is the first.
    pub ends: [u32; 2],
    pub kind: AuxiliaryKind,
}

/// Where an auxiliary point is on its line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum AuxiliaryKind {
    /// In the middle between the ends.
    Middle,
    /// Beyond the first end, so many times as far from it as the second.
    Ghost(u32),
}

/// Whether a length is as large as a bound.
fn reaches(length: f64, bound: f64) -> bool {
    length * (1.0 + EQUAL) >= bound
}

/// Where auxiliary points on the line through two nodes may be.
pub(super) fn possible_points([from, to]: [Vector3; 2]) -> impl Iterator<Item = Vector3> {
    let times = (0..=FARTHEST.ilog2()).map(|power| f64::from(1_u32 << power));
    let ghosts = times.flat_map(move |times| [from + (from - to) * times, to + (to - from) * times]);
    ghosts.chain([(from + to) / 2.0])
}

impl Auxiliary {
    /// The first end's part of the point; the second has what is missing to 1.
    pub fn part(&self) -> f64 {
        match self.kind {
            AuxiliaryKind::Middle => 0.5,
            AuxiliaryKind::Ghost(times) => 1.0 + f64::from(times),
        }
    }

    /// Where it is with the ends at these positions.
    pub fn position(&self, ends: [Point; 2]) -> Point {
        between(self.part(), ends)
    }
}

impl AuxiliaryKind {
    /// How many times its length beyond the rung; 0 in the middle.
    pub fn number(self) -> i64 {
        match self {
            Self::Middle => 0,
            Self::Ghost(times) => times.into(),
        }
    }

    /// That with this number.
    pub fn of(number: i64) -> Option<Self> {
        match u32::try_from(number).ok()? {
            0 => Some(Self::Middle),
            times if times <= FARTHEST => Some(Self::Ghost(times)),
            _ => None,
        }
    }
}

/// p x + (1 − p) y; of p = 1 it is x, to the bit.
pub(crate) fn between(part: f64, [x, y]: [Point; 2]) -> Point {
    [0, 1, 2].map(|k| x[k] + (part - 1.0) * (x[k] - y[k]))
}

/// Whether an edge is a rung, and with which points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rung {
    No,
    /// That depends on facets which are not there.
    Unknown,
    Middle,
    /// So many of its lengths beyond its ends.
    Ghosts(u32),
}

impl Rung {
    /// The auxiliary points of a rung with these ends.
    pub fn points(self, [from, to]: [u32; 2]) -> impl Iterator<Item = Auxiliary> {
        let point = |ends, kind| Some(Auxiliary { ends, kind });
        let points = match self {
            Self::No | Self::Unknown => [None, None],
            Self::Middle => [point([from.min(to), from.max(to)], AuxiliaryKind::Middle), None],
            Self::Ghosts(times) => {
                [[from, to], [to, from]].map(|ends| point(ends, AuxiliaryKind::Ghost(times)))
            }
        };
        points.into_iter().flatten()
    }
}

/// What the edges of each facet are; none where there is no rung. `is_complete`: whether all facets at a sheet node are there.
pub(super) fn rungs(
    nodes: &SheetNodes,
    index: &SurfaceIndex<'_>,
    creases: &Creases,
    symmetry: &Symmetry,
    is_complete: impl Fn(u32) -> bool,
) -> Vec<[Rung; 4]> {
    let surface = index.surface();
    let mut is_on_end = vec![false; nodes.places().len()];
    for facet in 0..surface.facet_count() as u32 {
        let own = nodes.of_facet(surface, facet);
        for edge in (0..own.len()).filter(|&edge| creases.ends_at(facet as usize, edge)) {
            is_on_end[own[edge] as usize] = true;
            is_on_end[own[(edge + 1) % own.len()] as usize] = true;
        }
    }
    let is_between = |facet: u32| {
        let mut inside = nodes.of_facet(surface, facet).iter().filter(|&&node| !is_on_end[node as usize]);
        match inside.clone().next() {
            None => Some(true),
            Some(_) if inside.any(|&node| is_complete(node)) => Some(false),
            Some(_) => None,
        }
    };
    let is_between: Vec<Option<bool>> = (0..surface.facet_count() as u32).map(is_between).collect();
    if is_between.iter().all(|&is| is == Some(false)) {
        return Vec::new();
    }
    let rungs = Rungs { index, nodes, creases, symmetry, is_complete: &is_complete, is_between };
    let of_facet = |facet: usize| {
        let mut edges = [Rung::No; 4];
        for (edge, rung) in edges.iter_mut().take(surface.corners_of(facet).len()).enumerate() {
            *rung = rungs.of_edge(facet, edge);
        }
        edges
    };
    (0..surface.facet_count()).map(of_facet).collect()
}

/// What rungs are found from.
struct Rungs<'a> {
    index: &'a SurfaceIndex<'a>,
    nodes: &'a SheetNodes,
    creases: &'a Creases,
    symmetry: &'a Symmetry,
    /// Whether all facets at a sheet node are there.
    is_complete: &'a dyn Fn(u32) -> bool,
    /// By facet, whether all its corners lie on the end of its sheet; `None` where that is not known.
    is_between: Vec<Option<bool>>,
}

impl Rungs<'_> {
    fn of_edge(&self, facet: usize, edge: usize) -> Rung {
        match self.is_across(facet, edge) {
            Some(true) => {}
            Some(false) => return Rung::No,
            None => return Rung::Unknown,
        }
        let is_inside = !self.creases.ends_at(facet, edge);
        let other = self.index.surface().across(facet)[edge];
        let beyond = if is_inside { self.same_edge(facet, other) } else { None };
        // Both facets see the edge from the same side, so that rounding does not make it another one.
        let (facet, edge, beyond) = match beyond {
            Some((lower, there)) if lower < facet => (lower, there, Some((facet, edge))),
            beyond => (facet, edge, beyond),
        };
        let sides = [Some((facet, edge)), beyond].into_iter().flatten();
        let mut is_one = sides.clone().map(|(facet, edge)| self.is_shortest(facet, edge));
        if !is_one.clone().any(|is| is == Some(true)) {
            return if is_one.any(|is| is.is_none()) { Rung::Unknown } else { Rung::No };
        }
        let shape = self.index.shape(facet as u32);
        let [from, to] = shape.edge(edge);
        let width = (to - from).norm();
        let Some(drop) = self.largest_drop(facet, edge) else { return Rung::Unknown };
        let length = sides.map(|(facet, edge)| self.length_along(facet, edge)).fold(0.0, f64::max);
        if reaches(width, WIDE * length) || reaches(width, WIDE_FOR_ITS_BEND * drop) {
            return Rung::Middle;
        }
        let mut times = 1;
        while !reaches(f64::from(times) * width, length) {
            times *= 2;
            if times > FARTHEST {
                return Rung::No;
            }
        }
        match self.keeps_apart(facet, edge, times.into()) {
            Some(true) => Rung::Ghosts(times),
            Some(false) => Rung::Middle,
            None => Rung::Unknown,
        }
    }

    /// The length of a facet along the strip.
    fn length_along(&self, facet: usize, edge: usize) -> f64 {
        let shape = self.index.shape(facet as u32);
        let [from, to] = shape.edge(edge);
        // The middle of a facet lies half its length from the edge, of a triangle a third.
        let part = if shape.corners().len() == 3 { 3.0 } else { 2.0 };
        let to_middle = shape.middle() - from;
        let across = (to - from).normalize();
        (to_middle - across * across.dot(&to_middle)).norm() * part
    }

    /// Whether ghost nodes so many times a rung's length outside are beside the strip, in the order of its rungs: the borders at both ends of
    /// the rung go along the strip, and so nearly side by side that their distances reach so far.
    fn keeps_apart(&self, facet: usize, edge: usize, times: f64) -> Option<bool> {
        let surface = self.index.surface();
        let own = self.nodes.of_facet(surface, facet as u32);
        let ends = [own[edge], own[(edge + 1) % own.len()]];
        if !ends.iter().all(|&node| (self.is_complete)(node)) {
            return None;
        }
        let shape = self.index.shape(facet as u32);
        let [from, to] = shape.edge(edge);
        let across = (to - from).normalize();
        let along = |x: Vector3| x - across * across.dot(&x);
        let borders = [0, 1].map(|end| self.borders(ends[end], ends[1 - end]));
        let forward = along(shape.middle() - from);
        let turned = |x: &Vector3| if x.dot(&forward) < 0.0 { *x * -1.0 } else { *x };
        let direction = along(borders.iter().flatten().map(turned).sum()).normalize();
        let goes_along = |x: &Vector3| reaches(x.dot(&direction).abs(), ALONG * x.norm());
        if !borders.iter().flatten().all(goes_along) {
            return Some(false);
        }
        let [one, two] = borders.map(|own| own.iter().map(|x| x.dot(&direction).abs()).sum::<f64>());
        let is_apart = |near: f64, far: f64| near + times * (near - far) >= (APART - EQUAL) * near;
        Some(is_apart(one, two) && is_apart(two, one))
    }

    /// The edges at a node with which its sheet ends, but for that to another node.
    fn borders(&self, node: u32, other: u32) -> Vec<Vector3> {
        let surface = self.index.surface();
        let mut all = Vec::new();
        for facet in self.nodes.facets(surface, node) {
            let (own, shape) = (self.nodes.of_facet(surface, facet), self.index.shape(facet));
            for edge in (0..own.len()).filter(|&edge| self.creases.ends_at(facet as usize, edge)) {
                let ([from, to], ends) = (shape.edge(edge), [own[edge], own[(edge + 1) % own.len()]]);
                if ends[0] == node && ends[1] != other {
                    all.push(to - from);
                } else if ends[1] == node && ends[0] != other {
                    all.push(from - to);
                }
            }
        }
        all
    }

    /// The largest drop at the edges inside of both facets at an edge, and of triangles next to them: a diagonal lies within a cell.
    fn largest_drop(&self, facet: usize, edge: usize) -> Option<f64> {
        let across = |facet: usize, edge: usize| {
            let other = self.index.surface().across(facet)[edge];
            (other != NONE && !self.creases.ends_at(facet, edge)).then_some(other as usize)
        };
        let mut facets: Vec<usize> = [Some(facet), across(facet, edge)].into_iter().flatten().collect();
        for own in facets.clone() {
            if self.index.shape(own as u32).corners().len() == 3 {
                facets.extend(self.inside(own)?.into_iter().filter_map(|edge| across(own, edge)));
            }
        }
        let mut largest = 0.0_f64;
        for facet in facets {
            for edge in self.inside(facet)? {
                largest = largest.max(self.drop(facet, edge));
            }
        }
        Some(largest)
    }

    /// Whether the edge is inside the strip, or is its end.
    fn is_across(&self, facet: usize, edge: usize) -> Option<bool> {
        if self.creases.ends_at(facet, edge) {
            self.is_last(facet, edge)
        } else {
            self.is_inside(facet, edge)
        }
    }

    /// Whether the strip ends at an edge: opposite to the only one inside of a quadrilateral, of a triangle that which leads away from the
    /// next one inside.
    fn is_last(&self, facet: usize, edge: usize) -> Option<bool> {
        let own = self.inside(facet)?;
        let &[inside] = &own[..] else { return Some(false) };
        let surface = self.index.surface();
        let count = surface.corners_of(facet).len();
        if count == 4 {
            return Some(edge == (inside + 2) % 4);
        }
        let Some((other, there)) = self.same_edge(facet, surface.across(facet)[inside]) else {
            return Some(false);
        };
        let next = self.inside(other)?;
        let mut next = next.into_iter().filter(|&edge| edge != there);
        let (Some(next), None) = (next.next(), next.next()) else { return Some(false) };
        let ends = |facet: usize, edge: usize| {
            let corners = surface.corners_of(facet);
            [corners[edge], corners[(edge + 1) % corners.len()]]
        };
        let shared = ends(other, next).into_iter().find(|node| ends(facet, inside).contains(node));
        Some(shared.is_some_and(|node| !ends(facet, edge).contains(&node)))
    }

    /// The edges inside a strip.
    fn inside(&self, facet: usize) -> Option<Vec<usize>> {
        let mut inside = Vec::new();
        for edge in 0..self.index.surface().corners_of(facet).len() {
            if self.is_inside(facet, edge)? {
                inside.push(edge);
            }
        }
        Some(inside)
    }

    /// The edge as the facet across has it.
    fn same_edge(&self, facet: usize, other: u32) -> Option<(usize, usize)> {
        let other = (other != NONE).then_some(other as usize)?;
        let across = self.index.surface().across(other);
        across.iter().position(|&own| own as usize == facet).map(|edge| (other, edge))
    }

    /// Whether the edge lies inside a sheet, and the corners of both its facets on the end of it.
    fn is_inside(&self, facet: usize, edge: usize) -> Option<bool> {
        let surface = self.index.surface();
        let other = surface.across(facet)[edge];
        if self.creases.ends_at(facet, edge) || self.is_between[facet] == Some(false) {
            return Some(false);
        }
        let beyond = if other != NONE {
            self.is_between[other as usize]
        } else if surface.is_cut(facet, edge) {
            None
        } else {
            // In a plane of symmetry: the facet's image.
            Some(true)
        };
        if beyond == Some(false) { beyond } else { self.is_between[facet].and(beyond) }
    }

    /// Whether no edge across is shorter of a triangle; of quadrilaterals rungs are opposite.
    fn is_shortest(&self, facet: usize, edge: usize) -> Option<bool> {
        let shape = self.index.shape(facet as u32);
        let length = |edge: usize| {
            let [from, to] = shape.edge(edge);
            (to - from).norm()
        };
        let count = shape.corners().len();
        let is_shorter = |other: &usize| !reaches(length(*other), length(edge));
        let shorter = (0..count).filter(|_| count == 3).filter(is_shorter);
        let mut across = shorter.map(|other| self.is_across(facet, other));
        if across.clone().any(|is| is == Some(true)) {
            Some(false)
        } else if across.any(|is| is.is_none()) {
            None
        } else {
            Some(true)
        }
    }

    /// How far the strip drops off the plane of one facet at an edge over the length of the next one.
    fn drop(&self, facet: usize, edge: usize) -> f64 {
        let other = self.index.surface().across(facet)[edge];
        let shape = self.index.shape(facet as u32);
        let [from, to] = shape.edge(edge);
        let middle = (from + to) / 2.0;
        // The middle of a facet lies half its length from the edge, of a triangle a third.
        let drop = |normal: Vector3, x: Vector3, count: usize| {
            normal.dot(&(x - middle)).abs() * if count == 3 { 3.0 } else { 2.0 }
        };
        let (own, normal, count) = (shape.middle(), self.index.normals()[facet], shape.corners().len());
        if other == NONE {
            // In a plane of symmetry the other one is the image.
            let stays = |image: &Image, x: Vector3| {
                (Vector3::from(image.of(x.into())) - x).norm() <= self.symmetry.tolerance()
            };
            let image =
                self.symmetry.images_at(from.into()).find(|image| stays(image, from) && stays(image, to));
            return image.map_or(0.0, |image| drop(normal, Vector3::from(image.of(own.into())), count));
        }
        let there = self.index.shape(other);
        let other = drop(self.index.normals()[other as usize], own, count);
        drop(normal, there.middle(), there.corners().len()).max(other)
    }
}
