//! Hencky elasticity with multiplicative J2 plasticity, and neo-Hooke elasticity.
//!
//! The stored energy falls into a volumetric and an isochoric part. A point needs the isochoric part only, [`Law::isochoric`]: a
//! deviatoric Kirchhoff stress, which neither a volume nor a pressure changes. The volumetric part, [`Law::volumetric`], is a
//! function of one ratio of volumes, which may be that of an element.

mod eigen;
mod hencky;
mod law;
mod neo_hooke;
mod state;
#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};

use hencky::Hencky;
pub use law::{Isochoric, Law, Unresolved, Volumetric};
use neo_hooke::NeoHooke;
pub use state::PointState;

/// Constants of an isotropic material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Young's modulus E, force per area.
    pub young: f64,
    /// Poisson's ratio ν, −1 < ν < 0.5.
    pub poisson: f64,
    /// The stored energy, and how the material yields.
    #[serde(flatten)]
    pub model: MaterialModel,
}

/// The stored energy of a material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "model", rename_all = "kebab-case")]
pub enum MaterialModel {
    /// κ/2 (ln θ)² + μ ‖e‖², with the ratio of volumes θ and the deviator e of the elastic logarithmic strains.
    Hencky {
        /// `None`: elastic.
        plasticity: Option<Plasticity>,
    },
    /// κ/2 (θ − 1)² + μ/2 (tr b̄ − 3), with b̄ = (det F)^(−2/3) F Fᵀ. Elastic.
    NeoHooke,
}

/// Von Mises plasticity with linear isotropic hardening: the yield stress is σ_y + H p.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plasticity {
    /// σ_y, force per area.
    pub yield_stress: f64,
    /// H ≥ 0, force per area.
    pub hardening: f64,
}

/// A constant for which there is no such material.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{constant} must be {range}, not {value}")]
pub struct MaterialError {
    /// Its name.
    pub constant: &'static str,
    /// What it may be.
    pub range: &'static str,
    /// What it is.
    pub value: f64,
}

impl Material {
    /// Hencky's elasticity without plasticity.
    pub const fn elastic(young: f64, poisson: f64) -> Self {
        Self { young, poisson, model: MaterialModel::Hencky { plasticity: None } }
    }

    /// Neo-Hooke elasticity.
    pub const fn neo_hooke(young: f64, poisson: f64) -> Self {
        Self { young, poisson, model: MaterialModel::NeoHooke }
    }

    /// The same material, of Hencky's elasticity, that yields.
    #[must_use]
    pub const fn with_plasticity(self, plasticity: Plasticity) -> Self {
        Self { model: MaterialModel::Hencky { plasticity: Some(plasticity) }, ..self }
    }

    /// How it yields; `None`: elastic.
    pub const fn plasticity(&self) -> Option<Plasticity> {
        match self.model {
            MaterialModel::Hencky { plasticity } => plasticity,
            MaterialModel::NeoHooke => None,
        }
    }

    /// Whether there is such a material.
    ///
    /// # Errors
    /// The first constant that is out of range or not finite.
    pub fn check(&self) -> Result<(), MaterialError> {
        let within = |constant, range, value: f64, sound: bool| match sound && value.is_finite() {
            true => Ok(()),
            false => Err(MaterialError { constant, range, value }),
        };
        within("Young's modulus", "positive and finite", self.young, self.young > 0.0)?;
        within(
            "Poisson's ratio",
            "between -1 and 0.5",
            self.poisson,
            self.poisson > -1.0 && self.poisson < 0.5,
        )?;
        // The largest double below 0.5 passes the test above with a modulus that is a multiple of 1e16 E.
        let bulk = self.bulk_modulus();
        within("the bulk modulus", "positive and finite", bulk, bulk > 0.0)?;
        let shear = self.shear_modulus();
        within("the shear modulus", "positive and finite", shear, shear > 0.0)?;
        if let Some(Plasticity { yield_stress, hardening }) = self.plasticity() {
            within("the yield stress", "positive and finite", yield_stress, yield_stress > 0.0)?;
            within("the hardening modulus", "zero or positive, and finite", hardening, hardening >= 0.0)?;
        }
        Ok(())
    }

    /// κ = E / 3(1 − 2ν), force per area.
    pub fn bulk_modulus(&self) -> f64 {
        self.young / (3.0 * (1.0 - 2.0 * self.poisson))
    }

    /// μ = E / 2(1 + ν), force per area.
    pub fn shear_modulus(&self) -> f64 {
        self.young / (2.0 * (1.0 + self.poisson))
    }
}
