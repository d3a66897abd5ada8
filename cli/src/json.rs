//! JSON, read strictly: what departs from the schema is refused, in one sentence that names file, line, column and
//! field.

use std::fmt;
use std::marker::PhantomData;

use diffuse_contact::{Basis, Frame, Point};
use diffuse_contact_mesh::names::{nearest, shown};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserialize, DeserializeOwned, Deserializer, MapAccess, Visitor};
use serde_path_to_error::{Path as Place, Segment};

use crate::error::CliError;

/// Words that some programs write in place of a number.
const NO_NUMBERS: [&str; 6] = ["NaN", "nan", "Infinity", "infinity", "Inf", "inf"];
/// What the parser says of a number beyond the range of f64: the text is JSON, but the number is lost.
const OUT_OF_RANGE: &str = "number out of range";

/// Three numbers.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(try_from = "Vec<f64>")]
pub struct Coordinates(pub Point);

impl TryFrom<Vec<f64>> for Coordinates {
    type Error = WrongLength;

    fn try_from(numbers: Vec<f64>) -> Result<Self, WrongLength> {
        let found = numbers.len();
        numbers.try_into().map(Self).map_err(|_| WrongLength { found })
    }
}

/// A point or a direction with a number of coordinates other than three.
#[derive(Debug, thiserror::Error)]
#[error("expected three coordinates [x, y, z], found {found}")]
pub struct WrongLength {
    found: usize,
}

/// A structure written as a JSON object. Serde by itself also takes the array of its fields, without their names.
#[derive(Debug)]
pub struct Object<T>(pub T);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Object<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(ObjectVisitor(PhantomData))
    }
}

struct ObjectVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for ObjectVisitor<T> {
    type Value = Object<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Object<T>, A::Error> {
        T::deserialize(MapAccessDeserializer::new(map)).map(Object)
    }
}

/// Basis of a fit.
#[derive(Clone, Copy, Debug, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BasisName {
    /// `"quadratic"`.
    Quadratic,
    /// `"linear"`.
    Linear,
}

impl From<BasisName> for Basis {
    fn from(basis: BasisName) -> Self {
        match basis {
            BasisName::Quadratic => Self::Quadratic,
            BasisName::Linear => Self::Linear,
        }
    }
}

/// A frame in the form in which it can be given.
#[derive(Debug, serde::Serialize)]
pub struct FrameOutput {
    origin: Point,
    t1: Point,
    t2: Point,
    normal: Point,
}

impl From<Frame> for FrameOutput {
    fn from(frame: Frame) -> Self {
        Self { origin: frame.origin, t1: frame.t1, t2: frame.t2, normal: frame.normal }
    }
}

/// A text without the mark that some editors begin a file with.
pub fn without_mark(text: &[u8]) -> &[u8] {
    text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text)
}

/// Reads a document, or says in one sentence where it departs from the schema. `file` names it in that sentence.
pub fn parse<T: DeserializeOwned>(file: &str, text: &[u8]) -> Result<T, CliError> {
    let text = without_mark(text);
    let mut deserializer = serde_json::Deserializer::from_slice(text);
    let mut track = serde_path_to_error::Track::new();
    let document = T::deserialize(serde_path_to_error::Deserializer::new(&mut deserializer, &mut track));
    match document {
        Ok(document) => {
            let rest = deserializer.end();
            rest.map(|()| document).map_err(|error| describe(file, text, &error, None))
        }
        Err(error) => Err(describe(file, text, &error, Some(&track.path()))),
    }
}

/// Line and column of the last character that is no space.
fn end(text: &[u8]) -> (usize, usize) {
    let text = text.trim_ascii_end();
    let line = text.iter().filter(|&&byte| byte == b'\n').count() + 1;
    (line, text.iter().rev().take_while(|&&byte| byte != b'\n').count())
}

fn describe(file: &str, text: &[u8], error: &serde_json::Error, path: Option<&Place>) -> CliError {
    let (line, column) = if error.is_eof() { end(text) } else { (error.line(), error.column()) };
    let message = error.to_string();
    let statement = message
        .strip_suffix(&format!(" at line {} column {}", error.line(), error.column()))
        .unwrap_or(&message);
    let statement = match word_at(text, line, column) {
        Some(word) if error.is_syntax() && NO_NUMBERS.contains(&word) => {
            &format!("{word} is no number in JSON")
        }
        _ if (error.is_syntax() || error.is_eof()) && statement != OUT_OF_RANGE => {
            &format!("not valid JSON: {statement}")
        }
        _ => statement,
    };
    let place = path.map(in_words).filter(|place| place != ".");
    let suggestion = path.and_then(|path| suggestion(path, statement));
    let statement = in_a_line(statement);
    let what = format!(
        "{}{statement}{}",
        place.map(|place| format!("{place}: ")).unwrap_or_default(),
        suggestion.map(|field| format!("; did you mean `{field}`?")).unwrap_or_default()
    );
    CliError::Json { file: file.into(), line, column, what }
}

/// A place with its names shown.
fn in_words(path: &Place) -> String {
    let mut text = String::new();
    for segment in path.iter() {
        match segment {
            Segment::Seq { .. } => text += &segment.to_string(),
            Segment::Map { key } | Segment::Enum { variant: key } => {
                text += if text.is_empty() { "" } else { "." };
                text += &shown(key).to_string();
            }
            Segment::Unknown => {}
        }
    }
    if text.is_empty() { ".".to_owned() } else { text }
}

/// Serde's statement in a line of limited length. What it quotes of the file stands before what was expected.
fn in_a_line(statement: &str) -> String {
    let (found, expected) = statement.split_at(statement.rfind(", expected ").unwrap_or(statement.len()));
    // What serde quotes ends with a quote.
    let end = if found.ends_with('`') { "`" } else { "" };
    format!("{}{end}{expected}", shown(found.strip_suffix('`').unwrap_or(found)))
}

/// The word of letters that begins or ends at a place of the text.
fn word_at(text: &[u8], line: usize, column: usize) -> Option<&str> {
    let line = text.split(|&byte| byte == b'\n').nth(line.checked_sub(1)?)?;
    let place = column.saturating_sub(1).min(line.len());
    let letter = |byte: &u8| byte.is_ascii_alphabetic();
    let before = line[..place].iter().rev().take_while(|byte| letter(byte)).count();
    let after = line[place..].iter().take_while(|byte| letter(byte)).count();
    str::from_utf8(&line[place - before..place + after]).ok()
}

/// The known field a misspelt one comes closest to. Serde lists the known ones in its statement, in backquotes
/// after the unknown one.
fn suggestion<'s>(path: &Place, statement: &'s str) -> Option<&'s str> {
    statement.strip_prefix("unknown field `")?;
    let known = statement[statement.rfind(", expected ")?..].split('`').skip(1).step_by(2);
    let Some(Segment::Map { key }) = path.iter().next_back() else { return None };
    nearest(key, known)
}
