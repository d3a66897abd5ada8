//! Which numbers of a result belong together, and how a difference of two results is measured.
//!
//! The difference of a block is the largest difference of an entry over the largest entry of the block. Values
//! that a harmless element can make small, so that their own size says nothing about their rounding, have their
//! natural scale as a lower bound of that denominator: the support radius R for lengths (f, g, and the foot, which is
//! taken relative to the slave), 1 for slopes, 1/R for curvatures, and so on for the coefficients. Derivatives and
//! the normal have no such bound: the largest entry alone counts. Each coefficient, each slope's gradient and each
//! Hessian is a part of its own, since units and sizes differ; a block has the largest difference of its parts.

use diffuse_contact::{
    Backend, Coefficients, ElementError, FootDerivatives, Gap, Mode, Slip, Surface, SymmetricMatrix,
};
use diffuse_contact_codegen::{FrameRule, Output};

use super::elements::RandomElement;
use crate::emit::frame_name;

/// What is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Subject {
    /// The output.
    pub output: Output,
    /// The frame rule; a moving frame makes a difference to gap and slip only.
    pub frame: FrameRule,
}

impl Subject {
    /// All of them, in the order of the report.
    pub const ALL: [Self; 8] =
        [COEFFICIENTS, SURFACE, GAP, CO_MOVING_GAP, MATERIAL_GAP, SLIP, CO_MOVING_SLIP, MATERIAL_SLIP];

    /// Name in the report.
    #[must_use]
    pub fn name(self) -> String {
        match self.frame {
            FrameRule::Held => self.output.name().to_owned(),
            FrameRule::CoMoving | FrameRule::Material => {
                format!("{}, {}", self.output.name(), frame_name(self.frame))
            }
        }
    }
}

const COEFFICIENTS: Subject = Subject { output: Output::Coefficients, frame: FrameRule::Held };
const SURFACE: Subject = Subject { output: Output::Surface, frame: FrameRule::Held };
const GAP: Subject = Subject { output: Output::Gap, frame: FrameRule::Held };
const CO_MOVING_GAP: Subject = Subject { output: Output::Gap, frame: FrameRule::CoMoving };
const MATERIAL_GAP: Subject = Subject { output: Output::Gap, frame: FrameRule::Material };
const SLIP: Subject = Subject { output: Output::Slip, frame: FrameRule::Held };
const CO_MOVING_SLIP: Subject = Subject { output: Output::Slip, frame: FrameRule::CoMoving };
const MATERIAL_SLIP: Subject = Subject { output: Output::Slip, frame: FrameRule::Material };

/// A block of the results of a subject.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Block {
    /// What it belongs to.
    pub subject: Subject,
    /// Its symbol.
    pub name: &'static str,
}

const fn block(subject: Subject, name: &'static str) -> Block {
    Block { subject, name }
}

/// All blocks, in the order of the report.
pub const BLOCKS: [Block; 57] = [
    block(COEFFICIENTS, "α"),
    block(COEFFICIENTS, "∂α/∂x"),
    block(COEFFICIENTS, "∂²α/∂x²"),
    block(SURFACE, "f"),
    block(SURFACE, "f_l"),
    block(SURFACE, "f_lm"),
    block(SURFACE, "∇f"),
    block(SURFACE, "T_l"),
    block(SURFACE, "H_f"),
    block(GAP, "g"),
    block(GAP, "foot"),
    block(GAP, "ν"),
    block(GAP, "α"),
    block(GAP, "N"),
    block(GAP, "M"),
    block(GAP, "φ"),
    block(GAP, "∂x^d/∂x"),
    block(GAP, "∂ν/∂x"),
    block(CO_MOVING_GAP, "g"),
    block(CO_MOVING_GAP, "foot"),
    block(CO_MOVING_GAP, "ν"),
    block(CO_MOVING_GAP, "α"),
    block(CO_MOVING_GAP, "N"),
    block(CO_MOVING_GAP, "M"),
    block(CO_MOVING_GAP, "φ"),
    block(CO_MOVING_GAP, "∂x^d/∂x"),
    block(CO_MOVING_GAP, "∂ν/∂x"),
    block(MATERIAL_GAP, "g"),
    block(MATERIAL_GAP, "foot"),
    block(MATERIAL_GAP, "ν"),
    block(MATERIAL_GAP, "α"),
    block(MATERIAL_GAP, "N"),
    block(MATERIAL_GAP, "M"),
    block(MATERIAL_GAP, "φ"),
    block(MATERIAL_GAP, "∂x^d/∂x"),
    block(MATERIAL_GAP, "∂ν/∂x"),
    block(SLIP, "g"),
    block(SLIP, "N"),
    block(SLIP, "M"),
    block(SLIP, "q"),
    block(SLIP, "∇q"),
    block(SLIP, "∇²q"),
    block(SLIP, "φ"),
    block(CO_MOVING_SLIP, "g"),
    block(CO_MOVING_SLIP, "N"),
    block(CO_MOVING_SLIP, "M"),
    block(CO_MOVING_SLIP, "q"),
    block(CO_MOVING_SLIP, "∇q"),
    block(CO_MOVING_SLIP, "∇²q"),
    block(CO_MOVING_SLIP, "φ"),
    block(MATERIAL_SLIP, "g"),
    block(MATERIAL_SLIP, "N"),
    block(MATERIAL_SLIP, "M"),
    block(MATERIAL_SLIP, "q"),
    block(MATERIAL_SLIP, "∇q"),
    block(MATERIAL_SLIP, "∇²q"),
    block(MATERIAL_SLIP, "φ"),
];

/// Entries of one unit.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Part {
    pub(super) entries: Vec<f64>,
    /// Lower bound of the denominator.
    scale: f64,
}

impl Part {
    pub(super) fn scaled(entries: &[f64], scale: f64) -> Self {
        Self { entries: entries.to_vec(), scale }
    }

    /// A part whose largest entry is its scale.
    pub(super) fn unscaled(entries: &[f64]) -> Self {
        Self::scaled(entries, 0.0)
    }

    /// Largest difference over the largest entry of `expected`, or the scale if that is larger.
    pub(super) fn difference(&self, expected: &Self) -> f64 {
        if self.entries.len() != expected.entries.len() {
            return f64::INFINITY;
        }
        let largest = expected.entries.iter().fold(expected.scale, |largest, x| largest.max(x.abs()));
        let differences = self.entries.iter().zip(&expected.entries).map(|(a, b)| (a - b).abs());
        let larger = |worst: f64, x: f64| if x > worst || x.is_nan() { x } else { worst };
        let worst = differences.fold(0.0, larger);
        if worst == 0.0 { 0.0 } else { worst / largest }
    }
}

/// The blocks of one result; those the mode does not ask for are left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Blocks {
    subject: Subject,
    parts: Vec<(&'static str, Vec<Part>)>,
}

impl Blocks {
    /// Evaluates an element and sorts the result.
    ///
    /// # Errors
    /// Those of the backend.
    pub fn evaluate(
        backend: &dyn Backend,
        random: &RandomElement,
        subject: Subject,
        mode: Mode,
    ) -> Result<Self, ElementError> {
        let element = random.element(subject.frame);
        let radius = element.support_radius;
        let mut parts = match subject.output {
            Output::Coefficients => of_coefficients(&backend.coefficients(&element, mode)?, radius),
            Output::Surface => of_surface(&backend.surface(&element, random.point, mode)?, radius),
            Output::Gap => of_gap(&backend.gap(&element, mode)?, element.slave, radius),
            Output::Slip => of_slip(&backend.slip(&element, random.anchor, mode)?, radius),
        };
        if subject.output == Output::Gap && mode == Mode::Hessian {
            parts.extend(of_foot(&backend.foot_derivatives(&element)?));
        }
        parts.retain(|(_, parts)| parts.iter().any(|part| !part.entries.is_empty()));
        Ok(Self { subject, parts })
    }

    /// The first part of a block, if it is there.
    pub(super) fn entries(&self, name: &str) -> Option<&[f64]> {
        let (_, parts) = self.parts.iter().find(|(other, _)| *other == name)?;
        parts.first().map(|part| part.entries.as_slice())
    }

    /// The differences from another result, for the blocks both have.
    pub fn differences<'a>(&'a self, expected: &'a Self) -> impl Iterator<Item = (Block, f64)> + 'a {
        self.parts.iter().filter_map(|(name, parts)| {
            let (_, expected) = expected.parts.iter().find(|(other, _)| other == name)?;
            let worst = parts.iter().zip(expected).map(|(a, b)| a.difference(b)).fold(0.0, f64::max);
            Some((block(self.subject, name), worst))
        })
    }
}

type Named = (&'static str, Vec<Part>);

fn of_coefficients(coefficients: &Coefficients, radius: f64) -> Vec<Named> {
    let derivatives = |parts: &[Vec<f64>]| parts.iter().map(|x| Part::unscaled(x)).collect();
    let hessians = coefficients.hessians.iter().map(hessian).collect();
    vec![
        ("α", values(&coefficients.values, radius)),
        ("∂α/∂x", derivatives(&coefficients.gradients)),
        ("∂²α/∂x²", hessians),
    ]
}

fn of_surface(surface: &Surface, radius: f64) -> Vec<Named> {
    vec![
        ("f", vec![Part::scaled(&[surface.value], radius)]),
        ("f_l", vec![Part::scaled(&surface.slopes, 1.0)]),
        ("f_lm", vec![Part::scaled(&surface.curvatures, 1.0 / radius)]),
        ("∇f", vec![Part::unscaled(&surface.gradient)]),
        ("T_l", surface.slope_gradients.iter().map(|x| Part::unscaled(x)).collect()),
        ("H_f", vec![hessian(&surface.hessian)]),
    ]
}

fn of_gap(gap: &Gap, slave: [f64; 3], radius: f64) -> Vec<Named> {
    let foot: [f64; 3] = std::array::from_fn(|k| gap.foot[k] - slave[k]);
    vec![
        ("g", vec![Part::scaled(&[gap.gap], radius)]),
        ("foot", vec![Part::scaled(&foot, radius)]),
        ("ν", vec![Part::unscaled(&gap.normal)]),
        ("α", values(&gap.coefficients, radius)),
        ("N", vec![Part::unscaled(&gap.gradient)]),
        ("M", vec![hessian(&gap.hessian)]),
    ]
}

fn of_foot(at_foot: &FootDerivatives) -> Vec<Named> {
    vec![
        ("φ", vec![Part::unscaled(&at_foot.weights)]),
        ("∂x^d/∂x", vec![Part::unscaled(&at_foot.foot)]),
        ("∂ν/∂x", vec![Part::unscaled(&at_foot.normal)]),
    ]
}

fn of_slip(slip: &Slip, radius: f64) -> Vec<Named> {
    vec![
        ("g", vec![Part::scaled(&[slip.contact.gap], radius)]),
        ("N", vec![Part::unscaled(&slip.contact.gradient)]),
        ("M", vec![hessian(&slip.contact.hessian)]),
        ("q", vec![Part::unscaled(&[slip.half_square])]),
        ("∇q", vec![Part::unscaled(&slip.gradient)]),
        ("∇²q", vec![hessian(&slip.hessian)]),
        ("φ", vec![Part::unscaled(&slip.foot_weights)]),
    ]
}

/// Coefficients, of units length, 1, 1, 1/length, ….
fn values(coefficients: &[f64], radius: f64) -> Vec<Part> {
    const DEGREES: [i32; 6] = [0, 1, 1, 2, 2, 2];
    let part = |(alpha, degree): (&f64, i32)| Part::scaled(&[*alpha], radius.powi(1 - degree));
    coefficients.iter().zip(DEGREES).map(part).collect()
}

fn hessian(matrix: &SymmetricMatrix) -> Part {
    Part::unscaled(matrix.packed())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_entry_or_the_scale_is_the_denominator() {
        let expected = Part::unscaled(&[1.5, -4.0]);
        assert_eq!(Part::unscaled(&[1.0, -4.5]).difference(&expected), 0.125);
        let expected = Part::scaled(&[1.5, -4.0], 8.0);
        assert_eq!(Part::unscaled(&[1.0, -4.5]).difference(&expected), 0.0625);
        assert_eq!(Part::unscaled(&[0.0]).difference(&Part::unscaled(&[0.0])), 0.0);
        assert_eq!(Part::unscaled(&[0.0]).difference(&Part::unscaled(&[])), f64::INFINITY);
        assert!(Part::unscaled(&[f64::NAN, 1.0]).difference(&Part::unscaled(&[1.0, 2.0])).is_nan());
    }

    #[test]
    fn a_mode_without_derivatives_has_no_blocks_for_them() {
        let coefficients = Coefficients { values: vec![1.0; 6], ..Coefficients::default() };
        let blocks = |coefficients: &Coefficients| {
            let mut parts = of_coefficients(coefficients, 2.0);
            parts.retain(|(_, parts)| parts.iter().any(|part| !part.entries.is_empty()));
            parts.len()
        };
        assert_eq!(blocks(&coefficients), 1);
    }
}
