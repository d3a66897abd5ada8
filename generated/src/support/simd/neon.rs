//! Vectors of aarch64.

use std::arch::aarch64::*;

use super::*;

/// Two numbers.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct F64x2(float64x2_t);

impl sealed::Sealed for F64x2 {}

operators!(F64x2, Add add vaddq_f64, Sub sub vsubq_f64, Mul mul vmulq_f64, Div div vdivq_f64);

// SAFETY, of all below: every machine of this architecture has the instructions.

impl Neg for F64x2 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(unsafe { vnegq_f64(self.0) })
    }
}

impl Lane for F64x2 {
    common_lane_methods!(float64x2_t, 2);

    #[inline]
    fn splat(value: f64) -> Self {
        Self(unsafe { vdupq_n_f64(value) })
    }

    #[inline]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        Self(unsafe { vfmaq_f64(term.0, self.0, factor.0) })
    }

    #[inline]
    fn neg_mul_add(self, factor: Self, term: Self) -> Self {
        Self(unsafe { vfmsq_f64(term.0, self.0, factor.0) })
    }

    #[inline]
    fn sqrt(self) -> Self {
        Self(unsafe { vsqrtq_f64(self.0) })
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { vabsq_f64(self.0) })
    }

    #[inline(always)]
    fn select_less(x: Self, y: Self, then: Self, otherwise: Self) -> Self {
        Self(unsafe { vbslq_f64(vcltq_f64(x.0, y.0), then.0, otherwise.0) })
    }

    #[inline(always)]
    fn all_less(x: Self, y: Self) -> bool {
        let less = unsafe { vcltq_f64(x.0, y.0) };
        unsafe { vgetq_lane_u64::<0>(less) & vgetq_lane_u64::<1>(less) != 0 }
    }
}

impl Vector for F64x2 {
    type Scalar = f64;

    #[inline(always)]
    fn sum(self) -> f64 {
        self.lane(0) + self.lane(1)
    }

    stores_by_number!();
}
