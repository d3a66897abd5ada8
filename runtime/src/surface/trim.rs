//! Domains made smaller where slaves would have many masters (`docs/equations.md`, [T18]).
//!
//! Each domain is as large as the most demanding of its centres asks for, so all of them together are larger than they need to be: most
//! where the size of cells changes, since large cells' domains reach across many small ones. So fits are looked at once more, with
//! the domains as they are, on a fine grid of *places*. The ratio of a place is the one down to which the domains of all nodes around it
//! can shrink together, the fit well conditioned all the way. A node shrinks by the largest ratio of the places that it still serves then,
//! if any place that it serves is crowded.
//!
//! Nodes around a place shrink by different ratios, none by more than that of the place. The fit of such a mixture may be a little worse
//! than that of all alike: hence the reserve of [`KEPT`].

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::prelude::*;

use super::auxiliary::Auxiliary;
use super::cells::with_auxiliary;
use super::conditioning::is_well_conditioned;
use super::fits::{Centre, Scratch};
use super::shape::Shape;
use super::sheets::{CHUNK, Carried, Listed, Sheets};
use super::topology::NONE;
use crate::vector::Vector3;
use crate::{MaterialDomain, Weight};

/// Places along an edge, one more with its ends.
const GRID: usize = 8;
/// A place with more masters is crowded.
const CROWD: usize = 16;
/// No domain shrinks by more.
const SMALLEST_RATIO: f64 = 0.7;
/// Ratios are tried in steps of this one, then halved in between so many times.
const STEP: f64 = 0.96;
const BISECTIONS: usize = 2;
/// The smallest singular value that places keep: a little more than centres ask for, since nodes shrink by different ratios.
const KEPT: f64 = 0.135;

/// What the places on some facets ask for. Of several parts the largest ratios count, and what is crowded in any of them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Ratios {
    /// By sheet node; 0 where no place asks for anything.
    pub ratios: Vec<f64>,
    /// Whether a place that the node serves is crowded.
    pub crowded: Vec<bool>,
}

impl Sheets<'_> {
    /// By sheet node whether a crowded place on these facets, which have these lists, is served by it, in parallel.
    pub fn crowded(&self, domains: &[MaterialDomain], facets: &[u32], lists: &[Vec<Listed>]) -> Vec<bool> {
        let crowded = Marks::none(self.nodes.places().len());
        let of_facet = |scratch: &mut Scratch, (&facet, listed): (&u32, &Vec<Listed>)| {
            if listed.len() <= CROWD {
                return;
            }
            scratch.take_listed(self, domains, listed);
            for place in places(self, facet) {
                let served = || scratch.around().iter().filter(|(_, domain)| domain.reaches(place.point));
                if served().count() > CROWD {
                    let ends = served().flat_map(|(node, _)| self.nodes.ends(*node));
                    ends.for_each(|node| crowded.mark(node));
                }
            }
        };
        let all = facets.par_iter().zip(lists).with_min_len(CHUNK);
        all.for_each_init(Scratch::default, of_facet);
        crowded.get()
    }

    /// By how much domains can shrink as far as the places on these facets go, which have these lists, in parallel. Of nodes that are not
    /// asked for, ratios may be too small.
    pub fn ratios(
        &self,
        domains: &[MaterialDomain],
        (bases, weight): (&[Carried], Weight),
        (facets, lists): (&[u32], &[Vec<Listed>]),
        is_asked: impl Fn(usize) -> bool + Sync,
    ) -> Ratios {
        let count = self.nodes.places().len();
        let is_asked = |node: u32| self.nodes.ends(node).iter().any(|&node| is_asked(node as usize));
        let ratios: Vec<AtomicU64> = (0..count).map(|_| AtomicU64::new(0)).collect();
        let crowded = Marks::none(count);
        let of_facet = |scratch: &mut Scratch, (&facet, listed): (&u32, &Vec<Listed>)| {
            if !listed.iter().any(|own| is_asked(own.node)) {
                return;
            }
            scratch.take_listed(self, domains, listed);
            for place in places(self, facet) {
                scratch.look(&place, self.symmetry);
                let served = scratch.nodes.partition_point(|node| node.distance < 1.0);
                if !scratch.nodes[..served].iter().any(|node| is_asked(node.node)) {
                    continue;
                }
                let ratio = smallest_ratio(scratch, weight, bases[facet as usize]);
                for near in &scratch.nodes[..served] {
                    let asked = if near.distance < ratio { ratio } else { SMALLEST_RATIO };
                    for node in self.nodes.ends(near.node) {
                        if served > CROWD {
                            crowded.mark(node);
                        }
                        // The largest does not depend on the order; the bits of positive numbers are ordered like them.
                        ratios[node as usize].fetch_max(asked.to_bits(), Ordering::Relaxed);
                    }
                }
            }
        };
        facets.par_iter().zip(lists).with_min_len(CHUNK).for_each_init(Scratch::default, of_facet);
        Ratios {
            ratios: ratios.into_iter().map(|bits| f64::from_bits(bits.into_inner())).collect(),
            crowded: crowded.get(),
        }
    }
}

/// Marks by sheet node, set in any order.
struct Marks(Vec<AtomicBool>);

impl Marks {
    fn none(count: usize) -> Self {
        Self((0..count).map(|_| AtomicBool::new(false)).collect())
    }

    fn mark(&self, node: u32) {
        self.0[node as usize].store(true, Ordering::Relaxed);
    }

    fn get(self) -> Vec<bool> {
        self.0.into_iter().map(AtomicBool::into_inner).collect()
    }
}

/// The domains of sheet nodes shrunk by the ratios of crowded ones, and those of auxiliary points. Nodes of strips that have such points keep
/// theirs: their fits have hardly more nodes than they need.
pub(crate) fn trimmed(
    domains: &[MaterialDomain],
    Ratios { ratios, crowded }: &Ratios,
    auxiliary: &[Auxiliary],
) -> Vec<MaterialDomain> {
    let mut shrinks: Vec<bool> = crowded.iter().zip(ratios).map(|(&is, &ratio)| is && ratio > 0.0).collect();
    auxiliary.iter().flat_map(|point| point.ends).for_each(|node| shrinks[node as usize] = false);
    let trimmed = |((domain, &ratio), shrinks): ((&MaterialDomain, &f64), bool)| {
        if shrinks { domain.times(ratio) } else { *domain }
    };
    with_auxiliary(domains.iter().zip(ratios).zip(shrinks).map(trimmed).collect(), auxiliary)
}

/// The smallest ratio for which the fit at a place is well conditioned, as it is with all larger ones; 1 if it is not as it is.
fn smallest_ratio(scratch: &Scratch, weight: Weight, carried: Carried) -> f64 {
    let mut within = Vec::new();
    let mut is_enough =
        |ratio: f64| is_well_conditioned((&scratch.nodes, ratio), weight, carried, KEPT, &mut within);
    if carried == Carried::Nothing || !is_enough(1.0) {
        return 1.0;
    }
    let mut ratio = 1.0;
    while ratio > SMALLEST_RATIO && is_enough(ratio * STEP) {
        ratio *= STEP;
    }
    let mut below = ratio * STEP;
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (below + ratio);
        if is_enough(middle) { ratio = middle } else { below = middle }
    }
    ratio.max(SMALLEST_RATIO)
}

/// The places that a facet looks after: inside it and, of its corners and edges, those of which it has the lowest number in its sheet.
fn places(sheets: &Sheets<'_>, facet: u32) -> Vec<Centre> {
    let Sheets { index, creases, nodes, .. } = *sheets;
    let surface = index.surface();
    let shape = index.shape(facet);
    let normal = index.normals()[facet as usize];
    let others = surface.across(facet as usize);
    let count = shape.corners().len();
    // Per edge the facet across it, if the sheet goes on there.
    let across = |edge: usize| {
        let is_end = others[edge] == NONE || creases.ends_at(facet as usize, edge);
        (!is_end).then(|| others[edge])
    };
    let fan = |&corner: &u32| nodes.facets(surface, nodes.at(surface, facet, corner)).collect();
    let fans: Vec<Vec<u32>> = surface.corners_of(facet as usize).iter().map(fan).collect();
    let mut all = Vec::with_capacity((GRID + 1) * (GRID + 1));
    for place in grid(&shape) {
        let facets: &[u32] = match place.on {
            On::Inside => &[],
            On::Edge(edge) => &across(edge).map_or([facet; 1], |other| [other]),
            On::Corner(corner) => &fans[corner % count],
        };
        if facets.iter().all(|&other| facet <= other) {
            let sum =
                facets.iter().filter(|&&other| other != facet).map(|&other| index.normals()[other as usize]);
            let normal = (normal + sum.sum::<Vector3>()).normalize();
            all.push(Centre { point: shape.point(place.natural), normal, facet, others: Vec::new() });
        }
    }
    all
}

/// A point of a facet's grid.
struct Place {
    natural: [f64; 2],
    on: On,
}

enum On {
    Inside,
    /// From the corner of this number to the next.
    Edge(usize),
    Corner(usize),
}

fn grid(shape: &Shape) -> Vec<Place> {
    let mut all = Vec::with_capacity((GRID + 1) * (GRID + 1));
    let is_triangle = matches!(shape, Shape::Triangle(_));
    for j in 0..=GRID {
        for i in 0..=GRID {
            if is_triangle && i + j > GRID {
                continue;
            }
            let [xi, eta] = [i, j].map(|k| k as f64 / GRID as f64);
            let natural = if is_triangle { [xi, eta] } else { [2.0 * xi - 1.0, 2.0 * eta - 1.0] };
            // Edges in their order, and whether the place is on them.
            let on: &[bool] = if is_triangle {
                &[j == 0, i + j == GRID, i == 0]
            } else {
                &[j == 0, i == GRID, j == GRID, i == 0]
            };
            let mut edges = (0..on.len()).filter(|&edge| on[edge]);
            let on = match (edges.next(), edges.next()) {
                (None, _) => On::Inside,
                (Some(edge), None) => On::Edge(edge),
                // The corner where one edge ends and the next begins; the first one is where the last edge ends.
                (Some(0), Some(last)) if last + 1 == on.len() => On::Corner(0),
                (_, Some(edge)) => On::Corner(edge),
            };
            all.push(Place { natural, on });
        }
    }
    all
}
