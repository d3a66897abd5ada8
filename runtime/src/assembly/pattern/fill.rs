//! Summing tangents into the entries of a pattern.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::super::law::{Active, Needs};
use super::super::{AssemblyError, ContactLaw, ElementView, Elements};
use super::{CsrPattern, NO_SLOT, RowGroup, split::for_each_part};

impl CsrPattern {
    /// Writes the sum of the tangents of all elements that carry force into `values`, one per entry, and returns the
    /// number of these elements. Nothing is allocated.
    ///
    /// `elements` are those the pattern was built for, in the same order; only their contact quantities may differ. Without
    /// friction the matrix is symmetric to the last bit, unless nodes occur more than once in an element: the sums of their entries
    /// are then rounded in a different order.
    ///
    /// # Errors
    /// [`AssemblyError::OutputLength`] and [`AssemblyError::PatternMismatch`] if `values` or the elements do not belong
    /// to this pattern, and every reason for which the law or an element is refused; `values` are then unchanged.
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
        let active = self.check(elements, law, values.len())?;
        let failed = AtomicUsize::new(usize::MAX);
        let groups = &self.groups;
        let start = |k: usize| groups.get(k).map_or(self.entries(), |group| self.row_offsets[group.first]);
        for_each_part(0..groups.len(), &start, values, &|k, rows: &mut [f64]| {
            if from_zero {
                rows.fill(0.0);
            }
            let group = &groups[k];
            self.add_rows(group, elements, law, rows);
            if let Some(place) = rows.iter().position(|value| !value.is_finite()) {
                let row = group.first + place / self.row_length(group.first);
                failed.fetch_min(row, Ordering::Relaxed);
            }
        });
        match failed.into_inner() {
            usize::MAX => Ok(active),
            equation => Err(AssemblyError::Overflow { what: "values", equation }),
        }
    }

    /// Adds the share of all elements to the rows of a group.
    fn add_rows<E: Elements + ?Sized>(
        &self,
        group: &RowGroup,
        elements: &E,
        law: &ContactLaw<'_>,
        rows: &mut [f64],
    ) {
        let axes = &group.axes[..usize::from(group.count)];
        let node = group.node as usize;
        let slots = &self.slots[self.slot_offsets[node]..self.slot_offsets[node + 1]];
        let length = self.row_length(group.first);
        for occurrence in self.occurrences_of(node) {
            let (k, local) = (occurrence.element as usize, occurrence.local as usize);
            let Some(active) = law.active(elements, k) else { continue };
            let nodes = self.nodes_of(k).len();
            let pairs = &self.pairs[self.pair_offsets[k] + local * nodes..][..nodes];
            for (row, &axis) in rows.chunks_exact_mut(length).zip(axes) {
                add_row(&active, 3 * local + usize::from(axis), pairs, slots, row);
            }
        }
    }

    /// Number of entries in a row.
    fn row_length(&self, row: usize) -> usize {
        self.row_offsets[row + 1] - self.row_offsets[row]
    }

    /// Checks values, law and elements; returns the number of elements that carry force.
    fn check<E: Elements + ?Sized>(
        &self,
        elements: &E,
        law: &ContactLaw<'_>,
        values: usize,
    ) -> Result<usize, AssemblyError> {
        if values != self.entries() {
            let expected = self.entries();
            return Err(AssemblyError::OutputLength { what: "values", found: values, expected });
        }
        let own = self.node_offsets.len() - 1;
        if elements.len() != own {
            return Err(AssemblyError::PatternMismatch { element: elements.len().min(own) });
        }
        law.check(elements.len())?;
        let mut active = 0;
        for k in 0..elements.len() {
            let element = elements.element(k);
            if !self.is_element(k, &element) {
                return Err(AssemblyError::PatternMismatch { element: k });
            }
            law.check_element(k, &element, Needs::Tangent)?;
            active += usize::from(law.active(elements, k).is_some());
        }
        Ok(active)
    }

    /// Whether these are the nodes of element `k`.
    fn is_element(&self, k: usize, element: &ElementView<'_>) -> bool {
        match self.nodes_of(k).split_first() {
            Some((&slave, masters)) => slave as usize == element.slave && masters == element.masters,
            None => element.masters.is_empty(),
        }
    }
}

/// Adds row `p` of an element's tangent to a row of the matrix.
fn add_row(active: &Active<'_>, p: usize, pairs: &[u32], slots: &[[u32; 3]], row: &mut [f64]) {
    for (b, &pair) in pairs.iter().enumerate() {
        for (axis, &slot) in slots[pair as usize].iter().enumerate() {
            if slot != NO_SLOT {
                row[slot as usize] += active.tangent(p, 3 * b + axis);
            }
        }
    }
}
