//! Collects nodes and elements by tag while a file is read, then checks them and turns tags into indices.

use std::collections::HashMap;

use crate::element::{Element, ElementKind, MOST_NODES};
use crate::error::{Fault, Problem};

/// Nodes or elements that all sets of a file hold together, each as often as it is named: some hundred times what large meshes have,
/// and some hundred megabytes. A small file could ask for any number.
pub(crate) const MOST_MEMBERS: usize = 50_000_000;

/// Nodes and elements of a file under way. `at` is always the byte at which an item was read, for messages.
#[derive(Default)]
pub(crate) struct Builder {
    nodes: Vec<[f64; 3]>,
    node_tags: Vec<u64>,
    node_index: HashMap<u64, usize>,
    elements: Vec<TaggedElement>,
    element_index: HashMap<u64, usize>,
}

/// An element whose nodes are still tags, since the nodes may follow later in the file.
struct TaggedElement {
    kind: ElementKind,
    tag: u64,
    nodes: [u64; MOST_NODES],
    at: usize,
    incompatible_modes: bool,
}

impl Builder {
    /// Adds a node: its tag and its coordinates, each with its place.
    pub fn add_node(
        &mut self,
        (tag, tag_at): (u64, usize),
        (coordinates, at): ([f64; 3], usize),
    ) -> Result<(), Fault> {
        for (axis, value) in ['x', 'y', 'z'].into_iter().zip(coordinates) {
            if !value.is_finite() {
                return Err(Fault::new(at, Problem::NonFiniteCoordinate { tag, axis, value }));
            }
        }
        if let Some(&known) = self.node_index.get(&tag) {
            // The same once more is no other node.
            if self.nodes[known] == coordinates {
                return Ok(());
            }
            return Err(Fault::new(tag_at, Problem::DuplicateNode { tag }));
        }
        self.node_index.insert(tag, self.nodes.len());
        self.nodes.push(coordinates);
        self.node_tags.push(tag);
        Ok(())
    }

    /// Adds an element; `nodes` holds tags, beyond the kind's count it is ignored.
    pub fn add_element(
        &mut self,
        kind: ElementKind,
        tag: u64,
        nodes: [u64; MOST_NODES],
        at: usize,
    ) -> Result<(), Fault> {
        if self.element_index.insert(tag, self.elements.len()).is_some() {
            return Err(Fault::new(at, Problem::DuplicateElement { tag }));
        }
        self.elements.push(TaggedElement { kind, tag, nodes, at, incompatible_modes: false });
        Ok(())
    }

    /// Says of the element added last whether the file asks for incompatible modes.
    pub fn set_incompatible_modes(&mut self, incompatible_modes: bool) {
        if let Some(last) = self.elements.last_mut() {
            last.incompatible_modes = incompatible_modes;
        }
    }

    pub fn node_index(&self, tag: u64) -> Option<usize> {
        self.node_index.get(&tag).copied()
    }

    pub fn node_tags(&self) -> &[u64] {
        &self.node_tags
    }

    pub fn element_index(&self, tag: u64) -> Option<usize> {
        self.element_index.get(&tag).copied()
    }

    /// The elements with node indices in place of tags, once all nodes are known.
    pub fn resolved_elements(&self) -> Result<Vec<Element>, Fault> {
        self.elements.iter().map(|element| self.resolved(element)).collect()
    }

    fn resolved(&self, element: &TaggedElement) -> Result<Element, Fault> {
        let &TaggedElement { kind, tag, nodes, at, incompatible_modes } = element;
        let mut indices = [0; MOST_NODES];
        for (i, &node) in nodes[..kind.node_count()].iter().enumerate() {
            if nodes[..i].contains(&node) {
                return Err(Fault::new(at, Problem::RepeatedNode { element: tag, node }));
            }
            indices[i] = self
                .node_index(node)
                .ok_or_else(|| Fault::new(at, Problem::MissingNode { element: tag, node }))?;
        }
        Ok(Element::new(kind, tag, indices).with_incompatible_modes(incompatible_modes))
    }

    /// Coordinates and tags of the nodes.
    pub fn into_nodes(self) -> (Vec<[f64; 3]>, Vec<u64>) {
        (self.nodes, self.node_tags)
    }
}
