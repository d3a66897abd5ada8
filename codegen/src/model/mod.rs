//! The contact element as formulas, and the kernels made of it.

mod basis;
mod diffuse;
mod facet;
mod kernel;
mod weight;

pub use basis::Basis;
pub use diffuse::Equation;
pub use facet::{FacetShape, FacetSpec};
pub use kernel::{FrameRule, Kernel, KernelSpec, Mode, Output, Value};
pub use weight::{Weight, WeightError};
