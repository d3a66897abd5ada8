//! `[[boundary]]` and `[[pressure]]`.

use super::error::{DeckError, Problem};
use super::parts::rotation;
use super::reader::{Field, Section};
use super::{Boundary, Pressure, Reference, schema};
use crate::model::{Amplitude, Motion};

pub(super) fn boundary(section: Section, end: f64) -> Result<Boundary, DeckError> {
    let section = section.expect(schema::BOUNDARY)?;
    let nodes = references(&section.need("nodes")?)?;
    let line = section.line();
    if let Some(fix) = section.get("fix") {
        section.refuse(&["translate", "rotate", "amplitude"], "beside fix")?;
        let mut axes = [false; 3];
        let words = [("x", 0), ("y", 1), ("z", 2)];
        let list = fix.list("a list of \"x\", \"y\", \"z\"")?;
        if list.is_empty() {
            return Err(fix.wrong_type("a list of at least one of \"x\", \"y\", \"z\""));
        }
        for axis in list {
            axes[axis.word(&words)?] = true;
        }
        return Ok(Boundary { line, nodes, axes, motion: Motion::fixed() });
    }

    let amplitude = amplitude(&section, end)?;
    let translate = section.get("translate");
    let rotation = section.get("rotate").map(|field| turn(&field, &amplitude)).transpose()?;
    let (axes, translation) = match &translate {
        Some(field) => components(field, rotation.is_some())?,
        None if rotation.is_some() => ([true; 3], [0.0; 3]),
        None => return Err(section.incomplete("fix, translate or rotate")),
    };
    Ok(Boundary { line, nodes, axes, motion: Motion { translation, amplitude, rotation } })
}

/// Displacement by axis, a number or "free".
fn components(field: &Field, turned: bool) -> Result<([bool; 3], [f64; 3]), DeckError> {
    let (mut axes, mut translation) = ([true; 3], [0.0; 3]);
    let members = field.tuple::<3>("a list of three, each a number or \"free\"")?;
    for (axis, member) in members.iter().enumerate() {
        match member.text() {
            Ok(word) if word == "free" && turned => {
                let field = format!("{} = \"free\"", member.name());
                return Err(member.error(Problem::Meaningless { field, reason: "beside rotate" }));
            }
            Ok(word) if word == "free" => axes[axis] = false,
            Ok(_) => return Err(member.wrong_type("a number or \"free\"")),
            Err(_) => translation[axis] = member.number()?,
        }
    }
    if axes == [false; 3] {
        return Err(field.wrong_type("a list with at least one number"));
    }
    Ok((axes, translation))
}

/// A rotation with its own amplitude or that of the condition.
fn turn(field: &Field, default: &Amplitude) -> Result<(crate::model::Rotation, Amplitude), DeckError> {
    let section = field.section()?.expect(schema::BOUNDARY_ROTATION)?;
    let amplitude = section.get("amplitude").map_or_else(|| Ok(default.clone()), |field| table(&field))?;
    Ok((rotation(&section)?, amplitude))
}

pub(super) fn pressure(section: Section, end: f64) -> Result<Pressure, DeckError> {
    let section = section.expect(schema::PRESSURE)?;
    Ok(Pressure {
        line: section.line(),
        surfaces: references(&section.need("surface")?)?,
        value: section.need("value")?.number()?,
        follower: section.or("follower", false, Field::flag)?,
        amplitude: amplitude(&section, end)?,
    })
}

fn amplitude(section: &Section, end: f64) -> Result<Amplitude, DeckError> {
    section.get("amplitude").map_or_else(|| Ok(Amplitude::ramp(end)), |field| table(&field))
}

/// Points of time and factor.
fn table(field: &Field) -> Result<Amplitude, DeckError> {
    let list = field.list("a list of [time, factor]")?;
    if list.is_empty() {
        return Err(field.wrong_type("a list of at least one [time, factor]"));
    }
    let points = list.iter().map(|point| point.numbers("[time, factor]")).collect::<Result<_, _>>()?;
    let ascending = |index| field.error(Problem::Amplitude { field: field.name().into(), index });
    Amplitude::new(points).map_err(ascending)
}

/// One name or a list of at least one.
pub(super) fn references(field: &Field) -> Result<Vec<Reference>, DeckError> {
    let reference = |field: &Field| Ok(Reference { name: field.text()?, line: field.line() });
    if !field.is_list() {
        return match reference(field) {
            Ok(one) => Ok(vec![one]),
            Err(_) => Err(field.wrong_type("a name or a list of names")),
        };
    }
    let names: Vec<Reference> =
        field.list("a list of names")?.iter().map(reference).collect::<Result<_, _>>()?;
    if names.is_empty() { Err(field.wrong_type("a list of at least one name")) } else { Ok(names) }
}
