//! Residual and tangent of an interface.

use diffuse_contact::assembly::{Triangle, Triplets, add_forces, slave_friction};
use diffuse_contact::interface::ContactRef;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyList;

use crate::arrays::{Indices, Numbers, of_triplets, slice_mut, words, writable};
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
    fn add_forces(slf: &Bound<'_, Self>, law: Law<'_>, forces: &Numbers<'_>) -> PyResult<usize> {
        let py = slf.py();
        let this = shared(slf)?;
        let own = law.own(py)?;
        let law = own.law(py)?;
        let mut forces = writable(forces)?;
        let forces = slice_mut(py, &mut forces)?;
        let (contacts, dofs) = (this.contacts(py)?, &this.dofs);
        threads::attempt(py, || add_forces(contacts, &law, dofs, forces))
    }

    /// Rows, columns and values of the tangents of all contacts that carry force, one after the other.
    fn triplets<'py>(
        slf: &Bound<'py, Self>,
        law: Law<'py>,
        lower: bool,
    ) -> PyResult<(Indices<'py>, Indices<'py>, Numbers<'py>)> {
        let py = slf.py();
        let this = shared(slf)?;
        let own = law.own(py)?;
        let law = own.law(py)?;
        let triangle = if lower { Triangle::Lower } else { Triangle::Full };
        let (contacts, dofs) = (this.contacts(py)?, &this.dofs);
        let mut triplets = Triplets::new();
        let list = &mut triplets;
        threads::attempt(py, || list.fill(contacts, &law, dofs, triangle))?;
        Ok(of_triplets(py, &triplets))
    }

    /// Normal contact force of every slave, max(0, λ − ε g) or that of a normal law; 0 where there is no contact.
    fn normal_forces<'py>(slf: &Bound<'py, Self>, law: Law<'py>) -> PyResult<Numbers<'py>> {
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
            threads::attempt(py, || contacts.iter().enumerate().map(force).collect::<Result<_, _>>())?;
        Ok(PyArray1::from_vec(py, forces))
    }

    /// Traction, state and slip of every slave.
    fn friction<'py>(
        slf: &Bound<'py, Self>,
        law: Law<'py>,
    ) -> PyResult<(Numbers<'py>, Bound<'py, PyList>, Numbers<'py>)> {
        let py = slf.py();
        let this = shared(slf)?;
        let own = law.own(py)?;
        let law = own.law(py)?;
        let contacts = this.contacts(py)?;
        let found = threads::attempt(py, || slave_friction(contacts, &law))?;
        Ok((
            PyArray1::from_vec(py, found.iter().flat_map(|slave| slave.traction).collect()),
            words(py, found.iter().map(|slave| slave.state.name()))?,
            PyArray1::from_iter(py, found.iter().map(|slave| slave.slip)),
        ))
    }
}
