//! How increments and iterations go.

use super::{State, StaticsError};
use crate::contact::ContactTangent;
use crate::named::named;
use crate::system::LinearSolverChoice;

/// All settings of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Settings {
    /// Increments.
    pub time: TimeSettings,
    /// Iterations.
    pub newton: NewtonSettings,
}

/// From 0 to `end` in increments.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct TimeSettings {
    /// T, the end of pseudo-time.
    pub end: f64,
    /// Length of the first increment.
    pub increment: f64,
    /// Shortest increment tried: cutting back stops below it.
    pub minimum: f64,
    /// Longest increment.
    pub maximum: f64,
    /// Factor ≥ 1 on the length after an increment that took few iterations.
    pub growth: f64,
    /// Factor < 1 on the length after a failure.
    pub cutback: f64,
}

/// Where an increment begins to look for its end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Extrapolation {
    /// At the end of a linear step from where it begins.
    #[default]
    None,
    /// On the straight line through the last two states: a linear solution fewer. The first increment, one after a failure and one whose
    /// extrapolation turns an element inside out take the linear step.
    Linear,
}

named!(Extrapolation { None => "none", Linear => "linear" });

/// Newton's method.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct NewtonSettings {
    /// Residual relative to the forces, > 0.
    pub tolerance: f64,
    /// Residual that is small enough whatever the forces are, force, ≥ 0. `None`: as large as
    /// [rounding](crate::solid::Solid::rounding_of_forces) makes it, in whatever units.
    pub absolute: Option<f64>,
    /// Most linear solutions in an increment, and in each round of an augmented Lagrangian; half as many more while whole steps
    /// bring the residual down, or three short ones to less than half.
    pub max_iterations: usize,
    /// An increment that takes at most so many, in each round of an augmented Lagrangian, lets the next one grow.
    pub few_iterations: usize,
    /// Whether a step that goes too far, so that the slope Δx·r changes its sign and stays large, is shortened.
    pub line_search: bool,
    /// The first guess.
    pub extrapolation: Extrapolation,
    /// The part of each diagonal entry of the stiffness that is added to it, ≥ 0. Forces have no such part: equilibrium stays what it
    /// is, and what no load moves stays in place.
    pub stabilisation: f64,
    /// How linear systems are solved.
    pub linear_solver: LinearSolverChoice,
    /// How the tangent of contact takes part in them.
    pub contact_tangent: ContactTangent,
}

impl Default for NewtonSettings {
    /// 1e-6 of the forces or their rounding, up to 20 iterations, 6 are few, with line search, without extrapolation and stabilisation; the linear
    /// solver by the size, the tangent of contact assembled.
    fn default() -> Self {
        Self {
            tolerance: 1e-6,
            absolute: None,
            max_iterations: 20,
            few_iterations: 6,
            line_search: true,
            extrapolation: Extrapolation::None,
            stabilisation: 0.0,
            linear_solver: LinearSolverChoice::Auto,
            contact_tangent: ContactTangent::Assembled,
        }
    }
}

impl Settings {
    /// With these increments and iterations.
    pub const fn new(time: TimeSettings, newton: NewtonSettings) -> Self {
        Self { time, newton }
    }

    /// Checks the ranges.
    pub(super) fn check(&self) -> Result<(), StaticsError> {
        let Self { time, newton } = self;
        let within = |name, value: f64, inside: bool, range| {
            if inside { Ok(()) } else { Err(StaticsError::Setting { name, value, range }) }
        };
        for (name, value) in [
            ("time.end", time.end),
            ("time.increment", time.increment),
            ("time.minimum", time.minimum),
            ("time.maximum", time.maximum),
            ("newton.tolerance", newton.tolerance),
        ] {
            within(name, value, value > 0.0 && value.is_finite(), "positive and finite")?;
        }
        let is_felt = time.minimum >= TimeSettings::SHORTEST * time.end;
        within("time.minimum", time.minimum, is_felt, "at least 1e-9 of time.end")?;
        let (growth, cutback, absolute) = (time.growth, time.cutback, newton.absolute.unwrap_or_default());
        within("time.growth", growth, growth >= 1.0 && growth.is_finite(), "at least 1 and finite")?;
        within("time.cutback", cutback, cutback > 0.0 && cutback < 1.0, "between 0 and 1")?;
        within(
            "newton.absolute",
            absolute,
            absolute >= 0.0 && absolute.is_finite(),
            "at least 0 and finite",
        )?;
        if newton.contact_tangent == ContactTangent::Operator
            && newton.linear_solver == LinearSolverChoice::Direct
        {
            return Err(StaticsError::NoFactors);
        }
        let part = newton.stabilisation;
        within("newton.stabilisation", part, (0.0..1.0).contains(&part), "at least 0 and below 1")?;
        within("newton.max_iterations", newton.max_iterations as f64, newton.max_iterations > 0, "at least 1")
    }
}

impl TimeSettings {
    /// Increments that start at `increment` and grow no further; cutting back stops after ten halvings, or at a billionth of the end.
    pub const fn new(end: f64, increment: f64) -> Self {
        let minimum = (increment / 1024.0).max(Self::SHORTEST * end);
        Self { end, increment, minimum, maximum: increment, growth: 1.5, cutback: 0.5 }
    }

    /// All increments are equal: there is no growth and no cut-back, and what fails ends the run.
    pub const fn fixed(end: f64, increment: f64) -> Self {
        Self { minimum: increment, growth: 1.0, ..Self::new(end, increment) }
    }

    /// Rounding of a sum of increments, relative to the end.
    pub(super) const ROUNDING: f64 = 1e-9;

    /// The shortest increment that may be asked for, relative to the end. A run of shorter ones would be over before its end, to rounding.
    pub(crate) const SHORTEST: f64 = 1e-9;

    pub(super) fn is_over(&self, time: f64) -> bool {
        time >= self.end * (1.0 - Self::ROUNDING)
    }

    /// Length of the next increment.
    pub(super) fn length(&self, state: &State) -> f64 {
        let length = if state.length > 0.0 { state.length } else { self.increment };
        length.min(self.maximum)
    }

    /// The end of an increment planned to be `length` long: the next of `stops` (ascending) or the end of time, exactly, if it would go
    /// beyond or within rounding of it.
    pub(super) fn next(&self, time: f64, length: f64, stops: &[f64]) -> f64 {
        let end = time + length;
        match self.stop_after(time, stops) {
            Some(stop) if self.has_reached(end, stop) => stop,
            _ if self.is_over(end) => self.end,
            _ => end,
        }
    }

    /// The first stop after `time` and before the end of time.
    fn stop_after(&self, time: f64, stops: &[f64]) -> Option<f64> {
        let first = stops.partition_point(|&stop| self.has_reached(time, stop));
        stops.get(first).copied().filter(|&stop| !self.is_over(stop))
    }

    /// Whether `time` is at `mark` or later, to rounding.
    fn has_reached(&self, time: f64, mark: f64) -> bool {
        time >= mark - self.end * Self::ROUNDING
    }

    /// Length to plan with after an increment from `time` to `end` that was planned to be `length` long. One that was shortened to meet
    /// `end` is no reason to stay short, and none to grow beyond what its own length stands for.
    pub(super) fn after(
        &self,
        [time, end]: [f64; 2],
        length: f64,
        iterations: usize,
        newton: &NewtonSettings,
    ) -> f64 {
        let own = if self.is_shortened([time, end], length) { end - time } else { length };
        self.grown(own, iterations, newton).max(length)
    }

    /// Whether an increment from `time` to `end` met a stop before the `length` that was planned.
    pub(super) fn is_shortened(&self, [time, end]: [f64; 2], length: f64) -> bool {
        !self.is_over(end) && !self.has_reached(end, time + length)
    }

    fn grown(&self, length: f64, iterations: usize, newton: &NewtonSettings) -> f64 {
        let factor = if iterations <= newton.few_iterations { self.growth } else { 1.0 };
        (length * factor).min(self.maximum)
    }

    pub(super) fn cut(&self, length: f64) -> f64 {
        length * self.cutback
    }
}
