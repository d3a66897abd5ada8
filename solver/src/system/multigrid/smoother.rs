//! Chebyshev's polynomial in D⁻¹ K, D the diagonal blocks: symmetric if K is, and it needs nothing but products.

use nalgebra::{DMatrix, SymmetricEigen};
use rayon::prelude::*;

use super::sparse::{Block, CHUNK, add_product, add_scaled, norm};

/// Degree of the polynomial: a product for each.
const DEGREE: usize = 2;
/// Steps that estimate the largest eigenvalue.
const POWER_STEPS: usize = 15;
/// How far beyond the estimate the polynomial reaches.
const SAFETY: f64 = 1.15;
/// Largest over smallest eigenvalue of what is smoothed; the rest is the coarse level's.
const RANGE: f64 = 10.0;

/// y = K x in the unknowns of a level.
pub trait Operator<const N: usize>: Sync {
    /// y = K x; what is no unknown is 0 in both.
    fn apply(&self, x: &[[f64; N]], y: &mut [[f64; N]]);
}

/// The smoother of a level.
#[derive(Clone, Debug)]
pub struct Smoother<const N: usize> {
    /// D⁻¹
    inverse: Vec<Block<N, N>>,
    /// The largest eigenvalue of D⁻¹ K, about.
    pub largest: f64,
}

impl<const N: usize> Smoother<N> {
    /// With these diagonal blocks; `active`: what is an unknown.
    pub fn new(diagonal: &[Block<N, N>], active: &[[bool; N]], operator: &impl Operator<N>) -> Self {
        let inverse: Vec<_> =
            diagonal.par_iter().zip(active).map(|(block, active)| inverse(block, active)).collect();
        let mut smoother = Self { inverse, largest: 1.0 };
        smoother.largest = smoother.largest_eigenvalue(active, operator);
        smoother
    }

    fn largest_eigenvalue(&self, active: &[[bool; N]], operator: &impl Operator<N>) -> f64 {
        let start = |node: usize| {
            std::array::from_fn(
                |i| if active[node][i] { crate::system::irregular(node * N + i) } else { 0.0 },
            )
        };
        let mut x: Vec<[f64; N]> = (0..active.len()).map(start).collect();
        let mut product = vec![[0.0; N]; x.len()];
        let mut largest = 1.0;
        for _ in 0..POWER_STEPS {
            let size = norm(&x);
            if !(size > 0.0 && size.is_finite()) {
                return 1.0;
            }
            x.as_flattened_mut().iter_mut().for_each(|x| *x /= size);
            operator.apply(&x, &mut product);
            self.divide(&product, &mut x);
            largest = norm(&x);
        }
        if largest > 0.0 && largest.is_finite() { largest } else { 1.0 }
    }

    /// y = D⁻¹ x
    pub fn divide(&self, x: &[[f64; N]], y: &mut [[f64; N]]) {
        y.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, y)| {
            for (k, y) in y.iter_mut().enumerate() {
                let node = chunk * CHUNK + k;
                *y = [0.0; N];
                add_product(y, &self.inverse[node], &x[node]);
            }
        });
    }

    /// D⁻¹ of a node.
    pub fn inverse(&self, node: usize) -> &Block<N, N> {
        &self.inverse[node]
    }

    /// x ← x + p(D⁻¹ K) D⁻¹ r, and r ← r − K Δx.
    pub fn smooth(&self, operator: &impl Operator<N>, x: &mut [[f64; N]], r: &mut [[f64; N]]) {
        let upper = SAFETY * self.largest;
        let lower = upper / RANGE;
        let (middle, half) = (0.5 * (upper + lower), 0.5 * (upper - lower));
        let sigma = middle / half;
        let mut rho = 1.0 / sigma;
        let mut step = vec![[0.0; N]; x.len()];
        let mut product = vec![[0.0; N]; x.len()];
        self.divide(r, &mut step);
        step.as_flattened_mut().iter_mut().for_each(|step| *step /= middle);
        for k in 0..DEGREE {
            add_scaled(x, 1.0, &step);
            operator.apply(&step, &mut product);
            add_scaled(r, -1.0, &product);
            if k + 1 < DEGREE {
                let next = 1.0 / (2.0 * sigma - rho);
                self.divide(r, &mut product);
                let (old, new) = (next * rho, 2.0 * next / half);
                step.par_chunks_mut(CHUNK).zip(product.par_chunks(CHUNK)).for_each(|(step, product)| {
                    let entries = step.as_flattened_mut().iter_mut().zip(product.as_flattened());
                    entries.for_each(|(step, product)| *step = old * *step + new * product);
                });
                rho = next;
            }
        }
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        self.inverse.len() * size_of::<Block<N, N>>()
    }
}

/// The inverse of the symmetric part among the unknowns, 0 elsewhere; of a block that is not definite that of its moduli.
fn inverse<const N: usize>(block: &Block<N, N>, active: &[bool; N]) -> Block<N, N> {
    let symmetric = |i: usize, j: usize| match (active[i], active[j]) {
        (true, true) => 0.5 * (block[i][j] + block[j][i]),
        _ if i == j => 1.0,
        _ => 0.0,
    };
    let matrix = DMatrix::from_fn(N, N, symmetric);
    let inverse = match matrix.clone().cholesky() {
        Some(cholesky) => cholesky.inverse(),
        None => {
            let eigen = SymmetricEigen::new(matrix);
            let largest = eigen.eigenvalues.amax();
            let moduli = eigen.eigenvalues.map(|value| {
                let modulus = value.abs();
                if modulus > 1e-10 * largest { 1.0 / modulus } else { 0.0 }
            });
            &eigen.eigenvectors * DMatrix::from_diagonal(&moduli) * eigen.eigenvectors.transpose()
        }
    };
    std::array::from_fn(|i| {
        std::array::from_fn(|j| if active[i] && active[j] { inverse[(i, j)] } else { 0.0 })
    })
}
