//! Calls in no order with arguments that nobody expects: a status each time, never an internal error, never a number that is none
//! with DC_OK, never a byte beyond an array.
//!
//! The same cases every time; with `DC_FUZZ_SECONDS=600` others, for that long.

mod arguments;
mod faces;
mod feet;
mod friction;
mod single;
mod windows;

use std::ptr::{null, null_mut};
use std::time::{Duration, Instant};

use super::random::Random;
use super::{Mesh, message};
use crate::assembly::{dc_add_forces, dc_triplets};
use crate::contacts::{dc_contact, dc_contact_of, dc_cutback, dc_derivatives, dc_forces, dc_gaps};
use crate::interface::{
    dc_counts, dc_destroy, dc_evaluate, dc_follow, dc_freeze, dc_interface, dc_refresh, dc_report,
    dc_set_equations, dc_set_symmetry, dc_thaw, dc_update,
};
use crate::pattern::{
    dc_pattern, dc_pattern_create, dc_pattern_destroy, dc_pattern_fill, dc_pattern_structure,
};
use crate::status::*;
use arguments::{Integers, Numbers, overlapping};

/// Calls from the fixed seed.
const CALLS: usize = 6000;

#[test]
fn odd_calls_have_a_status() {
    let seconds = std::env::var("DC_FUZZ_SECONDS").ok().and_then(|text| text.parse().ok());
    let mut counts = [0_usize; 17];
    match seconds.map(Duration::from_secs) {
        None => Fuzz::new(1).run(CALLS, &mut counts),
        Some(duration) => {
            let start = Instant::now();
            for seed in 2.. {
                Fuzz::new(seed).run(CALLS, &mut counts);
                if start.elapsed() > duration {
                    println!(
                        "{} calls from {} seeds, by status: {counts:?}",
                        counts.iter().sum::<usize>(),
                        seed - 1
                    );
                    break;
                }
            }
        }
    }
    // Every kind of answer occurs, but for those that need another thread, a pattern out of date, overflow or lack of memory.
    for status in [DC_OK, DC_FROZEN, DC_NO_CONTACT, DC_BAD_POINTER, DC_BAD_SIZE, DC_BAD_HANDLE, DC_BAD_OPTION]
    {
        assert!(counts[status as usize] > 0, "{status:?}");
    }
    for status in [DC_NOT_FINITE, DC_OUT_OF_RANGE, DC_BAD_SURFACE, DC_BAD_SLAVES, DC_NOT_EVALUATED] {
        assert!(counts[status as usize] > 0, "{status:?}");
    }
}

struct Fuzz {
    random: Random,
    mesh: Mesh,
    /// Live, destroyed, and no handles.
    interfaces: Vec<*mut dc_interface>,
    patterns: Vec<*mut dc_pattern>,
}

impl Fuzz {
    fn new(seed: u64) -> Self {
        let nothing = [0, 1, 8, usize::MAX, 0x5dc1 << 48 | 3];
        let interfaces = nothing.map(std::ptr::without_provenance_mut).to_vec();
        let patterns = nothing.map(std::ptr::without_provenance_mut).to_vec();
        Self { random: Random::new(seed), mesh: Mesh::new(), interfaces, patterns }
    }

    fn run(mut self, calls: usize, counts: &mut [usize; 17]) {
        for call in 0..calls {
            let status = self.call(call);
            assert_ne!(status, DC_INTERNAL, "{}", message());
            assert!(status == DC_OK || !message().is_empty());
            counts[status as usize] += 1;
        }
        // What is left alive is destroyed once.
        for handle in self.interfaces {
            assert!(matches!(dc_destroy(handle), DC_OK | DC_BAD_HANDLE));
        }
        for handle in self.patterns {
            assert!(matches!(dc_pattern_destroy(handle), DC_OK | DC_BAD_HANDLE));
        }
    }

    fn call(&mut self, number: usize) -> dc_status {
        let kind = if number == 0 { 0 } else { self.random.below(28) };
        match kind {
            0 => self.create(),
            1 | 2 => self.refresh(),
            3 => self.update(),
            4..=7 => {
                let (handle, mode) = (self.interface(), self.choice(3));
                dc_evaluate(handle, mode)
            }
            8 => {
                let handle = self.interface();
                match self.random.below(8) {
                    0 => dc_freeze(handle),
                    1 if self.random.one_in(4) => dc_destroy(handle),
                    _ => dc_thaw(handle),
                }
            }
            9 => self.contact(),
            10 => self.derivatives(),
            11 => self.all(),
            12 => self.equations(),
            13 => self.residual(),
            14 => self.triplets(),
            15 => self.pattern_create(),
            16 => self.pattern_fill(),
            17 => self.gap(),
            18 => self.batch(),
            19 => self.pair(),
            20 => self.symmetry(),
            21 => self.feet(),
            22 => self.friction(),
            23 => self.operator(),
            24 => self.window(),
            25 => self.part(),
            26 => self.faces(),
            _ => self.system(),
        }
    }

    fn create(&mut self) -> dc_status {
        let sound = self.mesh.clone();
        self.mesh.positions = self.positions();
        let random = &mut self.random;
        for (list, end) in
            [(&mut self.mesh.facets, 100), (&mut self.mesh.slaves, 4), (&mut self.mesh.slave_facets, 4)]
        {
            if random.one_in(6) {
                let place = random.below(end);
                list[place] = random.odd_integer();
            }
            if random.one_in(12) {
                let (from, to) = (random.below(end), random.below(end));
                list[to] = list[from];
            }
        }
        if random.one_in(8) {
            for row in self.mesh.facets.chunks_exact_mut(4).skip(3) {
                row[3] = -1;
            }
        }
        let options = self.options();
        let pointer = if self.random.one_in(4) { null() } else { &raw const options };
        let (status, handle) = self.mesh.make(pointer);
        self.mesh = sound;
        if status == DC_OK {
            self.interfaces.push(handle);
        }
        status
    }

    fn update(&mut self) -> dc_status {
        let (handle, positions) = (self.interface(), self.positions());
        let nodes = self.size(40);
        let mut rebuilt = -1;
        // SAFETY: there are at least as many positions.
        unsafe {
            if self.random.one_in(3) {
                return dc_update(handle, positions.as_ptr(), nodes);
            }
            let status = dc_follow(handle, positions.as_ptr(), nodes, &mut rebuilt);
            assert_eq!(matches!(status, DC_OK | DC_FROZEN), rebuilt >= 0);
            status
        }
    }

    /// Planes across the axes, as they are, tilted or no planes at all.
    fn symmetry(&mut self) -> dc_status {
        let handle = self.interface();
        let mut planes = Vec::new();
        for _ in 0..self.random.below(4) {
            let axis = self.random.below(3);
            let mut plane = [self.random.pick(&[0.0, 0.0, 2.5, -1.0]); 6];
            plane[3..].fill(0.0);
            plane[3 + axis] = self.random.pick(&[1.0, 1.0, 1.0, -1.0]);
            if self.random.one_in(6) {
                plane[self.random.below(6)] = self.random.odd_number();
            }
            planes.extend(plane);
        }
        let count = self.size(planes.len() / 6);
        // SAFETY: there are at least as many planes.
        unsafe { dc_set_symmetry(handle, planes.as_ptr(), count) }
    }

    fn refresh(&mut self) -> dc_status {
        let (handle, positions) = (self.interface(), self.positions());
        let nodes = self.size(40);
        // SAFETY: numbers, of which any bits are a value.
        let mut report: dc_report = unsafe { std::mem::zeroed() };
        report.size = if self.random.one_in(20) { self.random.below(200) } else { size_of::<dc_report>() };
        let pointer = if self.random.one_in(4) { null_mut() } else { &raw mut report };
        // SAFETY: as many positions, and room for the report, which is refused if it claims more.
        let status = unsafe { dc_refresh(handle, positions.as_ptr(), nodes, pointer) };
        if status == DC_OK && !pointer.is_null() {
            assert_eq!(report.paired + report.without, 4);
            assert!((0..=1).contains(&report.rebuilt));
            let numbers = [report.jump_before, report.jump_after, report.lost_gap, report.gained_gap];
            assert!(numbers.iter().all(|number| number.is_finite()));
        }
        status
    }

    fn contact(&mut self) -> dc_status {
        let (handle, slave) = (self.interface(), self.random.below(5));
        let mut contact = dc_contact::default();
        let mut factor = 0.0;
        let (mut nodes, mut slaves) = (0, 0);
        // SAFETY: they may be written.
        let (status, cutback, counts) = unsafe {
            (
                dc_contact_of(handle, slave, &mut contact),
                dc_cutback(handle, &mut factor),
                dc_counts(handle, &mut nodes, &mut slaves),
            )
        };
        assert_eq!(cutback == DC_OK, (0.1..=1.0).contains(&factor), "{factor}");
        assert_eq!(counts == DC_OK, (nodes, slaves) == (40, 4));
        let numbers = [contact.gap, contact.area, contact.support_radius];
        assert!(numbers.iter().chain(&contact.foot).chain(&contact.normal).all(|number| number.is_finite()));
        status
    }

    fn derivatives(&mut self) -> dc_status {
        let (handle, slave) = (self.interface(), self.random.below(5));
        let room = self.random.pick(&[120, 120, 500, 8]);
        let (mut nodes, mut gradient) = (Integers::new(room / 3), Numbers::new(room));
        let mut hessian = Numbers::new(self.random.pick(&[2000, 7260, 7260, 100]));
        let (gradient_size, hessian_size) = (gradient.len(), hessian.len());
        let gradient_at = gradient.pointer(&mut self.random);
        let hessian_at = hessian.pointer(&mut self.random);
        let hessian_at = overlapping(gradient_at, hessian_at, &mut self.random);
        // SAFETY: the arrays have the lengths given, or overlap, which is refused.
        let status = unsafe {
            dc_derivatives(
                handle,
                slave,
                nodes.pointer(&mut self.random),
                room / 3,
                gradient_at,
                gradient_size,
                hessian_at,
                hessian_size,
            )
        };
        nodes.check();
        gradient.check(status);
        hessian.check(status);
        status
    }

    fn all(&mut self) -> dc_status {
        let handle = self.interface();
        let slaves = self.size(4);
        let multipliers = self.multipliers();
        let law = self.law(&multipliers);
        let mut outcomes = Integers::new(4);
        let mut numbers = [Numbers::new(4), Numbers::new(4), Numbers::new(4), Numbers::new(4)];
        let [gaps, penetrations, forces, pressures] = &mut numbers;
        let random = &mut self.random;
        // SAFETY: the arrays have at least the lengths given.
        let (status, other) = unsafe {
            (
                dc_gaps(handle, outcomes.pointer(random), gaps.pointer(random), slaves),
                dc_forces(
                    handle,
                    &law,
                    penetrations.pointer(random),
                    forces.pointer(random),
                    pressures.pointer(random),
                    slaves,
                ),
            )
        };
        outcomes.check();
        numbers[0].check(status);
        numbers[1..].iter().for_each(|numbers| numbers.check(other));
        other
    }

    fn equations(&mut self) -> dc_status {
        let handle = self.interface();
        if self.random.one_in(2) {
            // SAFETY: nothing is read.
            return unsafe { dc_set_equations(handle, null(), self.random.pick(&[0, 0, 40]), 0) };
        }
        let mut numbers: Vec<i32> = (0..120).map(|k| if k % 7 == 0 { -1 } else { k }).collect();
        if self.random.one_in(3) {
            let place = self.random.below(120);
            numbers[place] = self.random.odd_integer();
        }
        let (nodes, equations) = (self.size(40), self.random.pick(&[120, 120, 120, 3, usize::MAX >> 1]));
        // SAFETY: the array has at least the length given.
        unsafe { dc_set_equations(handle, numbers.as_ptr(), nodes, equations) }
    }

    fn residual(&mut self) -> dc_status {
        let handle = self.interface();
        let multipliers = self.multipliers();
        let law = self.law(&multipliers);
        let mut residual = Numbers::new(120);
        let size = self.size(120);
        let mut active = 0;
        // SAFETY: the array has at least the length given.
        let status =
            unsafe { dc_add_forces(handle, &law, residual.pointer(&mut self.random), size, &mut active) };
        residual.check(status);
        assert!(active <= 4);
        status
    }

    fn triplets(&mut self) -> dc_status {
        let handle = self.interface();
        let multipliers = self.multipliers();
        let law = self.law(&multipliers);
        let capacity = self.random.pick(&[0, 100, 40_000, 40_000]);
        let (mut rows, mut columns) = (Integers::new(capacity), Integers::new(capacity));
        let mut values = Numbers::new(capacity);
        let triangle = self.choice(2);
        let mut count = 0;
        let random = &mut self.random;
        // SAFETY: the arrays have the lengths given.
        let status = unsafe {
            dc_triplets(
                handle,
                &law,
                triangle,
                rows.pointer(random),
                columns.pointer(random),
                values.pointer(random),
                capacity,
                &mut count,
            )
        };
        rows.check();
        columns.check();
        values.check(status);
        status
    }

    fn pattern_create(&mut self) -> dc_status {
        let handle = self.interface();
        if self.random.one_in(10) {
            let pattern = self.pattern();
            return dc_pattern_destroy(pattern);
        }
        let (mut pattern, mut entries) = (null_mut(), 0);
        // SAFETY: they may be written.
        let status = unsafe { dc_pattern_create(handle, &mut pattern, &mut entries) };
        assert_eq!(status == DC_OK, !pattern.is_null());
        if status == DC_OK {
            self.patterns.push(pattern);
        }
        status
    }

    fn pattern_fill(&mut self) -> dc_status {
        let (pattern, handle) = (self.pattern(), self.interface());
        let multipliers = self.multipliers();
        let law = self.law(&multipliers);
        let mut offsets = Integers::new(121);
        // SAFETY: the array has the length given.
        let status =
            unsafe { dc_pattern_structure(pattern, offsets.values.as_mut_ptr(), 121, null_mut(), 0) };
        offsets.check();
        let entries = if status == DC_OK { offsets.values[120] as usize } else { 9 };
        let mut values = Numbers::new(entries);
        let size = self.size(entries);
        let pointer = values.pointer(&mut self.random);
        // SAFETY: the array has at least the length given.
        let status = unsafe { dc_pattern_fill(pattern, handle, &law, pointer, size, null_mut()) };
        values.check(status);
        status
    }
}
