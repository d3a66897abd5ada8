//! Contact integrated over the slave's faces: pressures that finite elements can carry.
//!
//! A force at each slave node, spread over the masters by the weights of a fit, does not arrive as the pressure that it stands for:
//! no patch test is passed. Here the kinematics stay those of the smooth surface, but forces go by the shape functions of the faces on
//! both sides (docs/equations.md, section 18, T17):
//!
//! ```text
//! ḡ_A = ∫ N_A g dA / ∫ N_A dA        p_A = max(0, λ_A − ε ḡ_A)        p = Σ N_A p_A
//! f_a =  ∫ p N_a d dA                on the slave face, d along ∂g/∂x of its point
//! f_k = −∫ p N_k(η) d dA             on the master facet, where the line through the face's point along d meets it
//! ```
//!
//! * **Balance.** Σ f = 0, and Σ x × f = 0: the points of face and facet lie on one line along the force.
//! * **Patch test.** Faces are cut along the edges of the facets over them, so that uniform pressures pass exactly between faces whose
//!   opposite edges are parallel.
//! * **Areas** are those of the first configuration: p is force per area there.
//! * **Tangent.** Exact but for the places of the points, which are held: what a face integrates does not depend on them to the order
//!   of the [`FaceRule`]. It is not symmetric. The energy form of [`ContactInterface`], symmetric and conservative, stays beside it.
//! * **No history.** Points follow from the positions of a refresh: a restart needs the first positions and the multipliers only.
//! * **Layers.** Where facets that look at a face lie over one another, the nearest carries.
//!
//! ```
//! use diffuse_contact::assembly::{ContactLaw, DofMap, Tangent};
//! use diffuse_contact::faces::{FaceInterface, FaceOptions};
//! use diffuse_contact::surface::{Facet, MasterSurface};
//! use diffuse_contact::{InterfaceOptions, Mode};
//!
//! // Cells of 1 below cells of 1.5, both 6 wide; the upper ones look down.
//! let grid = |cells: i32, z: f64| {
//!     let size = 6.0 / f64::from(cells);
//!     let n = cells + 1;
//!     (0..n * n).map(move |k| [f64::from(k % n) * size, f64::from(k / n) * size, z])
//! };
//! let positions: Vec<[f64; 3]> = grid(6, 0.0).chain(grid(4, -0.01)).collect();
//! let node = |first: usize, n: usize, k: usize| first + k % (n - 1) + n * (k / (n - 1));
//! let master = (0..36).map(|k| node(0, 7, k)).map(|k| Facet::Quadrilateral([k, k + 1, k + 8, k + 7]));
//! let slave = (0..16).map(|k| node(49, 5, k)).map(|k| Facet::Quadrilateral([k, k + 5, k + 6, k + 1]));
//!
//! let master = MasterSurface::new(&positions, master.collect())?;
//! let slave: Vec<Facet> = slave.collect();
//! let options = FaceOptions::new(InterfaceOptions::default());
//! let mut interface = FaceInterface::new(master, &slave, &positions, options)?;
//! interface.update(&positions)?;
//! let contacts = interface.evaluate(&ContactLaw::penalty(100.0), Mode::Hessian)?;
//!
//! // A pressure of 1 everywhere: a node inside the master carries its cell's area, 1.
//! let dofs = DofMap::standard(positions.len());
//! let mut forces = vec![0.0; dofs.equations()];
//! contacts.add_residual(&dofs, &mut forces)?;
//! assert!((forces[3 * 24 + 2] + 1.0).abs() < 1e-12);
//! let tangent = contacts.triplets(Tangent::Exact, &dofs)?;
//! assert!(!tangent.is_empty());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod block;
mod carried;
mod contacts;
mod cut;
mod skin;

pub use contacts::{FaceContacts, NodeContact, TangentBlock};
pub use cut::FaceRule;

use std::ops::Range;

use rayon::prelude::*;

use block::{FaceBlock, FaceView};
use contacts::{DirectionBlock, NodeBlock};
use cut::{CutScratch, FacePoint, cut};
use skin::{Skin, shape};

use crate::assembly::ContactLaw;
use crate::interface::{
    ContactElement, ContactInterface, InterfaceError, InterfaceOptions, NoContact, Outcome, Results,
};
use crate::neighbourhood::{Fallback, NeighbourRule};
use crate::surface::{Facet, MasterSurface, SymmetryPlane};
use crate::vector::Vector3;
use crate::{Mode, Point};

/// Nodes with less than this part of their area over the master carry nothing.
const SMALLEST_AREA: f64 = 1e-9;
/// Pieces stay while no node has moved farther than this part of the smallest facet. What they miss of the edges between facets is of
/// the order of its square, of the master's end of its first.
const HELD: f64 = 1e-5;
/// Points that one thread evaluates in a row.
const CHUNK: usize = 256;

/// How a [`FaceInterface`] integrates.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct FaceOptions {
    /// The master's element, and how points are paired with it. A distance limit of `None` is a facet's and a face's extent together.
    /// Areas are always those of the faces.
    pub interface: InterfaceOptions,
    /// Points of each piece of a face.
    pub rule: FaceRule,
}

impl FaceOptions {
    /// With three or four points for each piece of a face.
    #[must_use]
    pub fn new(interface: InterfaceOptions) -> Self {
        Self { interface, rule: FaceRule::default() }
    }

    /// With this rule.
    #[must_use]
    pub const fn with_rule(self, rule: FaceRule) -> Self {
        Self { rule, ..self }
    }
}

/// What the cutting of the faces gave.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FaceReport {
    /// Points.
    pub points: usize,
    /// Of these: paired with masters.
    pub paired: usize,
    /// Faces with points.
    pub faces: usize,
    /// Whether nodes couple that did not since the last [`refresh`](FaceInterface::refresh): a pattern made for the ones of before is too
    /// small.
    pub grown: bool,
}

/// The faces of a slave's surface against a master surface.
#[derive(Debug)]
pub struct FaceInterface {
    /// Its slaves are the points.
    interface: ContactInterface,
    options: FaceOptions,
    faces: Vec<Facet>,
    skin: Skin,
    /// Positions that areas are measured in.
    first: Vec<Point>,
    /// Of all nodes, by the last update or refresh.
    positions: Vec<Point>,
    /// Corners of the faces, ascending.
    nodes: Vec<usize>,
    /// ∫ N_A dA over all of each node's faces, length².
    areas: Vec<f64>,
    /// The faces of each node.
    around: Vec<Vec<u32>>,
    points: Vec<FacePoint>,
    /// Of each face: how far away a facet may be, length.
    limits: Vec<f64>,
    /// Of each face.
    cuts: Vec<FaceCut>,
    /// Where the faces were cut, of all nodes.
    cut_at: Option<Vec<Point>>,
    /// What cutting gave.
    report: FaceReport,
    /// The smallest extent of a face or a facet in the first configuration.
    smallest: f64,
    /// What each node has been coupled with since the last refresh.
    cliques: Vec<Vec<u32>>,
    contacts: FaceContacts,
}

/// The points of a face and the nodes of its sums.
#[derive(Clone, Debug, Default, PartialEq)]
struct FaceCut {
    points: Range<usize>,
    rows: Vec<u32>,
    columns: Vec<u32>,
}

impl FaceInterface {
    /// An interface without points: until the first [`refresh`](Self::refresh) or [`update`](Self::update) there is no contact.
    ///
    /// `positions` are those of all nodes in the first configuration; the corners of `faces` and those of the master's facets are indices
    /// into them. Faces run counter-clockwise seen from outside.
    ///
    /// # Errors
    /// As [`ContactInterface::new`]; [`InterfaceError::FacesNeedDomains`]; [`InterfaceError::Surface`] also for faces whose own smooth surface cannot be found.
    pub fn new(
        master: MasterSurface,
        faces: &[Facet],
        positions: &[Point],
        options: FaceOptions,
    ) -> Result<Self, InterfaceError> {
        let own = InterfaceOptions { areas: false, ..options.interface };
        if let ContactElement::Diffuse { search, .. } = own.element
            && search.rule != NeighbourRule::Domains
        {
            return Err(InterfaceError::FacesNeedDomains);
        }
        let mut nodes: Vec<usize> = faces.iter().flat_map(|face| face.corners()).copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        // As slaves the nodes are checked like others.
        ContactInterface::new(master.clone(), nodes.clone(), faces, positions, own.with_areas(true))?;
        let areas = crate::surface::tributary_areas(positions, faces)?;
        let areas = nodes.iter().map(|&node| areas[node]).collect();
        let skin = Skin::new(faces, positions, &own, &[])?;
        let mut around = vec![Vec::new(); nodes.len()];
        for (k, face) in faces.iter().enumerate() {
            for node in face.corners() {
                if let Ok(place) = nodes.binary_search(node) {
                    around[place].push(k as u32);
                }
            }
        }
        let facets = (0..master.facet_count()).map(|facet| master.facet(facet));
        let extents = facets.chain(faces.iter().copied()).map(|facet| shape(&facet, positions).extent());
        let smallest = extents.fold(f64::INFINITY, f64::min);
        Ok(Self {
            interface: ContactInterface::new(master, Vec::new(), &[], positions, own)?,
            options,
            faces: faces.to_vec(),
            skin,
            first: positions.to_vec(),
            positions: positions.to_vec(),
            cliques: vec![Vec::new(); nodes.len()],
            nodes,
            areas,
            around,
            points: Vec::new(),
            limits: Vec::new(),
            cut_at: None,
            report: FaceReport::default(),
            smallest,
            cuts: vec![FaceCut::default(); faces.len()],
            contacts: FaceContacts::default(),
        })
    }

    /// Makes these planes of symmetry of both surfaces, as [`ContactInterface::set_symmetry`], in the first configuration. There is no
    /// contact until the next [`refresh`](Self::refresh) or [`update`](Self::update).
    ///
    /// # Errors
    /// As there. The interface is then as it was.
    pub fn set_symmetry(&mut self, planes: &[SymmetryPlane]) -> Result<(), InterfaceError> {
        let own = InterfaceOptions { areas: false, ..self.options.interface };
        let skin = Skin::new(&self.faces, &self.first, &own, planes)?;
        let mut interface = ContactInterface::new(self.master().clone(), Vec::new(), &[], &self.first, own)?;
        interface.set_symmetry(planes)?;
        (self.skin, self.interface) = (skin, interface);
        self.cut_at = None;
        self.points.clear();
        self.limits.clear();
        self.cuts.fill(FaceCut::default());
        self.cliques.fill(Vec::new());
        (self.report, self.contacts) = (FaceReport::default(), FaceContacts::default());
        Ok(())
    }

    /// The options.
    #[must_use]
    pub const fn options(&self) -> &FaceOptions {
        &self.options
    }

    /// The master surface.
    #[must_use]
    pub const fn master(&self) -> &MasterSurface {
        self.interface.master()
    }

    /// The nodes of the slave's faces, in the order of all results.
    #[must_use]
    pub fn slaves(&self) -> &[usize] {
        &self.nodes
    }

    /// ∫ N_A dA over all faces of each node in the first configuration, length².
    #[must_use]
    pub fn areas(&self) -> &[f64] {
        &self.areas
    }

    /// The nodes that the faces around the `k`-th node exert forces on, as they are cut now; some may be there more than once.
    ///
    /// # Panics
    /// If there is no such node.
    pub fn carriers(&self, k: usize) -> impl Iterator<Item = u32> + '_ {
        self.around[k].iter().flat_map(|&face| self.cuts[face as usize].rows.iter().copied())
    }

    /// Middles of edges and faces where the slave's own nodes carry no fit: there its faces are as flat as their corners say.
    #[must_use]
    pub const fn straight(&self) -> usize {
        self.skin.straight
    }

    /// The first configuration, of all nodes.
    #[must_use]
    pub fn first_positions(&self) -> &[Point] {
        &self.first
    }

    /// Takes over the positions and cuts the faces anew. What nodes couple is forgotten and begins with these positions.
    ///
    /// # Errors
    /// As [`ContactInterface::update`]. Points and positions of before then stay.
    pub fn refresh(&mut self, positions: &[Point]) -> Result<FaceReport, InterfaceError> {
        self.take(positions, true)
    }

    /// Takes over the positions, to be called in every iteration. Faces are cut anew unless all nodes are as good as where they were
    /// when they were cut: near equilibrium forces are smooth functions of the positions then, and the tangent is their derivative.
    /// What nodes couple only grows.
    ///
    /// # Errors
    /// As [`refresh`](Self::refresh).
    pub fn update(&mut self, positions: &[Point]) -> Result<FaceReport, InterfaceError> {
        self.check_positions(positions)?;
        if self.is_near_cut(positions) {
            self.move_points(positions)?;
            return Ok(FaceReport { grown: false, ..self.report });
        }
        self.take(positions, false)
    }

    fn check_positions(&self, positions: &[Point]) -> Result<(), InterfaceError> {
        let (found, expected) = (positions.len(), self.first.len());
        if found != expected {
            return Err(InterfaceError::WrongNumberOfPositions { found, expected });
        }
        self.master().check_positions(positions)?;
        Ok(self.nodes.iter().try_for_each(|&node| crate::surface::check_position(positions, node))?)
    }

    /// Whether no node has moved far enough since the faces were cut for their pieces to be others.
    fn is_near_cut(&self, positions: &[Point]) -> bool {
        let Some(cut_at) = &self.cut_at else { return false };
        let masters = self.master().nodes().iter().map(|&node| node as usize);
        let moved = |node: usize| (Vector3::from(positions[node]) - Vector3::from(cut_at[node])).norm();
        self.nodes.iter().copied().chain(masters).all(|node| moved(node) <= HELD * self.smallest)
    }

    /// All points where they are on their faces, over their facets.
    fn move_points(&mut self, positions: &[Point]) -> Result<(), InterfaceError> {
        let mut all = positions.to_vec();
        for (k, cut) in self.cuts.iter().enumerate() {
            let corners = self.faces[k].corners().len();
            let own = self.points[cut.points.clone()].iter();
            all.extend(own.map(|point| self.skin.position(k, corners, point.natural, positions)));
        }
        self.interface.update(&all)?;
        self.positions.copy_from_slice(positions);
        Ok(())
    }

    fn take(&mut self, positions: &[Point], forgets: bool) -> Result<FaceReport, InterfaceError> {
        self.check_positions(positions)?;
        let index = self.master().at(positions)?;
        let limit = |face: &Facet| {
            let extent = shape(face, positions).extent() + index.extent();
            self.options.interface.distance_limit.unwrap_or(extent)
        };
        let limits: Vec<f64> = self.faces.iter().map(limit).collect();
        let by_face: Vec<Vec<FacePoint>> = (0..self.faces.len())
            .into_par_iter()
            .map_init(CutScratch::default, |scratch, k| {
                let mut points = Vec::new();
                let face = shape(&self.faces[k], positions);
                let first = shape(&self.faces[k], &self.first);
                cut(&face, &first, &index, (self.options.rule, limits[k]), scratch, &mut points);
                points
            })
            .collect();
        let mut all = positions.to_vec();
        for (k, points) in by_face.iter().enumerate() {
            let corners = self.faces[k].corners().len();
            all.extend(points.iter().map(|point| self.skin.position(k, corners, point.natural, positions)));
        }
        let facets: Vec<u32> = by_face.iter().flatten().map(|point| point.facet).collect();
        let report = self.interface.pair_points(all, positions.len(), &facets)?;
        self.positions.copy_from_slice(positions);
        self.limits = limits;
        self.points = by_face.concat();
        let mut end = 0;
        let ranges: Vec<Range<usize>> = by_face
            .iter()
            .map(|points| {
                end += points.len();
                end - points.len()..end
            })
            .collect();
        self.cuts = ranges.into_par_iter().enumerate().map(|(k, points)| self.cut_of(k, points)).collect();
        let grown = self.couple(forgets);
        let faces = self.cuts.iter().filter(|cut| !cut.points.is_empty()).count();
        self.cut_at = Some(positions.to_vec());
        self.report = FaceReport { points: self.points.len(), paired: report.paired, faces, grown };
        Ok(self.report)
    }

    /// The largest limit of the faces around a node, at the last positions.
    fn limit_around(&self, k: usize) -> f64 {
        let of_face = |&face: &u32| self.limits.get(face as usize).copied().unwrap_or(0.0);
        self.around[k].iter().map(of_face).fold(0.0, f64::max)
    }

    fn cut_of(&self, k: usize, points: Range<usize>) -> FaceCut {
        if points.is_empty() {
            return FaceCut::default();
        }
        let mut rows: Vec<u32> = self.faces[k].corners().iter().map(|&node| node as u32).collect();
        let facets = self.points[points.clone()].iter().map(|point| point.facet as usize);
        facets.for_each(|facet| {
            rows.extend(self.master().facet(facet).corners().iter().map(|&node| node as u32))
        });
        sort(&mut rows);
        let mut columns = rows.clone();
        columns.extend(self.skin.faces[k].carriers.iter().map(|carrier| carrier.node));
        points.clone().for_each(|point| columns.extend_from_slice(self.interface.listed(point)));
        sort(&mut columns);
        FaceCut { points, rows, columns }
    }

    /// Nodes that the faces around each node couple; whether there are new ones.
    fn couple(&mut self, forgets: bool) -> bool {
        let Self { cliques, around, cuts, .. } = self;
        let grown = cliques.par_iter_mut().zip(around).map(|(clique, around)| {
            let mut nodes: Vec<u32> = Vec::new();
            around.iter().for_each(|&face| nodes.extend_from_slice(&cuts[face as usize].columns));
            sort(&mut nodes);
            let is_new = nodes.iter().any(|node| clique.binary_search(node).is_err());
            if forgets {
                *clique = nodes;
            } else if is_new {
                clique.extend(nodes);
                sort(clique);
            }
            is_new
        });
        grown.reduce(|| false, |one, other| one | other)
    }

    /// Nodes that couple with one another by the faces around each node: those of the last refresh and all updates since.
    pub fn cliques(&self) -> impl Iterator<Item = &[u32]> {
        self.cliques.iter().map(Vec::as_slice).filter(|clique| !clique.is_empty())
    }

    /// That of the `k`-th node; empty if no facet lies over its faces.
    ///
    /// # Panics
    /// If there is no such node.
    #[must_use]
    pub fn clique(&self, k: usize) -> &[u32] {
        &self.cliques[k]
    }

    /// What the last [`evaluate`](Self::evaluate) returned; empty before.
    #[must_use]
    pub const fn contacts(&self) -> &FaceContacts {
        &self.contacts
    }

    /// Gaps and pressures of all nodes by a law at the positions of the last update; with [`Mode::Gradient`] the forces and ε F Gᵀ, with
    /// [`Mode::Hessian`] the exact tangent. The law's penalty is per area, and so are its multipliers: pressures, one per node.
    ///
    /// # Errors
    /// [`InterfaceError::Law`], [`InterfaceError::FrictionOverFaces`], [`InterfaceError::OutOfMemory`].
    pub fn evaluate(&mut self, law: &ContactLaw<'_>, mode: Mode) -> Result<&FaceContacts, InterfaceError> {
        law.validate(self.nodes.len())?;
        if law.friction.is_some() {
            return Err(InterfaceError::FrictionOverFaces);
        }
        let nodes = self.averages(law)?;
        let mut contacts = FaceContacts { nodes, mode, ..FaceContacts::default() };
        if mode >= Mode::Gradient {
            self.derive(law, mode, &mut contacts)?;
        }
        self.contacts = contacts;
        Ok(&self.contacts)
    }

    /// The average gap at each node, and its pressure.
    fn averages(&self, law: &ContactLaw<'_>) -> Result<Vec<NodeContact>, InterfaceError> {
        let blank = |(k, &slave): (usize, &usize)| {
            let outcome = Outcome::None(NoContact::NothingOver { limit: self.limit_around(k) });
            NodeContact { slave, outcome, gap: 0.0, area: 0.0, normal: [0.0; 3], pressure: 0.0 }
        };
        let mut nodes: Vec<NodeContact> = self.nodes.iter().enumerate().map(blank).collect();
        let mut face = 0;
        let mut results = Results::default();
        self.interface.evaluate_range(0..self.points.len(), Mode::Value, &mut results, |contact| {
            let k = contact.slave - self.positions.len();
            while !self.cuts[face].points.contains(&k) {
                face += 1;
            }
            let point = &self.points[k];
            let functions = shape(&self.faces[face], &self.positions).functions(point.natural);
            for (corner, n) in self.faces[face].corners().iter().zip(functions) {
                let Ok(place) = self.nodes.binary_search(corner) else { continue };
                let node = &mut nodes[place];
                match (contact.outcome, node.outcome) {
                    (Outcome::Contact { .. }, _) => {
                        let weight = point.weight * n;
                        // Of several the one that gave up most.
                        if !matches!(node.outcome, Outcome::Contact { fallback: Fallback::Linear { .. } }) {
                            node.outcome = contact.outcome;
                        }
                        node.area += weight;
                        node.gap += weight * contact.point.gap;
                        for axis in 0..3 {
                            node.normal[axis] += weight * contact.point.normal[axis];
                        }
                    }
                    (reason, Outcome::None(NoContact::NothingOver { .. })) => node.outcome = reason,
                    (Outcome::None(_), _) => {}
                }
            }
        })?;
        for (k, (node, area)) in nodes.iter_mut().zip(&self.areas).enumerate() {
            if !(node.area > SMALLEST_AREA * area) {
                let outcome = match node.outcome {
                    Outcome::Contact { .. } => {
                        Outcome::None(NoContact::NothingOver { limit: self.limit_around(k) })
                    }
                    reason => reason,
                };
                *node = NodeContact { outcome, gap: 0.0, area: 0.0, normal: [0.0; 3], ..*node };
                continue;
            }
            node.gap /= node.area;
            let normal = Vector3::from(node.normal).try_normalize().filter(Vector3::is_finite);
            node.normal = normal.unwrap_or_default().into();
            node.pressure = law.force(k, node.gap, 1.0);
        }
        Ok(nodes)
    }

    /// Forces and tangents of the faces around nodes that carry pressure.
    fn derive(
        &self,
        law: &ContactLaw<'_>,
        mode: Mode,
        contacts: &mut FaceContacts,
    ) -> Result<(), InterfaceError> {
        let pressure = |node: &usize| {
            let place = self.nodes.binary_search(node).ok()?;
            let node = &contacts.nodes[place];
            (node.pressure > 0.0).then_some(node.pressure)
        };
        let pressures: Vec<[f64; 4]> = self
            .faces
            .iter()
            .map(|face| {
                let mut own = [0.0; 4];
                for (own, node) in own.iter_mut().zip(face.corners()) {
                    *own = pressure(node).unwrap_or(0.0);
                }
                own
            })
            .collect();
        let is_loaded =
            |k: &usize| !self.cuts[*k].points.is_empty() && pressures[*k].iter().any(|&p| p > 0.0);
        let loaded: Vec<usize> = (0..self.faces.len()).filter(is_loaded).collect();
        let blocks: Vec<Vec<FaceBlock>> = self
            .runs(&loaded)
            .into_par_iter()
            .map_init(Results::default, |results, faces| self.blocks(faces, mode, &pressures, results))
            .collect::<Result<_, _>>()?;
        let mut of_face: Vec<Option<FaceBlock>> = vec![None; self.faces.len()];
        for (&k, block) in loaded.iter().zip(blocks.into_iter().flatten()) {
            contacts.missed += block.missed;
            of_face[k] = Some(block);
        }
        let carrying: Vec<(usize, NodeContact)> =
            contacts.nodes.iter().copied().enumerate().filter(|(_, node)| node.pressure > 0.0).collect();
        contacts.blocks =
            carrying.into_par_iter().map(|(k, node)| self.node_block(k, &node, law, &of_face)).collect();
        if mode >= Mode::Hessian {
            contacts.directions = loaded
                .iter()
                .filter_map(|&k| {
                    let FaceCut { rows, columns, .. } = self.cuts[k].clone();
                    Some(DirectionBlock { rows, columns, block: of_face[k].take()? })
                })
                .collect();
        }
        Ok(())
    }

    /// Faces one after another whose points are evaluated together.
    fn runs<'s>(&self, loaded: &'s [usize]) -> Vec<&'s [usize]> {
        let mut count = 0;
        loaded
            .chunk_by(|&one, &next| {
                count += self.cuts[one].points.len();
                let goes_on = self.cuts[one].points.end == self.cuts[next].points.start && count < CHUNK;
                if !goes_on {
                    count = 0;
                }
                goes_on
            })
            .collect()
    }

    /// The sums of consecutive faces.
    fn blocks(
        &self,
        faces: &[usize],
        mode: Mode,
        pressures: &[[f64; 4]],
        results: &mut Results,
    ) -> Result<Vec<FaceBlock>, InterfaceError> {
        let views: Vec<FaceView<'_>> = faces
            .iter()
            .map(|&k| FaceView {
                facet: &self.faces[k],
                shape: shape(&self.faces[k], &self.positions),
                skin: &self.skin,
                face: k,
                rows: &self.cuts[k].rows,
                columns: &self.cuts[k].columns,
            })
            .collect();
        let mut blocks: Vec<FaceBlock> = views.iter().map(|view| FaceBlock::new(view, mode)).collect();
        let (Some(&first), Some(&last)) = (faces.first(), faces.last()) else { return Ok(blocks) };
        let range = self.cuts[first].points.start..self.cuts[last].points.end;
        let mut own = 0;
        self.interface.evaluate_range(range, mode, results, |contact| {
            let k = contact.slave - self.positions.len();
            while !self.cuts[faces[own]].points.contains(&k) {
                own += 1;
            }
            if contact.outcome.is_contact() {
                let point = &self.points[k];
                let facet = self.master().facet(point.facet as usize);
                let over = shape(&facet, &self.positions);
                let pressures = &pressures[faces[own]];
                blocks[own].add(&views[own], point, (facet.corners(), &over), &contact, pressures);
            }
        })?;
        Ok(blocks)
    }

    /// The sums of the faces around a node.
    fn node_block(
        &self,
        k: usize,
        node: &NodeContact,
        law: &ContactLaw<'_>,
        of_face: &[Option<FaceBlock>],
    ) -> NodeBlock {
        let faces = || {
            self.around[k].iter().filter_map(|&face| Some((face as usize, of_face[face as usize].as_ref()?)))
        };
        let mut nodes: Vec<u32> = faces().flat_map(|(face, _)| &self.cuts[face].columns).copied().collect();
        sort(&mut nodes);
        let mut sums = NodeBlock {
            forces: vec![0.0; 3 * nodes.len()],
            gradient: vec![0.0; 3 * nodes.len()],
            nodes,
            pressure: node.pressure,
            stiffness: law.penalty,
        };
        for (face, block) in faces() {
            let corner = self.faces[face].corners().iter().position(|&corner| corner == node.slave);
            let Some(corner) = corner else { continue };
            let cut = &self.cuts[face];
            add(&sums.nodes, &mut sums.forces, &cut.rows, &block.forces[corner], 1.0);
            add(&sums.nodes, &mut sums.gradient, &cut.columns, &block.gradients[corner], 1.0 / node.area);
        }
        sums
    }
}

/// Ascending, each once.
fn sort(nodes: &mut Vec<u32>) {
    nodes.sort_unstable();
    nodes.dedup();
}

/// Adds a vector over some of the nodes.
fn add(nodes: &[u32], sums: &mut [f64], own: &[u32], values: &[f64], factor: f64) {
    let mut place = 0;
    for (node, values) in own.iter().zip(values.as_chunks::<3>().0) {
        while nodes[place] != *node {
            place += 1;
        }
        for axis in 0..3 {
            sums[3 * place + axis] += factor * values[axis];
        }
    }
}

#[cfg(test)]
mod tests;
