//! Eigenvalues and eigenvectors of a small symmetric matrix, by Jacobi's rotations.

/// Sweeps of rotations: five are enough for a 3 × 3 matrix to rounding, eight for a 6 × 6 one.
const MOST_SWEEPS: usize = 12;

/// Eigenvalues of a symmetric matrix, ascending, with unit eigenvectors. Reads the upper triangle. Small eigenvalues come
/// out as exact as large ones allow, and eigenvectors are orthogonal to rounding however close eigenvalues are. With a NaN or an
/// infinity in the matrix an eigenvalue is not finite either.
pub fn symmetric_eigen<const N: usize>(mut a: [[f64; N]; N]) -> [(f64, [f64; N]); N] {
    // Rows become eigenvectors.
    let mut vectors: [[f64; N]; N] =
        std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    diagonalize(&mut a, |p, q, cosine, sine| {
        for k in 0..N {
            let (x, y) = (vectors[p][k], vectors[q][k]);
            vectors[p][k] = cosine * x - sine * y;
            vectors[q][k] = sine * x + cosine * y;
        }
    });
    let mut all = std::array::from_fn(|k| (a[k][k], vectors[k]));
    all.sort_by(|x: &(f64, _), y| x.0.total_cmp(&y.0));
    all
}

/// The smallest and the largest eigenvalue of a symmetric matrix. Reads the upper triangle.
pub fn extreme_eigenvalues<const N: usize>(mut a: [[f64; N]; N]) -> (f64, f64) {
    diagonalize(&mut a, |_, _, _, _| {});
    let values = (0..N).map(|k| a[k][k]);
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

/// Turns the matrix until its upper triangle is diagonal. `turn` gets the rows, the cosine and the sine of each rotation.
fn diagonalize<const N: usize>(a: &mut [[f64; N]; N], mut turn: impl FnMut(usize, usize, f64, f64)) {
    for _ in 0..MOST_SWEEPS {
        if (0..N).all(|p| a[p][p + 1..].iter().all(|&off| off == 0.0)) {
            break;
        }
        for p in 0..N {
            for q in p + 1..N {
                let off = a[p][q];
                // What does not change either diagonal entry is rounding.
                if a[p][p] + off == a[p][p] && a[q][q] + off == a[q][q] {
                    a[p][q] = 0.0;
                    continue;
                }
                let cotangent = (a[q][q] - a[p][p]) / (2.0 * off);
                let tangent = cotangent.signum() / (cotangent.abs() + (cotangent * cotangent + 1.0).sqrt());
                let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
                let sine = tangent * cosine;
                a[p][p] -= tangent * off;
                a[q][q] += tangent * off;
                a[p][q] = 0.0;
                for r in (0..N).filter(|&r| r != p && r != q) {
                    let [with_p, with_q] = [(p.min(r), p.max(r)), (q.min(r), q.max(r))];
                    let (x, y) = (a[with_p.0][with_p.1], a[with_q.0][with_q.1]);
                    a[with_p.0][with_p.1] = cosine * x - sine * y;
                    a[with_q.0][with_q.1] = sine * x + cosine * y;
                }
                turn(p, q, cosine, sine);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Q diag(values) Qᵀ for a rotation by angles, in the planes of pairs of axes.
    fn matrix<const N: usize>(values: [f64; N], angles: &[f64]) -> [[f64; N]; N] {
        let mut rows: [[f64; N]; N] =
            std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
        let planes = (0..N).flat_map(|p| (p + 1..N).map(move |q| (p, q)));
        for ((p, q), angle) in planes.zip(angles) {
            for row in &mut rows {
                let (x, y) = (row[p], row[q]);
                row[p] = angle.cos() * x - angle.sin() * y;
                row[q] = angle.sin() * x + angle.cos() * y;
            }
        }
        std::array::from_fn(|i| {
            std::array::from_fn(|j| (0..N).map(|k| rows[i][k] * values[k] * rows[j][k]).sum())
        })
    }

    /// Eigenvalues are those given, eigenvectors solve and are orthonormal, all to a multiple of rounding.
    fn check<const N: usize>(values: [f64; N], angles: &[f64], exponent: i32) -> Result<(), TestCaseError> {
        let size = 10_f64.powi(exponent);
        let a = matrix(values.map(|x| size * x), angles);
        let found = symmetric_eigen(a);
        let largest = values.iter().fold(0.0_f64, |m, x| m.max(x.abs())) * size;
        let mut expected = values.map(|x| size * x);
        expected.sort_by(f64::total_cmp);
        for (k, (value, vector)) in found.into_iter().enumerate() {
            prop_assert!((value - expected[k]).abs() <= 1e-14 * largest);
            for row in 0..N {
                let image: f64 = (0..N).map(|j| a[row][j] * vector[j]).sum();
                prop_assert!((image - value * vector[row]).abs() <= 1e-14 * largest);
            }
            for (other, (_, with)) in found.into_iter().enumerate() {
                let product: f64 = (0..N).map(|j| vector[j] * with[j]).sum();
                prop_assert!((product - f64::from(u8::from(other == k))).abs() <= 1e-14);
            }
        }
        prop_assert_eq!(extreme_eigenvalues(a), (found[0].0, found[N - 1].0));
        Ok(())
    }

    /// Values of very different size: each keeps its own digits as far as the matrix determines them.
    #[test]
    fn small_values_stand_beside_large_ones() {
        let values = symmetric_eigen([[1e8, 1.0, 0.0], [1.0, 1.0, 1e-5], [0.0, 1e-5, 1e-8]]).map(|(x, _)| x);
        // det = 1e8 (1e-8 − 1e-10) − 1e-8, and the largest is 1e8 + 1e-8.
        let determinant = 1e8 * (1e-8 - 1e-10) - 1e-8;
        let product: f64 = values.iter().product();
        assert!((product - determinant).abs() < 1e-13 * determinant, "{values:?}");
    }

    #[test]
    fn what_is_not_finite_stays_so() {
        for bad in [f64::NAN, f64::INFINITY] {
            for (row, column) in [(0, 1), (0, 2), (1, 2), (1, 1)] {
                let mut matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
                matrix[row][column] = bad;
                let values = symmetric_eigen(matrix).map(|(x, _)| x);
                assert!(values.iter().any(|x| !x.is_finite()), "{values:?}");
            }
        }
    }

    /// Equal and nearly equal values.
    #[test]
    fn values_may_lie_as_close_as_they_like() {
        for spread in [1.0, 1e-4, 1e-8, 1e-12, 1e-15, 0.0] {
            for k in 0..200 {
                let angles = [0.1, 0.7, 1.3].map(|x| x * f64::from(k));
                let values = [0.3, -0.8, 0.5].map(|x| 1.5 + spread * x * angles[0].sin());
                check(values, &angles, 0).unwrap();
            }
        }
    }

    fn value() -> impl Strategy<Value = f64> {
        prop_oneof![-1.0..1.0, Just(0.0), Just(1.0), 1e-12..1e-9]
    }

    proptest! {
        #[test]
        fn eigenvectors_of_three_axes_solve_and_are_orthonormal(
            values in prop::array::uniform3(value()),
            angles in prop::array::uniform3(-4.0..4.0),
            exponent in -100..100,
        ) {
            check(values, &angles, exponent)?;
        }

        #[test]
        fn eigenvectors_of_six_axes_solve_and_are_orthonormal(
            values in prop::array::uniform6(value()),
            angles in prop::array::uniform15(-4.0..4.0),
            exponent in -100..100,
        ) {
            check(values, &angles, exponent)?;
        }
    }
}
