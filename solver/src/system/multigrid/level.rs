//! One level of the hierarchy: its smoother and its way to the next one.

use rayon::prelude::*;

use super::aggregates::{Aggregates, Links, NONE, OwnLinks};
use super::smoother::{Operator, Smoother};
use super::sparse::{Block, CHUNK, Sparse, View, add_scaled};
use crate::system::SystemError;

/// Rigid motions of a body: unknowns of a coarse node.
pub const MODES: usize = 6;
/// The first of them are translations.
const TRANSLATIONS: usize = 3;
/// A motion that keeps less than this part of itself beside the ones before it is none of its own. Of rotations that is what they are
/// beside the translations: their centre may be far away.
const DEPENDENT: f64 = 1e-3;
/// The same for all of a motion: less is rounding.
const ROUNDING: f64 = 1e-9;
/// How far the prolongation is smoothed, over the largest eigenvalue.
const DAMPING: f64 = 4.0 / 3.0;

/// The matrix of a level.
pub struct LevelOperator<'a, const N: usize> {
    /// K
    pub matrix: View<'a, N, N>,
    /// What is an unknown.
    pub active: &'a [[bool; N]],
}

impl<const N: usize> Operator<N> for LevelOperator<'_, N> {
    fn apply(&self, x: &[[f64; N]], y: &mut [[f64; N]]) {
        self.matrix.multiply(x, y);
        clear_inactive(self.active, y);
    }
}

/// Sets to 0 what is no unknown.
fn clear_inactive<const N: usize>(active: &[[bool; N]], x: &mut [[f64; N]]) {
    x.par_chunks_mut(CHUNK).zip(active.par_chunks(CHUNK)).for_each(|(x, active)| {
        let entries = x.as_flattened_mut().iter_mut().zip(active.as_flattened());
        entries.for_each(|(x, active)| *x = if *active { *x } else { 0.0 });
    });
}

/// A level that has a coarser one.
#[derive(Clone, Debug)]
pub struct Level<const N: usize> {
    /// What is an unknown.
    pub active: Vec<[bool; N]>,
    smoother: Smoother<N>,
    /// From coarse unknowns to those of this level.
    prolongation: Sparse<N, MODES>,
    restriction: Sparse<MODES, N>,
}

/// What the next level is made of.
pub struct Coarse {
    /// Pᵀ K P
    pub matrix: Sparse<MODES, MODES>,
    /// Rigid motions in its unknowns.
    pub modes: Vec<Block<MODES, MODES>>,
    /// What is an unknown: motions that an aggregate does not have are not.
    pub active: Vec<[bool; MODES]>,
    /// What rounding of its matrix is measured by: the diagonal of the finest matrix, taken down by the squares of P.
    pub scale: Vec<[f64; MODES]>,
    /// Which of its nodes are neighbours.
    pub links: OwnLinks,
}

impl<const N: usize> Level<N> {
    /// Aggregates the nodes and smooths their `modes`, rigid motions by node in the unknowns of this level. `diagonal`: the matrix's blocks.
    /// `scale`: as [`Coarse`] has it.
    pub fn new(
        operator: &LevelOperator<'_, N>,
        diagonal: &[Block<N, N>],
        scale: &[[f64; N]],
        links: Links<'_>,
        modes: &[Block<N, MODES>],
    ) -> (Self, Coarse) {
        let active = operator.active;
        let smoother = Smoother::new(diagonal, active, operator);
        let has_unknowns: Vec<bool> = active.iter().map(|axes| axes.contains(&true)).collect();
        let aggregates = Aggregates::new(operator.matrix, links, &has_unknowns);
        let (tentative, coarse_modes, coarse_active) = tentative(&aggregates, active, modes);
        let prolongation = smoothed(operator, &smoother, tentative);
        let product = operator.matrix.product(prolongation.view());
        let restriction = prolongation.view().transposed();
        let matrix = restriction.view().product(product.view());
        drop(product);
        let coarse = Coarse {
            matrix,
            modes: coarse_modes,
            active: coarse_active,
            scale: taken_down(&prolongation, scale),
            links: links.of(&aggregates),
        };
        (Self { active: active.to_vec(), smoother, prolongation, restriction }, coarse)
    }

    /// One V: smoothed, corrected by `solve` on the coarser level, smoothed.
    ///
    /// # Errors
    /// Those of `solve`.
    pub fn cycle(
        &self,
        operator: &LevelOperator<'_, N>,
        right: &[[f64; N]],
        solve: impl FnOnce(&[[f64; MODES]]) -> Result<Vec<[f64; MODES]>, SystemError>,
    ) -> Result<Vec<[f64; N]>, SystemError> {
        let mut x = vec![[0.0; N]; right.len()];
        let mut residual = right.to_vec();
        self.smoother.smooth(operator, &mut x, &mut residual);
        let mut coarse = vec![[0.0; MODES]; self.prolongation.width];
        self.restriction.view().multiply(&residual, &mut coarse);
        let correction = solve(&coarse)?;
        let mut step = vec![[0.0; N]; right.len()];
        self.prolongation.view().multiply(&correction, &mut step);
        add_scaled(&mut x, 1.0, &step);
        let mut product = vec![[0.0; N]; right.len()];
        operator.apply(&step, &mut product);
        add_scaled(&mut residual, -1.0, &product);
        self.smoother.smooth(operator, &mut x, &mut residual);
        Ok(x)
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        self.smoother.bytes() + self.prolongation.bytes() + self.restriction.bytes() + self.active.len() * N
    }
}

/// Pᵀ D P on its diagonal.
fn taken_down<const N: usize>(prolongation: &Sparse<N, MODES>, scale: &[[f64; N]]) -> Vec<[f64; MODES]> {
    let mut coarse = vec![[0.0; MODES]; prolongation.width];
    for (node, scale) in scale.iter().enumerate() {
        for (other, block) in prolongation.view().row(node) {
            for (row, scale) in block.iter().zip(scale) {
                coarse[other].iter_mut().zip(row).for_each(|(sum, p)| *sum += p * p * scale);
            }
        }
    }
    coarse
}

/// The modes over each aggregate, made orthogonal among its unknowns: the prolongation before it is smoothed, the modes in coarse
/// unknowns, and which of those there are.
#[allow(clippy::type_complexity)]
fn tentative<const N: usize>(
    aggregates: &Aggregates,
    active: &[[bool; N]],
    modes: &[Block<N, MODES>],
) -> (Sparse<N, MODES>, Vec<Block<MODES, MODES>>, Vec<[bool; MODES]>) {
    let mut members = vec![Vec::new(); aggregates.count];
    for (node, &aggregate) in aggregates.of.iter().enumerate() {
        if aggregate != NONE {
            members[aggregate as usize].push(node);
        }
    }
    let of_aggregate = |nodes: &Vec<usize>| {
        let rows = nodes.iter().flat_map(|&node| (0..N).map(move |i| (node, i)));
        let mut basis: Vec<[f64; MODES]> =
            rows.map(|(node, i)| if active[node][i] { modes[node][i] } else { [0.0; MODES] }).collect();
        let (coarse, is_own) = orthogonalise(&mut basis);
        (basis, coarse, is_own)
    };
    let made: Vec<_> = members.par_iter().map(of_aggregate).collect();
    let mut place = vec![0; aggregates.of.len()];
    for nodes in &members {
        nodes.iter().enumerate().for_each(|(k, &node)| place[node] = k);
    }
    let row = |node: usize| match aggregates.of[node] {
        NONE => Vec::new(),
        aggregate => {
            let basis = &made[aggregate as usize].0[N * place[node]..];
            vec![(aggregate, std::array::from_fn(|i| basis[i]))]
        }
    };
    let prolongation = Sparse::from_rows(aggregates.count, (0..aggregates.of.len()).map(row));
    let coarse = made.iter().map(|(_, coarse, _)| *coarse).collect();
    let is_own = made.iter().map(|(_, _, is_own)| *is_own).collect();
    (prolongation, coarse, is_own)
}

/// Gram and Schmidt, each column against those before it: B = Q R with R upper triangular; a column that depends on those before it
/// becomes 0. Returns R and which columns are left.
fn orthogonalise(basis: &mut [[f64; MODES]]) -> (Block<MODES, MODES>, [bool; MODES]) {
    let mut factors = [[0.0; MODES]; MODES];
    let mut is_own = [false; MODES];
    for column in 0..MODES {
        let product = |basis: &[[f64; MODES]], a: usize, b: usize| -> f64 {
            basis.iter().map(|row| row[a] * row[b]).sum()
        };
        let size = |basis: &[[f64; MODES]]| product(basis, column, column).sqrt();
        let whole = size(basis);
        let mut beside = whole;
        // Twice is enough.
        for round in 0..2 {
            for earlier in (0..column).filter(|&earlier| is_own[earlier]) {
                if round == 0 && earlier == TRANSLATIONS {
                    beside = size(basis);
                }
                let part = product(basis, earlier, column);
                factors[earlier][column] += part;
                basis.iter_mut().for_each(|row| row[column] -= part * row[earlier]);
            }
            if round == 0 && column == TRANSLATIONS {
                beside = size(basis);
            }
        }
        let after = size(basis);
        is_own[column] = after > DEPENDENT * beside && after > ROUNDING * whole;
        let factor = if is_own[column] { 1.0 / after } else { 0.0 };
        factors[column][column] = if is_own[column] { after } else { 0.0 };
        basis.iter_mut().for_each(|row| row[column] *= factor);
    }
    (factors, is_own)
}

/// P₀ − ω D⁻¹ K P₀
fn smoothed<const N: usize>(
    operator: &LevelOperator<'_, N>,
    smoother: &Smoother<N>,
    tentative: Sparse<N, MODES>,
) -> Sparse<N, MODES> {
    let mut smoothed = operator.matrix.product(tentative.view());
    let damping = DAMPING / smoother.largest;
    for node in 0..tentative.starts.len() - 1 {
        let inverse = smoother.inverse(node);
        let of_node = tentative.view().row(node).next();
        for place in smoothed.starts[node]..smoothed.starts[node + 1] {
            let product = smoothed.blocks[place];
            let mut block = [[0.0; MODES]; N];
            if let Some((aggregate, own)) = of_node
                && smoothed.columns[place] as usize == aggregate
            {
                block = *own;
            }
            for i in 0..N {
                for k in 0..N {
                    for j in 0..MODES {
                        block[i][j] -= damping * inverse[i][k] * product[k][j];
                    }
                }
            }
            smoothed.blocks[place] = block;
        }
    }
    smoothed
}
