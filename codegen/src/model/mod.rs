//! The contact element as formulas, and the kernels made of it.

mod average_plane;
mod basis;
mod client;
mod diffuse;
mod element;
mod element_error;
mod element_outputs;
mod element_unknowns;
mod facet;
mod kernel;
mod material;
mod pole;
mod signature;
mod slip;
mod weight;

pub(crate) use basis::MOST_COEFFICIENTS;
pub use basis::{Basis, BasisError, CustomBasis};
pub(crate) use client::contact_signature;
pub use diffuse::Equation;
pub use element::{Defined, ElementError, ElementKernels, ElementModel, ElementSpec, NodeResult};
pub use element_unknowns::{Root, Stationary};
pub use facet::FacetShape;
pub(crate) use kernel::CHECKSUM;
pub use kernel::{FrameRule, Kernel, KernelSpec, Mode, Output, Value};
pub(crate) use material::MATERIAL_INPUTS;
pub(crate) use signature::is_identifier;
pub use signature::{Differentiated, DirectionSymbols, Input, Points, Quantity, Returned, Role, Signature};
pub(crate) use weight::DOMAIN_RATIO;
pub use weight::{Weight, WeightError, WeightNote};
