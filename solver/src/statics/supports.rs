//! Supports with the names under which results show them.

use crate::model::Support;

/// Nodes moved together: what one `[[boundary]]` of a deck says.
#[derive(Clone, Debug)]
pub struct SupportGroup {
    /// What it is called in results.
    pub name: String,
    /// Its nodes, their axes and their motion.
    pub support: Support,
}

impl SupportGroup {
    /// Displacement of its first node, the one with the lowest number, at `time` along the axes that it prescribes, 0 along others.
    #[must_use]
    pub fn displacement(&self, time: f64, start: &[[f64; 3]]) -> [f64; 3] {
        let Some(&node) = self.support.nodes.first() else { return [0.0; 3] };
        let position = self.support.motion.position(time, start[node]);
        let moved = |axis: usize| position[axis] - start[node][axis];
        [0, 1, 2].map(|axis| if self.support.axes[axis] { moved(axis) } else { 0.0 })
    }
}

/// All prescribed degrees of freedom.
#[derive(Clone, Debug, Default)]
pub struct SupportGroups {
    groups: Vec<SupportGroup>,
    /// The group that prescribes each degree of freedom, 3·node + axis.
    group_of: Vec<Option<u32>>,
}

impl SupportGroups {
    /// The groups of a model of so many nodes. Where several prescribe a degree of freedom, alike, it belongs to the first.
    #[must_use]
    pub fn new(nodes: usize, groups: Vec<SupportGroup>) -> Self {
        let mut group_of = vec![None; 3 * nodes];
        for (k, group) in groups.iter().enumerate() {
            for &node in &group.support.nodes {
                for axis in (0..3).filter(|&axis| group.support.axes[axis]) {
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

    /// The prescribed axes of each node.
    #[must_use]
    pub fn prescribed(&self) -> Vec<[bool; 3]> {
        self.group_of.as_chunks::<3>().0.iter().map(|axes| axes.map(|group| group.is_some())).collect()
    }

    /// The axes along which each node is held where it is.
    #[must_use]
    pub fn at_rest(&self) -> Vec<[bool; 3]> {
        let rests = |(axis, group): (usize, &Option<u32>)| {
            group.is_some_and(|group| self.groups[group as usize].support.motion.rests_along(axis))
        };
        let of_node = |groups: &[Option<u32>; 3]| {
            let mut axes = groups.iter().enumerate().map(rests);
            std::array::from_fn(|_| axes.next().unwrap_or_default())
        };
        self.group_of.as_chunks::<3>().0.iter().map(of_node).collect()
    }

    /// Prescribed degrees of freedom and their coordinates at `time`; `start`: positions at the start.
    pub fn targets<'a>(
        &'a self,
        time: f64,
        start: &'a [[f64; 3]],
    ) -> impl Iterator<Item = (usize, f64)> + 'a {
        self.group_of.iter().enumerate().filter_map(move |(freedom, group)| {
            let motion = &self.groups[(*group)? as usize].support.motion;
            Some((freedom, motion.position(time, start[freedom / 3])[freedom % 3]))
        })
    }

    /// Sum of `forces`, three per node, over the degrees of freedom that belong to a group.
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

    /// Moment about a point of `forces`, three per node, over the degrees of freedom that belong to a group: Σ (x − point) × f.
    #[must_use]
    pub fn moment(&self, group: usize, forces: &[f64], positions: &[[f64; 3]], point: [f64; 3]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        let nodes = self.group_of.as_chunks::<3>().0.iter().zip(forces.as_chunks::<3>().0).zip(positions);
        for ((of, force), position) in nodes {
            let own = |axis: usize| if of[axis] == Some(group as u32) { force[axis] } else { 0.0 };
            let arm = |axis: usize| position[axis] - point[axis];
            for (axis, sum) in sum.iter_mut().enumerate() {
                let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
                *sum += arm(next) * own(last) - arm(last) * own(next);
            }
        }
        sum
    }
}
