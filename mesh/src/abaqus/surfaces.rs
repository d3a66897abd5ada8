//! `*SURFACE`: faces of elements, or nodes.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use super::SetKind;
use super::sets::{Content, Entry, Found, Level, Member, Names, Room, Sets, Unusable};
use crate::element::{Element, Facet};
use crate::error::{Fault, Problem};

/// All surfaces of a file. Those of nodes and those of faces are numbered apart.
#[derive(Default)]
pub(super) struct Surfaces {
    of_faces: Names,
    faces: Vec<(Entry, Face)>,
    of_nodes: Names,
    nodes: Vec<Entry>,
    /// The first identifier of each surface of faces that is none of a whole facet.
    unsupported: BTreeMap<usize, String>,
    /// What is in the entries, those of nodes without a face: the same once more adds nothing.
    known: HashSet<(usize, Member, Option<Face>)>,
}

/// What is in a surface of faces.
#[derive(Clone, Default)]
pub(super) struct Faces {
    pub facets: Vec<Facet>,
    /// The first reason why these are not all.
    pub unread: Option<Unusable>,
    /// The first identifier in it that is not supported.
    pub unsupported: Option<String>,
}

/// A face identifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Face {
    /// `SPOS`: the side of a shell its normal points to.
    Positive,
    /// `SNEG`: the other side.
    Negative,
    /// `S1`, `S2`, ... of a solid, from 0.
    Number(usize),
}

impl Face {
    fn parse(text: &str) -> Option<Self> {
        let text = text.to_uppercase();
        match text.as_str() {
            "SPOS" => Some(Face::Positive),
            "SNEG" => Some(Face::Negative),
            _ => match text.strip_prefix('S')?.parse() {
                Ok(number @ 1..=6) => Some(Face::Number(number - 1)),
                _ => None,
            },
        }
    }

    /// Whether it is another identifier of Abaqus: an edge or an end, or the free faces that none at all stands for.
    fn is_other(text: &str) -> bool {
        let text = text.to_uppercase();
        let numbered = ["EDGE", "END", "E"].into_iter().find_map(|begin| text.strip_prefix(begin));
        text.is_empty() || numbered.is_some_and(|number| number.bytes().all(|digit| digit.is_ascii_digit()))
    }

    /// Empty if the element has no such face.
    fn facets(self, element: &Element) -> Vec<Facet> {
        match self {
            Face::Positive => element.facets(),
            Face::Negative => element.facets().into_iter().map(Facet::reversed).collect(),
            Face::Number(number) => element.face(number),
        }
    }
}

impl std::fmt::Display for Face {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Face::Positive => f.write_str("SPOS"),
            Face::Negative => f.write_str("SNEG"),
            Face::Number(number) => write!(f, "S{}", number + 1),
        }
    }
}

impl Surfaces {
    pub fn define(&mut self, kind: SetKind, level: Level, name: &str) -> usize {
        match kind {
            SetKind::Node => self.of_nodes.define(level, name),
            SetKind::Element => self.of_faces.define(level, name),
        }
    }

    pub fn add_nodes(&mut self, surface: usize, member: Member, at: usize) {
        if self.known.insert((surface, member, None)) {
            self.nodes.push(Entry { at, set: surface, member });
        }
    }

    pub fn add_face(&mut self, surface: usize, member: Member, face: &str, at: usize) -> Result<(), Fault> {
        let Some(face) = Face::parse(face) else {
            if Face::is_other(face) {
                self.unsupported.entry(surface).or_insert_with(|| face.to_uppercase());
                return Ok(());
            }
            let form = "a face identifier (SPOS, SNEG or S1 to S6) after the element set";
            return Err(Fault::unexpected(at, form, face));
        };
        if self.known.insert((surface, member, Some(face))) {
            self.faces.push((Entry { at, set: surface, member }, face));
        }
        Ok(())
    }

    /// What is in every surface of faces, each face once.
    pub fn resolve_facets(
        &self,
        element_sets: &Sets,
        elements_in: &[Content],
        find: impl Fn(u64) -> Found,
        elements: &[Element],
    ) -> Result<Vec<Faces>, Fault> {
        let mut surfaces = vec![Faces::default(); self.of_faces.count()];
        for (&surface, face) in &self.unsupported {
            surfaces[surface].unsupported = Some(face.clone());
        }
        let mut room = Room::new(element_sets.of);
        self.faces.iter().try_for_each(|(entry, _)| room.take(entry.member.count(elements_in), entry.at))?;
        let mut seen = HashSet::new();
        for &(entry @ Entry { at, set: surface, .. }, face) in &self.faces {
            let (indices, unread) = element_sets.members(entry, &self.of_faces, elements_in, &find)?;
            surfaces[surface].unread = surfaces[surface].unread.or(unread);
            for index in indices {
                let facets = face.facets(&elements[index]);
                let kind = elements[index].kind();
                if matches!(face, Face::Number(_)) && kind.dimension() == 2 {
                    // CalculiX numbers sides and edges of shells, and edges in a plane: a fault only where the surface is asked for.
                    surfaces[surface].unsupported.get_or_insert_with(|| face.to_string());
                    continue;
                }
                if facets.is_empty() {
                    return Err(Fault::new(at, wrong_face(face, &elements[index])));
                }
                if seen.insert((surface, index, face)) {
                    surfaces[surface].facets.extend(facets);
                }
            }
        }
        Ok(surfaces)
    }

    /// The nodes of every surface of nodes.
    pub fn resolve_nodes(
        &self,
        node_sets: &Sets,
        nodes_in: &[Content],
        find: impl Fn(u64) -> Found,
    ) -> Result<Vec<(usize, BTreeSet<usize>)>, Fault> {
        let mut surfaces = vec![(0, BTreeSet::new()); self.of_nodes.count()];
        let mut room = Room::new(node_sets.of);
        self.nodes.iter().try_for_each(|entry| room.take(entry.member.count(nodes_in), entry.at))?;
        for &entry in &self.nodes {
            let (members, _) = node_sets.members(entry, &self.of_nodes, nodes_in, &find)?;
            surfaces[entry.set].0 = entry.at;
            surfaces[entry.set].1.extend(members);
        }
        Ok(surfaces)
    }

    /// Adds the surfaces of nodes to the node sets, unless a name stands for two different sets then.
    pub fn merge_node_surfaces(
        &self,
        node_sets: &mut BTreeMap<String, Vec<usize>>,
        surfaces: Vec<(usize, BTreeSet<usize>)>,
        owner: &str,
    ) -> Result<(), Fault> {
        for (name, (at, nodes)) in self.of_nodes.publish(surfaces, owner) {
            let nodes: Vec<usize> = nodes.into_iter().collect();
            let alike = node_sets.iter().find(|(other, _)| other.to_uppercase() == name.to_uppercase());
            match alike {
                Some((_, others)) if *others == nodes => {}
                Some(_) => {
                    let feature = format!("a *SURFACE of nodes with the name {name:?} of a different *NSET");
                    return Err(Fault::unsupported(at, feature, "rename one of the two"));
                }
                None => {
                    node_sets.insert(name, nodes);
                }
            }
        }
        Ok(())
    }

    /// What belongs to every surface of faces, by name.
    pub fn publish<T>(&self, of_faces: Vec<T>, owner: &str) -> BTreeMap<String, T> {
        self.of_faces.publish(of_faces, owner)
    }
}

fn wrong_face(face: Face, element: &Element) -> Problem {
    let kind = element.kind();
    let advice = match (kind.dimension(), kind.faces().len()) {
        (2, _) => "its sides are SPOS and SNEG",
        (_, 4) => "its faces are S1 to S4",
        (_, 5) => "its faces are S1 to S5",
        (_, 6) => "its faces are S1 to S6",
        _ => "it has no faces",
    };
    Problem::WrongFace { face: face.to_string(), element: element.tag(), kind: kind.name(), advice }
}
