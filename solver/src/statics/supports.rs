//! Degrees of freedom whose motion is given.

use crate::deck::Motion;

/// Nodes moved together: what one `[[boundary]]` of a deck says.
#[derive(Clone, Debug)]
pub struct SupportGroup {
    /// What it is called in results.
    pub name: String,
    /// Where its nodes are at a time.
    pub motion: Motion,
    /// Which nodes, and which of their axes.
    pub nodes: Vec<(usize, [bool; 3])>,
}

/// All prescribed motions.
#[derive(Clone, Debug, Default)]
pub struct Supports {
    groups: Vec<SupportGroup>,
    /// The group that prescribes each degree of freedom.
    group_of: Vec<Option<u32>>,
}

impl Supports {
    /// `groups` prescribe no degree of freedom twice; of several the first counts.
    #[must_use]
    pub fn new(nodes: usize, groups: Vec<SupportGroup>) -> Self {
        let mut group_of = vec![None; 3 * nodes];
        for (k, group) in groups.iter().enumerate() {
            for &(node, axes) in &group.nodes {
                for axis in (0..3).filter(|&axis| axes[axis]) {
                    group_of[3 * node + axis].get_or_insert(k as u32);
                }
            }
        }
        Self { groups, group_of }
    }

    /// The groups, in the order of the deck.
    #[must_use]
    pub fn groups(&self) -> &[SupportGroup] {
        &self.groups
    }

    /// Whether a degree of freedom, 3·node + axis, is free.
    #[must_use]
    pub fn is_free(&self, freedom: usize) -> bool {
        self.group_of[freedom].is_none()
    }

    /// Where the prescribed coordinates are at `time`; `start`: positions at the start.
    pub fn prescribed<'a>(&'a self, time: f64, start: &'a [[f64; 3]]) -> impl Iterator<Item = (usize, f64)> + 'a {
        self.group_of.iter().enumerate().filter_map(move |(freedom, group)| {
            let group = &self.groups[(*group)? as usize];
            Some((freedom, group.motion.position(time, start[freedom / 3])[freedom % 3]))
        })
    }

    /// Sum of `forces`, three per node, over the degrees of freedom that a group prescribes.
    #[must_use]
    pub fn sum(&self, group: usize, forces: &[f64]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (freedom, of) in self.group_of.iter().enumerate() {
            if *of == Some(group as u32) {
                sum[freedom % 3] += forces[freedom];
            }
        }
        sum
    }
}
