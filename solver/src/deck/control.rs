//! `[time]`, `[newton]` and `[output]`.

use super::error::DeckError;
use super::reader::Section;
use super::{Interface, schema};
use crate::contact::{ContactTangent, Integration};
use crate::statics::{Extrapolation, NewtonSettings, TimeSettings};
use crate::system::LinearSolverChoice;

/// What is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Output {
    /// Every how manyth increment is written as VTU; the last one always is.
    pub every: usize,
    /// Whether stresses and plastic strains are written.
    pub stress: bool,
    /// What colours the deformed shape in the report.
    pub colour: Colour,
}

impl Default for Output {
    /// Every increment, with stresses, coloured by the von Mises stress.
    fn default() -> Self {
        Self { every: 1, stress: true, colour: Colour::VonMises }
    }
}

/// A field on the deformed shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// Size of the displacement, length.
    Displacement,
    /// Von Mises stress, force per area.
    VonMises,
    /// Equivalent plastic strain.
    PlasticStrain,
    /// Contact gap, length.
    Gap,
    /// Contact pressure, force per area.
    Pressure,
}

impl Colour {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Displacement, Self::VonMises, Self::PlasticStrain, Self::Gap, Self::Pressure];

    /// Name in decks.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Displacement => "displacement",
            Self::VonMises => "von_mises",
            Self::PlasticStrain => "plastic_strain",
            Self::Gap => "gap",
            Self::Pressure => "pressure",
        }
    }
}

/// Increments below this part of the whole time are not asked for: there would be more than 32 bits can count.
const SMALLEST_INCREMENT: f64 = 1e-9;

pub(super) fn time(deck: &Section) -> Result<TimeSettings, DeckError> {
    let section = deck.need_table("time")?.section()?.expect(schema::TIME)?;
    let end = section.get("end").map_or(Ok(1.0), |field| field.positive())?;
    let sensible = |value| value >= SMALLEST_INCREMENT * end && value <= end;
    let increment = section.need("increment")?.number_in("from 1e-9 times end to end", sensible)?;
    if section.get("fixed").map_or(Ok(false), |field| field.flag())? {
        section.refuse(&["minimum", "maximum", "growth", "cutback"], "beside fixed = true")?;
        return Ok(TimeSettings::fixed(end, increment));
    }
    let within = |value| value >= SMALLEST_INCREMENT * end && value <= increment;
    let above = |value| value >= increment && value <= end;
    let mut time = TimeSettings::new(end, increment);
    time.minimum = match section.get("minimum") {
        Some(field) => field.number_in("from 1e-9 times end to increment", within)?,
        None => time.minimum.max(SMALLEST_INCREMENT * end),
    };
    if let Some(field) = section.get("maximum") {
        time.maximum = field.number_in("from increment to end", above)?;
    }
    if let Some(field) = section.get("growth") {
        time.growth = field.number_in("from 1 to 10", |value| (1.0..=10.0).contains(&value))?;
    }
    if let Some(field) = section.get("cutback") {
        time.cutback = field.number_in("from 0.01 to 0.9", |value| (0.01..=0.9).contains(&value))?;
    }
    Ok(time)
}

pub(super) fn newton(deck: &Section) -> Result<NewtonSettings, DeckError> {
    let mut newton = NewtonSettings::default();
    let Some(field) = deck.get("newton") else { return Ok(newton) };
    let section = field.section()?.expect(schema::NEWTON)?;
    if let Some(field) = section.get("tolerance") {
        newton.tolerance = field.number_in("above 0 and below 1", |value| value > 0.0 && value < 1.0)?;
    }
    if let Some(field) = section.get("absolute") {
        newton.absolute = Some(field.number_in("at least 0", |value| value >= 0.0)?);
    }
    if let Some(field) = section.get("max_iterations") {
        newton.max_iterations = field.positive_count()?;
    }
    if let Some(field) = section.get("few_iterations") {
        newton.few_iterations = field.positive_count()?;
    }
    if let Some(field) = section.get("line_search") {
        newton.line_search = field.flag()?;
    }
    if let Some(field) = section.get("extrapolation") {
        newton.extrapolation = field.word(&Extrapolation::ALL.map(|rule| (rule.name(), rule)))?;
    }
    if let Some(field) = section.get("stabilisation") {
        newton.stabilisation =
            field.number_in("at least 0 and below 1", |value| (0.0..1.0).contains(&value))?;
    }
    if let Some(field) = section.get("linear_solver") {
        newton.linear_solver = field.word(&LinearSolverChoice::ALL.map(|choice| (choice.name(), choice)))?;
    }
    if let Some(field) = section.get("contact_tangent") {
        newton.contact_tangent = field.word(&ContactTangent::ALL.map(|form| (form.name(), form)))?;
    }
    Ok(newton)
}

/// Refuses the tangent as an operator where it is none.
pub(super) fn check_operator(
    deck: &Section,
    newton: &NewtonSettings,
    interfaces: &[Interface],
) -> Result<(), DeckError> {
    let Some(field) = deck.get("newton") else { return Ok(()) };
    let section = field.section()?;
    if newton.contact_tangent == ContactTangent::Assembled {
        return Ok(());
    }
    let refuse = |reason| section.refuse(&["contact_tangent"], reason);
    if newton.linear_solver == LinearSolverChoice::Direct {
        refuse("as an operator beside linear_solver = \"direct\"")?;
    }
    let is_symmetric =
        |interface: &Interface| interface.friction.as_ref().is_some_and(|friction| friction.is_symmetric);
    if interfaces.iter().any(is_symmetric) {
        refuse("as an operator beside a symmetric tangent of friction")?;
    }
    if interfaces.iter().any(|interface| interface.integration != Integration::Nodes) {
        refuse("as an operator beside integration over faces")?;
    }
    Ok(())
}

pub(super) fn output(deck: &Section) -> Result<Output, DeckError> {
    let mut output = Output::default();
    let Some(field) = deck.get("output") else { return Ok(output) };
    let section = field.section()?.expect(schema::OUTPUT)?;
    if let Some(field) = section.get("every") {
        output.every = field.positive_count()?;
    }
    if let Some(field) = section.get("stress") {
        output.stress = field.flag()?;
    }
    if let Some(field) = section.get("colour") {
        output.colour = field.word(&Colour::ALL.map(|colour| (colour.name(), colour)))?;
    }
    Ok(output)
}
