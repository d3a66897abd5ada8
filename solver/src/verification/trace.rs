//! A run of which nothing is written.

use std::path::Path;
use std::time::{Duration, Instant};

use crate::contact::{Resultant, SlaveState};
use crate::deck::Deck;
use crate::model::Model;
use crate::solid::SolidError;
use crate::solve::{SolveError, statics};
use crate::statics::{Control, Failure, IncrementRecord, Observer, Problem, State};

/// The end of an increment.
#[derive(Clone, Copy)]
pub struct Snapshot<'a> {
    /// What the increment took.
    pub record: &'a IncrementRecord,
    /// Where the nodes are.
    pub state: &'a State,
    /// Forces and contacts.
    pub problem: &'a Problem,
}

impl Snapshot<'_> {
    /// Moment about a point of the forces that the support of this name exerts, force times length: Σ (x − point) × f. The name is that of
    /// [`Support`](crate::model::Support): the node sets of a `[[boundary]]`, with `+` between them. `None`: there is no such
    /// support.
    pub fn moment(&self, support: &str, point: [f64; 3]) -> Option<[f64; 3]> {
        let supports = self.problem.supports();
        let group = supports.groups().iter().position(|group| group.name == support)?;
        let forces: Vec<f64> = self.problem.imbalance().collect();
        Some(supports.moment(group, &forces, &self.state.positions, point))
    }

    /// The contact of every slave node, interface by interface and pass by pass.
    pub fn slaves(&self) -> impl Iterator<Item = SlaveState> {
        self.problem.contacts().interactions().iter().flat_map(|interaction| interaction.slaves())
    }

    /// Sum of the contact forces on the slaves of all interfaces.
    pub fn contact_force(&self) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for Resultant { force, .. } in &self.record.contacts {
            (0..3).for_each(|axis| sum[axis] += force[axis]);
        }
        sum
    }
}

/// What was measured on a run to the end of time.
#[derive(Clone, Debug)]
pub struct Trace<T> {
    /// One measure an increment.
    pub measures: Vec<T>,
    /// Linear solutions, those of failed increments among them.
    pub iterations: usize,
    /// Increments that failed and were tried again with a shorter one.
    pub cutbacks: usize,
    /// How long it took.
    pub wall: Duration,
}

/// Runs a deck to the end of time and measures every increment. `base`: the directory that the deck's file names are relative to;
/// `threads`: those of the linear solver.
///
/// # Errors
/// Those of [`solve`](crate::solve::solve) except [`SolveError::EndedEarly`], in whose place there is its reason; an error of `measure`
/// ends the run.
pub fn trace<T>(
    deck: &Deck,
    base: &Path,
    threads: usize,
    measure: impl FnMut(&Snapshot<'_>) -> Result<T, SolidError>,
) -> Result<Trace<T>, SolveError> {
    trace_model(deck, &deck.model(base)?, threads, measure)
}

/// [`trace`] on a model of the deck, whose nodes may have been moved.
///
/// # Errors
/// Those of [`trace`].
pub fn trace_model<T>(
    deck: &Deck,
    model: &Model,
    threads: usize,
    measure: impl FnMut(&Snapshot<'_>) -> Result<T, SolidError>,
) -> Result<Trace<T>, SolveError> {
    let begin = Instant::now();
    let mut statics = statics(deck, model, threads)?;
    let start = statics.problem().start();
    let mut tracer = Tracer { measure, measures: Vec::new(), cutbacks: 0 };
    let state = statics.run(start, &mut tracer)?;
    let Tracer { measures, cutbacks, .. } = tracer;
    Ok(Trace { measures, iterations: state.iterations, cutbacks, wall: begin.elapsed() })
}

struct Tracer<T, F> {
    measure: F,
    measures: Vec<T>,
    cutbacks: usize,
}

impl<T, F: FnMut(&Snapshot<'_>) -> Result<T, SolidError>> Observer for Tracer<T, F> {
    fn cut_back(&mut self, _: f64, _: f64, _: &Failure) -> Control {
        self.cutbacks += 1;
        Control::Continue
    }

    fn increment(
        &mut self,
        record: &IncrementRecord,
        state: &State,
        problem: &Problem,
    ) -> Result<Control, Box<dyn std::error::Error + Send + Sync>> {
        self.measures.push((self.measure)(&Snapshot { record, state, problem })?);
        Ok(Control::Continue)
    }
}
