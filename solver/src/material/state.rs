//! What a point remembers.

use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};

/// Plastic history of a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointState {
    /// C_p⁻¹, the inverse of the plastic right Cauchy–Green tensor in reference axes: xx, yy, zz, xy, yz, xz. Its
    /// determinant is 1: plastic flow preserves volume.
    pub inverse_plastic_metric: [f64; 6],
    /// p, the equivalent plastic strain, at least 0.
    pub equivalent_plastic_strain: f64,
}

impl PointState {
    /// A point that never yielded.
    pub const VIRGIN: Self =
        Self { inverse_plastic_metric: [1.0, 1.0, 1.0, 0.0, 0.0, 0.0], equivalent_plastic_strain: 0.0 };

    /// C_p⁻¹ as a matrix.
    pub fn inverse_plastic_metric(&self) -> Matrix3<f64> {
        let [xx, yy, zz, xy, yz, xz] = self.inverse_plastic_metric;
        Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    }

    /// The state with this C_p⁻¹, a symmetric matrix, but for its determinant, which is set to 1: rounding in thousands of increments would
    /// add up to a volume otherwise.
    pub(super) fn isochoric(metric: &Matrix3<f64>, equivalent_plastic_strain: f64) -> Self {
        let m = metric / metric.determinant().cbrt();
        let inverse_plastic_metric = [m[(0, 0)], m[(1, 1)], m[(2, 2)], m[(1, 0)], m[(2, 1)], m[(2, 0)]];
        Self { inverse_plastic_metric, equivalent_plastic_strain }
    }
}

impl Default for PointState {
    fn default() -> Self {
        Self::VIRGIN
    }
}
