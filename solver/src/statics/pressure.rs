//! Pressure on facets, dead or following them.

use diffuse_contact::surface::Facet;

use crate::model::Amplitude;
use crate::system::BlockMatrix;

/// A pressure on facets; positive pushes against their outward side.
#[derive(Clone, Debug)]
pub struct Pressure {
    /// Where it acts.
    pub facets: Vec<Facet>,
    /// p, force per area.
    pub value: f64,
    /// Over time.
    pub amplitude: Amplitude,
    /// Whether it acts along the normal of the deformed facet and over its area; else those at the start.
    pub follower: bool,
}

/// Abscissa of the two-point rule; its weights are 1.
const GAUSS: f64 = 0.577_350_269_189_625_8;

impl Pressure {
    /// Adds the forces −p ∫ N_a n dA at `time`. `start`, `positions`: of all nodes.
    pub fn add_forces(&self, time: f64, start: &[[f64; 3]], positions: &[[f64; 3]], forces: &mut [f64]) {
        let factor = self.value * self.amplitude.at(time);
        let positions = if self.follower { positions } else { start };
        for facet in &self.facets {
            for_each_point(facet, |weight, shapes| {
                let [along, across] = tangents(facet, shapes, positions);
                let normal = cross(along, across);
                for (&node, shape) in facet.corners().iter().zip(shapes) {
                    for axis in 0..3 {
                        forces[3 * node + axis] -= factor * weight * shape[0] * normal[axis];
                    }
                }
            });
        }
    }

    /// Subtracts the derivative of the forces of a follower from a stiffness; it is not symmetric.
    pub fn add_tangent(&self, time: f64, positions: &[[f64; 3]], matrix: &mut BlockMatrix) {
        if !self.follower {
            return;
        }
        let factor = self.value * self.amplitude.at(time);
        for facet in &self.facets {
            for_each_point(facet, |weight, shapes| {
                let [along, across] = tangents(facet, shapes, positions);
                for (&row, shape) in facet.corners().iter().zip(shapes) {
                    for (&column, other) in facet.corners().iter().zip(shapes) {
                        // d(x,ξ × x,η) = (N,ξ dx) × x,η + x,ξ × (N,η dx)
                        let scale = factor * weight * shape[0];
                        let axial = [0, 1, 2].map(|k| scale * (other[2] * along[k] - other[1] * across[k]));
                        matrix.add_block(row, column, &skew(axial));
                    }
                }
            });
        }
    }

    /// The force per area at `time`.
    #[must_use]
    pub fn at(&self, time: f64) -> f64 {
        self.value * self.amplitude.at(time)
    }
}

/// Calls `f` with the weight and N, N,ξ, N,η of each corner at every integration point.
fn for_each_point(facet: &Facet, mut f: impl FnMut(f64, &[[f64; 3]])) {
    match facet {
        Facet::Triangle(_) => {
            for (a, b) in [(1.0 / 6.0, 1.0 / 6.0), (2.0 / 3.0, 1.0 / 6.0), (1.0 / 6.0, 2.0 / 3.0)] {
                f(1.0 / 6.0, &[[1.0 - a - b, -1.0, -1.0], [a, 1.0, 0.0], [b, 0.0, 1.0]]);
            }
        }
        Facet::Quadrilateral(_) => {
            for (xi, eta) in [(-GAUSS, -GAUSS), (GAUSS, -GAUSS), (GAUSS, GAUSS), (-GAUSS, GAUSS)] {
                let corner = |sx: f64, sy: f64| {
                    let (u, v) = (1.0 + sx * xi, 1.0 + sy * eta);
                    [0.25 * u * v, 0.25 * sx * v, 0.25 * sy * u]
                };
                f(1.0, &[corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
            }
        }
    }
}

/// x,ξ and x,η
fn tangents(facet: &Facet, shapes: &[[f64; 3]], positions: &[[f64; 3]]) -> [[f64; 3]; 2] {
    [1, 2].map(|derivative| {
        let mut tangent = [0.0; 3];
        for (&node, shape) in facet.corners().iter().zip(shapes) {
            for axis in 0..3 {
                tangent[axis] += shape[derivative] * positions[node][axis];
            }
        }
        tangent
    })
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The matrix of v ↦ a × v.
fn skew([x, y, z]: [f64; 3]) -> [[f64; 3]; 3] {
    [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
}
