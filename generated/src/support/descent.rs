//! Minimum of a function of two variables by a damped Newton iteration, all lanes at once.

use super::newton::{Iterate, LONGEST_STEP, newton_step, norm};
use super::{Lane, RootSolution};

/// Smallest curvature a step is based on where the function is not convex, relative to the largest.
const SMALLEST_CURVATURE: f64 = 1e-3;
/// A step may overshoot the minimum along it until the slope is this part of the one before, with the other sign.
const OVERSHOOT: f64 = 0.5;

/// Finds a minimum of E(y) from y = 0, one evaluation of −∂E/∂y and its Jacobian at a time.
///
/// Lengths are in edges of a facet. Where E is convex a step is Newton's; elsewhere it goes down along both principal
/// directions, so that the iteration is not drawn to a saddle. It is cut to half an edge plus half of the way already
/// made, and halved until it does not overshoot, or shortens the way by the same matrix, which does not depend on how
/// narrow a facet is. Lanes that have converged stay where they are.
#[derive(Clone, Copy, Debug)]
pub struct TwoVariables<T> {
    iterate: Iterate<T>,
    /// The step before it was cut.
    full: [T; 2],
}

impl<T: Lane> TwoVariables<T> {
    /// The iteration before the first evaluation.
    #[inline(always)]
    pub fn start() -> Self {
        Self { iterate: Iterate::start(), full: [T::ZERO; 2] }
    }

    /// Where to evaluate next.
    #[inline(always)]
    pub fn point(&self) -> [T; 2] {
        self.iterate.point()
    }

    /// Takes −∂E/∂y at [`point`](Self::point) and its Jacobian, row by row; returns the solution at the end.
    #[inline(always)]
    pub fn advance(&mut self, residual: [T; 2], jacobian: [T; 4]) -> Option<RootSolution<T>> {
        let Self { iterate, full } = self;
        if iterate.is_first() {
            iterate.begin(residual, jacobian);
            *full = downhill_step(residual, jacobian);
            iterate.step = bounded(iterate.y, *full);
        } else {
            let active = iterate.active();
            let (before, after) = (dot(iterate.step, iterate.residual), dot(iterate.step, residual));
            let bound = T::splat(-OVERSHOOT) * before;
            // What is left to go by the same matrix, and how much that may be after this part of the way.
            let rest = norm(downhill_step(residual, iterate.jacobian));
            let most = T::splat(OVERSHOOT).neg_mul_add(norm(iterate.step), norm(*full));
            let closer = T::select_less(rest, most, active, T::ZERO);
            let accepted = T::select_less(bound, after, active, closer);
            iterate.accept(accepted, residual, jacobian);
            *full = downhill_step(iterate.residual, iterate.jacobian);
            iterate.go_on(accepted, bounded(iterate.y, *full), active);
        }
        if !iterate.is_over() {
            return None;
        }
        // A singular Jacobian allows no last step: `residual` reports the failure.
        let last = newton_step(iterate.residual, iterate.jacobian);
        let longest = longest_step(iterate.y);
        Some(iterate.solution(pair(|k| T::select_less(norm(last), longest, last[k], T::ZERO))))
    }
}

#[inline(always)]
fn longest_step<T: Lane>(y: [T; 2]) -> T {
    T::splat(LONGEST_STEP).mul_add(norm(y), T::splat(LONGEST_STEP))
}

#[inline(always)]
fn bounded<T: Lane>(y: [T; 2], step: [T; 2]) -> [T; 2] {
    let (length, longest) = (norm(step), longest_step(y));
    let factor = T::select_less(longest, length, longest / length, T::ONE);
    pair(|k| factor * step[k])
}

/// H⁻¹ r with H = −J where that is positive definite; elsewhere with the absolute values of its eigenvalues, none of
/// which is taken for zero.
#[inline(always)]
fn downhill_step<T: Lane>(r: [T; 2], j: [T; 4]) -> [T; 2] {
    let half = T::splat(0.5);
    let off = -half * (j[1] + j[2]);
    let (mean, difference) = (-half * (j[0] + j[3]), half * (j[3] - j[0]));
    let radius = difference.mul_add(difference, off * off).sqrt();
    let smallest = mean - radius;
    // r along the eigenvectors, through the projections ½ (1 ± (H − mean) / radius).
    let turned = [difference.mul_add(r[0], off * r[1]), off.mul_sub(r[0], difference * r[1])];
    let deviation = pair(|k| turned[k].div_or_zero(radius));
    let largest = (mean + radius).abs();
    let floor = T::splat(SMALLEST_CURVATURE) * largest;
    let other = T::select_less(smallest.abs(), floor, floor, smallest.abs());
    let newton = newton_step(r, j);
    pair(|k| {
        let (upper, lower) = (half * (r[k] + deviation[k]), half * (r[k] - deviation[k]));
        let downhill = upper / largest + lower / other;
        T::select_less(T::ZERO, smallest, newton[k], downhill)
    })
}

/// Not `map` of arrays, which is not always inlined: then its closures are compiled without vector instructions.
#[inline(always)]
fn pair<T>(value: impl Fn(usize) -> T) -> [T; 2] {
    [value(0), value(1)]
}

#[inline(always)]
fn dot<T: Lane>(x: [T; 2], y: [T; 2]) -> T {
    x[0].mul_add(y[0], x[1] * y[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn minimise_two_variables(equations: impl Fn([f64; 2]) -> ([f64; 2], [f64; 4])) -> RootSolution<f64> {
        let mut iteration = TwoVariables::start();
        loop {
            let (residual, jacobian) = equations(iteration.point());
            if let Some(solution) = iteration.advance(residual, jacobian) {
                return solution;
            }
        }
    }

    /// E = x⁴/4 − x²/2 − c x + y²/2 + x y/10, not convex at the start.
    fn double_well(c: f64) -> impl Fn([f64; 2]) -> ([f64; 2], [f64; 4]) {
        move |[x, y]| {
            let gradient = [x * x * x - x - c + y / 10.0, y + x / 10.0];
            (gradient.map(|g| -g), [1.0 - 3.0 * x * x, -0.1, -0.1, -1.0])
        }
    }

    #[test]
    fn a_saddle_is_left_behind() {
        for c in [1e-6, -0.1, 0.3] {
            let solution = minimise_two_variables(double_well(c));
            let [x, _] = solution.unknowns;
            let (residual, jacobian) = double_well(c)(solution.unknowns);
            assert!(solution.residual < RootSolution::<f64>::TOLERANCE);
            assert!(norm(residual) < 1e-15);
            // The well on the side of the slope; a minimum.
            assert!(x * c > 0.0 && jacobian[0] * jacobian[3] - jacobian[1] * jacobian[2] > 0.0, "{x}");
        }
    }

    #[test]
    fn a_minimum_far_away_is_reached() {
        let solution = minimise_two_variables(|[x, y]: [f64; 2]| {
            ([1e6 - x, -3e4 - 2.0 * y - x], [-1.0, 0.0, -1.0, -2.0])
        });
        assert!(solution.residual < RootSolution::<f64>::TOLERANCE);
        assert!((solution.unknowns[0] - 1e6).abs() < 1e-9);
    }

    #[test]
    fn a_singular_start_stays_where_it_is() {
        let solution = minimise_two_variables(|[x, y]: [f64; 2]| ([x * x, -y], [2.0 * x, 0.0, 0.0, -1.0]));
        assert_eq!(solution.unknowns, [0.0; 2]);
        assert!(solution.residual > RootSolution::<f64>::TOLERANCE);
    }

    #[test]
    fn a_function_without_a_minimum_is_reported() {
        let solution =
            minimise_two_variables(|[x, y]: [f64; 2]| ([1.0 + x * x, -y], [2.0 * x, 0.0, 0.0, -1.0]));
        assert!(solution.residual > RootSolution::<f64>::TOLERANCE);
    }
}
