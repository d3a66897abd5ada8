//! Blocks of hexahedra and a small Newton loop.

#![allow(dead_code, reason = "each test file uses a part")]

use std::sync::Arc;

use diffuse_contact_solver::material::{Material, PointState};
use diffuse_contact_solver::model::Body;
use diffuse_contact_solver::solid::{Order, Solid, SolidResponse};
use diffuse_contact_solver::system::{BlockMatrix, BlockPattern, DirectSolver, Equations, Method, Symmetry};

/// Nodes and elements of a grid over the unit cube, mapped by `map`.
pub fn grid(divisions: [usize; 3], map: impl Fn([f64; 3]) -> [f64; 3]) -> (Vec<[f64; 3]>, Vec<[usize; 8]>) {
    let [nx, ny, nz] = divisions;
    let mut nodes = Vec::new();
    for k in 0..=nz {
        for j in 0..=ny {
            for i in 0..=nx {
                nodes.push(map([i as f64 / nx as f64, j as f64 / ny as f64, k as f64 / nz as f64]));
            }
        }
    }
    let node = |i: usize, j: usize, k: usize| (k * (ny + 1) + j) * (nx + 1) + i;
    let mut elements = Vec::new();
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let layer = |k| [node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k)];
                let ([a, b, c, d], [e, f, g, h]) = (layer(k), layer(k + 1));
                elements.push([a, b, c, d, e, f, g, h]);
            }
        }
    }
    (nodes, elements)
}

pub fn body(elements: Vec<[usize; 8]>, material: Material) -> Body {
    Body { name: "body".into(), elements, labels: Vec::new(), material }
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
    pub fn new(nodes: &[[f64; 3]], elements: Vec<[usize; 8]>, material: Material) -> Self {
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
        for (nodes, forces) in self.solid.elements().zip(&self.response.forces) {
            for (a, &node) in nodes.iter().enumerate() {
                for i in 0..3 {
                    residual[node][i] -= forces[3 * a + i];
                }
            }
        }
        residual
    }

    fn assemble(&mut self) {
        self.solid.evaluate(&self.positions, &self.states, Order::Tangent, &mut self.response).unwrap();
        self.matrix.clear();
        for (nodes, tangent) in self.solid.elements().zip(&self.response.tangents) {
            self.matrix.add_symmetric(nodes, tangent, 1.0);
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
