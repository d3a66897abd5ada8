//! Solid elements of any kind, one after the other.

use std::collections::HashMap;

use diffuse_contact::faces::QuadraticFace;
use diffuse_contact::surface::Facet;
use diffuse_contact_mesh::{self as mesh, ElementKind};

/// Solid elements: kinds of dimension three, each with as many nodes as it has.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cells {
    kinds: Vec<ElementKind>,
    /// The nodes of all elements.
    nodes: Vec<usize>,
    /// For each element the end of its nodes.
    ends: Vec<usize>,
    /// Whether each element has incompatible modes.
    incompatible: Vec<bool>,
}

/// One of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell<'a> {
    /// Its kind.
    pub kind: ElementKind,
    /// Its nodes in the order of the kind.
    pub nodes: &'a [usize],
    /// Whether incompatible modes let it bend: a hexahedron with 8 nodes.
    pub incompatible_modes: bool,
}

impl<'a> FromIterator<Cell<'a>> for Cells {
    fn from_iter<I: IntoIterator<Item = Cell<'a>>>(cells: I) -> Self {
        let mut all = Self::default();
        for Cell { kind, nodes, incompatible_modes } in cells {
            all.push(kind, nodes);
            if let Some(last) = all.incompatible.last_mut() {
                *last = incompatible_modes;
            }
        }
        all
    }
}

impl Cells {
    /// Adds an element.
    ///
    /// # Panics
    /// If the kind is no solid or has another number of nodes.
    pub fn push(&mut self, kind: ElementKind, nodes: &[usize]) {
        assert!(
            kind.dimension() == 3 && nodes.len() == kind.node_count(),
            "{kind:?} with {} nodes",
            nodes.len()
        );
        self.kinds.push(kind);
        self.nodes.extend(nodes);
        self.ends.push(self.nodes.len());
        self.incompatible.push(false);
    }

    /// Gives incompatible modes to those of the hexahedra with 8 nodes for which `which` holds, by their places, and to no others.
    pub fn set_incompatible_modes(&mut self, which: impl Fn(usize) -> bool) {
        for (k, (kind, incompatible)) in self.kinds.iter().zip(&mut self.incompatible).enumerate() {
            *incompatible = *kind == ElementKind::Hexahedron8 && which(k);
        }
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        self.kinds.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.kinds.is_empty()
    }

    /// All elements.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Cell<'_>> + Clone {
        (0..self.len()).map(|k| self.get(k))
    }

    /// The `k`-th element.
    ///
    /// # Panics
    /// If there is no such element.
    pub fn get(&self, k: usize) -> Cell<'_> {
        let start = if k == 0 { 0 } else { self.ends[k - 1] };
        let (kind, incompatible_modes) = (self.kinds[k], self.incompatible[k]);
        Cell { kind, nodes: &self.nodes[start..self.ends[k]], incompatible_modes }
    }

    /// The nodes of all elements, one element after the other.
    pub fn nodes(&self) -> &[usize] {
        &self.nodes
    }

    /// Some of the elements, by their places.
    ///
    /// # Panics
    /// If there is no such element.
    #[must_use]
    pub fn chosen(&self, which: &[usize]) -> Self {
        which.iter().map(|&k| self.get(k)).collect()
    }

    /// The same elements with other node indices.
    #[must_use]
    pub fn renumbered(&self, number: impl FnMut(usize) -> usize) -> Self {
        Self { nodes: self.nodes.iter().copied().map(number).collect(), ..self.clone() }
    }

    /// The facets that the faces of one element only are made of, oriented outward, in the order of the elements.
    pub fn skin(&self) -> Vec<Facet> {
        self.outside().flat_map(|(cell, corners)| cell.facets(corners)).collect()
    }

    /// The faces of one element only that have nodes in the middle of their edges, with all of their nodes.
    pub fn quadratic_faces(&self) -> Vec<QuadraticFace> {
        if !self.iter().any(|cell| cell.kind.has_middles()) {
            return Vec::new();
        }
        let faces = self.outside().filter_map(|(cell, corners)| {
            let nodes: Vec<usize> = cell.kind.nodes_of(corners).into_iter().map(|k| cell.nodes[k]).collect();
            QuadraticFace::new(&nodes)
        });
        faces.collect()
    }

    /// The first two elements that do not fit together, with what is wrong.
    pub(super) fn misfit(&self) -> Option<(usize, usize, Misfit)> {
        // The first element with a face, its corners there, and whether there is a second one.
        let mut faces: HashMap<[usize; 4], (usize, &'static [usize], bool)> =
            HashMap::with_capacity(4 * self.len());
        let all = |cell: Cell<'_>, corners: &[usize]| {
            let mut nodes: Vec<usize> =
                cell.kind.nodes_of(corners).into_iter().map(|k| cell.nodes[k]).collect();
            nodes.sort_unstable();
            nodes
        };
        for (element, cell) in self.iter().enumerate() {
            for &corners in cell.kind.faces() {
                let Some((other, others, has_second)) = faces.get_mut(&cell.key(corners)) else {
                    faces.insert(cell.key(corners), (element, corners, false));
                    continue;
                };
                let neighbour = self.get(*other);
                let shared =
                    cell.corners().iter().filter(|corner| neighbour.corners().contains(corner)).count();
                if shared > corners.len() || *has_second {
                    return Some((*other, element, Misfit::Overlapping { shared }));
                }
                if all(cell, corners) != all(neighbour, others) {
                    return Some((*other, element, Misfit::Hanging));
                }
                *has_second = true;
            }
        }
        None
    }

    /// The faces of one element only, each with its corners in it.
    fn outside(&self) -> impl Iterator<Item = (Cell<'_>, &'static [usize])> {
        let mut uses: HashMap<[usize; 4], u32> = HashMap::with_capacity(4 * self.len());
        let faces = || {
            self.iter().flat_map(|cell| {
                cell.kind.faces().iter().map(move |corners| (cell, *corners, cell.key(corners)))
            })
        };
        for (.., key) in faces() {
            *uses.entry(key).or_insert(0) += 1;
        }
        let outside: Vec<_> = faces().filter(|(.., key)| uses[key] == 1).collect();
        outside.into_iter().map(|(cell, corners, _)| (cell, corners))
    }
}

/// What is wrong with two elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Misfit {
    /// They share more corners than those of a face, or a face with a third element.
    Overlapping { shared: usize },
    /// They share the corners of a face, but not its other nodes.
    Hanging,
}

impl Cell<'_> {
    fn corners(&self) -> &[usize] {
        &self.nodes[..self.kind.corner_count()]
    }

    /// What faces of two elements that touch have in common: their corners, ascending.
    fn key(&self, corners: &[usize]) -> [usize; 4] {
        let mut key = [usize::MAX; 4];
        for (key, &corner) in key.iter_mut().zip(corners) {
            *key = self.nodes[corner];
        }
        key.sort_unstable();
        key
    }

    fn facets(self, corners: &[usize]) -> impl Iterator<Item = Facet> {
        let facets = self.kind.facets_of(corners).into_iter();
        facets.map(move |facet| contact_facet(facet, |node| self.nodes[node]))
    }
}

/// A facet of a mesh as one of a contact surface, with other node indices.
pub(super) fn contact_facet(facet: mesh::Facet, number: impl FnMut(usize) -> usize) -> Facet {
    match facet.map(number) {
        mesh::Facet::Triangle(nodes) => Facet::Triangle(nodes),
        mesh::Facet::Quadrilateral(nodes) => Facet::Quadrilateral(nodes),
    }
}

impl From<Vec<[usize; 8]>> for Cells {
    /// Hexahedra.
    fn from(hexahedra: Vec<[usize; 8]>) -> Self {
        let mut cells = Self::default();
        hexahedra.iter().for_each(|nodes| cells.push(ElementKind::Hexahedron8, nodes));
        cells
    }
}
