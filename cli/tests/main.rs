//! Runs the program.

/// The program that is run.
const PROGRAM: &str = env!("CARGO_BIN_EXE_diffuse-contact");

mod demo;
#[path = "../../program/tests/elements.rs"]
mod elements;
mod elsewhere;
mod evaluate;
mod evaluate_friction;
mod neighbours;
#[path = "../../program/tests/runs.rs"]
mod runs;
mod surface;
mod surroundings;
