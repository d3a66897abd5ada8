//! What domains of influence carry: masters of a slave, the conditioning of its fit and its error, on meshes of all kinds.
//!
//! Slave nodes sit at random on the exact surface, all over the mesh and up to its border.

use diffuse_contact::interface::{ContactInterface, InterfaceOptions, Outcome, PairedElement};
use diffuse_contact::pairing::Pairing;
use diffuse_contact::{Basis, Mode, Point, Weight};
use diffuse_contact_benches::Random;
use nalgebra::{DMatrix, SymmetricEigen};
use serde::Serialize;

use super::arguments::DomainsArguments;
use super::markdown::Table;
use super::patch::Patch;
use super::{StudyError, paired};
use crate::error::CliError;
use crate::output;

/// Height of the waves of the surface, and their length along both axes in cells.
const AMPLITUDE: f64 = 1.0;
const WAVELENGTH: f64 = 12.0;

/// A mesh over the plane.
struct Shape {
    name: &'static str,
    cells: [usize; 2],
    /// Sides of a cell, before grading.
    side: Point2,
    /// How far nodes are moved at random, over the sides of a cell.
    moved: f64,
    /// Columns and rows beyond the first of these are so many times larger.
    graded: Option<(usize, f64)>,
}

type Point2 = [f64; 2];

impl Shape {
    const fn square(name: &'static str, cells: [usize; 2], moved: f64) -> Self {
        Self { name, cells, side: [1.0; 2], moved, graded: None }
    }

    /// Cells whose sides have this ratio.
    const fn stretched(name: &'static str, ratio: f64, moved: f64) -> Self {
        Self { name, cells: [12; 2], side: [ratio, 1.0], moved, graded: None }
    }

    /// Cells with sides of 0.25, and of 1 beyond the first of these.
    const fn graded(name: &'static str, moved: f64) -> Self {
        Self { name, cells: [16; 2], side: [0.25; 2], moved, graded: Some((8, 4.0)) }
    }

    fn all() -> [Self; 8] {
        [
            Self::square("regular, 12 × 12", [12; 2], 0.0),
            Self::square("nodes moved by 20 %", [12; 2], 0.2),
            Self::square("nodes moved by 35 %", [12; 2], 0.35),
            Self::square("strip, 24 × 2", [24, 2], 0.0),
            Self::stretched("cells 3:1, moved by 8 %", 3.0, 0.08),
            Self::stretched("cells 10:1", 10.0, 0.0),
            Self::graded("0.25 next to 1", 0.0),
            Self::graded("0.25 next to 1, moved by 8 %", 0.08),
        ]
    }

    /// Where a line of the grid is.
    fn line(&self, axis: usize, index: f64) -> f64 {
        let (first, factor) =
            self.graded.map_or((f64::INFINITY, 1.0), |(first, factor)| (first as f64, factor));
        self.side[axis] * (index.min(first) + factor * (index - first).max(0.0))
    }

    fn size(&self) -> Point2 {
        [0, 1].map(|axis| self.line(axis, self.cells[axis] as f64))
    }

    /// The exact height; a wave is so many cells long along each axis.
    fn height(&self, [x, y]: Point2) -> f64 {
        let wave = std::f64::consts::TAU / WAVELENGTH;
        let side = if self.graded.is_some() { [1.0; 2] } else { self.side };
        AMPLITUDE * (wave * x / side[0]).sin() * (wave * y / side[1]).cos()
    }

    fn patch(&self) -> Patch {
        let mut random = Random::new(&[1]);
        let stride = self.cells[0] + 1;
        let moves: Vec<Point2> =
            (0..stride * (self.cells[1] + 1)).map(|_| [random.signed(), random.signed()]).collect();
        Patch::new(self.cells, |i, j| {
            let by = moves[i as usize + stride * j as usize];
            let place = [i, j].map(f64::from);
            let at: Point2 = std::array::from_fn(|axis| {
                let [before, here, after] = [-1.0, 0.0, 1.0].map(|step| self.line(axis, place[axis] + step));
                let is_inside = place[axis] > 0.0 && place[axis] < self.cells[axis] as f64;
                let room = if is_inside { (here - before).min(after - here) } else { 0.0 };
                here + self.moved * room * by[axis]
            });
            [at[0], at[1], self.height(at)]
        })
    }
}

/// What was found on a mesh.
#[derive(Debug, Serialize)]
struct Found {
    mesh: &'static str,
    weight: &'static str,
    slaves: usize,
    masters_mean: f64,
    masters_max: usize,
    /// Smallest singular value of the weighted design matrix, columns of length one.
    singular_value: f64,
    /// Slaves whose masters carry the linear basis only.
    linear: usize,
    /// Root of the mean square of the gap, whose exact value is 0, over that of facets.
    error_over_facets: f64,
}

/// Measures and prints.
pub fn run(arguments: &DomainsArguments) -> Result<(), CliError> {
    let mut all = Vec::new();
    for shape in Shape::all() {
        for weight in Weight::ALL {
            all.push(measure(&shape, weight, arguments.slaves as usize)?);
        }
    }
    if arguments.json {
        return output::write_json(&all);
    }
    let heading = format!("{} slaves on each mesh, at random", arguments.slaves);
    let columns = "mesh | weight | masters, mean | masters, largest | smallest singular value | \
                   linear basis | rms error over that of facets";
    let mut table = Table::new(heading, columns);
    for Found {
        mesh, weight, masters_mean, masters_max, singular_value, linear, error_over_facets, ..
    } in all
    {
        table.row(format!(
            "{mesh} | {weight} | {masters_mean:.1} | {masters_max} | {singular_value:.3} | {linear} | \
             {error_over_facets:.3}"
        ));
    }
    output::write_stdout(|writer| write!(writer, "{table}"))
}

fn measure(shape: &Shape, weight: Weight, slaves: usize) -> Result<Found, StudyError> {
    let gaps = |options: InterfaceOptions| -> Result<(ContactInterface, f64), StudyError> {
        let Patch { positions, facets } = shape.patch();
        let mut random = Random::new(&[2]);
        let points = (0..slaves).map(|_| {
            let at = shape.size().map(|size| random.between(0.0, size));
            [at[0], at[1], shape.height(at)]
        });
        let (mut interface, _) = paired(positions, facets, points, options)?;
        let contacts = interface.evaluate(Mode::Value)?;
        let mut sum = 0.0;
        for contact in contacts.iter() {
            if let Outcome::None(reason) = contact.outcome {
                let case = format!("{}, {}", shape.name, weight.name());
                return Err(StudyError::NoContact { case, slave: contact.slave, reason });
            }
            sum += contact.point.gap * contact.point.gap;
        }
        Ok((interface, (sum / slaves as f64).sqrt()))
    };
    let (_, of_facets) = gaps(InterfaceOptions::node_to_facet())?;
    let options = InterfaceOptions::default();
    let (interface, error) = gaps(options.with_element(options.element.with_weight(weight)))?;
    let mut found = Found {
        mesh: shape.name,
        weight: weight.name(),
        slaves,
        masters_mean: 0.0,
        masters_max: 0,
        singular_value: f64::INFINITY,
        linear: 0,
        error_over_facets: error / of_facets,
    };
    for k in 0..slaves {
        let Ok(PairedElement::Diffuse { slave, pairing }) = interface.element(k) else { continue };
        let (count, singular_value) = carried(slave, &pairing);
        found.masters_mean += count as f64 / slaves as f64;
        found.masters_max = found.masters_max.max(count);
        found.singular_value = found.singular_value.min(singular_value);
        found.linear += usize::from(pairing.basis == Basis::Linear);
    }
    Ok(found)
}

/// The masters that have a weight, with domains of influence.
pub fn weighted(pairing: &Pairing) -> impl Iterator<Item = (Point, f64)> {
    let weights = pairing.material.iter().map(|node| pairing.weight.fitting(node.distance()));
    pairing.positions.iter().copied().zip(weights).filter(|&(_, weight)| weight > 0.0)
}

/// How many masters have a weight, and the smallest singular value of their fit.
fn carried(slave: Point, pairing: &Pairing) -> (usize, f64) {
    let rows: Vec<[f64; 6]> = weighted(pairing)
        .map(|(x, weight)| {
            let along = |axis: Point| {
                (0..3).map(|k| axis[k] * (x[k] - slave[k])).sum::<f64>() / pairing.support_radius
            };
            let [a, b] = [pairing.frame.t1, pairing.frame.t2].map(along);
            [1.0, a, b, a * a, a * b, b * b].map(|p| weight.sqrt() * p)
        })
        .collect();
    let size = if pairing.basis == Basis::Linear { 3 } else { 6 };
    let design = DMatrix::from_fn(rows.len(), size, |row, column| rows[row][column]);
    let lengths: Vec<f64> = design.column_iter().map(|column| column.norm()).collect();
    let gram = DMatrix::from_fn(size, size, |i, j| {
        design.column(i).dot(&design.column(j)) / (lengths[i] * lengths[j])
    });
    let smallest = SymmetricEigen::new(gram).eigenvalues.min();
    (rows.len(), smallest.max(0.0).sqrt())
}
