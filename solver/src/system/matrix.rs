//! A sparse matrix over all nodes.

use std::sync::Arc;

use rayon::prelude::*;

use super::contact_rows::SavedRows;
use super::multigrid::{View, add_product};
use super::{BlockPattern, Equations, SystemError};

/// A 3 × 3 block for each pair of nodes of a pattern, [row axis][column axis]. Both halves are stored.
#[derive(Clone, Debug)]
pub struct BlockMatrix {
    pattern: Arc<BlockPattern>,
    blocks: Vec<[[f64; 3]; 3]>,
}

impl BlockMatrix {
    /// Zero.
    pub fn new(pattern: Arc<BlockPattern>) -> Self {
        let blocks = vec![[[0.0; 3]; 3]; pattern.blocks()];
        Self { pattern, blocks }
    }

    /// Its pattern.
    pub fn pattern(&self) -> &Arc<BlockPattern> {
        &self.pattern
    }

    /// Zero again, with the memory it has.
    pub fn clear(&mut self) {
        self.blocks.fill([[0.0; 3]; 3]);
    }

    /// The block of a pair of nodes, if there is one.
    pub fn block(&self, row: usize, column: usize) -> Option<&[[f64; 3]; 3]> {
        self.pattern.block(row, column).map(|index| &self.blocks[index])
    }

    /// All blocks, row by row.
    pub(super) fn blocks(&self) -> &[[[f64; 3]; 3]] {
        &self.blocks
    }

    /// Adds the symmetric matrix over the coordinates of `nodes`, node by node, whose lower triangle is `packed`
    /// row by row: entry (i, j ≤ i) at i(i+1)/2 + j. A node may occur more than once.
    ///
    /// # Panics
    /// If the length is not 3n(3n+1)/2, or a pair of the nodes is not in the pattern.
    pub fn add_symmetric(&mut self, nodes: &[usize], packed: &[f64]) {
        let size = 3 * nodes.len();
        assert_eq!(
            packed.len(),
            size * (size + 1) / 2,
            "entries of the lower triangle over {} nodes",
            nodes.len()
        );
        let mut rest = packed;
        for (a, &row) in nodes.iter().enumerate() {
            // The three rows of this node.
            let (x, others) = rest.split_at(3 * a + 1);
            let (y, others) = others.split_at(3 * a + 2);
            let (z, others) = others.split_at(3 * a + 3);
            rest = others;
            let columns = x.as_chunks::<3>().0.iter().zip(y.as_chunks::<3>().0).zip(z.as_chunks::<3>().0);
            for (((x, y), z), &column) in columns.zip(&nodes[..a]) {
                let (mut lower, mut upper) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
                for (i, entries) in [x, y, z].into_iter().enumerate() {
                    for j in 0..3 {
                        lower[i][j] = entries[j];
                        upper[j][i] = lower[i][j];
                    }
                }
                self.add_block(row, column, &lower);
                self.add_block(column, row, &upper);
            }
            let at = 3 * a;
            let (xx, yx, yy) = (x[at], y[at], y[at + 1]);
            let (zx, zy, zz) = (z[at], z[at + 1], z[at + 2]);
            self.add_block(row, row, &[[xx, yx, zx], [yx, yy, zy], [zx, zy, zz]]);
        }
    }

    /// Adds the matrix over the coordinates of `nodes`, node by node, all of it row by row.
    ///
    /// # Panics
    /// If the length is not (3n)², or a pair of the nodes is not in the pattern.
    pub fn add(&mut self, nodes: &[usize], entries: &[f64]) {
        let size = 3 * nodes.len();
        assert_eq!(entries.len(), size * size, "entries over {} nodes", nodes.len());
        for (a, &row) in nodes.iter().enumerate() {
            for (b, &column) in nodes.iter().enumerate() {
                let block = std::array::from_fn(|i| {
                    let at = (3 * a + i) * size + 3 * b;
                    [entries[at], entries[at + 1], entries[at + 2]]
                });
                self.add_block(row, column, &block);
            }
        }
    }

    /// Adds a matrix whose rows belong to some nodes and whose columns to others, all of it row by row.
    ///
    /// # Panics
    /// If the length is not that of its blocks, or a pair of the nodes is not in the pattern.
    pub fn add_rectangle(&mut self, rows: &[u32], columns: &[u32], entries: &[f64]) {
        let width = 3 * columns.len();
        assert_eq!(
            entries.len(),
            3 * rows.len() * width,
            "entries of {} times {} nodes",
            rows.len(),
            columns.len()
        );
        for (a, &row) in rows.iter().enumerate() {
            for (b, &column) in columns.iter().enumerate() {
                let block: [[f64; 3]; 3] = std::array::from_fn(|i| {
                    let at = (3 * a + i) * width + 3 * b;
                    [entries[at], entries[at + 1], entries[at + 2]]
                });
                if block != [[0.0; 3]; 3] {
                    self.add_block(row as usize, column as usize, &block);
                }
            }
        }
    }

    /// Adds to the block of one pair.
    ///
    /// # Panics
    /// If the pair is not in the pattern.
    #[inline]
    pub fn add_block(&mut self, row: usize, column: usize, block: &[[f64; 3]; 3]) {
        let index = self.pattern.block(row, column);
        let index =
            index.unwrap_or_else(|| panic!("the nodes {row} and {column} are no pair of the pattern"));
        let sums = &mut self.blocks[index];
        for i in 0..3 {
            for j in 0..3 {
                sums[i][j] += block[i][j];
            }
        }
    }

    /// K_ii ← K_ii + part · |K_ii|
    pub fn add_to_diagonal(&mut self, part: f64) {
        for node in 0..self.pattern.nodes() {
            let Some(index) = self.pattern.block(node, node) else { continue };
            for axis in 0..3 {
                let entry = &mut self.blocks[index][axis][axis];
                *entry += part * entry.abs();
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
        self.view().multiply(x, y);
    }

    /// y = |K| |x|, the moduli entry by entry.
    ///
    /// # Panics
    /// If a length is wrong.
    pub fn multiply_moduli(&self, x: &[[f64; 3]], y: &mut [[f64; 3]]) {
        assert_eq!(x.len(), self.pattern.nodes(), "entries of x");
        assert_eq!(y.len(), self.pattern.nodes(), "entries of y");
        let rows = y.par_iter_mut().enumerate().with_min_len(1024);
        rows.for_each(|(node, result)| *result = self.row_of_moduli(node, x));
    }

    /// The rows of K x of some nodes, in their order.
    ///
    /// # Panics
    /// If the length of x is wrong, or there is no such node.
    pub fn multiply_rows(&self, nodes: &[usize], x: &[[f64; 3]]) -> Vec<[f64; 3]> {
        assert_eq!(x.len(), self.pattern.nodes(), "entries of x");
        let view = self.view();
        let row = |&node: &usize| {
            let mut sum = [0.0; 3];
            view.row(node).for_each(|(column, block)| add_product(&mut sum, block, &x[column]));
            sum
        };
        nodes.par_iter().with_min_len(1024).map(row).collect()
    }

    /// The rows of |K| |x| of some nodes, in their order.
    ///
    /// # Panics
    /// As [`multiply_rows`](Self::multiply_rows).
    pub fn multiply_moduli_rows(&self, nodes: &[usize], x: &[[f64; 3]]) -> Vec<[f64; 3]> {
        assert_eq!(x.len(), self.pattern.nodes(), "entries of x");
        nodes.par_iter().with_min_len(1024).map(|&node| self.row_of_moduli(node, x)).collect()
    }

    fn row_of_moduli(&self, node: usize, x: &[[f64; 3]]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (column, block) in self.view().row(node) {
            let x = x[column].map(f64::abs);
            for i in 0..3 {
                sum[i] += block[i][0].abs() * x[0] + block[i][1].abs() * x[1] + block[i][2].abs() * x[2];
            }
        }
        sum
    }

    /// Its rows of some nodes, given in ascending order.
    pub fn rows_of(&self, nodes: &[u32]) -> SavedRows {
        let of_node = |&node: &u32| {
            let start = self.pattern.start(node as usize);
            &self.blocks[start..start + self.pattern.row(node as usize).len()]
        };
        let blocks = nodes.iter().flat_map(of_node).copied().collect();
        SavedRows { nodes: nodes.to_vec(), blocks }
    }

    /// The blocks of a node's row.
    pub(super) fn row_mut(&mut self, node: usize) -> &mut [[[f64; 3]; 3]] {
        let start = self.pattern.start(node);
        &mut self.blocks[start..start + self.pattern.row(node).len()]
    }

    /// Compressed rows.
    pub(super) fn view(&self) -> View<'_, 3, 3> {
        let (starts, columns) = self.pattern.rows();
        View { starts, columns, blocks: &self.blocks, width: self.pattern.nodes() }
    }

    /// Memory with the pattern's, bytes.
    pub(super) fn bytes(&self) -> usize {
        self.blocks.len() * (size_of::<[[f64; 3]; 3]>() + 4) + (self.pattern.nodes() + 1) * size_of::<usize>()
    }

    /// Finds an entry among the free equations that is not finite, the first by rows.
    pub(super) fn check_finite(&self, equations: &Equations) -> Result<(), SystemError> {
        let view = self.view();
        let find = |row: usize| {
            for (column, block) in view.row(row) {
                for (i, j) in (0..9).map(|k| (k / 3, k % 3)) {
                    let (equation, other) = (equations.number(row, i), equations.number(column, j));
                    if let (Some(equation), Some(_), false) = (equation, other, block[i][j].is_finite()) {
                        return Some(SystemError::NotFinite {
                            equation,
                            node: row,
                            axis: i,
                            value: block[i][j],
                        });
                    }
                }
            }
            None
        };
        let nodes = 0..self.pattern.nodes();
        nodes.into_par_iter().with_min_len(1024).find_map_first(find).map_or(Ok(()), Err)
    }
}
