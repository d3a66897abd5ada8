//! A whole contact interface: every slave node paired with the master surface, refreshed and evaluated.
//!
//! ```text
//! refresh_pairing   closest facet → nodes reached from it without crossing a sharp edge → neighbour search → pairing
//! evaluate          element by element, in parallel, each into its own slot → Contacts
//! ```
//!
//! * **Pairing data** (masters, support radius, basis, the facet that says which side is outside; the frame, if
//!   frames are held; the facet of a node-to-facet element) are piecewise constant: only
//!   [`refresh_pairing`](ContactInterface::refresh_pairing) changes them, and it reports by how much the gap
//!   jumped. Call it once an increment, or once an iteration.
//! * **Every slave has an [`Outcome`]**: contact, with what the search had to give up for it, or the named
//!   reason why not. [`InterfaceError`]s are for what the caller has to mend.
//! * **Derivatives** are with respect to the global coordinates of slave, master 1, …, master n, with the
//!   pairing held. With a co-moving frame (the default) they are the exact derivatives of the gap.
//! * **Outside** is the side of the closest facet's normal at the positions of the evaluation. A rigid motion of
//!   everything changes nothing.
//! * **Border.** A foot beyond the border of the master surface is no contact, nor is one beyond an edge
//!   sharper than the feature angle, where the fit of one face would be extended past it. So a slave over a
//!   sharp convex edge, seen by neither face, has no contact until it comes to lie over one of them.
//! * **Ends of slits.** Which nodes a slave's facet reaches is a matter of distance alone: those on the far side of a slit
//!   take part if the way around its end is over facets no farther from the slave than they are. Near the end
//!   that is most of the far side, and the search may also take nodes far away to surround the slave where the near
//!   ones are cut off: the fit then is over a support many facets wide, smooth across the slit. A support radius
//!   that large, or a fallback, shows in the pairing; finer facets around the end of the slit make it small.
//! * **Windows.** Where nobody holds the whole master surface, an interface has a [window](crate::surface::window) of it:
//!   [`in_window`](ContactInterface::in_window).
//! * **Threads.** Results and reports are the same, bit for bit, for any number of threads. Work is done in the
//!   current rayon pool.
//! * **Memory.** Results lie in buffers that are reused: after the first evaluation none is allocated per
//!   element, up to 24 masters. [`for_each`](ContactInterface::for_each) holds a few elements at a time instead
//!   of all.
//!
//! ```
//! use diffuse_contact::Mode;
//! use diffuse_contact::interface::{ContactInterface, InterfaceOptions};
//! use diffuse_contact::surface::{Facet, MasterSurface};
//!
//! // A 9 × 9 grid of master nodes in the plane z = 0, outside above, and one slave node 0.25 over it.
//! let mut positions: Vec<[f64; 3]> = (0..81).map(|k| [f64::from(k % 9), f64::from(k / 9), 0.0]).collect();
//! let facets = (0..64).map(|k| k % 8 + 9 * (k / 8)).map(|k| Facet::Quadrilateral([k, k + 1, k + 10, k + 9]));
//! let master = MasterSurface::new(&positions, facets.collect())?;
//! positions.push([4.2, 3.9, 0.25]);
//!
//! let options = InterfaceOptions::default();
//! let mut interface = ContactInterface::new(master, vec![81], &[], &positions, options)?;
//! let report = interface.refresh_pairing(&positions)?;
//! assert_eq!((report.paired, report.gained), (1, 1));
//!
//! // The slave moves; the pairing stays.
//! positions[81][2] = -0.1;
//! interface.update(&positions)?;
//! let contacts = interface.evaluate(Mode::Hessian)?;
//! let contact = contacts.get(0);
//! assert!(contact.outcome.is_contact());
//! assert!((contact.point.gap + 0.1).abs() < 1e-14);
//! assert_eq!(contact.gradient.len(), 3 * (contact.nodes.len() + 1));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod anchors;
mod contacts;
mod cutback;
mod element;
mod error;
mod evaluate;
mod fold;
mod linearise;
mod nodal;
mod options;
mod outcome;
mod pairings;
mod part;
mod refresh;
mod report;
mod scratch;
mod window;
mod within_reach;

pub use anchors::{Anchor, FrictionReport, split_history};
pub(crate) use anchors::{from_numbers, to_numbers};
pub use contacts::{ContactRef, Contacts};
pub use cutback::{Cutback, CutbackHint};
pub use element::PairedElement;
pub use error::InterfaceError;
pub use options::{ContactElement, InterfaceOptions};
pub use outcome::{NoContact, Outcome};
pub use part::{PartDemands, PartFacets, SurfacePart};
pub use report::{FallbackCounts, GapJump, RefreshReport, SlaveGap};

pub(crate) use contacts::Results;
use evaluate::{CHUNK, ElementScratch, Evaluator, Request};
pub(crate) use fold::back;
pub(crate) use linearise::{LinearContacts, SecondForm};
use nodal::{Nodal, symmetry_of};
use pairings::Pairings;
use refresh::{Compares, Refresh, RefreshScratch, SKIN};
pub(crate) use scratch::{Pool, recycled};
use window::Knowledge;
pub(crate) use within_reach::PointsWithinReach;

use std::ops::Range;
use std::sync::Arc;

use crate::neighbourhood::{NeighbourRule, SearchOptions};
use crate::pairing::NearestNodes;
use crate::surface::window::Known;
use crate::surface::{
    Creases, Facet, MasterSurface, OwnSurface, Symmetry, SymmetryPlane, check_position, tributary_areas,
};
use crate::{Basis, Mode, Point};

/// Chunks of slaves that [`ContactInterface::for_each`] holds for each thread.
const CHUNKS_PER_THREAD: usize = 4;

/// What the lists of nodal domains were made from.
#[derive(Debug)]
struct Listed {
    /// Of all nodes.
    positions: Vec<Point>,
    report: RefreshReport,
}

/// A master surface, slave nodes, and their pairing.
#[derive(Debug)]
pub struct ContactInterface {
    master: MasterSurface,
    options: InterfaceOptions,
    /// Of all nodes, by the last update or refresh.
    positions: Vec<Point>,
    creases: Creases,
    planes: Vec<SymmetryPlane>,
    nodal: Option<Nodal>,
    pairings: Pairings,
    /// With nodal domains: what the lists were made from.
    listed: Option<Listed>,
    /// Where each slave stuck, once a state with friction has been accepted.
    anchors: Option<Vec<Option<Anchor>>>,
    /// If there is a window of the surface only.
    known: Option<Known>,
    /// What augmentation made of them since.
    augmented: Option<Vec<Option<Anchor>>>,
    /// What slaves may touch, if the surface is in contact with itself.
    own: Option<OwnSurface>,
    contacts: Contacts,
    elements: Pool<ElementScratch>,
    refreshes: Pool<RefreshScratch>,
}

impl ContactInterface {
    /// An interface without a pairing: until the first [`refresh_pairing`](Self::refresh_pairing) no slave has
    /// contact.
    ///
    /// `positions` are those of all nodes; `slaves`, the corners of `slave_facets` and those of the master's
    /// facets are indices into them. The slave facets are only looked at for tributary areas, and may else be
    /// empty.
    ///
    /// # Errors
    /// [`InterfaceError::InvalidOption`], [`InterfaceError::InvalidSearch`], [`InterfaceError::TooMany`],
    /// [`InterfaceError::SlaveOutOfRange`], [`InterfaceError::RepeatedSlave`],
    /// [`InterfaceError::SlaveOnMaster`], [`InterfaceError::SlaveWithoutArea`], and [`InterfaceError::Surface`]
    /// for positions of nodes and for slave facets.
    pub fn new(
        master: MasterSurface,
        slaves: Vec<usize>,
        slave_facets: &[Facet],
        positions: &[Point],
        options: InterfaceOptions,
    ) -> Result<Self, InterfaceError> {
        options.check()?;
        if master.is_part() {
            return Err(InterfaceError::InWindow { what: "a new interface" });
        }
        let mut interface = Self::without_domains(master, slaves, slave_facets, positions, options)?;
        interface.find_domains()?;
        Ok(interface)
    }

    /// An interface without domains; the options have been checked.
    fn without_domains(
        master: MasterSurface,
        slaves: Vec<usize>,
        slave_facets: &[Facet],
        positions: &[Point],
        options: InterfaceOptions,
    ) -> Result<Self, InterfaceError> {
        check_count("positions", positions.len())?;
        check_count("slaves", slaves.len())?;
        check_slaves(&master, &slaves, positions)?;
        Self::build(master, slaves, slave_facets, positions, options)
    }

    /// A surface in contact with itself, without a pairing: every node of it is a slave, and may touch every facet that faces it, is
    /// far along the skin and lies in front of it. The surface may be the skins of several bodies, which then touch one another and
    /// themselves, without roles. Where that is so, closed skins are best: then the back of every wall is known.
    ///
    /// * A facet **faces** a node if their normals are more than 96° apart, at the positions of a refresh.
    /// * It is **far along the skin** if at least three facets lie between them, and no fit over it has the node.
    /// * It is **not its back**: in the first configuration it does not lie right behind the node, within 1.5 thicknesses of the body.
    /// * It lies **in front** of a node if the node is above it, or below it by at most half of the thickness of the body, that at the
    ///   node or that at the facet. The thickness is that of the first configuration, and unbounded where the surface has no other side.
    ///
    /// Facets farther away than the distance limit, by default two mean extents of a facet, are none of them. A slave without any has
    /// [`NoContact::NothingOver`].
    ///
    /// Both sides of a contact carry slaves. With ε from the one and ε from the other the stiffness is 2ε: give the law half of the
    /// penalty. The energy is then ½ (½ ε Σ A g²) of either side, force and tangent are its exact derivatives, and no side has a role.
    ///
    /// # Errors
    /// As [`new`](Self::new), but for what concerns slaves; [`InterfaceError::InWindow`] for a window of a surface.
    pub fn self_contact(
        surface: MasterSurface,
        positions: &[Point],
        options: InterfaceOptions,
    ) -> Result<Self, InterfaceError> {
        options.check()?;
        if surface.is_part() {
            return Err(InterfaceError::InWindow { what: "a new interface" });
        }
        check_count("positions", positions.len())?;
        let own = OwnSurface::new(&surface.at(positions)?, options.distance_limit);
        let slaves = surface.nodes().iter().map(|&node| node as usize).collect();
        let facets: Vec<Facet> = (0..surface.facet_count()).map(|facet| surface.facet(facet)).collect();
        let mut interface = Self::build(surface, slaves, &facets, positions, options)?;
        interface.find_domains()?;
        interface.own = Some(own);
        Ok(interface)
    }

    /// Everything has been checked.
    fn build(
        master: MasterSurface,
        slaves: Vec<usize>,
        slave_facets: &[Facet],
        positions: &[Point],
        options: InterfaceOptions,
    ) -> Result<Self, InterfaceError> {
        let areas = if options.areas { areas_of(&slaves, slave_facets, positions)? } else { Vec::new() };
        let pairings = Pairings::none(slaves, areas);
        let mut interface = Self {
            contacts: Contacts::new(pairings.layout.clone()),
            creases: Creases::default(),
            planes: Vec::new(),
            nodal: None,
            listed: None,
            anchors: None,
            known: None,
            augmented: None,
            own: None,
            positions: positions.to_vec(),
            master,
            options,
            pairings,
            elements: Pool::default(),
            refreshes: Pool::default(),
        };
        interface.update(positions)?;
        Ok(interface)
    }

    /// Makes these planes of symmetry: the master surface goes on beyond them as its mirror image, so that nodes near a plane have
    /// neighbours on both sides. To be called before the first [`refresh_pairing`](Self::refresh_pairing). Where the master ends in
    /// a plane, that is no border.
    ///
    /// Domains of influence are found anew, at the positions of the last update. Nobody is paired then, and the history of friction ends: both name images
    /// in the planes of before.
    ///
    /// # Errors
    /// [`InterfaceError::Surface`] for planes that cannot be planes of symmetry; [`InterfaceError::NoSymmetry`] if masters are
    /// found by a rule without domains of influence; [`InterfaceError::InWindow`] where the planes are those of a window. Planes and
    /// pairing of before then stay.
    pub fn set_symmetry(&mut self, planes: &[SymmetryPlane]) -> Result<(), InterfaceError> {
        self.check_whole("finding domains of influence")?;
        if let ContactElement::Diffuse { search, .. } = self.options.element
            && search.rule != NeighbourRule::Domains
            && !planes.is_empty()
        {
            return Err(InterfaceError::NoSymmetry);
        }
        let index = self.master.at(&self.positions)?;
        // Facets have no domains, but planes all the same.
        symmetry_of(&index, planes)?;
        self.nodal = Nodal::new(&index, &self.options, planes)?;
        self.planes = planes.to_vec();
        // Anchors name images by number.
        (self.anchors, self.augmented) = (None, None);
        self.end_pairings();
        Ok(())
    }

    /// Until the next refresh no slave is paired.
    fn end_pairings(&mut self) {
        self.listed = None;
        let layout = &self.pairings.layout;
        self.pairings = Pairings::none(layout.slaves().to_vec(), layout.areas().to_vec());
    }

    /// The planes of symmetry.
    #[must_use]
    pub fn symmetry(&self) -> &[SymmetryPlane] {
        &self.planes
    }

    /// First positions of the master surface's nodes, in the order of [`MasterSurface::nodes`]: the configuration in which domains of
    /// influence were found and stay what they are. `None` without domains.
    #[must_use]
    pub fn first_positions(&self) -> Option<Vec<Point>> {
        self.nodal.as_ref().map(|nodal| nodal.domains.positions().collect())
    }

    /// Makes these the first positions of the surface's nodes, in the order of [`MasterSurface::nodes`]. Where an interface is made
    /// in a deformed configuration, as after a restart, domains are those of the first one then, bit for bit.
    ///
    /// # Errors
    /// [`InterfaceError::WrongNumberOfPositions`], [`InterfaceError::Surface`]; [`InterfaceError::InWindow`] where they are those of a
    /// window.
    pub fn set_first_positions(&mut self, positions: &[Point]) -> Result<(), InterfaceError> {
        self.check_whole("finding domains of influence")?;
        let nodes = self.master.nodes();
        let (found, expected) = (positions.len(), nodes.len());
        if found != expected {
            return Err(InterfaceError::WrongNumberOfPositions { found, expected });
        }
        let mut all = vec![[0.0; 3]; self.master.positions_needed()];
        for (&node, &x) in nodes.iter().zip(positions) {
            all[node as usize] = x;
        }
        let index = self.master.at(&all)?;
        if let Some(nodal) = &mut self.nodal {
            nodal.renew(&index);
        }
        if let Some(own) = &mut self.own {
            *own = OwnSurface::new(&index, self.options.distance_limit);
        }
        self.listed = None;
        Ok(())
    }

    fn find_domains(&mut self) -> Result<(), InterfaceError> {
        let index = self.master.at(&self.positions)?;
        self.nodal = Nodal::new(&index, &self.options, &self.planes)?;
        Ok(())
    }

    /// The master surface.
    #[must_use]
    pub const fn master(&self) -> &MasterSurface {
        &self.master
    }

    /// The options.
    #[must_use]
    pub const fn options(&self) -> &InterfaceOptions {
        &self.options
    }

    /// The slave nodes, in the order of all results.
    #[must_use]
    pub fn slaves(&self) -> &[usize] {
        self.pairings.layout.slaves()
    }

    /// The element of the `k`-th slave at the positions of the moment, to be looked at or evaluated by itself.
    ///
    /// # Errors
    /// [`NoContact`] if the slave is not paired or its masters have no average plane.
    ///
    /// # Panics
    /// If there is no such slave.
    pub fn element(&self, k: usize) -> Result<PairedElement, NoContact> {
        let (pairings, evaluator) = (&self.pairings, self.evaluator());
        evaluator.paired_element(&pairings.get(k)?, &mut ElementScratch::default())
    }

    /// Support radius of the `k`-th slave's pairing, length (node to facet: the facet's extent); `None` if it is not paired.
    ///
    /// # Panics
    /// If there is no such slave.
    #[must_use]
    pub fn support_radius(&self, k: usize) -> Option<f64> {
        self.pairings.get(k).ok().map(|paired| paired.record.support_radius)
    }

    /// Takes over the positions at which the next evaluation takes place. The pairing is left as it is.
    ///
    /// # Errors
    /// [`InterfaceError::WrongNumberOfPositions`]; [`InterfaceError::Surface`] if a slave or a node of the
    /// master surface has a coordinate that is not finite. The positions of before then stay.
    pub fn update(&mut self, positions: &[Point]) -> Result<(), InterfaceError> {
        self.check_positions(positions)?;
        self.positions.copy_from_slice(positions);
        Ok(())
    }

    /// Whether an update may take over these positions.
    fn check_positions(&self, positions: &[Point]) -> Result<(), InterfaceError> {
        let (found, expected) = (positions.len(), self.positions.len());
        if found != expected {
            return Err(InterfaceError::WrongNumberOfPositions { found, expected });
        }
        self.master.check_positions(positions)?;
        Ok(self.slaves().iter().try_for_each(|&node| check_position(positions, node))?)
    }

    /// Takes over the positions and pairs every slave anew; with nodal domains lists of nodes stay while nobody has moved by more
    /// than half their skin.
    ///
    /// With nodal domains every node of the slave's sheet is listed that may come within reach, and a refresh changes no gap.
    ///
    /// By the other rules a slave is paired with the masters that the neighbour search finds among the nodes on its side of sharp
    /// edges: those reached from the closest facet over facets that meet in no edge sharper than the feature
    /// angle, that do not turn away from it by 89° or more, and that are no farther from the slave than the
    /// node itself. If they do not carry the quadratic basis the search takes more, then the linear basis; else
    /// there is no candidate.
    ///
    /// # Errors
    /// As [`update`](Self::update). Pairing and positions of before then stay.
    pub fn refresh_pairing(&mut self, positions: &[Point]) -> Result<RefreshReport, InterfaceError> {
        self.check_positions(positions)?;
        if let Some(report) = self.kept_lists(positions) {
            self.positions.copy_from_slice(positions);
            return Ok(report);
        }
        self.pair(positions, false, self.compared(), None)
    }

    /// As [`refresh_pairing`](Self::refresh_pairing), but with nodal domains lists are made anew wherever everybody is: what they are then
    /// follows from these positions alone. A run that has to go on from a saved state as if it had never stopped calls it at the
    /// beginning of its increments.
    ///
    /// # Errors
    /// As [`update`](Self::update). Pairing and positions of before then stay.
    pub fn renew_pairing(&mut self, positions: &[Point]) -> Result<RefreshReport, InterfaceError> {
        self.check_positions(positions)?;
        self.pair(positions, false, self.compared(), None)
    }

    /// As [`update`](Self::update), but with nodal domains the lists follow: if something has moved by more than half their skin they
    /// are made anew, which changes no gap. Returns whether they were: a pattern made for the old ones is no longer theirs. To be
    /// called in every iteration.
    ///
    /// # Errors
    /// As [`update`](Self::update).
    pub fn follow(&mut self, positions: &[Point]) -> Result<bool, InterfaceError> {
        self.check_positions(positions)?;
        let is_current = self.listed.is_none() || self.kept_lists(positions).is_some();
        if is_current {
            self.positions.copy_from_slice(positions);
            return Ok(false);
        }
        self.pair(positions, true, self.compared(), None)?;
        Ok(true)
    }

    const fn compared(&self) -> Compares {
        if self.nodal.is_some() { Compares::GainedAndLost } else { Compares::All }
    }

    /// Pairs every slave at positions that have been checked. `follows`: whether lists follow within an increment.
    fn pair(
        &mut self,
        positions: &[Point],
        follows: bool,
        compares: Compares,
        facets: Option<&[u32]>,
    ) -> Result<RefreshReport, InterfaceError> {
        // Everything that may fail comes first; nothing of `self` changes before.
        let search = match self.options.element {
            ContactElement::Diffuse { search, .. } if self.nodal.is_none() => search,
            _ => SearchOptions::default(),
        };
        let blank = RefreshScratch::new(search)?;
        let index = self.master.at(positions)?;
        let cloud = match self.options.element {
            ContactElement::Diffuse { .. } if self.nodal.is_none() => index.positions().to_vec(),
            _ => Vec::new(),
        };
        let cloud = NearestNodes::new(cloud).map_err(InterfaceError::MasterNodes)?;
        let creases = match &self.nodal {
            Some(nodal) => nodal.creases.clone(),
            None => {
                let symmetry = symmetry_of(&index, &self.planes)?;
                Creases::new(&index, self.options.feature_angle_degrees.to_radians(), &symmetry)
            }
        };
        let evaluator = Evaluator {
            surface: &self.master,
            creases: &creases,
            positions,
            options: &self.options,
            nodal: self.nodal.as_ref(),
            anchors: self.present_anchors(),
            committed: self.anchors.as_deref(),
            own: self.own.as_ref(),
        };
        let refresh = Refresh {
            index: &index,
            cloud: &cloud,
            evaluator,
            old: &self.pairings,
            old_creases: &self.creases,
            compares,
            facets,
            follows,
            knowledge: self.known.as_ref().map(|known| Knowledge::new(known, positions)),
        };
        let (mut pairings, report) = refresh.run(&self.refreshes, &blank);
        if pairings.layout.is_same(&self.pairings.layout) {
            // Maps of entries know the lists by the number of their layout.
            pairings.layout = Arc::clone(&self.pairings.layout);
        }
        let report = RefreshReport { rebuilt: true, ..report };
        self.pairings = pairings;
        self.creases = creases;
        self.positions.copy_from_slice(positions);
        if self.nodal.is_some() {
            self.listed = Some(Listed { positions: positions.to_vec(), report: report.clone() });
        }
        Ok(report)
    }

    /// Makes other points the slaves and pairs them: those that follow the nodes in `positions`, each over its facet. On an error points
    /// and pairing of before stay.
    pub(crate) fn pair_points(
        &mut self,
        positions: Vec<Point>,
        nodes: usize,
        facets: &[u32],
    ) -> Result<RefreshReport, InterfaceError> {
        check_count("positions", positions.len())?;
        self.master.check_positions(&positions)?;
        (nodes..positions.len()).try_for_each(|point| check_position(&positions, point))?;
        let blank = Pairings::none((nodes..positions.len()).collect(), Vec::new());
        let pairings = std::mem::replace(&mut self.pairings, blank);
        let before = std::mem::replace(&mut self.positions, positions.clone());
        let listed = self.listed.take();
        self.pair(&positions, false, Compares::None, Some(facets)).inspect_err(|_| {
            (self.pairings, self.positions, self.listed) = (pairings, before, listed);
        })
    }

    /// Evaluates some consecutive slaves into `results` and hands them over one by one.
    pub(crate) fn evaluate_range(
        &self,
        range: Range<usize>,
        mode: Mode,
        results: &mut Results,
        f: impl FnMut(ContactRef<'_>),
    ) -> Result<(), InterfaceError> {
        let layout = &self.pairings.layout;
        let slots = results.start(layout, range.clone(), mode, self.anchors.is_some())?;
        self.evaluator().fill(&self.pairings, Request::all(mode), slots, &self.elements);
        range.map(|k| results.get(layout, k)).for_each(f);
        Ok(())
    }

    /// The points of the `k`-th slave's fit with nodal domains, and its basis.
    pub(crate) fn fit(&self, k: usize) -> Result<(PointsWithinReach, Basis), NoContact> {
        let ContactElement::Diffuse { weight, .. } = self.options.element else {
            return Err(NoContact::NotPaired);
        };
        let paired = self.pairings.get(k)?;
        let points = self.evaluator().points_within_reach(&paired, weight, &mut ElementScratch::default())?;
        Ok((points, paired.record.basis))
    }

    /// Where the `k`-th slave is.
    pub(crate) fn position_of(&self, k: usize) -> Point {
        self.positions[self.pairings.layout.slave(k)]
    }

    /// The planes of symmetry with their images.
    pub(crate) fn images(&self) -> Symmetry {
        self.nodal.as_ref().map(|nodal| nodal.symmetry.clone()).unwrap_or_default()
    }

    /// Q of each image behind planes of symmetry, x' = Q x + t.
    pub(crate) fn rotations(&self) -> Vec<[[f64; 3]; 3]> {
        self.images().rotations().collect()
    }

    /// Master nodes listed with the `k`-th slave.
    pub(crate) fn listed(&self, k: usize) -> &[u32] {
        self.pairings.layout.masters(k)
    }

    /// The report of a refresh that leaves the lists of nodal domains as they are, as nobody has moved by more than half the skin,
    /// master and slave together.
    fn kept_lists(&self, positions: &[Point]) -> Option<RefreshReport> {
        let listed = self.listed.as_ref()?;
        // Frames that are held are those of the last refresh.
        if !self.pairings.frames.is_empty() {
            return None;
        }
        let square = |node: usize| {
            let [a, b, c] = [0, 1, 2].map(|axis| positions[node][axis] - listed.positions[node][axis]);
            a * a + b * b + c * c
        };
        let masters =
            self.master.nodes().iter().map(|&node| square(node as usize)).fold(0.0, f64::max).sqrt();
        let paired = |k: usize| self.pairings.get(k).ok().map(|paired| paired.record.support_radius);
        let smallest = self.pairings.all().filter_map(paired).fold(f64::INFINITY, f64::min);
        // Where nothing was near enough it comes near by no less than the limit.
        let smallest = self.own.as_ref().map_or(smallest, |own| smallest.min(own.limit()));
        let stays = |k: usize| {
            // A slave without a list may get one.
            let shortest = paired(k).unwrap_or(smallest);
            masters + square(self.pairings.layout.slave(k)).sqrt() <= 0.5 * SKIN * shortest
        };
        self.pairings.all().all(stays).then(|| {
            let paired = listed.report.paired;
            let without = listed.report.without.clone();
            let fallbacks = listed.report.fallbacks;
            RefreshReport { paired, kept: paired, without, fallbacks, ..RefreshReport::default() }
        })
    }

    fn evaluator(&self) -> Evaluator<'_> {
        let Self { master, options, positions, creases, nodal, anchors, own, .. } = self;
        let (nodal, committed, own) = (nodal.as_ref(), anchors.as_deref(), own.as_ref());
        let anchors = self.present_anchors();
        Evaluator { surface: master, creases, positions, options, nodal, anchors, committed, own }
    }

    /// The contact of every slave at the positions of the last [`update`](Self::update) or
    /// [`refresh_pairing`](Self::refresh_pairing), with the derivatives that `mode` asks for.
    ///
    /// # Errors
    /// [`InterfaceError::OutOfMemory`]: a Hessian over 16 masters takes 10.6 kB, see [`for_each`](Self::for_each).
    pub fn evaluate(&mut self, mode: Mode) -> Result<&Contacts, InterfaceError> {
        self.evaluate_as(Request::all(mode))
    }

    /// As [`evaluate`](Self::evaluate), but with derivatives only where `is_loaded` says so of the index of a slave, its gap and its
    /// tributary area; the gradient and the Hessian of others are empty. With the forces of a
    /// [`ContactLaw`](crate::assembly::ContactLaw), `|k, gap, area| law.normal_force(k, gap, area).force > 0.0`, residual and tangent by this
    /// law are those of all contacts, bit for bit: nothing else is read for them.
    ///
    /// All gaps are evaluated first, in [`Mode::Value`], so where most contacts carry force this takes longer. What is
    /// derived is as [`evaluate`](Self::evaluate) gives it, bit for bit; gaps that are not derived differ by
    /// rounding, which decides where a force is zero to rounding, or a foot on the limit of the border.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate).
    pub fn evaluate_where(
        &mut self,
        mode: Mode,
        is_loaded: impl Fn(usize, f64, f64) -> bool + Sync,
    ) -> Result<&Contacts, InterfaceError> {
        let layout = Arc::clone(&self.pairings.layout);
        let is_loaded = |k: usize, gap: f64| is_loaded(k, gap, layout.area(k));
        self.evaluate_as(Request { mode, is_loaded: Some(&is_loaded) })
    }

    fn evaluate_as(&mut self, request: Request<'_>) -> Result<&Contacts, InterfaceError> {
        let Self {
            master,
            options,
            positions,
            creases,
            nodal,
            anchors,
            augmented,
            own,
            pairings,
            contacts,
            elements,
            ..
        } = self;
        let (nodal, committed, own) = (nodal.as_ref(), anchors.as_deref(), own.as_ref());
        let anchors = augmented.as_deref().or(committed);
        let evaluator =
            Evaluator { surface: master, creases, positions, options, nodal, anchors, committed, own };
        let slots = contacts.start(&pairings.layout, request.mode, anchors.is_some())?;
        evaluator.fill(pairings, request, slots, elements);
        Ok(contacts)
    }

    /// What the last [`evaluate`](Self::evaluate) returned; empty before. A refresh or an update leaves it as it is.
    #[must_use]
    pub const fn contacts(&self) -> &Contacts {
        &self.contacts
    }

    /// Hands the contact of every slave to `f`, in the order of the slaves, without holding them all: 256 times
    /// the number of threads are evaluated in parallel, handed over one by one by the calling thread, and
    /// forgotten. They are the same as those of [`evaluate`](Self::evaluate), bit for bit.
    ///
    /// # Errors
    /// [`InterfaceError::OutOfMemory`].
    pub fn for_each<F>(&self, mode: Mode, mut f: F) -> Result<(), InterfaceError>
    where
        F: FnMut(ContactRef<'_>),
    {
        let mut results = Results::default();
        let batch = CHUNKS_PER_THREAD * CHUNK * rayon::current_num_threads();
        let all = self.pairings.all();
        all.clone().step_by(batch).try_for_each(|start| {
            self.evaluate_range(start..all.end.min(start + batch), mode, &mut results, &mut f)
        })
    }
}

/// Pairings name nodes and slaves by 32-bit indices.
fn check_count(what: &'static str, count: usize) -> Result<(), InterfaceError> {
    if u32::try_from(count).is_ok() { Ok(()) } else { Err(InterfaceError::TooMany { what, count }) }
}

/// Slaves exist, are named once and are no nodes of the master surface.
pub(crate) fn check_slaves(
    master: &MasterSurface,
    slaves: &[usize],
    positions: &[Point],
) -> Result<(), InterfaceError> {
    let count = positions.len();
    let mut is_slave = vec![false; count];
    for (index, &node) in slaves.iter().enumerate() {
        match is_slave.get_mut(node) {
            None => return Err(InterfaceError::SlaveOutOfRange { index, node, count }),
            Some(true) => return Err(InterfaceError::RepeatedSlave { node }),
            Some(unnamed) => *unnamed = true,
        }
    }
    let mut masters = master.nodes().iter().map(|&node| node as usize);
    match masters.find(|&node| is_slave.get(node).copied().unwrap_or(false)) {
        Some(node) => Err(InterfaceError::SlaveOnMaster { node }),
        None => Ok(()),
    }
}

/// The tributary areas of the slaves.
pub(crate) fn areas_of(
    slaves: &[usize],
    facets: &[Facet],
    positions: &[Point],
) -> Result<Vec<f64>, InterfaceError> {
    let areas = tributary_areas(positions, facets)?;
    let area = |&node: &usize| match areas[node] {
        area if area > 0.0 => Ok(area),
        _ => Err(InterfaceError::SlaveWithoutArea { node }),
    };
    slaves.iter().map(area).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_pointer_width = "64")]
    fn more_than_indices_can_name_is_too_many() {
        assert_eq!(check_count("slaves", u32::MAX as usize), Ok(()));
        let count = u32::MAX as usize + 1;
        assert_eq!(check_count("slaves", count), Err(InterfaceError::TooMany { what: "slaves", count }));
    }
}
