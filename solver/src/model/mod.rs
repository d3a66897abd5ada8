//! What is simulated: nodes, bodies of hexahedra, named node sets and surfaces.

use std::collections::BTreeMap;

use diffuse_contact::surface::Facet;

use crate::material::Material;

/// A mesh with materials. Indices in it are in range.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Positions of the nodes at the start, length.
    pub nodes: Vec<[f64; 3]>,
    /// Deformable bodies; a node that belongs to none is part of a rigid surface.
    pub bodies: Vec<Body>,
    /// Nodes by name, ascending.
    pub node_sets: BTreeMap<String, Vec<usize>>,
    /// Facets by name, oriented outward.
    pub surfaces: BTreeMap<String, Vec<Facet>>,
}

/// Hexahedra of one material.
#[derive(Clone, Debug)]
pub struct Body {
    /// Its name in the deck.
    pub name: String,
    /// Nodes of each hexahedron: a quadrilateral, then the opposite one, on the side of the first one's normal.
    pub elements: Vec<[usize; 8]>,
    /// What it is made of.
    pub material: Material,
}
