//! Emission: programs become functions, functions modules. It knows signatures and no model.

mod c;
mod count;
mod derivatives;
mod element;
mod element_kernel;
mod element_module;
mod element_test;
mod expression;
mod fixed;
mod function;
mod module;
mod names;
mod node_element;
mod node_loop;
mod node_module;
mod product_module;
mod shape;
mod tabulated;

pub(crate) use c::constants as c_constants;
pub use c::emit_c;
pub use count::{KernelCounts, OpCounts};
pub use element::{emit_element, emit_element_kernel};
pub use element_kernel::EmittedElementKernel;
pub use element_test::emit_element_test;
pub(crate) use element_test::test_module;
pub use shape::EmittedKernel;
pub(crate) use shape::{Combined, ShapeHead, emit_shape, kept_name};

/// Largest number of statements of an emitted function: rustc runs out of stack when it writes full debug information for
/// several thousand `let`s. The longest kernels have about 4,000, which it compiles.
pub const MOST_STATEMENTS: usize = 5_000;
