//! Iterations of the elastic pinch in longer increments.

use super::Decks;
use super::case::Outcome;
use super::pinch::{Master, Pipe, Scope, case};
use crate::error::CliError;
use crate::study::extremes;
use crate::study::markdown::Table;

/// Longer than the deck's increments of 2.5 mm by these factors.
const FACTORS: [u32; 3] = [1, 2, 4];
/// The deck's increment, in time and in mm.
const INCREMENT: (f64, f64) = (0.03125, 2.5);

/// Values of `interface.tangent`, of both elements.
const TANGENTS: [&str; 2] = ["adaptive", "exact"];

/// Number of runs.
pub fn runs(scope: &Scope) -> usize {
    4 * TANGENTS.len() * FACTORS.len() * scope.meshes.len() * scope.penalties.len()
}

/// Sums over all meshes and penalties.
pub fn table(decks: &Decks, scope: &Scope) -> Result<Table, CliError> {
    let columns = "increment, mm | tangent | master | decks | diffuse | facets | fewer | \
                   one deck, from | to | cut back";
    let mut table = Table::new("### Longer increments, elastic, all meshes and penalties together", columns);
    for (factor, tangent) in FACTORS.into_iter().flat_map(|factor| TANGENTS.map(|tangent| (factor, tangent)))
    {
        for master in Master::ALL {
            let mut pairs = Vec::new();
            for &mesh in scope.meshes {
                for &penalty in scope.penalties {
                    let case = case(Pipe::Elastic, mesh, penalty, master, scope.limit)
                        .with("time.increment", f64::from(factor) * INCREMENT.0)
                        .with("interface.tangent", tangent)
                        .named(&format!("{tangent}-by-{factor}"));
                    pairs.push([decks.run(&case)?, decks.run(&case.classic())?]);
                }
            }
            pairs.retain(|pair| pair.iter().all(Outcome::converged));
            let sum =
                |k: usize, of: fn(&Outcome) -> usize| pairs.iter().map(|pair| of(&pair[k])).sum::<usize>();
            let [diffuse, classic] = [0, 1].map(|k| sum(k, |outcome| outcome.iterations));
            let saved = pairs.iter().map(|[one, other]| percent(one.iterations, other.iterations));
            let [least, most] = extremes(saved);
            let [cut, classic_cut] = [0, 1].map(|k| sum(k, |outcome| outcome.cutbacks));
            let (increment, master) = (f64::from(factor) * INCREMENT.1, master.name());
            let (count, fewer) = (pairs.len(), percent(diffuse, classic));
            table.row(format!(
                "{increment} | {tangent} | {master} | {count} | {diffuse} | {classic} | {fewer:.1} % | \
                 {least:.1} % | {most:.1} % | {cut}, {classic_cut}"
            ));
        }
    }
    Ok(table)
}

/// How much less `one` is than `other`.
fn percent(one: usize, other: usize) -> f64 {
    100.0 * (1.0 - one as f64 / other.max(1) as f64)
}
