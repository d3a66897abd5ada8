//! Friction through C calls.

use std::ptr::null_mut;

use runtime::Mode;
use runtime::assembly::{ContactLaw, CsrMap, CsrPattern, DofMap, Tangent, add_forces};
use runtime::friction::Coulomb;
use runtime::interface::InterfaceOptions;

use super::misuse::LAW;
use super::{Mesh, message, options};
use crate::assembly::{dc_add_forces, dc_triplets};
use crate::friction::{dc_accept, dc_friction, dc_history, dc_set_history};
use crate::interface::{dc_destroy, dc_evaluate, dc_interface, dc_refresh, dc_set_symmetry};
use crate::law::dc_law;
use crate::map::{dc_map_add, dc_map_create, dc_map_destroy};
use crate::options::dc_options;
use crate::pattern::{dc_pattern_create, dc_pattern_destroy, dc_pattern_structure};
use crate::status::{DC_BAD_OPTION, DC_BAD_POINTER, DC_BAD_SIZE, DC_NOT_EVALUATED, DC_OK};

const FRICTION: dc_law = dc_law { friction: 0.2, tangential_stiffness: 500.0, ..LAW };

fn refresh(mesh: &Mesh, handle: *mut dc_interface) {
    // SAFETY: the array has the length given.
    assert_eq!(unsafe { dc_refresh(handle, mesh.positions.as_ptr(), mesh.nodes(), null_mut()) }, DC_OK);
}

fn accept(handle: *mut dc_interface, law: &dc_law) -> crate::status::dc_status {
    // SAFETY: a whole structure.
    unsafe { dc_accept(handle, law, null_mut(), null_mut(), null_mut(), null_mut(), null_mut()) }
}

fn residual(handle: *mut dc_interface, law: &dc_law) -> Vec<f64> {
    let mut residual = vec![0.0; 120];
    assert_eq!(dc_evaluate(handle, 2), DC_OK);
    // SAFETY: the array has the length given.
    assert_eq!(
        unsafe { dc_add_forces(handle, law, residual.as_mut_ptr(), 120, null_mut()) },
        DC_OK,
        "{}",
        message()
    );
    residual
}

/// Moves the slaves along x.
fn slid(mesh: &Mesh, step: f64) -> Mesh {
    let mut mesh = mesh.clone();
    for slave in &mesh.slaves {
        mesh.positions[3 * *slave as usize] += step;
    }
    mesh
}

/// What friction does at the slaves is what it adds to the forces on them, which slid by 0.05.
fn assert_friction(handle: *mut dc_interface, with: &[f64], without: &[f64]) {
    let (mut states, mut tractions, mut slips) = ([-1; 4], [9.0; 12], [9.0; 4]);
    let (of_states, of_slips) = (states.as_mut_ptr(), slips.as_mut_ptr());
    let read = |law: &dc_law, tractions: *mut f64, count: usize| {
        // SAFETY: the arrays have the lengths given.
        unsafe { dc_friction(handle, law, of_states, tractions, of_slips, count) }
    };
    assert_eq!(read(&FRICTION, tractions.as_mut_ptr(), 3), DC_BAD_SIZE);
    assert_eq!(read(&FRICTION, of_slips, 4), DC_BAD_POINTER);
    assert_eq!((states, slips), ([-1; 4], [9.0; 4]));
    assert_eq!(read(&FRICTION, tractions.as_mut_ptr(), 4), DC_OK, "{}", message());
    for (k, traction) in tractions.iter().enumerate() {
        let expected = with[3 * 36 + k] - without[3 * 36 + k];
        assert!((traction - expected).abs() < 1e-12 * with[3 * 36 + 2].abs(), "{k}: {traction} {expected}");
    }
    assert_eq!(states, [2; 4], "all slide");
    assert!(slips.iter().all(|slip| (slip - 0.05).abs() < 2e-3), "{slips:?}");
    assert_eq!(read(&LAW, tractions.as_mut_ptr(), 4), DC_OK, "{}", message());
    assert_eq!((states, tractions, slips), ([0; 4], [0.0; 12], [0.0; 4]));
    // Values have no gradient of the slip.
    assert_eq!(dc_evaluate(handle, 0), DC_OK);
    assert_eq!(read(&FRICTION, null_mut(), 4), DC_NOT_EVALUATED, "{}", message());
    assert_eq!(dc_evaluate(handle, 2), DC_OK);
}

/// On facets in every build.
#[test]
fn facets_have_friction_with_a_history() {
    a_history_outlives_the_handle(&dc_options { element: 1, ..options() });
}

#[test]
#[cfg(feature = "friction")]
fn the_smooth_surface_has_friction_with_a_history() {
    a_history_outlives_the_handle(&options());
}

fn a_history_outlives_the_handle(options: &dc_options) {
    let mesh = Mesh::new();
    let interface = || {
        let (status, handle) = mesh.make(options);
        assert_eq!(status, DC_OK, "{}", message());
        handle
    };
    let handle = interface();
    refresh(&mesh, handle);
    assert_eq!(accept(handle, &FRICTION), DC_OK);
    let ahead = slid(&mesh, 0.05);
    refresh(&ahead, handle);
    let (with, without) = (residual(handle, &FRICTION), residual(handle, &LAW));
    let traction = |k: usize| with[3 * (36 + k)] - without[3 * (36 + k)];
    assert!((0..4).all(|k| traction(k) < 0.0), "against the slip");
    let mut count = 0;
    // SAFETY: the arrays have the lengths given.
    unsafe {
        // One triangle is not all of a tangent with friction.
        let status = dc_triplets(handle, &FRICTION, 1, null_mut(), null_mut(), null_mut(), 0, &mut count);
        assert_eq!(status, DC_BAD_OPTION, "{}", message());
        assert!(message().starts_with("unsymmetric: "), "{}", message());
        assert_friction(handle, &with, &without);
        let (mut stuck, mut sliding, mut dissipated) = (9, 9, 0.0);
        let (mut unanchored, mut dropped) = (9, 9);
        let counts: [*mut usize; 4] = [&mut stuck, &mut sliding, &mut unanchored, &mut dropped];
        let [a, b, c, d] = counts;
        assert_eq!(dc_accept(handle, &FRICTION, a, b, c, d, &mut dissipated), DC_OK);
        assert_eq!((stuck, sliding, unanchored, dropped), (0, 4, 0, 0));
        assert!(dissipated > 0.0);
        assert_eq!(dc_history(handle, null_mut(), 0, &mut count), DC_OK);
        let (mut small, mut needed) = ([0.0], 0);
        assert_eq!(dc_history(handle, small.as_mut_ptr(), 1, &mut needed), DC_BAD_SIZE);
        assert_eq!((small, needed), ([0.0], count));
    }
    let mut history = vec![0.0; count];
    // SAFETY: the array has the length given.
    assert_eq!(unsafe { dc_history(handle, history.as_mut_ptr(), count, &mut count) }, DC_OK);
    let kept = |handle| {
        let (mut again, mut found) = (vec![0.0; count], 0);
        // SAFETY: the array has the length given.
        let status = unsafe { dc_history(handle, again.as_mut_ptr(), count, &mut found) };
        assert_eq!(status, DC_OK);
        again.truncate(found);
        again
    };
    // Planes that are the same.
    // SAFETY: there are none.
    assert_eq!(unsafe { dc_set_symmetry(handle, std::ptr::null(), 0) }, DC_OK);
    assert_eq!(kept(handle), history);
    let further = slid(&mesh, 0.06);
    refresh(&further, handle);
    let expected = residual(handle, &FRICTION);
    // Away from the surface, with forces until now.
    refresh(&slid(&mesh, 50.0), handle);
    let mut dropped = 9;
    // SAFETY: a whole structure.
    let status =
        unsafe { dc_accept(handle, &FRICTION, null_mut(), null_mut(), null_mut(), &mut dropped, null_mut()) };
    assert_eq!((status, dropped), (DC_OK, 4));
    assert_eq!(dc_destroy(handle), DC_OK);

    let handle = interface();
    // SAFETY: the array has the length given.
    assert_eq!(unsafe { dc_set_history(handle, history.as_ptr(), count) }, DC_OK);
    let plane = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
    // SAFETY: the arrays have the lengths given.
    unsafe {
        assert_eq!(dc_set_symmetry(handle, plane.as_ptr(), 1), DC_OK, "{}", message());
        assert!(kept(handle).is_empty(), "it is that of the planes of before");
        assert_eq!(dc_set_symmetry(handle, std::ptr::null(), 0), DC_OK);
        assert_eq!(dc_set_history(handle, history.as_ptr(), count), DC_OK);
    }
    refresh(&further, handle);
    assert_eq!(residual(handle, &FRICTION), expected);
    // What slid freely is no slip of the next increment; the evaluation ends, as the history is another one.
    let free = residual(handle, &LAW);
    assert_eq!(accept(handle, &LAW), DC_OK);
    let mut sum = vec![0.0; 120];
    // SAFETY: the array has the length given.
    let status = unsafe { dc_add_forces(handle, &FRICTION, sum.as_mut_ptr(), 120, null_mut()) };
    assert_eq!(status, DC_NOT_EVALUATED, "{}", message());
    refresh(&further, handle);
    let with = residual(handle, &FRICTION);
    assert!(with.iter().zip(&free).all(|(with, free)| (with - free).abs() < 1e-10), "{with:?} {free:?}");
    // SAFETY: the array has the length given.
    unsafe {
        assert_eq!(dc_set_history(handle, history.as_ptr(), count - 1), DC_BAD_OPTION);
        assert!(message().starts_with("invalid-history: "), "{}", message());
        assert_eq!(dc_set_history(handle, std::ptr::null(), 0), DC_OK);
    }
    refresh(&further, handle);
    assert_eq!(dc_evaluate(handle, 2), DC_OK);
    // SAFETY: the array has the length given.
    let status = unsafe { dc_add_forces(handle, &FRICTION, sum.as_mut_ptr(), 120, null_mut()) };
    assert_eq!(status, DC_NOT_EVALUATED, "{}", message());
    assert_eq!(dc_destroy(handle), DC_OK);
}

/// On facets in every build.
#[test]
fn facets_have_the_friction_of_the_runtime_to_the_last_bit() {
    agrees_with_the_runtime(&dc_options { element: 1, ..options() }, InterfaceOptions::node_to_facet());
}

#[test]
#[cfg(feature = "friction")]
fn the_smooth_surface_has_the_friction_of_the_runtime_to_the_last_bit() {
    agrees_with_the_runtime(&options(), InterfaceOptions::default());
}

fn bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|number| number.to_bits()).collect()
}

/// Forces, the tangent in a matrix of the caller's, and the history: of slaves that stick, then of slaves that slide.
fn agrees_with_the_runtime(options: &dc_options, of_runtime: InterfaceOptions) {
    let mesh = Mesh::new();
    let (status, handle) = mesh.make(options);
    assert_eq!(status, DC_OK, "{}", message());
    let mut own = mesh.of_runtime(of_runtime);
    let coulomb = Coulomb::new(FRICTION.friction, FRICTION.tangential_stiffness).unwrap();
    let law = ContactLaw::penalty(FRICTION.penalty).with_friction(Some(coulomb));
    refresh(&mesh, handle);
    assert_eq!(accept(handle, &FRICTION), DC_OK);
    own.refresh_pairing(mesh.points()).unwrap();
    own.accept(&law).unwrap();
    for (step, sliding) in [(1e-4, 0), (0.05, 4)] {
        let moved = slid(&mesh, step);
        refresh(&moved, handle);
        own.refresh_pairing(moved.points()).unwrap();
        for tangent in [Tangent::Exact, Tangent::GaussNewton] {
            let law = law.with_tangent(tangent);
            let of_c = dc_law { tangent: i32::from(tangent == Tangent::GaussNewton), ..FRICTION };
            let found = residual(handle, &of_c);
            let dofs = DofMap::standard(40);
            let mut forces = vec![0.0; 120];
            let contacts = own.evaluate(Mode::Hessian).unwrap();
            add_forces(contacts, &law, &dofs, &mut forces).unwrap();
            assert_eq!(bits(&found), bits(&forces), "{step}");
            let pattern = CsrPattern::union(contacts, &dofs).unwrap();
            let map = CsrMap::within(contacts, &dofs, pattern.row_offsets(), pattern.columns()).unwrap();
            // What the caller's matrix holds already.
            let mut values: Vec<f64> = (0..pattern.entries()).map(|k| (k as f64).sin()).collect();
            let (offsets, columns, from_c) = added(handle, &of_c, &values);
            map.add(contacts, &law, &mut values).unwrap();
            assert!(offsets.iter().map(|&offset| offset as usize).eq(pattern.row_offsets().iter().copied()));
            assert!(columns.iter().map(|&column| column as u32).eq(pattern.columns().iter().copied()));
            assert_eq!(bits(&from_c), bits(&values), "{step}");
        }
        let mut count = 0;
        let report = own.accept(&law).unwrap();
        assert_eq!((report.sliding, report.stuck + report.sliding), (sliding, 4));
        assert_eq!(accept(handle, &FRICTION), DC_OK);
        let expected = own.history();
        let mut history = vec![0.0; expected.len()];
        // SAFETY: the array has the length given.
        assert_eq!(unsafe { dc_history(handle, history.as_mut_ptr(), history.len(), &mut count) }, DC_OK);
        assert_eq!((count, bits(&history)), (expected.len(), bits(&expected)));
    }
    assert_eq!(dc_destroy(handle), DC_OK);
}

/// Row offsets and columns of the tangent, and what it makes of a matrix that holds `values` there.
fn added(handle: *mut dc_interface, law: &dc_law, values: &[f64]) -> (Vec<i32>, Vec<i32>, Vec<f64>) {
    let (mut pattern, mut map, mut count) = (null_mut(), null_mut(), 0);
    let mut sums = values.to_vec();
    // SAFETY: the arrays have the lengths given.
    unsafe {
        assert_eq!(dc_pattern_create(handle, &mut pattern, &mut count), DC_OK);
        assert_eq!(count, values.len());
        let (mut offsets, mut columns) = (vec![0; 121], vec![0; count]);
        let rows = (offsets.as_mut_ptr(), columns.as_mut_ptr());
        assert_eq!(dc_pattern_structure(pattern, rows.0, 121, rows.1, count), DC_OK);
        assert_eq!(dc_pattern_destroy(pattern), DC_OK);
        assert_eq!(dc_map_create(handle, rows.0, 121, rows.1, count, &mut map), DC_OK);
        let status = dc_map_add(map, handle, law, sums.as_mut_ptr(), count, null_mut());
        assert_eq!(status, DC_OK, "{}", message());
        assert_eq!(dc_map_destroy(map), DC_OK);
        (offsets, columns, sums)
    }
}
