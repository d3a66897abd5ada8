//! The C library of the diffuse contact element.
//!
//! A thin layer over the crate `diffuse-contact`: pointers become slices, errors a status, panics stop here. Its
//! documentation for users is the header `include/diffuse_contact.h`, which cbindgen makes of the doc comments in this
//! crate, and `docs/integrate.md`.
//!
//! | module | what is in it |
//! | --- | --- |
//! | `border` | pointers to slices, panics to a status: the unsafe code |
//! | `status`, `message`, `outcome` | what a call says |
//! | `registry` | which handles are live |
//! | `version` | version, vector instructions |
//! | `threads` | where evaluations run, also after a fork |
//! | `options`, `law` | structures the caller fills |
//! | `interface` | create and destroy, update, refresh, freeze, evaluate |
//! | `contacts`, `cutback` | results of an evaluation, the cut-back hint |
//! | `assembly`, `pattern` | residual, triplets, compressed rows |
//! | `element`, `batch`, `neighbours` | without interface: gap, force and stiffness, pairing |
// The names are those of the C interface.
#![allow(non_camel_case_types)]

mod assembly;
mod batch;
mod border;
mod choice;
mod contacts;
mod cutback;
mod element;
mod interface;
mod law;
mod message;
mod neighbours;
mod options;
mod outcome;
mod pattern;
mod registry;
mod status;
mod threads;
mod version;

#[cfg(test)]
mod tests;
