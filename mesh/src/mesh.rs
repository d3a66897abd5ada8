//! The mesh as its users see it: nodes, elements, named sets.

use std::collections::{BTreeMap, BTreeSet};

use crate::element::{Element, Facet};
use crate::error::MeshError;
use crate::names;

/// A finite element mesh with named sets.
///
/// Nodes and elements keep the order of the file and are referred to by index, from 0; their numbers in the
/// file are called tags. Sets are sorted by index and hold nothing twice.
///
/// # Names
///
/// A set is found by its exact name or, failing that, by its name in other letter case, if that is unique
/// (Abaqus does not tell case apart, Gmsh does). Node sets, element sets and surfaces are three name spaces, as
/// in Abaqus; [`facets`](Self::facets) and [`nodes_of`](Self::nodes_of) say in which order they look.
///
/// | file | node sets | element sets | surfaces |
/// | --- | --- | --- | --- |
/// | Gmsh | | physical groups (several of one name are united; one without a name is called `"surface 3"` after its dimension and tag) | physical surfaces that reverse an entity |
/// | Abaqus | `*NSET`, `*NODE, NSET=`, `*SURFACE, TYPE=NODE` | `*ELSET`, `*ELEMENT, ELSET=` | `*SURFACE, TYPE=ELEMENT` |
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    pub(crate) nodes: Vec<[f64; 3]>,
    pub(crate) node_tags: Vec<u64>,
    pub(crate) elements: Vec<Element>,
    pub(crate) node_sets: BTreeMap<String, Vec<usize>>,
    pub(crate) element_sets: BTreeMap<String, Vec<usize>>,
    pub(crate) surfaces: BTreeMap<String, Vec<Facet>>,
    pub(crate) unread: Unread,
    pub(crate) stiff: Vec<(usize, String)>,
    pub(crate) constraints: Vec<UnreadConstraint>,
}

/// A keyword of an Abaqus file that ties nodes to one another: it is not in the mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnreadConstraint {
    /// Its name in upper case, as in `RIGID BODY`.
    pub keyword: &'static str,
    /// Its line in the file, from 1.
    pub line: usize,
    /// The element set that a rigid body is made of.
    pub elements: Option<String>,
}

/// An element of a type that is not supported: it is not in the mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnreadElement {
    /// Its number in the file.
    pub tag: u64,
    /// Its type as the file names it, in upper case.
    pub kind: String,
    /// Its line in the file, from 1.
    pub line: usize,
}

/// Why a set cannot be used.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Lost {
    /// It holds this one of the elements that are not read.
    Element(usize),
    /// A member in this line is no label.
    Label { label: String, line: usize },
}

/// Elements of types that are not supported, and why sets and surfaces cannot be used that hold any. Of surfaces the first
/// face identifier that is not supported, too.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Unread {
    pub elements: Vec<UnreadElement>,
    pub in_sets: BTreeMap<String, Lost>,
    pub in_surfaces: BTreeMap<String, Lost>,
    pub faces: BTreeMap<String, String>,
}

impl Mesh {
    /// Coordinates of the nodes.
    pub fn nodes(&self) -> &[[f64; 3]] {
        &self.nodes
    }

    /// The numbers of the nodes in the file.
    pub fn node_tags(&self) -> &[u64] {
        &self.node_tags
    }

    /// All elements, of all kinds.
    pub fn elements(&self) -> &[Element] {
        &self.elements
    }

    /// Elements of types that are not supported; whoever asks for a set that holds one gets an error.
    pub fn unread_elements(&self) -> &[UnreadElement] {
        &self.unread.elements
    }

    /// The element sets and surfaces that are refused where they are asked for, with the error. A node set of the same name can be used.
    pub fn unread_sets(&self) -> BTreeMap<&str, MeshError> {
        let sets = self.unread.in_sets.iter().chain(&self.unread.in_surfaces);
        let sets = sets.map(|(name, lost)| (name.as_str(), self.refusal(name, lost)));
        let faces = self.unread.faces.iter().map(|(name, face)| {
            (name.as_str(), MeshError::UnsupportedFace { name: name.clone(), face: face.clone() })
        });
        sets.chain(faces).collect()
    }

    /// Trusses, beams, shells, membranes and elements in a plane with a section in an Abaqus file, by index and type: they are lines and
    /// facets of the mesh, without the stiffness they have there.
    pub fn stiff_lines_and_facets(&self) -> &[(usize, String)] {
        &self.stiff
    }

    /// Constraints between nodes that an Abaqus file has, of the instance that is read and of the whole assembly: the mesh goes without them.
    pub fn unread_constraints(&self) -> &[UnreadConstraint] {
        &self.constraints
    }

    /// Sets of nodes by name, as node indices.
    pub fn node_sets(&self) -> &BTreeMap<String, Vec<usize>> {
        &self.node_sets
    }

    /// Sets of elements by name, as element indices.
    pub fn element_sets(&self) -> &BTreeMap<String, Vec<usize>> {
        &self.element_sets
    }

    /// Surfaces by name that are more than a set of elements: faces of solids, reversed facets.
    pub fn surfaces(&self) -> &BTreeMap<String, Vec<Facet>> {
        &self.surfaces
    }

    /// The names of all sets and surfaces, sorted, each once.
    pub fn set_names(&self) -> Vec<&str> {
        let names: BTreeSet<&str> = self
            .node_sets
            .keys()
            .chain(self.element_sets.keys())
            .chain(self.surfaces.keys())
            .map(String::as_str)
            .collect();
        names.into_iter().collect()
    }

    /// The facets of the surface, or else of the element set, of this name.
    ///
    /// Of an element set these are its triangles and quadrilaterals; elements of other kinds do not count. A face with nodes in the
    /// middle of its edges counts as the facets between them.
    /// The result is never empty: a set without facets is an error.
    pub fn facets(&self, name: &str) -> Result<Vec<Facet>, MeshError> {
        let exact = self.surfaces.contains_key(name) || self.element_sets.contains_key(name);
        if let Some((spelling, surface)) = find(&self.surfaces, name, exact) {
            self.refuse_unread_surface(spelling, name)?;
            if !surface.is_empty() {
                return Ok(surface.clone());
            }
        }
        let mut facets = Vec::new();
        if let Some((spelling, elements)) = find(&self.element_sets, name, exact) {
            self.refuse_unread(&self.unread.in_sets, spelling, name)?;
            facets.extend(elements.iter().flat_map(|&index| self.elements[index].facets()));
        }
        if facets.is_empty() {
            let holds = self.content(name).ok_or_else(|| self.unknown_set(name))?;
            return Err(MeshError::NoFacets { name: name.into(), holds });
        }
        Ok(facets)
    }

    /// The nodes of the node set, or else the surface, or else the element set, of this name, as sorted indices.
    pub fn nodes_of(&self, name: &str) -> Result<Vec<usize>, MeshError> {
        let unite = |nodes: BTreeSet<usize>| nodes.into_iter().collect();
        let exact = self.is_spelled(name);
        if let Some((_, nodes)) = find(&self.node_sets, name, exact) {
            Ok(nodes.clone())
        } else if let Some((spelling, surface)) = find(&self.surfaces, name, exact) {
            self.refuse_unread_surface(spelling, name)?;
            Ok(unite(surface.iter().flat_map(Facet::nodes).copied().collect()))
        } else if let Some((spelling, elements)) = find(&self.element_sets, name, exact) {
            self.refuse_unread(&self.unread.in_sets, spelling, name)?;
            Ok(unite(elements.iter().flat_map(|&index| self.elements[index].nodes()).copied().collect()))
        } else {
            Err(self.unknown_set(name))
        }
    }

    /// The elements of the element set of this name, as sorted indices.
    pub fn elements_of(&self, name: &str) -> Result<&[usize], MeshError> {
        match find(&self.element_sets, name, self.element_sets.contains_key(name)) {
            Some((spelling, elements)) => {
                self.refuse_unread(&self.unread.in_sets, spelling, name)?;
                Ok(elements)
            }
            None => {
                let holds = self.content(name).ok_or_else(|| self.unknown_set(name))?;
                Err(MeshError::NoElements { name: name.into(), holds })
            }
        }
    }

    /// Whether a set or surface has this name as it is written.
    fn is_spelled(&self, name: &str) -> bool {
        self.node_sets.contains_key(name)
            || self.element_sets.contains_key(name)
            || self.surfaces.contains_key(name)
    }

    fn refuse_unread_surface(&self, spelling: &str, name: &str) -> Result<(), MeshError> {
        if let Some(face) = self.unread.faces.get(spelling) {
            return Err(MeshError::UnsupportedFace { name: name.into(), face: face.clone() });
        }
        self.refuse_unread(&self.unread.in_surfaces, spelling, name)
    }

    fn refuse_unread(
        &self,
        sets: &BTreeMap<String, Lost>,
        spelling: &str,
        name: &str,
    ) -> Result<(), MeshError> {
        sets.get(spelling).map_or(Ok(()), |lost| Err(self.refusal(name, lost)))
    }

    fn refusal(&self, name: &str, lost: &Lost) -> MeshError {
        let name = name.to_string();
        match lost {
            Lost::Element(index) => {
                let UnreadElement { tag, kind, line } = self.unread.elements[*index].clone();
                MeshError::UnreadElement { name, tag, kind, line }
            }
            Lost::Label { label, line } => MeshError::WrongLabel { name, label: label.clone(), line: *line },
        }
    }

    /// What there is by this name, in words.
    fn content(&self, name: &str) -> Option<String> {
        let exact = self.is_spelled(name);
        let mut counts = BTreeMap::new();
        let elements = find(&self.element_sets, name, exact).map(|(_, elements)| elements);
        for &index in elements.into_iter().flatten() {
            *counts.entry(self.elements[index].kind()).or_insert(0) += 1;
        }
        let mut parts: Vec<String> =
            counts.iter().map(|(kind, count)| format!("{count} {}", kind.plural())).collect();
        let surface = find(&self.surfaces, name, exact);
        parts.extend(surface.map(|(_, facets)| format!("{} facets", facets.len())));
        let nodes = find(&self.node_sets, name, exact);
        parts.extend(nodes.map(|(_, nodes)| format!("{} nodes", nodes.len())));
        if parts.is_empty() && elements.is_some() {
            parts.push("nothing".into());
        }
        (!parts.is_empty()).then(|| parts.join(", "))
    }

    fn unknown_set(&self, name: &str) -> MeshError {
        let available = self.set_names();
        MeshError::UnknownSet {
            name: name.into(),
            nearest: names::nearest(name, available.iter().copied()).map(String::from),
            available: names::closest_first(name, available).into_iter().map(String::from).collect(),
        }
    }
}

/// The entry of this name. Unless it has to be `exact`, as it has if any of the name spaces in question has it so, the only one whose name
/// differs by letter case alone. With it, how the name is spelled.
fn find<'a, T>(sets: &'a BTreeMap<String, T>, name: &str, exact: bool) -> Option<(&'a String, &'a T)> {
    if exact {
        return sets.get_key_value(name);
    }
    let folded = name.to_lowercase();
    let mut alike = sets.iter().filter(|(candidate, _)| candidate.to_lowercase() == folded);
    match (alike.next(), alike.next()) {
        (found, None) => found,
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_in_other_case_only_if_unique() {
        let sets = BTreeMap::from([("A".to_string(), 1), ("a".to_string(), 2), ("Plate".to_string(), 3)]);
        assert_eq!(find(&sets, "a", true), Some((&"a".to_string(), &2)));
        assert_eq!(find(&sets, "PLATE", false), Some((&"Plate".to_string(), &3)));
        assert_eq!([find(&sets, "b", false), find(&sets, "b", true)], [None; 2]);
        let both = BTreeMap::from([("Ab".to_string(), 1), ("aB".to_string(), 2)]);
        assert_eq!(find(&both, "ab", false), None);
    }
}
