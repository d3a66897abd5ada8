//! Derivatives of implicitly defined quantities, found in the structure of their definitions: sums over nodes,
//! common factors, small linear systems.

mod factors;
mod fit_derivatives;
mod small;

pub use fit_derivatives::{Block, CoordinateMap, Functional, Gradient, Hessian, NodeProblem};
