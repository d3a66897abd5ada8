//! A ring pressed on a block: what large sliding costs.

use diffuse_contact_solver::solve::SolveError;

use super::{Decks, Findings, SURFACES, row};
use crate::study::markdown::Table;

pub fn study(decks: &Decks) -> Result<Findings, SolveError> {
    let columns = "element | master | increments | cut-backs | iterations | force at the end";
    let mut table = Table::new("Ring on a block: to the end of the deck's time", columns);
    for exchange in [false, true] {
        for way in SURFACES {
            let mut deck = decks.by(way)?;
            for interface in &mut deck.interfaces {
                interface.exchange = exchange;
            }
            let run = decks.trace(&deck, |snapshot| Ok(snapshot.contact_force()))?;
            let figures = run.map(|run| {
                let force = run.measures.last().map_or(0.0, |force| force[1].abs());
                let counts =
                    [run.measures.len(), run.cutbacks, run.iterations].map(|count| count.to_string());
                let [increments, cutbacks, iterations] = counts;
                [increments, cutbacks, iterations, format!("{force:.1}")]
            });
            row(&mut table, &[way.name(), if exchange { "ring" } else { "block" }], figures);
        }
    }
    Ok(Findings { table, charts: Vec::new() })
}
