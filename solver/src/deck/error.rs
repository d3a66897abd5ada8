//! What can be wrong with a deck.

use std::path::PathBuf;

use diffuse_contact::friction::FrictionError;
use diffuse_contact_mesh::file::reason;
use diffuse_contact_mesh::names::{self, escaped, shown};

use crate::contact::{AdjustError, ContactError};
use crate::model::{ModelError, ShapeError};

/// Why a deck cannot be used. Each message is one sentence that can be shown as it stands.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DeckError {
    /// The file cannot be read at all.
    #[error("{path}: cannot be read: {}", reason(cause))]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        cause: std::io::Error,
    },
    /// Something is wrong at one place.
    #[error("{path}, line {line}: {}", escaped(&problem.to_string()))]
    Invalid {
        /// The file; `deck` if the text came from elsewhere.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What is wrong there.
        problem: Box<Problem>,
    },
}

impl DeckError {
    /// What is wrong, unless the file cannot be read.
    #[must_use]
    pub fn problem(&self) -> Option<&Problem> {
        match self {
            Self::Invalid { problem, .. } => Some(problem),
            Self::Read { .. } => None,
        }
    }
}

/// What is wrong at one place of a deck. Fields are named with their tables, like `parts.pipe.radius`.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// A coefficient of friction that is none.
    #[error("{field}: {error}")]
    Coefficient {
        /// The field.
        field: String,
        /// Why.
        error: FrictionError,
    },
    /// A list of numbers that do not ascend.
    #[error("{field}: numbers must ascend, but number {} is not larger than the one before", index + 1)]
    Descending {
        /// The field.
        field: String,
        /// The number, from 0.
        index: usize,
    },
    /// Not TOML.
    #[error("not valid TOML: {message}")]
    Syntax {
        /// What the parser says.
        message: String,
    },
    /// Nothing but blanks and comments.
    #[error("there is nothing in the deck; docs/how-to/decks.md lists what there can be")]
    Empty,
    /// A field that does not exist here.
    #[error("{table} has no {what} {field:?}{}; it has {}", did_you_mean(nearest), list(known), field = shown(field))]
    UnknownField {
        /// The table.
        table: String,
        /// `"field"`, or `"table"` if that is what stands there.
        what: &'static str,
        /// The field.
        field: String,
        /// The known field closest in spelling, if one is close.
        nearest: Option<String>,
        /// All known fields.
        known: Vec<String>,
    },
    /// A field that has to be there is not.
    #[error("{table} needs a {what} {field:?}", field = shown(field))]
    Missing {
        /// The table.
        table: String,
        /// `"field"`, or `"table"` if it has to be one.
        what: &'static str,
        /// The field.
        field: &'static str,
    },
    /// A value of another type.
    #[error("{field} must be {expected}, not {found}")]
    WrongType {
        /// The field.
        field: String,
        /// What it must be.
        expected: String,
        /// What it is.
        found: String,
    },
    /// A number outside its range.
    #[error("{field} must be {range}, not {value}")]
    OutOfRange {
        /// The field.
        field: String,
        /// What it may be.
        range: &'static str,
        /// What it is.
        value: f64,
    },
    /// A word that is none of those a field can have.
    #[error("{field} cannot be {word:?}{}; it can be {}", did_you_mean(nearest), list(known), word = shown(word))]
    UnknownWord {
        /// The field.
        field: String,
        /// The word.
        word: String,
        /// The known word closest in spelling, if one is close.
        nearest: Option<String>,
        /// All known words.
        known: Vec<String>,
    },
    /// A word that only other builds know.
    #[error("{field} cannot be {word:?} here: it needs a program built with --features {feature}")]
    LeftOut {
        /// The field.
        field: String,
        /// The word.
        word: String,
        /// The Cargo feature.
        feature: &'static str,
    },
    /// A field without meaning beside another, or without it.
    #[error("{field} has no meaning {reason}")]
    Meaningless {
        /// The field.
        field: String,
        /// Why: `"without yield_stress"`, `"beside fix"`.
        reason: &'static str,
    },
    /// None of several fields is there.
    #[error("{table} needs {fields}")]
    Incomplete {
        /// The table.
        table: String,
        /// The fields.
        fields: &'static str,
    },
    /// A list of time and factor that does not ascend in time.
    #[error("{field}: times must ascend, but point {} is not later than the one before", index + 1)]
    Amplitude {
        /// The field.
        field: String,
        /// The point, from 0.
        index: usize,
    },
    /// A name used twice.
    #[error("two {what}s are named {name:?}; the other is in line {other}", name = shown(name))]
    Repeated {
        /// `"interface"`.
        what: &'static str,
        /// The name.
        name: String,
        /// Line of the other.
        other: usize,
    },
    /// A surface that is a set without facets.
    #[error(
        "{name:?} is a set of {nodes} nodes and has no facets: name a surface, in `.inp` files one of \
         `*SURFACE, TYPE=ELEMENT`",
        name = shown(name)
    )]
    NoFacets {
        /// The name.
        name: String,
        /// How many.
        nodes: usize,
    },
    /// A name of nothing.
    #[error("no {what} is named {name:?}{}; there {}", did_you_mean(nearest), all(known, what), name = shown(name))]
    UnknownName {
        /// `"material"`, `"node set"` or `"surface"`.
        what: &'static str,
        /// The name.
        name: String,
        /// The known name closest in spelling, if one is close.
        nearest: Option<String>,
        /// All names there are.
        known: Vec<String>,
    },
    /// A shape that cannot be made.
    #[error("parts.{part}: {error}", part = shown(part))]
    Shape {
        /// The part.
        part: String,
        /// Why.
        error: ShapeError,
    },
    /// A part that cannot be used.
    #[error("parts.{part}: {error}", part = shown(part))]
    Part {
        /// The part.
        part: String,
        /// Why.
        error: ModelError,
    },
    /// A kind of hexahedra with 8 nodes for a part that has none.
    #[error("parts.{part}.element says what hexahedra with 8 nodes are, but the mesh file has none for this part", part = shown(part))]
    NoHexahedra {
        /// The part.
        part: String,
    },
    /// Two boundary conditions move one node differently along one axis.
    #[error(
        "node {node} at ({}) is moved along {axis} by this boundary condition and, differently, by that in line {other}",
        triple(position)
    )]
    Conflict {
        /// The node, from 0 in the order of the model.
        node: usize,
        /// Where it is.
        position: [f64; 3],
        /// `"x"`, `"y"` or `"z"`.
        axis: &'static str,
        /// Line of the earlier condition.
        other: usize,
    },
    /// A node of a rigid part is free.
    #[error(
        "the part {part:?} is rigid, but its node at ({}) is free along {axis}: a [[boundary]] has to fix, translate or \
         rotate all of its nodes along all axes",
        triple(position), part = shown(part)
    )]
    FreeRigidNode {
        /// The part.
        part: String,
        /// Where the node is.
        position: [f64; 3],
        /// `"x"`, `"y"` or `"z"`.
        axis: &'static str,
    },
    /// Pressure on a rigid surface.
    #[error("the surface {name:?} is rigid: a pressure on it has no effect", name = shown(name))]
    PressureOnRigid {
        /// The surface.
        name: String,
    },
    /// A surface of a mesh file lies inside its part in places.
    #[error(
        "{inner} of the {count} facets of the surface {name:?} are not on the skin of its part, where alone something can touch or \
         press it", name = shown(name)
    )]
    InnerFacets {
        /// The surface.
        name: String,
        /// How many are not on the skin.
        inner: usize,
        /// How many there are.
        count: usize,
    },
    /// Both sides of an interface are rigid.
    #[error("both sides of the interface {name:?} are rigid", name = shown(name))]
    RigidInterface {
        /// The interface.
        name: String,
    },
    /// A node is on both sides of an interface.
    #[error("the node at ({}) is on both sides of the interface {name:?}", triple(position), name = shown(name))]
    SharedNode {
        /// The interface.
        name: String,
        /// Where the node is.
        position: [f64; 3],
    },
    /// An interface that cannot be made.
    #[error(transparent)]
    Contact(ContactError),
    /// Slaves that cannot start in touch.
    #[error("the interface {name:?} cannot adjust its slaves: {error}", name = shown(name))]
    Adjust {
        /// The interface.
        name: String,
        /// Why.
        error: AdjustError,
    },
    /// There is nothing to move: no deformable part.
    #[error("the deck has no deformable part")]
    NothingDeformable,
}

fn did_you_mean(nearest: &Option<String>) -> String {
    nearest.as_ref().map_or_else(String::new, |name| format!(" (did you mean {:?}?)", shown(name)))
}

fn list(names: &[String]) -> String {
    names::list(names.iter().map(shown))
}

fn all(names: &[String], what: &str) -> String {
    match names {
        [] => format!("is no {what}"),
        [only] => format!("is only {}", shown(only)),
        _ => format!("are {}", list(names)),
    }
}

fn triple([x, y, z]: &[f64; 3]) -> String {
    format!("{x}, {y}, {z}")
}
