//! When an increment had better be smaller.

use runtime::ElementError;
use runtime::interface::{ContactRef, NoContact, Outcome};

use crate::status::{DC_BAD_OPTION, Failure};

/// Fractions of the support radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutbackOptions {
    /// Deepest penetration that is not too deep.
    pub penetration: f64,
    /// Deepest penetration at which a refresh may lose a contact.
    pub lost: f64,
}

impl Default for CutbackOptions {
    fn default() -> Self {
        Self { penetration: 0.25, lost: 0.01 }
    }
}

impl CutbackOptions {
    pub fn check(&self) -> Result<(), Failure> {
        for (name, value) in [("cutback_penetration", self.penetration), ("cutback_lost", self.lost)] {
            if !(value > 0.0 && value.is_finite()) {
                let message = format!("invalid-option: {name} must be positive and finite, not {value}");
                return Err(Failure::new(DC_BAD_OPTION, message));
            }
        }
        Ok(())
    }
}

/// Nothing speaks against the increment.
const NONE: f64 = 1.0;
/// A contact slid out of reach, or was lost: half the increment.
const HALF: f64 = 0.5;
/// A contact has no foot any more: a quarter.
const QUARTER: f64 = 0.25;
/// The least that is suggested.
const LEAST: f64 = 0.1;

/// What the evaluations and refreshes so far say about the increment.
#[derive(Clone, Debug)]
pub struct Cutback {
    options: CutbackOptions,
    /// Whether a slave penetrated when it last had a result.
    penetrates: Vec<bool>,
    /// Of the last refresh and of the last evaluation.
    refresh: f64,
    evaluation: f64,
}

impl Cutback {
    pub fn new(options: CutbackOptions, slaves: usize) -> Self {
        Self { options, penetrates: vec![false; slaves], refresh: NONE, evaluation: NONE }
    }

    /// Books a refresh: the deepest contact it lost, and the support radius that one had.
    pub fn refreshed(&mut self, lost: Option<(f64, f64)>) {
        let is_deep = |(gap, radius): (f64, f64)| -gap > self.options.lost * radius;
        self.refresh = if lost.is_some_and(is_deep) { HALF } else { NONE };
    }

    /// A new evaluation begins.
    pub fn start(&mut self) {
        self.evaluation = NONE;
    }

    /// Books the `k`-th slave of an evaluation.
    pub fn book(&mut self, k: usize, contact: &ContactRef<'_>, radius: Option<f64>) {
        let factor = match contact.outcome {
            Outcome::Contact { .. } => {
                let depth = -contact.point.gap / radius.unwrap_or(f64::INFINITY);
                self.penetrates[k] = depth > 0.0;
                if depth > self.options.penetration { self.options.penetration / depth } else { NONE }
            }
            Outcome::None(NoContact::Element { error }) if self.penetrates[k] => match error {
                ElementError::FootOutside { .. } => HALF,
                _ => QUARTER,
            },
            // It stays what it was until it has a result again.
            Outcome::None(NoContact::Element { .. }) => NONE,
            Outcome::None(_) => {
                self.penetrates[k] = false;
                NONE
            }
        };
        self.evaluation = self.evaluation.min(factor.max(LEAST));
    }

    /// The factor for the increment, from 0.1 to 1.
    pub fn factor(&self) -> f64 {
        self.refresh.min(self.evaluation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use runtime::ContactPoint;
    use runtime::neighbourhood::Fallback;

    fn contact(gap: f64) -> ContactRef<'static> {
        ContactRef {
            slave: 0,
            nodes: &[],
            outcome: Outcome::Contact { fallback: Fallback::None },
            point: ContactPoint { gap, ..ContactPoint::default() },
            area: 1.0,
            gradient: &[],
            hessian: &[],
        }
    }

    fn without(reason: NoContact) -> ContactRef<'static> {
        ContactRef { outcome: Outcome::None(reason), ..contact(0.0) }
    }

    fn evaluated(cutback: &mut Cutback, contact: &ContactRef<'_>) -> f64 {
        cutback.start();
        cutback.book(0, contact, Some(2.0));
        cutback.factor()
    }

    #[test]
    fn deep_penetration_is_cut_in_proportion() {
        let mut cutback = Cutback::new(CutbackOptions::default(), 1);
        assert_eq!(evaluated(&mut cutback, &contact(-0.5)), 1.0);
        assert_eq!(evaluated(&mut cutback, &contact(-1.0)), 0.5);
        assert_eq!(evaluated(&mut cutback, &contact(-100.0)), 0.1);
        assert_eq!(evaluated(&mut cutback, &contact(100.0)), 1.0);
    }

    #[test]
    fn a_contact_without_foot_is_cut_until_it_has_one_again() {
        let mut cutback = Cutback::new(CutbackOptions::default(), 1);
        let diverged = without(ElementError::FootDiverged { residual: 1.0, iterations: 9 }.into());
        let outside = without(ElementError::FootOutside { distance: 1.5 }.into());
        assert_eq!(evaluated(&mut cutback, &diverged), 1.0, "it has not penetrated");
        evaluated(&mut cutback, &contact(-0.1));
        assert_eq!(evaluated(&mut cutback, &outside), 0.5);
        assert_eq!(evaluated(&mut cutback, &diverged), 0.25);
        assert_eq!(evaluated(&mut cutback, &diverged), 0.25);
        evaluated(&mut cutback, &without(NoContact::NotPaired));
        assert_eq!(evaluated(&mut cutback, &diverged), 1.0);
    }

    #[test]
    fn a_refresh_that_loses_a_deep_contact_is_cut() {
        let mut cutback = Cutback::new(CutbackOptions::default(), 1);
        cutback.refreshed(Some((-0.1, 2.0)));
        assert_eq!(cutback.factor(), 0.5);
        cutback.refreshed(Some((-0.01, 2.0)));
        assert_eq!(cutback.factor(), 1.0);
        cutback.refreshed(Some((0.3, 2.0)));
        assert_eq!(cutback.factor(), 1.0);
        cutback.refreshed(None);
        assert_eq!(cutback.factor(), 1.0);
    }
}
