//! Options by name.

use diffuse_contact::assembly::Tangent;
use diffuse_contact::interface::{ContactElement, InterfaceOptions};
use diffuse_contact::neighbourhood::{NeighbourRule, SearchOptions};
use diffuse_contact::pairing::DEFAULT_NEIGHBOURS;
use diffuse_contact::{Basis, FrameDerivative, Mode, Weight};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors;

/// The value that goes by this name.
pub fn named<T: Copy>(py: Python<'_>, option: &str, name: &str, values: &[(&str, T)]) -> PyResult<T> {
    if let Some((_, value)) = values.iter().find(|(known, _)| *known == name) {
        return Ok(*value);
    }
    let names: Vec<String> = values.iter().map(|(known, _)| format!("\"{known}\"")).collect();
    let message = format!("{option} has to be one of {}, not \"{name}\"", names.join(", "));
    Err(errors::input(py, "invalid-option", &message))
}

pub fn mode(py: Python<'_>, name: &str) -> PyResult<Mode> {
    let modes = [("value", Mode::Value), ("gradient", Mode::Gradient), ("hessian", Mode::Hessian)];
    named(py, "mode", name, &modes)
}

pub fn weight(py: Python<'_>, name: &str) -> PyResult<Weight> {
    named(py, "weight", name, &Weight::ALL.map(|weight| (weight.name(), weight)))
}

pub fn basis(py: Python<'_>, name: &str) -> PyResult<Basis> {
    named(py, "basis", name, &[Basis::Quadratic, Basis::Linear].map(|basis| (basis.name(), basis)))
}

pub fn frame_derivative(py: Python<'_>, name: &str) -> PyResult<FrameDerivative> {
    let rules = [("co-moving", FrameDerivative::CoMoving), ("held", FrameDerivative::Held)];
    named(py, "frame_derivative", name, &rules)
}

/// The options of an interface, attributes of the Python object `diffuse_contact.Options`.
#[derive(FromPyObject)]
pub struct Options {
    element: String,
    weight: String,
    frame_derivative: String,
    rule: String,
    layers: Option<usize>,
    max_layers: usize,
    neighbours: usize,
    max_neighbours: usize,
    basis: String,
    linear_fallback: bool,
    smallest_regularity: f64,
    radius_factor: f64,
    candidates: usize,
    max_candidates: usize,
    feature_angle: f64,
    border_tolerance: f64,
    distance_limit: Option<f64>,
}

impl Options {
    /// What the interface takes; its ranges are checked there.
    pub fn interface(&self, py: Python<'_>, areas: bool) -> PyResult<InterfaceOptions> {
        let (layers, max_layers) = (self.layers, self.max_layers);
        let (count, max_count) = (self.neighbours, self.max_neighbours);
        let rules = [
            ("hull-layers", NeighbourRule::HullLayers { layers, max_layers }),
            ("hull-radius", NeighbourRule::HullRadius { layers, max_layers }),
            ("nearest", NeighbourRule::Nearest { count, max_count }),
            ("domains", NeighbourRule::Domains),
        ];
        let search = SearchOptions::default()
            .with_rule(named(py, "rule", &self.rule, &rules)?)
            .with_basis(basis(py, &self.basis)?)
            .with_linear_fallback(self.linear_fallback)
            .with_smallest_regularity(self.smallest_regularity)
            .with_radius_factor(self.radius_factor)
            .with_candidates(self.candidates)
            .with_max_candidates(self.max_candidates);
        let frame = frame_derivative(py, &self.frame_derivative)?;
        let diffuse =
            ContactElement::diffuse(search).with_weight(weight(py, &self.weight)?).with_frame(frame);
        let elements = [("diffuse", diffuse), ("node-to-facet", ContactElement::NodeToFacet)];
        Ok(InterfaceOptions::default()
            .with_element(named(py, "element", &self.element, &elements)?)
            .with_feature_angle_degrees(self.feature_angle)
            .with_border_tolerance(self.border_tolerance)
            .with_distance_limit(self.distance_limit)
            .with_areas(areas))
    }
}

/// Whether the words of options are known ones.
#[pyfunction]
pub fn check_options(py: Python<'_>, options: Options) -> PyResult<()> {
    options.interface(py, false).map(drop)
}

/// The defaults of the Rust library, with which those of `diffuse_contact.Options` are compared.
#[pyfunction]
pub fn default_options(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let InterfaceOptions { feature_angle_degrees, border_tolerance, distance_limit, .. } =
        InterfaceOptions::default();
    let SearchOptions {
        basis,
        linear_fallback,
        smallest_regularity,
        radius_factor,
        candidates,
        max_candidates,
        ..
    } = SearchOptions::default();
    let dict = PyDict::new(py);
    dict.set_item("weight", Weight::default().name())?;
    if let ContactElement::Diffuse { search, .. } = ContactElement::default() {
        let rule = match search.rule {
            NeighbourRule::Domains => "domains",
            NeighbourRule::HullLayers { .. } => "hull-layers",
            NeighbourRule::HullRadius { .. } => "hull-radius",
            _ => "nearest",
        };
        dict.set_item("rule", rule)?;
    }
    if let NeighbourRule::HullLayers { layers, max_layers } = NeighbourRule::default() {
        dict.set_item("layers", layers)?;
        dict.set_item("max_layers", max_layers)?;
    }
    if let NeighbourRule::Nearest { count, max_count } = NeighbourRule::nearest(DEFAULT_NEIGHBOURS) {
        dict.set_item("neighbours", count)?;
        dict.set_item("max_neighbours", max_count)?;
    }
    dict.set_item("basis", basis.name())?;
    dict.set_item("linear_fallback", linear_fallback)?;
    dict.set_item("smallest_regularity", smallest_regularity)?;
    dict.set_item("radius_factor", radius_factor)?;
    dict.set_item("candidates", candidates)?;
    dict.set_item("max_candidates", max_candidates)?;
    dict.set_item("feature_angle", feature_angle_degrees)?;
    dict.set_item("border_tolerance", border_tolerance)?;
    dict.set_item("distance_limit", distance_limit)?;
    Ok(dict)
}

pub fn tangent(py: Python<'_>, name: &str) -> PyResult<Tangent> {
    named(py, "tangent", name, &Tangent::ALL.map(|tangent| (tangent.name(), tangent)))
}

/// The name of the tangent for the next linear solution.
#[pyfunction]
pub fn adaptive_tangent(residual: f64, force: f64) -> &'static str {
    Tangent::adaptive(residual, force).name()
}
