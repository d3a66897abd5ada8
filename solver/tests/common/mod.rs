//! Blocks and a small Newton loop.

#![allow(dead_code, reason = "each test file uses a part")]

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use diffuse_contact_mesh::ElementKind;
use diffuse_contact_solver::material::{Material, PointState};
use diffuse_contact_solver::model::shape::Block;
use diffuse_contact_solver::model::{Body, Cells};
use diffuse_contact_solver::solid::{Order, Solid, SolidResponse};
use diffuse_contact_solver::system::{BlockMatrix, BlockPattern, DirectSolver, Equations, Method, Symmetry};

/// The kinds of solid element, and whether they have incompatible modes.
pub const ELEMENTS: [(ElementKind, bool); 8] = [
    (ElementKind::Tetrahedron4, false),
    (ElementKind::Tetrahedron10, false),
    (ElementKind::Wedge6, false),
    (ElementKind::Wedge15, false),
    (ElementKind::Hexahedron8, false),
    (ElementKind::Hexahedron8, true),
    (ElementKind::Hexahedron20, false),
    (ElementKind::Hexahedron27, false),
];

/// A hexahedron with 8 nodes and incompatible modes.
pub const INCOMPATIBLE: (ElementKind, bool) = (ElementKind::Hexahedron8, true);

/// Nodes and hexahedra of a grid over the unit cube, mapped by `map`.
pub fn grid(divisions: [usize; 3], map: impl Fn([f64; 3]) -> [f64; 3]) -> (Vec<[f64; 3]>, Cells) {
    meshed((ElementKind::Hexahedron8, false), divisions, map)
}

/// A grid of elements of any kind; the corners are mapped, nodes in the middle lie between them.
pub fn meshed(
    (kind, incompatible_modes): (ElementKind, bool),
    divisions: [usize; 3],
    map: impl Fn([f64; 3]) -> [f64; 3],
) -> (Vec<[f64; 3]>, Cells) {
    let block = |kind| {
        let block = Block { origin: [0.0; 3], size: [1.0; 3], divisions, grading: [1.0; 3] };
        let part = block.part(kind).unwrap();
        (part.nodes, part.elements)
    };
    let (mut nodes, mut cells) = match kind {
        ElementKind::Wedge6 | ElementKind::Wedge15 => {
            let (nodes, hexahedra) = block(ElementKind::Hexahedron27);
            let mut wedges = Cells::default();
            for cell in hexahedra.iter() {
                for corners in [[0, 1, 3, 4, 5, 7], [1, 2, 3, 5, 6, 7]] {
                    let at = |a: usize, b: usize| {
                        let (p, q) = (nodes[cell.nodes[a]], nodes[cell.nodes[b]]);
                        let middle = [0, 1, 2].map(|i| 0.5 * (p[i] + q[i]));
                        let near = |n: &&usize| (0..3).all(|i| (nodes[**n][i] - middle[i]).abs() < 1e-9);
                        *cell.nodes.iter().find(near).unwrap()
                    };
                    let mut own: Vec<usize> = corners.iter().map(|&k| cell.nodes[k]).collect();
                    own.extend(kind.edges().iter().map(|&[a, b]| at(corners[a], corners[b])));
                    wedges.push(kind, &own);
                }
            }
            // Without the nodes that no wedge has.
            let used: BTreeSet<usize> = wedges.nodes().iter().copied().collect();
            let number: BTreeMap<usize, usize> =
                used.iter().enumerate().map(|(k, &node)| (node, k)).collect();
            (used.iter().map(|&node| nodes[node]).collect(), wedges.renumbered(|node| number[&node]))
        }
        _ => block(kind),
    };
    let corners: BTreeSet<usize> =
        cells.iter().flat_map(|cell| cell.nodes[..cell.kind.corner_count()].to_vec()).collect();
    corners.iter().for_each(|&node| nodes[node] = map(nodes[node]));
    set_middles(&mut nodes, &cells);
    cells.set_incompatible_modes(|_| incompatible_modes);
    (nodes, cells)
}

/// The element at place `k` alone, on the nodes of all.
pub fn one_of(cells: &Cells, k: usize) -> Cells {
    let mut one = Cells::default();
    one.push(cells.get(k).kind, cells.get(k).nodes);
    one.set_incompatible_modes(|_| cells.get(k).incompatible_modes);
    one
}

/// Puts the nodes in the middle of edges, faces and elements there.
pub fn set_middles(nodes: &mut [[f64; 3]], cells: &Cells) {
    for cell in cells.iter() {
        let count = cell.kind.corner_count();
        let all: Vec<usize> = (0..count).collect();
        let edges = cell.kind.edges().iter().map(|ends| ends.to_vec());
        let centres = cell.kind.centres().iter().map(|around| around.to_vec());
        let others = edges.chain(centres).chain([all]);
        for (&node, of) in cell.nodes[count..].iter().zip(others) {
            let sum = |i: usize| of.iter().map(|&k| nodes[cell.nodes[k]][i]).sum::<f64>();
            nodes[node] = [0, 1, 2].map(|i| sum(i) / of.len() as f64);
        }
    }
}

pub fn body(elements: Cells, material: Material) -> Body {
    Body { part: "body".into(), name: "body".into(), elements, labels: Vec::new(), material }
}

/// A statics problem under Newton's iterations.
pub struct Problem {
    pub solid: Solid,
    pub positions: Vec<[f64; 3]>,
    pub states: Vec<PointState>,
    pub prescribed: Vec<[bool; 3]>,
    pub loads: Vec<[f64; 3]>,
    matrix: BlockMatrix,
    solver: DirectSolver,
    response: SolidResponse,
}

impl Problem {
    pub fn new(nodes: &[[f64; 3]], elements: Cells, material: Material) -> Self {
        let solid = Solid::new(nodes, &[body(elements, material)]).unwrap();
        let pattern = BlockPattern::new(nodes.len(), solid.elements());
        Self {
            positions: nodes.to_vec(),
            states: solid.states(),
            prescribed: vec![[false; 3]; nodes.len()],
            loads: vec![[0.0; 3]; nodes.len()],
            matrix: BlockMatrix::new(Arc::new(pattern)),
            solver: DirectSolver::new(1),
            response: SolidResponse::default(),
            solid,
        }
    }

    /// Holds the axes of all nodes for which `which` is true.
    pub fn hold(&mut self, axes: [bool; 3], which: impl Fn(&[f64; 3]) -> bool) {
        for (prescribed, position) in self.prescribed.iter_mut().zip(&self.positions) {
            if which(position) {
                for axis in 0..3 {
                    prescribed[axis] |= axes[axis];
                }
            }
        }
    }

    /// Moves the prescribed positions to those of `target` along a first linear step, then iterates until the residual is
    /// below `tolerance`; commits the states. Returns the norms of the residuals.
    pub fn step(&mut self, target: &[[f64; 3]], tolerance: f64) -> Vec<f64> {
        let equations = Equations::new(&self.prescribed);
        let mut history = Vec::new();
        let mut jump: Vec<[f64; 3]> = vec![[0.0; 3]; target.len()];
        for (node, jump) in jump.iter_mut().enumerate() {
            for axis in 0..3 {
                if self.prescribed[node][axis] {
                    jump[axis] = target[node][axis] - self.positions[node][axis];
                }
            }
        }
        let mut update = Vec::new();
        let mut pulled = jump.clone();
        for iteration in 0..30 {
            self.assemble();
            let mut residual = self.residual();
            if iteration > 0 {
                let norm = residual
                    .iter()
                    .zip(&self.prescribed)
                    .flat_map(|(r, p)| (0..3).filter(|&i| !p[i]).map(|i| r[i] * r[i]))
                    .sum::<f64>()
                    .sqrt();
                history.push(norm);
                if norm < tolerance {
                    self.states.clone_from(&self.response.states);
                    return history;
                }
            } else {
                self.matrix.multiply(&jump, &mut pulled);
                for (r, p) in residual.iter_mut().zip(&pulled) {
                    for i in 0..3 {
                        r[i] -= p[i];
                    }
                }
            }
            self.solver.factorise(&self.matrix, &equations, Symmetry::Symmetric).unwrap();
            let report = self.solver.solve(&residual, &mut update).unwrap();
            assert_eq!(report.method, Method::Symmetric);
            for (node, position) in self.positions.iter_mut().enumerate() {
                for i in 0..3 {
                    position[i] += update[node][i] + if iteration == 0 { jump[node][i] } else { 0.0 };
                }
            }
        }
        panic!("no convergence: {history:?}");
    }

    /// Loads less internal forces at the current positions.
    pub fn residual(&self) -> Vec<[f64; 3]> {
        let mut residual = self.loads.clone();
        for element in self.solid.responses(&self.response) {
            for (a, &node) in element.nodes.iter().enumerate() {
                for i in 0..3 {
                    residual[node][i] -= element.forces[3 * a + i];
                }
            }
        }
        residual
    }

    fn assemble(&mut self) {
        self.solid.evaluate(&self.positions, &self.states, Order::Tangent, &mut self.response).unwrap();
        self.matrix.clear();
        for element in self.solid.responses(&self.response) {
            self.matrix.add_symmetric(element.nodes, element.tangent);
        }
    }
}

/// Deterministic numbers in [−1, 1).
pub fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// The larger of two errors; NaN if one is.
pub fn worse(x: f64, y: f64) -> f64 {
    if x.is_nan() || x > y { x } else { y }
}
