//! The library as its users have it: built with optimisation, installed, found by pkg-config, linked from C and Fortran.
//!
//! ```text
//! cargo build --release -p diffuse-contact-capi
//! DIFFUSE_CONTACT_BUILT=$PWD/target/release cargo test --release -p diffuse-contact-capi --test installed
//! ```

mod c_program;
mod documented;
mod fortran;
mod support;
