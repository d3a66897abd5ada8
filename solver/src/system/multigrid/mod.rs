//! Smoothed aggregation: a preconditioner for stiffnesses of solids in contact.
//!
//! Nodes of a body are grouped into aggregates whose rigid motions are the unknowns of a coarser level, smoothed by one step of
//! D⁻¹ K, and so on until a level is small enough for a direct solution (P. Vaněk, M. Brezina and J. Mandel, Numerische Mathematik 88,
//! 2001, 559–579). Contact may be as stiff as the bodies a few times over: what is stiffer is the matter of [`StiffContact`](super::stiff). Nothing of it outlives a matrix, and every sum has one
//! order: the same matrix leads to the same bits, whatever was solved before and with any number of threads.

mod aggregates;
mod bottom;
mod level;
mod smoother;
mod sparse;

pub(super) use bottom::Bottom;
pub(super) use sparse::{Block, Sparse, View, add_product, add_scaled, dot, norm, scale_and_add};

use aggregates::Links;
use level::{Coarse, Level, LevelOperator, MODES};

use super::contact_rows::SavedRows;
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
    /// Rows of the nodes that contact couples before it was added.
    pub before: &'a SavedRows,
}

/// Levels from the finest one down.
pub struct Multigrid {
    fine: Level<3>,
    coarse: Vec<(Sparse<MODES, MODES>, Level<MODES>)>,
    bottom: Bottom<MODES>,
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
        let active = equations.free();
        let operator = LevelOperator { matrix: matrix.view(), active: &active };
        let (starts, columns) = geometry.links.rows();
        let (diagonal, modes) = (diagonal(operator.matrix), rigid_motions(geometry.positions));
        let scale: Vec<[f64; 3]> =
            diagonal.iter().map(|block| [0, 1, 2].map(|axis| block[axis][axis].abs())).collect();
        let (fine, mut next) = Level::new(&operator, &diagonal, &scale, Links { starts, columns }, &modes);
        let mut coarse = Vec::new();
        while next.active.len() > BOTTOM {
            let Coarse { matrix, modes, active, scale, links } = next;
            let operator = LevelOperator { matrix: matrix.view(), active: &active };
            let (level, coarser) =
                Level::new(&operator, &self::diagonal(matrix.view()), &scale, links.view(), &modes);
            if coarser.active.len() as f64 > WORTHWHILE * active.len() as f64 {
                next = Coarse { matrix, modes, active, scale, links };
                break;
            }
            coarse.push((matrix, level));
            next = coarser;
        }
        let bottom = Bottom::new(&next.matrix, (&next.active, Some(&next.scale)), symmetry, equations.len())?;
        Ok(Self { fine, coarse, bottom })
    }

    /// About K⁻¹ r, 0 where prescribed.
    ///
    /// # Errors
    /// No memory.
    pub fn apply(&mut self, matrix: &BlockMatrix, right: &[[f64; 3]]) -> Result<Vec<[f64; 3]>, SystemError> {
        let Self { fine, coarse, bottom } = self;
        let operator = LevelOperator { matrix: matrix.view(), active: &fine.active };
        fine.cycle(&operator, right, |right| descend(coarse, bottom, right))
    }

    /// Number of levels, the coarsest among them.
    pub fn levels(&self) -> usize {
        self.coarse.len() + 2
    }

    /// Memory without the coarsest level's, bytes.
    pub fn bytes(&self) -> usize {
        let coarse: usize = self.coarse.iter().map(|(matrix, level)| matrix.bytes() + level.bytes()).sum();
        self.fine.bytes() + coarse
    }
}

fn descend(
    levels: &[(Sparse<MODES, MODES>, Level<MODES>)],
    bottom: &mut Bottom<MODES>,
    right: &[[f64; MODES]],
) -> Result<Vec<[f64; MODES]>, SystemError> {
    let Some(((matrix, level), coarser)) = levels.split_first() else { return bottom.solve(right) };
    let operator = LevelOperator { matrix: matrix.view(), active: &level.active };
    level.cycle(&operator, right, |right| descend(coarser, bottom, right))
}

fn diagonal<const N: usize>(matrix: View<'_, N, N>) -> Vec<Block<N, N>> {
    (0..matrix.height()).map(|node| matrix.block(node, node).copied().unwrap_or([[0.0; N]; N])).collect()
}

/// Three translations and three rotations about the middle of everything, by node, as displacements per unit.
fn rigid_motions(positions: &[[f64; 3]]) -> Vec<Block<3, MODES>> {
    let count = positions.len().max(1) as f64;
    let middle = [0, 1, 2].map(|i| positions.iter().map(|position| position[i]).sum::<f64>() / count);
    let of_node = |position: &[f64; 3]| {
        let [x, y, z] = [0, 1, 2].map(|i| position[i] - middle[i]);
        [[1.0, 0.0, 0.0, 0.0, z, -y], [0.0, 1.0, 0.0, -z, 0.0, x], [0.0, 0.0, 1.0, y, -x, 0.0]]
    };
    positions.iter().map(of_node).collect()
}
