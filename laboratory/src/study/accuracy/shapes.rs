//! Surfaces of known shape, meshed with cells that are nearly square.

use std::f64::consts::PI;

use diffuse_contact::Point;
use serde::Serialize;

use crate::study::patch::Patch;

/// Radius of cylinder and sphere, and of the circle in the middle of the torus' tube.
pub const RADIUS: f64 = 100.0;
/// Radius of the torus' tube.
pub const TUBE_RADIUS: f64 = 40.0;
/// Where on the tube the cell of the torus is: between the outermost circle (0) and the crown (π/2), so that the cell
/// sits nowhere special.
const TUBE_ANGLE: f64 = PI / 3.0;
/// Where the cell of the sphere is in stereographic coordinates.
const SPHERE_PLACE: f64 = 0.25;
/// Cells around the cell under study on each side.
const MARGIN: usize = 6;

/// A surface with an outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Shape {
    /// Cells along the axis and around it.
    Cylinder,
    /// A stereographic grid: squares in the small.
    Sphere,
    /// Cells around the axis and around the tube; h is the angle around the tube.
    Torus,
}

impl Shape {
    /// All shapes.
    pub const ALL: [Self; 3] = [Self::Cylinder, Self::Sphere, Self::Torus];

    /// Name with dimensions.
    pub fn description(self) -> String {
        match self {
            Self::Cylinder => format!("Cylinder, radius {RADIUS}"),
            Self::Sphere => format!("Sphere, radius {RADIUS}"),
            Self::Torus => format!("Torus, radii {RADIUS} and {TUBE_RADIUS}"),
        }
    }

    /// Point and outward unit normal at cell coordinates: the cell under study, of size `h` (radians), is [0, 1]².
    pub fn at(self, h: f64, [s, t]: [f64; 2]) -> (Point, Point) {
        match self {
            Self::Cylinder => {
                let (sin, cos) = (s * h).sin_cos();
                ([RADIUS * sin, RADIUS * t * h, RADIUS * cos], [sin, 0.0, cos])
            }
            Self::Sphere => {
                // An angle dθ is a stereographic length (1 + ρ²)/2 dθ.
                let length = 0.5 * h * (1.0 + 2.0 * SPHERE_PLACE * SPHERE_PLACE);
                let [a, b] = [s, t].map(|s| SPHERE_PLACE + length * s);
                let square = a * a + b * b;
                let normal = [2.0 * a, 2.0 * b, 1.0 - square].map(|x| x / (1.0 + square));
                (normal.map(|x| RADIUS * x), normal)
            }
            Self::Torus => {
                let width = h * TUBE_RADIUS / (RADIUS + TUBE_RADIUS * TUBE_ANGLE.cos());
                let (sin_u, cos_u) = (s * width).sin_cos();
                let (sin_v, cos_v) = (TUBE_ANGLE + t * h).sin_cos();
                let distance = RADIUS + TUBE_RADIUS * cos_v;
                let position = [distance * cos_u, distance * sin_u, TUBE_RADIUS * sin_v];
                (position, [cos_v * cos_u, cos_v * sin_u, sin_v])
            }
        }
    }

    /// The mesh with cells of size `h`, radians, nodes on the surface.
    pub fn mesh(self, h: f64) -> Patch {
        let first = MARGIN as f64;
        Patch::new([2 * MARGIN + 1; 2], |i, j| self.at(h, [i - first, j - first]).0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn difference(h: f64, shape: Shape, axis: usize) -> Point {
        let step = 1e-6;
        let mut ends = [[0.4, 0.7]; 2];
        ends[0][axis] -= step;
        ends[1][axis] += step;
        let [before, after] = ends.map(|place| shape.at(h, place).0);
        std::array::from_fn(|k| (after[k] - before[k]) / (2.0 * step))
    }

    fn dot(a: Point, b: Point) -> f64 {
        (0..3).map(|k| a[k] * b[k]).sum()
    }

    #[test]
    fn cells_are_square_and_normals_outward() {
        let h = 1e-3;
        for shape in Shape::ALL {
            let [along, across] = [0, 1].map(|axis| difference(h, shape, axis));
            let normal = shape.at(h, [0.4, 0.7]).1;
            let size = if shape == Shape::Torus { TUBE_RADIUS * h } else { RADIUS * h };
            for tangent in [along, across] {
                assert!((dot(tangent, tangent).sqrt() / size - 1.0).abs() < 1e-3, "{shape:?} {tangent:?}");
                assert!(dot(tangent, normal).abs() < 1e-6 * size);
            }
            let cross: Point = std::array::from_fn(|k| {
                along[(k + 1) % 3] * across[(k + 2) % 3] - along[(k + 2) % 3] * across[(k + 1) % 3]
            });
            assert!(dot(cross, normal) > 0.99 * size * size, "{shape:?}");
        }
    }
}
