//! Nodes of the master that lie in the slave's faces between its nodes: contact over nodes does not see them.

use diffuse_contact::Point;
use diffuse_contact::surface::{Facet, MasterSurface};
use nalgebra::Vector3;
use rayon::prelude::*;

use super::tracks::twice_area_vector;

/// Of facets that touch, normals are at least as opposite as this cosine says.
const OPPOSITE: f64 = -0.5;

/// A place deeper in the faces than this part of their size is on the far side of a body rather than in it.
const FAR: f64 = 1.0;

/// The faces of a slave, as a surface that nodes of the master may lie in.
#[derive(Debug)]
pub struct SlaveFaces(MasterSurface);

impl SlaveFaces {
    /// `None` for a slave whose faces make no surface that has an inside.
    pub fn new(positions: &[Point], slave: &[Facet]) -> Option<Self> {
        MasterSurface::new(positions, slave.to_vec()).ok().map(Self)
    }

    /// How deep each node of a master lies in the faces, over their size, of those that lie in them. `size_at`: the size of the faces around
    /// a node of the slave, length.
    pub fn depths(
        &self,
        master: &MasterSurface,
        positions: &[Point],
        size_at: impl Fn(usize) -> f64 + Sync,
    ) -> Vec<f64> {
        let Self(slave) = self;
        let place = |&node: &u32| positions[node as usize];
        let margin = FAR * slave.nodes().iter().map(|&node| size_at(node as usize)).fold(0.0, f64::max);
        let [lower, upper] = bounds(slave.nodes().iter().map(place));
        let is_near =
            |x: Point| (0..3).all(|axis| (lower[axis] - margin..=upper[axis] + margin).contains(&x[axis]));
        if !master.nodes().iter().any(|node| is_near(place(node))) {
            return Vec::new();
        }
        let Ok(index) = slave.at(positions) else { return Vec::new() };
        let normals = normals(master, positions);
        let size_of = |facet: usize| {
            let facet = slave.facet(facet);
            let corners = facet.corners();
            corners.iter().map(|&node| size_at(node)).sum::<f64>() / corners.len() as f64
        };
        let depth = |(node, normal): (&u32, &Vector3<f64>)| {
            let x = place(node);
            let found = is_near(x).then(|| index.closest(x))?.filter(|found| !found.on_border)?;
            let outward = Vector3::from(index.normal(found.facet));
            let depth = -outward.dot(&(Vector3::from(x) - Vector3::from(found.point))) / size_of(found.facet);
            let is_opposite = outward.dot(normal) < OPPOSITE * normal.norm();
            (is_opposite && depth > 0.0 && depth <= FAR).then_some(depth)
        };
        master.nodes().par_iter().zip(&normals).filter_map(depth).collect()
    }
}

/// Along the normal at each node of a surface, in the order of its nodes: the facets around it count by their areas.
fn normals(surface: &MasterSurface, positions: &[Point]) -> Vec<Vector3<f64>> {
    let mut normals = vec![Vector3::zeros(); surface.nodes().len()];
    for k in 0..surface.facet_count() {
        let facet = surface.facet(k);
        let area = twice_area_vector(&facet, positions);
        for &node in facet.corners() {
            if let Ok(place) = surface.nodes().binary_search(&(node as u32)) {
                normals[place] += area;
            }
        }
    }
    normals
}

/// The box around points.
fn bounds(points: impl Iterator<Item = Point>) -> [Point; 2] {
    points.fold([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], |[lower, upper], point| {
        let by =
            |bound: Point, pick: fn(f64, f64) -> f64| [0, 1, 2].map(|axis| pick(bound[axis], point[axis]));
        [by(lower, f64::min), by(upper, f64::max)]
    })
}
