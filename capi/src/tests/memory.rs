//! The caller's memory: arrays that overlap, arrays and results that are as they were after a refusal, patterns of other equations.

use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

use super::faces::{Pair, law};
use super::misuse::{LAW, dc_report_of_size, refreshed};
use super::{Mesh, message};
use crate::assembly::{dc_add_forces, dc_triplets};
use crate::batch::dc_gap_batch;
use crate::contacts::{dc_derivatives, dc_forces, dc_gaps};
use crate::element::{dc_element, dc_element_system, dc_gap, dc_point};
use crate::faces::{dc_faces_contacts, dc_faces_destroy, dc_faces_evaluate, dc_faces_refresh};
use crate::interface::{
    dc_counts, dc_destroy, dc_evaluate, dc_interface, dc_refresh, dc_report, dc_set_equations,
};
use crate::law::dc_law;
use crate::neighbours::{dc_pair, dc_pairing};
use crate::pattern::{
    dc_pattern, dc_pattern_create, dc_pattern_destroy, dc_pattern_fill, dc_pattern_structure,
};
use crate::status::*;

fn evaluated(mesh: &Mesh) -> *mut dc_interface {
    let handle = refreshed(mesh);
    assert_eq!(dc_evaluate(handle, 2), DC_OK);
    handle
}

/// Refused, with a sentence that names both.
fn overlap(status: dc_status, one: &str, other: &str) {
    assert_eq!(status, DC_BAD_POINTER, "{one}, {other}: {}", message());
    assert_eq!(message(), format!("bad-pointer: {one} and {other} overlap"));
}

/// A sound element over nine masters, slave first among the positions.
fn element() -> (dc_element, Vec<f64>) {
    // SAFETY: numbers, of which any bits are a value.
    let zeros: dc_element = unsafe { std::mem::zeroed() };
    let element =
        dc_element { size: size_of::<dc_element>(), support_radius: 2.0, outward: [0.0, 0.0, 1.0], ..zeros };
    let masters = (0..9).flat_map(|k| [f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0, 0.0]);
    (element, [0.1, 0.2, 0.25].into_iter().chain(masters).collect())
}

#[test]
fn arrays_that_overlap_are_refused() {
    let mesh = Mesh::new();
    let handle = evaluated(&mesh);
    let mut numbers = vec![0.0_f64; 4000];
    let base = numbers.as_mut_ptr();
    let at = |k: usize| base.wrapping_add(k);
    let mut count = 0;
    // SAFETY: the arrays have the lengths given; what overlaps is refused.
    unsafe {
        overlap(dc_derivatives(handle, 0, null_mut(), 0, at(0), 120, at(20), 3900), "gradient", "hessian");
        overlap(dc_gaps(handle, at(0).cast(), at(1), 4), "outcomes", "gaps");
        overlap(dc_forces(handle, &LAW, at(0), at(3), null_mut(), 4), "penetrations", "forces");
        let law = dc_law { multipliers: at(0), multiplier_count: 4, ..LAW };
        overlap(dc_forces(handle, &law, at(3), null_mut(), null_mut(), 4), "multipliers", "penetrations");
        overlap(dc_forces(handle, &law, null_mut(), at(1), null_mut(), 4), "multipliers", "forces");
        assert_eq!(dc_forces(handle, &law, null_mut(), at(0), at(4), 4), DC_OK, "the next multipliers");
        assert!(numbers[..8].iter().all(|force| *force > 0.0));
        overlap(dc_add_forces(handle, &law, at(2), 120, null_mut()), "multipliers", "forces");
        overlap(dc_add_forces(handle, &LAW, at(0), 120, at(5).cast()), "forces", "active_count");
        let triplets = dc_triplets(handle, &LAW, 0, at(0).cast(), at(9).cast(), null_mut(), 900, &mut count);
        overlap(triplets, "rows", "columns");
        overlap(dc_counts(handle, &mut count, &mut count), "node_count", "slave_count");
        let mut pattern = null_mut::<dc_pattern>();
        assert_eq!(dc_pattern_create(handle, &mut pattern, &mut count), DC_OK);
        let mut offsets = vec![0; 121 + count];
        let structure = dc_pattern_structure(pattern, offsets.as_mut_ptr(), 121, offsets.as_mut_ptr(), count);
        overlap(structure, "row_offsets", "columns");
        let mut values = vec![1.5; count];
        let active = values.as_mut_ptr().cast();
        let fill = dc_pattern_fill(pattern, handle, &LAW, values.as_mut_ptr(), count, active);
        overlap(fill, "values", "active_count");
        assert!(values.iter().all(|value| *value == 1.5));
        assert_eq!(dc_pattern_destroy(pattern), DC_OK);
        let mut whole = mesh.positions.clone();
        let report = whole.as_mut_ptr().cast::<dc_report>();
        (*report).size = size_of::<dc_report>();
        overlap(dc_refresh(handle, whole.as_ptr(), 40, report), "positions", "dc_report");
        assert_eq!(dc_destroy(handle), DC_OK);
    }
}

#[test]
fn arrays_of_single_elements_that_overlap_are_refused() {
    let (element, nodes) = element();
    let mut numbers = nodes.clone();
    numbers.resize(2000, 0.0);
    let base = numbers.as_mut_ptr();
    let at = |k: usize| base.wrapping_add(k);
    let mut point = dc_point::default();
    // SAFETY: the arrays have the lengths given; what overlaps is refused.
    unsafe {
        let gap = |gradient, hessian, point| {
            dc_gap(&element, at(0), at(3), 9, 2, point, gradient, 30, hessian, 465)
        };
        assert_eq!(gap(at(30), at(60), &mut point), DC_OK);
        overlap(gap(at(29), at(60), &mut point), "masters", "gradient");
        overlap(gap(at(30), at(59), &mut point), "gradient", "hessian");
        overlap(gap(at(30), at(60), at(0).cast()), "slave", "point");
        assert_eq!(numbers[..30], nodes);
        let offsets = [0, 9];
        let batch = |points, gradients| {
            let (slaves, masters) = (at(0), at(3));
            dc_gap_batch(
                &element,
                1,
                null(),
                null(),
                slaves,
                masters,
                offsets.as_ptr(),
                1,
                points,
                gradients,
                30,
                null_mut(),
                0,
            )
        };
        assert_eq!(batch(&mut point, at(30)), DC_OK);
        overlap(batch(&mut point, at(20)), "masters", "gradients");
        overlap(batch(at(31).cast(), at(30)), "points", "gradients");
        let system = |residual, tangent| {
            dc_element_system(&LAW, -1.0, 1.0, 9, at(30), null(), null_mut(), residual, 30, tangent, 900)
        };
        overlap(system(at(40), null_mut()), "gradient", "nodal_forces");
        overlap(system(at(60), at(80)), "nodal_forces", "tangent");
        let mut pairing: dc_pairing = std::mem::zeroed();
        pairing.size = size_of::<dc_pairing>();
        let up = [0.0, 0.0, 1.0];
        let status = dc_pair(null(), at(0), at(3), 9, up.as_ptr(), at(10).cast(), 9, &mut pairing);
        overlap(status, "candidates", "masters");
    }
}

/// Neither NaN that was there before nor memory that has no value matters.
#[test]
fn what_was_in_an_array_before_does_not_matter() {
    let (element, nodes) = element();
    let mut gradient = [MaybeUninit::<f64>::uninit(); 30];
    let mut hessian = [MaybeUninit::<f64>::uninit(); 465];
    let mut point = MaybeUninit::<dc_point>::uninit();
    // SAFETY: the arrays have the lengths given, and hold numbers afterwards.
    unsafe {
        let (gradient_at, hessian_at) = (gradient.as_mut_ptr().cast(), hessian.as_mut_ptr().cast());
        let masters = nodes[3..].as_ptr();
        let status = dc_gap(
            &element,
            nodes.as_ptr(),
            masters,
            9,
            2,
            point.as_mut_ptr(),
            gradient_at,
            30,
            hessian_at,
            465,
        );
        assert_eq!(status, DC_OK);
        assert!((point.assume_init().gap - 0.25).abs() < 1e-14);
        assert!(gradient.iter().chain(&hessian).all(|value| value.assume_init().is_finite()));
    }
}

#[test]
fn a_refusal_leaves_the_caller_s_arrays_as_they_were() {
    let mesh = Mesh::new();
    let handle = refreshed(&mesh);
    let mut report = dc_report_of_size(size_of::<dc_report>());
    report.paired = 77;
    let mut bad = mesh.positions.clone();
    bad[4] = f64::NAN;
    // SAFETY: the arrays have the lengths given.
    unsafe {
        assert_eq!(dc_refresh(handle, bad.as_ptr(), 40, &mut report), DC_NOT_FINITE);
        assert_eq!(report.paired, 77);
        assert_eq!(dc_evaluate(handle, 1), DC_OK);
        let (mut nodes, mut gradient, mut hessian) = ([9; 40], [1.5; 120], [2.5; 7260]);
        let status = dc_derivatives(
            handle,
            0,
            nodes.as_mut_ptr(),
            40,
            gradient.as_mut_ptr(),
            120,
            hessian.as_mut_ptr(),
            7260,
        );
        assert_eq!(status, DC_NOT_EVALUATED);
        assert!(message().contains("no hessian, the last evaluation was with DC_GRADIENT"), "{}", message());
        assert_eq!((nodes, gradient, hessian), ([9; 40], [1.5; 120], [2.5; 7260]));
        assert_eq!(dc_destroy(handle), DC_OK);
        let (element, nodes) = element();
        let wrong = dc_element { weight: 9, ..element };
        let offsets = [0, 9];
        let mut points = [dc_point { gap: 4.0, ..dc_point::default() }];
        let status = dc_gap_batch(
            &wrong,
            1,
            null(),
            null(),
            nodes.as_ptr(),
            nodes[3..].as_ptr(),
            offsets.as_ptr(),
            1,
            points.as_mut_ptr(),
            gradient.as_mut_ptr(),
            120,
            null_mut(),
            0,
        );
        assert_eq!((status, points[0].gap, gradient), (DC_BAD_OPTION, 4.0, [1.5; 120]));
    }
}

#[test]
fn a_pattern_belongs_to_its_equations() {
    let mesh = Mesh::new();
    let (handle, other) = (evaluated(&mesh), evaluated(&mesh));
    let (mut pattern, mut entries) = (null_mut::<dc_pattern>(), 0);
    // Backwards, so that there are as many entries.
    let backwards: Vec<i32> = (0..120).rev().collect();
    let standard: Vec<i32> = (0..120).collect();
    // SAFETY: the arrays have the lengths given.
    unsafe {
        assert_eq!(dc_pattern_create(handle, &mut pattern, &mut entries), DC_OK);
        let mut values = vec![0.0; entries];
        let mut fill = |handle, pattern| {
            dc_pattern_fill(pattern, handle, &LAW, values.as_mut_ptr(), entries, null_mut())
        };
        assert_eq!(fill(handle, pattern), DC_OK);
        assert_eq!(fill(other, pattern), DC_OK, "the same pairing and equations");
        assert_eq!(dc_set_equations(handle, backwards.as_ptr(), 40, 120), DC_OK);
        assert_eq!(fill(handle, pattern), DC_PATTERN_MISMATCH);
        assert_eq!(message(), "pattern-mismatch: node 0 has had other equations when the pattern was made");
        assert_eq!(fill(other, pattern), DC_OK);
        assert_eq!(dc_set_equations(other, backwards.as_ptr(), 40, 121), DC_OK);
        assert_eq!(fill(other, pattern), DC_PATTERN_MISMATCH);
        assert_eq!(message(), "pattern-mismatch: the pattern is of 120 equations, the interface has 121");
        assert_eq!(dc_set_equations(handle, standard.as_ptr(), 40, 120), DC_OK);
        assert_eq!(fill(handle, pattern), DC_OK, "the same numbers again");
        assert_eq!(dc_pattern_destroy(pattern), DC_OK);
        assert_eq!(dc_destroy(handle), DC_OK);
        assert_eq!(dc_destroy(other), DC_OK);
    }
}

#[test]
fn a_refused_evaluation_leaves_the_one_before() {
    let pair = Pair::new();
    let (_, handle) = pair.make(2);
    let mut pressures = [[0.0; 25]; 2];
    // SAFETY: the arrays have the lengths given.
    unsafe {
        let contacts = |pressures: &mut [f64; 25]| {
            let pressures = pressures.as_mut_ptr();
            dc_faces_contacts(handle, null_mut(), null_mut(), pressures, null_mut(), null_mut(), 25)
        };
        let x = pair.positions.as_ptr();
        assert_eq!(dc_faces_refresh(handle, x, pair.nodes(), null_mut()), DC_OK, "{}", message());
        assert_eq!(dc_faces_evaluate(handle, &law(&[]), 2), DC_OK, "{}", message());
        assert_eq!(contacts(&mut pressures[0]), DC_OK);
        for (wrong, status) in [
            (dc_law { penalty: -1.0, ..law(&[]) }, DC_BAD_OPTION),
            (dc_law { friction: 0.3, ..law(&[]) }, DC_NOT_EVALUATED),
        ] {
            assert_eq!(dc_faces_evaluate(handle, &wrong, 2), status, "{}", message());
            assert_eq!(contacts(&mut pressures[1]), DC_OK, "{}", message());
            assert!(pressures[0] == pressures[1] && pressures[0].iter().any(|p| *p > 0.0));
        }
    }
    assert_eq!(dc_faces_destroy(handle), DC_OK);
}
