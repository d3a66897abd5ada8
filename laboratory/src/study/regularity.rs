//! What the least regularity of a fit costs and gains, on irregular meshes whose heights are off.
//!
//! Slaves sit at random on the surface without the errors, so that their exact gap is 0, and slide on from there.

use std::collections::HashMap;

use diffuse_contact::interface::{ContactElement, ContactInterface, InterfaceOptions, Outcome};
use diffuse_contact::neighbourhood::{Fallback, SMALLEST_REGULARITY, SearchOptions};
use diffuse_contact::surface::Facet;
use diffuse_contact::{Mode, Point};
use diffuse_contact_benches::Random;
use serde::Serialize;
use spade::{DelaunayTriangulation, Triangulation};

use super::arguments::RegularityArguments;
use super::markdown::Table;
use super::patch::Patch;
use super::{StudyError, paired};
use crate::error::CliError;
use crate::output;

/// Heights of nodes are off by up to this, in short sides of a cell.
const BUMPS: f64 = 0.05;
/// Radius of the paraboloid that the nodes would lie on.
const RADIUS: f64 = 10.0;
/// Slaves on each mesh, not so close to its border that bumps take the foot over it.
const SLAVES: usize = 500;
const MARGIN: f64 = 0.05;
/// Times that slaves slide on, each by so much.
const STEPS: usize = 2;
const STEP: f64 = 0.15;
const BOUNDS: [f64; 4] = [SMALLEST_REGULARITY, 0.02, 0.05, 0.1];

/// Meshes over a rectangle.
struct Kind {
    name: &'static str,
    cells: [usize; 2],
    side: Point2,
    /// How far nodes are moved at random, over the sides of a cell; on the border along it only.
    moved: f64,
    /// Triangles of Delaunay in place of quadrilaterals.
    triangles: bool,
}

type Point2 = [f64; 2];

const KINDS: [Kind; 5] = [
    Kind::square("quadrilaterals, moved by 8 %", [12; 2], 0.08),
    Kind::square("quadrilaterals, 20 %", [12; 2], 0.2),
    Kind { side: [3.0, 1.0], ..Kind::square("quadrilaterals 3:1, 8 %", [12; 2], 0.08) },
    Kind { triangles: true, ..Kind::square("triangles, 35 %", [12; 2], 0.35) },
    Kind::square("a strip of two rows, 30 %", [24, 2], 0.3),
];

impl Kind {
    const fn square(name: &'static str, cells: [usize; 2], moved: f64) -> Self {
        Self { name, cells, side: [1.0; 2], moved, triangles: false }
    }

    fn size(&self) -> Point2 {
        [0, 1].map(|axis| self.cells[axis] as f64 * self.side[axis])
    }

    /// The surface without bumps.
    fn point(&self, at: Point2) -> Point {
        let square: f64 = (0..2).map(|axis| (at[axis] - 0.5 * self.size()[axis]).powi(2)).sum();
        [at[0], at[1], -square / (2.0 * RADIUS)]
    }

    /// At least a cell away from the border.
    fn is_interior(&self, at: Point2) -> bool {
        (0..2).all(|axis| at[axis] > self.side[axis] && self.size()[axis] - at[axis] > self.side[axis])
    }

    fn mesh(&self, random: &mut Random) -> Patch {
        let stride = self.cells[0] + 1;
        let moves: Vec<Point> =
            (0..stride * (self.cells[1] + 1)).map(|_| std::array::from_fn(|_| random.signed())).collect();
        let mut patch = Patch::new(self.cells, |i, j| {
            let by = moves[i as usize + stride * j as usize];
            let at = [0, 1].map(|axis| {
                let place = [i, j][axis];
                let is_inside = place > 0.0 && place < self.cells[axis] as f64;
                self.side[axis] * (place + if is_inside { self.moved * by[axis] } else { 0.0 })
            });
            let [x, y, z] = self.point(at);
            [x, y, z + BUMPS * by[2]]
        });
        if self.triangles {
            patch.facets = triangulated(&patch.positions);
        }
        patch
    }
}

fn triangulated(positions: &[Point]) -> Vec<Facet> {
    let mut triangulation = DelaunayTriangulation::<spade::Point2<f64>>::new();
    let insert = |(k, x): (usize, &Point)| {
        // Nodes of a grid that are moved by less than half a cell are finite and apart.
        triangulation.insert(spade::Point2::new(x[0], x[1])).ok().map(|handle| (handle, k))
    };
    let nodes: HashMap<_, _> = positions.iter().enumerate().filter_map(insert).collect();
    let faces = triangulation.inner_faces().map(|face| face.vertices().map(|vertex| nodes[&vertex.fix()]));
    faces.map(Facet::Triangle).collect()
}

/// What was found with one bound on meshes of one kind.
#[derive(Default)]
struct Found {
    /// Sums of |∂gap/∂height| over the masters: by how much errors of the heights are enlarged.
    enlarged: Vec<f64>,
    square_gaps: f64,
    masters: usize,
    /// Inside, and at the border.
    slaves: [usize; 2],
    linear: [usize; 2],
    /// Of slaves that were paired with others.
    square_jumps: f64,
    largest_jump: f64,
    jumps: usize,
}

/// The same in numbers.
#[derive(Debug, Serialize)]
struct Row {
    mesh: &'static str,
    bound: f64,
    /// 99 % of all, all.
    enlarged_by: [f64; 2],
    rms_error: f64,
    masters: f64,
    /// Inside, at the border.
    linear_percent: [f64; 2],
    rms_jump: f64,
    largest_jump: f64,
}

/// Measures and prints.
pub fn run(arguments: &RegularityArguments) -> Result<(), CliError> {
    let mut rows = Vec::new();
    for kind in &KINDS {
        for bound in BOUNDS {
            let mut found = Found::default();
            for mesh in 0..u64::from(arguments.meshes) {
                found.add(kind, bound, &mut Random::new(&[mesh]))?;
            }
            rows.push(found.row(kind.name, bound));
        }
    }
    if arguments.json {
        return output::write_json(&rows);
    }
    let heading = format!("{SLAVES} slaves on each of {} meshes of a kind, at random", arguments.meshes);
    let columns = "mesh | bound | enlarged by: 99 %, all | rms error | masters | \
                   linear: inside, border, % | jump: rms, largest";
    let mut table = Table::new(heading, columns);
    for Row { mesh, bound, enlarged_by, rms_error, masters, linear_percent, rms_jump, largest_jump } in rows {
        let [enlarged, linear] =
            [enlarged_by, linear_percent].map(|[one, other]| format!("{one:.1}, {other:.1}"));
        table.row(format!(
            "{mesh} | {bound} | {enlarged} | {rms_error:.4} | {masters:.1} | {linear} | \
             {rms_jump:.4}, {largest_jump:.3}"
        ));
    }
    output::write_stdout(|writer| write!(writer, "{table}"))
}

impl Found {
    fn add(&mut self, kind: &Kind, bound: f64, random: &mut Random) -> Result<(), StudyError> {
        let Patch { positions, facets } = kind.mesh(random);
        let (masters, size) = (positions.len(), kind.size());
        let mut at: Vec<Point2> =
            (0..SLAVES).map(|_| size.map(|size| random.between(MARGIN, size - MARGIN))).collect();
        let search = SearchOptions::default().with_smallest_regularity(bound);
        let options = InterfaceOptions::default().with_element(ContactElement::diffuse(search));
        let points = at.iter().map(|&at| kind.point(at));
        let (mut interface, mut positions) = paired(positions, facets, points, options)?;
        self.add_fits(kind, &mut interface, &at)?;
        // They slide on, each its own way and back from the border.
        let turns: Vec<f64> = (0..SLAVES).map(|_| random.between(0.0, std::f64::consts::TAU)).collect();
        for _ in 0..STEPS {
            for (at, turn) in at.iter_mut().zip(&turns) {
                for (axis, way) in [turn.cos(), turn.sin()].into_iter().enumerate() {
                    let x = (at[axis] + STEP * way).abs();
                    at[axis] = if x > size[axis] { 2.0 * size[axis] - x } else { x };
                }
            }
            positions.truncate(masters);
            positions.extend(at.iter().map(|&at| kind.point(at)));
            self.add_jumps(&mut interface, &positions)?;
        }
        Ok(())
    }

    fn add_fits(
        &mut self,
        kind: &Kind,
        interface: &mut ContactInterface,
        at: &[Point2],
    ) -> Result<(), StudyError> {
        for (contact, &at) in interface.evaluate(Mode::Gradient)?.iter().zip(at) {
            let fallback = match contact.outcome {
                Outcome::Contact { fallback } => fallback,
                Outcome::None(reason) => {
                    let case = kind.name.to_owned();
                    return Err(StudyError::NoContact { case, slave: contact.slave, reason });
                }
            };
            let zone = usize::from(!kind.is_interior(at));
            self.slaves[zone] += 1;
            self.linear[zone] += usize::from(matches!(fallback, Fallback::Linear { .. }));
            let normal = contact.point.normal;
            let by_height = |node: &[f64]| (0..3).map(|axis| node[axis] * normal[axis]).sum::<f64>().abs();
            self.enlarged.push(contact.gradient[3..].chunks(3).map(by_height).sum());
            self.square_gaps += contact.point.gap.powi(2);
            self.masters += contact.nodes.len();
        }
        Ok(())
    }

    /// What a refresh does to the gaps at these positions.
    fn add_jumps(&mut self, interface: &mut ContactInterface, positions: &[Point]) -> Result<(), StudyError> {
        interface.update(positions)?;
        let gaps = |interface: &mut ContactInterface| -> Result<Vec<(bool, f64, Vec<u32>)>, StudyError> {
            let contacts = interface.evaluate(Mode::Value)?.iter();
            Ok(contacts.map(|one| (one.outcome.is_contact(), one.point.gap, one.nodes.to_vec())).collect())
        };
        let before = gaps(interface)?;
        interface.refresh_pairing(positions)?;
        for (old, new) in before.iter().zip(gaps(interface)?) {
            if old.0 && new.0 && old.2 != new.2 {
                let jump = (new.1 - old.1).abs();
                self.jumps += 1;
                self.square_jumps += jump * jump;
                self.largest_jump = self.largest_jump.max(jump);
            }
        }
        Ok(())
    }

    fn row(&mut self, mesh: &'static str, bound: f64) -> Row {
        self.enlarged.sort_by(f64::total_cmp);
        let count = self.enlarged.len();
        Row {
            mesh,
            bound,
            enlarged_by: [self.enlarged[count * 99 / 100], self.enlarged[count - 1]],
            rms_error: (self.square_gaps / count as f64).sqrt(),
            masters: self.masters as f64 / count as f64,
            linear_percent: [0, 1].map(|k| 100.0 * self.linear[k] as f64 / self.slaves[k].max(1) as f64),
            rms_jump: (self.square_jumps / self.jumps.max(1) as f64).sqrt(),
            largest_jump: self.largest_jump,
        }
    }
}
