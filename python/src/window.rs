//! Windows of a surface and the parts they are cut from: `Window`, `SurfacePart`, and interfaces in a window.

use diffuse_contact::Point;
use diffuse_contact::interface::{ContactInterface, PartDemands, PartFacets, SurfacePart, split_history};
use diffuse_contact::surface::window::{self, Box3, Extents};
use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::arrays::{Indices, Numbers, facets, indices, points, readable, slice};
use crate::errors::{self, Raise};
use crate::interface::{Equations, Interface, dofs_of, planes, shared};
use crate::options::Options;
use crate::threads;

type Rows<'py> = Bound<'py, PyArray2<f64>>;

fn numbers<'py>(py: Python<'py>, numbers: impl IntoIterator<Item = u64>) -> Indices<'py> {
    PyArray1::from_iter(py, numbers.into_iter().map(|number| number as i64))
}

/// Numbers of nodes or facets in the whole surface.
fn names(py: Python<'_>, what: &str, array: &Indices<'_>) -> PyResult<Vec<u64>> {
    Ok(indices(py, what, &readable(array)?)?.into_iter().map(|number| number as u64).collect())
}

/// Rows of six numbers: lowest and highest corner.
fn boxes_of(py: Python<'_>, array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Box3>> {
    Ok(points(py, array)?.as_chunks::<2>().0.to_vec())
}

/// Lowest and highest corner, and the longest edge of a facet.
type ExtentsRow = (Point, Point, f64);

fn extents_of((low, high, facet): ExtentsRow) -> Extents {
    Extents { low, high, facet }
}

/// Boxes around groups of points, rows of lowest and highest corner in turn.
#[pyfunction]
pub fn boxes_around<'py>(
    py: Python<'py>,
    around: &Rows<'py>,
    reach: f64,
    most: usize,
) -> PyResult<Numbers<'py>> {
    let around = readable(around)?;
    let around = points(py, &around)?;
    let boxes = threads::run(py, || window::boxes_around(around, reach, most));
    Ok(PyArray1::from_slice(py, boxes.as_flattened().as_flattened()))
}

/// Of facets alone.
#[pyfunction]
pub fn extents(
    py: Python<'_>,
    positions: &Rows<'_>,
    corners: &Bound<'_, PyArray2<i64>>,
) -> PyResult<ExtentsRow> {
    let (positions, corners) = (readable(positions)?, readable(corners)?);
    let (positions, facets) = (points(py, &positions)?, facets(py, &corners)?);
    let Extents { low, high, facet } = threads::attempt(py, || {
        let part = PartFacets {
            positions,
            node_numbers: &[],
            facet_numbers: &[],
            owned: &vec![true; facets.len()],
            facets: &facets,
            known: [[0.0; 3]; 2],
            extents: Extents::NONE,
        };
        part.own_extents()
    })?;
    Ok((low, high, facet))
}

/// How many numbers of a history each slave has.
#[pyfunction]
pub fn history_lengths<'py>(py: Python<'py>, history: &Numbers<'py>) -> PyResult<Indices<'py>> {
    let history = readable(history)?;
    let parts = split_history(slice(py, &history)?).map_err(|error| error.raise(py))?;
    Ok(PyArray1::from_iter(py, parts.iter().map(|part| part.len() as i64)))
}

/// What some slaves can need of a surface.
#[pyclass(module = "diffuse_contact._native", frozen)]
pub struct Window {
    pub window: window::Window,
}

#[pymethods]
impl Window {
    /// The window with these numbers.
    #[new]
    fn new(py: Python<'_>, integers: &Indices<'_>, reals: &Numbers<'_>) -> PyResult<Self> {
        let (integers, reals) = (readable(integers)?, readable(reals)?);
        let (integers, reals) = (slice(py, &integers)?, slice(py, &reals)?);
        let window = threads::attempt(py, || window::Window::from_numbers(integers, reals))?;
        Ok(Self { window })
    }

    /// The window as plain numbers.
    fn numbers<'py>(&self, py: Python<'py>) -> (Indices<'py>, Numbers<'py>) {
        let (integers, reals) = self.window.to_numbers();
        (PyArray1::from_vec(py, integers), PyArray1::from_vec(py, reals))
    }

    /// Windows of the same boxes as one.
    #[staticmethod]
    fn joined(py: Python<'_>, windows: Vec<PyRef<'_, Self>>) -> PyResult<Self> {
        let windows: Vec<window::Window> = windows.iter().map(|own| own.window.clone()).collect();
        let window = threads::attempt(py, || window::Window::joined(&windows))?;
        Ok(Self { window })
    }

    fn nodes<'py>(&self, py: Python<'py>) -> Indices<'py> {
        numbers(py, self.window.nodes())
    }

    fn facets<'py>(&self, py: Python<'py>) -> Indices<'py> {
        numbers(py, self.window.facets())
    }

    fn boxes<'py>(&self, py: Python<'py>) -> Numbers<'py> {
        PyArray1::from_slice(py, self.window.boxes().as_flattened().as_flattened())
    }

    fn first_positions<'py>(&self, py: Python<'py>) -> Numbers<'py> {
        PyArray1::from_iter(py, self.window.first_positions().flatten())
    }

    #[getter]
    const fn skin(&self) -> f64 {
        self.window.skin()
    }

    fn equals(&self, other: &Self) -> bool {
        self.window == other.window
    }
}

type Bytes<'py> = Bound<'py, PyArray1<u8>>;
type DemandsRow<'py> = (Indices<'py>, Numbers<'py>, Bytes<'py>, Indices<'py>, Bytes<'py>);

/// A part of a surface that windows are cut from.
#[pyclass(module = "diffuse_contact._native")]
pub struct Part {
    part: SurfacePart,
}

#[pymethods]
impl Part {
    /// `known`: a box; `symmetry`: a point and a normal in turn.
    #[new]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        positions: &Rows<'_>,
        node_numbers: &Indices<'_>,
        corners: &Bound<'_, PyArray2<i64>>,
        facet_numbers: &Indices<'_>,
        owned: &Bound<'_, PyArray1<bool>>,
        known: Box3,
        extents: ExtentsRow,
        options: Options,
        symmetry: &Rows<'_>,
    ) -> PyResult<Self> {
        let (positions, owned) = (readable(positions)?, readable(owned)?);
        let (node_numbers, facet_numbers) =
            (names(py, "node_numbers", node_numbers)?, names(py, "facet_numbers", facet_numbers)?);
        let facets = facets(py, &readable(corners)?)?;
        let part = PartFacets {
            positions: points(py, &positions)?,
            node_numbers: &node_numbers,
            facets: &facets,
            facet_numbers: &facet_numbers,
            owned: slice(py, &owned)?,
            known,
            extents: extents_of(extents),
        };
        let options = options.interface(py, false)?;
        let planes = planes(py, symmetry)?;
        let part = threads::attempt(py, || SurfacePart::new(&part, &options, &planes))?;
        Ok(Self { part })
    }

    /// Nodes, factors of their domains, whether these may shrink, facets, what they carry.
    fn demands<'py>(slf: &Bound<'py, Self>) -> PyResult<DemandsRow<'py>> {
        let py = slf.py();
        let this = slf.try_borrow().map_err(|_| busy(py))?;
        let PartDemands { nodes, factors, crowded, facets, bases } = this.part.demands();
        Ok((
            numbers(py, nodes),
            PyArray1::from_vec(py, factors),
            PyArray1::from_vec(py, crowded),
            numbers(py, facets),
            PyArray1::from_vec(py, bases),
        ))
    }

    /// Takes over what other parts ask for; whether domains are settled, or there is another round.
    fn settle(slf: &Bound<'_, Self>, others: Vec<DemandsRow<'_>>) -> PyResult<bool> {
        let py = slf.py();
        let mut this = slf.try_borrow_mut().map_err(|_| busy(py))?;
        let demands = |(nodes, factors, crowded, facets, bases): &DemandsRow<'_>| -> PyResult<PartDemands> {
            let (factors, crowded, bases) = (readable(factors)?, readable(crowded)?, readable(bases)?);
            Ok(PartDemands {
                nodes: names(py, "nodes", nodes)?,
                factors: slice(py, &factors)?.to_vec(),
                crowded: slice(py, &crowded)?.to_vec(),
                facets: names(py, "facets", facets)?,
                bases: slice(py, &bases)?.to_vec(),
            })
        };
        let others: Vec<PartDemands> = others.iter().map(demands).collect::<PyResult<_>>()?;
        let part = &mut this.part;
        threads::attempt(py, || part.settle(&others))
    }

    /// What slaves in these boxes can need of the own facets.
    fn window(slf: &Bound<'_, Self>, positions: &Rows<'_>, boxes: &Rows<'_>, skin: f64) -> PyResult<Window> {
        let py = slf.py();
        let this = slf.try_borrow().map_err(|_| busy(py))?;
        let (positions, boxes) = (readable(positions)?, readable(boxes)?);
        let (positions, boxes) = (points(py, &positions)?, boxes_of(py, &boxes)?);
        let part = &this.part;
        let window = threads::attempt(py, || part.window(positions, &boxes, skin))?;
        Ok(Window { window })
    }
}

fn busy(py: Python<'_>) -> PyErr {
    errors::busy(py, "the part of a surface")
}

#[pymethods]
impl Interface {
    /// Of slaves that know a window of the master only; arguments as of `new`.
    #[staticmethod]
    #[pyo3(signature = (window, slaves, positions, slave_facets, options, equations))]
    fn in_window(
        py: Python<'_>,
        window: &Window,
        slaves: &Indices<'_>,
        positions: &Rows<'_>,
        slave_facets: Option<&Bound<'_, PyArray2<i64>>>,
        options: Options,
        equations: Equations<'_>,
    ) -> PyResult<Self> {
        let slaves = indices(py, "slaves", &readable(slaves)?)?;
        let positions = readable(positions)?;
        let positions = points(py, &positions)?;
        let options = options.interface(py, slave_facets.is_some())?;
        let slave_facets = slave_facets.map(|array| facets(py, &readable(array)?)).transpose()?;
        let slave_facets = slave_facets.unwrap_or_default();
        let dofs = dofs_of(py, equations, positions.len())?;
        let window = &window.window;
        let interface = threads::attempt(py, || {
            ContactInterface::in_window(window, slaves, &slave_facets, positions, options)
        })?;
        Ok(Self::of(interface, dofs))
    }

    /// What slaves in these boxes can need of the master surface.
    fn window(slf: &Bound<'_, Self>, boxes: &Rows<'_>, skin: f64) -> PyResult<Window> {
        let py = slf.py();
        let this = shared(slf)?;
        let boxes = readable(boxes)?;
        let boxes = boxes_of(py, &boxes)?;
        let interface = &this.interface;
        let window = threads::attempt(py, || interface.window(&boxes, skin))?;
        Ok(Window { window })
    }

    /// Whether there is a window of the master surface only.
    fn is_in_window(slf: &Bound<'_, Self>) -> PyResult<bool> {
        Ok(shared(slf)?.interface.is_in_window())
    }
}
