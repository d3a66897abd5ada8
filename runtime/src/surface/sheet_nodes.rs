//! Nodes as the sheets have them: a node on a sharp edge counts once for each sheet that meets there.

use std::ops::Range;

use super::topology::NONE;
use super::{Creases, MasterSurface};

/// The sheet nodes of a surface: of each node one for every run of facets around it that is not parted by the end of a sheet.
#[derive(Clone, Debug)]
pub(crate) struct SheetNodes {
    /// The node's place in the surface, ascending; those of one place in the order of their lowest facets.
    places: Vec<u32>,
    /// Of the corners of each facet.
    of_corners: Vec<[u32; 4]>,
}

impl SheetNodes {
    pub fn new(surface: &MasterSurface, creases: &Creases) -> Self {
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
        Self { places, of_corners }
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
