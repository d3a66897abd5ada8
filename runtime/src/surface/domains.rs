//! Domains of influence that belong to the nodes, in the first configuration (`docs/equations.md`, [T14], [T18]).
//!
//! A node takes part in the fits of all slaves whose place in the first configuration lies in its domain, an ellipsoid that stays
//! what it is there. Its axes are those of the node's cells: C_k is the mean of e eᵀ over the edges e to the nodes of its facets,
//! |U (X − X_k)| with UᵀU = C_k⁻¹/s_k² the distance from it, 1 on its border. The factors s_k are as small as the conditioning of the
//! fits allows. At each *centre* c (a node, the middle of an edge or of a facet, a point halfway
//! between these) let s(c) be the smallest factor for which the weighted design matrix of the nodes nearer than s, columns scaled to
//! length one, has no singular value below [`SMALLEST_SINGULAR_VALUE`]. s_k is the largest s(c) of all centres that the node
//! serves, and a little more. Where that makes more masters than fits need, domains shrink again ([`trim`](super::trim)).
//!
//! Which nodes a slave may need follows from its closest facet, so facets have lists of them, found once.

use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};

use rayon::prelude::*;

use super::conditioning::{Near, smallest_factor};
use super::topology::NONE;
use super::trim::trimmed;
use super::{Creases, SurfaceIndex, Symmetry, Walk};
use crate::eigen::symmetric_eigen;
use crate::vector::Vector3;
use crate::{Basis, MaterialDomain, MaterialNode, Point, Weight};

/// What the fits at the centres have to reach; 0.25 is out of reach for one-sided fits.
pub(crate) const SMALLEST_SINGULAR_VALUE: f64 = 0.13;
/// Where all nodes of a sheet are at hand, domains that reach so many times farther than the farthest weight all alike.
const WIDEST: f64 = 10.0;
/// Domains are wider than the centres ask for by this factor: slaves are elsewhere, too.
const MORE: f64 = 1.09;
/// Nodes are first sought so many extents of a facet around it.
const FIRST_REACH: f64 = 3.5;
/// The shell whose nodes say how far a search reaches, from this part of its radius on.
const SHELL: f64 = 0.75;
/// A fit at a centre takes no more nodes than this.
const MOST_NODES: usize = 400;
/// Domains are wider across the surface than along it by this factor: the place of a slave over a curved master lies off the nodes'
/// surface, the farther the larger the cells, which must not count where cells are small.
const ACROSS: f64 = 2.0;
/// The least of the two smaller axes of a node's cells over the largest.
const THINNEST: f64 = 1e-3;
/// The list of a facet holds nodes whose domains end this far from it, over the domain: a slave's place may lie as far off its
/// closest facet.
const MARGIN: f64 = 0.3;
/// Centres that one thread works on in a row.
pub(super) const CHUNK: usize = 64;

/// The domains of all nodes of a surface, and where its facets carry which basis.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NodalDomains {
    /// By place among the surface's nodes; a metric of zeros where no fit takes the node.
    domains: Vec<MaterialDomain>,
    /// Per facet the basis that the fits on it carry.
    bases: Vec<Carried>,
    /// Nodes that slaves closest to a facet may need, those of all facets one after another.
    listed: Vec<Listed>,
    /// Where the list of each facet ends.
    ends: Vec<usize>,
}

/// A node of a facet's list, or one of its images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Listed {
    pub place: u32,
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
    /// Whether what was found may depend on what is not there.
    pub is_open: bool,
    walk: Walk,
    found: Vec<(u32, f64)>,
    /// The nodes around a facet, and their images, with their cells or domains.
    around: Vec<(u32, MaterialDomain)>,
    /// How far from the middle of the facet they were sought, and how far from there the outermost of them are that say how far a
    /// search reaches.
    reach: f64,
    shell: f64,
    middle: Vector3,
    /// The same seen from a centre.
    pub nodes: Vec<Near>,
}

/// Sheets in their first configuration, of a whole surface or of a part.
#[derive(Clone, Copy)]
pub(crate) struct Sheets<'a> {
    pub index: &'a SurfaceIndex<'a>,
    pub creases: &'a Creases,
    pub symmetry: &'a Symmetry,
    /// Of a part of a surface: by place whether all facets at the node are there, and domains of it follow from the part.
    pub complete: Option<&'a [bool]>,
}

/// What the fits at the centres of some facets ask for. Of several parts the largest factors and the least bases count, in any order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Demands {
    /// By place among the nodes of the surface; 0 where no fit takes the node.
    pub factors: Vec<f64>,
    /// Of each facet of the surface.
    pub bases: Vec<Carried>,
    /// Facets whose fits may depend on what is not there.
    pub open: Vec<u32>,
}

impl Sheets<'_> {
    /// What the centres ask for that these facets look after, in parallel.
    pub fn demands(&self, cells: &[MaterialDomain], weight: Weight, basis: Basis, facets: &[u32]) -> Demands {
        let surface = self.index.surface();
        let factors: Vec<AtomicU64> = (0..surface.nodes().len()).map(|_| AtomicU64::new(0)).collect();
        let bases: Vec<AtomicU8> =
            (0..surface.facet_count()).map(|_| AtomicU8::new(Carried::Quadratic as u8)).collect();
        let of_facet = |scratch: &mut Scratch, &facet: &u32| {
            let extent = self.index.shape(facet).extent();
            scratch.is_open = false;
            scratch.gather(self, (cells, facet), FIRST_REACH * extent);
            for centre in centres(self.index, self.creases, facet) {
                let (factor, carried) = factor_at(self, (weight, basis), &centre, (cells, scratch));
                // Largest and smallest do not depend on the order in which they come; the bits of positive numbers are
                // ordered like them.
                for node in scratch.nodes.iter().filter(|node| node.distance < factor) {
                    factors[node.place as usize].fetch_max(factor.to_bits(), Ordering::Relaxed);
                }
                for &facet in centre.others.iter().chain([&centre.facet]) {
                    bases[facet as usize].fetch_min(carried as u8, Ordering::Relaxed);
                }
            }
            scratch.is_open.then_some(facet)
        };
        let open: Vec<Option<u32>> =
            facets.par_iter().with_min_len(CHUNK).map_init(Scratch::default, of_facet).collect();
        Demands {
            factors: factors.into_iter().map(|bits| f64::from_bits(bits.into_inner())).collect(),
            bases: bases.into_iter().map(|carried| Carried::of(carried.into_inner())).collect(),
            open: open.into_iter().flatten().collect(),
        }
    }

    /// Per node its position and the metric of its cells.
    pub fn cells(&self) -> Vec<MaterialDomain> {
        cells(self.index, self.symmetry)
    }

    /// The lists of these facets, and those of them whose list may depend on what is not there.
    pub fn lists(&self, domains: &[MaterialDomain], facets: &[u32]) -> (Vec<Vec<Listed>>, Vec<u32>) {
        let extents: Vec<f64> = domains.par_iter().map(MaterialDomain::extent).collect();
        let lists: Vec<(Vec<Listed>, bool)> = facets
            .par_iter()
            .with_min_len(CHUNK)
            .map_init(Scratch::default, |scratch, &facet| {
                scratch.is_open = false;
                (list(self, (domains, &extents), facet, scratch), scratch.is_open)
            })
            .collect();
        let open = facets.iter().zip(&lists).filter(|(_, list)| list.1).map(|(facet, _)| *facet).collect();
        (lists.into_iter().map(|list| list.0).collect(), open)
    }

    /// Whether nodes that a walk has found may not be all, or not what they are.
    fn is_open(&self, walk: &Walk, found: &[(u32, f64)]) -> bool {
        self.complete.is_some_and(|complete| {
            walk.met_cut() || found.iter().any(|&(place, _)| !complete[place as usize])
        })
    }
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
        let sheets = Sheets { index, creases, symmetry, complete: None };
        let cells = sheets.cells();
        let facets: Vec<u32> = (0..index.surface().facet_count() as u32).collect();
        let Demands { factors, bases, .. } = sheets.demands(&cells, weight, basis, &facets);
        let domains = grown(&cells, &factors);
        let crowded = sheets.crowded(&domains, &facets);
        let ratios = sheets.ratios(&domains, (&bases, weight), &facets, |place| crowded[place]);
        let domains = trimmed(&domains, &ratios);
        let (lists, _) = sheets.lists(&domains, &facets);
        Self::given(domains, bases, &lists)
    }

    /// With domains by place, and bases and lists by facet.
    pub fn given(domains: Vec<MaterialDomain>, bases: Vec<Carried>, lists: &[Vec<Listed>]) -> Self {
        let ends = lists
            .iter()
            .scan(0, |end, list| {
                *end += list.len();
                Some(*end)
            })
            .collect();
        Self { domains, bases, listed: lists.concat(), ends }
    }

    /// Whether lists name no image from this number on; else the place of one that does among those listed.
    pub fn check_images(&self, count: u32) -> Result<(), usize> {
        let is_image = |listed: &Listed| listed.image == NONE || listed.image < count;
        self.listed.iter().position(|listed| !is_image(listed)).map_or(Ok(()), Err)
    }

    /// That of the node at a place.
    pub fn domain(&self, place: usize) -> &MaterialDomain {
        &self.domains[place]
    }

    /// First positions of the surface's nodes, by place.
    pub fn positions(&self) -> impl ExactSizeIterator<Item = Point> {
        self.domains.iter().map(|domain| domain.position)
    }

    /// The nodes that a slave may need whose closest facet this is, ascending by place, a node before its images.
    pub fn listed(&self, facet: u32) -> &[Listed] {
        let start = (facet as usize).checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.listed[start..self.ends[facet as usize]]
    }

    /// Whether a slave whose closest facet this is may need the node at a place, or an image of it.
    pub fn lists(&self, facet: u32, place: u32) -> bool {
        self.listed(facet).binary_search_by_key(&place, |listed| listed.place).is_ok()
    }

    /// What the nodes around a facet carry.
    pub fn carried(&self, facet: u32) -> Carried {
        self.bases[facet as usize]
    }
}

/// The domains of cells with these factors; a metric of zeros where no fit takes the node.
pub(crate) fn grown(cells: &[MaterialDomain], factors: &[f64]) -> Vec<MaterialDomain> {
    factors.iter().zip(cells).map(|(factor, domain)| domain.times(MORE * factor)).collect()
}

impl Symmetry {
    /// The domain of a node's image.
    pub fn domain_of(&self, number: u32, domain: &MaterialDomain) -> MaterialDomain {
        let image = self.image(number);
        MaterialDomain {
            position: image.of(domain.position),
            metric: triangle(turned(gram(&domain.metric), &image.rows)),
        }
    }
}

/// UᵀU
fn gram(&[xx, xy, xz, yy, yz, zz]: &[f64; 6]) -> [[f64; 3]; 3] {
    let rows = [[xx, xy, xz], [0.0, yy, yz], [0.0, 0.0, zz]];
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| rows.iter().map(|row| row[i] * row[j]).sum()))
}

/// Q M Qᵀ
fn turned(matrix: [[f64; 3]; 3], rows: &[Point; 3]) -> [[f64; 3]; 3] {
    let entry = |i: usize, j: usize| -> f64 {
        (0..3).map(|k| (0..3).map(|l| rows[i][k] * matrix[k][l] * rows[j][l]).sum::<f64>()).sum()
    };
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j)))
}

/// U of a positive definite UᵀU; zeros of zeros.
fn triangle(m: [[f64; 3]; 3]) -> [f64; 6] {
    if m[0][0] == 0.0 {
        return [0.0; 6];
    }
    let xx = m[0][0].sqrt();
    let (xy, xz) = (m[0][1] / xx, m[0][2] / xx);
    let yy = (m[1][1] - xy * xy).sqrt();
    let yz = (m[1][2] - xy * xz) / yy;
    [xx, xy, xz, yy, yz, (m[2][2] - xz * xz - yz * yz).sqrt()]
}

/// Per node its position and the metric of its cells.
fn cells(index: &SurfaceIndex<'_>, symmetry: &Symmetry) -> Vec<MaterialDomain> {
    let surface = index.surface();
    let positions = index.positions();
    (0..surface.nodes().len())
        .into_par_iter()
        .map(|place| {
            let position = positions[place];
            let own = Vector3::from(position);
            let mut others: Vec<u32> = surface
                .facets_of_place(place)
                .iter()
                .flat_map(|&facet| surface.corners_of(facet as usize))
                .copied()
                .filter(|&other| other as usize != place)
                .collect();
            others.sort_unstable();
            others.dedup();
            // In planes of symmetry cells go on as their images.
            let mut ends: Vec<Vector3> =
                others.iter().map(|&other| positions[other as usize].into()).collect();
            let near = symmetry.tolerance() * symmetry.tolerance();
            for image in symmetry.images_at(position) {
                for &other in &others {
                    let end = Vector3::from(image.of(positions[other as usize]));
                    if ends.iter().all(|known| (*known - end).norm_squared() > near) {
                        ends.push(end);
                    }
                }
            }
            let mut mean = [[0.0; 3]; 3];
            for end in &ends {
                let edge = *end - own;
                for i in 0..3 {
                    for j in 0..3 {
                        mean[i][j] += edge[i] * edge[j] / ends.len() as f64;
                    }
                }
            }
            MaterialDomain { position, metric: metric_of(mean) }
        })
        .collect()
}

/// U with UᵀU = C⁻¹ for the moment C of edges, whose smallest principal value, across the surface, is replaced: its root becomes
/// [`ACROSS`] that of the middle one.
fn metric_of(moment: [[f64; 3]; 3]) -> [f64; 6] {
    let [(_, across), (middle, along), (largest, farthest)] = symmetric_eigen(moment);
    let middle = middle.max(THINNEST * THINNEST * largest);
    let axes = [(ACROSS * ACROSS * middle, across), (middle, along), (largest, farthest)];
    let entry = |i: usize, j: usize| axes.iter().map(|(value, axis)| axis[i] * axis[j] / value).sum();
    triangle([0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j))))
}

impl MaterialDomain {
    /// The domain of cells times a factor; a metric of zeros if that is 0.
    pub(super) fn times(&self, factor: f64) -> Self {
        let scale = if factor > 0.0 { 1.0 / factor } else { 0.0 };
        Self { position: self.position, metric: self.metric.map(|entry| entry * scale) }
    }

    /// |U v|
    pub(crate) fn length(&self, v: Vector3) -> f64 {
        MaterialNode { offset: v.into(), metric: self.metric }.distance()
    }

    /// Whether a point lies in the domain.
    pub(super) fn reaches(&self, point: Vector3) -> bool {
        self.length(Vector3::from(self.position) - point) < 1.0
    }

    /// The shortest half axis.
    pub(crate) fn shortest(&self) -> f64 {
        let [_, _, (largest, _)] = symmetric_eigen(gram(&self.metric));
        1.0 / largest.sqrt()
    }

    /// The longest half axis; 0 of no domain.
    pub(super) fn extent(&self) -> f64 {
        let [(smallest, _), _, _] = symmetric_eigen(gram(&self.metric));
        if smallest > 0.0 { 1.0 / smallest.sqrt() } else { 0.0 }
    }
}

/// The nodes of the facet's sheet whose domains, with a margin, reach it, and their images.
fn list(
    sheets: &Sheets<'_>,
    (domains, extents): (&[MaterialDomain], &[f64]),
    facet: u32,
    scratch: &mut Scratch,
) -> Vec<Listed> {
    let Sheets { index, creases, symmetry, .. } = *sheets;
    let Scratch { walk, found, is_open, .. } = scratch;
    let shape = index.shape(facet);
    let corners = shape.corners();
    let middle = corners.iter().copied().sum::<Vector3>() / corners.len() as f64;
    let reaches = |domain: &MaterialDomain| {
        let reach = corners
            .iter()
            .map(|&corner| domain.length(corner - middle))
            .fold(1.0 + MARGIN, |reach, x| reach.max(1.0 + MARGIN + x));
        domain.metric[0] > 0.0 && domain.length(Vector3::from(domain.position) - middle) < reach
    };
    // A domain that reaches the facet from afar is long: walks go on while they meet such.
    let mut reach = shape.extent();
    loop {
        walk.start(index, facet, middle.into());
        walk.nodes_within(index, creases, reach, found);
        *is_open |= sheets.is_open(walk, found);
        let longest = found.iter().map(|&(place, _)| extents[place as usize]).fold(0.0, f64::max);
        let needed = (1.0 + MARGIN) * longest + shape.extent();
        if needed <= reach {
            break;
        }
        reach = needed;
    }
    let mut all = Vec::new();
    for &(place, _) in &*found {
        let domain = &domains[place as usize];
        if reaches(domain) {
            all.push(Listed { place, image: NONE });
        }
        symmetry.images_near(domain.position, middle.into(), reach, |image, _| {
            if reaches(&symmetry.domain_of(image, domain)) {
                all.push(Listed { place, image });
            }
        });
    }
    all
}

/// The centres that a facet looks after: its middle and quarter points and, of the corners and edges that it shares with facets of
/// its sheet, those of which it has the lowest number.
fn centres(index: &SurfaceIndex<'_>, creases: &Creases, facet: u32) -> Vec<Centre> {
    let shape = index.shape(facet);
    let corners = shape.corners();
    let normal = index.normals()[facet as usize];
    let own = |point| Centre { point, normal, facet, others: Vec::new() };
    let middle = corners.iter().copied().sum::<Vector3>() / corners.len() as f64;
    let mut all = vec![own(middle)];
    all.extend(corners.iter().map(|&corner| own((corner + middle) / 2.0)));
    let between = (0..corners.len()).map(|edge| shape.edge(edge));
    all.extend(between.map(|[from, to]| own(((from + to) / 2.0 + middle) / 2.0)));
    for (edge, &other) in index.surface().across(facet as usize).iter().enumerate() {
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
    for (&point, &place) in corners.iter().zip(index.surface().corners_of(facet as usize)) {
        let fan = fan(index, creases, facet, place);
        if fan.iter().all(|&other| facet <= other) {
            let normal =
                fan.iter().map(|&other| index.normals()[other as usize]).sum::<Vector3>().normalize();
            all.push(Centre { point, normal, facet, others: fan });
        }
    }
    all
}

/// The facets at a corner of `facet` that are reached over edges there which do not end the sheet.
pub(super) fn fan(index: &SurfaceIndex<'_>, creases: &Creases, facet: u32, corner: u32) -> Vec<u32> {
    let mut fan = vec![facet];
    let mut next = 0;
    while let Some(&facet) = fan.get(next) {
        next += 1;
        for (edge, &other) in index.surface().across(facet as usize).iter().enumerate() {
            let is_end = other == NONE || creases.ends_at(facet as usize, edge) || fan.contains(&other);
            if !is_end && index.surface().corners_of(other as usize).contains(&corner) {
                fan.push(other);
            }
        }
    }
    fan
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
        let is_all = count == last;
        for &carried in wanted {
            let largest =
                if carried == Carried::Quadratic || is_all || count > MOST_NODES { complete } else { 0.0 };
            let widest = scratch.nodes.last().map_or(0.0, |farthest| WIDEST * farthest.distance);
            let largest = if is_all && sheets.symmetry.is_none() { widest } else { largest.min(widest) };
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
        let Sheets { index, creases, symmetry, .. } = *sheets;
        let shape = index.shape(facet);
        let corners = shape.corners();
        self.middle = corners.iter().copied().sum::<Vector3>() / corners.len() as f64;
        let from = Point::from(self.middle);
        self.walk.start(index, facet, from);
        self.walk.nodes_within(index, creases, reach, &mut self.found);
        self.is_open |= sheets.is_open(&self.walk, &self.found);
        self.around.clear();
        for &(place, _) in &self.found {
            let domain = &cells[place as usize];
            self.around.push((place, *domain));
            symmetry.images_near(domain.position, from, reach, |image, _| {
                self.around.push((place, symmetry.domain_of(image, domain)));
            });
        }
        (self.reach, self.shell) = (reach, SHELL * reach.min(symmetry.reach()));
    }

    /// Takes the nodes that are listed for a facet, and their domains, for those around.
    pub fn take_listed(
        &mut self,
        sheets: &Sheets<'_>,
        (domains, extents): (&[MaterialDomain], &[f64]),
        facet: u32,
    ) {
        let listed = list(sheets, (domains, extents), facet, self);
        self.around.clear();
        self.around.extend(listed.iter().map(|own| {
            let domain = &domains[own.place as usize];
            let is_image = own.image != NONE;
            (own.place, if is_image { sheets.symmetry.domain_of(own.image, domain) } else { *domain })
        }));
        self.shell = f64::INFINITY;
    }

    /// The nodes around, or their images, with their domains.
    pub fn around(&self) -> &[(u32, MaterialDomain)] {
        &self.around
    }

    /// The gathered nodes as seen from a centre, nearest first. Returns the smallest distance of the outermost ones.
    pub fn look(&mut self, centre: &Centre, symmetry: &Symmetry) -> f64 {
        let normal = symmetry.within_planes(centre.point.into(), centre.normal).normalize();
        let axis = Vector3::axis(normal.smallest_axis());
        let t1 = (axis - normal * normal.dot(&axis)).normalize();
        let t2 = normal.cross(&t1);
        let mut outer = f64::INFINITY;
        self.nodes.clear();
        for (place, domain) in &self.around {
            let position = Vector3::from(domain.position);
            let offset = position - centre.point;
            let distance = domain.length(offset);
            if (position - self.middle).norm() > self.shell {
                outer = outer.min(distance);
            }
            let [xx, yy, both] = [t1, t2, t1 + t2].map(|axis| domain.length(axis).powi(2));
            let cells = [xx, 0.5 * (both - xx - yy), yy].map(|entry| entry / (xx + yy));
            self.nodes.push(Near {
                place: *place,
                offset: [offset.dot(&t1), offset.dot(&t2)],
                cells,
                distance,
            });
        }
        self.nodes.sort_by(|x, y| x.distance.total_cmp(&y.distance));
        outer
    }
}
