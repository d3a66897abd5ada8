//! The tangent in compressed sparse rows.

mod fill;
mod incidence;
mod locate;
mod map;
mod rows;
mod split;
mod stream;

pub(super) use incidence::Lists;
pub use locate::CsrIndex;
pub use map::CsrMap;

use super::{AssemblyError, DofMap, ElementView, Elements};
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
        Self::of(found, dofs, (Vec::new(), Vec::new()), Vec::new())
    }

    /// The pattern of the elements as they are now, in the memory of this one: after a refresh that changed lists of nodes, where
    /// [`fits`](CsrMap::fits) of the [`map`](Self::map) says no. The pages of new memory are a part of the time that
    /// [`union`](Self::union) takes.
    ///
    /// # Errors
    /// As [`union`](Self::union). The pattern is then as it was; without memory for the new one it has no elements and no entries.
    pub fn renew<E: Elements + ?Sized>(&mut self, elements: &E, dofs: &DofMap) -> Result<(), AssemblyError> {
        let found = Found::new(elements, dofs)?;
        let memory = (std::mem::take(&mut self.row_offsets), std::mem::take(&mut self.columns));
        let places = std::mem::take(&mut self.map.places);
        match Self::of(found, dofs, memory, places) {
            Ok(pattern) => {
                *self = pattern;
                Ok(())
            }
            Err(error) => {
                *self = Self::union::<[ElementView<'_>]>(&[], &DofMap::standard(0))?;
                Err(error)
            }
        }
    }

    fn of(
        found: Found,
        dofs: &DofMap,
        memory: (Vec<usize>, Vec<u32>),
        places: Vec<u32>,
    ) -> Result<Self, AssemblyError> {
        let (row_offsets, columns) = rows::union(&found.neighbours, &found.groups, dofs, memory)?;
        let map = found.within(dofs, &row_offsets, &columns, true, places)?;
        Ok(Self { row_offsets, columns, map })
    }

    /// Number of rows and columns, the equations of the [`DofMap`](super::DofMap).
    pub fn equations(&self) -> usize {
        self.row_offsets.len() - 1
    }

    /// Number of entries.
    pub fn entries(&self) -> usize {
        self.columns.len()
    }

    /// Where each row begins among the entries, and after the last row, where it ends: equations + 1 numbers.
    pub fn row_offsets(&self) -> &[usize] {
        &self.row_offsets
    }

    /// Column of each entry, ascending within a row.
    pub fn columns(&self) -> &[u32] {
        &self.columns
    }

    /// What fills the values.
    pub const fn map(&self) -> &CsrMap {
        &self.map
    }

    /// Which entry lies at (row, column), if there is one.
    pub fn position(&self, row: usize, column: usize) -> Option<usize> {
        let (&first, &end) = (self.row_offsets.get(row)?, self.row_offsets.get(row + 1)?);
        let column = u32::try_from(column).ok()?;
        self.columns[first..end].binary_search(&column).ok().map(|place| first + place)
    }

    /// Row offsets, columns and the map, to be kept apart from one another.
    pub fn into_parts(self) -> (Vec<usize>, Vec<u32>, CsrMap) {
        (self.row_offsets, self.columns, self.map)
    }

    /// Bytes the pattern occupies with its map, without the values.
    pub fn memory(&self) -> usize {
        size_of_val(self.row_offsets.as_slice()) + size_of_val(self.columns.as_slice()) + self.map.memory()
    }
}
