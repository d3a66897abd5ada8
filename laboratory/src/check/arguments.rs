//! What can be said to `check`.

use clap::Args;

use super::nodes::NodeCounts;
use crate::weight::{FORMULAS, FitArguments};

/// Arguments of `check`.
#[derive(Args, Clone, Debug)]
#[command(after_help = FORMULAS)]
pub struct CheckArguments {
    /// Numbers of master nodes: 9, 6..=12 or 6..12 [default: 6..=24 quadratic, 3..=24 linear]
    #[arg(long, value_name = "A..=B")]
    pub nodes: Option<NodeCounts>,
    /// Basis and weight.
    #[command(flatten)]
    pub fit: FitArguments,
    /// Seed of the random elements
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// Print JSON instead of a table
    #[arg(long)]
    pub json: bool,
}
