//! Parts from mesh files.

use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use diffuse_contact::surface::Facet;
use diffuse_contact_mesh::{self as mesh, Mesh};

use super::cells::contact_facet;
use super::{Cells, ModelError, Part, sorted};

/// How types begin that are no solids: points and springs, connectors, shells, membranes and surfaces, rigid facets, beams, elements in a
/// plane or on an axis, cavities, and elements of one's own.
const NO_SOLIDS: &[&str] = &[
    "MASS", "ROTARYI", "HEATCAP", "SPRING", "DASHPOT", "CONN", "DCOUP", "JOINT", "GAP", "ITS", "ITT", "IRS",
    "ISL", "DRAG", "S3", "S4", "S6", "S8", "S9", "STRI", "SAX", "SFM", "DS", "M3D", "MAX", "MGAX", "MCL",
    "R2D", "R3D", "RAX", "RB", "B2", "B3", "PIPE", "ELBOW", "FRAME", "T2D", "T3D", "CPE", "CPS", "CAX",
    "CGAX", "COH2D", "COHAX", "CINP", "CINAX", "AC1D", "AC2D", "ACAX", "ACIN", "DC1D", "DC2D", "DCAX",
    "DCC1D", "DCC2D", "DCCAX", "F2D", "F3D", "FAX", "FLINK", "U", "WARP",
];

/// Of those, types without stiffness.
const NO_STIFFNESS: &[&str] = &["MASS", "ROTARYI", "HEATCAP"];

/// Whether it may be a solid: a type that is not known to be something else.
fn may_be_solid(kind: &str) -> bool {
    // CalculiX' network elements are just that.
    kind != "D" && !NO_SOLIDS.iter().any(|begin| kind.starts_with(begin))
}

/// A deformable part: the solids of an element set, or of the whole file, and of the file's sets and surfaces what lies on
/// them. A surface of shell elements counts if it lies on the part's skin, and is turned outward. `instance`: which one of an
/// Abaqus file, if there are several.
///
/// # Errors
/// [`ModelError`]: the file cannot be read, there is no such set, it has solids of another kind or none.
pub fn read_solid_part(
    path: &Path,
    instance: Option<&str>,
    elements: Option<&str>,
) -> Result<Part, ModelError> {
    Meshes::default().solid_part(path, instance, elements)
}

fn solid_part(mesh: &Mesh, elements: Option<&str>) -> Result<Part, ModelError> {
    if elements.is_none()
        && let Some(solid) = mesh.unread_elements().iter().find(|element| may_be_solid(&element.kind))
    {
        let mesh::UnreadElement { tag, kind, line } = solid.clone();
        return Err(ModelError::UnreadSolid { tag, kind, line });
    }
    let all: Vec<usize>;
    let chosen = match elements {
        Some(set) => mesh.elements_of(set)?,
        None => {
            all = (0..mesh.elements().len()).collect();
            &all
        }
    };
    let (mut solids, mut labels, mut incompatible) = (Cells::default(), Vec::new(), Vec::new());
    let mut places = Vec::new();
    for &index in chosen {
        let element = &mesh.elements()[index];
        if element.kind().dimension() == 3 {
            places.push(index);
            solids.push(element.kind(), element.nodes());
            labels.push(element.tag());
            incompatible.push(element.has_incompatible_modes());
        }
    }
    if solids.is_empty() {
        return Err(ModelError::NoSolids { set: elements.map(String::from) });
    }
    solids.set_incompatible_modes(|k| incompatible[k]);
    let part = Subset::new(mesh, solids.nodes().iter().copied());
    let elements = solids.renumbered(|node| part.number[node]);
    // A facet of the file that lies on the skin is taken as the skin has it.
    let outward: BTreeMap<Vec<usize>, Facet> =
        elements.skin().into_iter().map(|facet| (sorted(facet.corners()), facet)).collect();
    let (surfaces, inner_facets) =
        part.surfaces(mesh, |facet| outward.get(&sorted(facet.corners())).copied());
    let place: HashMap<usize, usize> =
        places.iter().enumerate().map(|(own, &element)| (element, own)).collect();
    let own =
        |elements: &Vec<usize>| elements.iter().filter_map(|element| place.get(element).copied()).collect();
    let element_sets = mesh.element_sets().iter().map(|(name, elements)| (name.clone(), own(elements)));
    let element_sets: BTreeMap<String, Vec<usize>> =
        element_sets.filter(|(_, elements): &(String, Vec<usize>)| !elements.is_empty()).collect();
    let unread_constraints =
        mesh.unread_constraints().iter().filter(|constraint| holds(&element_sets, constraint));
    let unread_constraints = unread_constraints.cloned().collect();
    let mut unread_elements = BTreeMap::new();
    for (index, kind) in mesh.stiff_lines_and_facets() {
        // Of a rigid tool or another body they are not missing here.
        if mesh.elements()[*index].nodes().iter().any(|&node| part.number[node] != usize::MAX) {
            *unread_elements.entry(kind.clone()).or_default() += 1;
        }
    }
    for mesh::UnreadElement { kind, .. } in mesh.unread_elements() {
        if !may_be_solid(kind) && !NO_STIFFNESS.iter().any(|begin| kind.starts_with(begin)) {
            *unread_elements.entry(kind.clone()).or_default() += 1;
        }
    }
    let node_labels = part.nodes.iter().map(|&node| mesh.node_tags()[node]).collect();
    Ok(Part {
        elements,
        labels,
        element_sets,
        surfaces,
        inner_facets,
        unread_constraints,
        unread_elements,
        node_labels,
        ..part.into_part(mesh)
    })
}

/// Whether a constraint may hold elements of these sets: a rigid body of another set does not.
fn holds(sets: &BTreeMap<String, Vec<usize>>, constraint: &mesh::UnreadConstraint) -> bool {
    let is_named = |set: &String| sets.keys().any(|own| own.to_lowercase() == set.to_lowercase());
    constraint.elements.as_ref().is_none_or(is_named)
}

/// A rigid part: the triangles and quadrilaterals of a surface or an element set, oriented as in the file, and of the file's
/// sets and surfaces what lies on them. `instance`: which one of an Abaqus file, if there are several.
///
/// # Errors
/// [`ModelError`]: the file cannot be read, or there is no such set, or it has no facets.
pub fn read_rigid_part(path: &Path, instance: Option<&str>, surface: &str) -> Result<Part, ModelError> {
    Meshes::default().rigid_part(path, instance, surface)
}

fn rigid_part(mesh: &Mesh, surface: &str) -> Result<Part, ModelError> {
    let chosen = mesh.facets(surface)?;
    let part = Subset::new(mesh, chosen.iter().flat_map(mesh::Facet::nodes).copied());
    let facets: Vec<Facet> = chosen.iter().filter_map(|facet| part.facet(facet)).collect();
    let own: BTreeMap<Vec<usize>, Facet> =
        facets.iter().map(|&facet| (sorted(facet.corners()), facet)).collect();
    // Facets between its nodes that are none of its own belong to other surfaces.
    let (surfaces, _) = part.surfaces(mesh, |facet| own.get(&sorted(facet.corners())).copied());
    // Constraints are left out: a rigid part moves as one anyway.
    Ok(Part { facets, surfaces, ..part.into_part(mesh) })
}

/// Mesh files that have been read: parts of one file share it.
#[derive(Default)]
pub(crate) struct Meshes(HashMap<(PathBuf, Option<String>), Mesh>);

impl Meshes {
    fn read(&mut self, path: &Path, instance: Option<&str>) -> Result<&Mesh, ModelError> {
        Ok(match self.0.entry((path.to_owned(), instance.map(str::to_owned))) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => new.insert(match instance {
                Some(instance) => Mesh::read_instance(path, instance)?,
                None => Mesh::read(path)?,
            }),
        })
    }

    /// As [`read_solid_part`].
    pub fn solid_part(
        &mut self,
        path: &Path,
        instance: Option<&str>,
        elements: Option<&str>,
    ) -> Result<Part, ModelError> {
        solid_part(self.read(path, instance)?, elements)
    }

    /// As [`read_rigid_part`].
    pub fn rigid_part(
        &mut self,
        path: &Path,
        instance: Option<&str>,
        surface: &str,
    ) -> Result<Part, ModelError> {
        rigid_part(self.read(path, instance)?, surface)
    }
}

/// The nodes of a mesh that a part uses.
struct Subset {
    /// Nodes of the file in use, ascending.
    nodes: Vec<usize>,
    /// The part's number of each node of the file; `usize::MAX` if it has none.
    number: Vec<usize>,
}

impl Subset {
    fn new(mesh: &Mesh, used: impl Iterator<Item = usize>) -> Self {
        let mut nodes: Vec<usize> = used.collect();
        nodes.sort_unstable();
        nodes.dedup();
        let mut number = vec![usize::MAX; mesh.nodes().len()];
        nodes.iter().enumerate().for_each(|(own, &node)| number[node] = own);
        Self { nodes, number }
    }

    /// A facet of the file in the part's numbers, if all of its corners are in use.
    fn facet(&self, facet: &mesh::Facet) -> Option<Facet> {
        let own = contact_facet(*facet, |node| self.number[node]);
        (!own.corners().contains(&usize::MAX)).then_some(own)
    }

    /// The file's surfaces as far as `own` knows their facets; those of which nothing is left do not count. Beside them the numbers of facets
    /// that lie between the part's nodes and are not known.
    fn surfaces(
        &self,
        mesh: &Mesh,
        own: impl Fn(Facet) -> Option<Facet>,
    ) -> (BTreeMap<String, Vec<Facet>>, BTreeMap<String, usize>) {
        let (mut surfaces, mut others) = (BTreeMap::new(), BTreeMap::new());
        for name in mesh.set_names() {
            let Ok(facets) = mesh.facets(name) else { continue };
            let within: Vec<Facet> = facets.iter().filter_map(|facet| self.facet(facet)).collect();
            let found: Vec<Facet> = within.iter().copied().filter_map(&own).collect();
            if within.len() > found.len() {
                others.insert(name.to_string(), within.len() - found.len());
            }
            if !found.is_empty() {
                surfaces.insert(name.to_string(), found);
            }
        }
        (surfaces, others)
    }

    /// Nodes and node sets; sets of which nothing is left do not count.
    fn into_part(self, mesh: &Mesh) -> Part {
        let mut node_sets = BTreeMap::new();
        for name in mesh.set_names() {
            let Ok(nodes) = mesh.nodes_of(name) else { continue };
            let own: Vec<usize> =
                nodes.iter().map(|&n| self.number[n]).filter(|&own| own != usize::MAX).collect();
            if !own.is_empty() {
                node_sets.insert(name.to_string(), own);
            }
        }
        let nodes = self.nodes.iter().map(|&node| mesh.nodes()[node]).collect();
        // Whether they would lie on the part is not known.
        let unread_sets = mesh.unread_sets().into_iter();
        let unread_sets = unread_sets.map(|(name, error)| (name.to_string(), Arc::new(error))).collect();
        Part { nodes, node_sets, unread_sets, ..Part::default() }
    }
}
