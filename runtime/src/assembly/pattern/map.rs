//! Which entries of a matrix the blocks of the elements are added to.

use rayon::prelude::*;

use super::super::{AssemblyError, DofMap, Elements, in_memory, reserve};
use super::incidence::{Incidence, Lists, Neighbours};
use super::locate::{CsrIndex, Located, Slots, check_rows, locate};
use super::rows::{RowGroup, row_groups};
use super::split::for_each_part;
use crate::scratch::Pool;

/// Elements that are added at once, for each thread: so few that their numbers stay in the processor's cache.
const BATCH_PER_THREAD: usize = 256;
/// Pieces of a batch for each thread, if there are several.
const PIECES_PER_THREAD: usize = 2;

/// Where the tangents of elements go in the values of a matrix in compressed sparse rows: of the [`CsrPattern`](super::CsrPattern) that
/// it belongs to, or of a matrix that a host has already. It serves as long as the elements have the same nodes.
///
/// # How entries are summed
///
/// Elements are taken in batches, in their order. The rows of a batch are cut into pieces, which threads share. Each piece takes the
/// elements in their order, and their nodes in theirs. So each entry is the sum in the order of the elements, for any number of threads.
///
/// # Memory
///
/// For each slave with n masters 4 (n + 1) r bytes for the places of its blocks, 28 (n + 1) + 4 r for its nodes, and 24 besides; for each
/// node 80. Slave and masters make up r runs of nodes whose numbers and equations are consecutive: n + 1 if there are no such
/// neighbours. With nodes that have not three consecutive equations it is 36 bytes more for each pair of nodes that occur together.
#[derive(Clone, Debug)]
pub struct CsrMap {
    /// Whose nodes the lists are; `None` if they tell nobody.
    stamp: Option<u64>,
    equations: usize,
    entries: usize,
    /// Nodes of each element, slave first.
    element_nodes: Lists<u32>,
    /// Which of them begin a run, see [`Incidence::runs`].
    pub(super) runs: Lists<u32>,
    /// Rows that are added to, ascending.
    pub(super) groups: Vec<Located>,
    /// For each node of an element, and each of the element's runs: the slot of its first column in the rows of the former. Where these are
    /// not regular: which of the neighbours its first node is.
    pub(super) places: Vec<u32>,
    /// Slots of the neighbours in rows that are not regular.
    pub(super) others: Vec<[u32; 3]>,
    /// Elements of each batch, but for the last one.
    batch_size: usize,
    batches: Vec<Batch>,
    /// Rows of an element.
    pub(super) scratch: Pool<Vec<f64>>,
}

/// The work on some consecutive elements.
#[derive(Clone, Debug)]
pub(super) struct Batch {
    /// Those of one piece after another.
    tasks: Vec<Task>,
    pieces: Vec<Piece>,
}

/// Rows that one thread adds to.
#[derive(Clone, Copy, Debug)]
struct Piece {
    first_group: u32,
    /// Where its tasks end.
    end: usize,
}

/// What an element adds to a group of rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Task {
    /// Where the places of its runs begin.
    pub places: usize,
    pub element: u32,
    /// The node that the rows belong to, among those of the element.
    pub local: u32,
    pub group: u32,
    /// Whether it is the group's first, …
    pub opens: bool,
    /// … or its last.
    pub closes: bool,
}

/// The nodes of elements and the rows they have.
#[derive(Debug)]
pub(super) struct Found {
    stamp: Option<u64>,
    incidence: Incidence,
    pub neighbours: Neighbours,
    pub groups: Vec<RowGroup>,
}

impl Found {
    pub fn new<E: Elements + ?Sized>(elements: &E, dofs: &DofMap) -> Result<Self, AssemblyError> {
        let incidence = Incidence::new(elements, dofs)?;
        let neighbours = incidence.neighbours()?;
        let groups = row_groups(&neighbours, dofs)?;
        Ok(Self { stamp: elements.stamp(), incidence, neighbours, groups })
    }

    /// The places in a matrix whose row offsets have been checked, in memory that may be there. `is_union`: it is that of the union
    /// pattern.
    pub fn within<R: CsrIndex, C: CsrIndex>(
        self,
        dofs: &DofMap,
        row_offsets: &[R],
        columns: &[C],
        is_union: bool,
        places: Vec<u32>,
    ) -> Result<CsrMap, AssemblyError> {
        let (groups, slots) = locate(&self.neighbours, &self.groups, dofs, row_offsets, columns, is_union)?;
        let of_nodes = Lists::by(dofs.nodes(), groups.iter().map(|group| group.rows.node).zip(0..))?;
        let places = self.places(&groups, &of_nodes, &slots, places)?;
        let batch_size = BATCH_PER_THREAD * rayon::current_num_threads();
        let batches: Vec<Result<Batch, AssemblyError>> = (0..self.incidence.nodes.len().div_ceil(batch_size))
            .into_par_iter()
            .map(|batch| Batch::new(&self.incidence, &of_nodes, batch * batch_size, batch_size))
            .collect();
        Ok(CsrMap {
            stamp: self.stamp,
            equations: dofs.equations(),
            entries: columns.len(),
            element_nodes: self.incidence.nodes,
            runs: self.incidence.runs,
            groups,
            places,
            others: slots.others,
            batch_size,
            batches: batches.into_iter().collect::<Result<_, _>>()?,
            scratch: Pool::default(),
        })
    }

    /// [`CsrMap::places`].
    fn places(
        &self,
        groups: &[Located],
        of_nodes: &Lists<u32>,
        slots: &Slots,
        places: Vec<u32>,
    ) -> Result<Vec<u32>, AssemblyError> {
        let Incidence { nodes, runs, elements, bases, .. } = &self.incidence;
        let count = elements.len();
        let mut places = in_memory("runs of nodes of elements", bases[count], places)?;
        let pool = Pool::default();
        for_each_part(0..count, &|node| bases[node], &mut places, &|range, places: &mut [u32]| {
            // Each is written before it is read.
            pool.with(
                || vec![0_u32; count],
                |marks| {
                    let mut rest = places;
                    for node in range.filter(|&node| bases[node] < bases[node + 1]) {
                        let group = &groups[of_nodes.get(node)[0] as usize];
                        let around = self.neighbours.get(node).iter();
                        if group.is_regular {
                            around
                                .zip(slots.regular(group))
                                .for_each(|(&node, slot)| marks[node as usize] = slot);
                        } else {
                            around.zip(0..).for_each(|(&node, place)| marks[node as usize] = place);
                        }
                        for &element in elements.get(node) {
                            let (own, runs) = (nodes.get(element as usize), runs.get(element as usize));
                            let (front, after) = rest.split_at_mut(runs.len());
                            for (place, &local) in front.iter_mut().zip(runs) {
                                *place = marks[own[local as usize] as usize];
                            }
                            rest = after;
                        }
                    }
                },
            );
        });
        Ok(places)
    }
}

impl Batch {
    /// The work on at most `size` elements from `first` on.
    fn new(
        incidence: &Incidence,
        of_nodes: &Lists<u32>,
        first: usize,
        size: usize,
    ) -> Result<Self, AssemblyError> {
        let elements = first..incidence.nodes.len().min(first + size);
        let nodes = incidence.nodes.range(elements.start).start..incidence.nodes.range(elements.end - 1).end;
        let mut tasks = reserve("nodes of elements", nodes.len())?;
        for element in elements {
            let (own, at) = (incidence.nodes.get(element), incidence.nodes.range(element).start);
            let runs = incidence.runs.range(element).len();
            for (local, &node) in own.iter().enumerate() {
                let places = incidence.starts[at + local];
                let [opens, closes] = [
                    places == incidence.bases[node as usize],
                    places + runs == incidence.bases[node as usize + 1],
                ];
                let (element, local) = (element as u32, local as u32);
                let of_node = of_nodes.get(node as usize).iter();
                tasks.extend(of_node.map(|&group| Task { places, element, local, group, opens, closes }));
            }
        }
        let threads = rayon::current_num_threads();
        if threads == 1 {
            let end = tasks.len();
            return Ok(Self { tasks, pieces: vec![Piece { first_group: 0, end }] });
        }
        Self::in_pieces(&tasks, PIECES_PER_THREAD * threads)
    }

    /// Tasks ordered by pieces, of which at most `most` have about as many each.
    fn in_pieces(tasks: &[Task], most: usize) -> Result<Self, AssemblyError> {
        // A sample tells where to cut.
        let step = (tasks.len() / (16 * most)).max(1);
        let mut sample: Vec<u32> = tasks.iter().step_by(step).map(|task| task.group).collect();
        sample.sort_unstable();
        let mut firsts: Vec<u32> =
            (1..most).filter_map(|k| sample.get(k * sample.len() / most).copied()).collect();
        firsts.insert(0, 0);
        firsts.dedup();
        let piece_of = |task: &Task| firsts.partition_point(|&first| first <= task.group) - 1;
        let mut next = vec![0; firsts.len() + 1];
        tasks.iter().for_each(|task| next[piece_of(task) + 1] += 1);
        for k in 1..next.len() {
            next[k] += next[k - 1];
        }
        let ends = next[1..].to_vec();
        let mut ordered = reserve("nodes of elements", tasks.len())?;
        ordered.extend_from_slice(tasks);
        for task in tasks {
            let place = &mut next[piece_of(task)];
            ordered[*place] = *task;
            *place += 1;
        }
        let pieces = firsts.into_iter().zip(ends).map(|(first_group, end)| Piece { first_group, end });
        Ok(Self { tasks: ordered, pieces: pieces.collect() })
    }

    pub fn pieces(&self) -> std::ops::Range<usize> {
        0..self.pieces.len()
    }

    /// The first group that piece `k` may have, and its tasks.
    pub fn piece(&self, k: usize) -> (usize, &[Task]) {
        let start = k.checked_sub(1).map_or(0, |before| self.pieces[before].end);
        let Piece { first_group, end } = self.pieces[k];
        (first_group as usize, &self.tasks[start..end])
    }

    fn memory(&self) -> usize {
        size_of_val(self.tasks.as_slice()) + size_of_val(self.pieces.as_slice())
    }
}

impl CsrMap {
    /// The places in a matrix of a host, which has one row and column for each equation of `dofs`. Entries of row i are those from
    /// `row_offsets[i]` to `row_offsets[i + 1]`, counted from 0; their columns ascend. It may have any other entries besides those of the
    /// elements, and those of an element that never carries force have to be there, too. Neither array is kept.
    ///
    /// ```
    /// use diffuse_contact::assembly::{ContactLaw, ContactView, CsrMap, DofMap, ElementView};
    ///
    /// // Nodes 0 and 1 lie on the z axis; the host's matrix has only the equations of their displacements along it, and a third one.
    /// let dofs = DofMap::new(3, [[None, None, Some(0)], [None, None, Some(2)]])?;
    /// let (row_offsets, columns): ([i32; 4], [i32; 6]) = ([0, 2, 3, 6], [0, 2, 1, 0, 1, 2]);
    /// let contact = ContactView {
    ///     gap: -0.1,
    ///     area: 1.0,
    ///     gradient: &[0.0, 0.0, 1.0, 0.0, 0.0, -1.0],
    ///     hessian: &[0.0; 21],
    ///     slip: None,
    /// };
    /// let elements = [ElementView { slave: 0, masters: &[1], contact: Some(contact) }];
    /// let map = CsrMap::within(elements.as_slice(), &dofs, &row_offsets, &columns)?;
    /// let mut values = [10.0; 6];
    /// map.add(elements.as_slice(), &ContactLaw::penalty(5.0), &mut values)?;
    /// assert_eq!(values, [15.0, 5.0, 10.0, 5.0, 10.0, 15.0]);
    /// # Ok::<(), diffuse_contact::assembly::AssemblyError>(())
    /// ```
    ///
    /// # Errors
    /// [`AssemblyError::OutputLength`] and [`AssemblyError::InvalidRow`] for arrays that are no such matrix;
    /// [`AssemblyError::MissingEntry`] with the first row and column that the matrix lacks;
    /// [`AssemblyError::UnknownNode`]; [`AssemblyError::TooLarge`].
    pub fn within<E: Elements + ?Sized, R: CsrIndex, C: CsrIndex>(
        elements: &E,
        dofs: &DofMap,
        row_offsets: &[R],
        columns: &[C],
    ) -> Result<Self, AssemblyError> {
        check_rows(dofs.equations(), row_offsets, columns.len())?;
        Found::new(elements, dofs)?.within(dofs, row_offsets, columns, false, Vec::new())
    }

    /// Number of rows and columns, the equations of the [`DofMap`].
    pub const fn equations(&self) -> usize {
        self.equations
    }

    /// Number of values, also of those that nothing is added to.
    pub const fn entries(&self) -> usize {
        self.entries
    }

    /// Bytes it occupies.
    pub fn memory(&self) -> usize {
        self.element_nodes.memory()
            + self.runs.memory()
            + size_of_val(self.groups.as_slice())
            + size_of_val(self.places.as_slice())
            + size_of_val(self.others.as_slice())
            + size_of_val(self.batches.as_slice())
            + self.batches.iter().map(Batch::memory).sum::<usize>()
    }

    /// Whether elements are those of the map: as many, with the same nodes in the same order.
    pub fn fits<E: Elements + ?Sized>(&self, elements: &E) -> bool {
        self.check_elements(elements).is_ok()
    }

    /// Refuses elements that are not those of the map: other nodes, or another number.
    pub(super) fn check_elements<E: Elements + ?Sized>(&self, elements: &E) -> Result<(), AssemblyError> {
        let own = self.element_nodes.len();
        if elements.len() != own {
            return Err(AssemblyError::PatternMismatch { element: elements.len().min(own) });
        }
        if self.stamp.is_some() && self.stamp == elements.stamp() {
            return Ok(());
        }
        let is_own = |&k: &usize| {
            let element = elements.element(k);
            match self.element_nodes.get(k).split_first() {
                Some((&slave, masters)) => slave as usize == element.slave && masters == element.masters,
                None => element.masters.is_empty(),
            }
        };
        (0..own)
            .find(|k| !is_own(k))
            .map_or(Ok(()), |element| Err(AssemblyError::PatternMismatch { element }))
    }

    /// Batches with the elements of each.
    pub(super) fn batches(&self) -> impl Iterator<Item = (std::ops::Range<usize>, &Batch)> {
        let (size, all) = (self.batch_size, self.element_nodes.len());
        (0..all).step_by(size).map(move |first| first..all.min(first + size)).zip(&self.batches)
    }
}
