//! Balance of a contact's forces: N summed up over all nodes, and its moment, which has to vanish where the frame moves along.
//!
//! Both are sums that are zero, so there is nothing to compare with. They are measured over the largest entry of N, moments about the
//! slave over R times that.

use diffuse_contact::{Element, Point};
use diffuse_contact_codegen::{FrameRule, Output};
use serde::ser::{Serialize, SerializeStruct, Serializer};

use super::blocks::{Subject, worse};
use super::report::Worst;
use crate::emit::frame_name;

/// The sums, in the order of the report.
pub const SUMS: [&str; 2] = ["Σ N", "Σ x × N"];

/// The worst of one sum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BalanceRow {
    /// Whose N it is.
    pub subject: Subject,
    /// The sum, one of [`SUMS`].
    pub name: &'static str,
    /// Nothing where nothing was evaluated.
    pub worst: Option<Worst>,
}

impl BalanceRow {
    /// A row for each sum that has to vanish: a frame that is held takes a moment.
    pub(super) fn all() -> Vec<Self> {
        let gaps = Subject::ALL.into_iter().filter(|subject| subject.output == Output::Gap);
        let of = |subject: Subject| {
            let names =
                SUMS.into_iter().filter(move |&name| name == SUMS[0] || subject.frame != FrameRule::Held);
            names.map(move |name| Self { subject, name, worst: None })
        };
        gaps.flat_map(of).collect()
    }

    pub(super) fn passes(&self) -> bool {
        self.worst.as_ref().is_some_and(Worst::passes)
    }
}

/// Both sums of an element's N, in the order of [`SUMS`].
pub(super) fn sums(element: &Element<'_>, gradient: &[f64]) -> [f64; 2] {
    let largest = gradient.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
    let nodes = std::iter::once(&element.slave).chain(element.masters);
    let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
    for (x, n) in nodes.zip(gradient.as_chunks::<3>().0) {
        let arm: Point = std::array::from_fn(|k| x[k] - element.slave[k]);
        for axis in 0..3 {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            force[axis] += n[axis];
            moment[axis] += arm[next] * n[last] - arm[last] * n[next];
        }
    }
    let most = |sum: Point| sum.into_iter().map(f64::abs).fold(0.0, worse);
    [most(force) / largest, most(moment) / (element.support_radius * largest)]
}

impl Serialize for BalanceRow {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut row = serializer.serialize_struct("BalanceRow", 4)?;
        row.serialize_field("frame_derivative", frame_name(self.subject.frame))?;
        row.serialize_field("sum", self.name)?;
        row.serialize_field("passes", &self.passes())?;
        row.serialize_field("worst", &self.worst)?;
        row.end()
    }
}

#[cfg(test)]
mod tests {
    use diffuse_contact::{Frame, FrameDerivative};

    use super::*;

    #[test]
    fn a_pair_of_forces_balances_and_turns() {
        let masters = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let frame = Frame {
            origin: [0.0; 3],
            t1: axes[0],
            t2: axes[1],
            normal: axes[2],
            derivative: FrameDerivative::Held,
            reach: 0.0,
        };
        let element = Element::new([0.0; 3], &masters, frame, 4.0);
        let along = [-2.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        assert_eq!(sums(&element, &along), [0.0, 0.0]);
        let across = [0.0, 0.0, -2.0, 0.0, 0.0, 2.0, 0.0, 0.0, 1.0];
        assert_eq!(sums(&element, &across), [0.5, 0.25]);
        // Also where numbers follow.
        let broken = [f64::NAN, 0.0, -2.0, 0.0, 0.0, 2.0, 0.0, 0.0, 1.0];
        assert!(sums(&element, &broken).into_iter().all(f64::is_nan));
    }
}
