//! The compiled part of the Python module `diffuse_contact`.
//!
//! [`batch`] evaluates many elements on arrays. [`surface`], [`interface`] and [`faces`] wrap
//! [`MasterSurface`](diffuse_contact::surface::MasterSurface),
//! [`ContactInterface`](diffuse_contact::interface::ContactInterface) and
//! [`FaceInterface`](diffuse_contact::faces::FaceInterface), [`history`] the friction of both. What is here takes contiguous arrays of
//! the right type and fills arrays it is given; [`window`] has what ranks send one another of a surface. The package around it converts
//! what people pass, and is what people see.
//!
//! * No call panics on what it is given; every refusal is an exception with a stable `code` ([`errors`]).
//! * Numbers are computed without the GIL, in a pool of threads of our own ([`threads`]). The borrow of an object is held meanwhile, so a
//!   second thread gets a `BusyError`. No exception is made while the lock of the pool is held: making one runs Python, which may hand the
//!   GIL to a thread that waits for the lock.
//! * Batches are evaluated in pieces of 64 elements, each into its part of the arrays. Neither threads nor pieces change a bit.
//! * An interface is a `ContactInterface`, a `DofMap`, the pattern of its lists of nodes, and whether the contacts are those of the present
//!   positions: others are not handed out. Matrices share the pattern's index arrays, which are read-only.
//! * Default options are written out in Python, where people read them; a test compares them with Rust's.
//! * Kernels are compiled as those of all programs of the workspace are: numbers are equal to the last bit.
#![forbid(unsafe_code)]
// `cargo test NAME` builds a test program of every library, also of those that ask for none. It could not be linked: Python's symbols are
// those of the process that loads the module.
#![cfg(not(test))]
// Python sees what is exported; to Rust all of it is private.
#![allow(rustdoc::private_intra_doc_links)]

mod arrays;
mod assembly;
mod batch;
mod errors;
mod faces;
mod feet;
mod history;
mod interface;
mod isa;
mod law;
mod operator;
mod options;
mod pattern;
mod report;
mod surface;
mod threads;
mod window;

use pyo3::prelude::*;

/// The compiled part of `diffuse_contact`.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("HAS_FRICTION", cfg!(feature = "friction"))?;
    module.add("STATUS_CODES", batch::STATUS_CODES.to_vec())?;
    module.add_class::<surface::Surface>()?;
    module.add_class::<interface::Interface>()?;
    module.add_class::<faces::Faces>()?;
    module.add_class::<window::Window>()?;
    module.add_class::<window::Part>()?;
    module.add_function(wrap_pyfunction!(window::boxes_around, module)?)?;
    module.add_function(wrap_pyfunction!(window::extents, module)?)?;
    module.add_function(wrap_pyfunction!(window::history_lengths, module)?)?;
    module.add_class::<operator::Operator>()?;
    module.add_class::<pattern::Map>()?;
    module.add_function(wrap_pyfunction!(batch::gap_batch, module)?)?;
    module.add_function(wrap_pyfunction!(surface::tributary_areas, module)?)?;
    module.add_function(wrap_pyfunction!(faces::flat_facets, module)?)?;
    module.add_function(wrap_pyfunction!(law::check_law, module)?)?;
    module.add_function(wrap_pyfunction!(options::check_options, module)?)?;
    module.add_function(wrap_pyfunction!(options::default_options, module)?)?;
    module.add_function(wrap_pyfunction!(options::adaptive_tangent, module)?)?;
    module.add_function(wrap_pyfunction!(isa::isa, module)?)?;
    module.add_function(wrap_pyfunction!(isa::set_isa, module)?)?;
    module.add_function(wrap_pyfunction!(threads::set_threads, module)?)?;
    module.add_function(wrap_pyfunction!(threads::thread_count, module)?)
}
