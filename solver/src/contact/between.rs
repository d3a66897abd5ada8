//! Nodes of the master that lie in the slave's faces between its nodes: contact over nodes does not see them.

use diffuse_contact::Point;
use diffuse_contact::surface::{Facet, MasterSurface};
use nalgebra::Vector3;
use rayon::prelude::*;

/// Of facets that touch, normals are at least as opposite as this cosine says.
const OPPOSITE: f64 = -0.5;

/// A place deeper in the faces than this part of their size is on the far side of a body rather than in it.
const FAR: f64 = 1.0;

/// The surface of the slave, as one that nodes of the master may lie in.
#[derive(Debug)]
pub struct Between {
    slave: MasterSurface,
    master: MasterSurface,
}

impl Between {
    /// `None` for a slave whose facets make no surface that has an inside.
    pub fn new(positions: &[Point], slave: &[Facet], master: &MasterSurface) -> Option<Self> {
        let slave = MasterSurface::new(positions, slave.to_vec()).ok()?;
        Some(Self { slave, master: master.clone() })
    }

    /// How deep each node of the master lies in the slave's faces, over their size, of those that lie in them. `size_at`: the size of the
    /// facets around a node of the slave, length.
    pub fn depths(&self, positions: &[Point], size_at: impl Fn(usize) -> f64 + Sync) -> Vec<f64> {
        let (Ok(slave), Ok(master)) = (self.slave.at(positions), self.master.at(positions)) else {
            return Vec::new();
        };
        let mut normals = vec![Vector3::zeros(); positions.len()];
        for k in 0..self.master.facet_count() {
            let normal = Vector3::from(master.normal(k));
            self.master.facet(k).corners().iter().for_each(|&node| normals[node] += normal);
        }
        let [lower, upper] = bounds(slave.positions());
        let margin = FAR * self.slave.nodes().iter().map(|&node| size_at(node as usize)).fold(0.0, f64::max);
        let size_of = |facet: usize| {
            let facet = self.slave.facet(facet);
            let corners = facet.corners();
            corners.iter().map(|&node| size_at(node)).sum::<f64>() / corners.len() as f64
        };
        let depth = |&node: &u32| {
            let (x, normal) = (positions[node as usize], normals[node as usize]);
            let is_near = |axis: usize| (lower[axis] - margin..=upper[axis] + margin).contains(&x[axis]);
            if !(0..3).all(is_near) {
                return None;
            }
            let found = slave.closest(x).filter(|found| !found.on_border)?;
            let outward = Vector3::from(slave.normal(found.facet));
            let depth = -outward.dot(&(Vector3::from(x) - Vector3::from(found.point))) / size_of(found.facet);
            let is_opposite = outward.dot(&normal) < OPPOSITE * normal.norm();
            (is_opposite && depth > 0.0 && depth <= FAR).then_some(depth)
        };
        self.master.nodes().par_iter().filter_map(depth).collect()
    }
}

/// The box around points.
fn bounds(points: &[Point]) -> [Point; 2] {
    points.iter().fold([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], |[lower, upper], point| {
        let by =
            |bound: Point, pick: fn(f64, f64) -> f64| [0, 1, 2].map(|axis| pick(bound[axis], point[axis]));
        [by(lower, f64::min), by(upper, f64::max)]
    })
}
