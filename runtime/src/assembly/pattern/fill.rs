//! Summing tangents into the values of a matrix.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::super::law::{Active, Needs};
use super::super::{AssemblyError, ContactLaw, Elements};
use super::incidence::Occurrence;
use super::locate::{Located, NO_SLOT};
use super::map::Scratch;
use super::{CsrMap, CsrPattern};

/// Runs that one thread adds in a row: some ten microseconds' worth.
const GRAIN: usize = 16;

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
        law.check(elements.len())?;
        let mut count = 0;
        for k in 0..elements.len() {
            law.check_element(k, &elements.element(k), Needs::Tangent)?;
            count += usize::from(law.active(elements, k).is_some());
        }
        for batch in 0..self.batches() {
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
        batch: usize,
        active: &(impl Fn(usize) -> Option<Active<'e>> + Sync),
        values: &mut [f64],
        from_zero: bool,
    ) -> Result<(), AssemblyError> {
        let failed = AtomicUsize::new(usize::MAX);
        let work = Work { map: self, active, from_zero, failed: &failed };
        work.runs(self.runs_of(batch), 0, values);
        match failed.into_inner() {
            usize::MAX => Ok(()),
            equation => Err(AssemblyError::Overflow { what: "values", equation }),
        }
    }
}

/// The work on the runs of a batch.
struct Work<'a, A> {
    map: &'a CsrMap,
    active: &'a A,
    from_zero: bool,
    /// The first row that has a value that is not finite.
    failed: &'a AtomicUsize,
}

impl<'e, A: Fn(usize) -> Option<Active<'e>> + Sync> Work<'_, A> {
    /// Adds some runs; `values` are those from `base` on.
    fn runs(&self, runs: Range<usize>, base: usize, values: &mut [f64]) {
        let group = |run: usize| &self.map.groups[self.map.run(run).group as usize];
        if runs.len() > GRAIN {
            let middle = runs.start + runs.len() / 2;
            let split = group(middle).start;
            let (left, right) = values.split_at_mut(split - base);
            rayon::join(
                || self.runs(runs.start..middle, base, left),
                || self.runs(middle..runs.end, split, right),
            );
            return;
        }
        self.map.scratch.with(Scratch::default, |scratch| {
            scratch.marks.resize(self.map.neighbours.len(), 0);
            for run in runs {
                let group = group(run);
                self.run(run, group, &mut values[group.start - base..group.end() - base], scratch);
            }
        });
    }

    fn run(&self, run: usize, group: &Located, rows: &mut [f64], scratch: &mut Scratch) {
        let map = self.map;
        if self.from_zero && map.run(run).opens {
            rows.fill(0.0);
        }
        let occurrences = map.occurrences_of(run);
        let neighbours = map.neighbours.get(group.rows.node as usize);
        let Scratch { marks, of_element } = scratch;
        if group.is_regular {
            let places = map.places.regular(group, neighbours.len());
            let mark = |marks: &mut [u32]| {
                neighbours.iter().zip(places).for_each(|(&node, &slot)| marks[node as usize] = slot);
            };
            let (first, rest) = rows.split_at_mut(group.ends[0] as usize);
            let (second, third) = rest.split_at_mut((group.ends[1] - group.ends[0]) as usize);
            let mut rows = [first, second, third];
            self.elements(occurrences, marks, of_element, mark, |active, local, slots| {
                add_rows(active, local, slots, &mut rows);
            });
        } else {
            let mark = |marks: &mut [u32]| {
                neighbours.iter().zip(0..).for_each(|(&node, place)| marks[node as usize] = place);
            };
            let mut start = 0;
            for (row, (&axis, &end)) in group.rows.axes().iter().zip(&group.ends).enumerate() {
                let slots = map.places.others(group, neighbours.len(), row);
                let values = &mut rows[start..end as usize];
                self.elements(occurrences, marks, of_element, mark, |active, local, places| {
                    add_row(active, 3 * local + usize::from(axis), places, slots, values);
                });
                start = end as usize;
            }
        }
        if map.run(run).closes
            && let Some(place) = rows.iter().position(|value| !value.is_finite())
        {
            let row = group.ends.iter().position(|&end| place < end as usize).unwrap_or(0);
            self.failed.fetch_min(group.rows.first + row, Ordering::Relaxed);
        }
    }

    /// Hands over each element of the run that carries force, its own place of the node, and what `mark` marked its nodes with.
    fn elements(
        &self,
        occurrences: &[Occurrence],
        marks: &mut [u32],
        of_element: &mut Vec<u32>,
        mark: impl Fn(&mut [u32]),
        mut add: impl FnMut(&Active<'e>, usize, &[u32]),
    ) {
        let mut is_marked = false;
        for occurrence in occurrences {
            let k = occurrence.element as usize;
            let Some(active) = (self.active)(k) else { continue };
            if !std::mem::replace(&mut is_marked, true) {
                mark(marks);
            }
            of_element.clear();
            of_element.extend(self.map.nodes_of(k).iter().map(|&node| marks[node as usize]));
            add(&active, occurrence.local as usize, of_element);
        }
    }
}

/// Adds the rows of node `a` of an element to three rows of the matrix: its node b begins at `slots[b]`.
fn add_rows(active: &Active<'_>, a: usize, slots: &[u32], rows: &mut [&mut [f64]; 3]) {
    for (b, &slot) in slots.iter().enumerate() {
        let block = active.block(a, b);
        for (row, values) in rows.iter_mut().zip(block) {
            if let Some(entries) = row[slot as usize..].first_chunk_mut::<3>() {
                for (entry, value) in entries.iter_mut().zip(values) {
                    *entry += value;
                }
            }
        }
    }
}

/// Adds row `p` of an element's tangent to a row of the matrix.
fn add_row(active: &Active<'_>, p: usize, places: &[u32], slots: &[[u32; 3]], row: &mut [f64]) {
    for (b, &place) in places.iter().enumerate() {
        for (axis, &slot) in slots[place as usize].iter().enumerate() {
            if slot != NO_SLOT {
                row[slot as usize] += active.tangent(p, 3 * b + axis);
            }
        }
    }
}
