//! When an increment had better be smaller.

use super::{ContactInterface, Contacts, InterfaceError, NoContact, Outcome};
use crate::{ElementError, Mode};

/// Nothing speaks against the increment.
const NONE: f64 = 1.0;
/// A foot lies outside the domain of influence: half the increment.
const HALF: f64 = 0.5;
/// An element has no result for another reason: a quarter.
const QUARTER: f64 = 0.25;
/// The least that is suggested.
const LEAST: f64 = 0.1;

/// A factor for the increment, and what asks for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutbackHint {
    /// From 0.1 to 1; below 1 the increment had better be cut back by it.
    pub factor: f64,
    /// The slave node that asks for it, and its outcome; of equal ones the first. `None` if the factor is 1.
    pub cause: Option<(usize, Outcome)>,
}

/// Remembers which slaves penetrated, so as to tell a contact that was torn from its surface by too large an increment from one that
/// has opened.
///
/// A slave *penetrated* if its gap was negative when it last had one since [`begin`](Self::begin): evaluations in which its element has
/// no result leave that as it is, so that a hint does not depend on how often it is asked for. Outcomes that are no failure of the
/// element, nor of the window (not paired, too far, no candidate, beyond the border) end it.
///
/// ```
/// # use diffuse_contact::Mode;
/// # use diffuse_contact::interface::{ContactInterface, Cutback, InterfaceError};
/// # fn iterate(interface: &mut ContactInterface, positions: &[[f64; 3]]) -> Result<f64, InterfaceError> {
/// let mut cutback = Cutback::new(interface.slaves().len());
/// // At the start of an increment, the first as well as one that is repeated:
/// interface.refresh_pairing(positions)?;
/// cutback.begin(interface)?;
/// // In each iteration:
/// interface.follow(positions)?;
/// cutback.book(interface.evaluate(Mode::Hessian)?);
/// let hint = cutback.hint(interface, 0.25);
/// # Ok(hint.factor)
/// # }
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cutback {
    penetrated: Vec<bool>,
}

impl Cutback {
    /// Of an interface with this number of slaves, none of which has penetrated.
    pub fn new(slaves: usize) -> Self {
        Self { penetrated: vec![false; slaves] }
    }

    /// To be called after a refresh at the accepted positions: which slaves penetrate there, whatever was booked before. An attempt that
    /// failed and a restart so leave no trace.
    ///
    /// # Errors
    /// As [`ContactInterface::for_each`], which evaluates the gaps.
    pub fn begin(&mut self, interface: &ContactInterface) -> Result<(), InterfaceError> {
        self.penetrated.fill(false);
        let mut next = self.penetrated.iter_mut();
        interface.for_each(Mode::Value, |contact| {
            next.next()
                .into_iter()
                .for_each(|penetrated| book(penetrated, &contact.outcome, contact.point.gap));
        })
    }

    /// Books an evaluation. To be called after each.
    pub fn book(&mut self, contacts: &Contacts) {
        for (penetrated, contact) in self.penetrated.iter_mut().zip(contacts.iter()) {
            book(penetrated, &contact.outcome, contact.point.gap);
        }
    }

    /// The hint to the evaluation that was booked last, the smallest of
    ///
    /// * `limit` R/(−g) for a slave deeper than `limit` × R, the support radius (node to facet: the extent of the facet);
    /// * 0.5 for a slave that penetrated and whose foot lies outside its domain of influence now;
    /// * 0.25 for one whose element has no result for another reason: no foot, singular fit, overflow;
    ///
    /// but not below 0.1. `limit` is positive.
    pub fn hint(&self, interface: &ContactInterface, limit: f64) -> CutbackHint {
        let mut hint = CutbackHint { factor: NONE, cause: None };
        for (k, (contact, &penetrated)) in interface.contacts().iter().zip(&self.penetrated).enumerate() {
            let radius = || interface.support_radius(k);
            let factor = factor(&contact.outcome, contact.point.gap, penetrated, radius, limit);
            if factor < hint.factor {
                hint = CutbackHint { factor, cause: Some((contact.slave, contact.outcome)) };
            }
        }
        hint
    }
}

fn book(penetrated: &mut bool, outcome: &Outcome, gap: f64) {
    match outcome {
        Outcome::Contact { .. } => *penetrated = gap < 0.0,
        Outcome::None(NoContact::Element { .. } | NoContact::BeyondWindow { .. }) => {}
        Outcome::None(_) => *penetrated = false,
    }
}

/// What one slave asks for.
fn factor(
    outcome: &Outcome,
    gap: f64,
    penetrated: bool,
    radius: impl FnOnce() -> Option<f64>,
    limit: f64,
) -> f64 {
    match outcome {
        Outcome::Contact { .. } if gap < 0.0 => {
            let factor = radius().map_or(NONE, |radius| limit * radius / -gap);
            // The quotient of a product that overflows is no number; it then asks for nothing.
            if factor < NONE { factor.max(LEAST) } else { NONE }
        }
        Outcome::None(NoContact::Element { error }) if penetrated => match error {
            ElementError::FootOutside { .. } => HALF,
            _ => QUARTER,
        },
        _ => NONE,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::neighbourhood::Fallback;

    #[test]
    fn deep_penetration_is_cut_in_proportion() {
        let contact = Outcome::Contact { fallback: Fallback::None };
        let asks = |gap| factor(&contact, gap, true, || Some(2.0), 0.25);
        assert_eq!([asks(-0.5), asks(-1.0), asks(-100.0), asks(100.0)], [1.0, 0.5, 0.1, 1.0]);
        assert_eq!(factor(&contact, -1.0, true, || None, 0.25), 1.0);
        assert_eq!(factor(&contact, -f64::MIN_POSITIVE, true, || Some(f64::MAX), f64::MAX), 1.0);
    }

    #[test]
    fn a_lost_foot_is_cut_if_the_slave_penetrated() {
        let without = |error: ElementError| Outcome::None(error.into());
        let outside = without(ElementError::FootOutside { distance: 1.5 });
        let diverged = without(ElementError::FootDiverged { residual: 1.0, iterations: 9 });
        let asks = |outcome, penetrated| factor(outcome, 0.0, penetrated, || Some(2.0), 0.25);
        assert_eq!([asks(&outside, true), asks(&diverged, true)], [0.5, 0.25]);
        assert_eq!([asks(&outside, false), asks(&diverged, false)], [1.0, 1.0]);
        assert_eq!(asks(&Outcome::None(NoContact::NotPaired), true), 1.0);
    }
}
