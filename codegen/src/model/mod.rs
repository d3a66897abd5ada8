//! The contact element as formulas, and the kernels made of it.

mod basis;
mod diffuse;
mod kernel;
mod weight;

pub(crate) use basis::MOST_COEFFICIENTS;
pub use basis::{Basis, BasisError, CustomBasis};
pub use diffuse::Equation;
pub use kernel::{FrameRule, Kernel, KernelSpec, Mode, Output, Value};
pub use weight::{Weight, WeightError};
