//! The generated kernels against their rivals, all on the same elements: quadratic basis, cubic weight.
//!
//! Every way to evaluate the element is a [`Contender`]: the kernels, the element written by hand, automatic
//! differentiation. [`measure()`] compares their results, runs them in interleaved rounds and takes medians; a
//! [`Report`] holds what was found. `diffuse-contact bench` prints it. Figures count with link-time optimisation only:
//! `cargo run --profile bench -p diffuse-contact-laboratory -- bench`.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `elements.rs` | the elements all contenders evaluate |
//! | `random.rs` | the numbers they are made of |
//! | `contender.rs`, `contenders.rs` | what a contender is, and the list of them |
//! | `generated.rs` | the generated kernels one element at a time, and their operation counts |
//! | `batch.rs` | the generated kernels for many elements at once |
//! | `by_hand/` | the element written by hand with nalgebra |
//! | `one_by_one.rs` | those that take one element after another |
//! | `dual.rs` | the element over the dual numbers of num-dual |
//! | `peak.rs` | the fused multiply-adds a second that the machine can do |
//! | `tetrahedron.rs` | a solid element from its energy and by hand, of `benches/tetrahedron.rs` |
//! | `measure.rs`, `report.rs` | rounds and medians, tables and JSON |
#![forbid(unsafe_code)]

pub mod batch;
#[cfg(feature = "rivals")]
pub mod by_hand;
pub mod contender;
#[cfg(feature = "rivals")]
pub mod contenders;
#[cfg(feature = "rivals")]
pub mod dual;
pub mod elements;
pub mod generated;
#[cfg(feature = "rivals")]
pub mod measure;
mod one_by_one;
pub mod peak;
pub mod random;
#[cfg(feature = "rivals")]
pub mod report;
#[cfg(feature = "rivals")]
pub mod tetrahedron;

pub use contender::{Contender, Evaluation, NoResult, Output, Run};
#[cfg(feature = "rivals")]
pub use contenders::CONTENDERS;
pub use elements::{Elements, ElementsError};
#[cfg(feature = "rivals")]
pub use generated::operations;
pub use generated::{UnknownIsa, isa_named};
#[cfg(feature = "rivals")]
pub use measure::{MeasureError, Plan, measure};
pub use random::Random;
#[cfg(feature = "rivals")]
pub use report::Report;
