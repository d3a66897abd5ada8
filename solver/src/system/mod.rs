//! Linear systems: sparse matrices in 3 × 3 blocks by pairs of nodes, and their direct solution for the free equations.
//!
//! A [`BlockPattern`] has a block for each pair of nodes of a clique: an element, or a contact element. A [`BlockMatrix`] is
//! over all nodes; which (node, axis) are unknowns is the matter of [`Equations`], and a [`DirectSolver`] factorises that part.

mod equations;
mod error;
mod factor;
mod matrix;
mod pattern;
mod solver;

pub use equations::Equations;
pub use error::SystemError;
pub use matrix::BlockMatrix;
pub use pattern::BlockPattern;
pub use solver::{DirectSolver, Method, SolveReport, Symmetry};
