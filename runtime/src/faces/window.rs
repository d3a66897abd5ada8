//! Faces of a rank, where nobody holds the whole of either surface. See [`surface::window`](crate::surface::window).

use super::quadratic::{self, BEYOND, Carriers, Carrying};
use super::skin::Skin;
use super::{FaceInterface, FaceOptions, QuadraticFace};
use crate::Point;
use crate::interface::{ContactInterface, InterfaceError, InterfaceOptions, NoContact};
use crate::surface::window::{Known, Window};
use crate::surface::{Facet, Shape, shape_of};

#[derive(Clone, Copy, Debug)]
pub(super) enum Side {
    Master,
    Slave,
}

/// What faces know of both surfaces.
#[derive(Debug)]
pub(super) struct FaceWindow {
    master: Known,
    slave: Known,
    /// Of each face, what is not known of its face of second order.
    of_carriers: Vec<Option<NoContact>>,
    /// Of each of the slave's nodes, whether faces at it may not be there.
    of_nodes: Vec<Option<NoContact>>,
    /// Of each face at the last cut, what it does not know.
    beyond: Vec<Option<NoContact>>,
}

impl FaceWindow {
    /// Whether nothing of the master has moved by more than its skin.
    pub fn holds_at(&self, positions: &[Point]) -> bool {
        self.master.holds_at(positions)
    }

    /// Finds out at these positions which faces know all facets near enough.
    pub fn look(&self, faces: &[Facet], positions: &[Point], limits: &[f64]) -> Vec<Option<NoContact>> {
        let holds = self.holds_at(positions);
        let of_face = |(k, face): (usize, &Facet)| {
            let (low, high) = shape_of(face, positions).bounds();
            let around = self.master.around_box([low.into(), high.into()]);
            let known = if holds { around } else { f64::NEG_INFINITY };
            let needed = self.master.needed(limits[k]);
            let is_far = !(needed <= known);
            self.of_carriers[k].or_else(|| is_far.then_some(NoContact::BeyondWindow { needed, known }))
        };
        faces.iter().enumerate().map(of_face).collect()
    }

    /// That a facet of the master belongs to a face of second order with nodes farther away.
    pub fn beside(&self, facet: &Shape) -> NoContact {
        beside(&self.master, facet)
    }

    fn number_of(&self, node: u32) -> Option<u64> {
        let of_slave = || self.slave.number_of(node - self.master.node_count());
        self.master.number_of(node).or_else(of_slave)
    }

    /// Both surfaces may be numbered from nought.
    fn node_of(&self, side: Side, number: u64) -> Option<u32> {
        match side {
            Side::Master => self.master.node_of(number),
            Side::Slave => self.slave.node_of(number).map(|node| self.master.node_count() + node),
        }
    }

    /// Whether faces at the k-th slave may not be there.
    pub fn is_beside(&self, k: usize) -> bool {
        self.of_nodes.get(k).is_some_and(Option::is_some)
    }

    /// Takes over what [`look`](Self::look) found.
    pub fn take(&mut self, beyond: Vec<Option<NoContact>>) {
        self.beyond = beyond;
    }

    /// Why the result of the k-th node, with these faces around it, is not known.
    pub fn of_node(&self, k: usize, around: &[u32]) -> Option<NoContact> {
        let of_face = |&face: &u32| self.beyond.get(face as usize).copied().flatten();
        self.of_nodes[k].or_else(|| around.iter().find_map(of_face))
    }
}

impl FaceInterface {
    /// An interface of slaves that know windows of both surfaces only. Nodes are those of the [master's window](Window::nodes) in their
    /// order, then those of the slave's. `positions` are those when the master's window was made. The faces are the core of the slave's
    /// window, which is made once, in the first positions: its boxes are to hold the nodes whose results are asked for, with all faces at
    /// them.
    /// The master's boxes are to hold these faces and what is within the limit of the distance, at the positions until it is made anew.
    ///
    /// Gaps, pressures and areas after a [`refresh`](Self::refresh) are those of an interface of the whole surfaces, bit for bit, or the
    /// node has the outcome [`NoContact::BeyondWindow`] and no pressure. What other nodes add to a row is not known there. Friction goes on
    /// with the [history](Self::history) of its nodes, whose anchors have to be in the master's window, too.
    ///
    /// # Errors
    /// As [`new`](Self::new) and [`ContactInterface::in_window`]; [`InterfaceError::InvalidOption`] without a limit of the distance;
    /// [`InterfaceError::OtherThanWindow`] where the two windows have other planes of symmetry;
    /// [`InterfaceError::OtherThanWindows`].
    pub fn in_window(
        master: &Window,
        slave: &Window,
        positions: &[Point],
        options: FaceOptions,
    ) -> Result<Self, InterfaceError> {
        let own = InterfaceOptions { areas: false, ..options.interface };
        if own.distance_limit.is_none() {
            let range = "finite, as faces in a window need it";
            return Err(InterfaceError::InvalidOption {
                name: "distance_limit",
                range,
                value: f64::INFINITY,
            });
        }
        if master.setup.planes != slave.setup.planes {
            return Err(InterfaceError::OtherThanWindow { what: "symmetry of the slave" });
        }
        let offset = master.nodes().len();
        let (found, of_slave) = (positions.len(), slave.nodes().len());
        if found != offset + of_slave {
            return Err(InterfaceError::OtherThanWindows { found, master: offset, slave: of_slave });
        }
        let interface = ContactInterface::in_window(master, Vec::new(), &[], positions, own)?;
        let (skin, slaves) = Skin::in_window(slave, offset, &own)?;
        let faces: Vec<Facet> = slave.core_facets().map(|(_, face)| moved(&face, offset)).collect();
        let first: Vec<Point> = master.first_positions().chain(slave.first_positions()).collect();
        let mut made = Self::of((interface, skin, slaves), faces, first, options);
        made.positions.copy_from_slice(positions);
        let known = slave.known(&made.first[offset..]);
        let of_node = |&node: &usize| {
            let (needed, around) = (known.needed(0.0), known.around(made.first[node]));
            let is_beside = !(needed <= around);
            is_beside.then_some(NoContact::BeyondWindow { needed, known: around })
        };
        let of_nodes = made.slaves().iter().map(of_node).collect();
        let master = master.known(positions);
        let of_carriers = vec![None; made.faces.len()];
        made.window = Some(FaceWindow { master, slave: known, of_carriers, of_nodes, beyond: Vec::new() });
        Ok(made)
    }

    /// As [`set_quadratic_faces`](Self::set_quadratic_faces), for windows too: faces of the master and of the slave, whose nodes are numbers
    /// in the whole surfaces. Hand over all faces that have a node in the window; more do no harm. Where forces would act on a node that
    /// the window does not have, the outcome is [`NoContact::BeyondWindow`]. In an interface of the whole surfaces numbers are indices of
    /// positions, and sides make no difference.
    ///
    /// # Errors
    /// [`InterfaceError::Surface`] for a node twice in a face; of the whole surfaces, as there. The interface is then as it was.
    pub fn set_quadratic_faces_by_number(
        &mut self,
        master: &[QuadraticFace],
        slave: &[QuadraticFace],
    ) -> Result<(), InterfaceError> {
        let Some(window) = &mut self.window else {
            return self.set_quadratic_faces(&[master, slave].concat());
        };
        let mut known = Vec::with_capacity(master.len() + slave.len());
        for (side, faces) in [(Side::Master, master), (Side::Slave, slave)] {
            quadratic::check_distinct(faces)?;
            let node =
                |number: usize| window.node_of(side, number as u64).map_or(BEYOND, |node| node as usize);
            known.extend(faces.iter().map(|face| face.renumbered(node)));
        }
        self.carriers = Carriers::new(&self.faces, self.interface.master(), &known);
        let unknown = |(face, carrying): (&Facet, &Carrying)| {
            let is_beyond = matches!(carrying, Carrying::Beyond(_));
            is_beyond.then(|| beside(&window.slave, &shape_of(face, &self.first)))
        };
        window.of_carriers = self.faces.iter().zip(&self.carriers.faces).map(unknown).collect();
        self.tracks = None;
        self.forget();
        Ok(())
    }

    /// Whether there are windows of the surfaces only.
    pub const fn is_in_window(&self) -> bool {
        self.window.is_some()
    }

    /// The number of a node in a history, which is its number in the whole surfaces.
    pub(super) fn number_of(&self, node: u32) -> f64 {
        match &self.window {
            Some(window) => window.number_of(node).map_or(f64::NAN, |number| number as f64),
            None => f64::from(node),
        }
    }

    /// The node of the slave, or of the master, with this number in a history.
    pub(super) fn node_of(&self, side: Side, number: u64) -> Option<u32> {
        match &self.window {
            Some(window) => window.node_of(side, number),
            None => u32::try_from(number).ok(),
        }
    }

    pub(super) fn check_whole(&self, what: &'static str) -> Result<(), InterfaceError> {
        if self.window.is_some() { Err(InterfaceError::InWindow { what }) } else { Ok(()) }
    }
}

/// What is missing beside a facet whose face has nodes beyond the window: boxes that reach farther by the facet's extent.
fn beside(side: &Known, facet: &Shape) -> NoContact {
    let (low, high) = facet.bounds();
    let known = side.around_box([low.into(), high.into()]);
    let wide = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    NoContact::BeyondWindow { needed: known + wide, known }
}

/// A facet with other numbers of nodes.
fn moved(facet: &Facet, offset: usize) -> Facet {
    match *facet {
        Facet::Triangle(corners) => Facet::Triangle(corners.map(|node| node + offset)),
        Facet::Quadrilateral(corners) => Facet::Quadrilateral(corners.map(|node| node + offset)),
    }
}
