//! How a run ended, in a few numbers.

use serde::{Deserialize, Serialize};

use crate::deck::Deck;
use crate::model::Model;
use crate::statics::Effort;

/// `summary.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Title of the deck.
    pub title: String,
    /// Whether the end of time was reached.
    pub converged: bool,
    /// Why not, in a sentence; empty if it was.
    pub reason: String,
    /// Pseudo-time reached.
    pub time: f64,
    /// Converged increments.
    pub increments: usize,
    /// Increments that failed and were tried again with a shorter one.
    pub cutbacks: usize,
    /// Linear solutions, those of failed increments among them.
    pub newton_iterations: usize,
    /// Increments whose rounds of augmentation were over before the gaps were within the tolerance.
    #[serde(default)]
    pub augmentations_short: usize,
    /// Contacts that carried force and ended an increment without an element, over all increments.
    #[serde(default)]
    pub contacts_lost: usize,
    /// Interfaces that carried no force at the end of any increment.
    #[serde(default)]
    pub interfaces_without_force: Vec<String>,
    /// Deepest penetration at the end, length.
    pub max_penetration: f64,
    /// Deepest penetration at the end of any increment, length.
    pub max_penetration_ever: f64,
    /// Sum of the contact forces on the slaves of all interactions at the end.
    pub contact_force: [f64; 3],
    /// Seconds of the run; of all runs, if it was restarted.
    pub wall_s: f64,
    /// Share of the last run's time in evaluating contacts, 0 to 1.
    pub contact_share: f64,
    /// Share of the last run's time in pairing, 0 to 1.
    pub pairing_share: f64,
    /// Share of the last run's time in the linear solver, 0 to 1.
    pub linear_share: f64,
    /// Element of the interfaces: `diffuse`, `node-to-facet` or `none`.
    pub element: String,
    /// Nodes, elements.
    pub size: [usize; 2],
}

impl Summary {
    /// That of a deck's run before its first increment.
    #[must_use]
    pub fn new(deck: &Deck, model: &Model) -> Self {
        let elements = model.bodies.iter().map(|body| body.elements.len()).sum();
        Self {
            title: deck.title.clone(),
            element: deck.contact.name().to_owned(),
            size: [model.nodes.len(), elements],
            ..Self::default()
        }
    }

    /// Takes over what a run took.
    pub fn take(&mut self, effort: Effort) {
        self.cutbacks = effort.cutbacks;
        self.newton_iterations = effort.iterations;
    }
}
