//! Windows from C: sent as numbers, they give the results of the whole.

use std::ptr::{null, null_mut};

use super::{Mesh, message};
use crate::choice::dc_mode;
use crate::contacts::dc_gaps;
use crate::interface::{dc_destroy, dc_evaluate, dc_interface, dc_refresh};
use crate::outcome::dc_outcome;
use crate::status::{DC_BAD_HANDLE, DC_BAD_OPTION, DC_OK};
use crate::window::{
    dc_create_in_window, dc_window, dc_window_counts, dc_window_create, dc_window_destroy,
    dc_window_from_numbers, dc_window_names, dc_window_numbers,
};

/// Gaps and outcomes of the four slaves at these positions.
fn gaps(interface: *mut dc_interface, positions: &[f64]) -> (Vec<u64>, Vec<i32>) {
    let (mut gaps, mut outcomes) = ([0.0; 4], [-1; 4]);
    // SAFETY: the arrays have the lengths given.
    unsafe {
        let nodes = positions.len() / 3;
        assert_eq!(dc_refresh(interface, positions.as_ptr(), nodes, null_mut()), DC_OK, "{}", message());
        assert_eq!(dc_evaluate(interface, dc_mode::DC_GRADIENT as i32), DC_OK);
        assert_eq!(dc_gaps(interface, outcomes.as_mut_ptr(), gaps.as_mut_ptr(), 4), DC_OK);
    }
    (gaps.map(f64::to_bits).to_vec(), outcomes.to_vec())
}

/// A window of these boxes, made of the numbers of one that is gone.
fn sent(whole: *mut dc_interface, boxes: &[f64]) -> (*mut dc_window, Vec<i64>) {
    let (mut window, mut again) = (null_mut(), null_mut());
    let [mut nodes, mut facets, mut integers, mut reals] = [0; 4];
    // SAFETY: the arrays have the lengths given.
    unsafe {
        let made = dc_window_create(whole, boxes.as_ptr(), boxes.len() / 6, 0.0, &mut window);
        assert_eq!(made, DC_OK, "{}", message());
        assert_eq!(dc_window_counts(window, &mut nodes, &mut facets, &mut integers, &mut reals), DC_OK);
        let (mut names, mut whole_numbers, mut numbers) =
            (vec![0; nodes], vec![0; integers], vec![0.0; reals]);
        assert_eq!(dc_window_names(window, names.as_mut_ptr(), nodes, null_mut(), 0), DC_OK);
        let status =
            dc_window_numbers(window, whole_numbers.as_mut_ptr(), integers, numbers.as_mut_ptr(), reals);
        assert_eq!(status, DC_OK);
        assert_eq!(dc_window_destroy(window), DC_OK);
        assert_eq!(dc_window_destroy(window), DC_BAD_HANDLE);
        let status =
            dc_window_from_numbers(whole_numbers.as_ptr(), integers, numbers.as_ptr(), reals, &mut again);
        assert_eq!(status, DC_OK, "{}", message());
        whole_numbers[0] += 1;
        let mut none = null_mut();
        let status =
            dc_window_from_numbers(whole_numbers.as_ptr(), integers, numbers.as_ptr(), reals, &mut none);
        assert!(status == DC_BAD_OPTION && none.is_null());
        assert!(message().starts_with("invalid-window: "), "{}", message());
        (again, names)
    }
}

#[test]
fn a_window_gives_the_gaps_of_the_whole_or_none() {
    let mesh = Mesh::new();
    let whole = mesh.interface();
    let expected = gaps(whole, &mesh.positions);
    assert_eq!(expected.1, [dc_outcome::DC_CONTACT as i32; 4]);
    let wide = [1.0, 1.0, -2.0, 4.5, 4.5, 2.0];
    // Far from all of the surface.
    let aside = [8.0, 8.0, 8.0, 9.0, 9.0, 9.0];
    for (boxes, is_known) in [(wide, true), (aside, false)] {
        let (window, names) = sent(whole, &boxes);
        let name = |&node: &i64| 3 * node as usize;
        let mut positions: Vec<f64> =
            names.iter().flat_map(|node| &mesh.positions[name(node)..name(node) + 3]).copied().collect();
        positions.extend(&mesh.positions[3 * 36..]);
        let slaves: Vec<i32> = (0..4).map(|k| names.len() as i32 + k).collect();
        let mut part = null_mut();
        // SAFETY: the arrays have the lengths given.
        unsafe {
            let nodes = positions.len() / 3;
            let (of_nodes, of_slaves) = (positions.as_ptr(), slaves.as_ptr());
            let facet = slaves.as_ptr();
            let status =
                dc_create_in_window(window, of_nodes, nodes, of_slaves, 4, facet, 1, null(), &mut part);
            assert!(status == DC_BAD_OPTION && message().contains("areas"), "{}", message());
            let status =
                dc_create_in_window(window, of_nodes, nodes, of_slaves, 4, null(), 0, null(), &mut part);
            assert_eq!(status, DC_OK, "{}", message());
            assert_eq!(dc_window_destroy(window), DC_OK);
        }
        let found = gaps(part, &positions);
        if is_known {
            assert_eq!(found, expected);
        } else {
            assert!(names.is_empty());
            assert_eq!(found.1, [dc_outcome::DC_BEYOND_WINDOW as i32; 4]);
        }
        // SAFETY: as above.
        unsafe {
            let mut none = null_mut();
            assert_eq!(dc_window_create(part, wide.as_ptr(), 1, 0.0, &mut none), DC_BAD_OPTION);
            assert!(message().starts_with("in-window: ") && none.is_null(), "{}", message());
        }
        assert_eq!(dc_destroy(part), DC_OK);
    }
    assert_eq!(dc_destroy(whole), DC_OK);
}
