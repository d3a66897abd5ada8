//! How many fused multiply-adds the machine can do: what a fraction of peak is a fraction of.

use std::hint::black_box;
use std::time::{Duration, Instant};

use diffuse_contact_kernels::support::{Isa, Lane, Vector, WithLanes};

/// Passes over the accumulators between two looks at the clock: 0.1 ms and more.
const PASSES: usize = 20_000;
/// A measurement takes so long: what the operating system and the processor's clock do meanwhile averages out.
const SHORTEST: Duration = Duration::from_millis(20);

/// Fused multiply-adds a nanosecond in one thread with these instructions; where they have none that are fused, pairs of
/// a multiplication and an addition. Independent accumulators hide the latency; how many are best depends on registers
/// and latency, so that several numbers are tried and the best counts.
pub fn fma_per_ns(isa: Isa) -> f64 {
    let rates = [rate::<8>(isa), rate::<12>(isa), rate::<16>(isa), rate::<24>(isa)];
    rates.into_iter().fold(0.0, f64::max)
}

fn rate<const ACCUMULATORS: usize>(isa: Isa) -> f64 {
    let start = Instant::now();
    let mut rounds = 0;
    loop {
        black_box(isa.run(Loop::<ACCUMULATORS> { passes: PASSES }));
        rounds += 1;
        let elapsed = start.elapsed();
        if elapsed >= SHORTEST {
            let operations = rounds * PASSES * ACCUMULATORS * isa.width();
            return operations as f64 / (1e9 * elapsed.as_secs_f64());
        }
    }
}

/// [`fma_loop`] for any vector; the sum of its lanes.
struct Loop<const ACCUMULATORS: usize> {
    passes: usize,
}

impl<const ACCUMULATORS: usize> WithLanes for Loop<ACCUMULATORS> {
    type Output = f64;

    #[inline(always)]
    fn run<T: Vector>(self) -> f64 {
        fma_loop::<T, ACCUMULATORS>(self.passes).sum()
    }
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
        for isa in Isa::available() {
            let sum = isa.run(Loop::<12> { passes: 1000 });
            assert_eq!(sum, (isa.width() * 12) as f64 * 2.0, "{isa}");
        }
    }

    #[test]
    fn the_rate_is_a_number() {
        for isa in Isa::available() {
            let rate = fma_per_ns(isa);
            assert!(rate.is_finite() && rate > 0.0, "{isa}");
        }
    }
}
