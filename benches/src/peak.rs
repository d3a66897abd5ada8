//! How many fused multiply-adds the machine can do: what a fraction of peak is a fraction of.

use std::hint::black_box;
use std::time::Instant;

use diffuse_contact_kernels::support::Lane;

/// Passes over the accumulators in one measurement, a good millisecond.
const PASSES: usize = 200_000;
/// Lanes of the number the loop runs on.
const LANES: usize = 1;

/// Fused multiply-adds a nanosecond in one thread, with the instruction set the generated kernels use. Independent
/// accumulators hide the latency; how many are best depends on registers and latency, so that several numbers are
/// tried and the best counts.
#[must_use]
pub fn fma_per_ns() -> f64 {
    let rates = [rate::<8>(), rate::<12>(), rate::<16>(), rate::<24>()];
    rates.into_iter().fold(0.0, f64::max)
}

fn rate<const ACCUMULATORS: usize>() -> f64 {
    let start = Instant::now();
    // Here a vector of lanes takes the place of f64.
    black_box(fma_loop::<f64, ACCUMULATORS>(PASSES));
    (PASSES * ACCUMULATORS * LANES) as f64 / (1e9 * start.elapsed().as_secs_f64())
}

/// `passes` fused multiply-adds on each of the accumulators. They approach a fixed point: nothing overflows or becomes
/// subnormal.
#[inline(always)]
fn fma_loop<T: Lane, const ACCUMULATORS: usize>(passes: usize) -> T {
    let (factor, term) = (T::splat(black_box(0.75)), T::splat(black_box(0.5)));
    let mut accumulators: [T; ACCUMULATORS] = std::array::from_fn(|k| T::splat(black_box(k as f64)));
    for _ in 0..passes {
        for x in &mut accumulators {
            *x = x.mul_add(factor, term);
        }
    }
    accumulators.into_iter().fold(T::ZERO, |sum, x| sum + x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_accumulators_reach_the_fixed_point() {
        assert_eq!(fma_loop::<f64, 12>(1000), 12.0 * 2.0);
    }

    #[test]
    fn the_rate_is_a_number() {
        let rate = fma_per_ns();
        assert!(rate.is_finite() && rate > 0.0);
    }
}
