//! The 3D diffuse contact element of Chamoret, Rassineux and Bergheau (2008).
#![forbid(unsafe_code)]

#[cfg(feature = "ad")]
pub mod ad;
pub mod assembly;
pub mod backend;
pub mod batch;
mod eigen;
pub mod element;
pub mod error;
pub mod facet;
pub mod frame;
pub mod generated;
pub mod interface;
pub mod neighbourhood;
pub mod output;
pub mod pairing;
pub mod surface;
mod vector;

pub use backend::Backend;
pub use batch::{BatchScratch, GapSlot};
pub use diffuse_contact_kernels::support::{Basis, CustomBasis, Domains, Mode};
pub use element::{Element, Weight};
pub use error::ElementError;
pub use facet::{FacetElement, FacetPoint};
pub use frame::{Frame, FrameDerivative};
pub use generated::{Generated, GeneratedWith};
pub use output::{Coefficients, ContactPoint, Gap, Surface, SymmetricMatrix};

/// A point or a vector in global axes, in the length unit of the mesh.
pub type Point = [f64; 3];
