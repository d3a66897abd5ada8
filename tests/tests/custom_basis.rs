//! Kernels for bases of one's own against automatic differentiation, and what is refused.

use diffuse_contact::ad::Ad;
use diffuse_contact::{Backend, Basis, CustomBasis, ElementError, Generated, GeneratedWith, Mode, Weight};
use diffuse_contact_codegen::{BasisError, Config, ConfigError};
use diffuse_contact_kernels::support::KernelSet;
use diffuse_contact_tests::bases::{
    BILINEAR, THIRD_DEGREE, cubic::Cubic, cubic_interpolating::CubicInterpolating,
};
use diffuse_contact_tests::{
    Case, Random, assert_same_coefficients, assert_same_gap, assert_same_surface, difference,
};

const TOLERANCE: f64 = 1e-10;

#[track_caller]
fn compare<K: KernelSet + Sync>(case: &Case) {
    let (kernels, element) = (GeneratedWith::<K>::new(), case.element());
    let gap = |backend: &dyn Backend| backend.gap(&element, Mode::Hessian).unwrap();
    assert_same_gap(case, &gap(&kernels), &gap(&Ad), TOLERANCE);
}

#[test]
fn gap_with_both_weights() {
    for seed in 0..2 {
        for n in [4, 5, 9, 12] {
            let case = Case::random(n, BILINEAR, seed);
            compare::<Cubic>(&case);
            compare::<CubicInterpolating>(&case.with_weight(Weight::CubicInterpolating));
        }
        for n in [12, 16, 20, 25] {
            let case = Case::random(n, THIRD_DEGREE, seed);
            compare::<Cubic>(&case);
            compare::<Cubic>(&case.clone().co_moving());
            let case = case.with_weight(Weight::CubicInterpolating);
            compare::<CubicInterpolating>(&case);
            compare::<CubicInterpolating>(&case.co_moving());
        }
    }
}

#[test]
fn coefficients_and_surface() {
    for (n, basis) in [(7, BILINEAR), (16, THIRD_DEGREE)] {
        let case = Case::random(n, basis, 3);
        let (kernels, element) = (GeneratedWith::<Cubic>::new(), case.element());
        let fit = |backend: &dyn Backend| backend.coefficients(&element, Mode::Hessian).unwrap();
        assert_eq!(fit(&kernels).values.len(), basis.size());
        assert_same_coefficients(&case, &fit(&kernels), &fit(&Ad), TOLERANCE);
        let surface = |backend: &dyn Backend| backend.surface(&element, [0.3, -0.2], Mode::Hessian).unwrap();
        assert_same_surface(&case, &surface(&kernels), &surface(&Ad), TOLERANCE);
    }
}

#[test]
fn polynomials_of_the_basis_are_reproduced() {
    // z = 0.1 + 0.2 a - 0.1 b + 0.3 a b about the slave: the bilinear fit has these coefficients.
    let mut random = Random::new(5);
    let mut nodes = vec![[0.0; 3]];
    nodes.extend((0..9).map(|_| {
        let [a, b] = [random.signed(), random.signed()];
        [a, b, 0.1 + 0.2 * a - 0.1 * b + 0.3 * a * b]
    }));
    let case = Case::axis_aligned(&nodes, 2.0, BILINEAR);
    let fit = GeneratedWith::<Cubic>::new().coefficients(&case.element(), Mode::Value).unwrap();
    assert!(difference(&fit.values, &[0.1, 0.2, -0.1, 0.3]) < 1e-13, "{:?}", fit.values);
}

#[test]
fn what_a_basis_cannot_do_is_said() {
    let case = Case::random(9, BILINEAR, 1);
    let error = Generated.gap(&case.element(), Mode::Value).unwrap_err();
    assert_eq!(error, ElementError::NoKernels { basis: "bilinear" });
    let moving = case.clone().co_moving();
    for backend in [&GeneratedWith::<Cubic>::new() as &dyn Backend, &Ad] {
        let error = backend.gap(&moving.element(), Mode::Hessian).unwrap_err();
        assert_eq!(error, ElementError::AnisotropicBasis { basis: "bilinear" });
    }
    let mut few = case.element();
    few.masters = &case.masters[..3];
    let error = GeneratedWith::<Cubic>::new().gap(&few, Mode::Value).unwrap_err();
    assert_eq!(error, ElementError::TooFewNodes { found: 3, needed: 4 });
    for monomials in
        [&[][..], &[(0, 0), (0, 1), (1, 0)], &[(0, 0), (1, 0), (0, 1), (200, 100)], &[(0, 0); 20]]
    {
        let basis = Basis::Custom(CustomBasis { name: "none", monomials });
        for weight in [Weight::Cubic, Weight::CubicInterpolating] {
            let error =
                Ad.gap(&case.element().with_basis(basis).with_weight(weight), Mode::Hessian).unwrap_err();
            assert_eq!(error, ElementError::NoKernels { basis: "none" });
        }
    }
    assert!(BILINEAR != Basis::Linear && !BILINEAR.is_isotropic() && THIRD_DEGREE.is_isotropic());
}

#[test]
fn a_basis_that_is_none_is_refused() {
    let incomplete = Config::new().basis("own", &[(0, 0), (1, 0), (0, 1), (2, 2)]).unwrap_err();
    assert!(matches!(incomplete, ConfigError::Basis(BasisError::Derivative { .. })), "{incomplete}");
    let twice = Config::new().basis("own", &[(0, 0), (1, 0), (0, 1)]).unwrap();
    let twice = twice.basis("own", &[(0, 0), (1, 0), (0, 1)]).unwrap_err();
    assert!(matches!(twice, ConfigError::DuplicateBasis { .. }), "{twice}");
}
