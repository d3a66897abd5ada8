//! One increment.

use super::convergence::{comes_back, is_spent};
use super::line_search::line_search;
use super::observer::{IncrementRecord, IterationRecord, Observer};
use super::problem::{Balance, Past, Problem, State};
use super::{Extrapolation, Failure, Settings};
use crate::contact::{Augmented, RefreshRule, Way};
use crate::solid::Order;
use crate::system::Accuracy;

/// The residual that counts as divergence, relative to the largest of the first two of the increment, or of the round.
const DIVERGED: f64 = 1e6;
/// The relative residual of the linear solution that takes prescribed nodes along, if it is iterative: its right-hand side is the resistance
/// of the elements beside them, which is much more than the forces.
const PREDICTION: f64 = 1e-6;
/// Bounds of the residual of an iterative solution of a Newton step, over the size of its right-hand side. With the loosest one blocks in
/// contact take as many Newton steps as with factors, for penalties a hundred times apart, over nodes and faces; ten times looser some take more.
const LOOSEST: f64 = 1e-4;
const TIGHTEST: f64 = 1e-9;
/// How far a loaded part may be from equilibrium, over the forces on it.
const OF_A_PART: f64 = 1e-3;
/// Parts of the penalty that contact is found with one after the other, before that with all of it, where a body comes loose from it on the
/// way. The gap of a moving body is not linear: what is left of it after a step may be more than the penetration, and then there is no contact
/// to go on from.
const SOFTER: [f64; 6] = [1e-4, 1e-3, 1e-2, 0.03, 0.1, 0.3];
/// How often a step that turns an element inside out, or takes contacts their elements, is halved.
const HALVINGS: usize = 8;

/// An increment on its way.
pub struct Increment<'a> {
    problem: &'a mut Problem,
    settings: &'a Settings,
    committed: &'a State,
    end: f64,
    /// Whether it may end with lost contacts: a shorter one would not be tried.
    is_shortest: bool,
    positions: Vec<[f64; 3]>,
    history: Vec<IterationRecord>,
    iterations: usize,
    step: f64,
    /// The size of the right-hand side of the last Newton step, if its solution was iterative.
    size: Option<f64>,
    /// Whether the last state was in equilibrium as a whole, and a part of it was not.
    is_balanced: bool,
    rounds: Rounds,
    cycle: Cycle,
    /// How many of the softer penalties are still to come, and whether there were any.
    softer: usize,
    is_softened: bool,
    /// Linear solutions before the attempt on its way.
    before: usize,
}

/// Whether residuals come back every second time.
#[derive(Clone, Copy, Debug, Default)]
struct Cycle {
    /// Where in the history to look from.
    begin: usize,
    /// Whether the next step is to be halved, as the middle of two states that lead to each other leads elsewhere.
    halves: bool,
    /// Whether that was tried.
    is_known: bool,
}

/// How the augmentation goes.
#[derive(Clone, Copy, Debug, Default)]
struct Rounds {
    /// Rounds begun after the first equilibrium.
    count: usize,
    /// Linear solutions in the round on its way.
    iterations: usize,
    /// Those of the longest one.
    longest: usize,
    /// Where the residuals of the round on its way begin in the history.
    begin: usize,
    is_short: bool,
}

impl<'a> Increment<'a> {
    /// From a committed state to time `end`; `is_shortest`: a failure would end the run.
    pub fn new(
        problem: &'a mut Problem,
        settings: &'a Settings,
        committed: &'a State,
        end: f64,
        is_shortest: bool,
    ) -> Self {
        Self {
            problem,
            settings,
            committed,
            end,
            is_shortest,
            positions: committed.positions.clone(),
            history: Vec::new(),
            iterations: 0,
            step: 0.0,
            size: None,
            is_balanced: false,
            rounds: Rounds::default(),
            cycle: Cycle::default(),
            softer: 0,
            is_softened: false,
            before: 0,
        }
    }

    /// Iterates to equilibrium, with softer penalties first if a body came loose on the way without. A failure leaves the committed state
    /// what it is.
    pub fn solve(&mut self, observer: &mut dyn Observer) -> Result<(State, IncrementRecord), Failure> {
        let failure = match self.attempt(observer) {
            Err(failure) if failure.may_be_of_contact() && self.may_soften() => failure,
            outcome => return outcome,
        };
        let (left, count) = (self.positions.clone(), self.history.len());
        let Problem { supposed, stabilised, linear, .. } = *self.problem;
        self.positions.copy_from_slice(&self.committed.positions);
        (self.step, self.size, self.is_balanced) = (0.0, None, false);
        self.rounds = Rounds { begin: count, ..Rounds::default() };
        self.cycle = Cycle { begin: count, ..Cycle::default() };
        (self.softer, self.is_softened, self.before) = (SOFTER.len(), true, self.iterations);
        self.problem.contacts_mut().soften(SOFTER[0]);
        let outcome = self.attempt(observer);
        self.problem.contacts_mut().soften(1.0);
        if let Ok((state, mut record)) = outcome {
            record.supposed += supposed;
            record.stabilised += stabilised;
            record.linear.add(&linear);
            return Ok((state, record));
        }
        // What is told is the state that failed without. Where its forces are not found again they are not known.
        self.positions = left;
        let is_found = self.problem.refresh(RefreshRule::Iteration, &self.positions).is_ok()
            && self.evaluate(Order::Residual).is_ok();
        self.history.truncate(if is_found { count } else { count.min(1) });
        Err(failure)
    }

    /// Whether softer penalties may help: a body came loose from its contact, and no multipliers hold forces that penalties do not.
    fn may_soften(&self) -> bool {
        self.problem.supposed > 0
            && self.problem.contacts().multipliers().iter().flatten().all(|&force| force == 0.0)
    }

    fn attempt(&mut self, observer: &mut dyn Observer) -> Result<(State, IncrementRecord), Failure> {
        let newton = self.settings.newton;
        self.problem.take_history(self.committed)?;
        self.problem.refresh(RefreshRule::Increment, &self.positions)?;
        self.problem.contacts_mut().lasts(self.end - self.committed.time);
        self.problem.contacts_mut().begin_friction()?;
        let mut balance = match self.extrapolate()? {
            Some(balance) => balance,
            None => {
                // Seen from the committed points the next step is elastic; with the tangent of the last increment yielding goes on, and
                // so does sliding.
                let slides_on = self.look_back()?;
                let before = &self.committed.points_before;
                let balance = self.problem.evaluate(self.end, &self.positions, before, Order::Tangent)?;
                // Who has no element already here is not kept by a shorter increment.
                self.problem.contacts_mut().excuse();
                self.record(balance, observer)?;
                self.predict(slides_on)?
            }
        };
        self.rounds.iterations = 1;
        loop {
            self.record(balance, observer)?;
            let is_balanced = balance.excess <= self.allowed(balance);
            let of_parts = if is_balanced { self.problem.worst_part() } else { 0.0 };
            if is_balanced && of_parts <= OF_A_PART && self.harden(observer)? {
                // The next round begins.
            } else if is_balanced && of_parts <= OF_A_PART {
                self.check_losses()?;
                if self.augment(observer)? {
                    let before = (self.committed.increments > 0).then_some(&self.committed.positions[..]);
                    let times = (self.end, self.committed.time);
                    self.problem.check_loads(times, &self.positions, before, self.allowed(balance))?;
                    break;
                }
            } else if is_spent(
                &self.history[self.rounds.begin..],
                self.rounds.iterations,
                newton.max_iterations,
            ) {
                let residual = (balance.residual / balance.scale).max(of_parts);
                let left = self.problem.contacts().left().collect();
                let (iterations, stabilised) = (self.iterations, self.problem.stabilised);
                return Err(Failure::Iterations { residual, iterations, stabilised, left });
            } else {
                self.check_cycle(balance)?;
            }
            self.is_balanced = is_balanced && of_parts > OF_A_PART;
            balance = self.iterate()?;
            self.rounds.iterations += 1;
        }
        self.finish()
    }

    /// The excess that is small enough.
    fn allowed(&self, balance: Balance) -> f64 {
        self.settings.newton.tolerance * balance.scale + self.problem.negligible
    }

    /// Two rounds of two states that lead to each other: the first time a halved step follows, the second time there is no end to it.
    fn check_cycle(&mut self, balance: Balance) -> Result<(), Failure> {
        let begin = self.cycle.begin.max(self.rounds.begin);
        if !comes_back(&self.history[begin..]) {
            return Ok(());
        }
        if self.cycle.is_known {
            let residual = balance.residual / balance.scale;
            let left = self.problem.contacts().left().collect();
            return Err(Failure::Cycle { residual, iteration: self.iterations, left });
        }
        self.cycle = Cycle { begin: self.history.len() - 1, halves: true, is_known: true };
        Ok(())
    }

    /// From the committed positions to those of the moment.
    fn way(&self) -> Way<'_> {
        Way { from: &self.committed.positions, to: &self.positions }
    }

    /// Equilibrium without a contact that carried force on the way, or with a slave that went through, is another one: a shorter increment
    /// may keep the contact, unless it went with the pairing or there is none.
    fn check_losses(&self) -> Result<(), Failure> {
        if self.is_shortest {
            return Ok(());
        }
        let mut lost = self.problem.contacts().lost(self.way()).filter(|(_, lost)| !lost.from_start);
        let Some((interface, first)) = lost.next() else { return Ok(()) };
        let (interface, node, loss) = (interface.to_owned(), first.node, first.loss);
        Err(Failure::Lost { interface, node, loss, count: 1 + lost.count() })
    }

    /// In equilibrium: begins another round of augmentation, or tells that there is none to come.
    fn augment(&mut self, observer: &mut dyn Observer) -> Result<bool, Failure> {
        self.rounds.longest = self.rounds.longest.max(self.rounds.iterations);
        let augmented = self.problem.contacts_mut().augment(self.rounds.count)?;
        if augmented != Augmented::Due {
            self.rounds.is_short = augmented == Augmented::Short;
            return Ok(true);
        }
        self.rounds.count += 1;
        self.begin_round(observer)?;
        Ok(false)
    }

    /// In equilibrium with a softer penalty: goes on with the next stiffer one; whether there is any.
    fn harden(&mut self, observer: &mut dyn Observer) -> Result<bool, Failure> {
        if self.softer == 0 {
            return Ok(false);
        }
        self.softer -= 1;
        let softness = SOFTER.get(SOFTER.len() - self.softer).copied().unwrap_or(1.0);
        self.problem.contacts_mut().soften(softness);
        self.begin_round(observer)?;
        Ok(true)
    }

    /// What the new multipliers or penalties put out of balance is what the round starts from.
    fn begin_round(&mut self, observer: &mut dyn Observer) -> Result<(), Failure> {
        self.cycle = Cycle::default();
        self.rounds.longest = self.rounds.longest.max(self.rounds.iterations);
        (self.rounds.iterations, self.rounds.begin) = (0, self.history.len());
        (self.step, self.size) = (0.0, None);
        let balance = self.evaluate(Order::Tangent)?;
        self.record(balance, observer)
    }

    fn evaluate(&mut self, order: Order) -> Result<Balance, Failure> {
        self.problem.evaluate(self.end, &self.positions, &self.committed.points, order)
    }

    /// Notes a residual and who carries force; one that is no number or too large is a failure.
    fn record(&mut self, balance: Balance, observer: &mut dyn Observer) -> Result<(), Failure> {
        let Balance { residual, scale, excess } = balance;
        // With softer penalties other slaves carry force.
        if self.softer == 0 {
            self.problem.contacts_mut().note();
        }
        let relative = balance.relative();
        let record = IterationRecord {
            time: self.end,
            iteration: self.iterations,
            residual,
            relative,
            excess,
            allowed: self.allowed(balance),
            active: self.problem.active(),
            step: self.step,
        };
        observer.iteration(&record);
        self.history.push(record);
        let round = &self.history[self.rounds.begin..];
        let first = round.iter().take(2).map(|record| record.residual).fold(record.allowed, f64::max);
        if !residual.is_finite() || !scale.is_finite() || residual > DIVERGED * first {
            return Err(Failure::Diverged { residual: relative, iteration: self.iterations });
        }
        Ok(())
    }

    /// Goes on along the line through the last two states, if there are two and no element is inside out there.
    fn extrapolate(&mut self) -> Result<Option<Balance>, Failure> {
        let committed = self.committed;
        let Some(past) = &committed.past else { return Ok(None) };
        self.problem.excuse(&self.positions)?;
        let factor = (self.end - committed.time) / (committed.time - past.time);
        for (position, earlier) in self.positions.iter_mut().zip(&past.positions) {
            for axis in 0..3 {
                position[axis] += factor * (position[axis] - earlier[axis]);
            }
        }
        self.place_prescribed();
        self.step = 1.0;
        match self.settle() {
            Ok(balance) => Ok(Some(balance)),
            Err(Failure::Inverted(_)) => {
                self.step = 0.0;
                self.positions.copy_from_slice(&self.committed.positions);
                self.problem.refresh(RefreshRule::Iteration, &self.positions)?;
                Ok(None)
            }
            Err(failure) => Err(failure),
        }
    }

    /// The linear step that takes the prescribed nodes to where they belong: the whole of it, since they do not belong half-way. If it
    /// turns an element inside out a shorter increment has to do.
    fn predict(&mut self, slides_on: bool) -> Result<Balance, Failure> {
        let prescribed: Vec<(usize, f64)> = self
            .targets()
            .into_iter()
            .map(|(freedom, target)| (freedom, target - self.positions[freedom / 3][freedom % 3]))
            .collect();
        let step = self.linear_solution(&prescribed, Accuracy::fixed(PREDICTION))?;
        if slides_on {
            let contacts = self.problem.contacts_mut();
            contacts.set_friction_history(&self.committed.friction)?;
            contacts.lasts(self.end - self.committed.time);
            self.problem.refresh(RefreshRule::Increment, &self.positions)?;
        }
        let origin = self.positions.clone();
        self.advance(&origin, &step, 1.0);
        self.place_prescribed();
        self.step = 1.0;
        self.settle()
    }

    /// Measures friction as in the last increment, unless what is prescribed turns by a right angle or more; whether it does.
    fn look_back(&mut self) -> Result<bool, Failure> {
        let State { time, friction, .. } = self.committed;
        let lasted = friction.iter().map(|pass| pass.lasted).fold(0.0, f64::max);
        let at = |time: f64| self.problem.supports().targets(time, self.problem.start_positions());
        let ways = at(time - lasted).zip(at(*time)).zip(at(self.end));
        let (mut along, mut size) = (0.0, 0.0);
        for (((_, before), (_, now)), (_, then)) in ways {
            along += (now - before) * (then - now);
            size += (then - now).abs();
        }
        if !(along > 0.0 || size == 0.0) || !self.problem.contacts_mut().look_back(friction)? {
            return Ok(false);
        }
        self.problem.refresh(RefreshRule::Increment, &self.positions)?;
        Ok(true)
    }

    /// Where the prescribed degrees of freedom belong.
    fn targets(&self) -> Vec<(usize, f64)> {
        self.problem.supports().targets(self.end, self.problem.start_positions()).collect()
    }

    /// Takes the prescribed degrees of freedom to where they belong exactly, not to rounding.
    fn place_prescribed(&mut self) {
        for (freedom, target) in self.targets() {
            self.positions[freedom / 3][freedom % 3] = target;
        }
    }

    /// A Newton step, as far along as the line search says.
    fn iterate(&mut self) -> Result<Balance, Failure> {
        let step = self.linear_solution(&[], self.forcing())?;
        self.size = self.problem.size;
        let slope = |problem: &Problem| -> f64 {
            -problem.imbalance().zip(&step).map(|(force, step)| force * step).sum::<f64>()
        };
        let before = slope(self.problem);
        let origin = self.positions.clone();
        let (full, balance) = self.longest(&origin, &step)?;
        self.step = full;
        let mut is_whole = true;
        if self.settings.newton.line_search {
            let after = slope(self.problem);
            self.step *= line_search(before, after, |s| {
                is_whole = false;
                self.advance(&origin, &step, s * full);
                match self.evaluate(Order::Residual) {
                    Ok(_) => Ok::<f64, Failure>(slope(self.problem)),
                    Err(Failure::Inverted(_)) => Ok(f64::NAN),
                    Err(failure) => Err(failure),
                }
            })?;
        }
        if std::mem::take(&mut self.cycle.halves) {
            self.step *= 0.5;
            is_whole = false;
        }
        // Most steps are taken whole, and then everything is there already.
        if is_whole && !self.problem.pairs_in_iterations() {
            return Ok(balance);
        }
        self.advance(&origin, &step, self.step);
        self.settle()
    }

    /// Pairs anew where that is due in every iteration, and evaluates.
    fn settle(&mut self) -> Result<Balance, Failure> {
        self.problem.refresh(RefreshRule::Iteration, &self.positions)?;
        self.evaluate(Order::Tangent)
    }

    /// Takes the full step, or the part of it that leaves all elements the right way round and the contacts their elements, and
    /// evaluates there. Where a body has gone through another no force tells the line search so.
    fn longest(&mut self, origin: &[[f64; 3]], step: &[f64]) -> Result<(f64, Balance), Failure> {
        let lost =
            |own: &Self| own.problem.contacts().lost(own.way()).filter(|(_, lost)| !lost.from_start).count();
        let lost_before = lost(self);
        let mut length = 1.0;
        for _ in 0..HALVINGS {
            self.advance(origin, step, length);
            match self.evaluate(Order::Tangent) {
                Ok(balance) if lost(self) <= lost_before => return Ok((length, balance)),
                Ok(_) | Err(Failure::Inverted(_)) => length *= 0.5,
                Err(failure) => return Err(failure),
            }
        }
        self.advance(origin, step, length);
        self.evaluate(Order::Tangent).map(|balance| (length, balance))
    }

    fn linear_solution(
        &mut self,
        prescribed: &[(usize, f64)],
        accuracy: Accuracy,
    ) -> Result<Vec<f64>, Failure> {
        self.iterations += 1;
        let is_alone = self.problem.is_of_the_bodies_alone();
        // Where the increment begins, not where a line through the last two states leads.
        let is_start = self.iterations == self.before + 1 && self.positions == self.committed.positions;
        let solved = self.problem.solve(self.end, &self.positions, prescribed, accuracy);
        let had_contact = self.committed.loaded.iter().any(|slaves| !slaves.is_empty());
        // A shorter increment has the same stiffness at its start. Contacts that were supposed it has to suppose again, unless it begins
        // with some.
        let is_final = is_alone && (is_start || self.problem.supposed > 0 && !had_contact);
        let time = self.committed.time;
        solved.map_err(|failure| if is_final { failure.without_contact(time) } else { failure })
    }

    /// How accurate an iterative solution of a Newton step is: a residual that shrinks with the square of what the last step gained keeps
    /// the convergence quadratic. Less than a tenth of what is allowed in equilibrium is of no use.
    fn forcing(&self) -> Accuracy {
        if self.is_balanced {
            // As a whole, but not each part: what is allowed of the whole says nothing.
            return Accuracy::between(LOOSEST, TIGHTEST).after(self.size);
        }
        let enough = self.history.last().map_or(0.0, |last| 0.1 * last.allowed / last.residual);
        let tightest = if enough.is_finite() { enough.clamp(TIGHTEST, 0.1) } else { LOOSEST };
        Accuracy::between(LOOSEST.max(tightest), tightest).after(self.size)
    }

    /// x ← origin + factor · step
    fn advance(&mut self, origin: &[[f64; 3]], step: &[f64], factor: f64) {
        let moves = origin.iter().zip(step.as_chunks::<3>().0);
        for (position, (origin, step)) in self.positions.iter_mut().zip(moves) {
            for axis in 0..3 {
                position[axis] = origin[axis] + factor * step[axis];
            }
        }
    }

    /// The residuals and the positions where it was left.
    pub fn left(self) -> (Vec<IterationRecord>, Vec<[f64; 3]>) {
        (self.history, self.positions)
    }

    /// Linear solutions so far.
    pub fn iterations(&self) -> usize {
        self.iterations
    }

    fn finish(&mut self) -> Result<(State, IncrementRecord), Failure> {
        let solid = self.problem.solid();
        let strain_energy =
            solid.stored_energy(&self.positions, &self.committed.points).map_err(Failure::of_solid)?;
        let friction = self.problem.contacts_mut().accept()?;
        let &mut Self { committed, end, iterations, rounds, .. } = self;
        let positions = std::mem::take(&mut self.positions);
        let history = std::mem::take(&mut self.history);
        let past = (self.settings.newton.extrapolation == Extrapolation::Linear)
            .then(|| Past { time: committed.time, positions: committed.positions.clone() });
        let problem = &*self.problem;
        let state = State {
            time: end,
            length: committed.length,
            increments: committed.increments + 1,
            iterations: committed.iterations + iterations,
            cutbacks: committed.cutbacks,
            positions,
            past,
            points: problem.response().states.clone(),
            points_before: committed.points.clone(),
            multipliers: problem.contacts().multipliers(),
            loaded: problem.contacts().loaded(),
            friction: problem.contacts().friction_history(),
        };
        let way = Way { from: &committed.positions, to: &state.positions };
        let imbalance: Vec<f64> = problem.imbalance().collect();
        let groups = 0..problem.supports().groups().len();
        let longest = problem.largest_motion(&state.positions);
        let record = IncrementRecord {
            number: state.increments,
            time: end,
            length: end - committed.time,
            iterations,
            longest_round: rounds.longest,
            history,
            augmentations: rounds.count,
            is_short: rounds.is_short,
            active: problem.active(),
            lost: problem.contacts().lost(way).count(),
            vanished: problem.contacts().vanished(way).collect(),
            fallbacks: problem.contacts().fallbacks().collect(),
            penetrations: problem.contacts().penetrations(&state.positions, longest).collect(),
            missed: problem.contacts().missed(),
            supposed: problem.supposed,
            softened: self.is_softened,
            negative: problem.negative,
            stabilised: problem.stabilised,
            linear: problem.linear,
            max_penetration: problem.contacts().max_penetration(),
            strain_energy,
            contacts: problem.contacts().resultants(&state.positions),
            friction,
            reactions: groups.map(|group| problem.supports().sum(group, &imbalance)).collect(),
            timing: problem.timing,
        };
        Ok((state, record))
    }
}
