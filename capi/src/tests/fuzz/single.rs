//! Calls without an interface.

use std::ptr::null;

use super::Fuzz;
use super::arguments::{Integers, Numbers, overlapping};
use crate::batch::dc_gap_batch;
use crate::element::{dc_element, dc_element_system, dc_gap, dc_point};
use crate::law::dc_law;
use crate::neighbours::{dc_pair, dc_pairing};
use crate::status::{DC_OK, dc_status};

impl Fuzz {
    pub(super) fn element(&mut self) -> dc_element {
        let mut vector =
            |far: bool| [0; 3].map(|_| if far { self.random.odd_number() } else { self.random.unit() - 0.5 });
        let (near, odd) = (vector(false), vector(true));
        let mut element = dc_element {
            size: size_of::<dc_element>(),
            basis: self.choice(3),
            weight: self.choice(3),
            frame: self.choice(3),
            reserved: 0,
            support_radius: 1.0 + 4.0 * self.random.unit(),
            outward: self.random.pick(&[[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], near, odd, [0.0; 3]]),
            t1: self.random.pick(&[[1.0, 0.0, 0.0], odd]),
            t2: self.random.pick(&[[0.0, 1.0, 0.0], near]),
            normal: self.random.pick(&[[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]),
        };
        if self.random.one_in(12) {
            element.support_radius = self.random.odd_number();
        }
        if self.random.one_in(20) {
            element.size = self.random.below(200);
        }
        element
    }

    pub(super) fn gap(&mut self) -> dc_status {
        let element = self.element();
        let positions = self.positions();
        let count = self.random.pick(&[0, 1, 3, 6, 9, 16, 36]);
        let freedoms = 3 * (count + 1);
        let (mut gradient, mut hessian) =
            (Numbers::new(freedoms), Numbers::new(freedoms * (freedoms + 1) / 2));
        let (gradient_size, hessian_size) = (self.size(freedoms), self.size(hessian.len()));
        let mode = self.choice(3);
        let mut point = dc_point::default();
        let random = &mut self.random;
        let gradient_at = gradient.pointer(random);
        let hessian_at = overlapping(gradient_at, hessian.pointer(random), random);
        // SAFETY: the arrays have at least the lengths given, or overlap, which is refused.
        let status = unsafe {
            dc_gap(
                &element,
                positions[108..].as_ptr(),
                positions.as_ptr(),
                count,
                mode,
                &mut point,
                gradient_at,
                gradient_size,
                hessian_at,
                hessian_size,
            )
        };
        gradient.check(status);
        hessian.check(status);
        assert!(status != DC_OK || point.outcome == 0);
        assert!([point.gap].iter().chain(&point.foot).chain(&point.normal).all(|number| number.is_finite()));
        status
    }

    pub(super) fn batch(&mut self) -> dc_status {
        let element = self.element();
        let positions = self.positions();
        let count = self.random.below(5);
        let mut offsets = vec![0];
        for k in 0..count {
            offsets.push(offsets[k] + self.random.pick(&[9, 9, 4, 0]));
        }
        if self.random.one_in(10) {
            let place = self.random.below(offsets.len());
            offsets[place] = self.random.below(36);
        }
        let mode = self.choice(3);
        let (mut gradients, mut hessians) = (Numbers::new(4 * 120), Numbers::new(4 * 7260));
        let (gradient_size, hessian_size) = (self.size(4 * 120), self.size(4 * 7260));
        let mut points = [dc_point::default(); 5];
        let (outwards, radii) = ([0.0, 0.0, 1.0].repeat(4), [2.0, 3.0, self.random.odd_number(), 0.0]);
        let random = &mut self.random;
        // SAFETY: the arrays have at least the lengths given: no offset is beyond 36.
        let status = unsafe {
            dc_gap_batch(
                &element,
                count,
                if random.one_in(2) { null() } else { outwards.as_ptr() },
                if random.one_in(2) { null() } else { radii.as_ptr() },
                positions[108..].as_ptr(),
                positions.as_ptr(),
                offsets.as_ptr(),
                mode,
                points.as_mut_ptr(),
                gradients.pointer(random),
                gradient_size,
                hessians.pointer(random),
                hessian_size,
            )
        };
        gradients.check(status);
        hessians.check(status);
        assert_eq!(points[4], dc_point::default(), "written beyond the end");
        for point in points {
            assert!(
                [point.gap].iter().chain(&point.foot).chain(&point.normal).all(|number| number.is_finite())
            );
        }
        status
    }

    pub(super) fn pair(&mut self) -> dc_status {
        let options = self.options();
        let positions = self.positions();
        let outward = self.random.pick(&[[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [f64::NAN; 3]]);
        let (count, capacity) = (self.random.pick(&[36, 36, 9, 3, 1, 0]), self.random.pick(&[36, 36, 5]));
        let mut masters = Integers::new(36);
        // SAFETY: numbers, of which any bits are a value.
        let mut pairing: dc_pairing = unsafe { std::mem::zeroed() };
        pairing.size = if self.random.one_in(20) { self.random.below(100) } else { size_of::<dc_pairing>() };
        // SAFETY: the arrays have at least the lengths given.
        let status = unsafe {
            dc_pair(
                &options,
                positions[108..].as_ptr(),
                positions.as_ptr(),
                count,
                outward.as_ptr(),
                masters.pointer(&mut self.random),
                capacity,
                &mut pairing,
            )
        };
        masters.check();
        if status == DC_OK {
            assert!(masters.values[..pairing.master_count as usize].iter().all(|&k| (k as usize) < count));
            assert!(pairing.support_radius.is_finite() && pairing.normal.iter().all(|x| x.is_finite()));
        }
        status
    }

    pub(super) fn system(&mut self) -> dc_status {
        let random = &mut self.random;
        let count = random.pick(&[0, 1, 9]);
        let freedoms = 3 * (count + 1);
        let mut numbers = |count: usize| -> Vec<f64> {
            (0..count).map(|_| if random.one_in(400) { random.odd_number() } else { random.unit() }).collect()
        };
        let (gradient, hessian) = (numbers(freedoms), numbers(freedoms * (freedoms + 1) / 2));
        let gap = if self.random.one_in(10) { self.random.odd_number() } else { self.random.unit() - 0.8 };
        let area = if self.random.one_in(10) { self.random.odd_number() } else { 1.0 };
        let multipliers = self.multipliers();
        let law = dc_law { multiplier_count: self.random.pick(&[0, 1]), ..self.law(&multipliers) };
        let mut force = 0.0;
        let (mut residual, mut tangent) = (Numbers::new(freedoms), Numbers::new(freedoms * freedoms));
        let (residual_size, tangent_size) = (self.size(freedoms), self.size(freedoms * freedoms));
        let random = &mut self.random;
        let without = random.one_in(10);
        // SAFETY: the arrays have at least the lengths given.
        let status = unsafe {
            dc_element_system(
                &law,
                gap,
                area,
                count,
                gradient.as_ptr(),
                if without { null() } else { hessian.as_ptr() },
                &mut force,
                residual.pointer(random),
                residual_size,
                tangent.pointer(random),
                tangent_size,
            )
        };
        residual.check(status);
        tangent.check(status);
        assert!(force.is_finite());
        status
    }
}
