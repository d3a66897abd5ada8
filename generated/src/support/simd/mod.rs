//! Vectors of numbers, and code compiled for the machine's vector instructions: the one module with unsafe code.
//!
//! Safety rests on two things. The vector types are not public: code gets hold of them only as the type parameter of
//! [`WithLanes::run`], which [`Isa::run`] calls, and an [`Isa`] exists only where its instructions do: only this module
//! can make one, and it asks the machine. And each type is a vector of plain numbers, for which any content is valid.
#![allow(unsafe_code)]

use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};
use std::sync::OnceLock;

use super::Lane;

pub(super) use spread::{Placed, Spread};

/// Numbers in the widest vector.
pub(super) const MOST_LANES: usize = 8;

/// Code that is generic over the vector it computes with.
pub trait WithLanes {
    /// What it returns.
    type Output;

    /// Runs it. To be marked `#[inline(always)]`, and so everything it calls that computes with `T`: only what is
    /// inlined is compiled for the instruction set. Single operations are `#[inline]`: always inlined, too, as they are one
    /// instruction each, and later, when the compiler has reduced them to it. That takes less of its time.
    fn run<T: Vector>(self) -> Self::Output;
}

/// A vector of plain numbers of the machine.
pub trait Vector: Lane + sealed::Sealed {
    /// One number, with the same instructions.
    type Scalar: Vector;

    /// The sum of the lanes.
    fn sum(self) -> f64;

    /// The sum of the lanes of each.
    #[inline(always)]
    fn sums(vectors: [Self; 4]) -> [f64; 4] {
        let [a, b, c, d] = vectors;
        [a.sum(), b.sum(), c.sum(), d.sum()]
    }

    /// The vectors as numbers.
    #[inline(always)]
    fn numbers(vectors: &mut [Self]) -> &mut [f64] {
        const { assert!(size_of::<Self>() == 8 * Self::WIDTH && align_of::<Self>() >= align_of::<f64>()) };
        let count = vectors.len() * Self::WIDTH;
        // SAFETY: size and alignment fit (above), and a vector is plain numbers.
        unsafe { std::slice::from_raw_parts_mut(vectors.as_mut_ptr().cast::<f64>(), count) }
    }

    /// The numbers from `place` on.
    ///
    /// # Panics
    /// If there are too few.
    #[inline(always)]
    fn load(source: &[f64], place: usize) -> Self {
        let numbers = &source[place..place + Self::WIDTH];
        // SAFETY: there are as many as in a vector (above), which is plain numbers.
        unsafe { numbers.as_ptr().cast::<Self>().read_unaligned() }
    }

    /// Writes the numbers from `place` on.
    ///
    /// # Panics
    /// If there is no room.
    #[inline(always)]
    fn store(self, target: &mut [f64], place: usize) {
        let numbers = &mut target[place..place + Self::WIDTH];
        // SAFETY: there are as many as in a vector (above), which is plain numbers.
        unsafe { numbers.as_mut_ptr().cast::<Self>().write_unaligned(self) };
    }

    /// Writes lane 0 of the three vectors, then lane 1, …, as far as `target` goes.
    ///
    /// # Panics
    /// If `target` is longer than the three vectors.
    fn store_interleaved(values: [Self; 3], target: &mut [f64]);

    /// Writes lane l of the four vectors, one after another, to the l-th target from the l-th place on.
    ///
    /// # Safety
    /// There is room for four numbers there, and there are no more targets than lanes and places.
    unsafe fn store_fours(source: [Self; 4], targets: &[*mut f64], places: &[u32; MOST_LANES]);

    /// The same of three vectors and numbers.
    ///
    /// # Safety
    /// There is room for three numbers there, and there are no more targets than lanes and places.
    #[inline(always)]
    unsafe fn store_threes(source: [Self; 3], targets: &[*mut f64], places: &[u32; MOST_LANES]) {
        // SAFETY: as the caller says.
        unsafe { by_number(&source, targets, places) };
    }

    /// Writes lane l of the k-th vector to place k of the l-th target.
    ///
    /// # Panics
    /// If a target is shorter than `source`, or there are more targets than lanes.
    fn store_transposed<O>(source: &[Self], outputs: &mut [O], target: impl Fn(&mut O) -> &mut [f64]);
}

mod sealed {
    pub trait Sealed {}
}

/// A set of vector instructions that this machine has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Isa(Kind);

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
enum Kind {
    Scalar,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(all(target_arch = "x86_64", feature = "avx512"))]
    Avx512,
    #[cfg(target_arch = "aarch64")]
    Neon,
}

/// What [`Isa::best`] returns from its first call on.
static BEST: OnceLock<Isa> = OnceLock::new();
/// Names the instructions to use, for instance under a tool that does not know all of them.
const VARIABLE: &str = "DIFFUSE_CONTACT_ISA";

impl Isa {
    /// One number at a time: on every machine.
    pub const SCALAR: Self = Self(Kind::Scalar);

    /// All that this machine has and this crate is compiled for, the widest last.
    pub fn available() -> impl DoubleEndedIterator<Item = Self> {
        #[cfg(target_arch = "x86_64")]
        let kinds = [
            (Kind::Scalar, true),
            (Kind::Avx2, x86::has_avx2()),
            #[cfg(feature = "avx512")]
            (Kind::Avx512, x86::has_avx512()),
        ];
        #[cfg(target_arch = "aarch64")]
        let kinds = [(Kind::Scalar, true), (Kind::Neon, true)];
        #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
        let kinds = [(Kind::Scalar, true)];
        kinds.into_iter().filter(|(_, is_there)| *is_there).map(|(kind, _)| Self(kind))
    }

    /// The widest of the [available](Self::available), unless [`prefer`](Self::prefer) or the environment variable
    /// `DIFFUSE_CONTACT_ISA`, read once, names another one that it has; one that it has not is told on the standard error stream. Where this crate is compiled without
    /// optimisation, one number at a time: its kernels are compiled for nothing else there. Kernels of a crate of one's own may be
    /// compiled otherwise than this one:
    /// [`KernelSet::best_isa`](super::KernelSet::best_isa).
    pub fn best() -> Self {
        if cfg!(unoptimised) {
            return Self::SCALAR;
        }
        *BEST.get_or_init(|| {
            let widest = Self::available().next_back().unwrap_or(Self::SCALAR);
            let Ok(name) = std::env::var(VARIABLE) else { return widest };
            Self::named(&name).unwrap_or_else(|| {
                // Results would differ by rounding from those that were asked for.
                eprintln!(
                    "{VARIABLE}={name} is not among this machine's instructions: {} are used",
                    widest.name()
                );
                widest
            })
        })
    }

    /// Makes these instructions the [`best`](Self::best), for the whole process.
    ///
    /// # Errors
    /// The best, if it is another one and has been asked for before: all results of one process are made with the same
    /// instructions.
    pub fn prefer(self) -> Result<(), Self> {
        let best = if cfg!(unoptimised) { Self::SCALAR } else { *BEST.get_or_init(|| self) };
        if best == self { Ok(()) } else { Err(best) }
    }

    /// The one of this name, if it is [available](Self::available).
    pub fn named(name: &str) -> Option<Self> {
        Self::available().find(|isa| isa.name() == name)
    }

    /// `scalar`, `avx2`, `avx512` or `neon`.
    pub const fn name(self) -> &'static str {
        match self.0 {
            Kind::Scalar => "scalar",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => "avx2",
            #[cfg(all(target_arch = "x86_64", feature = "avx512"))]
            Kind::Avx512 => "avx512",
            #[cfg(target_arch = "aarch64")]
            Kind::Neon => "neon",
        }
    }

    /// Numbers in a vector.
    pub const fn width(self) -> usize {
        match self.0 {
            Kind::Scalar => 1,
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => 4,
            #[cfg(all(target_arch = "x86_64", feature = "avx512"))]
            Kind::Avx512 => 8,
            #[cfg(target_arch = "aarch64")]
            Kind::Neon => 2,
        }
    }

    /// Runs code compiled for these instructions.
    #[inline]
    pub fn run<W: WithLanes>(self, code: W) -> W::Output {
        self.run_vectors(code).unwrap_or_else(|code| code.run::<f64>())
    }

    /// As [`run`](Self::run), or the code back if there are no vectors.
    #[inline]
    pub fn run_vectors<W: WithLanes>(self, code: W) -> Result<W::Output, W> {
        self.run_vectors_beside::<W, W>(code)
    }

    /// Runs code with vectors of four numbers; if there are none (on aarch64, of two), it comes back.
    #[inline]
    pub fn run_four<W: WithLanes>(self, code: W) -> Result<W::Output, W> {
        self.run_four_beside::<W, W>(code)
    }

    /// [`run_vectors`](Self::run_vectors) with code that rustc puts into the part of the crate that the module of `P` is in. All that a
    /// function becomes for many types is in one part, which takes long to compile; methods of types are where their types are.
    #[inline]
    pub(super) fn run_vectors_beside<P, W: WithLanes>(self, code: W) -> Result<W::Output, W> {
        match self.0 {
            // SAFETY: an `Isa` exists only where its instructions do.
            #[cfg(all(target_arch = "x86_64", feature = "avx512"))]
            Kind::Avx512 => Ok(unsafe { <P as x86::Avx512>::run_avx512::<x86::F64x8, W>(code) }),
            _ => self.run_four_beside::<P, W>(code),
        }
    }

    /// The same of [`run_four`](Self::run_four).
    #[inline]
    pub(super) fn run_four_beside<P, W: WithLanes>(self, code: W) -> Result<W::Output, W> {
        match self.0 {
            Kind::Scalar => Err(code),
            // SAFETY: an `Isa` exists only where its instructions do, and those of four numbers are among them.
            #[cfg(all(target_arch = "x86_64", feature = "avx512"))]
            Kind::Avx512 => Ok(unsafe { <P as x86::Avx2>::run_avx2::<x86::F64x4, W>(code) }),
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => Ok(unsafe { <P as x86::Avx2>::run_avx2::<x86::F64x4, W>(code) }),
            #[cfg(target_arch = "aarch64")]
            Kind::Neon => Ok(code.run::<neon::F64x2>()),
        }
    }
}

/// Runs code number by number, compiled in the module of the type, as [`Isa::run_vectors_beside`].
pub(super) trait ByNumber {
    #[inline(never)]
    fn run_by_number<W: WithLanes>(code: W) -> W::Output {
        code.run::<f64>()
    }
}

impl<P> ByNumber for P {}

impl Default for Isa {
    fn default() -> Self {
        Self::best()
    }
}

impl fmt::Display for Isa {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Memory for vectors of any width.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Block([f64; 8]);

impl Block {
    /// Zeros.
    pub const ZERO: Self = Self([0.0; 8]);

    /// Blocks that hold `count` vectors.
    pub const fn count<T: Lane>(count: usize) -> usize {
        (count * T::WIDTH).div_ceil(8)
    }

    /// The blocks as vectors.
    pub fn vectors<T: Vector>(blocks: &mut [Self]) -> &mut [T] {
        const { assert!(size_of::<T>() == 8 * T::WIDTH && align_of::<T>() <= 64 && 8 % T::WIDTH == 0) };
        let count = blocks.len() * (8 / T::WIDTH);
        // SAFETY: size and alignment fit (above), and any bits are a `T`, as it is a vector of `f64`.
        unsafe { std::slice::from_raw_parts_mut(blocks.as_mut_ptr().cast::<T>(), count) }
    }
}

impl sealed::Sealed for f64 {}

impl Vector for f64 {
    type Scalar = Self;

    #[inline(always)]
    fn sum(self) -> f64 {
        self
    }

    #[inline(always)]
    fn store_interleaved(values: [Self; 3], target: &mut [f64]) {
        assert!(target.len() <= 3);
        target.copy_from_slice(&values[..target.len()]);
    }

    #[inline(always)]
    unsafe fn store_fours(source: [Self; 4], targets: &[*mut f64], places: &[u32; MOST_LANES]) {
        // SAFETY: as the caller says.
        unsafe { by_number(&source, targets, places) };
    }

    #[inline(always)]
    fn store_transposed<O>(source: &[Self], outputs: &mut [O], target: impl Fn(&mut O) -> &mut [f64]) {
        assert!(outputs.len() <= 1);
        for output in outputs {
            target(output)[..source.len()].copy_from_slice(source);
        }
    }
}

/// Operators by their intrinsics.
macro_rules! operators {
    ($name:ident, $($trait:ident $method:ident $intrinsic:ident),*) => {
        $(impl $trait for $name {
            type Output = Self;
            #[inline]
            fn $method(self, other: Self) -> Self {
                // SAFETY: the type exists only where the instructions do.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        })*
    };
}

/// What all vectors of `$width` numbers have in common. `$expression`s may use the intrinsics.
macro_rules! common_lane_methods {
    ($vector:ident, $width:literal) => {
        const WIDTH: usize = $width;
        // SAFETY: of the same size, both plain numbers.
        const ZERO: Self = Self(unsafe { std::mem::transmute::<[f64; $width], $vector>([0.0; $width]) });
        const ONE: Self = Self(unsafe { std::mem::transmute::<[f64; $width], $vector>([1.0; $width]) });

        #[inline(always)]
        fn from_fn(mut value: impl FnMut(usize) -> f64) -> Self {
            // Not `std::array::from_fn`, which is not always inlined.
            let mut numbers = [0.0; $width];
            for (k, number) in numbers.iter_mut().enumerate() {
                *number = value(k);
            }
            // SAFETY: of the same size, both plain numbers.
            Self(unsafe { std::mem::transmute::<[f64; $width], $vector>(numbers) })
        }

        #[inline(always)]
        fn lane(&self, k: usize) -> f64 {
            // SAFETY: of the same size, both plain numbers; the array is not aligned more strictly.
            let numbers: &[f64; $width] = unsafe { &*std::ptr::from_ref(self).cast() };
            numbers[k]
        }

        #[inline(always)]
        fn exp(self) -> Self {
            Self::from_fn(|k| self.lane(k).exp())
        }
    };
}

/// [`Vector::store_fours`] and [`Vector::store_threes`] number by number.
///
/// # Safety
/// As there.
#[inline(always)]
unsafe fn by_number<T: Vector>(source: &[T], targets: &[*mut f64], places: &[u32; MOST_LANES]) {
    for lane in 0..targets.len() {
        for k in 0..source.len() {
            // SAFETY: as the caller says.
            unsafe { *targets[lane].add(places[lane] as usize + k) = source[k].lane(lane) };
        }
    }
}

/// What [`Vector`] stores number by number.
macro_rules! stores_by_number {
    () => {
        #[inline(always)]
        fn store_interleaved(values: [Self; 3], target: &mut [f64]) {
            assert!(target.len() <= 3 * Self::WIDTH);
            for (place, number) in target.iter_mut().enumerate() {
                *number = values[place % 3].lane(place / 3);
            }
        }

        #[inline(always)]
        unsafe fn store_fours(source: [Self; 4], targets: &[*mut f64], places: &[u32; MOST_LANES]) {
            // SAFETY: as the caller says.
            unsafe { by_number(&source, targets, places) };
        }

        #[inline(always)]
        fn store_transposed<O>(source: &[Self], outputs: &mut [O], target: impl Fn(&mut O) -> &mut [f64]) {
            assert!(outputs.len() <= Self::WIDTH);
            for lane in 0..outputs.len() {
                let target = &mut target(&mut outputs[lane])[..source.len()];
                for k in 0..source.len() {
                    target[k] = source[k].lane(lane);
                }
            }
        }
    };
}

#[cfg(target_arch = "aarch64")]
mod neon;
mod spread;
#[cfg(target_arch = "x86_64")]
mod x86;
