//! Smoothed aggregation: a preconditioner for stiffnesses of solids in contact.
//!
//! Nodes of a body are grouped into aggregates whose rigid motions are the unknowns of a coarser level, smoothed by one step of
//! D⁻¹ K, and so on until a level is small enough for a direct solution (P. Vaněk, M. Brezina and J. Mandel, Numerische Mathematik 88,
//! 2001, 559–579). [`change`] takes stiff contact out of the finest level first. Nothing of it outlives a matrix, and every sum has one
//! order: the same matrix leads to the same bits, whatever was solved before and with any number of threads.

mod aggregates;
mod bottom;
mod change;
mod level;
mod smoother;
mod sparse;
#[cfg(test)]
mod tests;

pub use change::SavedRows;
pub(super) use sparse::{View, add_scaled, dot, norm, scale_and_add};

use aggregates::Links;
use bottom::Bottom;
use change::Change;
use level::{Coarse, Level, LevelOperator, MODES, clear_inactive};
use sparse::{Block, Sparse};

use super::{BlockMatrix, BlockPattern, Equations, Symmetry, SystemError};

/// As many nodes are solved directly.
const BOTTOM: usize = 250;
/// A level that has more than this part of the finer one's nodes is not worth it.
const WORTHWHILE: f64 = 0.7;

/// What a preconditioner has to know beside the matrix.
#[derive(Clone, Copy, Debug)]
pub struct Geometry<'a> {
    /// Positions of the nodes, length: bodies are stress-free in their rigid motions from here.
    pub positions: &'a [[f64; 3]],
    /// Pairs of nodes that share an element.
    pub links: &'a BlockPattern,
    /// Rows of the slaves before contact was added.
    pub slaves: &'a SavedRows,
}

/// Levels from the finest one down.
pub struct Multigrid {
    change: Option<Change>,
    fine: Level<3>,
    coarse: Vec<(Sparse<MODES, MODES>, Level<MODES>)>,
    bottom: Bottom,
}

impl Multigrid {
    /// For a matrix with at least one equation.
    ///
    /// # Errors
    /// A coarsest level that is singular: a rigid motion costs nothing. One that does not fit into memory.
    pub fn new(
        matrix: &BlockMatrix,
        equations: &Equations,
        symmetry: Symmetry,
        geometry: Geometry<'_>,
    ) -> Result<Self, SystemError> {
        let view = matrix.view();
        let active = equations.free();
        let change = Change::new(view, geometry.slaves, &active);
        let diagonal = match &change {
            Some(change) => change.diagonal(view),
            None => diagonal(view),
        };
        let modes = rigid_motions(geometry.positions, change.as_ref());
        let operator = LevelOperator { matrix: view, change: views(change.as_ref()), active: &active };
        let (starts, columns) = geometry.links.rows();
        let (fine, mut next) = Level::new(&operator, &diagonal, Links { starts, columns }, &modes);
        let mut coarse = Vec::new();
        while next.active.len() > BOTTOM {
            let Coarse { matrix, modes, active, links } = next;
            let operator = LevelOperator { matrix: matrix.view(), change: None, active: &active };
            let (level, coarser) = Level::new(&operator, &diagonal_of(&matrix), links.view(), &modes);
            if coarser.active.len() as f64 > WORTHWHILE * active.len() as f64 {
                next = Coarse { matrix, modes, active, links };
                break;
            }
            coarse.push((matrix, level));
            next = coarser;
        }
        let bottom = Bottom::new(&next.matrix, &next.active, symmetry, equations.len())?;
        Ok(Self { change, fine, coarse, bottom })
    }

    /// About K⁻¹ r, 0 where prescribed.
    ///
    /// # Errors
    /// No memory.
    pub fn apply(&mut self, matrix: &BlockMatrix, right: &[[f64; 3]]) -> Result<Vec<[f64; 3]>, SystemError> {
        let Self { change, fine, coarse, bottom } = self;
        let operator =
            LevelOperator { matrix: matrix.view(), change: views(change.as_ref()), active: &fine.active };
        let own = operator.change.map(|(_, backward)| {
            let mut own = vec![[0.0; 3]; right.len()];
            backward.multiply(right, &mut own);
            clear_inactive(&fine.active, &mut own);
            own
        });
        let x =
            fine.cycle(&operator, own.as_deref().unwrap_or(right), |right| descend(coarse, bottom, right))?;
        Ok(match operator.change {
            Some((forward, _)) => {
                let mut own = vec![[0.0; 3]; x.len()];
                forward.multiply(&x, &mut own);
                own
            }
            None => x,
        })
    }

    /// Number of levels, the coarsest among them.
    #[must_use]
    pub fn levels(&self) -> usize {
        self.coarse.len() + 2
    }

    /// Memory without the coarsest level's, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let coarse: usize = self.coarse.iter().map(|(matrix, level)| matrix.bytes() + level.bytes()).sum();
        self.change.as_ref().map_or(0, Change::bytes) + self.fine.bytes() + coarse
    }
}

fn descend(
    levels: &[(Sparse<MODES, MODES>, Level<MODES>)],
    bottom: &mut Bottom,
    right: &[[f64; MODES]],
) -> Result<Vec<[f64; MODES]>, SystemError> {
    let Some(((matrix, level), coarser)) = levels.split_first() else { return bottom.solve(right) };
    let operator = LevelOperator { matrix: matrix.view(), change: None, active: &level.active };
    level.cycle(&operator, right, |right| descend(coarser, bottom, right))
}

#[allow(clippy::type_complexity)]
fn views(change: Option<&Change>) -> Option<(View<'_, 3, 3>, View<'_, 3, 3>)> {
    change.map(|change| (change.forward.view(), change.backward.view()))
}

fn diagonal<const N: usize>(matrix: View<'_, N, N>) -> Vec<Block<N, N>> {
    (0..matrix.height()).map(|node| matrix.block(node, node).copied().unwrap_or([[0.0; N]; N])).collect()
}

fn diagonal_of(matrix: &Sparse<MODES, MODES>) -> Vec<Block<MODES, MODES>> {
    diagonal(matrix.view())
}

/// Three translations and three rotations about the middle of everything, by node, as displacements per unit. Of a slave only what it
/// does itself: in stiff directions it follows its masters.
fn rigid_motions(positions: &[[f64; 3]], change: Option<&Change>) -> Vec<Block<3, MODES>> {
    let count = positions.len().max(1) as f64;
    let middle = [0, 1, 2].map(|i| positions.iter().map(|position| position[i]).sum::<f64>() / count);
    let of_node = |position: &[f64; 3]| {
        let [x, y, z] = [0, 1, 2].map(|i| position[i] - middle[i]);
        [[1.0, 0.0, 0.0, 0.0, z, -y], [0.0, 1.0, 0.0, -z, 0.0, x], [0.0, 0.0, 1.0, y, -x, 0.0]]
    };
    let mut modes: Vec<Block<3, MODES>> = positions.iter().map(of_node).collect();
    for (slave, soft) in change.iter().flat_map(|change| &change.soft) {
        let rigid = modes[*slave];
        modes[*slave] =
            [0, 1, 2].map(|i| std::array::from_fn(|j| (0..3).map(|k| soft[i][k] * rigid[k][j]).sum()));
    }
    modes
}
