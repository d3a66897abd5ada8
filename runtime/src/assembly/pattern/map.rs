//! Which entries of a matrix the blocks of the elements are added to.

use super::super::{AssemblyError, DofMap, Elements, reserve};
use super::incidence::{Lists, Occurrence, element_nodes, neighbours, occurrences};
use super::locate::{CsrIndex, Located, Places, check_rows, locate};
use super::rows::{RowGroup, row_groups};
use crate::interface::Pool;

/// Elements that are added at once, for each thread: so few that their numbers stay in the processor's cache.
const BATCH_PER_THREAD: usize = 512;

/// Where the tangents of elements go in the values of a matrix in compressed sparse rows: of the [`CsrPattern`](super::CsrPattern) that
/// it belongs to, or of a matrix that a host has already. It serves as long as the elements have the same nodes.
///
/// # How entries are summed
///
/// Elements are taken in batches, in their order. Within a batch rows are shared among the threads, and each thread adds to a row
/// what the elements have for it, in their order. So each entry is the sum in the order of the elements, for any number of threads.
///
/// # Memory
///
/// For each slave with n masters 4 (n + 1) bytes for its nodes and 8 (n + 1) for where they occur; for each pair of nodes that occur
/// together 8 bytes; for each node some 150. With nodes that have not three consecutive equations it is 40 bytes for a pair.
#[derive(Clone, Debug)]
pub struct CsrMap {
    /// Whose nodes the lists are; `None` if they tell nobody.
    stamp: Option<u64>,
    equations: usize,
    entries: usize,
    /// Nodes of each element, slave first.
    element_nodes: Lists<u32>,
    pub(super) neighbours: Lists<u32>,
    /// Rows that are added to, ascending.
    pub(super) groups: Vec<Located>,
    pub(super) places: Places,
    batches: Batches,
    pub(super) scratch: Pool<Scratch>,
}

/// What one thread keeps from one batch to the next.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    /// Place of each node among the columns of the rows at hand.
    pub marks: Vec<u32>,
    /// The same of the nodes of an element.
    pub of_element: Vec<u32>,
}

/// Who adds what to a group of rows within a batch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    /// Its occurrences begin here, and end where those of the next run begin.
    first: usize,
    pub group: u32,
    /// Whether it is the group's first run, …
    pub opens: bool,
    /// … or its last.
    pub closes: bool,
}

/// Runs batch by batch, in the order of rows within a batch.
#[derive(Clone, Debug)]
struct Batches {
    /// Elements of each, but for the last one.
    size: usize,
    /// Where the runs of each batch begin.
    offsets: Vec<usize>,
    runs: Vec<Run>,
    occurrences: Vec<Occurrence>,
}

/// The nodes of elements and the rows they have.
#[derive(Debug)]
pub(super) struct Found {
    stamp: Option<u64>,
    element_nodes: Lists<u32>,
    occurrences: Lists<Occurrence>,
    pub neighbours: Lists<u32>,
    pub groups: Vec<RowGroup>,
}

impl Found {
    pub fn new<E: Elements + ?Sized>(elements: &E, dofs: &DofMap) -> Result<Self, AssemblyError> {
        let element_nodes = element_nodes(elements, dofs.nodes())?;
        let occurrences = occurrences(&element_nodes, dofs.nodes())?;
        let neighbours = neighbours(&element_nodes, &occurrences)?;
        let groups = row_groups(&neighbours, dofs)?;
        Ok(Self { stamp: elements.stamp(), element_nodes, occurrences, neighbours, groups })
    }

    /// The places in a matrix whose row offsets have been checked.
    pub fn within<R: CsrIndex, C: CsrIndex>(
        self,
        dofs: &DofMap,
        row_offsets: &[R],
        columns: &[C],
    ) -> Result<CsrMap, AssemblyError> {
        let (groups, places) = locate(&self.neighbours, &self.groups, dofs, row_offsets, columns)?;
        let batches = Batches::new(&self.occurrences, &groups, self.element_nodes.len())?;
        Ok(CsrMap {
            stamp: self.stamp,
            equations: dofs.equations(),
            entries: columns.len(),
            element_nodes: self.element_nodes,
            neighbours: self.neighbours,
            groups,
            places,
            batches,
            scratch: Pool::default(),
        })
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
        Found::new(elements, dofs)?.within(dofs, row_offsets, columns)
    }

    /// Number of rows and columns, the equations of the [`DofMap`].
    #[must_use]
    pub const fn equations(&self) -> usize {
        self.equations
    }

    /// Number of values, also of those that nothing is added to.
    #[must_use]
    pub const fn entries(&self) -> usize {
        self.entries
    }

    /// Bytes it occupies.
    #[must_use]
    pub fn memory(&self) -> usize {
        self.element_nodes.memory()
            + self.neighbours.memory()
            + size_of_val(self.groups.as_slice())
            + self.places.memory()
            + self.batches.memory()
    }

    /// Whether elements are those of the map: as many, with the same nodes in the same order.
    #[must_use]
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

    /// Nodes of element `k`, slave first.
    pub(super) fn nodes_of(&self, k: usize) -> &[u32] {
        self.element_nodes.get(k)
    }

    /// Number of batches.
    pub(super) fn batches(&self) -> usize {
        self.batches.offsets.len() - 1
    }

    /// The elements of a batch.
    pub(super) fn elements_of(&self, batch: usize) -> std::ops::Range<usize> {
        let (size, all) = (self.batches.size, self.element_nodes.len());
        batch * size..all.min((batch + 1) * size)
    }

    pub(super) fn runs_of(&self, batch: usize) -> std::ops::Range<usize> {
        self.batches.offsets[batch]..self.batches.offsets[batch + 1]
    }

    pub(super) fn run(&self, run: usize) -> Run {
        self.batches.runs[run]
    }

    pub(super) fn occurrences_of(&self, run: usize) -> &[Occurrence] {
        let Batches { runs, occurrences, .. } = &self.batches;
        let end = runs.get(run + 1).map_or(occurrences.len(), |next| next.first);
        &occurrences[runs[run].first..end]
    }
}

impl Batches {
    fn new(of_nodes: &Lists<Occurrence>, groups: &[Located], elements: usize) -> Result<Self, AssemblyError> {
        let size = (BATCH_PER_THREAD * rayon::current_num_threads()).next_power_of_two();
        let shift = size.ilog2();
        let batch_of = |occurrence: &Occurrence| (occurrence.element >> shift) as usize;
        let count = elements.div_ceil(size);
        let mut offsets = reserve("elements", count + 1)?;
        offsets.resize(count + 1, 0_usize);
        let mut next_occurrence = reserve("elements", count)?;
        next_occurrence.resize(count, 0_usize);
        for group in groups {
            let mut last = usize::MAX;
            for batch in of_nodes.get(group.rows.node as usize).iter().map(batch_of) {
                next_occurrence[batch] += 1;
                offsets[batch] += usize::from(std::mem::replace(&mut last, batch) != batch);
            }
        }
        let (mut run_count, mut sum) = (0, 0);
        for (offset, next) in offsets.iter_mut().zip(next_occurrence.iter_mut().chain([&mut 0])) {
            run_count += std::mem::replace(offset, run_count);
            sum += std::mem::replace(next, sum);
        }
        let mut occurrences = reserve("nodes of elements", sum)?;
        occurrences.resize(sum, Occurrence { element: 0, local: 0 });
        let mut runs = reserve("nodes of elements", run_count)?;
        runs.resize(run_count, Run { first: 0, group: 0, opens: false, closes: false });
        let mut next_run = offsets.clone();
        for (k, group) in groups.iter().enumerate() {
            let mut last = usize::MAX;
            for occurrence in of_nodes.get(group.rows.node as usize) {
                let batch = batch_of(occurrence);
                if batch != last {
                    runs[next_run[batch]] = Run {
                        first: next_occurrence[batch],
                        group: k as u32,
                        opens: last == usize::MAX,
                        closes: false,
                    };
                    next_run[batch] += 1;
                    last = batch;
                }
                occurrences[next_occurrence[batch]] = *occurrence;
                next_occurrence[batch] += 1;
            }
            if last != usize::MAX {
                runs[next_run[last] - 1].closes = true;
            }
        }
        Ok(Self { size, offsets, runs, occurrences })
    }

    fn memory(&self) -> usize {
        size_of_val(self.offsets.as_slice())
            + size_of_val(self.runs.as_slice())
            + size_of_val(self.occurrences.as_slice())
    }
}
