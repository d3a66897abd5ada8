//! What can be wrong with shapes, parts and models.

use diffuse_contact_mesh::names::shown;
use diffuse_contact_mesh::{MeshError, advice_on};

/// The order of the nodes of tetrahedra, wedges and hexahedra, in Abaqus' and Gmsh's files alike.
const ORDER: &str = "; below 0 its nodes are in the wrong order: those of the first face have to turn counter-clockwise as seen from the others";

/// A shape that cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum ShapeError {
    #[error("{field} must be {range}, not {value}")]
    OutOfRange { field: &'static str, range: &'static str, value: f64 },
    /// The shape would have more than [`MAX_NODES`](super::MAX_NODES) nodes.
    #[error("these divisions make {count} nodes; at most {limit} are possible")]
    TooManyNodes { count: f64, limit: usize },
    /// The shape is more than the machine has memory for.
    #[error(
        "these divisions make {count} nodes; a run with them needs about {gigabytes:.0} GB of memory besides its factors"
    )]
    NoMemory { count: f64, gigabytes: f64 },
}

/// Parts that make no model. Nodes and elements count from 0 in the order of the part, corners in that of the element. `label` is an
/// element's number in the mesh file, if the part is from one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum ModelError {
    /// A name is empty or has a dot, which separates the names of a part and of its sets.
    #[error("a part cannot be named {part:?}: a name is not empty and has no dot", part = shown(part))]
    InvalidName { part: String },
    #[error("two parts are named {part:?}", part = shown(part))]
    RepeatedPart { part: String },
    /// A part has no nodes, or nothing that uses them.
    #[error("the part {part:?} has neither elements nor facets", part = shown(part))]
    EmptyPart { part: String },
    #[error("the part {part:?} has solid elements and needs a material", part = shown(part))]
    NoMaterial { part: String },
    /// A material is for an element set that the part has not. `known` are those that hold elements of the part.
    #[error(
        "the part {part:?} has no element set {set:?}{}",
        hint(nearest.as_deref(), known),
        part = shown(part),
        set = shown(set)
    )]
    NoElementSet { part: String, set: String, nearest: Option<String>, known: Vec<String> },
    #[error(
        "element {} of the part {part:?} is in the sets {:?} and {:?}, which both have a material",
        number_of(*element, *label),
        shown(&sets[0]),
        shown(&sets[1]),
        part = shown(part)
    )]
    TwoMaterials { part: String, element: usize, label: Option<u64>, sets: [String; 2] },
    #[error(
        "the part {part:?} has elements in no set that has a material: {count}, the first is element {}",
        number_of(*element, *label),
        part = shown(part)
    )]
    ElementWithoutMaterial { part: String, element: usize, label: Option<u64>, count: usize },
    /// A part without elements has a material.
    #[error("the part {part:?} is rigid: a material has no meaning", part = shown(part))]
    RigidMaterial { part: String },
    /// More than [`MAX_NODES`](super::MAX_NODES) nodes in all.
    #[error("the parts have {count} nodes together; at most {limit} are possible")]
    TooManyNodes { count: f64, limit: usize },
    /// A node of a set, a facet or an element does not exist.
    #[error("the part {part:?} refers to node {node}, but it has {count} nodes", part = shown(part))]
    NodeOutOfRange { part: String, node: usize, count: usize },
    #[error("the part {part:?} has a set with element {element}, but it has {count} elements", part = shown(part))]
    ElementOutOfRange { part: String, element: usize, count: usize },
    #[error(
        "node {node} of the part {part:?} has a coordinate that is not a finite number below 1e75: {value:?}", part = shown(part)
    )]
    NonFinitePosition { part: String, node: usize, value: f64 },
    /// An element is turned inside out or flat at one of its corners. The triple product is 1 at the corner of a cube.
    #[error(
        "element {} of the part {part:?} is inside out, flat or not convex: the triple product of the directions of the edges at its \
         corner {} is {jacobian:e}{}",
        number_of(*element, *label),
        corner + 1, if *jacobian < 0.0 { ORDER } else { "" }, part = shown(part)
    )]
    InvertedElement { part: String, element: usize, label: Option<u64>, corner: usize, jacobian: f64 },
    /// Two elements have the same nodes, or are both on one side of a face: its nodes would count as inside.
    #[error(
        "elements {} and {} of the part {part:?} lie on one another: they share {shared} corners in a way that neighbours do not",
        number_of(*element, *label),
        number_of(*other, *other_label), part = shown(part)
    )]
    OverlappingElements {
        part: String,
        element: usize,
        label: Option<u64>,
        other: usize,
        other_label: Option<u64>,
        shared: usize,
    },
    /// Two elements share the corners of a face, but not the nodes in the middle of its edges: the face would gape.
    #[error(
        "elements {} and {} of the part {part:?} share the corners of a face, but one has a node in the middle of it or of an edge that \
         the other has not",
        number_of(*element, *label),
        number_of(*other, *other_label), part = shown(part)
    )]
    HangingNodes { part: String, element: usize, label: Option<u64>, other: usize, other_label: Option<u64> },
    /// A mesh file cannot be read, or has no such set.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A solid element was not read, and nothing says that it is no part of this part.
    #[error(
        "element {tag} (line {line} of the mesh file) is of type {kind}, which is not supported; `elements` can name a set without it, \
         docs/how-to/decks.md lists what is supported{}",
        advice_on(kind), kind = shown(kind)
    )]
    UnreadSolid { tag: u64, kind: String, line: usize },
    /// A mesh file has no solid elements where a solid part was asked for. `set` is `None` for the whole file.
    #[error("the mesh file has no solid elements{}", in_set(set))]
    NoSolids { set: Option<String> },
}

/// Another name, or all of them.
fn hint(nearest: Option<&str>, known: &[String]) -> String {
    match (nearest, known) {
        (Some(name), _) => format!(" (did you mean {:?}?)", shown(name)),
        (None, []) => "; it has none".into(),
        (None, _) => {
            let names: Vec<String> = known.iter().take(8).map(|name| format!("{:?}", shown(name))).collect();
            let more = if known.len() > names.len() { ", …" } else { "" };
            format!("; it has {}{more}", names.join(", "))
        }
    }
}

/// An element as messages give it: by its number in the mesh file, or counted from 1.
fn number_of(element: usize, label: Option<u64>) -> String {
    label.map_or_else(|| (element + 1).to_string(), |label| format!("{label} (in the mesh file)"))
}

fn in_set(set: &Option<String>) -> String {
    set.as_ref().map_or_else(String::new, |set| format!(" in the element set {:?}", shown(set)))
}
