//! What is simulated: nodes, bodies of solid elements, named node sets and surfaces, and how nodes are moved.
//!
//! A [`Model`] is put together from parts with [`Model::add`]. A [`Part`] comes from a parametric [`shape`] or from a
//! mesh file; it has its own nodes, so that parts are connected by contact alone. What a model holds is sound: indices are
//! in range, coordinates are finite, no element is turned inside out at its corners, facets point outward.
//!
//! Names: `"pipe.inner"` is the set or the surface `inner` of the part `pipe`, and `"pipe"` is all of its nodes or its whole
//! skin.

mod cells;
mod error;
mod file;
mod fingerprint;
mod joints;
mod materials;
mod motion;
mod part;
pub mod shape;
mod supports;

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;

use diffuse_contact::faces::QuadraticFace;
use diffuse_contact::surface::Facet;
use diffuse_contact_mesh::MeshError;

use crate::material::Material;

pub use cells::{Cell, Cells};
pub use error::{ModelError, ShapeError};
pub(crate) use file::Meshes;
pub use file::{read_rigid_part, read_solid_part};
pub use joints::shared_nodes;
pub use materials::Materials;
pub use motion::{Amplitude, Motion, Rotation};
pub use part::{MAX_NODES, Part};
pub use supports::{Conflict, Support, Supports};

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
    /// Numbers of facets that a mesh file counts to a surface although they are not on its part's skin.
    pub inner_facets: BTreeMap<String, usize>,
    /// Sets and surfaces of mesh files that are refused where they are asked for, with the error.
    pub unread_sets: BTreeMap<String, Arc<MeshError>>,
    /// Where nodes that a mesh file joins are not joined here, in sentences.
    pub warnings: Vec<String>,
    /// The nodes that [`adjust`](Self::adjust) moved.
    pub adjusted: BTreeMap<usize, AdjustedNode>,
    /// By interface, how many of its slaves were to be adjusted but are free along its master alone.
    pub not_adjusted: BTreeMap<String, usize>,
}

/// A node that was moved before there was any strain.
#[derive(Clone, Debug, PartialEq)]
pub struct AdjustedNode {
    /// Where it was, length.
    pub before: [f64; 3],
    /// The interface whose master it touches now.
    pub interface: String,
}

/// Elements of one material.
#[derive(Clone, Debug)]
pub struct Body {
    /// The part it belongs to.
    pub part: String,
    /// The part's name; `part.set` where the part has materials by element sets.
    pub name: String,
    /// Its elements.
    pub elements: Cells,
    /// The numbers that the mesh file gives them; none if there is no file.
    pub labels: Vec<u64>,
    /// What it is made of.
    pub material: Material,
}

impl Model {
    /// Adds a part under a name: its nodes after those that are there, its elements as a body for each of its `materials`, its sets and
    /// surfaces as `name.set`, all its nodes and its whole skin as `name`. A part without elements is rigid and takes no
    /// material.
    ///
    /// # Errors
    /// [`ModelError`]: a part of this name exists, the part is not sound, a material is missing or has no use, materials are for sets that do
    /// not hold each element once, or there are more than [`MAX_NODES`] nodes.
    pub fn add(&mut self, name: &str, part: Part, materials: impl Into<Materials>) -> Result<(), ModelError> {
        let materials = materials.into();
        if name.is_empty() || name.contains('.') {
            return Err(ModelError::InvalidName { part: name.into() });
        }
        if self.node_sets.contains_key(name) {
            return Err(ModelError::RepeatedPart { part: name.into() });
        }
        part.check(name)?;
        let count = self.nodes.len() + part.nodes.len();
        if count > MAX_NODES {
            return Err(ModelError::TooManyNodes { count: count as f64, limit: MAX_NODES });
        }
        let first = self.nodes.len();
        let bodies = materials::bodies(name, &part, &materials, first)?;
        self.warnings.extend(joints::unread_constraints(name, &part.unread_constraints));
        self.warnings.extend(joints::unread_elements(name, &part.unread_elements));
        self.warnings.extend(joints::seams(name, &part));
        let whole = part.outside();
        self.node_sets.insert(name.into(), (first..count).collect());
        self.surfaces.insert(name.into(), shifted(whole, first));
        for (set, nodes) in part.node_sets {
            self.node_sets.insert(format!("{name}.{set}"), nodes.into_iter().map(|n| n + first).collect());
        }
        for (set, facets) in part.surfaces {
            self.surfaces.insert(format!("{name}.{set}"), shifted(facets, first));
        }
        for (set, count) in part.inner_facets {
            self.inner_facets.insert(format!("{name}.{set}"), count);
        }
        for (set, error) in part.unread_sets {
            self.unread_sets.insert(format!("{name}.{set}"), error);
        }
        self.bodies.extend(bodies);
        self.nodes.extend(part.nodes);
        Ok(())
    }

    /// Moves a node onto the master of an interface, before there is any strain.
    pub fn adjust(&mut self, node: usize, position: [f64; 3], interface: &str) {
        let last = std::mem::replace(&mut self.nodes[node], position);
        let before = self.adjusted.get(&node).map_or(last, |earlier| earlier.before);
        self.adjusted.insert(node, AdjustedNode { before, interface: interface.to_owned() });
    }

    /// Which nodes belong to a body; the others are rigid.
    pub fn deformable(&self) -> Vec<bool> {
        let mut deformable = vec![false; self.nodes.len()];
        for &node in self.bodies.iter().flat_map(|body| body.elements.nodes()) {
            deformable[node] = true;
        }
        deformable
    }

    /// The faces of the deformable parts' skins that have nodes in the middle of their edges.
    pub fn quadratic_faces(&self) -> Vec<QuadraticFace> {
        self.deformable_parts().flat_map(|bodies| whole(bodies).quadratic_faces()).collect()
    }

    /// The facets of each body that are on the skin of its part: none between materials.
    pub fn skins(&self) -> Vec<Vec<Facet>> {
        let of_part = |bodies: &[Body]| {
            let all = whole(bodies).skin();
            if bodies.len() == 1 {
                return vec![all];
            }
            let outside: HashSet<Vec<usize>> = all.iter().map(|facet| sorted(facet.corners())).collect();
            let is_outside = |facet: &Facet| outside.contains(&sorted(facet.corners()));
            bodies.iter().map(|body| body.elements.skin().into_iter().filter(is_outside).collect()).collect()
        };
        self.deformable_parts().flat_map(of_part).collect()
    }

    /// The bodies of each deformable part.
    fn deformable_parts(&self) -> impl Iterator<Item = &[Body]> {
        self.bodies.chunk_by(|one, next| one.part == next.part)
    }

    /// The faces that facets are made of, each by its nodes: a face of second order if all of its facets are there, or the facet.
    pub fn faces_of(&self, facets: &[Facet]) -> Vec<Vec<usize>> {
        let mut parts: HashMap<Vec<usize>, usize> = HashMap::new();
        let faces = self.quadratic_faces();
        for (k, face) in faces.iter().enumerate() {
            for facet in face.facets() {
                parts.insert(sorted(facet.corners()), k);
            }
        }
        let of = |facet: &Facet| parts.get(&sorted(facet.corners())).copied();
        let mut found = vec![0_usize; faces.len()];
        facets.iter().filter_map(of).for_each(|k| found[k] += 1);
        let is_whole = |k: &usize| found[*k] == faces[*k].facets().len();
        let whole = (0..faces.len()).filter(is_whole).map(|k| faces[k].nodes().to_vec());
        let alone = facets.iter().filter(|facet| of(facet).is_none_or(|k| !is_whole(&k)));
        whole.chain(alone.map(|facet| facet.corners().to_vec())).collect()
    }

    /// The rigid parts with their facets, in the order of their nodes.
    pub fn rigid_parts(&self) -> impl Iterator<Item = (&str, &[Facet])> {
        let is_rigid = |name: &str| self.bodies.iter().all(|body| body.part != name);
        let parts = self.parts().into_iter().filter(move |&(name, _)| is_rigid(name));
        parts.map(|(name, _)| (name, &self.surfaces[name][..]))
    }

    /// The parts by name with their first node, in the order of their nodes.
    pub fn parts(&self) -> Vec<(&str, usize)> {
        let whole = self.node_sets.iter().filter(|(name, _)| !name.contains('.'));
        let mut parts: Vec<_> =
            whole.filter_map(|(name, nodes)| Some((name.as_str(), *nodes.first()?))).collect();
        parts.sort_by_key(|&(_, first)| first);
        parts
    }
}

/// All elements of a part.
fn whole(bodies: &[Body]) -> Cow<'_, Cells> {
    match bodies {
        [one] => Cow::Borrowed(&one.elements),
        _ => Cow::Owned(bodies.iter().flat_map(|body| body.elements.iter()).collect()),
    }
}

/// The same nodes, ascending: a facet without its orientation.
pub(crate) fn sorted(nodes: &[usize]) -> Vec<usize> {
    let mut nodes = nodes.to_vec();
    nodes.sort_unstable();
    nodes
}

/// Facets with all corners moved on.
fn shifted(facets: Vec<Facet>, by: usize) -> Vec<Facet> {
    let shift = |facet| match facet {
        Facet::Triangle(corners) => Facet::Triangle(corners.map(|n| n + by)),
        Facet::Quadrilateral(corners) => Facet::Quadrilateral(corners.map(|n| n + by)),
    };
    facets.into_iter().map(shift).collect()
}
