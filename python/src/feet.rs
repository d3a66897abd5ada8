//! The feet of an interface with their derivatives.

use diffuse_contact::interface::{ContactFeet, FootRef};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::interface::{Interface, shared};
use crate::threads;

/// One entry for each slave and each of its masters, slave first; zeros without contact.
struct Entries {
    /// Where the entries of each slave begin, and the end.
    offsets: Vec<i64>,
    nodes: Vec<i64>,
    /// φ; 0 for the slave.
    weights: Vec<f64>,
    /// ∂x^d/∂x by the node of the entry, 3 × 3 numbers, and ∂ν/∂x.
    jacobians: [Vec<f64>; 2],
}

impl Entries {
    fn of(feet: &ContactFeet) -> Self {
        let count = feet.iter().map(|foot| foot.nodes.len() + 1).sum();
        let mut entries = Self {
            offsets: Vec::with_capacity(feet.len() + 1),
            nodes: Vec::with_capacity(count),
            weights: vec![0.0; count],
            jacobians: [Vec::with_capacity(9 * count), Vec::with_capacity(9 * count)],
        };
        entries.offsets.push(0);
        for foot in feet.iter() {
            entries.push(&foot);
        }
        entries
    }

    fn push(&mut self, foot: &FootRef<'_>) {
        let first = self.nodes.len();
        self.nodes.push(foot.slave as i64);
        self.nodes.extend(foot.nodes.iter().map(|&node| i64::from(node)));
        let count = self.nodes.len() - first;
        self.offsets.push(self.nodes.len() as i64);
        self.weights[first + 1..first + 1 + foot.weights.len()].copy_from_slice(foot.weights);
        for (all, rows) in self.jacobians.iter_mut().zip([foot.foot, foot.normal]) {
            // From rows over all nodes to a block for each node.
            let [x, y, z] = [0, 1, 2].map(|row| rows.chunks_exact(3).skip(row * count).take(count));
            all.extend(x.zip(y).zip(z).flat_map(|((x, y), z)| [x, y, z]).flatten());
            all.resize(9 * self.nodes.len(), 0.0);
        }
    }
}

#[pymethods]
impl Interface {
    /// Feet, weights of the masters and derivatives, at the present positions, in flat arrays.
    fn feet<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        let py = slf.py();
        let this = shared(slf)?;
        let interface = &this.interface;
        let (feet, entries) = threads::attempt(py, || {
            interface.foot_derivatives().map(|feet| {
                let entries = Entries::of(&feet);
                (feet, entries)
            })
        })?;
        let Entries { offsets, nodes, weights, jacobians: [foot_jacobian, normal_jacobian] } = entries;
        let point = |foot: FootRef<'_>| {
            let ([x, y, z], [u, v, w]) = (foot.point.foot, foot.point.normal);
            if foot.outcome.is_contact() { [foot.point.gap, x, y, z, u, v, w] } else { [f64::NAN; 7] }
        };
        let points: Vec<[f64; 7]> = feet.iter().map(point).collect();
        let column = |from: usize, to: usize| {
            PyArray1::from_vec(py, points.iter().flat_map(|point| &point[from..to]).copied().collect())
        };
        let dict = PyDict::new(py);
        dict.set_item("offsets", PyArray1::from_vec(py, offsets))?;
        dict.set_item("nodes", PyArray1::from_vec(py, nodes))?;
        dict.set_item("weights", PyArray1::from_vec(py, weights))?;
        dict.set_item("gap", column(0, 1))?;
        dict.set_item("foot", column(1, 4))?;
        dict.set_item("normal", column(4, 7))?;
        dict.set_item("foot_jacobian", PyArray1::from_vec(py, foot_jacobian))?;
        dict.set_item("normal_jacobian", PyArray1::from_vec(py, normal_jacobian))?;
        dict.set_item("outcomes", feet.iter().map(|foot| foot.outcome.code()).collect::<Vec<_>>())?;
        Ok(dict)
    }
}
