//! Summing tangents into the values of a matrix.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::super::law::{Active, Needs};
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
        self.check_values(values.len())?;
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

    /// Refuses another number of values.
    pub(super) fn check_values(&self, found: usize) -> Result<(), AssemblyError> {
        let expected = self.entries();
        let wrong = AssemblyError::OutputLength { what: "values", found, expected };
        if found == expected { Ok(()) } else { Err(wrong) }
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
        let work = Work { map: self, batch, active, from_zero, failed: &failed };
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
            let (local, places) = (task.local as usize, &map.places[task.places..]);
            if group.is_regular {
                add_rows(active, local, places, rows, scratch);
            } else {
                let mut start = 0;
                for (row, (&axis, &end)) in group.rows.axes().iter().zip(&group.ends).enumerate() {
                    let (slots, values) = (of_row(&map.others, group, row), &mut rows[start..end as usize]);
                    add_row(active, 3 * local + usize::from(axis), places, slots, values);
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

/// Adds the rows of node `a` of an element to three rows of the matrix: its node b begins at `slots[b]`.
fn add_rows(active: &Active<'_>, a: usize, slots: &[u32], rows: &mut [f64], scratch: &mut Vec<f64>) {
    let freedoms = 3 * active.nodes();
    if scratch.len() < 3 * freedoms {
        scratch.resize(3 * freedoms, 0.0);
    }
    let (x, rest) = scratch.split_at_mut(freedoms);
    let (y, z) = rest.split_at_mut(freedoms);
    active.rows(a, [&mut *x, &mut *y, &mut *z]);
    let length = rows.len() / 3;
    let (first, rest) = rows.split_at_mut(length);
    let (second, third) = rest.split_at_mut(length);
    let third = &mut third[..length];
    let [x, y, z] = [&*x, &*y, &z[..freedoms]].map(|row| row.as_chunks::<3>().0);
    for (((&slot, x), y), z) in slots.iter().zip(x).zip(y).zip(z) {
        let columns = slot as usize..slot as usize + 3;
        let targets = [&mut first[columns.clone()], &mut second[columns.clone()], &mut third[columns]];
        for (target, values) in targets.into_iter().zip([x, y, z]) {
            for (entry, value) in target.iter_mut().zip(values) {
                *entry += value;
            }
        }
    }
}

/// Adds row `p` of an element's tangent to a row of the matrix.
fn add_row(active: &Active<'_>, p: usize, places: &[u32], slots: &[[u32; 3]], row: &mut [f64]) {
    for (b, &place) in places[..active.nodes()].iter().enumerate() {
        for (axis, &slot) in slots[place as usize].iter().enumerate() {
            if slot != NO_SLOT {
                row[slot as usize] += active.tangent(p, 3 * b + axis);
            }
        }
    }
}
