//! What the fits at the centres of facets ask of the domains around them.

use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};

use rayon::prelude::*;

use super::conditioning::{Near, smallest_factor};
use super::sheets::{CHUNK, Carried, Found, Listed, Sheets};
use super::symmetry::Symmetry;
use super::topology::NONE;
use crate::frame::tangents;
use crate::vector::Vector3;
use crate::{Basis, MaterialDomain, Point, Weight};

/// Where all nodes of a sheet are at hand, domains that reach so many times farther than the farthest weight all alike.
const WIDEST: f64 = 10.0;
/// A quadratic basis that asks for a larger factor is not carried, unless the sheet ends before: nodes would reach from one end of a long
/// sheet to the other. Two thirds of this are enough inside, and nine tenths at corners and where the size of cells changes.
const LARGEST_FACTOR: f64 = 4.0;
/// Nodes are first sought so many extents of a facet around it.
const FIRST_REACH: f64 = 3.5;
/// The shell whose nodes say how far a search reaches, from this part of its radius on.
const SHELL: f64 = 0.75;
/// A fit at a centre takes no more nodes than this.
const MOST_NODES: usize = 400;

/// What the fits at the centres of some facets ask for. Of several parts the largest factors and the least bases count, in any order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Demands {
    /// By sheet node; 0 where no fit takes it.
    pub factors: Vec<f64>,
    /// Of each facet of the surface.
    pub bases: Vec<Carried>,
    /// Facets whose fits may depend on what is not there.
    pub open: Vec<u32>,
}

/// Where a fit is looked at.
pub(super) struct Centre {
    pub point: Vector3,
    pub normal: Vector3,
    /// A facet around it, and the others.
    pub facet: u32,
    pub others: Vec<u32>,
}

/// Memory of one thread.
#[derive(Default)]
pub(super) struct Scratch {
    pub found: Found,
    /// The sheet nodes and auxiliary points around a facet, and their images, with their cells or domains.
    around: Vec<(u32, MaterialDomain)>,
    /// How far from the middle of the facet they were sought, and how far from there the outermost of them are that say how far a
    /// search reaches.
    reach: f64,
    shell: f64,
    middle: Vector3,
    /// Whether the sheet has no others.
    is_all: bool,
    /// The same seen from a centre.
    pub nodes: Vec<Near>,
}

impl Sheets<'_> {
    /// What the centres ask for that these facets look after, in parallel.
    pub fn demands(&self, cells: &[MaterialDomain], weight: Weight, basis: Basis, facets: &[u32]) -> Demands {
        let surface = self.index.surface();
        let factors: Vec<AtomicU64> = (0..self.nodes.places().len()).map(|_| AtomicU64::new(0)).collect();
        let bases: Vec<AtomicU8> =
            (0..surface.facet_count()).map(|_| AtomicU8::new(Carried::Quadratic as u8)).collect();
        let of_facet = |scratch: &mut Scratch, &facet: &u32| {
            let extent = self.index.shape(facet).extent();
            scratch.found.is_open = false;
            scratch.gather(self, (cells, facet), FIRST_REACH * extent);
            for centre in centres(self, facet) {
                let (factor, carried) = factor_at(self, (weight, basis), &centre, (cells, scratch));
                // Largest and smallest do not depend on the order in which they come; the bits of positive numbers are
                // ordered like them.
                for near in scratch.nodes.iter().filter(|near| near.distance < factor) {
                    for node in self.nodes.ends(near.node) {
                        factors[node as usize].fetch_max(factor.to_bits(), Ordering::Relaxed);
                    }
                }
                for &facet in centre.others.iter().chain([&centre.facet]) {
                    bases[facet as usize].fetch_min(carried as u8, Ordering::Relaxed);
                }
            }
            scratch.found.is_open.then_some(facet)
        };
        let open: Vec<Option<u32>> =
            facets.par_iter().with_min_len(CHUNK).map_init(Scratch::default, of_facet).collect();
        Demands {
            factors: factors.into_iter().map(|bits| f64::from_bits(bits.into_inner())).collect(),
            bases: bases.into_iter().map(|carried| Carried::of(carried.into_inner())).collect(),
            open: open.into_iter().flatten().collect(),
        }
    }
}

/// The centres that a facet looks after: its middle and quarter points and, of the corners and edges that it shares with facets of
/// its sheet, those of which it has the lowest number.
fn centres(sheets: &Sheets<'_>, facet: u32) -> Vec<Centre> {
    let Sheets { index, creases, nodes, .. } = *sheets;
    let surface = index.surface();
    let shape = index.shape(facet);
    let corners = shape.corners();
    let normal = index.normals()[facet as usize];
    let own = |point| Centre { point, normal, facet, others: Vec::new() };
    let middle = shape.middle();
    let mut all = vec![own(middle)];
    all.extend(corners.iter().map(|&corner| own((corner + middle) / 2.0)));
    let between = (0..corners.len()).map(|edge| shape.edge(edge));
    all.extend(between.map(|[from, to]| own(((from + to) / 2.0 + middle) / 2.0)));
    for (edge, &other) in surface.across(facet as usize).iter().enumerate() {
        let [from, to] = shape.edge(edge);
        let is_end = other == NONE || creases.ends_at(facet as usize, edge);
        if !is_end && other < facet {
            continue;
        }
        let normal = if is_end { normal } else { (normal + index.normals()[other as usize]).normalize() };
        let others = if is_end { Vec::new() } else { vec![other] };
        let on_edge = [0.25, 0.5, 0.75].map(|t| from * (1.0 - t) + to * t);
        all.extend(on_edge.map(|point| Centre { point, normal, facet, others: others.clone() }));
    }
    for (&point, &place) in corners.iter().zip(surface.corners_of(facet as usize)) {
        let fan: Vec<u32> = nodes.facets(surface, nodes.at(surface, facet, place)).collect();
        if fan.iter().all(|&other| facet <= other) {
            let normal =
                fan.iter().map(|&other| index.normals()[other as usize]).sum::<Vector3>().normalize();
            all.push(Centre { point, normal, facet, others: fan });
        }
    }
    all
}

/// s(c), and what the nodes within reach of it carry. `scratch.nodes` are those that were looked at.
fn factor_at(
    sheets: &Sheets<'_>,
    (weight, basis): (Weight, Basis),
    centre: &Centre,
    (cells, scratch): (&[MaterialDomain], &mut Scratch),
) -> (f64, Carried) {
    let mut last = usize::MAX;
    let wanted =
        if basis == Basis::Linear { &[Carried::Linear][..] } else { &[Carried::Quadratic, Carried::Linear] };
    loop {
        // Beyond this a node that is not among those gathered might be within reach.
        let complete = scratch.look(centre, sheets.symmetry);
        let count = scratch.nodes.len();
        let is_all = scratch.is_all && count == last;
        let farthest = scratch.nodes.last().map_or(0.0, |farthest| farthest.distance);
        // Then what the quadratic basis asks for cannot be found among more nodes.
        let is_decided = is_all || count > MOST_NODES || complete.min(farthest) >= LARGEST_FACTOR;
        for &carried in wanted {
            let is_quadratic = carried == Carried::Quadratic;
            let largest = if is_quadratic || is_decided { complete } else { 0.0 };
            let widest = WIDEST * farthest;
            let largest = if is_all && sheets.symmetry.is_none() { widest } else { largest.min(widest) };
            let is_long = is_quadratic && (farthest > LARGEST_FACTOR || !is_all);
            let largest = if is_long { largest.min(LARGEST_FACTOR) } else { largest };
            if let Some(factor) = smallest_factor(&scratch.nodes, weight, carried, largest) {
                return (factor, carried);
            }
        }
        if is_all || count > MOST_NODES {
            return (0.0, Carried::Nothing);
        }
        last = count;
        scratch.gather(sheets, (cells, centre.facet), 1.5 * scratch.reach);
    }
}

impl Scratch {
    /// Gathers the nodes of the facet's sheet within reach of its middle, with their images.
    fn gather(&mut self, sheets: &Sheets<'_>, (cells, facet): (&[MaterialDomain], u32), reach: f64) {
        let symmetry = sheets.symmetry;
        self.middle = sheets.index.shape(facet).middle();
        let from = Point::from(self.middle);
        self.is_all = sheets.find(&mut self.found, (facet, from), reach);
        self.around.clear();
        for &node in &self.found.nodes {
            let domain = &cells[node as usize];
            self.around.push((node, *domain));
            symmetry.images_near(domain.position, from, reach, |image, _| {
                self.around.push((node, symmetry.domain_of(image, domain)));
            });
        }
        (self.reach, self.shell) = (reach, SHELL * reach.min(symmetry.reach()));
    }

    /// Takes the nodes that are listed for a facet, and their domains, for those around.
    pub fn take_listed(&mut self, sheets: &Sheets<'_>, domains: &[MaterialDomain], listed: &[Listed]) {
        self.around.clear();
        self.around.extend(listed.iter().map(|own| (own.node, sheets.domain_of(domains, own))));
        self.shell = f64::INFINITY;
    }

    /// The sheet nodes around, or their images, with their domains.
    pub fn around(&self) -> &[(u32, MaterialDomain)] {
        &self.around
    }

    /// The gathered nodes as seen from a centre, nearest first. Returns the smallest distance of the outermost ones.
    pub fn look(&mut self, centre: &Centre, symmetry: &Symmetry) -> f64 {
        let normal = symmetry.within_planes(centre.point.into(), centre.normal).normalize();
        let (t1, t2) = tangents(&normal);
        let mut outer = f64::INFINITY;
        self.nodes.clear();
        for &(node, ref domain) in &self.around {
            let position = Vector3::from(domain.position);
            let offset = position - centre.point;
            let distance = domain.length(offset);
            if (position - self.middle).norm() > self.shell {
                outer = outer.min(distance);
            }
            self.nodes.push(Near { node, offset: [offset.dot(&t1), offset.dot(&t2)], distance });
        }
        self.nodes.sort_by(|x, y| x.distance.total_cmp(&y.distance));
        outer
    }
}
