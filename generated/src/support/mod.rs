//! What generated kernels stand on: the arithmetic and the layouts they are generic over, what compiles them for the
//! machine's vector instructions and runs them, their inputs and results, the iterations for the foot point and the typed
//! status.

mod descent;
mod drive;
mod equations;
mod facet;
mod foot;
mod form;
mod inputs;
mod lane;
mod newton;
mod nodes;
mod second;
mod set;
mod shape;
mod simd;
mod status;
mod values;

pub use descent::TwoVariables;
pub use drive::{BatchElement, GapKernel, Widths, Workspace, batch, scalar, single};
pub use equations::{Equations, Solution};
pub use facet::{AREA_TOLERANCE, FacetFigures};
pub use form::FormRows;
pub use inputs::{Domains, ElementInputs, Inputs, MATERIAL_VALUES, Masters, MaterialNode, NODE_VALUES};
pub use lane::Lane;
pub use newton::{RootSolution, TwoEquations};
pub use nodes::multiply_node_rows;
pub use second::{Second, SecondKind};
pub use set::KernelSet;
pub use shape::{Batch, Shape, Single};
pub use simd::{Isa, Vector, WithLanes};
pub use status::{JACOBIAN_TOLERANCE, PIVOT_TOLERANCE, Status};
pub use values::{Basis, CoefficientsValues, CustomBasis, FrameRule, GapValues, Mode, SurfaceValues};

/// Position of the first entry of a row in a packed lower triangle.
#[inline(always)]
pub const fn packed_row(row: usize) -> usize {
    row * (row + 1) / 2
}

/// The first entries of a slice as an array.
///
/// # Panics
/// If the slice is shorter.
pub fn first_entries<T, const COUNT: usize>(slice: &mut [T]) -> &mut [T; COUNT] {
    let length = slice.len();
    slice.first_chunk_mut().unwrap_or_else(|| panic!("{length} entries where {COUNT} are needed"))
}
