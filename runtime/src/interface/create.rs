//! Interfaces from a master surface and slaves, and what they keep of the first configuration: planes of symmetry, domains.

use super::follow::Lost;
use super::nodal::{Nodal, check_planes};
use super::pairings::Pairings;
use super::{ContactElement, ContactInterface, Contacts, InterfaceError, InterfaceOptions};
use crate::Point;
use crate::neighbourhood::NeighbourRule;
use crate::scratch::Pool;
use crate::surface::{Creases, Facet, MasterSurface, OwnSurface, SymmetryPlane, tributary_areas};

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
    pub(super) fn without_domains(
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
    /// * It lies **in front** of a node if the node is above it and it is above the node, or below by at most half of the thickness of the
    ///   body, at the node and at the facet. The thickness is that of the first configuration, and unbounded where the surface has no other
    ///   side.
    /// * It lies **below** the node, not farther aside than its own extent.
    ///
    /// Facets farther away than the distance limit, by default two mean extents of a facet, are none of them. A slave without any has
    /// [`NoContact::NothingOver`](super::NoContact::NothingOver).
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
            contacts: Contacts::new(pairings.layout.clone(), options.check_friction()),
            creases: Creases::default(),
            planes: Vec::new(),
            nodal: None,
            listed: None,
            lost: Lost::default(),
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
    /// Domains of influence are found anew, in the first configuration, nobody is paired then, and rounds of augmentation are forgotten. The
    /// history of friction names images in the planes of before: it ends, unless the planes are the same.
    ///
    /// # Errors
    /// [`InterfaceError::Surface`] for planes that cannot be planes of symmetry; [`InterfaceError::SlaveBehindSymmetry`];
    /// [`InterfaceError::NoSymmetry`] if masters are found by a rule without domains of influence; [`InterfaceError::InWindow`] where the planes are those of a window. Planes and
    /// pairing of before then stay.
    pub fn set_symmetry(&mut self, planes: &[SymmetryPlane]) -> Result<(), InterfaceError> {
        self.check_whole("finding domains of influence")?;
        if let ContactElement::Diffuse { search, .. } = self.options.element
            && search.rule != NeighbourRule::Domains
            && !planes.is_empty()
        {
            return Err(InterfaceError::NoSymmetry);
        }
        let mut first = self.positions.clone();
        if let Some(nodal) = &self.nodal {
            for (place, &node) in self.master.nodes().iter().enumerate() {
                first[node as usize] = nodal.domains.first_position(place as u32);
            }
        }
        let index = self.master.at(&first)?;
        // Facets have no domains, but planes all the same.
        check_planes(&index, planes, self.pairings.layout.slaves(), &first)?;
        self.nodal = Nodal::new(&index, &self.options, planes)?;
        // Anchors name images by number.
        if self.planes != planes {
            self.anchors = None;
        }
        self.planes = planes.to_vec();
        self.augmented = None;
        self.end_pairings();
        Ok(())
    }

    /// Refuses nodes that lie behind the planes, seen from the master.
    ///
    /// # Errors
    /// [`InterfaceError::SlaveBehindSymmetry`].
    pub(crate) fn check_slave_sides(&self, nodes: &[usize]) -> Result<(), InterfaceError> {
        check_planes(&self.master.at(&self.positions)?, &self.planes, nodes, &self.positions)
    }

    /// Until the next refresh no slave is paired.
    pub(super) fn end_pairings(&mut self) {
        self.listed = None;
        self.lost = Lost::default();
        let layout = &self.pairings.layout;
        self.pairings = Pairings::none(layout.slaves().to_vec(), layout.areas().to_vec());
    }

    fn find_domains(&mut self) -> Result<(), InterfaceError> {
        let index = self.master.at(&self.positions)?;
        self.nodal = Nodal::new(&index, &self.options, &self.planes)?;
        Ok(())
    }
}

/// Pairings name nodes and slaves by 32-bit indices.
pub(super) fn check_count(what: &'static str, count: usize) -> Result<(), InterfaceError> {
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
fn areas_of(slaves: &[usize], facets: &[Facet], positions: &[Point]) -> Result<Vec<f64>, InterfaceError> {
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
