//! Coefficients of friction that depend on the pressure and on how fast a contact slides.

use std::fmt;

use diffuse_contact_kernels::decaying_coefficient;

use super::FrictionError;
use crate::Mode;
use crate::assembly::Table;

/// A coefficient of friction μ of the pressure and the slip rate, such as one of the user's own.
///
/// It is asked from many threads at once, and has to answer the same each time. A coefficient that is negative or not finite, or has a
/// derivative that is not finite, ends the assembly with
/// [`AssemblyError::InvalidCoefficient`](crate::assembly::AssemblyError::InvalidCoefficient).
pub trait FrictionCoefficient: fmt::Debug + Send + Sync {
    /// μ and its derivatives at the pressure p > 0 (force per area; over nodes without areas the force) and the slip rate v ≥ 0, length
    /// per time. Sticking contacts are asked for v = 0: there it is the coefficient of rest.
    fn coefficient(&self, pressure: f64, rate: f64) -> CoefficientValue;
}

/// A coefficient of friction with its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoefficientValue {
    /// μ ≥ 0.
    pub value: f64,
    /// ∂μ/∂p.
    pub by_pressure: f64,
    /// ∂μ/∂v.
    pub by_rate: f64,
}

impl CoefficientValue {
    /// The same, or what is no number in all places.
    pub(super) fn or_nan(self) -> Self {
        let Self { value, by_pressure, by_rate } = self;
        let is_sound = value >= 0.0 && [value, by_pressure, by_rate].iter().all(|x| x.is_finite());
        if is_sound { self } else { Self { value: f64::NAN, by_pressure: f64::NAN, by_rate: f64::NAN } }
    }
}

/// A coefficient that decays from rest to fast sliding, μ = μ_k + (μ_s − μ_k) exp(−β v).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecayingCoefficient {
    at_rest: f64,
    in_motion: f64,
    decay: f64,
}

impl DecayingCoefficient {
    /// μ_s ≥ 0 of rest, μ_k ≥ 0 of fast sliding, and β ≥ 0, time per length.
    ///
    /// # Errors
    /// [`FrictionError::InvalidCoefficient`] for coefficients, [`FrictionError::InvalidDecay`].
    pub fn new(at_rest: f64, in_motion: f64, decay: f64) -> Result<Self, FrictionError> {
        for value in [at_rest, in_motion] {
            super::check_coefficient(value)?;
        }
        if !(decay >= 0.0 && decay.is_finite()) {
            return Err(FrictionError::InvalidDecay { value: decay });
        }
        Ok(Self { at_rest, in_motion, decay })
    }
}

impl FrictionCoefficient for DecayingCoefficient {
    fn coefficient(&self, _pressure: f64, rate: f64) -> CoefficientValue {
        let Self { at_rest, in_motion, decay } = *self;
        let inputs = decaying_coefficient::Inputs { rate, at_rest, in_motion, decay };
        let results = decaying_coefficient::evaluate(Mode::Gradient, &inputs);
        let [by_rate] = results.coefficient_jacobian;
        CoefficientValue { value: results.values.coefficient, by_pressure: 0.0, by_rate }
    }
}

/// A coefficient by a table: linear between its pressures and slip rates, constant beyond them.
#[derive(Clone, Debug, PartialEq)]
pub struct TabulatedCoefficient(Table);

impl TabulatedCoefficient {
    /// The coefficients at ascending pressures and slip rates, of which either may be one number only: then μ does not depend on it.
    /// `coefficients` has one entry for each rate at the first pressure, then for each at the next one.
    ///
    /// # Errors
    /// [`FrictionError::InvalidTable`] with the place of the first entry that is not finite or does not ascend, in pressures, rates and
    /// coefficients one after another, or of the first that is missing or too many; [`FrictionError::InvalidCoefficient`].
    pub fn new(pressures: &[f64], rates: &[f64], coefficients: &[f64]) -> Result<Self, FrictionError> {
        let table = Table::new(pressures, rates, coefficients)
            .map_err(|place| FrictionError::InvalidTable { place })?;
        coefficients.iter().try_for_each(|&value| super::check_coefficient(value))?;
        Ok(Self(table))
    }
}

impl FrictionCoefficient for TabulatedCoefficient {
    fn coefficient(&self, pressure: f64, rate: f64) -> CoefficientValue {
        let (value, [by_pressure, by_rate]) = self.0.value(pressure, rate);
        CoefficientValue { value, by_pressure, by_rate }
    }
}

/// The coefficient of a contact that slides, and its rate.
#[derive(Clone, Copy, Debug)]
pub(super) struct AtRate {
    pub coefficient: CoefficientValue,
    pub rate: f64,
}

/// What the search for the slip rate needs to know: F(v) = ε_T (w s − v w Δt) − min(μ(p, v) p, τ), positive for v = 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct SlipRate {
    /// w s, length.
    pub slip: f64,
    /// p, force.
    pub pressure: f64,
    /// ε_T, force per length.
    pub stiffness: f64,
    /// τ, force.
    pub limit: f64,
    /// w Δt
    pub in_touch: f64,
}

impl SlipRate {
    const ITERATIONS: usize = 200;
    /// What rounding makes of F, over ε_T w s.
    const ROUNDING: f64 = 8.0 * f64::EPSILON;

    /// The rate at which the elastic slip has the traction that the coefficient allows: a root of F between 0 and s/Δt, by Newton's
    /// iteration within the bracket. A coefficient that is no number ends it with one.
    pub fn find(&self, coefficient: impl Fn(f64) -> CoefficientValue) -> AtRate {
        let Self { slip, pressure, stiffness, limit, in_touch } = *self;
        let (mut low, mut high) = (0.0, slip / in_touch);
        // What slides if the coefficient of rest remains.
        let mut rate = (slip - (coefficient(0.0).value * pressure).min(limit) / stiffness) / in_touch;
        for _ in 0..Self::ITERATIONS {
            let at = coefficient(rate);
            let strength = at.value * pressure;
            let excess = stiffness * (slip - rate * in_touch) - strength.min(limit);
            let is_done =
                excess.abs() <= Self::ROUNDING * stiffness * slip || high - low <= f64::EPSILON * high;
            if is_done || !excess.is_finite() {
                return AtRate { coefficient: at, rate };
            }
            if excess > 0.0 {
                low = rate
            } else {
                high = rate
            }
            let by_rate = if strength < limit { at.by_rate * pressure } else { 0.0 };
            let next = rate + excess / (stiffness * in_touch + by_rate);
            rate = if next > low && next < high { next } else { 0.5 * (low + high) };
        }
        AtRate { coefficient: coefficient(rate), rate }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::{Coulomb, FrictionState, NormalForce};

    const NORMAL: NormalForce = NormalForce { force: 10.0, stiffness: 400.0 };

    fn table() -> TabulatedCoefficient {
        TabulatedCoefficient::new(&[0.0, 20.0], &[0.0, 1.0, 3.0], &[0.5, 0.4, 0.2, 0.3, 0.2, 0.1]).unwrap()
    }

    #[test]
    fn coefficients_are_those_of_their_laws() {
        let decaying = DecayingCoefficient::new(0.5, 0.2, 2.0).unwrap();
        for rate in [0.0, 0.3, 40.0] {
            let at = decaying.coefficient(3.0, rate);
            let expected = 0.3 * (-2.0 * rate).exp();
            assert!((at.value - 0.2 - expected).abs() < 1e-16 && (at.by_rate + 2.0 * expected).abs() < 1e-15);
            assert_eq!(at.by_pressure, 0.0);
        }
        let table = table();
        for (pressure, rate, value, by_pressure, by_rate) in
            [(10.0, 2.0, 0.225, -0.0075, -0.075), (30.0, 2.0, 0.15, 0.0, -0.05), (0.0, 5.0, 0.2, -0.005, 0.0)]
        {
            let at = table.coefficient(pressure, rate);
            let expected = [value, by_pressure, by_rate];
            for (found, expected) in [at.value, at.by_pressure, at.by_rate].into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-15, "{at:?} {pressure} {rate}");
            }
        }
        let of_pressure = TabulatedCoefficient::new(&[1.0, 2.0], &[0.0], &[0.3, 0.1]).unwrap();
        assert!((of_pressure.coefficient(1.5, 7.0).value - 0.2).abs() < 1e-16);
    }

    /// The traction is μ(p, v) p with the rate of what slides, and its derivatives are its differences.
    #[test]
    fn sliding_contacts_have_the_coefficient_of_their_rate() {
        let decaying = DecayingCoefficient::new(0.5, 0.2, 2.0).unwrap();
        let table = table();
        let laws: [&dyn FrictionCoefficient; 2] = [&decaying, &table];
        for coefficient in laws {
            let law = Coulomb::variable(coefficient, 0.25, 100.0).unwrap();
            for (slip, opening) in [(0.04, 0.0), (0.3, 0.0), (0.3, 5.0)] {
                let at = |force: f64, q: f64| law.force_since(NormalForce { force, ..NORMAL }, q, opening);
                let q = 0.5 * slip * slip;
                let force = at(10.0, q);
                let traction = force.factor * slip;
                if slip == 0.04 {
                    assert_eq!((force.state, force.kept), (FrictionState::Stick, 1.0));
                    assert!((traction - 4.0).abs() < 1e-14);
                    continue;
                }
                assert_eq!(force.state, FrictionState::Slip);
                let rate = (force.share * slip - traction / 100.0) / (0.25 * force.share);
                let expected = 10.0 * coefficient.coefficient(10.0, rate).value;
                assert!((traction - expected).abs() < 1e-13, "{traction} {expected}");
                let h = 1e-6;
                let by_q = (at(10.0, q + h).factor - at(10.0, q - h).factor) / (2.0 * h);
                let by_gap = (at(10.0 - 400.0 * h, q).factor - at(10.0 + 400.0 * h, q).factor) / (2.0 * h);
                assert!((force.factor_by_half_square / by_q - 1.0).abs() < 1e-7);
                assert!(
                    (force.factor_by_gap / by_gap - 1.0).abs() < 1e-6,
                    "{} {by_gap}",
                    force.factor_by_gap
                );
            }
            // Pressures are forces over areas.
            let one = law.force_since(NORMAL, 0.02, 0.0);
            let normal = NormalForce { force: 30.0, stiffness: 1200.0 };
            let three = law.over(3.0).force_since(normal, 0.02, 0.0);
            assert!((three.factor / one.factor - 3.0).abs() < 1e-13);
            // A shear limit below.
            let limited = law.with_shear_limit(Some(1.0)).unwrap().force_since(NORMAL, 0.02, 0.0);
            assert!((limited.factor * 0.2 - 1.0).abs() < 1e-14 && limited.factor_by_gap == 0.0);
        }
    }

    #[test]
    fn coefficients_that_are_none_are_refused() {
        for (at_rest, in_motion, decay, code) in [
            (-0.1, 0.2, 1.0, "invalid-friction-coefficient"),
            (0.1, f64::NAN, 1.0, "invalid-friction-coefficient"),
            (0.1, 0.2, -1.0, "invalid-decay"),
        ] {
            assert_eq!(DecayingCoefficient::new(at_rest, in_motion, decay).unwrap_err().code(), code);
        }
        for (pressures, rates, values, place) in [
            (&[1.0, 1.0][..], &[0.0][..], &[0.1, 0.1][..], 1),
            (&[1.0], &[0.0, f64::INFINITY], &[0.1, 0.1], 2),
            (&[1.0, 2.0], &[0.0], &[0.1], 4),
            (&[], &[0.0], &[], 0),
        ] {
            let refused = TabulatedCoefficient::new(pressures, rates, values);
            assert_eq!(refused, Err(FrictionError::InvalidTable { place }));
        }
        let negative = TabulatedCoefficient::new(&[1.0], &[0.0], &[-0.1]).unwrap_err();
        assert_eq!(negative.code(), "invalid-friction-coefficient");
    }
}
