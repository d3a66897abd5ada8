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
//! * **Pressures of points** instead, p = max(0, Σ N_A λ_A − ε g) at each, by [`FacePressures::Points`]: for faces that are wide beside
//!   the master's radius of curvature.
//! * **Balance.** Σ f = 0, and Σ x × f = 0: the points of face and facet lie on one line along the force.
//! * **Sharp edges.** What is averaged belongs to one sheet of the slave: a node on an edge sharper than the feature angle has a gap and a
//!   pressure for each sheet that meets there ([`slaves`](FaceInterface::slaves)).
//! * **Patch test.** Faces are cut along the edges of the facets over them, so that uniform pressures pass exactly between faces whose
//!   opposite edges are parallel.
//! * **Areas** are those of the first configuration: p is force per area there.
//! * **Tangent.** Exact but for the places of the points, which are held: what a face integrates does not depend on them to the order
//!   of the [`FaceRule`]. It is not symmetric. The energy form of [`ContactInterface`], symmetric and conservative, stays beside it.
//! * **History.** Without friction there is none: points follow from the positions of a refresh. A restart needs the first positions and
//!   the multipliers. Friction remembers for each node what it stuck to: [`history`](FaceInterface::history).
//! * **Second order.** Faces of 6, 8 or 9 nodes come as flat facets between all of their nodes, for gaps, pieces and pressures. With
//!   [`set_quadratic_faces`](FaceInterface::set_quadratic_faces) N_a and N_k are theirs as a whole, in windows with
//!   [`set_quadratic_faces_by_number`](FaceInterface::set_quadratic_faces_by_number).
//! * **Layers.** Where facets that look at a face lie over one another, the nearest carries. What lies behind a facet that looks the
//!   way the face does, as the far side of a plate, carries nothing.
//! * **Self contact.** [`self_contact`](FaceInterface::self_contact) has one surface, whose faces are slaves and facets at once.
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
//! contacts.add_forces(&dofs, &mut forces)?;
//! assert!((forces[3 * 24 + 2] + 1.0).abs() < 1e-12);
//! let tangent = contacts.triplets(Tangent::Exact, &dofs)?;
//! assert!(!tangent.is_empty());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod block;
mod carried;
mod contacts;
mod cover;
mod create;
mod cut;
mod evaluate;
mod friction;
mod points;
mod product;
mod quadratic;
mod skin;
mod slave_nodes;
mod track;
mod window;

pub use contacts::{FaceContacts, NodeContact, TangentBlock};
pub use cover::{CoveredPlace, FaceCover};
pub use cut::FaceRule;
pub use points::IntegrationPoint;
pub use quadratic::QuadraticFace;

use std::ops::Range;

use rayon::prelude::*;

use cut::{CutScratch, Cutting, FacePoint, cut};
use evaluate::Averages;
use quadratic::{Carriers, Carrying};
use skin::Skin;
use slave_nodes::SlaveNodes;
use track::Track;
use window::FaceWindow;

use crate::assembly::ContactLaw;
use crate::interface::{ContactInterface, InterfaceError, InterfaceOptions, NoContact};
use crate::surface::{Facet, MasterSurface, OwnSurface, SurfaceIndex, check_position, shape_of, sort};
use crate::vector::Vector3;
use crate::with::with;
use crate::{Mode, Point};

/// Pieces stay while no node has moved farther than this part of the smallest facet. What they miss of the edges between facets is of
/// the order of its square, of the master's end of its first.
const HELD: f64 = 1e-5;

/// Where the pressure follows from the gap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FacePressures {
    /// At the slave's nodes, from the average gap around each: no more unknown pressures than the slave has nodes, so that a stiff penalty
    /// leaves them smooth.
    #[default]
    Nodes,
    /// At each integration point, from its own gap: for faces that touch with a small part of themselves, as coarse ones do on a small
    /// radius. A stiff penalty makes pressures rough. Multipliers are interpolated between the nodes, so that augmentation closes average gaps.
    Points,
}

impl FacePressures {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Nodes, Self::Points];

    /// Its name, as decks and Python have it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nodes => "nodes",
            Self::Points => "points",
        }
    }
}

/// How a [`FaceInterface`] integrates.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct FaceOptions {
    /// The master's element, and how points are paired with it. A distance limit of `None` is the extents of the face
    /// and of the facet over it together; in self contact it is two mean extents of a facet. Areas are always those of the faces.
    pub interface: InterfaceOptions,
    /// Points of each piece of a face. Between a face and a facet of which one belongs to a quadrilateral of second order it is
    /// [`FaceRule::Fourth`] always.
    pub rule: FaceRule,
    /// Where pressures follow from gaps.
    pub pressures: FacePressures,
}

impl FaceOptions {
    /// With the rule of second degree, and pressures of nodes.
    pub fn new(interface: InterfaceOptions) -> Self {
        Self { interface, rule: FaceRule::default(), pressures: FacePressures::default() }
    }

    with! {
        /// With this rule.
        with_rule(rule: FaceRule);
        /// With pressures of these.
        with_pressures(pressures: FacePressures);
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
    /// What faces may touch, if the surface is in contact with itself.
    own: Option<OwnSurface>,
    /// What is known of the surfaces, if that is not all.
    window: Option<FaceWindow>,
    options: FaceOptions,
    faces: Vec<Facet>,
    /// What carries the forces of faces and facets.
    carriers: Carriers,
    skin: Skin,
    /// Positions that areas are measured in.
    first: Vec<Point>,
    /// Of all nodes, by the last update or refresh.
    positions: Vec<Point>,
    /// Corners of the faces.
    slaves: SlaveNodes,
    points: Vec<FacePoint>,
    /// Of each face: how far away a facet may be, length.
    limits: Vec<f64>,
    /// Of each face.
    cuts: Vec<FaceCut>,
    /// Where the faces were cut, of all nodes.
    cut_at: Option<Vec<Point>>,
    /// Of each face: points whose place on it or on the facet was not found.
    unplaced: Vec<usize>,
    /// What cutting gave.
    report: FaceReport,
    /// The smallest extent of a face or a facet in the first configuration.
    smallest: f64,
    /// What each node has been coupled with since the last refresh.
    cliques: Vec<Vec<u32>>,
    /// The history of friction, one entry per node; `None` before a state was accepted.
    tracks: Option<Vec<Option<Track>>>,
    /// What augmentation made of it since.
    augmented: Option<Vec<Option<Track>>>,
    contacts: FaceContacts,
}

/// What cutting a face gave.
#[derive(Debug, Default)]
struct CutFace {
    points: Vec<FacePoint>,
    /// Points whose place was not found.
    unplaced: usize,
    /// What its window does not know; then there are no points.
    beyond: Option<NoContact>,
}

/// The points of a face and the nodes of its sums.
#[derive(Clone, Debug, Default, PartialEq)]
struct FaceCut {
    points: Range<usize>,
    rows: Vec<u32>,
    columns: Vec<u32>,
}

impl FaceInterface {
    /// The options.
    pub const fn options(&self) -> &FaceOptions {
        &self.options
    }

    /// From the next evaluation on with pressures of these.
    pub const fn set_pressures(&mut self, pressures: FacePressures) {
        self.options.pressures = pressures;
    }

    /// The master surface.
    pub const fn master(&self) -> &MasterSurface {
        self.interface.master()
    }

    /// The nodes of the slave's faces, in the order of all results: ascending, and one on an edge sharper than the
    /// [feature angle](InterfaceOptions::feature_angle_degrees) in the first configuration once for each sheet that meets there. Sheets of
    /// one node come in the order of their lowest faces.
    pub fn slaves(&self) -> &[usize] {
        &self.slaves.nodes
    }

    /// ∫ N_A dA over the faces of each in the first configuration, length².
    pub fn areas(&self) -> &[f64] {
        &self.slaves.areas
    }

    /// The nodes that the faces around the `k`-th slave exert forces on, as they are cut now; some may be there more than once.
    ///
    /// # Panics
    /// If there is no such node.
    pub fn carriers(&self, k: usize) -> impl Iterator<Item = u32> + '_ {
        self.slaves.around[k].iter().flat_map(|&face| self.cuts[face as usize].rows.iter().copied())
    }

    /// Middles of edges and faces where the slave's own nodes carry no fit: there its faces are as flat as their corners say.
    pub const fn straight(&self) -> usize {
        self.skin.straight
    }

    /// Takes over the positions and cuts the faces anew. What nodes couple is forgotten and begins with these positions.
    ///
    /// # Errors
    /// As [`ContactInterface::update`]. Points and positions of before then stay.
    pub fn refresh(&mut self, positions: &[Point]) -> Result<FaceReport, InterfaceError> {
        self.take(positions, true)
    }

    /// Takes over the positions, to be called in every iteration. Faces are cut anew, unless all nodes have moved by less than 10⁻⁵ of
    /// the smallest facet since. So near equilibrium forces are smooth functions of the positions, and the tangent is their derivative.
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
        InterfaceError::check_count(positions, self.first.len())?;
        self.master().check_positions(positions)?;
        let mut nodes = self.slaves.nodes.iter().chain(&self.carriers.nodes);
        Ok(nodes.try_for_each(|&node| check_position(positions, node))?)
    }

    /// Whether no node has moved far enough since the faces were cut for their pieces to be others.
    fn is_near_cut(&self, positions: &[Point]) -> bool {
        let Some(cut_at) = &self.cut_at else { return false };
        if self.window.as_ref().is_some_and(|window| !window.holds_at(positions)) {
            return false;
        }
        let masters = self.master().nodes().iter().map(|&node| node as usize);
        let moved = |node: usize| (Vector3::from(positions[node]) - Vector3::from(cut_at[node])).norm();
        let others = self.slaves.nodes.iter().chain(&self.carriers.nodes).copied();
        others.chain(masters).all(|node| moved(node) <= HELD * self.smallest)
    }

    /// All points where they are on their faces, over their facets.
    fn move_points(&mut self, positions: &[Point]) -> Result<(), InterfaceError> {
        let mut all = positions.to_vec();
        for (k, cut) in self.cuts.iter().enumerate() {
            let own = self.points[cut.points.clone()].iter();
            all.extend(own.map(|point| self.skin.position(k, point.natural, positions)));
        }
        self.interface.update(&all)?;
        self.positions.copy_from_slice(positions);
        Ok(())
    }

    fn take(&mut self, positions: &[Point], forgets: bool) -> Result<FaceReport, InterfaceError> {
        self.check_positions(positions)?;
        let index = self.master().at(positions)?;
        let limit = |face: &Facet| match (&self.own, self.options.interface.distance_limit) {
            (Some(own), _) => own.limit(),
            (None, Some(limit)) => limit,
            (None, None) => shape_of(face, positions).extent() + index.extent(),
        };
        let limits: Vec<f64> = self.faces.iter().map(limit).collect();
        let beyond = self.window.as_ref().map(|window| window.look(&self.faces, positions, &limits));
        let results: Vec<CutFace> = (0..self.faces.len())
            .into_par_iter()
            .map_init(CutScratch::default, |scratch, k| match beyond.as_ref().and_then(|beyond| beyond[k]) {
                Some(reason) => CutFace { beyond: Some(reason), ..CutFace::default() },
                None => self.cut_face(k, positions, (&index, limits[k]), scratch),
            })
            .collect();
        let mut by_face = Vec::with_capacity(results.len());
        let mut unplaced = Vec::with_capacity(results.len());
        let mut beyond = Vec::with_capacity(results.len());
        for result in results {
            by_face.push(result.points);
            beyond.push(result.beyond);
            unplaced.push(result.unplaced);
        }
        let mut all = positions.to_vec();
        for (k, points) in by_face.iter().enumerate() {
            all.extend(points.iter().map(|point| self.skin.position(k, point.natural, positions)));
        }
        let facets: Vec<u32> = by_face.iter().flatten().map(|point| point.facet).collect();
        let report = self.interface.pair_points(all, positions.len(), &facets)?;
        self.positions.copy_from_slice(positions);
        self.limits = limits;
        if let Some(window) = &mut self.window {
            window.take(beyond);
        }
        self.unplaced = unplaced;
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

    /// Cuts a face along the edges of the facets within its limit.
    fn cut_face(
        &self,
        k: usize,
        positions: &[Point],
        (index, limit): (&SurfaceIndex<'_>, f64),
        scratch: &mut CutScratch,
    ) -> CutFace {
        let face = shape_of(&self.faces[k], positions);
        let first = shape_of(&self.faces[k], &self.first);
        let functions = |natural| self.carriers.faces[k].functions(&face, natural, positions);
        let depth = |facet| match &self.own {
            Some(own) => own.depth_below(self.master(), self.interface.domains(), k as u32, facet),
            None => Some(f64::INFINITY),
        };
        let rule = |facet| self.carriers.rule((k, facet), self.options.rule);
        let is_given = self.own.is_some() || self.options.interface.distance_limit.is_some();
        let extent = face.extent();
        let limit_of = |facet| if is_given { limit } else { extent + index.shape(facet).extent() };
        let cutting = Cutting {
            rule: &rule,
            limit,
            limit_of: &limit_of,
            depth: &depth,
            hides_behind: self.own.is_none(),
        };
        let mut points = Vec::new();
        let unplaced = cut(&face, &first, functions, index, cutting, scratch, &mut points);
        let carrying = |point: &FacePoint| &self.carriers.facets[point.facet as usize];
        let unknown = points.iter().find(|point| matches!(carrying(point), Carrying::Beyond(_)));
        let beyond = unknown.and_then(|point| Some(self.window.as_ref()?.beside(&index.shape(point.facet))));
        if beyond.is_some() {
            CutFace { beyond, ..CutFace::default() }
        } else {
            CutFace { points, unplaced, beyond }
        }
    }

    /// The largest limit of the faces around a node, at the last positions.
    fn limit_around(&self, k: usize) -> f64 {
        let of_face = |&face: &u32| self.limits.get(face as usize).copied().unwrap_or(0.0);
        self.slaves.around[k].iter().map(of_face).fold(0.0, f64::max)
    }

    fn cut_of(&self, k: usize, points: Range<usize>) -> FaceCut {
        if points.is_empty() {
            return FaceCut::default();
        }
        let mut rows: Vec<u32> = self.carriers.faces[k].nodes().iter().map(|&node| node as u32).collect();
        let facets = self.points[points.clone()].iter().map(|point| point.facet as usize);
        facets.for_each(|facet| {
            rows.extend(self.carriers.facets[facet].nodes().iter().map(|&node| node as u32))
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
        let Self { cliques, slaves: SlaveNodes { around, .. }, cuts, tracks, augmented, .. } = self;
        let grown = cliques.par_iter_mut().zip(around).enumerate().map(|(k, (clique, around))| {
            let tracks =
                [&*tracks, &*augmented].into_iter().flatten().filter_map(|tracks| tracks[k].as_ref());
            let mut nodes: Vec<u32> = tracks.flat_map(Track::nodes).collect();
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

    /// What the last [`evaluate`](Self::evaluate) returned; empty before.
    pub const fn contacts(&self) -> &FaceContacts {
        &self.contacts
    }

    /// Gaps and pressures of all nodes by a law at the positions of the last update; with [`Mode::Gradient`] the forces and ε F Gᵀ, with
    /// [`Mode::Hessian`] the exact tangent. The law's penalty is per area, and so are its multipliers: pressures, one per node.
    ///
    /// # Errors
    /// [`InterfaceError::NotRefreshed`] before the first refresh or update; [`InterfaceError::Law`]; [`InterfaceError::OutOfMemory`], after
    /// which there are no contacts. A law with friction needs a state that was [accepted](Self::accept) before nodes carry pressure.
    pub fn evaluate(&mut self, law: &ContactLaw<'_>, mode: Mode) -> Result<&FaceContacts, InterfaceError> {
        self.check_law(law)?;
        let Averages { mut nodes, normals, points, missed } = self.averages(law, law.friction.is_some())?;
        let tractions = self.tractions(law, &mut nodes, &normals)?;
        let mut contacts = FaceContacts { nodes, mode, missed, ..FaceContacts::default() };
        if mode >= Mode::Gradient {
            // In the memory of the last evaluation: new pages would take as long as their numbers.
            let earlier = std::mem::take(&mut self.contacts).faces;
            self.derive(mode, (&points, &tractions), &mut contacts, earlier)?;
        }
        contacts.pressures = points.pressures.iter().map(|own| own.force).collect();
        contacts.found = points.is_contact;
        self.contacts = contacts;
        Ok(&self.contacts)
    }

    /// Whether the law can be evaluated now.
    fn check_law(&self, law: &ContactLaw<'_>) -> Result<(), InterfaceError> {
        law.validate(self.slaves().len())?;
        if self.cut_at.is_none() { Err(InterfaceError::NotRefreshed) } else { Ok(()) }
    }
}
