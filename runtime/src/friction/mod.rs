//! Coulomb friction with an exact tangent, after docs/equations.md, T16.
//!
//! The slip of a contact is measured from its *anchor*, a material point of the master that the slave stuck to. The potential
//! of a stuck contact is ε_T q with q = ½ |P_ν d|², half the square of the slip; that of a sliding one has the magnitude μ p of its
//! traction instead. Both are one force −c ∇q with a factor c of q and of the gap:
//!
//! ```text
//! stick, w ε_T s ≤ μ p:   c = w ε_T
//! slip:                   c = μ p / s,   s = √(2q)
//! ```
//!
//! A law with a shear limit slides at min(μ p, τ) instead of μ p: metals yield below the surface before high pressures make it stick.
//! μ may be a [`FrictionCoefficient`] of pressure and slip rate. The rate is that of what slides, v = (w s − c s/ε_T)/(w Δt) with w as
//! below: the traction is the root of an equation, and its derivatives are those of the root.
//!
//! w is the part of the slip since the place of touch: 1 for a contact that was closed when the last step was accepted. One that
//! was open by g₀ has slid from its foot of then to its foot of now while the gap went from g₀ to the present one. It touched at
//! 1 − w of the way, and of the time: w = p/(p + ε g₀). Friction begins with the pressure, without a jump.
//!
//! q does not change under rigid motions of slave, masters and anchor together: the forces balance, and so do their moments.

mod coefficient;
mod error;
mod force;

use std::cell::Cell;

use diffuse_contact_kernels::{coulomb, coulomb_sliding, traction, traction_sliding};

pub use coefficient::{CoefficientValue, DecayingCoefficient, FrictionCoefficient, TabulatedCoefficient};
pub use error::FrictionError;
pub use force::{BeforeStep, FrictionForce, FrictionState, NormalForce};
pub(crate) use force::{FaceTraction, Sliding};

use coefficient::{AtRate, SlipRate};

use crate::vector::Vector3;
use crate::{Mode, Point};

/// Coulomb's law with a penalty for stick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coulomb<'a> {
    coefficient: Coefficient<'a>,
    stiffness: f64,
    /// τ; the largest number for none.
    shear_limit: f64,
    is_augmented: bool,
}

/// μ
#[derive(Clone, Copy, Debug)]
enum Coefficient<'a> {
    Constant(f64),
    Variable {
        law: &'a dyn FrictionCoefficient,
        /// Δt
        duration: f64,
        /// What forces are divided by to be pressures.
        area: f64,
    },
}

impl PartialEq for Coefficient<'_> {
    /// Two laws are the same if they are one in memory.
    fn eq(&self, other: &Self) -> bool {
        match (*self, *other) {
            (Self::Constant(one), Self::Constant(other)) => one == other,
            (
                Self::Variable { law, duration, area },
                Self::Variable { law: other, duration: other_duration, area: other_area },
            ) => std::ptr::addr_eq(law, other) && (duration, area) == (other_duration, other_area),
            _ => false,
        }
    }
}

/// Whether it is one.
fn check_coefficient(value: f64) -> Result<(), FrictionError> {
    let is_sound = value >= 0.0 && value.is_finite();
    if is_sound { Ok(()) } else { Err(FrictionError::InvalidCoefficient { value }) }
}

fn check_stiffness(value: f64) -> Result<(), FrictionError> {
    let is_sound = value > 0.0 && value.is_finite();
    if is_sound { Ok(()) } else { Err(FrictionError::InvalidStiffness { value }) }
}

impl<'a> Coulomb<'a> {
    /// The law with the coefficient of friction μ ≥ 0 and the tangential stiffness ε_T > 0, force per length.
    pub fn new(coefficient: f64, stiffness: f64) -> Result<Self, FrictionError> {
        check_coefficient(coefficient)?;
        check_stiffness(stiffness)?;
        Ok(Self {
            coefficient: Coefficient::Constant(coefficient),
            stiffness,
            shear_limit: f64::MAX,
            is_augmented: false,
        })
    }

    /// The law with a coefficient of pressure and slip rate in a step that lasts `duration` > 0, and the tangential stiffness ε_T > 0.
    ///
    /// The slip rate of a contact that closes in the step is over the part of the duration since its place of touch; after a round of
    /// augmentation over the whole of it.
    ///
    /// Where μ falls with the rate so fast that p |∂μ/∂v| > ε_T `duration`, the elastic slip snaps: a contact that begins to slide
    /// then loses traction at once.
    ///
    /// # Errors
    /// [`FrictionError::InvalidDuration`], [`FrictionError::InvalidStiffness`].
    pub fn variable(
        coefficient: &'a dyn FrictionCoefficient,
        duration: f64,
        stiffness: f64,
    ) -> Result<Self, FrictionError> {
        if !(duration > 0.0 && duration.is_finite()) {
            return Err(FrictionError::InvalidDuration { value: duration });
        }
        check_stiffness(stiffness)?;
        let coefficient = Coefficient::Variable { law: coefficient, duration, area: 1.0 };
        Ok(Self { coefficient, stiffness, shear_limit: f64::MAX, is_augmented: false })
    }

    /// The law with a traction τ > 0 that no contact exceeds, in the unit of the pressure: contacts slide at min(μ p, τ). `None`: without.
    ///
    /// # Errors
    /// [`FrictionError::InvalidShearLimit`].
    pub fn with_shear_limit(self, limit: Option<f64>) -> Result<Self, FrictionError> {
        let shear_limit = limit.unwrap_or(f64::MAX);
        if shear_limit > 0.0 && shear_limit.is_finite() {
            Ok(Self { shear_limit, ..self })
        } else {
            Err(FrictionError::InvalidShearLimit { value: shear_limit })
        }
    }

    /// Whether the history notes where contacts really stuck, so that [`augment`](crate::ContactInterface::augment) can take away what
    /// they creep by ε_T, or not. Tractions are the same.
    #[must_use]
    pub const fn with_augmentation(self, is_augmented: bool) -> Self {
        Self { is_augmented, ..self }
    }

    /// Whether contacts may be augmented.
    pub const fn is_augmented(&self) -> bool {
        self.is_augmented
    }

    /// Whether μ is 0 whatever the contact does.
    pub fn is_none(&self) -> bool {
        matches!(self.coefficient, Coefficient::Constant(0.0))
    }

    /// ε_T, force per length.
    pub const fn stiffness(&self) -> f64 {
        self.stiffness
    }

    /// τ, if there is a limit.
    pub fn shear_limit(&self) -> Option<f64> {
        Some(self.shear_limit).filter(|limit| *limit < f64::MAX)
    }

    /// The law of a slave with this tributary area, whose stiffness and shear limit are per area.
    #[must_use]
    pub fn over(&self, area: f64) -> Self {
        let limit = self.shear_limit().map_or(f64::MAX, |limit| limit * area);
        let coefficient = match self.coefficient {
            Coefficient::Variable { law, duration, area: before } => {
                Coefficient::Variable { law, duration, area: area * before }
            }
            constant @ Coefficient::Constant(_) => constant,
        };
        Self { coefficient, stiffness: self.stiffness * area, shear_limit: limit, ..*self }
    }

    /// μ of a contact that sticks, with this normal force.
    fn coefficient_of_rest(&self, pressure: f64) -> f64 {
        match self.coefficient {
            Coefficient::Constant(coefficient) => coefficient,
            Coefficient::Variable { law, area, .. } => law.coefficient(pressure / area, 0.0).or_nan().value,
        }
    }

    /// The largest friction that a contact at rest bears with this normal force, min(μ p, τ A); 0 where there is none.
    pub(crate) fn limit(&self, normal_force: f64) -> f64 {
        if !(normal_force > 0.0) {
            return 0.0;
        }
        let limit = self.coefficient_of_rest(normal_force) * normal_force;
        if limit.is_finite() { limit.min(self.shear_limit) } else { 0.0 }
    }

    /// μ, with derivatives by the normal force, and the rate of a contact that has slid by w s in w Δt; `None` for a constant coefficient.
    fn sliding_coefficient(&self, pressure: f64, slip: f64, share: f64) -> Option<(AtRate, f64)> {
        let Coefficient::Variable { law, duration, area } = self.coefficient else { return None };
        let (stiffness, limit) = (self.stiffness, self.shear_limit);
        let in_touch = share * duration;
        let found = SlipRate { slip: share * slip, pressure, stiffness, limit, in_touch }.find(|rate| {
            let by_area = law.coefficient(pressure / area, rate).or_nan();
            CoefficientValue { by_pressure: by_area.by_pressure / area, ..by_area }
        });
        Some((found, duration))
    }

    /// The pressure, the rate and what the law gave there that is no coefficient, if that is why a friction is none. Arguments are those of
    /// the contact's normal force, its slip, and the part of it since the place of touch.
    pub(crate) fn unsound_coefficient(
        &self,
        pressure: f64,
        slip: f64,
        share: f64,
    ) -> Option<([f64; 2], CoefficientValue)> {
        let Coefficient::Variable { law, duration, area } = self.coefficient else { return None };
        let found = Cell::new(None);
        let ask = |rate: f64| {
            let value = law.coefficient(pressure / area, rate);
            let by_area = value.or_nan();
            if by_area.value.is_nan() && rate.is_finite() && found.get().is_none() {
                found.set(Some(([pressure / area, rate], value)));
            }
            CoefficientValue { by_pressure: by_area.by_pressure / area, ..by_area }
        };
        if !ask(0.0).value.is_nan() {
            let (stiffness, limit, in_touch) = (self.stiffness, self.shear_limit, share * duration);
            SlipRate { slip: share * slip, pressure, stiffness, limit, in_touch }.find(ask);
        }
        found.get()
    }

    /// t_A and its derivatives over faces, for a way and a normal of any length (docs/equations.md, section 18), and what becomes of
    /// the slip.
    pub(crate) fn traction(
        &self,
        (way, normal): (Point, Point),
        pressure: f64,
        opening: f64,
    ) -> FaceTraction {
        let Self { stiffness, shear_limit, .. } = *self;
        let at = |coefficient: f64| {
            let inputs =
                traction::Inputs { way, normal, pressure, coefficient, stiffness, opening, shear_limit };
            traction::evaluate(Mode::Gradient, &inputs)
        };
        let made = |results: &traction::Results| {
            let traction::Values { slip, traction, factor, share, slides } = results.values;
            let sliding = self.sliding(factor, share, slides);
            FaceTraction { slip, traction, jacobian: results.traction_jacobian, sliding }
        };
        let coefficient = self.coefficient_of_rest(pressure);
        let mut at_rest = made(&at(coefficient));
        if coefficient.is_nan() {
            at_rest.traction = [f64::NAN; 3];
        }
        let FaceTraction { slip, sliding, .. } = at_rest;
        if sliding.state == FrictionState::Stick {
            return at_rest;
        }
        let found = self.sliding_coefficient(pressure, Vector3::from(slip).norm(), sliding.share);
        let Some((AtRate { coefficient: found, rate }, duration)) = found else { return at_rest };
        if found.value * pressure >= shear_limit {
            return made(&at(found.value));
        }
        let results = traction_sliding::evaluate(
            Mode::Gradient,
            &traction_sliding::Inputs {
                way,
                normal,
                pressure,
                coefficient: found.value,
                coefficient_by_pressure: found.by_pressure,
                coefficient_by_rate: found.by_rate,
                at_pressure: pressure,
                at_rate: rate,
                stiffness,
                opening,
                duration,
            },
        );
        let sliding = self.sliding(results.values.factor, sliding.share, 1.0);
        FaceTraction { slip, traction: results.values.traction, jacobian: results.traction_jacobian, sliding }
    }

    fn sliding(&self, factor: f64, share: f64, slides: f64) -> Sliding {
        let (state, kept) = if slides > 0.0 {
            (FrictionState::Slip, factor / self.stiffness)
        } else {
            (FrictionState::Stick, share)
        };
        Sliding { state, factor, share, kept }
    }

    /// The friction of a contact with this normal force and this half square q ≥ 0 of the slip. Without normal force, or with μ = 0,
    /// there is none.
    pub fn force(&self, normal: NormalForce, half_square: f64) -> FrictionForce {
        self.force_since(normal, half_square, 0.0)
    }

    /// The same of a contact that was open when the last step was accepted, and had its anchor in its foot. `opening` ≥ 0 is the
    /// force that the gap of then would make, ε g₀.
    pub fn force_since(&self, normal: NormalForce, half_square: f64, opening: f64) -> FrictionForce {
        if !(normal.force > 0.0) {
            return FrictionForce::NONE;
        }
        let Self { stiffness, shear_limit, .. } = *self;
        let pressure = normal.force;
        let at_rest = self.coefficient_of_rest(pressure);
        if matches!(self.coefficient, Coefficient::Constant(_)) && at_rest * pressure == 0.0 {
            return FrictionForce { state: FrictionState::Slip, kept: 0.0, ..FrictionForce::NONE };
        }
        if at_rest.is_nan() {
            return FrictionForce { factor: f64::NAN, ..FrictionForce::NONE };
        }
        let at = |coefficient: f64| {
            let inputs =
                coulomb::Inputs { half_square, pressure, coefficient, stiffness, opening, shear_limit };
            coulomb::evaluate(Mode::Gradient, &inputs)
        };
        let mut results = at(at_rest);
        let coulomb::Values { share, slides, .. } = results.values;
        if slides > 0.0
            && let Some((AtRate { coefficient: found, rate }, duration)) =
                self.sliding_coefficient(pressure, (2.0 * half_square).sqrt(), share)
        {
            if found.value * pressure >= shear_limit {
                results = at(found.value);
            } else {
                let sliding = coulomb_sliding::evaluate(
                    Mode::Gradient,
                    &coulomb_sliding::Inputs {
                        half_square,
                        pressure,
                        coefficient: found.value,
                        coefficient_by_pressure: found.by_pressure,
                        coefficient_by_rate: found.by_rate,
                        at_pressure: pressure,
                        at_rate: rate,
                        stiffness,
                        opening,
                        duration,
                    },
                );
                results.values.factor = sliding.values.factor;
                results.factor_jacobian = sliding.factor_jacobian;
            }
        }
        let [by_half_square, by_pressure] = results.factor_jacobian;
        let factor = results.values.factor;
        let Sliding { state, kept, .. } = self.sliding(factor, share, slides);
        FrictionForce {
            state,
            factor,
            factor_by_half_square: by_half_square,
            factor_by_gap: -normal.stiffness * by_pressure,
            share,
            kept,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NORMAL: NormalForce = NormalForce { force: 10.0, stiffness: 400.0 };

    #[test]
    fn the_traction_grows_with_the_slip_up_to_its_limit() {
        let law = Coulomb::new(0.3, 100.0).unwrap();
        for (slip, state, traction) in [
            (0.0, FrictionState::Stick, 0.0),
            (0.02, FrictionState::Stick, 2.0),
            (0.03, FrictionState::Stick, 3.0),
            (0.04, FrictionState::Slip, 3.0),
            (5.0, FrictionState::Slip, 3.0),
        ] {
            let force = law.force(NORMAL, 0.5 * slip * slip);
            assert_eq!(force.state, state, "{slip}");
            assert!((force.factor * slip - traction).abs() < 1e-14, "{slip}");
            // An accepted step leaves a slip whose traction is the same.
            assert!((law.stiffness() * force.kept * slip - traction).abs() < 1e-14, "{slip}");
        }
    }

    #[test]
    fn a_shear_limit_is_no_function_of_the_pressure() {
        let law = Coulomb::new(0.3, 100.0).unwrap().with_shear_limit(Some(2.0)).unwrap();
        assert_eq!((law.shear_limit(), law.over(3.0).shear_limit()), (Some(2.0), Some(6.0)));
        let at = |pressure: f64, slip: f64| {
            law.force(NormalForce { force: pressure, ..NORMAL }, 0.5 * slip * slip)
        };
        for (pressure, slip, traction) in
            [(5.0, 0.1, 1.5), (10.0, 0.1, 2.0), (1e6, 0.1, 2.0), (1e6, 0.01, 1.0)]
        {
            assert!((at(pressure, slip).factor * slip - traction).abs() < 1e-14, "{pressure}");
        }
        assert_eq!(at(10.0, 0.1).factor_by_gap, 0.0);
        assert!(at(5.0, 0.1).factor_by_gap < 0.0);
        assert_eq!(Coulomb::new(0.3, 100.0).unwrap().over(2.0).shear_limit(), None);
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let refused = law.with_shear_limit(Some(value)).unwrap_err();
            assert_eq!(refused.code(), "invalid-shear-limit");
        }
    }

    #[test]
    fn the_factors_derivatives_are_its_differences() {
        let law = Coulomb::new(0.3, 100.0).unwrap();
        let (q, h) = (0.5 * 0.3 * 0.3, 1e-6);
        // In slip; in stick of a contact that was open.
        for (q, opening) in [(q, 0.0), (0.01 * q, 0.05)] {
            let at = |gap: f64, q: f64| {
                let normal = NormalForce { force: NORMAL.force - NORMAL.stiffness * gap, ..NORMAL };
                law.force_since(normal, q, NORMAL.stiffness * opening)
            };
            let force = at(0.0, q);
            let by_q = (at(0.0, q + h).factor - at(0.0, q - h).factor) / (2.0 * h);
            let by_gap = (at(h, q).factor - at(-h, q).factor) / (2.0 * h);
            assert!((force.factor_by_half_square - by_q).abs() <= 1e-7 * by_q.abs());
            assert!((force.factor_by_gap / by_gap - 1.0).abs() < 1e-7);
        }
    }

    #[test]
    fn a_contact_that_sticks_keeps_all_of_its_slip() {
        for k in 1..10_000 {
            let pressure = 0.37 * f64::from(k).sqrt();
            let law = Coulomb::new(0.3, 100.0 + 0.1 * f64::from(k)).unwrap();
            let force = law.force(NormalForce { force: pressure, stiffness: 400.0 }, 1e-30);
            assert_eq!((force.state, force.share, force.kept), (FrictionState::Stick, 1.0, 1.0), "{k}");
            assert_eq!(
                (force.factor, force.dissipated(1e-15, BeforeStep::Stuck(pressure))),
                (law.stiffness(), 0.0)
            );
        }
    }

    #[test]
    fn a_contact_that_was_open_slides_from_its_place_of_touch() {
        let law = Coulomb::new(0.3, 100.0).unwrap();
        // 10 of force at a stiffness of 400: 0.025 deep, and open by 0.075 before. A quarter of the way was in touch.
        for (slip, state, traction) in [(0.1, FrictionState::Stick, 2.5), (0.2, FrictionState::Slip, 3.0)] {
            let force = law.force_since(NORMAL, 0.5 * slip * slip, 30.0);
            assert!((force.share - 0.25).abs() < 1e-15);
            assert_eq!(force.state, state);
            assert!((force.factor * slip - traction).abs() < 1e-14, "{slip}");
            // The new slip has this traction. Of the mean traction the rest was work, if it slides.
            assert!((law.stiffness() * force.kept * slip - traction).abs() < 1e-14);
            let slid = if state == FrictionState::Slip { slip - traction / 100.0 } else { 0.0 };
            assert!(
                (force.dissipated(slip, BeforeStep::Open) - 0.5 * traction * slid).abs() < 1e-15,
                "{slip}"
            );
        }
        // At the touch there is no friction.
        let touch = NormalForce { force: 1e-9, ..NORMAL };
        assert!(law.force_since(touch, 0.5, 30.0).factor < 1e-8);
    }

    /// Nodes that come and go, however long the steps are: of all places where a step may begin the mean is the work.
    #[test]
    fn the_work_of_a_contact_that_passes_does_not_depend_on_the_steps() {
        let law = Coulomb::new(0.3, 1e6).unwrap();
        // A parabola of pressure that is 2 long, over the way.
        let pressure = |way: f64| 400.0 * (1.0 - way * way).max(0.0);
        let exact = 0.3 * 400.0 * 4.0 / 3.0;
        for step in [0.1, 0.7, 1.9, 3.3] {
            let mut sum = 0.0;
            for start in 0..100 {
                let ends = (0..).map(|k| -5.0 + step * (k as f64 + f64::from(start) / 100.0));
                let mut before = BeforeStep::Open;
                for end in ends.take_while(|end| *end < 5.0) {
                    let normal = NormalForce { force: pressure(end), stiffness: 400.0 };
                    let force = law.force(normal, 0.5 * step * step);
                    sum += force.dissipated(step, before) / 100.0;
                    before = match force.state {
                        FrictionState::Slip => BeforeStep::Slid(force.factor * step),
                        FrictionState::Open | FrictionState::Stick => BeforeStep::Open,
                    };
                }
            }
            assert!((sum / exact - 1.0).abs() < 0.02, "{step} {sum} {exact}");
        }
    }

    /// Half of what a contact slides on for until it opens counts, and nothing of what it is carried after it stuck.
    #[test]
    fn work_ends_where_contact_does() {
        let law = Coulomb::new(0.3, 100.0).unwrap();
        let open = law.force(NormalForce { force: 0.0, ..NORMAL }, 0.5);
        let work = |before| open.dissipated(1.0, before);
        assert_eq!(
            [BeforeStep::Open, BeforeStep::Stuck(3.0), BeforeStep::Slid(3.0)].map(work),
            [0.0, 0.0, 1.5]
        );
        // One that stuck slides at what it could bear.
        let sliding = law.force(NORMAL, 0.5);
        let work = |before| sliding.dissipated(1.0, before);
        assert_eq!(work(BeforeStep::Stuck(2.0)), work(BeforeStep::Slid(2.0)));
        assert_eq!(law.limit(NORMAL.force), sliding.factor);
    }

    /// A coefficient that is none at rest, as one with a pole at no pressure, is no work.
    #[test]
    fn a_coefficient_that_is_none_limits_nothing() {
        #[derive(Debug)]
        struct Pole;
        impl FrictionCoefficient for Pole {
            fn coefficient(&self, pressure: f64, _: f64) -> CoefficientValue {
                CoefficientValue {
                    value: 1.0 / pressure,
                    by_pressure: -1.0 / (pressure * pressure),
                    by_rate: 0.0,
                }
            }
        }
        let law = Coulomb::variable(&Pole, 1.0, 100.0).unwrap();
        assert_eq!([0.0, f64::NAN, 2.0].map(|pressure| law.limit(pressure)), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn without_pressure_or_coefficient_there_is_no_friction() {
        let open = NormalForce { force: 0.0, stiffness: 400.0 };
        let law = Coulomb::new(0.3, 100.0).unwrap();
        assert_eq!(law.force(open, 1.0).state, FrictionState::Open);
        for force in [law.force(open, 1.0), Coulomb::new(0.0, 100.0).unwrap().force(NORMAL, 1.0)] {
            let FrictionForce { factor, factor_by_half_square, factor_by_gap, .. } = force;
            assert_eq!([factor, factor_by_half_square, factor_by_gap], [0.0; 3]);
        }
    }

    #[test]
    fn laws_that_are_none_are_refused() {
        for (coefficient, stiffness, code) in [
            (-0.1, 1.0, "invalid-friction-coefficient"),
            (f64::NAN, 1.0, "invalid-friction-coefficient"),
            (f64::INFINITY, 1.0, "invalid-friction-coefficient"),
            (0.3, 0.0, "invalid-friction-stiffness"),
            (0.3, f64::NAN, "invalid-friction-stiffness"),
        ] {
            assert_eq!(Coulomb::new(coefficient, stiffness).unwrap_err().code(), code);
        }
    }
}
