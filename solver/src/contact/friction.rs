//! The friction of a pass: its law and what it remembers.

use std::sync::Arc;

use diffuse_contact::friction::{
    CoefficientValue, Coulomb, FrictionCoefficient, FrictionError, TabulatedCoefficient,
};
use serde::{Deserialize, Serialize};

use super::{Coefficient, ContactError, Friction, InteractionOptions};

/// What a pass with friction remembers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrictionHistory {
    /// [`history`](diffuse_contact::interface::ContactInterface::history) of the interface; empty before the first increment.
    pub anchors: Vec<f64>,
    /// The same that the last increment was solved with, rounds of augmentation included: from there slaves that slid slide on. Empty before
    /// there was one, and in what an earlier version wrote.
    #[serde(default)]
    pub anchors_before: Vec<f64>,
    /// How long the last increment lasted.
    #[serde(default)]
    pub lasted: f64,
    /// Work of friction so far, energy.
    pub dissipated: f64,
}

/// μ by the pressures of a pass.
#[derive(Clone, Debug)]
enum PassCoefficient {
    Constant(f64),
    Variable(Arc<dyn FrictionCoefficient>),
}

/// A table by the pressures of all passes together, of which one has a share.
#[derive(Clone, Debug)]
struct SharedTable {
    table: Arc<TabulatedCoefficient>,
    share: f64,
}

impl FrictionCoefficient for SharedTable {
    fn coefficient(&self, pressure: f64, rate: f64) -> CoefficientValue {
        let whole = self.table.coefficient(pressure / self.share, rate);
        CoefficientValue { by_pressure: whole.by_pressure / self.share, ..whole }
    }
}

/// The friction of a pass.
#[derive(Clone, Debug)]
pub struct PassFriction {
    coefficient: PassCoefficient,
    /// ε_T, over faces per area.
    stiffness: f64,
    shear_limit: Option<f64>,
    pub is_augmented: bool,
    /// How long the increment lasts.
    pub duration: f64,
    /// Whether the law is for the moment that of no friction.
    pub is_left_out: bool,
}

impl PassFriction {
    /// Of a pass with this penalty; none for a coefficient of 0.
    ///
    /// # Errors
    /// [`ContactError::Friction`], [`ContactError::SplitPressure`].
    pub fn new(options: &InteractionOptions, penalty: f64) -> Result<Option<Self>, ContactError> {
        let is_some = |friction: &&Friction| friction.coefficient != Coefficient::Constant(0.0);
        let Some(friction) = options.friction.as_ref().filter(is_some) else { return Ok(None) };
        // Two passes have half of the penalty each, and so of all pressures, of a stiffness and of a limit that were given.
        let share = penalty / options.penalty;
        let looks_at_pressure =
            friction.shear_limit.is_some() || matches!(friction.coefficient, Coefficient::Tabulated(_));
        if looks_at_pressure && share != 1.0 && options.augmentation.is_some() {
            return Err(ContactError::SplitPressure { interface: options.name.clone() });
        }
        let coefficient = match &friction.coefficient {
            &Coefficient::Constant(coefficient) => PassCoefficient::Constant(coefficient),
            &Coefficient::Decaying(law) => PassCoefficient::Variable(Arc::new(law)),
            Coefficient::Tabulated(table) => {
                PassCoefficient::Variable(Arc::new(SharedTable { table: Arc::clone(table), share }))
            }
        };
        let made = Self {
            coefficient,
            stiffness: friction.stiffness.map_or(penalty, |stiffness| share * stiffness),
            shear_limit: friction.shear_limit.map(|limit| share * limit),
            is_augmented: friction.augmentation.is_some(),
            duration: 1.0,
            is_left_out: false,
        };
        match made.checked() {
            Ok(_) => Ok(Some(made)),
            Err(source) => Err(ContactError::Friction { interface: options.name.clone(), source }),
        }
    }

    fn checked(&self) -> Result<Coulomb<'_>, FrictionError> {
        if self.is_left_out {
            return Coulomb::new(0.0, self.stiffness);
        }
        let law = match &self.coefficient {
            &PassCoefficient::Constant(coefficient) => Coulomb::new(coefficient, self.stiffness),
            PassCoefficient::Variable(law) => Coulomb::variable(law.as_ref(), self.duration, self.stiffness),
        }?;
        Ok(law.with_shear_limit(self.shear_limit)?.with_augmentation(self.is_augmented))
    }

    /// The law, which was checked when this was made.
    pub fn law(&self) -> Coulomb<'_> {
        self.checked().unwrap_or_else(|error| unreachable!("{error}"))
    }
}

#[cfg(test)]
mod tests {
    use diffuse_contact::friction::NormalForce;

    use super::super::Augmentation;
    use super::*;

    /// Two passes have half of the pressure each, and the coefficient of all of it.
    #[test]
    fn tables_are_read_at_the_pressure_of_all_passes() {
        let table = TabulatedCoefficient::new(&[0.0, 10.0], &[0.0], &[0.1, 0.3]).unwrap();
        let friction = Friction::new(Coefficient::Tabulated(Arc::new(table)));
        let options = InteractionOptions::new("blocks", 1000.0).with_friction(Some(friction));
        let sliding = |options: &InteractionOptions, share: f64, pressure: f64| {
            let pass = PassFriction::new(options, share * options.penalty).unwrap().unwrap();
            let (force, stiffness) = (share * pressure, share * options.penalty);
            let force = pass.law().force_since(NormalForce { force, stiffness }, 0.5, 0.0);
            // q = s²/2 with s = 1.
            [force.factor, force.factor_by_gap].map(|of_pass| of_pass / share)
        };
        let [whole, whole_by_gap] = sliding(&options, 1.0, 6.0);
        for (pressure, coefficient) in [(10.0, 0.3), (6.0, 0.22), (20.0, 0.3)] {
            let [half, half_by_gap] = sliding(&options.clone().with_two_pass(true), 0.5, pressure);
            assert!((half / (coefficient * pressure) - 1.0).abs() < 1e-12, "{half} {pressure}");
            if pressure == 6.0 {
                assert!(
                    (half / whole - 1.0).abs() < 1e-12 && (half_by_gap / whole_by_gap - 1.0).abs() < 1e-12
                );
            }
        }
    }

    #[test]
    fn multipliers_in_two_passes_leave_no_pressure_to_look_at() {
        let table = TabulatedCoefficient::new(&[0.0, 10.0], &[0.0], &[0.1, 0.3]).unwrap();
        let tabulated = Friction::new(Coefficient::Tabulated(Arc::new(table)));
        let constant = Friction::new(Coefficient::Constant(0.3));
        let limited = constant.clone().with_shear_limit(Some(2.0));
        let augmented =
            InteractionOptions::new("blocks", 1000.0).with_augmentation(Some(Augmentation::new(1e-3)));
        for (friction, looks_at_pressure) in [(tabulated, true), (limited, true), (constant, false)] {
            let options = augmented.clone().with_friction(Some(friction));
            assert!(PassFriction::new(&options, options.penalty).is_ok());
            assert!(
                PassFriction::new(&options.clone().with_augmentation(None), 0.5 * options.penalty).is_ok()
            );
            let halves = PassFriction::new(&options, 0.5 * options.penalty);
            assert_eq!(
                halves.is_err_and(|error| matches!(error, ContactError::SplitPressure { .. })),
                looks_at_pressure
            );
        }
    }
}
