//! What can be wrong with a mesh file, or with a question asked of a mesh.

use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::file::reason;
use crate::names::{self, shown};

/// Why there is no mesh, or no such set in it. Each message is one sentence that can be shown as it stands.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum MeshError {
    /// The file cannot be read at all.
    #[error("{path}: cannot be read: {}", reason(cause))]
    Read { path: PathBuf, cause: std::io::Error },
    /// Neither the extension nor the content tells the format.
    #[error(
        "{path}: not a mesh format known here; expected Gmsh .msh (begins with $MeshFormat) or Abaqus .inp \
         (begins with a * keyword)"
    )]
    UnknownFormat { path: PathBuf },
    /// The file breaks its format, or uses something this reader does not support.
    #[error("{path}, {place}: {problem}")]
    Invalid { path: PathBuf, place: Place, problem: Problem },
    /// The file is well formed but holds no nodes, or nodes and no elements.
    #[error("{path}: the mesh has no {what}")]
    Empty { path: PathBuf, what: &'static str },
    /// All of its elements are of types that are not supported. `kinds` are these types, sorted.
    #[error(
        "{path}: none of the mesh's elements is of a type that is supported: they are of type {}; {SUPPORTED}{}",
        names::list(kinds.iter().map(shown)),
        kinds.iter().map(|kind| advice_on(kind)).find(|advice| !advice.is_empty()).unwrap_or_default()
    )]
    NothingSupported { path: PathBuf, kinds: Vec<String> },
    /// An instance was asked of a file of a format that has none.
    #[error("{path}: a Gmsh file has no instances, and so none that is named {name:?}", name = shown(name))]
    NoInstances { path: PathBuf, name: String },
    /// The set holds an element that was not read, because its type is not supported. `kind` is the type as the file names it.
    #[error(
        "the set {name:?} holds element {tag} of type {kind} (line {line} of the mesh file), which is not supported; {SUPPORTED}{}",
        advice_on(kind), name = shown(name), kind = shown(kind)
    )]
    UnreadElement { name: String, tag: u64, kind: String, line: usize },
    /// The element set has a member that is a number and no label.
    #[error(
        "the set {name:?} has the member {label} (line {line} of the mesh file), but labels of elements are positive whole numbers",
        name = shown(name), label = shown(label)
    )]
    WrongLabel { name: String, label: String, line: usize },
    /// The surface has edges, ends or all free faces of elements, which are not read. `face` is the first such identifier; it is empty for
    /// all free faces.
    #[error(
        "the surface {name:?} has the face identifier {face:?}, an edge or free faces there, which are no facets; facets are SPOS and SNEG of shells, S1 to S6 of solids",
        name = shown(name),
        face = shown(face)
    )]
    UnsupportedFace { name: String, face: String },
    /// No set has this name. `nearest` is the existing name closest in spelling, if one is close; `available` are all names, the closest
    /// first and those that Gmsh makes up last.
    #[error("no set is named {name:?}{}; {}", did_you_mean(nearest.as_deref()), list_of(available), name = shown(name))]
    UnknownSet { name: String, nearest: Option<String>, available: Vec<String> },
    /// The set exists, but none of its members is a triangle or a quadrilateral.
    #[error("the set {name:?} has no triangles or quadrilaterals to serve as facets: it holds {holds}", name = shown(name))]
    NoFacets { name: String, holds: String },
    /// The set exists, but it is not a set of elements.
    #[error("the set {name:?} is not an element set: it holds {holds}", name = shown(name))]
    NoElements { name: String, holds: String },
}

const SUPPORTED: &str = "supported are points, lines, triangles, quadrilaterals, tetrahedra, wedges and hexahedra of first and \
                         second order, except 18-node wedges and, in Abaqus files, 9-node quadrilaterals and 27-node hexahedra";

/// What helps with an element type that is not supported, as the end of a sentence; empty if nothing is known to. Types are those of
/// Abaqus or, of Gmsh, as the reader's messages have them.
pub fn advice_on(kind: &str) -> &'static str {
    if kind.starts_with("C3D27") {
        "; Gmsh's option Mesh.SecondOrderIncomplete = 1 writes C3D20 instead, and .msh 4.1 files may have 27-node hexahedra"
    } else if ["M3D9", "S9", "SFM3D9"].iter().any(|begin| kind.starts_with(begin)) {
        "; Gmsh's option Mesh.SecondOrderIncomplete = 1 writes 8-node quadrilaterals instead, and .msh 4.1 files may have those with 9"
    } else if kind.starts_with("C3D18") || kind.contains("18-node") {
        "; Gmsh's option Mesh.SecondOrderIncomplete = 1 writes 15-node wedges instead"
    } else {
        ""
    }
}

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

/// What is wrong at one place of a mesh file. Nodes and elements are named by their tags.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum Problem {
    /// The file ends too early.
    #[error("the file ends before {expected}")]
    Truncated { expected: String },
    /// Something else stands where the format wants a certain thing.
    #[error("expected {expected}, found {found:?}", found = shown(found))]
    Unexpected { expected: String, found: String },
    /// A version of the MSH format other than 4.1.
    #[error(
        "MSH version {version} is not supported; save the mesh as version 4.1, for example with \
         `gmsh old.msh -save -format msh41 -o new.msh`"
    )]
    UnsupportedVersion { version: String },
    /// An element type that is not read here. `name` is that of the file or of the format's manual.
    #[error("element type {name} is not supported; {SUPPORTED}{}", advice_on(name))]
    UnsupportedElement { name: String },
    /// A feature of the format that would change the mesh and is not supported.
    #[error("{feature} is not supported; {advice}")]
    UnsupportedFeature { feature: String, advice: &'static str },
    /// A file has several instances, and none was asked for.
    #[error("the file has several instances, and one has to be named; {}", list("there are", available))]
    SeveralInstances { available: Vec<String> },
    /// A file does not have the instance that was asked for.
    #[error("no instance is named {name:?}; {}", list("there are", available), name = shown(name))]
    UnknownInstance { name: String, available: Vec<String> },
    /// Sets hold more nodes or elements than can be meant, counted as often as they are named.
    #[error("the sets name {what} more than {limit} times altogether")]
    SetsTooLarge { what: &'static str, limit: usize },
    /// Two nodes share a tag.
    #[error("node {tag} is defined twice")]
    DuplicateNode { tag: u64 },
    /// Two elements share a tag.
    #[error("element {tag} is defined twice")]
    DuplicateElement { tag: u64 },
    /// A coordinate is NaN or infinite.
    #[error("node {tag} has the {axis} coordinate {value}, which is not a finite number")]
    NonFiniteCoordinate { tag: u64, axis: char, value: f64 },
    /// An element refers to a node that does not exist.
    #[error("element {element} refers to node {node}, which does not exist")]
    MissingNode { element: u64, node: u64 },
    /// An element uses a node more than once.
    #[error("element {element} uses node {node} more than once; collapsed elements are not supported")]
    RepeatedNode { element: u64, node: u64 },
    /// A header announces another number of things than follow.
    #[error("the header announces {declared} {what}, but the section holds {found}")]
    CountMismatch { what: &'static str, declared: u64, found: u64 },
    /// A header announces more things than the rest of the file has room for.
    #[error("the header announces {declared} {what}, but the file ends before so many")]
    CountTooLarge { what: &'static str, declared: u64 },
    /// A set or surface refers to something that does not exist, such as `node 7`, `element 7` or `element set "name"`.
    #[error("{set:?} refers to {member}, which does not exist", set = shown(set))]
    MissingMember { set: String, member: String },
    /// A set or surface has a member that is a number and no label.
    #[error("{set:?} has the member {label}, but labels of {what}s are positive whole numbers", set = shown(set), label = shown(label))]
    WrongLabel { set: String, label: String, what: &'static str },
    /// A surface names a face that the element does not have. `advice` names the faces that such an element has.
    #[error("face {face:?} does not belong to element {element}, a {kind}; {advice}", face = shown(face))]
    WrongFace { face: String, element: u64, kind: &'static str, advice: &'static str },
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

    pub fn unsupported(at: usize, feature: impl Into<String>, advice: &'static str) -> Self {
        Self::new(at, Problem::UnsupportedFeature { feature: feature.into(), advice })
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
