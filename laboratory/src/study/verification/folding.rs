//! Surfaces in contact with themselves: how deep they penetrate, and how smooth their force is.

use diffuse_contact::surface::tributary_areas;
use diffuse_contact_solver::contact::Integration;
use diffuse_contact_solver::deck::Deck;
use diffuse_contact_solver::solve::SolveError;
use diffuse_contact_solver::verification::largest_kink;

use super::{Decks, Findings, Way, percent, row};
use crate::study::markdown::Table;

const WAYS: [Way; 4] = [Way::DIFFUSE_OVER_FACES, Way::DIFFUSE, Way::FACETS_OVER_FACES, Way::FACETS];

pub fn study(decks: &Decks, title: &str) -> Result<Findings, SolveError> {
    let columns =
        "element | increments | cut-backs | iterations | deepest penetration, of a facet | largest kink";
    let mut table = Table::new(format!("{title}: contact of a surface with itself"), columns);
    for way in WAYS {
        let mut deck = decks.with(way.element)?;
        // What else touches is over what the deck says.
        for interface in deck.interfaces.iter_mut().filter(|interface| interface.self_contact) {
            interface.integration = if way.over_faces { Integration::FACES } else { Integration::Nodes };
        }
        row(&mut table, &[way.name()], pressed(&deck, decks)?);
    }
    Ok(Findings { table, charts: Vec::new() })
}

fn pressed(deck: &Deck, decks: &Decks) -> Result<Result<[String; 5], String>, SolveError> {
    let own = deck.interfaces.iter().position(|interface| interface.self_contact).unwrap_or(0);
    let model = deck.model(decks.base())?;
    let facets = deck.sides(&model, &deck.interfaces[own])?.master;
    // Checked when the model was made.
    let area: f64 = tributary_areas(&model.nodes, &facets).unwrap_or_default().iter().sum();
    let size = (area / facets.len() as f64).sqrt();
    let run = decks.trace(deck, |snapshot| {
        let depth = snapshot.problem.contacts().interactions()[own].max_penetration();
        Ok((depth / size, [snapshot.record.time, snapshot.record.contacts[own].normal]))
    })?;
    Ok(run.map(|run| {
        let deepest = run.measures.iter().map(|(depth, _)| *depth).fold(0.0, f64::max);
        let curve: Vec<[f64; 2]> = run.measures.iter().map(|(_, point)| *point).collect();
        let [increments, cutbacks, iterations] =
            [run.measures.len(), run.cutbacks, run.iterations].map(|count| count.to_string());
        [increments, cutbacks, iterations, percent(deepest), percent(largest_kink(&curve))]
    }))
}
