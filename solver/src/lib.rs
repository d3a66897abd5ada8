//! Finite-strain statics of solids in contact: the diffuse contact element inside an implicit finite element code.
//!
//! A deck, a text in TOML, states a problem; [`solve`] runs it. The library does without the program:
//!
//! ```
//! use diffuse_contact_solver::deck::Deck;
//! use std::path::Path;
//!
//! let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
//! let deck = Deck::read(&examples.join("patch_test.toml"))?;
//! let model = deck.model(&examples)?;
//! assert_eq!(model.bodies.len(), 2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Data flow
//!
//! ```text
//! deck/       TOML text → Deck, every field checked                       a misspelt field names the nearest one
//!    │
//! model/      Deck → Model: nodes, bodies, node sets, surfaces            parametric shapes and mesh files; sound, as a Mesh is
//!    │
//! solid/      positions, states → element forces, tangents, new states    tetrahedra, wedges, hexahedra; material/ is called per point
//! contact/    positions → contact forces and tangents                     a Pass over nodes or faces; penalty, augmented Lagrangian, friction
//!    │
//! system/     blocks → sparse matrix → solution                           node-block pattern; faer's factors, or Krylov's methods with multigrid/
//!    │
//! statics/    increments, Newton, line search, cut-back, loose parts      knows nothing of files
//!    │
//! output/     a finished increment → history.csv, VTU, restart, summary   a file is whole or not there
//! report/     results on disk → report.html
//! ```
//!
//! # What holds
//!
//! * **Unknowns** are displacements of nodes, three each. A node of no body is part of a rigid surface and has all of them prescribed.
//!   Prescribed positions are functions of time (`Motion`: translation, rotation about an axis), so that a rotation is exact. The full
//!   matrix over all nodes is assembled in blocks of 3 × 3; the free part is factorised. The rest predicts what the prescribed motion of an
//!   increment does to the free nodes.
//! * **Solid.** Volumetric and isochoric parts are uncoupled. The material is Hencky's, Kirchhoff stress over logarithmic strains, or
//!   neo-Hooke. Hencky's may yield: J2 plasticity is multiplicative with linear isotropic hardening, and the return mapping is radial in
//!   principal logarithmic strains. Neo-Hooke elasticity and both volumetric parts are generated from their energies. Derivatives of
//!   the return mapping and of the elements are written by hand; tests compare them with differences.
//! * **Increments** end at the points of all amplitudes. `solve::statics` puts a deck's problem, its settings and these points together.
//! * **Contact's tangent** is chosen when it is assembled, by the relative residual of the evaluation (`TangentRule`). A contact's force and
//!   Hessian come from one evaluation either way.
//! * **System.** The symmetric factorisation L B Lᵀ pivots within supernodes only. Its failures show in a lost pivot or in the residual,
//!   which every solution is checked by; then L U is used. Every factorisation that is kept looks for the direction that the scaled
//!   matrix makes least of, by up to three steps of inverse iteration. The matrix is singular at 2e-15 or below (`docs/solver.md`).
//! * **State.** All history lies in `State`: positions, with `extrapolation` those before, plastic states, multipliers, the history of
//!   friction, counters, and which slaves carry force. Pairings are none of it: they follow from the positions. A failed increment leaves
//!   the state untouched but for the count of iterations. A restart leads to the same end, bit for bit.
//! * **Files.** The recorder observes a run and writes to a `Directory`, whose files are replaced as a whole and whose tables grow by whole
//!   lines. `state.json` comes last: an increment that it counts is on disk. The report is made from what is on disk, by the same code for
//!   one run and for several.

#![forbid(unsafe_code)]

pub mod contact;
pub mod deck;
mod distinct;
pub mod material;
pub mod model;
mod named;
pub mod output;
pub mod report;
pub mod solid;
pub mod solve;
pub mod statics;
pub mod system;
pub mod verification;

/// The examples of the README, which are run with the documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
