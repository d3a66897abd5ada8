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

    /// Symbols of its blocks, in the order of the report.
    const fn blocks(self) -> &'static [&'static str] {
        match self.output {
            Output::Coefficients => &["α", "∂α/∂x", "∂²α/∂x²"],
            Output::Surface => &["f", "f_l", "f_lm", "∇f", "T_l", "H_f"],
            Output::Gap => &["g", "foot", "ν", "α", "N", "M", "φ", "∂x^d/∂x", "∂ν/∂x"],
            Output::Slip => &["g", "N", "M", "q", "∇q", "∇²q", "φ"],
        }
    }

    /// Name in the report.
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

/// All blocks, in the order of the report.
pub fn blocks() -> impl Iterator<Item = Block> {
    let of = |subject: Subject| subject.blocks().iter().map(move |&name| Block { subject, name });
    Subject::ALL.into_iter().flat_map(of)
}

/// The larger of two sizes; NaN if one is.
pub(super) fn worse(x: f64, y: f64) -> f64 {
    if x.is_nan() || x > y { x } else { y }
}

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
        let largest = expected.entries.iter().map(|x| x.abs()).fold(expected.scale, worse);
        let worst = self.entries.iter().zip(&expected.entries).map(|(a, b)| (a - b).abs()).fold(0.0, worse);
        if worst == 0.0 { 0.0 } else { worst / largest }
    }
}

/// The blocks of one result; those the mode does not ask for are left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Blocks {
    subject: Subject,
    mode: Mode,
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
        Ok(Self { subject, mode, parts })
    }

    /// The first part of a block, if it is there.
    pub(super) fn entries(&self, name: &str) -> Option<&[f64]> {
        let (_, parts) = self.parts.iter().find(|(other, _)| *other == name)?;
        parts.first().map(|part| part.entries.as_slice())
    }

    /// The differences from another result. A block that one side lacks differs infinitely, unless it is one of derivatives that only
    /// the other's mode has.
    pub fn differences<'a>(&'a self, expected: &'a Self) -> impl Iterator<Item = (Block, f64)> + 'a {
        let of = |blocks: &'a Self, name: &str| blocks.parts.iter().find(|(other, _)| *other == name);
        let found = self.parts.iter().map(move |(name, parts)| {
            let expected = of(expected, name).map_or(&[][..], |(_, parts)| parts);
            let differences = parts.iter().zip(expected).map(|(a, b)| a.difference(b));
            let all = parts.len() == expected.len();
            (*name, if all { differences.fold(0.0, worse) } else { f64::INFINITY })
        });
        let missing = expected
            .parts
            .iter()
            .filter(move |(name, _)| self.mode == expected.mode && of(self, name).is_none());
        let missing = missing.map(|(name, _)| (*name, f64::INFINITY));
        found.chain(missing).map(|(name, difference)| (Block { subject: self.subject, name }, difference))
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
    fn what_one_side_lacks_or_is_no_number_differs() {
        let blocks = |mode, parts| Blocks { subject: GAP, mode, parts };
        let differences = |found: &Blocks, expected: &Blocks| -> Vec<(&str, f64)> {
            found.differences(expected).map(|(block, difference)| (block.name, difference)).collect()
        };
        let [one, two] = [1.0, 2.0].map(|x| Part::unscaled(&[x]));
        let whole =
            blocks(Mode::Hessian, vec![("α", vec![one.clone(), two.clone()]), ("M", vec![one.clone()])]);
        assert_eq!(differences(&whole, &whole), [("α", 0.0), ("M", 0.0)]);
        let cut = blocks(Mode::Hessian, vec![("α", vec![one.clone()]), ("M", vec![one.clone()])]);
        assert_eq!(differences(&cut, &whole), [("α", f64::INFINITY), ("M", 0.0)]);
        assert_eq!(differences(&whole, &cut), [("α", f64::INFINITY), ("M", 0.0)]);
        let value = vec![("α", vec![one, two.clone()])];
        // Only a lower mode may lack derivatives.
        assert_eq!(differences(&blocks(Mode::Value, value.clone()), &whole), [("α", 0.0)]);
        let without = blocks(Mode::Hessian, value);
        assert_eq!(differences(&without, &whole), [("α", 0.0), ("M", f64::INFINITY)]);
        assert_eq!(differences(&whole, &without), [("α", 0.0), ("M", f64::INFINITY)]);
        let nan = blocks(Mode::Value, vec![("α", vec![Part::unscaled(&[f64::NAN]), two])]);
        assert!(differences(&nan, &whole)[0].1.is_nan());
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
