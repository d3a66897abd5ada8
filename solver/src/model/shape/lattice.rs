//! Nodes and cells by integer coordinates.

use diffuse_contact::surface::Facet;

use crate::model::Part;

/// A lattice of cells[0] × cells[1] × cells[2] hexahedra. With `cyclic` the second direction closes upon itself.
pub(super) struct HexLattice {
    pub cells: [usize; 3],
    pub cyclic: bool,
}

impl HexLattice {
    /// Numbers of nodes along the three directions.
    fn counts(&self) -> [usize; 3] {
        let [a, b, c] = self.cells;
        [a + 1, if self.cyclic { b } else { b + 1 }, c + 1]
    }

    fn node(&self, [i, j, k]: [usize; 3]) -> usize {
        let [a, b, _] = self.counts();
        i + a * ((if self.cyclic { j % b } else { j }) + b * k)
    }

    /// The part with nodes at `position`, which keeps the lattice's orientation. `faces` names the faces of each direction at
    /// its beginning and its end; those across a cyclic direction do not exist.
    pub fn part(&self, position: impl Fn([usize; 3]) -> [f64; 3], faces: [[&str; 2]; 3]) -> Part {
        let counts = self.counts();
        let mut part = Part::default();
        let mut at = Vec::new();
        for k in 0..counts[2] {
            for j in 0..counts[1] {
                for i in 0..counts[0] {
                    part.nodes.push(position([i, j, k]));
                    at.push([i, j, k]);
                }
            }
        }
        for k in 0..self.cells[2] {
            for j in 0..self.cells[1] {
                for i in 0..self.cells[0] {
                    let corner = |[a, b, c]: [usize; 3]| self.node([i + a, j + b, k + c]);
                    part.elements.push(CUBE.map(corner));
                }
            }
        }
        let outside = part.outside();
        for direction in (0..3).filter(|&direction| !(direction == 1 && self.cyclic)) {
            for (name, end) in faces[direction].into_iter().zip([0, self.cells[direction]]) {
                part.name_face(name, &outside, |node| at[node][direction] == end);
            }
        }
        part
    }
}

/// Corners of a cell in the order of a hexahedron.
const CUBE: [[usize; 3]; 8] =
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];

/// A core of cells and layers of cells around it: a mesh of round solids without degenerate cells.
///
/// The core is the lattice from `low` to `high`. Along the first `round` axes it would reach from −`half` to `half` if it were
/// not cut; where it does reach ±`half` along one of them, layers stand on it.
pub(super) struct ButterflyLattice {
    pub low: [i64; 3],
    pub high: [i64; 3],
    pub half: i64,
    pub round: usize,
    pub layers: usize,
}

/// Coordinates of a node: those of the core, and the layer, 0 for the core itself.
pub(super) type Place = ([i64; 3], usize);

impl ButterflyLattice {
    fn counts(&self) -> [usize; 3] {
        std::array::from_fn(|axis| (self.high[axis] - self.low[axis]) as usize + 1)
    }

    fn core_node(&self, at: [i64; 3]) -> usize {
        let [a, b, _] = self.counts();
        let [i, j, k]: [usize; 3] = std::array::from_fn(|axis| (at[axis] - self.low[axis]) as usize);
        i + a * (j + b * k)
    }

    /// All points of the core in the order of their nodes.
    fn core(&self) -> Vec<[i64; 3]> {
        let (low, high) = (self.low, self.high);
        let plane = |k| (low[1]..=high[1]).flat_map(move |j| (low[0]..=high[0]).map(move |i| [i, j, k]));
        (low[2]..=high[2]).flat_map(plane).collect()
    }

    /// Whether layers stand on a point of the core.
    fn is_rim(&self, at: [i64; 3]) -> bool {
        at[..self.round].iter().any(|x| x.abs() == self.half)
    }

    /// The faces of the core on which layers stand, oriented outward.
    fn rim_faces(&self) -> Vec<[[i64; 3]; 4]> {
        let mut faces = Vec::new();
        for axis in 0..self.round {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            for side in [-self.half, self.half] {
                if side < self.low[axis] || side > self.high[axis] {
                    continue;
                }
                for j in self.low[v]..self.high[v] {
                    for i in self.low[u]..self.high[u] {
                        let mut face = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[a, b]| {
                            let mut at = [0; 3];
                            (at[axis], at[u], at[v]) = (side, i + a, j + b);
                            at
                        });
                        if side < 0 {
                            face.reverse();
                        }
                        faces.push(face);
                    }
                }
            }
        }
        faces
    }

    /// The part with nodes at `position`, and where each of its nodes is in the lattice. No faces are named.
    pub fn part(&self, position: impl Fn(Place) -> [f64; 3]) -> (Part, Vec<Place>) {
        let core = self.core();
        let mut places: Vec<Place> = core.iter().map(|&at| (at, 0)).collect();
        // The first node of the layers over each point of the rim; the others follow it.
        let mut above = vec![usize::MAX; core.len()];
        for (node, &at) in core.iter().enumerate() {
            if self.is_rim(at) {
                above[node] = places.len();
                places.extend((1..=self.layers).map(|layer| (at, layer)));
            }
        }
        let node = |at, layer| {
            let core = self.core_node(at);
            if layer == 0 { core } else { above[core] + layer - 1 }
        };

        let mut part =
            Part { nodes: places.iter().map(|&place| position(place)).collect(), ..Part::default() };
        for k in self.low[2]..self.high[2] {
            for j in self.low[1]..self.high[1] {
                for i in self.low[0]..self.high[0] {
                    let corner = |[a, b, c]: [usize; 3]| [i + a as i64, j + b as i64, k + c as i64];
                    part.elements.push(CUBE.map(|offset| self.core_node(corner(offset))));
                }
            }
        }
        for [a, b, c, d] in self.rim_faces() {
            for layer in 0..self.layers {
                let corners = [(a, 0), (b, 0), (c, 0), (d, 0), (a, 1), (b, 1), (c, 1), (d, 1)];
                part.elements.push(corners.map(|(at, up)| node(at, layer + up)));
            }
        }
        (part, places)
    }

    /// The rim alone, as a surface with nodes at `position`: a rigid part, and where each of its nodes is in the lattice.
    pub fn rim(&self, position: impl Fn([i64; 3]) -> [f64; 3]) -> (Part, Vec<[i64; 3]>) {
        let core = self.core();
        let mut number = vec![usize::MAX; core.len()];
        let mut places = Vec::new();
        for (node, &at) in core.iter().enumerate() {
            if self.is_rim(at) {
                number[node] = places.len();
                places.push(at);
            }
        }
        let corners = |face: [[i64; 3]; 4]| face.map(|at| number[self.core_node(at)]);
        let facets = self.rim_faces().into_iter().map(|face| Facet::Quadrilateral(corners(face))).collect();
        let nodes = places.iter().map(|&at| position(at)).collect();
        (Part { nodes, facets, ..Part::default() }, places)
    }
}
