//! A whole contact interface: every slave node paired with the master surface, refreshed and evaluated.
//!
//! ```text
//! refresh_pairing   closest facet → the nodes whose domains reach it → those near the slave's place → pairing
//!                   (other rules: nodes reached without crossing a sharp edge → neighbour search → pairing)
//! evaluate          element by element, in parallel, each into its own slot → Contacts
//! ```
//!
//! * **Pairing data** (masters, support radius, basis, the facet that says which side is outside; the frame, if
//!   frames are held; the facet of a node-to-facet element) are piecewise constant.
//!   Call [`refresh_pairing`](ContactInterface::refresh_pairing) once an increment and
//!   [`follow`](ContactInterface::follow) in its iterations: they change them where positions ask for it. By rules other than nodal domains the gap may jump, by as much as the report says.
//! * **Every slave has an [`Outcome`]**: contact, with what the search had to give up for it, or the named
//!   reason why not. [`InterfaceError`]s are for what the caller has to mend.
//! * **Derivatives** are with respect to the global coordinates of slave, master 1, …, master n, with the
//!   pairing held. With a co-moving frame (the default) they are the exact derivatives of the gap.
//! * **Outside** is the side of the closest facet's normal at the positions of the evaluation. A rigid motion of
//!   everything changes nothing.
//! * **Border.** A foot beyond the border of the master surface is no contact, nor is one beyond an edge
//!   sharper than the feature angle, where the fit of one face would be extended past it. So a slave over a
//!   sharp convex edge, seen by neither face, has no contact until it comes to lie over one of them.
//! * **Ends of slits.** By rules other than nodal domains, which nodes a slave's facet reaches is a matter of distance alone: those on the
//!   far side of a slit take part if the way around its end is over facets no farther from the slave than they are. Near the end that is
//!   most of the far side, and the search may also take nodes far away to surround the slave where the near ones are cut off: the fit then
//!   is over a support many facets wide, smooth across the slit. A support radius that large, or a fallback, shows in the pairing; finer
//!   facets around the end of the slit make it small.
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

mod accept;
mod anchors;
mod contacts;
mod create;
mod cutback;
mod element;
mod error;
mod evaluate;
mod evaluator;
mod fill;
mod fold;
mod follow;
mod foot;
mod gather;
mod linearise;
mod listing;
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

use std::sync::Arc;

pub use accept::FrictionReport;
pub use anchors::{Anchor, split_history};
pub(crate) use anchors::{from_numbers, to_numbers};
pub use contacts::{ContactRef, Contacts};
pub use cutback::{Cutback, CutbackHint};
pub use element::PairedElement;
pub use error::InterfaceError;
pub use foot::{ContactFeet, FootRef};
pub use options::{ContactElement, InterfaceOptions};
pub use outcome::{NoContact, Outcome};
pub use part::{PartDemands, PartFacets, SurfacePart};
pub use report::{FallbackCounts, GapJump, RefreshReport, SlaveGap};

pub(crate) use contacts::{Results, reserve};
pub(crate) use create::check_slaves;
pub(crate) use fold::{FitPoint, back};
pub(crate) use linearise::{LinearContacts, Second, SecondForm};
use nodal::Nodal;
use pairings::Pairings;
use refresh::RefreshScratch;
use scratch::ElementScratch;
pub(crate) use within_reach::PointsWithinReach;

use crate::affine::Carrier;
use crate::scratch::Pool;
use crate::surface::window::Known;
use crate::surface::{
    Creases, Image, MasterSurface, NodalDomains, OwnSurface, Symmetry, SymmetryPlane, check_position,
};
use crate::{Basis, Point};

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
    /// What following has lost since the last refresh.
    lost: follow::Lost,
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
    /// The planes of symmetry.
    pub fn symmetry(&self) -> &[SymmetryPlane] {
        &self.planes
    }

    /// The master surface.
    pub const fn master(&self) -> &MasterSurface {
        &self.master
    }

    /// The options.
    pub const fn options(&self) -> &InterfaceOptions {
        &self.options
    }

    /// The slave nodes, in the order of all results.
    pub fn slaves(&self) -> &[usize] {
        self.pairings.layout.slaves()
    }

    /// Support radius of the `k`-th slave's pairing, length (node to facet: the facet's extent); `None` if it is not paired.
    ///
    /// # Panics
    /// If there is no such slave.
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
        InterfaceError::check_count(positions, self.positions.len())?;
        self.master.check_positions(positions)?;
        Ok(self.slaves().iter().try_for_each(|&node| check_position(positions, node))?)
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

    /// Domains of influence, if the element has any.
    pub(crate) fn domains(&self) -> Option<&NodalDomains> {
        self.nodal.as_ref().map(|nodal| &nodal.domains)
    }

    /// The image that a carrier is, if it is one.
    pub(crate) fn image_of(&self, carrier: Carrier) -> Option<&Image> {
        let (nodal, number) = (self.nodal.as_ref()?, carrier.image?);
        Some(nodal.symmetry.image(number))
    }

    /// The planes of symmetry with their images.
    pub(crate) fn images(&self) -> Symmetry {
        self.nodal.as_ref().map(|nodal| nodal.symmetry.clone()).unwrap_or_default()
    }

    /// Master nodes listed with the `k`-th slave.
    pub(crate) fn listed(&self, k: usize) -> &[u32] {
        self.pairings.layout.masters(k)
    }

    /// The first slave whose list is another than at the last evaluation.
    pub(crate) fn listed_anew(&self) -> Option<usize> {
        let (now, then) = (&self.pairings.layout, &self.contacts.layout);
        let is_other = |&k: &usize| k >= then.len() || now.masters(k) != then.masters(k);
        (!Arc::ptr_eq(now, then)).then(|| self.pairings.all().find(is_other)).flatten()
    }

    /// What the last [`evaluate`](Self::evaluate) returned; empty before. A refresh or an update leaves it as it is.
    pub const fn contacts(&self) -> &Contacts {
        &self.contacts
    }
}
