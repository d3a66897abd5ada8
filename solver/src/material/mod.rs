//! Hencky elasticity with multiplicative J2 plasticity.
//!
//! The stored energy depends on the elastic logarithmic strains and falls into a volumetric and an isochoric part. A point
//! needs the isochoric part only, [`Hencky::isochoric`]: a deviatoric Kirchhoff stress, which neither a volume nor a
//! pressure changes. The volumetric part, [`Hencky::volumetric`], is a function of one ratio of volumes, which may be
//! that of an element.

mod eigen;
mod hencky;
mod state;

use serde::{Deserialize, Serialize};

pub use hencky::{Hencky, Isochoric, Unresolved, Volumetric};
pub use state::PointState;

/// Constants of an isotropic material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Young's modulus E, force per area.
    pub young: f64,
    /// Poisson's ratio ν, −1 < ν < 0.5.
    pub poisson: f64,
    /// `None`: elastic.
    pub plasticity: Option<Plasticity>,
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
        if let Some(Plasticity { yield_stress, hardening }) = self.plasticity {
            within("the yield stress", "positive and finite", yield_stress, yield_stress > 0.0)?;
            within("the hardening modulus", "zero or positive, and finite", hardening, hardening >= 0.0)?;
        }
        Ok(())
    }

    /// κ = E / 3(1 − 2ν), force per area.
    #[must_use]
    pub fn bulk_modulus(&self) -> f64 {
        self.young / (3.0 * (1.0 - 2.0 * self.poisson))
    }

    /// μ = E / 2(1 + ν), force per area.
    #[must_use]
    pub fn shear_modulus(&self) -> f64 {
        self.young / (2.0 * (1.0 + self.poisson))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_out_of_range_are_named() {
        let steel = Material { young: 2e5, poisson: 0.3, plasticity: None };
        assert_eq!(steel.check(), Ok(()));
        assert!((steel.bulk_modulus() - 2e5 / 1.2).abs() < 1e-9);
        assert!((steel.shear_modulus() - 2e5 / 2.6).abs() < 1e-9);
        let plastic = |yield_stress, hardening| Material {
            plasticity: Some(Plasticity { yield_stress, hardening }),
            ..steel
        };
        assert_eq!(plastic(400.0, 0.0).check(), Ok(()));
        for (material, constant) in [
            (Material { young: 0.0, ..steel }, "Young's modulus"),
            (Material { young: f64::INFINITY, ..steel }, "Young's modulus"),
            (Material { poisson: 0.5, ..steel }, "Poisson's ratio"),
            (Material { poisson: f64::NAN, ..steel }, "Poisson's ratio"),
            (Material { young: 1e300, poisson: 0.5 - 1e-16, ..steel }, "the bulk modulus"),
            (plastic(0.0, 1.0), "the yield stress"),
            (plastic(400.0, -1.0), "the hardening modulus"),
            (plastic(400.0, f64::INFINITY), "the hardening modulus"),
        ] {
            assert_eq!(material.check().unwrap_err().constant, constant, "{material:?}");
        }
    }
}
