//! Symbolic differentiation and Rust code generation for moving least squares contact elements.
//!
//! The pipeline, one module per stage:
//!
//! ```text
//! formula    text of a weight                    "(1 - r)^2 * (1 + 2*r)"
//! model      basis, weight, fit, foot, gap, facet formulas over a graph
//! graph      hash-consed expressions             simplification, derivatives, substitution
//! structure  sums, systems, roots                first and second derivatives of implicit quantities
//! lower      structured nodes to arithmetic      unrolled factorisation and solves
//! schedule   arithmetic to a program             segments, loops over nodes, fused products
//! emit       program to syn::File                functions, documentation, operation counts
//! config     syn::File to a file                 the build API, the only place with input and output
//! interpret  the graph in f64                    second witness of every kernel
//! ```
#![forbid(unsafe_code)]

pub mod config;
pub mod emit;
pub mod formula;
pub mod graph;
pub mod interpret;
pub mod lower;
pub mod model;
pub mod schedule;
pub mod structure;

pub use config::{Config, ConfigError};
pub use model::{
    Basis, BasisError, CustomBasis, FacetShape, FacetSpec, FrameRule, Kernel, KernelSpec, Mode, Output,
    Weight, WeightError, WeightNote,
};
