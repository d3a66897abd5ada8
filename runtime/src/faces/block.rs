//! The contribution of one slave face: forces by unit pressures and tractions of its corners, gradients of their gaps, and what the
//! directions of the forces add to the tangent.

use std::sync::{Mutex, PoisonError};

use diffuse_contact_kernels::support::{Isa, Vector, WithLanes};

use super::carried::{Carried, PointLoad, direction_along, load_of_point};
use super::cut::FacePoint;
use super::quadratic::{Carrying, MOST_NODES};
use super::skin::Skin;
use crate::friction::NormalForce;
use crate::interface::{ContactInterface, FitPoint, InterfaceError, back, reserve};
use crate::surface::{Facet, Image, Shape};
use crate::vector::Vector3;
use crate::{Mode, Point};

/// A block's memory is at most so many times what it needs.
const MOST_SPARE: usize = 4;

/// What a face needs to know of itself.
pub struct FaceView<'a> {
    pub facet: &'a Facet,
    pub shape: Shape,
    /// What carries its forces.
    pub carrying: &'a Carrying,
    /// Of all nodes.
    pub positions: &'a [Point],
    pub skin: &'a Skin,
    pub interface: &'a ContactInterface,
    /// The face's number.
    pub face: usize,
    /// Nodes that forces act on, ascending: those of the face and of the facets over it.
    pub rows: &'a [u32],
    /// Nodes that forces depend on, ascending.
    pub columns: &'a [u32],
    pub load: FaceLoad,
    /// Of all points, if they have pressures of their own.
    pub pressures: &'a [NormalForce],
    pub places: FacePlaces<'a>,
}

/// The contact of a point.
pub struct PointContact<'a> {
    /// The points of its element.
    pub points: &'a [FitPoint],
    /// N by the point and these.
    pub gradient: &'a [f64],
    /// Derivatives of ∂g/∂x of the point by the same, three rows; empty below Hessian mode.
    pub slave_rows: &'a [f64],
}

/// A column, and the image that its node is, if it is one.
type Column<'a> = (usize, Option<&'a Image>);

/// Where a face's nodes are found, at any of its points.
pub struct FacePlaces<'a> {
    /// The skin's carriers in the columns.
    skin: Vec<Column<'a>>,
    /// The nodes that carry the face's forces.
    own: Vec<Place>,
}

/// Where a node is in the rows and in the columns.
#[derive(Clone, Copy, Debug)]
struct Place {
    row: usize,
    column: usize,
}

impl Place {
    fn of(node: usize, rows: &[u32], columns: &[u32]) -> Self {
        Self { row: place(rows, node as u32), column: place(columns, node as u32) }
    }
}

impl<'a> FacePlaces<'a> {
    /// Of the face with this number.
    pub fn new(skin: &'a Skin, face: usize, carrying: &Carrying, rows: &[u32], columns: &[u32]) -> Self {
        let carriers = skin.faces[face].carriers.iter();
        Self {
            skin: carriers.map(|&carrier| (place(columns, carrier.node), skin.image(carrier))).collect(),
            own: carrying.nodes().iter().map(|&node| Place::of(node, rows, columns)).collect(),
        }
    }
}

/// Where a node is in a list that has it.
pub fn place(list: &[u32], node: u32) -> usize {
    list.binary_search(&node)
        .unwrap_or_else(|_| unreachable!("lists hold all nodes of their points and histories"))
}

/// What goes from point to point.
#[derive(Default)]
pub struct PointScratch<'a> {
    /// What each of the skin's carriers has of the point.
    weights: Vec<f64>,
    /// The nodes of the contact's points in the columns, with the point and the part that they have of it.
    masters: Vec<(Column<'a>, usize, f64)>,
    /// ∂g/∂x by the columns that it depends on.
    gradient: Vec<(usize, Point)>,
    /// Face and facet that `over` belongs to.
    of: Option<(usize, u32)>,
    /// The nodes that carry the facet's forces.
    over: Vec<Place>,
    /// Derivatives of ∂g/∂x of the slave by the columns: three rows.
    along_by_nodes: Vec<f64>,
    /// Who carries the point's force: row, which part of it, and the factor.
    carriers: Vec<(usize, usize, f64)>,
    /// Rows that the turning of the force is added to.
    rows: Vec<(usize, [f64; 3])>,
}

impl<'a> PointScratch<'a> {
    /// Finds what there is of a point.
    fn look(&mut self, view: &FaceView<'a>, point: &FacePoint, over: &Carrying, contact: &PointContact<'_>) {
        self.weights.clear();
        self.weights.extend(view.skin.faces[view.face].weights(point.natural));
        // Nodes ascend as columns do, but for those of a facet by itself.
        let mut next = 0;
        self.masters.clear();
        let parts =
            (0..).zip(contact.points).flat_map(|(k, point)| point.carriers().map(move |part| (k, part)));
        self.masters.extend(parts.map(|(k, (carrier, part))| {
            let node = carrier.node;
            let found = view.columns[next..].iter().position(|&column| column >= node);
            let at = found.map_or(0, |more| next + more);
            next = if view.columns[at] == node { at } else { place(view.columns, node) };
            ((next, view.interface.image_of(carrier)), k, part)
        }));
        let of = Some((view.face, point.facet));
        if self.of != of {
            self.of = of;
            self.over.clear();
            self.over.extend(over.nodes().iter().map(|&node| Place::of(node, view.rows, view.columns)));
        }
        self.carriers.clear();
        let own = view.places.own.iter().zip(point.functions);
        self.carriers.extend(own.map(|(place, n)| (place.row, 0, n)));
        self.carriers.extend(self.over.iter().enumerate().map(|(k, place)| (place.row, k + 1, -1.0)));
    }
}

/// What the corners of a face carry.
#[derive(Clone, Copy, Debug, Default)]
pub struct FaceLoad {
    /// Force per area.
    pub pressures: [f64; 4],
    /// Friction, force per area, or over the pressure where points have theirs; `None` if no corner has a history of it.
    pub tractions: Option<[Point; 4]>,
}

impl FaceLoad {
    /// The pressure at a point with these shape functions, and the traction over it. `own`: its own pressure, if it has one.
    fn at(&self, functions: &[f64; 4], own: Option<&NormalForce>) -> (f64, Option<Vector3>) {
        let of_corners = || functions.iter().zip(&self.pressures).map(|(n, p)| n * p).sum();
        let pressure = own.map_or_else(of_corners, |own| own.force);
        let over = if own.is_some() { 1.0 } else { pressure };
        let traction = self.tractions.filter(|_| pressure > 0.0).map(|tractions| {
            let sum = functions.iter().zip(tractions);
            sum.fold(Vector3::zeros(), |sum, (&n, t)| sum + Vector3::from(t) * n) / over
        });
        (pressure, traction)
    }
}

/// The sums over a face's points.
#[derive(Clone, Debug, Default)]
pub struct FaceBlock {
    /// By unit pressure of each corner: what it exerts on the rows' nodes, length². Empty with pressures of points.
    pub forces: [Vec<f64>; 4],
    /// By each component of the traction of each corner: the same; empty without friction. With pressures of points by the traction over
    /// the pressure, force.
    pub friction: [[Vec<f64>; 3]; 4],
    /// ∫ N_A ∂g/∂x dA by the columns' nodes, length². With pressures of points ∫ N_A ε ∂g/∂x dA.
    pub gradients: [Vec<f64>; 4],
    /// What pressures of points exert on the rows' nodes, without friction.
    pub pressed: Vec<f64>,
    /// ∫ ε R ∂g/∂x dA, R the force at unit pressure with its friction: a row per coordinate of the rows' nodes. Empty without pressures of points.
    pub by_gaps: Vec<f64>,
    /// ∂/∂x of ∫ N_A ∂g/∂x_s dA, x_s the points of the slave: three rows by the columns' nodes, length; empty without friction.
    pub normals: [Vec<f64>; 4],
    /// −∂R/∂x with pressures and tractions held, a row per coordinate of the rows' nodes; empty below Hessian mode.
    pub directions: Vec<f64>,
    /// Points whose line of force meets no place of their facet, or whose derivatives overflow: they count for the gap, but carry no force.
    pub missed: usize,
}

/// Where the derivatives of a point's gap and normal are found among those by all columns.
struct Columns<'a> {
    /// Of the skin's carriers.
    skin: &'a [Column<'a>],
    /// What each of them has of the point.
    weights: &'a [f64],
    /// Of the nodes of the contact's points, with the point and their part of it.
    masters: &'a [(Column<'a>, usize, f64)],
}

/// What a point has of its face.
struct PointShare<'a> {
    /// Its area.
    weight: f64,
    /// What each corner has of it.
    areas: &'a [f64],
    /// Its own pressure, if it has one.
    own: Option<&'a NormalForce>,
    /// ∂g/∂x by the columns.
    gradient: &'a [(usize, Point)],
    /// The force at unit pressure by the friction over it, where that is not the traction itself.
    by_ratio: Option<[Point; 3]>,
}

/// A force with its derivatives, and those of its line.
struct Line<'a> {
    force: &'a Carried,
    /// Of the direction, or of the force at unit pressure, by ∂g/∂x of the slave.
    by_along: &'a [Point; 3],
    /// ∂g/∂x of the slave by the columns: three rows.
    along_by_nodes: &'a [f64],
}

impl Columns<'_> {
    /// Hands over a derivative by the contact's point and carriers as one by columns; some come more than once.
    fn spread(&self, own: &[f64], mut f: impl FnMut(usize, Point)) {
        let (own, _) = own.as_chunks::<3>();
        for (&(place, image), weight) in self.skin.iter().zip(self.weights) {
            f(place, back(image, own[0]).map(|value| weight * value));
        }
        for &((place, image), point, part) in self.masters {
            f(place, back(image, own[point + 1]).map(|value| part * value));
        }
    }

    /// The slave's rows of M by `width` coordinates of the columns; `rows` is empty before.
    fn spread_rows(&self, contact: &PointContact<'_>, width: usize, rows: &mut Vec<f64>) {
        rows.resize(3 * width, 0.0);
        let by_contact = contact.slave_rows.chunks_exact(contact.gradient.len());
        for (row, own) in rows.chunks_exact_mut(width.max(1)).zip(by_contact) {
            let row = row.as_chunks_mut::<3>().0;
            self.spread(own, |place, by| {
                row[place].iter_mut().zip(by).for_each(|(sum, by)| *sum += by);
            });
        }
    }
}

impl FaceBlock {
    /// No points yet. `memory`: of blocks of before.
    ///
    /// # Errors
    /// [`InterfaceError::OutOfMemory`].
    pub fn new(
        view: &FaceView<'_>,
        mode: Mode,
        memory: &Mutex<Vec<Vec<f64>>>,
    ) -> Result<Self, InterfaceError> {
        let (rows, columns) = (3 * view.rows.len(), 3 * view.columns.len());
        let of_corners = |count: usize| std::array::from_fn(|_| vec![0.0; count]);
        let matrix = || {
            let mut entries: Vec<f64> =
                memory.lock().unwrap_or_else(PoisonError::into_inner).pop().unwrap_or_default();
            entries.clear();
            let count = rows.saturating_mul(columns);
            // Blocks change hands: small ones must not keep the memory of large ones, until all have it.
            if entries.capacity() > MOST_SPARE * count {
                entries = Vec::new();
            }
            reserve(&mut entries, count)?;
            entries.resize(rows * columns, 0.0);
            Ok::<_, InterfaceError>(entries)
        };
        let mut block = Self { gradients: of_corners(columns), ..Self::default() };
        if view.pressures.is_empty() {
            block.forces = of_corners(rows);
        } else {
            (block.pressed, block.by_gaps) = (vec![0.0; rows], matrix()?);
        }
        if mode >= Mode::Hessian {
            block.directions = matrix()?;
        }
        if view.load.tractions.is_some() {
            block.friction = std::array::from_fn(|_| std::array::from_fn(|_| vec![0.0; rows]));
            if mode >= Mode::Hessian {
                block.normals = of_corners(3 * columns);
            }
        }
        Ok(block)
    }

    /// Adds a point with this number. `over`: what carries the forces of the facet over it.
    pub fn add<'a>(
        &mut self,
        view: &FaceView<'a>,
        (index, point): (usize, &FacePoint),
        over: &Carrying,
        contact: &PointContact<'_>,
        scratch: &mut PointScratch<'a>,
    ) {
        scratch.look(view, point, over, contact);
        let PointScratch { weights, masters, gradient, over: facet, along_by_nodes, carriers, rows, .. } =
            scratch;
        let functions = view.shape.functions(point.natural);
        let along = [contact.gradient[0], contact.gradient[1], contact.gradient[2]];
        // Where the point is on what carries it.
        let x = view.carrying.point(&point.functions, view.positions);
        let columns = Columns { skin: &view.places.skin, weights, masters };
        gradient.clear();
        columns.spread(contact.gradient, |place, by| gradient.push((place, by)));
        // What each corner has of the point's area.
        let areas = functions.map(|n| point.weight * n);
        let corners = view.facet.corners().len();
        let own = view.pressures.get(index);
        let gap_areas = own.map_or(areas, |own| areas.map(|area| area * own.stiffness));
        self.add_gradient(&gap_areas[..corners], gradient);
        let (direction, by_along) = direction_along(along);
        let (pressure, traction) = view.load.at(&functions, own);
        let (needs_hessian, is_moved) = (!self.directions.is_empty(), traction.is_some());
        // The direction is along ∂g/∂x of the slave: its derivatives are the slave's rows of M.
        along_by_nodes.clear();
        if needs_hessian {
            columns.spread_rows(contact, self.gradients[0].len(), along_by_nodes);
        }
        for (sums, area) in self.normals.iter_mut().zip(areas) {
            sums.iter_mut().zip(&*along_by_nodes).for_each(|(sum, by)| *sum += area * by);
        }
        // A pressure of one, and the traction that goes with it. What nodes have of it need not lie across a point's direction.
        let across = traction.filter(|_| own.is_some()).map(|ratio| load_of_point(along, ratio.into()));
        let load = match (&across, traction) {
            (Some(across), _) => across.load,
            (None, Some(traction)) => (Vector3::from(direction) + traction).into(),
            (None, None) => direction,
        };
        let mode = if needs_hessian || is_moved { Mode::Gradient } else { Mode::Value };
        if own.is_some_and(|own| !(own.force > 0.0)) {
            // Only its normal counts.
            return;
        }
        let Some(force) = over.carried(view.positions, x, load, mode) else {
            self.missed += 1;
            return;
        };
        let by_ratio = across.as_ref().map(|across| across.by_ratio);
        let share = PointShare { weight: point.weight, areas: &areas[..corners], own, gradient, by_ratio };
        self.add_forces(share, carriers, &force, is_moved.then_some(direction));
        if needs_hessian && pressure != 0.0 {
            let by_along = across.map_or(by_along, |PointLoad { by_along, .. }| by_along);
            let of_line = Line { force: &force, by_along: &by_along, along_by_nodes };
            let load = point.weight * pressure;
            let held = (&view.places.own[..], &facet[..], &point.functions);
            self.add_directions(of_line, held, carriers, load, rows);
        }
    }

    /// Adds a point's ∂g/∂x to those of the corners, which have these areas of it.
    fn add_gradient(&mut self, areas: &[f64], gradient: &[(usize, Point)]) {
        for (sums, area) in self.gradients.iter_mut().zip(areas) {
            let sums = sums.as_chunks_mut::<3>().0;
            for &(place, by) in gradient {
                sums[place].iter_mut().zip(by).for_each(|(sum, by)| *sum += area * by);
            }
        }
    }

    /// Adds a point's force: +N_a of it act on the nodes of the face, −N_k on those of the facet.
    /// `direction`: of the pressure, where friction moves the line of force away from it.
    fn add_forces(
        &mut self,
        PointShare { weight, areas, own, gradient, by_ratio }: PointShare<'_>,
        carriers: &[(usize, usize, f64)],
        force: &Carried,
        direction: Option<Point>,
    ) {
        let width = self.gradients[0].len();
        let of_traction = own.map_or(1.0, |own| own.force);
        for &(node, of, part) in carriers {
            for axis in 0..3 {
                let row = 3 * node + axis;
                // Forces are linear in a traction and a pressure that grow together, not in either of them.
                let by_pressure = if let Some(direction) = direction {
                    let by = &force.row(3 * of + axis)[3..6];
                    let by_traction = by_ratio.map_or([by[0], by[1], by[2]], |by_ratio| {
                        [0, 1, 2].map(|i| (0..3).map(|j| by[j] * by_ratio[j][i]).sum())
                    });
                    for (sums, area) in self.friction.iter_mut().zip(areas) {
                        let by = sums.iter_mut().zip(by_traction);
                        by.for_each(|(sums, by)| sums[row] += area * of_traction * part * by);
                    }
                    by.iter().zip(direction).map(|(by, d)| by * d).sum()
                } else {
                    force.forces[of][axis]
                };
                let Some(own) = own else {
                    let corners = self.forces.iter_mut().zip(areas);
                    corners.for_each(|(sums, area)| sums[row] += area * part * by_pressure);
                    continue;
                };
                self.pressed[row] += weight * own.force * part * by_pressure;
                let factor = weight * own.stiffness * part * force.forces[of][axis];
                let entries = self.by_gaps[row * width..][..width].as_chunks_mut::<3>().0;
                for &(place, by) in gradient {
                    entries[place].iter_mut().zip(by).for_each(|(sum, by)| *sum += factor * by);
                }
            }
        }
    }

    /// The chain rule: the forces by point, direction and facet; point and direction by the nodes.
    fn add_directions(
        &mut self,
        line_of_force: Line<'_>,
        (own, facet, functions): (&[Place], &[Place], &[f64; MOST_NODES]),
        carriers: &[(usize, usize, f64)],
        load: f64,
        rows: &mut Vec<(usize, [f64; 3])>,
    ) {
        let width = self.gradients[0].len();
        let Line { force, by_along, along_by_nodes } = line_of_force;
        rows.clear();
        for &(row, part, sign) in carriers {
            let factor = -load * sign;
            for axis in 0..3 {
                let (row, by) = (3 * row + axis, force.row(3 * part + axis));
                let of_direction =
                    [0, 1, 2].map(|k| factor * (0..3).map(|j| by[3 + j] * by_along[j][k]).sum::<f64>());
                rows.push((row, of_direction));
                if part == 0 {
                    // The force itself: it does not depend on where the nodes are.
                    continue;
                }
                let target = self.directions[row * width..][..width].as_chunks_mut::<3>().0;
                for (place, n) in own.iter().zip(functions) {
                    for (sum, by) in target[place.column].iter_mut().zip(by) {
                        *sum += factor * (n * by);
                    }
                }
                for (place, by) in facet.iter().zip(by[6..].as_chunks::<3>().0) {
                    for (sum, by) in target[place.column].iter_mut().zip(by) {
                        *sum += factor * by;
                    }
                }
            }
        }
        let target = &mut self.directions[..];
        Isa::best().run(Combinations { rows, along_by_nodes, width, target });
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
