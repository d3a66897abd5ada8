//! From a kernel's figures to a typed status.

use super::{CoefficientsValues, GapValues, RootSolution, SurfaceValues};

/// The relative pivot of the moment matrix has to exceed this. Layouts that are singular in exact arithmetic leave
/// pivots of up to about 1e-8 after rounding.
pub const PIVOT_TOLERANCE: f64 = 1e-7;
/// The determinant of the foot equations' Jacobian has to exceed this in absolute value; it is at least 1 on a
/// flat surface. Close to a multiple root the iteration stops a square root of rounding away from it.
pub const JACOBIAN_TOLERANCE: f64 = 1e-7;

/// Outcome of one element.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
#[allow(missing_docs)] // The names say what the fields are.
pub enum Status {
    /// All results are finite numbers.
    Ok,
    /// The moment matrix is singular to working precision. `pivot_ratio` is the smallest relative pivot.
    SingularFit { pivot_ratio: f64 },
    /// The iteration for the foot did not converge. `residual` is the largest relative one, `iterations` are evaluations of the equations.
    FootDiverged { residual: f64, iterations: f64 },
    /// The foot lies outside the domain of influence. `distance` is that in the plane over the support radius.
    FootOutside { distance: f64 },
    /// The slave lies on a centre of curvature; of a facet, also beyond one. `determinant` is that of the Jacobian.
    CentreOfCurvature { determinant: f64 },
    /// The slave lies beyond a centre of curvature: the foot is a stationary point of the distance, but not a minimum. The figures are
    /// those of the Jacobian, whose trace is negative at a minimum.
    BeyondCentreOfCurvature { determinant: f64, trace: f64 },
    /// The average plane is not unique to working precision. `pivot_ratio` is the smallest relative pivot of the plane's system.
    NoAveragePlane { pivot_ratio: f64 },
    /// A facet without area, folded or not convex, or its extension folded at the foot. `area` is the area element at a corner or at the
    /// foot, relative to a square's; 0 if there is none.
    DegenerateFacet { area: f64 },
    /// A result is not a finite number although nothing else is wrong: overflow, or input that was not finite.
    NotFinite,
}

// A NaN fails the comparisons below, or the checksum.
impl Status {
    /// A matrix whose factorisation broke down before it had a pivot to report has none: 0.
    fn singular_fit(pivot_ratio: f64) -> Self {
        Self::SingularFit { pivot_ratio: if pivot_ratio.is_finite() { pivot_ratio } else { 0.0 } }
    }

    fn of_fit(pivot_ratio: f64, checksum: f64) -> Self {
        if !(pivot_ratio > PIVOT_TOLERANCE) {
            return Self::singular_fit(pivot_ratio);
        }
        if checksum.is_finite() { Self::Ok } else { Self::NotFinite }
    }
}

impl CoefficientsValues<f64> {
    /// Whether the values, and the derivatives that came with them, are numbers to use.
    pub fn status(&self) -> Status {
        Status::of_fit(self.pivot_ratio, self.checksum)
    }
}

impl SurfaceValues<f64> {
    /// Whether the values, and the derivatives that came with them, are numbers to use.
    pub fn status(&self) -> Status {
        Status::of_fit(self.pivot_ratio, self.checksum)
    }
}

impl GapValues<f64> {
    /// Whether the values, and the derivatives that came with them, are numbers to use.
    pub fn status(&self) -> Status {
        if !(self.pivot_ratio > PIVOT_TOLERANCE) {
            return Status::singular_fit(self.pivot_ratio);
        }
        if !(self.plane_pivot_ratio > PIVOT_TOLERANCE) {
            return Status::NoAveragePlane { pivot_ratio: self.plane_pivot_ratio };
        }
        let determinant = self.jacobian_determinant;
        if determinant.abs() <= JACOBIAN_TOLERANCE {
            return Status::CentreOfCurvature { determinant };
        }
        if !(self.foot_residual < RootSolution::<f64>::TOLERANCE) {
            return Status::FootDiverged { residual: self.foot_residual, iterations: self.foot_iterations };
        }
        if !(self.foot_distance <= 1.0) {
            return Status::FootOutside { distance: self.foot_distance };
        }
        let trace = self.jacobian_trace;
        if determinant < 0.0 || trace >= 0.0 {
            return Status::BeyondCentreOfCurvature { determinant, trace };
        }
        Status::of_fit(self.pivot_ratio, self.checksum)
    }
}
