//! Vectors of x86-64, and code compiled for them.

use std::arch::x86_64::*;

use super::*;

/// Features, whether the machine has all of them, and a method of all types that runs code compiled for them.
macro_rules! compiled_for {
    ($trait:ident, $has:ident, $run:ident: $($feature:tt),+) => {
        #[doc = concat!("Whether the machine has", $(" ", $feature),+, ".")]
        pub fn $has() -> bool {
            $(is_x86_feature_detected!($feature))&&+
        }

        /// Runs code with these instructions, compiled beside the type.
        pub trait $trait {
            /// # Safety
            /// The machine has the instructions.
            unsafe fn $run<T: Vector, W: WithLanes>(code: W) -> W::Output;
        }

        impl<P> $trait for P {
            $(#[target_feature(enable = $feature)])+
            unsafe fn $run<T: Vector, W: WithLanes>(code: W) -> W::Output {
                code.run::<T>()
            }
        }
    };
}
compiled_for!(Avx2, has_avx2, run_avx2: "avx2", "fma");
#[cfg(feature = "avx512")]
compiled_for!(Avx512, has_avx512, run_avx512: "avx512f", "avx512dq", "avx512vl", "avx2", "fma");

/// One number, with fused multiply-adds.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Fused(f64);

impl sealed::Sealed for Fused {}

macro_rules! fused_operators {
    ($($trait:ident $method:ident $operator:tt),*) => {
        $(impl $trait for Fused {
            type Output = Self;
            #[inline]
            fn $method(self, other: Self) -> Self {
                Self(self.0 $operator other.0)
            }
        })*
    };
}
fused_operators!(Add add +, Sub sub -, Mul mul *, Div div /);

impl Neg for Fused {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Lane for Fused {
    const WIDTH: usize = 1;
    const ZERO: Self = Self(0.0);
    const ONE: Self = Self(1.0);

    #[inline]
    fn splat(value: f64) -> Self {
        Self(value)
    }

    #[inline(always)]
    fn from_fn(mut value: impl FnMut(usize) -> f64) -> Self {
        Self(value(0))
    }

    #[inline(always)]
    fn lane(&self, k: usize) -> f64 {
        self.0.lane(k)
    }

    #[inline]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        Self(f64::mul_add(self.0, factor.0, term.0))
    }

    #[inline]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    #[inline(always)]
    fn exp(self) -> Self {
        Self(self.0.exp())
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }

    #[inline(always)]
    fn select_less(x: Self, y: Self, then: Self, otherwise: Self) -> Self {
        if x.0 < y.0 { then } else { otherwise }
    }

    #[inline(always)]
    fn all_less(x: Self, y: Self) -> bool {
        x.0 < y.0
    }
}

impl Vector for Fused {
    type Scalar = Self;

    #[inline(always)]
    fn sum(self) -> f64 {
        self.0
    }

    stores_by_number!();
}

// SAFETY, of all below: the types exist only where the instructions do.

/// What F64x4 and F64x8 do by the same intrinsics of different width.
macro_rules! fused_lane_methods {
    ($splat:ident, $mul_add:ident, $mul_sub:ident, $neg_mul_add:ident, $sqrt:ident) => {
        #[inline]
        fn splat(value: f64) -> Self {
            Self(unsafe { $splat(value) })
        }

        #[inline]
        fn mul_add(self, factor: Self, term: Self) -> Self {
            Self(unsafe { $mul_add(self.0, factor.0, term.0) })
        }

        #[inline]
        fn mul_sub(self, factor: Self, term: Self) -> Self {
            Self(unsafe { $mul_sub(self.0, factor.0, term.0) })
        }

        #[inline]
        fn neg_mul_add(self, factor: Self, term: Self) -> Self {
            Self(unsafe { $neg_mul_add(self.0, factor.0, term.0) })
        }

        #[inline]
        fn sqrt(self) -> Self {
            Self(unsafe { $sqrt(self.0) })
        }
    };
}

/// [`Vector::store_transposed`] for vectors with a function `transposed`: squares of numbers, then what is left over.
macro_rules! stores_by_squares {
    () => {
        #[inline(always)]
        fn store_transposed<O>(source: &[Self], outputs: &mut [O], target: impl Fn(&mut O) -> &mut [f64]) {
            let (squares, rest) = source.as_chunks::<{ Self::WIDTH }>();
            let targets = places::<O, _, { Self::WIDTH }>(source.len(), outputs, &target);
            for (k, square) in squares.iter().enumerate() {
                let columns = Self::transposed(*square);
                for lane in 0..outputs.len() {
                    // SAFETY: vectors of plain numbers, and each target has room for `source.len()` of them.
                    unsafe {
                        targets[lane].add(k * Self::WIDTH).cast::<Self>().write_unaligned(columns[lane])
                    };
                }
            }
            if !rest.is_empty() {
                let mut square = [Self::ZERO; Self::WIDTH];
                for k in 0..rest.len() {
                    square[k] = rest[k];
                }
                let columns = Self::transposed(square);
                for lane in 0..outputs.len() {
                    let end = &mut target(&mut outputs[lane])[Self::WIDTH * squares.len()..source.len()];
                    columns[lane].store_first(end);
                }
            }
        }
    };
}

mod avx2;
#[cfg(feature = "avx512")]
mod avx512;

pub use avx2::F64x4;
#[cfg(feature = "avx512")]
pub use avx512::F64x8;

/// Where each output's target begins.
///
/// # Panics
/// If one is shorter than `length`, or there are more than `WIDTH`.
#[inline(always)]
fn places<O, F: Fn(&mut O) -> &mut [f64], const WIDTH: usize>(
    length: usize,
    outputs: &mut [O],
    target: &F,
) -> [*mut f64; WIDTH] {
    let mut places = [std::ptr::null_mut(); WIDTH];
    assert!(outputs.len() <= WIDTH, "{} outputs of {WIDTH} lanes", outputs.len());
    for lane in 0..outputs.len() {
        places[lane] = target(&mut outputs[lane])[..length].as_mut_ptr();
    }
    places
}
