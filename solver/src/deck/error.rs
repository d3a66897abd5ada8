//! What can be wrong with a deck.

use std::path::PathBuf;
use std::sync::Arc;

use diffuse_contact::friction::FrictionError;
use diffuse_contact_mesh::MeshError;
use diffuse_contact_mesh::file::reason;
use diffuse_contact_mesh::names::{self, escaped, shown};

use crate::contact::{AdjustError, ContactError};
use crate::model::{ModelError, ShapeError};

/// Why a deck cannot be used. Each message is one sentence that can be shown as it stands.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum DeckError {
    #[error("{path}: cannot be read: {}", reason(cause))]
    Read { path: PathBuf, cause: std::io::Error },
    /// Something is wrong at one place. The path is `deck` if the text came from elsewhere; lines count from 1.
    #[error("{path}, line {line}: {}", escaped(&problem.to_string()))]
    Invalid { path: PathBuf, line: usize, problem: Box<Problem> },
}

impl DeckError {
    /// What is wrong, unless the file cannot be read.
    pub fn problem(&self) -> Option<&Problem> {
        match self {
            Self::Invalid { problem, .. } => Some(problem),
            Self::Read { .. } => None,
        }
    }
}

/// What is wrong at one place of a deck. Fields are named with their tables, like `parts.pipe.radius`. Nodes count from 0 in the order of
/// the model, an `index` from 0, lines from 1. `nearest` is the known name closest in spelling, if one is close.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum Problem {
    /// A coefficient of friction that is none.
    #[error("{field}: {error}")]
    Coefficient { field: String, error: FrictionError },
    #[error("{field}: numbers must ascend, but number {} is not larger than the one before", index + 1)]
    Descending { field: String, index: usize },
    #[error("not valid TOML: {message}")]
    Syntax { message: String },
    /// Nothing but blanks and comments.
    #[error("there is nothing in the deck; docs/how-to/decks.md lists what there can be")]
    Empty,
    /// A field that does not exist here; `what` is `"field"`, or `"table"` if that is what stands there.
    #[error("{table} has no {what} {field:?}{}; it has {}", did_you_mean(nearest), list(known), field = shown(field))]
    UnknownField {
        table: String,
        what: &'static str,
        field: String,
        nearest: Option<String>,
        known: Vec<String>,
    },
    /// A field that has to be there is not; `what` is `"field"`, or `"table"` if it has to be one.
    #[error("{table} needs a {what} {field:?}", field = shown(field))]
    Missing { table: String, what: &'static str, field: &'static str },
    #[error("{field} must be {expected}, not {found}")]
    WrongType { field: String, expected: String, found: String },
    #[error("{field} must be {range}, not {value}")]
    OutOfRange { field: String, range: &'static str, value: f64 },
    #[error("{field} cannot be {word:?}{}; it can be {}", did_you_mean(nearest), list(known), word = shown(word))]
    UnknownWord { field: String, word: String, nearest: Option<String>, known: Vec<String> },
    #[error("{field} cannot be {word:?} here: it needs a program built with --features {feature}")]
    LeftOut { field: String, word: String, feature: &'static str },
    /// A field without meaning beside another, or without it; the reason is like `"without yield_stress"` or `"beside fix"`.
    #[error("{field} has no meaning {reason}")]
    Meaningless { field: String, reason: &'static str },
    /// None of several fields is there.
    #[error("{table} needs {fields}")]
    Incomplete { table: String, fields: &'static str },
    #[error("{field}: times must ascend, but point {} is not later than the one before", index + 1)]
    Amplitude { field: String, index: usize },
    #[error("two {what}s are named {name:?}; the other is in line {other}", name = shown(name))]
    Repeated { what: &'static str, name: String, other: usize },
    #[error(
        "{name:?} is a set of {nodes} nodes and has no facets: name a surface, in `.inp` files one of \
         `*SURFACE, TYPE=ELEMENT`",
        name = shown(name)
    )]
    NoFacets { name: String, nodes: usize },
    /// A name of nothing; `what` is `"material"`, `"node set"` or `"surface"`. Names that are `known` begin with the closest ones.
    #[error("no {what} is named {name:?}{}; there {}", did_you_mean(nearest), all(known, what), name = shown(name))]
    UnknownName { what: &'static str, name: String, nearest: Option<String>, known: Vec<String> },
    /// A set of a mesh file that holds what is not read.
    #[error("parts.{part}: {error}", part = shown(part))]
    UnreadSet { part: String, error: Arc<MeshError> },
    /// A shape that cannot be made.
    #[error("parts.{part}: {error}", part = shown(part))]
    Shape { part: String, error: ShapeError },
    /// A part that cannot be used.
    #[error("parts.{part}: {error}", part = shown(part))]
    Part { part: String, error: ModelError },
    #[error("parts.{part}.element says what hexahedra with 8 nodes are, but the mesh file has none for this part", part = shown(part))]
    NoHexahedra { part: String },
    /// Friction is measured on a straight line from where a node was when the increment began.
    #[error(
        "this boundary condition turns by {degrees:.0}° in an increment of {increment}, or against an earlier one: with friction it has to \
         be less than 180°, so that it is known which way slaves slide"
    )]
    TurnsTooFar { degrees: f64, increment: f64 },
    /// Two boundary conditions move one node differently; `other` is the line of the earlier one.
    #[error(
        "node {node} at ({}) is moved along {axis} by this boundary condition and, differently, by that in line {other}",
        triple(position)
    )]
    Conflict { node: usize, position: [f64; 3], axis: &'static str, other: usize },
    #[error(
        "the part {part:?} is rigid, but its node at ({}) is free along {axis}: a [[boundary]] has to fix, translate or \
         rotate all of its nodes along all axes",
        triple(position), part = shown(part)
    )]
    FreeRigidNode { part: String, position: [f64; 3], axis: &'static str },
    #[error("the surface {name:?} is rigid: a pressure on it has no effect", name = shown(name))]
    PressureOnRigid { name: String },
    #[error(
        "{inner} of the {count} facets of the surface {name:?} are not on the skin of its part, where alone something can touch or \
         press it", name = shown(name)
    )]
    InnerFacets { name: String, inner: usize, count: usize },
    #[error("both sides of the interface {name:?} are rigid", name = shown(name))]
    RigidInterface { name: String },
    #[error("the node at ({}) is on both sides of the interface {name:?}", triple(position), name = shown(name))]
    SharedNode { name: String, position: [f64; 3] },
    /// An interface that cannot be made.
    #[error(transparent)]
    Contact(ContactError),
    #[error("the interface {name:?} cannot adjust its slaves: {error}", name = shown(name))]
    Adjust { name: String, error: AdjustError },
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
