//! The tests of the public interface, and of the program.

/// The program that is run.
#[cfg(feature = "program")]
const PROGRAM: &str = env!("CARGO_BIN_EXE_diffuse-contact-solve");

mod common;
mod contact;
mod deck;
#[cfg(feature = "program")]
mod decks;
mod element;
mod examples;
mod friction;
mod joints;
mod model;
mod multigrid;
mod output;
mod paper;
#[cfg(feature = "program")]
mod points;
mod proposals;
#[cfg(feature = "program")]
mod report;
#[cfg(feature = "program")]
mod restart;
#[cfg(feature = "program")]
#[path = "../../program/tests/runs.rs"]
mod runs;
mod self_contact;
mod shapes;
mod solid;
#[cfg(feature = "program")]
mod solve;
#[cfg(feature = "program")]
mod solve_interrupted;
mod statics;
mod system;
mod warnings;
mod wedges;
