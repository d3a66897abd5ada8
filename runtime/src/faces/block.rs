//! The contribution of one slave face: forces by unit pressures of its corners, gradients of their gaps, and what the directions of the
//! forces add to the tangent.

use super::carried::Carried;
use super::cut::FacePoint;
use super::quadratic::{Carrying, MOST_NODES};
use super::skin::Skin;
use crate::interface::{ContactRef, back};
use crate::surface::{Facet, Image, Shape};
use crate::{Mode, Point};

/// What a face needs to know of itself.
pub struct FaceView<'a> {
    pub facet: &'a Facet,
    pub shape: Shape,
    /// What carries its forces.
    pub carrying: &'a Carrying,
    /// Of all nodes.
    pub positions: &'a [Point],
    pub skin: &'a Skin,
    /// The face's number.
    pub face: usize,
    /// Nodes that forces act on, ascending: those of the face and of the facets over it.
    pub rows: &'a [u32],
    /// Nodes that forces depend on, ascending.
    pub columns: &'a [u32],
}

/// The sums over a face's points.
#[derive(Clone, Debug, Default)]
pub struct FaceBlock {
    /// By unit pressure of each corner: what it exerts on the rows' nodes, length².
    pub forces: [Vec<f64>; 4],
    /// ∫ N_A ∂g/∂x dA by the columns' nodes, length².
    pub gradients: [Vec<f64>; 4],
    /// −∂R/∂x with the pressures held, a row per coordinate of the rows' nodes; empty below Hessian mode.
    pub directions: Vec<f64>,
    /// Points whose line of force meets no place of their facet: they count for the gap, but carry no force.
    pub missed: usize,
}

/// Where the derivatives of a point's gap and normal are found among those by all columns.
struct Columns<'a> {
    /// Of the skin's carriers, with what each has of the point.
    skin: Vec<(usize, Option<&'a Image>, f64)>,
    /// Of the masters.
    masters: Vec<usize>,
    /// Of the nodes that carry the face's forces.
    face: Vec<usize>,
    /// Of those that carry the facet's.
    facet: Vec<usize>,
    contact: &'a ContactRef<'a>,
}

impl Columns<'_> {
    /// Adds `factor` times a derivative by the contact's own points to one by the columns. `own`: by coordinate of slave and masters.
    fn spread(&self, own: impl Fn(usize) -> f64, factor: f64, sum: &mut [f64]) {
        let by_point = [0, 1, 2].map(|axis| factor * own(axis));
        for &(place, image, weight) in &self.skin {
            for (axis, value) in back(image, by_point).into_iter().enumerate() {
                sum[3 * place + axis] += weight * value;
            }
        }
        for (k, &place) in self.masters.iter().enumerate() {
            for axis in 0..3 {
                sum[3 * place + axis] += factor * own(3 * (k + 1) + axis);
            }
        }
    }
}

impl FaceBlock {
    /// No points yet.
    pub fn new(view: &FaceView<'_>, mode: Mode) -> Self {
        let (rows, columns) = (3 * view.rows.len(), 3 * view.columns.len());
        let of_corners = |count: usize| std::array::from_fn(|_| vec![0.0; count]);
        let directions = if mode >= Mode::Hessian { vec![0.0; rows * columns] } else { Vec::new() };
        Self { forces: of_corners(rows), gradients: of_corners(columns), directions, missed: 0 }
    }

    /// Adds a point. `over`: what carries the forces of the facet over it; `pressures`: of the face's corners.
    pub fn add(
        &mut self,
        view: &FaceView<'_>,
        point: &FacePoint,
        over: &Carrying,
        contact: &ContactRef<'_>,
        pressures: &[f64; 4],
    ) {
        let functions = view.shape.functions(point.natural);
        let along = [contact.gradient[0], contact.gradient[1], contact.gradient[2]];
        let mode = if contact.hessian.is_empty() { Mode::Value } else { Mode::Gradient };
        // Where the point is on what carries it.
        let own = view.carrying.nodes();
        let mut x = [0.0; 3];
        for (&node, n) in own.iter().zip(point.functions) {
            (0..3).for_each(|axis| x[axis] += n * view.positions[node][axis]);
        }
        let place = |list: &[u32], node: usize| {
            list.binary_search(&(node as u32))
                .unwrap_or_else(|_| unreachable!("lists hold all nodes of their points"))
        };
        let in_columns = |node: usize| place(view.columns, node);
        let face = &view.skin.faces[view.face];
        let weights = face.weights(view.facet.corners().len(), point.natural);
        let skin =
            face.carriers.iter().zip(weights).map(|(&carrier, weight)| {
                (in_columns(carrier.node as usize), view.skin.image(carrier), weight)
            });
        let columns = Columns {
            skin: skin.collect(),
            masters: contact.nodes.iter().map(|&node| in_columns(node as usize)).collect(),
            face: own.iter().map(|&node| in_columns(node)).collect(),
            facet: over.nodes().iter().map(|&node| in_columns(node)).collect(),
            contact,
        };
        for (corner, &n) in functions.iter().enumerate().take(view.facet.corners().len()) {
            columns.spread(|own| contact.gradient[own], point.weight * n, &mut self.gradients[corner]);
        }
        let Some(force) = over.carried(view.positions, x, along, mode) else {
            self.missed += 1;
            return;
        };
        // Who carries the force: +N_a of it the nodes of the face, −N_k those of the facet.
        let of_face = own.iter().zip(point.functions).map(|(&node, n)| (place(view.rows, node), 0, n));
        let of_facet =
            over.nodes().iter().enumerate().map(|(k, &node)| (place(view.rows, node), k + 1, -1.0));
        let carriers: Vec<(usize, usize, f64)> = of_face.chain(of_facet).collect();
        for (corner, &n) in functions.iter().enumerate().take(view.facet.corners().len()) {
            let weight = point.weight * n;
            for &(row, own, part) in &carriers {
                for axis in 0..3 {
                    self.forces[corner][3 * row + axis] += weight * part * force.forces[own][axis];
                }
            }
        }
        let pressure: f64 = functions.iter().zip(pressures).map(|(n, p)| n * p).sum();
        if !self.directions.is_empty() && pressure != 0.0 {
            self.add_directions(&force, &columns, &carriers, &point.functions, point.weight * pressure);
        }
    }

    /// The chain rule: the forces by point, direction and facet; point and direction by the nodes.
    fn add_directions(
        &mut self,
        force: &Carried,
        columns: &Columns<'_>,
        carriers: &[(usize, usize, f64)],
        functions: &[f64; MOST_NODES],
        load: f64,
    ) {
        let width = self.gradients[0].len();
        let hessian = columns.contact.hessian;
        let entry = |i: usize, j: usize| {
            if i >= j { hessian[i * (i + 1) / 2 + j] } else { hessian[j * (j + 1) / 2 + i] }
        };
        // The direction is ∂g/∂x of the slave: its derivatives are the slave's rows of M.
        let mut by_nodes = vec![0.0; 3 * width];
        for axis in 0..3 {
            columns.spread(|own| entry(axis, own), 1.0, &mut by_nodes[axis * width..][..width]);
        }
        let mut line = vec![0.0; width];
        let count = columns.facet.len() + 1;
        for own in 0..count {
            for axis in 0..3 {
                let by = force.row(3 * own + axis);
                line.fill(0.0);
                for (k, factor) in by[3..6].iter().enumerate() {
                    for (entry, other) in line.iter_mut().zip(&by_nodes[k * width..][..width]) {
                        *entry += factor * other;
                    }
                }
                for k in 0..3 {
                    for (&place, n) in columns.face.iter().zip(functions) {
                        line[3 * place + k] += n * by[k];
                    }
                    for (node, &place) in columns.facet.iter().enumerate() {
                        line[3 * place + k] += by[6 + 3 * node + k];
                    }
                }
                for &(row, _, part) in carriers.iter().filter(|carrier| carrier.1 == own) {
                    let target = &mut self.directions[(3 * row + axis) * width..][..width];
                    for (sum, entry) in target.iter_mut().zip(&line) {
                        *sum -= load * part * entry;
                    }
                }
            }
        }
    }
}
