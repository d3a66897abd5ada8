//! Domains of influence: lists that follow, symmetry planes, and what a report says of them.

use std::ptr::{null, null_mut};

use runtime::Mode;
use runtime::interface::{ContactInterface, InterfaceOptions};
use runtime::surface::{Facet, MasterSurface, SymmetryPlane};

use super::misuse::{LAW, dc_report_of_size, refreshed};
use super::{Mesh, message, options};
use crate::choice::{dc_frame, dc_rule};
use crate::contacts::{dc_contact, dc_contact_of, dc_gaps};
use crate::interface::{
    dc_destroy, dc_evaluate, dc_follow, dc_freeze, dc_interface, dc_refresh, dc_renew, dc_report,
    dc_set_symmetry, dc_thaw, dc_update,
};
use crate::neighbours::{dc_pair, dc_pairing};
use crate::options::dc_options;
use crate::outcome::dc_fallback;
use crate::pattern::{dc_pattern_create, dc_pattern_destroy, dc_pattern_fill};
use crate::status::*;

/// Of all four slaves.
fn gaps(handle: *mut dc_interface) -> [f64; 4] {
    let mut gaps = [0.0; 4];
    assert_eq!(dc_evaluate(handle, 2), DC_OK);
    // SAFETY: an entry for each slave.
    assert_eq!(unsafe { dc_gaps(handle, null_mut(), gaps.as_mut_ptr(), 4) }, DC_OK);
    gaps
}

/// The slaves moved along x.
fn slid(mesh: &Mesh, by: f64) -> Vec<f64> {
    let mut positions = mesh.positions.clone();
    positions.iter_mut().skip(3 * 36).step_by(3).for_each(|x| *x += by);
    positions
}

#[test]
fn lists_follow_and_say_so() {
    let mesh = Mesh::new();
    let handle = mesh.interface();
    let mut report = dc_report_of_size(size_of::<dc_report>());
    let (mut pattern, mut entries, mut rebuilt) = (null_mut(), 0, -1);
    // SAFETY: the arrays have the lengths given.
    unsafe {
        let follow =
            |positions: &[f64], rebuilt: *mut i32| dc_follow(handle, positions.as_ptr(), 40, rebuilt);
        let refresh =
            |positions: &[f64], report: *mut dc_report| dc_refresh(handle, positions.as_ptr(), 40, report);
        assert_eq!(follow(&mesh.positions, &mut rebuilt), DC_OK);
        assert_eq!(rebuilt, 0, "there are no lists yet");
        assert_eq!(refresh(&mesh.positions, &mut report), DC_OK);
        assert_eq!((report.paired, report.gained, report.rebuilt, report.deep), (4, 4, 1, 0));
        let here = gaps(handle);
        assert_eq!(dc_pattern_create(handle, &mut pattern, &mut entries), DC_OK);
        let mut values = vec![0.0; entries];
        let mut fill = || dc_pattern_fill(pattern, handle, &LAW, values.as_mut_ptr(), entries, null_mut());

        let (near, far) = (slid(&mesh, 0.01), slid(&mesh, 0.9));
        assert_eq!(follow(&near, &mut rebuilt), DC_OK);
        assert_eq!((rebuilt, fill()), (0, DC_NOT_EVALUATED));
        assert_ne!(gaps(handle), here);
        assert_eq!(fill(), DC_OK);
        assert_eq!(refresh(&near, &mut report), DC_OK);
        assert_eq!((report.paired, report.kept, report.rebuilt), (4, 4, 0));
        gaps(handle);
        assert_eq!(fill(), DC_OK, "the lists are those of before");
        assert_eq!(dc_renew(handle, near.as_ptr(), 40, &mut report), DC_OK);
        assert_eq!((report.paired, report.kept, report.rebuilt), (4, 0, 1));
        let there = gaps(handle);
        // What is refused leaves the evaluation as it is.
        let wrong: Vec<f64> = near.iter().map(|_| f64::NAN).collect();
        for refused in [dc_refresh, dc_renew] {
            assert_eq!(refused(handle, wrong.as_ptr(), 40, &mut report), DC_NOT_FINITE);
            let mut gaps = [0.0; 4];
            assert_eq!(dc_gaps(handle, null_mut(), gaps.as_mut_ptr(), 4), DC_OK);
            assert_eq!(gaps, there);
        }

        assert_eq!(dc_freeze(handle), DC_OK);
        assert_eq!(follow(&far, &mut rebuilt), DC_FROZEN);
        assert_eq!(rebuilt, 0);
        assert!(message().starts_with("frozen: "), "{}", message());
        assert_eq!(dc_thaw(handle), DC_OK);
        assert_eq!(follow(&far, &mut rebuilt), DC_OK);
        assert_eq!(rebuilt, 1);
        gaps(handle);
        assert_eq!(fill(), DC_PATTERN_MISMATCH);
        // Back there are the gaps of the beginning, whatever the lists are.
        assert_eq!(follow(&mesh.positions, null_mut()), DC_OK);
        let back = gaps(handle);
        assert!(here.iter().zip(back).all(|(x, y)| (x - y).abs() < 1e-14), "{here:?} {back:?}");

        let mut overlapping = mesh.positions.clone();
        let inside = overlapping.as_mut_ptr().wrapping_add(7).cast();
        assert_eq!(dc_follow(handle, overlapping.as_ptr(), 40, inside), DC_BAD_POINTER);
        assert_eq!(dc_follow(handle, null(), 40, null_mut()), DC_BAD_POINTER);
        assert_eq!(dc_follow(handle, mesh.positions.as_ptr(), 39, null_mut()), DC_BAD_SIZE);
        assert_eq!(dc_follow(null_mut(), mesh.positions.as_ptr(), 40, null_mut()), DC_BAD_HANDLE);
        assert_eq!(dc_pattern_destroy(pattern), DC_OK);
    }
    assert_eq!(dc_destroy(handle), DC_OK);
}

/// The mesh with slaves at its edge y = 0.
fn at_the_edge() -> Mesh {
    let mut mesh = Mesh::new();
    mesh.positions.iter_mut().skip(3 * 36 + 1).step_by(3).for_each(|y| *y -= 2.1);
    mesh
}

#[test]
fn symmetry_planes_are_those_of_the_runtime() {
    let mesh = at_the_edge();
    let (positions, _) = mesh.positions.as_chunks::<3>();
    let corners = |row: &[i32; 4]| Facet::Quadrilateral(row.map(|node| node as usize));
    let facets = mesh.facets.as_chunks::<4>().0.iter().map(corners).collect();
    let master = MasterSurface::new(positions, facets).unwrap();
    let slaves = mesh.slaves.iter().map(|&node| node as usize).collect();
    let mut expected =
        ContactInterface::new(master, slaves, &[], positions, InterfaceOptions::default()).unwrap();
    expected.set_symmetry(&[SymmetryPlane::across(1, [0.0; 3])]).unwrap();
    expected.refresh_pairing(positions).unwrap();
    let expected = expected.evaluate(Mode::Hessian).unwrap();

    let handle = refreshed(&mesh);
    let without = gaps(handle);
    let planes = [9.0, 0.0, 7.0, 0.0, 1.0, 0.0];
    let mut contact = dc_contact::default();
    // SAFETY: the arrays have the lengths given.
    unsafe {
        assert_eq!(dc_set_symmetry(handle, planes.as_ptr(), 1), DC_OK);
        assert_eq!(dc_contact_of(handle, 0, &mut contact), DC_NOT_EVALUATED);
        assert_eq!(dc_evaluate(handle, 0), DC_NOT_EVALUATED);
        assert!(message().starts_with("not-refreshed: "), "{}", message());
        assert_eq!(dc_refresh(handle, mesh.positions.as_ptr(), 40, null_mut()), DC_OK);
    }
    let with = gaps(handle);
    assert_ne!(with[0], without[0]);
    for (k, contact) in expected.iter().enumerate() {
        assert_eq!(with[k], contact.point.gap);
    }
    // Without planes it is as at the beginning.
    // SAFETY: nothing is read; as many positions as nodes.
    unsafe {
        assert_eq!(dc_set_symmetry(handle, null(), 0), DC_OK);
        assert_eq!(dc_refresh(handle, mesh.positions.as_ptr(), 40, null_mut()), DC_OK);
    }
    assert_eq!(gaps(handle), without);
    assert_eq!(dc_destroy(handle), DC_OK);
}

#[test]
fn planes_that_are_refused_change_nothing() {
    let mesh = at_the_edge();
    for rule in [dc_rule::DC_HULL_LAYERS, dc_rule::DC_HULL_RADIUS, dc_rule::DC_NEAREST] {
        let (status, handle) = mesh.make(&dc_options { rule: rule as i32, ..options() });
        assert_eq!(status, DC_OK);
        // SAFETY: six numbers, or none.
        unsafe {
            assert_eq!(dc_set_symmetry(handle, [0.0, 0.0, 0.0, 0.0, 1.0, 0.0].as_ptr(), 1), DC_BAD_OPTION);
            assert!(message().starts_with("no-symmetry: "), "{}", message());
            assert_eq!(dc_set_symmetry(handle, null(), 0), DC_OK);
        }
        assert_eq!(dc_destroy(handle), DC_OK);
    }
    let facets = dc_options { element: 1, ..options() };
    for element in [options(), facets] {
        let (status, handle) = mesh.make(&element);
        assert_eq!(status, DC_OK);
        // SAFETY: the arrays have the lengths given.
        unsafe {
            assert_eq!(dc_refresh(handle, mesh.positions.as_ptr(), 40, null_mut()), DC_OK);
            let before = gaps(handle);
            let refused = |plane: [f64; 6]| dc_set_symmetry(handle, plane.as_ptr(), 1);
            assert_eq!(refused([0.0, 0.0, 0.0, 0.0, 2.0, 0.0]), DC_BAD_SURFACE);
            assert!(message().starts_with("invalid-symmetry: "), "{}", message());
            assert_eq!(refused([0.0; 6]), DC_BAD_SURFACE);
            assert_eq!(refused([0.0, f64::NAN, 0.0, 0.0, 1.0, 0.0]), DC_BAD_SURFACE);
            assert_eq!(refused([0.0, 0.0, 0.0, f64::NAN, 1.0, 0.0]), DC_BAD_SURFACE);
            assert_eq!(dc_set_symmetry(handle, null(), 1), DC_BAD_POINTER);
            assert_eq!(dc_set_symmetry(handle, [0.0; 6].as_ptr(), usize::MAX / 4), DC_BAD_SIZE);
            assert_eq!(gaps(handle), before);
            assert_eq!(refused([0.0, 0.0, 0.0, 0.0, 1.0, 0.0]), DC_OK);
            assert_eq!(dc_refresh(handle, mesh.positions.as_ptr(), 40, null_mut()), DC_OK);
        }
        assert_eq!(dc_destroy(handle), DC_OK);
    }
}

/// Images that stand above one another leave no node but their own beside a centre; that ends all the same.
#[test]
fn planes_along_the_surface_are_no_trap() {
    let mut mesh = Mesh::new();
    mesh.positions.iter_mut().take(3 * 36).skip(2).step_by(3).for_each(|z| *z = 0.0);
    let handle = mesh.interface();
    let planes = [0.0, 0.0, -0.25, 0.0, 0.0, 1.0, 0.0, 0.0, 0.25, 0.0, 0.0, -1.0];
    // SAFETY: two planes, and as many positions as nodes.
    unsafe {
        assert_eq!(dc_set_symmetry(handle, planes.as_ptr(), 2), DC_OK);
        assert_eq!(dc_refresh(handle, mesh.positions.as_ptr(), 40, null_mut()), DC_OK);
    }
    assert_eq!(dc_evaluate(handle, 2), DC_OK);
    assert_eq!(dc_destroy(handle), DC_OK);
}

/// A master whose corners go round the wrong way has its outside below, and slaves above it lie deep inside.
#[test]
fn a_master_inside_out_is_counted() {
    let mut mesh = Mesh::new();
    mesh.facets.as_chunks_mut::<4>().0.iter_mut().for_each(|corners| corners.reverse());
    (36..40).for_each(|slave| mesh.positions[3 * slave + 2] = 0.5);
    let handle = mesh.interface();
    let mut report = dc_report_of_size(size_of::<dc_report>());
    // SAFETY: as many positions as nodes.
    assert_eq!(unsafe { dc_refresh(handle, mesh.positions.as_ptr(), 40, &mut report) }, DC_OK);
    assert_eq!((report.paired, report.deep), (4, 4));
    assert_eq!(dc_destroy(handle), DC_OK);
}

/// A program that knows the report as it was before gets as much of it.
#[test]
fn a_shorter_report_is_filled_as_far_as_it_goes() {
    let mesh = Mesh::new();
    let handle = mesh.interface();
    let before = std::mem::offset_of!(dc_report, rebuilt);
    let mut report = dc_report { rebuilt: -6, ..dc_report_of_size(before) };
    // SAFETY: as many positions as nodes.
    assert_eq!(unsafe { dc_refresh(handle, mesh.positions.as_ptr(), 40, &mut report) }, DC_OK);
    assert_eq!((report.size, report.paired), (before, 4));
    assert_eq!(report.rebuilt, -6);
    assert_eq!(dc_destroy(handle), DC_OK);
}

#[test]
fn without_a_surface_domains_stand_for_hull_layers() {
    let mesh = Mesh::new();
    let pair = |options: *const dc_options| {
        let mut masters = [-1; 36];
        // SAFETY: numbers, of which any bits are a value.
        let mut pairing = dc_pairing { size: size_of::<dc_pairing>(), ..unsafe { std::mem::zeroed() } };
        let (slave, outward) = ([2.4, 2.3, -0.02], [0.0, 0.0, 1.0]);
        // SAFETY: the arrays have the lengths given.
        let status = unsafe {
            dc_pair(
                options,
                slave.as_ptr(),
                mesh.positions.as_ptr(),
                36,
                outward.as_ptr(),
                masters.as_mut_ptr(),
                36,
                &mut pairing,
            )
        };
        assert_eq!(status, DC_OK, "{}", message());
        (masters, pairing)
    };
    let defaults = options();
    assert_eq!(defaults.rule, dc_rule::DC_DOMAINS as i32);
    let layers = pair(&dc_options { rule: dc_rule::DC_HULL_LAYERS as i32, ..defaults });
    assert_eq!(pair(&defaults), layers);
    assert_eq!(pair(null()), layers);
}

/// Master and slaves drawn out along y.
fn stretched(mesh: &Mesh, by: f64) -> Vec<f64> {
    mesh.positions.iter().enumerate().map(|(k, x)| if k % 3 == 1 { by * x } else { *x }).collect()
}

/// Domains stretch with the master: no refresh changes a gap, and it does not matter by which way a position is reached.
#[test]
fn a_stretched_master_renews_nothing() {
    let mesh = Mesh::new();
    let handle = refreshed(&mesh);
    let here = gaps(handle);
    let mut report = dc_report_of_size(size_of::<dc_report>());
    let (mut rebuilt, mut last) = (0, here);
    // SAFETY: as many positions as nodes.
    unsafe {
        for step in 1..=100 {
            let positions = stretched(&mesh, 1.0 + 0.01 * f64::from(step));
            assert_eq!(dc_update(handle, positions.as_ptr(), 40), DC_OK);
            let before = gaps(handle);
            assert_eq!(dc_refresh(handle, positions.as_ptr(), 40, &mut report), DC_OK);
            assert_eq!((report.paired, report.extended, report.linear), (4, 0, 0), "{report:?}");
            assert_eq!((report.jump_node, report.contacts_lost, report.contacts_gained), (-1, 0, 0));
            rebuilt += report.rebuilt;
            let after = gaps(handle);
            for k in 0..4 {
                assert!((after[k] - before[k]).abs() < 1e-13, "{step}: {before:?} {after:?}");
                assert!((after[k] - last[k]).abs() < 1e-3, "{step}: {last:?} {after:?}");
            }
            last = after;
        }
        assert!(rebuilt > 1, "the lists have followed");
        let far = stretched(&mesh, 2.0);
        let direct = refreshed(&mesh);
        assert_eq!(dc_refresh(direct, far.as_ptr(), 40, null_mut()), DC_OK);
        let at_once = gaps(direct);
        assert!(last.iter().zip(at_once).all(|(x, y)| (x - y).abs() < 1e-13), "{last:?} {at_once:?}");
        assert_eq!(dc_destroy(direct), DC_OK);
        // Made there, an interface has that for its first configuration.
        let another = refreshed(&Mesh { positions: far, ..mesh.clone() });
        assert_ne!(gaps(another), last);
        assert_eq!(dc_destroy(another), DC_OK);
        assert_eq!(dc_refresh(handle, mesh.positions.as_ptr(), 40, &mut report), DC_OK);
    }
    let back = gaps(handle);
    assert!(here.iter().zip(back).all(|(x, y)| (x - y).abs() < 1e-13), "{here:?} {back:?}");
    assert_eq!(dc_destroy(handle), DC_OK);
}

/// The distance from the parabola z = -0.04 (x - 2.5)^2.
fn distance_from_the_ridge(x: f64, z: f64) -> f64 {
    let distance = |foot: f64| (x - 2.5 - foot).hypot(z + 0.04 * foot * foot);
    let (mut low, mut high) = (-2.5, 2.5);
    for _ in 0..200 {
        let (one, other) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if distance(one) < distance(other) { high = other } else { low = one }
    }
    distance(low)
}

#[test]
fn a_slave_far_away_has_a_gap_like_any_other() {
    let mut mesh = Mesh::new();
    for z in mesh.positions.iter_mut().skip(3 * 36 + 2).step_by(3) {
        *z += 4.0;
    }
    let handle = mesh.interface();
    let mut report = dc_report_of_size(size_of::<dc_report>());
    let mut contact = dc_contact::default();
    // SAFETY: as many positions as nodes, and it may be written.
    unsafe {
        assert_eq!(dc_refresh(handle, mesh.positions.as_ptr(), 40, &mut report), DC_OK);
        assert_eq!((report.paired, report.extended, report.linear), (4, 0, 0), "{report:?}");
        let gaps = gaps(handle);
        for (k, gap) in gaps.iter().enumerate() {
            assert_eq!(dc_contact_of(handle, k, &mut contact), DC_OK, "{}", message());
            assert_eq!(contact.fallback, dc_fallback::DC_NO_FALLBACK as i32);
            let [x, _, z] = mesh.positions.as_chunks::<3>().0[36 + k];
            assert!((gap - distance_from_the_ridge(x, z)).abs() < 2e-3, "slave {k}: {gap}");
        }
    }
    assert_eq!(dc_destroy(handle), DC_OK);
}

#[test]
fn a_held_frame_needs_another_rule() {
    let mesh = Mesh::new();
    let held = dc_options { frame: dc_frame::DC_HELD as i32, ..options() };
    assert_eq!(mesh.make(&held).0, DC_BAD_OPTION);
    assert!(message().starts_with("held-frame: "), "{}", message());
    for rule in [dc_rule::DC_HULL_LAYERS, dc_rule::DC_HULL_RADIUS, dc_rule::DC_NEAREST] {
        let (status, handle) = mesh.make(&dc_options { rule: rule as i32, ..held });
        assert_eq!(status, DC_OK, "{}", message());
        // SAFETY: as many positions as nodes.
        assert_eq!(unsafe { dc_refresh(handle, mesh.positions.as_ptr(), 40, null_mut()) }, DC_OK);
        gaps(handle);
        assert_eq!(dc_destroy(handle), DC_OK);
    }
    // Facets have no frame.
    let (status, handle) = mesh.make(&dc_options { element: 1, ..held });
    assert_eq!((status, dc_destroy(handle)), (DC_OK, DC_OK));
}
