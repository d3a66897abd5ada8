//! Emission: programs become functions, functions modules, modules a formatted file.

mod c;
mod count;
mod diffuse;
mod element;
mod expression;
mod facet;
mod fixed;
mod formula;
mod function;
mod module;
mod names;
mod node_element;
mod node_loop;
mod node_module;

pub use c::emit_c;
pub use count::{KernelCounts, OpCounts};
pub use diffuse::{EmittedKernel, emit_kernel};
pub use element::{EmittedElementKernel, emit_element, emit_element_kernel};
pub use facet::{EmittedFacetKernel, emit_facet_kernel};

pub use module::{EmitOptions, TooLong, emit_file, emit_single, emit_single_facet};

/// Largest number of statements of an emitted function: rustc runs out of stack when it writes full debug information for
/// several thousand `let`s. It still does so for the longest kernels, of about 4,000.
pub const MOST_STATEMENTS: usize = 5_000;
