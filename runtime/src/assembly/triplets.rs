//! The tangent as triplets.

use super::law::{Needs, check};
use super::{AssemblyError, ContactLaw, DofMap, Elements};

/// Which entries of a symmetric matrix are given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Triangle {
    /// Both triangles.
    #[default]
    Full,
    /// The entries with row ≥ column.
    Lower,
}

/// The entries (row, column, value) of a sparse matrix, in no particular order of rows; entries of the same place are
/// to be summed.
///
/// They come in the order of the elements, and keep their memory from one assembly to the next. For the same
/// elements at every iteration, [`CsrPattern`](super::CsrPattern) takes less memory and time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Triplets {
    rows: Vec<usize>,
    columns: Vec<usize>,
    values: Vec<f64>,
}

impl Triplets {
    /// No entries.
    pub const fn new() -> Self {
        Self { rows: Vec::new(), columns: Vec::new(), values: Vec::new() }
    }

    /// Replaces the entries by those of the tangents of all elements that carry force, and returns their number. A
    /// tangent's zeros are entries like others; constrained degrees of freedom have none.
    ///
    /// # Errors
    /// Every reason for which the law or an element is refused, [`AssemblyError::Unsymmetric`] for the lower triangle of the exact tangent
    /// of friction, [`AssemblyError::TooLarge`] if the entries do not fit
    /// into memory, [`AssemblyError::Overflow`] if a value is not finite. There are no entries then.
    pub fn fill<E: Elements + ?Sized>(
        &mut self,
        elements: &E,
        law: &ContactLaw<'_>,
        dofs: &DofMap,
        triangle: Triangle,
    ) -> Result<usize, AssemblyError> {
        self.clear();
        if triangle == Triangle::Lower && !law.is_symmetric() {
            return Err(AssemblyError::Unsymmetric);
        }
        check(elements, law, dofs.nodes(), Needs::Tangent)?;
        let filled = self.push_all(elements, law, dofs, triangle);
        if filled.is_err() {
            self.clear();
        }
        filled
    }

    fn push_all<E: Elements + ?Sized>(
        &mut self,
        elements: &E,
        law: &ContactLaw<'_>,
        dofs: &DofMap,
        triangle: Triangle,
    ) -> Result<usize, AssemblyError> {
        let mut count = 0;
        for k in 0..elements.len() {
            let Some(active) = law.active(elements, k) else { continue };
            count += 1;
            let element = elements.element(k);
            let freedoms = || {
                let of_node = |node| dofs.of_node(node);
                element.nodes().flat_map(of_node).enumerate().filter_map(|(p, row)| Some((p, row?)))
            };
            let count = freedoms().count();
            self.reserve(count, count)?;
            for (p, row) in freedoms() {
                for (q, column) in freedoms() {
                    if triangle == Triangle::Lower && row < column {
                        continue;
                    }
                    let value = active.tangent(p, q);
                    if !value.is_finite() {
                        return Err(AssemblyError::Overflow { what: "values", equation: row });
                    }
                    self.push(row, column, value);
                }
            }
        }
        Ok(count)
    }

    /// Makes room for a block.
    pub(crate) fn reserve(&mut self, rows: usize, columns: usize) -> Result<(), AssemblyError> {
        let more = rows.saturating_mul(columns);
        let count = self.values.len().saturating_add(more);
        let too_large = |_| AssemblyError::TooLarge { what: "triplets", count };
        self.rows.try_reserve(more).map_err(too_large)?;
        self.columns.try_reserve(more).map_err(too_large)?;
        self.values.try_reserve(more).map_err(too_large)
    }

    /// Adds an entry.
    pub(crate) fn push(&mut self, row: usize, column: usize, value: f64) {
        self.rows.push(row);
        self.columns.push(column);
        self.values.push(value);
    }

    /// Removes all entries, keeps the memory.
    pub fn clear(&mut self) {
        self.rows.clear();
        self.columns.clear();
        self.values.clear();
    }

    /// Number of entries.
    pub const fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there are none.
    pub const fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Row of each entry.
    pub fn rows(&self) -> &[usize] {
        &self.rows
    }

    /// Column of each entry.
    pub fn columns(&self) -> &[usize] {
        &self.columns
    }

    /// Value of each entry, force per length.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// All entries.
    pub fn iter(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        let places = self.rows.iter().zip(&self.columns);
        places.zip(&self.values).map(|((&row, &column), &value)| (row, column, value))
    }
}
