//! Finite-strain statics of solids in contact: the diffuse contact element inside an implicit finite element code.

#![forbid(unsafe_code)]

pub mod contact;
pub mod deck;
pub mod material;
pub mod model;
pub mod output;
pub mod report;
pub mod solid;
pub mod solve;
pub mod statics;
pub mod system;
pub mod verification;
