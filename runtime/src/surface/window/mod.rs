//! Windows of a surface: what some slaves can need of it, where nobody holds the whole.
//!
//! A code that is distributed over ranks gives each rank a window for its slaves. There is no communication in here: windows are made
//! of plain numbers, and the host carries these.
//!
//! ```text
//! first positions   each rank: its facets and those around them → SurfacePart → Demands of the fits at its facets
//!                   host: the demands of all ranks with the same nodes → SurfacePart::settle       once, in two rounds
//! now and then      host: all ranks tell boxes around their slaves (boxes_around)
//!                   the owners of facets in a box: SurfacePart::window(boxes, skin) → numbers → the rank of the slaves
//!                   there: Window::joined of what comes → ContactInterface::in_window
//! each iteration    host: positions of the window's nodes; refresh, follow, evaluate as ever
//! ```
//!
//! Who has the whole surface in one place makes the same windows with
//! [`ContactInterface::window`](crate::interface::ContactInterface::window).
//!
//! # What a result depends on, and why a window gives the same bits
//!
//! * **Closest facet, ties, limit of the distance, the way beyond a border at a refresh**: all facets as near to the slave as the
//!   closest one, at the positions of the moment. They have to be in the window: a slave knows of everything within a ball around it if
//!   that lies in one of the window's boxes. Facets that meet a box, with the skin around it, are the *core* of the window.
//! * **Listed nodes**: the domains that reach the closest facet in the first configuration. They are found once, by the owner of the
//!   facet, and travel with it: so do the auxiliary points between them, domains, the basis that fits carry there, and where sheets end. None of them is
//!   found again in a window.
//! * **Border of the patch**: the facets at listed nodes. All of them are in the window, with all their corners, around its core.
//! * **Order**: ties go to the lower number, sums run through nodes in ascending order. A window keeps the order of the numbers of the
//!   whole surface.
//! * **Whole surface**: images in planes of symmetry, their numbers and tolerances follow from the [`Extents`] of the whole, which
//!   travel with the window.
//!
//! So a slave's pairing, gap, N and M are those of the whole surface, bit for bit, or it has the outcome
//! [`BeyondWindow`](crate::interface::NoContact::BeyondWindow). That says that a ball around the slave as large as the distance of the
//! closest facet known (the limit of the distance, where that is smaller) leaves the boxes, or that the window is older than its skin: its
//! core has moved by more than that from where it was when the window was made, which travels with it.
//! There is no other number.
//!
//! The width that follows: boxes reach beyond the slaves by the limit of the distance, or by the largest distance of a slave from the
//! surface, and by as much as slaves are to move until windows are made anew. Around the core there are as many facets as domains of
//! influence reach, 2 to 4 on a regular mesh.
//!
//! Domains themselves depend on more, once: the fits at the centres of a facet take the nodes of its sheet within 3.5 of its longest edges,
//! and 1.5 times as far until they carry the basis; its list takes a walk as far as the longest domain met reaches. A
//! [`SurfacePart`](crate::interface::SurfacePart) says for which of its facets it was not wide enough.
//!
//! # Faces
//!
//! A [`FaceInterface`](crate::faces::FaceInterface::in_window) has two windows. That of the master is as above, with its boxes around whole
//! faces. That of the slave is made once, in the first positions: faces are as curved as fits through their own nodes say.
//!
//! # Borders
//!
//! An edge that only one facet of the window has is a border if the whole surface ends there. Else the window is *cut* there:
//! [`MasterSurface::cut_edges`]. A cut is no border, and no result depends on it.

mod boxes;
mod error;
mod known;
mod numbers;

pub use boxes::boxes_around;
pub use error::WindowError;
pub(crate) use known::Known;

use super::auxiliary::Auxiliary;
use super::domains::NodalDomains;
pub use super::extents::Extents;
use super::sheet_nodes::ends;
use super::topology::NONE;
use super::{Carried, Creases, Facet, Listed, MasterSurface, SymmetryPlane, sort};
use crate::{Basis, MaterialDomain, Point, Weight};

/// A box: its lowest and its highest corner.
pub type Box3 = [Point; 2];

/// Numbers of nodes and facets stay below this: they are exact as floating-point numbers, too.
pub const LARGEST_NUMBER: u64 = 1 << 53;

/// What domains of influence were found with.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Setup {
    pub weight: Weight,
    pub basis: Basis,
    pub feature_angle_degrees: f64,
    pub planes: Vec<SymmetryPlane>,
    pub extents: Extents,
}

/// What some slaves can need of a surface, by the numbers of the whole. See [the module](self).
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    pub(crate) setup: Setup,
    boxes: Vec<Box3>,
    skin: f64,
    /// Numbers of the nodes, ascending.
    nodes: Vec<u64>,
    /// By ascending place among the nodes, each of which is there.
    sheet_nodes: Vec<WindowNode>,
    /// The auxiliary points that are listed, with their ends by place among the sheet nodes; ascending.
    auxiliary: Vec<Auxiliary>,
    /// By ascending number.
    facets: Vec<WindowFacet>,
    /// Lists of the core's facets, one after another, by place among the sheet nodes and the auxiliary points after them.
    listed: Vec<Listed>,
    /// Where the corners of the core's facets were when the window was made, by ascending place.
    cut: Vec<Point>,
}

/// A node of a window, as one of the sheets that meet in it has it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct WindowNode {
    place: u32,
    domain: MaterialDomain,
}

/// A facet of a window.
#[derive(Clone, Copy, Debug, PartialEq)]
struct WindowFacet {
    number: u64,
    /// By place among the nodes; the fourth of a triangle is [`NONE`].
    corners: [u32; 4],
    /// Bit k where the whole surface ends at the edge from corner k to the next.
    borders: u8,
    /// Bit k where the sheet ends there.
    ends: u8,
    /// Of a facet of the core what fits carry there, and how many nodes are listed.
    core: Option<(Carried, u32)>,
}

/// All that a window is cut from.
pub(crate) struct Sheet<'a> {
    pub surface: &'a MasterSurface,
    pub domains: &'a NodalDomains,
    pub creases: &'a Creases,
    pub setup: &'a Setup,
    pub node_number: &'a dyn Fn(u32) -> u64,
    pub facet_number: &'a dyn Fn(u32) -> u64,
    /// Where the node at a place is at the moment; of corners of the core.
    pub position: &'a dyn Fn(u32) -> Point,
}

impl Sheet<'_> {
    /// The window with this core: the facets that meet one of the boxes, with a skin around them.
    pub fn window(&self, mut core: Vec<u32>, boxes: &[Box3], skin: f64) -> Window {
        let surface = self.surface;
        sort(&mut core);
        let mut facets = core.clone();
        for &facet in &core {
            let listed = self.domains.listed(facet).iter();
            let places = listed.flat_map(|listed| self.domains.places_of(listed.node));
            facets.extend(places.flat_map(|place| surface.facets_of_place(place as usize)));
        }
        sort(&mut facets);
        let mut places: Vec<u32> =
            facets.iter().flat_map(|&facet| surface.corners_of(facet as usize)).copied().collect();
        sort(&mut places);
        let place_of = |place: &u32| places.binary_search(place).map_or(NONE, |place| place as u32);
        let sheet_nodes: Vec<u32> = places.iter().flat_map(|&place| self.domains.at(place)).collect();
        let sheet_node_of = |node: &u32| sheet_nodes.binary_search(node).map_or(NONE, |node| node as u32);
        let lists = core.iter().flat_map(|&facet| self.domains.listed(facet));
        let mut points: Vec<u32> =
            lists.map(|listed| listed.node).filter(|&node| self.domains.is_auxiliary(node)).collect();
        sort(&mut points);
        let own = |&node: &u32| {
            let point = self.domains.auxiliary(node);
            Auxiliary { ends: point.ends.map(|end| sheet_node_of(&end)), ..point }
        };
        let auxiliary = points.iter().map(own).collect();
        let listed_of = |node: &u32| match points.binary_search(node) {
            Ok(point) => (sheet_nodes.len() + point) as u32,
            Err(_) => sheet_node_of(node),
        };
        let mut listed = Vec::new();
        let facet = |&facet: &u32| {
            let mut corners = [NONE; 4];
            for (own, place) in corners.iter_mut().zip(surface.corners_of(facet as usize)) {
                *own = place_of(place);
            }
            let edges = surface.across(facet as usize).iter().enumerate();
            let is_border = |edge, other| other == NONE && !surface.is_cut(facet as usize, edge);
            let core = core.binary_search(&facet).is_ok().then(|| {
                let list = self.domains.listed(facet);
                listed.extend(list.iter().map(|own| Listed { node: listed_of(&own.node), ..*own }));
                (self.domains.carried(facet), list.len() as u32)
            });
            WindowFacet {
                number: (self.facet_number)(facet),
                corners,
                borders: edges.map(|(edge, &other)| u8::from(is_border(edge, other)) << edge).sum(),
                ends: self.creases.of_facet(facet as usize),
                core,
            }
        };
        let facets: Vec<WindowFacet> = facets.iter().map(facet).collect();
        let cut = core_places(&facets).map(|place| (self.position)(places[place as usize])).collect();
        let window_node = |&node: &u32| WindowNode {
            place: place_of(&self.domains.place(node)),
            domain: *self.domains.domain(node),
        };
        let sheet_nodes = sheet_nodes.iter().map(window_node).collect();
        let nodes = places.iter().map(|&place| (self.node_number)(place)).collect();
        let (setup, boxes) = (self.setup.clone(), boxes.to_vec());
        Window { setup, boxes, skin, nodes, sheet_nodes, auxiliary, facets, listed, cut }
    }
}

/// The places of the corners of the core's facets, ascending.
fn core_places(facets: &[WindowFacet]) -> impl Iterator<Item = u32> {
    let core = facets.iter().filter(|facet| facet.core.is_some());
    let mut places: Vec<u32> =
        core.flat_map(|facet| facet.corners).filter(|&corner| corner != NONE).collect();
    sort(&mut places);
    places.into_iter()
}

/// A box with a skin around it.
pub(crate) fn widened([low, high]: Box3, skin: f64) -> Box3 {
    [low.map(|x| x - skin), high.map(|x| x + skin)]
}

/// Whether these are boxes and a skin.
pub(crate) fn check_boxes(boxes: &[Box3], skin: f64) -> Result<(), WindowError> {
    let is_box = |[low, high]: &Box3| {
        low.iter().zip(high).all(|(low, high)| low.is_finite() && high.is_finite() && low <= high)
    };
    let is_skin = skin >= 0.0 && skin.is_finite();
    let place = if is_skin { boxes.iter().position(|own| !is_box(own)) } else { Some(0) };
    place.map_or(Ok(()), |place| Err(WindowError::InvalidBox { place, skin }))
}

impl Window {
    /// Numbers of its nodes in the whole surface, ascending. An [interface](crate::interface::ContactInterface::in_window) of the window
    /// has them first among its nodes, in this order.
    pub fn nodes(&self) -> impl ExactSizeIterator<Item = u64> + '_ {
        self.nodes.iter().copied()
    }

    /// Numbers of its facets in the whole surface, ascending.
    pub fn facets(&self) -> impl ExactSizeIterator<Item = u64> + '_ {
        self.facets.iter().map(|facet| facet.number)
    }

    /// Its boxes: everything that meets them is known, while no node of the whole surface has moved by more than the
    /// [skin](Self::skin) since the window was made.
    pub fn boxes(&self) -> &[Box3] {
        &self.boxes
    }

    /// How far nodes of the surface may move before the window is to be made anew, length.
    pub const fn skin(&self) -> f64 {
        self.skin
    }

    /// First positions of its nodes.
    pub fn first_positions(&self) -> impl Iterator<Item = Point> + '_ {
        let first_of_node = self.sheet_nodes.chunk_by(|one, other| one.place == other.place);
        first_of_node.map(|of_node| of_node[0].domain.position)
    }

    /// Windows for the same slaves from the owners of several parts of the surface, as one. The boxes and the skin have to be the same.
    ///
    /// # Errors
    /// [`WindowError::Differs`] for windows of different surfaces, options, boxes, skins or positions; [`WindowError::None`] without a
    /// window.
    pub fn joined(windows: &[Self]) -> Result<Self, WindowError> {
        let [first, others @ ..] = windows else {
            return Err(WindowError::None);
        };
        for (number, other) in (1..).zip(others) {
            if other.setup != first.setup {
                return Err(WindowError::Differs { what: "the options of part", number });
            }
            if (&other.boxes, other.skin) != (&first.boxes, first.skin) {
                return Err(WindowError::Differs { what: "the boxes of part", number });
            }
        }
        let mut nodes: Vec<u64> = windows.iter().flat_map(|window| &window.nodes).copied().collect();
        sort(&mut nodes);
        let place = |number: &u64| nodes.binary_search(number).map_or(NONE, |place| place as u32);
        let places: Vec<Vec<u32>> =
            windows.iter().map(|window| window.nodes.iter().map(place).collect()).collect();
        // A sheet node is known by its node and by which of those it is there.
        let known: Vec<Vec<(u32, u32, MaterialDomain)>> =
            windows.iter().zip(&places).map(|(window, places)| window.known_sheet_nodes(places)).collect();
        let mut all = known.concat();
        all.sort_by_key(|&(place, sheet, _)| (place, sheet));
        let is_same = |one: &(u32, u32, _), other: &(u32, u32, _)| (one.0, one.1) == (other.0, other.1);
        if let Some(pair) = all.windows(2).find(|pair| is_same(&pair[0], &pair[1]) && pair[0].2 != pair[1].2)
        {
            return Err(WindowError::Differs { what: "node", number: nodes[pair[0].0 as usize] });
        }
        all.dedup_by(|one, other| is_same(one, other));
        let sheet_node = |&(place, sheet, _): &(u32, u32, _)| {
            all.binary_search_by_key(&(place, sheet), |own| (own.0, own.1)).map_or(NONE, |node| node as u32)
        };
        let mut joined: Vec<Vec<u32>> =
            known.iter().map(|own| own.iter().map(sheet_node).collect()).collect();
        let auxiliary_of = |(joined, window): (&Vec<u32>, &Self)| -> Vec<Auxiliary> {
            let own =
                |point: &Auxiliary| Auxiliary { ends: point.ends.map(|end| joined[end as usize]), ..*point };
            window.auxiliary.iter().map(own).collect()
        };
        let known_points: Vec<Vec<Auxiliary>> = joined.iter().zip(windows).map(auxiliary_of).collect();
        let mut auxiliary = known_points.concat();
        sort(&mut auxiliary);
        for (joined, own) in joined.iter_mut().zip(&known_points) {
            let number = |point: &Auxiliary| all.len() + auxiliary.partition_point(|own| own < point);
            joined.extend(own.iter().map(|point| number(point) as u32));
        }
        let sheet_nodes = all.iter().map(|&(place, _, domain)| WindowNode { place, domain }).collect();
        let mut facets: Vec<(WindowFacet, Vec<Listed>)> = Vec::new();
        for ((places, joined), window) in places.iter().zip(&joined).zip(windows) {
            for (facet, list) in window.facets_with_lists() {
                let corners =
                    facet.corners.map(|corner| if corner == NONE { NONE } else { places[corner as usize] });
                let list = list.iter().map(|own| Listed { node: joined[own.node as usize], ..*own });
                facets.push((WindowFacet { corners, ..*facet }, list.collect()));
            }
        }
        // Those of a core come first.
        facets.sort_by_key(|(facet, _)| (facet.number, facet.core.is_none()));
        for pair in facets.windows(2) {
            let [(one, list), (two, other)] = pair else { continue };
            let is_same = WindowFacet { core: None, ..*one } == WindowFacet { core: None, ..*two }
                && (two.core.is_none() || (one.core, list) == (two.core, other));
            if one.number == two.number && !is_same {
                return Err(WindowError::Differs { what: "facet", number: one.number });
            }
        }
        facets.dedup_by_key(|(facet, _)| facet.number);
        let listed = facets.iter().flat_map(|(_, list)| list).copied().collect();
        let facets = facets.into_iter().map(|(facet, _)| facet).collect();
        let own_cut = |(window, places): (&Self, &Vec<u32>)| -> Vec<(u32, Point)> {
            let own = core_places(&window.facets).map(|place| places[place as usize]);
            own.zip(window.cut.iter().copied()).collect()
        };
        let mut cut: Vec<(u32, Point)> = windows.iter().zip(&places).flat_map(own_cut).collect();
        cut.sort_by_key(|&(place, _)| place);
        if let Some(pair) = cut.windows(2).find(|pair| pair[0].0 == pair[1].0 && pair[0].1 != pair[1].1) {
            let number = nodes[pair[0].0 as usize];
            return Err(WindowError::Differs { what: "the position of node", number });
        }
        cut.dedup_by_key(|(place, _)| *place);
        let cut = cut.into_iter().map(|(_, x)| x).collect();
        let (setup, boxes, skin) = (first.setup.clone(), first.boxes.clone(), first.skin);
        Ok(Self { setup, boxes, skin, nodes, sheet_nodes, auxiliary, facets, listed, cut })
    }

    /// Its sheet nodes with other places of the nodes, and with which of their node's they are, from 0.
    fn known_sheet_nodes(&self, places: &[u32]) -> Vec<(u32, u32, MaterialDomain)> {
        let of_nodes = self.sheet_nodes.chunk_by(|one, other| one.place == other.place);
        let numbered = of_nodes.flat_map(|of_node| (0..).zip(of_node));
        numbered.map(|(sheet, own)| (places[own.place as usize], sheet, own.domain)).collect()
    }

    /// Each facet with its list, which is empty outside of the core.
    fn facets_with_lists(&self) -> impl Iterator<Item = (&WindowFacet, &[Listed])> {
        self.facets.iter().scan(&self.listed[..], |rest, facet| {
            let count = facet.core.map_or(0, |(_, count)| count as usize);
            let (list, after) = rest.split_at(count);
            *rest = after;
            Some((facet, list))
        })
    }

    /// The surface, with its domains and where sheets end.
    ///
    /// # Errors
    /// [`WindowError::Surface`], [`WindowError::Incomplete`].
    pub(crate) fn surface(&self) -> Result<(MasterSurface, NodalDomains, Creases), WindowError> {
        let corners = self.facets.iter().map(|facet| facet.corners).collect();
        let is_border = |facet: usize, edge: usize| self.facets[facet].borders >> edge & 1 == 1;
        let surface = MasterSurface::part(self.nodes.len(), corners, is_border)?;
        let mut is_cut = vec![false; self.nodes.len()];
        surface.cut_edges().flatten().for_each(|node| is_cut[node] = true);
        for (facet, list) in self.facets_with_lists() {
            let ends =
                list.iter().flat_map(|listed| ends(&self.auxiliary, self.sheet_nodes.len(), listed.node));
            let mut places = ends.map(|end| self.sheet_nodes[end as usize].place as usize);
            if let Some(place) = places.find(|&place| is_cut[place]) {
                let node = self.nodes[place];
                return Err(WindowError::Incomplete { facet: facet.number, node });
            }
        }
        let (places, domains) = self.sheet_nodes.iter().map(|node| (node.place, node.domain)).unzip();
        let carried = |facet: &WindowFacet| facet.core.map_or(Carried::Nothing, |(carried, _)| carried);
        let bases = self.facets.iter().map(carried).collect();
        let lists: Vec<Vec<Listed>> = self.facets_with_lists().map(|(_, list)| list.to_vec()).collect();
        let creases = Creases::given(self.facets.iter().map(|facet| facet.ends).collect());
        let auxiliary = self.auxiliary.clone();
        Ok((surface, NodalDomains::given((places, auxiliary), domains, bases, &lists), creases))
    }

    /// The facets of its core with their places, ascending, corners by place among its nodes.
    pub(crate) fn core_facets(&self) -> impl Iterator<Item = (u32, Facet)> + '_ {
        let core = (0..).zip(&self.facets).filter(|(_, facet)| facet.core.is_some());
        core.map(|(place, facet)| match facet.corners.map(|corner| corner as usize) {
            [a, b, c, _] if facet.corners[3] == NONE => (place, Facet::Triangle([a, b, c])),
            corners => (place, Facet::Quadrilateral(corners)),
        })
    }
}
