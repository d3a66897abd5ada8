//! The gap element written by hand: the opponent that counts.
//!
//! Quadratic basis, cubic weight, held frame (Chamoret et al. 2008, eqs. 13, 14, 19, 22, 32, 42), the number of
//! nodes known at compile time, no allocation. What somebody who knows the element and wants it fast would write:
//!
//! * weights with closed-form derivatives, the 15 different moments only, an unrolled 6 × 6 Cholesky factorisation;
//! * the fit as the stationary value of Λ = p(u)·α + Σ w (λ·p)(z − p·α), so that nothing is differentiated through
//!   the factorisation, and the foot by the implicit function theorem;
//! * M = block diagonal + F G ᵀ + G Fᵀ with F = B̂ᵀ = (L⁻¹B)ᵀ and G = Ĉᵀ, both with six columns. What the foot adds is a
//!   form in the three rows ∇f, T_1, T_2, which lie in the row space of B̂, and is folded into Ĉ;
//! * the factors are rotated to global axes, not the finished matrix, and the slave is one more node whose factors are
//!   minus the sum of the others;
//! * only the lower triangle is computed, where it is wanted;
//! * multiply-adds are fused where the program is compiled for a processor that has them (`-C target-cpu=native`).
//!
//! Derivatives are written out here and nowhere else in the workspace.

mod fit;

use diffuse_contact::{ContactPoint, Element};
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Matrix6x3, SMatrix, Vector3, Vector6};

use fit::{Node, cholesky, foot, inverse, moments};

use crate::Elements;
use crate::contender::{Output, Run};
use crate::one_by_one::OneByOne;

/// a b + c, fused where the compiler may use the instruction: elsewhere that would be a call.
#[inline(always)]
fn fma(a: f64, b: f64, c: f64) -> f64 {
    if cfg!(any(target_feature = "fma", target_arch = "aarch64")) { a.mul_add(b, c) } else { a * b + c }
}

/// `sum` + `a` `b`. (nalgebra's products are not fused.)
#[inline(always)]
fn add_product<const R: usize, const K: usize, const C: usize>(
    mut sum: SMatrix<f64, R, C>,
    a: &SMatrix<f64, R, K>,
    b: &SMatrix<f64, K, C>,
) -> SMatrix<f64, R, C> {
    let (a, b) = (&a.data.0, &b.data.0);
    for (column, factors) in sum.data.0.iter_mut().zip(b) {
        for k in 0..K {
            for i in 0..R {
                column[i] = fma(a[k][i], factors[k], column[i]);
            }
        }
    }
    sum
}

/// `a` `b`
#[inline(always)]
fn product<const R: usize, const K: usize, const C: usize>(
    a: &SMatrix<f64, R, K>,
    b: &SMatrix<f64, K, C>,
) -> SMatrix<f64, R, C> {
    add_product(SMatrix::zeros(), a, b)
}

/// The contender for these elements; `None` if they have fewer than 6 or more than 24 nodes.
pub fn prepare(elements: &Elements) -> Option<Box<dyn Run + '_>> {
    macro_rules! by_nodes {
        ($($nodes:literal)*) => {
            match elements.nodes() {
                $($nodes => Some(boxed::<$nodes, { 3 * ($nodes + 1) }>(elements)),)*
                _ => None,
            }
        };
    }
    by_nodes!(6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24)
}

fn boxed<const N: usize, const C: usize>(elements: &Elements) -> Box<dyn Run + '_> {
    let mut by_hand = ByHand::<N, C>::default();
    Box::new(OneByOne::new(elements, Output::GapHessian, move |elements, index, gradient, hessian| {
        let point = by_hand.gap(&elements.held(index), gradient, hessian)?;
        // Foot and normal count as used, too.
        Some(std::hint::black_box(point).gap)
    }))
}

/// The element for `N` master nodes; `C`, the number of coordinates, has to be 3 (`N` + 1).
#[derive(Clone, Debug)]
pub struct ByHand<const N: usize, const C: usize> {
    nodes: [Node; N],
    /// B̂ᵀ and Ĉᵀ in global axes, slave first.
    factors: [SMatrix<f64, C, 6>; 2],
}

impl<const N: usize, const C: usize> Default for ByHand<N, C> {
    fn default() -> Self {
        Self { nodes: [Node::default(); N], factors: [SMatrix::zeros(); 2] }
    }
}

impl<const N: usize, const C: usize> ByHand<N, C> {
    const SIZES_FIT: () = assert!(C == 3 * (N + 1), "C is the number of coordinates, 3 (N + 1)");

    /// Gap, foot and normal; N into `gradient` and the packed lower triangle of M into `hessian`, as
    /// [`Generated::gap_into`](diffuse_contact::Generated::gap_into) does. `None` if the element has no gap.
    ///
    /// # Panics
    /// If the element has another number of masters, or a slice is too short.
    pub fn gap(
        &mut self,
        element: &Element<'_>,
        gradient: &mut [f64],
        hessian: &mut [f64],
    ) -> Option<ContactPoint> {
        let () = Self::SIZES_FIT;
        let masters: &[_; N] = element.masters.try_into().expect("as many masters as the kernel is for");
        let (gradient, hessian) = (&mut gradient[..C], &mut hessian[..C * (C + 1) / 2]);
        let radius = element.support_radius;
        let per_radius = 1.0 / radius;
        let [t1, t2, normal] = element.frame.rows().map(Vector3::from);
        let slave = Vector3::from(element.slave);
        for (node, master) in self.nodes.iter_mut().zip(masters) {
            let offset = (Vector3::from(*master) - slave) * per_radius;
            *node = Node::new([t1.dot(&offset), t2.dot(&offset), normal.dot(&offset)]);
        }

        let (matrix, beta) = moments(&self.nodes);
        let (l, reciprocals) = cholesky(matrix)?;
        let l_inverse = inverse(&l, &reciprocals);
        let l_transposed = l_inverse.transpose();
        let alpha = product(&l_transposed, &product(&l_inverse, &beta));
        let foot = foot(&alpha)?;

        let [a, b] = foot.u;
        // p, ∂p/∂a, ∂p/∂b at the foot; G = L⁻¹ of them; λ = L⁻ᵀ G.
        let p = Matrix6x3::from_columns(&[
            Vector6::new(1.0, a, b, a * a, a * b, b * b),
            Vector6::new(0.0, 1.0, 0.0, 2.0 * a, b, 0.0),
            Vector6::new(0.0, 0.0, 1.0, 0.0, a, 2.0 * b),
        ]);
        let g = product(&l_inverse, &p);
        let lambda = product(&l_transposed, &g);

        let [f_1, f_2] = foot.slopes;
        let ell = (1.0 + f_1 * f_1 + f_2 * f_2).sqrt();
        let gap = -foot.f * ell;
        let form = foot_form(&foot, ell);

        // M = scale (blocks + Ĉᵀ B̂ + B̂ᵀ Ĉ), where Ĉ has taken in the foot's form: Vᵀ c V with V = Gᵀ B̂.
        let scale = -per_radius / ell;
        let folded = product(&g, &form) * (-0.5 * ell);
        let axes = Matrix3::from_columns(&[t1, t2, normal]);
        let mut blocks = [Matrix3::zeros(); N];
        let mut slave_sums = [SMatrix::<f64, 3, 6>::zeros(); 2];
        let mut slave_gradient = Vector3::zeros();
        let [b_factor, c_factor] = &mut self.factors;
        for (i, node) in self.nodes.iter().enumerate() {
            let part = NodePart::new(node, &alpha, &lambda, &l_inverse);
            let v = part.gradients;
            let c_local = add_product(part.c_hat, &folded, &v.transpose());
            let row = 3 * (i + 1);
            let b_global = product(&axes, &part.b_hat.transpose());
            let c_global = product(&axes, &(c_local.transpose() * scale));
            b_factor.fixed_rows_mut::<3>(row).copy_from(&b_global);
            c_factor.fixed_rows_mut::<3>(row).copy_from(&c_global);
            slave_sums[0] -= b_global;
            slave_sums[1] -= c_global;
            blocks[i] = product(&product(&axes, &(part.block * scale)), &axes.transpose());
            let n = product(&axes, &(v.column(0) * (-1.0 / ell)));
            gradient[row..row + 3].copy_from_slice(n.as_slice());
            slave_gradient -= n;
        }
        gradient[..3].copy_from_slice(slave_gradient.as_slice());
        b_factor.fixed_rows_mut::<3>(0).copy_from(&slave_sums[0]);
        c_factor.fixed_rows_mut::<3>(0).copy_from(&slave_sums[1]);
        lower_triangle(b_factor, c_factor, hessian);
        add_blocks(&blocks, hessian);

        let nu = axes * Vector3::new(-f_1, -f_2, 1.0) / ell;
        let foot = slave + axes * Vector3::new(a, b, foot.f) * radius;
        Some(ContactPoint { gap: gap * radius, foot: foot.into(), normal: nu.into() })
    }
}

/// The symmetric form c of what the motion of the foot adds to M: Σ c_ab v_a v_bᵀ with v = (∇f, T_1, T_2), lengths
/// over R.
#[inline(always)]
fn foot_form(foot: &fit::Point, ell: f64) -> Matrix3<f64> {
    let [f_1, f_2] = foot.slopes;
    let [f_11, f_12, f_22] = foot.curvatures;
    let h = -foot.f;
    let [j_11, j_12, j_22] = foot.jacobian();
    let reciprocal = 1.0 / (j_11 * j_22 - j_12 * j_12);
    let inverse = Matrix2::new(j_22, -j_12, -j_12, j_11) * reciprocal;
    // S = X v, D = Y v (Chamoret et al. 2008, eqs. 39 and 41).
    let x = inverse * Matrix2x3::new(f_1, -h, 0.0, f_2, 0.0, -h);
    let e = Matrix2x3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
    let y = e + Matrix2::new(f_11, f_12, f_12, f_22) * x;
    let squares = 1.0 / (ell * ell);
    let metric = Matrix2::new(
        1.0 - f_1 * f_1 * squares,
        -f_1 * f_2 * squares,
        -f_1 * f_2 * squares,
        1.0 - f_2 * f_2 * squares,
    );
    // g / ℓ² = h / ℓ
    (y.tr_mul(&(metric * y)) * h - e.tr_mul(&x) - x.tr_mul(&y)) / ell
}

/// What one master node contributes, in local axes.
struct NodePart {
    /// Rows of ∇f, T_1 and T_2, as columns.
    gradients: Matrix3<f64>,
    b_hat: Matrix6x3<f64>,
    c_hat: Matrix6x3<f64>,
    /// Second derivatives of w e σ with α and λ held.
    block: Matrix3<f64>,
}

impl NodePart {
    #[inline(always)]
    fn new(
        node: &Node,
        alpha: &Vector6<f64>,
        lambda: &Matrix6x3<f64>,
        l_inverse: &nalgebra::Matrix6<f64>,
    ) -> Self {
        let &Node { a, b, z, w, slope, curvature } = node;
        // (1, a, b, a², ab, b²) · c and its derivatives.
        let value = |c: &[f64; 6]| {
            let along_a = fma(b, c[4], fma(a, c[3], c[1]));
            fma(b, fma(b, c[5], c[2]), fma(a, along_a, c[0]))
        };
        let along_a = |c: &[f64; 6]| fma(b, c[4], fma(2.0 * a, c[3], c[1]));
        let along_b = |c: &[f64; 6]| fma(2.0 * b, c[5], fma(a, c[4], c[2]));
        // x · y
        let dot = |x: [f64; 2], y: [f64; 2]| fma(x[0], y[0], x[1] * y[1]);
        let alpha: &[f64; 6] = alpha.as_ref();
        let lambda: &[[f64; 6]; 3] = lambda.as_ref();

        let (w_a, w_b) = (slope * a, slope * b);
        let (cu_a, cu_b) = (curvature * a, curvature * b);
        let (w_aa, w_ab, w_bb) = (fma(cu_a, a, slope), cu_a * b, fma(cu_b, b, slope));
        let (e, e_a, e_b) = (z - value(alpha), -along_a(alpha), -along_b(alpha));
        let (we, we_a, we_b) = (w * e, dot([w_a, w], [e, e_a]), dot([w_b, w], [e, e_b]));
        let gradients = Matrix3::from_columns(&[0, 1, 2].map(|k| {
            let (c, s) = (&lambda[k], value(&lambda[k]));
            Vector3::new(dot([we_a, we], [s, along_a(c)]), dot([we_b, we], [s, along_b(c)]), w * s)
        }));

        let c = &lambda[0];
        let (s, s_a, s_b) = (value(c), along_a(c), along_b(c));
        let (ws, ws_a, ws_b) = (w * s, dot([w_a, w], [s, s_a]), dot([w_b, w], [s, s_b]));
        let (es_a, es_b) = (dot([e_a, e], [s, s_a]), dot([e_b, e], [s, s_b]));
        let second = |k: usize| fma(e, c[k], -s * alpha[k]);
        let es = e * s;
        let aa = fma(w_aa, es, 2.0 * fma(w_a, es_a, w * fma(e_a, s_a, second(3))));
        let bb = fma(w_bb, es, 2.0 * fma(w_b, es_b, w * fma(e_b, s_b, second(5))));
        let mixed = fma(e_a, s_b, fma(e_b, s_a, second(4)));
        let ab = fma(w_ab, es, fma(w_a, es_b, fma(w_b, es_a, w * mixed)));
        let block = Matrix3::new(aa, ab, ws_a, ab, bb, ws_b, ws_a, ws_b, 0.0);

        // L⁻¹ p, L⁻¹ ∂p/∂a, L⁻¹ ∂p/∂b: columns of L⁻¹ times the few entries that are not zero.
        let l = &l_inverse.data.0;
        let (aa, ab, bb) = (a * a, a * b, b * b);
        let [mut b_hat, mut c_hat] = [Matrix6x3::zeros(); 2];
        for i in 0..6 {
            let linear = fma(l[2][i], b, fma(l[1][i], a, l[0][i]));
            let p = fma(l[5][i], bb, fma(l[4][i], ab, fma(l[3][i], aa, linear)));
            let p_a = fma(l[4][i], b, fma(l[3][i], 2.0 * a, l[1][i]));
            let p_b = fma(l[5][i], 2.0 * b, fma(l[4][i], a, l[2][i]));
            b_hat.data.0[0][i] = dot([p, p_a], [we_a, we]);
            b_hat.data.0[1][i] = dot([p, p_b], [we_b, we]);
            b_hat.data.0[2][i] = p * w;
            c_hat.data.0[0][i] = -dot([p, p_a], [ws_a, ws]);
            c_hat.data.0[1][i] = -dot([p, p_b], [ws_b, ws]);
        }
        Self { gradients, b_hat, c_hat, block }
    }
}

/// The packed lower triangle of F Gᵀ + G Fᵀ, three rows at a time: they share what is read of F and G.
#[inline(always)]
fn lower_triangle<const C: usize>(f: &SMatrix<f64, C, 6>, g: &SMatrix<f64, C, 6>, packed: &mut [f64]) {
    let (f, g) = (&f.data.0, &g.data.0);
    let mut rest = packed;
    for first in (0..C).step_by(3) {
        let (x, after) = rest.split_at_mut(first + 1);
        let (y, after) = after.split_at_mut(first + 2);
        let (z, after) = after.split_at_mut(first + 3);
        rest = after;
        let rows = |columns: &[[f64; C]; 6]| -> [[f64; 6]; 3] {
            std::array::from_fn(|m| std::array::from_fn(|k| columns[k][first + m]))
        };
        let (f_rows, g_rows) = (rows(f), rows(g));
        let entry = |m: usize, j: usize| {
            (0..6).fold(0.0, |sum, k| fma(g_rows[m][k], f[k][j], fma(f_rows[m][k], g[k][j], sum)))
        };
        for j in 0..first {
            let mut sums = [0.0; 3];
            for k in 0..6 {
                for m in 0..3 {
                    sums[m] = fma(g_rows[m][k], f[k][j], fma(f_rows[m][k], g[k][j], sums[m]));
                }
            }
            (x[j], y[j], z[j]) = (sums[0], sums[1], sums[2]);
        }
        x[first] = entry(0, first);
        for l in 0..2 {
            y[first + l] = entry(1, first + l);
        }
        for l in 0..3 {
            z[first + l] = entry(2, first + l);
        }
    }
}

/// Adds the masters' diagonal blocks, and to the slave's rows and columns what translation invariance asks for.
#[inline(always)]
fn add_blocks(blocks: &[Matrix3<f64>], packed: &mut [f64]) {
    let mut sum = Matrix3::zeros();
    for (i, block) in blocks.iter().enumerate() {
        sum += block;
        for k in 0..3 {
            let row = 3 * (i + 1) + k;
            let start = row * (row + 1) / 2;
            for l in 0..3 {
                packed[start + l] -= block[(k, l)];
            }
            for l in 0..=k {
                packed[start + 3 * (i + 1) + l] += block[(k, l)];
            }
        }
    }
    for k in 0..3 {
        for l in 0..=k {
            packed[k * (k + 1) / 2 + l] += sum[(k, l)];
        }
    }
}

#[cfg(test)]
mod tests {
    use diffuse_contact::{Generated, Mode};

    use super::*;
    use crate::Elements;

    /// Largest difference of an entry over the largest entry.
    fn difference(found: &[f64], expected: &[f64]) -> f64 {
        let size = expected.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
        // A NaN stays.
        let worse = |x: f64, y: f64| if x.is_nan() || x > y { x } else { y };
        found.iter().zip(expected).map(|(x, y)| (x - y).abs() / size).fold(0.0, worse)
    }

    fn agrees<const N: usize, const C: usize>() {
        let elements = Elements::new(N, 20).unwrap();
        let mut by_hand = ByHand::<N, C>::default();
        let [mut n, mut expected_n] = [vec![f64::NAN; C], vec![0.0; C]];
        let [mut m, mut expected_m] = [vec![f64::NAN; C * (C + 1) / 2], vec![0.0; C * (C + 1) / 2]];
        for index in 0..elements.len() {
            let element = elements.held(index);
            let found = by_hand.gap(&element, &mut n, &mut m).unwrap();
            let expected =
                Generated.gap_into(&element, Mode::Hessian, &mut expected_n, &mut expected_m).unwrap();
            assert!((found.gap - expected.gap).abs() / element.support_radius < 1e-12);
            let offset = |x: [f64; 3]| [0, 1, 2].map(|k| x[k] - element.slave[k]);
            assert!(
                (Vector3::from(offset(found.foot)) - Vector3::from(offset(expected.foot))).norm() < 1e-11
            );
            assert!(difference(&found.normal, &expected.normal) < 1e-12);
            let [n, m] = [difference(&n, &expected_n), difference(&m, &expected_m)];
            assert!(n < 1e-11 && m < 1e-11, "{N} nodes, element {index}: N {n:e}, M {m:e}");
        }
    }

    #[test]
    fn it_agrees_with_the_generated_kernels() {
        agrees::<6, 21>();
        agrees::<7, 24>();
        agrees::<12, 39>();
        agrees::<24, 75>();
    }

    #[test]
    fn a_slave_above_a_node_is_no_exception() {
        let masters = [
            [0.0, 0.0, 0.1],
            [1.0, 0.1, 0.0],
            [0.2, 1.0, 0.1],
            [-0.9, 0.8, 0.0],
            [-1.0, -0.3, 0.0],
            [0.1, -0.9, 0.1],
            [0.9, -0.8, 0.2],
        ];
        let frame =
            diffuse_contact::Frame::given([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], None);
        let element = Element::new([0.0, 0.0, 0.2], &masters, frame.unwrap(), 1.6)
            .with_basis(diffuse_contact::Basis::Quadratic)
            .with_weight(diffuse_contact::Weight::Cubic);
        let (mut n, mut m, mut expected_n, mut expected_m) = ([0.0; 24], [0.0; 300], [0.0; 24], [0.0; 300]);
        ByHand::<7, 24>::default().gap(&element, &mut n, &mut m).unwrap();
        Generated.gap_into(&element, Mode::Hessian, &mut expected_n, &mut expected_m).unwrap();
        assert!(difference(&n, &expected_n) < 1e-12 && difference(&m, &expected_m) < 1e-12);
    }

    #[test]
    fn nodes_on_a_circle_have_no_gap() {
        let masters: [[f64; 3]; 6] =
            std::array::from_fn(|k| [(1.1 * k as f64).cos(), (1.1 * k as f64).sin(), 0.0]);
        let frame =
            diffuse_contact::Frame::given([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], None);
        let element = Element::new([0.1, 0.0, 0.2], &masters, frame.unwrap(), 1.6);
        assert!(ByHand::<6, 21>::default().gap(&element, &mut [0.0; 21], &mut [0.0; 231]).is_none());
    }
}
