//! Derivatives of implicitly defined quantities, found in the structure of their definitions: sums over nodes,
//! common factors, small linear systems.

mod chain;
mod combination;
mod coordinates;
mod definition;
mod direction;
mod elimination;
mod expansion;
mod factors;
mod fit_derivatives;
mod follower;
mod intermediates;
mod invariance;
mod known;
mod linear_images;
mod low_rank;
mod node_problem;
mod node_sums;
mod outer_block;
mod point;

pub use chain::{Chain, Way};
pub use coordinates::CoordinateMap;
pub use definition::Intermediate;
pub use direction::Direction;
pub use elimination::Elimination;
pub use expansion::Derivatives;
pub use follower::Follower;
pub use intermediates::{Written, as_bound, with_found};
pub use invariance::{NodeVectors, hessian_product, total_derivatives};
pub use low_rank::{LowRankForm, LowRankTerm, PointForm};
pub use node_problem::{Block, Functional, Gradient, NodeProblem};
pub use node_sums::{Asked, Implicit, NoSum, NodeDerivatives, NodeSecond, node_derivatives};
pub(crate) use node_sums::{has_within, sums_in};
pub use point::PointDependence;
