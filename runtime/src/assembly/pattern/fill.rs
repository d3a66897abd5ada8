//! Summing tangents into the values of a matrix.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use diffuse_contact_kernels::support::{Isa, Vector, WithLanes};

use super::super::active::Active;
use super::super::law::Needs;
use super::super::{AssemblyError, ContactLaw, Elements};
use super::locate::{Located, NO_SLOT, of_row};
use super::map::{Batch, Task};
use super::{CsrMap, CsrPattern};

impl CsrPattern {
    /// [`CsrMap::fill`] of its [`map`](Self::map).
    ///
    /// # Errors
    /// As there.
    pub fn fill<E: Elements + ?Sized>(
        &self,
        elements: &E,
        law: &ContactLaw<'_>,
        values: &mut [f64],
    ) -> Result<usize, AssemblyError> {
        self.map().fill(elements, law, values)
    }

    /// [`CsrMap::add`] of its [`map`](Self::map).
    ///
    /// # Errors
    /// As there.
    pub fn add<E: Elements + ?Sized>(
        &self,
        elements: &E,
        law: &ContactLaw<'_>,
        values: &mut [f64],
    ) -> Result<usize, AssemblyError> {
        self.map().add(elements, law, values)
    }
}

impl CsrMap {
    /// Writes the sum of the tangents of all elements that carry force into `values`, and returns the
    /// number of these elements; rows that no element has are left as they are. Nothing is allocated.
    ///
    /// `elements` are those the map was made for, in the same order; only their contact quantities may differ. Without
    /// friction the matrix is symmetric to the last bit, unless nodes occur more than once in an element: the sums of their entries
    /// are then rounded in a different order.
    ///
    /// # Errors
    /// [`AssemblyError::OutputLength`] and [`AssemblyError::PatternMismatch`] if `values` or the elements do not belong
    /// to this map, and every reason for which the law or an element is refused; `values` are then unchanged.
    /// [`AssemblyError::Overflow`] if a sum is not finite; the contents of `values` are then unspecified.
    pub fn fill<E: Elements + ?Sized>(
        &self,
        elements: &E,
        law: &ContactLaw<'_>,
        values: &mut [f64],
    ) -> Result<usize, AssemblyError> {
        self.sum(elements, law, values, true)
    }

    /// As [`fill`](Self::fill), but adds to what is there.
    ///
    /// # Errors
    /// As [`fill`](Self::fill).
    pub fn add<E: Elements + ?Sized>(
        &self,
        elements: &E,
        law: &ContactLaw<'_>,
        values: &mut [f64],
    ) -> Result<usize, AssemblyError> {
        self.sum(elements, law, values, false)
    }

    fn sum<E: Elements + ?Sized>(
        &self,
        elements: &E,
        law: &ContactLaw<'_>,
        values: &mut [f64],
        from_zero: bool,
    ) -> Result<usize, AssemblyError> {
        AssemblyError::check_length("values", values.len(), self.entries())?;
        self.check_elements(elements)?;
        law.check_for(elements)?;
        let mut count = 0;
        for k in 0..elements.len() {
            law.check_element(k, &elements.element(k), Needs::Tangent)?;
            count += usize::from(law.active(elements, k).is_some());
        }
        for (_, batch) in self.batches() {
            self.add_batch(batch, &|k| law.active(elements, k), values, from_zero)?;
        }
        Ok(count)
    }

    /// Adds what the elements of a batch contribute. `from_zero`: rows are set to zero before the first element of theirs.
    pub(super) fn add_batch<'e>(
        &self,
        batch: &Batch,
        active: &(impl Fn(usize) -> Option<Active<'e>> + Sync),
        values: &mut [f64],
        from_zero: bool,
    ) -> Result<(), AssemblyError> {
        let failed = AtomicUsize::new(usize::MAX);
        let work = Work { map: self, batch, active, from_zero, failed: &failed, isa: Isa::best() };
        work.pieces(batch.pieces(), 0, values);
        match failed.into_inner() {
            usize::MAX => Ok(()),
            equation => Err(AssemblyError::Overflow { what: "values", equation }),
        }
    }
}

/// The work on a batch.
struct Work<'a, A> {
    map: &'a CsrMap,
    batch: &'a Batch,
    active: &'a A,
    from_zero: bool,
    /// The first row that has a value that is not finite.
    failed: &'a AtomicUsize,
    isa: Isa,
}

impl<'e, A: Fn(usize) -> Option<Active<'e>> + Sync> Work<'_, A> {
    /// Adds some pieces; `values` are those from `base` on.
    fn pieces(&self, pieces: Range<usize>, base: usize, values: &mut [f64]) {
        if pieces.len() > 1 {
            let middle = pieces.start + pieces.len() / 2;
            let split = self.map.groups[self.batch.piece(middle).0].start;
            let (left, right) = values.split_at_mut(split - base);
            rayon::join(
                || self.pieces(pieces.start..middle, base, left),
                || self.pieces(middle..pieces.end, split, right),
            );
            return;
        }
        let (mut element, mut active) = (None, None);
        self.map.scratch.with(Vec::new, |scratch| {
            for task in pieces.flat_map(|piece| self.batch.piece(piece).1) {
                if element.replace(task.element) != Some(task.element) {
                    active = (self.active)(task.element as usize);
                    active.iter().for_each(Active::look);
                }
                let group = &self.map.groups[task.group as usize];
                let rows = &mut values[group.start - base..group.end() - base];
                self.task(task, group, active.as_ref(), rows, scratch);
            }
        });
    }

    fn task(
        &self,
        task: &Task,
        group: &Located,
        active: Option<&Active<'_>>,
        rows: &mut [f64],
        scratch: &mut Vec<f64>,
    ) {
        let map = self.map;
        if self.from_zero && task.opens {
            rows.fill(0.0);
        }
        if let Some(active) = active {
            let (local, runs) = (task.local as usize, map.runs.get(task.element as usize));
            let places = &map.places[task.places..][..runs.len()];
            if group.is_regular {
                add_rows(self.isa, AddRows { active, local, runs, slots: places, rows, scratch });
            } else {
                let mut start = 0;
                for (row, (&axis, &end)) in group.rows.axes().iter().zip(&group.ends).enumerate() {
                    let (slots, values) = (of_row(&map.others, group, row), &mut rows[start..end as usize]);
                    add_row(active, 3 * local + usize::from(axis), (runs, places), slots, values);
                    start = end as usize;
                }
            }
        }
        if task.closes
            && !is_finite(rows)
            && let Some(place) = rows.iter().position(|value| !value.is_finite())
        {
            let row = group.ends.iter().position(|&end| place < end as usize).unwrap_or(0);
            self.failed.fetch_min(group.rows.first + row, Ordering::Relaxed);
        }
    }
}

/// Whether all values are finite: many at a time.
fn is_finite(values: &[f64]) -> bool {
    let (chunks, rest) = values.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for chunk in chunks {
        for (sum, value) in sums.iter_mut().zip(chunk) {
            *sum += 0.0 * value;
        }
    }
    sums.iter().chain(rest).all(|value| value.is_finite())
}

/// The rows of a node of an element, which are added to three rows of the matrix.
struct AddRows<'a> {
    active: &'a Active<'a>,
    /// The node, among those of the element.
    local: usize,
    /// Which nodes of the element begin a run, …
    runs: &'a [u32],
    /// … and the slot of the first column of each.
    slots: &'a [u32],
    rows: &'a mut [f64],
    scratch: &'a mut Vec<f64>,
}

/// Four numbers at a time, as runs have few.
fn add_rows(isa: Isa, rows: AddRows<'_>) {
    isa.run_four(rows).unwrap_or_else(|rows| isa.run(rows));
}

impl WithLanes for AddRows<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Vector>(self) {
        let Self { active, local, runs, slots, rows, scratch } = self;
        let freedoms = 3 * active.nodes();
        if scratch.len() < 3 * freedoms {
            scratch.resize(3 * freedoms, 0.0);
        }
        let (x, rest) = scratch.split_at_mut(freedoms);
        let (y, z) = rest.split_at_mut(freedoms);
        let z = &mut z[..freedoms];
        active.rows::<T>(local, [&mut *x, &mut *y, &mut *z]);
        let length = rows.len() / 3;
        let (first, rest) = rows.split_at_mut(length);
        let (second, third) = rest.split_at_mut(length);
        let ends = runs.iter().skip(1).map(|&local| 3 * local as usize).chain([freedoms]);
        let mut start = 0;
        for (&slot, end) in slots.iter().zip(ends) {
            let columns = slot as usize..slot as usize + end - start;
            add::<T>(&mut first[columns.clone()], &x[start..end]);
            add::<T>(&mut second[columns.clone()], &y[start..end]);
            add::<T>(&mut third[columns], &z[start..end]);
            start = end;
        }
    }
}

/// Adds as many numbers as there are.
#[inline(always)]
fn add<T: Vector>(target: &mut [f64], source: &[f64]) {
    let target = &mut target[..source.len()];
    let whole = source.len() - source.len() % T::WIDTH;
    let mut place = 0;
    while place < whole {
        (T::load(target, place) + T::load(source, place)).store(target, place);
        place += T::WIDTH;
    }
    for place in whole..source.len() {
        target[place] += source[place];
    }
}

/// Adds row `p` of an element's tangent to a row of the matrix. `runs`: which nodes begin one, and which of the slots each has.
fn add_row(
    active: &Active<'_>,
    p: usize,
    (runs, places): (&[u32], &[u32]),
    slots: &[[u32; 3]],
    row: &mut [f64],
) {
    let ends = runs.iter().skip(1).copied().chain([active.nodes() as u32]);
    for ((&first, end), &place) in runs.iter().zip(ends).zip(places) {
        for (b, slots) in (first as usize..end as usize).zip(&slots[place as usize..]) {
            for (axis, &slot) in slots.iter().enumerate() {
                if slot != NO_SLOT {
                    row[slot as usize] += active.tangent(p, 3 * b + axis);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::{ContactLaw, ContactView};
    use super::*;

    /// All instruction sets add the same numbers to the same places, bit for bit.
    #[test]
    fn rows_are_those_of_single_entries_with_all_instructions() {
        let number = |k: usize| (1.7 * k as f64 + 0.3).sin();
        let law = ContactLaw::penalty(3.7);
        for nodes in 1..9 {
            let freedoms = 3 * nodes;
            let gradient: Vec<f64> = (0..freedoms).map(number).collect();
            let hessian: Vec<f64> = (0..freedoms * (freedoms + 1) / 2).map(|k| number(k + 100)).collect();
            let view =
                ContactView { gap: -0.1, area: 0.3, gradient: &gradient, hessian: &hessian, slip: None };
            let active = law.active_contact(0, &view).unwrap();
            // Runs of one, two, … nodes, with two other columns before each.
            let runs: Vec<u32> = [0, 1, 3, 6].into_iter().filter(|&first| first < nodes as u32).collect();
            let slots: Vec<u32> = runs.iter().zip(1..).map(|(&first, k)| 3 * first + 2 * k).collect();
            let length = freedoms + 2 * runs.len() + 1;
            let place = |b: usize| {
                let run = runs.partition_point(|&first| first as usize <= b) - 1;
                slots[run] as usize + 3 * (b - runs[run] as usize)
            };
            for local in 0..nodes {
                let start: Vec<f64> = (0..3 * length).map(|k| number(k + 1000)).collect();
                let mut expected = start.clone();
                for (i, row) in expected.chunks_exact_mut(length).enumerate() {
                    for q in 0..freedoms {
                        row[place(q / 3) + q % 3] += active.tangent(3 * local + i, q);
                    }
                }
                for isa in Isa::available() {
                    let (mut rows, mut scratch) = (start.clone(), Vec::new());
                    let (active, scratch) = (&active, &mut scratch);
                    add_rows(
                        isa,
                        AddRows { active, local, runs: &runs, slots: &slots, rows: &mut rows, scratch },
                    );
                    let is_same = rows.iter().zip(&expected).all(|(a, b)| a.to_bits() == b.to_bits());
                    assert!(is_same, "{isa}, node {local} of {nodes}");
                }
            }
        }
    }
}
