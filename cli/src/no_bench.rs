//! The `bench` job in a program that was built without it.

use clap::Args;

use crate::error::CliError;

/// Arguments of `bench`: whatever it is.
#[derive(Args, Clone, Debug)]
#[command(disable_help_flag = true)]
pub struct BenchArguments {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    all: Vec<String>,
}

/// Says how to get it.
pub fn run(_: &BenchArguments) -> Result<(), CliError> {
    Err(CliError::NoBench)
}
