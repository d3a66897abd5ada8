//! What contact adds to the rows of a matrix.

use nalgebra::{Matrix3, SymmetricEigen};

use super::multigrid::{Block, View};

/// The rows of some nodes before contact was added to a matrix.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SavedRows {
    /// The nodes, ascending.
    pub nodes: Vec<u32>,
    /// Their blocks, row after row.
    pub blocks: Vec<Block<3, 3>>,
}

/// The contact's part of a matrix, row by row.
pub struct ContactRows<'a> {
    /// The matrix with contact.
    pub matrix: View<'a, 3, 3>,
    /// Rows without it.
    pub before: &'a SavedRows,
    /// Where the blocks of each saved row begin.
    starts: Vec<usize>,
    /// Which axes of a node are unknowns.
    active: &'a [[bool; 3]],
}

impl<'a> ContactRows<'a> {
    /// Of a matrix with the pattern that the rows were saved with.
    pub fn new(matrix: View<'a, 3, 3>, before: &'a SavedRows, active: &'a [[bool; 3]]) -> Self {
        let mut starts = vec![0];
        for &node in &before.nodes {
            let node = node as usize;
            starts.push(starts[starts.len() - 1] + matrix.starts[node + 1] - matrix.starts[node]);
        }
        Self { matrix, before, starts, active }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.before.nodes.len()
    }

    /// The node of a row.
    pub fn node(&self, k: usize) -> usize {
        self.before.nodes[k] as usize
    }

    /// The row of a node.
    pub fn place(&self, node: usize) -> Option<usize> {
        self.before.nodes.binary_search(&(node as u32)).ok()
    }

    /// The blocks of a row without contact.
    pub fn without(&self, k: usize) -> &'a [Block<3, 3>] {
        &self.before.blocks[self.starts[k]..self.starts[k + 1]]
    }

    /// The contact's part of the blocks of a row, without axes that are no unknowns.
    pub fn row(&self, k: usize) -> impl Iterator<Item = (usize, Matrix3<f64>)> {
        let own = self.node(k);
        self.matrix.row(own).zip(self.without(k)).map(move |((node, after), before)| {
            let is_free = |i: usize, j: usize| self.active[own][i] && self.active[node][j];
            let entry = |i, j| if is_free(i, j) { after[i][j] - before[i][j] } else { 0.0 };
            (node, Matrix3::from_fn(entry))
        })
    }

    /// The contact's part of a row's diagonal block.
    pub fn own(&self, k: usize) -> Matrix3<f64> {
        let own = self.node(k);
        self.row(k).find(|&(node, _)| node == own).map_or_else(Matrix3::zeros, |(_, block)| block)
    }

    /// The mean modulus of a row's diagonal entries without contact: what the body resists with.
    pub fn elastic(&self, k: usize) -> f64 {
        let own = self.node(k);
        let place = self.matrix.row(own).position(|(node, _)| node == own);
        let block = place.map_or([[0.0; 3]; 3], |place| self.without(k)[place]);
        (0..3).map(|i| block[i][i].abs()).sum::<f64>() / 3.0
    }

    /// Principal directions and stiffnesses of the symmetric part of a row's [`own`](Self::own).
    pub fn principal(&self, k: usize) -> SymmetricEigen<f64, nalgebra::Const<3>> {
        let own = self.own(k);
        SymmetricEigen::new(0.5 * (own + own.transpose()))
    }
}
