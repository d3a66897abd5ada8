//! Domains of influence that belong to the nodes, in the first configuration (`docs/equations.md`, [T14], [T18]).
//!
//! A node takes part in the fits of all slaves whose place in the first configuration lies in its domain, an ellipsoid that stays
//! what it is there. Its axes are those of the node's cells: C_k is the mean of e eᵀ over the edges e to the nodes of its facets on the sheet,
//! |U (X − X_k)| with UᵀU = C_k⁻¹/s_k² the distance from it, 1 on its border. The factors s_k are as small as the conditioning of the
//! fits allows. At each *centre* c (a node, the middle of an edge or of a facet, a point halfway between these) let s(c) be the smallest
//! factor for which the weighted design matrix of the nodes nearer than s, columns [scaled](super::conditioning) so that in-plane axes do not
//! matter, has no singular value below [`SMALLEST_SINGULAR_VALUE`](super::conditioning::SMALLEST_SINGULAR_VALUE). s_k is the largest s(c)
//! of all centres that the node serves, and a little more. Where that makes more masters than fits need, domains shrink again
//! ([`trim`](super::trim)).
//!
//! A node on a sharp edge has a domain in each of the sheets that meet there, a *sheet node*: cells of other sheets say nothing of the fits
//! on this one. [Auxiliary](super::auxiliary) points have domains that follow from those of their ends.
//!
//! Which nodes a slave may need follows from its closest facet, so facets have lists of them, found once.

use std::ops::Range;

use super::auxiliary::Auxiliary;
use super::cells::with_auxiliary;
use super::fits::Demands;
use super::lists::still_listed;
use super::sheet_nodes::{SheetNodes, at_place, ends};
use super::sheets::{Carried, Listed, Sheets};
use super::topology::NONE;
use super::trim::trimmed;
use super::{Creases, SurfaceIndex, Symmetry};
use crate::{Basis, MaterialDomain, Point, Weight};

/// Domains are wider than the centres ask for by this factor: slaves are elsewhere, too.
const MORE: f64 = 1.09;

/// The domains of all sheet nodes of a surface, and where its facets carry which basis.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NodalDomains {
    /// By sheet node its place among the surface's nodes, ascending.
    places: Vec<u32>,
    /// Points between them, which have the numbers after those of sheet nodes.
    auxiliary: Vec<Auxiliary>,
    /// By sheet node, and after them by auxiliary point; a metric of zeros where no fit takes it.
    domains: Vec<MaterialDomain>,
    /// Per facet the basis that the fits on it carry.
    bases: Vec<Carried>,
    /// Nodes that slaves closest to a facet may need, those of all facets one after another.
    listed: Vec<Listed>,
    /// Where the list of each facet ends.
    ends: Vec<usize>,
    /// The shortest half axis of all domains; infinite without one.
    shortest: f64,
}

impl NodalDomains {
    /// The domains for this surface as it is, in parallel; the same for any number of threads.
    pub fn new(
        index: &SurfaceIndex<'_>,
        creases: &Creases,
        symmetry: &Symmetry,
        weight: Weight,
        basis: Basis,
    ) -> Self {
        let nodes = SheetNodes::new(index, creases, symmetry, None);
        let sheets = Sheets { index, creases, nodes: &nodes, symmetry, complete: None };
        let cells = sheets.cells();
        let facets: Vec<u32> = (0..index.surface().facet_count() as u32).collect();
        let Demands { factors, bases, .. } = sheets.demands(&cells, weight, basis, &facets);
        let mut domains = grown(&cells, &factors, nodes.auxiliary());
        let mut lists = sheets.lists(&domains, &facets).0;
        let crowded = sheets.crowded(&domains, &facets, &lists);
        if crowded.contains(&true) {
            let ratios = sheets.ratios(&domains, (&bases, weight), (&facets, &lists), |node| crowded[node]);
            domains = trimmed(&domains, &ratios, nodes.auxiliary());
            still_listed(&sheets, &domains, &facets, &mut lists);
        }
        Self::given((nodes.places().to_vec(), nodes.auxiliary().to_vec()), domains, bases, &lists)
    }

    /// With places by sheet node, auxiliary points, domains by sheet node, those of points after them or not, and bases and lists by facet.
    pub fn given(
        (places, auxiliary): (Vec<u32>, Vec<Auxiliary>),
        mut domains: Vec<MaterialDomain>,
        bases: Vec<Carried>,
        lists: &[Vec<Listed>],
    ) -> Self {
        domains.truncate(places.len());
        let domains = with_auxiliary(domains, &auxiliary);
        let ends = lists
            .iter()
            .scan(0, |end, list| {
                *end += list.len();
                Some(*end)
            })
            .collect();
        let shortest = domains.iter().map(MaterialDomain::shortest).fold(f64::INFINITY, f64::min);
        Self { places, auxiliary, domains, bases, listed: lists.concat(), ends, shortest }
    }

    /// Whether lists name no image from this number on; else the place of one that does among those listed.
    pub fn check_images(&self, count: u32) -> Result<(), usize> {
        let is_image = |listed: &Listed| listed.image == NONE || listed.image < count;
        self.listed.iter().position(|listed| !is_image(listed)).map_or(Ok(()), Err)
    }

    /// That of a sheet node, or of an auxiliary point.
    pub fn domain(&self, node: u32) -> &MaterialDomain {
        &self.domains[node as usize]
    }

    /// The place of a sheet node among the surface's nodes.
    pub fn place(&self, node: u32) -> u32 {
        self.places[node as usize]
    }

    /// Whether this is an auxiliary point.
    pub fn is_auxiliary(&self, node: u32) -> bool {
        node as usize >= self.places.len()
    }

    /// An auxiliary point.
    pub fn auxiliary(&self, node: u32) -> Auxiliary {
        self.auxiliary[node as usize - self.places.len()]
    }

    /// The sheet nodes that carry an auxiliary point, or a sheet node twice.
    pub fn ends(&self, node: u32) -> [u32; 2] {
        ends(&self.auxiliary, self.places.len(), node)
    }

    /// The part that the first of these has of it; the second has what is missing to 1.
    pub fn part(&self, node: u32) -> f64 {
        if self.is_auxiliary(node) { self.auxiliary(node).part() } else { 1.0 }
    }

    /// The places of those.
    pub fn places_of(&self, node: u32) -> [u32; 2] {
        self.ends(node).map(|end| self.place(end))
    }

    /// The sheet nodes at a place.
    pub fn at(&self, place: u32) -> Range<u32> {
        at_place(&self.places, place)
    }

    /// The first position of the node at a place.
    pub fn first_position(&self, place: u32) -> Point {
        self.domain(self.at(place).start).position
    }

    /// The shortest half axis of all domains; infinite without one.
    pub const fn shortest(&self) -> f64 {
        self.shortest
    }

    /// The nodes that a slave may need whose closest facet this is, ascending, a node before its images.
    pub fn listed(&self, facet: u32) -> &[Listed] {
        let start = (facet as usize).checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.listed[start..self.ends[facet as usize]]
    }

    /// The sheet node at a place that a slave whose closest facet this is may need, or an image of it.
    pub fn listed_at(&self, facet: u32, place: u32) -> Option<u32> {
        let listed = self.listed(facet);
        // Auxiliary points come last.
        let key = |listed: &Listed| self.places.get(listed.node as usize).copied().unwrap_or(NONE);
        let found = listed.binary_search_by_key(&place, key).ok()?;
        Some(listed[found].node)
    }

    /// What the nodes around a facet carry.
    pub fn carried(&self, facet: u32) -> Carried {
        self.bases[facet as usize]
    }
}

/// The domains of cells with these factors, by sheet node, a metric of zeros where no fit takes it; and those of auxiliary points.
pub(crate) fn grown(
    cells: &[MaterialDomain],
    factors: &[f64],
    auxiliary: &[Auxiliary],
) -> Vec<MaterialDomain> {
    let domains = factors.iter().zip(cells).map(|(factor, domain)| domain.times(MORE * factor));
    with_auxiliary(domains.collect(), auxiliary)
}
