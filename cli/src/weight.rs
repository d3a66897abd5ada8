//! The weight asked for on the command line.

use diffuse_contact_codegen::Weight;

use crate::error::CliError;

/// Name in emitted code of a weight given as a formula.
const NAME: &str = "custom";

/// The weight of that formula; the cubic weight of the paper if there is none.
pub fn weight(formula: Option<&str>) -> Result<Weight, CliError> {
    Ok(match formula {
        Some(formula) => Weight::new(NAME, formula)?,
        None => Weight::cubic(),
    })
}
