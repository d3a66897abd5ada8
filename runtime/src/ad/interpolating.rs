//! The fit with an interpolating weight w = ω/(1 − ω) (Chamoret et al. 2008, eq. 16), over any kind of number.
//!
//! w is infinite where the slave stands straight above a node. With the origin of the basis at the nearest node k, w_k
//! enters the system in one entry only, A₀₀ = S₀ + w_k with S₀ = Σ_{i≠k} w_i. Eliminating α₀ leaves expressions in
//! ε = 1/w_k = (1 − ω)/ω, which is smooth, and a system for the other coefficients that is regular at ε = 0.

use super::foot::{Polynomial, basis_functions};
use super::linear::{Coefficients, Matrix, Scalar, solve_cholesky};
use super::{RadialWeight, WeightFunction};
use crate::{Basis, ElementError};

/// The coefficients about the slave of a fit to `offsets` (a, b, z) from the slave; `squares`: r² of each node.
pub(super) fn fit<D: Scalar, W: RadialWeight>(
    weight: &WeightFunction<'_, W>,
    basis: Basis,
    offsets: &[[D; 3]],
    squares: &[D],
) -> Result<Polynomial<D>, ElementError> {
    let nearest = (0..offsets.len()).min_by(|&i, &j| squares[i].re().total_cmp(&squares[j].re()));
    let Some(pole) = nearest else {
        return Err(ElementError::TooFewNodes { found: 0, needed: basis.size() });
    };
    let [a_k, b_k, z_k] = offsets[pole];
    super::finite("offset", [a_k.re(), b_k.re(), z_k.re()])?;
    let s_k = squares[pole];
    if s_k.re() >= 1.0 {
        return Err(ElementError::SingularFit { pivot_ratio: 0.0, tolerance: 0.0 });
    }
    let epsilon = weight.complement_at_square(s_k) / weight.at_square(s_k);

    let others = basis.size() - 1;
    let Sums { s_0, s_z, s_p, mut s_pz, mut s_pp } = Sums::without(pole, weight, basis, offsets, squares)?;
    let share = (epsilon * s_0 + 1.0).recip();
    let (matrix_factor, mean) = (epsilon * share, (z_k + epsilon * s_z) * share);
    let diagonals = std::array::from_fn(|k| s_pp[k][k].re());
    for k in 0..others {
        s_pz[k] -= s_p[k] * mean;
        for l in 0..=k {
            s_pp[k][l] -= s_p[k] * s_p[l] * matrix_factor;
        }
    }
    let alpha = solve_cholesky(&basis.monomials()[1..], diagonals, s_pp, s_pz)?;
    super::finite("coefficient", alpha.map(|x| x.re()))?;
    let products = (0..others).map(|k| s_p[k] * alpha[k]);
    let constant = mean - matrix_factor * products.fold(D::zero(), |sum, x| sum + x);

    let about_pole = std::iter::once(constant).chain(alpha);
    Ok(Polynomial { basis, coefficients: about_slave(basis, about_pole, [a_k, b_k]) })
}

/// The sums over all nodes but the pole; with p = (a, b, a², ab, b²) about the pole.
struct Sums<D> {
    /// S₀
    s_0: D,
    /// Σ w z
    s_z: D,
    /// Σ w p
    s_p: Coefficients<D>,
    /// Σ w p z
    s_pz: Coefficients<D>,
    /// Σ w p pᵀ
    s_pp: Matrix<D>,
}

impl<D: Scalar> Sums<D> {
    fn without<W: RadialWeight>(
        pole: usize,
        weight: &WeightFunction<'_, W>,
        basis: Basis,
        offsets: &[[D; 3]],
        squares: &[D],
    ) -> Result<Self, ElementError> {
        let (zero, zeros) = (D::zero(), [D::zero(); Basis::MOST_COEFFICIENTS]);
        let s_pp = [zeros; Basis::MOST_COEFFICIENTS];
        let mut sums = Self { s_0: zero, s_z: zero, s_p: zeros, s_pz: zeros, s_pp };
        let [a_k, b_k, _] = offsets[pole];
        for (i, &offset) in offsets.iter().enumerate().filter(|&(i, _)| i != pole) {
            let [a, b, z] = offset;
            super::finite("offset", [a.re(), b.re(), z.re()])?;
            let s = squares[i];
            if s.re() >= 1.0 {
                continue;
            }
            let w = weight.at_square(s) / weight.complement_at_square(s);
            super::finite("weight", [w.re()])?;
            let p = &basis_functions(basis, [a - a_k, b - b_k])[1..];
            sums.s_0 += w;
            sums.s_z += w * z;
            for k in 0..basis.size() - 1 {
                let weighted = w * p[k];
                sums.s_p[k] += weighted;
                sums.s_pz[k] += weighted * z;
                for l in 0..=k {
                    sums.s_pp[k][l] += weighted * p[l];
                }
            }
        }
        Ok(sums)
    }
}

/// From the pole to the slave: f = Σ c_mn (a − a_k)ᵐ (b − b_k)ⁿ, expanded about (0, 0).
fn about_slave<D: Scalar>(
    basis: Basis,
    about_pole: impl Iterator<Item = D> + Clone,
    [a_k, b_k]: [D; 2],
) -> Coefficients<D> {
    let mut coefficients = [D::zero(); Basis::MOST_COEFFICIENTS];
    for (k, &(i, j)) in basis.monomials().iter().enumerate() {
        let terms = about_pole.clone().zip(basis.monomials());
        for (c, &(m, n)) in terms.filter(|(_, (m, n))| *m >= i && *n >= j) {
            let choices = binomial(m, i) * binomial(n, j);
            coefficients[k] += c * (-a_k).powi(i32::from(m - i)) * (-b_k).powi(i32::from(n - j)) * choices;
        }
    }
    coefficients
}

fn binomial(n: u8, k: u8) -> f64 {
    (0..k).map(|i| f64::from(n - i) / f64::from(i + 1)).product()
}
