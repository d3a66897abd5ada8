//! Nodes and cells by integer coordinates.
//!
//! A cell is one hexahedron or six tetrahedra. Where these have nodes in the middle of their edges a cell is two steps of the lattice
//! wide, one otherwise, and steps that no element uses have no node.

use diffuse_contact::surface::Facet;
use diffuse_contact_mesh::ElementKind;

use crate::model::{Cells, Part};

/// Steps of the lattice along an edge of a cell.
pub(super) const fn steps(kind: ElementKind) -> usize {
    if kind.has_middles() { 2 } else { 1 }
}

/// A lattice of cells[0] × cells[1] × cells[2] cells. With `cyclic` the second direction closes upon itself.
pub(super) struct HexLattice {
    pub cells: [usize; 3],
    pub cyclic: bool,
    pub kind: ElementKind,
}

impl HexLattice {
    /// Numbers of nodes along the three directions.
    fn counts(&self) -> [usize; 3] {
        let [a, b, c] = self.cells.map(|count| steps(self.kind) * count);
        [a + 1, if self.cyclic { b } else { b + 1 }, c + 1]
    }

    fn node(&self, [i, j, k]: [usize; 3]) -> usize {
        let [a, b, _] = self.counts();
        i + a * ((if self.cyclic { j % b } else { j }) + b * k)
    }

    /// The part with nodes at `position` of steps, which keeps the lattice's orientation. `faces` names the faces of each direction at
    /// its beginning and its end; those across a cyclic direction do not exist.
    pub fn part(&self, position: impl Fn([usize; 3]) -> [f64; 3], faces: [[&str; 2]; 3]) -> Part {
        let (counts, steps) = (self.counts(), steps(self.kind));
        let mut at: Vec<[usize; 3]> = grid(counts).collect();
        let mut part = Part { nodes: at.iter().map(|&at| position(at)).collect(), ..Part::default() };
        for [i, j, k] in grid(self.cells) {
            let node = |[a, b, c]: [usize; 3]| self.node([steps * i + a, steps * j + b, steps * k + c]);
            add_cell(&mut part.elements, self.kind, node);
        }
        drop_unused(&mut part, &mut at);
        let outside = part.outside();
        for direction in (0..3).filter(|&direction| !(direction == 1 && self.cyclic)) {
            for (name, end) in faces[direction].into_iter().zip([0, steps * self.cells[direction]]) {
                part.name_face(name, &outside, |node| at[node][direction] == end);
            }
        }
        part
    }
}

/// Integer coordinates from 0 to below these, the first ones fastest.
fn grid([a, b, c]: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..c).flat_map(move |k| (0..b).flat_map(move |j| (0..a).map(move |i| [i, j, k])))
}

/// Corners of a cell in the order of a hexahedron.
const CUBE: [[usize; 3]; 8] =
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];

/// Adds the elements of a cell. `node`: by steps from its first corner.
fn add_cell(elements: &mut Cells, kind: ElementKind, node: impl Fn([usize; 3]) -> usize) {
    let steps = steps(kind);
    let mut add = |corners: &[usize]| {
        // The mean of a few corners in steps.
        let mean = |of: &[usize]| {
            let sum = |axis: usize| of.iter().map(|&k| steps * CUBE[corners[k]][axis]).sum::<usize>();
            [0, 1, 2].map(|axis| sum(axis) / of.len())
        };
        let all: Vec<usize> = (0..corners.len()).collect();
        let at_corners = all.iter().map(|k| mean(std::slice::from_ref(k)));
        let others = kind
            .edges()
            .iter()
            .map(|ends| mean(ends))
            .chain(kind.centres().iter().map(|around| mean(around)));
        let places = at_corners.chain(others).chain([mean(&all)]);
        let nodes: Vec<usize> = places.take(kind.node_count()).map(&node).collect();
        elements.push(kind, &nodes);
    };
    if kind.corner_count() == 8 {
        add(&[0, 1, 2, 3, 4, 5, 6, 7]);
        return;
    }
    let corners = CUBE.map(|corner| node(corner.map(|x| steps * x)));
    tetrahedra(&corners).iter().for_each(|tetrahedron| add(tetrahedron));
}

/// Six tetrahedra that fill a hexahedron, by local corners: from its first node to the faces that do not have it, each halved from its
/// own first node. So neighbours halve their common face alike.
fn tetrahedra(corners: &[usize; 8]) -> Vec<[usize; 4]> {
    let first_of = |local: &[usize]| local.iter().copied().min_by_key(|&k| corners[k]).unwrap_or_default();
    let apex = first_of(&[0, 1, 2, 3, 4, 5, 6, 7]);
    let far = ElementKind::Hexahedron8.faces().iter().filter(|face| !face.contains(&apex));
    far.flat_map(|face| {
        let first = first_of(face);
        let place = face.iter().position(|&k| k == first).unwrap_or_default();
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| face[(place + k) % 4]);
        // Seen from the apex, which is inside, the face runs the other way round.
        [[a, c, b, apex], [a, d, c, apex]]
    })
    .collect()
}

/// Drops the nodes that no element has. `at`: an entry for each node.
fn drop_unused<T: Copy>(part: &mut Part, at: &mut Vec<T>) {
    let mut number = vec![usize::MAX; part.nodes.len()];
    part.elements.nodes().iter().for_each(|&node| number[node] = 0);
    let kept: Vec<usize> = (0..number.len()).filter(|&node| number[node] == 0).collect();
    for (k, &node) in kept.iter().enumerate() {
        number[node] = k;
    }
    part.nodes = kept.iter().map(|&node| part.nodes[node]).collect();
    *at = kept.iter().map(|&node| at[node]).collect();
    part.elements = part.elements.renumbered(|node| number[node]);
}

/// A core of cells and layers of cells around it: a mesh of round solids without degenerate cells. All numbers count steps.
///
/// The core is the lattice from `low` to `high`. Along the first `round` axes it would reach from −`half` to `half` if it were
/// not cut; where it does reach ±`half` along one of them, layers stand on it.
pub(super) struct ButterflyLattice {
    pub kind: ElementKind,
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
        let at = |steps: [usize; 3]| std::array::from_fn(|axis| self.low[axis] + steps[axis] as i64);
        grid(self.counts()).map(at).collect()
    }

    /// The points of the rim in the order of their nodes, without a list of the core.
    fn rim_points(&self) -> Vec<[i64; 3]> {
        let (low, high) = (self.low, self.high);
        let mut points = Vec::new();
        for k in low[2]..=high[2] {
            for j in low[1]..=high[1] {
                // Between the ends of a row all points are like the one beside the first.
                let step = if self.is_rim([low[0] + 1, j, k]) { 1 } else { high[0] - low[0] };
                let row = (low[0]..=high[0]).step_by(step as usize).map(|i| [i, j, k]);
                points.extend(row.filter(|&at| self.is_rim(at)));
            }
        }
        points
    }

    /// Whether layers stand on a point of the core.
    fn is_rim(&self, at: [i64; 3]) -> bool {
        at[..self.round].iter().any(|x| x.abs() == self.half)
    }

    /// The faces of the core's cells on which layers stand.
    fn rim_faces(&self) -> Vec<RimFace> {
        let (mut faces, steps) = (Vec::new(), steps(self.kind));
        for axis in 0..self.round {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            for side in [-self.half, self.half] {
                if side < self.low[axis] || side > self.high[axis] {
                    continue;
                }
                for j in (self.low[v]..self.high[v]).step_by(steps) {
                    for i in (self.low[u]..self.high[u]).step_by(steps) {
                        let mut first = [0; 3];
                        (first[axis], first[u], first[v]) = (side, i, j);
                        faces.push(RimFace { first, along: [u, v], flipped: (side < 0).then_some(steps) });
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
        let steps = steps(self.kind);
        for k in (self.low[2]..self.high[2]).step_by(steps) {
            for j in (self.low[1]..self.high[1]).step_by(steps) {
                for i in (self.low[0]..self.high[0]).step_by(steps) {
                    let at = |[a, b, c]: [usize; 3]| [i + a as i64, j + b as i64, k + c as i64];
                    add_cell(&mut part.elements, self.kind, |offset| self.core_node(at(offset)));
                }
            }
        }
        for face in self.rim_faces() {
            for layer in (0..self.layers).step_by(steps) {
                add_cell(&mut part.elements, self.kind, |[a, b, up]| node(face.at([a, b]), layer + up));
            }
        }
        drop_unused(&mut part, &mut places);
        (part, places)
    }

    /// The rim alone, as a surface with nodes at `position`: a rigid part, and where each of its nodes is in the lattice.
    pub fn rim(&self, position: impl Fn([i64; 3]) -> [f64; 3]) -> (Part, Vec<[i64; 3]>) {
        let places = self.rim_points();
        let ordered = |[i, j, k]: [i64; 3]| [k, j, i];
        let number = |at: [i64; 3]| {
            let place = places.binary_search_by_key(&ordered(at), |&place| ordered(place));
            place.unwrap_or_else(|_| unreachable!("corners of the rim's faces are on it"))
        };
        let corners = |face: RimFace| [[0, 0], [1, 0], [1, 1], [0, 1]].map(|offset| number(face.at(offset)));
        let facets = self.rim_faces().into_iter().map(|face| Facet::Quadrilateral(corners(face))).collect();
        let nodes = places.iter().map(|&at| position(at)).collect();
        (Part { nodes, facets, ..Part::default() }, places)
    }
}

/// A face of a cell of the core, seen from outside.
#[derive(Clone, Copy)]
struct RimFace {
    first: [i64; 3],
    /// The axes of its own two directions.
    along: [usize; 2],
    /// Its steps along an edge, if the second direction runs backward.
    flipped: Option<usize>,
}

impl RimFace {
    fn at(self, [a, b]: [usize; 2]) -> [i64; 3] {
        let mut at = self.first;
        at[self.along[0]] += a as i64;
        at[self.along[1]] += self.flipped.map_or(b, |steps| steps - b) as i64;
        at
    }
}
