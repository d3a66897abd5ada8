//! Coulomb friction with an exact tangent, after docs/equations.md, T16.
//!
//! The slip of a contact is measured from its *anchor*, a material point of the master that the slave stuck to. The potential
//! of a stuck contact is ε_T q with q = ½ |P_ν d|², half the square of the slip; that of a sliding one has the magnitude μ p of its
//! traction instead. Both are one force −c ∇q with a factor c of q and of the gap:
//!
//! ```text
//! stick, ε_T s ≤ μ p:   c = ε_T
//! slip:                 c = μ p / s,   s = √(2q)
//! ```
//!
//! q does not change under rigid motions of slave, masters and anchor together: the forces balance, and so do their moments.

use diffuse_contact_kernels::coulomb;

use crate::{ElementError, Mode, Slip};

/// Coulomb's law with a penalty for stick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coulomb {
    coefficient: f64,
    stiffness: f64,
}

/// What a contact with friction does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FrictionState {
    /// No pressure: no friction.
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
}

impl FrictionError {
    /// Short name, as in results.
    #[must_use]
    pub const fn code(&self) -> &'static str {
        match self {
            Self::InvalidCoefficient { .. } => "invalid-friction-coefficient",
            Self::InvalidStiffness { .. } => "invalid-friction-stiffness",
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
    /// Part of the slip that remains behind the slave when the step is accepted, 1 − θ = μ p/(ε_T s); 1 in stick.
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
        Ok(Self { coefficient, stiffness })
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

    /// The friction of a contact with this normal force and this half square q ≥ 0 of the slip. Without normal force, or with μ = 0,
    /// there is none.
    #[must_use]
    pub fn force(&self, normal: NormalForce, half_square: f64) -> FrictionForce {
        if !(normal.force > 0.0) {
            return FrictionForce::NONE;
        }
        let Self { coefficient, stiffness } = *self;
        if coefficient * normal.force == 0.0 {
            return FrictionForce { state: FrictionState::Slip, kept: 0.0, ..FrictionForce::NONE };
        }
        let inputs = coulomb::Inputs { half_square, pressure: normal.force, coefficient, stiffness };
        let coulomb::Results { values, factor_jacobian: [by_half_square, by_pressure] } =
            coulomb::evaluate(Mode::Gradient, &inputs);
        let factor = values.factor;
        FrictionForce {
            state: if factor < stiffness { FrictionState::Slip } else { FrictionState::Stick },
            factor,
            factor_by_half_square: by_half_square,
            factor_by_gap: -normal.stiffness * by_pressure,
            kept: factor / stiffness,
        }
    }
}

impl FrictionForce {
    const NONE: Self = Self {
        state: FrictionState::Open,
        factor: 0.0,
        factor_by_half_square: 0.0,
        factor_by_gap: 0.0,
        kept: 1.0,
    };

    /// R = −c ∇q, the force on slave, masters and anchor, 3(n+2) entries.
    #[must_use]
    pub fn contact_force(&self, slip: &Slip) -> Vec<f64> {
        slip.gradient.iter().map(|x| -self.factor * x).collect()
    }

    /// K = −∂R/∂x = c ∇²q + ∂c/∂q ∇q ∇qᵀ + ∂c/∂g ∇q Nᵀ, rows of 3(n+2) entries over slave, masters and anchor. The last term is not
    /// symmetric; it is zero in stick.
    ///
    /// # Panics
    /// If the slip has no Hessian.
    #[must_use]
    pub fn tangent(&self, slip: &Slip) -> Vec<Vec<f64>> {
        let size = slip.gradient.len();
        assert_eq!(slip.hessian.size(), size, "a slip with its Hessian");
        // The gap does not depend on the anchor.
        let by_gap = |q: usize| slip.contact.gradient.get(q).map_or(0.0, |n| self.factor_by_gap * n);
        let entry = |p: usize, q: usize| {
            let by_slip = self.factor_by_half_square * slip.gradient[q];
            self.factor * slip.hessian.get(p, q) + slip.gradient[p] * (by_slip + by_gap(q))
        };
        (0..size).map(|p| (0..size).map(|q| entry(p, q)).collect()).collect()
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
    fn the_factors_derivatives_are_its_differences() {
        let law = Coulomb::new(0.3, 100.0).unwrap();
        let (q, h) = (0.5 * 0.3 * 0.3, 1e-6);
        let at = |gap: f64, q: f64| {
            let normal = NormalForce { force: NORMAL.force - NORMAL.stiffness * gap, ..NORMAL };
            law.force(normal, q)
        };
        let force = at(0.0, q);
        let by_q = (at(0.0, q + h).factor - at(0.0, q - h).factor) / (2.0 * h);
        let by_gap = (at(h, q).factor - at(-h, q).factor) / (2.0 * h);
        assert!((force.factor_by_half_square / by_q - 1.0).abs() < 1e-8);
        assert!((force.factor_by_gap / by_gap - 1.0).abs() < 1e-8);
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
