//! The gap over the dual numbers of num-dual: the function stated once, differentiated by arithmetic.
//!
//! Quadratic basis, cubic weight, held frame. As good as dual numbers allow: the foot is found on reals, and two Newton
//! steps with its real Jacobian carry derivatives of second order exactly; of the moment matrix only the 15 different
//! entries are summed; nothing is allocated. Lengths are over the support radius.

use diffuse_contact::Element;
use nalgebra::{Const, U1};
use num_dual::{Dual2SVec64, DualNum, HyperDual64};

use crate::Elements;
use crate::contender::{Output, Run};
use crate::one_by_one::OneByOne;

/// Most Newton iterations for the foot on reals.
const MOST_ITERATIONS: usize = 50;

/// Which moment Σ w aⁱ bʲ each entry of the lower triangle of A is.
const MOMENTS: [[usize; 6]; 6] = [
    [0, 0, 0, 0, 0, 0],
    [1, 3, 0, 0, 0, 0],
    [2, 4, 5, 0, 0, 0],
    [3, 6, 7, 10, 0, 0],
    [4, 7, 8, 11, 12, 0],
    [5, 8, 9, 12, 13, 14],
];

/// The contender of [`by_vectors`] for these elements. Every number of nodes takes seconds to compile: `None` for those
/// left out.
pub fn prepare_vectors(elements: &Elements) -> Option<Box<dyn Run + '_>> {
    macro_rules! by_nodes {
        ($($nodes:literal)*) => {
            match elements.nodes() {
                $($nodes => Some(one_by_one(elements, by_vectors::<{ 3 * ($nodes + 1) }>)),)*
                _ => None,
            }
        };
    }
    by_nodes!(6 8 9 12 16 20 24)
}

/// The contender of [`by_pairs`] for these elements.
pub fn prepare_pairs(elements: &Elements) -> Option<Box<dyn Run + '_>> {
    Some(one_by_one(elements, by_pairs))
}

fn one_by_one(
    elements: &Elements,
    gap: fn(&Element<'_>, &mut [f64], &mut [f64]) -> Option<f64>,
) -> Box<dyn Run + '_> {
    Box::new(OneByOne::new(elements, Output::GapHessian, move |elements, index, gradient, hessian| {
        gap(&elements.held(index), gradient, hessian)
    }))
}

/// A number the gap can be a function of.
trait Number: DualNum<Primitive = f64> + Copy {}
impl<D: DualNum<Primitive = f64> + Copy> Number for D {}

/// Gap, N and M by one evaluation over numbers with a gradient of `C` = 3 (n + 1) entries and a Hessian of `C`².
/// `None` if the element has no gap.
///
/// # Panics
/// If `C` is another number, or a slice is too short.
pub fn by_vectors<const C: usize>(
    element: &Element<'_>,
    gradient: &mut [f64],
    hessian: &mut [f64],
) -> Option<f64> {
    assert_eq!(C, element.degrees_of_freedom());
    let foot = RealFoot::find(element)?;
    let seed = |x: f64, freedom: usize| Dual2SVec64::<C>::from_re(x).derivative(freedom);
    let gap = foot.follow(&fit(element, seed)?);
    gradient[..C].copy_from_slice(gap.v1.unwrap_generic(U1, Const::<C>).as_slice());
    let m = gap.v2.unwrap_generic(Const::<C>, Const::<C>);
    for i in 0..C {
        for j in 0..=i {
            hessian[i * (i + 1) / 2 + j] = m[(i, j)] / element.support_radius;
        }
    }
    Some(gap.re * element.support_radius)
}

/// Gap, N and M by one evaluation over hyper-dual numbers for each entry of the lower triangle. `None` if the element has
/// no gap.
///
/// # Panics
/// If a slice is too short.
pub fn by_pairs(element: &Element<'_>, gradient: &mut [f64], hessian: &mut [f64]) -> Option<f64> {
    let foot = RealFoot::find(element)?;
    let mut value = 0.0;
    for i in 0..element.degrees_of_freedom() {
        for j in 0..=i {
            let seed = |x: f64, freedom: usize| {
                let [first, second] = [i, j].map(|k| f64::from(u8::from(k == freedom)));
                HyperDual64::new(x, first, second, 0.0)
            };
            let gap = foot.follow(&fit(element, seed)?);
            hessian[i * (i + 1) / 2 + j] = gap.eps1eps2 / element.support_radius;
            (gradient[i], value) = (gap.eps1, gap.re);
        }
    }
    Some(value * element.support_radius)
}

/// α of the fit. `seed` makes numbers of coordinates over R, given their place among the degrees of freedom.
fn fit<D: Number>(element: &Element<'_>, seed: impl Fn(f64, usize) -> D) -> Option<[D; 6]> {
    let rows = element.frame.rows();
    // The slave is the origin: derivatives do not depend on where that is.
    let slave: [D; 3] = std::array::from_fn(|k| seed(0.0, k));
    let mut m = [D::zero(); 15];
    let mut vector = [D::zero(); 6];
    for (i, master) in element.masters.iter().enumerate() {
        let [x, y, z] = std::array::from_fn(|k| {
            seed((master[k] - element.slave[k]) / element.support_radius, 3 * (i + 1) + k) - slave[k]
        });
        let [a, b, z] = rows.map(|row| x * row[0] + y * row[1] + z * row[2]);
        let s = a * a + b * b;
        if s.re() >= 1.0 {
            continue;
        }
        // Straight above a node √s has no derivative, and s √s vanishes with its first two.
        let w = if s.re() > 0.0 { s * (s.sqrt() * 2.0 - 3.0) + 1.0 } else { s * -3.0 + 1.0 };
        let (wa, wb) = (w * a, w * b);
        let (waa, wab, wbb) = (wa * a, wa * b, wb * b);
        let (waaa, waab, wabb, wbbb) = (waa * a, waa * b, wbb * a, wbb * b);
        let values = [
            w,
            wa,
            wb,
            waa,
            wab,
            wbb,
            waaa,
            waab,
            wabb,
            wbbb,
            waaa * a,
            waaa * b,
            waab * b,
            wabb * b,
            wbbb * b,
        ];
        for (moment, value) in m.iter_mut().zip(&values) {
            *moment += *value;
        }
        for (entry, value) in vector.iter_mut().zip(&values) {
            *entry += z * value;
        }
    }
    let mut matrix: [[D; 6]; 6] = std::array::from_fn(|i| std::array::from_fn(|j| m[MOMENTS[i][j]]));
    solve(&mut matrix, &mut vector)?;
    Some(vector)
}

/// Solves A x = b by A = L D Lᵀ, in place; `None` if a pivot is too small.
fn solve<D: Number>(matrix: &mut [[D; 6]; 6], vector: &mut [D; 6]) -> Option<()> {
    let mut reciprocals = [D::zero(); 6];
    for j in 0..6 {
        let diagonal = matrix[j][j].re();
        // Row j holds L D until its pivot is known.
        let mut scaled = [D::zero(); 6];
        for k in 0..j {
            scaled[k] = matrix[j][k] * reciprocals[k];
            let product = matrix[j][k] * scaled[k];
            matrix[j][j] -= product;
        }
        for i in j + 1..6 {
            for k in 0..j {
                let product = matrix[i][k] * scaled[k];
                matrix[i][j] -= product;
            }
        }
        if !(matrix[j][j].re() > 1e-7 * diagonal) {
            return None;
        }
        reciprocals[j] = matrix[j][j].recip();
    }
    for i in 0..6 {
        for k in 0..i {
            let product = matrix[i][k] * vector[k];
            vector[i] -= product;
        }
        vector[i] *= reciprocals[i];
    }
    for i in (0..6).rev() {
        for k in i + 1..6 {
            let product = matrix[k][i] * reciprocals[i] * vector[k];
            vector[i] -= product;
        }
    }
    Some(())
}

/// f and its slopes at u.
fn surface<D: Number>(alpha: &[D; 6], [a, b]: [D; 2]) -> (D, [D; 2]) {
    let slopes = [alpha[1] + alpha[3] * a * 2.0 + alpha[4] * b, alpha[2] + alpha[4] * a + alpha[5] * b * 2.0];
    let f = alpha[0] + ((alpha[1] + slopes[0]) * a + (alpha[2] + slopes[1]) * b) * 0.5;
    (f, slopes)
}

/// Foot equations F_k = −u_k − f f_k.
fn residual<D: Number>(alpha: &[D; 6], u: [D; 2]) -> [D; 2] {
    let (f, slopes) = surface(alpha, u);
    [0, 1].map(|k| -u[k] - f * slopes[k])
}

/// The foot on reals.
struct RealFoot {
    u: [f64; 2],
    /// J⁻¹, entries 11, 12, 22.
    inverse: [f64; 3],
}

impl RealFoot {
    fn find(element: &Element<'_>) -> Option<Self> {
        let alpha = fit(element, |x, _| x)?;
        let mut u = [0.0; 2];
        for _ in 0..MOST_ITERATIONS {
            let inverse = inverse_jacobian(&alpha, u);
            let [r_1, r_2] = residual(&alpha, u);
            let step = [inverse[0] * r_1 + inverse[1] * r_2, inverse[1] * r_1 + inverse[2] * r_2];
            u = [u[0] - step[0], u[1] - step[1]];
            let [size, length] = [step[0].hypot(step[1]), u[0].hypot(u[1])];
            if !(length <= 1.0) {
                return None;
            }
            if size <= 1e-10 * length + 1e-15 {
                return Some(Self { u, inverse: inverse_jacobian(&alpha, u) });
            }
        }
        None
    }

    /// The gap on the surface with dual coefficients: two steps from the real foot, each of which makes one more order
    /// of derivatives exact.
    fn follow<D: Number>(&self, alpha: &[D; 6]) -> D {
        let mut u = self.u.map(D::from);
        for _ in 0..2 {
            let [r_1, r_2] = residual(alpha, u);
            let [i_11, i_12, i_22] = self.inverse;
            u = [u[0] - (r_1 * i_11 + r_2 * i_12), u[1] - (r_1 * i_12 + r_2 * i_22)];
        }
        let (f, [f_1, f_2]) = surface(alpha, u);
        (u[0] * f_1 + u[1] * f_2 - f) / (f_1 * f_1 + f_2 * f_2 + 1.0).sqrt()
    }
}

/// Inverse of J_kl = −δ_kl − f_k f_l − f f_kl.
fn inverse_jacobian(alpha: &[f64; 6], u: [f64; 2]) -> [f64; 3] {
    let (f, [f_1, f_2]) = surface(alpha, u);
    let [j_11, j_12, j_22] = [
        -1.0 - f_1 * f_1 - 2.0 * f * alpha[3],
        -f_1 * f_2 - f * alpha[4],
        -1.0 - f_2 * f_2 - 2.0 * f * alpha[5],
    ];
    let determinant = j_11 * j_22 - j_12 * j_12;
    [j_22 / determinant, -j_12 / determinant, j_11 / determinant]
}
