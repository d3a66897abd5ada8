//! The C functions give the numbers of the runtime, bit for bit.

use std::ptr::{null, null_mut};

use runtime::assembly::{ContactLaw, DofMap, Tangent, Triangle, Triplets, add_forces};
use runtime::interface::InterfaceOptions;
use runtime::{Element, Frame, FrameDerivative, Generated, Mode, Weight};

use super::Mesh;
use crate::assembly::{dc_add_forces, dc_triplets};
use crate::batch::dc_gap_batch;
use crate::contacts::{dc_contact, dc_contact_of, dc_derivatives, dc_forces};
use crate::element::{dc_element, dc_gap, dc_point};
use crate::interface::{dc_destroy, dc_evaluate, dc_refresh, dc_slaves};
use crate::law::{dc_adaptive_tangent, dc_law};
use crate::neighbours::{dc_pair, dc_pairing};
use crate::status::{DC_BAD_SIZE, DC_NO_CONTACT, DC_OK};

#[test]
fn an_interface_gives_what_the_runtime_gives() {
    let mesh = Mesh::new();
    let mut expected = mesh.of_runtime(InterfaceOptions::default().with_areas(true));
    expected.refresh_pairing(mesh.points()).unwrap();
    let expected = expected.evaluate(Mode::Hessian).unwrap();

    let options = crate::options::dc_options { areas: 1, ..super::options() };
    let (status, handle) = mesh.make(&options);
    assert_eq!(status, DC_OK);
    let multipliers = [0.0, 0.3, 2.0, 0.1];
    let law = dc_law {
        size: size_of::<dc_law>(),
        penalty: 1e3,
        multipliers: multipliers.as_ptr(),
        multiplier_count: 4,
        tangent: 0,
        reserved: 0,
        friction: 0.0,
        tangential_stiffness: 0.0,
        shear_limit: 0.0,
        ..dc_law::NONE
    };
    let own_law = ContactLaw::penalty(1e3).with_multipliers(Some(&multipliers));
    // SAFETY: the arrays have the lengths given.
    unsafe {
        assert_eq!(dc_refresh(handle, mesh.positions.as_ptr(), 40, null_mut()), DC_OK);
        assert_eq!(dc_evaluate(handle, 2), DC_OK);
        let mut slaves = [-1; 4];
        assert_eq!(dc_slaves(handle, slaves.as_mut_ptr(), 4), DC_OK);
        assert_eq!(slaves, mesh.slaves[..]);
        for (k, contact) in expected.iter().enumerate() {
            let mut found = dc_contact::default();
            assert_eq!(dc_contact_of(handle, k, &mut found), DC_OK);
            assert_eq!((found.gap, found.foot), (contact.point.gap, contact.point.foot));
            assert_eq!((found.normal, found.area), (contact.point.normal, contact.area));
            let mut nodes = vec![0; contact.nodes.len() + 1];
            let mut gradient = vec![0.0; contact.gradient.len()];
            let mut hessian = vec![0.0; contact.hessian.len()];
            let status = dc_derivatives(
                handle,
                k,
                nodes.as_mut_ptr(),
                nodes.len(),
                gradient.as_mut_ptr(),
                gradient.len(),
                hessian.as_mut_ptr(),
                hessian.len(),
            );
            assert_eq!(status, DC_OK);
            assert_eq!((nodes[0] as usize, nodes[1] as u32), (contact.slave, contact.nodes[0]));
            assert_eq!((gradient.as_slice(), hessian.as_slice()), (contact.gradient, contact.hessian));
        }
        let dofs = DofMap::standard(40);
        let (mut residual, mut own) = (vec![0.0; 120], vec![0.0; 120]);
        let mut active = 0;
        assert_eq!(dc_add_forces(handle, &law, residual.as_mut_ptr(), 120, &mut active), DC_OK);
        assert_eq!(active, add_forces(expected, &own_law, &dofs, &mut own).unwrap());
        assert_eq!(residual, own);
        let mut triplets = Triplets::new();
        triplets.fill(expected, &own_law, &dofs, Triangle::Lower).unwrap();
        let mut count = 0;
        assert_eq!(dc_triplets(handle, &law, 1, null_mut(), null_mut(), null_mut(), 0, &mut count), DC_OK);
        assert_eq!(count, triplets.len());
        let (mut rows, mut values) = (vec![0; count], vec![0.0; count]);
        let status = dc_triplets(
            handle,
            &law,
            1,
            rows.as_mut_ptr(),
            null_mut(),
            values.as_mut_ptr(),
            count,
            &mut count,
        );
        assert_eq!(status, DC_OK);
        assert_eq!(values, triplets.values());
        assert!(rows.iter().zip(triplets.rows()).all(|(found, expected)| *found as usize == *expected));
        // The update of the augmented Lagrangian, in place.
        let mut forces = multipliers;
        let law = dc_law { multipliers: forces.as_ptr(), ..law };
        assert_eq!(dc_forces(handle, &law, null_mut(), forces.as_mut_ptr(), null_mut(), 4), DC_OK);
        for (k, contact) in expected.iter().enumerate() {
            assert_eq!(forces[k], own_law.force(k, contact.point.gap, contact.area));
        }
    }
    assert_eq!(dc_destroy(handle), DC_OK);
}

#[test]
fn single_elements_and_batches_give_what_the_runtime_gives() {
    let mesh = Mesh::new();
    let candidates = &mesh.positions[..3 * 36];
    let slave = [2.4, 2.3, -0.02];
    let mut masters = [0; 36];
    // SAFETY: numbers, of which any bits are a value.
    let mut pairing = dc_pairing { size: size_of::<dc_pairing>(), ..unsafe { std::mem::zeroed() } };
    let mut pair = |slave: [f64; 3], capacity: usize| {
        let outward = [0.0, 0.0, 1.0];
        // SAFETY: the arrays have the lengths given.
        let status = unsafe {
            dc_pair(
                null(),
                slave.as_ptr(),
                candidates.as_ptr(),
                36,
                outward.as_ptr(),
                masters.as_mut_ptr(),
                capacity,
                &mut pairing,
            )
        };
        (status, pairing, masters)
    };
    assert_eq!(pair(slave, 3).0, DC_BAD_SIZE);
    let (status, pairing, masters) = pair(slave, 36);
    assert_eq!((status, pairing.encloses_slave, pairing.basis), (DC_OK, 1, 2));
    let masters = &masters[..pairing.master_count as usize];
    assert!(masters.windows(2).all(|pair| pair[0] < pair[1]));
    let own: Vec<[f64; 3]> = masters.iter().map(|&k| mesh.positions.as_chunks::<3>().0[k as usize]).collect();

    let (n, element_count) = (own.len(), 3);
    let freedoms = 3 * (n + 1);
    let packed = freedoms * (freedoms + 1) / 2;
    for (frame, derivative) in [(0, FrameDerivative::CoMoving), (1, FrameDerivative::Held)] {
        let element = dc_element {
            size: size_of::<dc_element>(),
            basis: pairing.basis,
            weight: 1,
            frame,
            reserved: 0,
            support_radius: pairing.support_radius,
            outward: pairing.normal,
            t1: [0.0; 3],
            t2: [0.0; 3],
            normal: [0.0; 3],
        };
        let expected = Element::new(
            slave,
            &own,
            Frame { derivative, ..Frame::average_plane(&own, pairing.normal).unwrap() },
            pairing.support_radius,
        )
        .with_basis(runtime::Basis::Quadratic)
        .with_weight(Weight::CubicInterpolating);
        let (mut gradient, mut hessian) = (vec![0.0; freedoms], vec![0.0; packed]);
        let point = Generated.gap_into(&expected, Mode::Hessian, &mut gradient, &mut hessian).unwrap();
        let (mut found, mut found_gradient, mut found_hessian) =
            (dc_point::default(), vec![0.0; freedoms], vec![0.0; packed]);
        // SAFETY: the arrays have the lengths given.
        let status = unsafe {
            dc_gap(
                &element,
                slave.as_ptr(),
                own.as_ptr().cast(),
                n,
                2,
                &mut found,
                found_gradient.as_mut_ptr(),
                freedoms,
                found_hessian.as_mut_ptr(),
                packed,
            )
        };
        assert_eq!(
            (status, found.gap, found.foot, found.normal),
            (DC_OK, point.gap, point.foot, point.normal)
        );
        assert_eq!((&found_gradient, &found_hessian), (&gradient, &hessian));

        // The same one among others that differ in place or fail; neighbours make no difference.
        let slaves = [slave, [2.4, 2.3, f64::NAN], [2.6, 2.2, 0.1]].concat();
        let all = [own.as_slice(), own.as_slice(), own.as_slice()].concat();
        let offsets = [0, n, 2 * n, 3 * n];
        let mut points = [dc_point::default(); 3];
        let (mut gradients, mut hessians) = (vec![9.0; 3 * freedoms], vec![9.0; 3 * packed]);
        // SAFETY: the arrays have the lengths given.
        let status = unsafe {
            dc_gap_batch(
                &element,
                element_count,
                null(),
                null(),
                slaves.as_ptr(),
                all.as_ptr().cast(),
                offsets.as_ptr(),
                2,
                points.as_mut_ptr(),
                gradients.as_mut_ptr(),
                3 * freedoms,
                hessians.as_mut_ptr(),
                3 * packed,
            )
        };
        assert_eq!((status, points.map(|point| point.outcome)), (DC_OK, [0, 15, 0]));
        // Shapes differ by rounding.
        assert!((points[0].gap - point.gap).abs() < 1e-13);
        assert!(gradients.iter().zip(&gradient).all(|(x, y)| (x - y).abs() < 1e-11));
        assert!(gradients[freedoms..2 * freedoms].iter().all(|x| *x == 0.0));
        assert!(hessians[packed..2 * packed].iter().all(|x| *x == 0.0));
    }
    let far = pair([2.4, 2.3, f64::INFINITY], 36).0;
    assert_ne!(far, DC_OK);
    // Six candidates on two lines carry no quadratic, and two carry nothing.
    let mut few = [0; 2];
    // SAFETY: the arrays have the lengths given.
    let status = unsafe {
        let outward = [0.0, 0.0, 1.0];
        let candidates = candidates.as_ptr();
        let mut pairing = pairing;
        dc_pair(null(), slave.as_ptr(), candidates, 2, outward.as_ptr(), few.as_mut_ptr(), 2, &mut pairing)
    };
    assert_eq!(status, DC_NO_CONTACT);
}

#[test]
fn the_adaptive_tangent_is_that_of_the_runtime() {
    let ratio = Tangent::ADAPTIVE_RATIO;
    let residuals =
        [0.0, 1e-300, ratio.next_down(), ratio, ratio.next_up(), 1.0, 3e5, f64::INFINITY, f64::NAN];
    let mut found = [0; 2];
    for residual in residuals {
        for force in [0.0, 1e-300, 1.0, 1e6, f64::INFINITY, f64::NAN] {
            let tangent = dc_adaptive_tangent(residual, force);
            let expected = [Tangent::Exact, Tangent::GaussNewton][tangent as usize];
            assert_eq!(expected, Tangent::adaptive(residual, force), "{residual} {force}");
            found[tangent as usize] += 1;
        }
    }
    assert!(found.iter().all(|&count| count > 10), "{found:?}");
    assert_eq!([ratio, ratio.next_up()].map(|residual| dc_adaptive_tangent(residual, 1.0)), [0, 1]);
}
