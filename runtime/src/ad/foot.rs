//! The fitted polynomial, the foot point of the slave on it, and the gap.
//!
//! Everything is in offsets from the slave over the support radius: the slave is the origin. The foot is found
//! on reals; its derivatives come from Newton steps over dual numbers taken at the converged foot, by which
//! the exact derivatives flow through the iteration itself: no implicit function theorem is written down.

use num_dual::{Dual, HyperDual};

use super::linear::{Coefficients, Scalar, determinant, inverse};
use crate::{Basis, ElementError};

/// Iterations after which the search for the foot gives up.
const MAX_ITERATIONS: usize = 50;
/// Steps are halved at most this often before another direction is tried.
const MAX_HALVINGS: usize = 40;
/// Residual at which the search ends at once, relative to the size of the residual's terms.
const RESIDUAL_GOAL: f64 = 1e-15;
/// Residual accepted when no step makes it smaller: rounding is all that is left.
const RESIDUAL_ACCEPTED: f64 = 1e-12;
/// |det J| at or below this is a centre of curvature; it is at least 1 on a flat surface.
const DETERMINANT_TOLERANCE: f64 = 1e-7;
/// Newton steps over dual numbers. With the real Jacobian of the foot each step makes one more order of
/// derivatives exact: two are needed, the others wash out rounding.
const PROPAGATION_STEPS: usize = 4;

/// Directions of the two in-plane coordinates.
const UNITS: [[f64; 2]; 2] = [[1.0, 0.0], [0.0, 1.0]];

/// The fitted surface z = α·p(a, b).
#[derive(Clone, Copy, Debug)]
pub(super) struct Polynomial<D> {
    pub(super) basis: Basis,
    pub(super) coefficients: Coefficients<D>,
}

impl<D: Scalar> Polynomial<D> {
    /// Height f(u) (Chamoret et al. 2008, eq. 13).
    pub(super) fn value(&self, u: [D; 2]) -> D {
        let terms = basis_functions(self.basis, u).into_iter().zip(self.coefficients);
        terms.take(self.basis.size()).fold(D::zero(), |sum, (p, alpha)| sum + alpha * p)
    }

    fn map<E: Scalar>(&self, f: impl Fn(D) -> E) -> Polynomial<E> {
        let mut coefficients = [E::zero(); Basis::MOST_COEFFICIENTS];
        for (to, from) in coefficients.iter_mut().zip(self.coefficients).take(self.basis.size()) {
            *to = f(from);
        }
        Polynomial { basis: self.basis, coefficients }
    }

    /// Slopes f_1, f_2, by dual numbers over `D`.
    pub(super) fn slopes(&self, [a, b]: [D; 2]) -> [D; 2] {
        let lifted = self.map(Dual::from_re);
        UNITS.map(|[da, db]| lifted.value([Dual::new(a, D::from(da)), Dual::new(b, D::from(db))]).eps)
    }

    /// Second derivatives f_11, f_12, f_22, by hyper-dual numbers over `D`.
    pub(super) fn curvatures(&self, u: [D; 2]) -> [D; 3] {
        let lifted = self.map(HyperDual::from_re);
        let zero = D::from(0.0);
        [(UNITS[0], UNITS[0]), (UNITS[0], UNITS[1]), (UNITS[1], UNITS[1])].map(|(first, second)| {
            let at = |k: usize| HyperDual::new(u[k], D::from(first[k]), D::from(second[k]), zero);
            lifted.value([at(0), at(1)]).eps1eps2
        })
    }

    /// Foot equations F_k = −u_k + h f_k with the slave's height h = −f(u) over the surface: the line from the
    /// foot to the slave is normal to the surface.
    fn residual(&self, u: [D; 2]) -> [D; 2] {
        let height = -self.value(u);
        let [f_1, f_2] = self.slopes(u);
        [height * f_1 - u[0], height * f_2 - u[1]]
    }

    /// Gap g = (x^c − x^d)·ν (Chamoret et al. 2008, eq. 19) with x^c the origin, x^d = (u, f(u)) and
    /// ν = (−f_1, −f_2, 1)/ℓ (eq. 22).
    pub(super) fn gap(&self, u: [D; 2]) -> D {
        let [f_1, f_2] = self.slopes(u);
        let length = (f_1 * f_1 + f_2 * f_2 + 1.0).sqrt();
        (u[0] * f_1 + u[1] * f_2 - self.value(u)) / length
    }
}

impl Polynomial<f64> {
    /// Jacobian ∂F_k/∂u_l of the foot equations, by dual numbers.
    fn jacobian(&self, u: [f64; 2]) -> [[f64; 2]; 2] {
        let lifted = self.map(Dual::from_re);
        let columns =
            UNITS.map(|[da, db]| lifted.residual([Dual::new(u[0], da), Dual::new(u[1], db)]).map(|r| r.eps));
        [[columns[0][0], columns[1][0]], [columns[0][1], columns[1][1]]]
    }

    /// Size of the terms the residual is made of: rounding in it is this times the machine precision.
    fn residual_size(&self, [a, b]: [f64; 2]) -> f64 {
        let size = self.map(f64::abs);
        let u = [a.abs(), b.abs()];
        let [f_1, f_2] = size.slopes(u);
        u[0].max(u[1]) + size.value(u) * f_1.max(f_2)
    }
}

/// p(u): the monomials of a basis.
pub(super) fn basis_functions<D: Scalar>(basis: Basis, [a, b]: [D; 2]) -> Coefficients<D> {
    let mut functions = [D::one(); Basis::MOST_COEFFICIENTS];
    for (function, &(i, j)) in functions.iter_mut().zip(basis.monomials()) {
        // Products one by one: powers of zero have the derivatives they should.
        for _ in 0..i {
            *function *= a;
        }
        for _ in 0..j {
            *function *= b;
        }
    }
    functions
}

/// Where the projection lies on reals, with what dual numbers need to follow it.
pub(super) struct Foot {
    u: [f64; 2],
    inverse_jacobian: [[f64; 2]; 2],
}

impl Foot {
    /// Damped Newton iteration from u = 0, straight below the slave.
    ///
    /// The residual decreases at every step; where Newton's direction does not achieve that (a singular or
    /// nearly singular Jacobian), the steepest descent of the residual's square is taken. A step is not longer
    /// than half the support radius plus the distance already covered. A slave closer to the surface than its
    /// centres of curvature finds the foot; beyond them the residual may have a minimum that is no foot, which
    /// is reported as divergence.
    pub(super) fn find(polynomial: &Polynomial<f64>) -> Result<Self, ElementError> {
        let mut u = [0.0; 2];
        let mut iterations = 0;
        loop {
            let residual = polynomial.residual(u);
            let norm = residual[0].hypot(residual[1]);
            super::finite("foot residual", [norm])?;
            let size = polynomial.residual_size(u);
            if norm <= RESIDUAL_GOAL * size {
                break;
            }
            let jacobian = polynomial.jacobian(u);
            let newton = multiply(&inverse(&jacobian), residual).map(|d| -d);
            let descent = multiply(&jacobian, residual).map(|d| -d);
            let step = decreasing_step(polynomial, u, newton, norm)
                .or_else(|| decreasing_step(polynomial, u, descent, norm));
            match step {
                Some(next) if iterations < MAX_ITERATIONS => u = next,
                None if norm <= RESIDUAL_ACCEPTED * size => break,
                _ => {
                    let residual = residual[0].abs().max(residual[1].abs());
                    return Err(ElementError::FootDiverged { residual, iterations });
                }
            }
            iterations += 1;
        }
        Self::checked(polynomial, u)
    }

    /// The converged foot, if it is unique and inside the domain of influence.
    fn checked(polynomial: &Polynomial<f64>, u: [f64; 2]) -> Result<Self, ElementError> {
        let jacobian = polynomial.jacobian(u);
        let determinant = determinant(&jacobian);
        super::finite("foot Jacobian", [determinant])?;
        if determinant.abs() <= DETERMINANT_TOLERANCE {
            return Err(ElementError::CentreOfCurvature { determinant });
        }
        let distance = u[0].hypot(u[1]);
        if distance > 1.0 {
            return Err(ElementError::FootOutside { distance });
        }
        let trace = jacobian[0][0] + jacobian[1][1];
        if determinant < 0.0 || trace >= 0.0 {
            return Err(ElementError::BeyondCentreOfCurvature { determinant, trace });
        }
        Ok(Self { u, inverse_jacobian: inverse(&jacobian) })
    }

    /// In-plane offset of the foot from the slave's projection, over R.
    pub(super) const fn position(&self) -> [f64; 2] {
        self.u
    }

    /// The foot on the surface with dual coefficients: Newton steps from the real foot.
    pub(super) fn propagate<D: Scalar>(&self, polynomial: &Polynomial<D>) -> [D; 2] {
        let mut u = self.u.map(D::from);
        for _ in 0..PROPAGATION_STEPS {
            let [r_1, r_2] = polynomial.residual(u);
            for (u_k, [j_1, j_2]) in u.iter_mut().zip(self.inverse_jacobian) {
                *u_k -= r_1 * j_1 + r_2 * j_2;
            }
        }
        u
    }
}

/// The longest tried step along `direction` that makes the residual smaller than `norm`.
fn decreasing_step(
    polynomial: &Polynomial<f64>,
    u: [f64; 2],
    direction: [f64; 2],
    norm: f64,
) -> Option<[f64; 2]> {
    let longest = 0.5 + u[0].hypot(u[1]);
    let length = direction[0].hypot(direction[1]);
    if !length.is_finite() {
        return None;
    }
    let mut factor = if length > longest { longest / length } else { 1.0 };
    for _ in 0..MAX_HALVINGS {
        let next = [u[0] + factor * direction[0], u[1] + factor * direction[1]];
        let [r_1, r_2] = polynomial.residual(next);
        if r_1.hypot(r_2) < (1.0 - 1e-4 * factor) * norm {
            return Some(next);
        }
        factor *= 0.5;
    }
    None
}

fn multiply([[a, b], [c, d]]: &[[f64; 2]; 2], [x, y]: [f64; 2]) -> [f64; 2] {
    [a * x + b * y, c * x + d * y]
}

#[cfg(test)]
mod tests {
    use num_dual::HyperDual;

    use super::*;

    fn quadratic<D: Scalar>(six: [D; 6]) -> Polynomial<D> {
        let mut coefficients = [D::zero(); Basis::MOST_COEFFICIENTS];
        coefficients[..6].copy_from_slice(&six);
        Polynomial { basis: Basis::Quadratic, coefficients }
    }

    #[test]
    fn foot_on_an_inclined_plane() {
        // Plane z = −1 + a/2 − b/4: the gap is 1/ℓ.
        let plane = quadratic([-1.0, 0.5, -0.25, 0.0, 0.0, 0.0]);
        let foot = Foot::find(&plane).unwrap();
        let length = (1.0f64 + 0.25 + 0.0625).sqrt();
        assert!((plane.gap(foot.position()) - 1.0 / length).abs() < 1e-15);
    }

    #[test]
    fn derivatives_flow_through_the_iteration() {
        // Parabola z = −c + a²/2 with the slave at height c < 1 over the vertex, tilted by a slope e: the foot
        // u solves u = (c − e u − u²/2)(e + u), whence at e = 0: u_e = c/(1 − c) and, by symmetry, u_ee = 0;
        // u_ec = 1/(1 − c)².
        let c = HyperDual::from_re(0.25).derivative1();
        let e = HyperDual::from_re(0.0).derivative2();
        let zero = HyperDual::from_re(0.0);
        let dual = quadratic([-c, e, zero, zero + 0.5, zero, zero]);
        let real = dual.map(|x| x.re);
        let [u, _] = Foot::find(&real).unwrap().propagate(&dual);
        assert!(u.re.abs() < 1e-15);
        assert!((u.eps2 - 0.25 / 0.75).abs() < 1e-15);
        assert!((u.eps1eps2 - 1.0 / (0.75 * 0.75)).abs() < 1e-14);
    }

    /// How many of 2000 surfaces have a foot and for how many the iteration stalls: low-discrepancy
    /// coefficients, height of the slave over R up to `height`, radii of curvature down to R/3.
    fn found_and_stalled(height: f64) -> (usize, usize) {
        let (mut found, mut stalled) = (0, 0);
        for i in 1..=2000 {
            let part = |k: i32| 2.0 * (f64::from(i) * f64::from(k).sqrt()).fract() - 1.0;
            let slopes = [0.5 * part(3), 0.5 * part(5)];
            let polynomial = quadratic([height * part(2), slopes[0], slopes[1], part(7), part(11), part(13)]);
            match Foot::find(&polynomial) {
                Ok(foot) => {
                    let [r_1, r_2] = polynomial.residual(foot.position());
                    assert!(r_1.hypot(r_2) < 1e-13, "{polynomial:?}");
                    found += 1;
                }
                // A stationary point, but not the nearest: as much a foot for the iteration.
                Err(ElementError::BeyondCentreOfCurvature { determinant, trace }) => {
                    assert!(height > 0.3 && (determinant < 0.0 || trace >= 0.0), "{polynomial:?}");
                    found += 1;
                }
                Err(ElementError::FootDiverged { residual, .. }) => {
                    assert!(residual > 1e-6, "{polynomial:?}");
                    stalled += 1;
                }
                Err(error) => panic!("{polynomial:?}: {error}"),
            }
        }
        (found, stalled)
    }

    #[test]
    fn a_foot_is_found_or_an_error_says_why() {
        assert_eq!(found_and_stalled(0.3), (2000, 0));
        // Beyond the centres of curvature the residual may have a minimum that is no foot.
        assert!(found_and_stalled(1.0).0 > 1800);
    }

    #[test]
    fn centre_of_curvature_and_far_feet_are_errors() {
        let bowl = quadratic([-1.0, 0.0, 0.0, 0.5, 0.0, 0.5]);
        assert!(matches!(Foot::find(&bowl), Err(ElementError::CentreOfCurvature { .. })));
        let steep = quadratic([-10.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
        let Err(ElementError::FootOutside { distance }) = Foot::find(&steep) else { panic!("foot accepted") };
        assert!((distance - 5.0).abs() < 1e-13);
        let overflowing = quadratic([1e200, 1e200, 0.0, 0.0, 0.0, 0.0]);
        assert!(matches!(Foot::find(&overflowing), Err(ElementError::Overflow { .. })));
    }
}
