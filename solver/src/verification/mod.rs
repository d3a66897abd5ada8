//! Problems with known answers: a run in memory, and what is measured on it.
//!
//! | measure | of | exact |
//! | --- | --- | --- |
//! | [`Uniformity`] | stress and contact pressure of a patch test | uniform |
//! | [`LineContact`], [`PointContact`], [`PressureProfile`] | a cylinder or a ball on a plane | Hertz |
//! | [`PartialSlip`], [`TractionProfile`] | cylinders that stick in the middle | Cattaneo and Mindlin |
//! | [`Snapshot::moment`] | two rings turned in one another without friction | none |
//! | [`Oscillation`] | the force on what slides over a surface of revolution | constant |
//! | [`largest_kink`] | the force of a surface on itself | smooth |
//!
//! The decks in `examples/` are such problems. The solver's tests assert these numbers on coarse meshes, `diffuse-contact-laboratory
//! study verification` prints them.

mod hertz;
mod kink;
mod mindlin;
mod oscillation;
mod patch;
mod trace;

pub use hertz::{LineContact, NodalPressure, PointContact, PressureProfile};
pub use kink::largest_kink;
pub use mindlin::{NodalTraction, PartialSlip, TractionProfile};
pub use oscillation::Oscillation;
pub use patch::Uniformity;
pub use trace::{Snapshot, Trace, trace, trace_model};
