//! Which nodes are prescribed along which axes, and how they move.

use super::Motion;

/// Nodes moved alike.
#[derive(Clone, Debug, PartialEq)]
pub struct Support {
    /// The nodes.
    pub nodes: Vec<usize>,
    /// The axes along which they are prescribed: x, y, z.
    pub axes: [bool; 3],
    /// Where they are over time.
    pub motion: Motion,
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
    supports: Vec<Support>,
    /// Of each node and axis the motion.
    of_node: Vec<[Option<usize>; 3]>,
}

impl Supports {
    /// The supports of a model of `node_count` nodes, all of which are in range. Where two prescribe one node along one
    /// axis they have to agree.
    ///
    /// # Errors
    /// The first [`Conflict`].
    pub fn new(node_count: usize, supports: &[Support]) -> Result<Self, Conflict> {
        let mut of_node = vec![[None; 3]; node_count];
        for (second, support) in supports.iter().enumerate() {
            for &node in &support.nodes {
                for axis in (0..3).filter(|&axis| support.axes[axis]) {
                    let motion = *of_node[node][axis].get_or_insert(second);
                    if !supports[motion].motion.agrees(&support.motion, axis) {
                        return Err(Conflict { node, axis, first: motion, second });
                    }
                }
            }
        }
        Ok(Self { supports: supports.to_vec(), of_node })
    }

    /// The supports it was made of.
    #[must_use]
    pub fn supports(&self) -> &[Support] {
        &self.supports
    }

    /// How a node moves along an axis (0 for x, 1 for y, 2 for z); `None` if it is free.
    #[must_use]
    pub fn motion(&self, node: usize, axis: usize) -> Option<&Motion> {
        self.of_node[node][axis].map(|k| &self.supports[k].motion)
    }

    /// The prescribed degrees of freedom as node and axis, ascending.
    pub fn prescribed(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let axes = |(node, of_axis): (usize, &[Option<usize>; 3])| {
            let of_axis = *of_axis;
            (0..3).filter(move |&axis| of_axis[axis].is_some()).map(move |axis| (node, axis))
        };
        self.of_node.iter().enumerate().flat_map(axes)
    }

    /// Moves the prescribed coordinates of `positions` to where they are at a time. `reference` has the positions at the
    /// start; both have as many nodes as the model.
    pub fn apply(&self, time: f64, reference: &[[f64; 3]], positions: &mut [[f64; 3]]) {
        for (node, of_axis) in self.of_node.iter().enumerate() {
            for axis in 0..3 {
                if let Some(k) = of_axis[axis] {
                    positions[node][axis] = self.supports[k].motion.position(time, reference[node])[axis];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Amplitude;

    fn moved(nodes: &[usize], axes: [bool; 3], translation: [f64; 3]) -> Support {
        let motion = Motion { translation, amplitude: Amplitude::ramp(1.0), rotation: None };
        Support { nodes: nodes.to_vec(), axes, motion }
    }

    #[test]
    fn supports_share_nodes_where_they_agree() {
        let fixed = Support { nodes: vec![0, 1], axes: [true, false, true], motion: Motion::fixed() };
        let pressed = moved(&[1, 2], [true, true, false], [0.0, -3.0, 9.0]);
        let supports = Supports::new(4, &[fixed, pressed]).unwrap();
        let prescribed: Vec<_> = supports.prescribed().collect();
        assert_eq!(prescribed, [(0, 0), (0, 2), (1, 0), (1, 1), (1, 2), (2, 0), (2, 1)]);

        let reference = [[1.0; 3]; 4];
        let mut positions = [[5.0; 3]; 4];
        supports.apply(0.5, &reference, &mut positions);
        assert_eq!(positions, [[1.0, 5.0, 1.0], [1.0, -0.5, 1.0], [1.0, -0.5, 5.0], [5.0; 3]]);
        assert!(supports.motion(3, 0).is_none());
    }

    #[test]
    fn a_conflict_names_node_and_axis() {
        let pressed = moved(&[1, 2], [false, true, false], [0.0, -3.0, 0.0]);
        let fixed = Support { nodes: vec![0, 2], axes: [true; 3], motion: Motion::fixed() };
        let conflict = Supports::new(3, &[pressed, fixed]).unwrap_err();
        assert_eq!(conflict, Conflict { node: 2, axis: 1, first: 0, second: 1 });
    }
}
