//! A cylinder and a ball on a rigid plane: the peak pressure against Hertz, at the force that the run found. And on an elastic block of
//! the same material, whose nodes are the slaves of the curved body.

use diffuse_contact_solver::deck::{Boundary, Deck, PartSource, Reference};
use diffuse_contact_solver::model::Motion;
use diffuse_contact_solver::model::shape::{Block, Shape};
use diffuse_contact_solver::output::Fields;
use diffuse_contact_solver::solve::SolveError;
use diffuse_contact_solver::verification::{LineContact, PointContact, PressureProfile, Snapshot, Trace};

use super::plot::chart;
use super::{Decks, Findings, Way, divide, percent, row};
use crate::study::markdown::Table;
use crate::study::plot::{COLOURS, Chart, Curve, Mark, Scale};

/// Cells of the body, and of an elastic floor along x and z; `None`: there is no run with one.
struct Mesh {
    body: &'static [usize],
    floor: Option<usize>,
    /// Whether it is one of those that take minutes.
    fine: bool,
}

/// Two layers of cells along the cylinder, for it to be a master; its deck has one.
const CYLINDERS: [Mesh; 3] = [
    Mesh { body: &[10, 8, 2], floor: Some(12), fine: false },
    Mesh { body: &[20, 16, 2], floor: Some(24), fine: false },
    Mesh { body: &[40, 32, 2], floor: Some(48), fine: true },
];
/// The second one is the deck's.
const BALLS: [Mesh; 3] = [
    Mesh { body: &[6, 5], floor: Some(7), fine: false },
    Mesh { body: &[9, 8], floor: Some(10), fine: false },
    Mesh { body: &[14, 12], floor: None, fine: true },
];

impl Mesh {
    /// Its cells as in a deck.
    fn name(&self) -> String {
        self.body.iter().map(usize::to_string).collect::<Vec<_>>().join(" × ")
    }
}

/// One of the two problems.
struct Problem {
    title: &'static str,
    /// The body in the deck.
    body: &'static str,
    meshes: &'static [Mesh],
    /// The place among them of the one that the chart shows, with an elastic floor.
    charted: usize,
    /// Cells across and width of an elastic floor along y; as along x without.
    across: Option<(usize, f64)>,
    /// Sides of the elastic floor that lie on planes of symmetry, and the axes along which they stay.
    symmetry: &'static [(&'static str, [bool; 3])],
    /// What lies between a position and the first touch, length.
    distance: fn([f64; 3]) -> f64,
    /// Half width and peak pressure at a force on the part that is modelled, and a modulus E*.
    exact: fn(f64, f64) -> [f64; 2],
}

/// Of both decks: E* on a rigid floor, and radius.
const MODULUS: f64 = 200_000.0 / (1.0 - 0.3 * 0.3);
const RADIUS: f64 = 10.0;
/// Length of the cylinder.
const LENGTH: f64 = 0.5;

pub fn cylinder(decks: &Decks) -> Result<Findings, SolveError> {
    study(
        decks,
        &Problem {
            title: "Hertz, cylinder",
            body: "cylinder",
            meshes: &CYLINDERS,
            charted: 1,
            across: Some((2, LENGTH)),
            symmetry: &[
                ("floor.x-", [true, false, false]),
                ("floor.y-", [false, true, false]),
                ("floor.y+", [false, true, false]),
            ],
            distance: |x| x[0].abs(),
            // Half of the cylinder is modelled.
            exact: |force, modulus| {
                let contact = LineContact { force: 2.0 * force / LENGTH, radius: RADIUS, modulus };
                [contact.half_width(), contact.peak_pressure()]
            },
        },
    )
}

pub fn ball(decks: &Decks) -> Result<Findings, SolveError> {
    study(
        decks,
        &Problem {
            title: "Hertz, ball",
            body: "ball",
            meshes: &BALLS,
            charted: 1,
            across: None,
            symmetry: &[("floor.x-", [true, false, false]), ("floor.y-", [false, true, false])],
            distance: |x| x[0].hypot(x[1]),
            // A quarter of the ball is modelled.
            exact: |force, modulus| {
                let contact = PointContact { force: 4.0 * force, radius: RADIUS, modulus };
                [contact.half_width(), contact.peak_pressure()]
            },
        },
    )
}

/// Force and pressures at the end of an increment.
struct Press {
    force: f64,
    profile: PressureProfile,
    /// `contact_pressure` of the results over the distance, of the nodes that have one.
    smoothed: Vec<(f64, f64)>,
}

impl Press {
    fn of(snapshot: &Snapshot<'_>, distance: fn([f64; 3]) -> f64) -> Self {
        let fields = Fields::of(snapshot.problem, snapshot.state);
        let start = snapshot.problem.start_positions();
        let slaves = snapshot.slaves().map(|slave| slave.node);
        let smoothed = slaves.map(|node| (distance(start[node]), fields.contact_pressure[node]));
        Self {
            force: snapshot.contact_force()[2].abs(),
            profile: PressureProfile::of(snapshot, distance),
            smoothed: smoothed.filter(|&(_, pressure)| pressure > 0.0).collect(),
        }
    }
}

/// How far from the middle the chart shows, over the half width: the outermost nodes have pressures beyond it.
const SHOWN: f64 = 1.2;

fn study(decks: &Decks, problem: &Problem) -> Result<Findings, SolveError> {
    let heading =
        format!("{}: deviation of peak pressure and half width from the closed form", problem.title);
    let meshes: Vec<&Mesh> = problem.meshes.iter().filter(|mesh| mesh.fine == decks.fine).collect();
    let columns = "slave | element | cells | pressed nodes | force, N | p₀, closed form, MPa | \
                   largest nodal pressure | p₀ of the fitted ellipse | a of the fitted ellipse | iterations";
    let mut table = Table::new(heading, columns);
    let mut curves = Vec::new();
    for exchange in [false, true] {
        for way in [Way::FACETS, Way::DIFFUSE, Way::DIFFUSE_OVER_FACES] {
            for mesh in &meshes {
                let mut deck = decks.by(way)?;
                divide(&mut deck, problem.body, mesh.body);
                let modulus = match (exchange, mesh.floor) {
                    (false, _) => MODULUS,
                    (true, Some(cells)) => {
                        soften(&mut deck, problem, cells);
                        0.5 * MODULUS
                    }
                    (true, None) => continue,
                };
                let run = decks.trace(&deck, |snapshot| Ok(Press::of(snapshot, problem.distance)))?;
                let is_charted = exchange && mesh.body == problem.meshes[problem.charted].body;
                if let (Ok(run), true) = (&run, is_charted) {
                    curves.extend(points(run, problem, way, modulus));
                }
                let figures = run.map(|run| figures(&run, problem, modulus));
                let slave = if exchange { "elastic floor" } else { problem.body };
                row(&mut table, &[slave, way.name(), &mesh.name()], figures);
            }
        }
    }
    let charts = if curves.is_empty() { vec![] } else { vec![pressures(problem, curves)] };
    Ok(Findings { table, charts })
}

/// The curves with the closed form over them.
fn pressures(problem: &Problem, mut curves: Vec<Curve>) -> Chart {
    let exact = (0..=200).map(|k| {
        let x: f64 = f64::from(k) / 200.0;
        (x, (1.0 - x * x).sqrt())
    });
    curves.push(Curve::new("closed form", COLOURS.other, Mark::Line, exact));
    let cells = problem.meshes[problem.charted].name();
    let rows =
        problem.across.map_or(String::new(), |(across, _)| format!(", {} rows across the strip", across + 1));
    let title = format!("{} as master, {cells} cells: pressure; one dot per node{rows}", problem.title);
    Chart { x_range: Scale::Linear(0.0..SHOWN), ..chart(title, ["x / a", "p / p₀"], curves) }
}

/// Makes the floor an elastic block, whose nodes are the slaves: the curved body carries the contact surface.
fn soften(deck: &mut Deck, problem: &Problem, cells: usize) {
    let materials =
        deck.parts.iter().map(|part| part.materials.clone()).find(|materials| !materials.is_empty());
    let (across, width) = problem.across.unwrap_or((cells, RADIUS));
    let fine = 80.0;
    for part in deck.parts.iter_mut().filter(|part| part.name == "floor") {
        part.source = PartSource::Shape(Shape::Block(Block {
            origin: [0.0, 0.0, -RADIUS],
            size: [RADIUS, width, RADIUS],
            divisions: [cells, across, cells],
            grading: [fine, if problem.across.is_some() { 1.0 } else { fine }, 1.0 / fine],
        }));
        part.materials = materials.clone().unwrap_or_default();
        part.translation = [0.0; 3];
    }
    let named = |name: &str| vec![Reference { name: name.to_owned(), line: 0 }];
    for node_set in deck.boundaries.iter_mut().flat_map(|boundary| &mut boundary.nodes) {
        if node_set.name == "floor" {
            node_set.name = "floor.z-".to_owned();
        }
    }
    deck.boundaries.extend(problem.symmetry.iter().map(|&(nodes, axes)| Boundary {
        line: 0,
        nodes: named(nodes),
        axes,
        motion: Motion::fixed(),
    }));
    for interface in &mut deck.interfaces {
        interface.master = std::mem::replace(&mut interface.slave, named("floor.z+"));
    }
}

fn figures(run: &Trace<Press>, problem: &Problem, modulus: f64) -> [String; 7] {
    let Some(Press { force, profile, .. }) = run.measures.last() else { return Default::default() };
    let [half_width, peak] = (problem.exact)(*force, modulus);
    let ellipse = |k: usize, exact: f64| {
        profile.ellipse().map_or_else(|| "–".to_owned(), |ellipse| percent(ellipse[k] / exact - 1.0))
    };
    [
        profile.nodes.len().to_string(),
        format!("{force:.1}"),
        format!("{peak:.0}"),
        percent(profile.largest() / peak - 1.0),
        ellipse(0, peak),
        ellipse(1, half_width),
        run.iterations.to_string(),
    ]
}

/// Nodal pressures over those of the closed form; over faces those of the results besides.
fn points(run: &Trace<Press>, problem: &Problem, way: Way, modulus: f64) -> Vec<Curve> {
    let Some(Press { force, profile, smoothed }) = run.measures.last() else { return Vec::new() };
    let [half_width, peak] = (problem.exact)(*force, modulus);
    let shown = |(distance, pressure): (f64, f64)| (distance / half_width, pressure / peak);
    let own = profile.nodes.iter().map(|node| shown((node.distance, node.pressure)));
    if !way.over_faces {
        return vec![Curve::new(way.name(), way.colour(), Mark::Dots, own)];
    }
    let smoothed = smoothed.iter().copied().map(shown);
    vec![
        Curve::new(way.name().to_owned() + ",\np_A", way.colour(), Mark::Rings, own),
        Curve::new(way.name().to_owned() + ",\ncontact_pressure", way.colour(), Mark::Dots, smoothed),
    ]
}
