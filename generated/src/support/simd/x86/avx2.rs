//! Four numbers.

use super::*;

/// Four numbers.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct F64x4(pub(super) __m256d);

impl sealed::Sealed for F64x4 {}

operators!(F64x4, Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd, Div div _mm256_div_pd);

impl Neg for F64x4 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(unsafe { _mm256_xor_pd(self.0, _mm256_set1_pd(-0.0)) })
    }
}

impl Lane for F64x4 {
    common_lane_methods!(__m256d, 4);

    fused_lane_methods!(_mm256_set1_pd, _mm256_fmadd_pd, _mm256_fmsub_pd, _mm256_fnmadd_pd, _mm256_sqrt_pd);

    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
    }

    #[inline(always)]
    fn select_less(x: Self, y: Self, then: Self, otherwise: Self) -> Self {
        Self(unsafe { _mm256_blendv_pd(otherwise.0, then.0, _mm256_cmp_pd::<_CMP_LT_OQ>(x.0, y.0)) })
    }

    #[inline(always)]
    fn all_less(x: Self, y: Self) -> bool {
        unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(x.0, y.0)) == 0b1111 }
    }
}

impl F64x4 {
    /// Rows become columns.
    #[inline(always)]
    fn transposed(rows: [Self; 4]) -> [Self; 4] {
        let [Self(a), Self(b), Self(c), Self(d)] = rows;
        unsafe {
            let (ab_even, ab_odd) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
            let (cd_even, cd_odd) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
            [
                Self(_mm256_permute2f128_pd::<0x20>(ab_even, cd_even)),
                Self(_mm256_permute2f128_pd::<0x20>(ab_odd, cd_odd)),
                Self(_mm256_permute2f128_pd::<0x31>(ab_even, cd_even)),
                Self(_mm256_permute2f128_pd::<0x31>(ab_odd, cd_odd)),
            ]
        }
    }

    /// Stores the first numbers, as many as fit.
    #[inline(always)]
    fn store_first(self, target: &mut [f64]) {
        if target.len() >= 4 {
            // SAFETY: there is room for four.
            unsafe { _mm256_storeu_pd(target.as_mut_ptr(), self.0) };
        } else {
            // SAFETY: the mask ends where the target does.
            unsafe {
                let places = _mm256_set_epi64x(3, 2, 1, 0);
                let length = _mm256_set1_epi64x(target.len() as i64);
                let mask = _mm256_cmpgt_epi64(length, places);
                _mm256_maskstore_pd(target.as_mut_ptr(), mask, self.0);
            }
        }
    }
}

impl Vector for F64x4 {
    type Scalar = Fused;

    #[inline(always)]
    fn sum(self) -> f64 {
        unsafe {
            let halves = _mm_add_pd(_mm256_castpd256_pd128(self.0), _mm256_extractf128_pd::<1>(self.0));
            _mm_cvtsd_f64(_mm_add_sd(halves, _mm_unpackhi_pd(halves, halves)))
        }
    }

    #[inline(always)]
    fn sums(vectors: [Self; 4]) -> [f64; 4] {
        let [Self(a), Self(b), Self(c), Self(d)] = vectors;
        let sums = unsafe {
            let (ab, cd) = (_mm256_hadd_pd(a, b), _mm256_hadd_pd(c, d));
            Self(_mm256_add_pd(_mm256_permute2f128_pd::<0x21>(ab, cd), _mm256_blend_pd::<0b1100>(ab, cd)))
        };
        [sums.lane(0), sums.lane(1), sums.lane(2), sums.lane(3)]
    }

    #[inline(always)]
    fn store_interleaved(values: [Self; 3], target: &mut [f64]) {
        assert!(target.len() <= 3 * Self::WIDTH);
        let [Self(x), Self(y), Self(z)] = values;
        let interleaved = unsafe {
            // x0 y0 x2 y2, z0 x1 z2 x3, y1 z1 y3 z3
            let xy = _mm256_unpacklo_pd(x, y);
            let zx = _mm256_shuffle_pd::<0b1010>(z, x);
            let yz = _mm256_unpackhi_pd(y, z);
            [
                Self(_mm256_permute2f128_pd::<0x20>(xy, zx)),
                Self(_mm256_permute2f128_pd::<0x30>(yz, xy)),
                Self(_mm256_permute2f128_pd::<0x31>(zx, yz)),
            ]
        };
        for (k, vector) in interleaved.into_iter().enumerate() {
            if let Some(rest) = target.get_mut(4 * k..) {
                vector.store_first(rest);
            }
        }
    }

    #[inline(always)]
    unsafe fn store_fours(source: [Self; 4], targets: &[*mut f64], places: &[u32; MOST_LANES]) {
        let fours = Self::transposed(source);
        // By constant numbers of lanes, or the fours would go by way of memory.
        for lane in 0..Self::WIDTH {
            if lane < targets.len() {
                // SAFETY: as the caller says.
                unsafe { _mm256_storeu_pd(targets[lane].add(places[lane] as usize), fours[lane].0) };
            }
        }
    }

    #[inline(always)]
    unsafe fn store_threes(source: [Self; 3], targets: &[*mut f64], places: &[u32; MOST_LANES]) {
        let [x, y, z] = source;
        let fours = Self::transposed([x, y, z, Self::ZERO]);
        for lane in 0..targets.len() {
            // SAFETY: as the caller says.
            unsafe {
                let (target, Self(four)) = (targets[lane].add(places[lane] as usize), fours[lane]);
                _mm_storeu_pd(target, _mm256_castpd256_pd128(four));
                _mm_store_sd(target.add(2), _mm256_extractf128_pd::<1>(four));
            }
        }
    }

    stores_by_squares!();
}
