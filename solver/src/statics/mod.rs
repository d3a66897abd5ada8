//! Equilibrium over time: increments, Newton's method, cut-back and growth.
//!
//! A [`Problem`] is what has to be in equilibrium, a [`State`] what history there is. [`Statics::run`] leads from a state to
//! the end of time, one converged increment after the other, and tells an [`Observer`] about each; it knows nothing of files.
//!
//! **An increment** starts from a committed state. Slaves are paired at its positions, and one linear step from there, with the
//! prescribed nodes moving to where they belong at the new time, predicts the new positions; with [`Extrapolation::Linear`] they are
//! extrapolated instead. From then on it is Newton's method:
//!
//! ```text
//! r = f_ext(t, x) + Σ f_k N_k − f_int(x)      K Δx = r      x ← x + s Δx
//! ```
//!
//! It ends at the times that [`Statics::stopping_at`] was told, if it would go beyond one.
//!
//! **Convergence**: ‖max(0, |r| − ε |K| |x|)‖ ≤ tolerance · F + absolute, over the free degrees of freedom. ε |K| |x| is what rounding of
//! the positions makes of each component of r, ε the machine's, so that no stiff part excuses a soft one; F is the largest of the norms of
//! external forces, reactions and contact forces of the moment. What moves nothing is no part of F: loads on prescribed degrees of
//! freedom, and contact and elements all of whose nodes are prescribed. The same rule holds for every element.
//!
//! **Linear solutions** of large problems are iterative, as accurate as Newton's method has use for: the residual may be 0.9 (r / r before)²
//! of r, sizes without what [stiff contact takes up by itself](crate::system::Accuracy), by S. C. Eisenstat and H. F. Walker (SIAM Journal on Scientific Computing 17, 1996, 16–32), between bounds.
//!
//! **Line search**: if the slope Δx·r changes its sign over a full step and is not below 0.8 of what it was, s is sought by
//! regula falsi between 0.005 and 1, by halves where a loose body moves freely at first; of the steps tried the one with the smallest slope is taken. A slope that keeps its sign says
//! that no shorter step is better. A Newton step that turns an element inside out is halved first, the linear prediction is not.
//!
//! **Softer penalties**: an increment that fails although contacts were supposed to close, since nothing else held a body, begins again with
//! 10⁻⁴ of all normal penalties and goes on with stiffer ones, from equilibrium to equilibrium.
//!
//! **Cut-back**: an increment that does not converge within its iterations, diverges, turns an element inside out in spite of
//! halved steps, goes where contact cannot be evaluated, or ends without contacts that carried force since their elements have no
//! result, or with slaves that went through the master, starts again with a fraction of its length; nothing of the failed try is kept. Lost
//! contacts are accepted where there is no shorter increment, and counted. Below the smallest length the run ends with [`StaticsError::NoConvergence`]: all increments before it are valid.

mod convergence;
mod error;
mod increment;
mod line_search;
mod linear;
mod loose;
mod observer;
mod pressure;
mod problem;
mod settings;
mod shown_time;
mod sparse;
mod unloaded;

pub use error::{Failure, StaticsError};
pub use loose::{Loose, RigidMotion};
pub use observer::{
    Control, FailedIncrement, IncrementRecord, IterationRecord, LinearEffort, Observer, Timing,
};
pub use pressure::Pressure;
pub use problem::{Past, Problem, State};
pub use settings::{Extrapolation, NewtonSettings, Settings, TimeSettings};
pub use shown_time::ShownTime;

use increment::Increment;

/// Leads a problem through time.
pub struct Statics {
    problem: Problem,
    settings: Settings,
    /// Times that no increment goes beyond without ending there, ascending.
    stops: Vec<f64>,
    effort: Effort,
}

/// What a run and those that it went on from took, increments that failed among them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Linear solutions.
    pub iterations: usize,
    /// Increments that failed.
    pub cutbacks: usize,
}

impl Statics {
    /// A problem and how to solve it.
    ///
    /// # Errors
    /// [`StaticsError::Setting`], [`StaticsError::NoFactors`]; [`StaticsError::Contact`] where the tangent is no operator.
    pub fn new(mut problem: Problem, settings: Settings) -> Result<Self, StaticsError> {
        settings.check()?;
        problem.set(&settings.newton)?;
        Ok(Self { problem, settings, stops: Vec::new(), effort: Effort::default() })
    }

    /// Lets increments end at these times, in any order, too: those of the points of amplitudes, so that no load between them is stepped
    /// over. An increment that would go beyond one ends there, and the next has the length again that this one was to have.
    #[must_use]
    pub fn stopping_at(mut self, times: impl IntoIterator<Item = f64>) -> Self {
        self.stops.extend(times.into_iter().filter(|time| time.is_finite()));
        self.stops.sort_by(f64::total_cmp);
        self
    }

    /// The problem.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// Pairs and evaluates the contacts at a state, so that [`problem`](Self::problem) shows them.
    ///
    /// # Errors
    /// [`StaticsError::Contact`].
    pub fn look_at_contacts(&mut self, state: &State) -> Result<(), StaticsError> {
        self.problem.look_at_contacts(state)
    }

    /// What the last [`run`](Self::run) took, and what came before its first state; the last state of a run that failed does not
    /// know of its last tries.
    pub fn effort(&self) -> Effort {
        self.effort
    }

    /// Whether a state can be gone on from.
    ///
    /// # Errors
    /// [`StaticsError::StateOutOfRange`], [`StaticsError::ForeignState`], [`StaticsError::Contact`].
    pub fn check_state(&mut self, state: &State) -> Result<(), StaticsError> {
        let end = self.settings.time.end;
        let outside = |what, value, range| Err(StaticsError::StateOutOfRange { what, value, range });
        // What rounding adds to the last increment is no time beyond the end.
        if !(0.0..=end * (1.0 + TimeSettings::ROUNDING)).contains(&state.time) {
            return outside("time", state.time, "from 0 to the end of time");
        }
        if !(0.0..=f64::MAX).contains(&state.length) {
            return outside("length of an increment", state.length, "at least 0 and finite");
        }
        for (what, count) in
            [("number of iterations", state.iterations), ("number of cut-backs", state.cutbacks)]
        {
            if u32::try_from(count).is_err() {
                return outside(what, count as f64, "at most 4294967295");
            }
        }
        for history in &state.friction {
            let has_length = history.lasted > 0.0 || history.anchors_before.is_empty();
            if !(0.0..=f64::MAX).contains(&history.lasted) || !has_length {
                let range = "finite and at least 0, and positive where anchors of its start are given";
                return outside("length of the last increment", history.lasted, range);
            }
            if !history.dissipated.is_finite() {
                return outside("work of friction", history.dissipated, "finite");
            }
        }
        self.problem.check_state(state)
    }

    /// Goes on from `state` until the end of time, or until the observer stops it. Returns the last converged state.
    ///
    /// # Errors
    /// [`StaticsError::NoConvergence`] when the smallest increment does not converge, [`StaticsError::Observer`] if the observer fails,
    /// [`StaticsError::Solid`], [`StaticsError::Contact`], [`StaticsError::System`] for what a smaller increment does not mend.
    pub fn run(&mut self, mut state: State, observer: &mut dyn Observer) -> Result<State, StaticsError> {
        let time = self.settings.time;
        self.effort = Effort { iterations: state.iterations, cutbacks: state.cutbacks };
        while !time.is_over(state.time) {
            let length = time.length(&state);
            let end = time.next(state.time, length, &self.stops);
            let is_shortest = time.cut(end - state.time) < time.minimum;
            let mut increment = Increment::new(&mut self.problem, &self.settings, &state, end, is_shortest);
            let outcome = increment.solve(observer);
            let iterations = state.iterations + increment.iterations();
            let (history, positions) = increment.left();
            self.effort = Effort { iterations, cutbacks: state.cutbacks };
            match outcome {
                Ok((mut next, record)) => {
                    let from_to = [state.time, end];
                    next.length = time.after(from_to, length, record.longest_round, &self.settings.newton);
                    if time.is_shortened(from_to, length) {
                        // A line through a short piece says little of a long one.
                        next.past = None;
                    }
                    let control = observer.increment(&record, &next, &self.problem);
                    state = next;
                    match control.map_err(StaticsError::Observer)? {
                        Control::Continue => {}
                        Control::Stop => break,
                    }
                }
                Err(failure) => {
                    let (reason, history, positions) = (&failure, &history[..], &positions[..]);
                    let failed =
                        FailedIncrement { end, length: end - state.time, reason, history, positions };
                    observer.failed(&failed);
                    if self.cut_back(&mut state, end, iterations, failure, observer)? == Control::Stop {
                        break;
                    }
                }
            }
        }
        Ok(state)
    }

    /// Makes the next increment shorter, unless it would be too short. `iterations`: with those of the failed one.
    fn cut_back(
        &mut self,
        state: &mut State,
        end: f64,
        iterations: usize,
        failure: Failure,
        observer: &mut dyn Observer,
    ) -> Result<Control, StaticsError> {
        if let Failure::Fatal(error) = failure {
            return Err(error);
        }
        let time = self.settings.time;
        // The last increment may be shorter than was planned.
        let length = end - state.time;
        if time.cut(length) < time.minimum {
            let (time, minimum, reason) = (state.time, time.minimum, Box::new(failure));
            return Err(StaticsError::NoConvergence { time, length, minimum, reason });
        }
        // Of the failed try only its price is kept.
        state.iterations = iterations;
        state.cutbacks += 1;
        state.length = time.cut(length);
        // The path may have turned.
        state.past = None;
        self.effort.cutbacks += 1;
        Ok(observer.cut_back(end, length, &failure))
    }
}
