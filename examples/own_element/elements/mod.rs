//! Elements from their formulas, one file each. The build script generates their kernels; the tests interpret the same formulas.

pub mod arm;
pub mod cloud;
pub mod cohesive;
pub mod contact;
pub mod joint;
pub mod neo_hooke;
pub mod surface;
pub mod tanks;
