//! `ContactInterface`: pairing, evaluation, results. Residual and tangent are in [`assembly`](crate::assembly).

use diffuse_contact::assembly::DofMap;
use diffuse_contact::interface::{
    ContactInterface, ContactRef, Contacts, Cutback, InterfaceError, Outcome, PairedElement, RefreshReport,
};
use diffuse_contact::neighbourhood::Fallback;
use diffuse_contact::surface::SymmetryPlane;
use diffuse_contact::{Mode, Point};
use numpy::{PyArray1, PyArray2};
use pyo3::PyClass;
use pyo3::prelude::*;
use pyo3::pyclass::boolean_struct::False;
use pyo3::types::{PyDict, PyList};

use crate::arrays::{Indices, Numbers, facets, indices, points, readable, words};
use crate::errors::{self, Raise};
use crate::options::{self, Options};
use crate::pattern::Pattern;
use crate::surface::Surface;
use crate::{report, threads};

/// A contact interface, and what belongs to its present pairing.
#[pyclass(module = "diffuse_contact._native")]
pub struct Interface {
    pub interface: ContactInterface,
    pub dofs: DofMap,
    /// The union pattern, once it has been asked for: of the lists of nodes of then.
    pub pattern: Option<Pattern>,
    /// Whether the contacts are those of the present pairing and positions.
    pub current: bool,
    /// Which slaves penetrated.
    cutback: Cutback,
    /// Whether a refresh leaves the pairing as it is.
    frozen: bool,
}

/// Write access for this thread alone.
pub fn exclusive<'py, T: PyClass<Frozen = False>>(object: &Bound<'py, T>) -> PyResult<PyRefMut<'py, T>> {
    object.try_borrow_mut().map_err(|_| errors::busy(object.py(), "the interface"))
}

/// Read access while no thread writes.
pub fn shared<'py, T: PyClass>(object: &Bound<'py, T>) -> PyResult<PyRef<'py, T>> {
    object.try_borrow().map_err(|_| errors::busy(object.py(), "the interface"))
}

impl Interface {
    /// One that has not been paired.
    pub fn of(interface: ContactInterface, dofs: DofMap) -> Self {
        let cutback = Cutback::new(interface.slaves().len());
        Self { interface, dofs, pattern: None, current: false, cutback, frozen: false }
    }

    /// The contacts at the present positions.
    pub fn contacts(&self, py: Python<'_>) -> PyResult<&Contacts> {
        if self.current {
            return Ok(self.interface.contacts());
        }
        let message = "there is no evaluation at the present positions and pairing: call evaluate() first";
        Err(errors::exception(py, "InterfaceError", "not-evaluated", message))
    }

    /// The `k`-th contact.
    fn contact_at(&self, py: Python<'_>, k: usize) -> PyResult<ContactRef<'_>> {
        let contacts = self.contacts(py)?;
        self.check_slave(py, k)?;
        Ok(contacts.get(k))
    }

    fn check_slave(&self, py: Python<'_>, k: usize) -> PyResult<()> {
        let count = self.interface.slaves().len();
        if k < count {
            return Ok(());
        }
        let message = format!("there is no slave number {k}, there are {count}");
        Err(errors::input(py, "no-such-slave", &message))
    }
}

/// Number of equations, and those of each node's axes, if they are given.
pub type Equations<'py> = Option<(usize, Bound<'py, PyArray2<i64>>)>;

/// Equations as given, or 3·node + axis.
pub fn dofs_of(py: Python<'_>, equations: Equations<'_>, nodes: usize) -> PyResult<DofMap> {
    match equations {
        Some((count, numbers)) => dof_map(py, count, &numbers, nodes),
        None => Ok(DofMap::standard(nodes)),
    }
}

/// Planes from a point and a normal in turn.
pub fn planes(py: Python<'_>, symmetry: &Bound<'_, PyArray2<f64>>) -> PyResult<Vec<SymmetryPlane>> {
    let symmetry = readable(symmetry)?;
    let (planes, _) = points(py, &symmetry)?.as_chunks::<2>();
    Ok(planes.iter().map(|&[point, normal]| SymmetryPlane { point, normal }).collect())
}

fn with_planes(
    mut interface: ContactInterface,
    planes: &[SymmetryPlane],
) -> Result<ContactInterface, InterfaceError> {
    if !planes.is_empty() {
        interface.set_symmetry(planes)?;
    }
    Ok(interface)
}

#[pymethods]
impl Interface {
    /// `equations`: number, and those of each node's axes, −1 where there is none; `None` for 3·node + axis. `symmetry`: a point
    /// and a normal in turn.
    #[new]
    #[pyo3(signature = (master, slaves, positions, slave_facets, options, equations, symmetry))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        master: &Surface,
        slaves: &Indices<'_>,
        positions: &Bound<'_, PyArray2<f64>>,
        slave_facets: Option<&Bound<'_, PyArray2<i64>>>,
        options: Options,
        equations: Equations<'_>,
        symmetry: &Bound<'_, PyArray2<f64>>,
    ) -> PyResult<Self> {
        let slaves = indices(py, "slaves", &readable(slaves)?)?;
        let positions = readable(positions)?;
        let positions = points(py, &positions)?;
        let areas = slave_facets.is_some();
        let slave_facets = slave_facets.map(|array| facets(py, &readable(array)?)).transpose()?;
        let slave_facets = slave_facets.unwrap_or_default();
        let options = options.interface(py, areas)?;
        let dofs = dofs_of(py, equations, positions.len())?;
        let planes = planes(py, symmetry)?;
        let master = master.surface.clone();
        let interface = threads::attempt(py, || {
            with_planes(ContactInterface::new(master, slaves, &slave_facets, positions, options)?, &planes)
        })?;
        Ok(Self::of(interface, dofs))
    }

    /// Of a surface in contact with itself.
    #[staticmethod]
    #[pyo3(signature = (surface, positions, areas, options, equations, symmetry))]
    fn self_contact(
        py: Python<'_>,
        surface: &Surface,
        positions: &Bound<'_, PyArray2<f64>>,
        areas: bool,
        options: Options,
        equations: Equations<'_>,
        symmetry: &Bound<'_, PyArray2<f64>>,
    ) -> PyResult<Self> {
        let positions = readable(positions)?;
        let positions = points(py, &positions)?;
        let options = options.interface(py, areas)?;
        let dofs = dofs_of(py, equations, positions.len())?;
        let planes = planes(py, symmetry)?;
        let surface = surface.surface.clone();
        let interface = threads::attempt(py, || {
            with_planes(ContactInterface::self_contact(surface, positions, options)?, &planes)
        })?;
        Ok(Self::of(interface, dofs))
    }

    fn slaves<'py>(slf: &Bound<'py, Self>) -> PyResult<Indices<'py>> {
        let this = shared(slf)?;
        Ok(PyArray1::from_iter(slf.py(), this.interface.slaves().iter().map(|&node| node as i64)))
    }

    fn refresh_pairing<'py>(
        slf: &Bound<'py, Self>,
        positions: &Bound<'py, PyArray2<f64>>,
        renew: bool,
    ) -> PyResult<Bound<'py, PyDict>> {
        let py = slf.py();
        let mut this = exclusive(slf)?;
        let positions = readable(positions)?;
        let positions = points(py, &positions)?;
        let frozen = this.frozen;
        let Interface { interface, cutback, current, .. } = &mut *this;
        let report = threads::attempt(py, || match (frozen, renew) {
            (true, _) => interface.update(positions).map(|()| RefreshReport::default()),
            (false, false) => interface.refresh_pairing(positions),
            (false, true) => interface.renew_pairing(positions),
        })?;
        *current = false;
        if !frozen {
            threads::attempt(py, || cutback.begin(interface))?;
        }
        let dict = report::to_dict(py, &report)?;
        dict.set_item("frozen", frozen)?;
        Ok(dict)
    }

    /// Whether refreshes leave the pairing as it is.
    #[getter]
    fn frozen(slf: &Bound<'_, Self>) -> PyResult<bool> {
        Ok(shared(slf)?.frozen)
    }

    /// Holds the pairing, or ends that.
    fn set_frozen(slf: &Bound<'_, Self>, frozen: bool) -> PyResult<()> {
        exclusive(slf)?.frozen = frozen;
        Ok(())
    }

    fn update(slf: &Bound<'_, Self>, positions: &Bound<'_, PyArray2<f64>>) -> PyResult<()> {
        let py = slf.py();
        let mut this = exclusive(slf)?;
        let positions = readable(positions)?;
        let positions = points(py, &positions)?;
        let interface = &mut this.interface;
        threads::attempt(py, || interface.update(positions))?;
        this.current = false;
        Ok(())
    }

    /// Whether lists are others now; never while the interface is frozen.
    fn follow(slf: &Bound<'_, Self>, positions: &Bound<'_, PyArray2<f64>>) -> PyResult<bool> {
        let py = slf.py();
        let mut this = exclusive(slf)?;
        let positions = readable(positions)?;
        let positions = points(py, &positions)?;
        let (frozen, interface) = (this.frozen, &mut this.interface);
        let rebuilt = threads::attempt(py, || {
            if frozen { interface.update(positions).map(|()| false) } else { interface.follow(positions) }
        })?;
        this.current = false;
        Ok(rebuilt)
    }

    fn evaluate(slf: &Bound<'_, Self>, mode: &str) -> PyResult<()> {
        let py = slf.py();
        let mode = options::mode(py, mode)?;
        let mut this = exclusive(slf)?;
        this.current = false;
        let interface = &mut this.interface;
        threads::attempt(py, || interface.evaluate(mode).map(|_| ()))?;
        let this = &mut *this;
        this.cutback.book(this.interface.contacts());
        this.current = true;
        Ok(())
    }

    /// Gap, foot, normal, area of every slave; NaN where there is no contact, except for the area.
    fn points<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Numbers<'py>, Numbers<'py>, Numbers<'py>, Numbers<'py>)> {
        let py = slf.py();
        let this = shared(slf)?;
        let contacts = this.contacts(py)?;
        let vectors = |of: &dyn Fn(ContactRef<'_>) -> Point| {
            let vector = |contact: ContactRef<'_>| {
                if contact.outcome.is_contact() { of(contact) } else { [f64::NAN; 3] }
            };
            PyArray1::from_vec(py, contacts.iter().flat_map(vector).collect())
        };
        let gap = |contact: ContactRef<'_>| match contact.outcome {
            Outcome::Contact { .. } => contact.point.gap,
            Outcome::None(_) => f64::NAN,
        };
        Ok((
            PyArray1::from_iter(py, contacts.iter().map(gap)),
            vectors(&|contact| contact.point.foot),
            vectors(&|contact| contact.point.normal),
            PyArray1::from_iter(py, contacts.iter().map(|contact| contact.area)),
        ))
    }

    /// The code of every slave's outcome.
    fn outcomes<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyList>> {
        let (py, this) = (slf.py(), shared(slf)?);
        words(py, this.contacts(py)?.iter().map(|contact| contact.outcome.code()))
    }

    /// One contact with its derivatives.
    fn contact<'py>(slf: &Bound<'py, Self>, k: usize) -> PyResult<Bound<'py, PyDict>> {
        let py = slf.py();
        let this = shared(slf)?;
        let contact = this.contact_at(py, k)?;
        let dict = PyDict::new(py);
        dict.set_item("slave", contact.slave)?;
        dict.set_item("masters", PyArray1::from_iter(py, contact.nodes.iter().map(|&node| i64::from(node))))?;
        dict.set_item("outcome", contact.outcome.code())?;
        let (reason, fallback) = match contact.outcome {
            Outcome::Contact { fallback } => (None, Some(fallback_name(fallback))),
            Outcome::None(reason) => (Some(reason.to_string()), None),
        };
        dict.set_item("reason", reason)?;
        dict.set_item("fallback", fallback)?;
        dict.set_item("area", contact.area)?;
        let result = contact.outcome.is_contact().then_some(contact.point);
        dict.set_item("gap", result.map(|point| point.gap))?;
        dict.set_item("foot", result.map(|point| PyArray1::from_slice(py, &point.foot)))?;
        dict.set_item("normal", result.map(|point| PyArray1::from_slice(py, &point.normal)))?;
        let mode = this.interface.contacts().mode();
        let wanted = |least: Mode| result.is_some() && mode >= least;
        let array = |numbers, wanted: bool| wanted.then(|| PyArray1::from_slice(py, numbers));
        dict.set_item("gradient", array(contact.gradient, wanted(Mode::Gradient)))?;
        dict.set_item("hessian", array(contact.hessian, wanted(Mode::Hessian)))?;
        Ok(dict)
    }

    /// What one slave is paired with.
    fn pairing<'py>(slf: &Bound<'py, Self>, k: usize) -> PyResult<Bound<'py, PyDict>> {
        let py = slf.py();
        let this = shared(slf)?;
        this.check_slave(py, k)?;
        let reason = |reason: diffuse_contact::interface::NoContact| {
            errors::exception(py, "InterfaceError", reason.code(), &reason.to_string())
        };
        let dict = PyDict::new(py);
        match this.interface.element(k).map_err(reason)? {
            PairedElement::Diffuse { pairing, .. } => {
                let frame = pairing.frame.rows();
                dict.set_item("masters", PyArray1::from_iter(py, pairing.masters.iter().map(|&k| k as i64)))?;
                if !pairing.others.is_empty() {
                    let nodes = pairing.others.iter().map(|&(node, _)| node as i64);
                    let parts = pairing.others.iter().map(|&(_, part)| part);
                    dict.set_item("others", PyArray1::from_iter(py, nodes))?;
                    dict.set_item("parts", PyArray1::from_iter(py, parts))?;
                }
                dict.set_item("positions", PyArray1::from_slice(py, pairing.positions.as_flattened()))?;
                dict.set_item("frame", PyArray1::from_slice(py, frame.as_flattened()))?;
                dict.set_item("support_radius", pairing.support_radius)?;
                if !pairing.material.is_empty() {
                    let offsets = pairing.material.iter().flat_map(|node| node.offset);
                    let metrics = pairing.material.iter().flat_map(|node| node.metric);
                    dict.set_item("offsets", PyArray1::from_iter(py, offsets))?;
                    dict.set_item("metrics", PyArray1::from_iter(py, metrics))?;
                }
                dict.set_item("basis", pairing.basis.name())?;
            }
            PairedElement::Facet { corners, .. } => {
                dict.set_item("positions", PyArray1::from_slice(py, corners.as_flattened()))?;
            }
        }
        Ok(dict)
    }

    /// Factor, slave and outcome of the cut-back hint.
    fn cut_back(slf: &Bound<'_, Self>, limit: f64) -> PyResult<(f64, Option<(usize, &'static str)>)> {
        let py = slf.py();
        if !(limit > 0.0 && limit.is_finite()) {
            let message = format!("the limit must be positive and finite, not {limit}");
            return Err(errors::input(py, "invalid-option", &message));
        }
        let this = shared(slf)?;
        this.contacts(py)?;
        let hint = this.cutback.hint(&this.interface, limit);
        Ok((hint.factor, hint.cause.map(|(slave, outcome)| (slave, outcome.code()))))
    }
}

fn fallback_name(fallback: Fallback) -> &'static str {
    match fallback {
        Fallback::None => "none",
        Fallback::Extended { .. } => "extended",
        Fallback::Linear { .. } => "linear",
        _ => "other",
    }
}

fn dof_map(
    py: Python<'_>,
    count: usize,
    numbers: &Bound<'_, PyArray2<i64>>,
    nodes: usize,
) -> PyResult<DofMap> {
    let numbers = readable(numbers)?;
    let (rows, rest) = crate::arrays::slice(py, &numbers)?.as_chunks::<3>();
    if rows.len() != nodes || !rest.is_empty() {
        let message = format!("dofs have {} rows of three, but there are {nodes} positions", rows.len());
        return Err(errors::input(py, "wrong-shape", &message));
    }
    let equation = |number: i64| match number {
        -1 => Ok(None),
        number => usize::try_from(number).map(Some).map_err(|_| {
            let message = format!("dofs: {number} is no equation, and only −1 says that there is none");
            errors::input(py, "negative-index", &message)
        }),
    };
    let row = |row: &[i64; 3]| Ok([equation(row[0])?, equation(row[1])?, equation(row[2])?]);
    let rows: Vec<[Option<usize>; 3]> = rows.iter().map(row).collect::<PyResult<_>>()?;
    DofMap::new(count, rows).map_err(|error| error.raise(py))
}
