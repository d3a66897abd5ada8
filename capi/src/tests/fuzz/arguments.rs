//! What calls are made with: mostly sound, now and then odd.

use std::ptr::{null, null_mut};

use super::super::random::Random;
use super::Fuzz;
use crate::interface::dc_interface;
use crate::law::dc_law;
use crate::options::dc_options;
use crate::pattern::dc_pattern;
use crate::status::{DC_OK, dc_status};

/// What stands behind the end of each array.
const GUARD: f64 = -7.25e11;
const GUARD_INTEGER: i32 = -0x5a5a_5a5a;

/// An array for results with a guard behind its end.
pub(super) struct Numbers {
    pub(super) values: Vec<f64>,
}

impl Numbers {
    pub(super) fn new(count: usize) -> Self {
        let mut values = vec![0.0; count];
        values.push(GUARD);
        Self { values }
    }

    pub(super) fn len(&self) -> usize {
        self.values.len() - 1
    }

    /// The array; NULL or misaligned now and then.
    pub(super) fn pointer(&mut self, random: &mut Random) -> *mut f64 {
        odd_pointer(self.values.as_mut_ptr(), random)
    }

    pub(super) fn check(&self, status: dc_status) {
        assert_eq!(self.values[self.len()], GUARD, "written beyond the end");
        if status == DC_OK {
            assert!(
                self.values.iter().all(|value| value.is_finite()),
                "{status:?} with numbers that are none"
            );
        }
    }
}

/// A pointer, mostly as it is.
fn odd_pointer<T>(pointer: *mut T, random: &mut Random) -> *mut T {
    match random.below(45) {
        0..3 => null_mut(),
        3 => pointer.wrapping_byte_add(1),
        _ => pointer,
    }
}

/// The second of two arrays, in the place of the first now and then.
pub(super) fn overlapping(first: *mut f64, second: *mut f64, random: &mut Random) -> *mut f64 {
    // Beside NULL there is nothing to overlap with, and nothing to write to.
    if random.one_in(30) && !first.is_null() { first.wrapping_add(random.below(3)) } else { second }
}

/// As [`Numbers`].
pub(super) struct Integers {
    pub(super) values: Vec<i32>,
}

impl Integers {
    pub(super) fn new(count: usize) -> Self {
        let mut values = vec![0; count];
        values.push(GUARD_INTEGER);
        Self { values }
    }

    pub(super) fn pointer(&mut self, random: &mut Random) -> *mut i32 {
        odd_pointer(self.values.as_mut_ptr(), random)
    }

    pub(super) fn check(&self) {
        assert_eq!(self.values.last(), Some(&GUARD_INTEGER), "written beyond the end");
    }
}

impl Fuzz {
    /// A handle, mostly a live one.
    pub(super) fn interface(&mut self) -> *mut dc_interface {
        let last = self.interfaces.len() - 1;
        if self.random.one_in(3) { self.random.pick(&self.interfaces) } else { self.interfaces[last] }
    }

    pub(super) fn pattern(&mut self) -> *mut dc_pattern {
        let last = self.patterns.len() - 1;
        if self.random.one_in(3) { self.random.pick(&self.patterns) } else { self.patterns[last] }
    }

    /// Positions, mostly sound ones.
    pub(super) fn positions(&mut self) -> Vec<f64> {
        let mut positions = self.mesh.positions.clone();
        let scale = self.random.pick(&[0.0, 0.01, 0.3, 3.0]);
        let height = self.random.pick(&[0.0, 0.0, -0.3, 2.0]);
        for (k, x) in positions.iter_mut().enumerate() {
            *x += scale * (self.random.unit() - 0.5);
            if k >= 3 * 36 && k % 3 == 2 {
                *x += height;
            }
        }
        while self.random.one_in(5) {
            let place = self.random.below(positions.len());
            positions[place] = self.random.odd_number();
        }
        positions
    }

    /// The number of a mode, an option, …, mostly one that is.
    pub(super) fn choice(&mut self, end: usize) -> i32 {
        if self.random.one_in(12) { self.random.odd_integer() } else { self.random.below(end) as i32 }
    }

    /// A size that is right, too small or too large for an array of `count`.
    pub(super) fn size(&mut self, count: usize) -> usize {
        if self.random.one_in(8) { self.random.below(count + 1) } else { count }
    }

    pub(super) fn law(&mut self, multipliers: &[f64]) -> dc_law {
        let penalty = if self.random.one_in(10) { self.random.odd_number() } else { 1e3 };
        let with = self.random.one_in(2);
        dc_law {
            size: if self.random.one_in(20) { self.random.below(100) } else { size_of::<dc_law>() },
            penalty,
            multipliers: if with { multipliers.as_ptr() } else { null() },
            multiplier_count: if with {
                self.size(multipliers.len())
            } else {
                self.random.pick(&[0, 0, 0, 4])
            },
            tangent: self.choice(2),
            reserved: i32::from(self.random.one_in(40)),
            friction: self.random.pick(&[0.0, 0.0, 0.3, -1.0, f64::NAN]),
            tangential_stiffness: self.random.pick(&[0.0, 50.0, -1.0]),
            shear_limit: self.random.pick(&[0.0, 0.0, 2.0, -1.0, f64::NAN]),
            ..dc_law::NONE
        }
    }

    pub(super) fn options(&mut self) -> dc_options {
        let mut options = super::super::options();
        let end = if self.random.one_in(3) { 6 } else { 0 };
        for _ in 0..end {
            let integers = [
                &mut options.element,
                &mut options.weight,
                &mut options.frame,
                &mut options.rule,
                &mut options.layers,
                &mut options.max_layers,
                &mut options.nearest,
                &mut options.max_nearest,
                &mut options.candidates,
                &mut options.max_candidates,
                &mut options.basis,
                &mut options.linear_fallback,
                &mut options.areas,
            ];
            let place = self.random.below(integers.len());
            let odd = self.random.odd_integer();
            let value = if self.random.one_in(4) { odd } else { self.random.below(3) as i32 };
            *integers.into_iter().nth(place).expect("a field") = value;
        }
        if self.random.one_in(4) {
            let numbers = [
                &mut options.smallest_regularity,
                &mut options.radius_factor,
                &mut options.feature_angle_degrees,
                &mut options.border_tolerance,
                &mut options.distance_limit,
                &mut options.cutback_penetration,
            ];
            let place = self.random.below(numbers.len());
            *numbers.into_iter().nth(place).expect("a field") = self.random.odd_number();
        }
        if self.random.one_in(20) {
            options.size = self.random.below(200);
        }
        options
    }

    pub(super) fn multipliers(&mut self) -> Vec<f64> {
        let random = &mut self.random;
        (0..4).map(|_| if random.one_in(20) { random.odd_number() } else { random.unit() }).collect()
    }
}
