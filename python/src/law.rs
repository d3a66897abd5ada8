//! Laws of contact: objects of Python become those of the library.

use diffuse_contact::assembly::{ContactLaw, TabulatedPressure};
use diffuse_contact::friction::{
    Coulomb, DecayingCoefficient, FrictionCoefficient, FrictionError, TabulatedCoefficient,
};
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;

use crate::arrays::{Numbers, readable, slice};
use crate::errors::{self, Raise};
use crate::options;

/// A contact law, attributes of the Python object `_Law`.
#[derive(FromPyObject)]
pub struct Law<'py> {
    penalty: f64,
    /// One per slave.
    multipliers: Option<Numbers<'py>>,
    /// The name of the tangent.
    tangent: String,
    friction: Option<Friction<'py>>,
    /// Gaps and pressures.
    normal: Option<(Numbers<'py>, Numbers<'py>)>,
}

/// Attributes of the Python object `_Friction`.
#[derive(FromPyObject)]
struct Friction<'py> {
    coefficient: Coefficient<'py>,
    stiffness: f64,
    shear_limit: Option<f64>,
    duration: Option<f64>,
    augmented: bool,
}

#[derive(FromPyObject)]
enum Coefficient<'py> {
    Constant(f64),
    /// Pressures, rates, coefficients. Before numbers: an array of one number is taken for that number.
    Tabulated(Numbers<'py>, Numbers<'py>, Numbers<'py>),
    /// At rest, in motion, decay.
    Decaying(f64, f64, f64),
}

/// What a law refers to.
pub struct OwnedLaw<'a, 'py> {
    law: &'a Law<'py>,
    multipliers: Option<PyReadonlyArray1<'py, f64>>,
    normal: Option<TabulatedPressure>,
    /// A coefficient that is no constant.
    coefficient: Option<Box<dyn FrictionCoefficient>>,
}

fn of_friction(py: Python<'_>, error: FrictionError) -> PyErr {
    errors::exception(py, "AssemblyError", error.code(), &error.to_string())
}

impl<'py> Law<'py> {
    /// Reads the arrays.
    pub fn own(&self, py: Python<'py>) -> PyResult<OwnedLaw<'_, 'py>> {
        let multipliers = self.multipliers.as_ref().map(readable).transpose()?;
        let pressures = |(gaps, pressures): &(Numbers<'py>, Numbers<'py>)| {
            let (gaps, pressures) = (readable(gaps)?, readable(pressures)?);
            TabulatedPressure::new(slice(py, &gaps)?, slice(py, &pressures)?).map_err(|error| error.raise(py))
        };
        let normal = self.normal.as_ref().map(pressures).transpose()?;
        let coefficient = match &self.friction {
            Some(friction) => friction.coefficient.variable(py)?,
            None => None,
        };
        Ok(OwnedLaw { law: self, multipliers, normal, coefficient })
    }
}

impl Coefficient<'_> {
    fn variable(&self, py: Python<'_>) -> PyResult<Option<Box<dyn FrictionCoefficient>>> {
        Ok(match self {
            Self::Constant(_) => None,
            &Self::Decaying(at_rest, in_motion, decay) => {
                let made = DecayingCoefficient::new(at_rest, in_motion, decay);
                Some(Box::new(made.map_err(|error| of_friction(py, error))?))
            }
            Self::Tabulated(pressures, rates, coefficients) => {
                let [pressures, rates, coefficients] =
                    [readable(pressures)?, readable(rates)?, readable(coefficients)?];
                let [pressures, rates, coefficients] =
                    [slice(py, &pressures)?, slice(py, &rates)?, slice(py, &coefficients)?];
                let made = TabulatedCoefficient::new(pressures, rates, coefficients);
                Some(Box::new(made.map_err(|error| of_friction(py, error))?))
            }
        })
    }
}

impl OwnedLaw<'_, '_> {
    /// The law.
    pub fn law(&self, py: Python<'_>) -> PyResult<ContactLaw<'_>> {
        let multipliers = self.multipliers.as_ref().map(|array| slice(py, array)).transpose()?;
        let law = ContactLaw::penalty(self.law.penalty)
            .with_multipliers(multipliers)
            .with_tangent(options::tangent(py, &self.law.tangent)?)
            .with_normal(self.normal.as_ref().map(|table| table as _));
        let Some(friction) = &self.law.friction else { return Ok(law) };
        let made = match (&friction.coefficient, &self.coefficient) {
            (&Coefficient::Constant(coefficient), _) => Coulomb::new(coefficient, friction.stiffness),
            (_, Some(coefficient)) => {
                let missing = || {
                    let sentence = "duration is missing: the coefficient may depend on the speed";
                    errors::exception(py, "AssemblyError", "invalid-duration", sentence)
                };
                let duration = friction.duration.ok_or_else(missing)?;
                Coulomb::variable(&**coefficient, duration, friction.stiffness)
            }
            (_, None) => return Ok(law),
        };
        let made = made.and_then(|made| made.with_shear_limit(friction.shear_limit));
        let made = made.map_err(|error| of_friction(py, error))?;
        Ok(law.with_friction(Some(made.with_augmentation(friction.augmented))))
    }
}

/// Refuses what is no law.
#[pyfunction]
pub fn check_law(py: Python<'_>, law: Law<'_>) -> PyResult<()> {
    law.own(py)?.law(py).map(drop)
}
