//! A block on a cylinder that turns under it: without friction the force is constant.

use diffuse_contact_solver::solve::SolveError;
use diffuse_contact_solver::verification::{Oscillation, Trace};

use super::plot::chart;
use super::{Decks, Findings, SURFACES, Way, classic_over, row};
use crate::study::markdown::Table;
use crate::study::plot::Curve;

/// When the cylinder has come up and begins to turn, the time of the turn, and its angle, degrees.
const START: f64 = 0.2;
const TURN: f64 = 0.8;
const DEGREES: f64 = 20.0;

/// Of an increment: time and force on the block.
type Force = (f64, [f64; 3]);

pub fn study(decks: &Decks) -> Result<Findings, SolveError> {
    let columns = "element | facets | mean of F_z, N | F_z, peak to peak over mean | classic over diffuse | \
                   F_x, peak to peak over mean F_z | classic over diffuse | iterations | cut-backs";
    let mut table = Table::new("Block on a turning cylinder: force while it turns", columns);
    let mut charts: [Vec<Curve>; 2] = Default::default();
    for (around, facets) in [(15, "6°"), (30, "3°"), (60, "1.5°")] {
        let mut classic = [None; 2];
        for way in SURFACES {
            let mut deck = decks.by(way)?;
            super::divide(&mut deck, "cylinder", &[around]);
            let run = decks.trace(&deck, |snapshot| Ok((snapshot.record.time, snapshot.contact_force())))?;
            if let (Ok(run), 30) = (&run, around) {
                for (chart, axis) in charts.iter_mut().zip([2, 0]) {
                    let turning = run.measures.iter().filter(|(time, _)| is_turning(*time));
                    let points = turning.map(|(time, force)| (DEGREES * (time - START) / TURN, force[axis]));
                    chart.push(way.curve(points));
                }
            }
            let figures = run.map(|run| figures(&run, way, &mut classic));
            row(&mut table, &[way.name(), facets], figures);
        }
    }
    let forces = [("pressing, exact constant", "F_z in N"), ("along the turn, exact constant", "F_x in N")];
    let charts = forces.into_iter().zip(charts).map(|((what, force), curves)| {
        let title = format!("Block on a turning cylinder, facets of 3°: force {what}");
        chart(title, ["angle in degrees", force], curves)
    });
    Ok(Findings { table, charts: charts.collect() })
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
