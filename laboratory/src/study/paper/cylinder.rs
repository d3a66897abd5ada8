//! The paper's first example: a plate pressed on a rigid cylinder of 32 triangles.

use std::fmt::Write as _;

use super::case::{Case, Outcome};
use super::plot::{Axes, figure};
use super::{Chapter, Decks, Pictures};
use crate::error::CliError;
use crate::study::StudyError;
use crate::study::markdown::{Table, cells};
use crate::study::plot::{COLOURS, Curve, Mark, Scale};

const DECK: &str = include_str!("../../../../examples/plate_cylinder.toml");
/// Of the deck: radius of the cylinder, height of its axis, pressure at the end.
const RADIUS: f64 = 100.0;
const AXIS: f64 = -100.0;
const PRESSURE: f64 = 200.0;
/// Points along each direction of a face that are looked at.
const SAMPLES: usize = 9;

/// How one element does over the steps.
struct Course {
    label: &'static str,
    outcome: Outcome,
    steps: Vec<Depths>,
}

/// Distances from the true cylinder at the end of a step, positive inside.
struct Depths {
    pressure: f64,
    /// The deepest node of the plate's lower face.
    node: f64,
    /// The deepest of the points sampled on its faces.
    face: f64,
    /// How far the node that is farthest outside among those that carry contact force is from the cylinder.
    above: f64,
    /// How far the penalty gives way at most: force over ε.
    given_way: f64,
}

/// The deck with both elements.
pub fn cases() -> [(&'static str, Case); 4] {
    let case = || Case::new("plate_cylinder", DECK);
    [
        ("facets", case().classic()),
        ("diffuse, cubic weight", case().named("diffuse")),
        (
            "diffuse, interpolating weight",
            case().named("interpolating").with("interface.weight", "cubic-interpolating"),
        ),
        ("hull layers, cubic weight", case().hull_layers()),
    ]
}

/// Runs them all.
pub fn chapter(decks: &Decks) -> Result<Chapter, CliError> {
    let courses = courses(decks)?;
    Ok(Chapter { text: text(&courses), pictures: vec![(PICTURE, picture(&courses)?)] })
}

/// The figure alone.
pub fn pictures(decks: &Decks) -> Result<Pictures, CliError> {
    Ok(vec![(PICTURE, picture(&courses(decks)?)?)])
}

const PICTURE: &str = "paper-cylinder.svg";

fn courses(decks: &Decks) -> Result<Vec<Course>, CliError> {
    let mut courses = Vec::new();
    for (label, case) in cases() {
        let outcome = decks.run(&case)?;
        courses.push(Course { label, steps: steps(&outcome), outcome });
    }
    Ok(courses)
}

/// Penetrations over the pressure. Those that are none have their place in the legend only.
fn picture(courses: &[Course]) -> Result<String, StudyError> {
    // In the order of `cases`.
    let colours = [COLOURS.facets, COLOURS.smooth, COLOURS.interpolating, COLOURS.hull_layers];
    let curves = courses.iter().zip(colours).map(|(course, colour)| {
        let is_none = course.steps.iter().all(|step| step.node == 0.0);
        let label = if is_none { format!("{}:\nnone", course.label) } else { course.label.to_owned() };
        let points = course.steps.iter().filter(|step| step.node > 0.0);
        Curve::new(label, colour, Mark::Points, points.map(|step| (step.pressure, step.node)))
    });
    let axes = Axes {
        names: ["pressure, MPa", "largest penetration, mm"],
        x: |[_, end]| Scale::Linear(0.0..end),
        y: Scale::decades,
    };
    let title = "Largest penetration of the plate's nodes into the true cylinder";
    figure(title, &axes, curves.collect())
}

fn steps(outcome: &Outcome) -> Vec<Depths> {
    let faces = &outcome.surfaces["plate.z-"];
    let depth = |[x, _, z]: [f64; 3]| RADIUS - x.hypot(z - AXIS);
    let states = outcome.increments.iter().zip(&outcome.positions).zip(&outcome.forces);
    states
        .map(|((record, positions), forces)| {
            let deepest = |points: &mut dyn Iterator<Item = [f64; 3]>| points.map(depth).fold(0.0, f64::max);
            let corners = || faces.iter().flat_map(|face| face.corners());
            // Clamped nodes cannot get out of the way.
            let is_free = |node: usize| outcome.start[node][1] > 0.0;
            let loaded = || forces.iter().filter(|&(&node, &force)| force > 0.0 && is_free(node));
            Depths {
                pressure: PRESSURE * record.time,
                node: deepest(&mut corners().map(|&node| positions[node])),
                face: deepest(&mut faces.iter().flat_map(|face| samples(face.corners(), positions))),
                above: loaded().map(|(&node, _)| -depth(positions[node])).fold(0.0, f64::max),
                given_way: loaded().map(|(_, force)| force / PENALTY).fold(0.0, f64::max),
            }
        })
        .collect()
}

/// Points of a quadrilateral, its corners among them.
fn samples(corners: &[usize], positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let [a, b, c, d] = [0, 1, 2, 3].map(|k| positions[corners[k]]);
    let share = |k: usize| k as f64 / (SAMPLES - 1) as f64;
    let point = |s: f64, t: f64| {
        std::array::from_fn(|axis| {
            let lower = a[axis] + (b[axis] - a[axis]) * s;
            let upper = d[axis] + (c[axis] - d[axis]) * s;
            lower + (upper - lower) * t
        })
    };
    (0..SAMPLES * SAMPLES).map(|k| point(share(k % SAMPLES), share(k / SAMPLES))).collect()
}

/// How deep nodes and faces are in each step.
fn penetrations(courses: &[Course]) -> Table {
    let columns = courses.iter().map(|course| format!("{0}: nodes | {0}: faces", course.label));
    let columns = format!("pressure, MPa | {}", cells(columns));
    let mut table = Table::new("Largest penetration into the true cylinder, mm", &columns);
    for k in 0..courses.iter().map(|course| course.steps.len()).min().unwrap_or(0) {
        let values = courses.iter().map(|course| {
            let Depths { node, face, .. } = course.steps[k];
            format!("{node:.4} | {face:.4}")
        });
        table.row(format!("{:.0} | {}", courses[0].steps[k].pressure, cells(values)));
    }
    table
}

/// The worst of all steps.
fn summary(courses: &[Course]) -> Table {
    let mut summary = Table::new(
        "All steps",
        "element | deepest node, mm | facets over it | loaded nodes outside by, mm | off either way, mm | \
         facets over it | by the penalty, mm | iterations",
    );
    let worst =
        |course: &Course, value: fn(&Depths) -> f64| course.steps.iter().map(value).fold(0.0, f64::max);
    let either = |course: &Course| worst(course, |step| step.node.max(step.above));
    let (classic, classic_off) = (worst(&courses[0], |step| step.node), either(&courses[0]));
    for course in courses {
        let (deepest, above) = (worst(course, |step| step.node), worst(course, |step| step.above));
        let (off, penalty) = (either(course), worst(course, |step| step.given_way));
        // Where all nodes are outside there is nothing to divide by.
        let ratio = if deepest > 0.0 { format!("{:.0}", classic / deepest) } else { "–".to_owned() };
        let (label, off_ratio, count) = (course.label, classic_off / off, course.outcome.count());
        summary.row(format!(
            "{label} | {deepest:.5} | {ratio} | {above:.4} | {off:.4} | {off_ratio:.1} | {penalty:.5} | {count}"
        ));
    }
    summary
}

fn text(courses: &[Course]) -> String {
    let (table, summary) = (penetrations(courses), summary(courses));
    let sagitta = RADIUS * (1.0 - 5_f64.to_radians().cos());
    let mut text = String::new();
    let _ = write!(
        text,
        "## A plate on a rigid cylinder\n\n\
         `examples/plate_cylinder.toml`: 32 triangles (master), 100 quadrilateral faces of the plate (slave), pressure up to \
         {PRESSURE} MPa in steps of 20. The paper prints no dimensions: radius 100 mm, a plate of 100 × 50 × 5 mm that is \
         clamped along its edge y = 0. The penalty is the same for both elements, and so large that what it lets through is small \
         against the error of the geometry.\n\n\
         The penetration is measured against the cylinder, not against its mesh: at all nodes of the plate's lower side, and at \
         {SAMPLES} × {SAMPLES} points of each of its faces. The second does not measure the contact element alone: faces \
         of the plate are 10 mm long and straight, their middle lies 10²/(8·100) = 0.125 mm below their ends, whatever keeps the nodes \
         outside.\n\n\
         ![On facets nodes of the plate come up to 0.3 mm into the true cylinder, with the interpolating weight 0.001 mm, with the cubic \
         weight and with hull layers not at all](pictures/paper-cylinder.svg)\n\n{table}\n{summary}\n\
         A facet spans 10 degrees; its middle lies {sagitta:.3} mm inside the cylinder, and that is how far facets let a node \
         in. The fit is off the other way: it lies outside the cylinder nearly everywhere, so that hardly any penetration is \
         left, and loaded nodes stand off instead. How good the surface is shows in the distance either way, in which the ratio is \
         smaller; there the interpolating weight is better than the cubic one, although it lets nodes in no less.\n",
    );
    text
}

/// Of the deck, force per length.
const PENALTY: f64 = 2e7;
