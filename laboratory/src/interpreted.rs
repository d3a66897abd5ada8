//! The backend that evaluates the formulas' expression graph as it stands: the second witness of every kernel.
//!
//! [`Interpreted`] shares the derivation with the generated kernels, and nothing after it: the graph is neither
//! lowered nor scheduled nor printed, and its systems, roots and sums are evaluated by the interpreter's own
//! methods. Against it a kernel shows errors of emission; it shows errors of derivation against
//! [`Ad`](diffuse_contact::ad::Ad). It takes any number of master nodes and any weight, and its speed is no aim.

pub(crate) mod evaluation;

use std::sync::OnceLock;

use diffuse_contact::{
    Backend, Coefficients, ContactPoint, Domains, Element, ElementError, FootDerivatives, FrameDerivative,
    Gap, Mode, Point, Slip, Surface,
};
use diffuse_contact_codegen::interpret::{Interpreter, NodeInputs};
use diffuse_contact_codegen::{self as codegen, FrameRule, Kernel, KernelSpec, Output, Weight};
use diffuse_contact_kernels::support::{CoefficientsValues, SurfaceValues};
use evaluation::Evaluation;

const OUTPUTS: usize = Output::ALL.len();
const MODES: usize = codegen::Mode::ALL.len();
const BASES: usize = codegen::Basis::ALL.len();
const FRAMES: usize = FrameRule::ALL.len();

/// Evaluates elements by interpreting the graph the kernels are generated from. [`Element::weight`] is ignored: the
/// weight is the one given to [`Interpreted::new`].
///
/// The graph of an output, mode, basis and frame rule is built when it is first needed and kept.
#[derive(Debug)]
pub struct Interpreted {
    weight: Weight,
    kernels: [OnceLock<Kernel<KernelSpec>>; OUTPUTS * MODES * BASES * FRAMES],
}

/// How far an element is from having no result, as dimensionless figures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditioning {
    /// Smallest pivot of the moment matrix over its diagonal entry, 0 for a singular fit: about the slave or about
    /// the surface point, whichever is smaller.
    pub pivot_ratio: f64,
    /// Smallest pivot of the equations for the turn of the average plane over its diagonal entry, 0 if the plane
    /// is not unique; 1 for a frame that is held.
    pub plane_pivot_ratio: f64,
    /// Determinant of the foot equations' Jacobian, 1 on a flat surface and 0 on a centre of curvature.
    pub jacobian_determinant: f64,
    /// In-plane distance of the foot from the slave's projection over the support radius.
    pub foot_distance: f64,
}

impl Default for Interpreted {
    /// The cubic weight (Chamoret et al. 2008, eq. 14).
    fn default() -> Self {
        Self::new(Weight::cubic())
    }
}

impl Interpreted {
    /// A backend with this weight.
    pub fn new(weight: Weight) -> Self {
        Self { weight, kernels: std::array::from_fn(|_| OnceLock::new()) }
    }

    /// The weight at r, of an interpolating weight ω/(1 − ω) that of ω.
    pub fn fitting_weight(&self, r: f64) -> f64 {
        self.weight.fitting_value(r)
    }

    /// The figures that decide whether an element has a gap, and a surface at `point`, and how many digits they are
    /// good for. An element without a gap has figures too.
    ///
    /// # Errors
    /// What [`Element::validate`] finds.
    pub fn conditioning(&self, element: &Element<'_>, point: [f64; 2]) -> Result<Conditioning, ElementError> {
        let inputs = self.inputs(element, point)?;
        let mut surface = self.evaluation(Output::Surface, element, Mode::Value, &inputs)?;
        // Without derivatives nothing is known of the plane.
        let mut gap = self.evaluation(Output::Gap, element, Mode::Gradient, &inputs)?;
        let [about_point, about_slave] = [surface.scalar("pivot_ratio"), gap.scalar("pivot_ratio")];
        Ok(Conditioning {
            pivot_ratio: smaller(about_point, about_slave),
            plane_pivot_ratio: gap.plane_pivot_ratio(),
            jacobian_determinant: gap.scalar("jacobian_determinant"),
            foot_distance: gap.scalar("foot_distance"),
        })
    }

    /// [`inputs`] of an element, if it is valid.
    fn inputs(&self, element: &Element<'_>, point: [f64; 2]) -> Result<NodeInputs, ElementError> {
        element.validate_with(|r| self.fitting_weight(r))?;
        Ok(inputs(element, point))
    }

    fn evaluation<'a>(
        &'a self,
        output: Output,
        element: &Element<'_>,
        mode: Mode,
        inputs: &'a NodeInputs,
    ) -> Result<Evaluation<'a>, ElementError> {
        let (mode, basis) = (mode_of(mode), basis_of(element.basis)?);
        let frame = frame_rule(output, element);
        let place = codegen::Basis::ALL.iter().position(|&known| known == basis).unwrap_or_default();
        let index = ((output as usize * MODES + mode as usize) * BASES + place) * FRAMES + frame as usize;
        let kernel = self.kernels[index].get_or_init(|| {
            Kernel::new(KernelSpec { output, mode, basis, weight: self.weight.clone(), frame })
        });
        Ok(Evaluation {
            kernel,
            interpreter: Interpreter::new(&kernel.graph, inputs),
            count: element.masters.len(),
        })
    }
}

/// The smaller of two figures; NaN if one is.
fn smaller(x: f64, y: f64) -> f64 {
    if x.is_nan() || x < y { x } else { y }
}

impl Backend for Interpreted {
    fn coefficients(&self, element: &Element<'_>, mode: Mode) -> Result<Coefficients, ElementError> {
        let inputs = self.inputs(element, [0.0; 2])?;
        let mut evaluation = self.evaluation(Output::Coefficients, element, mode, &inputs)?;
        let coefficients = evaluation.padded("coefficients");
        ElementError::check(
            CoefficientsValues {
                coefficients,
                pivot_ratio: evaluation.scalar("pivot_ratio"),
                checksum: evaluation.scalar("checksum"),
            }
            .status(),
        )?;
        Ok(Coefficients {
            values: coefficients[..element.basis.size()].to_vec(),
            gradients: evaluation.gradients(),
            hessians: evaluation.hessians(),
        })
    }

    fn surface(&self, element: &Element<'_>, point: [f64; 2], mode: Mode) -> Result<Surface, ElementError> {
        let inputs = self.inputs(element, point)?;
        if !point.iter().all(|x| x.is_finite()) {
            return Err(ElementError::NonFiniteInput { what: "point", index: 0 });
        }
        let mut evaluation = self.evaluation(Output::Surface, element, mode, &inputs)?;
        let values = SurfaceValues {
            value: evaluation.scalar("value"),
            slopes: evaluation.array("slopes"),
            curvatures: evaluation.array("curvatures"),
            pivot_ratio: evaluation.scalar("pivot_ratio"),
            checksum: evaluation.scalar("checksum"),
        };
        ElementError::check(values.status())?;
        let mut gradients = evaluation.gradients().into_iter();
        let mut next = || gradients.next().unwrap_or_default();
        Ok(Surface {
            value: values.value,
            slopes: values.slopes,
            curvatures: values.curvatures,
            gradient: next(),
            slope_gradients: [next(), next()],
            hessian: evaluation.hessians().pop().unwrap_or_default(),
        })
    }

    fn gap(&self, element: &Element<'_>, mode: Mode) -> Result<Gap, ElementError> {
        let inputs = self.inputs(element, [0.0; 2])?;
        let mut evaluation = self.evaluation(Output::Gap, element, mode, &inputs)?;
        let mut gap = evaluation.contact(element)?;
        gap.gradient = evaluation.gradients().pop().unwrap_or_default();
        gap.hessian = evaluation.hessians().pop().unwrap_or_default();
        Ok(gap)
    }

    fn foot_derivatives(&self, element: &Element<'_>) -> Result<FootDerivatives, ElementError> {
        let inputs = self.inputs(element, [0.0; 2])?;
        let mut evaluation = self.evaluation(Output::Gap, element, Mode::Hessian, &inputs)?;
        let Gap { gap, foot, normal, .. } = evaluation.contact(element)?;
        let gradient = evaluation.gradients().pop().unwrap_or_default();
        let by_height = evaluation.combination("height");
        let along = |by: &[f64; 3]| by.iter().zip(element.frame.normal).map(|(x, n)| x * n).sum();
        let weights = by_height[1..].iter().map(along).collect();
        let by_normal =
            ["normal_x", "normal_y", "normal_z"].map(|name| evaluation.combination(name).concat());
        // x^d = x^c − g ν, by the rule of products.
        let by_foot = (0..3).flat_map(|axis| {
            let entry = |k: usize| {
                let of_slave = f64::from(u8::from(k == axis));
                of_slave - normal[axis] * gradient[k] - gap * by_normal[axis][k]
            };
            (0..gradient.len()).map(entry).collect::<Vec<_>>()
        });
        Ok(FootDerivatives {
            point: ContactPoint { gap, foot, normal },
            weights,
            foot: by_foot.collect(),
            normal: by_normal.concat(),
        })
    }

    fn slip(&self, element: &Element<'_>, anchor: Point, mode: Mode) -> Result<Slip, ElementError> {
        let mut inputs = self.inputs(element, [0.0; 2])?;
        set_vector(&mut inputs, "anchor", anchor);
        let mut evaluation = self.evaluation(Output::Slip, element, mode, &inputs)?;
        let mut contact = evaluation.contact(element)?;
        let mut gradients = evaluation.gradients().into_iter();
        let mut hessians = evaluation.hessians().into_iter();
        contact.gradient = gradients.next().unwrap_or_default();
        contact.hessian = hessians.next().unwrap_or_default();
        Ok(Slip {
            contact,
            half_square: evaluation.scalar("slip"),
            gradient: gradients.next().unwrap_or_default(),
            hessian: hessians.next().unwrap_or_default(),
            foot_weights: evaluation.node_values(),
        })
    }
}

const AXES: [&str; 3] = ["x", "y", "z"];

/// Sets the three input symbols of a vector.
pub(crate) fn set_vector(inputs: &mut NodeInputs, name: &str, vector: Point) {
    for (axis, value) in AXES.iter().zip(vector) {
        inputs.set_element(&format!("{name}_{axis}"), value);
    }
}

/// The values of all input symbols; `point` is read by the surface kernels only.
fn inputs(element: &Element<'_>, point: [f64; 2]) -> NodeInputs {
    let mut inputs = NodeInputs::new(element.masters.len());
    let [t1, t2, normal] = element.frame.rows();
    for (name, vector) in [("slave", element.slave), ("t1", t1), ("t2", t2), ("normal", normal)] {
        set_vector(&mut inputs, name, vector);
    }
    inputs.set_element("support_radius", element.support_radius);
    inputs.set_element("plane_reach", element.frame.reach);
    inputs.set_element("pole", element.nearest_in_plane() as f64);
    inputs.set_element("point_1", point[0]);
    inputs.set_element("point_2", point[1]);
    for (k, axis) in AXES.iter().enumerate() {
        let coordinates = element.masters.iter().map(|master| master[k]).collect();
        inputs.set_node(&format!("master_{axis}"), coordinates);
    }
    let radius = |k| element.domains.radius(k, element.support_radius);
    let ratios = (0..element.masters.len()).map(|k| element.support_radius / radius(k)).collect();
    inputs.set_node("domain_ratio", ratios);
    if let Domains::Material(nodes) = element.domains {
        for (k, axis) in AXES.iter().enumerate() {
            inputs.set_node(&format!("material_{axis}"), nodes.iter().map(|node| node.offset[k]).collect());
        }
        for (k, entry) in ["xx", "xy", "xz", "yy", "yz", "zz"].into_iter().enumerate() {
            inputs.set_node(&format!("metric_{entry}"), nodes.iter().map(|node| node.metric[k]).collect());
        }
    }
    inputs
}

pub(crate) const fn mode_of(mode: Mode) -> codegen::Mode {
    match mode {
        Mode::Value => codegen::Mode::Value,
        Mode::Gradient => codegen::Mode::Gradient,
        Mode::Hessian => codegen::Mode::Hessian,
    }
}

/// The frame's motion makes a difference to the gap only.
fn frame_rule(output: Output, element: &Element<'_>) -> FrameRule {
    match (element.frame.derivative, element.domains) {
        (FrameDerivative::CoMoving, Domains::Material(_)) if output.has_gap() => FrameRule::Material,
        (FrameDerivative::CoMoving, _) if output.has_gap() => FrameRule::CoMoving,
        _ => FrameRule::Held,
    }
}

/// The built-in bases only.
const fn basis_of(basis: diffuse_contact::Basis) -> Result<codegen::Basis, ElementError> {
    match basis {
        diffuse_contact::Basis::Quadratic => Ok(codegen::Basis::Quadratic),
        diffuse_contact::Basis::Linear => Ok(codegen::Basis::Linear),
        diffuse_contact::Basis::Custom(custom) => Err(ElementError::NoKernels { basis: custom.name }),
    }
}

#[cfg(test)]
mod tests {
    use diffuse_contact::{Basis, Frame, Generated};

    use super::*;

    fn element(masters: &[[f64; 3]], basis: Basis) -> Element<'_> {
        let frame = Frame::given([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], None).unwrap();
        Element::new([0.1, 0.2, 0.5], masters, frame, 2.0)
            .with_basis(basis)
            .with_weight(diffuse_contact::Weight::Cubic)
    }

    fn grid() -> Vec<[f64; 3]> {
        (0..9).map(|k| [f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0, 0.0]).collect()
    }

    #[test]
    fn a_figure_that_is_no_number_stays() {
        assert_eq!([smaller(1.0, 2.0), smaller(2.0, 1.0)], [1.0; 2]);
        assert!(smaller(f64::NAN, 1.0).is_nan() && smaller(1.0, f64::NAN).is_nan());
    }

    #[test]
    fn the_parts_a_mode_does_not_ask_for_are_empty() {
        let (backend, masters) = (Interpreted::default(), grid());
        let element = element(&masters, Basis::Quadratic);
        let value = backend.surface(&element, [0.1, 0.0], Mode::Value).unwrap();
        assert!(value.gradient.is_empty() && value.slope_gradients[1].is_empty());
        assert_eq!(value.hessian.size(), 0);
        let gradient = backend.coefficients(&element, Mode::Gradient).unwrap();
        assert_eq!(gradient.gradients.len(), 6);
        assert!(gradient.hessians.is_empty());
        assert_eq!(backend.gap(&element, Mode::Hessian).unwrap().hessian.size(), 30);
    }

    #[test]
    fn a_co_moving_frame_changes_the_derivatives_of_the_gap_only() {
        let backend = Interpreted::default();
        // Rough, so that the frame's turn matters.
        let rough = |(k, x): (usize, &[f64; 3])| [x[0], x[1], 0.1 * (k * k % 5) as f64];
        let masters: Vec<[f64; 3]> = grid().iter().enumerate().map(rough).collect();
        let moving = element(&masters, Basis::Linear)
            .with_frame(Frame::average_plane(&masters, [0.0, 0.0, 1.0]).unwrap());
        let held = moving.with_frame(moving.frame.held());
        for mode in [Mode::Value, Mode::Gradient, Mode::Hessian] {
            let coefficients = |element| backend.coefficients(element, mode).unwrap();
            assert_eq!(coefficients(&moving), coefficients(&held));
            let surface = |element| backend.surface(element, [0.1, 0.0], mode).unwrap();
            assert_eq!(surface(&moving), surface(&held));
        }
        let [moving, held] = [&moving, &held].map(|element| backend.gap(element, Mode::Hessian).unwrap());
        assert!((moving.gap - held.gap).abs() < 1e-15);
        let differs = |a: &[f64], b: &[f64]| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 1e-3);
        assert!(differs(&moving.gradient, &held.gradient));
        assert!(differs(moving.hessian.packed(), held.hessian.packed()));
    }

    #[test]
    fn a_plane_that_is_not_unique_is_no_frame_to_move() {
        // As thick as wide: its principal moments are equal.
        let signs = |k: usize| [k & 1, k >> 1 & 1, k >> 2].map(|bit| if bit == 1 { 0.25 } else { -0.25 });
        let masters: Vec<[f64; 3]> = (0..8).map(signs).collect();
        let held = element(&masters, Basis::Linear);
        let frame = Frame { derivative: FrameDerivative::CoMoving, ..held.frame };
        let moving = held.with_frame(frame);
        assert!(Interpreted::default().gap(&held, Mode::Gradient).is_ok());
        for backend in [&Interpreted::default() as &dyn Backend, &Generated] {
            for mode in [Mode::Value, Mode::Gradient, Mode::Hessian] {
                let error = backend.gap(&moving, mode).unwrap_err();
                assert!(matches!(error, ElementError::UnstableAveragePlane { .. }), "{error}");
            }
        }
    }

    #[test]
    fn elements_without_a_result_are_told_apart() {
        let backend = Interpreted::default();
        let code = |element: &Element<'_>| {
            let found = backend.gap(element, Mode::Hessian).map_err(|error| error.code()).err();
            let expected = Generated.gap(element, Mode::Hessian).map_err(|error| error.code()).err();
            assert_eq!(found, expected, "interpreter and generated kernels");
            found
        };
        let line: Vec<[f64; 3]> = (0..9).map(|k| [0.2 * f64::from(k), 0.0, 0.0]).collect();
        assert_eq!(code(&element(&line, Basis::Linear)), Some("singular-fit"));
        assert_eq!(code(&element(&line[..5], Basis::Quadratic)), Some("too-few-nodes"));
        let slope: Vec<[f64; 3]> = grid().iter().map(|x| [x[0], x[1], 12.0 + 3.0 * x[0]]).collect();
        assert_eq!(code(&element(&slope, Basis::Linear)), Some("foot-outside"));
        let infinite: Vec<[f64; 3]> = grid().iter().map(|x| [x[0], x[1], f64::NAN]).collect();
        assert_eq!(code(&element(&infinite, Basis::Linear)), Some("non-finite-input"));
    }
}
