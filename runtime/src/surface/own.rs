//! Contact of a surface with itself: which facets a node of it may touch.
//!
//! The nearest facets of a node are its own, and behind it lies the other side of the body. Neither can ever touch it. So a facet is a
//! candidate of a node only where
//!
//! * **it faces the node**: their normals are opposite;
//! * **it is far along the skin**: at least [`RINGS`] facets lie between them, and no fit over the facet has the node itself;
//! * **it is not its back**: in the first configuration neither lies right behind the other, up to [`BEHIND`] thicknesses of the body;
//! * **it is in front**: the node lies above the facet, and the facet above the node, or below it by no more than [`DEPTH`] of the
//!   thickness of the body, at the node and at the facet. Around a bend a wall's other side may face a node, too, but from behind;
//! * **it is below the node**, not farther aside than its own extent.
//!
//! Rings and thickness are those of the first configuration, too. In trial states of an iteration a wall may be squeezed to a part of its
//! thickness: what is its back cannot follow from positions of the moment.

use std::cmp::Ordering::Equal;

use rayon::prelude::*;

use super::index::Closest;
use super::shape::Foot;
use super::topology::NONE;
use super::{MasterSurface, NodalDomains, Shape, SurfaceIndex, sort};
use crate::vector::Vector3;
use crate::{ContactPoint, Point};

/// Cosine of the angle between the normals of a node and of a facet that it may touch, at most.
const OPPOSITE: f64 = -0.1;
/// Facets between a node and one that it may touch, along the skin.
const RINGS: usize = 3;
/// As far behind a node, in thicknesses of the body, a facet is its back, if it is also no farther aside than one thickness or this many
/// extents of the facet.
const BEHIND: f64 = 1.5;
const ASIDE: f64 = 3.0;
/// How deep a node may lie below a facet, in parts of the thickness of the body. At its whole thickness the facet is its own back.
const DEPTH: f64 = 0.5;
/// Facets that are farther away are no candidates unless another limit is asked for, in mean extents of a facet.
const REACH: f64 = 2.0;
/// A way through the body as short as this part of a facet's extent ends on the node's own facets.
const NOWHERE: f64 = 1e-9;
/// Places on a way that are as near to one another as this part of it are one.
const ONCE: f64 = 1e-9;
/// How far beyond a facet's edge a way through the body still meets it, in natural coordinates: none slips through between two.
const ON_EDGE: f64 = 1e-9;

/// What the nodes of a surface may touch of it.
#[derive(Clone, Debug)]
pub(crate) struct OwnSurface {
    /// Facets near each node along the skin, by place, ascending.
    near: Vec<Vec<u32>>,
    /// Each node in the first configuration, by place.
    first: Vec<First>,
    /// The connected part of the surface that each facet belongs to.
    parts: Vec<u32>,
    /// The largest distance of a candidate, length.
    limit: f64,
}

/// A node in the first configuration.
#[derive(Clone, Copy, Debug)]
struct First {
    position: Vector3,
    /// Outward, of length one.
    normal: Vector3,
    /// Of the body below it, length; infinite where the surface has no other side.
    thickness: f64,
    /// The connected part of the surface that its other side belongs to, if it has one, else its own.
    back: u32,
    /// Its own.
    part: u32,
}

impl OwnSurface {
    /// With the surface as it is at the index for its first configuration.
    pub fn new(index: &SurfaceIndex<'_>, limit: Option<f64>) -> Self {
        let surface = index.surface();
        let places = 0..surface.nodes().len();
        let extents = (0..surface.facet_count()).map(|facet| index.shape(facet as u32).extent());
        let mean = extents.sum::<f64>() / surface.facet_count() as f64;
        let parts = connected_parts(surface);
        Self {
            near: places.clone().into_par_iter().map(|place| facets_around(surface, place)).collect(),
            first: places.into_par_iter().map(|place| First::of(index, &parts, place)).collect(),
            parts,
            limit: limit.unwrap_or(REACH * mean),
        }
    }

    /// The largest distance of a candidate, length.
    pub const fn limit(&self) -> f64 {
        self.limit
    }

    /// The closest of the facets that a node may touch and that `may` says so of; `ties` gets those that share the closest point.
    /// `before`: a facet that it touched a moment ago. It may lie deeper below the facets around this one.
    pub fn closest(
        &self,
        index: &SurfaceIndex<'_>,
        domains: Option<&NodalDomains>,
        place: usize,
        before: Option<u32>,
        ties: &mut Vec<Closest>,
        may: impl Fn(u32) -> bool,
    ) -> Option<Closest> {
        let surface = index.surface();
        let may_touch = self.may_touch(index, domains, place, 0.0);
        let (point, normals) = (index.positions()[place], index.normals());
        let x = Vector3::from(point);
        let normal = normal_at(surface, place, |facet| index.shape(facet));
        let around = |facet: u32| {
            let corners = |facet: u32| surface.corners_of(facet as usize);
            before.is_some_and(|before| corners(before).iter().any(|place| corners(facet).contains(place)))
        };
        let is_in_front = |facet: u32, foot: &Foot| {
            let way = x - foot.point;
            let height = normals[facet as usize].dot(&way);
            let beside = (way - normals[facet as usize] * height).norm();
            let is_over = beside <= index.shape(facet).extent();
            is_over && height.min(-normal.dot(&way)) >= -self.depth(surface, place, facet) || around(facet)
        };
        index.closest_where(point, self.limit, ties, |facet, foot| match foot {
            None => may(facet) && may_touch(facet),
            Some(foot) => is_in_front(facet, foot),
        })
    }

    /// Whether the node at a place may touch a facet, if it lies in front of it. `turned`: the cosine of its angle to one that looks against
    /// the node may be larger by so much.
    pub fn may_touch<'s>(
        &'s self,
        index: &'s SurfaceIndex<'_>,
        domains: Option<&'s NodalDomains>,
        place: usize,
        turned: f64,
    ) -> impl Fn(u32) -> bool + 's {
        let surface = index.surface();
        let normal = normal_at(surface, place, |facet| index.shape(facet));
        move |facet| {
            index.normals()[facet as usize].dot(&normal) <= OPPOSITE + turned
                && self.is_apart(surface, domains, place, facet)
        }
    }

    /// How deep points of one of the surface's facets may lie below another one, length; `None` if they can never touch it. That they face
    /// each other is for the caller to see.
    pub fn depth_below(
        &self,
        surface: &MasterSurface,
        domains: Option<&NodalDomains>,
        own: u32,
        facet: u32,
    ) -> Option<f64> {
        let corners = surface.corners_of(own as usize);
        let is_apart = corners.iter().all(|&place| self.is_apart(surface, domains, place as usize, facet));
        let depths = corners.iter().map(|&place| self.depth(surface, place as usize, facet));
        is_apart.then(|| depths.fold(f64::INFINITY, f64::min))
    }

    /// Whether a facet is far from a node along the skin, and not its back.
    fn is_apart(
        &self,
        surface: &MasterSurface,
        domains: Option<&NodalDomains>,
        place: usize,
        facet: u32,
    ) -> bool {
        self.near[place].binary_search(&facet).is_err()
            && !self.is_back(surface, place, facet)
            && domains.is_none_or(|domains| domains.listed_at(facet, place as u32).is_none())
    }

    /// The nodes of a facet in the first configuration.
    fn corners<'s>(
        &'s self,
        surface: &'s MasterSurface,
        facet: u32,
    ) -> impl ExactSizeIterator<Item = &'s First> + Clone {
        surface.corners_of(facet as usize).iter().map(|&corner| &self.first[corner as usize])
    }

    /// How deep a node may lie below a facet.
    fn depth(&self, surface: &MasterSurface, place: usize, facet: u32) -> f64 {
        let thickness = self.corners(surface, facet).map(|corner| corner.thickness);
        DEPTH * thickness.fold(self.first[place].thickness, f64::min)
    }

    /// Whether a facet lies right behind a node, or the node right behind the facet: at an edge of the body the node's own normal says
    /// little.
    fn is_back(&self, surface: &MasterSurface, place: usize, facet: u32) -> bool {
        let First { position, normal, thickness, back, part } = self.first[place];
        let corners = self.corners(surface, facet);
        let extent = extent(&corners);
        let is_other_side =
            |corner: &&First| (corner.back, corner.part) == (part, back) && corner.thickness.is_finite();
        let mut backs = corners.filter(is_other_side);
        if backs.any(|corner| {
            let offset = corner.position - position;
            lies_behind(offset, corner.normal, corner.thickness, extent)
        }) {
            return true;
        }
        if self.parts[facet as usize] != back {
            return false;
        }
        let corners = self.corners(surface, facet);
        let thickness = if thickness.is_finite() {
            thickness
        } else {
            // Its way misses the other side, as at a rim.
            corners.clone().map(|corner| corner.thickness).fold(thickness, f64::min)
        };
        if !thickness.is_finite() {
            return false;
        }
        lies_behind(position - centre(&corners), normal, thickness, extent)
    }

    /// Whether a node can touch the fit over a facet at this foot, at these positions of all nodes: it may lead back to the node's own
    /// place, or to the other side of its wall.
    pub fn may_rest_on(
        &self,
        surface: &MasterSurface,
        positions: &[Point],
        node: usize,
        facet: u32,
        found: &ContactPoint,
    ) -> bool {
        let Ok(place) = surface.nodes().binary_search(&(node as u32)) else { return true };
        let shape = |facet: u32| surface.shape(facet as usize, positions);
        if normal_at(surface, place, shape).dot(&found.normal.into()) >= 0.0 {
            return false;
        }
        let depth = self.depth(surface, place, facet);
        found.gap >= -depth || {
            let (x, facet) = (Vector3::from(positions[node]), shape(facet));
            let height = facet.normal().dot(&(x - facet.closest(x).point));
            found.gap >= height.min(0.0) - depth
        }
    }
}

/// The middle of a facet's corners.
fn centre<'s>(corners: &(impl ExactSizeIterator<Item = &'s First> + Clone)) -> Vector3 {
    corners.clone().map(|corner| corner.position).sum::<Vector3>() / corners.len() as f64
}

/// The longest edge of a facet.
fn extent<'s>(corners: &(impl ExactSizeIterator<Item = &'s First> + Clone)) -> f64 {
    let edges = corners.clone().zip(corners.clone().cycle().skip(1));
    edges.map(|(from, to)| (to.position - from.position).norm()).fold(0.0, f64::max)
}

/// Whether a place lies right behind a wall of this thickness. `offset`: from there to the wall's front, which looks along `normal`.
fn lies_behind(offset: Vector3, normal: Vector3, thickness: f64, extent: f64) -> bool {
    let behind = offset.dot(&normal);
    let aside = (offset - normal * behind).norm();
    behind > 0.0 && behind <= BEHIND * thickness && aside <= thickness.max(ASIDE * extent)
}

/// The number of the connected part that each facet belongs to.
pub(crate) fn connected_parts(surface: &MasterSurface) -> Vec<u32> {
    let mut parts = vec![NONE; surface.facet_count()];
    let mut next = Vec::new();
    for start in 0..surface.facet_count() {
        if parts[start] != NONE {
            continue;
        }
        parts[start] = start as u32;
        next.push(start);
        while let Some(facet) = next.pop() {
            for &other in surface.across(facet) {
                if other != NONE && parts[other as usize] == NONE {
                    parts[other as usize] = start as u32;
                    next.push(other as usize);
                }
            }
        }
    }
    parts
}

/// The unit normal of the node at a place; zero if it has none.
fn normal_at(surface: &MasterSurface, place: usize, shape: impl Fn(u32) -> Shape) -> Vector3 {
    let sum: Vector3 = surface.facets_of_place(place).iter().map(|&facet| shape(facet).area_vector()).sum();
    sum.try_normalize().filter(Vector3::is_finite).unwrap_or_default()
}

/// The facets within so many rings around a node, ascending.
fn facets_around(surface: &MasterSurface, place: usize) -> Vec<u32> {
    let mut facets: Vec<u32> = surface.facets_of_place(place).to_vec();
    for _ in 1..RINGS {
        let corners = facets.iter().flat_map(|&facet| surface.corners_of(facet as usize));
        facets = corners.flat_map(|&corner| surface.facets_of_place(corner as usize)).copied().collect();
        sort(&mut facets);
    }
    facets
}

/// Where the way through the body meets the surface.
struct Hit {
    way: f64,
    part: u32,
    /// Whether the way comes out of a body there.
    is_exit: bool,
    /// Whether the facet looks the other way than the node.
    is_opposite: bool,
}

impl First {
    /// The thickness is the way through the body, against the normal, to the nearest facet that looks the other way. Where the node lies
    /// inside another body, too, that is one of the node's own part, if there is any: the nearest one may belong to the other body.
    fn of(index: &SurfaceIndex<'_>, parts: &[u32], place: usize) -> Self {
        let surface = index.surface();
        let normal = normal_at(surface, place, |facet| index.shape(facet));
        let (position, along) = (Vector3::from(index.positions()[place]), normal * -1.0);
        let own = surface.facets_of_place(place).first().map_or(0, |&facet| parts[facet as usize]);
        let mut hits = Vec::new();
        index.for_each_along(position, along, |facet| {
            if surface.facets_of_place(place).contains(&facet) {
                return;
            }
            let shape = index.shape(facet);
            let way = way_to(&shape, position, along).filter(|way| *way > NOWHERE * shape.extent());
            let cosine = index.normals()[facet as usize].dot(&normal);
            hits.extend(way.map(|way| Hit {
                way,
                part: parts[facet as usize],
                is_exit: cosine < 0.0,
                is_opposite: cosine <= OPPOSITE,
            }));
        });
        hits.sort_by(|one, other| (one.way, one.part).partial_cmp(&(other.way, other.part)).unwrap_or(Equal));
        // A way through an edge or a corner meets all facets there.
        let mut bodies = 0;
        for (k, hit) in hits.iter().enumerate() {
            let is_same = |other: &Hit| {
                (other.part, other.is_exit) == (hit.part, hit.is_exit)
                    && hit.way - other.way <= ONCE * hit.way
            };
            if !hits[..k].iter().any(is_same) {
                bodies += if hit.is_exit { 1 } else { -1 };
            }
        }
        let back = |of_own: bool| hits.iter().find(|hit| hit.is_opposite && (!of_own || hit.part == own));
        let found = if bodies > 1 { back(true).or_else(|| back(false)) } else { back(false) };
        let (thickness, back) = found.map_or((f64::INFINITY, own), |hit| (hit.way, hit.part));
        Self { position, normal, thickness, back, part: own }
    }
}

/// How far a facet is along a direction, if it lies there; a quadrilateral is taken for two triangles.
fn way_to(shape: &Shape, from: Vector3, along: Vector3) -> Option<f64> {
    match *shape {
        Shape::Triangle([a, b, c]) => way_to_triangle([a, b, c], from, along),
        Shape::Quadrilateral([a, b, c, d]) => {
            way_to_triangle([a, b, c], from, along).or_else(|| way_to_triangle([a, c, d], from, along))
        }
    }
}

fn way_to_triangle([a, b, c]: [Vector3; 3], from: Vector3, along: Vector3) -> Option<f64> {
    let (first, second) = (b - a, c - a);
    let across = along.cross(&second);
    let volume = first.dot(&across);
    let offset = from - a;
    let xi = offset.dot(&across) / volume;
    let turned = offset.cross(&first);
    let eta = along.dot(&turned) / volume;
    let is_inside = xi >= -ON_EDGE && eta >= -ON_EDGE && xi + eta <= 1.0 + ON_EDGE;
    // Neither holds of NaN, where the direction lies in the plane.
    is_inside.then(|| second.dot(&turned) / volume)
}
