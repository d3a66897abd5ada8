//! `FaceInterface`: contact integrated over the slave's faces.

use diffuse_contact::Point;
use diffuse_contact::assembly::{DofMap, Tangent};
use diffuse_contact::faces::{
    FaceContacts, FaceInterface, FaceOptions, FacePressures, FaceReport, FaceRule, IntegrationPoint,
    NodeContact, QuadraticFace,
};
use diffuse_contact::interface::InterfaceError;
use diffuse_contact::surface::Facet;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyList;

use crate::arrays::{
    Indices, Numbers, facets, of_triplets, points, quadratic_faces, readable, slice, slice_mut, words,
    writable,
};
use crate::errors::{self, Raise};
use crate::interface::{Equations, dofs_of, exclusive, planes, shared};
use crate::law::Law;
use crate::options::{self, Options};
use crate::surface::Surface;
use crate::threads;
use crate::window::Window;

/// The flat facets of faces of second order: rows of four corners, the last one −1 for a triangle.
#[pyfunction]
pub fn flat_facets<'py>(py: Python<'py>, faces: &Bound<'py, PyArray2<i64>>) -> PyResult<Indices<'py>> {
    let faces = quadratic_faces(py, std::slice::from_ref(faces))?;
    let row = |facet: Facet| match facet {
        Facet::Triangle([a, b, c]) => [a as i64, b as i64, c as i64, -1],
        Facet::Quadrilateral(corners) => corners.map(|node| node as i64),
    };
    Ok(PyArray1::from_iter(py, faces.iter().flat_map(QuadraticFace::facets).flat_map(row)))
}

/// An interface of faces, and whether its contacts are those of the present positions.
#[pyclass(module = "diffuse_contact._native")]
pub struct Faces {
    pub interface: FaceInterface,
    dofs: DofMap,
    pub current: bool,
}

/// With the rule of this degree, and pressures of these.
fn face_options(py: Python<'_>, options: Options, degree: usize, pressures: &str) -> PyResult<FaceOptions> {
    let rule = FaceRule::ALL.into_iter().find(|rule| rule.degree() == degree).ok_or_else(|| {
        errors::input(py, "invalid-option", &format!("degree has to be 2 or 4, not {degree}"))
    })?;
    let known = FacePressures::ALL.map(|own| (own.name(), own));
    let pressures = options::named(py, "pressures", pressures, &known)?;
    Ok(FaceOptions::new(options.interface(py, false)?).with_rule(rule).with_pressures(pressures))
}

impl Faces {
    fn contacts(&self, py: Python<'_>) -> PyResult<&FaceContacts> {
        if self.current {
            return Ok(self.interface.contacts());
        }
        let message = "there is no evaluation at the present positions: call evaluate() first";
        Err(errors::exception(py, "InterfaceError", "not-evaluated", message))
    }
}

#[pymethods]
impl Faces {
    /// `faces`: of the slave, without them the surface is in contact with itself. `degree`: of the rule on each piece of a face, `pressures`:
    /// where they follow from gaps; the rest as of `Interface`.
    #[new]
    #[pyo3(signature = (master, faces, positions, options, degree, pressures, equations, symmetry, quadratic))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        master: &Surface,
        faces: Option<&Bound<'_, PyArray2<i64>>>,
        positions: &Bound<'_, PyArray2<f64>>,
        options: Options,
        degree: usize,
        pressures: &str,
        equations: Equations<'_>,
        symmetry: &Bound<'_, PyArray2<f64>>,
        quadratic: Vec<Bound<'_, PyArray2<i64>>>,
    ) -> PyResult<Self> {
        let faces = faces.map(|faces| facets(py, &readable(faces)?)).transpose()?;
        let positions = readable(positions)?;
        let positions = points(py, &positions)?;
        let options = face_options(py, options, degree, pressures)?;
        let dofs = dofs_of(py, equations, positions.len())?;
        let master = master.surface.clone();
        let planes = planes(py, symmetry)?;
        let curved = quadratic_faces(py, &quadratic)?;
        let interface = threads::attempt(py, || -> Result<_, InterfaceError> {
            let mut interface = match &faces {
                Some(faces) => FaceInterface::new(master, faces, positions, options)?,
                None => FaceInterface::self_contact(master, positions, options)?,
            };
            if !curved.is_empty() {
                interface.set_quadratic_faces(&curved)?;
            }
            if !planes.is_empty() {
                interface.set_symmetry(&planes)?;
            }
            Ok(interface)
        })?;
        Ok(Self { interface, dofs, current: false })
    }

    /// Of faces that know windows of both surfaces only.
    #[staticmethod]
    #[pyo3(signature = (master, slave, positions, options, degree, pressures, equations, quadratic))]
    #[allow(clippy::too_many_arguments)]
    fn in_window(
        py: Python<'_>,
        master: &Window,
        slave: &Window,
        positions: &Bound<'_, PyArray2<f64>>,
        options: Options,
        degree: usize,
        pressures: &str,
        equations: Equations<'_>,
        quadratic: [Vec<Bound<'_, PyArray2<i64>>>; 2],
    ) -> PyResult<Self> {
        let positions = readable(positions)?;
        let positions = points(py, &positions)?;
        let options = face_options(py, options, degree, pressures)?;
        let dofs = dofs_of(py, equations, positions.len())?;
        let (master, slave) = (&master.window, &slave.window);
        let [below, above] = quadratic;
        let (below, above) = (quadratic_faces(py, &below)?, quadratic_faces(py, &above)?);
        let interface = threads::attempt(py, || -> Result<_, InterfaceError> {
            let mut interface = FaceInterface::in_window(master, slave, positions, options)?;
            if !(below.is_empty() && above.is_empty()) {
                interface.set_quadratic_faces_by_number(&below, &above)?;
            }
            Ok(interface)
        })?;
        Ok(Self { interface, dofs, current: false })
    }

    /// Whether there are windows of the surfaces only.
    fn is_in_window(slf: &Bound<'_, Self>) -> PyResult<bool> {
        Ok(shared(slf)?.interface.is_in_window())
    }

    fn slaves<'py>(slf: &Bound<'py, Self>) -> PyResult<Indices<'py>> {
        let this = shared(slf)?;
        Ok(PyArray1::from_iter(slf.py(), this.interface.slaves().iter().map(|&node| node as i64)))
    }

    fn straight(slf: &Bound<'_, Self>) -> PyResult<usize> {
        Ok(shared(slf)?.interface.straight())
    }

    /// Takes over positions; `forgets`: whether what nodes couple begins anew. Points, those with masters, faces with points, and
    /// whether more nodes couple.
    fn take(
        slf: &Bound<'_, Self>,
        positions: &Bound<'_, PyArray2<f64>>,
        forgets: bool,
    ) -> PyResult<(usize, usize, usize, bool)> {
        let py = slf.py();
        let mut this = exclusive(slf)?;
        let positions = readable(positions)?;
        let positions = points(py, &positions)?;
        let interface = &mut this.interface;
        let FaceReport { points, paired, faces, grown } = threads::attempt(py, || {
            if forgets { interface.refresh(positions) } else { interface.update(positions) }
        })?;
        this.current = false;
        Ok((points, paired, faces, grown))
    }

    fn evaluate(slf: &Bound<'_, Self>, law: Law<'_>, mode: &str) -> PyResult<()> {
        let py = slf.py();
        let mode = options::mode(py, mode)?;
        let mut this = exclusive(slf)?;
        let own = law.own(py)?;
        let law = own.law(py)?;
        let interface = &mut this.interface;
        let evaluated = threads::run(py, || interface.evaluate(&law, mode).map(|_| ()));
        // Without memory there are no contacts; any other refusal leaves those of before.
        this.current = match &evaluated {
            Ok(()) => true,
            Err(error) => this.current && !matches!(error, InterfaceError::OutOfMemory { .. }),
        };
        evaluated.map_err(|error| error.raise(py))
    }

    /// Traction, state and slip of every node.
    fn friction<'py>(slf: &Bound<'py, Self>) -> PyResult<(Numbers<'py>, Bound<'py, PyList>, Numbers<'py>)> {
        let py = slf.py();
        let this = shared(slf)?;
        let nodes = this.contacts(py)?.nodes();
        Ok((
            PyArray1::from_vec(py, nodes.iter().flat_map(|node| node.friction).collect()),
            words(py, nodes.iter().map(|node| node.friction_state.name()))?,
            PyArray1::from_iter(py, nodes.iter().map(|node| node.slip)),
        ))
    }

    /// Gaps, area, pressure and normal of every node, and its outcome; NaN where there is no contact, but for area and pressure.
    fn nodes<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Numbers<'py>, Numbers<'py>, Numbers<'py>, Numbers<'py>, Bound<'py, PyList>)> {
        let py = slf.py();
        let this = shared(slf)?;
        let nodes = this.contacts(py)?.nodes();
        let normal = |node: &NodeContact| -> Point {
            if node.outcome.is_contact() { node.normal } else { [f64::NAN; 3] }
        };
        let gap = |node: &NodeContact| if node.outcome.is_contact() { node.gap } else { f64::NAN };
        Ok((
            PyArray1::from_iter(py, nodes.iter().map(gap)),
            PyArray1::from_iter(py, nodes.iter().map(|node| node.area)),
            PyArray1::from_iter(py, nodes.iter().map(|node| node.pressure)),
            PyArray1::from_vec(py, nodes.iter().flat_map(normal).collect()),
            words(py, nodes.iter().map(|node| node.outcome.code()))?,
        ))
    }

    /// Of every point with a contact: its face, position, area, gap, normal, pressure and traction.
    fn points<'py>(slf: &Bound<'py, Self>) -> PyResult<(Indices<'py>, [Numbers<'py>; 6])> {
        let py = slf.py();
        let this = shared(slf)?;
        this.contacts(py)?;
        let interface = &this.interface;
        let points = threads::attempt(py, || interface.integration_points())?;
        let numbers =
            |of: fn(&IntegrationPoint) -> f64| PyArray1::from_vec(py, points.iter().map(of).collect());
        let vectors =
            |of: fn(&IntegrationPoint) -> Point| PyArray1::from_vec(py, points.iter().flat_map(of).collect());
        Ok((
            PyArray1::from_iter(py, points.iter().map(|point| point.face as i64)),
            [
                vectors(|point| point.position),
                numbers(|point| point.area),
                numbers(|point| point.gap),
                vectors(|point| point.normal),
                numbers(|point| point.pressure),
                vectors(|point| point.friction),
            ],
        ))
    }

    /// Number of equations.
    fn equations(slf: &Bound<'_, Self>) -> PyResult<usize> {
        Ok(shared(slf)?.dofs.equations())
    }

    /// Adds the contact forces on the nodes; returns the number of nodes that carry pressure.
    fn add_forces(slf: &Bound<'_, Self>, forces: &Numbers<'_>) -> PyResult<usize> {
        let py = slf.py();
        let this = shared(slf)?;
        let mut forces = writable(forces)?;
        let forces = slice_mut(py, &mut forces)?;
        let (contacts, dofs) = (this.contacts(py)?, &this.dofs);
        threads::attempt(py, || contacts.add_forces(dofs, forces))
    }

    /// Nodes that couple: offsets of the cliques, and their nodes.
    fn cliques<'py>(slf: &Bound<'py, Self>) -> PyResult<(Indices<'py>, Indices<'py>)> {
        let py = slf.py();
        let this = shared(slf)?;
        let (mut offsets, mut nodes) = (vec![0], Vec::new());
        for clique in this.interface.cliques() {
            nodes.extend(clique.iter().map(|&node| i64::from(node)));
            offsets.push(nodes.len() as i64);
        }
        Ok((PyArray1::from_vec(py, offsets), PyArray1::from_vec(py, nodes)))
    }

    /// Points of loaded faces that carry no force.
    fn missed(slf: &Bound<'_, Self>) -> PyResult<usize> {
        let this = shared(slf)?;
        Ok(this.contacts(slf.py())?.missed())
    }

    /// Adds K v.
    fn add_product(
        slf: &Bound<'_, Self>,
        tangent: &str,
        v: &Numbers<'_>,
        product: &Numbers<'_>,
    ) -> PyResult<()> {
        let py = slf.py();
        let this = shared(slf)?;
        let tangent: Tangent = options::tangent(py, tangent)?;
        let v = readable(v)?;
        let v = slice(py, &v)?;
        let mut product = writable(product)?;
        let product = slice_mut(py, &mut product)?;
        let (contacts, dofs) = (this.contacts(py)?, &this.dofs);
        threads::attempt(py, || contacts.add_product(tangent, dofs, v, product))
    }

    /// Rows, columns and values of the tangent, to be summed.
    fn triplets<'py>(
        slf: &Bound<'py, Self>,
        tangent: &str,
    ) -> PyResult<(Indices<'py>, Indices<'py>, Numbers<'py>)> {
        let py = slf.py();
        let this = shared(slf)?;
        let tangent: Tangent = options::tangent(py, tangent)?;
        let (contacts, dofs) = (this.contacts(py)?, &this.dofs);
        let triplets = threads::attempt(py, || contacts.triplets(tangent, dofs))?;
        Ok(of_triplets(py, &triplets))
    }
}
