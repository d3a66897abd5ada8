//! What can be said to `check`.

use clap::Args;
use diffuse_contact_codegen::Basis;
use diffuse_contact_program::arguments::named;

use super::nodes::NodeCounts;
use crate::weight::FORMULAS;

/// Arguments of `check`.
#[derive(Args, Clone, Debug)]
#[command(after_help = FORMULAS)]
pub struct CheckArguments {
    /// Numbers of master nodes: 9, 6..=12 or 6..12 [default: 6..=24 quadratic, 3..=24 linear]
    #[arg(long, value_name = "A..=B")]
    pub nodes: Option<NodeCounts>,
    /// Basis of the fit [default: both]
    #[arg(long, value_parser = named(Basis::ALL, Basis::name))]
    pub basis: Option<Basis>,
    /// Weight of the fit, by name or formula [default: all that kernels are compiled for]. Of a formula there are no
    /// kernels in the program: the interpreter is compared with automatic differentiation
    #[arg(long, value_name = "FORMULA")]
    pub weight: Option<String>,
    /// Make the weight of the formula interpolating
    #[arg(long, requires = "weight")]
    pub interpolating: bool,
    /// Seed of the random elements
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// Print JSON instead of a table
    #[arg(long)]
    pub json: bool,
}
