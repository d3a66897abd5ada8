//! Where the columns of nodes lie in rows.

use std::ops::Range;

use rayon::prelude::*;

use super::super::{AssemblyError, DofMap, reserve};
use super::incidence::Neighbours;
use super::rows::RowGroup;

/// Groups of rows that are worked on in one go.
const CHUNK: usize = 1024;
/// In place of a slot where the column is constrained.
pub const NO_SLOT: u32 = u32::MAX;

/// What a matrix in compressed sparse rows may be indexed by: `i32`, `i64`, `u32`, `usize` and others.
pub trait CsrIndex: Copy + PartialEq + Send + Sync + TryInto<usize> {}

impl<T: Copy + PartialEq + Send + Sync + TryInto<usize>> CsrIndex for T {}

/// Rows of a node, and where they are.
#[derive(Clone, Copy, Debug)]
pub struct Located {
    pub rows: RowGroup,
    /// Where the first row begins among the values.
    pub start: usize,
    /// Where each row ends, seen from there.
    pub ends: [u32; 3],
    /// Whether it has three rows with the same columns, of which each neighbour has three in a row.
    pub is_regular: bool,
    /// Whether it is regular, and its columns up to the last are those of its neighbours, in their order: slots follow.
    is_dense: bool,
    /// Number of the node's neighbours.
    neighbours: u32,
    /// Where the slots begin, in [`Slots::regular`] or in [`Slots::others`].
    slots: usize,
}

impl Located {
    /// Where the last row ends.
    pub fn end(&self) -> usize {
        self.start + self.ends[usize::from(self.rows.count) - 1] as usize
    }
}

/// Slots of the columns of each group's neighbours, seen from the beginning of their row.
#[derive(Debug, Default)]
pub struct Slots {
    /// Of regular groups that are not dense: the first one of each neighbour.
    regular: Vec<u32>,
    /// Of the others row by row: those of each neighbour, or [`NO_SLOT`].
    pub others: Vec<[u32; 3]>,
}

impl Slots {
    /// The first slot of each neighbour of a regular group.
    pub fn regular(&self, group: &Located) -> impl Iterator<Item = u32> {
        let count = if group.is_dense { 0 } else { group.neighbours };
        let listed = self.regular[group.slots..][..count as usize].iter().copied();
        listed.chain((count..group.neighbours).map(|neighbour| 3 * neighbour))
    }
}

/// The part of [`Slots::others`] of the `row`-th row of a group that is not regular.
pub fn of_row<'a>(others: &'a [[u32; 3]], group: &Located, row: usize) -> &'a [[u32; 3]] {
    let neighbours = group.neighbours as usize;
    &others[group.slots + row * neighbours..][..neighbours]
}

/// Checks the row offsets of a matrix with so many rows and entries.
pub fn check_rows<R: CsrIndex>(rows: usize, offsets: &[R], entries: usize) -> Result<(), AssemblyError> {
    AssemblyError::check_length("row offsets", offsets.len(), rows.saturating_add(1))?;
    let mut last = 0;
    for (place, &offset) in offsets.iter().enumerate() {
        let row = place.saturating_sub(1);
        let offset = offset.try_into().map_err(|_| AssemblyError::InvalidRow { row })?;
        let is_end = place == rows;
        if offset < last || offset > entries || (place == 0 && offset > 0) || (is_end && offset < entries) {
            return Err(AssemblyError::InvalidRow { row });
        }
        last = offset;
    }
    Ok(())
}

/// A matrix, and what is sought in it.
struct Search<'a, R, C> {
    neighbours: &'a Neighbours,
    dofs: &'a DofMap,
    row_offsets: &'a [R],
    columns: &'a [C],
    /// Whether rows and columns are those of the union pattern, which need no check.
    is_union: bool,
}

/// Where the rows of all groups and the columns in them are. Row offsets have been checked. `is_union`: columns are those that the union
/// pattern has.
pub fn locate<R: CsrIndex, C: CsrIndex>(
    neighbours: &Neighbours,
    groups: &[RowGroup],
    dofs: &DofMap,
    row_offsets: &[R],
    columns: &[C],
    is_union: bool,
) -> Result<(Vec<Located>, Slots), AssemblyError> {
    let search = Search { neighbours, dofs, row_offsets, columns, is_union };
    let chunks: Vec<Result<(Vec<Located>, Slots), AssemblyError>> = groups
        .par_chunks(CHUNK)
        .map(|groups| {
            let mut slots = Slots::default();
            let located = groups.iter().map(|rows| search.group(rows, &mut slots));
            Ok((located.collect::<Result<_, _>>()?, slots))
        })
        .collect();
    let chunks = chunks.into_iter().collect::<Result<Vec<_>, _>>()?;
    let count = |of: fn(&Slots) -> usize| chunks.iter().map(|(_, slots)| of(slots)).sum();
    let mut located = reserve("nodes", groups.len())?;
    let mut all = Slots {
        regular: reserve("pairs of nodes", count(|slots| slots.regular.len()))?,
        others: reserve("pairs of nodes", count(|slots| slots.others.len()))?,
    };
    for (groups, slots) in chunks {
        let [regular, others] = [all.regular.len(), all.others.len()];
        located.extend(groups.into_iter().map(|group| {
            let base = if group.is_regular { regular } else { others };
            Located { slots: base + group.slots, ..group }
        }));
        all.regular.extend(slots.regular);
        all.others.extend(slots.others);
    }
    Ok((located, all))
}

impl<R: CsrIndex, C: CsrIndex> Search<'_, R, C> {
    /// The rows of a group, its slots behind those of others.
    fn group(&self, rows: &RowGroup, slots: &mut Slots) -> Result<Located, AssemblyError> {
        let count = usize::from(rows.count);
        let start = self.row(rows.first)?.start;
        let mut ends = [0; 3];
        for (k, end) in ends.iter_mut().enumerate().take(count) {
            let row = self.row(rows.first + k)?;
            if !self.is_union {
                self.check_columns(rows.first + k, row.clone())?;
            }
            *end = u32::try_from(row.end - start)
                .map_err(|_| AssemblyError::TooLarge { what: "entries of a row", count: row.end - start })?;
        }
        let neighbours = self.neighbours.get(rows.node as usize).len() as u32;
        let first = slots.regular.len();
        let mut group =
            Located { rows: *rows, start, ends, is_regular: true, is_dense: false, neighbours, slots: first };
        if !self.regular(&group, &mut slots.regular)? {
            slots.regular.truncate(group.slots);
            (group.is_regular, group.slots) = (false, slots.others.len());
            for k in 0..count {
                self.row_slots(rows.first + k, rows.node, &mut slots.others)?;
            }
        } else if slots.regular[first..].iter().zip(0..).all(|(&slot, neighbour)| slot == 3 * neighbour) {
            slots.regular.truncate(first);
            group.is_dense = true;
        }
        Ok(group)
    }

    /// Where a row lies.
    fn row(&self, row: usize) -> Result<Range<usize>, AssemblyError> {
        let invalid = AssemblyError::InvalidRow { row };
        let [start, end] = [row, row + 1].map(|place| self.row_offsets[place].try_into());
        let (Ok(start), Ok(end)) = (start, end) else { return Err(invalid) };
        if start <= end && end <= self.columns.len() { Ok(start..end) } else { Err(invalid) }
    }

    /// Columns ascend and are there.
    fn check_columns(&self, row: usize, entries: Range<usize>) -> Result<(), AssemblyError> {
        let mut next = 0_usize;
        for &column in &self.columns[entries] {
            match column.try_into() {
                Ok(column) if column >= next && column < self.dofs.equations() => next = column + 1,
                _ => return Err(AssemblyError::InvalidRow { row }),
            }
        }
        Ok(())
    }

    /// Whether the group is regular; if so, its slots.
    fn regular(&self, group: &Located, slots: &mut Vec<u32>) -> Result<bool, AssemblyError> {
        let RowGroup { first, node, axes, count } = group.rows;
        if count != 3 || axes != [0, 1, 2] {
            return Ok(false);
        }
        let [one, two, three] = [self.row(first)?, self.row(first + 1)?, self.row(first + 2)?];
        let columns = &self.columns[one];
        if !self.is_union && (self.columns[two] != *columns || self.columns[three] != *columns) {
            return Ok(false);
        }
        let mut next = 0;
        for &neighbour in self.neighbours.get(node as usize) {
            let Some(x) = self.dofs.three_in_a_row(neighbour as usize) else { return Ok(false) };
            let slot = find(columns, x, next).ok_or(AssemblyError::MissingEntry { row: first, column: x })?;
            let is_there =
                |k: usize| columns.get(slot + k).is_some_and(|&own| own.try_into().ok() == Some(x + k));
            if !self.is_union
                && let Some(k) = [1, 2].into_iter().find(|&k| !is_there(k))
            {
                return Err(AssemblyError::MissingEntry { row: first, column: x + k });
            }
            slots.push(slot as u32);
            next = slot + 3;
        }
        Ok(true)
    }

    /// The slots of a row, neighbour by neighbour.
    fn row_slots(&self, row: usize, node: u32, slots: &mut Vec<[u32; 3]>) -> Result<(), AssemblyError> {
        let columns = &self.columns[self.row(row)?];
        let mut next = 0;
        for &neighbour in self.neighbours.get(node as usize) {
            let mut of_node = [NO_SLOT; 3];
            for (slot, equation) in of_node.iter_mut().zip(self.dofs.of_node(neighbour as usize)) {
                let Some(column) = equation else { continue };
                let found = find(columns, column, next).ok_or(AssemblyError::MissingEntry { row, column })?;
                *slot = found as u32;
                next = found + 1;
            }
            slots.push(of_node);
        }
        Ok(())
    }
}

/// Where a column is among ascending ones, most likely at `guess`.
fn find<C: CsrIndex>(columns: &[C], column: usize, guess: usize) -> Option<usize> {
    let at = |place: usize| columns.get(place).and_then(|&found| found.try_into().ok());
    if at(guess) == Some(column) {
        return Some(guess);
    }
    let place = columns.partition_point(|&found| found.try_into().is_ok_and(|found: usize| found < column));
    (at(place) == Some(column)).then_some(place)
}
