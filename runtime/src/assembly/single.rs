//! Force and stiffness of one element by itself, as a user element of another program needs them.

use super::law::Needs;
use super::{AssemblyError, ContactLaw, ContactView};

impl ContactLaw<'_> {
    /// Writes R = f N into `nodal_forces` and K = −∂R/∂x, both triangles row by row, into `tangent`, over the element's own
    /// 3(n+1) coordinates; zeros if it carries no force. An empty slice is not wanted. Returns the force f.
    ///
    /// The entries are those that [`add_forces`](super::add_forces) and [`Triplets`](super::Triplets) make of a list of
    /// this one element, bit for bit.
    ///
    /// # Errors
    /// [`AssemblyError::OutputLength`] if a slice is neither empty nor of its size, and every reason for which the
    /// law (with one multiplier or none) or the element is refused; both slices are then unchanged.
    /// [`AssemblyError::Overflow`] if a value is not finite; their contents are then unspecified.
    ///
    /// ```
    /// use diffuse_contact::assembly::{ContactLaw, ContactView};
    ///
    /// // A slave 0.25 below one master, held apart along z.
    /// let gradient = [0.0, 0.0, 1.0, 0.0, 0.0, -1.0];
    /// let contact = ContactView { gap: -0.25, area: 1.0, gradient: &gradient, hessian: &[0.0; 21], slip: None };
    /// let (mut nodal_forces, mut tangent) = ([0.0; 6], [0.0; 36]);
    /// let force = ContactLaw::penalty(8.0).element_system(&contact, &mut nodal_forces, &mut tangent)?;
    /// assert_eq!((force, nodal_forces[2], nodal_forces[5]), (2.0, 2.0, -2.0));
    /// assert_eq!((tangent[2 * 6 + 2], tangent[2 * 6 + 5]), (8.0, -8.0));
    /// # Ok::<(), diffuse_contact::assembly::AssemblyError>(())
    /// ```
    pub fn element_system(
        &self,
        contact: &ContactView<'_>,
        nodal_forces: &mut [f64],
        tangent: &mut [f64],
    ) -> Result<f64, AssemblyError> {
        self.check(1)?;
        let freedoms = contact.gradient.len();
        let length = |what, found: usize, expected| {
            if found == 0 { Ok(()) } else { AssemblyError::check_length(what, found, expected) }
        };
        length("forces", nodal_forces.len(), freedoms)?;
        length("values", tangent.len(), freedoms * freedoms)?;
        let needs = if tangent.is_empty() { Needs::Residual } else { Needs::Tangent };
        self.check_contact(0, contact, freedoms, needs)?;
        nodal_forces.fill(0.0);
        tangent.fill(0.0);
        let Some(active) = self.active_contact(0, contact) else { return Ok(0.0) };
        let finite = |what, equation, value: f64| {
            if value.is_finite() { Ok(value) } else { Err(AssemblyError::Overflow { what, equation }) }
        };
        for (p, entry) in nodal_forces.iter_mut().enumerate() {
            // Added to zero, as a sum over elements is.
            *entry = finite("forces", p, 0.0 + active.contact_force(p))?;
        }
        if tangent.is_empty() {
            return Ok(active.force);
        }
        let mut is_finite = true;
        if !active.is_symmetric() {
            for (place, entry) in tangent.iter_mut().enumerate() {
                *entry = active.tangent(place / freedoms, place % freedoms);
                is_finite &= entry.is_finite();
            }
            return if is_finite { Ok(active.force) } else { Err(active.overflow()) };
        }
        for p in 0..freedoms {
            is_finite &= active.tangent_row(p, &mut tangent[p * freedoms..][..=p]);
            for q in 0..p {
                tangent[q * freedoms + p] = tangent[p * freedoms + q];
            }
        }
        if is_finite { Ok(active.force) } else { Err(active.overflow()) }
    }

    /// Writes K = −∂R/∂x of an element over its own 3(n+1) coordinates into `packed`, the lower triangle row by row as M has it; zeros
    /// if it carries no force. Returns the force f. The entries are those of [`element_system`](Self::element_system), bit for bit.
    ///
    /// # Errors
    /// As [`element_system`](Self::element_system); [`AssemblyError::Unsymmetric`] where friction makes the tangent
    /// unsymmetric.
    pub fn element_tangent(
        &self,
        contact: &ContactView<'_>,
        packed: &mut [f64],
    ) -> Result<f64, AssemblyError> {
        self.check(1)?;
        let freedoms = contact.gradient.len();
        AssemblyError::check_length("values", packed.len(), freedoms * (freedoms + 1) / 2)?;
        self.check_contact(0, contact, freedoms, Needs::Tangent)?;
        let Some(active) = self.active_contact(0, contact) else {
            packed.fill(0.0);
            return Ok(0.0);
        };
        if !active.is_symmetric() {
            return Err(AssemblyError::Unsymmetric);
        }
        let mut rest = packed;
        let mut is_finite = true;
        for p in 0..freedoms {
            let (row, others) = rest.split_at_mut(p + 1);
            is_finite &= active.tangent_row(p, row);
            rest = others;
        }
        if is_finite { Ok(active.force) } else { Err(active.overflow()) }
    }
}
