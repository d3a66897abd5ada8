//! Residual and tangent of an interface.

use diffuse_contact::assembly::{Triangle, Triplets, add_forces, slave_friction};
use diffuse_contact::interface::ContactRef;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyList;

use crate::arrays::{slice_mut, words, writable};
use crate::errors::Raise;
use crate::interface::{Interface, shared};
use crate::law::Law;
use crate::threads;

#[pymethods]
impl Interface {
    /// Number of equations.
    fn equations(slf: &Bound<'_, Self>) -> PyResult<usize> {
        Ok(shared(slf)?.dofs.equations())
    }

    /// Adds the contact forces on the nodes; returns the number of contacts that carry force.
    fn add_forces(slf: &Bound<'_, Self>, law: Law<'_>, forces: &Bound<'_, PyArray1<f64>>) -> PyResult<usize> {
        let py = slf.py();
        let this = shared(slf)?;
        let own = law.own(py)?;
        let law = own.law(py)?;
        let mut forces = writable(forces)?;
        let forces = slice_mut(py, &mut forces)?;
        let (contacts, dofs) = (this.contacts(py)?, &this.dofs);
        threads::run(py, || add_forces(contacts, &law, dofs, forces)).map_err(|error| error.raise(py))
    }

    /// Rows, columns and values of the tangents of all contacts that carry force, one after the other.
    #[allow(clippy::type_complexity)]
    fn triplets<'py>(
        slf: &Bound<'py, Self>,
        law: Law<'py>,
        lower: bool,
    ) -> PyResult<(Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<f64>>)> {
        let py = slf.py();
        let this = shared(slf)?;
        let own = law.own(py)?;
        let law = own.law(py)?;
        let triangle = if lower { Triangle::Lower } else { Triangle::Full };
        let (contacts, dofs) = (this.contacts(py)?, &this.dofs);
        let mut triplets = Triplets::new();
        let list = &mut triplets;
        let filled = threads::run(py, || list.fill(contacts, &law, dofs, triangle));
        filled.map_err(|error| error.raise(py))?;
        let numbers =
            |numbers: &[usize]| PyArray1::from_iter(py, numbers.iter().map(|&number| number as i64));
        Ok((
            numbers(triplets.rows()),
            numbers(triplets.columns()),
            PyArray1::from_slice(py, triplets.values()),
        ))
    }

    /// Normal contact force of every slave, max(0, λ − ε g) or that of a normal law; 0 where there is no contact.
    fn normal_forces<'py>(slf: &Bound<'py, Self>, law: Law<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let py = slf.py();
        let this = shared(slf)?;
        let own = law.own(py)?;
        let law = own.law(py)?;
        let contacts = this.contacts(py)?;
        law.validate_for(contacts).map_err(|error| error.raise(py))?;
        let force = |(element, contact): (usize, ContactRef<'_>)| {
            let (gap, area) = (contact.point.gap, contact.area);
            if !contact.outcome.is_contact() {
                return Ok(0.0);
            }
            law.checked_normal_force(element, gap, area).map(|at| at.force)
        };
        let forces =
            threads::run(py, || contacts.iter().enumerate().map(force).collect::<Result<Vec<f64>, _>>());
        Ok(PyArray1::from_vec(py, forces.map_err(|error| error.raise(py))?))
    }

    /// Traction, state and slip of every slave.
    #[allow(clippy::type_complexity)]
    fn friction<'py>(
        slf: &Bound<'py, Self>,
        law: Law<'py>,
    ) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyList>, Bound<'py, PyArray1<f64>>)> {
        let py = slf.py();
        let this = shared(slf)?;
        let own = law.own(py)?;
        let law = own.law(py)?;
        let contacts = this.contacts(py)?;
        let found = threads::run(py, || slave_friction(contacts, &law)).map_err(|error| error.raise(py))?;
        Ok((
            PyArray1::from_vec(py, found.iter().flat_map(|slave| slave.traction).collect()),
            words(py, found.iter().map(|slave| slave.state.name()))?,
            PyArray1::from_iter(py, found.iter().map(|slave| slave.slip)),
        ))
    }
}
