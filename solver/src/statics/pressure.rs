//! Pressure on facets, dead or following them.

use crate::model::Amplitude;
use crate::solid::{FacePoint, face_points};
use crate::system::BlockMatrix;

/// A pressure on faces; positive pushes against their outward side.
#[derive(Clone, Debug)]
pub struct Pressure {
    /// The nodes of each face that it acts on: of a triangle 3 or 6, of a quadrilateral 4, 8 or 9.
    pub faces: Vec<Vec<usize>>,
    /// p, force per area.
    pub value: f64,
    /// Over time.
    pub amplitude: Amplitude,
    /// Whether it acts along the normal of the deformed face and over its area; else those at the start.
    pub follower: bool,
}

impl Pressure {
    /// Adds the forces −p ∫ N_a n dA at `time`. `start`, `positions`: of all nodes.
    pub fn add_forces(&self, time: f64, start: &[[f64; 3]], positions: &[[f64; 3]], forces: &mut [f64]) {
        let factor = self.at(time);
        let positions = if self.follower { positions } else { start };
        for face in &self.faces {
            for FacePoint { weight, functions } in face_points(face.len()) {
                let [along, across] = tangents(face, functions, positions);
                let normal = cross(along, across);
                for (&node, function) in face.iter().zip(functions) {
                    for axis in 0..3 {
                        forces[3 * node + axis] -= factor * weight * function[0] * normal[axis];
                    }
                }
            }
        }
    }

    /// Subtracts the derivative of the forces of a follower from a stiffness; it is not symmetric.
    pub fn add_tangent(&self, time: f64, positions: &[[f64; 3]], matrix: &mut BlockMatrix) {
        if !self.follower {
            return;
        }
        let factor = self.at(time);
        for face in &self.faces {
            for FacePoint { weight, functions } in face_points(face.len()) {
                let [along, across] = tangents(face, functions, positions);
                for (&row, function) in face.iter().zip(functions) {
                    for (&column, other) in face.iter().zip(functions) {
                        // d(x,ξ × x,η) = (N,ξ dx) × x,η + x,ξ × (N,η dx)
                        let scale = factor * weight * function[0];
                        let axial = [0, 1, 2].map(|k| scale * (other[2] * along[k] - other[1] * across[k]));
                        matrix.add_block(row, column, &skew(axial));
                    }
                }
            }
        }
    }

    /// The force per area at `time`.
    fn at(&self, time: f64) -> f64 {
        self.value * self.amplitude.at(time)
    }
}

/// x,ξ and x,η
fn tangents(face: &[usize], functions: &[[f64; 3]], positions: &[[f64; 3]]) -> [[f64; 3]; 2] {
    [1, 2].map(|derivative| {
        let mut tangent = [0.0; 3];
        for (&node, function) in face.iter().zip(functions) {
            for axis in 0..3 {
                tangent[axis] += function[derivative] * positions[node][axis];
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::system::BlockPattern;

    /// A quadrilateral in a plane, a triangle beside it.
    const POSITIONS: [[f64; 3]; 5] =
        [[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [2.0, 1.5, 1.0], [0.0, 1.0, 1.0], [3.0, 0.5, 1.0]];

    fn pressure(follower: bool) -> Pressure {
        let faces = vec![vec![0, 1, 2, 3], vec![1, 4, 2]];
        let amplitude = Amplitude::new(vec![[0.0, 0.0], [1.0, 0.5], [2.0, 3.0]]).unwrap();
        Pressure { faces, value: 7.0, amplitude, follower }
    }

    /// Positions that bend the quadrilateral and turn both.
    fn deformed() -> Vec<[f64; 3]> {
        let mut positions = POSITIONS.to_vec();
        for (k, x) in positions.iter_mut().enumerate() {
            let t = 1.0 + k as f64;
            *x = [x[0] + 0.2 * (3.0 * t).sin(), x[1] + 0.3 * t.cos(), x[2] + 0.25 * (2.0 * t).cos()];
        }
        positions
    }

    fn forces(pressure: &Pressure, time: f64, positions: &[[f64; 3]]) -> Vec<f64> {
        let mut forces = vec![0.0; 15];
        pressure.add_forces(time, &POSITIONS, positions, &mut forces);
        forces
    }

    #[test]
    fn forces_are_pressure_times_area_against_the_normal() {
        for (follower, positions) in [(false, deformed()), (true, POSITIONS.to_vec())] {
            let found = forces(&pressure(follower), 2.0, &positions);
            let area = 2.0 * 1.25 + 0.5 * 1.5;
            let sum = |axis: usize| found.iter().skip(axis).step_by(3).sum::<f64>();
            assert!((sum(2) + 21.0 * area).abs() < 1e-12, "{}", sum(2));
            assert!(sum(0).abs() < 1e-12 && sum(1).abs() < 1e-12);
            // The triangle's share goes to its corners in equal parts: node 4 belongs to it alone.
            assert!((found[14] + 21.0 * 0.75 / 3.0).abs() < 1e-12);
        }
    }

    #[test]
    fn forces_follow_their_amplitude() {
        let of = |time: f64| forces(&pressure(false), time, &POSITIONS)[14];
        assert_eq!(of(0.0), 0.0);
        assert!((of(1.0) / of(2.0) - 0.5 / 3.0).abs() < 1e-14);
        assert!((pressure(false).at(1.5) - 7.0 * 1.75).abs() < 1e-12);
    }

    /// Neither sum nor moment: to rounding, and to `tolerance` of the largest force.
    fn assert_balanced(positions: &[[f64; 3]], forces: &[f64], tolerance: f64) {
        let size = forces.iter().map(|f| f.abs()).fold(0.0, f64::max);
        let mut moment = [0.0; 3];
        for (x, f) in positions.iter().zip(forces.as_chunks::<3>().0) {
            let turned = cross(*x, *f);
            (0..3).for_each(|axis| moment[axis] += turned[axis]);
        }
        for axis in 0..3 {
            assert!(forces.iter().skip(axis).step_by(3).sum::<f64>().abs() < 1e-13 * size);
            assert!(moment[axis].abs() < tolerance * size, "{moment:?} {size}");
        }
    }

    /// The forces on a closed surface in a uniform pressure are in equilibrium, wherever its nodes are.
    #[test]
    fn followers_on_a_closed_surface_are_in_equilibrium() {
        let positions = deformed();
        let faces = vec![vec![0, 2, 1], vec![0, 1, 4], vec![1, 2, 4], vec![2, 0, 4]];
        let closed = Pressure { faces, ..pressure(true) };
        let found = forces(&closed, 2.0, &positions);
        assert_balanced(&positions, &found, 1e-12);
    }

    /// The same with the curved faces of a tetrahedron of second order.
    #[test]
    fn followers_on_curved_faces_are_in_equilibrium() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.1, 0.0], [0.2, 1.0, 0.1], [0.1, 0.2, 1.1]];
        let edges = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];
        let mut positions = corners.to_vec();
        for (k, [a, b]) in edges.into_iter().enumerate() {
            let aside = 0.1 * (1.7 * k as f64).sin();
            let middle = |axis: usize| 0.5 * (positions[a][axis] + positions[b][axis]);
            let moved = [middle(0) + aside, middle(1) - 0.5 * aside, middle(2) + 0.7 * aside];
            positions.push(moved);
        }
        let faces = [[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [2, 0, 3, 6, 7, 9]]
            .map(|face| face.to_vec());
        let closed = Pressure { faces: faces.to_vec(), ..pressure(true) };
        let mut found = vec![0.0; 30];
        closed.add_forces(2.0, &positions, &positions, &mut found);
        assert_balanced(&positions, &found, 1e-13);
        // The derivative, by differences of what is quadratic in each coordinate.
        let mut matrix = BlockMatrix::new(Arc::new(BlockPattern::new(10, closed.faces.iter())));
        closed.add_tangent(2.0, &positions, &mut matrix);
        for column in 0..30 {
            let at = |shift: f64| {
                let (mut moved, mut forces) = (positions.clone(), vec![0.0; 30]);
                moved[column / 3][column % 3] += shift;
                closed.add_forces(2.0, &positions, &moved, &mut forces);
                forces
            };
            let (after, before) = (at(1e-3), at(-1e-3));
            for row in 0..30 {
                let expected = -(after[row] - before[row]) / 2e-3;
                let found = matrix.block(row / 3, column / 3).map_or(0.0, |block| block[row % 3][column % 3]);
                assert!((found - expected).abs() < 1e-9, "{row} {column}: {found} {expected}");
            }
        }
    }

    #[test]
    fn tangent_of_a_follower_is_minus_the_derivative_of_its_forces() {
        let (positions, pressure) = (deformed(), pressure(true));
        let mut matrix = BlockMatrix::new(Arc::new(BlockPattern::new(5, pressure.faces.iter())));
        pressure.add_tangent(2.0, &positions, &mut matrix);
        // Forces are quadratic in the positions: central differences are exact but for rounding.
        let step = 1e-3;
        for column in 0..15 {
            let at = |shift: f64| {
                let mut moved = positions.clone();
                moved[column / 3][column % 3] += shift;
                forces(&pressure, 2.0, &moved)
            };
            let (after, before) = (at(step), at(-step));
            for row in 0..15 {
                let expected = -(after[row] - before[row]) / (2.0 * step);
                let found = matrix.block(row / 3, column / 3).map_or(0.0, |block| block[row % 3][column % 3]);
                assert!((found - expected).abs() < 1e-9, "{row} {column}: {found} {expected}");
            }
        }
    }

    /// A uniform pressure on flat faces of second order: corners of a triangle carry nothing, those of a quadrilateral are pulled.
    #[test]
    fn faces_of_second_order_carry_what_is_in_equilibrium_with_a_uniform_stress() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let sixth = 1.0 / 6.0;
        let expected = [
            (3, [0.0, sixth, 0.0]),
            (4, [-1.0 / 12.0, 1.0 / 3.0, 0.0]),
            (4, [1.0 / 36.0, 1.0 / 9.0, 4.0 / 9.0]),
        ];
        for (k, (corners, [corner, middle, centre])) in expected.into_iter().enumerate() {
            let mut nodes: Vec<[f64; 3]> = square[..corners].iter().map(|[x, y]| [*x, *y, 0.0]).collect();
            for k in 0..corners {
                let (a, b) = (nodes[k], nodes[(k + 1) % corners]);
                nodes.push([0, 1, 2].map(|axis| 0.5 * (a[axis] + b[axis])));
            }
            if k == 2 {
                nodes.push([0.5, 0.5, 0.0]);
            }
            let face = Pressure { faces: vec![(0..nodes.len()).collect()], ..pressure(false) };
            let mut found = vec![0.0; 3 * nodes.len()];
            face.add_forces(1.0, &nodes, &nodes, &mut found);
            for (node, force) in found.as_chunks::<3>().0.iter().enumerate() {
                let share = if node < corners {
                    corner
                } else if node < 2 * corners {
                    middle
                } else {
                    centre
                };
                assert!((force[2] + 3.5 * share).abs() < 1e-14, "{} nodes, {node}: {force:?}", nodes.len());
                assert!(force[0].abs() + force[1].abs() < 1e-14);
            }
        }
    }

    #[test]
    fn dead_pressure_has_no_tangent() {
        let pressure = pressure(false);
        let mut matrix = BlockMatrix::new(Arc::new(BlockPattern::new(5, [vec![0, 1, 2, 3, 4]].iter())));
        pressure.add_tangent(2.0, &deformed(), &mut matrix);
        let all_zero = |k: usize| matrix.block(k / 5, k % 5).is_some_and(|block| *block == [[0.0; 3]; 3]);
        assert!((0..25).all(all_zero));
    }
}
