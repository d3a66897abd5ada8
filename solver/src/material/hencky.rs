//! The constitutive law: radial return in principal logarithmic strains.

use nalgebra::{Matrix3, Vector3};

use super::law::{Isochoric, Unresolved, congruence, principal_stretches};
use super::{Plasticity, PointState};

/// Stored energy μ ‖e‖² of the deviator e of the elastic logarithmic strains, with J2 plasticity.
#[derive(Clone, Copy, Debug)]
pub struct Hencky {
    shear: f64,
    /// Infinite if elastic.
    yield_stress: f64,
    hardening: f64,
}

impl Hencky {
    pub(super) fn new(shear: f64, plasticity: Option<Plasticity>) -> Self {
        let (yield_stress, hardening) = match plasticity {
            Some(plasticity) => (plasticity.yield_stress, plasticity.hardening),
            None => (f64::INFINITY, 0.0),
        };
        Self { shear, yield_stress, hardening }
    }

    /// Step from `committed` to the deformation gradient F, det F > 0.
    ///
    /// The trial strain has the plastic metric as it was; the return is radial, so that the stress is 2 μ_s e with the
    /// trial deviator e and one secant modulus μ_s. The tangent is the exact derivative of the step.
    ///
    /// # Errors
    /// If a trial stretch is not a number between 1e-70 and 1e70.
    #[inline]
    pub fn isochoric(
        &self,
        deformation_gradient: &Matrix3<f64>,
        committed: &PointState,
    ) -> Result<Isochoric, Unresolved> {
        let f = deformation_gradient;
        let (squares, axes) = principal_stretches(f, &committed.inverse_plastic_metric())?;
        let strain = squares.map(|square| 0.5 * square.ln());
        let mean = strain.mean();
        let deviator = strain.add_scalar(-mean);

        let mu = self.shear;
        // q² = 3/2 s·s
        let von_mises = mu * (6.0 * deviator.norm_squared()).sqrt();
        let excess = von_mises - (self.yield_stress + self.hardening * committed.equivalent_plastic_strain);
        let mut secant = mu;
        let mut state = *committed;
        // Multiplies n⊗n with the unit deviator n; 0 if elastic.
        let mut along = 0.0;
        if excess > 0.0 {
            let increment = excess / (3.0 * mu + self.hardening);
            secant = mu * (1.0 - 3.0 * mu * increment / von_mises);
            along = 6.0 * mu * mu * (increment / von_mises - 1.0 / (3.0 * mu + self.hardening));
            let elastic = (deviator * (secant / mu)).map(|e| (2.0 * (e + mean)).exp());
            let pulled_back = f
                .try_inverse()
                .map(|inverse| inverse * axes)
                .filter(|rows| rows.iter().all(|entry| entry.is_finite()))
                .ok_or(Unresolved { squares: squares.into() })?;
            state = PointState::isochoric(
                &congruence(&pulled_back, &Matrix3::from_diagonal(&elastic)),
                committed.equivalent_plastic_strain + increment,
            );
        }

        let stress = deviator * (2.0 * secant);
        let mut normal = Matrix3::from_element(-2.0 * secant / 3.0);
        if along != 0.0 {
            let direction = deviator / deviator.norm();
            normal += direction * direction.transpose() * along;
        }
        for a in 0..3 {
            normal[(a, a)] += 2.0 * (secant - stress[a]);
        }
        // With τ_A − τ_B = 2 μ_s (ε_A − ε_B) the quotient is −(τ_A + τ_B)/2 + μ_s x coth x, x = ε_A − ε_B, and as the
        // stresses add up to 0 the first term is τ_k/2.
        let shear = Vector3::from_fn(|k, _| {
            let difference = strain[(k + 1) % 3] - strain[(k + 2) % 3];
            0.5 * stress[k] + secant * x_coth_x(difference)
        });
        let energy = (secant * secant / mu) * deviator.norm_squared();
        Ok(Isochoric { axes, stress, normal, shear, state, energy })
    }
}

/// x coth x, even and smooth, 1 at 0.
#[inline]
fn x_coth_x(x: f64) -> f64 {
    if x.abs() < 0.1 {
        // The next term is below 3e-18.
        let s = x * x;
        1.0 + s
            * (1.0 / 3.0 + s * (-1.0 / 45.0 + s * (2.0 / 945.0 + s * (-1.0 / 4725.0 + s * (2.0 / 93555.0)))))
    } else {
        x / x.tanh()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn x_coth_x_has_no_seam() {
        let (below, above) = (0.1 * (1.0 - 1e-15), 0.1);
        assert!((x_coth_x(below) - x_coth_x(above)).abs() < 5e-16);
        assert_eq!(x_coth_x(0.0), 1.0);
        assert_eq!(x_coth_x(-0.03), x_coth_x(0.03));
        assert!((x_coth_x(40.0) - 40.0).abs() < 1e-12);
    }
}
