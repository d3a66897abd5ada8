//! Other unknowns for slaves: what a stiff contact couples to masters becomes small in them.
//!
//! A penalty ε N Nᵀ adds stiffness ε to the gap alone. Motions of slave and masters together cost nothing of it, yet every diagonal entry
//! on their way has ε: a smoother that divides by it stands still, and aggregates on both sides cannot follow. So the unknowns of a slave
//! s in the stiff directions Q are measured from where its masters m would take it:
//!
//! ```text
//! v = T y:   v_s = y_s − Σ_m H_sm y_m      H_sm = Q (Qᵀ C_ss Q)⁻¹ Qᵀ C_sm      v_m = y_m
//! ```
//!
//! C is the contact's part of the matrix. The stiff entries of Tᵀ K T then are those of y_s on the diagonal, and no ε is left in the
//! masters'. T changes the preconditioner only: any regular one leads to the same solution.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use rayon::prelude::*;

use super::sparse::{Block, Sparse, View};

/// A direction is stiff if contact adds at least this part of the stiffness that the node has without.
const STIFF: f64 = 0.5;

/// The rows of some nodes before contact was added to a matrix.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SavedRows {
    /// The nodes, ascending.
    pub nodes: Vec<u32>,
    /// Their blocks, row after row.
    pub blocks: Vec<Block<3, 3>>,
}

/// T, its transpose, and the stiff directions.
#[derive(Clone, Debug)]
pub struct Change {
    /// T
    pub forward: Sparse<3, 3>,
    /// Tᵀ
    pub backward: Sparse<3, 3>,
    /// I − Q Qᵀ of each slave that has stiff directions.
    pub soft: Vec<(usize, Block<3, 3>)>,
}

impl Change {
    /// For the slaves whose rows were saved; `None` if nothing is stiff. `active`: which axes of a node are unknowns.
    pub fn new(matrix: View<'_, 3, 3>, saved: &SavedRows, active: &[[bool; 3]]) -> Option<Self> {
        let mut starts = vec![0];
        for &node in &saved.nodes {
            let node = node as usize;
            starts.push(starts[starts.len() - 1] + matrix.starts[node + 1] - matrix.starts[node]);
        }
        let slaves = Slaves { matrix, saved, starts, active };
        let has_contact: Vec<bool> =
            (0..saved.nodes.len()).map(|k| slaves.own(k) != Matrix3::zeros()).collect();
        let place = |node: usize| saved.nodes.binary_search(&(node as u32)).ok().filter(|&k| has_contact[k]);
        let made: Vec<_> = (0..saved.nodes.len())
            .into_par_iter()
            .filter(|&k| has_contact[k])
            .filter_map(|k| slaves.row(k, |node| place(node).is_some()))
            .collect();
        if made.is_empty() {
            return None;
        }
        let mut rows = made.iter().peekable();
        let row = |node: usize| {
            let mut own = vec![(node as u32, identity())];
            if let Some((_, _, masters)) = rows.next_if(|(slave, _, _)| *slave == node) {
                own.extend_from_slice(masters);
                own.sort_unstable_by_key(|&(column, _)| column);
            }
            own
        };
        let forward = Sparse::from_rows(matrix.height(), (0..matrix.height()).map(row));
        let backward = forward.view().transposed();
        let soft = made.into_iter().map(|(slave, soft, _)| (slave, soft)).collect();
        Some(Self { forward, backward, soft })
    }

    /// The diagonal blocks of Tᵀ K T.
    pub fn diagonal(&self, matrix: View<'_, 3, 3>) -> Vec<Block<3, 3>> {
        let columns = self.backward.view();
        let of = |block: &Block<3, 3>| Matrix3::from_fn(|i, j| block[i][j]);
        let diagonal = |node: usize| {
            let mut sum = Matrix3::zeros();
            for (a, left) in columns.row(node) {
                for (b, right) in columns.row(node) {
                    if let Some(block) = matrix.block(a, b) {
                        sum += of(left) * of(block) * of(right).transpose();
                    }
                }
            }
            block_of(&sum)
        };
        (0..matrix.height()).into_par_iter().map(diagonal).collect()
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        self.forward.bytes() + self.backward.bytes()
    }
}

struct Slaves<'a> {
    matrix: View<'a, 3, 3>,
    saved: &'a SavedRows,
    /// Where the blocks of each row begin.
    starts: Vec<usize>,
    active: &'a [[bool; 3]],
}

impl Slaves<'_> {
    /// The contact's part of the blocks of a row, without axes that are no unknowns.
    fn contact(&self, k: usize) -> impl Iterator<Item = (usize, Matrix3<f64>)> {
        let slave = self.saved.nodes[k] as usize;
        let before = &self.saved.blocks[self.starts[k]..self.starts[k + 1]];
        self.matrix.row(slave).zip(before).map(move |((node, after), before)| {
            let is_free = |i: usize, j: usize| self.active[slave][i] && self.active[node][j];
            let entry = |i, j| if is_free(i, j) { after[i][j] - before[i][j] } else { 0.0 };
            (node, Matrix3::from_fn(entry))
        })
    }

    /// C_ss
    fn own(&self, k: usize) -> Matrix3<f64> {
        let slave = self.saved.nodes[k] as usize;
        self.contact(k).find(|&(node, _)| node == slave).map_or_else(Matrix3::zeros, |(_, block)| block)
    }

    /// A slave, I − Q Qᵀ, and its −H; `None` if no direction is stiff. Other slaves count as moving along, as those of one face do.
    #[allow(clippy::type_complexity)]
    fn row(
        &self,
        k: usize,
        is_slave: impl Fn(usize) -> bool,
    ) -> Option<(usize, Block<3, 3>, Vec<(u32, Block<3, 3>)>)> {
        let slave = self.saved.nodes[k] as usize;
        let mut own = Matrix3::zeros();
        let mut masters = Vec::new();
        for (node, block) in self.contact(k) {
            if node == slave || is_slave(node) {
                own += block;
            } else if block != Matrix3::zeros() {
                masters.push((node as u32, block));
            }
        }
        let elastic: f64 = {
            let place = self.matrix.row(slave).position(|(node, _)| node == slave)?;
            let before = self.saved.blocks[self.starts[k] + place];
            (0..3).map(|i| before[i][i].abs()).sum::<f64>() / 3.0
        };
        let eigen = SymmetricEigen::new(0.5 * (own + own.transpose()));
        let (mut inverse, mut soft) = (Matrix3::zeros(), Matrix3::identity());
        for direction in 0..3 {
            let stiffness = eigen.eigenvalues[direction];
            if stiffness > STIFF * elastic {
                let q: Vector3<f64> = eigen.eigenvectors.column(direction).into();
                inverse += q * q.transpose() / stiffness;
                soft -= q * q.transpose();
            }
        }
        if inverse == Matrix3::zeros() || !inverse.iter().all(|x| x.is_finite()) {
            return None;
        }
        let follow = |(node, block): &(u32, Matrix3<f64>)| (*node, block_of(&(-inverse * block)));
        Some((slave, block_of(&soft), masters.iter().map(follow).collect()))
    }
}

fn block_of(matrix: &Matrix3<f64>) -> Block<3, 3> {
    std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]))
}

fn identity() -> Block<3, 3> {
    std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))))
}
