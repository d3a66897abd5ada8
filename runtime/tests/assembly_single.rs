//! One element has the bits of a list of one.

use diffuse_contact::assembly::{AssemblyError, ContactLaw, ContactView};
use diffuse_contact::assembly::{
    CsrPattern, DofMap, ElementView, SlipView, Tangent, Triangle, Triplets, add_forces,
};
use diffuse_contact::friction::Coulomb;

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
    let contact = ContactView { gap: -0.3, area: 0.7, gradient: &gradient, hessian: &hessian, slip: None };
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
        let slip = SlipView { half_square, opening, ..SlipView::default() };
        let slip = SlipView { gradient: &of_slip.0, hessian: &of_slip.1, ..slip };
        ContactView { gap: -0.3, area: 0.7, gradient: &gradient, hessian: &hessian, slip: Some(slip) }
    };
    let coulomb = Coulomb::new(0.2, 5.0).unwrap();
    for tangent in [Tangent::Exact, Tangent::GaussNewton] {
        let law = ContactLaw::penalty(3.1).with_tangent(tangent).with_friction(Some(coulomb));
        // Stick, slip, and stick of a contact that was open.
        for (half_square, opening, is_symmetric) in [(1e-4, 0.0, true), (0.5, 0.0, false), (1e-4, 0.1, false)]
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
    let contact = ContactView { gap: -0.3, area: 0.7, gradient: &gradient, hessian: &hessian, slip: None };
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
    assert_eq!(law.element_system(&short, &mut [], &mut [0.0; 36]).unwrap_err().code(), "derivative-length");
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
