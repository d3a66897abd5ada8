//! The weight asked for on the command line or in a file.

use clap::Args;
use diffuse_contact_codegen::{self as codegen, Basis, WeightError};
use diffuse_contact_program::arguments::named;

use crate::error::{CliError, say};

/// How a weight is written, for the help of `emit` and `check`.
pub(crate) const FORMULAS: &str = "\
FORMULA is a weight w(r) for 0 <= r < 1, r = in-plane distance over the support radius; it is 0 beyond.
It may contain r, numbers, + - * /, ^ with an integer exponent, ( ), exp(...), sqrt(...) and
if r < 0.5 { ... } else { ... }. It must be positive and flat at r = 0.
The cubic weight of the paper is \"(1 - r)^2 * (1 + 2*r)\". Built-in weights have names: cubic, cubic-interpolating,
wendland-c2. With --interpolating the weight is w/(1 - w): the surface passes through the master nodes.";

/// The fit that kernels are asked for.
#[derive(Args, Clone, Debug)]
pub struct FitArguments {
    /// Basis of the fit [default: both; of a single kernel quadratic]
    #[arg(long, value_parser = named(Basis::ALL, Basis::name))]
    pub basis: Option<Basis>,
    /// Weight of the fit, by name or formula [default: cubic; of `check` all that kernels are compiled for]. Of a formula
    /// `check` has no kernels: it compares the interpreter with automatic differentiation
    #[arg(long, value_name = "FORMULA")]
    pub weight: Option<String>,
    /// Make the weight of the formula interpolating
    #[arg(long, requires = "weight")]
    pub interpolating: bool,
}

impl FitArguments {
    /// The weight that was asked for.
    pub fn weight(&self) -> Result<Option<Weight>, CliError> {
        let Some(text) = &self.weight else { return Ok(None) };
        let weight =
            Weight::new(text, self.interpolating).map_err(|reason| CliError::job(WeightArgument(reason)))?;
        if let Some(note) = weight.for_generator().note() {
            say(&format!("note: {note}"));
        }
        Ok(Some(weight))
    }
}

/// Name in emitted code of a weight given as a formula.
const NAME: &str = "custom";

/// A weight the program knows how to differentiate.
#[derive(Clone, Debug, PartialEq)]
pub enum Weight {
    /// One whose kernels are compiled into the program.
    BuiltIn(diffuse_contact::Weight),
    /// One given as a formula.
    Formula(codegen::Weight),
}

impl Default for Weight {
    fn default() -> Self {
        Self::BuiltIn(diffuse_contact::Weight::default())
    }
}

impl Weight {
    /// The weight with this name or formula, with `interpolating` the one made interpolating from the formula.
    ///
    /// # Errors
    /// [`WeightError`] if a formula is no weight.
    pub fn new(text: &str, interpolating: bool) -> Result<Self, WeightError> {
        let mut built_in = diffuse_contact::Weight::ALL.into_iter();
        if let Some(built_in) = built_in.find(|weight| weight.name() == text && !interpolating) {
            return Ok(Self::BuiltIn(built_in));
        }
        let weight = if interpolating { codegen::Weight::interpolating } else { codegen::Weight::new };
        Ok(Self::Formula(weight(NAME, text)?))
    }

    /// What the generator makes kernels of.
    pub fn for_generator(&self) -> codegen::Weight {
        match self {
            Self::BuiltIn(diffuse_contact::Weight::Cubic) => codegen::Weight::cubic(),
            Self::BuiltIn(diffuse_contact::Weight::CubicInterpolating) => {
                codegen::Weight::cubic_interpolating()
            }
            Self::BuiltIn(diffuse_contact::Weight::WendlandC2) => codegen::Weight::wendland_c2(),
            Self::Formula(weight) => weight.clone(),
        }
    }

    /// The built-in weight, if it is one.
    pub const fn as_built_in(&self) -> Option<diffuse_contact::Weight> {
        match self {
            Self::BuiltIn(weight) => Some(*weight),
            Self::Formula(_) => None,
        }
    }

    /// Formula in one line, after the name of a built-in weight.
    pub fn description(&self) -> String {
        let weight = self.for_generator();
        let formula = weight.text().split_whitespace().collect::<Vec<_>>().join(" ");
        let formula = match weight.is_interpolating() {
            true => format!("omega/(1 - omega), omega = {formula}"),
            false => formula,
        };
        match self {
            Self::BuiltIn(built_in) => format!("{}: {formula}", built_in.name()),
            Self::Formula(_) => formula,
        }
    }
}

/// What is wrong with the weight that was asked for. If a formula cannot be read, the formula itself follows below the sentence, with a mark.
#[derive(Debug, thiserror::Error)]
#[error("--weight: {0}")]
pub(crate) struct WeightArgument<E>(pub E);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_formulas_are_told_apart() {
        for built_in in diffuse_contact::Weight::ALL {
            let weight = Weight::new(built_in.name(), false).unwrap();
            assert_eq!(weight.as_built_in(), Some(built_in));
            assert!(weight.description().starts_with(built_in.name()));
        }
        let formula = Weight::new("(1 - r)^2 * (1 + 2*r)", true).unwrap();
        assert_eq!(formula.as_built_in(), None);
        assert_eq!(formula.description(), "omega/(1 - omega), omega = (1 - r)^2 * (1 + 2*r)");
    }
}
