//! M v from the factors of M, and the slave's rows of M: the same as of M itself, whatever the weight, basis, frame, shape and instructions.

use diffuse_contact::ad::Ad;
use diffuse_contact::{Backend, Basis, Generated, Mode, SymmetricMatrix, Weight};
use diffuse_contact_kernels::support::{FrameRule, Isa, SecondKind, Workspace};
use diffuse_contact_tests::{Case, Found, GAP_KERNELS, GapKernels, Kernel, instructions, largest};

use crate::lanes::{BASES, FRAMES, sound, with_frame};

/// Factors against the matrix that the same kernel makes of them.
const TOLERANCE: f64 = 1e-13;
/// Generated kernels against automatic differentiation.
const OF_AD: f64 = 1e-12;

fn vector(length: usize, seed: usize) -> Vec<f64> {
    (0..length).map(|k| (1.7 * k as f64 + 0.3 + seed as f64).sin()).collect()
}

fn product(matrix: &SymmetricMatrix, v: &[f64]) -> Vec<f64> {
    (0..v.len()).map(|i| v.iter().enumerate().map(|(j, v)| matrix.get(i, j) * v).sum()).collect()
}

/// The largest difference of M v over the largest entry of |M| |v|.
fn difference(found: &[f64], matrix: &SymmetricMatrix, v: &[f64]) -> f64 {
    let expected = product(matrix, v);
    let row = |i: usize| v.iter().enumerate().map(|(j, v)| (matrix.get(i, j) * v).abs()).sum::<f64>();
    let scale = (0..v.len()).map(row).fold(0.0, f64::max);
    let differences: Vec<f64> = found.iter().zip(&expected).map(|(x, y)| x - y).collect();
    largest(&differences) / scale
}

/// What was asked for in the place of M, beside the matrix of the same element in the same shape.
struct Pair<'a> {
    set: &'a GapKernels,
    kernel: Kernel,
    isa: Isa,
    case: &'a Case,
    of_matrix: &'a Found,
    of_second: &'a Found,
}

impl Pair<'_> {
    fn check(&self, error: f64) {
        let Self { set, kernel, isa, case, .. } = self;
        let n = case.masters.len();
        assert!(error < TOLERANCE, "{} {kernel:?} {n} {isa}: {error:e}", set.weight);
    }
}

/// All kernels, some sizes and all instructions, elements side by side and alone. It is one kernel up to the products.
fn for_each_pair(kind: SecondKind, check: impl Fn(Pair<'_>)) {
    let mut workspace = Workspace::default();
    let kernels = BASES.into_iter().flat_map(|basis| FRAMES.map(|frame| (basis, frame, Mode::Hessian)));
    for (set, kernel) in GAP_KERNELS.into_iter().flat_map(|set| kernels.clone().map(move |k| (set, k))) {
        for n in [kernel.0.size(), 9, 13] {
            let cases = [1000, 2000].map(|seed| sound(&set, kernel, n, seed));
            let (both, spare) = (cases.each_ref(), n % 2 * 5);
            for isa in instructions() {
                let matrices = set.batch(isa, kernel, &both, &mut workspace, 0);
                let seconds = set.batch_second(isa, kernel, kind, (&both, &mut workspace), spare);
                let alone = both.map(|case| {
                    (set.single(isa, kernel, case, 0), set.single_second(isa, kernel, kind, case, spare))
                });
                let pairs = matrices.iter().zip(&seconds).chain(alone.iter().map(|(x, y)| (x, y)));
                for ((of_matrix, of_second), case) in pairs.zip(both.iter().cycle()) {
                    let values = |found: &Found| {
                        let values = found.values;
                        (values.gap, values.foot, values.normal, found.gradient.clone())
                    };
                    assert_eq!(values(of_matrix), values(of_second));
                    assert_eq!(of_matrix.status(), of_second.status());
                    check(Pair { set: &set, kernel, isa, case, of_matrix, of_second });
                }
            }
        }
    }
}

#[test]
fn factors_times_a_vector_are_the_hessian_times_it() {
    for_each_pair(SecondKind::Factors, |pair| {
        let Pair { set, kernel, isa, case, of_matrix, of_second } = pair;
        let matrix = of_matrix.gap(case).hessian;
        let rows = set.form(kernel, case);
        let v = vector(matrix.size(), case.masters.len());
        let mut found = vec![f64::NAN; v.len()];
        rows.multiply_factors(isa, &of_second.hessian, &v, &mut found);
        pair.check(difference(&found, &matrix, &v));
        // Translations change nothing, not even a bit.
        let together: Vec<f64> = (0..v.len()).map(|k| [0.3, -0.7, 1.1][k % 3]).collect();
        rows.multiply_factors(isa, &of_second.hessian, &together, &mut found);
        assert!(found.iter().all(|x| *x == 0.0), "{found:?}");
        rows.factors_diagonal(&of_second.hessian, &mut found);
        let entries: Vec<f64> = (0..v.len()).map(|k| found[k] - matrix.get(k, k)).collect();
        pair.check(largest(&entries) / largest(matrix.packed()));
    });
}

#[test]
fn rows_of_the_slave_are_those_of_the_hessian() {
    for_each_pair(SecondKind::SlaveRows, |pair| {
        let matrix = pair.of_matrix.gap(pair.case).hessian;
        let (size, found) = (matrix.size(), &pair.of_second.hessian);
        let differences: Vec<f64> =
            (0..3 * size).map(|k| found[k] - matrix.get(k / size, k % size)).collect();
        pair.check(largest(&differences) / largest(matrix.packed()));
    });
}

#[test]
fn products_are_those_of_automatic_differentiation() {
    let weights = [Weight::Cubic, Weight::CubicInterpolating, Weight::WendlandC2];
    for (set, weight) in GAP_KERNELS.into_iter().zip(weights) {
        for (basis, frame) in BASES.into_iter().flat_map(|basis| FRAMES.map(|frame| (basis, frame))) {
            let case = sound(&set, (basis, frame, Mode::Hessian), 8, 400).with_weight(weight);
            let matrix = Ad.gap(&case.element(), Mode::Hessian).unwrap().hessian;
            let factors = Generated.gap_factors(&case.element()).unwrap();
            let v = vector(matrix.size(), 3);
            let mut found = vec![f64::NAN; v.len()];
            factors.hessian.multiply(&v, &mut found);
            let worst = difference(&found, &matrix, &v);
            assert!(worst < OF_AD, "{weight:?} {basis:?} {frame:?}: {worst:e}");
        }
    }
}

/// An element without a result has no factors: the checksum says so although nothing is multiplied.
#[test]
fn factors_that_are_not_finite_are_no_result() {
    let kernel = (Basis::Quadratic, FrameRule::Held, Mode::Hessian);
    for set in GAP_KERNELS {
        for n in [9, 12] {
            let mut case = with_frame(Case::random(n, kernel.0, 5), kernel.1);
            case.masters[n - 1][2] = f64::NAN;
            let found = set.single_second(Isa::SCALAR, kernel, SecondKind::Factors, &case, 0);
            assert!(found.values.checksum.is_nan());
            assert_ne!(found.status(), diffuse_contact_kernels::support::Status::Ok);
        }
    }
}
