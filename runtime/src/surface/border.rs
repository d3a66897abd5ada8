//! Where a patch ends: at borders of the surface and at edges sharper than the feature angle.

use crate::vector::Vector3;
use rayon::prelude::*;

use super::index::Closest;
use super::shape::{Foot, Near};
use super::topology::NONE;
use super::{MasterSurface, SurfaceIndex, Symmetry};
use crate::Point;

/// An edge counts as sharp if its angle exceeds the feature angle by this, in radians: prisms have edges of
/// exactly 45°.
const ANGLE_TOLERANCE: f64 = 1e-4;
/// Facets as close as the closest to this fraction of their extent share the closest point.
const TIE: f64 = 1e-9;

/// Whether `distance` from a facet of this extent is more than `least`, and no tie.
fn is_farther(distance: f64, least: f64, extent: f64) -> bool {
    distance > least + TIE * (least + extent)
}

/// Which edges end a sheet: borders, and edges sharper than the feature angle at the positions of a refresh.
#[derive(Clone, Debug, Default)]
pub struct Creases {
    /// Per facet, bit k for the edge from corner k to the next.
    ends: Vec<u8>,
}

/// Memory of the border test, kept from one slave to the next.
#[derive(Clone, Debug, Default)]
pub struct BorderScratch {
    /// Facets of the patch with their boxes.
    near: Vec<(Near, u32)>,
    feet: Vec<(u32, Foot)>,
}

impl Creases {
    /// Of the surface as it is now; `feature_angle` in radians. An edge in a symmetry plane is no border: the surface goes on as its
    /// image. Nor is one at which a part of a surface is cut.
    pub fn new(index: &SurfaceIndex<'_>, feature_angle: f64, symmetry: &Symmetry) -> Self {
        let smallest = (feature_angle + ANGLE_TOLERANCE).min(std::f64::consts::PI).cos();
        let (surface, normals) = (index.surface(), index.normals());
        let of_facet = |facet: usize| {
            let ends = |edge: usize, other: u32| {
                if other == NONE {
                    let shape = index.shape(facet as u32);
                    return !surface.is_cut(facet, edge)
                        && !symmetry.holds_edge(shape.edge(edge).map(Point::from));
                }
                !(normals[facet].dot(&normals[other as usize]) >= smallest)
            };
            let edges = surface.across(facet).iter().enumerate();
            edges.map(|(edge, &other)| u8::from(ends(edge, other)) << edge).sum()
        };
        Self { ends: (0..surface.facet_count()).into_par_iter().map(of_facet).collect() }
    }

    /// Of facets for which it is known: bit k for the edge from corner k to the next.
    pub fn given(ends: Vec<u8>) -> Self {
        Self { ends }
    }

    /// Bit k if the patch ends at the edge from corner k to the next.
    pub fn of_facet(&self, facet: usize) -> u8 {
        self.ends[facet]
    }

    /// Whether the patch ends at this edge.
    pub fn ends_at(&self, facet: usize, edge: usize) -> bool {
        self.ends[facet] >> edge & 1 == 1
    }

    /// The facets of the patch around `nodes` (ascending) that `facet` belongs to, if it ends anywhere; else none.
    pub fn patch_with_end(&self, surface: &MasterSurface, facet: u32, nodes: &[u32], patch: &mut Vec<u32>) {
        self.patch(surface, facet, nodes, patch);
        if patch.iter().all(|&facet| self.ends[facet as usize] == 0) {
            patch.clear();
        }
    }

    /// How far `point` lies beyond the end of a patch: in the plane of the closest facet, over its height over the edge; 0 if
    /// it does not lie beyond.
    pub fn beyond(
        &self,
        surface: &MasterSurface,
        positions: &[Point],
        patch: &[u32],
        point: Point,
        scratch: &mut BorderScratch,
    ) -> f64 {
        let BorderScratch { near, feet } = scratch;
        let x = Vector3::from(point);
        near.clear();
        near.extend(patch.iter().map(|&facet| (surface.shape(facet as usize, positions).near(x), facet)));
        near.sort_unstable_by(|(one, _), (other, _)| one.at_least.total_cmp(&other.at_least));
        feet.clear();
        let mut least = f64::INFINITY;
        for &(Near { at_least, extent }, facet) in &*near {
            // Feet cost most of the test, and two or three of a patch matter.
            if is_farther(at_least, least, extent) {
                continue;
            }
            let foot = surface.shape(facet as usize, positions).closest(x);
            least = least.min(foot.distance);
            feet.push((facet, foot));
        }
        feet.iter()
            .map(|&(facet, foot)| {
                let shape = surface.shape(facet as usize, positions);
                if is_farther(foot.distance, least, shape.extent()) {
                    return 0.0;
                }
                let offset = x - foot.point;
                self.reach_beyond(facet, foot.edges, |edge| shape.reach_across(edge, offset))
            })
            .fold(0.0, f64::max)
    }

    /// The same for a slave and the facets closest to it among all.
    pub fn slave_beyond(&self, index: &SurfaceIndex<'_>, slave: Point, closest: &[Closest]) -> f64 {
        let x = Vector3::from(slave);
        let beyond = closest.iter().map(|tie| {
            let shape = index.shape(tie.facet);
            self.reach_beyond(tie.facet, tie.edges, |edge| shape.reach_across(edge, x - tie.point))
        });
        beyond.fold(0.0, f64::max)
    }

    /// The largest reach across those of the `edges` at which the patch ends.
    fn reach_beyond(&self, facet: u32, edges: u8, reach: impl Fn(usize) -> f64) -> f64 {
        let ends = self.ends[facet as usize] & edges;
        (0..4).filter(|edge| ends >> edge & 1 == 1).map(reach).fold(0.0, f64::max)
    }

    /// The facets with a corner among `nodes` that are reached from `facet` over one another.
    pub fn patch(&self, surface: &MasterSurface, facet: u32, nodes: &[u32], patch: &mut Vec<u32>) {
        patch.clear();
        patch.push(facet);
        let mut next = 0;
        while let Some(&facet) = patch.get(next) {
            next += 1;
            for (edge, &other) in surface.across(facet as usize).iter().enumerate() {
                if other == NONE || self.ends_at(facet as usize, edge) || patch.contains(&other) {
                    continue;
                }
                let mut corners = surface.corners_of(other as usize).iter();
                let node = |place: &u32| surface.nodes()[*place as usize];
                if corners.any(|place| nodes.binary_search(&node(place)).is_ok()) {
                    patch.push(other);
                }
            }
        }
    }
}
