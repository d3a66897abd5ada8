//! Linear systems: sparse matrices in 3 × 3 blocks by pairs of nodes, and their solution for the free equations, directly or iteratively.
//!
//! A [`BlockPattern`] has a block for each pair of nodes of a clique: an element, or a contact element. A [`BlockMatrix`] is
//! over all nodes; which (node, axis) are unknowns is the matter of [`Equations`]. A [`LinearSolver`] solves that part: with a
//! [`DirectSolver`], which factorises it, or by [`solve_iteratively`], whose memory grows with the number of equations only.

mod choice;
mod condition;
mod contact_rows;
mod equations;
mod error;
mod factor;
mod iterative;
mod matrix;
mod multigrid;
mod operator;
mod pattern;
mod preconditioner;
mod solver;
mod stiff;
mod work;

pub use choice::{LinearReport, LinearSolver, LinearSolverChoice, LinearSystem};
use condition::irregular;
pub use contact_rows::SavedRows;
pub use equations::Equations;
pub use error::SystemError;
pub use iterative::{Accuracy, IterativeReport, solve_iteratively};
pub use matrix::BlockMatrix;
pub use multigrid::Geometry;
pub use operator::Operator;
pub use pattern::BlockPattern;
pub use solver::{DirectSolver, Method, SolveReport, Symmetry};
