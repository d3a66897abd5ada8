//! A block on a cylinder that turns under it: without friction the force is constant.

use diffuse_contact_solver::solve::SolveError;
use diffuse_contact_solver::verification::{Oscillation, Trace};

use super::plot::decades;
use super::{Decks, Findings, SURFACES, Way, classic_over, row};
use crate::study::markdown::Table;
use crate::study::plot::Curve;

/// When the cylinder has come up and begins to turn, the time of the turn, and its angle, degrees.
const START: f64 = 0.2;
const TURN: f64 = 0.8;
const DEGREES: f64 = 20.0;

/// What smaller deviations are drawn as.
const LEAST: f64 = 1e-7;

/// Of an increment: time and force on the block.
type Force = (f64, [f64; 3]);

pub fn study(decks: &Decks) -> Result<Findings, SolveError> {
    let columns = "element | facets | mean of F_z, N | F_z, peak to peak over mean | classic over diffuse | \
                   F_x, peak to peak over mean F_z | classic over diffuse | iterations | cut-backs";
    let mut table = Table::new("Block on a turning cylinder: force while it turns", columns);
    let mut curves: Vec<Curve> = Vec::new();
    for (around, facets) in [(15, "6°"), (30, "3°"), (60, "1.5°")] {
        let mut classic = [None; 2];
        for way in SURFACES {
            let mut deck = decks.by(way)?;
            super::divide(&mut deck, "cylinder", &[around]);
            let run = decks.trace(&deck, |snapshot| Ok((snapshot.record.time, snapshot.contact_force())))?;
            // The automatic penalty is another one: its force is larger.
            let has_penalty_of_deck = !(way.by_area || way.over_faces);
            if let (Ok(run), 30, true) = (&run, around, has_penalty_of_deck) {
                curves.push(way.curve(deviations(run)));
            }
            let figures = run.map(|run| figures(&run, way, &mut classic));
            row(&mut table, &[way.name(), facets], figures);
        }
    }
    let title = "Block on a turning cylinder, facets of 3°: ripple of the force that presses, exact 0";
    let chart = decades(title, ["angle, degrees", "|F_z / mean − 1|"], LEAST, curves);
    Ok(Findings { table, charts: vec![chart] })
}

/// By how much F_z is off its mean, at each angle.
fn deviations(run: &Trace<Force>) -> impl Iterator<Item = (f64, f64)> {
    let turning = || run.measures.iter().filter(|(time, _)| is_turning(*time));
    let mean = Oscillation::of(turning().map(|(_, force)| force[2])).map_or(f64::NAN, |force| force.mean);
    turning().map(move |(time, force)| (DEGREES * (time - START) / TURN, (force[2] / mean - 1.0).abs()))
}

/// Whether the run-in is over: the first increment of the turn is left out.
fn is_turning(time: f64) -> bool {
    time > START * (1.0 + 1e-9)
}

/// The cells of a run. `classic`: both oscillations with facets, once they are known.
fn figures(run: &Trace<Force>, way: Way, classic: &mut [Option<f64>; 2]) -> [String; 7] {
    let of = |axis: usize| {
        let turning = run.measures.iter().filter(|(time, _)| is_turning(*time));
        Oscillation::of(turning.map(|(_, force)| force[axis]))
    };
    let mean = of(2).map_or(f64::NAN, |force| force.mean);
    let relative = [2, 0].map(|axis| of(axis).map_or(f64::NAN, |force| force.peak_to_peak() / mean));
    let ratios = [0, 1].map(|k| classic_over(&mut classic[k], way, relative[k]));
    let ([up, along], [ratio_up, ratio_along]) = (relative.map(|r| format!("{r:.2e}")), ratios);
    let [iterations, cutbacks] = [run.iterations, run.cutbacks].map(|count| count.to_string());
    [format!("{mean:.2}"), up, ratio_up, along, ratio_along, iterations, cutbacks]
}
