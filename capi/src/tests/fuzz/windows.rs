//! Calls for windows, and for the parts of a surface that they are cut from.

use std::ptr::{null, null_mut};

use super::Fuzz;
use super::arguments::{Integers, Numbers};
use crate::contacts::dc_gaps;
use crate::interface::{dc_destroy, dc_evaluate, dc_refresh};
use crate::part::{
    dc_boxes_around, dc_extents, dc_part, dc_part_create, dc_part_demands, dc_part_destroy, dc_part_settle,
    dc_part_window,
};
use crate::status::{DC_OK, dc_status};
use crate::window::{
    dc_create_in_window, dc_window, dc_window_counts, dc_window_create, dc_window_destroy,
    dc_window_from_numbers, dc_window_names, dc_window_numbers,
};

impl Fuzz {
    /// Boxes around the slaves, mostly sound.
    fn boxes(&mut self, positions: &[f64]) -> Vec<f64> {
        let reach = if self.random.one_in(10) { self.random.odd_number() } else { self.random.unit() };
        let (mut boxes, mut count) = (vec![0.0; 24], 0);
        let most = self.random.pick(&[4, 1, 2]);
        // SAFETY: the arrays have at least the lengths given.
        let status = unsafe {
            dc_boxes_around(positions[108..].as_ptr(), 4, reach, most, boxes.as_mut_ptr(), &mut count)
        };
        assert!(status == DC_OK || count == 0);
        boxes.truncate(6 * count);
        if self.random.one_in(6) && count > 0 {
            let place = self.random.below(boxes.len());
            boxes[place] = self.random.odd_number();
        }
        boxes
    }

    pub(super) fn window(&mut self) -> dc_status {
        let handle = self.interface();
        let positions = self.positions();
        let boxes = self.boxes(&positions);
        let skin = self.random.pick(&[0.0, 0.1, 0.1, -1.0, f64::NAN]);
        let mut window = null_mut();
        // SAFETY: the array has the length given.
        let status = unsafe { dc_window_create(handle, boxes.as_ptr(), boxes.len() / 6, skin, &mut window) };
        assert_eq!(status == DC_OK, !window.is_null());
        if status == DC_OK { self.sent(window, &positions) } else { status }
    }

    /// The window by its numbers, one of which may be another; then an interface of it.
    fn sent(&mut self, window: *mut dc_window, positions: &[f64]) -> dc_status {
        let [mut nodes, mut integer_count, mut real_count] = [0; 3];
        let mut again = null_mut();
        // SAFETY: the arrays have at least the lengths given.
        unsafe {
            let counts =
                dc_window_counts(window, &mut nodes, null_mut(), &mut integer_count, &mut real_count);
            assert_eq!(counts, DC_OK);
            let (mut names, mut integers) = (vec![0; nodes], vec![0; integer_count]);
            let mut reals = vec![0.0; real_count];
            assert_eq!(dc_window_names(window, names.as_mut_ptr(), nodes, null_mut(), 0), DC_OK);
            let (i, r) = (integers.as_mut_ptr(), reals.as_mut_ptr());
            assert_eq!(dc_window_numbers(window, i, integer_count, r, real_count), DC_OK);
            assert_eq!(dc_window_destroy(window), DC_OK);
            if self.random.one_in(3) {
                let place = self.random.below(integer_count);
                let odd = i64::from(self.random.odd_integer());
                integers[place] = self.random.pick(&[odd, integers[place] + 1, integers[place] ^ 1 << 32]);
            }
            if self.random.one_in(6) {
                reals[self.random.below(real_count)] = self.random.odd_number();
            }
            let size = self.size(integer_count);
            let status = dc_window_from_numbers(i, size, r, real_count, &mut again);
            assert_eq!(status == DC_OK, !again.is_null());
            if status != DC_OK {
                return status;
            }
            let of_node = |name: &i64| positions.get(3 * *name as usize..).and_then(|x| x.first_chunk::<3>());
            let mut here: Vec<f64> = names.iter().filter_map(of_node).flatten().copied().collect();
            here.extend(&positions[108..]);
            let status = self.within(again, &here);
            assert_eq!(dc_window_destroy(again), DC_OK);
            status
        }
    }

    /// Gaps of the slaves of a window, the last four nodes.
    fn within(&mut self, window: *mut dc_window, positions: &[f64]) -> dc_status {
        let (nodes, mut interface) = (positions.len() / 3, null_mut());
        let slaves: Vec<i32> = (nodes as i32 - 4..nodes as i32).collect();
        let options = self.options();
        let pointer = if self.random.one_in(2) { null() } else { &raw const options };
        let (mut gaps, mut outcomes) = (Numbers::new(4), Integers::new(4));
        // SAFETY: the arrays have the lengths given.
        unsafe {
            let (x, own) = (positions.as_ptr(), slaves.as_ptr());
            let status = dc_create_in_window(window, x, nodes, own, 4, null(), 0, pointer, &mut interface);
            assert_eq!(status == DC_OK, !interface.is_null());
            if status != DC_OK {
                return status;
            }
            let mut status = dc_refresh(interface, x, nodes, null_mut());
            if status == DC_OK {
                status = dc_evaluate(interface, 1);
                let (outcomes, gaps) = (outcomes.values.as_mut_ptr(), gaps.values.as_mut_ptr());
                assert_eq!(status == DC_OK, dc_gaps(interface, outcomes, gaps, 4) == DC_OK);
            }
            gaps.check(status);
            outcomes.check();
            assert_eq!(dc_destroy(interface), DC_OK);
            status
        }
    }

    pub(super) fn part(&mut self) -> dc_status {
        let positions = self.positions();
        let mut facets = self.mesh.facets.clone();
        let mut owned: Vec<i32> = (0..25).map(|k| i32::from(k < 15)).collect();
        let mut names: Vec<i64> = (0..36).collect();
        if self.random.one_in(5) {
            facets[self.random.below(100)] = self.random.odd_integer();
            owned[self.random.below(25)] = self.choice(2);
            names[self.random.below(36)] = i64::from(self.random.odd_integer());
        }
        let mut known = [-1e3, -1e3, -1e3, 1e3, 1e3, 1e3];
        if self.random.one_in(4) {
            known[self.random.below(6)] = self.random.odd_number();
        }
        let plane = [self.random.pick(&[0.0, 2.5]), 0.0, 0.0, 1.0, 0.0, 0.0];
        let planes = self.random.below(2);
        let options = self.options();
        let pointer = if self.random.one_in(2) { null() } else { &raw const options };
        let (mut extents, mut part) = ([0.0; 7], null_mut());
        let x = positions.as_ptr();
        // SAFETY: the arrays have the lengths given.
        unsafe {
            let status = dc_extents(x, 36, facets.as_ptr(), 25, extents.as_mut_ptr());
            assert!(status == DC_OK || extents == [0.0; 7]);
            if self.random.one_in(6) {
                extents[self.random.below(7)] = self.random.odd_number();
            }
            let (f, o, n) = (facets.as_ptr(), owned.as_ptr(), names.as_ptr());
            let [k, e, p] = [known.as_ptr(), extents.as_ptr(), plane.as_ptr()];
            let status = dc_part_create(x, n, 36, f, n, o, 25, k, e, p, planes, pointer, &mut part);
            assert_eq!(status == DC_OK, !part.is_null());
            if status != DC_OK {
                return status;
            }
        }
        let status = self.settle(part, &positions);
        assert_eq!(dc_part_destroy(part), DC_OK);
        status
    }

    /// Two rounds with the own demands, mostly as they are; then a window.
    fn settle(&mut self, part: *mut dc_part, positions: &[f64]) -> dc_status {
        let boxes = self.boxes(positions);
        // SAFETY: the arrays have the lengths given.
        unsafe {
            for _ in 0..self.random.pick(&[2, 2, 1]) {
                let (mut integers, mut reals) = (vec![0; 400], vec![0.0; 400]);
                let ([mut own, mut real], mut is_settled) = ([0; 2], -1);
                let (i, r) = (integers.as_mut_ptr(), reals.as_mut_ptr());
                assert_eq!(dc_part_demands(part, i, 400, &mut own, r, 400, &mut real), DC_OK);
                if self.random.one_in(4) {
                    integers[self.random.below(own)] = i64::from(self.random.odd_integer());
                }
                if self.random.one_in(8) && real > 0 {
                    reals[self.random.below(real)] = self.random.odd_number();
                }
                let status = dc_part_settle(part, i, own, r, real, &mut is_settled);
                assert_eq!(status == DC_OK, (0..=1).contains(&is_settled));
                if status != DC_OK {
                    return status;
                }
            }
            let mut window = null_mut();
            let count = boxes.len() / 6;
            let status =
                dc_part_window(part, positions.as_ptr(), 36, boxes.as_ptr(), count, 0.1, &mut window);
            assert_eq!(status == DC_OK, !window.is_null());
            if status == DC_OK { self.sent(window, positions) } else { status }
        }
    }
}
