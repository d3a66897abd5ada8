//! Generated kernels of the 3D diffuse contact element.
//!
//! Nothing in here but [`support`] is written by hand: the build script generates the rest from the formulas in
//! `diffuse-contact-codegen`. For every weight there is a module with the kernels of both bases, and a
//! [`support::KernelSet`] that chooses among them by basis, frame rule and mode. The modules `gap_over_triangle` and
//! `gap_over_quadrilateral` have the distance from a facet itself.
//!
//! Users call the kernels through `diffuse-contact`, or include those of a weight or an element of their own in their own crate. These need
//! [`support`] alone: without the feature `contact` no kernel is generated here. What users touch here is the choice of vector
//! instructions:
//!
//! ```
//! use diffuse_contact_kernels::support::Isa;
//!
//! assert!(Isa::available().any(|isa| isa.name() == "scalar"));
//! ```
//!
//! # What is emitted
//!
//! Per weight and basis, for {coefficients, surface, gap} × {value, gradient, hessian}, and for the gap with a co-moving frame
//! and with domains in the first configuration, with the feature `friction` for gap and slip:
//!
//! * `gap_hessian::<E, T, S: Shape<Element = E, Node = T>>(inputs, scratch, gradients, second)`: the kernel, once for any n, any
//!   number type and any layout of elements and nodes in vectors;
//! * `GapHessian: GapKernel`: the same as a type, which [`support`] runs;
//! * `KernelSet`: all of it for `f64` behind one trait, compiled in this crate. The kernels themselves are private.
//!
//! A value of a kernel is of element scope (`E`) or of node scope (`T`), and the `Shape` says how they relate:
//!
//! | shape | a lane of `E` is | a lane of `T` is | `KernelSet` | used for |
//! | --- | --- | --- | --- | --- |
//! | `Batch<T>` | an element | the same node of each element | `gap_batch` | many elements of one n |
//! | `Single<T>` | the one element (`E` has one lane) | a node | `gap` | one element |
//!
//! # Vector instructions
//!
//! `Isa` is a set of vector instructions that the machine has. `Isa::run` compiles a job, `WithLanes`, for each and runs the one asked for.
//! `support/simd/` is the one place with `unsafe`, and the one that can make an `Isa`, by asking the machine.
//!
//! | | scalar | AVX2 | AVX-512 | NEON |
//! | --- | --- | --- | --- | --- |
//! | single | 1 | 4 nodes | as AVX2 | 2 |
//! | batch, quadratic basis, fitting weight | 1 | 4 elements | 8 | 2 |
//! | batch, other bases, interpolating weight | 1 | 4 | as AVX2 | 2 |
//!
//! Batches for AVX-512 are compiled with the feature `avx512`, on by default; without it `Isa` has none of that name.
//! Processors of x86-64 without AVX2 and fused multiply-adds, most of them from before 2014, compute number by number.
//!
//! Other combinations were left out for compile time and size. A single element of 9 to 16 nodes
//! gains nothing from vectors of eight. For the same reason the cubic and the C² weight share kernels (`Config::share_kernels`): a choice
//! between two polynomials per node costs 0.8 % of the operations.
//!
//! * **Inlining.** Everything a job calls with vectors has to be inlined into it, or it is compiled for the baseline and passes vectors
//!   through memory. Kernels are `#[inline(always)]`, and `support` has loops where `array::map` or `array::from_fn`, which are not always
//!   inlined, would read better.
//! * **At optimisation level 0 or 1** a kernel is compiled once, for one element number by number: vectors take five times as long to compile and gain
//!   nothing. `KernelSet::best_isa` is scalar there: `Config::compile` notes Cargo's `OPT_LEVEL` in each `KernelSet`, as kernels of one's
//!   own weight are compiled in one's own crate.
//! * **Bits.** Neighbours in a batch make no difference to an element. Shapes and instructions differ by rounding.
//!
//! # Status
//!
//! Kernels never panic on numbers. The checksum contains every value and the slave's part of N, which is a sum over the masters'. Entries
//! of M, or its factors, are checked where they are written. That costs 2 to 4 % of the time.
//!
//! `golden/` holds one emitted text for review; a test keeps it fresh.
#![deny(unsafe_code)]

pub mod support;

// The tests of this crate are those of `support`; all others have the kernels to test.
#[cfg(all(feature = "contact", not(test)))]
include!(concat!(env!("OUT_DIR"), "/diffuse_contact_kernels.rs"));
