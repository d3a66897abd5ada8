//! Interfaces of a window: the slaves of a rank, where nobody holds the whole surface. See [`surface::window`](crate::surface::window).

use super::nodal::Nodal;
use super::{ContactElement, ContactInterface, InterfaceError, InterfaceOptions, NoContact};
use crate::Point;
use crate::neighbourhood::NeighbourRule;
use crate::surface::window::{Box3, Extents, Known, Setup, Sheet, Window, WindowError, check_boxes, widened};
use crate::surface::{Closest, Facet, Symmetry, SymmetryPlane};

impl Setup {
    /// What domains are found with by these options, if they ask for any.
    pub(crate) fn new(
        options: &InterfaceOptions,
        planes: &[SymmetryPlane],
        extents: Extents,
    ) -> Result<Self, WindowError> {
        let ContactElement::Diffuse { weight, search, .. } = options.element else {
            return Err(WindowError::NeedsDomains);
        };
        if search.rule != NeighbourRule::Domains {
            return Err(WindowError::NeedsDomains);
        }
        let (basis, feature_angle_degrees) = (search.basis, options.feature_angle_degrees);
        Ok(Self { weight, basis, feature_angle_degrees, planes: planes.to_vec(), extents })
    }
}

impl Window {
    /// Whether the options of an interface are those that the domains were found with.
    fn check_options(&self, options: &InterfaceOptions) -> Result<(), InterfaceError> {
        let own = Setup::new(options, &self.setup.planes, self.setup.extents)?;
        let differs = |what| Err(InterfaceError::OtherThanWindow { what });
        if own.weight != self.setup.weight {
            return differs("weight");
        }
        if own.basis != self.setup.basis {
            return differs("basis");
        }
        if own.feature_angle_degrees != self.setup.feature_angle_degrees {
            return differs("feature angle");
        }
        Ok(())
    }
}

impl ContactInterface {
    /// What slaves in these boxes can need of the master surface at the positions of the last update: see
    /// [`surface::window`](crate::surface::window). The window holds while no node of the master has moved by more than `skin`, length.
    /// Numbers of nodes and facets are those of this interface.
    ///
    /// # Errors
    /// [`InterfaceError::Window`] for boxes that are none, and without domains of influence; [`InterfaceError::InWindow`] for an
    /// interface that has a window only; [`InterfaceError::SelfContact`] for a surface in contact with itself: what is near a node along
    /// the skin, and what is its back, is not in a window.
    pub fn window(&self, boxes: &[Box3], skin: f64) -> Result<Window, InterfaceError> {
        self.check_whole("a window of it")?;
        if self.own.is_some() {
            return Err(InterfaceError::SelfContact { what: "a window of it" });
        }
        check_boxes(boxes, skin)?;
        let Some(nodal) = &self.nodal else { return Err(WindowError::NeedsDomains.into()) };
        let setup = Setup::new(&self.options, &self.planes, nodal.extents)?;
        let index = self.master.at(&self.positions)?;
        let (mut core, mut found) = (Vec::new(), Vec::new());
        for own in boxes {
            let [low, high] = widened(*own, skin);
            index.facets_near(low, high, &mut found);
            core.append(&mut found);
        }
        let sheet = Sheet {
            surface: &self.master,
            domains: &nodal.domains,
            creases: &nodal.creases,
            setup: &setup,
            node_number: &|place| u64::from(self.master.nodes()[place as usize]),
            facet_number: &|facet| u64::from(facet),
            position: &|place| self.positions[self.master.nodes()[place as usize] as usize],
        };
        Ok(sheet.window(core, boxes, skin))
    }

    /// An interface of slaves that know a window of the master surface only. As [`new`](Self::new), but the first positions are those of
    /// the window's [nodes](Window::nodes), in their order; slaves come after them. How far the core has moved since the window was made is
    /// known from the window. Planes of symmetry and first positions
    /// are those of the window. Options of domains, which are weight, basis and feature angle, have to be those that it was made with.
    ///
    /// Results are those of an interface of the whole surface, bit for bit, or [`NoContact::BeyondWindow`]. A slave beyond the limit of
    /// the distance from all facets of the window has [`NoContact::TooFar`], with an infinite distance where the closest facet is not in
    /// the window. Areas are the same if `slave_facets` are all facets at the slaves, in the order of the whole, and the positions of their
    /// nodes those of the first configuration: what this call takes for the areas is where they are here, also in a later increment.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`InterfaceError::Window`] for a window with something missing; [`InterfaceError::OtherThanWindow`] for
    /// other options; [`InterfaceError::FewerThanWindow`] for fewer positions than nodes of the window.
    pub fn in_window(
        window: &Window,
        slaves: Vec<usize>,
        slave_facets: &[Facet],
        positions: &[Point],
        options: InterfaceOptions,
    ) -> Result<Self, InterfaceError> {
        options.check()?;
        window.check_options(&options)?;
        let (found, expected) = (positions.len(), window.nodes().len());
        if found < expected {
            return Err(InterfaceError::FewerThanWindow { found, expected });
        }
        let (master, domains, creases) = window.surface()?;
        let setup = &window.setup;
        let symmetry = Symmetry::of_surface(&setup.planes, &setup.extents)?;
        domains
            .check_images(symmetry.count())
            .map_err(|place| WindowError::Invalid { what: "image", place })?;
        let nodal = Nodal { domains, symmetry, creases, extents: setup.extents };
        let mut interface = Self::without_domains(master, slaves, slave_facets, positions, options)?;
        interface.planes = setup.planes.clone();
        interface.creases = nodal.creases.clone();
        interface.nodal = Some(nodal);
        interface.known = Some(window.known(positions));
        Ok(interface)
    }

    /// Whether there is a window of the master surface only.
    pub const fn is_in_window(&self) -> bool {
        self.known.is_some()
    }

    pub(super) fn check_whole(&self, what: &'static str) -> Result<(), InterfaceError> {
        if self.known.is_some() { Err(InterfaceError::InWindow { what }) } else { Ok(()) }
    }
}

/// What a refresh knows of the surface, where it has a window.
#[derive(Clone, Copy)]
pub struct Knowledge<'a> {
    known: &'a Known,
    /// Whether nothing has moved by more than the skin.
    is_valid: bool,
}

impl<'a> Knowledge<'a> {
    pub fn new(known: &'a Known, positions: &[Point]) -> Self {
        Self { known, is_valid: known.holds_at(positions) }
    }

    /// The radius of the largest ball around a point in which every facet is known; negative outside of the window.
    pub fn radius(&self, point: Point) -> f64 {
        self.known.radius(self.around(point))
    }

    fn around(&self, point: Point) -> f64 {
        if self.is_valid { self.known.around(point) } else { f64::NEG_INFINITY }
    }

    /// The closest facet of the window, if it is that of the whole surface and within the limit of the distance. `closest` and `ties` are
    /// those of the window.
    pub fn check(
        &self,
        slave: Point,
        limit: Option<f64>,
        closest: Option<Closest>,
        ties: &[Closest],
    ) -> Result<Closest, NoContact> {
        let distance = closest.map_or(f64::INFINITY, |closest| closest.distance);
        let known = self.around(slave);
        let needed = self.known.needed(distance);
        let within_limit = limit.map_or(needed, |limit| needed.min(self.known.needed(limit)));
        if !(within_limit <= known) {
            return Err(NoContact::BeyondWindow { needed: within_limit, known });
        }
        if let Some(limit) = limit
            && distance > limit
        {
            let distance = if needed <= known { distance } else { f64::INFINITY };
            return Err(NoContact::TooFar { distance, limit });
        }
        match closest {
            Some(closest) if ties.iter().all(|tie| self.known.is_core(tie.facet)) => Ok(closest),
            _ => Err(NoContact::BeyondWindow { needed, known }),
        }
    }
}
