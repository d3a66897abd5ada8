//! Neo-Hooke elasticity, from its energy: the kernel is generated.

use diffuse_contact_kernels::isochoric_neo_hooke;
use diffuse_contact_kernels::support::Mode;
use nalgebra::Matrix3;

use super::PointState;
use super::law::{Isochoric, Unresolved, principal_stretches};

/// Stored energy μ/2 (tr b̄ − 3).
#[derive(Clone, Copy, Debug)]
pub struct NeoHooke {
    shear: f64,
}

impl NeoHooke {
    pub(super) const fn new(shear: f64) -> Self {
        Self { shear }
    }

    /// At the deformation gradient F, det F > 0; the state stays.
    ///
    /// # Errors
    /// If a stretch is not a number between 1e-70 and 1e70.
    #[inline]
    pub fn isochoric(
        &self,
        deformation_gradient: &Matrix3<f64>,
        committed: &PointState,
    ) -> Result<Isochoric, Unresolved> {
        let (squares, axes) = principal_stretches(deformation_gradient, &Matrix3::identity())?;
        let inputs = isochoric_neo_hooke::Inputs { squares: squares.into(), shear_modulus: self.shear };
        let found = isochoric_neo_hooke::evaluate(Mode::Value, &inputs).values;
        Ok(Isochoric {
            axes,
            stress: found.stress.into(),
            // Rows for columns: it is symmetric.
            normal: found.normal.into(),
            shear: found.shear.into(),
            state: *committed,
            energy: found.energy,
        })
    }
}
