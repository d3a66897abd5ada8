//! What the exact tangent is worth: residuals of one increment, and iterations with less than all of it.

use std::fmt::Write as _;

use super::case::{Case, Outcome};
use super::pinch::{Master, PENALTIES, Pipe, Scope, case};
use super::plot::{Axes, figure};
use super::{Chapter, Decks, Pictures};
use crate::error::CliError;
use crate::study::StudyError;
use crate::study::markdown::{Table, cells};
use crate::study::plot::{COLOURS, Curve, Mark, Scale};

/// What takes part in the tangent.
const TANGENTS: [&str; 4] = ["exact", "adaptive", "frame held (hull layers)", "ε N Nᵀ"];

/// Number of runs.
pub fn runs(scope: &Scope) -> usize {
    decks_of(scope).len() * TANGENTS.len()
}

/// Of the figure.
pub const DRAWN_RUNS: usize = TANGENTS.len();

const PICTURE: &str = "paper-residuals.svg";

/// Headings and decks; the first one is drawn.
fn decks_of(scope: &Scope) -> Vec<(String, Case)> {
    let decks = [
        (Pipe::Elastic, "elastic, coarse", scope.coarsest()),
        (Pipe::Elastic, "elastic, fine", scope.finest()),
        (Pipe::Plastic, "elastoplastic, coarse", scope.coarsest()),
    ];
    decks
        .into_iter()
        .flat_map(|(pipe, name, mesh)| {
            PENALTIES.map(|penalty| {
                (format!("{name}, {penalty:.0e} N/mm"), case(pipe, mesh, penalty, Master::Pipe, scope.limit))
            })
        })
        .collect()
}

/// The deck with each tangent.
fn variants(case: &Case) -> [Case; TANGENTS.len()] {
    let with = |tangent: &str| case.clone().with("interface.tangent", tangent).named(tangent);
    [
        with("exact"),
        with("adaptive"),
        with("exact")
            .with("interface.frame", "held")
            .with("interface.neighbours.rule", "hull-layers")
            .named("held"),
        with("gauss-newton"),
    ]
}

/// Runs them all.
pub fn chapter(decks: &Decks, scope: &Scope) -> Result<Chapter, CliError> {
    let tangents = TANGENTS.join(" | ");
    let columns = format!("deck, pipe as master | {tangents}");
    let mut counts = Table::new("### Iterations of the diffuse element", &columns);
    let mut histories = None;
    for (name, case) in decks_of(scope) {
        let outcomes = outcomes(decks, &case)?;
        counts.row(format!("{name} | {}", cells(outcomes.iter().map(Outcome::count))));
        if histories.is_none() {
            histories = Some((name, outcomes));
        }
    }
    let Some((name, outcomes)) = histories else {
        return Ok(Chapter { text: counts.to_string(), pictures: Vec::new() });
    };
    let (number, residuals) = residuals(&outcomes);
    let figure = picture(number, &name, &residuals)?;
    let heading = format!("### Residuals over the forces, increment {} ({name})", number + 1);
    let mut table = Table::new(heading, &format!("iteration | {tangents}"));
    for k in 0..residuals.iter().map(Vec::len).max().unwrap_or(0) {
        let of = |list: &Vec<f64>| list.get(k).map_or(String::new(), |value| format!("{value:.1e}"));
        table.row(format!("{} | {}", k + 1, cells(residuals.iter().map(of))));
    }
    let mut text = String::new();
    let _ = write!(
        text,
        "## What the exact tangent is worth\n\n\
         The exact tangent is ε (g M + N Nᵀ) with the frame moving along. The adaptive one is the same, but ε N Nᵀ alone where the \
         residual is more than 0.3 of the forces. It is a deck's default, and that of all other runs but those of `ring_block` and \
         those marked exact. The paper holds the frame within an increment: force and \
         tangent still belong to each other. Domains of influence need a frame that moves, so that column has hull layers. ε N Nᵀ leaves out the Hessian: what an element without second \
         derivatives has.\n\n{counts}\n\
         The increment below is the one in which the tangents differ most.\n\n{table}\n\
         ![Residuals of an increment by tangent: with the exact and with the adaptive one they fall fastest, and alike; \
         with ε N Nᵀ alone they fall along a straight line, and slowest](pictures/paper-residuals.svg)\n"
    );
    Ok(Chapter { text, pictures: vec![(PICTURE, figure)] })
}

/// The figure alone.
pub fn pictures(decks: &Decks, scope: &Scope) -> Result<Pictures, CliError> {
    let mut pictures = Vec::new();
    if let Some((name, case)) = decks_of(scope).first() {
        let (number, residuals) = residuals(&outcomes(decks, case)?);
        pictures.push((PICTURE, picture(number, name, &residuals)?));
    }
    Ok(pictures)
}

/// With each tangent.
fn outcomes(decks: &Decks, case: &Case) -> Result<Vec<Outcome>, CliError> {
    variants(case).iter().map(|case| decks.run(case)).collect()
}

/// An increment, from 0, and its residuals by tangent.
fn residuals(outcomes: &[Outcome]) -> (usize, Vec<Vec<f64>>) {
    let number = hardest(outcomes);
    (number, outcomes.iter().map(|outcome| history(outcome, number)).collect())
}

/// Residuals over the iterations, by tangent.
fn picture(number: usize, deck: &str, residuals: &[Vec<f64>]) -> Result<String, StudyError> {
    // In the order of `TANGENTS`.
    let styles = [
        (COLOURS.smooth, Mark::Points),
        (COLOURS.other, Mark::Dashes),
        (COLOURS.hull_layers, Mark::Points),
        (COLOURS.other, Mark::PointsDotted),
    ];
    let curves = TANGENTS.iter().zip(styles).zip(residuals).map(|((label, (colour, mark)), residuals)| {
        let points = residuals.iter().enumerate();
        let points = points.map(|(k, &residual)| ((k + 1) as f64, residual.max(1e-16)));
        Curve::new(label.replace(" (", "\n("), colour, mark, points)
    });
    let axes = Axes {
        names: ["iteration", "residual over the forces"],
        x: |[start, end]| Scale::Counts(start..end),
        y: Scale::decades,
    };
    figure(&format!("Residuals of increment {}: {deck}", number + 1), &axes, curves.collect())
}

/// The increment that takes the last tangent most iterations more than the first, from 0.
fn hardest(outcomes: &[Outcome]) -> usize {
    let [Some(first), Some(last)] = [outcomes.first(), outcomes.last()] else { return 0 };
    let pairs = first.increments.iter().zip(&last.increments).enumerate();
    let extra = pairs
        .map(|(k, (one, other))| (other.iterations as i64 - one.iterations as i64, std::cmp::Reverse(k)));
    extra.max().map_or(0, |(_, std::cmp::Reverse(k))| k)
}

/// Residuals of an increment after each linear solution.
fn history(outcome: &Outcome, number: usize) -> Vec<f64> {
    let records = outcome.increments.get(number).map(|record| &record.history[..]).unwrap_or_default();
    records.iter().filter(|record| record.iteration > 0).map(|record| record.relative).collect()
}
