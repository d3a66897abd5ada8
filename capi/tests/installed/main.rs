//! The library as its users have it: installed, found by pkg-config, linked from C and Fortran.

mod c_program;
mod documented;
mod fortran;
mod support;
