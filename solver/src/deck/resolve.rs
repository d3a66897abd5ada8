//! From a deck to a model: parts are made, names become nodes and facets.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::path::Path;

use diffuse_contact::surface::Facet;
use diffuse_contact_mesh::ElementKind;
use diffuse_contact_mesh::names::{self, nearest};

use super::error::{DeckError, Problem};
use super::{Boundary, Deck, Interface, PartEntry, PartSource, Pressure, Reference};
use crate::distinct::distinct;
use crate::model::{Conflict, Materials, Meshes, Model, ModelError, Part, Support, Supports, shared_nodes};
use crate::statics;

const AXES: [&str; 3] = ["x", "y", "z"];

/// The two sides of an interface, exchanged if the deck says so.
#[derive(Clone, Debug, PartialEq)]
pub struct Sides {
    /// Facets that carry the contact surface; in contact of surfaces with themselves also the slave's.
    pub master: Vec<Facet>,
    /// Facets whose nodes must not penetrate it.
    pub slave: Vec<Facet>,
}

impl Deck {
    /// Makes the model. Mesh files are sought beside `base`, the directory of the deck. All names of the deck are resolved, so
    /// that what [`supports`](Self::supports), [`loads`](Self::loads) and [`sides`](Self::sides) have to say is said here. Slaves that are
    /// to start in touch are moved.
    ///
    /// # Errors
    /// [`DeckError::Invalid`].
    pub fn model(&self, base: impl AsRef<Path>) -> Result<Model, DeckError> {
        let mut model = Model::default();
        let (mut from_files, mut meshes) = (Vec::new(), Meshes::default());
        for entry in &self.parts {
            let failed = |error| self.error(entry.line, Problem::Part { part: entry.name.clone(), error });
            let materials = self.materials(&entry.materials)?;
            let part = entry.part(base.as_ref(), &mut meshes);
            let mut part = part.map_err(|problem| self.error(entry.line, *problem))?;
            if let PartSource::Solid { file, instance, .. } = &entry.source {
                let nodes = std::mem::take(&mut part.node_labels);
                let file = base.as_ref().join(file);
                // A file that is placed twice makes two bodies.
                let place = (&entry.rotations, entry.translation);
                let source = (file.canonicalize().unwrap_or(file), instance, place);
                from_files.push((entry.name.as_str(), source, nodes));
            }
            model.add(&entry.name, part, materials).map_err(failed)?;
        }
        model.warnings.extend(shared_nodes(&from_files));
        if model.bodies.is_empty() {
            return Err(self.error(1, Problem::NothingDeformable));
        }
        self.supports(&model)?;
        self.pressures.iter().try_for_each(|pressure| self.pressed(&model, pressure).map(drop))?;
        self.interfaces.iter().try_for_each(|interface| self.sides(&model, interface).map(drop))?;
        self.adjust(&mut model)?;
        Ok(model)
    }

    /// The times of the points of all amplitudes, in no order.
    pub fn amplitude_times(&self) -> impl Iterator<Item = f64> {
        let motions = self.boundaries.iter().flat_map(|boundary| boundary.motion.times());
        motions.chain(self.pressures.iter().flat_map(|pressure| pressure.amplitude.times()))
    }

    /// The prescribed degrees of freedom of the deck's model.
    ///
    /// # Errors
    /// [`DeckError::Invalid`]: a set that does not exist, two conditions that contradict each other, a rigid node that is free.
    pub fn supports(&self, model: &Model) -> Result<Supports, DeckError> {
        let mut supports = Vec::new();
        for (boundary, name) in self.boundaries.iter().zip(support_names(&self.boundaries)) {
            let mut nodes = BTreeSet::new();
            for set in &boundary.nodes {
                nodes.extend(self.find_set(model, &model.node_sets, "node set", set)?);
            }
            let (axes, motion) = (boundary.axes, boundary.motion.clone());
            supports.push(Support { name, nodes: nodes.into_iter().collect(), axes, motion });
        }
        let contradiction = |Conflict { node, axis, first, second }| {
            let (position, axis, other) = (model.nodes[node], AXES[axis], self.boundaries[first].line);
            self.error(self.boundaries[second].line, Problem::Conflict { node, position, axis, other })
        };
        let supports = Supports::new(model.nodes.len(), supports).map_err(contradiction)?;

        let deformable = model.deformable();
        for entry in self.parts.iter().filter(|entry| entry.materials.is_empty()) {
            for &node in model.node_sets.get(&entry.name).into_iter().flatten() {
                let free = (0..3).find(|&axis| !deformable[node] && supports.is_free(3 * node + axis));
                if let Some(axis) = free {
                    let (part, position) = (entry.name.clone(), model.nodes[node]);
                    let problem = Problem::FreeRigidNode { part, position, axis: AXES[axis] };
                    return Err(self.error(entry.line, problem));
                }
            }
        }
        Ok(supports)
    }

    /// The pressures on the deck's model.
    ///
    /// # Errors
    /// [`DeckError::Invalid`]: a surface that does not exist or is rigid.
    pub fn loads(&self, model: &Model) -> Result<Vec<statics::Pressure>, DeckError> {
        let load = |pressure: &Pressure| {
            Ok(statics::Pressure {
                faces: model.faces_of(&self.pressed(model, pressure)?),
                value: pressure.value,
                amplitude: pressure.amplitude.clone(),
                follower: pressure.follower,
            })
        };
        self.pressures.iter().map(load).collect()
    }

    /// The facets under a pressure.
    fn pressed(&self, model: &Model, pressure: &Pressure) -> Result<Vec<Facet>, DeckError> {
        let (all, deformable) = (self.facets(model, &pressure.surfaces)?, model.deformable());
        for name in &pressure.surfaces {
            let facets = self.find(&model.surfaces, "surface", name)?;
            if facets.iter().flat_map(Facet::corners).any(|&node| !deformable[node]) {
                let problem = Problem::PressureOnRigid { name: name.name.clone() };
                return Err(self.error(name.line, problem));
            }
        }
        Ok(all)
    }

    /// The sides of one of the deck's interfaces.
    ///
    /// # Errors
    /// [`DeckError::Invalid`]: a surface that does not exist, two rigid sides, or a node on both.
    pub fn sides(&self, model: &Model, interface: &Interface) -> Result<Sides, DeckError> {
        let mut sides = Sides {
            master: self.facets(model, &interface.master)?,
            slave: self.facets(model, &interface.slave)?,
        };
        if interface.exchange {
            std::mem::swap(&mut sides.master, &mut sides.slave);
        }
        let (masters, slaves) = (nodes_of(&sides.master), nodes_of(&sides.slave));
        let name = || interface.name.clone();
        if let Some(&node) = masters.intersection(&slaves).next().filter(|_| !interface.self_contact) {
            let problem = Problem::SharedNode { name: name(), position: model.nodes[node] };
            return Err(self.error(interface.line, problem));
        }
        let deformable = model.deformable();
        if !masters.union(&slaves).any(|&node| deformable[node]) {
            return Err(self.error(interface.line, Problem::RigidInterface { name: name() }));
        }
        Ok(sides)
    }

    /// The facets of several surfaces, each facet once, in the order of the names.
    ///
    /// # Errors
    /// [`DeckError::Invalid`] for a surface that does not exist, or has facets inside its part.
    pub fn facets(&self, model: &Model, names: &[Reference]) -> Result<Vec<Facet>, DeckError> {
        let (mut facets, mut known) = (Vec::new(), HashSet::new());
        for name in names {
            // A surface of this very name is meant, whatever others are like.
            let others =
                |name: &str| alike(&model.inner_facets, name).filter(|_| !model.surfaces.contains_key(name));
            if let Some(&inner) = model.inner_facets.get(&name.name).or_else(|| others(&name.name)) {
                let on_skin = model.surfaces.get(&name.name).or_else(|| alike(&model.surfaces, &name.name));
                let count = inner + on_skin.map_or(0, Vec::len);
                let problem = Problem::InnerFacets { name: name.name.clone(), inner, count };
                return Err(self.error(name.line, problem));
            }
            let is_known =
                model.surfaces.contains_key(&name.name) || alike(&model.surfaces, &name.name).is_some();
            let nodes = model.node_sets.get(&name.name).or_else(|| alike(&model.node_sets, &name.name));
            if let (false, Some(nodes)) = (is_known, nodes) {
                self.refuse_unread(model, name)?;
                let problem = Problem::NoFacets { name: name.name.clone(), nodes: nodes.len() };
                return Err(self.error(name.line, problem));
            }
            let surface = self.find_set(model, &model.surfaces, "surface", name)?;
            facets.extend(surface.iter().filter(|&&facet| known.insert(facet)));
        }
        Ok(facets)
    }

    fn materials(&self, named: &[(Option<String>, Reference)]) -> Result<Materials, DeckError> {
        let found = |name: &Reference| self.find(&self.materials, "material", name).copied();
        match named {
            [] => Ok(Materials::None),
            [(None, name)] => Ok(Materials::One(found(name)?)),
            _ => {
                let of_set = |(set, name): &(Option<String>, Reference)| {
                    Ok((set.clone().unwrap_or_default(), found(name)?))
                };
                named.iter().map(of_set).collect::<Result<_, _>>().map(Materials::BySet)
            }
        }
    }

    /// Refuses the name of a set of a mesh file that holds what is not read.
    fn refuse_unread(&self, model: &Model, name: &Reference) -> Result<(), DeckError> {
        let sets = &model.unread_sets;
        let Some(error) = sets.get(&name.name).or_else(|| alike(sets, &name.name)) else { return Ok(()) };
        let part = name.name.split('.').next().unwrap_or_default().to_owned();
        Err(self.error(name.line, Problem::UnreadSet { part, error: error.clone() }))
    }

    /// The set, or the surface, of this name among those of the model.
    fn find_set<'a, T>(
        &self,
        model: &Model,
        among: &'a BTreeMap<String, T>,
        what: &'static str,
        name: &Reference,
    ) -> Result<&'a T, DeckError> {
        let found = self.find(among, what, name);
        if found.is_err() {
            self.refuse_unread(model, name)?;
        }
        found
    }

    fn find<'a, T>(
        &self,
        among: &'a BTreeMap<String, T>,
        what: &'static str,
        name: &Reference,
    ) -> Result<&'a T, DeckError> {
        among.get(&name.name).or_else(|| alike(among, &name.name)).ok_or_else(|| {
            let nearest = nearest_name(&name.name, among.keys().map(String::as_str)).map(str::to_owned);
            let known = closest_first(&name.name, among.keys().map(String::as_str));
            let known = known.into_iter().map(str::to_owned).collect();
            self.error(name.line, Problem::UnknownName { what, name: name.name.clone(), nearest, known })
        })
    }

    pub(super) fn error(&self, line: usize, problem: Problem) -> DeckError {
        DeckError::Invalid { path: self.path.clone(), line, problem: Box::new(problem) }
    }
}

impl PartEntry {
    /// The mesh, in its place.
    fn part(&self, base: &Path, meshes: &mut Meshes) -> Result<Part, Box<Problem>> {
        let name = || self.name.clone();
        let failed = |error: ModelError| Box::new(Problem::Part { part: name(), error });
        let mut part = match &self.source {
            PartSource::Shape(shape) => {
                shape.part(self.element).map_err(|error| Box::new(Problem::Shape { part: name(), error }))?
            }
            PartSource::Solid { file, instance, elements } => {
                let (instance, elements) = (instance.as_deref(), elements.as_deref());
                meshes.solid_part(&base.join(file), instance, elements).map_err(failed)?
            }
            PartSource::Rigid { file, instance, surface } => {
                meshes.rigid_part(&base.join(file), instance.as_deref(), surface).map_err(failed)?
            }
        };
        if let Some(has) = self.incompatible_modes {
            let is_from_file = matches!(self.source, PartSource::Solid { .. });
            if is_from_file && part.elements.iter().all(|cell| cell.kind != ElementKind::Hexahedron8) {
                return Err(Box::new(Problem::NoHexahedra { part: name() }));
            }
            part.elements.set_incompatible_modes(|_| has);
        }
        self.rotations.iter().for_each(|rotation| part.rotate(rotation));
        part.translate(self.translation);
        Ok(part)
    }
}

/// The only set of the part whose name differs by letter case alone: Abaqus does not tell case apart. The name of the part does.
fn alike<'a, T>(among: &'a BTreeMap<String, T>, name: &str) -> Option<&'a T> {
    let (part, set) = name.split_once('.')?;
    let set = set.to_lowercase();
    let is_alike = |other: &&String| {
        other.split_once('.').is_some_and(|(owner, other)| owner == part && other.to_lowercase() == set)
    };
    let mut found = among.keys().filter(is_alike);
    let first = found.next()?;
    if found.next().is_none() { among.get(first) } else { None }
}

/// The name that was meant. If the part is right its set is misspelt, and compared alone: beside a long part any set looks like a slip.
fn nearest_name<'a>(name: &str, among: impl Iterator<Item = &'a str> + Clone) -> Option<&'a str> {
    let sets_of = |part| {
        among.clone().filter_map(move |other| {
            other.split_once('.').filter(|(owner, _)| *owner == part).map(|(_, set)| (set, other))
        })
    };
    match name.split_once('.') {
        Some((part, set)) if among.clone().any(|other| other == part) => {
            let meant = nearest(set, sets_of(part).map(|(set, _)| set))?;
            sets_of(part).find(|(set, _)| *set == meant).map(|(_, other)| other)
        }
        _ => nearest(name, among),
    }
}

/// Names in the order in which a list is of use: those of the part that was asked for first, the closest spellings first.
fn closest_first<'a>(name: &str, among: impl Iterator<Item = &'a str> + Clone) -> Vec<&'a str> {
    fn split(name: &str) -> (&str, &str) {
        name.split_once('.').unwrap_or((name, ""))
    }
    if !name.contains('.') && among.clone().all(|other| !other.contains('.')) {
        return names::closest_first(name, among);
    }
    let (part, set) = split(name);
    // A part of this name, or the one that was meant.
    let parts = among.clone().map(|other| split(other).0);
    let part = parts.clone().find(|&other| other == part).or_else(|| nearest(part, parts));
    let (own, others): (Vec<&str>, Vec<&str>) = among.partition(|&other| Some(split(other).0) == part);
    let mut sorted = Vec::new();
    for names in [own, others] {
        let sets: BTreeSet<&str> = names.iter().map(|&other| split(other).1).collect();
        let place: HashMap<&str, usize> = names::closest_first(set, sets)
            .into_iter()
            .enumerate()
            .map(|(place, set)| (set, place))
            .collect();
        let start = sorted.len();
        sorted.extend(names);
        sorted[start..].sort_by_key(|&other| (place[split(other).1], other));
    }
    sorted
}

/// What the boundaries are called in results: by their node sets, and by a number where those are the same.
fn support_names(boundaries: &[Boundary]) -> Vec<String> {
    let joined = |boundary: &Boundary| {
        let sets: Vec<&str> = boundary.nodes.iter().map(|name| name.name.as_str()).collect();
        sets.join("+")
    };
    distinct(boundaries.iter().map(joined))
}

fn nodes_of(facets: &[Facet]) -> BTreeSet<usize> {
    facets.iter().flat_map(Facet::corners).copied().collect()
}
