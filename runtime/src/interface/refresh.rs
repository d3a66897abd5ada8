//! Pairing every slave with its masters.

use std::cell::RefCell;
use std::ops::Range;

use crate::vector::Vector3;
use rayon::prelude::*;

use super::anchors::{append_carriers, list_carriers};
use super::contacts::Layout;
use super::evaluator::Evaluator;
use super::nodal::Nodal;
use super::pairings::{Lists, Paired, Pairings, Record};
use super::report::RefreshReport;
use super::scratch::ElementScratch;
use super::window::Knowledge;
use super::{ContactElement, InterfaceError, NoContact};
use crate::neighbourhood::{Fallback, NeighbourSearch, NeighbourhoodError, SearchOptions};
use crate::pairing::NearestNodes;
use crate::scratch::Pool;
use crate::surface::{Carried, Closest, Creases, Foot, Listed, NONE, SurfaceIndex, Walk};
use crate::{Basis, Frame, Point, Weight};

/// Slaves that one thread pairs in a row.
const CHUNK: usize = 256;
/// A slave that lies beyond the border by more than this many heights of the facet is not paired.
const FARTHEST_BEYOND: f64 = 1.0;

/// A slave deeper below the closest facet than this part of the facet's size is more than a mesh that does not quite fit.
const DEEP: f64 = 0.1;

/// Whose gaps before and after a refresh are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compares {
    /// Those of all slaves.
    All,
    /// Of slaves that had no pairing, or have none: with nodal domains a list makes no difference to another gap.
    GainedAndLost,
    /// Nobody's: nobody has a pairing.
    None,
}

/// All that a refresh works with.
pub struct Refresh<'a> {
    pub index: &'a SurfaceIndex<'a>,
    /// The surface's nodes by place.
    pub cloud: &'a NearestNodes,
    pub evaluator: Evaluator<'a>,
    pub old: &'a Pairings,
    /// What the old pairing has been evaluated with.
    pub old_creases: &'a Creases,
    pub compares: Compares,
    /// The facet of each slave, where it is known: no closest one is looked for.
    pub facets: Option<&'a [u32]>,
    /// Whether lists follow within an increment: then no slave changes to the other side of a surface.
    pub follows: bool,
    /// What is known, where there is a window of the surface only.
    pub knowledge: Option<Knowledge<'a>>,
}

/// Memory of one thread, kept from one refresh to the next.
#[derive(Clone, Debug)]
pub struct RefreshScratch {
    search: NeighbourSearch,
    walk: Walk,
    ties: Vec<Closest>,
    masters: Vec<u32>,
    places: Vec<u32>,
    images: Vec<u32>,
    patch: Vec<u32>,
    element: ElementScratch,
}

impl RefreshScratch {
    pub fn new(options: SearchOptions) -> Result<Self, InterfaceError> {
        Ok(Self {
            search: NeighbourSearch::new(options)?,
            walk: Walk::default(),
            ties: Vec::new(),
            masters: Vec::new(),
            places: Vec::new(),
            images: Vec::new(),
            patch: Vec::new(),
            element: ElementScratch::default(),
        })
    }
}

impl RefreshScratch {
    /// A pairing with nodal domains as it is.
    fn take_over(&mut self, old: &Paired<'_>) {
        let Self { masters, places, images, patch, .. } = self;
        let lists = [(masters, old.masters), (places, old.places), (images, old.images), (patch, old.patch)];
        for (own, list) in lists {
            own.clear();
            own.extend_from_slice(list);
        }
    }
}

/// The pairing of slaves near one another.
#[derive(Default)]
struct Chunk {
    records: Vec<Result<Record, NoContact>>,
    masters: Vec<u32>,
    /// Where the masters of each slave end.
    ends: Vec<usize>,
    frames: Vec<Frame>,
    patches: Lists,
    places: Vec<u32>,
    images: Lists,
    report: RefreshReport,
}

impl Chunk {
    /// Where the masters of the `own`-th slave of the chunk are.
    fn range_of(&self, own: usize) -> Range<usize> {
        let start = own.checked_sub(1).map_or(0, |before| self.ends[before]);
        start..self.ends[own]
    }

    fn masters_of(&self, own: usize) -> &[u32] {
        &self.masters[self.range_of(own)]
    }
}

impl Refresh<'_> {
    /// Pairs all slaves, in parallel; neither the pairing nor the report depends on the number of threads.
    pub fn run(&self, pool: &Pool<RefreshScratch>, blank: &RefreshScratch) -> (Pairings, RefreshReport) {
        let old = &self.old.layout;
        let order = spatial_order(old.slaves(), self.evaluator.positions);
        let chunks: Vec<Chunk> = order
            .par_chunks(CHUNK)
            .map(|slaves| {
                pool.with(
                    || blank.clone(),
                    |scratch| {
                        let mut chunk = Chunk::default();
                        slaves.iter().for_each(|&k| self.slave(k as usize, scratch, &mut chunk));
                        chunk
                    },
                )
            })
            .collect();
        let mut report = RefreshReport::default();
        let mut places = vec![0; order.len()];
        for (place, &k) in order.iter().enumerate() {
            places[k as usize] = place;
        }
        let mut masters = Vec::with_capacity(chunks.iter().map(|chunk| chunk.masters.len()).sum());
        let mut records = Vec::with_capacity(order.len());
        let mut frames = Vec::new();
        let (mut patches, mut images, mut listed) = (Lists::default(), Lists::default(), Vec::new());
        chunks.iter().for_each(|chunk| report.append(&chunk.report));
        for &place in &places {
            let (chunk, own) = (&chunks[place / CHUNK], place % CHUNK);
            records.push(chunk.records[own]);
            masters.extend_from_slice(chunk.masters_of(own));
            frames.extend(chunk.frames.get(own));
            patches.push(chunk.patches.get(own));
            images.push(chunk.images.get(own));
            listed.extend_from_slice(chunk.places.get(chunk.range_of(own)).unwrap_or(&[]));
        }
        let lengths = places.iter().map(|place| chunks[place / CHUNK].masters_of(place % CHUNK).len());
        let layout = Layout::new(old.slaves().to_vec(), old.areas().to_vec(), lengths, masters);
        (Pairings { layout: layout.into(), records, frames, patches, places: listed, images }, report)
    }

    /// Pairs the `k`-th slave and books it.
    fn slave(&self, k: usize, scratch: &mut RefreshScratch, chunk: &mut Chunk) {
        let node = self.old.layout.slave(k);
        let old = self.old.get(k).ok();
        let closest = match self.facets {
            Some(facets) => Ok(self.over(node, facets[k])),
            None => self.closest(node, old.as_ref().filter(|_| self.follows), scratch),
        };
        let record = match (old, closest) {
            (Some(old), closest) if self.follows && self.keeps(&old, closest.ok().as_ref()) => {
                scratch.take_over(&old);
                Ok(*old.record)
            }
            (_, Err(reason)) => Err(reason),
            (_, Ok(closest)) => self.pair(k, &closest, scratch),
        };
        let RefreshScratch { masters, places, images, patch, element, .. } = scratch;
        let paired = record.as_ref().map_err(|reason| *reason).and_then(|record| {
            let paired = Paired { slave: node, masters, record, frame: None, patch, places, images };
            Ok((paired, self.evaluator.held_frame(&paired, element)?))
        });
        let report = &mut chunk.report;
        match paired {
            Ok((paired, frame)) => {
                report.paired += 1;
                report.count_fallback(paired.record.fallback);
                report.deep += usize::from(self.is_deep(node, paired.record.facet, closest.ok().as_ref()));
                match old {
                    None => report.gained += 1,
                    Some(old) if old.masters == paired.masters => report.renewed += 1,
                    Some(_) => report.changed += 1,
                }
                if self.compares == Compares::All
                    || (old.is_none() && self.compares == Compares::GainedAndLost)
                {
                    let paired = Paired { frame: frame.as_ref(), ..paired };
                    let before = old.as_ref().and_then(|old| self.old_gap(old, element));
                    report.compare(node, before, self.evaluator.gap(&paired, element).ok());
                }
                chunk.masters.extend_from_slice(masters);
                chunk.records.push(record);
                chunk.frames.extend(frame);
                chunk.patches.push(patch);
                chunk.places.extend_from_slice(places);
                chunk.images.push(images);
            }
            Err(reason) => {
                report.lost += usize::from(old.is_some());
                report.compare(node, old.and_then(|old| self.old_gap(&old, element)), None);
                report.count_without(reason);
                chunk.records.push(Err(reason));
                chunk.frames.extend(self.evaluator.stand_in_frame());
                chunk.patches.push(&[]);
                chunk.images.push(&[]);
            }
        }
        chunk.ends.push(chunk.masters.len());
    }

    /// Whether a slave lies deep below the facet of its pairing. `closest`: where that was looked for.
    fn is_deep(&self, node: usize, facet: u32, closest: Option<&Closest>) -> bool {
        let known = closest.filter(|closest| closest.facet == facet);
        let foot = known.map_or_else(|| self.over(node, facet).point, |closest| closest.point);
        let height =
            (Vector3::from(self.evaluator.positions[node]) - foot).dot(&self.index.normals()[facet as usize]);
        height < 0.0 && height * height > DEEP * DEEP * self.index.shape(facet).area_vector().norm()
    }

    /// Whether a slave stays with its pairing within an increment: where the closest facet looks away from that of the pairing. A slave
    /// of a surface in contact with itself also does where it lies so deep below its facet that none is a candidate.
    fn keeps(&self, old: &Paired<'_>, closest: Option<&Closest>) -> bool {
        let before = self.index.normals()[old.record.facet as usize];
        match closest {
            Some(closest) => before.dot(&self.index.normals()[closest.facet as usize]) < 0.0,
            None => {
                let foot = self.over(old.slave, old.record.facet);
                let offset = Vector3::from(self.evaluator.positions[old.slave]) - foot.point;
                self.evaluator.own.is_some() && before.dot(&offset) < 0.0
            }
        }
    }

    /// The gap by the old pairing and the creases of before, if there is one.
    fn old_gap(&self, old: &Paired<'_>, scratch: &mut ElementScratch) -> Option<f64> {
        let evaluator = Evaluator { creases: self.old_creases, ..self.evaluator };
        evaluator.gap(old, scratch).ok()
    }

    /// The closest point of a facet that the slave is known to lie over.
    fn over(&self, node: usize, facet: u32) -> Closest {
        let Foot { natural, point, distance, edges } =
            self.index.shape(facet).closest(Vector3::from(self.evaluator.positions[node]));
        Closest { facet, natural, point, distance, edges }
    }

    /// The closest facet, if it is near enough and the slave not far beyond the border. `old`: the pairing that the slave follows.
    fn closest(
        &self,
        node: usize,
        old: Option<&Paired<'_>>,
        scratch: &mut RefreshScratch,
    ) -> Result<Closest, NoContact> {
        let slave = self.evaluator.positions[node];
        let Evaluator { creases, options, own, surface, nodal, .. } = self.evaluator;
        let ties = &mut scratch.ties;
        let own = own.map(|own| (own, surface.nodes().binary_search(&(node as u32))));
        let closest = match (own, self.knowledge) {
            (Some((own, Ok(place))), _) => {
                let (domains, before) = (nodal.map(|nodal| &nodal.domains), old.map(|old| old.record.facet));
                let found = own.closest(self.index, domains, place, before, ties);
                found.ok_or(NoContact::NothingOver { limit: own.limit() })?
            }
            (_, Some(knowledge)) => knowledge.check(self.index, slave, options.distance_limit, ties)?,
            // Positions have been checked, so that there is a closest facet.
            _ => self.index.closest_among_ties(slave, ties).ok_or(NoContact::NotPaired)?,
        };
        if let Some(limit) = options.distance_limit
            && closest.distance > limit
        {
            return Err(NoContact::TooFar { distance: closest.distance, limit });
        }
        let beyond = creases.slave_beyond(self.index, slave, &scratch.ties);
        if beyond > FARTHEST_BEYOND + options.border_tolerance {
            return Err(NoContact::BeyondBorder { distance: beyond, tolerance: options.border_tolerance });
        }
        Ok(closest)
    }

    /// The pairing of the `k`-th slave with the masters around its closest facet, which go to `scratch.masters`.
    fn pair(&self, k: usize, closest: &Closest, scratch: &mut RefreshScratch) -> Result<Record, NoContact> {
        let Evaluator { surface, creases, positions, options, .. } = self.evaluator;
        let RefreshScratch { search, walk, masters, places, images, patch, .. } = scratch;
        masters.clear();
        places.clear();
        images.clear();
        patch.clear();
        if let Some(nodal) = self.evaluator.nodal {
            return self.list(nodal, k, closest, scratch);
        }
        let Closest { facet, .. } = *closest;
        if options.element == ContactElement::NodeToFacet {
            masters.extend(surface.facet(facet as usize).corners().iter().map(|&node| node as u32));
            append_carriers(self.evaluator.anchors_of(k), masters);
            return Ok(Record {
                support_radius: self.index.shape(facet).extent(),
                basis: Basis::Linear,
                fallback: Fallback::None,
                facet,
                complete_within: 0.0,
            });
        }
        let slave: Point = positions[self.old.layout.slave(k)];
        walk.start(self.index, facet, slave);
        let walk = RefCell::new(walk);
        let reached = |place: usize| walk.borrow_mut().reaches(self.index, creases, place);
        let outward = self.index.normal(facet as usize);
        let found = search
            .find_among(self.cloud, slave, outward, reached)
            .map_err(|reason| NoContact::NoCandidate { reason })?;
        masters.extend(found.nodes.iter().map(|&place| surface.nodes()[place]));
        masters.sort_unstable();
        creases.patch_with_end(surface, facet, masters, patch);
        Ok(Record {
            support_radius: found.support_radius,
            basis: found.basis,
            fallback: found.fallback,
            facet,
            complete_within: 0.0,
        })
    }
}

/// A listed node may be outside its domain by this fraction of it: lists hold while nobody has moved by half of it.
pub const SKIN: f64 = 0.12;

impl Refresh<'_> {
    /// Lists the nodes of the slave's sheet that may come within reach, with their images.
    fn list(
        &self,
        nodal: &Nodal,
        k: usize,
        closest: &Closest,
        scratch: &mut RefreshScratch,
    ) -> Result<Record, NoContact> {
        let node = self.old.layout.slave(k);
        let Evaluator { surface, creases, options, .. } = self.evaluator;
        let RefreshScratch { masters, places, images, patch, element, .. } = scratch;
        let Closest { facet, .. } = *closest;
        let (wanted, falls_back, weight) = match options.element {
            ContactElement::Diffuse { search, weight, .. } => (search.basis, search.linear_fallback, weight),
            ContactElement::NodeToFacet => (Basis::Linear, false, Weight::default()),
        };
        let (basis, fallback) = match (wanted, nodal.domains.carried(facet)) {
            (Basis::Quadratic, Carried::Linear) if falls_back => {
                (Basis::Linear, Fallback::Linear { quadratic_regularity: 0.0 })
            }
            (Basis::Quadratic, Carried::Quadratic) | (Basis::Linear, Carried::Linear) => {
                (wanted, Fallback::None)
            }
            _ => {
                let reason = NeighbourhoodError::NoCandidate { found: 0, needed: wanted.size() };
                return Err(NoContact::NoCandidate { reason });
            }
        };
        // A slave far beyond a border may have no place: all are listed then, and the evaluation says why there is no contact.
        let listed = nodal.domains.listed(facet);
        let place = self.evaluator.place_among(listed, node, facet, weight, element).ok();
        let mut shortest = f64::INFINITY;
        for &Listed { place: of_node, image } in listed {
            let domain = nodal.domain(of_node, image);
            let is_far = |place| domain.length(Vector3::from(domain.position) - place) >= 1.0 + SKIN;
            if place.is_some_and(is_far) {
                continue;
            }
            shortest = shortest.min(domain.shortest());
            if places.last() != Some(&of_node) {
                places.push(of_node);
                masters.push(surface.nodes()[of_node as usize]);
            }
            if image != NONE {
                images.extend([places.len() as u32 - 1, image]);
            }
        }
        creases.patch_with_end(surface, facet, masters, patch);
        list_carriers(self.evaluator.anchors_of(k), masters, places, images);
        let complete_within = 0.5 * SKIN * shortest * self.squeezed(nodal, facet);
        Ok(Record { support_radius: shortest, basis, fallback, facet, complete_within })
    }

    /// By how much the shortest edge of a facet has become shorter, a factor of at most 1: domains, and the skin around them, lie in the
    /// first configuration, where a slave's place moves by as much more.
    fn squeezed(&self, nodal: &Nodal, facet: u32) -> f64 {
        let (shape, places) = (self.index.shape(facet), self.evaluator.surface.corners_of(facet as usize));
        let first = |corner: usize| Vector3::from(nodal.domains.domain(places[corner] as usize).position);
        let ratio = |edge: usize| {
            let [from, to] = shape.edge(edge);
            (to - from).norm() / (first((edge + 1) % places.len()) - first(edge)).norm()
        };
        (0..places.len()).map(ratio).fold(1.0, f64::min)
    }
}

/// The slaves along a space-filling curve (bits of the coordinates interleaved): one after another works on the
/// same part of the master surface, which is in the cache then.
fn spatial_order(slaves: &[usize], positions: &[Point]) -> Vec<u32> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for &node in slaves {
        for axis in 0..3 {
            low[axis] = low[axis].min(positions[node][axis]);
            high[axis] = high[axis].max(positions[node][axis]);
        }
    }
    let extent = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    let key = |node: usize| {
        let cell = |axis: usize| ((positions[node][axis] - low[axis]) / extent * f64::from(1 << 20)) as u64;
        (0..3).map(|axis| spread_bits(cell(axis)) << axis).sum::<u64>()
    };
    let mut order: Vec<(u64, u32)> =
        slaves.par_iter().enumerate().map(|(k, &node)| (key(node), k as u32)).collect();
    order.par_sort_unstable();
    order.into_iter().map(|(_, k)| k).collect()
}

/// Bit k of a number below 2²¹ goes to bit 3k.
fn spread_bits(x: u64) -> u64 {
    let x = x & 0x1f_ffff;
    let x = (x | x << 32) & 0x001f_0000_0000_ffff;
    let x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_spread_by_three() {
        for x in [0, 1, 0b101, 0x1f_ffff, 0x15_5555, 0x10_0001] {
            let expected: u64 = (0..21).map(|k| (x >> k & 1) << (3 * k)).sum();
            assert_eq!(spread_bits(x), expected);
        }
    }

    #[test]
    fn the_order_holds_every_slave_once_wherever_they_are() {
        let positions: Vec<Point> = (0..100).map(|k| [f64::from(k * 37 % 100), 1e70, -0.1]).collect();
        let slaves: Vec<usize> = (0..100).collect();
        let order = spatial_order(&slaves, &positions);
        assert!(order.windows(2).all(|k| positions[k[0] as usize][0] < positions[k[1] as usize][0]));
        assert_eq!(spatial_order(&[7], &positions), [0]);
        assert!(spatial_order(&[], &positions).is_empty());
    }
}
