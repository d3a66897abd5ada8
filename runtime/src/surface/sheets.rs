//! Sheets in their first configuration, which domains are found on.

use super::auxiliary::{Rung, possible_points};
use super::border::Creases;
use super::index::SurfaceIndex;
use super::sheet_nodes::SheetNodes;
use super::symmetry::Symmetry;
use super::topology::NONE;
use super::walk::Walk;
use crate::{MaterialDomain, Point};

/// Centres that one thread works on in a row.
pub(super) const CHUNK: usize = 64;

/// Sheets in their first configuration, of a whole surface or of a part.
#[derive(Clone, Copy)]
pub(crate) struct Sheets<'a> {
    pub index: &'a SurfaceIndex<'a>,
    pub creases: &'a Creases,
    pub nodes: &'a SheetNodes,
    pub symmetry: &'a Symmetry,
    /// Of a part of a surface: by place whether all facets at the node are there, with all auxiliary points on their edges, so that domains of
    /// it follow from the part.
    pub complete: Option<&'a [bool]>,
}

/// Nodes of a sheet around a facet, in the memory of one thread.
#[derive(Default)]
pub(super) struct Found {
    walk: Walk,
    /// Places with the facets over which they were reached.
    reached: Vec<(u32, u32)>,
    /// Sheet nodes, and after them auxiliary points, ascending.
    pub nodes: Vec<u32>,
    /// Whether these may not be all, or not what they are: of any search since it was last set to `false`.
    pub is_open: bool,
}

impl Sheets<'_> {
    /// The domain of a listed node, or of the image that is listed.
    pub(super) fn domain_of(&self, domains: &[MaterialDomain], listed: &Listed) -> MaterialDomain {
        let domain = &domains[listed.node as usize];
        if listed.image == NONE { *domain } else { self.symmetry.domain_of(listed.image, domain) }
    }

    /// Finds the nodes of the facet's sheet within reach of a point of it, and auxiliary points. Returns whether the sheet has no others.
    pub(super) fn find(&self, found: &mut Found, (facet, from): (u32, Point), reach: f64) -> bool {
        let Found { walk, reached, nodes, is_open } = found;
        walk.start(self.index, facet, from);
        let is_all = walk.nodes_within(self.index, self.creases, reach, reached);
        let sheet_node = |&(place, facet): &(u32, u32)| self.nodes.at(self.index.surface(), facet, place);
        nodes.clear();
        nodes.extend(reached.iter().map(sheet_node));
        *is_open |= self.complete.is_some_and(|complete| {
            walk.met_cut() || reached.iter().any(|&(place, _)| !complete[place as usize])
        });
        let count = nodes.len();
        let surface = self.index.surface();
        let position = |node: u32| self.index.positions()[self.nodes.place(node)];
        walk.facets_within(reach, |facet, is_within| {
            for (edge, &rung) in self.nodes.of_edges(facet).iter().enumerate() {
                if rung == Rung::Unknown {
                    let [from, to] = self.index.shape(facet).edge(edge);
                    *is_open |= possible_points([from, to]).any(is_within);
                }
                let points = self.nodes.points_of_edge(surface, facet, edge);
                let within =
                    points.filter(|(_, point)| is_within(point.position(point.ends.map(position)).into()));
                nodes.extend(within.map(|(number, _)| number));
            }
        });
        nodes[count..].sort_unstable();
        nodes.dedup();
        is_all
    }
}

/// A sheet node of a facet's list, or one of its images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Listed {
    pub node: u32,
    /// The number of the image, or [`NONE`].
    pub image: u32,
}

/// What the nodes around a facet carry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Carried {
    Nothing,
    Linear,
    Quadratic,
}

impl Carried {
    pub const fn of(number: u8) -> Self {
        match number {
            0 => Self::Nothing,
            1 => Self::Linear,
            _ => Self::Quadratic,
        }
    }

    /// The number of functions.
    pub(super) const fn size(self) -> usize {
        match self {
            Self::Nothing => 0,
            Self::Linear => 3,
            Self::Quadratic => 6,
        }
    }
}
