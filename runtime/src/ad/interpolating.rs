//! The fit with an interpolating weight w = ω/(1 − ω) (Chamoret et al. 2008, eq. 16), over any kind of number.
//!
//! w is infinite where the slave stands straight above a node. With the origin of the basis at the nearest node k, w_k
//! enters the system in one entry only, A₀₀ = S₀ + w_k with S₀ = Σ_{i≠k} w_i. Eliminating α₀ leaves expressions in
//! ε = 1/w_k = (1 − ω)/ω, which is smooth, and a system for the other coefficients that is regular at ε = 0.

use super::foot::Polynomial;
use super::model::{Scalar, solve_cholesky};
use super::{RadialWeight, WeightFunction};
use crate::ElementError;

/// The coefficients about the slave of a fit with `size` coefficients to `offsets` (a, b, z) from the slave.
pub(super) fn fit<D: Scalar, W: RadialWeight>(
    weight: &WeightFunction<'_, W>,
    size: usize,
    offsets: &[[D; 3]],
) -> Result<Polynomial<D>, ElementError> {
    let square = |[a, b, _]: [D; 3]| a * a + b * b;
    let nearest =
        (0..offsets.len()).min_by(|&i, &j| square(offsets[i]).re().total_cmp(&square(offsets[j]).re()));
    let Some(anchor) = nearest else { return Err(ElementError::TooFewNodes { found: 0, needed: size }) };
    let [a_k, b_k, z_k] = offsets[anchor];
    super::finite("offset", [a_k.re(), b_k.re(), z_k.re()])?;
    let s_k = square(offsets[anchor]);
    if s_k.re() >= 1.0 {
        return Err(ElementError::SingularFit { pivot_ratio: 0.0, tolerance: 0.0 });
    }
    let epsilon = weight.complement_at_square(s_k) / weight.at_square(s_k);

    // S₀, Σ w z, and with p = (a, b, a², ab, b²) about the anchor Σ w p, Σ w p z, Σ w p pᵀ, without the anchor.
    let (mut s_0, mut s_z) = (D::zero(), D::zero());
    let (mut s_p, mut s_pz, mut s_pp) = ([D::zero(); 6], [D::zero(); 6], [[D::zero(); 6]; 6]);
    let others = size - 1;
    for (_, &offset) in offsets.iter().enumerate().filter(|&(i, _)| i != anchor) {
        let [a, b, z] = offset;
        super::finite("offset", [a.re(), b.re(), z.re()])?;
        let s = square(offset);
        if s.re() >= 1.0 {
            continue;
        }
        let w = weight.at_square(s) / weight.complement_at_square(s);
        super::finite("weight", [w.re()])?;
        let (a, b) = (a - a_k, b - b_k);
        let p = [a, b, a * a, a * b, b * b];
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
    let alpha = solve_cholesky(others, 1, diagonals, s_pp, s_pz)?;
    super::finite("coefficient", alpha.map(|x| x.re()))?;
    let products = (0..others).map(|k| s_p[k] * alpha[k]);
    let constant = mean - matrix_factor * products.fold(D::zero(), |sum, x| sum + x);

    // From the anchor to the slave: f = c₀ + c·p(u − (a_k, b_k)), expanded about u = 0.
    let [c_1, c_2, c_11, c_12, c_22, _] = alpha;
    let at_slave = constant - c_1 * a_k - c_2 * b_k + c_11 * a_k * a_k + c_12 * a_k * b_k + c_22 * b_k * b_k;
    Ok(Polynomial([
        at_slave,
        c_1 - c_11 * a_k * 2.0 - c_12 * b_k,
        c_2 - c_12 * a_k - c_22 * b_k * 2.0,
        c_11,
        c_12,
        c_22,
    ]))
}
