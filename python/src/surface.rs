//! `MasterSurface` and tributary areas.

use diffuse_contact::surface::{self, MasterSurface};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::arrays::{Indices, Numbers, facets, points, readable};
use crate::threads;

/// The connectivity of the master facets.
#[pyclass(module = "diffuse_contact._native", frozen)]
pub struct Surface {
    pub surface: MasterSurface,
}

#[pymethods]
impl Surface {
    #[new]
    fn new(
        py: Python<'_>,
        positions: &Bound<'_, PyArray2<f64>>,
        corners: &Bound<'_, PyArray2<i64>>,
    ) -> PyResult<Self> {
        let (positions, corners) = (readable(positions)?, readable(corners)?);
        let (positions, facets) = (points(py, &positions)?, facets(py, &corners)?);
        let surface = threads::attempt(py, || MasterSurface::new(positions, facets))?;
        Ok(Self { surface })
    }

    /// Number of facets.
    #[getter]
    fn facet_count(&self) -> usize {
        self.surface.facet_count()
    }

    /// The nodes of the surface, ascending.
    fn nodes<'py>(&self, py: Python<'py>) -> Indices<'py> {
        PyArray1::from_iter(py, self.surface.nodes().iter().map(|&node| i64::from(node)))
    }

    /// The edges at which the surface ends, two nodes each, one edge after another.
    fn border_edges<'py>(&self, py: Python<'py>) -> Indices<'py> {
        PyArray1::from_iter(py, self.surface.border_edges().flatten().map(|node| node as i64))
    }

    /// Outward normals of the nodes of the surface, not normalised, one after another.
    fn node_normals<'py>(
        &self,
        py: Python<'py>,
        positions: &Bound<'py, PyArray2<f64>>,
    ) -> PyResult<Numbers<'py>> {
        let positions = readable(positions)?;
        let positions = points(py, &positions)?;
        let normals = threads::attempt(py, || self.surface.node_normals(positions))?;
        Ok(PyArray1::from_slice(py, normals.as_flattened()))
    }
}

/// Tributary area of every node.
#[pyfunction]
pub fn tributary_areas<'py>(
    py: Python<'py>,
    positions: &Bound<'py, PyArray2<f64>>,
    corners: &Bound<'py, PyArray2<i64>>,
) -> PyResult<Numbers<'py>> {
    let (positions, corners) = (readable(positions)?, readable(corners)?);
    let (positions, facets) = (points(py, &positions)?, facets(py, &corners)?);
    let areas = threads::attempt(py, || surface::tributary_areas(positions, &facets))?;
    Ok(PyArray1::from_vec(py, areas))
}
