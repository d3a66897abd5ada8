//! Which nodes are prescribed along which axes, and how they move.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::Motion;

/// Nodes moved alike: what one `[[boundary]]` of a deck says.
#[derive(Clone, Debug, PartialEq)]
pub struct Support {
    /// What it is called in results.
    pub name: String,
    /// The nodes.
    pub nodes: Vec<usize>,
    /// The axes along which they are prescribed: x, y, z.
    pub axes: [bool; 3],
    /// Where they are over time.
    pub motion: Motion,
}

impl Support {
    /// Displacement of its first node, the one with the lowest number, at `time` along the axes that it prescribes, 0 along others.
    pub fn displacement(&self, time: f64, start: &[[f64; 3]]) -> [f64; 3] {
        let Some(&node) = self.nodes.first() else { return [0.0; 3] };
        let position = self.motion.position(time, start[node]);
        let moved = |axis: usize| position[axis] - start[node][axis];
        [0, 1, 2].map(|axis| if self.axes[axis] { moved(axis) } else { 0.0 })
    }
}

/// Two supports move one node differently along one axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Conflict {
    /// The node.
    pub node: usize,
    /// 0 for x, 1 for y, 2 for z.
    pub axis: usize,
    /// Index of the earlier support.
    pub first: usize,
    /// Index of the later support.
    pub second: usize,
}

/// The prescribed degrees of freedom of a model.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Supports {
    groups: Vec<Support>,
    /// The group that prescribes each degree of freedom, 3·node + axis.
    group_of: Vec<Option<u32>>,
}

impl Supports {
    /// The supports of a model of so many nodes, all of which are in range. Where two prescribe one node along one axis they have to
    /// agree, and the degree of freedom belongs to the first.
    ///
    /// # Errors
    /// The first [`Conflict`].
    pub fn new(nodes: usize, groups: Vec<Support>) -> Result<Self, Conflict> {
        let mut group_of = vec![None; 3 * nodes];
        // Amplitudes may have many points.
        let mut known = HashMap::new();
        let mut agree = |first: usize, second: usize, axis: usize| {
            let answer = || groups[first].motion.agrees(&groups[second].motion, axis);
            first == second || *known.entry((first, second, axis)).or_insert_with(answer)
        };
        for (second, group) in groups.iter().enumerate() {
            for &node in &group.nodes {
                for axis in (0..3).filter(|&axis| group.axes[axis]) {
                    let first = *group_of[3 * node + axis].get_or_insert(second as u32) as usize;
                    if !agree(first, second, axis) {
                        return Err(Conflict { node, axis, first, second });
                    }
                }
            }
        }
        Ok(Self { groups, group_of })
    }

    /// The supports it was made of, in the order of the deck.
    pub fn groups(&self) -> &[Support] {
        &self.groups
    }

    /// Whether a degree of freedom, 3·node + axis, is free.
    pub fn is_free(&self, freedom: usize) -> bool {
        self.group_of[freedom].is_none()
    }

    /// The prescribed axes of each node.
    pub fn prescribed(&self) -> Vec<[bool; 3]> {
        self.group_of.as_chunks::<3>().0.iter().map(|axes| axes.map(|group| group.is_some())).collect()
    }

    /// The axes along which each node is held where it is.
    pub fn at_rest(&self) -> Vec<[bool; 3]> {
        let rests = |group: Option<u32>, axis: usize| {
            group.is_some_and(|group| self.groups[group as usize].motion.rests_along(axis))
        };
        let nodes = self.group_of.as_chunks::<3>().0.iter();
        nodes.map(|groups| [0, 1, 2].map(|axis| rests(groups[axis], axis))).collect()
    }

    /// Prescribed degrees of freedom and their coordinates at `time`; `start`: positions at the start.
    pub fn targets<'a>(
        &'a self,
        time: f64,
        start: &'a [[f64; 3]],
    ) -> impl Iterator<Item = (usize, f64)> + 'a {
        self.group_of.iter().enumerate().filter_map(move |(freedom, group)| {
            let motion = &self.groups[(*group)? as usize].motion;
            Some((freedom, motion.position(time, start[freedom / 3])[freedom % 3]))
        })
    }

    /// Sum of `forces`, three per node, over the degrees of freedom that belong to a group.
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
    pub fn moment(&self, group: usize, forces: &[f64], positions: &[[f64; 3]], point: [f64; 3]) -> [f64; 3] {
        let mut sum = Vector3::zeros();
        let nodes = self.group_of.as_chunks::<3>().0.iter().zip(forces.as_chunks::<3>().0).zip(positions);
        for ((of, force), position) in nodes {
            let own = [0, 1, 2].map(|axis| if of[axis] == Some(group as u32) { force[axis] } else { 0.0 });
            sum += (Vector3::from(*position) - Vector3::from(point)).cross(&Vector3::from(own));
        }
        sum.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Amplitude;

    fn moved(nodes: &[usize], axes: [bool; 3], translation: [f64; 3]) -> Support {
        let motion = Motion { translation, amplitude: Amplitude::ramp(1.0), rotation: None };
        Support { name: "moved".to_owned(), nodes: nodes.to_vec(), axes, motion }
    }

    fn fixed(nodes: &[usize], axes: [bool; 3]) -> Support {
        Support { name: "fixed".to_owned(), nodes: nodes.to_vec(), axes, motion: Motion::fixed() }
    }

    #[test]
    fn supports_share_nodes_where_they_agree() {
        let fixed = fixed(&[0, 1], [true, false, true]);
        let pressed = moved(&[1, 2], [true, true, false], [0.0, -3.0, 9.0]);
        let supports = Supports::new(4, vec![fixed, pressed]).unwrap();
        let prescribed = [[true, false, true], [true, true, true], [true, true, false], [false; 3]];
        assert_eq!(supports.prescribed(), prescribed);
        assert!(supports.is_free(1) && !supports.is_free(2));
        let targets: Vec<_> = supports.targets(0.5, &[[1.0; 3]; 4]).collect();
        assert_eq!(targets, [(0, 1.0), (2, 1.0), (3, 1.0), (4, -0.5), (5, 1.0), (6, 1.0), (7, -0.5)]);
        // What both prescribe belongs to the first.
        let forces: Vec<f64> = (0..12).map(f64::from).collect();
        assert_eq!(supports.sum(0, &forces), [3.0, 0.0, 7.0]);
        assert_eq!(supports.sum(1, &forces), [6.0, 11.0, 0.0]);
    }

    #[test]
    fn a_conflict_names_node_and_axis() {
        let pressed = moved(&[1, 2], [false, true, false], [0.0, -3.0, 0.0]);
        let conflict = Supports::new(3, vec![pressed, fixed(&[0, 2], [true; 3])]).unwrap_err();
        assert_eq!(conflict, Conflict { node: 2, axis: 1, first: 0, second: 1 });
    }
}
