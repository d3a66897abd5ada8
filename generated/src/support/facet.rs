//! Inputs, results and status of the facet kernels.

use super::{JACOBIAN_TOLERANCE, RootSolution, Status};

/// The relative area element of a facet has to exceed this, at every corner and at the foot. Corners that coincide or
/// lie on one line in exact arithmetic leave about 1e-16; as the foot's equations square it, nothing is left of their
/// digits at 1e-8.
pub const AREA_TOLERANCE: f64 = 1e-7;

/// What a facet kernel reads. Positions are in global axes.
#[derive(Clone, Copy, Debug)]
pub struct FacetInputs<T, const CORNERS: usize> {
    /// Slave node x^c.
    pub slave: [T; 3],
    /// Corner nodes x^1 … x^n, counter-clockwise seen from the outward side.
    pub corners: [[T; 3]; CORNERS],
}

/// Values of the facet kernels.
#[derive(Clone, Copy, Debug)]
pub struct FacetValues<T> {
    /// Signed gap g, length: positive on the outward side.
    pub gap: T,
    /// Foot point, global axes.
    pub foot: [T; 3],
    /// Unit normal ν at the foot, outward, global axes.
    pub normal: [T; 3],
    /// Natural coordinates (ξ, η) of the foot: area coordinates of the second and third corner of a triangle, −1 … 1 on
    /// a quadrilateral.
    pub natural: [T; 2],
    /// Smallest area element at a corner, along the normal at the centre, over the mean square of the tangents there:
    /// 1 for a square, 0 or less for a facet that has no area, is folded or not convex.
    pub corner_area: T,
    /// The same at the foot.
    pub foot_area: T,
    /// Largest foot residual, relative to the starting residual or the foot's distance from the centre; 0 where the
    /// equations are linear.
    pub foot_residual: T,
    /// Evaluations of the foot equations.
    pub foot_iterations: T,
    /// Π (1 − g κ) over the principal curvatures κ at the foot: 1 on a flat facet, 0 on a centre of curvature.
    pub jacobian_determinant: T,
    /// Finite only if every result is.
    pub checksum: T,
}

// Comparisons below are written so that a NaN fails them.
impl FacetValues<f64> {
    /// Whether the values, and the derivatives that came with them, are numbers to use.
    #[must_use]
    pub fn status(&self) -> Status {
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
        if self.checksum.is_finite() { Status::Ok } else { Status::NotFinite }
    }
}

/// The first entries of a slice as an array.
///
/// # Panics
/// If the slice is shorter.
pub fn first_entries<T, const COUNT: usize>(slice: &mut [T]) -> &mut [T; COUNT] {
    let length = slice.len();
    slice.first_chunk_mut().unwrap_or_else(|| panic!("{length} entries where {COUNT} are needed"))
}
