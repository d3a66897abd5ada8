//! What a run tells about itself.

use std::time::Duration;

use diffuse_contact::interface::FrictionReport;

use super::{Failure, Problem, State};
use crate::contact::{Fallbacks, Penetration, Resultant};

/// Whether to go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// With the next increment, or with the failed one again.
    Continue,
    /// No further: the run ends with what there is.
    Stop,
}

/// Is told of iterations and increments.
pub trait Observer {
    /// The residual was evaluated.
    fn iteration(&mut self, record: &IterationRecord) {
        let _ = record;
    }

    /// An increment failed. It is told before [`cut_back`](Self::cut_back), and when it ends the run.
    fn failed(&mut self, failed: &FailedIncrement<'_>) {
        let _ = failed;
    }

    /// An increment to time `end`, `length` long, failed and is tried again with a shorter one, unless this stops the run or there
    /// is no shorter one.
    fn cut_back(&mut self, end: f64, length: f64, reason: &Failure) -> Control {
        let _ = (end, length, reason);
        Control::Continue
    }

    /// An increment has converged; `problem` holds forces and contacts at its end.
    ///
    /// # Errors
    /// Whatever keeps the run from going on, such as a full disk.
    fn increment(
        &mut self,
        record: &IncrementRecord,
        state: &State,
        problem: &Problem,
    ) -> Result<Control, Box<dyn std::error::Error + Send + Sync>>;
}

/// An increment that failed.
#[derive(Clone, Copy, Debug)]
pub struct FailedIncrement<'a> {
    /// The time at which it would have ended.
    pub end: f64,
    /// Its length.
    pub length: f64,
    /// Why it failed.
    pub reason: &'a Failure,
    /// Its residuals.
    pub history: &'a [IterationRecord],
    /// Positions where it was left, length.
    pub positions: &'a [[f64; 3]],
}

/// A residual.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IterationRecord {
    /// The time at the end of the increment.
    pub time: f64,
    /// Linear solutions so far in this increment: 0 for the residual before the first. A round of augmentation begins with a residual
    /// of the same number, by the new multipliers.
    pub iteration: usize,
    /// Norm of the residual, force.
    pub residual: f64,
    /// The same divided by the norm of the forces.
    pub relative: f64,
    /// Norm of that part of the residual which rounding of the positions does not explain, force.
    pub excess: f64,
    /// What this had to come down to, force.
    pub allowed: f64,
    /// Contacts that carry force.
    pub active: usize,
    /// Factor on the last step; 0 for the first residual of an increment or of a round, unless it is that of an extrapolation.
    pub step: f64,
}

impl IterationRecord {
    /// Whether it is small enough only since rounding of the positions explains the rest.
    pub fn is_rounded(&self) -> bool {
        self.residual > self.allowed && self.excess <= self.allowed
    }
}

/// A converged increment.
#[derive(Clone, Debug, PartialEq)]
pub struct IncrementRecord {
    /// Its number in the run, from 1.
    pub number: usize,
    /// The time at its end.
    pub time: f64,
    /// Its length.
    pub length: f64,
    /// Linear solutions.
    pub iterations: usize,
    /// The most of them in one round of augmentation, or with one of softer penalties; all of them without either.
    pub longest_round: usize,
    /// Residuals, from the one before the first solution to the converged one.
    pub history: Vec<IterationRecord>,
    /// Rounds of augmentation.
    pub augmentations: usize,
    /// Whether these were over before the gaps were within the tolerance.
    pub is_short: bool,
    /// Contacts that carry force.
    pub active: usize,
    /// Contacts that carried force in it or right before it and ended without an element, and slaves that went through their masters.
    pub lost: usize,
    /// Interfaces whose force vanished in it although slaves that carried it have not risen from their masters, and how many these are.
    pub vanished: Vec<(String, usize)>,
    /// Interfaces with slaves whose masters do not carry the fit that was asked for.
    pub fallbacks: Vec<(String, Fallbacks)>,
    /// Interfaces with slaves deep below their masters, beside the size of their facets.
    pub penetrations: Vec<(String, Penetration)>,
    /// Integration points of loaded faces that have a gap but carry no force.
    pub missed: usize,
    /// Linear solutions in which slaves near their masters were supposed to touch, as nothing else held a body.
    pub supposed: usize,
    /// Whether contact was found with softer penalties first, as bodies came loose from it on the way.
    pub softened: bool,
    /// Negative eigenvalues of the last stiffness that was solved with, if it was symmetric, solved by factors, and neither stabilised nor of
    /// supposed contacts: equilibrium near there is not stable.
    pub negative: Option<usize>,
    /// Linear solutions in which nothing but the stabilisation held a part.
    pub stabilised: usize,
    /// Deepest penetration, length.
    pub max_penetration: f64,
    /// Elastic energy of the bodies.
    pub strain_energy: f64,
    /// What each interaction exerts on its slaves.
    pub contacts: Vec<Resultant>,
    /// What friction did in each interaction that has any.
    pub friction: Vec<Option<FrictionReport>>,
    /// Force that each support group exerts on the nodes it moves.
    pub reactions: Vec<[f64; 3]>,
    /// What its iterative linear solutions took.
    pub linear: LinearEffort,
    /// Time spent so far in the whole run.
    pub timing: Timing,
}

impl IncrementRecord {
    /// Whether it ended with a residual that is small enough only by rounding of the positions.
    pub fn is_rounded(&self) -> bool {
        self.history.last().is_some_and(IterationRecord::is_rounded)
    }

    /// Whether equilibrium is known not to be stable.
    pub fn is_unstable(&self) -> bool {
        self.negative.is_some_and(|count| count > 0)
    }

    /// Slaves that carry force without friction although their interaction has it: they had no gap at the end of the increment before.
    pub fn unanchored(&self) -> usize {
        self.friction.iter().flatten().map(|friction| friction.unanchored).sum()
    }
}

/// What the iterative linear solutions of an increment took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinearEffort {
    /// Iterations of all of them, also in vain.
    pub iterations: usize,
    /// Systems that were solved directly since the iterative solution did not converge.
    pub direct_instead: usize,
    /// The most memory that matrix, preconditioner and vectors took, bytes; 0 if all were solved directly.
    pub bytes: usize,
}

impl LinearEffort {
    /// Adds that of an earlier attempt.
    pub(super) fn add(&mut self, earlier: &Self) {
        self.iterations += earlier.iterations;
        self.direct_instead += earlier.direct_instead;
        self.bytes = self.bytes.max(earlier.bytes);
    }
}

/// Where the time went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Timing {
    /// Forces and stiffness of the solid.
    pub solid: Duration,
    /// Gap and derivatives of all contacts, with their forces and tangents.
    pub contact: Duration,
    /// Pairing slaves.
    pub pairing: Duration,
    /// Pattern of the stiffness, ordering, factorisation, solution.
    pub linear: Duration,
}
