//! Generated kernels of the 3D diffuse contact element.
//!
//! Nothing in here but [`support`] is written by hand: the build script generates the rest from the formulas in
//! `diffuse-contact-codegen`. For every weight there is a module with the kernels of both bases, and a
//! [`support::KernelSet`] that chooses among them by basis, frame rule and mode. The module `facet` has the
//! distance from a facet itself, a triangle or a quadrilateral.
#![deny(unsafe_code)]

pub mod support;

include!(concat!(env!("OUT_DIR"), "/diffuse_contact_kernels.rs"));
