//! The arithmetic of the kernels.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number, or several numbers that go through the same kernel side by side, one element each.
///
/// Kernels use these operations only and never branch on values, so a vector of elements needs no other code than
/// one element. Comparisons choose between values for every lane on its own.
pub trait Lane:
    Copy
    + std::fmt::Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Numbers side by side.
    const WIDTH: usize;
    /// 0 in all lanes.
    const ZERO: Self;
    /// 1 in all lanes.
    const ONE: Self;

    /// `value` in all lanes.
    fn splat(value: f64) -> Self;

    /// `value(k)` in lane k.
    fn from_fn(value: impl FnMut(usize) -> f64) -> Self;

    /// The number in lane k.
    ///
    /// # Panics
    /// If there is no such lane.
    fn lane(&self, k: usize) -> f64;

    /// `self` · `factor` + `term`, fused where the target has the instruction.
    #[must_use]
    fn mul_add(self, factor: Self, term: Self) -> Self;

    /// `self` · `factor` − `term`.
    #[must_use]
    #[inline]
    fn mul_sub(self, factor: Self, term: Self) -> Self {
        self.mul_add(factor, -term)
    }

    /// `term` − `self` · `factor`.
    #[must_use]
    #[inline]
    fn neg_mul_add(self, factor: Self, term: Self) -> Self {
        (-self).mul_add(factor, term)
    }

    /// Square root.
    #[must_use]
    fn sqrt(self) -> Self;

    /// Exponential.
    #[must_use]
    fn exp(self) -> Self;

    /// Natural logarithm, number by number as the other functions without a vector instruction.
    #[must_use]
    #[inline(always)]
    fn ln(self) -> Self {
        Self::from_fn(|k| self.lane(k).ln())
    }

    /// Sine.
    #[must_use]
    #[inline(always)]
    fn sin(self) -> Self {
        Self::from_fn(|k| self.lane(k).sin())
    }

    /// Cosine.
    #[must_use]
    #[inline(always)]
    fn cos(self) -> Self {
        Self::from_fn(|k| self.lane(k).cos())
    }

    /// Cube root.
    #[must_use]
    #[inline(always)]
    fn cbrt(self) -> Self {
        Self::from_fn(|k| self.lane(k).cbrt())
    }

    /// Angle of the point (`x`, `self`).
    #[must_use]
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        Self::from_fn(|k| self.lane(k).atan2(x.lane(k)))
    }

    /// `self` to the power of `exponent`, for positive numbers.
    #[must_use]
    #[inline(always)]
    fn powf(self, exponent: Self) -> Self {
        Self::from_fn(|k| self.lane(k).powf(exponent.lane(k)))
    }

    /// Absolute value.
    #[must_use]
    fn abs(self) -> Self;

    /// `then` in the lanes where `x` < `y`, elsewhere, also where one is NaN, `otherwise`.
    fn select_less(x: Self, y: Self, then: Self, otherwise: Self) -> Self;

    /// `self` / `divisor`, and 0 in the lanes where `divisor` is 0. A NaN stays one.
    #[must_use]
    #[inline(always)]
    fn div_or_zero(self, divisor: Self) -> Self {
        let smallest = Self::splat(f64::from_bits(1));
        Self::select_less(divisor.abs(), smallest, Self::ZERO, self / divisor)
    }

    /// Whether `x` < `y` in every lane.
    fn all_less(x: Self, y: Self) -> bool;
}

impl Lane for f64 {
    const WIDTH: usize = 1;
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;

    #[inline]
    fn splat(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn from_fn(mut value: impl FnMut(usize) -> f64) -> Self {
        value(0)
    }

    #[inline(always)]
    fn lane(&self, k: usize) -> f64 {
        assert_eq!(k, 0, "one lane");
        *self
    }

    #[inline]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        // Without the instruction, a fused multiply-add is a slow library call.
        if cfg!(any(target_feature = "fma", target_arch = "aarch64")) {
            f64::mul_add(self, factor, term)
        } else {
            self * factor + term
        }
    }

    #[inline]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }

    #[inline(always)]
    fn exp(self) -> Self {
        f64::exp(self)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }

    #[inline(always)]
    fn select_less(x: Self, y: Self, then: Self, otherwise: Self) -> Self {
        if x < y { then } else { otherwise }
    }

    #[inline(always)]
    fn all_less(x: Self, y: Self) -> bool {
        x < y
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Isa, Vector, WithLanes};

    /// What a function of lanes returned, and the same function of their numbers.
    type Pair<T> = (T, fn(f64, f64) -> f64);

    /// Every function as the generator writes it.
    struct Functions;

    impl WithLanes for Functions {
        type Output = ();

        #[inline(always)]
        fn run<T: Vector>(self) {
            let [x, y] = [0.5, 0.25].map(|start| T::from_fn(|k| start + k as f64));
            let all: [Pair<T>; 8] = [
                (x.sqrt(), |x, _| x.sqrt()),
                (x.exp(), |x, _| x.exp()),
                (x.ln(), |x, _| x.ln()),
                (x.sin(), |x, _| x.sin()),
                (x.cos(), |x, _| x.cos()),
                (x.cbrt(), |x, _| x.cbrt()),
                (x.atan2(-y), |x, y| x.atan2(-y)),
                (x.powf(y), f64::powf),
            ];
            for (k, (found, expected)) in (0..T::WIDTH).flat_map(|k| all.map(|pair| (k, pair))) {
                assert_eq!(found.lane(k), expected(x.lane(k), y.lane(k)), "lane {k} of {}", T::WIDTH);
            }
        }
    }

    #[test]
    fn every_lane_has_the_function_of_its_number() {
        for isa in Isa::available() {
            isa.run(Functions);
        }
    }
}
