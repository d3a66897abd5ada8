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
            let wrong = AssemblyError::OutputLength { what, found, expected };
            if found == 0 || found == expected { Ok(()) } else { Err(wrong) }
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
        let (found, expected) = (packed.len(), freedoms * (freedoms + 1) / 2);
        if found != expected {
            return Err(AssemblyError::OutputLength { what: "values", found, expected });
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::{
        CsrPattern, DofMap, ElementView, SlipView, Tangent, Triangle, Triplets, add_forces,
    };
    use crate::friction::Coulomb;

    /// Some numbers of an element with one master.
    fn numbers(count: usize) -> Vec<f64> {
        (0..count).map(|k| (k as f64 + 0.3).sin()).collect()
    }

    /// Residual and tangent of a list of one element are those of the element, and symmetric if the law says so.
    fn assert_alike(law: &ContactLaw<'_>, contact: ContactView<'_>) -> Vec<f64> {
        let elements = [ElementView { slave: 0, masters: &[1], contact: Some(contact) }];
        let dofs = DofMap::standard(2);
        let mut listed = vec![0.0; 6];
        add_forces(elements.as_slice(), law, &dofs, &mut listed).unwrap();
        let mut triplets = Triplets::new();
        triplets.fill(elements.as_slice(), law, &dofs, Triangle::Full).unwrap();
        let (mut nodal_forces, mut matrix) = (vec![9.0; 6], vec![9.0; 36]);
        let force = law.element_system(&contact, &mut nodal_forces, &mut matrix).unwrap();
        assert_eq!(force, law.force(0, contact.gap, contact.area));
        assert_eq!(nodal_forces, listed);
        assert_eq!(matrix, triplets.values());
        let pattern = CsrPattern::union(elements.as_slice(), &dofs).unwrap();
        let mut values = vec![0.0; pattern.entries()];
        pattern.fill(elements.as_slice(), law, &mut values).unwrap();
        for p in 0..6 {
            for q in 0..6 {
                assert_eq!(values[pattern.position(p, q).unwrap()], matrix[6 * p + q], "{p} {q}");
            }
        }
        let mut packed = vec![9.0; 21];
        let is_symmetric = (0..36).all(|k| matrix[k] == matrix[6 * (k % 6) + k / 6]);
        if is_symmetric {
            assert_eq!(law.element_tangent(&contact, &mut packed), Ok(force));
            let lower = (0..6).flat_map(|p| matrix[6 * p..][..=p].iter().copied());
            assert_eq!(packed, lower.collect::<Vec<f64>>());
        } else {
            assert_eq!(law.element_tangent(&contact, &mut packed), Err(AssemblyError::Unsymmetric));
        }
        if !law.is_symmetric() {
            let lower = triplets.fill(elements.as_slice(), law, &dofs, Triangle::Lower);
            assert_eq!(lower, Err(AssemblyError::Unsymmetric));
        }
        matrix
    }

    #[test]
    fn one_element_has_the_bits_of_a_list_of_one() {
        let (gradient, hessian) = (numbers(6), numbers(21));
        let contact =
            ContactView { gap: -0.3, area: 0.7, gradient: &gradient, hessian: &hessian, slip: None };
        for tangent in [Tangent::Exact, Tangent::GaussNewton] {
            for multiplier in [0.0, 0.4] {
                let multipliers = [multiplier];
                let law = ContactLaw::penalty(3.1).with_multipliers(Some(&multipliers)).with_tangent(tangent);
                assert_alike(&law, contact);
            }
        }
    }

    #[test]
    fn friction_has_its_part_in_force_and_tangent() {
        let (gradient, hessian) = (numbers(6), numbers(21));
        let of_slip = (numbers(12).split_off(6), numbers(42).split_off(21));
        let with_slip = |half_square, opening| {
            let slip = SlipView { half_square, opening, gradient: &of_slip.0, hessian: &of_slip.1 };
            ContactView { gap: -0.3, area: 0.7, gradient: &gradient, hessian: &hessian, slip: Some(slip) }
        };
        let coulomb = Coulomb::new(0.2, 5.0).unwrap();
        for tangent in [Tangent::Exact, Tangent::GaussNewton] {
            let law = ContactLaw::penalty(3.1).with_tangent(tangent).with_friction(Some(coulomb));
            // Stick, slip, and stick of a contact that was open.
            for (half_square, opening, is_symmetric) in
                [(1e-4, 0.0, true), (0.5, 0.0, false), (1e-4, 0.1, false)]
            {
                let contact = with_slip(half_square, opening);
                let matrix = assert_alike(&law, contact);
                let turned = |p: usize, q: usize| (matrix[6 * p + q] - matrix[6 * q + p]).abs();
                let largest = (0..36).map(|k| turned(k / 6, k % 6)).fold(0.0, f64::max);
                let is_symmetric = is_symmetric || tangent == Tangent::GaussNewton;
                assert_eq!(largest < 1e-12, is_symmetric, "{largest:e}");
                // Without friction it is another matrix.
                let without = assert_alike(&law.with_friction(None), contact);
                assert!(matrix.iter().zip(&without).all(|(with, without)| with != without));
            }
        }
        // A coefficient of 0 leaves every bit, and the symmetry.
        let law = ContactLaw::penalty(3.1).with_friction(Some(Coulomb::new(0.0, 5.0).unwrap()));
        assert_eq!(law, ContactLaw::penalty(3.1));
    }

    #[test]
    fn friction_asks_for_slips_but_not_of_a_slave_without_an_anchor() {
        let (gradient, hessian) = (numbers(6), numbers(21));
        let contact =
            ContactView { gap: -0.3, area: 0.7, gradient: &gradient, hessian: &hessian, slip: None };
        let law = ContactLaw::penalty(3.1).with_friction(Some(Coulomb::new(0.2, 5.0).unwrap()));
        let mut nodal_forces = [0.0; 6];
        let system = |contact: &ContactView<'_>, nodal_forces: &mut [f64]| {
            law.element_system(contact, nodal_forces, &mut [])
        };
        assert_eq!(system(&contact, &mut nodal_forces), Err(AssemblyError::NoSlip { element: 0 }));
        let open = ContactView { gap: 0.3, ..contact };
        assert_eq!(system(&open, &mut nodal_forces), Ok(0.0));
        let first = ContactView { slip: Some(SlipView::default()), ..contact };
        let force = system(&first, &mut nodal_forces).unwrap();
        assert_eq!(nodal_forces.to_vec(), gradient.iter().map(|n| force * n).collect::<Vec<f64>>());
        let short = SlipView { half_square: 1.0, gradient: &gradient[..5], ..SlipView::default() };
        let wrong = system(&ContactView { slip: Some(short), ..contact }, &mut nodal_forces).unwrap_err();
        assert_eq!(wrong.code(), "derivative-length");
        let nan = SlipView { half_square: f64::NAN, gradient: &gradient, ..SlipView::default() };
        let wrong = system(&ContactView { slip: Some(nan), ..contact }, &mut nodal_forces).unwrap_err();
        assert_eq!(wrong.code(), "invalid-slip");
    }

    #[test]
    fn what_does_not_fit_is_refused_and_what_is_apart_is_zero() {
        let (gradient, hessian) = (numbers(6), numbers(21));
        let contact = ContactView { gap: 0.1, area: 1.0, gradient: &gradient, hessian: &hessian, slip: None };
        let law = ContactLaw::penalty(2.0);
        let mut nodal_forces = [1.0; 6];
        assert_eq!(law.element_system(&contact, &mut nodal_forces, &mut []), Ok(0.0));
        assert_eq!(nodal_forces, [0.0; 6]);
        let mut packed = [1.0; 21];
        assert_eq!(law.element_tangent(&contact, &mut packed), Ok(0.0));
        assert_eq!(packed, [0.0; 21]);
        let wrong = law.element_tangent(&contact, &mut packed[..20]).unwrap_err();
        assert_eq!(wrong, AssemblyError::OutputLength { what: "values", found: 20, expected: 21 });
        let wrong = law.element_system(&contact, &mut nodal_forces[..5], &mut []).unwrap_err();
        assert_eq!(wrong, AssemblyError::OutputLength { what: "forces", found: 5, expected: 6 });
        let short = ContactView { gap: -0.1, hessian: &hessian[..20], ..contact };
        assert_eq!(
            law.element_system(&short, &mut [], &mut [0.0; 36]).unwrap_err().code(),
            "derivative-length"
        );
        let nan = ContactView { gap: f64::NAN, ..contact };
        assert_eq!(law.element_system(&nan, &mut [], &mut []).unwrap_err().code(), "invalid-gap");
        let infinite = ContactView { gap: -0.1, gradient: &[f64::INFINITY; 6], ..contact };
        assert_eq!(law.element_system(&infinite, &mut nodal_forces, &mut []).unwrap_err().code(), "overflow");
        // The first equation with such an entry, although the lower triangle has it in a later row.
        let mut large = hessian.clone();
        large[4 * 5 / 2 + 2] = f64::INFINITY;
        let contact = ContactView { gap: -0.1, hessian: &large, ..contact };
        let overflow = AssemblyError::Overflow { what: "values", equation: 2 };
        assert_eq!(law.element_system(&contact, &mut [], &mut [0.0; 36]), Err(overflow));
        assert_eq!(law.element_tangent(&contact, &mut packed), Err(overflow));
    }
}
