//! One part before it joins a model: nodes, elements or rigid facets, sets by their short names.

use std::collections::BTreeMap;
use std::sync::Arc;

use diffuse_contact::surface::Facet;
use diffuse_contact_mesh::{ElementKind, MeshError, UnreadConstraint};
use nalgebra::Vector3;

use super::cells::{Cell, Misfit};
use super::{Cells, ModelError, Rotation};

/// Nodes a model may have.
pub const MAX_NODES: usize = 20_000_000;
/// Coordinates stay below, where products of three lengths are finite: the bound of contact surfaces.
pub(super) const MAX_COORDINATE: f64 = 1e75;
/// What the triple product of the directions of the edges at a corner of an element exceeds.
const SMALLEST_JACOBIAN: f64 = 1e-6;

/// A part. Indices are those of its own nodes.
#[derive(Clone, Debug, Default)]
pub struct Part {
    /// Positions, length.
    pub nodes: Vec<[f64; 3]>,
    /// Its elements; a part without is rigid.
    pub elements: Cells,
    /// The numbers that the mesh file gives them; none if there is no file.
    pub labels: Vec<u64>,
    /// All facets of a rigid part, oriented outward; empty for others, whose skin follows from the elements.
    pub facets: Vec<Facet>,
    /// Elements by name, ascending: the sets of a mesh file.
    pub element_sets: BTreeMap<String, Vec<usize>>,
    /// Nodes by name, ascending.
    pub node_sets: BTreeMap<String, Vec<usize>>,
    /// Facets by name, oriented outward.
    pub surfaces: BTreeMap<String, Vec<Facet>>,
    /// Numbers of facets that a mesh file counts to a surface although they are not on the part's skin.
    pub inner_facets: BTreeMap<String, usize>,
    /// Sets and surfaces of the mesh file that are refused where they are asked for, with the error.
    pub unread_sets: BTreeMap<String, Arc<MeshError>>,
    /// Constraints between nodes that the mesh file has: they are not kept.
    pub unread_constraints: Vec<UnreadConstraint>,
    /// Types of springs, beams and the like that the mesh file has and nothing reads, and how many elements there are of each.
    pub unread_elements: BTreeMap<String, usize>,
    /// The numbers of its nodes in the mesh file; none if there is no file or the part is rigid.
    pub node_labels: Vec<u64>,
}

impl Part {
    /// Turns the part about an axis.
    pub fn rotate(&mut self, rotation: &Rotation) {
        for node in &mut self.nodes {
            *node = rotation.turned(*node, 1.0);
        }
    }

    /// Moves the part.
    pub fn translate(&mut self, by: [f64; 3]) {
        for node in &mut self.nodes {
            (0..3).for_each(|k| node[k] += by[k]);
        }
    }

    /// All facets of the outside: those of a rigid part, the skin of a solid.
    pub fn outside(&self) -> Vec<Facet> {
        if self.elements.is_empty() { self.facets.clone() } else { self.elements.skin() }
    }

    /// Names the nodes where `belongs` holds, and the facets of `outside` all of whose corners are among them.
    pub(super) fn name_face(&mut self, name: &str, outside: &[Facet], belongs: impl Fn(usize) -> bool) {
        let facets: Vec<Facet> =
            outside.iter().filter(|facet| facet.corners().iter().all(|&n| belongs(n))).copied().collect();
        self.node_sets.insert(name.into(), (0..self.nodes.len()).filter(|&n| belongs(n)).collect());
        if !facets.is_empty() {
            self.surfaces.insert(name.into(), facets);
        }
    }

    /// Checks what [`Model::add`](super::Model::add) promises; `name` is that of the part, for messages.
    pub(super) fn check(&self, name: &str) -> Result<(), ModelError> {
        let part = || name.to_string();
        let count = self.nodes.len();
        if self.elements.is_empty() && self.facets.is_empty() {
            return Err(ModelError::EmptyPart { part: part() });
        }
        let facets = self.facets.iter().chain(self.surfaces.values().flatten());
        let named = self.node_sets.values().flatten().chain(facets.flat_map(|facet| facet.corners()));
        if let Some(&node) = self.elements.nodes().iter().chain(named).find(|&&node| node >= count) {
            return Err(ModelError::NodeOutOfRange { part: part(), node, count });
        }
        let count = self.elements.len();
        if let Some(&element) = self.element_sets.values().flatten().find(|&&element| element >= count) {
            return Err(ModelError::ElementOutOfRange { part: part(), element, count });
        }
        for (node, position) in self.nodes.iter().enumerate() {
            if let Some(&value) = position.iter().find(|value| !(value.abs() < MAX_COORDINATE)) {
                return Err(ModelError::NonFinitePosition { part: part(), node, value });
            }
        }
        for (element, cell) in self.elements.iter().enumerate() {
            for corner in 0..cell.kind.corner_count() {
                let jacobian = corner_jacobian(&self.nodes, cell, corner);
                if !(jacobian > SMALLEST_JACOBIAN) {
                    let label = self.labels.get(element).copied();
                    return Err(ModelError::InvertedElement {
                        part: part(),
                        element,
                        label,
                        corner,
                        jacobian,
                    });
                }
            }
        }
        let label = |element: usize| self.labels.get(element).copied();
        match self.elements.misfit() {
            Some((other, element, misfit)) => {
                let (label, other_label) = (label(element), label(other));
                Err(match misfit {
                    Misfit::Overlapping { shared } => ModelError::OverlappingElements {
                        part: part(),
                        element,
                        label,
                        other,
                        other_label,
                        shared,
                    },
                    Misfit::Hanging => {
                        ModelError::HangingNodes { part: part(), element, label, other, other_label }
                    }
                })
            }
            None => Ok(()),
        }
    }
}

/// Triple product of the directions of the edges that leave a corner, at most 1: positive where the map from the reference element
/// keeps its orientation.
fn corner_jacobian(positions: &[[f64; 3]], cell: Cell<'_>, corner: usize) -> f64 {
    let at = |n: usize| Vector3::from(positions[cell.nodes[n]]);
    let [a, b, c] = neighbours(cell.kind)[corner].map(|n| at(n) - at(corner));
    if [a, b, c].iter().any(|edge| edge.amax() == 0.0) {
        return 0.0;
    }
    let [a, b, c] = [a, b, c].map(|edge| (edge / edge.amax()).normalize());
    a.cross(&b).dot(&c)
}

/// The corners next to each corner, in a right-handed order.
const fn neighbours(kind: ElementKind) -> &'static [[usize; 3]] {
    match kind.corner_count() {
        4 => &[[1, 2, 3], [2, 0, 3], [0, 1, 3], [0, 2, 1]],
        6 => &[[1, 2, 3], [2, 0, 4], [0, 1, 5], [5, 4, 0], [3, 5, 1], [4, 3, 2]],
        _ => &[[1, 3, 4], [2, 0, 5], [3, 1, 6], [0, 2, 7], [7, 5, 0], [4, 6, 1], [5, 7, 2], [6, 4, 3]],
    }
}
