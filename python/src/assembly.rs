//! Residual and tangent of an interface.

use diffuse_contact::assembly::{AssemblyError, ContactLaw, Triangle, Triplets, add_residual};
use diffuse_contact::friction::Coulomb;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::arrays::{readable, slice, slice_mut, writable};
use crate::errors::Raise;
use crate::interface::{Interface, shared};
use crate::{errors, options, threads};

/// Penalty, multipliers (one per slave), the name of the tangent, and coefficient, stiffness and shear limit of friction: attributes
/// of the Python object `_Law`.
#[derive(FromPyObject)]
pub struct Law<'py> {
    penalty: f64,
    multipliers: Option<Bound<'py, PyArray1<f64>>>,
    tangent: String,
    friction: Option<(f64, f64, Option<f64>)>,
}

impl<'py> Law<'py> {
    pub fn multipliers(&self) -> PyResult<Option<PyReadonlyArray1<'py, f64>>> {
        self.multipliers.as_ref().map(readable).transpose()
    }

    pub fn law<'a>(
        &self,
        py: Python<'_>,
        multipliers: Option<&'a PyReadonlyArray1<'_, f64>>,
    ) -> PyResult<ContactLaw<'a>> {
        let multipliers = multipliers.map(|array| slice(py, array)).transpose()?;
        let law = options::law(py, self.penalty, multipliers, &self.tangent)?;
        let Some((coefficient, stiffness, limit)) = self.friction else { return Ok(law) };
        let friction = Coulomb::new(coefficient, stiffness)
            .and_then(|friction| friction.with_shear_limit(limit))
            .map_err(|error| errors::exception(py, "AssemblyError", error.code(), &error.to_string()))?;
        Ok(law.with_friction(Some(friction)))
    }
}

#[pymethods]
impl Interface {
    /// Number of equations.
    fn equations(slf: &Bound<'_, Self>) -> PyResult<usize> {
        Ok(shared(slf)?.dofs.equations())
    }

    /// Adds the contact forces on the nodes; returns the number of contacts that carry force.
    fn add_residual(
        slf: &Bound<'_, Self>,
        law: Law<'_>,
        residual: &Bound<'_, PyArray1<f64>>,
    ) -> PyResult<usize> {
        let py = slf.py();
        let this = shared(slf)?;
        let multipliers = law.multipliers()?;
        let law = law.law(py, multipliers.as_ref())?;
        let mut residual = writable(residual)?;
        let residual = slice_mut(py, &mut residual)?;
        let (contacts, dofs) = (this.contacts(py)?, &this.dofs);
        threads::run(py, || add_residual(contacts, &law, dofs, residual))?.map_err(|error| error.raise(py))
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
        let multipliers = law.multipliers()?;
        let law = law.law(py, multipliers.as_ref())?;
        let triangle = if lower { Triangle::Lower } else { Triangle::Full };
        let (contacts, dofs) = (this.contacts(py)?, &this.dofs);
        let mut triplets = Triplets::new();
        let list = &mut triplets;
        let filled = threads::run(py, || list.fill(contacts, &law, dofs, triangle))?;
        filled.map_err(|error| error.raise(py))?;
        let numbers =
            |numbers: &[usize]| PyArray1::from_iter(py, numbers.iter().map(|&number| number as i64));
        Ok((
            numbers(triplets.rows()),
            numbers(triplets.columns()),
            PyArray1::from_slice(py, triplets.values()),
        ))
    }

    /// Normal contact force of every slave, max(0, λ − ε g); 0 where there is no contact.
    fn normal_forces<'py>(slf: &Bound<'py, Self>, law: Law<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let py = slf.py();
        let this = shared(slf)?;
        let multipliers = law.multipliers()?;
        let law = law.law(py, multipliers.as_ref())?;
        let contacts = this.contacts(py)?;
        let elements = contacts.len();
        let error = match law.multipliers {
            Some(multipliers) if multipliers.len() != elements => {
                Some(AssemblyError::MultiplierCount { found: multipliers.len(), elements })
            }
            Some(multipliers) => multipliers
                .iter()
                .position(|value| !(*value >= 0.0 && value.is_finite()))
                .map(|element| AssemblyError::InvalidMultiplier { element, value: multipliers[element] }),
            None => None,
        };
        let value = law.penalty;
        let penalty =
            (!(value > 0.0 && value.is_finite())).then_some(AssemblyError::InvalidPenalty { value });
        if let Some(error) = penalty.or(error) {
            return Err(error.raise(py));
        }
        let mut forces = Vec::with_capacity(elements);
        for (element, contact) in contacts.iter().enumerate() {
            let (gap, area) = (contact.point.gap, contact.area);
            let force = if contact.outcome.is_contact() { law.force(element, gap, area) } else { 0.0 };
            if !force.is_finite() {
                return Err(AssemblyError::ForceOverflow { element, penalty: value, area, gap }.raise(py));
            }
            forces.push(force);
        }
        Ok(PyArray1::from_vec(py, forces))
    }
}
