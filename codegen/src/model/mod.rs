//! The contact element as formulas, and the kernels made of it.

mod average_plane;
mod basis;
mod contact_kernel;
mod diffuse;
mod facet;
mod material;
mod pole;
mod slip;
mod weight;

pub(crate) use basis::MOST_COEFFICIENTS;
pub use basis::{Basis, BasisError, CustomBasis};
pub use contact_kernel::{FrameRule, KernelSpec, Output};
pub use facet::FacetShape;
pub(crate) use material::MATERIAL_INPUTS;
pub(crate) use weight::{DOMAIN_RATIO, PLANE_REACH, WEIGHT_NUMBER};
pub use weight::{Weight, WeightError, WeightNote};
