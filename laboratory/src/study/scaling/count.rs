//! What each rank holds, gets and sends, by the rules of the library and of the host in `hosts/dolfinx`.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::partition::Partition;
use super::rects::{Rect, bounds, boxes, count, split, sums, within};
use super::stencil::{SHIFT, Stencil};

/// Facets around the own ones that a part of a surface is made with, in extents of a facet.
pub const WIDTH: i64 = 8;
/// Boxes around the slaves of a rank.
pub const BOXES: usize = 8;
/// The limit of the distance is reached for by so much more.
pub const MARGIN: f64 = 1.001;

/// Bytes of a facet that the host holds: number, and by corner number, equations, owner and first position.
const FACET: u64 = 8 + 4 * (3 * 8 + 24);
/// Bytes of a position, and of a force.
const POINT: u64 = 24;
/// Bytes of equations and owner that the host sends with a node of a window.
const NODE: u64 = 16;
/// Bytes of an entry of a row of another rank: value, row and column.
const ENTRY: u64 = 16;

/// A flat square surface of square facets of side 1, and slaves over part of it.
pub struct Scene {
    /// Facets along a side.
    pub side: i64,
    /// Cells with a slave each.
    pub contact: Rect,
    /// Largest distance at which there is contact, over the side of a facet.
    pub limit: f64,
    /// How far nodes may move before windows are made anew, over the side of a facet.
    pub skin: f64,
    pub stencil: Stencil,
}

/// What a window has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Size {
    pub core: u64,
    pub facets: u64,
    pub nodes: u64,
    /// Corners of the core.
    pub cut: u64,
}

impl Size {
    /// Bytes of a window with these boxes as numbers.
    pub fn bytes(self, boxes: usize, listed: u64) -> u64 {
        let integers = 10 + 2 * self.nodes + 7 * self.facets + listed * self.core;
        8 * (integers + 9 + 6 * boxes as u64 + 9 * self.nodes + 3 * self.cut)
    }
}

/// Nodes that come from others, and from how many of these.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flow {
    pub count: u64,
    pub ranks: u64,
}

impl Flow {
    fn add(&mut self, count: u64) {
        self.count += count;
        self.ranks += 1;
    }
}

/// What a rank gets from others. What it sends is counted the same way, at the other end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Nodes of the window and of the slaves' facets: positions come, forces go.
    pub nodes: Flow,
    /// Slaves' nodes once more, and nodes of the part: for the watch over the skin.
    pub slaves: Flow,
    pub part: Flow,
    /// Bytes of windows.
    pub windows: Flow,
    /// Bytes of rows of the tangent. They go where positions come from.
    pub rows: Flow,
}

impl Traffic {
    fn flows(&mut self) -> [&mut Flow; 5] {
        [&mut self.nodes, &mut self.slaves, &mut self.part, &mut self.windows, &mut self.rows]
    }
}

/// What a rank has.
#[derive(Clone, Debug, Default)]
pub struct Rank {
    pub own: u64,
    pub part: u64,
    pub slaves: u64,
    pub window: Size,
    /// Bytes of surface, as the host counts them.
    pub bytes: u64,
    /// Ranks that something comes from in an iteration.
    pub neighbours: u64,
    pub gets: Traffic,
    pub sends: Traffic,
}

impl Scene {
    /// How far boxes reach beyond slaves.
    pub fn reach(&self) -> f64 {
        MARGIN * self.limit + self.skin
    }

    fn nodes(&self) -> Rect {
        Rect::square(self.side + 1)
    }

    /// Facets that a rank knows in the first phase: those that meet a box around its own.
    pub fn part(&self, own: &[Rect]) -> Option<Rect> {
        // A facet that only touches the box meets it.
        bounds(own).and_then(|own| own.grown(WIDTH + 1, WIDTH + 1).common(Rect::square(self.side)))
    }

    /// Boxes around slaves, and the facets that meet them with the skin around.
    pub fn core(&self, slaves: &[Rect]) -> Vec<Rect> {
        let reach = self.reach() + self.skin;
        let core = |Rect(of): &Rect| {
            let meets = |axis: usize| {
                let [from, to] = of[axis];
                let (low, high) = (from as f64 + SHIFT[axis] - reach, (to - 1) as f64 + SHIFT[axis] + reach);
                [(low - 1.0).ceil() as i64, high.floor() as i64 + 1]
            };
            Rect([meets(0), meets(1)])
        };
        let core: Vec<Rect> = boxes(slaves, BOXES).iter().map(core).collect();
        within(&core, Rect::square(self.side))
    }

    /// Facets of a window with this core.
    pub fn facets(&self, core: &[Rect]) -> Vec<Rect> {
        within(&sums(core, &self.stencil.facets), Rect::square(self.side))
    }

    pub fn size(&self, core: &[Rect], facets: &[Rect]) -> Size {
        let nodes = count(&corners(facets));
        Size { core: count(core), facets: count(facets), nodes, cut: count(&corners(core)) }
    }

    /// Facets between slaves with a corner among these, and all their corners.
    fn slave_facets(&self, slaves: &[Rect]) -> [Vec<Rect>; 2] {
        let grown = |before, after| slaves.iter().map(|own| own.grown(before, after)).collect::<Vec<_>>();
        let Rect(contact) = self.contact;
        let facets = Rect(contact.map(|[from, to]| [from, to - 1]));
        [within(&grown(1, 0), facets), within(&grown(1, 1), self.contact)]
    }

    /// The slaves of each rank: where they are owned, …
    pub fn slaves_owned(&self, partition: &Partition) -> Vec<Vec<Rect>> {
        partition.regions().iter().map(|own| within(own, self.contact)).collect()
    }

    /// … or dealt out evenly: in the order of the ranks that own them, along the longest side of what each has.
    pub fn slaves_dealt(&self, partition: &Partition) -> Vec<Vec<Rect>> {
        let (ranks, all) = (partition.count as u64, self.contact.count());
        // The first slave of a rank's share.
        let start = |rank: u64| (u128::from(rank) * u128::from(all)).div_ceil(u128::from(ranks)) as u64;
        let mut shares = vec![Vec::new(); partition.count];
        let (mut rank, mut before) = (0, 0);
        for mut own in self.slaves_owned(partition) {
            let Some(Rect([[a, b], [c, d]])) = bounds(&own) else { continue };
            let axis = usize::from(d - c > b - a);
            let end = before + count(&own);
            while before < end {
                while start(rank + 1) <= before {
                    rank += 1;
                }
                let next = start(rank + 1).min(end);
                let [first, rest] = split(&own, axis, next - before);
                shares[rank as usize].extend(first);
                (own, before) = (rest, next);
            }
        }
        shares
    }

    /// Counts for all ranks.
    pub fn count(&self, partition: &Partition, slaves: &[Vec<Rect>]) -> Vec<Rank> {
        let regions = partition.regions();
        let counted = (0..partition.count).into_par_iter();
        let counted: Vec<(Rank, Others)> =
            counted.map(|rank| self.of_rank(partition, rank, &regions[rank], &slaves[rank])).collect();
        let (mut ranks, from): (Vec<Rank>, Vec<_>) = counted.into_iter().unzip();
        for (owner, amounts) in from.into_iter().flatten() {
            let flows = ranks[owner].sends.flows().into_iter().zip(amounts);
            flows.filter(|(_, amount)| *amount > 0).for_each(|(flow, amount)| flow.add(amount));
        }
        ranks
    }

    /// Counts for a rank, and what comes from each of the others.
    fn of_rank(&self, partition: &Partition, rank: usize, own: &[Rect], slaves: &[Rect]) -> (Rank, Others) {
        let core = self.core(slaves);
        let facets = self.facets(&core);
        let window = self.size(&core, &facets);
        let part: Vec<Rect> = self.part(own).into_iter().collect();
        let [slave_facets, slave_nodes] = self.slave_facets(slaves);
        let (boxes, listed) = (boxes(slaves, BOXES).len(), self.stencil.listed);
        let numbers = if core.is_empty() { 0 } else { window.bytes(boxes, listed) };
        let mut found = Rank {
            own: count(own),
            part: count(&part),
            slaves: count(slaves),
            window,
            bytes: FACET * (count(&part) + count(&slave_facets)) + numbers,
            ..Rank::default()
        };
        let mut amounts = Amounts::default();
        amounts.add(partition.nodes(&corners(&facets)), &[0], count);
        amounts.add(partition.cells(&slave_nodes), &[0, 1], count);
        amounts.add(partition.nodes(&corners(&part)), &[2], count);
        amounts.add(partition.cells(&core), &[3], |core| {
            let sent = self.size(core, &self.facets(core));
            sent.bytes(boxes, listed) + NODE * sent.nodes
        });
        let [masters, slave] = self.row_bytes();
        let touched = self.touched(slaves);
        amounts.add(partition.nodes(&touched), &[4], |nodes| masters * count(nodes));
        amounts.add(partition.cells(slaves), &[4], |nodes| slave * count(nodes));
        amounts.0.remove(&rank);
        for amounts in amounts.0.values() {
            found.neighbours += u64::from(amounts[..3].iter().any(|count| *count > 0));
            let flows = found.gets.flows().into_iter().zip(amounts);
            flows.filter(|(_, amount)| **amount > 0).for_each(|(flow, amount)| flow.add(*amount));
        }
        (found, amounts.0.into_iter().collect())
    }

    /// Masters that carry the fit of a slave.
    fn touched(&self, slaves: &[Rect]) -> Vec<Rect> {
        within(&sums(slaves, &self.stencil.masters), self.nodes())
    }

    /// Bytes of the rows of a master node, as full as inside the contact, and of a slave.
    fn row_bytes(&self) -> [u64; 2] {
        let Stencil { coupled, carried, .. } = self.stencil;
        [coupled + carried, carried + 1].map(|blocks| 9 * ENTRY * blocks)
    }
}

/// What comes from other ranks, in the order of [`Traffic`].
type Others = Vec<(usize, [u64; 5])>;

/// The same by rank.
#[derive(Default)]
struct Amounts(BTreeMap<usize, [u64; 5]>);

impl Amounts {
    /// Adds what is counted for each owner's share, in these places.
    fn add(&mut self, owners: Vec<(usize, Vec<Rect>)>, places: &[usize], counted: impl Fn(&[Rect]) -> u64) {
        for (owner, share) in owners {
            let amounts = self.0.entry(owner).or_default();
            places.iter().for_each(|&place| amounts[place] += counted(&share));
        }
    }
}

/// Nodes of facets.
fn corners(facets: &[Rect]) -> Vec<Rect> {
    facets.iter().map(|own| own.grown(0, 1)).collect()
}

impl Rank {
    /// Bytes of an iteration, the larger of what comes and what goes, without the tangent and with its rows.
    pub fn iteration_bytes(&self) -> [u64; 2] {
        let watch = |one: &Traffic| POINT * (one.slaves.count + one.part.count);
        let both = POINT * (self.gets.nodes.count + self.sends.nodes.count);
        let (gets, sends) = (both + watch(&self.gets), both + watch(&self.sends));
        // Rows go where nodes come from.
        [gets.max(sends), (gets + self.sends.rows.count).max(sends + self.gets.rows.count)]
    }

    /// Messages of an iteration, the larger of those that come and those that go, without the tangent and with its rows.
    pub fn iteration_messages(&self) -> [u64; 2] {
        let watch = |one: &Traffic| one.slaves.ranks + one.part.ranks;
        let both = self.gets.nodes.ranks + self.sends.nodes.ranks;
        let (gets, sends) = (both + watch(&self.gets), both + watch(&self.sends));
        [gets.max(sends), (gets + self.sends.rows.ranks).max(sends + self.gets.rows.ranks)]
    }

    /// Bytes of windows made anew, the larger of what comes and what goes; boxes are apart.
    pub fn window_bytes(&self) -> u64 {
        self.gets.windows.count.max(self.sends.windows.count)
    }

    pub fn window_messages(&self) -> u64 {
        self.gets.windows.ranks.max(self.sends.windows.ranks)
    }
}

#[cfg(test)]
mod tests;
