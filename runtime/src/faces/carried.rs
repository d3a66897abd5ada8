//! A force on a facet, by the generated kernels.

use diffuse_contact_kernels::{
    carried_by_quadrilateral, carried_by_quadrilateral8, carried_by_quadrilateral9, carried_by_triangle,
    carried_by_triangle6, direction, load_of_point,
};

use super::quadratic::MOST_NODES;
use crate::surface::Shape;
use crate::vector::Vector3;
use crate::{Mode, Point};

/// A force through a point, and what each node of the facet carries of it: its shape function where the line of the force meets the
/// facet, times the force.
#[derive(Clone, Debug, PartialEq)]
pub struct Carried {
    /// Natural coordinates of the place where the line meets the facet, which may lie beyond its edges.
    pub natural: [f64; 2],
    /// The force, then the parts of the nodes; zero beyond the last.
    pub forces: [Point; 1 + MOST_NODES],
    /// By the point, the force, and the nodes: a row of `variables` per component of `forces`; empty without.
    pub derivatives: Vec<f64>,
    /// 6 and three for each node.
    pub variables: usize,
}

impl Carried {
    /// The derivatives of an entry of `forces`.
    pub fn row(&self, entry: usize) -> &[f64] {
        &self.derivatives[entry * self.variables..][..self.variables]
    }

    /// Of a quadrilateral whose corners begin at the opposite one.
    fn turned(self) -> Self {
        let Self { natural, mut forces, derivatives, variables } = self;
        let opposite = |corner: usize| (corner + 2) % 4;
        let all = forces;
        (0..4).for_each(|corner| forces[1 + corner] = all[1 + opposite(corner)]);
        let mut turned = derivatives.clone();
        for (k, row) in turned.chunks_exact_mut(variables).enumerate() {
            let (entry, axis) = (k / 3, k % 3);
            let entry = if entry == 0 { 0 } else { 1 + opposite(entry - 1) };
            let of_entry = &derivatives[(3 * entry + axis) * variables..][..variables];
            for (place, by) in row.iter_mut().enumerate() {
                let of = if place < 6 { place } else { 6 + 3 * opposite(place / 3 - 2) + place % 3 };
                *by = of_entry[of];
            }
        }
        Self { natural: natural.map(|x| -x), forces, derivatives: turned, variables }
    }

    /// Itself if the line meets a place of the facet.
    fn if_met(self, beside: [f64; 2], farthest: f64) -> Option<Self> {
        // The sum over all results is finite only if each is.
        let sum: f64 = self.forces.as_flattened().iter().chain(&self.derivatives).sum();
        let is_met = beside.iter().all(|x| x.abs() <= LARGEST_RESIDUAL)
            && sum.is_finite()
            && self.natural.iter().all(|x| x.abs() <= farthest);
        is_met.then_some(self)
    }
}

/// Runs a kernel and takes its results over.
macro_rules! run {
    ($kernel:ident, $mode:expr, $inputs:expr, $farthest:expr, |$values:ident| $beside:expr) => {{
        let results = $kernel::evaluate($mode, &$inputs);
        let $values = &results.values;
        let mut forces = [[0.0; 3]; 1 + MOST_NODES];
        forces[0] = $inputs.force;
        forces[1..=$values.parts.len()].copy_from_slice(&$values.parts);
        let derivatives = if $mode == Mode::Value {
            Vec::new()
        } else {
            let mut by_itself = [[0.0; $kernel::VARIABLES]; 3];
            (0..3).for_each(|axis| by_itself[axis][3 + axis] = 1.0);
            [by_itself.as_flattened(), &results.parts_jacobian].concat()
        };
        let carried =
            Carried { natural: $values.natural, forces, derivatives, variables: $kernel::VARIABLES };
        carried.if_met($beside, $farthest)
    }};
}

/// `None` if the line of the force meets no place of the facet.
pub fn carried(shape: &Shape, point: Point, force: Point, mode: Mode) -> Option<Carried> {
    // Nothing depends on the place, but for rounding.
    let first = shape.corners()[0];
    let about = |x: Vector3| Point::from(x - first);
    let point = about(point.into());
    match *shape {
        Shape::Triangle(corners) => {
            let inputs = carried_by_triangle::Inputs { point, force, corners: corners.map(about) };
            run!(carried_by_triangle, mode, inputs, FARTHEST, |_values| [0.0; 2])
        }
        Shape::Quadrilateral([a, b, c, d]) => {
            // The way to the place begins at the first corner. From a reflex one it leads elsewhere.
            let along = Vector3::from(force);
            let is_reflex = (b - a).cross(&(d - a)).dot(&along) * (c - a).cross(&(d - b)).dot(&along) < 0.0;
            let corners = if is_reflex { [c, d, a, b] } else { [a, b, c, d] }.map(about);
            let inputs = carried_by_quadrilateral::Inputs { point, force, corners };
            let carried = run!(carried_by_quadrilateral, mode, inputs, FARTHEST, |values| values.beside);
            if is_reflex { carried.map(Carried::turned) } else { carried }
        }
    }
}

/// The same by 6, 8 or 9 nodes of a face of second order; `start`: natural coordinates near the place.
pub fn carried_by_quadratic(
    nodes: &[Point],
    [start_xi, start_eta]: [f64; 2],
    point: Point,
    force: Point,
    mode: Mode,
) -> Option<Carried> {
    let about = |x: Point| [0, 1, 2].map(|axis| x[axis] - nodes[0][axis]);
    let point = about(point);
    macro_rules! by {
        ($kernel:ident) => {{
            let corners = std::array::from_fn(|k| about(nodes[k]));
            let inputs = $kernel::Inputs { point, force, corners, start_xi, start_eta };
            run!($kernel, mode, inputs, FARTHEST_ON_CURVED, |values| values.beside)
        }};
    }
    match nodes.len() {
        6 => by!(carried_by_triangle6),
        8 => by!(carried_by_quadrilateral8),
        _ => by!(carried_by_quadrilateral9),
    }
}

/// The unit vector along another one, and its derivatives by it, a row per component.
pub fn direction_along(along: Point) -> (Point, [Point; 3]) {
    let direction::Results { values, direction_jacobian: by, .. } =
        direction::evaluate(Mode::Gradient, &direction::Inputs { along });
    (values.direction, [0, 1, 2].map(|i| [0, 1, 2].map(|j| by[3 * i + j])))
}

/// A force at unit pressure, and what it changes with.
pub struct PointLoad {
    pub load: Point,
    /// By ∂g/∂x of the point.
    pub by_along: [Point; 3],
    /// By the friction over the pressure.
    pub by_ratio: [Point; 3],
}

/// The force of a point along a vector of any length, with the part of a friction that lies across it.
pub fn load_of_point(along: Point, ratio: Point) -> PointLoad {
    let load_of_point::Results { values, load_jacobian: by, .. } =
        load_of_point::evaluate(Mode::Gradient, &load_of_point::Inputs { along, ratio });
    let block = |first: usize| [0, 1, 2].map(|i| [0, 1, 2].map(|j| by[6 * i + first + j]));
    PointLoad { load: values.load, by_along: block(0), by_ratio: block(3) }
}

/// Of the equations of the place, in natural coordinates.
const LARGEST_RESIDUAL: f64 = 1e-9;
/// Natural coordinates beyond this belong to a line that all but misses the facet's surface.
const FARTHEST: f64 = 3.0;
/// On faces of second order, whose functions grow fast and whose equations have other roots out there.
const FARTHEST_ON_CURVED: f64 = 1.5;

#[cfg(test)]
mod tests {
    use super::*;

    fn shapes() -> [Shape; 2] {
        let [a, b, c, d] =
            [[0.1, 0.0, 0.2], [1.2, 0.1, 0.0], [1.1, 0.9, 0.3], [-0.1, 1.0, 0.1]].map(Vector3::from);
        [Shape::Triangle([a, b, c]), Shape::Quadrilateral([a, b, c, d])]
    }

    const POINT: Point = [0.6, 0.4, 0.5];
    const ALONG: Point = [0.1, -0.2, 0.7];

    /// Force and moment of the parts are those of the force.
    #[test]
    fn the_corners_carry_the_force_on_its_line() {
        for shape in shapes() {
            let carried = carried(&shape, POINT, ALONG, Mode::Value).unwrap();
            let force = Vector3::from(ALONG);
            assert_eq!(carried.forces[0], ALONG);
            let parts = carried.forces[1..].iter().map(|&part| Vector3::from(part));
            let sum = parts.clone().fold(Vector3::zeros(), |sum, part| sum + part);
            let moment = shape
                .corners()
                .iter()
                .zip(parts)
                .fold(Vector3::zeros(), |sum, (&x, part)| sum + (x - Vector3::from(POINT)).cross(&part));
            assert!((sum - force).norm() < 1e-14 && moment.norm() < 1e-14, "{sum:?} {moment:?}");
        }
    }

    #[test]
    fn derivatives_are_those_of_the_parts() {
        for shape in shapes() {
            let exact = carried(&shape, POINT, ALONG, Mode::Gradient).unwrap();
            let count = shape.corners().len();
            for variable in 0..6 + 3 * count {
                let at = |step: f64| {
                    let (mut point, mut along) = (POINT, ALONG);
                    let mut corners: Vec<Point> = shape.corners().iter().map(|&x| x.into()).collect();
                    let all = [&mut [point, along][..], &mut corners].concat();
                    let mut all = all.as_flattened().to_vec();
                    all[variable] += step;
                    let rows = all.as_chunks::<3>().0;
                    (point, along) = (rows[0], rows[1]);
                    let x = |k: usize| Vector3::from(rows[2 + k]);
                    let moved = match shape {
                        Shape::Triangle(_) => Shape::Triangle([x(0), x(1), x(2)]),
                        Shape::Quadrilateral(_) => Shape::Quadrilateral([x(0), x(1), x(2), x(3)]),
                    };
                    carried(&moved, point, along, Mode::Value).unwrap().forces
                };
                let (after, before) = (at(1e-6), at(-1e-6));
                for row in 0..3 * (count + 1) {
                    let [after, before] = [after, before].map(|forces| forces.as_flattened()[row]);
                    let expected = (after - before) / 2e-6;
                    assert!((exact.row(row)[variable] - expected).abs() < 1e-8, "{row} {variable}");
                }
            }
        }
    }

    /// Coordinates of geodesy, in metres: rounding is that of the positions.
    #[test]
    fn far_from_the_origin_lines_meet_the_same_places() {
        let away = Vector3::from([5e6, -4e6, 2e6]);
        for shape in shapes() {
            let x: Vec<Vector3> = shape.corners().iter().map(|&x| x + away).collect();
            let moved = match x[..] {
                [a, b, c] => Shape::Triangle([a, b, c]),
                _ => Shape::Quadrilateral([x[0], x[1], x[2], x[3]]),
            };
            let near = carried(&shape, POINT, ALONG, Mode::Gradient).unwrap();
            let far = carried(&moved, (Vector3::from(POINT) + away).into(), ALONG, Mode::Gradient).unwrap();
            let all = near.forces.as_flattened().iter().chain(&near.derivatives);
            let both = all.zip(far.forces.as_flattened().iter().chain(&far.derivatives));
            assert!(both.into_iter().all(|(near, far)| (near - far).abs() < 1e-8));
        }
    }

    /// Wherever its corners begin, a quadrilateral with a reflex corner carries a force alike.
    #[test]
    fn a_reflex_corner_may_come_first() {
        let dart = [[0.6, 0.6, 0.0], [1.0, 0.0, 0.1], [1.0, 1.0, 0.0], [0.0, 1.0, 0.1]].map(Vector3::from);
        let by_turn = |turn: usize| {
            let corners = [0, 1, 2, 3].map(|k| dart[(k + turn) % 4]);
            let carried =
                carried(&Shape::Quadrilateral(corners), [0.9, 0.9, 1.0], [0.0, 0.1, -1.0], Mode::Gradient);
            let carried = carried.unwrap();
            let place = |corner: usize| (corner + 4 - turn) % 4;
            let forces = [0, 1, 2, 3].map(|corner| carried.forces[1 + place(corner)]);
            let column = |variable: usize| match variable {
                0..6 => variable,
                _ => 6 + 3 * place(variable / 3 - 2) + variable % 3,
            };
            let rows = (0..12).map(|k| 3 * (1 + place(k / 3)) + k % 3);
            let derivatives: Vec<f64> = rows
                .flat_map(|row| (0..18).map(move |k| (row, k)))
                .map(|(row, k)| carried.row(row)[column(k)])
                .collect();
            (forces, derivatives)
        };
        let (forces, derivatives) = by_turn(0);
        assert!(forces.iter().all(|part| part[2] < 0.0), "no corner is pulled: {forces:?}");
        for turn in 1..4 {
            let (other, by) = by_turn(turn);
            let all = forces.as_flattened().iter().chain(&derivatives);
            let both = all.zip(other.as_flattened().iter().chain(&by));
            assert!(both.into_iter().all(|(one, other)| (one - other).abs() < 1e-11), "{turn}");
        }
    }

    #[test]
    fn a_line_along_the_facet_meets_no_place() {
        let [triangle, _] = shapes();
        let [a, b, _] = triangle.corners() else { panic!("it has three corners") };
        assert_eq!(carried(&triangle, POINT, (*b - *a).into(), Mode::Value), None);
    }
}
