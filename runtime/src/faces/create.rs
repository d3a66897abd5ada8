//! Face interfaces from two surfaces, or from one in contact with itself; planes of symmetry and faces of second order.

use super::quadratic::{self, Carriers};
use super::skin::Skin;
use super::slave_nodes::SlaveNodes;
use super::{FaceContacts, FaceCut, FaceInterface, FaceOptions, FaceReport, QuadraticFace};
use crate::Point;
use crate::interface::{ContactElement, ContactInterface, InterfaceError, InterfaceOptions, check_slaves};
use crate::neighbourhood::NeighbourRule;
use crate::surface::{Facet, MasterSurface, OwnSurface, SymmetryPlane, shape_of, sort};

impl FaceInterface {
    /// An interface without points: until the first [`refresh`](Self::refresh) or [`update`](Self::update) there is no contact.
    ///
    /// `positions` are those of all nodes in the first configuration; the corners of `faces` and those of the master's facets are indices
    /// into them. Faces run counter-clockwise seen from outside; there may be none.
    ///
    /// # Errors
    /// As [`ContactInterface::new`]; [`InterfaceError::FacesNeedDomains`]; [`InterfaceError::Surface`] also for faces whose own smooth
    /// surface cannot be found.
    pub fn new(
        master: MasterSurface,
        faces: &[Facet],
        positions: &[Point],
        options: FaceOptions,
    ) -> Result<Self, InterfaceError> {
        check_slaves(&master, &nodes_of(faces), positions)?;
        Self::build(master, faces, positions, options)
    }

    /// A surface in contact with itself: every face of it is a slave, and may touch every other one that faces it, is far along the skin,
    /// is not its back and lies in front of it, by the rules of [`ContactInterface::self_contact`]. Each corner of a face has to be apart
    /// from the facet, and points lie below it by no more than the least depth of all corners. The surface may be the skins of several
    /// bodies.
    ///
    /// Each of two faces in touch is integrated over the other one. Give the law half of the penalty: so the pressures of both are one.
    /// No side has a role, and forces and moments are in balance.
    ///
    /// # Errors
    /// As [`new`](Self::new), but for what concerns slaves; [`InterfaceError::InWindow`] for a window of a surface.
    pub fn self_contact(
        surface: MasterSurface,
        positions: &[Point],
        options: FaceOptions,
    ) -> Result<Self, InterfaceError> {
        options.interface.check()?;
        if surface.is_part() {
            return Err(InterfaceError::InWindow { what: "a new interface" });
        }
        let own = OwnSurface::new(&surface.at(positions)?, options.interface.distance_limit);
        let faces: Vec<Facet> = (0..surface.facet_count()).map(|facet| surface.facet(facet)).collect();
        Ok(Self { own: Some(own), ..Self::build(surface, &faces, positions, options)? })
    }

    /// Slaves have been checked.
    fn build(
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
        // Without faces, as on a rank of a parallel code, there is no surface.
        let (mut skin, mut slaves) = (Skin::default(), SlaveNodes::default());
        if !faces.is_empty() {
            let surface = MasterSurface::new(positions, faces.to_vec())?;
            let numbers: Vec<u32> = (0..faces.len() as u32).collect();
            slaves = SlaveNodes::new(&surface, &numbers, positions, own.feature_angle_degrees)?;
            skin = Skin::new(surface, positions, &own, &[])?;
        }
        let interface = ContactInterface::new(master, Vec::new(), &[], positions, own)?;
        Ok(Self::of((interface, skin, slaves), faces.to_vec(), positions.to_vec(), options))
    }

    /// Of these parts, by positions in the first configuration.
    pub(super) fn of(
        (interface, skin, slaves): (ContactInterface, Skin, SlaveNodes),
        faces: Vec<Facet>,
        first: Vec<Point>,
        options: FaceOptions,
    ) -> Self {
        let master = interface.master();
        let facets = (0..master.facet_count()).map(|facet| master.facet(facet));
        let extents = facets.chain(faces.iter().copied()).map(|facet| shape_of(&facet, &first).extent());
        let smallest = extents.fold(f64::INFINITY, f64::min);
        Self {
            carriers: Carriers::new(&faces, master, &[]),
            interface,
            own: None,
            window: None,
            options,
            skin,
            positions: first.clone(),
            first,
            cliques: vec![Vec::new(); slaves.nodes.len()],
            slaves,
            points: Vec::new(),
            limits: Vec::new(),
            cut_at: None,
            unplaced: Vec::new(),
            report: FaceReport::default(),
            smallest,
            cuts: vec![FaceCut::default(); faces.len()],
            faces,
            tracks: None,
            augmented: None,
            contacts: FaceContacts::default(),
        }
    }

    /// Makes faces of second order carry the forces on the facets that they are made of, on both sides: those whose corners are all nodes
    /// of one face. Only so are forces in equilibrium with a uniform stress inside. The history of friction ends, and there is no contact
    /// until the next [`refresh`](Self::refresh) or [`update`](Self::update).
    ///
    /// # Errors
    /// [`InterfaceError::Surface`] if a node is not there, [`InterfaceError::InWindow`] for a window of the surfaces, which takes faces
    /// [by number](Self::set_quadratic_faces_by_number): the interface is then as it was.
    pub fn set_quadratic_faces(&mut self, faces: &[QuadraticFace]) -> Result<(), InterfaceError> {
        self.check_whole("forces on faces of second order")?;
        quadratic::check(faces, &self.first)?;
        self.carriers = Carriers::new(&self.faces, self.master(), faces);
        self.tracks = None;
        self.forget();
        Ok(())
    }

    /// Makes these planes of symmetry of both surfaces, as [`ContactInterface::set_symmetry`], in the first configuration. The history of
    /// friction ends, unless the planes are the same. There is no contact until the next [`refresh`](Self::refresh) or
    /// [`update`](Self::update).
    ///
    /// # Errors
    /// As there. The interface is then as it was.
    pub fn set_symmetry(&mut self, planes: &[SymmetryPlane]) -> Result<(), InterfaceError> {
        self.check_whole("a plane of symmetry")?;
        let own = InterfaceOptions { areas: false, ..self.options.interface };
        let skin = if self.faces.is_empty() {
            Skin::default()
        } else {
            Skin::new(MasterSurface::new(&self.first, self.faces.clone())?, &self.first, &own, planes)?
        };
        let mut interface = ContactInterface::new(self.master().clone(), Vec::new(), &[], &self.first, own)?;
        interface.set_symmetry(planes)?;
        interface.check_slave_sides(self.slaves())?;
        if self.interface.symmetry() != planes {
            self.tracks = None;
        }
        (self.skin, self.interface) = (skin, interface);
        self.forget();
        Ok(())
    }

    /// No points, no contact.
    pub(super) fn forget(&mut self) {
        self.cut_at = None;
        self.augmented = None;
        self.points.clear();
        self.limits.clear();
        self.cuts.fill(FaceCut::default());
        self.cliques.fill(Vec::new());
        (self.report, self.contacts) = (FaceReport::default(), FaceContacts::default());
    }
}

/// The corners of faces, ascending, each once.
fn nodes_of(faces: &[Facet]) -> Vec<usize> {
    let mut nodes: Vec<usize> = faces.iter().flat_map(|face| face.corners()).copied().collect();
    sort(&mut nodes);
    nodes
}
