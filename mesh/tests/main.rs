//! The tests of the public interface.

mod abaqus;
mod cae;
mod gmsh;
mod robustness;
mod shipped;
mod vtu;
