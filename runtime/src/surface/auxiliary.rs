//! Auxiliary points, which fits along a strip of one row of cells take beside nodes.
//!
//! Two rows of nodes carry no quadratic surface across. A third row is on the *rungs*: the edges across the strip. It is as straight between
//! the nodes as the facets are. Where the strip is wide it is in the middles of rungs. Where the strip is narrow and bends, nodes would spread
//! more along the normal than across, and their average plane would be none of the strip. There two rows of ghost nodes lie outside: beyond
//! each end of a rung, by its length.
//!
//! A rung is an edge inside a sheet around which all corners lie on the end of the sheet. A triangle has such edges along diagonals, too: of
//! them only that counts which is the shortest of one of its triangles. Where a strip ends with a quadrilateral the edge opposite to its rung
//! is one as well.

use super::sheet_nodes::SheetNodes;
use super::topology::NONE;
use super::{Creases, Image, SurfaceIndex, Symmetry};
use crate::Point;
use crate::vector::Vector3;

/// Edges as long as the shortest of a triangle to this fraction are as short.
const AS_SHORT: f64 = 1e-6;
/// Where a rung is so many times as long as the strip drops over the length of a facet, the strip is wide.
const WIDE: f64 = 1.0;
/// The same, where it is too narrow for ghost nodes.
const NARROWEST: f64 = 0.6;

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
    /// Beyond the first end, as far from it as the second.
    Ghost,
}

impl Auxiliary {
    /// The first end's part of the point; the second has what is missing to 1.
    pub const fn part(&self) -> f64 {
        match self.kind {
            AuxiliaryKind::Middle => 0.5,
            AuxiliaryKind::Ghost => 2.0,
        }
    }

    /// Where it is with the ends at these positions.
    pub fn position(&self, ends: [Point; 2]) -> Point {
        between(self.part(), ends)
    }
}

/// p x + (1 − p) y; of p = 1 it is x, to the bit.
pub(crate) fn between(part: f64, [x, y]: [Point; 2]) -> Point {
    if part == 1.0 { x } else { [0, 1, 2].map(|k| part * x[k] + (1.0 - part) * y[k]) }
}

/// Whether an edge is a rung, and with which points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rung {
    No,
    /// That depends on facets which are not there.
    Unknown,
    Middle,
    Ghosts,
}

impl Rung {
    /// The auxiliary points of a rung with these ends.
    pub fn points(self, [from, to]: [u32; 2]) -> impl Iterator<Item = Auxiliary> {
        let point = |ends, kind| Some(Auxiliary { ends, kind });
        let points = match self {
            Self::No | Self::Unknown => [None, None],
            Self::Middle => [point([from.min(to), from.max(to)], AuxiliaryKind::Middle), None],
            Self::Ghosts => [[from, to], [to, from]].map(|ends| point(ends, AuxiliaryKind::Ghost)),
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
    let rungs = Rungs { index, creases, symmetry, is_between };
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
    creases: &'a Creases,
    symmetry: &'a Symmetry,
    /// By facet, whether all its corners lie on the end of its sheet; `None` where that is not known.
    is_between: Vec<Option<bool>>,
}

impl Rungs<'_> {
    fn of_edge(&self, facet: usize, edge: usize) -> Rung {
        let is_quadrilateral = self.index.surface().corners_of(facet).len() == 4;
        if self.creases.ends_at(facet, edge) && is_quadrilateral {
            self.of_edge_inside(facet, (edge + 2) % 4)
        } else {
            self.of_edge_inside(facet, edge)
        }
    }

    fn of_edge_inside(&self, facet: usize, edge: usize) -> Rung {
        match self.is_inside(facet, edge) {
            Some(true) => {}
            Some(false) => return Rung::No,
            None => return Rung::Unknown,
        }
        let other = self.index.surface().across(facet)[edge];
        let sides = [Some((facet, edge)), self.same_edge(facet, other)];
        let mut sides = sides.into_iter().flatten().map(|(facet, edge)| self.is_shortest(facet, edge));
        let is_one = sides.clone().any(|is| is == Some(true));
        if !is_one {
            return if sides.any(|is| is.is_none()) { Rung::Unknown } else { Rung::No };
        }
        let shape = self.index.shape(facet as u32);
        let [from, to] = shape.edge(edge);
        match self.largest_drop(facet, edge) {
            None => Rung::Unknown,
            Some(drop) if (to - from).norm() >= WIDE * drop => Rung::Middle,
            Some(drop) if (to - from).norm() >= NARROWEST * drop => Rung::Ghosts,
            Some(_) => Rung::No,
        }
    }

    /// The largest drop at the edges inside of both facets at an edge: diagonals lie within bent cells.
    fn largest_drop(&self, facet: usize, edge: usize) -> Option<f64> {
        let other = self.index.surface().across(facet)[edge];
        let facets = [Some(facet), (other != NONE).then_some(other as usize)];
        let mut largest = 0.0_f64;
        for facet in facets.into_iter().flatten() {
            for edge in 0..self.index.shape(facet as u32).corners().len() {
                if self.is_inside(facet, edge)? {
                    largest = largest.max(self.drop(facet, edge));
                }
            }
        }
        Some(largest)
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

    /// Whether no edge inside is shorter of a triangle; of quadrilaterals rungs are opposite.
    fn is_shortest(&self, facet: usize, edge: usize) -> Option<bool> {
        let shape = self.index.shape(facet as u32);
        let length = |edge: usize| {
            let [from, to] = shape.edge(edge);
            (to - from).norm()
        };
        let count = shape.corners().len();
        let is_shorter = |other: &usize| length(*other) * (1.0 + AS_SHORT) < length(edge);
        let shorter = (0..count).filter(|_| count == 3).filter(is_shorter);
        let mut inside = shorter.map(|other| self.is_inside(facet, other));
        if inside.clone().any(|is| is == Some(true)) {
            Some(false)
        } else if inside.any(|is| is.is_none()) {
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
