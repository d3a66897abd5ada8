//! How deep slaves that carry force lie below their masters, beside the mesh.

use diffuse_contact_mesh::names::shown;
use serde::{Deserialize, Serialize};

/// Penetration over the size of the facets around a slave from which it is no longer well below the error of the mesh.
const DEEP: f64 = 0.05;

/// A node of the master that lies deeper in the slave's faces than slaves in the master by this factor lies between them.
const BETWEEN: f64 = 3.0;

/// Points that lie so much deeper than their average, over the longest way of a node, touch late enough to be told.
const LATE: f64 = 0.05;

/// Slaves of an interface, of both passes if there are two, that carry force deeper below the master than 5 % of the size of the facets around
/// them. Over nodes also nodes of the master between slaves, over faces points, which the average gaps of nodes do not show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Penetration {
    /// How many.
    pub slaves: usize,
    /// The deepest of them, over the size of its facets.
    pub part: f64,
    /// Over nodes in one pass: how many nodes of the master lie deeper than 5 % of their size in the slave's faces, between its nodes, and
    /// three times deeper than any slave in the master.
    pub masters: usize,
    /// The deepest of them, over the size of the faces.
    pub part_of_masters: f64,
    /// How many integration points under pressure lie deeper than 5 % of the mean size of the slave's faces, and three times deeper than the
    /// average of their nodes.
    pub points: usize,
    /// The deepest of them, over that size.
    pub part_of_points: f64,
    /// How much deeper a point under pressure lies than the average of its nodes, over the longest way of a node, at the end of the last
    /// increment: contact began later by about that.
    pub part_of_motion: f64,
}

impl Penetration {
    /// Whether there are none.
    pub(crate) fn is_none(&self) -> bool {
        self.slaves == 0 && self.masters == 0 && self.points == 0 && !(self.part_of_motion > LATE)
    }

    /// Counts an integration point that lies so deep, over the size of faces, and so much deeper than the average, over the longest way of a
    /// node.
    pub(super) fn count_point(&mut self, part: f64, late: f64) {
        if late.is_finite() {
            self.part_of_motion = self.part_of_motion.max(late);
        }
        if part > DEEP {
            (self.points, self.part_of_points) = (self.points + 1, self.part_of_points.max(part));
        }
    }

    /// Counts a node of the master that lies so deep in the slave's faces, over their size, where slaves lie so deep at most.
    pub(super) fn count_master(&mut self, part: f64, of_slaves: f64) {
        if part > DEEP && part > BETWEEN * of_slaves {
            (self.masters, self.part_of_masters) = (self.masters + 1, self.part_of_masters.max(part));
        }
    }

    /// Counts a slave that lies so deep, over the size of its facets.
    pub(super) fn count(&mut self, part: f64) {
        if part > DEEP {
            (self.slaves, self.part) = (self.slaves + 1, self.part.max(part));
        }
    }

    /// The larger of each.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self {
            slaves: self.slaves.max(other.slaves),
            part: self.part.max(other.part),
            masters: self.masters.max(other.masters),
            part_of_masters: self.part_of_masters.max(other.part_of_masters),
            points: self.points.max(other.points),
            part_of_points: self.part_of_points.max(other.part_of_points),
            part_of_motion: self.part_of_motion.max(other.part_of_motion),
        }
    }

    /// What to think of it, in sentences about an interface with this penalty.
    pub fn warnings(&self, interface: &str, penalty: f64) -> Vec<String> {
        let interface = shown(interface);
        let Self { slaves, part, masters, part_of_masters, points, part_of_points, part_of_motion } = self;
        let mut warnings = Vec::new();
        if *slaves > 0 {
            warnings.push(format!(
                "interface `{interface}`: up to {slaves} slaves ended an increment deeper below the master than 5 % of the size of their \
                 facets, by up to {:.1} %, with the penalty {penalty:.3e}: a stiffer one, or method = \"augmented-lagrangian\", lets them in \
                 less",
                100.0 * part
            ));
        }
        if *masters > 0 {
            warnings.push(format!(
                "interface `{interface}`: up to {masters} nodes of the master ended an increment in the slave's faces between its nodes, by up to \
                 {:.1} % of the faces' size, where nothing holds them: the slave is coarse beside the master, and forces may be too small; \
                 master and slave the other way round, integration = \"faces\", two_pass = true or smaller faces of the slave help",
                100.0 * part_of_masters
            ));
        }
        if *points > 0 || *part_of_motion > LATE {
            let by = if *points > 0 {
                format!("by up to {:.1} % of the faces' size", 100.0 * part_of_points)
            } else {
                format!("by {:.1} % of the longest way of a node", 100.0 * part_of_motion)
            };
            warnings.push(format!(
                "interface `{interface}`: points of the slave's faces lay deeper below the master than the average gaps of their nodes, {by}: \
                 the faces are coarse beside the master's curvature, or the slave's surface is round over an edge, so that contact begins late and \
                 forces are inaccurate; in the first case smaller faces, exchanged roles, integration = \"nodes\" or without multipliers \
                 pressures of points (integration = {{ over = \"faces\", pressures = \"points\" }}) help, in the second a smaller feature_angle"
            ));
        }
        warnings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A soft penalty is no reason not to say that averages close late.
    #[test]
    fn deep_slaves_do_not_hide_deep_points() {
        let slaves = Penetration { slaves: 4, part: 0.067, ..Penetration::default() };
        let points = Penetration { points: 68, part_of_points: 0.171, ..Penetration::default() };
        let masters = Penetration { masters: 3, part_of_masters: 0.12, ..Penetration::default() };
        let late = Penetration { part_of_motion: 0.5, ..Penetration::default() };
        let said = |found: Penetration| found.warnings("c", 8e3);
        assert!(said(Penetration::default()).is_empty());
        let [deep] = &said(slaves)[..] else { panic!("one") };
        assert!(deep.contains("up to 4 slaves ended an increment deeper below the master"), "{deep}");
        let [between] = &said(masters)[..] else { panic!("one") };
        assert!(
            between.contains("up to 3 nodes of the master ended an increment in the slave's faces"),
            "{between}"
        );
        for found in [points, late] {
            let [coarse] = &said(found)[..] else { panic!("one") };
            assert!(coarse.contains(
                "the faces are coarse beside the master's curvature, or the slave's surface is round over an edge"
            ));
            assert!(coarse.contains("pressures = \"points\""), "{coarse}");
            assert_eq!(said(slaves.max(found)), [deep.clone(), coarse.clone()]);
        }
    }
}
