//! The compiled part of the Python module `diffuse_contact`.
//!
//! [`batch`] evaluates many elements on arrays, [`surface`] and [`interface`] wrap
//! [`MasterSurface`](diffuse_contact::surface::MasterSurface) and
//! [`ContactInterface`](diffuse_contact::interface::ContactInterface). What is here takes contiguous arrays of the right
//! type and fills arrays it is given; the package around it converts what people pass, and is what people see.
//!
//! * No call panics on what it is given; every refusal is an exception with a stable `code` ([`errors`]).
//! * Numbers are computed without the GIL, in a pool of threads of our own ([`threads`]).
#![forbid(unsafe_code)]

mod arrays;
mod assembly;
mod batch;
mod errors;
mod interface;
mod options;
mod report;
mod surface;
mod threads;

use pyo3::prelude::*;

/// The compiled part of `diffuse_contact`.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("STATUS_CODES", batch::STATUS_CODES.to_vec())?;
    module.add_class::<surface::Surface>()?;
    module.add_class::<interface::Interface>()?;
    module.add_function(wrap_pyfunction!(batch::gap_batch, module)?)?;
    module.add_function(wrap_pyfunction!(surface::tributary_areas, module)?)?;
    module.add_function(wrap_pyfunction!(options::default_options, module)?)?;
    module.add_function(wrap_pyfunction!(threads::set_threads, module)?)?;
    module.add_function(wrap_pyfunction!(threads::thread_count, module)?)
}
