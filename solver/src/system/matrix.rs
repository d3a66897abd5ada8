//! A sparse matrix over all nodes.

use std::sync::Arc;

use super::BlockPattern;

/// A 3 × 3 block for each pair of nodes of a pattern, [row axis][column axis]. Both halves are stored.
#[derive(Clone, Debug)]
pub struct BlockMatrix {
    pattern: Arc<BlockPattern>,
    blocks: Vec<[[f64; 3]; 3]>,
}

impl BlockMatrix {
    /// Zero.
    #[must_use]
    pub fn new(pattern: Arc<BlockPattern>) -> Self {
        let blocks = vec![[[0.0; 3]; 3]; pattern.blocks()];
        Self { pattern, blocks }
    }

    /// Its pattern.
    #[must_use]
    pub fn pattern(&self) -> &Arc<BlockPattern> {
        &self.pattern
    }

    /// Zero again, with the memory it has.
    pub fn clear(&mut self) {
        self.blocks.fill([[0.0; 3]; 3]);
    }

    /// Zero again with another pattern.
    pub fn reset(&mut self, pattern: Arc<BlockPattern>) {
        self.blocks.clear();
        self.blocks.resize(pattern.blocks(), [[0.0; 3]; 3]);
        self.pattern = pattern;
    }

    /// The block of a pair of nodes, if there is one.
    #[must_use]
    pub fn block(&self, row: usize, column: usize) -> Option<&[[f64; 3]; 3]> {
        self.pattern.block(row, column).map(|index| &self.blocks[index])
    }

    /// All entries: block by block, in each row axis by row axis.
    #[cfg(test)]
    pub(crate) fn entries(&self) -> &[f64] {
        self.blocks.as_flattened().as_flattened()
    }

    /// All blocks, row by row.
    pub(super) fn blocks(&self) -> &[[[f64; 3]; 3]] {
        &self.blocks
    }

    /// Adds a matrix over the coordinates of `nodes`, node by node, whose rows follow one another in `dense`. A node may occur more than once.
    ///
    /// # Panics
    /// If the length is not (3n)², or a pair of the nodes is not in the pattern.
    pub fn add_dense(&mut self, nodes: &[usize], dense: &[f64]) {
        let size = 3 * nodes.len();
        assert_eq!(dense.len(), size * size, "entries over {} nodes", nodes.len());
        for (rows, &row) in dense.chunks_exact((3 * size).max(1)).zip(nodes) {
            for (b, &column) in nodes.iter().enumerate() {
                let block = std::array::from_fn(|i| std::array::from_fn(|j| rows[i * size + 3 * b + j]));
                self.add_block(row, column, &block);
            }
        }
    }

    /// Adds `scale` times the symmetric matrix over the coordinates of `nodes`, node by node, whose lower triangle is `packed`
    /// row by row: entry (i, j ≤ i) at i(i+1)/2 + j. A node may occur more than once.
    ///
    /// # Panics
    /// If the length is not 3n(3n+1)/2, or a pair of the nodes is not in the pattern.
    pub fn add_symmetric(&mut self, nodes: &[usize], packed: &[f64], scale: f64) {
        let size = 3 * nodes.len();
        assert_eq!(
            packed.len(),
            size * (size + 1) / 2,
            "entries of the lower triangle over {} nodes",
            nodes.len()
        );
        for (a, &row) in nodes.iter().enumerate() {
            for (b, &column) in nodes[..a].iter().enumerate() {
                let lower = std::array::from_fn(|i| {
                    let at = (3 * a + i) * (3 * a + i + 1) / 2 + 3 * b;
                    [scale * packed[at], scale * packed[at + 1], scale * packed[at + 2]]
                });
                let upper = std::array::from_fn(|i| std::array::from_fn(|j| lower[j][i]));
                self.add_block(row, column, &lower);
                self.add_block(column, row, &upper);
            }
            let entry = |i: usize, j: usize| scale * packed[(3 * a + i) * (3 * a + i + 1) / 2 + 3 * a + j];
            let diagonal = std::array::from_fn(|i| std::array::from_fn(|j| entry(i.max(j), i.min(j))));
            self.add_block(row, row, &diagonal);
        }
    }

    /// Adds `scale` times the matrix over the coordinates of `nodes`, node by node, all of it row by row.
    ///
    /// # Panics
    /// If the length is not (3n)², or a pair of the nodes is not in the pattern.
    pub fn add(&mut self, nodes: &[usize], entries: &[f64], scale: f64) {
        let size = 3 * nodes.len();
        assert_eq!(entries.len(), size * size, "entries over {} nodes", nodes.len());
        for (a, &row) in nodes.iter().enumerate() {
            for (b, &column) in nodes.iter().enumerate() {
                let block = std::array::from_fn(|i| {
                    let at = (3 * a + i) * size + 3 * b;
                    [scale * entries[at], scale * entries[at + 1], scale * entries[at + 2]]
                });
                self.add_block(row, column, &block);
            }
        }
    }

    /// Adds to the block of one pair.
    ///
    /// # Panics
    /// If the pair is not in the pattern.
    pub fn add_block(&mut self, row: usize, column: usize, block: &[[f64; 3]; 3]) {
        let index = self.pattern.block(row, column);
        let index =
            index.unwrap_or_else(|| panic!("the nodes {row} and {column} are no pair of the pattern"));
        for (sums, entries) in self.blocks[index].iter_mut().zip(block) {
            for (sum, entry) in sums.iter_mut().zip(entries) {
                *sum += entry;
            }
        }
    }

    /// y = K x. Lists of another length than the nodes' are an error of the program.
    ///
    /// # Panics
    /// If a length is wrong.
    pub fn multiply(&self, x: &[[f64; 3]], y: &mut [[f64; 3]]) {
        assert_eq!(x.len(), self.pattern.nodes(), "entries of x");
        assert_eq!(y.len(), self.pattern.nodes(), "entries of y");
        for (node, result) in y.iter_mut().enumerate() {
            let blocks = &self.blocks[self.pattern.start(node)..];
            let mut sum = [0.0; 3];
            for (block, &column) in blocks.iter().zip(self.pattern.row(node)) {
                let x = x[column as usize];
                for i in 0..3 {
                    sum[i] += block[i][0] * x[0] + block[i][1] * x[1] + block[i][2] * x[2];
                }
            }
            *result = sum;
        }
    }

    /// y = |K| |x|, the moduli entry by entry.
    ///
    /// # Panics
    /// If a length is wrong.
    pub fn multiply_moduli(&self, x: &[[f64; 3]], y: &mut [[f64; 3]]) {
        assert_eq!(x.len(), self.pattern.nodes(), "entries of x");
        assert_eq!(y.len(), self.pattern.nodes(), "entries of y");
        for (node, result) in y.iter_mut().enumerate() {
            let blocks = &self.blocks[self.pattern.start(node)..];
            let mut sum = [0.0; 3];
            for (block, &column) in blocks.iter().zip(self.pattern.row(node)) {
                let x = x[column as usize].map(f64::abs);
                for i in 0..3 {
                    sum[i] += block[i][0].abs() * x[0] + block[i][1].abs() * x[1] + block[i][2].abs() * x[2];
                }
            }
            *result = sum;
        }
    }
}
