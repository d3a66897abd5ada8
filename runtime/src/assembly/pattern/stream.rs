//! Summing tangents of an interface whose second derivatives nobody holds.

use super::super::law::Needs;
use super::super::{AssemblyError, ContactLaw, Elements, Tangent, reserve};
use super::CsrMap;
use crate::Mode;
use crate::interface::{ContactInterface, InterfaceError, Results};

impl CsrMap {
    /// As [`fill`](Self::fill) of the contacts of an interface, which were evaluated at its present positions in [`Mode::Gradient`]: M of
    /// what carries force is evaluated some hundred slaves at a time, added and forgotten. A packed M over 16 masters takes 10.6 kB, so
    /// this takes less memory than [`Mode::Hessian`]. The numbers are the same, bit for bit.
    ///
    /// # Errors
    /// As [`fill`](Self::fill), as [`InterfaceError::Law`]: [`AssemblyError::PatternMismatch`] also where lists have been made anew since
    /// the evaluation; [`AssemblyError::DerivativeLength`] for contacts that were evaluated in
    /// [`Mode::Value`]; [`InterfaceError::OutOfMemory`], after which the contents of `values` are unspecified, too.
    pub fn fill_from(
        &self,
        interface: &ContactInterface,
        law: &ContactLaw<'_>,
        values: &mut [f64],
    ) -> Result<usize, InterfaceError> {
        self.sum_from(interface, law, values, true)
    }

    /// As [`fill_from`](Self::fill_from), but adds to what is there.
    ///
    /// # Errors
    /// As [`fill_from`](Self::fill_from).
    pub fn add_from(
        &self,
        interface: &ContactInterface,
        law: &ContactLaw<'_>,
        values: &mut [f64],
    ) -> Result<usize, InterfaceError> {
        self.sum_from(interface, law, values, false)
    }

    fn sum_from(
        &self,
        interface: &ContactInterface,
        law: &ContactLaw<'_>,
        values: &mut [f64],
        from_zero: bool,
    ) -> Result<usize, InterfaceError> {
        let contacts = interface.contacts();
        if let Some(element) = interface.listed_anew() {
            return Err(AssemblyError::PatternMismatch { element }.into());
        }
        let needs_second = law.tangent == Tangent::Exact || law.friction.is_some();
        if !needs_second || contacts.mode() >= Mode::Hessian {
            let summed =
                if from_zero { self.fill(contacts, law, values) } else { self.add(contacts, law, values) };
            return Ok(summed?);
        }
        AssemblyError::check_length("values", values.len(), self.entries())?;
        self.check_elements(contacts)?;
        let loaded = loaded(contacts, law)?;
        let mut results = Results::default();
        for (elements, batch) in self.batches() {
            if !loaded[elements.clone()].contains(&true) {
                if from_zero {
                    self.add_batch(batch, &|_| None, values, true)?;
                }
                continue;
            }
            let contact = interface.evaluate_loaded(elements, Mode::Hessian, &|k| loaded[k], &mut results)?;
            let active = |k: usize| {
                let view = contact(k).view().filter(|_| loaded[k])?;
                law.active_contact(k, &view)
            };
            self.add_batch(batch, &active, values, from_zero)?;
        }
        Ok(loaded.into_iter().filter(|is_loaded| *is_loaded).count())
    }
}

/// Which elements carry force; none of them has to be refused then.
fn loaded<E: Elements + ?Sized>(elements: &E, law: &ContactLaw<'_>) -> Result<Vec<bool>, AssemblyError> {
    law.check_for(elements)?;
    let mut loaded = reserve("elements", elements.len())?;
    for k in 0..elements.len() {
        law.check_element(k, &elements.element(k), Needs::Residual)?;
        loaded.push(law.active(elements, k).is_some());
    }
    Ok(loaded)
}
