//! Hessians from their form of low rank: M = Σ cᵀb + bᵀc over slave and nodes, plus the nodes' own blocks.
//!
//! The own block O of a node stands at (node, node), −O at (node, slave).
//! Rows are ordered b₀, c₀, b₁, c₁, ….
//!
//! A product may overflow though others that it cancels with hide it: what multiplies also returns 0 times sums of entries it wrote: 0 if all
//! are finite, NaN if not, or if their sum is within a factor of nine of overflow. The slave's rows are the negative sums of the nodes', and
//! so is its own block.

use super::second::MOST_ROWS;
use super::simd::Vector;
use super::{Lane, packed_row};

/// How many rows a form has.
#[derive(Clone, Copy, Debug)]
pub struct FormRows {
    /// Rows of a node, two for each product.
    pub rows: usize,
    /// Number of master nodes.
    pub count: usize,
}

impl FormRows {
    /// Room for a node's own block, and for a sum of blocks.
    pub const OWN: usize = 15;

    /// Numbers of the [factors](super::Second) that a form leaves.
    #[inline(always)]
    pub const fn factors(self) -> usize {
        self.node_factors() * self.count
    }

    /// Numbers of the slave's [rows](super::SecondKind::SlaveRows) of M.
    #[inline(always)]
    pub const fn slave_rows(self) -> usize {
        9 * (self.count + 1)
    }

    /// Factors of one node.
    #[inline(always)]
    pub(super) const fn node_factors(self) -> usize {
        3 * self.rows + 6
    }
}

/// Writes values one after another. (`copy_from_slice` is not always inlined.)
#[allow(clippy::manual_memcpy)]
#[inline(always)]
pub(super) fn write<T: Copy, const VALUES: usize>(values: [T; VALUES], target: &mut [T], start: usize) {
    let target = &mut target[start..start + VALUES];
    for k in 0..VALUES {
        target[k] = values[k];
    }
}

/// Where the blocks of a Hessian go, as [`batch::multiply`] writes them: node after node from the last one on, of each the blocks with nodes
/// before it, ascending, then its own and the one with the slave.
pub(super) trait Blocks<T> {
    /// Goes on to the rows of a node, counted from 1.
    fn begin(&mut self, node: usize);

    /// The block with a node before this one.
    fn write_block(&mut self, column: usize, block: &[[T; 3]; 3]);

    /// The node's own block, of which the lower triangle is read, and the one with the slave.
    fn write_ends(&mut self, own: &[[T; 3]; 3], with_slave: &[[T; 3]; 3]);

    /// The slave's own block, last of all.
    fn write_slave(&mut self, block: &[[T; 3]; 3]);
}

/// A packed lower triangle, and the node whose rows are written.
pub(super) struct Packed<'a, T> {
    pub target: &'a mut [T],
    pub node: usize,
}

impl<T: Lane> Packed<'_, T> {
    #[inline(always)]
    fn write_lower(&mut self, node: usize, block: &[[T; 3]; 3]) {
        for i in 0..3 {
            for j in 0..=i {
                self.target[packed_row(3 * node + i) + 3 * node + j] = block[i][j];
            }
        }
    }
}

impl<T: Lane> Blocks<T> for Packed<'_, T> {
    #[inline(always)]
    fn begin(&mut self, node: usize) {
        self.node = node;
    }

    #[inline(always)]
    fn write_block(&mut self, column: usize, block: &[[T; 3]; 3]) {
        for i in 0..3 {
            write(block[i], self.target, packed_row(3 * self.node + i) + 3 * column);
        }
    }

    #[inline(always)]
    fn write_ends(&mut self, own: &[[T; 3]; 3], with_slave: &[[T; 3]; 3]) {
        self.write_lower(self.node, own);
        self.write_block(0, with_slave);
    }

    #[inline(always)]
    fn write_slave(&mut self, block: &[[T; 3]; 3]) {
        self.write_lower(0, block);
    }
}

pub(super) mod batch;
pub(super) mod single;

#[cfg(test)]
mod tests;
