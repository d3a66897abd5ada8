//! Domains of influence that belong to the nodes (`docs/equations.md`, [T14]).
//!
//! A node takes part in the fits of all slaves within its radius R_k, which stays what it is while the surface moves. The
//! radii are as small as the conditioning of the fits allows. Each is a multiple s_k of the size h_k of the cells around the
//! node, so that a coarse region does not widen the domains of a fine one beside it. At each *centre* c (a node, the middle of an
//! edge or of a facet; where cells change size also the quarter points of the facet) let s(c) be the smallest multiple for which the
//! weighted design matrix of the nodes with |x_k − c| < s h_k, columns scaled to length one, has no singular value below
//! [`SMALLEST_SINGULAR_VALUE`]. s_k is the largest s(c) of all centres that the node serves, |x_k − c| < s(c) h_k.

use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};

use rayon::prelude::*;

use super::topology::NONE;
use super::{Creases, SurfaceIndex, Symmetry, Walk};
use crate::vector::Vector3;
use crate::{Basis, Point, Weight};

/// What the fits at the centres have to reach; 0.25 is out of reach for one-sided fits.
pub(crate) const SMALLEST_SINGULAR_VALUE: f64 = 0.15;
/// Facets that differ in size from a neighbour by more than this factor have centres at their quarter points, too.
const ABRUPT: f64 = 1.5;
/// Radii are tried in steps of this factor, then halved in between so many times.
const STEP: f64 = 1.04;
const BISECTIONS: usize = 8;
/// A fit at a centre takes no more nodes than this.
const MOST_NODES: usize = 120;
/// Centres that one thread works on in a row.
const CHUNK: usize = 64;

/// The radii of all nodes of a surface, and where its facets carry which basis.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NodalDomains {
    /// R_k by place among the surface's nodes, length; 0 where no fit takes the node.
    radii: Vec<f64>,
    /// Per facet the basis that the fits on it carry.
    bases: Vec<Carried>,
    /// Per node the mean distance to the corners of its facets when the radii were found.
    spacing: Vec<f64>,
    largest: f64,
}

/// What the nodes around a facet carry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Carried {
    Nothing,
    Linear,
    Quadratic,
}

impl Carried {
    const fn of(number: u8) -> Self {
        match number {
            0 => Self::Nothing,
            1 => Self::Linear,
            _ => Self::Quadratic,
        }
    }
}

/// Where a fit is looked at.
struct Centre {
    point: Vector3,
    normal: Vector3,
    /// A facet around it, and the others.
    facet: u32,
    others: Vec<u32>,
}

/// Memory of one thread.
#[derive(Default)]
struct Scratch {
    walk: Walk,
    found: Vec<(u32, f64)>,
    nodes: Vec<Near>,
}

/// A node, or an image of one, seen from a centre.
#[derive(Clone, Copy)]
struct Near {
    place: u32,
    /// In the plane of the centre, length.
    offset: [f64; 2],
    /// Distance in that plane over the size of the cells around the node.
    distance: f64,
    /// Square of the distance in space over that of the size.
    square: f64,
}

impl NodalDomains {
    /// The radii for this surface as it is, in parallel; the same for any number of threads.
    pub fn new(
        index: &SurfaceIndex<'_>,
        creases: &Creases,
        symmetry: &Symmetry,
        weight: Weight,
        basis: Basis,
    ) -> Self {
        let surface = index.surface();
        let sizes = cell_sizes(index);
        let multiples: Vec<AtomicU64> = (0..surface.nodes().len()).map(|_| AtomicU64::new(0)).collect();
        let bases: Vec<AtomicU8> =
            (0..surface.facet_count()).map(|_| AtomicU8::new(Carried::Quadratic as u8)).collect();
        let facets: Vec<u32> = (0..surface.facet_count() as u32).collect();
        facets.par_chunks(CHUNK).for_each(|facets| {
            let mut scratch = Scratch::default();
            for centre in facets.iter().flat_map(|&facet| centres(index, creases, facet)) {
                let (multiple, carried) =
                    multiple_at(index, creases, symmetry, (weight, basis), &centre, (&sizes, &mut scratch));
                // Largest and smallest do not depend on the order in which they come; the bits of positive numbers are
                // ordered like them.
                for node in scratch.nodes.iter().filter(|node| node.square < multiple * multiple) {
                    multiples[node.place as usize].fetch_max(multiple.to_bits(), Ordering::Relaxed);
                }
                for &facet in centre.others.iter().chain([&centre.facet]) {
                    bases[facet as usize].fetch_min(carried as u8, Ordering::Relaxed);
                }
            }
        });
        let bases = bases.into_iter().map(|carried| Carried::of(carried.into_inner())).collect();
        let multiples = multiples.into_iter().map(|bits| f64::from_bits(bits.into_inner()));
        let radii: Vec<f64> = multiples.zip(&sizes).map(|(multiple, size)| multiple * size).collect();
        let largest = radii.iter().copied().fold(0.0, f64::max);
        Self { radii, bases, spacing: spacing(index), largest }
    }

    /// R_k of the node at a place, length.
    pub fn radius(&self, place: usize) -> f64 {
        self.radii[place]
    }

    /// The largest of all.
    pub const fn largest(&self) -> f64 {
        self.largest
    }

    /// The smallest of all, of nodes that fits take.
    pub fn smallest(&self) -> f64 {
        self.radii.iter().copied().filter(|&radius| radius > 0.0).fold(f64::INFINITY, f64::min)
    }

    /// The largest at the corners of a facet.
    pub fn around(&self, index: &SurfaceIndex<'_>, facet: u32) -> f64 {
        let corners = index.surface().corners_of(facet as usize).iter();
        corners.map(|&place| self.radii[place as usize]).fold(0.0, f64::max)
    }

    /// What the nodes around a facet carry.
    pub fn carried(&self, facet: u32) -> Carried {
        self.bases[facet as usize]
    }

    /// The largest change of a node's spacing since the radii were found: 0.1 if it has grown or shrunk by a tenth.
    pub fn stretch(&self, index: &SurfaceIndex<'_>) -> f64 {
        let now = spacing(index);
        let change =
            |(now, then): (&f64, &f64)| if *then > 0.0 { (now / then).ln().abs().exp() - 1.0 } else { 0.0 };
        now.iter().zip(&self.spacing).map(change).fold(0.0, f64::max)
    }
}

/// Per node the root of the mean area of its facets, triangles counting twice: the side of square cells.
fn cell_sizes(index: &SurfaceIndex<'_>) -> Vec<f64> {
    let surface = index.surface();
    let area = |&facet: &u32| {
        let shape = index.shape(facet);
        shape.area_vector().norm() * if shape.corners().len() == 3 { 2.0 } else { 1.0 }
    };
    (0..surface.nodes().len())
        .into_par_iter()
        .map(|place| {
            let facets = surface.facets_of_place(place);
            (facets.iter().map(area).sum::<f64>() / facets.len() as f64).sqrt()
        })
        .collect()
}

/// Per node the mean distance to the corners of its facets.
fn spacing(index: &SurfaceIndex<'_>) -> Vec<f64> {
    let surface = index.surface();
    let positions = index.positions();
    (0..surface.nodes().len())
        .into_par_iter()
        .map(|place| {
            let own = Vector3::from(positions[place]);
            let (mut total, mut count) = (0.0, 0.0);
            for &facet in surface.facets_of_place(place) {
                for &other in surface.corners_of(facet as usize) {
                    if other as usize != place {
                        total += (Vector3::from(positions[other as usize]) - own).norm();
                        count += 1.0;
                    }
                }
            }
            if count > 0.0 { total / count } else { 0.0 }
        })
        .collect()
}

/// The centres that a facet looks after: its middle and, of the corners and the middles of edges that it shares with facets of
/// its sheet, those of which it has the lowest number.
fn centres(index: &SurfaceIndex<'_>, creases: &Creases, facet: u32) -> Vec<Centre> {
    let shape = index.shape(facet);
    let corners = shape.corners();
    let normal = index.normals()[facet as usize];
    let own = |point| Centre { point, normal, facet, others: Vec::new() };
    let middle = corners.iter().copied().sum::<Vector3>() / corners.len() as f64;
    let mut all = vec![own(middle)];
    let mut is_abrupt = false;
    for (edge, &other) in index.surface().across(facet as usize).iter().enumerate() {
        let [from, to] = shape.edge(edge);
        let centre = own((from + to) / 2.0);
        if other == NONE || creases.ends_at(facet as usize, edge) {
            all.push(centre);
            continue;
        }
        if facet < other {
            let normal = (normal + index.normals()[other as usize]).normalize();
            all.push(Centre { normal, others: vec![other], ..centre });
        }
        let ratio = index.shape(other).area_vector().norm() / shape.area_vector().norm();
        is_abrupt |= !(ratio.max(1.0 / ratio) <= ABRUPT);
    }
    for (&point, &place) in corners.iter().zip(index.surface().corners_of(facet as usize)) {
        let fan = fan(index, creases, facet, place);
        if fan.iter().all(|&other| facet <= other) {
            let normal =
                fan.iter().map(|&other| index.normals()[other as usize]).sum::<Vector3>().normalize();
            all.push(Centre { point, normal, facet, others: fan });
        }
    }
    if is_abrupt {
        all.extend(corners.iter().map(|&corner| own((corner + middle) / 2.0)));
    }
    all
}

/// The facets at a corner of `facet` that are reached over edges there which do not end the sheet.
fn fan(index: &SurfaceIndex<'_>, creases: &Creases, facet: u32, corner: u32) -> Vec<u32> {
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
fn multiple_at(
    index: &SurfaceIndex<'_>,
    creases: &Creases,
    symmetry: &Symmetry,
    (weight, basis): (Weight, Basis),
    centre: &Centre,
    (sizes, scratch): (&[f64], &mut Scratch),
) -> (f64, Carried) {
    let mut reach = 3.0 * index.shape(centre.facet).extent();
    let mut last = usize::MAX;
    let wanted =
        if basis == Basis::Linear { &[Carried::Linear][..] } else { &[Carried::Quadratic, Carried::Linear] };
    loop {
        gather(index, creases, symmetry, centre, reach, (sizes, scratch));
        let count = scratch.nodes.len();
        let is_all = count == last;
        for &carried in wanted {
            // Beyond this a node that is not among those gathered might be within reach.
            let coarsest = scratch.nodes.iter().map(|node| sizes[node.place as usize]).fold(0.0, f64::max);
            let reach = reach.min(symmetry.reach()) / coarsest;
            let largest =
                if carried == Carried::Quadratic || is_all || count > MOST_NODES { reach } else { 0.0 };
            if let Some(multiple) = smallest_multiple(&scratch.nodes, weight, carried, largest) {
                return (multiple, carried);
            }
        }
        if is_all || count > MOST_NODES {
            return (0.0, Carried::Nothing);
        }
        last = count;
        reach *= 1.5;
    }
}

/// The nodes of the centre's sheet within reach, with their images, nearest first.
fn gather(
    index: &SurfaceIndex<'_>,
    creases: &Creases,
    symmetry: &Symmetry,
    centre: &Centre,
    reach: f64,
    (sizes, scratch): (&[f64], &mut Scratch),
) {
    let Scratch { walk, found, nodes } = scratch;
    let from = Point::from(centre.point);
    walk.start(index, centre.facet, from);
    walk.nodes_within(index, creases, reach, found);
    let normal = symmetry.within_planes(from, centre.normal).normalize();
    let axis = Vector3::axis(normal.smallest_axis());
    let t1 = (axis - normal * normal.dot(&axis)).normalize();
    let t2 = normal.cross(&t1);
    nodes.clear();
    let mut push = |place: u32, x: Point| {
        let offset = Vector3::from(x) - centre.point;
        let in_plane = [offset.dot(&t1), offset.dot(&t2)];
        let size = sizes[place as usize];
        let distance = in_plane[0].hypot(in_plane[1]) / size;
        nodes.push(Near { place, offset: in_plane, distance, square: offset.norm_squared() / (size * size) });
    };
    for &(place, _) in &*found {
        let x = index.positions()[place as usize];
        push(place, x);
        symmetry.images_near(x, from, reach, |_, image| push(place, image));
    }
    nodes.sort_by(|x, y| x.distance.total_cmp(&y.distance));
}

/// The smallest multiple up to `largest` for which the nodes within reach carry the basis.
fn smallest_multiple(nodes: &[Near], weight: Weight, carried: Carried, largest: f64) -> Option<f64> {
    let size = match carried {
        Carried::Quadratic => 6,
        Carried::Linear => 3,
        Carried::Nothing => return None,
    };
    // Images in a plane along the surface stand above one another: steps from zero would lead nowhere.
    let first = nodes.get(size - 1..)?.iter().map(|node| node.distance).find(|x| x.is_normal())?;
    let is_enough = |multiple: f64| is_well_conditioned(nodes, weight, size, multiple);
    let (mut below, mut multiple) = (first, first * STEP);
    while !is_enough(multiple) {
        below = multiple;
        multiple *= STEP;
        if !(multiple <= largest) {
            return None;
        }
    }
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (below + multiple);
        if is_enough(middle) { multiple = middle } else { below = middle }
    }
    (multiple <= largest).then_some(multiple)
}

/// Whether no singular value of the weighted design matrix, columns scaled to length one, is below
/// [`SMALLEST_SINGULAR_VALUE`]: whether its Gram matrix less the square of that on the diagonal is positive definite.
fn is_well_conditioned(nodes: &[Near], weight: Weight, size: usize, multiple: f64) -> bool {
    // Columns are scaled in the end: this is for their powers.
    let unit = nodes.last().map_or(1.0, |node| node.offset[0].abs().max(node.offset[1].abs()));
    let mut gram = [[0.0; 6]; 6];
    for node in nodes.iter().take_while(|node| node.distance < multiple) {
        let [a, b] = node.offset.map(|x| x / unit);
        let w = weight.fitting(node.distance / multiple);
        let p = [1.0, a, b, a * a, a * b, b * b];
        for i in 0..size {
            let weighted = w * p[i];
            for j in 0..=i {
                gram[i][j] += weighted * p[j];
            }
        }
    }
    let lengths: [f64; 6] = std::array::from_fn(|k| gram[k][k].sqrt());
    for i in 0..size {
        for j in 0..=i {
            let mut entry = gram[i][j] / (lengths[i] * lengths[j]);
            if i == j {
                entry -= SMALLEST_SINGULAR_VALUE * SMALLEST_SINGULAR_VALUE;
            }
            for k in 0..j {
                entry -= gram[i][k] * gram[j][k];
            }
            // The factor overwrites the matrix row by row; a row reads factors of earlier columns only.
            gram[i][j] = if i == j {
                if !(entry > 0.0) {
                    return false;
                }
                entry.sqrt()
            } else {
                entry / gram[j][j]
            };
        }
    }
    true
}
