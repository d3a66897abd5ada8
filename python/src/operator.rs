//! The tangent as an operator.

use diffuse_contact::assembly::TangentOperator;
use diffuse_contact::interface::InterfaceError;
use pyo3::prelude::*;

use crate::arrays::{Numbers, readable, slice, slice_mut, writable};
use crate::errors::{self, Raise};
use crate::interface::{Interface, shared};
use crate::law::Law;
use crate::threads;

/// The tangent of an interface at the positions it was made for.
#[pyclass(module = "diffuse_contact._native")]
pub struct Operator {
    operator: TangentOperator,
}

fn exclusive<'py>(object: &Bound<'py, Operator>) -> PyResult<PyRefMut<'py, Operator>> {
    object.try_borrow_mut().map_err(|_| errors::busy(object.py(), "the operator"))
}

#[pymethods]
impl Operator {
    /// Number of equations, of contacts that carry force, and of bytes.
    fn sizes(slf: &Bound<'_, Self>) -> PyResult<(usize, usize, usize)> {
        let this = exclusive(slf)?;
        Ok((this.operator.equations(), this.operator.contacts(), this.operator.bytes()))
    }

    /// Adds K v, or Kᵀ v.
    fn add_product(
        slf: &Bound<'_, Self>,
        v: &Numbers<'_>,
        product: &Numbers<'_>,
        is_transposed: bool,
    ) -> PyResult<()> {
        let py = slf.py();
        let mut this = exclusive(slf)?;
        let v = readable(v)?;
        let v = slice(py, &v)?;
        let mut product = writable(product)?;
        let product = slice_mut(py, &mut product)?;
        let operator = &mut this.operator;
        threads::attempt(py, || {
            if is_transposed {
                operator.add_transposed_product(v, product)
            } else {
                operator.add_product(v, product)
            }
        })
    }

    /// Adds the diagonal of K.
    fn add_diagonal(slf: &Bound<'_, Self>, diagonal: &Numbers<'_>) -> PyResult<()> {
        let py = slf.py();
        let mut this = exclusive(slf)?;
        let mut diagonal = writable(diagonal)?;
        let diagonal = slice_mut(py, &mut diagonal)?;
        let operator = &mut this.operator;
        threads::attempt(py, || operator.add_diagonal(diagonal))
    }
}

#[pymethods]
impl Interface {
    /// The tangent at the positions of the last update, without an evaluation.
    fn operator(slf: &Bound<'_, Self>, law: Law<'_>) -> PyResult<Operator> {
        let py = slf.py();
        let this = shared(slf)?;
        let own = law.own(py)?;
        let law = own.law(py)?;
        let (interface, dofs) = (&this.interface, &this.dofs);
        let made = threads::run(py, || TangentOperator::new(interface, &law, dofs));
        let operator = made.map_err(|error| match error {
            InterfaceError::Law(error) => error.raise(py),
            error => error.raise(py),
        })?;
        Ok(Operator { operator })
    }
}
