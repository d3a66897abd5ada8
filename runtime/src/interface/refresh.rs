//! Pairing every slave with its masters.

use std::cell::RefCell;

use crate::vector::{Vector3, bounds};
use rayon::prelude::*;

use super::anchors::append_carriers;
use super::contacts::Layout;
use super::evaluator::Evaluator;
use super::listing::ListedAuxiliary;
use super::pairings::{Lists, Paired, Pairings, Record};
use super::report::RefreshReport;
use super::scratch::ElementScratch;
use super::window::Knowledge;
use super::{ContactElement, InterfaceError, NoContact};
use crate::neighbourhood::{Fallback, NeighbourSearch, SearchOptions};
use crate::pairing::NearestNodes;
use crate::scratch::Pool;
use crate::surface::{Closest, Creases, Foot, SurfaceIndex, Walk};
use crate::{Basis, Frame, Point};

/// Slaves that one thread pairs in a row.
const CHUNK: usize = 256;
/// A slave that lies beyond the border by more than this many heights of the facet is not paired.
pub(super) const FARTHEST_BEYOND: f64 = 1.0;

/// A slave deeper below the closest facet than this part of the facet's size is more than a mesh that does not quite fit.
const DEEP: f64 = 0.1;

/// Whose gaps before and after a refresh are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compares {
    /// Those of all slaves.
    All,
    /// Of slaves that had no pairing, have none, or come to where their old list does not reach, such as another sheet: another list makes
    /// no difference elsewhere.
    OtherSheets,
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
    /// How far each slave may still move with the list it has, if any does: lists of those that may move stay.
    pub slacks: Option<&'a [f64]>,
    /// What is known, where there is a window of the surface only.
    pub knowledge: Option<Knowledge<'a>>,
}

/// Memory of one thread, kept from one refresh to the next.
#[derive(Clone, Debug)]
pub struct RefreshScratch {
    search: NeighbourSearch,
    walk: Walk,
    ties: Vec<Closest>,
    pub(super) masters: Vec<u32>,
    pub(super) sheet_nodes: Vec<u32>,
    pub(super) images: Vec<u32>,
    pub(super) between: Vec<ListedAuxiliary>,
    pub(super) auxiliary: Vec<u32>,
    pub(super) patch: Vec<u32>,
    pub(super) element: ElementScratch,
}

impl RefreshScratch {
    pub fn new(options: SearchOptions) -> Result<Self, InterfaceError> {
        Ok(Self {
            search: NeighbourSearch::new(options)?,
            walk: Walk::default(),
            ties: Vec::new(),
            masters: Vec::new(),
            sheet_nodes: Vec::new(),
            images: Vec::new(),
            between: Vec::new(),
            auxiliary: Vec::new(),
            patch: Vec::new(),
            element: ElementScratch::default(),
        })
    }
}

/// What a refresh made.
pub struct Refreshed {
    pub pairings: Pairings,
    pub report: RefreshReport,
    /// Which slaves lost a contact, and the gap of each by the old pairing, in no order.
    pub lost: Vec<(u32, f64)>,
}

/// The facet that a slave is to be paired with.
#[derive(Clone, Copy)]
struct Found {
    closest: Closest,
    /// Whether the slave stays below a facet that it would not be paired with anew.
    stays_below: bool,
}

/// The pairing of slaves near one another.
#[derive(Default)]
struct Chunk {
    records: Vec<Result<Record, NoContact>>,
    slacks: Vec<f64>,
    masters: Lists,
    frames: Vec<Frame>,
    patches: Lists,
    sheet_nodes: Vec<u32>,
    images: Lists,
    auxiliary: Lists,
    report: RefreshReport,
    lost: Vec<(u32, f64)>,
}

impl Chunk {
    /// Books the gap of the `k`-th slave by the old and by the new pairing, as far as there is one.
    fn compare(&mut self, k: usize, slave: usize, before: Option<f64>, after: Option<f64>) {
        self.report.compare(slave, before, after);
        if after.is_none() {
            self.lost.extend(before.map(|gap| (k as u32, gap)));
        }
    }

    /// Appends the lists of a slave.
    fn push(&mut self, paired: &Paired<'_>) {
        self.masters.push(paired.masters);
        self.records.push(Ok(*paired.record));
        self.frames.extend(paired.frame);
        self.patches.push(paired.patch);
        self.sheet_nodes.extend_from_slice(paired.sheet_nodes);
        self.images.push(paired.images);
        self.auxiliary.push(paired.auxiliary);
    }

    /// Appends a slave without a pairing.
    fn push_without(&mut self, reason: NoContact, stand_in: Option<Frame>) {
        self.report.count_without(reason);
        self.records.push(Err(reason));
        self.frames.extend(stand_in);
        for lists in [&mut self.masters, &mut self.patches, &mut self.images, &mut self.auxiliary] {
            lists.push(&[]);
        }
    }
}

impl Refresh<'_> {
    /// Pairs all slaves, in parallel; neither the pairing nor the report depends on the number of threads.
    pub fn run(&self, pool: &Pool<RefreshScratch>, blank: &RefreshScratch) -> Refreshed {
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
        let mut masters = Vec::with_capacity(chunks.iter().map(|chunk| chunk.masters.count()).sum());
        let mut records = Vec::with_capacity(order.len());
        let mut slacks = Vec::with_capacity(order.len());
        let mut frames = Vec::new();
        let [mut patches, mut images, mut auxiliary] = <[Lists; 3]>::default();
        let mut sheet_nodes = Vec::new();
        chunks.iter().for_each(|chunk| report.append(&chunk.report));
        for &place in &places {
            let (chunk, own) = (&chunks[place / CHUNK], place % CHUNK);
            records.push(chunk.records[own]);
            slacks.push(chunk.slacks[own]);
            masters.extend_from_slice(chunk.masters.get(own));
            frames.extend(chunk.frames.get(own));
            patches.push(chunk.patches.get(own));
            images.push(chunk.images.get(own));
            auxiliary.push(chunk.auxiliary.get(own));
            sheet_nodes.extend_from_slice(chunk.sheet_nodes.get(chunk.masters.range(own)).unwrap_or(&[]));
        }
        let lengths = places.iter().map(|place| chunks[place / CHUNK].masters.range(place % CHUNK).len());
        let layout = Layout::new(old.slaves().to_vec(), old.areas().to_vec(), lengths, masters).into();
        let pairings = Pairings {
            is_made: true,
            layout,
            records,
            slacks,
            frames,
            patches,
            sheet_nodes,
            images,
            auxiliary,
        };
        Refreshed { pairings, report, lost: chunks.into_iter().flat_map(|chunk| chunk.lost).collect() }
    }

    /// Pairs the `k`-th slave and books it.
    fn slave(&self, k: usize, scratch: &mut RefreshScratch, chunk: &mut Chunk) {
        if let Some(&slack) = self.slacks.map(|slacks| &slacks[k]).filter(|slack| **slack > 0.0) {
            return self.keep(k, slack, chunk);
        }
        let node = self.old.layout.slave(k);
        let old = self.old.get(k).ok();
        let found = match self.facets {
            Some(facets) => Ok(Found { closest: self.over(node, facets[k]), stays_below: false }),
            None => self.closest(node, old.as_ref().filter(|_| self.follows), scratch),
        };
        let closest = found.map(|found| found.closest);
        let record = closest.and_then(|closest| {
            if self.facets.is_none() {
                self.check_reach(node, &closest, &scratch.ties)?;
            }
            self.pair(k, &closest, scratch)
        });
        chunk.slacks.push(match found {
            // A refresh of the same positions would not find it.
            Ok(Found { stays_below: true, .. }) => 0.0,
            _ => self.slack(
                k,
                closest.as_ref().map_err(|reason| *reason),
                record.as_ref().map_err(|reason| *reason),
            ),
        });
        let RefreshScratch { masters, sheet_nodes, images, auxiliary, patch, element, .. } = scratch;
        let paired = record.as_ref().map_err(|reason| *reason).and_then(|record| {
            let paired =
                Paired { slave: node, masters, record, frame: None, patch, sheet_nodes, images, auxiliary };
            Ok((paired, self.evaluator.held_frame(&paired)?))
        });
        match paired {
            Ok((paired, frame)) => {
                let report = &mut chunk.report;
                report.paired += 1;
                report.count_fallback(paired.record.fallback);
                report.deep += usize::from(self.is_deep(node, paired.record.facet, closest.ok().as_ref()));
                match old {
                    None => report.gained += 1,
                    Some(old) if old.masters == paired.masters => report.renewed += 1,
                    Some(_) => report.changed += 1,
                }
                let paired = Paired { frame: frame.as_ref(), ..paired };
                if self.compares(old.as_ref().map(|old| old.record.facet), paired.record.facet) {
                    let before = old.as_ref().and_then(|old| self.old_gap(old, element));
                    chunk.compare(k, node, before, self.evaluator.gap(&paired, element).ok());
                }
                chunk.push(&paired);
            }
            Err(reason) => {
                chunk.report.lost += usize::from(old.is_some());
                chunk.compare(k, node, old.and_then(|old| self.old_gap(&old, element)), None);
                chunk.push_without(reason, self.evaluator.stand_in_frame());
            }
        }
    }

    /// Leaves the list of the `k`-th slave as it is.
    fn keep(&self, k: usize, slack: f64, chunk: &mut Chunk) {
        chunk.slacks.push(slack);
        match self.old.get(k) {
            Ok(paired) => {
                let report = &mut chunk.report;
                (report.paired, report.kept) = (report.paired + 1, report.kept + 1);
                report.count_fallback(paired.record.fallback);
                report.deep += usize::from(self.is_deep(paired.slave, paired.record.facet, None));
                chunk.push(&paired);
            }
            Err(reason) => chunk.push_without(reason, self.evaluator.stand_in_frame()),
        }
    }

    /// Whether gaps are compared of a slave with a pairing. `before`: the facet of the old one.
    fn compares(&self, before: Option<u32>, facet: u32) -> bool {
        match (self.compares, self.evaluator.nodal, before) {
            (Compares::None, ..) => false,
            (Compares::OtherSheets, Some(nodal), Some(before)) => !self.lists_alike(nodal, before, facet),
            _ => true,
        }
    }

    /// Whether a slave lies deep below the facet of its pairing. `closest`: where that was looked for.
    fn is_deep(&self, node: usize, facet: u32, closest: Option<&Closest>) -> bool {
        let known = closest.filter(|closest| closest.facet == facet);
        let foot = known.map_or_else(|| self.over(node, facet).point, |closest| closest.point);
        let height =
            (Vector3::from(self.evaluator.positions[node]) - foot).dot(&self.index.normals()[facet as usize]);
        height < 0.0 && height * height > DEEP * DEEP * self.index.shape(facet).area_vector().norm()
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

    /// The closest facet. `old`: the pairing that the slave follows, to whose side of the surface it stays.
    fn closest(
        &self,
        node: usize,
        old: Option<&Paired<'_>>,
        scratch: &mut RefreshScratch,
    ) -> Result<Found, NoContact> {
        let found = |closest: Closest| Found { closest, stays_below: false };
        let nearest = self.closest_of(node, old, scratch, |_| true);
        let Some(old) = old else { return nearest.map(found) };
        let normals = self.index.normals();
        let before = normals[old.record.facet as usize];
        match nearest {
            Ok(closest) if before.dot(&normals[closest.facet as usize]) < 0.0 => {
                let is_on_its_side = |facet: u32| before.dot(&normals[facet as usize]) >= 0.0;
                self.closest_of(node, Some(old), scratch, is_on_its_side).map(found)
            }
            // So deep below its facet, in contact with itself, that none is a candidate.
            Err(NoContact::NothingOver { .. }) => {
                let closest = self.over(node, old.record.facet);
                let offset = Vector3::from(self.evaluator.positions[node]) - closest.point;
                scratch.ties.clear();
                let stays_below = before.dot(&offset) < 0.0;
                if stays_below { Ok(Found { closest, stays_below }) } else { nearest.map(found) }
            }
            nearest => nearest.map(found),
        }
    }

    /// The closest of the facets that `may` says so of.
    fn closest_of(
        &self,
        node: usize,
        old: Option<&Paired<'_>>,
        scratch: &mut RefreshScratch,
        may: impl Fn(u32) -> bool,
    ) -> Result<Closest, NoContact> {
        let slave = self.evaluator.positions[node];
        let Evaluator { options, own, surface, nodal, .. } = self.evaluator;
        let ties = &mut scratch.ties;
        let own = own.map(|own| (own, surface.nodes().binary_search(&(node as u32))));
        if let Some((own, Ok(place))) = own {
            let (domains, before) = (nodal.map(|nodal| &nodal.domains), old.map(|old| old.record.facet));
            let found = own.closest(self.index, domains, place, before, ties, may);
            return found.ok_or(NoContact::NothingOver { limit: own.limit() });
        }
        let closest = self.index.closest_where(slave, f64::INFINITY, ties, |facet, _| may(facet));
        match self.knowledge {
            Some(knowledge) => knowledge.check(slave, options.distance_limit, closest, ties),
            // Positions have been checked, so that there is a closest facet.
            None => closest.ok_or(NoContact::NotPaired),
        }
    }

    /// Whether the closest facet is near enough, and the slave not far beyond the border. `ties`: all that are as close.
    fn check_reach(&self, node: usize, closest: &Closest, ties: &[Closest]) -> Result<(), NoContact> {
        let Evaluator { creases, options, positions, .. } = self.evaluator;
        if let Some(limit) = options.distance_limit
            && closest.distance > limit
        {
            return Err(NoContact::TooFar { distance: closest.distance, limit });
        }
        let beyond = creases.slave_beyond(self.index, positions[node], ties);
        if beyond > FARTHEST_BEYOND + options.border_tolerance {
            return Err(NoContact::BeyondBorder { distance: beyond, tolerance: options.border_tolerance });
        }
        Ok(())
    }

    /// The pairing of the `k`-th slave with the masters around its closest facet, which go to `scratch.masters`.
    fn pair(&self, k: usize, closest: &Closest, scratch: &mut RefreshScratch) -> Result<Record, NoContact> {
        let Evaluator { surface, creases, positions, options, .. } = self.evaluator;
        let RefreshScratch { search, walk, masters, sheet_nodes, images, between, auxiliary, patch, .. } =
            scratch;
        masters.clear();
        sheet_nodes.clear();
        images.clear();
        between.clear();
        auxiliary.clear();
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
        })
    }
}

/// The slaves along a space-filling curve (bits of the coordinates interleaved): one after another works on the
/// same part of the master surface, which is in the cache then.
fn spatial_order(slaves: &[usize], positions: &[Point]) -> Vec<u32> {
    let [low, high] = bounds(slaves.iter().map(|&node| positions[node]));
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
