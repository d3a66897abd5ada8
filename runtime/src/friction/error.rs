//! Why numbers are no law of friction.

/// A coefficient or a stiffness that is none.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum FrictionError {
    /// μ is negative or not a number.
    #[error("the coefficient of friction has to be a number that is not negative, not {value:?}")]
    InvalidCoefficient { value: f64 },
    /// ε_T is not positive.
    #[error("the tangential stiffness has to be a positive number, not {value:?}")]
    InvalidStiffness { value: f64 },
    /// The duration Δt of a step is not positive.
    #[error("the duration of a step has to be a positive number, not {value:?}")]
    InvalidDuration { value: f64 },
    /// The decay β of a coefficient is negative or not a number.
    #[error(
        "the decay of the coefficient of friction has to be a number that is not negative, not {value:?}"
    )]
    InvalidDecay { value: f64 },
    /// Numbers that are no table. `place` is that of the first such number, in pressures, rates and coefficients one after another.
    #[error("number {place} of the table is not finite, does not ascend, is missing or too many")]
    InvalidTable { place: usize },
    /// τ is not positive.
    #[error("the shear limit has to be a positive number, not {value:?}")]
    InvalidShearLimit { value: f64 },
}

impl FrictionError {
    /// Short name, as in results.
    pub const fn code(&self) -> &'static str {
        match self {
            Self::InvalidCoefficient { .. } => "invalid-friction-coefficient",
            Self::InvalidStiffness { .. } => "invalid-friction-stiffness",
            Self::InvalidShearLimit { .. } => "invalid-shear-limit",
            Self::InvalidDuration { .. } => "invalid-duration",
            Self::InvalidDecay { .. } => "invalid-decay",
            Self::InvalidTable { .. } => "invalid-table",
        }
    }
}
