//! What dc_cutback says, and when.

use std::ptr::null_mut;

use super::misuse::refreshed;
use super::{Mesh, message, options};
use crate::contacts::{dc_cutback, dc_gaps};
use crate::interface::{
    dc_destroy, dc_evaluate, dc_follow, dc_freeze, dc_interface, dc_refresh, dc_report, dc_thaw, dc_update,
};
use crate::options::dc_options;
use crate::outcome::dc_outcome;
use crate::status::{DC_FROZEN, DC_NOT_EVALUATED, DC_OK};

/// The hint; `None` if there is no evaluation.
fn hint(handle: *mut dc_interface) -> Option<f64> {
    let mut factor = -1.0;
    // SAFETY: it may be written.
    match unsafe { dc_cutback(handle, &mut factor) } {
        DC_OK => Some(factor),
        status => {
            assert_eq!((status, factor), (DC_NOT_EVALUATED, -1.0), "{}", message());
            None
        }
    }
}

/// Moves the first slave to a place beside its own.
fn moved(mesh: &Mesh, by: [f64; 3]) -> Vec<f64> {
    let mut positions = mesh.positions.clone();
    (0..3).for_each(|axis| positions[3 * 36 + axis] += by[axis]);
    positions
}

fn update(handle: *mut dc_interface, positions: &[f64]) {
    // SAFETY: as many positions as nodes.
    assert_eq!(unsafe { dc_update(handle, positions.as_ptr(), 40) }, DC_OK);
}

#[test]
fn there_is_no_hint_without_an_evaluation() {
    let mesh = Mesh::new();
    let handle = refreshed(&mesh);
    assert_eq!(hint(handle), None);
    assert_eq!(dc_evaluate(handle, 0), DC_OK);
    assert_eq!(hint(handle), Some(1.0));
    update(handle, &mesh.positions);
    assert_eq!(hint(handle), None, "of other positions");
    assert_eq!(dc_evaluate(handle, 2), DC_OK);
    assert_eq!(hint(handle), Some(1.0));
    assert_eq!(dc_freeze(handle), DC_OK);
    // SAFETY: as many positions as nodes.
    assert_eq!(unsafe { dc_refresh(handle, mesh.positions.as_ptr(), 40, null_mut()) }, DC_FROZEN);
    assert_eq!(hint(handle), None, "a frozen refresh is an update");
    assert_eq!(dc_destroy(handle), DC_OK);
}

#[test]
fn a_slave_that_lost_its_surface_asks_until_it_has_it_again() {
    let mesh = Mesh::new();
    let handle = refreshed(&mesh);
    assert_eq!(dc_evaluate(handle, 0), DC_OK);
    // Through the ridge and beyond its centre of curvature, which lies 12.5 below its crest: barely, then well.
    for down in [-12.6, -14.0] {
        update(handle, &moved(&mesh, [0.4, 0.0, down]));
        for _ in 0..3 {
            assert_eq!(dc_evaluate(handle, 0), DC_OK);
            let (mut outcomes, mut gaps) = ([-1; 4], [0.0; 4]);
            // SAFETY: an entry for each slave.
            assert_eq!(unsafe { dc_gaps(handle, outcomes.as_mut_ptr(), gaps.as_mut_ptr(), 4) }, DC_OK);
            assert_eq!(outcomes[0], dc_outcome::DC_BEYOND_CENTRE_OF_CURVATURE as i32);
            assert_eq!(hint(handle), Some(0.25));
        }
    }
    update(handle, &mesh.positions);
    assert_eq!(dc_evaluate(handle, 0), DC_OK);
    assert_eq!(hint(handle), Some(1.0));
    assert_eq!(dc_destroy(handle), DC_OK);
}

/// What a refresh at accepted positions loses is in its report: no shorter increment brings it back.
#[test]
fn a_contact_lost_by_a_refresh_is_no_reason_to_cut_back() {
    let mesh = Mesh::new();
    let limited = dc_options { distance_limit: 0.5, ..options() };
    let (status, handle) = mesh.make(&limited);
    assert_eq!(status, DC_OK);
    // SAFETY: numbers, of which any bits are a value.
    let mut report = dc_report { size: size_of::<dc_report>(), ..unsafe { std::mem::zeroed() } };
    // SAFETY: as many positions as nodes.
    let refresh = |positions: &[f64], report: &mut dc_report| unsafe {
        dc_refresh(handle, positions.as_ptr(), 40, report)
    };
    assert_eq!(refresh(&mesh.positions, &mut report), DC_OK);
    assert_eq!(refresh(&moved(&mesh, [0.0, 0.0, -0.6]), &mut report), DC_OK);
    assert!(report.contacts_lost == 1 && report.lost_gap < -0.4, "{report:?}");
    assert_eq!(dc_thaw(handle), DC_OK);
    assert_eq!(dc_evaluate(handle, 0), DC_OK);
    assert_eq!(hint(handle), Some(1.0));
    // So is what following lost before.
    assert_eq!(refresh(&mesh.positions, &mut report), DC_OK);
    let down = moved(&mesh, [0.0, 0.0, -0.6]);
    // SAFETY: as many positions as nodes.
    assert_eq!(unsafe { dc_follow(handle, down.as_ptr(), 40, null_mut()) }, DC_OK);
    assert_eq!(refresh(&down, &mut report), DC_OK);
    assert!(report.contacts_lost == 1 && report.lost == 0 && report.lost_gap < -0.4, "{report:?}");
    assert_eq!(dc_destroy(handle), DC_OK);
}
