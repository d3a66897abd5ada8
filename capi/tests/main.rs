//! The header and the Fortran module beside the library. What is installed has tests of its own, see `installed`.

mod fortran_module;
mod header;
