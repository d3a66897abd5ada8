//! The contribution of one slave face: forces by unit pressures and tractions of its corners, gradients of their gaps, and what the
//! directions of the forces add to the tangent.

use diffuse_contact_kernels::support::{Isa, Vector, WithLanes};

use super::carried::{Carried, direction_along};
use super::cut::FacePoint;
use super::quadratic::{Carrying, MOST_NODES};
use super::skin::Skin;
use crate::interface::{ContactRef, back};
use crate::surface::{Facet, Image, Shape};
use crate::vector::Vector3;
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
    pub load: FaceLoad,
}

/// What the corners of a face carry.
#[derive(Clone, Copy, Debug, Default)]
pub struct FaceLoad {
    /// Force per area.
    pub pressures: [f64; 4],
    /// Friction, force per area; `None` if no corner has a history of it.
    pub tractions: Option<[Point; 4]>,
}

impl FaceLoad {
    /// The pressure at a point with these shape functions, and the traction over it.
    fn at(&self, functions: &[f64; 4]) -> (f64, Option<Vector3>) {
        let pressure: f64 = functions.iter().zip(&self.pressures).map(|(n, p)| n * p).sum();
        let traction = self.tractions.filter(|_| pressure > 0.0).map(|tractions| {
            let sum = functions.iter().zip(tractions);
            sum.fold(Vector3::zeros(), |sum, (&n, t)| sum + Vector3::from(t) * n) / pressure
        });
        (pressure, traction)
    }
}

/// The sums over a face's points.
#[derive(Clone, Debug, Default)]
pub struct FaceBlock {
    /// By unit pressure of each corner: what it exerts on the rows' nodes, length².
    pub forces: [Vec<f64>; 4],
    /// By each component of the traction of each corner: the same; empty without friction.
    pub friction: [[Vec<f64>; 3]; 4],
    /// ∫ N_A ∂g/∂x dA by the columns' nodes, length².
    pub gradients: [Vec<f64>; 4],
    /// ∂/∂x of ∫ N_A ∂g/∂x_s dA, x_s the points of the slave: three rows by the columns' nodes, length; empty without friction.
    pub normals: [Vec<f64>; 4],
    /// −∂R/∂x with pressures and tractions held, a row per coordinate of the rows' nodes; empty below Hessian mode.
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
}

/// A force with its derivatives, and those of its line.
struct Line<'a> {
    force: &'a Carried,
    /// Of the direction, by ∂g/∂x of the slave.
    by_along: &'a [Point; 3],
    /// ∂g/∂x of the slave by the columns: three rows.
    along_by_nodes: &'a [f64],
}

/// An entry of a packed symmetric matrix.
fn contact_entry(hessian: &[f64], i: usize, j: usize) -> f64 {
    if i >= j { hessian[i * (i + 1) / 2 + j] } else { hessian[j * (j + 1) / 2 + i] }
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
        let mut block =
            Self { forces: of_corners(rows), gradients: of_corners(columns), directions, ..Self::default() };
        if view.load.tractions.is_some() {
            block.friction = std::array::from_fn(|_| std::array::from_fn(|_| vec![0.0; rows]));
            if mode >= Mode::Hessian {
                block.normals = of_corners(3 * columns);
            }
        }
        block
    }

    /// Adds a point. `over`: what carries the forces of the facet over it.
    pub fn add(&mut self, view: &FaceView<'_>, point: &FacePoint, over: &Carrying, contact: &ContactRef<'_>) {
        let functions = view.shape.functions(point.natural);
        let along = [contact.gradient[0], contact.gradient[1], contact.gradient[2]];
        // Where the point is on what carries it.
        let own = view.carrying.nodes();
        let x = view.carrying.point(&point.functions, view.positions);
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
        };
        for (corner, &n) in functions.iter().enumerate().take(view.facet.corners().len()) {
            columns.spread(|own| contact.gradient[own], point.weight * n, &mut self.gradients[corner]);
        }
        let (direction, by_along) = direction_along(along);
        let (pressure, traction) = view.load.at(&functions);
        let (needs_hessian, is_moved) = (!self.directions.is_empty(), traction.is_some());
        let mode = if needs_hessian || is_moved { Mode::Gradient } else { Mode::Value };
        // The direction is along ∂g/∂x of the slave: its derivatives are the slave's rows of M.
        let width = self.gradients[0].len();
        let mut by_nodes = vec![0.0; if needs_hessian { 3 * width } else { 0 }];
        for (axis, row) in by_nodes.chunks_exact_mut(width.max(1)).enumerate() {
            columns.spread(|own| contact_entry(contact.hessian, axis, own), 1.0, row);
        }
        for (sums, n) in self.normals.iter_mut().zip(functions) {
            sums.iter_mut().zip(&by_nodes).for_each(|(sum, by)| *sum += point.weight * n * by);
        }
        // A pressure of one, and the traction that goes with it.
        let load = traction.map_or(direction, |traction| (Vector3::from(direction) + traction).into());
        let Some(force) = over.carried(view.positions, x, load, mode) else {
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
                    // Forces are linear in a traction and a pressure that grow together, not in either of them.
                    let by_pressure = if is_moved {
                        let by = &force.row(3 * own + axis)[3..6];
                        for (sums, by) in self.friction[corner].iter_mut().zip(by) {
                            sums[3 * row + axis] += weight * part * by;
                        }
                        by.iter().zip(direction).map(|(by, d)| by * d).sum()
                    } else {
                        force.forces[own][axis]
                    };
                    self.forces[corner][3 * row + axis] += weight * part * by_pressure;
                }
            }
        }
        if needs_hessian && pressure != 0.0 {
            let of_line = Line { force: &force, by_along: &by_along, along_by_nodes: &by_nodes };
            self.add_directions(of_line, &columns, &carriers, &point.functions, point.weight * pressure);
        }
    }

    /// The chain rule: the forces by point, direction and facet; point and direction by the nodes.
    fn add_directions(
        &mut self,
        line_of_force: Line<'_>,
        columns: &Columns<'_>,
        carriers: &[(usize, usize, f64)],
        functions: &[f64; MOST_NODES],
        load: f64,
    ) {
        let width = self.gradients[0].len();
        let Line { force, by_along, along_by_nodes } = line_of_force;
        let mut rows = Vec::with_capacity(3 * carriers.len());
        for &(row, own, part) in carriers {
            let factor = -load * part;
            for axis in 0..3 {
                let (row, by) = (3 * row + axis, force.row(3 * own + axis));
                let of_direction =
                    [0, 1, 2].map(|k| factor * (0..3).map(|j| by[3 + j] * by_along[j][k]).sum::<f64>());
                rows.push((row, of_direction));
                let target = &mut self.directions[row * width..][..width];
                for k in 0..3 {
                    for (&place, n) in columns.face.iter().zip(functions) {
                        target[3 * place + k] += factor * (n * by[k]);
                    }
                    for (node, &place) in columns.facet.iter().enumerate() {
                        target[3 * place + k] += factor * by[6 + 3 * node + k];
                    }
                }
            }
        }
        let target = &mut self.directions[..];
        Isa::best().run(Combinations { rows: &rows, along_by_nodes, width, target });
    }
}

/// Combinations of three rows, each added to a row of a matrix.
struct Combinations<'a> {
    /// The row that is added to, and the factors.
    rows: &'a [(usize, [f64; 3])],
    along_by_nodes: &'a [f64],
    width: usize,
    target: &'a mut [f64],
}

impl WithLanes for Combinations<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Vector>(self) {
        let Self { rows, along_by_nodes, width, target } = self;
        let whole = width - width % T::WIDTH;
        for &(row, [a, b, c]) in rows {
            let target = &mut target[width * row..][..width];
            let (x, y, z) = (T::splat(a), T::splat(b), T::splat(c));
            let mut place = 0;
            while place < whole {
                let sum = x.mul_add(T::load(along_by_nodes, place), T::load(target, place));
                let sum = y.mul_add(T::load(along_by_nodes, width + place), sum);
                let sum = z.mul_add(T::load(along_by_nodes, 2 * width + place), sum);
                sum.store(target, place);
                place += T::WIDTH;
            }
            for place in whole..width {
                let [x, y, z] = [0, 1, 2].map(|k| along_by_nodes[k * width + place]);
                target[place] += a * x + b * y + c * z;
            }
        }
    }
}
