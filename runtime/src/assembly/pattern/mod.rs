//! The tangent in compressed sparse rows.

mod build;
mod fill;
mod split;

/// The places of the tangent's entries in compressed sparse rows, for all elements of a pairing whether they carry force
/// or not: it stays valid until the pairing is refreshed, and a solver can keep its symbolic factorisation as long.
///
/// Both triangles are there. Rows are equations; rows of equations that belong to no node of the elements are empty. The
/// columns of a row ascend.
///
/// # Memory
///
/// With `e` entries, `r` equations, `c` nodes of which `m` occur in elements, `b` pairs of nodes (i, j) that occur
/// together in an element (i = j too), and elements with n₁, n₂, … nodes (slave included), in bytes on a 64-bit machine:
///
/// ```text
/// 8 e + 8 (r + 1)                 columns and row offsets
/// 12 b + 16 (c + 1) + 16 m        where the entries of two nodes lie in a row
/// Σ (4 nₖ² + 12 nₖ + 16) + 16     which pairs of nodes an element has
/// ```
///
/// and 8 e for the caller's values; e = 9 b without constraints. (If the equations of a node are not consecutive, it takes up to
/// 48 instead of 16 bytes.) [`memory`](Self::memory) is this sum. An element with
/// twelve master nodes takes 848 bytes, and on a surface whose slave mesh is about as fine as the master's, with some 60
/// pairs per slave, the whole takes about 10 kB per slave including the values.
#[derive(Clone, Debug)]
pub struct CsrPattern {
    /// Entries of row i are those from `row_offsets[i]` to `row_offsets[i + 1]`.
    row_offsets: Vec<usize>,
    columns: Vec<usize>,
    /// Nodes of element k: `element_nodes[node_offsets[k]..node_offsets[k + 1]]`, slave first.
    node_offsets: Vec<usize>,
    element_nodes: Vec<u32>,
    /// Row by row, for each pair (a, b) of an element's nodes: the number of b's pair among those of the node a.
    /// Those of element k begin at `pair_offsets[k]`.
    pair_offsets: Vec<usize>,
    pairs: Vec<u32>,
    /// Occurrences of a node in elements, in order of the elements: `occurrences[occurrence_offsets[node]..]`.
    occurrence_offsets: Vec<usize>,
    occurrences: Vec<Occurrence>,
    /// For each pair (i, j) of nodes, those of i from `slot_offsets[i]` on: the places of the axes of j within a row
    /// of i, or [`NO_SLOT`].
    slot_offsets: Vec<usize>,
    slots: Vec<[u32; 3]>,
    /// Rows to be filled, ascending.
    groups: Vec<RowGroup>,
}

/// In place of a slot where the column is constrained.
const NO_SLOT: u32 = u32::MAX;

/// A node in an element.
#[derive(Clone, Copy, Debug)]
struct Occurrence {
    element: u32,
    /// Place among the element's nodes, 0 for the slave.
    local: u32,
}

/// Consecutive rows of the same node: all three of them, unless the map of degrees of freedom tears them apart.
#[derive(Clone, Copy, Debug)]
struct RowGroup {
    /// The first of the rows.
    first: usize,
    node: u32,
    /// Axes of the rows.
    axes: [u8; 3],
    /// Number of rows.
    count: u8,
}

impl CsrPattern {
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
    pub fn columns(&self) -> &[usize] {
        &self.columns
    }

    /// Which entry lies at (row, column), if there is one.
    #[must_use]
    pub fn position(&self, row: usize, column: usize) -> Option<usize> {
        let (&first, &end) = (self.row_offsets.get(row)?, self.row_offsets.get(row + 1)?);
        self.columns[first..end].binary_search(&column).ok().map(|place| first + place)
    }

    /// Bytes the pattern occupies, without the values.
    #[must_use]
    pub fn memory(&self) -> usize {
        let lists = [
            &self.row_offsets,
            &self.columns,
            &self.node_offsets,
            &self.pair_offsets,
            &self.occurrence_offsets,
            &self.slot_offsets,
        ];
        lists.iter().map(|list| size_of_val(list.as_slice())).sum::<usize>()
            + size_of_val(self.element_nodes.as_slice())
            + size_of_val(self.pairs.as_slice())
            + size_of_val(self.occurrences.as_slice())
            + size_of_val(self.slots.as_slice())
            + size_of_val(self.groups.as_slice())
    }

    /// Nodes of element `k`, slave first.
    fn nodes_of(&self, k: usize) -> &[u32] {
        &self.element_nodes[self.node_offsets[k]..self.node_offsets[k + 1]]
    }

    /// Occurrences of a node.
    fn occurrences_of(&self, node: usize) -> &[Occurrence] {
        &self.occurrences[self.occurrence_offsets[node]..self.occurrence_offsets[node + 1]]
    }
}
