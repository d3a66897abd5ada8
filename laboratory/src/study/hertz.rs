//! A cylinder and a ball on a block, all of one material: nodal pressures over faces against Hertz', either side as slave, and the orders
//! at which their errors fall.
//!
//! Of both bodies there is what lies within many half widths of the contact, in a graded grid whose cells are equally long where they
//! touch. What lies farther away changes how far they approach, not the pressure at a force: that of the run is put into the closed form.

use clap::ValueEnum;
use diffuse_contact::faces::{FacePressures, FaceRule};
use diffuse_contact::surface::SymmetryPlane;
use diffuse_contact_solver::contact::{Integration, SlaveState};
use diffuse_contact_solver::deck::{Deck, Reference};
use diffuse_contact_solver::model::Model;
use diffuse_contact_solver::model::shape::Shape;
use diffuse_contact_solver::output::Fields;
use diffuse_contact_solver::solve::SolveError;
use diffuse_contact_solver::system::LinearSolverChoice;
use diffuse_contact_solver::verification::{LineContact, PointContact, trace_model};

use super::StudyError;
use super::arguments::{HertzArguments, HertzBody, name};
use super::markdown::Table;
use crate::error::CliError;
use crate::output;
use crate::threads::with_threads;

/// Both bodies are boxes of single cells in it.
const DECK: &str = include_str!("hertz.toml");
/// Of the deck's material, force per area.
const YOUNG: f64 = 200_000.0;
/// E* of two bodies of it, force per area.
const MODULUS: f64 = 0.5 * YOUNG / (1.0 - 0.3 * 0.3);
/// Length of the block's cells over that of the body's.
const FINER: f64 = 0.8;
/// From one cell to the next where they grow.
const GROWTH: f64 = 1.35;
/// Cells are equally long within so many half widths.
const UNIFORM: f64 = 1.3;
/// How far a curved body reaches from its axis, at most, radii.
const WIDEST: f64 = 0.9;
/// Nodes within so many half widths are compared.
const INNER: f64 = 0.85;

/// What is known of a body.
struct Case {
    name: String,
    /// Whether it is a slice in plane strain.
    is_slice: bool,
    /// About the half width of the contact at the end, length.
    half_width: f64,
    /// Of the curved body, length.
    radius: f64,
    /// How much of both bodies there is, half widths.
    extent: f64,
    /// What the far side of the body comes down by, length.
    approach: f64,
    /// Of the interface, over E/h of the curved body's cells.
    penalty: f64,
    pressures: FacePressures,
}

impl Case {
    /// The body as it is, or with another half width over radius, another extent or penalty, for meshes with so many cells.
    fn new(body: HertzBody, arguments: &HertzArguments, meshes: &[usize]) -> Result<Self, StudyError> {
        // Approaches over a²/R belong to the extents.
        let (is_slice, half_width, extent, approach) = match body {
            HertzBody::Cylinder => (true, 0.4, 20.0, 1.90625),
            HertzBody::Ball => (false, 0.5, 10.0, 0.96),
        };
        let radius = half_width / arguments.slenderness;
        let extent = arguments.extent.unwrap_or(extent);
        let sizes =
            meshes.iter().flat_map(|&cells| [1.0, FINER].map(|finer| finer * (half_width / cells as f64)));
        let uniform = sizes.map(|size| size * count(size, UNIFORM * half_width) as f64);
        let least = uniform.fold(0.0, f64::max) / half_width;
        if extent <= least {
            return Err(StudyError::NarrowBody { extent, least });
        }
        // To the corner of its grid; the half width at the end may be a little more than planned.
        let widest = half_width * extent * if is_slice { 1.0 } else { 2.0_f64.sqrt() };
        if widest > WIDEST * radius {
            return Err(StudyError::WideBody { widest, radius });
        }
        let approach = approach * half_width * half_width / radius;
        let (name, penalty) = (name(body), arguments.penalty);
        let pressures = if arguments.points { FacePressures::Points } else { FacePressures::Nodes };
        Ok(Self { name, is_slice, half_width, radius, extent, approach, penalty, pressures })
    }

    /// From the line or the point of first touch.
    fn distance(&self, x: f64, y: f64) -> f64 {
        if self.is_slice { x } else { x.hypot(y) }
    }
}

/// Solves all of them and prints a table.
pub fn run(arguments: &HertzArguments) -> Result<(), CliError> {
    let bodies = if arguments.bodies.is_empty() { HertzBody::value_variants() } else { &arguments.bodies };
    let meshes: Vec<usize> = (0..arguments.meshes)
        .rev()
        .map(|k| (f64::from(arguments.finest) * (2.0_f64 / 3.0).powi(k as i32)).round() as usize)
        .collect();
    with_threads(arguments.threads, || {
        for body in bodies {
            let case = Case::new(*body, arguments, &meshes)?;
            let table = table(&case, &meshes, arguments.threads.unwrap_or(1)).map_err(CliError::job)?;
            output::write_stdout(|writer| writeln!(writer, "{table}"))?;
        }
        Ok(())
    })
}

fn table(case: &Case, meshes: &[usize], threads: usize) -> Result<Table, SolveError> {
    let columns = "slave | cells within a, body and block | force, N | a, mm | p₀, closed form, MPa | \
                   nodes within 0.85 a | rms | order | largest error | order | largest pressure | \
                   rms of p_A | iterations | cut-backs";
    let heading = format!("Hertz, {} and block elastic: errors of the nodal pressures over p₀", case.name);
    let mut table = Table::new(heading, columns);
    for exchange in [true, false] {
        let mut coarser: Option<(usize, Errors)> = None;
        for &cells in meshes {
            let run = press(case, cells, exchange, threads)?;
            let order = |of: fn(&Errors) -> f64| match &coarser {
                Some((before, errors)) => {
                    let order = (of(errors) / of(&run.errors)).ln() / (cells as f64 / *before as f64).ln();
                    format!("{order:.1}")
                }
                None => "–".to_owned(),
            };
            let percent = |ratio: f64| format!("{:+.2} %", 100.0 * ratio);
            let row = [
                if exchange { "block, the finer one".to_owned() } else { case.name.clone() },
                format!("{cells}, {:.1}", cells as f64 / FINER),
                format!("{:.2}", run.force),
                format!("{:.4}", run.half_width),
                format!("{:.0}", run.peak),
                run.errors.nodes.to_string(),
                format!("{:.2} %", 100.0 * run.errors.rms),
                order(|errors| errors.rms),
                percent(run.errors.largest),
                order(|errors| errors.largest.abs()),
                percent(run.errors.peak),
                format!("{:.2} %", 100.0 * run.coefficients.rms),
                run.iterations.to_string(),
                run.cutbacks.to_string(),
            ];
            table.row(row.join(" | "));
            coarser = Some((cells, run.errors));
        }
    }
    Ok(table)
}

/// What pressures are off by, over p₀.
#[derive(Clone, Copy)]
pub struct Errors {
    nodes: usize,
    pub rms: f64,
    /// With its sign.
    pub largest: f64,
    /// Of the largest pressure.
    peak: f64,
}

impl Errors {
    /// Of pressures at distances, over p₀ and half width; those farther away than `bound` are not compared.
    pub fn within(bound: f64, points: impl Iterator<Item = [f64; 2]>) -> Self {
        let (mut count, mut sum, mut largest, mut peak) = (0, 0.0, 0.0_f64, 0.0_f64);
        for [distance, pressure] in points {
            peak = peak.max(pressure);
            if distance <= bound {
                let error = pressure - (1.0 - distance * distance).sqrt();
                count += 1;
                sum += error * error;
                if error.abs() > largest.abs() {
                    largest = error;
                }
            }
        }
        Self { nodes: count, rms: (sum / count as f64).sqrt(), largest, peak: peak - 1.0 }
    }
}

/// A run.
struct Press {
    /// On what is modelled.
    force: f64,
    half_width: f64,
    peak: f64,
    /// Of the pressures of the results.
    errors: Errors,
    /// Of p_A, each by its node's average gap.
    coefficients: Errors,
    iterations: usize,
    cutbacks: usize,
}

fn press(case: &Case, cells: usize, exchange: bool, threads: usize) -> Result<Press, SolveError> {
    let (deck, model) = scene(case, cells, exchange)?;
    let width = slice(case);
    let run = trace_model(&deck, &model, threads, |snapshot| {
        let force = snapshot.contact_force()[2].abs();
        let [half_width, peak] = closed_form(case, force, width);
        let fields = Fields::of(snapshot.problem, snapshot.state);
        let over = |slave: &SlaveState, pressure: f64| {
            let [x, y, _] = snapshot.problem.start_positions()[slave.node];
            [case.distance(x, y) / half_width, pressure / peak]
        };
        let slaves = || snapshot.slaves();
        let pressures = slaves().map(|slave| over(&slave, fields.contact_pressure[slave.node]));
        let coefficients = slaves().map(|slave| over(&slave, slave.force / slave.area));
        let [errors, coefficients] = [Errors::within(INNER, pressures), Errors::within(INNER, coefficients)];
        Ok(([force, half_width, peak], [errors, coefficients]))
    })?;
    // The last increment ends at the end of time.
    let ([force, half_width, peak], [errors, coefficients]) = run.measures[run.measures.len() - 1];
    let (iterations, cutbacks) = (run.iterations, run.cutbacks);
    Ok(Press { force, half_width, peak, errors, coefficients, iterations, cutbacks })
}

/// Half width and peak pressure at a force on half of the slice, or on a quarter of the ball.
fn closed_form(case: &Case, force: f64, width: f64) -> [f64; 2] {
    if case.is_slice {
        let line = LineContact { force: 2.0 * force / width, radius: case.radius, modulus: MODULUS };
        [line.half_width(), line.peak_pressure()]
    } else {
        let point = PointContact { force: 4.0 * force, radius: case.radius, modulus: MODULUS };
        [point.half_width(), point.peak_pressure()]
    }
}

/// Width of the slice, of two cells. Images in its sides are the more the narrower it is beside the largest cells.
fn slice(case: &Case) -> f64 {
    0.5 * case.half_width
}

/// The deck, and its boxes with their nodes moved to where they are in the bodies.
fn scene(case: &Case, cells: usize, exchange: bool) -> Result<(Deck, Model), SolveError> {
    let size = case.half_width / cells as f64;
    let extent = case.extent * case.half_width;
    let grids = [("body", size), ("block", FINER * size)].map(|(name, size)| {
        let along = ends(size, UNIFORM * case.half_width, extent);
        let depth = ends(size, case.half_width, extent);
        let across = if case.is_slice {
            (0..=2).map(|k| 0.5 * f64::from(k) * slice(case)).collect()
        } else {
            along.clone()
        };
        (name, [along, across, depth])
    });
    let mut deck = Deck::parse(DECK)?;
    for (name, ends) in &grids {
        if let Some(Shape::Block(block)) = deck.shape_mut(name) {
            block.divisions = [0, 1, 2].map(|axis| ends[axis].len() - 1);
        }
    }
    if case.is_slice {
        let ends = ["body.y+", "block.y+"].map(|name| Reference { name: name.to_owned(), line: 0 });
        deck.boundaries[1].nodes.extend(ends);
    }
    if !case.is_slice {
        // Factors take minutes on its finer meshes.
        deck.newton.linear_solver = LinearSolverChoice::Iterative;
    }
    deck.boundaries[3].motion.translation[2] = -case.approach;
    for interface in &mut deck.interfaces {
        interface.integration = Integration::Faces { rule: FaceRule::Second, pressures: case.pressures };
        interface.penalty = Some(case.penalty * YOUNG / size);
        interface.exchange = exchange;
        if case.is_slice {
            let far = [0.0, slice(case), 0.0];
            interface.symmetry.push(SymmetryPlane { point: far, normal: [0.0, -1.0, 0.0] });
        }
    }
    let mut model = deck.model("")?;
    for (name, ends) in &grids {
        let counts = [0, 1, 2].map(|axis| (ends[axis].len() - 1) as f64);
        let nodes = model.node_sets.get(*name).cloned().unwrap_or_default();
        for node in nodes {
            let place = model.nodes[node];
            let at = |axis: usize| ends[axis][(place[axis].abs() * counts[axis]).round() as usize];
            let (x, y, depth) = (at(0), at(1), at(2));
            let distance = case.distance(x, y);
            // Both far sides are plane.
            let sagitta = (1.0 - depth / extent)
                * (case.radius - (case.radius * case.radius - distance * distance).sqrt());
            model.nodes[node] = [x, y, if *name == "body" { depth + sagitta } else { -depth }];
        }
    }
    Ok((deck, model))
}

/// Cells of this size as far as `uniform`, the last one whole.
fn count(size: f64, uniform: f64) -> usize {
    (uniform / size).ceil() as usize
}

/// Ends of cells from 0: of this size as far as `uniform`, then larger and larger as far as `extent`.
fn ends(size: f64, uniform: f64, extent: f64) -> Vec<f64> {
    let count = count(size, uniform);
    let mut ends: Vec<f64> = (0..=count).map(|k| size * k as f64).collect();
    let (start, mut step, mut end) = (size * count as f64, size, size * count as f64);
    let mut grown = Vec::new();
    while end < extent {
        step *= GROWTH;
        end += step;
        grown.push(end);
    }
    let scale = (extent - start) / (end - start);
    ends.extend(grown.into_iter().map(|end| start + scale * (end - start)));
    ends
}
