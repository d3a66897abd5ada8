//! One ring turned in another with an interference: without friction there is no torque.

use diffuse_contact_solver::solve::SolveError;
use diffuse_contact_solver::verification::{Oscillation, Trace};

use super::plot::decades;
use super::{Decks, Findings, SURFACES, Way, classic_over, row};
use crate::study::markdown::Table;
use crate::study::plot::{Curve, Mark};

/// The support that turns, and its angle at the end, degrees.
const SUPPORT: &str = "shaft.inner";
const DEGREES: f64 = 20.0;
/// Radius of the interface, length.
const RADIUS: f64 = 50.0;

/// Smaller torques are not drawn, N mm: in every other increment there is none by symmetry.
const LEAST: f64 = 1.0;

/// Of an increment: time, torque, sum of the contact forces.
type Torque = [f64; 3];

pub fn study(decks: &Decks) -> Result<Findings, SolveError> {
    let columns = "element | master | largest torque, N mm | over R Σ f | classic over diffuse | \
                   Σ f at the end, N | iterations | cut-backs";
    let mut table = Table::new("Coaxial cylinders: torque of the turn, 0 if exact", columns);
    let mut curves = Vec::new();
    for (master, exchange) in [("ring", false), ("shaft", true)] {
        let mut classic = None;
        for way in SURFACES {
            let mut deck = decks.by(way)?;
            for interface in &mut deck.interfaces {
                interface.exchange = exchange;
            }
            let run = decks.trace(&deck, |snapshot| {
                let torque = snapshot.moment(SUPPORT, [0.0; 3]).map_or(f64::NAN, |moment| moment[2]);
                let force = snapshot.slaves().map(|slave| slave.force).sum();
                Ok([snapshot.record.time, torque, force])
            })?;
            if let (Ok(run), false) = (&run, exchange) {
                let points = run.measures.iter().map(|[time, torque, _]| (DEGREES * time, torque.abs()));
                let points = points.filter(|(_, torque)| *torque >= LEAST);
                curves.push(Curve::new(way.name(), way.colour(), Mark::Dots, points));
            }
            let figures = run.map(|run| figures(&run, way, &mut classic));
            row(&mut table, &[way.name(), master], figures);
        }
    }
    let title = "Coaxial cylinders, ring as master: torque of the turn, exact 0";
    let chart = decades(title, ["angle, degrees", "|torque|, N mm, from 1 on"], LEAST, curves);
    Ok(Findings { table, charts: vec![chart] })
}

/// The cells of a run. `classic`: the amplitude with facets, once it is known.
fn figures(run: &Trace<Torque>, way: Way, classic: &mut Option<f64>) -> [String; 6] {
    let amplitude = Oscillation::of(run.measures.iter().map(|[_, torque, _]| *torque))
        .map_or(0.0, |torque| torque.amplitude());
    let force = run.measures.last().map_or(0.0, |measure| measure[2]);
    [
        format!("{amplitude:.3e}"),
        format!("{:.2e}", amplitude / (RADIUS * force)),
        classic_over(classic, way, amplitude),
        format!("{force:.0}"),
        run.iterations.to_string(),
        run.cutbacks.to_string(),
    ]
}
