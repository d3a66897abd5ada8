//! What a caller can do wrong has a status and a sentence.

use std::ptr::{null, null_mut};

use super::{Mesh, message, options, text};
use crate::assembly::{dc_add_forces, dc_triplets};
use crate::batch::dc_gap_batch;
use crate::choice::dc_rule;
use crate::contacts::{dc_contact, dc_contact_of, dc_cutback, dc_derivatives, dc_forces, dc_gaps};
use crate::element::{dc_element, dc_element_system, dc_gap, dc_point};
use crate::interface::{
    dc_create, dc_destroy, dc_evaluate, dc_freeze, dc_interface, dc_refresh, dc_report, dc_set_equations,
    dc_thaw, dc_update,
};
use crate::law::dc_law;
use crate::options::{dc_options, dc_options_default};
use crate::outcome::{dc_outcome, dc_outcome_code};
use crate::pattern::{
    dc_pattern, dc_pattern_create, dc_pattern_destroy, dc_pattern_fill, dc_pattern_structure,
};
use crate::status::*;
use crate::threads::{dc_set_threads, dc_thread_count};
use crate::version::{dc_isa, dc_set_isa, dc_version};

pub const LAW: dc_law = dc_law {
    size: size_of::<dc_law>(),
    penalty: 1e3,
    multipliers: null(),
    multiplier_count: 0,
    tangent: 0,
    reserved: 0,
    friction: 0.0,
    tangential_stiffness: 0.0,
    shear_limit: 0.0,
    ..dc_law::NONE
};

/// Refuses a changed mesh.
fn refused(change: impl FnOnce(&mut Mesh), status: dc_status, code: &str) {
    let mut mesh = Mesh::new();
    change(&mut mesh);
    assert_eq!(mesh.make(null()), (status, null_mut()), "{}", message());
    assert!(message().starts_with(&format!("{code}: ")), "{}", message());
}

/// Refuses changed options.
fn refused_options(change: impl FnOnce(&mut dc_options), status: dc_status, says: &str) {
    let mut changed = options();
    change(&mut changed);
    assert_eq!(Mesh::new().make(&changed).0, status, "{}", message());
    assert!(message().contains(says), "{}", message());
}

/// An interface that has been refreshed.
pub fn refreshed(mesh: &Mesh) -> *mut dc_interface {
    let handle = mesh.interface();
    // SAFETY: as many positions as nodes.
    let status = unsafe { dc_refresh(handle, mesh.positions.as_ptr(), mesh.nodes(), null_mut()) };
    assert_eq!(status, DC_OK);
    handle
}

#[test]
fn meshes_that_are_none() {
    refused(|mesh| mesh.facets[1] = mesh.facets[0], DC_BAD_SURFACE, "repeated-node");
    refused(|mesh| mesh.facets[6] = 40, DC_OUT_OF_RANGE, "node-out-of-range");
    refused(|mesh| mesh.facets[6] = -7, DC_OUT_OF_RANGE, "node-out-of-range");
    refused(|mesh| mesh.facets.clear(), DC_BAD_SURFACE, "empty-surface");
    refused(|mesh| mesh.facets.swap(1, 3), DC_BAD_SURFACE, "inconsistent-orientation");
    refused(|mesh| mesh.slaves[1] = 36, DC_BAD_SLAVES, "repeated-slave");
    refused(|mesh| mesh.slaves[1] = 3, DC_BAD_SLAVES, "slave-on-master");
    refused(|mesh| mesh.slaves[1] = 40, DC_OUT_OF_RANGE, "slave-out-of-range");
    refused(|mesh| mesh.slaves[1] = i32::MIN, DC_OUT_OF_RANGE, "slave-out-of-range");
    refused(|mesh| mesh.positions[5] = f64::NAN, DC_NOT_FINITE, "non-finite-position");
    refused(|mesh| mesh.positions[118] = f64::INFINITY, DC_NOT_FINITE, "non-finite-position");
}

#[test]
fn options_out_of_range() {
    refused_options(|options| options.size = 4, DC_BAD_SIZE, "sizeof(dc_options)");
    refused_options(|options| options.size = 4000, DC_BAD_SIZE, "sizeof(dc_options)");
    refused_options(|options| options.weight = 7, DC_BAD_OPTION, "weight is 7");
    refused_options(|options| options.layers = -1, DC_BAD_OPTION, "layers is -1");
    refused_options(|options| options.frame = 2, DC_BAD_OPTION, "frame is 2");
    refused_options(|options| options.areas = 3, DC_BAD_OPTION, "areas is 3");
    refused_options(|options| options.feature_angle_degrees = 200.0, DC_BAD_OPTION, "from 0 to 180");
    refused_options(|options| options.border_tolerance = f64::NAN, DC_BAD_OPTION, "border_tolerance");
    refused_options(|options| options.radius_factor = 1.0, DC_BAD_OPTION, "radius_factor");
    refused_options(|options| options.cutback_penetration = 0.0, DC_BAD_OPTION, "cutback_penetration");
    refused_options(|options| options.reserved = 1, DC_BAD_OPTION, "dc_options.reserved is 1");
    refused_options(
        |options| options.areas = 1,
        DC_OK,
        // The message of the failure before.
        "dc_options.reserved",
    );
    let mut mesh = Mesh::new();
    mesh.slave_facets.clear();
    let with_areas = dc_options { areas: 1, ..options() };
    assert_eq!(mesh.make(&with_areas).0, DC_BAD_SLAVES);
    // A penalty that was meant per area would be one per node.
    let mesh = Mesh::new();
    let (x, facets, slaves) = (mesh.positions.as_ptr(), mesh.facets.as_ptr(), mesh.slaves.as_ptr());
    let (of_slaves, mut handle) = (mesh.slave_facets.as_ptr(), null_mut());
    // SAFETY: the arrays have the lengths given.
    let status = unsafe { dc_create(x, 40, facets, 25, slaves, 4, of_slaves, 1, null(), &mut handle) };
    assert_eq!((status, handle.is_null()), (DC_BAD_OPTION, true));
    assert!(message().contains("set areas of dc_options to 1"), "{}", message());
    // SAFETY: NULL is allowed to be refused.
    assert_eq!(unsafe { dc_options_default(null_mut()) }, DC_BAD_POINTER);
}

#[test]
fn structures_of_no_version_are_refused() {
    // Up to the penultimate field.
    let known = std::mem::offset_of!(dc_options, cutback_penetration);
    let unknown = dc_options { size: known, cutback_penetration: -1.0, ..options() };
    assert_eq!(Mesh::new().make(&unknown).0, DC_BAD_SIZE, "no such version has been released");
    let mut short = dc_report_of_size(std::mem::offset_of!(dc_report, gained_gap));
    let mesh = Mesh::new();
    let handle = mesh.interface();
    // SAFETY: as many positions as nodes.
    let status = unsafe { dc_refresh(handle, mesh.positions.as_ptr(), mesh.nodes(), &mut short) };
    assert_eq!(status, DC_BAD_SIZE);
    assert_eq!(dc_destroy(handle), DC_OK);
}

pub fn dc_report_of_size(size: usize) -> dc_report {
    // SAFETY: numbers, of which any bits are a value.
    dc_report { size, ..unsafe { std::mem::zeroed() } }
}

#[test]
fn pointers_sizes_and_handles() {
    let mesh = Mesh::new();
    let handle = refreshed(&mesh);
    let positions = mesh.positions.as_ptr();
    // SAFETY: the arrays have the lengths given, or are NULL.
    unsafe {
        assert_eq!(dc_update(handle, null(), 40), DC_BAD_POINTER);
        assert_eq!(message(), "bad-pointer: positions is NULL");
        assert_eq!(dc_update(handle, positions.byte_add(1), 1), DC_BAD_POINTER);
        assert_eq!(dc_update(handle, positions, 39), DC_BAD_SIZE);
        assert_eq!(dc_update(handle, positions, usize::MAX), DC_BAD_SIZE);
        assert_eq!(dc_update(handle, positions, usize::MAX / 24 + 1), DC_BAD_SIZE);
        assert_eq!(dc_create(null(), 0, null(), 0, null(), 0, null(), 0, null(), null_mut()), DC_BAD_POINTER);
        let (mut outcomes, mut gaps) = ([-1; 4], [0.0; 4]);
        assert_eq!(dc_gaps(handle, outcomes.as_mut_ptr(), gaps.as_mut_ptr(), 4), DC_NOT_EVALUATED);
        assert_eq!(dc_evaluate(handle, 3), DC_BAD_OPTION);
        assert_eq!(dc_evaluate(handle, 0), DC_OK);
        assert_eq!(dc_cutback(handle, null_mut()), DC_BAD_POINTER);
        assert_eq!(dc_gaps(handle, outcomes.as_mut_ptr(), gaps.as_mut_ptr(), 3), DC_BAD_SIZE);
        assert_eq!(dc_gaps(handle, outcomes.as_mut_ptr(), gaps.as_mut_ptr(), 4), DC_OK);
        assert_eq!(outcomes, [0; 4]);
        assert!(gaps.iter().all(|gap| *gap < 0.0));
        let mut contact = dc_contact::default();
        assert_eq!(dc_contact_of(handle, 4, &mut contact), DC_OUT_OF_RANGE);
        assert_eq!(dc_contact_of(handle, 3, &mut contact), DC_OK);
        assert_eq!((contact.node, contact.gap), (39, gaps[3]));
        let count = contact.master_count as usize;
        let (mut nodes, mut gradient) = (vec![0; count + 1], vec![0.0; 3 * (count + 1)]);
        let derivatives = |nodes: &mut Vec<i32>, gradient: &mut Vec<f64>| {
            let (node_size, size) = (nodes.len(), gradient.len());
            dc_derivatives(
                handle,
                3,
                nodes.as_mut_ptr(),
                node_size,
                gradient.as_mut_ptr(),
                size,
                null_mut(),
                0,
            )
        };
        assert_eq!(derivatives(&mut nodes, &mut gradient), DC_NOT_EVALUATED, "value mode has no gradient");
        assert_eq!(message(), "not-evaluated: there is no gradient, the last evaluation was with DC_VALUE");
        assert_eq!(derivatives(&mut vec![0; count], &mut gradient), DC_BAD_SIZE);
        assert_eq!(nodes[0], 0, "a refusal writes nothing");
        let mut residual = [0.0; 120];
        assert_eq!(dc_add_forces(handle, &LAW, residual.as_mut_ptr(), 120, null_mut()), DC_NOT_EVALUATED);
        // Which array of which slave, its length, and the one it has to have.
        let sentence = message();
        assert_eq!(dc_contact_of(handle, 0, &mut contact), DC_OK);
        let needed = 3 * (contact.master_count + 1);
        assert_eq!(
            sentence,
            format!(
                "derivative-length: the gradient of element 0 has 0 entries instead of {needed}: not evaluated, or in a mode with fewer derivatives"
            )
        );
        assert_eq!(dc_evaluate(handle, 2), DC_OK);
        assert_eq!(derivatives(&mut nodes, &mut gradient), DC_OK);
        assert_eq!(dc_add_forces(handle, &LAW, residual.as_mut_ptr(), 119, null_mut()), DC_BAD_SIZE);
        assert_eq!(dc_add_forces(handle, null(), residual.as_mut_ptr(), 120, null_mut()), DC_BAD_POINTER);
        let wrong = dc_law { penalty: -1.0, ..LAW };
        assert_eq!(dc_add_forces(handle, &wrong, residual.as_mut_ptr(), 120, null_mut()), DC_BAD_OPTION);
        let wrong = dc_law { reserved: 1, ..LAW };
        assert_eq!(dc_add_forces(handle, &wrong, residual.as_mut_ptr(), 120, null_mut()), DC_BAD_OPTION);
        let wrong = dc_law { multipliers: gaps.as_ptr(), multiplier_count: 3, ..LAW };
        assert_eq!(dc_add_forces(handle, &wrong, residual.as_mut_ptr(), 120, null_mut()), DC_BAD_SIZE);
        let wrong = dc_law { multiplier_count: 4, ..wrong };
        assert_eq!(dc_add_forces(handle, &wrong, residual.as_mut_ptr(), 120, null_mut()), DC_BAD_OPTION);
        assert_eq!(dc_forces(handle, &wrong, null_mut(), null_mut(), null_mut(), 4), DC_BAD_OPTION);
        assert_eq!(residual, [0.0; 120]);
        let mut count = 0;
        let status = dc_triplets(handle, &LAW, 1, null_mut(), null_mut(), gaps.as_mut_ptr(), 4, &mut count);
        assert_eq!((status, count > 4), (DC_BAD_SIZE, true));
        assert_eq!(
            dc_triplets(handle, &LAW, 2, null_mut(), null_mut(), null_mut(), 0, &mut count),
            DC_BAD_OPTION
        );
        let mut equations = [-1; 120];
        equations[7] = 2;
        assert_eq!(dc_set_equations(handle, equations.as_ptr(), 40, 2), DC_OUT_OF_RANGE);
        equations[8] = 2;
        assert_eq!(dc_set_equations(handle, equations.as_ptr(), 40, 3), DC_BAD_OPTION);
        assert_eq!(message(), "shared-equation: two degrees of freedom have the same equation 2");
        equations[8] = -2;
        assert_eq!(dc_set_equations(handle, equations.as_ptr(), 40, 3), DC_OUT_OF_RANGE);
        assert_eq!(dc_set_equations(handle, equations.as_ptr(), 39, 3), DC_BAD_SIZE);
        // An array that could not be had is no wish for the standard numbering.
        for (nodes, count) in [(40, 120), (40, 0), (0, 120), (39, 3)] {
            assert_eq!(dc_set_equations(handle, null(), nodes, count), DC_BAD_POINTER);
            assert!(message().starts_with("bad-pointer: equations is NULL"), "{}", message());
        }
        assert_eq!(dc_set_equations(handle, null(), 0, 0), DC_OK);

        assert_eq!(dc_destroy(handle), DC_OK);
        assert_eq!(dc_destroy(handle), DC_BAD_HANDLE);
        assert_eq!(dc_destroy(null_mut()), DC_OK);
        assert_eq!(dc_update(handle, positions, 40), DC_BAD_HANDLE);
        assert!(message().ends_with("never made, or destroyed"), "{}", message());
        let on_stack: *mut dc_interface = (&raw mut count).cast();
        for garbage in [null_mut(), on_stack, handle.wrapping_byte_add(3), std::ptr::dangling_mut()] {
            assert_eq!(dc_evaluate(garbage, 0), DC_BAD_HANDLE);
            assert_eq!(dc_freeze(garbage), DC_BAD_HANDLE);
        }
    }
}

#[test]
fn a_frozen_interface_keeps_its_pairing_and_moves() {
    let mesh = Mesh::new();
    // Their support radius is another one for other masters.
    let (status, handle) = mesh.make(&dc_options { rule: dc_rule::DC_HULL_LAYERS as i32, ..options() });
    assert_eq!(status, DC_OK);
    // SAFETY: as many positions as nodes.
    assert_eq!(unsafe { dc_refresh(handle, mesh.positions.as_ptr(), 40, null_mut()) }, DC_OK);
    let mut moved = mesh.positions.clone();
    moved.iter_mut().skip(3 * 36).step_by(3).for_each(|x| *x += 0.9);
    let mut report = dc_report_of_size(size_of::<dc_report>());
    let gap = |handle| {
        let mut contact = dc_contact::default();
        assert_eq!(dc_evaluate(handle, 0), DC_OK);
        // SAFETY: it may be written.
        assert_eq!(unsafe { dc_contact_of(handle, 0, &mut contact) }, DC_OK);
        contact
    };
    let before = gap(handle);
    // SAFETY: the arrays have the lengths given.
    unsafe {
        assert_eq!(dc_freeze(handle), DC_OK);
        assert_eq!(dc_refresh(handle, moved.as_ptr(), 40, &mut report), DC_FROZEN);
        assert_eq!((report.paired, report.jump_node), (0, -1));
        let held = gap(handle);
        assert_ne!(held.gap, before.gap);
        assert_eq!(held.support_radius, before.support_radius);
        assert_eq!(dc_thaw(handle), DC_OK);
        assert_eq!(dc_refresh(handle, moved.as_ptr(), 40, &mut report), DC_OK);
        assert_eq!((report.paired, report.changed), (4, 4));
        assert_ne!(gap(handle).support_radius, before.support_radius);
    }
    assert_eq!(dc_destroy(handle), DC_OK);
}

#[test]
fn a_pattern_belongs_to_a_pairing() {
    let mesh = Mesh::new();
    let handle = mesh.interface();
    let (mut pattern, mut entries) = (null_mut::<dc_pattern>(), 0);
    // SAFETY: the arrays have the lengths given.
    unsafe {
        assert_eq!(dc_pattern_create(handle, &mut pattern, &mut entries), DC_NOT_EVALUATED);
        assert!(pattern.is_null());
        assert_eq!(dc_refresh(handle, mesh.positions.as_ptr(), 40, null_mut()), DC_OK);
        assert_eq!(dc_evaluate(handle, 2), DC_OK);
        assert_eq!(dc_pattern_create(handle, &mut pattern, &mut entries), DC_OK);
        let mut values = vec![0.0; entries];
        let fill = |values: &mut Vec<f64>| {
            dc_pattern_fill(pattern, handle, &LAW, values.as_mut_ptr(), values.len(), null_mut())
        };
        assert_eq!(fill(&mut values), DC_OK);
        assert!(values.iter().any(|value| *value != 0.0));
        assert_eq!(fill(&mut values[1..].to_vec()), DC_BAD_SIZE);
        let mut offsets = [0; 121];
        assert_eq!(dc_pattern_structure(pattern, offsets.as_mut_ptr(), 120, null_mut(), 0), DC_BAD_SIZE);
        assert_eq!(dc_pattern_structure(pattern, offsets.as_mut_ptr(), 121, null_mut(), 0), DC_OK);
        assert_eq!(offsets[120] as usize, entries);
        let mut moved = mesh.positions.clone();
        moved.iter_mut().skip(3 * 36).step_by(3).for_each(|x| *x += 0.9);
        assert_eq!(dc_refresh(handle, moved.as_ptr(), 40, null_mut()), DC_OK);
        assert_eq!(fill(&mut values), DC_NOT_EVALUATED);
        assert_eq!(dc_evaluate(handle, 2), DC_OK);
        assert_eq!(fill(&mut values), DC_PATTERN_MISMATCH);
        // An interface is no pattern.
        assert_eq!(dc_pattern_destroy(handle.cast()), DC_BAD_HANDLE);
        assert_eq!(dc_destroy(pattern.cast()), DC_BAD_HANDLE);
        assert_eq!(dc_destroy(handle), DC_OK);
        assert_eq!(fill(&mut values), DC_BAD_HANDLE);
        assert_eq!(dc_pattern_destroy(pattern), DC_OK);
        assert_eq!(dc_pattern_destroy(pattern), DC_BAD_HANDLE);
    }
}

#[test]
fn single_elements_are_refused_or_have_no_contact() {
    let masters: Vec<f64> =
        (0..9).flat_map(|k| [f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0, 0.0]).collect();
    // SAFETY: numbers, of which any bits are a value.
    let zeros: dc_element = unsafe { std::mem::zeroed() };
    let sound =
        dc_element { size: size_of::<dc_element>(), support_radius: 2.0, outward: [0.0, 0.0, 1.0], ..zeros };
    let mut point = dc_point::default();
    let mut gradient = [0.0; 30];
    let mut gap = |element: &dc_element, slave: [f64; 3], count: usize, mode: i32| {
        // SAFETY: the arrays have the lengths given.
        let status = unsafe {
            dc_gap(
                element,
                slave.as_ptr(),
                masters.as_ptr(),
                count,
                mode,
                &mut point,
                gradient.as_mut_ptr(),
                30,
                null_mut(),
                0,
            )
        };
        (status, point)
    };
    let slave = [0.1, 0.2, 0.25];
    let (status, found) = gap(&sound, slave, 9, 1);
    assert_eq!((status, found.outcome), (DC_OK, dc_outcome::DC_CONTACT as i32));
    assert!((found.gap - 0.25).abs() < 1e-14);
    assert_eq!(gap(&sound, slave, 9, 2).0, DC_BAD_SIZE, "no room for the Hessian");
    assert_eq!(gap(&sound, slave, 5, 1).0, DC_BAD_SIZE, "too few for the quadratic basis");
    assert_eq!(gap(&sound, slave, usize::MAX / 3, 1).0, DC_BAD_SIZE);
    assert_eq!(gap(&sound, [f64::NAN, 0.0, 0.0], 9, 1).0, DC_NOT_FINITE);
    assert_eq!(gap(&dc_element { size: 0, ..sound }, slave, 9, 1).0, DC_BAD_SIZE);
    assert_eq!(gap(&dc_element { support_radius: 0.0, ..sound }, slave, 9, 1).0, DC_BAD_OPTION);
    assert_eq!(gap(&dc_element { basis: 9, ..sound }, slave, 9, 1).0, DC_BAD_OPTION);
    assert_eq!(gap(&dc_element { reserved: 1, ..sound }, slave, 9, 1).0, DC_BAD_OPTION);
    assert_eq!(gap(&dc_element { frame: 3, ..sound }, slave, 9, 1).0, DC_BAD_OPTION);
    assert_eq!(message(), "invalid-option: frame is 3, which is none of 0, 1, 2");
    assert_eq!(gap(&dc_element { frame: 2, ..sound }, slave, 9, 1).0, DC_BAD_OPTION, "no frame given");
    let (status, found) = gap(&dc_element { outward: [1.0, 0.0, 0.0], ..sound }, slave, 9, 1);
    assert_eq!((status, found.outcome), (DC_NO_CONTACT, dc_outcome::DC_AMBIGUOUS_OUTWARD as i32));
    assert_eq!((found.gap, found.normal), (0.0, [0.0; 3]));
    let (status, found) = gap(&sound, slave, 6, 1);
    assert_eq!((status, found.outcome), (DC_NO_CONTACT, dc_outcome::DC_SINGULAR_FIT as i32), "two rows");
    assert!(message().starts_with("singular-fit: "), "{}", message());
    let given =
        dc_element { frame: 2, t1: [1.0, 0.0, 0.0], t2: [0.0, 1.0, 0.0], normal: [0.0, 0.0, 1.0], ..sound };
    assert_eq!(gap(&given, slave, 9, 1).0, DC_OK);

    let mut points = [dc_point::default(); 2];
    let batch = |offsets: &[usize; 3], points: &mut [dc_point; 2]| {
        let slaves = [0.1, 0.2, 0.25, f64::NAN, 0.0, 0.0];
        // SAFETY: the arrays have the lengths given; masters are as many as the last offset says.
        unsafe {
            dc_gap_batch(
                &sound,
                2,
                null(),
                null(),
                slaves.as_ptr(),
                [masters.as_slice(), masters.as_slice()].concat().as_ptr(),
                offsets.as_ptr(),
                0,
                points.as_mut_ptr(),
                null_mut(),
                0,
                null_mut(),
                0,
            )
        }
    };
    assert_eq!(batch(&[0, 9, 18], &mut points), DC_OK);
    assert_eq!(points.map(|point| point.outcome), [0, dc_outcome::DC_REFUSED as i32]);
    assert!((points[0].gap - 0.25).abs() < 1e-14);
    assert_eq!(batch(&[0, 9, 8], &mut points), DC_OUT_OF_RANGE);
    assert_eq!(batch(&[1, 9, 18], &mut points), DC_OUT_OF_RANGE);
    assert_eq!(batch(&[0, 9, 9], &mut points), DC_OK, "no masters at all");
    assert_eq!(points[1].outcome, dc_outcome::DC_NO_AVERAGE_PLANE as i32);

    let gradient = [f64::MAX; 6];
    // SAFETY: the arrays have the lengths given.
    unsafe {
        let system = |law: &dc_law, gap, residual: *mut f64, size| {
            dc_element_system(
                law,
                gap,
                1.0,
                1,
                gradient.as_ptr(),
                null(),
                null_mut(),
                residual,
                size,
                null_mut(),
                0,
            )
        };
        let mut residual = [0.0; 6];
        assert_eq!(system(&LAW, -1.0, residual.as_mut_ptr(), 6), DC_OVERFLOW);
        assert_eq!(system(&LAW, f64::NAN, residual.as_mut_ptr(), 6), DC_NOT_FINITE);
        assert_eq!(system(&LAW, -1.0, residual.as_mut_ptr(), 5), DC_BAD_SIZE);
        assert_eq!(system(&LAW, 1.0, residual.as_mut_ptr(), 6), DC_OK);
    }
}

#[test]
fn two_threads_on_one_handle_take_turns_or_are_told() {
    let mesh = Mesh::new();
    let handle = refreshed(&mesh).addr();
    let worker = || {
        let handle: *mut dc_interface = std::ptr::without_provenance_mut(handle);
        let mut done = 0;
        for _ in 0..300 {
            match dc_evaluate(handle, 2) {
                DC_OK => done += 1,
                status => assert_eq!((status, message().as_str()), (DC_BUSY, BUSY)),
            }
        }
        done
    };
    const BUSY: &str = "busy: another thread is in a call with this interface";
    let done: i32 = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(worker)).collect();
        threads.into_iter().map(|thread| thread.join().expect("no panic")).sum()
    });
    assert!(done > 0);
    let handle: *mut dc_interface = std::ptr::without_provenance_mut(handle);
    assert_eq!(dc_evaluate(handle, 2), DC_OK);
    assert_eq!(dc_destroy(handle), DC_OK);
}

#[test]
fn names_and_versions_are_texts() {
    assert_eq!(text(dc_version()), env!("CARGO_PKG_VERSION"));
    assert_eq!(text(dc_status_name(DC_PATTERN_MISMATCH as i32)), "pattern-mismatch");
    assert_eq!(text(dc_status_name(DC_INTERNAL as i32)), "internal");
    assert_eq!(text(dc_status_name(17)), "unknown");
    assert_eq!(text(dc_status_name(-1)), "unknown");
    assert_eq!(text(dc_outcome_code(dc_outcome::DC_FOOT_OUTSIDE as i32)), "foot-outside");
    assert_eq!(text(dc_outcome_code(99)), "unknown");
    let used = dc_isa();
    // SAFETY: texts that end with a zero byte.
    unsafe {
        assert_eq!(dc_set_isa(used), DC_OK);
        assert_eq!(dc_set_isa(null()), DC_BAD_POINTER);
        assert_eq!(dc_set_isa(c"abacus".as_ptr()), DC_BAD_OPTION);
    }
}

#[test]
fn every_reason_of_the_runtime_has_an_outcome() {
    use runtime::ElementError as E;
    use runtime::interface::{NoContact, Outcome};
    use runtime::neighbourhood::NeighbourhoodError;
    let errors = [
        E::SingularFit { pivot_ratio: 0.0, tolerance: 0.0 },
        E::FootDiverged { residual: 0.0, iterations: 0 },
        E::FootOutside { distance: 0.0 },
        E::CentreOfCurvature { determinant: 0.0 },
        E::BeyondCentreOfCurvature { determinant: 0.0, trace: 0.0 },
        E::NoAveragePlane { smallest: 0.0, middle: 0.0 },
        E::AmbiguousOutward { cosine: 0.0 },
        E::DegenerateFacet { area: 0.0 },
        E::Overflow { what: "gap" },
        E::NotMaterialPlace { deviation: 0.0 },
    ];
    for error in errors {
        let outcome = crate::outcome::with_code(error.code());
        assert_ne!(outcome, dc_outcome::DC_REFUSED, "{error}");
        assert_eq!(text(dc_outcome_code(outcome as i32)), error.code());
        assert_eq!(Failure::from(error).status, DC_NO_CONTACT);
    }
    let reasons = [
        NoContact::NotPaired,
        NoContact::TooFar { distance: 0.0, limit: 0.0 },
        NoContact::BeyondWindow { needed: 0.0, known: 0.0 },
        NoContact::NothingOver { limit: 0.0 },
        NoContact::NoCandidate { reason: NeighbourhoodError::NoCandidate { found: 0, needed: 3 } },
        NoContact::BeyondBorder { distance: 0.0, tolerance: 0.0 },
    ];
    // What held lists come to is none of an element of the caller's own.
    let few = Outcome::None(E::TooFewNodes { found: 2, needed: 6 }.into());
    assert_eq!(crate::outcome::of(&few), dc_outcome::DC_SINGULAR_FIT);
    for reason in reasons {
        let outcome = crate::outcome::of(&Outcome::None(reason));
        assert_eq!(text(dc_outcome_code(outcome as i32)), reason.code());
    }
}

#[test]
#[cfg(not(feature = "friction"))]
fn a_library_without_friction_says_so() {
    let mesh = Mesh::new();
    let handle = mesh.interface();
    let law = dc_law { friction: 0.2, ..LAW };
    let accept = |law: &dc_law| {
        // SAFETY: a whole structure.
        unsafe {
            crate::friction::dc_accept(
                handle,
                law,
                null_mut(),
                null_mut(),
                null_mut(),
                null_mut(),
                null_mut(),
            )
        }
    };
    // SAFETY: the array has the length given.
    assert_eq!(unsafe { dc_refresh(handle, mesh.positions.as_ptr(), mesh.nodes(), null_mut()) }, DC_OK);
    assert_eq!(accept(&law), DC_BAD_OPTION);
    assert!(message().starts_with("no-friction-kernels: "), "{}", message());
    assert_eq!(accept(&LAW), DC_OK);
    assert_eq!(dc_evaluate(handle, 2), DC_OK);
    // Where the law is handed in, not only where a step is accepted.
    let (mut sum, mut count) = (vec![0.0; 120], 7);
    // SAFETY: the arrays have the lengths given.
    let refused = unsafe {
        [
            dc_add_forces(handle, &law, sum.as_mut_ptr(), 120, null_mut()),
            dc_triplets(handle, &law, 0, null_mut(), null_mut(), null_mut(), 0, &mut count),
            dc_forces(handle, &law, null_mut(), null_mut(), null_mut(), 4),
        ]
    };
    assert_eq!(refused, [DC_BAD_OPTION; 3]);
    assert!(message().starts_with("no-friction-kernels: "), "{}", message());
    assert!(sum.iter().all(|&force| force == 0.0) && count == 7);
    assert_eq!(dc_destroy(handle), DC_OK);
}

#[test]
fn the_number_of_threads_can_be_set() {
    for count in [1, 3] {
        assert_eq!((dc_set_threads(count), dc_thread_count()), (DC_OK, count as usize));
    }
    for count in [-1, 1025] {
        assert_eq!(dc_set_threads(count), DC_BAD_OPTION);
        assert!(message().contains(&format!("not {count}")), "{}", message());
        assert_eq!(dc_thread_count(), 3);
    }
    assert_eq!(dc_set_threads(0), DC_OK);
    assert!(dc_thread_count() > 0);
}
