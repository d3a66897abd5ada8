//! The average plane of the masters on dual numbers, for a frame that moves with them.
//!
//! n̂ minimises Σ ω_i (n·(x_i − x̄))² over unit vectors: C n̂ = λ n̂ with the smallest eigenvalue of the scatter matrix
//! C = Σ ω_i (x_i − x̄)(x_i − x̄)ᵀ, x̄ the mean with the same weights. On reals n̂ is known: it is the given frame's normal. Its
//! derivatives come from Newton steps on C n = λ n over dual numbers taken at the given normal, as those of the foot do: no derivative of
//! the plane is written down.

use super::linear::{Scalar, dot, inverse};
use crate::{Element, ElementError, Point};

/// A pivot of the real equations for the plane's turn has to exceed this fraction of the principal moment it
/// came from.
const PIVOT_TOLERANCE: f64 = 1e-10;
/// The given normal may be this far, in radians, from that of the average plane. An eigenvector of nodes that
/// [`Frame::average_plane`](crate::Frame::average_plane) accepts is off by 1e-8 at worst.
const TURN_TOLERANCE: f64 = 1e-6;
/// Newton steps over dual numbers. With the real Jacobian of the given normal each step makes one more order of
/// derivatives exact: two are needed, the others wash out rounding.
const PROPAGATION_STEPS: usize = 4;

/// A rotation matrix by rows, in the axes of the given frame: its real part is the identity.
pub(super) type Turn<D> = [[D; 3]; 3];

/// Symmetric 3 × 3 matrix: 11, 12, 22, 13, 23, 33.
type Scatter<D> = [D; 6];

/// The average plane on reals, with what dual numbers need to follow it.
pub(super) struct AveragePlane {
    axes: [Point; 3],
    /// A point near the mean of the masters, held constant. C does not depend on it but for rounding.
    centre: Point,
    /// Largest distance of a master from the centre along a global axis.
    size: f64,
    inverse_jacobian: [[f64; 2]; 2],
}

impl AveragePlane {
    /// The plane of an element whose frame is its masters' average plane.
    ///
    /// # Errors
    /// [`ElementError::UnstableAveragePlane`] if the plane is not unique to working precision, or if the given
    /// one is not the thinnest; [`ElementError::NotAveragePlane`] if the given normal is not stationary: the
    /// deviation is the angle in radians by which it misses.
    ///
    /// `weights`: of the masters.
    pub(super) fn find(element: &Element<'_>, weights: &[f64]) -> Result<Self, ElementError> {
        let masters = element.masters;
        // Mean of differences from the first node: far from the origin the plain mean loses digits.
        let mean_offset = |k: usize| masters.iter().map(|x| x[k] - masters[0][k]).sum::<f64>();
        let centre: Point = std::array::from_fn(|k| masters[0][k] + mean_offset(k) / masters.len() as f64);
        let extent = |x: &Point| (0..3).map(|k| (x[k] - centre[k]).abs()).fold(0.0, f64::max);
        let size = masters.iter().map(extent).fold(0.0, f64::max);
        super::finite("offset", centre.into_iter().chain([size]))?;
        let unstable = |pivot_ratio| Err(ElementError::UnstableAveragePlane { pivot_ratio });
        if size == 0.0 {
            return unstable(0.0);
        }
        let plane = Self { axes: element.frame.rows(), centre, size, inverse_jacobian: [[0.0; 2]; 2] };
        let scatter = plane.scatter(masters, weights);

        // Jacobian of the residual at no turn: C_kl − δ_kl λ, positive definite at the thinnest plane.
        let [c_11, c_12, c_22, _, _, c_33] = scatter;
        let [j_11, j_12, j_22] = [c_11 - c_33, c_12, c_22 - c_33];
        let relative = |pivot: f64, moment: f64| if moment > 0.0 { pivot / moment } else { 0.0 };
        let first = relative(j_11, c_11);
        if !(first > PIVOT_TOLERANCE) {
            return unstable(first);
        }
        let second = relative(j_22 - j_12 * j_12 / j_11, c_22);
        if !(second > PIVOT_TOLERANCE) {
            return unstable(second);
        }
        let plane = Self { inverse_jacobian: inverse(&[[j_11, j_12], [j_12, j_22]]), ..plane };

        let deviation =
            plane.step(residual(&scatter, [0.0; 2])).map(f64::abs).into_iter().fold(0.0, f64::max);
        if !(deviation <= TURN_TOLERANCE) {
            return Err(ElementError::NotAveragePlane { angle: deviation });
        }
        Ok(plane)
    }

    /// How the given frame turns with the plane of dual masters: the axes of the moved frame in those of the
    /// given one. In the plane it turns as little as it can, which is of no consequence to the gap.
    pub(super) fn propagate<D: Scalar>(&self, masters: &[[D; 3]], weights: &[D]) -> Turn<D> {
        let scatter = self.scatter(masters, weights);
        let mut slopes = [D::zero(); 2];
        // The rounding error of the given normal; without it the real part stays that normal.
        let rest = residual(&scatter, slopes).map(|r| r.re());
        for _ in 0..PROPAGATION_STEPS {
            let [r_1, r_2] = residual(&scatter, slopes);
            let step = self.step([r_1 - rest[0], r_2 - rest[1]]);
            slopes = [slopes[0] - step[0], slopes[1] - step[1]];
        }
        let normal = normalised([slopes[0], slopes[1], D::one()]);
        let axis = |k: usize| std::array::from_fn(|l| if k == l { D::one() } else { D::zero() });
        let t1 = normalised(without(axis(0), normal));
        let t2 = normalised(without(without(axis(1), normal), t1));
        [t1, t2, normal]
    }

    /// C in the axes of the given frame, lengths over the size of the patch. The mean is subtracted from the
    /// moments: about the centre it is nearly zero.
    fn scatter<D: Scalar>(&self, masters: &[[D; 3]], weights: &[D]) -> Scatter<D> {
        let mut moments = [D::zero(); 6];
        let mut sum = [D::zero(); 3];
        let mut total_weight = D::zero();
        for (master, &weight) in masters.iter().zip(weights) {
            total_weight += weight;
            let [x, y, z] = std::array::from_fn(|k| (master[k] - self.centre[k]) / self.size);
            let offset = self.axes.map(|axis| x * axis[0] + y * axis[1] + z * axis[2]);
            for (total, part) in sum.iter_mut().zip(offset) {
                *total += weight * part;
            }
            for (moment, product) in moments.iter_mut().zip(products(offset)) {
                *moment += weight * product;
            }
        }
        let of_sum = products(sum);
        std::array::from_fn(|k| moments[k] - of_sum[k] / total_weight)
    }

    fn step<D: Scalar>(&self, [r_1, r_2]: [D; 2]) -> [D; 2] {
        self.inverse_jacobian.map(|[j_1, j_2]| r_1 * j_1 + r_2 * j_2)
    }
}

fn products<D: Scalar>([a, b, z]: [D; 3]) -> Scatter<D> {
    [a * a, a * b, b * b, a * z, b * z, z * z]
}

/// In-plane components of C n − λ n for n = (slopes, 1), where its third component, which gives λ, vanishes.
fn residual<D: Scalar>([c_11, c_12, c_22, c_13, c_23, c_33]: &Scatter<D>, [p, q]: [D; 2]) -> [D; 2] {
    let lambda = *c_13 * p + *c_23 * q + *c_33;
    [*c_11 * p + *c_12 * q + *c_13 - lambda * p, *c_12 * p + *c_22 * q + *c_23 - lambda * q]
}

fn normalised<D: Scalar>(x: [D; 3]) -> [D; 3] {
    let length = dot(x, x).sqrt();
    x.map(|x| x / length)
}

/// `x` without its component along the unit vector `y`.
fn without<D: Scalar>(x: [D; 3], y: [D; 3]) -> [D; 3] {
    let along = dot(x, y);
    std::array::from_fn(|k| x[k] - y[k] * along)
}

#[cfg(test)]
mod tests {
    use num_dual::{Dual3, DualNum, HyperDual};

    use super::*;
    use crate::{Basis, Frame};

    const MASTERS: [Point; 5] =
        [[1.0, 0.1, 0.2], [-0.3, 0.9, -0.1], [-1.1, -0.2, 0.05], [0.2, -1.3, 0.3], [0.4, 0.3, -0.2]];

    fn element(masters: &[Point], frame: Frame) -> Element<'_> {
        Element::new([0.0; 3], masters, frame, 2.0).with_basis(Basis::Linear)
    }

    fn plane(masters: &[Point]) -> (AveragePlane, Frame) {
        let frame = Frame::average_plane(masters, [0.1, 0.2, 1.0]).unwrap();
        (AveragePlane::find(&element(masters, frame), &vec![1.0; masters.len()]).unwrap(), frame)
    }

    /// Each order of a dual number is settled by one more step: what is left after the last one is rounding,
    /// up to third order.
    #[test]
    fn the_plane_is_that_of_the_dual_masters() {
        let (plane, _) = plane(&MASTERS);
        let t = Dual3::from_re(0.0).derivative();
        let moved: Vec<[Dual3<f64>; 3]> = MASTERS
            .iter()
            .enumerate()
            .map(|(i, x)| std::array::from_fn(|k| t * (1.3 * (3 * i + k) as f64).sin() + x[k]))
            .collect();
        let weights = [Dual3::from_re(1.0); 5];
        let [t1, t2, n] = plane.propagate(&moved, &weights);
        let scatter = plane.scatter(&moved, &weights);
        let [r_1, r_2] = residual(&scatter, [n[0] / n[2], n[1] / n[2]]);
        for r in [r_1, r_2] {
            assert!(r.v1.abs() < 1e-14 && r.v2.abs() < 1e-13 && r.v3.abs() < 1e-12, "{r:?}");
        }
        assert!(n[0].v2.abs() > 1e-2 && n[0].v3.abs() > 1e-2);
        for (product, expected) in
            [(dot(n, n), 1.0), (dot(t1, t1), 1.0), (dot(t2, t2), 1.0), (dot(n, t1), 0.0), (dot(n, t2), 0.0)]
        {
            let product = product - expected;
            assert!(product.re.abs() < 1e-15 && product.v1.abs() < 1e-14 && product.v2.abs() < 1e-13);
        }
    }

    /// Turning the masters rigidly turns the plane with them: n = (sin φ, 0, cos φ).
    #[test]
    fn a_rigid_turn_is_followed() {
        let (plane, frame) = plane(&MASTERS);
        let phi = HyperDual::from_re(0.0).derivative1().derivative2();
        let (s, c) = (phi.sin(), phi.cos());
        let [t1, t2, n] = frame.rows();
        let turned: Vec<[HyperDual<f64>; 3]> = MASTERS
            .iter()
            .map(|x| {
                let [a, b, z] = [t1, t2, n].map(|axis| (0..3).map(|k| axis[k] * x[k]).sum::<f64>());
                let (a, z) = (c * a + s * z, c * z - s * a);
                std::array::from_fn(|k| a * t1[k] + z * n[k] + b * t2[k])
            })
            .collect();
        let [t1, t2, n] = plane.propagate(&turned, &[HyperDual::from_re(1.0); 5]);
        let expected = [[c, c * 0.0, -s], [c * 0.0, c * 0.0 + 1.0, c * 0.0], [s, c * 0.0, c]];
        for (found, expected) in [t1, t2, n].as_flattened().iter().zip(expected.as_flattened()) {
            assert_eq!(found.re, expected.re);
            assert!((found.eps1 - expected.eps1).abs() < 1e-14);
            assert!((found.eps1eps2 - expected.eps1eps2).abs() < 1e-13);
        }
    }

    #[test]
    fn what_is_not_the_average_plane_is_refused() {
        let find = |masters: &[Point], frame| {
            AveragePlane::find(&element(masters, frame), &vec![1.0; masters.len()]).map(|_| ())
        };
        let (_, frame) = plane(&MASTERS);
        let mut moved = MASTERS;
        moved[2][2] += 1e-4;
        let Err(ElementError::NotAveragePlane { angle: deviation }) = find(&moved, frame) else {
            panic!("accepted")
        };
        assert!(deviation > 1e-5 && deviation < 1e-3);
        // Stationary, but not the thinnest.
        let turned = Frame { t1: frame.t2, t2: frame.normal, normal: frame.t1, ..frame };
        assert!(matches!(find(&MASTERS, turned), Err(ElementError::UnstableAveragePlane { .. })));
        // A line, a point, an octahedron.
        let axis = |k: usize, x: f64| std::array::from_fn(|l| if k == l { x } else { 0.0 });
        let line: Vec<Point> = (0..5).map(|i| [0.1 * f64::from(i), 0.2 * f64::from(i), 0.0]).collect();
        let octahedron: Vec<Point> = (0..6).map(|i| axis(i / 2, [1.0, -1.0][i % 2])).collect();
        let global = Frame::given([0.0; 3], axis(0, 1.0), axis(1, 1.0), axis(2, 1.0), None).unwrap();
        for masters in [line, octahedron, vec![[0.3, 0.4, 0.5]; 6]] {
            let Err(ElementError::UnstableAveragePlane { pivot_ratio }) = find(&masters, global) else {
                panic!("accepted")
            };
            assert!(pivot_ratio.abs() < 1e-13);
        }
    }
}
