//! Damped, bounded Newton iteration for a few equations, all lanes at once.

use super::Lane;
use super::newton::{LONGEST_LAST_STEP, TINY, TOLERANCE, choose, infinite_if_none, larger};

/// Result of an iteration.
#[derive(Clone, Copy, Debug)]
pub struct Solution<T, const N: usize> {
    /// The unknowns.
    pub unknowns: [T; N],
    /// As of [`RootSolution`](super::RootSolution).
    pub residual: T,
    /// Evaluations of the equations.
    pub iterations: T,
}

/// Solves r(y) = 0 from y = 0, one evaluation of r and its Jacobian at a time.
///
/// A step is cut to a length, and halved until it reduces the residual. Rows are exchanged in elimination, in each lane by itself. Lanes
/// that have converged stay where they are. Without a bound on steps linear equations take two evaluations.
#[derive(Clone, Copy, Debug)]
pub struct Equations<T, const N: usize> {
    y: [T; N],
    residual: [T; N],
    jacobian: [[T; N]; N],
    /// −J⁻¹ r
    newton: [T; N],
    step: [T; N],
    start: T,
    /// Squares of what is compared, in units of the start, must not underflow.
    unit: T,
    relative: T,
    iterations: T,
    evaluations: u32,
    longest: f64,
    most: u32,
}

impl<T: Lane, const N: usize> Equations<T, N> {
    /// The iteration before the first evaluation: with steps of at most this length, and at most so many evaluations.
    #[inline(always)]
    pub fn within(longest_step: f64, evaluations: u32) -> Self {
        Self {
            y: [T::ZERO; N],
            residual: [T::ZERO; N],
            jacobian: [[T::ZERO; N]; N],
            newton: [T::ZERO; N],
            step: [T::ZERO; N],
            start: T::ZERO,
            unit: T::ONE,
            relative: T::ONE,
            iterations: T::ONE,
            evaluations: 0,
            longest: longest_step,
            most: evaluations,
        }
    }

    /// Where to evaluate next.
    #[inline(always)]
    pub fn point(&self) -> [T; N] {
        std::array::from_fn(|k| self.y[k] + self.step[k])
    }

    /// Takes the residuals at [`point`](Self::point) and their Jacobian, row by row; returns the solution at the end.
    #[inline(always)]
    pub fn advance(&mut self, residual: [T; N], jacobian: [[T; N]; N]) -> Option<Solution<T, N>> {
        let active = T::select_less(self.relative, T::splat(TOLERANCE), T::ZERO, T::ONE);
        let accepted = if self.evaluations == 0 {
            self.start = norm(residual) + T::splat(TINY);
            self.unit = T::ONE / self.start;
            T::ONE
        } else {
            self.iterations = self.iterations + active;
            T::select_less(self.squared(residual), self.squared(self.residual), active, T::ZERO)
        };
        self.accept(accepted, residual, jacobian);
        self.evaluations += 1;
        // The step first: a NaN in it comes through.
        let last = norm(self.newton) * T::splat(TOLERANCE / LONGEST_LAST_STEP);
        self.relative = larger(last, norm(self.residual)) / larger(self.start, norm(self.y));
        if self.evaluations < self.most && !T::all_less(self.relative, T::splat(TOLERANCE)) {
            return None;
        }
        // Lanes that have not converged take no last step, as from a singular Jacobian: `residual` reports the failure.
        let is_found = |then, otherwise| T::select_less(self.relative, T::splat(TOLERANCE), then, otherwise);
        Some(Solution {
            unknowns: std::array::from_fn(|k| self.y[k] + is_found(self.newton[k], T::ZERO)),
            residual: infinite_if_none(self.relative),
            iterations: self.iterations,
        })
    }

    /// Takes over the evaluation in lanes where `accepted` is 1; the others go half as far.
    #[inline(always)]
    fn accept(&mut self, accepted: T, residual: [T; N], jacobian: [[T; N]; N]) {
        let trial = self.point();
        for row in 0..N {
            self.y[row] = choose(accepted, trial[row], self.y[row]);
            self.residual[row] = choose(accepted, residual[row], self.residual[row]);
            for column in 0..N {
                self.jacobian[row][column] =
                    choose(accepted, jacobian[row][column], self.jacobian[row][column]);
            }
        }
        self.newton = solved(self.jacobian, self.residual.map(|r| -r));
        let (length, longest) = (norm(self.newton), T::splat(self.longest));
        let factor = T::select_less(longest, length, longest / length, T::ONE);
        for k in 0..N {
            self.step[k] = choose(accepted, factor * self.newton[k], T::splat(0.5) * self.step[k]);
        }
    }

    /// |r|² in units of the start.
    #[inline(always)]
    fn squared(&self, r: [T; N]) -> T {
        r.into_iter().fold(T::ZERO, |sum, r| {
            let r = self.unit * r;
            r.mul_add(r, sum)
        })
    }
}

/// Largest absolute component; NaN if one is not finite.
#[inline(always)]
fn norm<T: Lane, const N: usize>(x: [T; N]) -> T {
    let zero = x.into_iter().fold(T::ZERO, |sum, x| x.mul_add(T::ZERO, sum));
    zero + x.into_iter().fold(T::ZERO, |largest, x| larger(x.abs(), largest))
}

/// A⁻¹ b by elimination, each lane with the largest pivots of its own.
#[inline(always)]
fn solved<T: Lane, const N: usize>(mut a: [[T; N]; N], mut b: [T; N]) -> [T; N] {
    for k in 0..N {
        for i in k + 1..N {
            // 1 where the rows are exchanged; the pivot is the largest so far.
            let exchanged = T::select_less(a[k][k].abs(), a[i][k].abs(), T::ONE, T::ZERO);
            for column in k..N {
                let (x, y) = (a[k][column], a[i][column]);
                (a[k][column], a[i][column]) = (choose(exchanged, y, x), choose(exchanged, x, y));
            }
            (b[k], b[i]) = (choose(exchanged, b[i], b[k]), choose(exchanged, b[k], b[i]));
        }
        let reciprocal = T::ONE / a[k][k];
        for i in k + 1..N {
            let factor = a[i][k] * reciprocal;
            for column in k + 1..N {
                a[i][column] = factor.neg_mul_add(a[k][column], a[i][column]);
            }
            b[i] = factor.neg_mul_add(b[k], b[i]);
        }
    }
    for k in (0..N).rev() {
        let rest = (k + 1..N).fold(b[k], |rest, j| a[k][j].neg_mul_add(b[j], rest));
        b[k] = rest / a[k][k];
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solve<const N: usize>(
        (longest, most): (f64, u32),
        equations: impl Fn([f64; N]) -> ([f64; N], [[f64; N]; N]),
    ) -> Solution<f64, N> {
        let mut iteration = Equations::within(longest, most);
        loop {
            let (residual, jacobian) = equations(iteration.point());
            if let Some(solution) = iteration.advance(residual, jacobian) {
                return solution;
            }
        }
    }

    /// Numbers in (−0.5, 0.5) that look random.
    fn random() -> impl FnMut() -> f64 {
        let mut value = 0.37;
        move || {
            value = (value * 7.3_f64 + 0.17).fract();
            value - 0.5
        }
    }

    fn linear<const N: usize>() {
        let mut random = random();
        // Nothing on the diagonal at first: rows have to be exchanged.
        let a: [[f64; N]; N] = std::array::from_fn(|i| {
            std::array::from_fn(|j| if i == j && N > 1 { 0.0 } else { 0.7 + random() * (i + 1) as f64 })
        });
        let b: [f64; N] = std::array::from_fn(|_| 1e3 * random());
        let rest = |y: [f64; N]| std::array::from_fn(|i| (0..N).map(|j| a[i][j] * y[j]).sum::<f64>() - b[i]);
        let found = solve((f64::INFINITY, 5), |y| (rest(y), a));
        assert!(found.residual < TOLERANCE, "{N}: {found:?}");
        assert!(found.iterations <= 3.0 && norm(rest(found.unknowns)) < 1e-10, "{N}: {found:?}");
    }

    #[test]
    fn linear_equations_of_any_size_take_two_evaluations() {
        linear::<1>();
        linear::<2>();
        linear::<3>();
        linear::<5>();
        linear::<8>();
    }

    #[test]
    fn a_root_of_three_equations_is_found_to_rounding() {
        // On a sphere, on a plane, on a cylinder.
        let equations = |[x, y, z]: [f64; 3]| {
            (
                [x * x + y * y + z * z - 1.0, x - y + 0.2 * z + 0.1, x * x + z * z - 0.5],
                [[2.0 * x, 2.0 * y, 2.0 * z], [1.0, -1.0, 0.2], [2.0 * x, 0.0, 2.0 * z]],
            )
        };
        let from = |[x, y, z]: [f64; 3]| equations([x + 0.8, y + 0.7, z + 0.3]);
        let found = solve((0.5, 60), from);
        assert!(found.residual < TOLERANCE && norm(from(found.unknowns).0) < 1e-15, "{found:?}");
    }

    #[test]
    fn what_has_no_root_is_reported() {
        let found = solve((0.5, 60), |[x]: [f64; 1]| ([x * x + 1.0], [[2.0 * x + 1e-3]]));
        assert!(found.residual > TOLERANCE);
        let found = solve((0.5, 60), |[x, y]: [f64; 2]| ([1.0 + x + y, x + y], [[1.0; 2]; 2]));
        assert!(found.residual > TOLERANCE);
        // Too few evaluations.
        let found = solve((0.5, 3), |[x]: [f64; 1]| ([x - 10.0], [[1.0]]));
        assert!(found.residual > 0.1 && found.unknowns[0] < 1.01);
    }

    #[test]
    fn a_number_that_is_none_in_one_equation_is_reported() {
        for place in 0..3 {
            let equations = |y: [f64; 3]| {
                let mut residual = y.map(|y| y - 0.1);
                residual[place] = f64::NAN;
                (residual, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
            };
            assert!(solve((0.5, 60), equations).residual > TOLERANCE, "{place}");
        }
    }

    #[test]
    fn equations_that_hold_at_the_start_stay_there() {
        let found = solve((0.5, 60), |[x, y]: [f64; 2]| ([x + y * y, y], [[1.0, 2.0 * y], [0.0, 1.0]]));
        assert_eq!((found.unknowns, found.iterations), ([0.0; 2], 1.0));
    }
}
