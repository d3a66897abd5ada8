//! Weight, moments, Cholesky factorisation and foot, all lengths over the support radius.

use nalgebra::{Matrix6, Vector6};

use super::fma;

/// Most evaluations of the foot equations, and most halvings of a step.
const MOST_ITERATIONS: usize = 50;
/// Largest residual, relative to the starting one, at which one last step is taken; that squares it.
const FOOT_TOLERANCE: f64 = 1e-9;
/// Longest step towards the foot.
const LONGEST_STEP: f64 = 0.5;
/// A pivot has to exceed this fraction of its diagonal entry.
const PIVOT_TOLERANCE: f64 = 1e-7;

/// A master node in the plane, with its weight.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Node {
    pub(super) a: f64,
    pub(super) b: f64,
    pub(super) z: f64,
    /// w = 1 − 3s + 2s√s with s = a² + b² (Chamoret et al. 2008, eq. 14).
    pub(super) w: f64,
    /// ∂w/∂s, twice.
    pub(super) slope: f64,
    /// 4 ∂²w/∂s².
    pub(super) curvature: f64,
}

impl Node {
    #[inline(always)]
    pub(super) fn new([a, b, z]: [f64; 3]) -> Self {
        let s = a * a + b * b;
        let r = s.sqrt();
        let inside = if s < 1.0 { 1.0 } else { 0.0 };
        // At r = 0 the curvature is only ever multiplied by products of a and b, which are 0 with it.
        let reciprocal = if r > 0.0 { 1.0 / r } else { 0.0 };
        Self {
            a,
            b,
            z,
            w: inside * (1.0 - s * (3.0 - 2.0 * r)),
            slope: inside * (6.0 * r - 6.0),
            curvature: inside * 6.0 * reciprocal,
        }
    }
}

/// Moment matrix and vector, A = Σ w p pᵀ and β = Σ w z p.
#[inline(always)]
pub(super) fn moments(nodes: &[Node]) -> (Matrix6<f64>, Vector6<f64>) {
    // Σ w aⁱ bʲ, by degree.
    let mut m = [0.0; 15];
    let mut beta = [0.0; 6];
    for &Node { a, b, z, w, .. } in nodes {
        let (aa, ab, bb) = (a * a, a * b, b * b);
        let (waa, wab, wbb) = (w * aa, w * ab, w * bb);
        let low = [w, w * a, w * b, waa, wab, wbb];
        for k in 0..6 {
            m[k] += low[k];
            beta[k] = fma(low[k], z, beta[k]);
        }
        let high =
            [(waa, a), (waa, b), (wbb, a), (wbb, b), (waa, aa), (waa, ab), (waa, bb), (wab, bb), (wbb, bb)];
        for k in 0..9 {
            m[6 + k] = fma(high[k].0, high[k].1, m[6 + k]);
        }
    }
    let [m00, m10, m01, m20, m11, m02, m30, m21, m12, m03, m40, m31, m22, m13, m04] = m;
    let matrix = Matrix6::new(
        m00, 0.0, 0.0, 0.0, 0.0, 0.0, //
        m10, m20, 0.0, 0.0, 0.0, 0.0, //
        m01, m11, m02, 0.0, 0.0, 0.0, //
        m20, m30, m21, m40, 0.0, 0.0, //
        m11, m21, m12, m31, m22, 0.0, //
        m02, m12, m03, m22, m13, m04,
    );
    (matrix, Vector6::from(beta))
}

/// The factor L of A = L Lᵀ and the reciprocals of its diagonal, from the lower triangle of A; `None` if a pivot is too
/// small.
#[inline(always)]
pub(super) fn cholesky(mut l: Matrix6<f64>) -> Option<(Matrix6<f64>, [f64; 6])> {
    let mut reciprocals = [0.0; 6];
    for j in 0..6 {
        let mut pivot = l[(j, j)];
        for k in 0..j {
            pivot = fma(-l[(j, k)], l[(j, k)], pivot);
        }
        if !(pivot > PIVOT_TOLERANCE * l[(j, j)]) {
            return None;
        }
        let root = pivot.sqrt();
        let reciprocal = 1.0 / root;
        for i in j + 1..6 {
            let mut entry = l[(i, j)];
            for k in 0..j {
                entry = fma(-l[(i, k)], l[(j, k)], entry);
            }
            l[(i, j)] = entry * reciprocal;
        }
        l[(j, j)] = root;
        reciprocals[j] = reciprocal;
    }
    Some((l, reciprocals))
}

/// L⁻¹, lower triangle.
#[inline(always)]
pub(super) fn inverse(l: &Matrix6<f64>, reciprocals: &[f64; 6]) -> Matrix6<f64> {
    let mut inverse = Matrix6::zeros();
    for j in 0..6 {
        inverse[(j, j)] = reciprocals[j];
        for i in j + 1..6 {
            let mut sum = 0.0;
            for k in j..i {
                sum = fma(l[(i, k)], inverse[(k, j)], sum);
            }
            inverse[(i, j)] = -sum * reciprocals[i];
        }
    }
    inverse
}

/// The surface at a point of the plane: height over the slave's own, slopes, curvatures f_11, f_12, f_22.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub(super) u: [f64; 2],
    pub(super) f: f64,
    pub(super) slopes: [f64; 2],
    pub(super) curvatures: [f64; 3],
}

impl Point {
    #[inline(always)]
    fn new(alpha: &Vector6<f64>, u: [f64; 2]) -> Self {
        let [a, b] = u;
        let curvatures = [2.0 * alpha[3], alpha[4], 2.0 * alpha[5]];
        let slopes = [
            fma(curvatures[1], b, fma(curvatures[0], a, alpha[1])),
            fma(curvatures[2], b, fma(curvatures[1], a, alpha[2])),
        ];
        let f = fma(0.5, fma(alpha[1] + slopes[0], a, (alpha[2] + slopes[1]) * b), alpha[0]);
        Self { u, f, slopes, curvatures }
    }

    /// Foot equations F_k = −u_k + h f_k with h = −f.
    #[inline(always)]
    fn residual(&self) -> [f64; 2] {
        [fma(-self.f, self.slopes[0], -self.u[0]), fma(-self.f, self.slopes[1], -self.u[1])]
    }

    /// Their Jacobian −δ_kl − f_k f_l + h f_kl, entries 11, 12, 22.
    #[inline(always)]
    pub(super) fn jacobian(&self) -> [f64; 3] {
        let ([f_1, f_2], [f_11, f_12, f_22]) = (self.slopes, self.curvatures);
        [
            fma(-self.f, f_11, fma(-f_1, f_1, -1.0)),
            fma(-self.f, f_12, -f_1 * f_2),
            fma(-self.f, f_22, fma(-f_2, f_2, -1.0)),
        ]
    }

    /// −J⁻¹ F
    #[inline(always)]
    fn step(&self) -> [f64; 2] {
        let [j_11, j_12, j_22] = self.jacobian();
        let [r_1, r_2] = self.residual();
        let reciprocal = 1.0 / fma(j_11, j_22, -j_12 * j_12);
        [fma(j_12, r_2, -j_22 * r_1) * reciprocal, fma(j_12, r_1, -j_11 * r_2) * reciprocal]
    }
}

/// The foot of the slave on the fitted surface by damped Newton iteration from straight below it; `None` if there is
/// none within the domain of influence that is a minimum of the distance.
#[inline(always)]
pub(super) fn foot(alpha: &Vector6<f64>) -> Option<Point> {
    let square = |r: [f64; 2]| r[0] * r[0] + r[1] * r[1];
    let mut point = Point::new(alpha, [0.0; 2]);
    let mut size = square(point.residual());
    let goal = FOOT_TOLERANCE * FOOT_TOLERANCE * size;
    let mut step = point.step();
    let mut iterations = 0;
    while size > goal {
        iterations += 1;
        if iterations > MOST_ITERATIONS {
            return None;
        }
        let length = square(step);
        if length > LONGEST_STEP * LONGEST_STEP {
            let factor = LONGEST_STEP / length.sqrt();
            step = step.map(|x| factor * x);
        }
        let trial = Point::new(alpha, [point.u[0] + step[0], point.u[1] + step[1]]);
        let trial_size = square(trial.residual());
        if trial_size < size {
            (point, size) = (trial, trial_size);
            step = point.step();
        } else {
            step = step.map(|x| 0.5 * x);
        }
    }
    let foot = Point::new(alpha, [point.u[0] + step[0], point.u[1] + step[1]]);
    let [j_11, j_12, j_22] = foot.jacobian();
    let minimum = j_11 * j_22 - j_12 * j_12 > 1e-7 && j_11 + j_22 < 0.0;
    (minimum && square(foot.u) <= 1.0).then_some(foot)
}
