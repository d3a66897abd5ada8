//! What generated kernels stand on: the arithmetic they are generic over, their inputs and results, the
//! iterations for the foot point and the typed status.

mod descent;
mod facet;
mod lane;
mod newton;
mod status;
mod values;

pub use descent::minimise_two_variables;
pub use facet::{AREA_TOLERANCE, FacetInputs, FacetValues, first_entries};
pub use lane::Lane;
pub use newton::{RootSolution, solve_two_equations};
pub use status::{JACOBIAN_TOLERANCE, PIVOT_TOLERANCE, Status};
pub use values::{Basis, CoefficientsValues, CustomBasis, GapValues, Inputs, KernelSet, Mode, SurfaceValues};

/// Position of the first entry of a row in a packed lower triangle.
#[inline(always)]
#[must_use]
pub const fn packed_row(row: usize) -> usize {
    row * (row + 1) / 2
}
