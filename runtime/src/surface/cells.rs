//! The cells of nodes in the first configuration, as metrics; and domains as multiples of them.

use rayon::prelude::*;

use super::auxiliary::{Auxiliary, AuxiliaryKind};
use super::sheets::Sheets;
use super::sort;
use super::symmetry::Symmetry;
use crate::eigen::symmetric_eigen;
use crate::vector::Vector3;
use crate::{MaterialDomain, MaterialNode, Point};

/// Domains are wider across the surface than along it by this factor: the place of a slave over a curved master lies off the nodes'
/// surface, the farther the larger the cells, which must not count where cells are small.
const ACROSS: f64 = 2.0;
/// The least of the two smaller axes of a node's cells over the largest.
const THINNEST: f64 = 1e-3;

impl Sheets<'_> {
    /// Per sheet node its position and the metric of its cells, and after them those of auxiliary points.
    pub fn cells(&self) -> Vec<MaterialDomain> {
        let Sheets { index, nodes, symmetry, .. } = *self;
        let surface = index.surface();
        let positions = index.positions();
        let mut on_rungs: Vec<u32> = nodes.auxiliary().iter().flat_map(|point| point.ends).collect();
        on_rungs.sort_unstable();
        let cells = (0..nodes.places().len() as u32)
            .into_par_iter()
            .map(|node| {
                let place = nodes.place(node);
                let position = positions[place];
                let own = Vector3::from(position);
                let mut others: Vec<u32> = nodes
                    .facets(surface, node)
                    .flat_map(|facet| surface.corners_of(facet as usize))
                    .copied()
                    .filter(|&other| other as usize != place)
                    .collect();
                sort(&mut others);
                let mut ends: Vec<Vector3> =
                    others.iter().map(|&other| positions[other as usize].into()).collect();
                // A narrow strip goes on to its ghost nodes.
                let of_facet = |facet| {
                    let edges = 0..nodes.of_edges(facet).len();
                    edges.flat_map(move |edge| nodes.points_of_edge(surface, facet, edge))
                };
                let points = nodes.facets(surface, node).flat_map(of_facet);
                let mut ghosts: Vec<Auxiliary> = points
                    .map(|(_, point)| point)
                    .filter(|point| point.kind != AuxiliaryKind::Middle)
                    .collect();
                sort(&mut ghosts);
                let of_ends = |point: &Auxiliary| point.ends.map(|end| positions[nodes.place(end)]);
                ends.extend(ghosts.iter().map(|point| Vector3::from(point.position(of_ends(point)))));
                // In planes of symmetry cells go on as their images.
                let near = symmetry.tolerance() * symmetry.tolerance();
                let count = ends.len();
                for image in symmetry.images_at(position) {
                    for other in 0..count {
                        let end = Vector3::from(image.of(ends[other].into()));
                        if ends.iter().all(|known| (*known - end).norm_squared() > near) {
                            ends.push(end);
                        }
                    }
                }
                // Around a bend neighbours may lie lower than a strip is wide: its cells are seen along the normal.
                let normal = on_rungs.binary_search(&node).is_ok().then(|| {
                    let normals = nodes.facets(surface, node).map(|facet| index.normals()[facet as usize]);
                    symmetry.within_planes(position, normals.sum()).normalize()
                });
                let mut mean = [[0.0; 3]; 3];
                for end in &ends {
                    let edge = *end - own;
                    let edge = normal.map_or(edge, |normal| edge - normal * normal.dot(&edge));
                    for i in 0..3 {
                        for j in 0..3 {
                            mean[i][j] += edge[i] * edge[j] / ends.len() as f64;
                        }
                    }
                }
                MaterialDomain { position, metric: metric_of(mean) }
            })
            .collect();
        with_auxiliary(cells, nodes.auxiliary())
    }
}

/// The domains of sheet nodes, followed by those of auxiliary points: whatever is within both ends' domains, seen from the same distance, is
/// within the point's.
pub(crate) fn with_auxiliary(
    mut domains: Vec<MaterialDomain>,
    auxiliary: &[Auxiliary],
) -> Vec<MaterialDomain> {
    let own = |point: &Auxiliary| point.domain(point.ends.map(|end| domains[end as usize]));
    let own: Vec<MaterialDomain> = auxiliary.iter().map(own).collect();
    domains.extend(own);
    domains
}

impl Auxiliary {
    /// Its domain, from those of its ends: the mean of the matrices C of both ellipsoids. None without one of either.
    fn domain(&self, ends: [MaterialDomain; 2]) -> MaterialDomain {
        let position = self.position(ends.map(|end| end.position));
        let are_there = ends.iter().all(|end| end.metric[0] > 0.0);
        let mean = are_there.then(|| {
            let [one, two] = ends.map(|end| end.ellipsoid());
            [0, 1, 2].map(|i| [0, 1, 2].map(|j| 0.5 * (one[i][j] + two[i][j])))
        });
        let domain = mean.and_then(|squares| MaterialDomain::of_ellipsoid(position, squares));
        domain.unwrap_or(MaterialDomain { position, metric: [0.0; 6] })
    }
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
