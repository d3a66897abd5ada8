//! `[time]`, `[newton]` and `[output]`.

use super::error::DeckError;
use super::reader::{Field, Section};
use super::{Interface, schema};
use crate::contact::{ContactTangent, Integration};
use crate::named::named;
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

named!(Colour {
    Displacement => "displacement",
    VonMises => "von_mises",
    PlasticStrain => "plastic_strain",
    Gap => "gap",
    Pressure => "pressure",
});

pub(super) fn time(deck: &Section) -> Result<TimeSettings, DeckError> {
    let section = deck.need_table("time")?.section()?.expect(schema::TIME)?;
    let end = section.or("end", 1.0, Field::positive)?;
    let sensible = |value| value >= TimeSettings::SHORTEST * end && value <= end;
    let increment = section.need("increment")?.number_in("from 1e-9 times end to end", sensible)?;
    if section.or("fixed", false, Field::flag)? {
        section.refuse(&["minimum", "maximum", "growth", "cutback"], "beside fixed = true")?;
        return Ok(TimeSettings::fixed(end, increment));
    }
    let within = |value| value >= TimeSettings::SHORTEST * end && value <= increment;
    let above = |value| value >= increment && value <= end;
    let mut time = TimeSettings::new(end, increment);
    section.set("minimum", &mut time.minimum, |field| {
        field.number_in("from 1e-9 times end to increment", within)
    })?;
    section.set("maximum", &mut time.maximum, |field| field.number_in("from increment to end", above))?;
    section.set("growth", &mut time.growth, |field| {
        field.number_in("from 1 to 10", |value| (1.0..=10.0).contains(&value))
    })?;
    section.set("cutback", &mut time.cutback, |field| {
        field.number_in("from 0.01 to 0.9", |value| (0.01..=0.9).contains(&value))
    })?;
    Ok(time)
}

pub(super) fn newton(deck: &Section) -> Result<NewtonSettings, DeckError> {
    let mut newton = NewtonSettings::default();
    let Some(field) = deck.get("newton") else { return Ok(newton) };
    let section = field.section()?.expect(schema::NEWTON)?;
    section.set("tolerance", &mut newton.tolerance, |field| {
        field.number_in("above 0 and below 1", |value| value > 0.0 && value < 1.0)
    })?;
    if let Some(field) = section.get("absolute") {
        newton.absolute = Some(field.number_in("at least 0", |value| value >= 0.0)?);
    }
    section.set("max_iterations", &mut newton.max_iterations, Field::positive_count)?;
    section.set("few_iterations", &mut newton.few_iterations, Field::positive_count)?;
    section.set("line_search", &mut newton.line_search, Field::flag)?;
    section.set("extrapolation", &mut newton.extrapolation, |field| field.word(Extrapolation::NAMED))?;
    section.set("stabilisation", &mut newton.stabilisation, |field| {
        field.number_in("at least 0 and below 1", |value| (0.0..1.0).contains(&value))
    })?;
    section.set("linear_solver", &mut newton.linear_solver, |field| field.word(LinearSolverChoice::NAMED))?;
    section.set("contact_tangent", &mut newton.contact_tangent, |field| field.word(ContactTangent::NAMED))?;
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
    section.set("every", &mut output.every, |field| field.positive_count())?;
    section.set("stress", &mut output.stress, |field| field.flag())?;
    section.set("colour", &mut output.colour, |field| field.word(Colour::NAMED))?;
    Ok(output)
}
