//! Derivatives of implicitly defined quantities, found in the structure of their definitions: sums over nodes,
//! common factors, small linear systems.

mod factors;
mod fit_derivatives;
mod follower;
mod linear_images;
mod low_rank;
mod small;

pub use fit_derivatives::{Block, CoordinateMap, Functional, Gradient, Hessian, NodeProblem};
pub use follower::Follower;
pub use linear_images::{LinearImages, SecondDerivative};
