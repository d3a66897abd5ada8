//! Calls for the feet.

use super::Fuzz;
use super::arguments::{Integers, Numbers, overlapping};
use crate::feet::dc_feet;
use crate::status::dc_status;

impl Fuzz {
    pub(super) fn feet(&mut self) -> dc_status {
        let (handle, slaves) = (self.interface(), self.size(4));
        let mut outcomes = Integers::new(4);
        let mut weights = Numbers::new(self.random.pick(&[144, 144, 144, 8]));
        let rows = self.random.pick(&[1332, 1332, 1332, 40]);
        let (mut foot, mut normal) = (Numbers::new(rows), Numbers::new(rows));
        let random = &mut self.random;
        let sizes = [weights.len(), foot.len(), normal.len()];
        let foot_at = foot.pointer(random);
        let normal_at = normal.pointer(random);
        let normal_at = overlapping(foot_at, normal_at, random);
        // SAFETY: the arrays have the lengths given, or overlap, which is refused.
        let status = unsafe {
            dc_feet(
                handle,
                outcomes.pointer(random),
                slaves,
                weights.pointer(random),
                sizes[0],
                foot_at,
                sizes[1],
                normal_at,
                sizes[2],
            )
        };
        outcomes.check();
        [&weights, &foot, &normal].into_iter().for_each(|numbers| numbers.check(status));
        status
    }
}
