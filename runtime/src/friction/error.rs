//! Why numbers are no law of friction.

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
    /// The duration of a step is not positive.
    #[error("the duration of a step has to be a positive number, not {value}")]
    InvalidDuration {
        /// Δt.
        value: f64,
    },
    /// The decay of a coefficient is negative or not a number.
    #[error("the decay of the coefficient of friction has to be a number that is not negative, not {value}")]
    InvalidDecay {
        /// β.
        value: f64,
    },
    /// Numbers that are no table.
    #[error("number {place} of the table is not finite, does not ascend, is missing or too many")]
    InvalidTable {
        /// The place of the first such number, in pressures, rates and coefficients one after another.
        place: usize,
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
            Self::InvalidDuration { .. } => "invalid-duration",
            Self::InvalidDecay { .. } => "invalid-decay",
            Self::InvalidTable { .. } => "invalid-table",
        }
    }
}
