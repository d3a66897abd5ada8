//! Finite-strain statics of solids in contact: the diffuse contact element inside an implicit finite element code.

#![forbid(unsafe_code)]

pub mod deck;
pub mod material;
pub mod model;
