//! The tangent in compressed sparse rows.

mod fill;
mod incidence;
mod locate;
mod map;
mod rows;
mod split;
mod stream;

pub use locate::CsrIndex;
pub use map::CsrMap;

use super::{AssemblyError, DofMap, Elements};
use map::Found;

/// The places of the tangent's entries in compressed sparse rows, for all elements of a pairing whether they carry force
/// or not: it stays valid until the lists of nodes change, and a solver can keep its symbolic factorisation as long.
///
/// Both triangles are there. Rows are equations; rows of equations that belong to no node of the elements are empty. The
/// columns of a row ascend. [`map`](Self::map) fills the values; a matrix that a host has already, with other entries beside these,
/// gets a [`CsrMap`] of its own.
///
/// # Memory
///
/// With `e` entries and `r` equations, 4 e + 8 (r + 1) bytes, and what the map takes; 8 e for the caller's values come on top.
#[derive(Clone, Debug)]
pub struct CsrPattern {
    /// Entries of row i are those from `row_offsets[i]` to `row_offsets[i + 1]`.
    row_offsets: Vec<usize>,
    columns: Vec<u32>,
    map: CsrMap,
}

impl CsrPattern {
    /// The union of the places of all paired elements. Elements without masters take part in nothing, but count.
    ///
    /// # Errors
    /// [`AssemblyError::UnknownNode`]; [`AssemblyError::TooLarge`] if there are 2³² nodes, elements or equations or more, or
    /// an array cannot be allocated. (Where the system promises more memory than it has, it may still end the
    /// program when the memory is used.)
    pub fn union<E: Elements + ?Sized>(elements: &E, dofs: &DofMap) -> Result<Self, AssemblyError> {
        let found = Found::new(elements, dofs)?;
        let (row_offsets, columns) = rows::union(&found.neighbours, &found.groups, dofs)?;
        let map = found.within(dofs, &row_offsets, &columns)?;
        Ok(Self { row_offsets, columns, map })
    }

    /// Number of rows and columns, the equations of the [`DofMap`](super::DofMap).
    #[must_use]
    pub fn equations(&self) -> usize {
        self.row_offsets.len() - 1
    }

    /// Number of entries.
    #[must_use]
    pub fn entries(&self) -> usize {
        self.columns.len()
    }

    /// Where each row begins among the entries, and after the last row, where it ends: equations + 1 numbers.
    #[must_use]
    pub fn row_offsets(&self) -> &[usize] {
        &self.row_offsets
    }

    /// Column of each entry, ascending within a row.
    #[must_use]
    pub fn columns(&self) -> &[u32] {
        &self.columns
    }

    /// What fills the values.
    #[must_use]
    pub const fn map(&self) -> &CsrMap {
        &self.map
    }

    /// Which entry lies at (row, column), if there is one.
    #[must_use]
    pub fn position(&self, row: usize, column: usize) -> Option<usize> {
        let (&first, &end) = (self.row_offsets.get(row)?, self.row_offsets.get(row + 1)?);
        let column = u32::try_from(column).ok()?;
        self.columns[first..end].binary_search(&column).ok().map(|place| first + place)
    }

    /// Row offsets, columns and the map, to be kept apart from one another.
    #[must_use]
    pub fn into_parts(self) -> (Vec<usize>, Vec<u32>, CsrMap) {
        (self.row_offsets, self.columns, self.map)
    }

    /// Bytes the pattern occupies with its map, without the values.
    #[must_use]
    pub fn memory(&self) -> usize {
        size_of_val(self.row_offsets.as_slice()) + size_of_val(self.columns.as_slice()) + self.map.memory()
    }
}
