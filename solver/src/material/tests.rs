//! The laws of materials: tangents are derivatives, invariances, closed forms.

use nalgebra::{Matrix3, Vector3};

use super::eigen::symmetric_eigen;
use super::{Isochoric, Law, Material, Plasticity, PointState, Volumetric};

const STEEL: Material = Material::elastic(2e5, 0.3);

fn elastic() -> Law {
    Law::new(&STEEL).unwrap()
}

fn plastic() -> Law {
    Law::new(&STEEL.with_plasticity(Plasticity { yield_stress: 400.0, hardening: 3450.0 })).unwrap()
}

fn neo_hooke() -> Law {
    Law::new(&Material::neo_hooke(2e5, 0.3)).unwrap()
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
fn tangent_error(law: &Law, f: &Matrix3<f64>, state: &PointState) -> f64 {
    let answer = law.isochoric(f, state).unwrap();
    let tau = answer.kirchhoff();
    let step = 1e-3;
    let mut worst: f64 = 0.0;
    for i in 0..3 {
        for j in 0..3 {
            let mut l = Matrix3::zeros();
            l[(i, j)] = 1.0;
            let at = |h: f64| law.isochoric(&((Matrix3::identity() + l * h) * f), state).unwrap().kirchhoff();
            // Richardson's extrapolation of central differences, sixth order.
            let central = |h: f64| (at(h) - at(-h)) / (2.0 * h);
            let (d1, d2, d4) = (central(step), central(step / 2.0), central(step / 4.0));
            let (e1, e2) = ((d2 * 4.0 - d1) / 3.0, (d4 * 4.0 - d2) / 3.0);
            let numeric = (e2 * 16.0 - e1) / 15.0;
            let exact = tangent_times(&answer, &((l + l.transpose()) * 0.5)) + l * tau + tau * l.transpose();
            worst = worst.max((numeric - exact).amax());
        }
    }
    worst / STEEL.shear_modulus()
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
fn elastic_tangents_are_the_derivatives() {
    for law in [elastic(), neo_hooke()] {
        for stretch in stretches() {
            let error = tangent_error(&law, &gradient(stretch), &PointState::VIRGIN);
            assert!(error < 2e-10, "{law:?} {stretch:?}: {error:e}");
        }
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
    for law in [elastic(), plastic(), neo_hooke()] {
        let f = gradient([1.3, 0.9, 0.7]);
        let answer = law.isochoric(&f, &PointState::VIRGIN).unwrap();
        let b = f * f.transpose();
        let square = |a: usize| (answer.axes.column(a).transpose() * b * answer.axes.column(a))[(0, 0)];
        for k in 0..3 {
            let (a, b) = ((k + 1) % 3, (k + 2) % 3);
            let (la, lb) = (square(a), square(b));
            let quotient = (answer.stress[a] * lb - answer.stress[b] * la) / (la - lb);
            assert!((quotient - answer.shear[k]).abs() < 1e-12 * STEEL.shear_modulus());
        }
    }
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
        let volumetric = q / (3.0 * STEEL.bulk_modulus());
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
    for law in [plastic(), neo_hooke()] {
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
}

/// A volume changes neither stress nor flow.
#[test]
fn pressure_is_not_felt() {
    for law in [plastic(), neo_hooke()] {
        let f = gradient([1.2, 0.9, 0.95]);
        let answer = law.isochoric(&f, &PointState::VIRGIN).unwrap();
        let swollen = law.isochoric(&(f * 1.7), &PointState::VIRGIN).unwrap();
        assert!((answer.kirchhoff() - swollen.kirchhoff()).amax() < 1e-10);
        let metrics = swollen.state.inverse_plastic_metric() - answer.state.inverse_plastic_metric();
        assert!(metrics.amax() < 1e-14);
    }
}

#[test]
fn stress_and_stiffness_derive_from_the_volumetric_energy() {
    for (law, theta) in [elastic(), neo_hooke()]
        .into_iter()
        .flat_map(|law| [0.3, 0.9, 1.0, 1.5, 4.0].map(|theta| (law, theta)))
    {
        let h = 1e-4 * theta;
        let at = |t| law.volumetric(t);
        let d = |f: fn(&Volumetric) -> f64| {
            (8.0 * (f(&at(theta + h)) - f(&at(theta - h)))
                - (f(&at(theta + 2.0 * h)) - f(&at(theta - 2.0 * h))))
                / (12.0 * h)
        };
        assert!((d(|v| v.energy) - at(theta).pressure).abs() < 1e-9 * STEEL.bulk_modulus());
        assert!((d(|v| v.pressure) - at(theta).stiffness).abs() < 1e-8 * STEEL.bulk_modulus());
    }
}

#[test]
fn lost_stretches_and_broken_states_are_errors() {
    let law = plastic();
    let flat = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 0.0));
    assert!(law.isochoric(&flat, &PointState::VIRGIN).is_err());
    let huge = Matrix3::identity() * 1e200;
    assert!(law.isochoric(&huge, &PointState::VIRGIN).is_err());
    let broken = PointState { inverse_plastic_metric: [1.0, -1.0, 1.0, 0.0, 0.0, 0.0], ..PointState::VIRGIN };
    assert!(law.isochoric(&Matrix3::identity(), &broken).is_err());
    let nan = PointState { inverse_plastic_metric: [f64::NAN; 6], ..PointState::VIRGIN };
    assert!(law.isochoric(&Matrix3::identity(), &nan).is_err());
}

/// Kirchhoff's stress of simple shear by γ is μ γ, with a difference of normal stresses of μ γ²; of a stretch λ along an axis that keeps the
/// volume, the difference is μ (λ² − 1/λ).
#[test]
fn neo_hooke_elasticity_in_closed_form() {
    let law = neo_hooke();
    let gamma = 0.8;
    let mut f = Matrix3::identity();
    f[(0, 1)] = gamma;
    let stress = law.isochoric(&f, &PointState::VIRGIN).unwrap().kirchhoff();
    assert!((stress[(0, 1)] - STEEL.shear_modulus() * gamma).abs() < 1e-14 * STEEL.shear_modulus());
    assert!(
        (stress[(0, 0)] - stress[(1, 1)] - STEEL.shear_modulus() * gamma * gamma).abs()
            < 1e-14 * STEEL.shear_modulus()
    );
    for stretch in [0.2_f64, 0.9, 1.0, 1.1, 4.0] {
        let across = stretch.sqrt().recip();
        let f = Matrix3::from_diagonal(&Vector3::new(stretch, across, across));
        let answer = law.isochoric(&f, &PointState::VIRGIN).unwrap();
        let stress = answer.kirchhoff();
        let expected = STEEL.shear_modulus() * (stretch * stretch - 1.0 / stretch);
        assert!(
            (stress[(0, 0)] - stress[(1, 1)] - expected).abs()
                < 1e-14 * STEEL.shear_modulus() * stretch.powi(2).max(1.0 / stretch)
        );
        let energy = 0.5 * STEEL.shear_modulus() * (stretch * stretch + 2.0 / stretch - 3.0);
        assert!(
            (answer.energy - energy).abs()
                < 1e-14 * STEEL.shear_modulus() * stretch.powi(2).max(1.0 / stretch)
        );
    }
}

#[test]
fn constants_out_of_range_are_named() {
    let steel = Material::elastic(2e5, 0.3);
    assert_eq!(steel.check(), Ok(()));
    assert!((steel.bulk_modulus() - 2e5 / 1.2).abs() < 1e-9);
    assert!((steel.shear_modulus() - 2e5 / 2.6).abs() < 1e-9);
    let plastic = |yield_stress, hardening| steel.with_plasticity(Plasticity { yield_stress, hardening });
    assert_eq!(plastic(400.0, 0.0).check(), Ok(()));
    for (material, constant) in [
        (Material { young: 0.0, ..steel }, "Young's modulus"),
        (Material { young: f64::INFINITY, ..steel }, "Young's modulus"),
        (Material { poisson: 0.5, ..steel }, "Poisson's ratio"),
        (Material { poisson: f64::NAN, ..steel }, "Poisson's ratio"),
        (Material { young: 1e300, poisson: 0.5 - 1e-16, ..steel }, "the bulk modulus"),
        (plastic(0.0, 1.0), "the yield stress"),
        (plastic(400.0, -1.0), "the hardening modulus"),
        (plastic(400.0, f64::INFINITY), "the hardening modulus"),
    ] {
        assert_eq!(material.check().unwrap_err().constant, constant, "{material:?}");
    }
}
