//! What can be wrong with a mesh file, or with a question asked of a mesh.

use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::file::reason;
use crate::names::{self, shown};

/// Why there is no mesh, or no such set in it. Each message is one sentence that can be shown as it stands.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MeshError {
    /// The file cannot be read at all.
    #[error("{path}: cannot be read: {}", reason(cause))]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        cause: std::io::Error,
    },
    /// Neither the extension nor the content tells the format.
    #[error(
        "{path}: not a mesh format known here; expected Gmsh .msh (begins with $MeshFormat) or Abaqus .inp \
         (begins with a * keyword)"
    )]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// The file breaks its format, or uses something this reader does not support.
    #[error("{path}, {place}: {problem}")]
    Invalid {
        /// The file.
        path: PathBuf,
        /// Where in the file.
        place: Place,
        /// What is wrong there.
        problem: Problem,
    },
    /// The file is well formed but holds no nodes, or nodes and no elements.
    #[error("{path}: the mesh has no {what}")]
    Empty {
        /// The file.
        path: PathBuf,
        /// `"nodes"` or `"elements"`.
        what: &'static str,
    },
    /// All of its elements are of types that are not supported.
    #[error(
        "{path}: none of the mesh's elements is of a type that is supported: they are of type {}; {SUPPORTED}",
        names::list(kinds.iter().map(shown))
    )]
    NothingSupported {
        /// The file.
        path: PathBuf,
        /// Their types, sorted.
        kinds: Vec<String>,
    },
    /// An instance was asked of a file of a format that has none.
    #[error("{path}: a Gmsh file has no instances, and so none that is named {name:?}", name = shown(name))]
    NoInstances {
        /// The file.
        path: PathBuf,
        /// The instance asked for.
        name: String,
    },
    /// The set holds an element that was not read, because its type is not supported.
    #[error("the set {name:?} holds element {tag} of type {kind}, which is not supported; {SUPPORTED}", name = shown(name))]
    UnreadElement {
        /// The name of the set.
        name: String,
        /// The element's tag.
        tag: u64,
        /// Its type as the file names it.
        kind: String,
    },
    /// The surface has edges, ends or all free faces of elements, which are not read.
    #[error(
        "the surface {name:?} has the face identifier {face:?}, which is not supported; supported are SPOS, SNEG and S1 to S6",
        name = shown(name),
        face = shown(face)
    )]
    UnsupportedFace {
        /// The name of the surface.
        name: String,
        /// The first such identifier; empty for all free faces.
        face: String,
    },
    /// No set has this name.
    #[error("no set is named {name:?}{}; {}", did_you_mean(nearest.as_deref()), list_of(available), name = shown(name))]
    UnknownSet {
        /// The name asked for.
        name: String,
        /// The existing name closest in spelling, if one is close.
        nearest: Option<String>,
        /// Every name there is, sorted.
        available: Vec<String>,
    },
    /// The set exists, but none of its members is a triangle or a quadrilateral.
    #[error("the set {name:?} has no triangles or quadrilaterals to serve as facets: it holds {holds}", name = shown(name))]
    NoFacets {
        /// The name of the set.
        name: String,
        /// What it holds instead.
        holds: String,
    },
    /// The set exists, but it is not a set of elements.
    #[error("the set {name:?} is not an element set: it holds {holds}", name = shown(name))]
    NoElements {
        /// The name of the set.
        name: String,
        /// What it holds instead.
        holds: String,
    },
}

const SUPPORTED: &str = "supported are points, lines, triangles, quadrilaterals, tetrahedra, wedges and hexahedra of first and \
                         second order, except 18-node wedges";

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line of a text file, counted from 1.
    Line(usize),
    /// A byte of a binary file, counted from 0.
    Byte(usize),
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Place::Line(line) => write!(f, "line {line}"),
            Place::Byte(byte) => write!(f, "byte {byte}"),
        }
    }
}

/// What is wrong at one place of a mesh file.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Problem {
    /// The file ends too early.
    #[error("the file ends before {expected}")]
    Truncated {
        /// What should have followed.
        expected: String,
    },
    /// Something else stands where the format wants a certain thing.
    #[error("expected {expected}, found {found:?}", found = shown(found))]
    Unexpected {
        /// What the format wants here.
        expected: String,
        /// What stands here.
        found: String,
    },
    /// A version of the MSH format other than 4.1.
    #[error(
        "MSH version {version} is not supported; save the mesh as version 4.1, for example with \
         `gmsh old.msh -save -format msh41 -o new.msh`"
    )]
    UnsupportedVersion {
        /// The version the file declares.
        version: String,
    },
    /// An element type that is not read here.
    #[error("element type {name} is not supported; {SUPPORTED}")]
    UnsupportedElement {
        /// The type as the file or the format's manual names it.
        name: String,
    },
    /// A feature of the format that would change the mesh and is not supported.
    #[error("{feature} is not supported; {advice}")]
    UnsupportedFeature {
        /// The feature.
        feature: String,
        /// What to do instead.
        advice: &'static str,
    },
    /// A file has several instances, and none was asked for.
    #[error("the file has several instances, and one has to be named; {}", list("there are", available))]
    SeveralInstances {
        /// Their names.
        available: Vec<String>,
    },
    /// A file does not have the instance that was asked for.
    #[error("no instance is named {name:?}; {}", list("there are", available), name = shown(name))]
    UnknownInstance {
        /// The name asked for.
        name: String,
        /// The names there are.
        available: Vec<String>,
    },
    /// Sets hold more nodes or elements than can be meant, counted as often as they are named.
    #[error("the sets name {what} more than {limit} times altogether")]
    SetsTooLarge {
        /// `"nodes"` or `"elements"`.
        what: &'static str,
        /// How many are read.
        limit: usize,
    },
    /// Two nodes share a tag.
    #[error("node {tag} is defined twice")]
    DuplicateNode {
        /// The tag.
        tag: u64,
    },
    /// Two elements share a tag.
    #[error("element {tag} is defined twice")]
    DuplicateElement {
        /// The tag.
        tag: u64,
    },
    /// A coordinate is NaN or infinite.
    #[error("node {tag} has the {axis} coordinate {value}, which is not a finite number")]
    NonFiniteCoordinate {
        /// The node's tag.
        tag: u64,
        /// `'x'`, `'y'` or `'z'`.
        axis: char,
        /// NaN or an infinity.
        value: f64,
    },
    /// An element refers to a node that does not exist.
    #[error("element {element} refers to node {node}, which does not exist")]
    MissingNode {
        /// The element's tag.
        element: u64,
        /// The tag of the missing node.
        node: u64,
    },
    /// An element uses a node more than once.
    #[error("element {element} uses node {node} more than once; collapsed elements are not supported")]
    RepeatedNode {
        /// The element's tag.
        element: u64,
        /// The node's tag.
        node: u64,
    },
    /// A header announces another number of things than follow.
    #[error("the header announces {declared} {what}, but the section holds {found}")]
    CountMismatch {
        /// What is counted.
        what: &'static str,
        /// The number in the header.
        declared: u64,
        /// The number found.
        found: u64,
    },
    /// A header announces more things than the rest of the file has room for.
    #[error("the header announces {declared} {what}, but the file ends before so many")]
    CountTooLarge {
        /// What is counted.
        what: &'static str,
        /// The number in the header.
        declared: u64,
    },
    /// A set or surface refers to something that does not exist.
    #[error("{set:?} refers to {member}, which does not exist", set = shown(set))]
    MissingMember {
        /// The set or surface.
        set: String,
        /// `"node 7"`, `"element 7"` or `"element set \"name\""`.
        member: String,
    },
    /// A surface names a face that the element does not have.
    #[error("face {face:?} does not belong to element {element}, a {kind}; {advice}", face = shown(face))]
    WrongFace {
        /// The face identifier.
        face: String,
        /// The element's tag.
        element: u64,
        /// The element's kind.
        kind: &'static str,
        /// The identifiers such an element has.
        advice: &'static str,
    },
}

/// How many lines end in these bytes.
pub(crate) fn newlines(bytes: &[u8]) -> usize {
    bytes.iter().filter(|&&byte| byte == b'\n').count()
}

/// A problem and the byte at which it was met: what the readers raise before path and line are known.
#[derive(Debug)]
pub(crate) struct Fault {
    pub at: usize,
    pub problem: Problem,
}

impl Fault {
    pub fn new(at: usize, problem: Problem) -> Self {
        Self { at, problem }
    }

    pub fn truncated(at: usize, expected: impl Into<String>) -> Self {
        Self::new(at, Problem::Truncated { expected: expected.into() })
    }

    pub fn unexpected(at: usize, expected: impl Into<String>, found: impl AsRef<[u8]>) -> Self {
        Self::new(at, Problem::Unexpected { expected: expected.into(), found: excerpt(found.as_ref()) })
    }

    /// The error for a text file: the byte becomes a line number.
    pub fn in_text(self, path: &Path, bytes: &[u8]) -> MeshError {
        let before = &bytes[..self.at.min(bytes.len())];
        let line = 1 + newlines(before);
        MeshError::Invalid { path: path.into(), place: Place::Line(line), problem: self.problem }
    }

    /// The error for a binary file.
    pub fn in_binary(self, path: &Path) -> MeshError {
        MeshError::Invalid { path: path.into(), place: Place::Byte(self.at), problem: self.problem }
    }
}

/// The beginning of what was found, short enough for a message.
fn excerpt(found: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text = String::from_utf8_lossy(&found[..found.len().min(4 * LONGEST)]);
    let mut short: String = text.trim().chars().take(LONGEST).collect();
    if text.trim().chars().nth(LONGEST).is_some() {
        short.push_str("...");
    }
    short
}

fn did_you_mean(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |name| format!(" (did you mean {:?}?)", shown(name)))
}

fn list_of(names: &[String]) -> String {
    if names.is_empty() { "the mesh has no named sets".into() } else { list("the mesh has", names) }
}

fn list(begin: &str, names: &[String]) -> String {
    if names.is_empty() {
        return format!("{begin} none");
    }
    format!("{begin} {}", names::list(names.iter().map(|name| format!("{:?}", shown(name)))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn excerpts_are_short_and_survive_invalid_text() {
        assert_eq!(excerpt(b" 12 "), "12");
        assert_eq!(excerpt(&[b'x'; 1000]).len(), 43);
        assert_eq!(excerpt(&[0xff, b'a']), "\u{fffd}a");
    }

    #[test]
    fn a_fault_counts_lines_from_one() {
        let fault = |at| Fault::truncated(at, "more").in_text(Path::new("m.msh"), b"a\nb\nc").to_string();
        assert_eq!(fault(0), "m.msh, line 1: the file ends before more");
        assert_eq!(fault(4), "m.msh, line 3: the file ends before more");
    }
}
