//! Symbolic differentiation and Rust code generation for moving least squares contact elements.
//!
//! A build script states a weight; [`Config`] writes the kernels, with exact first and second derivatives, into `OUT_DIR`:
//!
//! ```no_run
//! use diffuse_contact_codegen::{Config, ConfigError};
//!
//! fn main() -> Result<(), ConfigError> {
//!     Config::new().weight("quartic", "(1 - r)^3 * (1 + 3*r)")?.compile()?;
//!     Ok(())
//! }
//! ```
//!
//! Formulas are checked, and errors point at the character:
//!
//! ```
//! use diffuse_contact_codegen::Weight;
//!
//! assert!(Weight::new("quartic", "(1 - r)^3 * (1 + 3*r)").is_ok());
//! let error = Weight::new("wrong", "(1 - q)^3").unwrap_err().to_string();
//! assert!(error.contains('^'), "{error}");
//! ```
//!
//! The same engine serves any element, with a fixed number of nodes or an open one, from its energy: [`Config::element`].
//!
//! # The pipeline
//!
//! One module per stage; what must stay true of each is in `ARCHITECTURE.md`:
//!
//! ```text
//! formula    text of a weight                    "(1 - r)^2 * (1 + 2*r)"
//! model      basis, weight, fit, foot, gap, slip, facet
//! kernel     inputs, formulas, outputs             the contact element's and those of callers
//! expr       formulas as they are written        handles with operators, vectors, matrices
//! graph      hash-consed expressions             simplification, derivatives, substitution
//! structure  sums, systems, roots                first and second derivatives of implicit quantities
//! lower      structured nodes to arithmetic      unrolled factorisation and solves
//! schedule   arithmetic to a program             segments, loops over nodes, fused products
//! emit       program to source                   functions, documentation, operation counts; C
//! contact    our kernels as clients of emit      names, types of support, one syn::File
//! config     syn::File to a file                 the build API, the only place with input and output
//! interpret  the graph in numbers                second witness of every kernel, of own elements also the third
//! ```
//!
//! # How it works
//!
//! `docs/equations.md` derives what the contact element needs: the rule for second derivatives (5), the two choices that keep it cheap (6, 7),
//! the slave's rows (8), weights at r = 0, at r = 1 and at their poles (9), the co-moving frame (13), and the facets (16).
//!
//! **Types.** `ExprId`, `SymbolId`, `SystemId`, `SolveId` and `RootId` index arenas of one `Graph`. An expression has a `Scope`: `Element`
//! (one value) or `Node` (one per master node). `Op::Sum` leads from `Node` to `Element`.
//!
//! **Symbols** are inputs, or *bound* to an expression. A bound symbol (a, b, z, α, λ, the foot) has its definition's value, but is a
//! variable of its own for differentiation. So the structured rules, not the generic chain rule, differentiate through definitions: they
//! know which blocks are zero, symmetric or of low rank. Zeros follow from simplification; nothing is special-cased.
//!
//! **Structured nodes.** `Op::Sum`, `Op::Solution` (symmetric system, L S Lᵀ with signs S known beforehand) and `Op::RootValue` (small
//! system solved by iteration) have rules of their own in `graph/derivative.rs`. The last two use the implicit function theorem.
//!
//! **Elements of the caller's** (`kernel/element.rs`) have a signature: typed inputs, which are variables or parameters, and values, of which
//! it says how often they are differentiated. An energy depends on its variables through few quantities, such as a deformation gradient F
//! and det F. `structure/intermediates.rs` finds those that are not named, `structure/chain.rs` differentiates through all, and
//! `structure/invariance.rs` takes the way with the fewest operations. `emit/fixed.rs` writes them, `emit/c/`
//! writes C.
//!
//! **Products with a vector** need no rules of their own. `structure/direction.rs` gives each variable a rate and lets the engine
//! differentiate the gradient by all of them at once: forward over reverse. Each such kernel is one more function of the same signature.
//!
//! **Nodes of an open number** in elements of the caller's: a function depends on them through sums, and through unknowns of equations that
//! are linear in sums. `structure/node_sums.rs` eliminates one after the other and leaves a Hessian of low rank. `emit/node_loop.rs` writes
//! the loops, those of the contact kernels too. `contact/elements.rs` gives the contact kernels the signature that C is written from.
//!
//! **Program.** A level is a straight-line segment and a loop over the nodes; a value's level is the number of such loops that must run
//! before. Values of nodes that later loops need are kept in an array per node. A Hessian leaves the program as the rows of its low-rank
//! form and the nodes' own blocks; `support/form.rs` of the kernels multiplies them.
#![forbid(unsafe_code)]

pub mod config;
pub mod contact;
pub mod emit;
pub mod expr;
pub mod formula;
pub mod graph;
pub mod interpret;
pub mod kernel;
pub mod lower;
pub mod model;
pub mod schedule;
pub mod structure;
mod table;

pub use config::{Config, ConfigError};
pub use expr::{Expr, Sheet};
pub use graph::{Limits, Polynomial};
pub use kernel::{Defined, ElementError, ElementKernels, ElementModel, Kernel, Mode, NodeResult, Stationary};
pub use model::{
    Basis, BasisError, CustomBasis, FacetShape, FrameRule, KernelSpec, Output, Weight, WeightError,
    WeightNote,
};

/// The examples of the README, which are run with the documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
