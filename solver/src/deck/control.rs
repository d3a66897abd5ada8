//! `[time]`, `[newton]` and `[output]`.

use super::error::DeckError;
use super::reader::Section;
use super::schema;
use crate::statics::Extrapolation;

/// How time goes on from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Time {
    /// Where it ends, positive.
    pub end: f64,
    /// The first increment, positive and up to `end`.
    pub increment: f64,
    /// Cutting back stops below this.
    pub minimum: f64,
    /// The largest increment.
    pub maximum: f64,
    /// Factor of the increment after one that was easy, at least 1.
    pub growth: f64,
    /// Factor of the increment after one that failed, above 0 and below 1.
    pub cutback: f64,
    /// All increments are equal: there is no growth and no cut-back, and what fails ends the run.
    pub fixed: bool,
}

/// When an increment is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Newton {
    /// Largest residual force over the reference force of the increment.
    pub tolerance: f64,
    /// Residual force that counts as none whatever the reference force, force.
    pub absolute: f64,
    /// Iterations after which an increment has failed.
    pub max_iterations: usize,
    /// Iterations up to which an increment lets the next one grow.
    pub few_iterations: usize,
    /// Whether a step that goes too far, so that the slope Δx·r changes its sign and stays large, is shortened.
    pub line_search: bool,
    /// Where an increment looks for its end first.
    pub extrapolation: Extrapolation,
}

/// What is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Output {
    /// Every how manyth increment is written as VTU; the last one always is.
    pub every: usize,
    /// Whether stresses and plastic strains are written.
    pub stress: bool,
    /// What colours the deformed shape in the report.
    pub colour: Colour,
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
    #[must_use]
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

pub(super) fn time(deck: &Section) -> Result<Time, DeckError> {
    let section = deck.need("time")?.section()?.expect(schema::TIME)?;
    let end = section.get("end").map_or(Ok(1.0), |field| field.positive())?;
    let sensible = |value| value >= SMALLEST_INCREMENT * end && value <= end;
    let increment = section.need("increment")?.number_in("from 1e-9 times end to end", sensible)?;
    let fixed = section.get("fixed").map_or(Ok(false), |field| field.flag())?;
    if fixed {
        section.refuse(&["minimum", "maximum", "growth", "cutback"], "beside fixed = true")?;
    }
    let within = |value| value >= SMALLEST_INCREMENT * end && value <= increment;
    let above = |value| value >= increment && value <= end;
    Ok(Time {
        end,
        increment,
        minimum: match section.get("minimum") {
            Some(field) => field.number_in("from 1e-9 times end to increment", within)?,
            None => (increment / 1024.0).max(SMALLEST_INCREMENT * end),
        },
        maximum: match section.get("maximum") {
            Some(field) => field.number_in("from increment to end", above)?,
            None => increment,
        },
        growth: match section.get("growth") {
            Some(field) => field.number_in("from 1 to 10", |value| (1.0..=10.0).contains(&value))?,
            None => 1.5,
        },
        cutback: match section.get("cutback") {
            Some(field) => field.number_in("from 0.01 to 0.9", |value| (0.01..=0.9).contains(&value))?,
            None => 0.5,
        },
        fixed,
    })
}

pub(super) fn newton(deck: &Section) -> Result<Newton, DeckError> {
    let mut newton = Newton {
        tolerance: 1e-6,
        absolute: 1e-8,
        max_iterations: 20,
        few_iterations: 6,
        line_search: true,
        extrapolation: Extrapolation::None,
    };
    let Some(field) = deck.get("newton") else { return Ok(newton) };
    let section = field.section()?.expect(schema::NEWTON)?;
    if let Some(field) = section.get("tolerance") {
        newton.tolerance = field.number_in("above 0 and below 1", |value| value > 0.0 && value < 1.0)?;
    }
    if let Some(field) = section.get("absolute") {
        newton.absolute = field.number_in("at least 0", |value| value >= 0.0)?;
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
    Ok(newton)
}

pub(super) fn output(deck: &Section) -> Result<Output, DeckError> {
    let mut output = Output { every: 1, stress: true, colour: Colour::VonMises };
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
