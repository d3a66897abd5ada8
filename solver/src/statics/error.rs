//! Why a run or an increment ended early.

use diffuse_contact_mesh::names::shown;
use thiserror::Error;

use super::{Loose, ShownTime};
use crate::contact::{ContactError, Loss};
use crate::solid::SolidError;
use crate::system::SystemError;

/// Why a run ended before the end of time.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StaticsError {
    /// A setting out of its range.
    #[error("{name} is {value}; it has to be {range}")]
    Setting {
        /// Its name in the deck.
        name: &'static str,
        /// What was given.
        value: f64,
        /// What is allowed.
        range: &'static str,
    },
    /// An operator has no factors.
    #[error(
        "newton.contact_tangent is an operator, which has no factors; newton.linear_solver has to be iterative or auto"
    )]
    NoFactors,
    /// The shortest increment did not converge.
    #[error(
        "no convergence after time {}: {reason}; the increment of {length:.3e} may not be cut below {minimum:.3e}",
        ShownTime(*time)
    )]
    NoConvergence {
        /// The time that was reached.
        time: f64,
        /// Length of the last increment tried.
        length: f64,
        /// Shortest length allowed.
        minimum: f64,
        /// Why it failed.
        reason: Box<Failure>,
    },
    /// A part is loose, and no contact carries force that could hold it.
    #[error("the run cannot go on from time {}: {}{error}", ShownTime(*time), all(loose))]
    Singular {
        /// The time that was reached.
        time: f64,
        /// What the linear solver says.
        error: SystemError,
        /// The parts that nothing holds; empty if a motion of other kind is free.
        loose: Vec<Loose>,
    },
    /// Nothing but friction holds a part, and there is no force that friction could come from.
    #[error(
        "the run cannot go on from time {}: {}contact acts on it with {force:.1e}, and equilibrium is known to {noise:.1e}, by newton.tolerance of the largest force and rounding: friction has nothing to come from",
        ShownTime(*time),
        all(loose)
    )]
    Unloaded {
        /// The time that was reached.
        time: f64,
        /// The parts that nothing else holds.
        loose: Vec<Loose>,
        /// The largest contact force on one of them, the root of the sum of squares over its nodes.
        force: f64,
        /// What counts as none: what Newton's iteration allows, `newton.tolerance` of the largest force of all, and rounding.
        noise: f64,
    },
    /// The solid was refused.
    #[error(transparent)]
    Solid(#[from] SolidError),
    /// A contact was refused.
    #[error(transparent)]
    Contact(#[from] ContactError),
    /// The equations were refused.
    #[error(transparent)]
    System(#[from] SystemError),
    /// A state of another problem.
    #[error("the state has {found} {what}; this problem has {expected}")]
    ForeignState {
        /// What was counted.
        what: &'static str,
        /// How many the state has.
        found: usize,
        /// How many the problem has.
        expected: usize,
    },
    /// A number in a state that no run has.
    #[error("the state has a {what} of {value}; it has to be {range}")]
    StateOutOfRange {
        /// What it is.
        what: &'static str,
        /// The number.
        value: f64,
        /// What is possible.
        range: &'static str,
    },
    /// Whoever was told of an increment failed.
    #[error(transparent)]
    Observer(Box<dyn std::error::Error + Send + Sync>),
}

/// A clause for each part, and what may help.
fn all(loose: &[Loose]) -> String {
    let parts: String = loose.iter().map(|loose| format!("{loose}; ")).collect();
    let help = "a `boundary` can hold it, a master closer than a facet's size, or, where no load acts along that, \
                `newton.stabilisation`; ";
    if parts.is_empty() { parts } else { parts + help }
}

/// A clause for each interface whose slaves left the master over its border.
fn over_border(left: &[(String, usize)]) -> String {
    let clause = |(interface, count): &(String, usize)| {
        format!(
            "; {count} slaves of interface `{}` carried force and are beyond the master's border now: a wider master or a larger \
             `border_tolerance` keeps them",
            shown(interface)
        )
    };
    left.iter().map(clause).collect()
}

/// Why one increment failed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Failure {
    /// Too many iterations.
    #[error(
        "the residual is {residual:.2e} of the forces after {iterations} iterations{}",
        over_border(left)
    )]
    Iterations {
        /// Relative residual.
        residual: f64,
        /// Iterations made.
        iterations: usize,
        /// Interfaces, and how many of their slaves carried force in the increment and lie beyond the master's border at its end.
        left: Vec<(String, usize)>,
    },
    /// The residual grew beyond reason or is no number.
    #[error("the residual grew to {residual:.2e} of the forces in iteration {iteration}")]
    Diverged {
        /// Relative residual.
        residual: f64,
        /// Number of the iteration.
        iteration: usize,
    },
    /// Two states lead to each other, and from the middle between them back again.
    #[error(
        "the iteration goes back and forth between two states; the residual is {residual:.2e} of the forces in iteration {iteration}{}",
        over_border(left)
    )]
    Cycle {
        /// Relative residual.
        residual: f64,
        /// Number of the iteration.
        iteration: usize,
        /// As of [`Iterations`](Self::Iterations).
        left: Vec<(String, usize)>,
    },
    /// An element was turned inside out, or has stresses that are not found or no numbers, however short the step.
    #[error("{0}")]
    Inverted(SolidError),
    /// Contact could not be evaluated where an iteration led to, such as beyond all bounds.
    #[error("{0}")]
    Contact(ContactError),
    /// There is equilibrium, but slaves went through their masters, or have elements without a result although they carried force in the
    /// increment or right before it.
    #[error(
        "interface `{interface}`, slave node {node} lost its contact: {loss}; {count} did so", interface = shown(interface)
    )]
    Lost {
        /// Interface of the first one.
        interface: String,
        /// Slave node of the first one.
        node: usize,
        /// How it was lost.
        loss: Loss,
        /// How many there are.
        count: usize,
    },
    /// The stiffness is singular.
    #[error("{}{error}", all(loose))]
    Singular {
        /// What the linear solver says.
        error: SystemError,
        /// The parts that nothing holds; empty if a motion of other kind is free.
        loose: Vec<Loose>,
    },
    /// A linear system was not solved iteratively, and is too large for factors.
    #[error(transparent)]
    Unsolved(SystemError),
    /// What a shorter increment does not mend.
    #[error(transparent)]
    Fatal(StaticsError),
}

impl From<ContactError> for Failure {
    fn from(error: ContactError) -> Self {
        Self::Fatal(error.into())
    }
}

impl Failure {
    /// A matrix that a shorter step may leave regular, or something else: with a shorter step there are as many equations, and their
    /// factors are as large.
    pub(super) fn of_system(error: SystemError, loose: Vec<Loose>) -> Self {
        match error {
            SystemError::TooLarge { .. } => Self::Fatal(error.into()),
            SystemError::NotConverged { .. } => Self::Unsolved(error),
            _ => Self::Singular { error, loose },
        }
    }

    /// Where nothing but the bodies themselves could hold a part that is loose, a shorter increment does not mend it.
    pub(super) fn without_contact(self, time: f64) -> Self {
        match self {
            Self::Singular { error, loose } if !loose.is_empty() => {
                Self::Fatal(StaticsError::Singular { time, error, loose })
            }
            other => other,
        }
    }

    /// An element that a shorter step may leave sound, or something else.
    pub(super) fn of_solid(error: SolidError) -> Self {
        match error {
            SolidError::Inverted { .. }
            | SolidError::UnstableModes { .. }
            | SolidError::Unresolved { .. }
            | SolidError::NotFinite { .. } => Self::Inverted(error),
            _ => Self::Fatal(error.into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_that_are_too_large_are_not_tried_again() {
        let too_large = SystemError::TooLarge { equations: 201_873 };
        assert!(
            matches!(Failure::of_system(too_large, Vec::new()), Failure::Fatal(StaticsError::System(error)) if error == too_large)
        );
        let singular = SystemError::Singular { equations: 3, residual: 1.0, condition: 1e20 };
        assert!(matches!(Failure::of_system(singular, Vec::new()), Failure::Singular { .. }));
    }
}
