//! How many slaves have a weaker fit than the one asked for.

use diffuse_contact::neighbourhood::Fallback;
use diffuse_contact_mesh::names::shown;
use serde::{Deserialize, Serialize};

/// Numbers of slaves, of both passes if there are two, whose masters do not carry what was asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Fallbacks {
    /// With the linear basis, as their masters carry no quadratic surface.
    pub linear: usize,
    /// With more layers or nodes than asked for.
    pub extended: usize,
}

impl Fallbacks {
    /// Whether there are none.
    pub const fn is_none(&self) -> bool {
        self.linear == 0 && self.extended == 0
    }

    /// Counts a slave.
    pub(super) fn count(&mut self, fallback: Fallback) {
        match fallback {
            Fallback::Linear { .. } => self.linear += 1,
            Fallback::Extended { .. } => self.extended += 1,
            _ => {}
        }
    }

    /// The larger number of each kind.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self { linear: self.linear.max(other.linear), extended: self.extended.max(other.extended) }
    }

    /// Those kinds that are more than `before`, in sentences about an interface of so many slaves.
    pub fn warnings(&self, before: Self, interface: &str, slaves: usize) -> Vec<String> {
        let kinds = [
            (
                self.linear,
                before.linear,
                "have the linear basis, which is no better than facets: name the symmetry planes that the master ends in, or mesh it with \
                 three rows of nodes",
            ),
            (
                self.extended,
                before.extended,
                "have more layers or nodes than asked for, as fewer carry no fit: the neighbour rule `domains` needs none",
            ),
        ];
        let grown = kinds.into_iter().filter(|(count, before, _)| count > before);
        let sentence = |(count, _, what): (usize, usize, &str)| {
            format!("interface `{}`: {count} of {slaves} slaves {what}", shown(interface))
        };
        grown.map(sentence).collect()
    }
}
