//! Status of the facet kernels.

use super::{JACOBIAN_TOLERANCE, RootSolution, Status};

/// The relative area element of a facet has to exceed this, at every corner and at the foot. Corners that coincide or
/// lie on one line in exact arithmetic leave about 1e-16; as the foot's equations square it, nothing is left of their
/// digits at 1e-8.
pub const AREA_TOLERANCE: f64 = 1e-7;

/// The figures of a facet's kernel that tell whether its results are numbers to use, as they are named there.
#[derive(Clone, Copy, Debug)]
pub struct FacetFigures {
    /// Smallest area element at a corner, relative.
    pub corner_area: f64,
    /// The same at the foot.
    pub foot_area: f64,
    /// Largest foot residual, relative.
    pub foot_residual: f64,
    /// Evaluations of the foot equations.
    pub foot_iterations: f64,
    /// Π (1 − g κ) over the principal curvatures κ at the foot.
    pub jacobian_determinant: f64,
}

// A NaN fails the comparisons below, or the last of them.
impl FacetFigures {
    /// Whether results are numbers to use, of which it is known whether all are finite.
    pub fn status(&self, are_finite: bool) -> Status {
        let determinant = self.jacobian_determinant;
        if self.corner_area.is_nan() {
            return Status::NotFinite;
        }
        if !(self.corner_area > AREA_TOLERANCE) {
            return Status::DegenerateFacet { area: self.corner_area };
        }
        // A double root slows the iteration down: the cause before the consequence.
        if determinant.abs() <= JACOBIAN_TOLERANCE {
            return Status::CentreOfCurvature { determinant };
        }
        if !(self.foot_residual < RootSolution::<f64>::TOLERANCE) {
            return Status::FootDiverged { residual: self.foot_residual, iterations: self.foot_iterations };
        }
        if self.foot_area <= AREA_TOLERANCE {
            return Status::DegenerateFacet { area: self.foot_area };
        }
        // Beyond a centre of curvature the foot is a saddle of the distance, not its minimum.
        if determinant < 0.0 {
            return Status::CentreOfCurvature { determinant };
        }
        if are_finite && !(determinant + self.foot_area).is_nan() { Status::Ok } else { Status::NotFinite }
    }
}
