//! Runs the program, and the library behind it.

/// The program that is run.
const PROGRAM: &str = env!("CARGO_BIN_EXE_diffuse-contact-laboratory");

mod bench;
mod check;
#[path = "../../program/tests/elements.rs"]
mod elements;
mod emit;
mod emit_c;
mod evaluate;
#[path = "../../program/tests/runs.rs"]
mod runs;
mod study;
