//! The contact kernels as clients of [`emit`](crate::emit): names and types that surround their functions, and the file they stand in.

mod elements;
mod file;
mod formula;
mod kernels;
mod module;

pub(crate) use file::{EmitOptions, TooLong, emit_file};
pub use file::{emit_single, emit_single_element};
pub use kernels::emit_kernel;
