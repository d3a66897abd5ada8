//! A cylinder and a ball on a rigid plane: the peak pressure against Hertz, at the force that the run found.

use diffuse_contact_solver::deck::{Contact, Deck, PartSource};
use diffuse_contact_solver::model::shape::{RigidPlane, Shape};
use diffuse_contact_solver::solve::SolveError;
use diffuse_contact_solver::verification::{LineContact, PointContact, PressureProfile, Trace, trace};

use super::plot::{Chart, Curve};
use super::{Decks, ELEMENTS, Findings, colour, divide, outcome, percent, row};
use crate::study::markdown::Table;

/// Cells of the body and of the floor on each mesh. The second is the deck's.
struct Mesh {
    name: &'static str,
    body: &'static [usize],
    floor: [usize; 2],
}

const CYLINDERS: [Mesh; 3] = [
    Mesh { name: "coarse", body: &[10, 8, 2], floor: [10, 2] },
    Mesh { name: "deck", body: &[20, 16, 2], floor: [20, 2] },
    Mesh { name: "fine", body: &[40, 32, 2], floor: [40, 2] },
];
const BALLS: [Mesh; 3] = [
    Mesh { name: "coarse", body: &[6, 5], floor: [8, 8] },
    Mesh { name: "deck", body: &[9, 8], floor: [12, 12] },
    Mesh { name: "fine", body: &[14, 12], floor: [20, 20] },
];

/// One of the two problems.
struct Problem {
    title: &'static str,
    /// The body in the deck.
    body: &'static str,
    meshes: &'static [Mesh],
    /// The floor while its nodes are the slaves: just as large as need be, length.
    floor: [f64; 2],
    /// What lies between a position and the first touch, length.
    distance: fn([f64; 3]) -> f64,
    /// Half width and peak pressure at a force on the part that is modelled.
    exact: fn(f64) -> [f64; 2],
}

/// Of both decks: E* and radius.
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
            floor: [0.8, LENGTH],
            distance: |x| x[0].abs(),
            // Half of the cylinder is modelled.
            exact: |force| {
                let contact = LineContact { force: 2.0 * force / LENGTH, radius: RADIUS, modulus: MODULUS };
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
            floor: [1.2, 1.2],
            distance: |x| x[0].hypot(x[1]),
            // A quarter of the ball is modelled.
            exact: |force| {
                let contact = PointContact { force: 4.0 * force, radius: RADIUS, modulus: MODULUS };
                [contact.half_width(), contact.peak_pressure()]
            },
        },
    )
}

/// Force and pressures at the end of an increment.
type Press = (f64, PressureProfile);

fn study(decks: &Decks, problem: &Problem) -> Result<Findings, SolveError> {
    let heading =
        format!("{}: deviation of peak pressure and half width from the closed form", problem.title);
    let columns = [
        "slave",
        "element",
        "mesh",
        "pressed nodes",
        "force, N",
        "p₀, closed form, MPa",
        "largest nodal pressure",
        "p₀ of the fitted ellipse",
        "a of the fitted ellipse",
        "iterations",
        "s",
    ];
    let mut table = Table::new(heading, columns);
    let mut curves = Vec::new();
    for exchange in [false, true] {
        for element in ELEMENTS {
            for mesh in problem.meshes {
                let deck = variant(decks.with(element)?, problem, mesh, exchange);
                let run = outcome(press(&deck, decks, problem))?;
                if let (Ok(run), "deck", true) = (&run, mesh.name, exchange) {
                    curves.extend(curve(run, problem, element));
                }
                let figures = run.map(|run| figures(&run, problem));
                row(
                    &mut table,
                    [if exchange { "floor" } else { problem.body }, element.name(), mesh.name],
                    figures,
                );
            }
        }
    }
    let pressures = (0..=200).map(|k| {
        let x: f64 = f64::from(k) / 200.0;
        (x, (1.0 - x * x).sqrt())
    });
    curves.push(Curve {
        label: "closed form".into(),
        colour: plotters::style::BLACK,
        dotted: false,
        points: pressures.collect(),
    });
    let chart = Chart {
        title: format!("{}: pressure with the curved body as master, the deck's mesh", problem.title),
        abscissa: "x / a",
        ordinate: "p / p₀",
        curves,
    };
    Ok(Findings { tables: vec![table], charts: vec![chart] })
}

/// The deck on another mesh; with `exchange` the floor's nodes are the slaves and the curved body carries the contact surface.
fn variant(mut deck: Deck, problem: &Problem, mesh: &Mesh, exchange: bool) -> Deck {
    divide(&mut deck, problem.body, mesh.body);
    for interface in &mut deck.interfaces {
        interface.exchange = exchange;
    }
    if exchange && let Some(floor) = deck.parts.iter_mut().find(|part| part.name == "floor") {
        if let PartSource::Shape(Shape::RigidPlane(RigidPlane { size, divisions, .. })) = &mut floor.source {
            (*size, *divisions) = (problem.floor, mesh.floor);
        }
        floor.translation = [0.0; 3];
    }
    deck
}

fn press(deck: &Deck, decks: &Decks, problem: &Problem) -> Result<Trace<Press>, SolveError> {
    trace(deck, decks.base(), decks.threads, |snapshot| {
        Ok((snapshot.contact_force()[2].abs(), PressureProfile::of(snapshot, problem.distance)))
    })
}

fn figures(run: &Trace<Press>, problem: &Problem) -> [String; 8] {
    let Some((force, profile)) = run.measures.last() else { return Default::default() };
    let [half_width, peak] = (problem.exact)(*force);
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
        format!("{:.1}", run.wall.as_secs_f64()),
    ]
}

/// Nodal pressures over those of the closed form.
fn curve(run: &Trace<Press>, problem: &Problem, element: Contact) -> Option<Curve> {
    let (force, profile) = run.measures.last()?;
    let [half_width, peak] = (problem.exact)(*force);
    let points = profile.nodes.iter().map(|node| (node.distance / half_width, node.pressure / peak));
    Some(Curve {
        label: element.name().to_owned(),
        colour: colour(element),
        dotted: true,
        points: points.collect(),
    })
}
