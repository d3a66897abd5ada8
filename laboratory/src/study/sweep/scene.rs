//! A wavy surface and a closed path just below it. The unit of length is the height of the waves over their middle.

use std::f64::consts::TAU;

use diffuse_contact::Point;
use diffuse_contact_benches::Random;

use crate::study::patch::Patch;

/// Length of each side: two waves. The coarsest mesh has cells of side 1.
const SIDE: usize = 24;
/// Height of the waves.
const AMPLITUDE: f64 = 1.0;
/// Length of the waves.
pub const WAVELENGTH: f64 = 12.0;
/// How deep below the exact surface the path runs.
pub const DEPTH: f64 = 0.05;
/// How far the path reaches from the middle.
const REACH: f64 = 7.0;

/// A point of the exact surface z = A sin(kx) sin(ky) and its outward unit normal.
fn surface(x: f64, y: f64) -> (Point, Point) {
    let wave = TAU / WAVELENGTH;
    let ((sin_x, cos_x), (sin_y, cos_y)) = ((wave * x).sin_cos(), (wave * y).sin_cos());
    let slopes = [cos_x * sin_y, sin_x * cos_y].map(|slope| AMPLITUDE * wave * slope);
    let length = (1.0 + slopes[0] * slopes[0] + slopes[1] * slopes[1]).sqrt();
    let normal = [-slopes[0], -slopes[1], 1.0].map(|x| x / length);
    ([x, y, AMPLITUDE * sin_x * sin_y], normal)
}

/// A mesh of the waves.
#[derive(Clone, Copy, Debug)]
pub struct Cells {
    /// Cells have sides of 1 over this.
    pub refine: u32,
    /// Nodes inside are moved by up to this part of a side along each axis, at random.
    pub moved: f64,
}

impl Cells {
    /// The mesh, nodes on the exact surface, outside above.
    pub fn mesh(self) -> Patch {
        let (count, size) = (SIDE * self.refine as usize, 1.0 / f64::from(self.refine));
        let mut random = Random::new(&[1]);
        let moves: Vec<[f64; 2]> =
            (0..(count + 1).pow(2)).map(|_| [random.signed(), random.signed()]).collect();
        Patch::new([count; 2], |i, j| {
            let by = moves[i as usize + (count + 1) * j as usize];
            let is_inside = |k: f64| k > 0.0 && k < count as f64;
            let room = if is_inside(i) && is_inside(j) { self.moved } else { 0.0 };
            surface(size * (i + room * by[0]), size * (j + room * by[1])).0
        })
    }
}

/// The point of the exact surface at `turn`, from 0 to 1 around a Lissajous figure that runs over the facets in all directions, and the
/// normal there.
pub fn figure(turn: f64) -> (Point, Point) {
    let middle = 0.5 * SIDE as f64;
    let [x, y] = [2.0 * TAU * turn + 0.3, 3.0 * TAU * turn].map(|angle| middle + REACH * angle.sin());
    surface(x, y)
}

/// The slave's position at `turn`, at constant depth below the exact surface.
pub fn path(turn: f64) -> Point {
    let (position, normal) = figure(turn);
    std::array::from_fn(|axis| position[axis] - DEPTH * normal[axis])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_path_is_closed_and_keeps_its_depth() {
        let [start, end] = [path(0.0), path(1.0)];
        assert!((0..3).all(|axis| (start[axis] - end[axis]).abs() < 1e-12));
        for k in 0..50 {
            let position = path(f64::from(k) / 50.0);
            // Newton's method for the closest point of the exact surface is not needed: its foot is near, so sample.
            let samples = (0..=200).flat_map(|i| (0..=200).map(move |j| [i, j]));
            let nearest = samples
                .map(|[i, j]| {
                    let [x, y] =
                        [(position[0], i), (position[1], j)].map(|(x, i)| x + 1e-3 * f64::from(i - 100));
                    let point = surface(x, y).0;
                    (0..3).map(|axis| (point[axis] - position[axis]).powi(2)).sum::<f64>().sqrt()
                })
                .fold(f64::INFINITY, f64::min);
            assert!((nearest - DEPTH).abs() < 1e-4, "{nearest}");
        }
    }
}
