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

    // S₀, Σ w z, and with p = (a, b, a², ab, b²) about the pole Σ w p, Σ w p z, Σ w p pᵀ, without the pole.
    let (mut s_0, mut s_z) = (D::zero(), D::zero());
    let zeros: Coefficients<D> = [D::zero(); Basis::MOST_COEFFICIENTS];
    let (mut s_p, mut s_pz) = (zeros, zeros);
    let mut s_pp: Matrix<D> = [zeros; Basis::MOST_COEFFICIENTS];
    let monomials = &basis.monomials()[1..];
    let others = monomials.len();
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
        s_0 += w;
        s_z += w * z;
        for k in 0..others {
            let weighted = w * p[k];
            s_p[k] += weighted;
            s_pz[k] += weighted * z;
            for l in 0..=k {
                s_pp[k][l] += weighted * p[l];
            }
        }
    }

    let share = (epsilon * s_0 + 1.0).recip();
    let (matrix_factor, mean) = (epsilon * share, (z_k + epsilon * s_z) * share);
    let diagonals = std::array::from_fn(|k| s_pp[k][k].re());
    for k in 0..others {
        s_pz[k] -= s_p[k] * mean;
        for l in 0..=k {
            s_pp[k][l] -= s_p[k] * s_p[l] * matrix_factor;
        }
    }
    let alpha = solve_cholesky(monomials, diagonals, s_pp, s_pz)?;
    super::finite("coefficient", alpha.map(|x| x.re()))?;
    let products = (0..others).map(|k| s_p[k] * alpha[k]);
    let constant = mean - matrix_factor * products.fold(D::zero(), |sum, x| sum + x);

    // From the pole to the slave: f = Σ c_mn (a − a_k)ᵐ (b − b_k)ⁿ, expanded about (0, 0).
    let mut coefficients = zeros;
    for (k, &(i, j)) in basis.monomials().iter().enumerate() {
        let about_pole = std::iter::once(constant).chain(alpha);
        for (c, &(m, n)) in about_pole.zip(basis.monomials()).filter(|(_, (m, n))| *m >= i && *n >= j) {
            let choices = binomial(m, i) * binomial(n, j);
            coefficients[k] += c * (-a_k).powi(i32::from(m - i)) * (-b_k).powi(i32::from(n - j)) * choices;
        }
    }
    Ok(Polynomial { basis, coefficients })
}

fn binomial(n: u8, k: u8) -> f64 {
    (0..k).map(|i| f64::from(n - i) / f64::from(i + 1)).product()
}
