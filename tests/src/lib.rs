//! What the tests share: random elements, their transformations, and the measure of a difference.
#![forbid(unsafe_code)]

mod case;
mod difference;
mod facet;
mod geometry;
mod shapes;

pub use case::{Case, Quadric, cases, fixed};
pub use difference::{
    assert_finite_gap, assert_same_coefficients, assert_same_gap, assert_same_surface, difference, largest,
    worse,
};
pub use facet::{FacetCase, facet_cases};
pub use geometry::{Random, add, cross, dot, length, scale, turn, turned_rows, turned_vector};
pub use shapes::{Found, GAP_KERNELS, GapKernels, Kernel, instructions, output_sizes};

/// Kernels that the build script generated for weights of its own.
pub mod weights {
    include!(concat!(env!("OUT_DIR"), "/diffuse_contact_kernels.rs"));
}

/// Kernels that the build script generated for bases of its own.
#[cfg(feature = "bases")]
pub mod bases {
    include!(concat!(env!("OUT_DIR"), "/bases/diffuse_contact_kernels.rs"));
}
