//! Which pairs of nodes have a block.

/// Pairs of nodes that share a clique, in compressed rows; each node also makes a pair with itself. Symmetric.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlockPattern {
    /// Where the row of each node begins, and the end.
    starts: Vec<usize>,
    /// Second nodes, ascending within a row.
    columns: Vec<u32>,
}

impl BlockPattern {
    /// The pattern over `nodes` nodes of all `cliques`; they may repeat a node, and are gone through twice.
    ///
    /// # Panics
    /// If a clique names a node that is not there, or there are more nodes than 32-bit indices can name.
    pub fn new<C: AsRef<[usize]>>(nodes: usize, cliques: impl Iterator<Item = C> + Clone) -> Self {
        assert!(u32::try_from(nodes).is_ok(), "{nodes} nodes are more than 32-bit indices can name");
        // Rows with repetitions first: the diagonal, then each clique in turn.
        let mut ends = vec![1; nodes];
        for clique in cliques.clone() {
            let clique = clique.as_ref();
            for &node in clique {
                ends[node] += clique.len();
            }
        }
        let mut total = 0;
        for end in &mut ends {
            total += std::mem::replace(end, total);
        }
        let mut crowded = vec![0_u32; total];
        for node in 0..nodes {
            crowded[ends[node]] = node as u32;
            ends[node] += 1;
        }
        for clique in cliques {
            let clique = clique.as_ref();
            for &node in clique {
                for (slot, &other) in crowded[ends[node]..].iter_mut().zip(clique) {
                    *slot = other as u32;
                }
                ends[node] += clique.len();
            }
        }

        let mut starts = Vec::with_capacity(nodes + 1);
        let mut columns = Vec::new();
        let mut begin = 0;
        starts.push(0);
        for end in ends {
            let row = &mut crowded[begin..end];
            row.sort_unstable();
            let first = columns.len();
            for &column in &*row {
                if columns.len() == first || columns.last() != Some(&column) {
                    columns.push(column);
                }
            }
            starts.push(columns.len());
            begin = end;
        }
        Self { starts, columns }
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.starts.len() - 1
    }

    /// Number of blocks.
    pub fn blocks(&self) -> usize {
        self.columns.len()
    }

    /// The nodes that make a pair with `node`, ascending.
    pub fn row(&self, node: usize) -> &[u32] {
        &self.columns[self.starts[node]..self.starts[node + 1]]
    }

    /// Where the row of each node begins, and the end; the second nodes.
    pub(super) fn rows(&self) -> (&[usize], &[u32]) {
        (&self.starts, &self.columns)
    }

    /// Index of the first block of a row.
    pub(super) fn start(&self, node: usize) -> usize {
        self.starts[node]
    }

    /// Index of the block of a pair.
    #[inline]
    pub fn block(&self, row: usize, column: usize) -> Option<usize> {
        let place = self.row(row).binary_search(&u32::try_from(column).ok()?).ok()?;
        Some(self.starts[row] + place)
    }
}
