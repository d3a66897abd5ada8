//! Why a run or an increment ended early.

use diffuse_contact_mesh::names::{list, shown};
use thiserror::Error;

use super::{Loose, ShownTime};
use crate::contact::{ContactError, Loss};
use crate::solid::SolidError;
use crate::system::SystemError;

/// Why a run ended before the end of time.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum StaticsError {
    /// A setting out of its range, by its name in the deck.
    #[error("{name} is {value}; it has to be {range}")]
    Setting { name: &'static str, value: f64, range: &'static str },
    #[error(
        "newton.contact_tangent is an operator, which has no factors; newton.linear_solver has to be iterative or auto"
    )]
    NoFactors,
    #[error(
        "no convergence after time {}: {reason}; the increment of {length:.3e} may not be cut below {minimum:.3e}",
        ShownTime(*time)
    )]
    NoConvergence { time: f64, length: f64, minimum: f64, reason: Box<Failure> },
    /// A part is loose, and no contact carries force that could hold it. `loose` are the parts that nothing holds; it is empty if a motion
    /// of other kind is free.
    #[error("the run cannot go on from time {}: {}{error}", ShownTime(*time), all(loose))]
    Singular { time: f64, error: SystemError, loose: Vec<Loose> },
    /// Nothing but friction holds a part, and there is no force that friction could come from. `force` is the largest contact force on one
    /// of them, the root of the sum of squares over its nodes.
    #[error(
        "the run cannot go on from time {}: {}contact acts on it with {force:.1e}, and equilibrium is known to {noise:.1e}, by newton.tolerance of the largest force and rounding: friction has nothing to come from",
        ShownTime(*time),
        all(loose)
    )]
    Unloaded { time: f64, loose: Vec<Loose>, force: f64, noise: f64 },
    #[error(transparent)]
    Solid(#[from] SolidError),
    #[error(transparent)]
    Contact(#[from] ContactError),
    #[error(transparent)]
    System(#[from] SystemError),
    #[error("the state has {found} {what}; this problem has {expected}")]
    ForeignState { what: &'static str, found: usize, expected: usize },
    #[error("the state has a {what} of {value}; it has to be {range}")]
    StateOutOfRange { what: &'static str, value: f64, range: &'static str },
    /// Whoever was told of an increment failed.
    #[error(transparent)]
    Observer(Box<dyn std::error::Error + Send + Sync>),
}

/// Parts that a message names.
const MOST: usize = 5;

/// A clause for each part, and what may help.
fn all(loose: &[Loose]) -> String {
    let mut parts: String = loose.iter().take(MOST).map(|loose| format!("{loose}; ")).collect();
    if loose.len() > MOST {
        parts += &format!("nothing holds {} more parts; ", loose.len() - MOST);
    }
    let help = "a `boundary` can hold it, a master closer than a facet's size, or, where no load acts along that, \
                `newton.stabilisation`; ";
    if parts.is_empty() {
        return parts;
    }
    parts += help;
    let averaged = &loose[0].averaged;
    if !averaged.is_empty() {
        parts += &format!(
            "at {} the gaps that count are averages around nodes, and points of the faces are far nearer: there \
             integration = {{ over = \"faces\", pressures = \"points\" }} or a first increment that presses by more may hold it; ",
            list(averaged.iter().map(|name| format!("`{}`", shown(name))))
        );
    }
    parts
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

/// A clause where nothing but the stabilisation held a part.
const fn of_stabilisation(solutions: usize) -> &'static str {
    match solutions {
        0 => "",
        _ => "; a part was loose on the way, and the stabilisation that held it carries no load",
    }
}

/// Why one increment failed.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum Failure {
    /// Too many iterations. `left` are interfaces, and how many of their slaves carried force in the increment and lie beyond the master's
    /// border at its end; `stabilised` are linear solutions in which nothing but the stabilisation held a part.
    #[error(
        "the residual is {residual:.2e} of the forces after {iterations} iterations{}{}",
        of_stabilisation(*stabilised), over_border(left)
    )]
    Iterations { residual: f64, iterations: usize, stabilised: usize, left: Vec<(String, usize)> },
    /// The residual grew beyond reason or is no number.
    #[error("the residual grew to {residual:.2e} of the forces in iteration {iteration}")]
    Diverged { residual: f64, iteration: usize },
    /// Two states lead to each other, and from the middle between them back again. `left` is as of [`Iterations`](Self::Iterations).
    #[error(
        "the iteration goes back and forth between two states; the residual is {residual:.2e} of the forces in iteration {iteration}{}",
        over_border(left)
    )]
    Cycle { residual: f64, iteration: usize, left: Vec<(String, usize)> },
    /// An element was turned inside out, or has stresses that are not found or no numbers, however short the step.
    #[error("{0}")]
    Inverted(SolidError),
    /// Contact could not be evaluated where an iteration led to, such as beyond all bounds.
    #[error("{0}")]
    Contact(ContactError),
    /// There is equilibrium, but slaves went through their masters, or have elements without a result although they carried force in the
    /// increment or right before it. The first one is named.
    #[error(
        "interface `{interface}`, slave node {node} lost its contact: {loss}; {count} did so", interface = shown(interface)
    )]
    Lost { interface: String, node: usize, loss: Loss, count: usize },
    /// The stiffness is singular. `loose` are the parts that nothing holds; it is empty if a motion of other kind is free.
    #[error("{}{error}", all(loose))]
    Singular { error: SystemError, loose: Vec<Loose> },
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

    /// Whether the iteration may have failed since bodies came loose from stiff contact.
    pub(super) fn may_be_of_contact(&self) -> bool {
        matches!(
            self,
            Self::Iterations { .. }
                | Self::Diverged { .. }
                | Self::Cycle { .. }
                | Self::Inverted(_)
                | Self::Lost { .. }
                | Self::Singular { .. }
                | Self::Fatal(StaticsError::Singular { .. })
        )
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
