//! Damped, bounded Newton iteration for two equations, all lanes at once.

use super::Lane;

/// Most evaluations of the equations.
const MOST_ITERATIONS: u32 = 60;
/// Residual at which the iteration ends, relative to the starting residual or the unknowns, whichever is larger; a last
/// full step follows and squares it.
pub(super) const TOLERANCE: f64 = 1e-12;
/// The last step has to be shorter than this, by the same measure, or a nearly singular Jacobian makes it worthless.
pub(super) const LONGEST_LAST_STEP: f64 = 1e-6;
/// Added to the measure, so that a root at the start is one.
pub(super) const TINY: f64 = 1e-290;
/// Longest step, in units of the support radius, or of an edge of the facet.
pub(super) const LONGEST_STEP: f64 = 0.5;

/// Result of an iteration.
#[derive(Clone, Copy, Debug)]
pub struct RootSolution<T> {
    /// The unknowns.
    pub unknowns: [T; 2],
    /// Largest absolute residual before the last step, divided by the starting residual or the unknowns, whichever
    /// is larger, or 10⁻⁶ of the last step by the same measure, if that is larger. Not below
    /// [`RootSolution::TOLERANCE`] if the iteration did not converge; infinite where it met no number, as from a singular Jacobian.
    pub residual: T,
    /// Evaluations of the equations.
    pub iterations: T,
}

impl<T> RootSolution<T> {
    /// Bound on the residual of a converged iteration.
    pub const TOLERANCE: f64 = TOLERANCE;
}

/// Where an iteration for two unknowns is, where it looks next, and how far it has come.
#[derive(Clone, Copy, Debug)]
pub(super) struct Iterate<T> {
    pub y: [T; 2],
    pub residual: [T; 2],
    pub jacobian: [T; 4],
    start: [T; 2],
    pub step: [T; 2],
    /// [`RootSolution::residual`] so far.
    pub relative: T,
    iterations: T,
    evaluations: u32,
}

impl<T: Lane> Iterate<T> {
    /// Before the first evaluation.
    #[inline(always)]
    pub fn start() -> Self {
        Self {
            y: [T::ZERO; 2],
            residual: [T::ZERO; 2],
            jacobian: [T::ZERO; 4],
            start: [T::ZERO; 2],
            step: [T::ZERO; 2],
            relative: T::ONE,
            iterations: T::ONE,
            evaluations: 0,
        }
    }

    /// Where to evaluate next.
    #[inline(always)]
    pub fn point(&self) -> [T; 2] {
        [self.y[0] + self.step[0], self.y[1] + self.step[1]]
    }

    /// Whether there has been no evaluation.
    #[inline(always)]
    pub fn is_first(&self) -> bool {
        self.evaluations == 0
    }

    /// Takes over the first evaluation.
    #[inline(always)]
    pub fn begin(&mut self, residual: [T; 2], jacobian: [T; 4]) {
        (self.residual, self.jacobian, self.start) = (residual, jacobian, residual);
    }

    /// 1 in lanes that have not converged, 0 in the others.
    #[inline(always)]
    pub fn active(&self) -> T {
        T::select_less(self.relative, T::splat(TOLERANCE), T::ZERO, T::ONE)
    }

    /// Takes over the evaluation at [`point`](Self::point) in lanes where `accepted` is 1.
    #[inline(always)]
    pub fn accept(&mut self, accepted: T, residual: [T; 2], jacobian: [T; 4]) {
        let trial = self.point();
        for k in 0..2 {
            self.y[k] = choose(accepted, trial[k], self.y[k]);
            self.residual[k] = choose(accepted, residual[k], self.residual[k]);
        }
        for k in 0..4 {
            self.jacobian[k] = choose(accepted, jacobian[k], self.jacobian[k]);
        }
    }

    /// Goes on with `next` in lanes where `accepted` is 1, else with half of the step before.
    #[inline(always)]
    pub fn go_on(&mut self, accepted: T, next: [T; 2], active: T) {
        let half = T::splat(0.5);
        for k in 0..2 {
            self.step[k] = choose(accepted, next[k], half * self.step[k]);
        }
        self.iterations = self.iterations + active;
    }

    /// Counts the evaluation; whether it was the last one.
    #[inline(always)]
    pub fn is_over(&mut self) -> bool {
        self.evaluations += 1;
        self.relative = distance(self.start, self.y, self.residual, self.jacobian);
        self.evaluations >= MOST_ITERATIONS || T::all_less(self.relative, T::splat(TOLERANCE))
    }

    /// The solution, after a last step.
    #[inline(always)]
    pub fn solution(&self, last: [T; 2]) -> RootSolution<T> {
        RootSolution {
            unknowns: [self.y[0] + last[0], self.y[1] + last[1]],
            residual: infinite_if_none(self.relative),
            iterations: self.iterations,
        }
    }
}

/// Solves r(y) = 0 from y = 0, one evaluation of r and its Jacobian at a time.
///
/// Lengths are in support radii. A step is cut to half the support radius, and halved until it reduces the residual, so
/// that the iteration cannot leave the region the start belongs to for a far root. Lanes that have converged stay where
/// they are.
#[derive(Clone, Copy, Debug)]
pub struct TwoEquations<T> {
    iterate: Iterate<T>,
    /// Squares of what is compared, in units of the start, must not underflow.
    unit: T,
}

impl<T: Lane> TwoEquations<T> {
    /// The iteration before the first evaluation.
    #[inline(always)]
    pub fn start() -> Self {
        Self { iterate: Iterate::start(), unit: T::ONE }
    }

    /// Where to evaluate next.
    #[inline(always)]
    pub fn point(&self) -> [T; 2] {
        self.iterate.point()
    }

    /// Takes the residuals at [`point`](Self::point) and their Jacobian, row by row; returns the solution at the end.
    #[inline(always)]
    pub fn advance(&mut self, residual: [T; 2], jacobian: [T; 4]) -> Option<RootSolution<T>> {
        let Self { iterate, unit } = self;
        if iterate.is_first() {
            iterate.begin(residual, jacobian);
            *unit = T::ONE / (norm(residual) + T::splat(TINY));
            iterate.step = bounded_step(residual, jacobian);
        } else {
            let before = squared(*unit, iterate.residual);
            let after = squared(*unit, residual);
            let active = iterate.active();
            let accepted = T::select_less(after, before, active, T::ZERO);
            iterate.accept(accepted, residual, jacobian);
            iterate.go_on(accepted, bounded_step(iterate.residual, iterate.jacobian), active);
        }
        if !iterate.is_over() {
            return None;
        }
        // Lanes that have not converged take no last step, as from a singular Jacobian: `residual` reports the failure.
        let last = newton_step(iterate.residual, iterate.jacobian);
        let (relative, tolerance) = (iterate.relative, T::splat(TOLERANCE));
        Some(iterate.solution([
            T::select_less(relative, tolerance, last[0], T::ZERO),
            T::select_less(relative, tolerance, last[1], T::ZERO),
        ]))
    }
}

/// How far y is from a root, by the larger of the residual and the step before it; relative to the starting residual or
/// the unknowns.
#[inline(always)]
fn distance<T: Lane>(start: [T; 2], y: [T; 2], residual: [T; 2], jacobian: [T; 4]) -> T {
    let step = norm(newton_step(residual, jacobian)) * T::splat(TOLERANCE / LONGEST_LAST_STEP);
    let start = norm(start) + T::splat(TINY);
    // The step first: a NaN in it comes through.
    larger(step, norm(residual)) / larger(start, norm(y))
}

/// −J⁻¹ r
#[inline(always)]
pub(super) fn newton_step<T: Lane>(r: [T; 2], j: [T; 4]) -> [T; 2] {
    let reciprocal = T::ONE / j[0].mul_sub(j[3], j[1] * j[2]);
    [j[1].mul_sub(r[1], j[3] * r[0]) * reciprocal, j[2].mul_sub(r[0], j[0] * r[1]) * reciprocal]
}

#[inline(always)]
fn bounded_step<T: Lane>(r: [T; 2], j: [T; 4]) -> [T; 2] {
    let step = newton_step(r, j);
    let length = norm(step);
    let longest = T::splat(LONGEST_STEP);
    let factor = T::select_less(longest, length, longest / length, T::ONE);
    [factor * step[0], factor * step[1]]
}

/// `then` in the lanes where `condition` is 1, `otherwise` where it is 0.
#[inline(always)]
pub(super) fn choose<T: Lane>(condition: T, then: T, otherwise: T) -> T {
    T::select_less(T::ZERO, condition, then, otherwise)
}

/// |unit · x|²
#[inline(always)]
fn squared<T: Lane>(unit: T, x: [T; 2]) -> T {
    let [x, y] = [unit * x[0], unit * x[1]];
    x.mul_add(x, y * y)
}

/// The larger value; x if x is NaN.
#[inline(always)]
pub(super) fn larger<T: Lane>(x: T, y: T) -> T {
    T::select_less(x, y, y, x)
}

/// x, and infinity where it is NaN: a failure is found by any comparison.
#[inline(always)]
pub(super) fn infinite_if_none<T: Lane>(x: T) -> T {
    let infinity = T::splat(f64::INFINITY);
    T::select_less(x, infinity, x, infinity)
}

/// Largest absolute component.
#[inline(always)]
pub(super) fn norm<T: Lane>(x: [T; 2]) -> T {
    larger(x[0].abs(), x[1].abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solve_two_equations(equations: impl Fn([f64; 2]) -> ([f64; 2], [f64; 4])) -> RootSolution<f64> {
        let mut iteration = TwoEquations::start();
        loop {
            let (residual, jacobian) = equations(iteration.point());
            if let Some(solution) = iteration.advance(residual, jacobian) {
                return solution;
            }
        }
    }

    #[test]
    fn a_smooth_root_is_found_to_rounding() {
        let solution = solve_two_equations(|[x, y]: [f64; 2]| {
            ([x * x + y - 0.3, x - y * y + 0.2], [2.0 * x, 1.0, 1.0, -2.0 * y])
        });
        let [x, y] = solution.unknowns;
        assert!((x * x + y - 0.3).abs() < 1e-15 && (x - y * y + 0.2).abs() < 1e-15);
        assert!(solution.residual < 1e-12);
    }

    #[test]
    fn a_root_next_to_the_start_is_found_however_near() {
        for size in [1e-20, 1e-160, 1e-200, 1e-280] {
            let solution = solve_two_equations(|[x, y]: [f64; 2]| {
                ([size - x + 0.3 * y, 0.2 * size - y - 0.1 * x + x * x], [-1.0, 0.3, 2.0 * x - 0.1, -1.0])
            });
            assert!(solution.residual < RootSolution::<f64>::TOLERANCE, "{size:e}");
            assert!((solution.unknowns[0] / size - 1.06 / 1.03).abs() < 1e-12, "{size:e}");
        }
    }

    #[test]
    fn equations_without_a_root_are_reported() {
        let solution =
            solve_two_equations(|[x, y]: [f64; 2]| ([x * x + 1.0, y], [2.0 * x + 1e-3, 0.0, 0.0, 1.0]));
        assert!(solution.residual > RootSolution::<f64>::TOLERANCE);
    }

    #[test]
    fn a_singular_jacobian_gives_no_converged_number() {
        let solution = solve_two_equations(|[x, y]: [f64; 2]| ([1.0 + x - x, y], [0.0, 0.0, 0.0, 1.0]));
        assert!(solution.residual > RootSolution::<f64>::TOLERANCE);
    }
}
