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
//!
//! w is the part of the slip since the place of touch: 1 for a contact that was closed when the last step was accepted. One that
//! was open by g₀ has slid from its foot of then to its foot of now while the gap went from g₀ to the present one. It touched at
//! 1 − w of the way: w = p/(p + ε g₀). Friction begins with the pressure, without a jump.
//!
//! q does not change under rigid motions of slave, masters and anchor together: the forces balance, and so do their moments.

use diffuse_contact_kernels::{coulomb, traction};

use crate::{ElementError, Mode, Point, Slip};

/// Coulomb's law with a penalty for stick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coulomb {
    coefficient: f64,
    stiffness: f64,
    /// τ; the largest number for none.
    shear_limit: f64,
}

/// What a contact with friction does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FrictionState {
    /// No pressure, or no history yet: no friction.
    #[default]
    Open,
    /// The traction is below μ p.
    Stick,
    /// The traction is μ p, against the slip.
    Slip,
}

impl FrictionState {
    /// Name in results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Stick => "stick",
            Self::Slip => "slip",
        }
    }
}

/// A coefficient or a stiffness that is none.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FrictionError {
    /// μ is negative or not a number.
    #[error("the coefficient of friction has to be a number that is not negative, not {value}")]
    InvalidCoefficient {
        /// μ.
        value: f64,
    },
    /// ε_T is not positive.
    #[error("the tangential stiffness has to be a positive number, not {value}")]
    InvalidStiffness {
        /// ε_T.
        value: f64,
    },
    /// τ is not positive.
    #[error("the shear limit has to be a positive number, not {value}")]
    InvalidShearLimit {
        /// τ.
        value: f64,
    },
}

impl FrictionError {
    /// Short name, as in results.
    #[must_use]
    pub const fn code(&self) -> &'static str {
        match self {
            Self::InvalidCoefficient { .. } => "invalid-friction-coefficient",
            Self::InvalidStiffness { .. } => "invalid-friction-stiffness",
            Self::InvalidShearLimit { .. } => "invalid-shear-limit",
        }
    }
}

/// The normal force of a contact and how it depends on the gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalForce {
    /// p ≥ 0, force.
    pub force: f64,
    /// −∂p/∂g ≥ 0, force per length: ε.
    pub stiffness: f64,
}

/// The friction of one contact: the factor c of R = −c ∇q, and its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionForce {
    /// Stick, slip or neither.
    pub state: FrictionState,
    /// c, force per length.
    pub factor: f64,
    /// ∂c/∂q, force per length³.
    pub factor_by_half_square: f64,
    /// ∂c/∂g, force per length².
    pub factor_by_gap: f64,
    /// w, the part of the slip since the place of touch.
    pub share: f64,
    /// Part of the slip that remains behind the slave when the step is accepted, 1 − θ = c/ε_T; 1 in stick.
    pub kept: f64,
}

impl Coulomb {
    /// The law with the coefficient of friction μ ≥ 0 and the tangential stiffness ε_T > 0, force per length.
    ///
    /// # Errors
    /// [`FrictionError`].
    pub fn new(coefficient: f64, stiffness: f64) -> Result<Self, FrictionError> {
        if !(coefficient >= 0.0 && coefficient.is_finite()) {
            return Err(FrictionError::InvalidCoefficient { value: coefficient });
        }
        if !(stiffness > 0.0 && stiffness.is_finite()) {
            return Err(FrictionError::InvalidStiffness { value: stiffness });
        }
        Ok(Self { coefficient, stiffness, shear_limit: f64::MAX })
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

    /// μ
    #[must_use]
    pub const fn coefficient(&self) -> f64 {
        self.coefficient
    }

    /// ε_T, force per length.
    #[must_use]
    pub const fn stiffness(&self) -> f64 {
        self.stiffness
    }

    /// τ, if there is a limit.
    #[must_use]
    pub fn shear_limit(&self) -> Option<f64> {
        Some(self.shear_limit).filter(|limit| *limit < f64::MAX)
    }

    /// The law of a slave with this tributary area, whose stiffness and shear limit are per area.
    #[must_use]
    pub fn over(&self, area: f64) -> Self {
        let limit = self.shear_limit().map_or(f64::MAX, |limit| limit * area);
        Self { stiffness: self.stiffness * area, shear_limit: limit, ..*self }
    }

    /// t_A and its derivatives over faces, for a way and a normal of any length (docs/equations.md, section 18), and what becomes of
    /// the slip.
    pub(crate) fn traction(
        &self,
        (way, normal): (Point, Point),
        pressure: f64,
        opening: f64,
    ) -> (traction::Results, Sliding) {
        let Self { coefficient, stiffness, shear_limit } = *self;
        let inputs = traction::Inputs { way, normal, pressure, coefficient, stiffness, opening, shear_limit };
        let results = traction::evaluate(Mode::Gradient, &inputs);
        let traction::Values { factor, share, slides, .. } = results.values;
        (results, self.sliding(factor, share, slides))
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
    #[must_use]
    pub fn force(&self, normal: NormalForce, half_square: f64) -> FrictionForce {
        self.force_since(normal, half_square, 0.0)
    }

    /// The same of a contact that was open by the gap `opening` ≥ 0 when the last step was accepted, and had its anchor in its foot.
    #[must_use]
    pub fn force_since(&self, normal: NormalForce, half_square: f64, opening: f64) -> FrictionForce {
        if !(normal.force > 0.0) {
            return FrictionForce::NONE;
        }
        let Self { coefficient, stiffness, shear_limit } = *self;
        if coefficient * normal.force == 0.0 {
            return FrictionForce { state: FrictionState::Slip, kept: 0.0, ..FrictionForce::NONE };
        }
        let opening = normal.stiffness * opening;
        let pressure = normal.force;
        let inputs = coulomb::Inputs { half_square, pressure, coefficient, stiffness, opening, shear_limit };
        let coulomb::Results { values, factor_jacobian: [by_half_square, by_pressure] } =
            coulomb::evaluate(Mode::Gradient, &inputs);
        let coulomb::Values { factor, share, slides, .. } = values;
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

/// What a contact does with its slip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sliding {
    pub state: FrictionState,
    /// c, force per length, with areas per area.
    pub factor: f64,
    /// w
    pub share: f64,
    /// 1 − θ
    pub kept: f64,
}

impl Sliding {
    /// As [`FrictionForce::dissipated`], with areas per area.
    pub fn dissipated(&self, slip: f64) -> f64 {
        match self.state {
            FrictionState::Slip => self.factor * slip * (self.share - self.kept) * slip,
            FrictionState::Open | FrictionState::Stick => 0.0,
        }
    }
}

impl FrictionForce {
    const NONE: Self = Self {
        state: FrictionState::Open,
        factor: 0.0,
        factor_by_half_square: 0.0,
        factor_by_gap: 0.0,
        share: 1.0,
        kept: 1.0,
    };

    /// Work of the traction over what slid since the last step was accepted, for a slip s, energy: what the slip since the place of
    /// touch has lost to the anchor.
    #[must_use]
    pub fn dissipated(&self, slip: f64) -> f64 {
        let Self { state, factor, share, kept, .. } = *self;
        Sliding { state, factor, share, kept }.dissipated(slip)
    }

    /// R = −c ∇q, the force on slave, masters and anchor, 3(n+2) entries.
    #[must_use]
    pub fn contact_force(&self, slip: &Slip) -> Vec<f64> {
        slip.gradient.iter().map(|x| -self.factor * x).collect()
    }

    /// K = −∂R/∂x = c ∇²q + ∂c/∂q ∇q ∇qᵀ + ∂c/∂g ∇q Nᵀ, rows of 3(n+2) entries over slave, masters and anchor. The last term is not
    /// symmetric; it is zero in stick, unless the contact has closed since the last accepted step.
    ///
    /// # Panics
    /// If the slip has no Hessian.
    #[must_use]
    pub fn tangent(&self, slip: &Slip) -> Vec<Vec<f64>> {
        let size = slip.gradient.len();
        assert_eq!(slip.hessian.size(), size, "a slip with its Hessian");
        // The gap does not depend on the anchor.
        let by_gap = |q: usize| slip.contact.gradient.get(q).copied().unwrap_or(0.0);
        let entry = |p: usize, q: usize| {
            let [own, other] = [p, q].map(|p| slip.gradient[p]);
            self.tangent_entry([own, other], slip.hessian.get(p, q), by_gap(q))
        };
        (0..size).map(|p| (0..size).map(|q| entry(p, q)).collect()).collect()
    }

    /// Entry (p, q) of the tangent from ∇q at p and q, ∇²q at (p, q) and N at q.
    pub(crate) fn tangent_entry(&self, [own, other]: [f64; 2], second: f64, by_gap: f64) -> f64 {
        // The product of a pair is the same either way round: without the last term the tangent is symmetric to the last bit.
        let symmetric = self.factor * second + self.factor_by_half_square * (own * other);
        symmetric + self.factor_by_gap * own * by_gap
    }

    /// Whether the force and its derivatives are finite.
    ///
    /// # Errors
    /// [`ElementError::Overflow`].
    pub fn check(&self) -> Result<(), ElementError> {
        let all = [self.factor, self.factor_by_half_square, self.factor_by_gap, self.kept];
        let is_finite = all.iter().all(|x| x.is_finite());
        if is_finite { Ok(()) } else { Err(ElementError::Overflow { what: "friction" }) }
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
                law.force_since(normal, q, opening)
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
            assert_eq!((force.factor, force.dissipated(1e-15)), (law.stiffness(), 0.0));
        }
    }

    #[test]
    fn a_contact_that_was_open_slides_from_its_place_of_touch() {
        let law = Coulomb::new(0.3, 100.0).unwrap();
        // 10 of force at a stiffness of 400: 0.025 deep, and open by 0.075 before. A quarter of the way was in touch.
        for (slip, state, traction) in [(0.1, FrictionState::Stick, 2.5), (0.2, FrictionState::Slip, 3.0)] {
            let force = law.force_since(NORMAL, 0.5 * slip * slip, 0.075);
            assert!((force.share - 0.25).abs() < 1e-15);
            assert_eq!(force.state, state);
            assert!((force.factor * slip - traction).abs() < 1e-14, "{slip}");
            // The new slip has this traction, and what the old one lost in touch was work.
            assert!((law.stiffness() * force.kept * slip - traction).abs() < 1e-14);
            let slid = 0.25 * slip - traction / 100.0;
            assert!((force.dissipated(slip) - traction * slid).abs() < 1e-15, "{slip}");
        }
        // At the touch there is no friction.
        let touch = NormalForce { force: 1e-9, ..NORMAL };
        assert!(law.force_since(touch, 0.5, 0.075).factor < 1e-8);
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
