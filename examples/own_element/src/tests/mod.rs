//! The compiled kernels against the interpreter of their formulas, and against automatic differentiation of functions written once more for
//! dual numbers.

mod arm;
mod cloud;
mod cohesive;
mod contact;
#[path = "../../elements/mod.rs"]
mod elements;
mod joint;
mod neo_hooke;
mod products;
mod surface;
mod tanks;
mod tet4;
mod witnesses;
