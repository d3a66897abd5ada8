//! The tangent in compressed sparse rows: a pattern of its own, or a matrix that the host has.

use diffuse_contact::assembly::{CsrMap, CsrPattern};
use diffuse_contact::interface::InterfaceError;
use numpy::{Element, PyArray1};
use pyo3::prelude::*;

use crate::arrays::{Numbers, readable, slice, slice_mut, writable};
use crate::errors::Raise;
use crate::interface::{Interface, exclusive, shared};
use crate::law::Law;
use crate::threads;

/// The union pattern of a pairing: its arrays are Python's, made once and read-only.
pub struct Pattern {
    map: CsrMap,
    offsets: Py<PyAny>,
    columns: Py<PyAny>,
}

/// An array that nobody writes to.
fn constant<T: Element>(py: Python<'_>, numbers: Vec<T>) -> PyResult<Py<PyAny>> {
    let array = PyArray1::from_vec(py, numbers);
    writable(&array)?.make_nonwriteable();
    Ok(array.into_any().unbind())
}

impl Pattern {
    fn new(py: Python<'_>, made: CsrPattern) -> PyResult<Self> {
        let (offsets, columns, map) = made.into_parts();
        // Offsets and columns have one type, as scipy wants them: that of the number of entries, the largest of all.
        let (offsets, columns) = if i32::try_from(map.entries().max(map.equations())).is_ok() {
            let columns = columns.into_iter().map(|column| column as i32).collect();
            (constant(py, offsets.into_iter().map(|offset| offset as i32).collect())?, constant(py, columns)?)
        } else {
            let columns = columns.into_iter().map(i64::from).collect();
            (constant(py, offsets.into_iter().map(|offset| offset as i64).collect())?, constant(py, columns)?)
        };
        Ok(Self { map, offsets, columns })
    }
}

/// Where tangents go in a matrix of the host.
#[pyclass(module = "diffuse_contact._native", frozen)]
pub struct Map {
    map: CsrMap,
}

#[pymethods]
impl Map {
    /// Number of values of the matrix.
    #[getter]
    fn entries(&self) -> usize {
        self.map.entries()
    }

    /// Number of its rows and columns.
    #[getter]
    fn equations(&self) -> usize {
        self.map.equations()
    }
}

/// Row offsets and columns of a matrix: 32 bits or 64.
#[derive(FromPyObject)]
pub enum Rows<'py> {
    Short(Bound<'py, PyArray1<i32>>, Bound<'py, PyArray1<i32>>),
    Long(Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<i64>>),
}

impl Interface {
    /// Makes the pattern if there is none of the present lists of nodes.
    fn make_pattern(&mut self, py: Python<'_>) -> PyResult<&Pattern> {
        let contacts = self.contacts(py)?;
        if !self.pattern.as_ref().is_some_and(|pattern| pattern.map.fits(contacts)) {
            // Both at once may be more than there is room for.
            self.pattern = None;
        }
        if let Some(pattern) = self.pattern.take() {
            return Ok(self.pattern.insert(pattern));
        }
        let (contacts, dofs) = (self.contacts(py)?, &self.dofs);
        let made = threads::attempt(py, || CsrPattern::union(contacts, dofs))?;
        Ok(self.pattern.insert(Pattern::new(py, made)?))
    }

    /// Writes or adds the tangent; M is evaluated in passing if the evaluation did not keep it.
    fn sum(
        &self,
        py: Python<'_>,
        map: &CsrMap,
        law: &Law<'_>,
        values: &Numbers<'_>,
        add: bool,
    ) -> PyResult<usize> {
        let own = law.own(py)?;
        let law = own.law(py)?;
        let mut values = writable(values)?;
        let values = slice_mut(py, &mut values)?;
        self.contacts(py)?;
        let interface = &self.interface;
        let summed = threads::run(py, || {
            if add { map.add_from(interface, &law, values) } else { map.fill_from(interface, &law, values) }
        });
        summed.map_err(|error| match error {
            InterfaceError::Law(error) => error.raise(py),
            error => error.raise(py),
        })
    }
}

#[pymethods]
impl Interface {
    /// Row offsets and columns of the union pattern.
    fn pattern(slf: &Bound<'_, Self>) -> PyResult<(Py<PyAny>, Py<PyAny>)> {
        let py = slf.py();
        let mut this = exclusive(slf)?;
        let pattern = this.make_pattern(py)?;
        Ok((pattern.offsets.clone_ref(py), pattern.columns.clone_ref(py)))
    }

    /// Number of entries of the union pattern.
    fn entries(slf: &Bound<'_, Self>) -> PyResult<usize> {
        Ok(exclusive(slf)?.make_pattern(slf.py())?.map.entries())
    }

    /// Writes the values of the tangent, one per entry of the pattern, or adds them; returns the number of contacts that
    /// carry force.
    fn fill_tangent(slf: &Bound<'_, Self>, law: Law<'_>, values: &Numbers<'_>, add: bool) -> PyResult<usize> {
        let py = slf.py();
        let mut this = exclusive(slf)?;
        this.make_pattern(py)?;
        let this = &*this;
        let Some(pattern) = &this.pattern else { return Ok(0) };
        this.sum(py, &pattern.map, &law, values, add)
    }

    /// The places in a matrix of the host.
    fn csr_map(slf: &Bound<'_, Self>, rows: Rows<'_>) -> PyResult<Map> {
        let py = slf.py();
        let this = shared(slf)?;
        let (contacts, dofs) = (this.contacts(py)?, &this.dofs);
        macro_rules! within {
            ($offsets:expr, $columns:expr) => {{
                let (offsets, columns) = (readable(&$offsets)?, readable(&$columns)?);
                let (offsets, columns) = (slice(py, &offsets)?, slice(py, &columns)?);
                threads::attempt(py, || CsrMap::within(contacts, dofs, offsets, columns))?
            }};
        }
        let map = match rows {
            Rows::Short(offsets, columns) => within!(offsets, columns),
            Rows::Long(offsets, columns) => within!(offsets, columns),
        };
        Ok(Map { map })
    }

    /// Adds the tangent to the values of a matrix of the host.
    fn add_tangent(slf: &Bound<'_, Self>, map: &Map, law: Law<'_>, values: &Numbers<'_>) -> PyResult<usize> {
        shared(slf)?.sum(slf.py(), &map.map, &law, values, true)
    }
}
