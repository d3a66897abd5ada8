//! Nodes as the sheets have them: a node on a sharp edge counts once for each sheet that meets there. And the [auxiliary](super::auxiliary)
//! points between them.

use std::ops::Range;

use super::auxiliary::{Auxiliary, Rung, rungs};
use super::topology::NONE;
use super::{Creases, MasterSurface, SurfaceIndex, Symmetry, sort};

/// The sheet nodes of a surface: of each node one for every run of facets around it that is not parted by the end of a sheet. Auxiliary points
/// have the numbers after those of sheet nodes.
#[derive(Clone, Debug)]
pub(crate) struct SheetNodes {
    /// The node's place in the surface, ascending; those of one place in the order of their lowest facets.
    places: Vec<u32>,
    /// Of the corners of each facet.
    of_corners: Vec<[u32; 4]>,
    /// Ascending.
    auxiliary: Vec<Auxiliary>,
    /// What the edges of each facet are; none where there is no rung.
    of_edges: Vec<[Rung; 4]>,
}

impl SheetNodes {
    /// `complete`: of a part of a surface, by place, whether all facets at the node are there.
    pub fn new(
        index: &SurfaceIndex<'_>,
        creases: &Creases,
        symmetry: &Symmetry,
        complete: Option<&[bool]>,
    ) -> Self {
        let surface = index.surface();
        let mut nodes = Self::without_auxiliary(surface, creases);
        let is_complete = |node: u32| complete.is_none_or(|complete| complete[nodes.place(node)]);
        let of_edges = rungs(&nodes, index, creases, symmetry, is_complete);
        for (facet, edges) in (0..).zip(&of_edges) {
            for (edge, rung) in edges.iter().enumerate() {
                nodes.auxiliary.extend(rung.points(nodes.ends_of_edge(surface, facet, edge)));
            }
        }
        sort(&mut nodes.auxiliary);
        Self { of_edges, ..nodes }
    }

    /// Without auxiliary points.
    pub fn without_auxiliary(surface: &MasterSurface, creases: &Creases) -> Self {
        let mut places = Vec::with_capacity(surface.nodes().len());
        let mut of_corners = vec![[NONE; 4]; surface.facet_count()];
        let mut run = Vec::new();
        for place in 0..surface.nodes().len() as u32 {
            for &facet in surface.facets_of_place(place as usize) {
                if of_corners[facet as usize][corner_of(surface, facet, place)] != NONE {
                    continue;
                }
                run_around(surface, creases, (facet, place), &mut run);
                for &facet in &run {
                    of_corners[facet as usize][corner_of(surface, facet, place)] = places.len() as u32;
                }
                places.push(place);
            }
        }
        Self { places, of_corners, auxiliary: Vec::new(), of_edges: Vec::new() }
    }

    /// Ascending; their numbers follow those of sheet nodes.
    pub fn auxiliary(&self) -> &[Auxiliary] {
        &self.auxiliary
    }

    /// What the edges of a facet are; none where there is no rung.
    pub(super) fn of_edges(&self, facet: u32) -> &[Rung] {
        self.of_edges.get(facet as usize).map_or(&[], |edges| edges)
    }

    /// Whether no auxiliary point on the edges of the facets at a place depends on facets that are not there.
    pub fn is_settled(&self, surface: &MasterSurface, place: usize) -> bool {
        !surface.facets_of_place(place).iter().any(|&facet| self.of_edges(facet).contains(&Rung::Unknown))
    }

    /// The auxiliary points of an edge, with their numbers.
    pub(super) fn points_of_edge(
        &self,
        surface: &MasterSurface,
        facet: u32,
        edge: usize,
    ) -> impl Iterator<Item = (u32, Auxiliary)> {
        let points = self.of_edges[facet as usize][edge].points(self.ends_of_edge(surface, facet, edge));
        let before = |point: &Auxiliary| self.auxiliary.partition_point(|other| other < point);
        points.map(move |point| ((self.places.len() + before(&point)) as u32, point))
    }

    /// The sheet nodes at the ends of an edge; of an edge beyond the last one of a triangle some.
    fn ends_of_edge(&self, surface: &MasterSurface, facet: u32, edge: usize) -> [u32; 2] {
        let own = self.of_facet(surface, facet);
        [own[edge % own.len()], own[(edge + 1) % own.len()]]
    }

    /// The sheet nodes that carry an auxiliary point, or a sheet node twice.
    pub fn ends(&self, node: u32) -> [u32; 2] {
        ends(&self.auxiliary, self.places.len(), node)
    }

    /// By sheet node, the place of its node in the surface, ascending.
    pub fn places(&self) -> &[u32] {
        &self.places
    }

    /// The place of a sheet node.
    pub fn place(&self, node: u32) -> usize {
        self.places[node as usize] as usize
    }

    /// The sheet nodes at a place.
    pub fn at_place(&self, place: u32) -> Range<u32> {
        at_place(&self.places, place)
    }

    /// The sheet node that a facet has at a corner.
    pub fn at(&self, surface: &MasterSurface, facet: u32, place: u32) -> u32 {
        self.of_corners[facet as usize][corner_of(surface, facet, place)]
    }

    /// Those at the corners of a facet.
    pub fn of_facet(&self, surface: &MasterSurface, facet: u32) -> &[u32] {
        &self.of_corners[facet as usize][..surface.corners_of(facet as usize).len()]
    }

    /// The facets of a sheet node, ascending.
    pub fn facets<'s>(&'s self, surface: &'s MasterSurface, node: u32) -> impl Iterator<Item = u32> + 's {
        let facets = surface.facets_of_place(self.place(node)).iter().copied();
        facets.filter(move |&facet| self.of_corners[facet as usize].contains(&node))
    }
}

/// The sheet nodes that carry one of the auxiliary points after so many sheet nodes, or one of these twice.
pub(super) fn ends(auxiliary: &[Auxiliary], nodes: usize, node: u32) -> [u32; 2] {
    (node as usize).checked_sub(nodes).map_or([node; 2], |own| auxiliary[own].ends)
}

/// Which of the sheet nodes with these places, ascending, are those of a place.
pub(super) fn at_place(places: &[u32], place: u32) -> Range<u32> {
    let below = |limit: u32| places.partition_point(|&own| own < limit) as u32;
    below(place)..below(place + 1)
}

fn corner_of(surface: &MasterSurface, facet: u32, place: u32) -> usize {
    let corner = surface.corners_of(facet as usize).iter().position(|&corner| corner == place);
    corner.expect("the facet is one of the node's")
}

/// The facets at a corner of `facet` that are reached over edges there which do not end the sheet.
fn run_around(surface: &MasterSurface, creases: &Creases, (facet, place): (u32, u32), run: &mut Vec<u32>) {
    run.clear();
    run.push(facet);
    let mut next = 0;
    while let Some(&facet) = run.get(next) {
        next += 1;
        for (edge, &other) in surface.across(facet as usize).iter().enumerate() {
            let is_end = other == NONE || creases.ends_at(facet as usize, edge) || run.contains(&other);
            if !is_end && surface.corners_of(other as usize).contains(&place) {
                run.push(other);
            }
        }
    }
}
