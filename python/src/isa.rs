//! The vector instructions in use.

use diffuse_contact_kernels::support::Isa;
use pyo3::prelude::*;

use crate::errors;

/// The vector instructions in use, such as `"avx2"`.
#[pyfunction]
pub fn isa() -> &'static str {
    Isa::best().name()
}

/// Makes these the instructions in use.
#[pyfunction]
pub fn set_isa(py: Python<'_>, name: &str) -> PyResult<()> {
    let refused = |message: String| errors::input(py, "invalid-option", &message);
    let Some(isa) = Isa::named(name) else {
        let known: Vec<&str> = Isa::available().map(Isa::name).collect();
        return Err(refused(format!("\"{name}\" is none of {}, which there are", known.join(", "))));
    };
    isa.prefer().map_err(|used| refused(format!("\"{used}\" is in use already, \"{name}\" comes too late")))
}
