//! Calls for contact over faces.

use std::ptr::{null, null_mut};

use super::Fuzz;
use super::arguments::{Integers, Numbers, overlapping};
use crate::faces::{
    dc_faces, dc_faces_contacts, dc_faces_create, dc_faces_destroy, dc_faces_evaluate, dc_faces_refresh,
    dc_faces_update,
};
use crate::faces_assembly::{dc_faces_add_forces, dc_faces_product, dc_faces_triplets};
use crate::faces_friction::{
    dc_faces_accept, dc_faces_history, dc_faces_roll_back, dc_faces_set_history, dc_faces_slip_errors,
};
use crate::status::{DC_BAD_HANDLE, DC_NOT_EVALUATED, DC_OK, dc_status};

impl Fuzz {
    /// Some calls on one object; the status of the last.
    pub(super) fn faces(&mut self) -> dc_status {
        let first = self.positions();
        let options = self.options();
        let pointer = if self.random.one_in(2) { null() } else { &raw const options };
        let degree = self.random.pick(&[2, 2, 4, 3]);
        let (master, slave) = (self.mesh.facets.as_ptr(), self.mesh.slave_facets.as_ptr());
        let mut faces = null_mut();
        // SAFETY: the arrays have the lengths given.
        let mut status =
            unsafe { dc_faces_create(first.as_ptr(), 40, master, 25, slave, 1, pointer, degree, &mut faces) };
        assert_eq!(status == DC_OK, !faces.is_null());
        if status != DC_OK {
            return status;
        }
        for _ in 0..6 {
            status = match self.random.below(8) {
                0..3 => self.cut(faces),
                3 | 4 => self.evaluate_faces(faces),
                5 => self.sums_of_faces(faces),
                6 => self.triplets_of_faces(faces),
                _ => self.friction_of_faces(faces),
            };
        }
        assert_eq!(dc_faces_destroy(faces), DC_OK);
        assert_eq!(dc_faces_destroy(faces), DC_BAD_HANDLE);
        status
    }

    fn cut(&mut self, faces: *mut dc_faces) -> dc_status {
        let (positions, nodes) = (self.positions(), self.size(40));
        // SAFETY: there are at least as many positions.
        unsafe {
            if self.random.one_in(2) {
                dc_faces_refresh(faces, positions.as_ptr(), nodes, null_mut())
            } else {
                dc_faces_update(faces, positions.as_ptr(), nodes, null_mut())
            }
        }
    }

    /// What is refused leaves the contacts as they were.
    fn evaluate_faces(&mut self, faces: *mut dc_faces) -> dc_status {
        let multipliers = self.multipliers();
        let law = self.law(&multipliers);
        let mode = self.choice(3);
        let mut results = [Numbers::new(4), Numbers::new(4)];
        let contacts = |gaps: &mut Numbers| {
            let gaps = gaps.values.as_mut_ptr();
            // SAFETY: the array has the length given.
            unsafe { dc_faces_contacts(faces, null_mut(), gaps, null_mut(), null_mut(), null_mut(), 4) }
        };
        let before = contacts(&mut results[0]);
        // SAFETY: the law has its multipliers.
        let status = unsafe { dc_faces_evaluate(faces, &law, mode) };
        let after = contacts(&mut results[1]);
        results.iter().for_each(|gaps| gaps.check(after));
        if status == DC_OK {
            assert_eq!(after, DC_OK);
        } else {
            assert_eq!((before, &results[0].values), (after, &results[1].values));
        }
        status
    }

    fn sums_of_faces(&mut self, faces: *mut dc_faces) -> dc_status {
        let (size, tangent) = (self.size(120), self.choice(2));
        let mut v: Vec<f64> = (0..120).map(|_| self.random.unit()).collect();
        if self.random.one_in(6) {
            v[self.random.below(120)] = self.random.odd_number();
        }
        let mut sums = Numbers::new(120);
        let (mut active, mut missed) = (0, 0);
        let target = sums.pointer(&mut self.random);
        // SAFETY: the arrays have at least the lengths given, or overlap, which is refused.
        let status = unsafe {
            if self.random.one_in(2) {
                dc_faces_add_forces(faces, target, size, &mut active, &mut missed)
            } else {
                let target = overlapping(v.as_mut_ptr(), target, &mut self.random);
                dc_faces_product(faces, tangent, v.as_ptr(), target, size)
            }
        };
        sums.check(status);
        assert!(active <= 4);
        status
    }

    fn triplets_of_faces(&mut self, faces: *mut dc_faces) -> dc_status {
        let capacity = self.random.pick(&[0, 100, 40_000, 40_000]);
        let (mut rows, mut columns) = (Integers::new(capacity), Integers::new(capacity));
        let (mut values, mut count) = (Numbers::new(capacity), 0);
        let tangent = self.choice(2);
        let random = &mut self.random;
        let (rows_at, columns_at) = (rows.pointer(random), columns.pointer(random));
        let values_at = values.pointer(random);
        // SAFETY: the arrays have the lengths given.
        let status = unsafe {
            dc_faces_triplets(faces, tangent, rows_at, columns_at, values_at, capacity, &mut count)
        };
        rows.check();
        columns.check();
        values.check(status);
        status
    }

    fn friction_of_faces(&mut self, faces: *mut dc_faces) -> dc_status {
        let multipliers = self.multipliers();
        let mut law = self.law(&multipliers);
        law.augmented = self.choice(2);
        let (mut history, mut errors, mut count) = (Numbers::new(900), Numbers::new(4), 0);
        let slaves = self.size(4);
        // SAFETY: the arrays have at least the lengths given.
        unsafe {
            match self.random.below(4) {
                0 | 1 => {
                    let null = null_mut();
                    dc_faces_accept(faces, &law, null, null, null, null, null_mut())
                }
                2 => {
                    let status = dc_faces_slip_errors(faces, &law, errors.pointer(&mut self.random), slaves);
                    errors.check(status);
                    let rolled = dc_faces_roll_back(faces);
                    assert!(matches!(rolled, DC_OK | DC_NOT_EVALUATED));
                    status
                }
                _ => {
                    let status = dc_faces_history(faces, history.values.as_mut_ptr(), 900, &mut count);
                    history.check(status);
                    if status != DC_OK {
                        return status;
                    }
                    if self.random.one_in(4) && count > 0 {
                        history.values[self.random.below(count)] = self.random.odd_number();
                    }
                    dc_faces_set_history(faces, history.values.as_ptr(), self.size(count))
                }
            }
        }
    }
}
