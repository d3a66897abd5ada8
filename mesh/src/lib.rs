//! Finite element meshes for contact: readers for Gmsh `.msh` 4.1 and Abaqus `.inp`, a writer for VTK `.vtu`.
//!
//! What this crate promises:
//!
//! * **A mesh that was read is sound.** Every coordinate is finite, every element refers to nodes that exist
//!   and to no node twice, tags are unique, and every index in a set is in range. Whoever holds a [`Mesh`] may
//!   index without checking.
//! * **Bad input is an error, never a panic** and never a huge allocation: counts in a file's header are not
//!   trusted. A [`MeshError`] names the file, the line (or the byte, in a binary file) and what was found.
//! * **Nothing is guessed.** What the readers do not support (pyramids, elements of third order, coordinate systems, partitioned meshes) is
//!   refused by name; in an Abaqus file, which may hold much that nobody asks for, elements that are not supported are refused when
//!   a set with one of them is asked for. What cannot matter here (materials, steps, post-processing sections) is skipped.
//! * **Orientation is kept.** A [`Facet`] lists its nodes so that the right-hand rule gives its normal: as Gmsh
//!   or Abaqus orders them, reversed for `SNEG` and for negative physical tags, outward for faces of solids.
//! * **A written file is whole.** [`VtuFile::write`] fills a temporary file and renames it.
//!
//! The crate knows nothing of contact: it has no geometry beyond coordinates, and changes no mesh.
//!
//! ```no_run
//! use diffuse_contact_mesh::{Mesh, VtuFile};
//!
//! let mesh = Mesh::read("plate_on_cylinder.msh")?;
//! let master = mesh.facets("master")?;
//! let heights: Vec<f64> = mesh.nodes().iter().map(|node| node[2]).collect();
//! VtuFile::new()
//!     .points(mesh.nodes())
//!     .cells(&master)
//!     .point_scalars("height", &heights)
//!     .write("master.vtu")?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]

mod abaqus;
mod builder;
mod element;
mod error;
pub mod file;
mod gmsh;
mod mesh;
pub mod names;
mod read;
pub mod vtu;

pub use element::{Cell, Element, ElementKind, Facet};
pub use error::{MeshError, Place, Problem, advice_on};
pub use mesh::{Mesh, UnreadConstraint, UnreadElement};
pub use vtu::{VtuError, VtuFile};

/// A mesh to try things with, the bytes of `meshes/plate_on_cylinder.msh` in this crate's folder: a plate (the set `slave`) close
/// to a cylinder (`master`).
pub const PLATE_ON_CYLINDER: &[u8] = include_bytes!("../meshes/plate_on_cylinder.msh");

/// The examples of the README, which are run with the documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
