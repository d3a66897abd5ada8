//! Eight numbers.

use super::*;

/// Eight numbers.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct F64x8(__m512d);

impl sealed::Sealed for F64x8 {}

operators!(F64x8, Add add _mm512_add_pd, Sub sub _mm512_sub_pd, Mul mul _mm512_mul_pd, Div div _mm512_div_pd);

impl Neg for F64x8 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(unsafe { _mm512_xor_pd(self.0, _mm512_set1_pd(-0.0)) })
    }
}

impl Lane for F64x8 {
    common_lane_methods!(__m512d, 8);

    fused_lane_methods!(_mm512_set1_pd, _mm512_fmadd_pd, _mm512_fmsub_pd, _mm512_fnmadd_pd, _mm512_sqrt_pd);

    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm512_abs_pd(self.0) })
    }

    #[inline(always)]
    fn select_less(x: Self, y: Self, then: Self, otherwise: Self) -> Self {
        Self(unsafe {
            let less = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(x.0, y.0);
            _mm512_mask_blend_pd(less, otherwise.0, then.0)
        })
    }

    #[inline(always)]
    fn all_less(x: Self, y: Self) -> bool {
        unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(x.0, y.0) == 0xff }
    }
}

impl F64x8 {
    /// Rows become columns.
    #[inline(always)]
    fn transposed(rows: [Self; 8]) -> [Self; 8] {
        let [Self(r0), Self(r1), Self(r2), Self(r3), Self(r4), Self(r5), Self(r6), Self(r7)] = rows;
        unsafe {
            // Pairs of rows, then quarters of four rows, then halves of all.
            let pairs = [
                _mm512_unpacklo_pd(r0, r1),
                _mm512_unpackhi_pd(r0, r1),
                _mm512_unpacklo_pd(r2, r3),
                _mm512_unpackhi_pd(r2, r3),
                _mm512_unpacklo_pd(r4, r5),
                _mm512_unpackhi_pd(r4, r5),
                _mm512_unpacklo_pd(r6, r7),
                _mm512_unpackhi_pd(r6, r7),
            ];
            #[inline(always)]
            unsafe fn quarters(even: __m512d, odd: __m512d) -> (__m512d, __m512d) {
                unsafe { (_mm512_shuffle_f64x2::<0x88>(even, odd), _mm512_shuffle_f64x2::<0xdd>(even, odd)) }
            }
            // Columns 0 and 4, 2 and 6 of rows 0 … 3 or 4 … 7; then the odd ones.
            let (upper_04, upper_26) = quarters(pairs[0], pairs[2]);
            let (upper_15, upper_37) = quarters(pairs[1], pairs[3]);
            let (lower_04, lower_26) = quarters(pairs[4], pairs[6]);
            let (lower_15, lower_37) = quarters(pairs[5], pairs[7]);
            let (c0, c4) = quarters(upper_04, lower_04);
            let (c2, c6) = quarters(upper_26, lower_26);
            let (c1, c5) = quarters(upper_15, lower_15);
            let (c3, c7) = quarters(upper_37, lower_37);
            [Self(c0), Self(c1), Self(c2), Self(c3), Self(c4), Self(c5), Self(c6), Self(c7)]
        }
    }

    #[inline(always)]
    fn halves_added(self) -> F64x4 {
        F64x4(unsafe { _mm256_add_pd(_mm512_castpd512_pd256(self.0), _mm512_extractf64x4_pd::<1>(self.0)) })
    }

    /// The numbers of each lane.
    #[inline(always)]
    fn fours([Self(a), Self(b), Self(c), Self(d)]: [Self; 4]) -> [__m256d; 8] {
        // Lanes of one parity: 0 and 2, 4 and 6.
        #[inline(always)]
        unsafe fn pairs(ab: __m512d, cd: __m512d) -> (__m512d, __m512d) {
            unsafe {
                let low = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11);
                let high = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
                (_mm512_permutex2var_pd(ab, low, cd), _mm512_permutex2var_pd(ab, high, cd))
            }
        }
        unsafe {
            let (l02, l46) = pairs(_mm512_unpacklo_pd(a, b), _mm512_unpacklo_pd(c, d));
            let (l13, l57) = pairs(_mm512_unpackhi_pd(a, b), _mm512_unpackhi_pd(c, d));
            [
                _mm512_castpd512_pd256(l02),
                _mm512_castpd512_pd256(l13),
                _mm512_extractf64x4_pd::<1>(l02),
                _mm512_extractf64x4_pd::<1>(l13),
                _mm512_castpd512_pd256(l46),
                _mm512_castpd512_pd256(l57),
                _mm512_extractf64x4_pd::<1>(l46),
                _mm512_extractf64x4_pd::<1>(l57),
            ]
        }
    }

    /// Stores the first numbers, as many as fit.
    #[inline(always)]
    fn store_first(self, target: &mut [f64]) {
        let mask = if target.len() >= 8 { 0xff } else { (1u8 << target.len()) - 1 };
        // SAFETY: the mask ends where the target does.
        unsafe { _mm512_mask_storeu_pd(target.as_mut_ptr(), mask, self.0) };
    }
}

impl Vector for F64x8 {
    type Scalar = Fused;

    #[inline(always)]
    fn sum(self) -> f64 {
        self.halves_added().sum()
    }

    #[inline(always)]
    fn sums([a, b, c, d]: [Self; 4]) -> [f64; 4] {
        F64x4::sums([a.halves_added(), b.halves_added(), c.halves_added(), d.halves_added()])
    }

    #[inline(always)]
    fn store_interleaved(values: [Self; 3], target: &mut [f64]) {
        assert!(target.len() <= 3 * Self::WIDTH);
        let [Self(x), Self(y), Self(z)] = values;
        let interleaved = unsafe {
            // The k-th vector holds numbers 8k … 8k + 7 of x0 y0 z0 x1 …; from 8 on an index means the second operand.
            #[inline(always)]
            unsafe fn pick(k: [i64; 8]) -> __m512i {
                unsafe { _mm512_setr_epi64(k[0], k[1], k[2], k[3], k[4], k[5], k[6], k[7]) }
            }
            let first = _mm512_permutex2var_pd(x, pick([0, 8, 0, 1, 9, 0, 2, 10]), y);
            let second = _mm512_permutex2var_pd(x, pick([0, 3, 11, 0, 4, 12, 0, 5]), y);
            let third = _mm512_permutex2var_pd(x, pick([13, 0, 6, 14, 0, 7, 15, 0]), y);
            [
                Self(_mm512_permutex2var_pd(first, pick([0, 1, 8, 3, 4, 9, 6, 7]), z)),
                Self(_mm512_permutex2var_pd(second, pick([10, 1, 2, 11, 4, 5, 12, 7]), z)),
                Self(_mm512_permutex2var_pd(third, pick([0, 13, 2, 3, 14, 5, 6, 15]), z)),
            ]
        };
        for (k, vector) in interleaved.into_iter().enumerate() {
            if let Some(rest) = target.get_mut(8 * k..) {
                vector.store_first(rest);
            }
        }
    }

    #[inline(always)]
    unsafe fn store_fours(source: [Self; 4], targets: &[*mut f64], places: &[u32; MOST_LANES]) {
        let fours = Self::fours(source);
        // SAFETY: as the caller says.
        unsafe {
            if targets.len() == Self::WIDTH {
                for lane in 0..Self::WIDTH {
                    _mm256_storeu_pd(targets[lane].add(places[lane] as usize), fours[lane]);
                }
            } else {
                // By constant numbers of lanes, or the fours would go by way of memory for full vectors, too.
                for lane in 0..Self::WIDTH {
                    if lane < targets.len() {
                        _mm256_storeu_pd(targets[lane].add(places[lane] as usize), fours[lane]);
                    }
                }
            }
        }
    }

    #[inline(always)]
    unsafe fn store_threes(source: [Self; 3], targets: &[*mut f64], places: &[u32; MOST_LANES]) {
        let [x, y, z] = source;
        let fours = Self::fours([x, y, z, Self::ZERO]);
        for lane in 0..targets.len() {
            // SAFETY: as the caller says.
            unsafe {
                let target = targets[lane].add(places[lane] as usize);
                _mm_storeu_pd(target, _mm256_castpd256_pd128(fours[lane]));
                _mm_store_sd(target.add(2), _mm256_extractf128_pd::<1>(fours[lane]));
            }
        }
    }

    stores_by_squares!();
}
