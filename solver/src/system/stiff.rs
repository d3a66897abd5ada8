//! Stiff contact taken out of what multigrid has to solve.
//!
//! Where nodes are slaves and masters of stiff contacts, no smoother and no coarse level reaches the motions that contact couples. So
//! they are solved for exactly, and the rest sees a soft contact. Let Q be the directions of the nodes that contact stiffens, and
//! K̃ = Qᵀ K Q, which has factors: a surface's unknowns, few beside those of the bodies. With a preconditioner B of the matrix K_s, in which
//! contact is as stiff as the body at most some times over,
//!
//! ```text
//! M⁻¹ = Q K̃⁻¹ Qᵀ + Π B Πᵀ        Π = 1 − Q K̃⁻¹ Qᵀ K
//! ```
//!
//! is the factorisation in blocks of K among Q and the rest, with the Schur complement of K_s in the place of that of K. In a Schur complement
//! contact stands in series with the elements beside it: once it is stiffer than they are, how much stiffer makes no difference. (Balancing
//! of a coarse space, J. Mandel, Communications in Numerical Methods in Engineering 9, 1993, 233–241, with the stiff directions as the space.)

use rayon::prelude::*;

use super::contact_rows::ContactRows;
use super::multigrid::{Block, Bottom, Sparse, add_scaled};
use super::{BlockMatrix, Equations, Symmetry, SystemError};

/// A direction is stiff if contact adds at least this part of the stiffness that the node has without.
const STIFF: f64 = 0.1;
/// Contact is softened to this many times the stiffness of the nodes without it.
const LIMIT: f64 = 3.0;

/// The stiff directions with the factors of what they couple.
pub struct StiffContact {
    /// Q, by nodes and stiff nodes.
    basis: Sparse<3, 3>,
    /// Qᵀ
    restriction: Sparse<3, 3>,
    /// K Q
    forward: Sparse<3, 3>,
    /// Qᵀ K
    backward: Sparse<3, 3>,
    factors: Bottom<3>,
}

/// How far contact is softened at each saved row: by a factor for all nodes that contact couples. `None` if it is soft as it is.
pub fn softening(rows: &ContactRows<'_>) -> Option<Vec<f64>> {
    let ratio = |k: usize| {
        let elastic = rows.elastic(k);
        if elastic > 0.0 { rows.principal(k).eigenvalues.amax() / elastic } else { 0.0 }
    };
    let ratios: Vec<f64> = (0..rows.len()).into_par_iter().map(ratio).collect();
    let groups = coupled(rows);
    let mut of_group: Vec<Vec<f64>> = vec![Vec::new(); rows.len()];
    for (&group, &ratio) in groups.iter().zip(&ratios) {
        if ratio > STIFF && ratio.is_finite() {
            of_group[group].push(ratio);
        }
    }
    let factor = |ratios: &mut Vec<f64>| {
        ratios.sort_unstable_by(f64::total_cmp);
        ratios.get(ratios.len() / 2).map_or(1.0, |middle| (LIMIT / middle).min(1.0))
    };
    let factors: Vec<f64> = of_group.iter_mut().map(factor).collect();
    let softened = groups.iter().map(|&group| factors[group]).collect::<Vec<_>>();
    softened.iter().any(|&factor| factor < 1.0).then_some(softened)
}

/// A number for each saved row, the same for rows that contact couples.
fn coupled(rows: &ContactRows<'_>) -> Vec<usize> {
    let mut parents: Vec<usize> = (0..rows.len()).collect();
    for k in 0..rows.len() {
        let others = rows.row(k).filter(|(_, block)| block.iter().any(|&x| x != 0.0));
        for other in others.filter_map(|(node, _)| rows.place(node)) {
            let (a, b) = (root(&mut parents, k), root(&mut parents, other));
            parents[a.max(b)] = a.min(b);
        }
    }
    (0..rows.len()).map(|k| root(&mut parents, k)).collect()
}

/// The first of those that `k` belongs to; the way there gets shorter.
fn root(parents: &mut [usize], mut k: usize) -> usize {
    while parents[k] != k {
        parents[k] = parents[parents[k]];
        k = parents[k];
    }
    k
}

/// The matrix with softened contact.
pub fn softened(matrix: &BlockMatrix, rows: &ContactRows<'_>, factors: &[f64]) -> BlockMatrix {
    let mut soft = matrix.clone();
    for (k, &factor) in factors.iter().enumerate().filter(|&(_, &factor)| factor < 1.0) {
        let own = soft.row_mut(rows.node(k)).iter_mut().zip(rows.without(k));
        for (after, before) in own {
            for (after, before) in after.as_flattened_mut().iter_mut().zip(before.as_flattened()) {
                *after = before + factor * (*after - before);
            }
        }
    }
    soft
}

impl StiffContact {
    /// Of the rows whose contact is softened.
    ///
    /// # Errors
    /// Stiff directions that are singular; factors that do not fit into memory.
    pub fn new(
        rows: &ContactRows<'_>,
        factors: &[f64],
        symmetry: Symmetry,
        equations: &Equations,
    ) -> Result<Self, SystemError> {
        let stiff_directions = |k: usize| {
            let (principal, elastic) = (rows.principal(k), rows.elastic(k));
            let is_stiff = [0, 1, 2].map(|axis| principal.eigenvalues[axis].abs() > STIFF * elastic);
            let entry = |i: usize, j: usize| if is_stiff[j] { principal.eigenvectors[(i, j)] } else { 0.0 };
            let block: Block<3, 3> = [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j)));
            (rows.node(k), block, is_stiff)
        };
        let stiff: Vec<_> = (0..rows.len())
            .into_par_iter()
            .filter(|&k| factors[k] < 1.0)
            .map(stiff_directions)
            .filter(|(_, _, is_stiff)| is_stiff.contains(&true))
            .collect();
        let mut next = stiff.iter().enumerate().peekable();
        let row = |node: usize| match next.next_if(|(_, stiff)| stiff.0 == node) {
            Some((k, (_, block, _))) => vec![(k as u32, *block)],
            None => Vec::new(),
        };
        let basis = Sparse::from_rows(stiff.len(), (0..rows.matrix.height()).map(row));
        let restriction = basis.view().transposed();
        let backward = restriction.view().product(rows.matrix);
        let forward = match symmetry {
            Symmetry::Symmetric => backward.view().transposed(),
            Symmetry::General => rows.matrix.product(basis.view()),
        };
        let own = backward.view().product(basis.view());
        let active: Vec<[bool; 3]> = stiff.iter().map(|(_, _, is_stiff)| *is_stiff).collect();
        let factors = Bottom::new(&own, (&active, None), symmetry, equations.len())?;
        Ok(Self { basis, restriction, forward, backward, factors })
    }

    /// About K⁻¹ r, with `rest` for what is not stiff.
    ///
    /// # Errors
    /// Those of `rest`; no memory.
    pub fn apply(
        &mut self,
        equations: &Equations,
        right: &[[f64; 3]],
        rest: impl FnOnce(&[[f64; 3]]) -> Result<Vec<[f64; 3]>, SystemError>,
    ) -> Result<Vec<[f64; 3]>, SystemError> {
        let (own, left) = self.take_up(equations, right)?;
        let (mut of_stiff, mut over_nodes) = (vec![[0.0; 3]; self.basis.width], vec![[0.0; 3]; right.len()]);
        let mut x = rest(&left)?;
        self.backward.view().multiply(&x, &mut of_stiff);
        let mut correction = self.factors.solve(&of_stiff)?;
        for (correction, own) in correction.as_flattened_mut().iter_mut().zip(own.as_flattened()) {
            *correction = own - *correction;
        }
        self.basis.view().multiply(&correction, &mut over_nodes);
        add_scaled(&mut x, 1.0, &over_nodes);
        Ok(x)
    }

    /// K̃⁻¹ Qᵀ r, and what is left of r, Πᵀ r.
    ///
    /// # Errors
    /// No memory.
    #[allow(clippy::type_complexity)]
    pub fn take_up(
        &mut self,
        equations: &Equations,
        right: &[[f64; 3]],
    ) -> Result<(Vec<[f64; 3]>, Vec<[f64; 3]>), SystemError> {
        let (mut of_stiff, mut over_nodes) = (vec![[0.0; 3]; self.basis.width], vec![[0.0; 3]; right.len()]);
        self.restriction.view().multiply(right, &mut of_stiff);
        let own = self.factors.solve(&of_stiff)?;
        self.forward.view().multiply(&own, &mut over_nodes);
        let mut left = right.to_vec();
        add_scaled(&mut left, -1.0, &over_nodes);
        equations.clear_prescribed(&mut left);
        Ok((own, left))
    }

    /// Memory without the factors', bytes.
    pub fn bytes(&self) -> usize {
        [&self.basis, &self.restriction, &self.forward, &self.backward].map(Sparse::bytes).iter().sum()
    }
}
