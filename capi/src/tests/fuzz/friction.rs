//! Calls for friction and its history, and for operators.

use std::ptr::null_mut;

use super::Fuzz;
use super::arguments::{Numbers, overlapping};
use crate::friction::{
    dc_accept, dc_augment, dc_friction, dc_history, dc_roll_back, dc_set_history, dc_slip_errors,
};
use crate::interface::dc_interface;
use crate::operator::{
    dc_operator_create, dc_operator_destroy, dc_operator_diagonal, dc_operator_product,
    dc_operator_transposed_product,
};
use crate::status::{DC_BAD_HANDLE, DC_OK, dc_status};

impl Fuzz {
    pub(super) fn friction(&mut self) -> dc_status {
        let handle = self.interface();
        let multipliers = self.multipliers();
        let mut law = self.law(&multipliers);
        law.augmented = self.choice(2);
        let slaves = self.size(4);
        let (mut errors, mut tractions) = (Numbers::new(4), Numbers::new(12));
        let (mut counts, mut dissipated) = ([0; 4], 0.0);
        let [stuck, sliding, unanchored, dropped] = &mut counts;
        // SAFETY: the arrays have at least the lengths given.
        unsafe {
            match self.random.below(7) {
                0 | 1 => {
                    let status =
                        dc_accept(handle, &law, stuck, sliding, unanchored, dropped, &mut dissipated);
                    assert!(counts.iter().all(|&count| count <= 4) && dissipated.is_finite());
                    status
                }
                2 => {
                    let moves = [0, 1, self.choice(2), 1];
                    dc_augment(handle, &law, moves.as_ptr(), slaves)
                }
                3 => {
                    let status = dc_slip_errors(handle, &law, errors.pointer(&mut self.random), slaves);
                    errors.check(status);
                    status
                }
                4 => dc_roll_back(handle),
                5 => {
                    let (slips, of_tractions) =
                        (errors.pointer(&mut self.random), tractions.pointer(&mut self.random));
                    let status = dc_friction(handle, &law, null_mut(), of_tractions, slips, slaves);
                    errors.check(status);
                    tractions.check(status);
                    status
                }
                _ => self.history(handle),
            }
        }
    }

    /// The history of one interface for the same or another one, mostly as it is.
    fn history(&mut self, handle: *mut dc_interface) -> dc_status {
        let mut history = Numbers::new(self.random.pick(&[800, 800, 3, 0]));
        let (room, mut count) = (history.len(), 0);
        // SAFETY: the arrays have the lengths given.
        unsafe {
            let status = dc_history(handle, history.pointer(&mut self.random), room, &mut count);
            history.check(status);
            if status != DC_OK {
                return status;
            }
            let mut numbers = history.values[..count.min(room)].to_vec();
            if self.random.one_in(4) && !numbers.is_empty() {
                let place = self.random.below(numbers.len());
                numbers[place] = self.random.odd_number();
            }
            let size = self.size(numbers.len());
            dc_set_history(self.interface(), numbers.as_ptr(), size)
        }
    }

    pub(super) fn operator(&mut self) -> dc_status {
        let handle = self.interface();
        let multipliers = self.multipliers();
        let law = self.law(&multipliers);
        let mut v: Vec<f64> = (0..120).map(|_| self.random.unit()).collect();
        if self.random.one_in(6) {
            v[self.random.below(120)] = self.random.odd_number();
        }
        let (mut tangent, mut active, mut product) = (null_mut(), 0, Numbers::new(120));
        let size = self.size(120);
        // SAFETY: the arrays have at least the lengths given, or overlap, which is refused.
        unsafe {
            let status = dc_operator_create(handle, &law, &mut tangent, &mut active);
            assert!((status == DC_OK) != tangent.is_null() && active <= 4);
            if status != DC_OK {
                return status;
            }
            let target = overlapping(v.as_mut_ptr(), product.pointer(&mut self.random), &mut self.random);
            let status = match self.random.below(3) {
                0 => dc_operator_product(tangent, v.as_ptr(), target, size),
                1 => dc_operator_transposed_product(tangent, v.as_ptr(), target, size),
                _ => dc_operator_diagonal(tangent, product.pointer(&mut self.random), size),
            };
            product.check(status);
            assert_eq!(dc_operator_destroy(tangent), DC_OK);
            assert_eq!(dc_operator_destroy(tangent), DC_BAD_HANDLE);
            status
        }
    }
}
