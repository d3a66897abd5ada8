//! The constitutive law: radial return in principal logarithmic strains.

use nalgebra::{Matrix3, Vector3};

use super::eigen::symmetric_eigen;
use super::{Material, MaterialError, PointState};

/// The law of one [`Material`]: stored energy U(θ) + μ ‖e‖², where θ is the ratio of volumes and e the deviator of the
/// elastic logarithmic strains. Energies are per reference volume and stresses are those of Kirchhoff, force per
/// reference area.
#[derive(Clone, Copy, Debug)]
pub struct Hencky {
    bulk: f64,
    shear: f64,
    /// Infinite if elastic.
    yield_stress: f64,
    hardening: f64,
}

/// The isochoric answer of a point, in the principal axes of its trial strain b = F C_p⁻¹ Fᵀ.
#[derive(Clone, Copy, Debug)]
pub struct Isochoric {
    /// Principal axes as columns.
    pub axes: Matrix3<f64>,
    /// Principal values τ_A of the deviatoric Kirchhoff stress; they add up to 0.
    pub stress: Vector3<f64>,
    /// ∂τ_A/∂ε_B − 2 τ_A δ_AB by the principal trial strains: the spatial tangent's components AABB. Symmetric.
    pub normal: Matrix3<f64>,
    /// (τ_A λ_B² − τ_B λ_A²)/(λ_A² − λ_B²), the spatial tangent's components ABAB, entry k for the axes A, B ≠ k. λ are
    /// the trial stretches; they may be equal.
    pub shear: Vector3<f64>,
    /// The state that the step ends in.
    pub state: PointState,
    /// μ ‖e‖².
    pub energy: f64,
}

/// The volumetric answer, U = κ/2 (ln θ)².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volumetric {
    /// U.
    pub energy: f64,
    /// U' = κ ln θ / θ: the mean Cauchy stress, positive in tension.
    pub pressure: f64,
    /// U''.
    pub stiffness: f64,
}

/// F C_p⁻¹ Fᵀ is not positive definite in floating point: a stretch is lost beside another or is no length any more, or
/// the state is no metric.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the squares of the principal stretches are {squares:?}")]
pub struct Unresolved {
    /// As far as they were computed.
    pub squares: [f64; 3],
}

impl Hencky {
    /// # Errors
    /// Those of [`Material::check`].
    pub fn new(material: &Material) -> Result<Self, MaterialError> {
        material.check()?;
        let (yield_stress, hardening) = match material.plasticity {
            Some(plasticity) => (plasticity.yield_stress, plasticity.hardening),
            None => (f64::INFINITY, 0.0),
        };
        Ok(Self { bulk: material.bulk_modulus(), shear: material.shear_modulus(), yield_stress, hardening })
    }

    /// κ + 4/3 μ, force per area: the stiffness against a strain along one axis alone.
    #[must_use]
    pub fn longitudinal_modulus(&self) -> f64 {
        self.bulk + 4.0 / 3.0 * self.shear
    }

    /// `volume_ratio` θ > 0.
    #[must_use]
    #[inline]
    pub fn volumetric(&self, volume_ratio: f64) -> Volumetric {
        let logarithm = volume_ratio.ln();
        Volumetric {
            energy: 0.5 * self.bulk * logarithm * logarithm,
            pressure: self.bulk * logarithm / volume_ratio,
            stiffness: self.bulk * (1.0 - logarithm) / (volume_ratio * volume_ratio),
        }
    }

    /// Step from `committed` to the deformation gradient F, det F > 0.
    ///
    /// The trial strain has the plastic metric as it was; the return is radial, so that the stress is 2 μ_s e with the
    /// trial deviator e and one secant modulus μ_s. The tangent is the exact derivative of the step.
    ///
    /// # Errors
    /// If a trial stretch is not a number between 1e-70 and 1e70.
    #[inline]
    pub fn isochoric(
        &self,
        deformation_gradient: &Matrix3<f64>,
        committed: &PointState,
    ) -> Result<Isochoric, Unresolved> {
        let f = deformation_gradient;
        let trial = congruence(f, &committed.inverse_plastic_metric());
        let (squares, axes) = symmetric_eigen(&trial);
        if !squares.iter().all(|&square| square > 1e-140 && square < 1e140) {
            return Err(Unresolved { squares: squares.into() });
        }
        let strain = squares.map(|square| 0.5 * square.ln());
        let mean = strain.mean();
        let deviator = strain.add_scalar(-mean);

        let mu = self.shear;
        // q² = 3/2 s·s
        let von_mises = mu * (6.0 * deviator.norm_squared()).sqrt();
        let excess = von_mises - (self.yield_stress + self.hardening * committed.equivalent_plastic_strain);
        let mut secant = mu;
        let mut state = *committed;
        // Multiplies n⊗n with the unit deviator n; 0 if elastic.
        let mut along = 0.0;
        if excess > 0.0 {
            let increment = excess / (3.0 * mu + self.hardening);
            secant = mu * (1.0 - 3.0 * mu * increment / von_mises);
            along = 6.0 * mu * mu * (increment / von_mises - 1.0 / (3.0 * mu + self.hardening));
            let elastic = (deviator * (secant / mu)).map(|e| (2.0 * (e + mean)).exp());
            let pulled_back = f
                .try_inverse()
                .map(|inverse| inverse * axes)
                .filter(|rows| rows.iter().all(|entry| entry.is_finite()))
                .ok_or(Unresolved { squares: squares.into() })?;
            state = PointState::isochoric(
                &congruence(&pulled_back, &Matrix3::from_diagonal(&elastic)),
                committed.equivalent_plastic_strain + increment,
            );
        }

        let stress = deviator * (2.0 * secant);
        let mut normal = Matrix3::from_element(-2.0 * secant / 3.0);
        if along != 0.0 {
            let direction = deviator / deviator.norm();
            normal += direction * direction.transpose() * along;
        }
        for a in 0..3 {
            normal[(a, a)] += 2.0 * (secant - stress[a]);
        }
        // With τ_A − τ_B = 2 μ_s (ε_A − ε_B) the quotient is −(τ_A + τ_B)/2 + μ_s x coth x, x = ε_A − ε_B, and as the
        // stresses add up to 0 the first term is τ_k/2.
        let shear = Vector3::from_fn(|k, _| {
            let difference = strain[(k + 1) % 3] - strain[(k + 2) % 3];
            0.5 * stress[k] + secant * x_coth_x(difference)
        });
        let energy = (secant * secant / mu) * deviator.norm_squared();
        Ok(Isochoric { axes, stress, normal, shear, state, energy })
    }
}

impl Isochoric {
    /// The deviatoric Kirchhoff stress in global axes.
    #[must_use]
    #[inline]
    pub fn kirchhoff(&self) -> Matrix3<f64> {
        let scaled = Matrix3::from_columns(&[0, 1, 2].map(|a| self.axes.column(a) * self.stress[a]));
        scaled * self.axes.transpose()
    }
}

/// A S Aᵀ for symmetric S, symmetric to the last bit. Written out, as the products of matrices are not always inlined.
#[inline]
fn congruence(a: &Matrix3<f64>, s: &Matrix3<f64>) -> Matrix3<f64> {
    let mut half = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            half[i][j] = a[(i, 0)] * s[(0, j)] + a[(i, 1)] * s[(1, j)] + a[(i, 2)] * s[(2, j)];
        }
    }
    let mut result = Matrix3::zeros();
    for i in 0..3 {
        for j in 0..=i {
            let entry = half[i][0] * a[(j, 0)] + half[i][1] * a[(j, 1)] + half[i][2] * a[(j, 2)];
            result[(i, j)] = entry;
            result[(j, i)] = entry;
        }
    }
    result
}

/// x coth x, even and smooth, 1 at 0.
#[inline]
fn x_coth_x(x: f64) -> f64 {
    if x.abs() < 0.1 {
        // The next term is below 3e-18.
        let s = x * x;
        1.0 + s
            * (1.0 / 3.0 + s * (-1.0 / 45.0 + s * (2.0 / 945.0 + s * (-1.0 / 4725.0 + s * (2.0 / 93555.0)))))
    } else {
        x / x.tanh()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Plasticity;

    const STEEL: Material = Material {
        young: 2e5,
        poisson: 0.3,
        plasticity: Some(Plasticity { yield_stress: 400.0, hardening: 3450.0 }),
    };

    fn elastic() -> Hencky {
        Hencky::new(&Material { plasticity: None, ..STEEL }).unwrap()
    }

    fn plastic() -> Hencky {
        Hencky::new(&STEEL).unwrap()
    }

    fn turn(angles: [f64; 3]) -> Matrix3<f64> {
        *nalgebra::Rotation3::new(Vector3::from(angles)).matrix()
    }

    /// c : (δε ⊗ symmetric), the spatial tangent applied to a symmetric tensor.
    fn tangent_times(answer: &Isochoric, strain: &Matrix3<f64>) -> Matrix3<f64> {
        let local = answer.axes.transpose() * strain * answer.axes;
        let mut rate = Matrix3::zeros();
        for a in 0..3 {
            for b in 0..3 {
                rate[(a, a)] += answer.normal[(a, b)] * local[(b, b)];
                if a != b {
                    rate[(a, b)] = 2.0 * answer.shear[3 - a - b] * local[(a, b)];
                }
            }
        }
        answer.axes * rate * answer.axes.transpose()
    }

    /// δτ = c : sym L + L τ + τ Lᵀ for F → (1 + L) F, by differences of fourth order in all nine directions.
    fn tangent_error(law: &Hencky, f: &Matrix3<f64>, state: &PointState) -> f64 {
        let answer = law.isochoric(f, state).unwrap();
        let tau = answer.kirchhoff();
        let step = 1e-3;
        let mut worst: f64 = 0.0;
        for i in 0..3 {
            for j in 0..3 {
                let mut l = Matrix3::zeros();
                l[(i, j)] = 1.0;
                let at =
                    |h: f64| law.isochoric(&((Matrix3::identity() + l * h) * f), state).unwrap().kirchhoff();
                // Richardson's extrapolation of central differences, sixth order.
                let central = |h: f64| (at(h) - at(-h)) / (2.0 * h);
                let (d1, d2, d4) = (central(step), central(step / 2.0), central(step / 4.0));
                let (e1, e2) = ((d2 * 4.0 - d1) / 3.0, (d4 * 4.0 - d2) / 3.0);
                let numeric = (e2 * 16.0 - e1) / 15.0;
                let exact =
                    tangent_times(&answer, &((l + l.transpose()) * 0.5)) + l * tau + tau * l.transpose();
                worst = worst.max((numeric - exact).amax());
            }
        }
        worst / law.shear
    }

    /// Stretches far apart, near, two equal, three equal, at rest.
    fn stretches() -> [[f64; 3]; 8] {
        [
            [1.3, 0.9, 0.7],
            [1.2, 1.2 * (1.0 + 1e-6), 0.8],
            [1.2, 1.2 * (1.0 + 1e-11), 0.8],
            [1.2, 1.2, 0.8],
            [0.9, 0.9, 0.9],
            [1.0, 1.0, 1.0],
            [1.0, 1.0, 1.1],
            [2.5, 0.5, 0.4],
        ]
    }

    fn gradient(stretch: [f64; 3]) -> Matrix3<f64> {
        turn([0.3, -0.5, 0.9]) * Matrix3::from_diagonal(&stretch.into()) * turn([-0.7, 0.2, 0.4])
    }

    #[test]
    fn elastic_tangent_is_the_derivative() {
        for stretch in stretches() {
            let error = tangent_error(&elastic(), &gradient(stretch), &PointState::VIRGIN);
            assert!(error < 2e-10, "{stretch:?}: {error:e}");
        }
    }

    #[test]
    fn plastic_tangent_is_the_derivative() {
        let law = plastic();
        // From a state that has yielded before in another direction.
        let before = law
            .isochoric(&(turn([0.1, 0.8, 0.2]) * gradient([1.1, 0.95, 1.0])), &PointState::VIRGIN)
            .unwrap()
            .state;
        assert!(before.equivalent_plastic_strain > 0.01);
        let mut yielding = 0;
        for state in [PointState::VIRGIN, before] {
            for stretch in stretches() {
                let f = gradient(stretch);
                let answer = law.isochoric(&f, &state).unwrap();
                let yields = answer.state.equivalent_plastic_strain - state.equivalent_plastic_strain;
                // Spherical strains cannot be differentiated across the yield surface, and need not be: they are elastic.
                if yields == 0.0 || yields > 5e-3 {
                    yielding += usize::from(yields > 0.0);
                    let error = tangent_error(&law, &f, &state);
                    assert!(error < 1e-8, "{stretch:?}: {error:e}, yields {yields}");
                }
            }
        }
        assert!(yielding >= 12, "{yielding}");
    }

    /// The quotient as it is written agrees where it can be evaluated.
    #[test]
    fn shear_is_the_quotient_of_its_definition() {
        for (law, limit) in [(elastic(), 1e-12), (plastic(), 1e-12)] {
            let f = gradient([1.3, 0.9, 0.7]);
            let answer = law.isochoric(&f, &PointState::VIRGIN).unwrap();
            let b = f * f.transpose();
            let square = |a: usize| (answer.axes.column(a).transpose() * b * answer.axes.column(a))[(0, 0)];
            for k in 0..3 {
                let (a, b) = ((k + 1) % 3, (k + 2) % 3);
                let (la, lb) = (square(a), square(b));
                let quotient = (answer.stress[a] * lb - answer.stress[b] * la) / (la - lb);
                assert!((quotient - answer.shear[k]).abs() < limit * law.shear);
            }
        }
    }

    #[test]
    fn x_coth_x_has_no_seam() {
        let (below, above) = (0.1 * (1.0 - 1e-15), 0.1);
        assert!((x_coth_x(below) - x_coth_x(above)).abs() < 5e-16);
        assert_eq!(x_coth_x(0.0), 1.0);
        assert_eq!(x_coth_x(-0.03), x_coth_x(0.03));
        assert!((x_coth_x(40.0) - 40.0).abs() < 1e-12);
    }

    /// Uniaxial stress under stretch in steps: q = σ_y + H p, and the axial strain is q/E + p.
    #[test]
    fn uniaxial_tension_follows_the_closed_form() {
        let law = plastic();
        let (young, hardening, yield_stress) = (2e5, 3450.0, 400.0);
        let mut state = PointState::VIRGIN;
        for step in 1..=60 {
            let axial = 0.02 * f64::from(step);
            let q = if young * axial < yield_stress {
                young * axial
            } else {
                (yield_stress + hardening * axial) / (1.0 + hardening / young)
            };
            let plastic_strain = axial - q / young;
            // The lateral strain leaves the volume to the elastic part.
            let volumetric = q / (3.0 * law.bulk);
            let lateral = 0.5 * (volumetric - axial);
            let f = turn([0.2 * axial, 0.5, -axial])
                * Matrix3::from_diagonal(&Vector3::new(axial.exp(), lateral.exp(), lateral.exp()));
            let answer = law.isochoric(&f, &state).unwrap();
            state = answer.state;
            let pressure = law.volumetric(f.determinant());
            let tau = answer.kirchhoff() + Matrix3::identity() * pressure.pressure * f.determinant();
            let axis = f.column(0).normalize();
            assert!(((axis.transpose() * tau * axis)[(0, 0)] - q).abs() < 1e-9 * q);
            assert!((tau.trace() - q).abs() < 1e-9 * q, "the lateral stress is not zero");
            assert!((state.equivalent_plastic_strain - plastic_strain).abs() < 1e-12);
            let determinant = state.inverse_plastic_metric().determinant();
            assert!((determinant - 1.0).abs() < 4e-15, "{determinant}");
        }
        assert!(state.equivalent_plastic_strain > 1.1);
    }

    /// Unloading is elastic, and a state is at rest under the deformation that it has itself.
    #[test]
    fn unloading_is_elastic() {
        let law = plastic();
        let loaded = law.isochoric(&gradient([1.2, 0.9, 0.95]), &PointState::VIRGIN).unwrap().state;
        let answer = law.isochoric(&gradient([1.199, 0.9005, 0.9505]), &loaded).unwrap();
        assert_eq!(answer.state, loaded);
        let cp = loaded.inverse_plastic_metric().try_inverse().unwrap();
        let (squares, axes) = symmetric_eigen(&cp);
        let stretch = axes * Matrix3::from_diagonal(&squares.map(f64::sqrt)) * axes.transpose();
        let rest = law.isochoric(&stretch, &loaded).unwrap();
        assert!(rest.stress.amax() < 1e-9);
    }

    /// τ(QF) = Q τ(F) Qᵀ with the same state; a turned reference turns the state and nothing else.
    #[test]
    fn objective_and_isotropic() {
        let law = plastic();
        let f = gradient([1.3, 0.9, 0.8]);
        let q = turn([1.0, -2.0, 0.5]);
        let answer = law.isochoric(&f, &PointState::VIRGIN).unwrap();
        let turned = law.isochoric(&(q * f), &PointState::VIRGIN).unwrap();
        let difference = turned.kirchhoff() - q * answer.kirchhoff() * q.transpose();
        assert!(difference.amax() < 1e-10);
        let metrics = turned.state.inverse_plastic_metric() - answer.state.inverse_plastic_metric();
        assert!(metrics.amax() < 1e-14);
        let reference = law.isochoric(&(f * q.transpose()), &PointState::VIRGIN).unwrap();
        assert!((reference.kirchhoff() - answer.kirchhoff()).amax() < 1e-10);
        let expected = q * answer.state.inverse_plastic_metric() * q.transpose();
        assert!((reference.state.inverse_plastic_metric() - expected).amax() < 1e-14);
    }

    /// A volume changes neither stress nor flow.
    #[test]
    fn pressure_is_not_felt() {
        let law = plastic();
        let f = gradient([1.2, 0.9, 0.95]);
        let answer = law.isochoric(&f, &PointState::VIRGIN).unwrap();
        let swollen = law.isochoric(&(f * 1.7), &PointState::VIRGIN).unwrap();
        assert!((answer.kirchhoff() - swollen.kirchhoff()).amax() < 1e-10);
        let metrics = swollen.state.inverse_plastic_metric() - answer.state.inverse_plastic_metric();
        assert!(metrics.amax() < 1e-14);
    }

    #[test]
    fn stress_and_stiffness_derive_from_the_volumetric_energy() {
        let law = elastic();
        for theta in [0.3, 0.9, 1.0, 1.5, 4.0] {
            let h = 1e-4 * theta;
            let at = |t| law.volumetric(t);
            let d = |f: fn(&Volumetric) -> f64| {
                (8.0 * (f(&at(theta + h)) - f(&at(theta - h)))
                    - (f(&at(theta + 2.0 * h)) - f(&at(theta - 2.0 * h))))
                    / (12.0 * h)
            };
            assert!((d(|v| v.energy) - at(theta).pressure).abs() < 1e-9 * law.bulk);
            assert!((d(|v| v.pressure) - at(theta).stiffness).abs() < 1e-8 * law.bulk);
        }
    }

    #[test]
    fn lost_stretches_and_broken_states_are_errors() {
        let law = plastic();
        let flat = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 0.0));
        assert!(law.isochoric(&flat, &PointState::VIRGIN).is_err());
        let huge = Matrix3::identity() * 1e200;
        assert!(law.isochoric(&huge, &PointState::VIRGIN).is_err());
        let broken =
            PointState { inverse_plastic_metric: [1.0, -1.0, 1.0, 0.0, 0.0, 0.0], ..PointState::VIRGIN };
        assert!(law.isochoric(&Matrix3::identity(), &broken).is_err());
        let nan = PointState { inverse_plastic_metric: [f64::NAN; 6], ..PointState::VIRGIN };
        assert!(law.isochoric(&Matrix3::identity(), &nan).is_err());
    }
}
