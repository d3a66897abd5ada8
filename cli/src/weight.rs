//! The weight asked for on the command line or in a file.

use std::io::Write;

use diffuse_contact_codegen::{self as codegen, WeightError};

use crate::error::CliError;

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
        if let Some(built_in) = Self::built_in(text).filter(|_| !interpolating) {
            return Ok(Self::BuiltIn(built_in));
        }
        let weight = if interpolating { codegen::Weight::interpolating } else { codegen::Weight::new };
        Ok(Self::Formula(weight(NAME, text)?))
    }

    fn built_in(name: &str) -> Option<diffuse_contact::Weight> {
        diffuse_contact::Weight::ALL.into_iter().find(|weight| weight.name() == name)
    }

    /// What the generator makes kernels of.
    #[must_use]
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
    #[must_use]
    pub const fn as_built_in(&self) -> Option<diffuse_contact::Weight> {
        match self {
            Self::BuiltIn(weight) => Some(*weight),
            Self::Formula(_) => None,
        }
    }

    /// Formula in one line, after the name of a built-in weight.
    #[must_use]
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

/// The weight of `--weight` and `--interpolating`; the cubic weight of the paper if there is none.
pub fn weight(text: Option<&str>, interpolating: bool) -> Result<Weight, CliError> {
    let weight = text.map_or_else(|| Ok(Weight::default()), |text| Weight::new(text, interpolating))?;
    if let Some(note) = weight.for_generator().note() {
        let _ = writeln!(std::io::stderr(), "note: {note}");
    }
    Ok(weight)
}

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
