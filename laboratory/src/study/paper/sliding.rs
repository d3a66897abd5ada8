//! Iterations where nodes slide over the master's kinks, and with the next increment extrapolated.

use super::case::{Case, saving};
use super::pinch::{Master, Pipe, Scope, case};
use super::{Chapter, Decks};
use crate::error::CliError;
use crate::study::markdown::Table;

/// Decks of the repository besides the paper's: name, text, master as in the deck and exchanged.
const EXAMPLES: [(&str, &str, &[&str]); 3] = [
    ("sliding_block", include_str!("../../../../examples/sliding_block.toml"), &["cylinder"]),
    ("coaxial_cylinders", include_str!("../../../../examples/coaxial_cylinders.toml"), &["ring", "shaft"]),
    ("ring_block", include_str!("../../../../examples/ring_block.toml"), &["block", "ring"]),
];

/// Values of `newton.extrapolation`.
const RULES: [&str; 2] = ["none", "linear"];

/// Number of runs.
pub fn runs(scope: &Scope) -> usize {
    3 * RULES.len() * cases(scope).len()
}

/// Headings and decks.
fn cases(scope: &Scope) -> Vec<(String, Case)> {
    let pinches = [(Pipe::Elastic, "pipe_pinch"), (Pipe::Plastic, "pipe_pinch_plastic")];
    let pinches = pinches.into_iter().map(|(pipe, name)| {
        let case = case(pipe, scope.coarsest(), 2e6, Master::Pipe, scope.limit);
        (format!("`{name}`, pipe as master"), case)
    });
    let others = EXAMPLES.into_iter().flat_map(|(name, text, masters)| {
        masters.iter().enumerate().map(move |(k, master)| {
            let case = Case::new(name, text).with("interface.exchange", k > 0).named(master);
            (format!("`{name}`, {master} as master"), case.up_to(scope.limit))
        })
    });
    pinches.chain(others).collect()
}

/// Runs them all.
pub fn chapter(decks: &Decks, scope: &Scope) -> Result<Chapter, CliError> {
    let columns = "deck | diffuse | hull layers | facets | fewer | diffuse, linear | \
                   hull layers, linear | facets, linear | fewer";
    let mut table = Table::new("### Iterations, by a linear step and by linear extrapolation", columns);
    for (name, case) in cases(scope) {
        let mut row = vec![name];
        for rule in RULES {
            let case = case.clone().with("newton.extrapolation", rule).named(rule);
            let [diffuse, layers] = [decks.run(&case)?, decks.run(&case.clone().hull_layers())?];
            let classic = decks.run(&case.classic())?;
            row.extend([diffuse.count(), layers.count(), classic.count(), saving(&diffuse, &classic)]);
        }
        table.row(row.join(" | "));
    }
    let text = format!(
        "## Where nodes slide\n\n\
         In the pinch the pipe rolls along the plate: hardly a node crosses an edge of a facet while it is pressed. Here they do, in the other \
         examples of the repository, which are described in [Verification](verification.md). Increments begin with a linear step, or with \
         the line through the last two states (`extrapolation = \"linear\"`), which is worth the more the smoother the motion is.\n\n{table}"
    );
    Ok(Chapter { text, pictures: Vec::new() })
}
