//! An elastic cylinder on an elastic block: `contact_pressure` at the nodes against Hertz', inside nearly all of the contact, with cells of
//! the cylinder that are wide at its end.

use diffuse_contact::Weight;
use diffuse_contact_solver::deck::Contact;
use diffuse_contact_solver::output::Fields;
use diffuse_contact_solver::solve::SolveError;
use diffuse_contact_solver::verification::LineContact;

use super::{Decks, Findings, Way, divide, percent, row};
use crate::study::hertz::Errors;
use crate::study::markdown::Table;

/// Ways, weights of the fit, and cells of the cylinder's core, 20 in the deck.
const RUNS: [(Way, Weight, usize); 9] = [
    (Way::FACETS, Weight::Cubic, 20),
    (Way::FACETS_OVER_FACES, Weight::Cubic, 20),
    (Way::DIFFUSE, Weight::Cubic, 20),
    (Way::DIFFUSE_OVER_FACES, Weight::Cubic, 20),
    (Way::DIFFUSE_OVER_FACES, Weight::WendlandC2, 20),
    (Way::DIFFUSE_OVER_FACES, Weight::CubicInterpolating, 20),
    (Way::FACETS, Weight::Cubic, 40),
    (Way::FACETS_OVER_FACES, Weight::Cubic, 40),
    (Way::DIFFUSE_OVER_FACES, Weight::Cubic, 40),
];

/// E* of both bodies, radius, length of the slice.
const MODULUS: f64 = 0.5 * 210_000.0 / (1.0 - 0.3 * 0.3);
const RADIUS: f64 = 10.0;
const LENGTH: f64 = 0.1;

/// Nodes within so many half widths are compared, those farther inside, and those on the line of first touch.
const BOUNDS: [f64; 3] = [0.95, 0.85, 1e-9];

pub fn study(decks: &Decks) -> Result<Findings, SolveError> {
    let mut table = Table::new(
        "Elastic cylinder on elastic block: errors of the pressure over p₀ within 0.95 a",
        "element | weight | cells around | rms | largest | at the middle | rms within 0.85 a | largest | \
         iterations | cut-backs",
    );
    for (way, weight, cells) in RUNS {
        let mut deck = decks.by(way)?;
        divide(&mut deck, "cylinder", &[cells]);
        for interface in &mut deck.interfaces {
            interface.surface.element = interface.surface.element.with_weight(weight);
        }
        let run = decks.trace(&deck, |snapshot| {
            // Half of the cylinder is modelled.
            let force = 2.0 * snapshot.contact_force()[1].abs() / LENGTH;
            let exact = LineContact { force, radius: RADIUS, modulus: MODULUS };
            let (half_width, peak) = (exact.half_width(), exact.peak_pressure());
            let pressures = Fields::of(snapshot.problem, snapshot.state).contact_pressure;
            let place = |node: usize| snapshot.problem.start_positions()[node][0].abs();
            let nodes = snapshot.slaves().map(|slave| slave.node);
            Ok(nodes.map(|node| [place(node) / half_width, pressures[node] / peak]).collect())
        })?;
        let figures = run.map(|run| {
            let nodes: &[[f64; 2]] = run.measures.last().map_or(&[], Vec::as_slice);
            let [all, inner, middle] = BOUNDS.map(|bound| Errors::within(bound, nodes.iter().copied()));
            [
                format!("{:.2} %", 100.0 * all.rms),
                percent(all.largest),
                percent(middle.largest),
                format!("{:.2} %", 100.0 * inner.rms),
                percent(inner.largest),
                run.iterations.to_string(),
                run.cutbacks.to_string(),
            ]
        });
        let weight = if way.element == Contact::Diffuse { weight.name() } else { "–" };
        row(&mut table, &[way.name(), weight, &cells.to_string()], figures);
    }
    Ok(Findings { table, charts: Vec::new() })
}
