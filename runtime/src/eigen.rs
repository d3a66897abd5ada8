//! Eigenvalues and eigenvectors of a symmetric 3 × 3 matrix.

/// Sweeps of rotations: five are enough for any matrix to rounding.
const MOST_SWEEPS: usize = 10;

/// Eigenvalues of a symmetric matrix, ascending, with unit eigenvectors, by Jacobi's rotations: small eigenvalues come out as
/// exact as large ones allow, and eigenvectors are orthogonal to rounding however close eigenvalues are.
pub(crate) fn symmetric_eigen(mut a: [[f64; 3]; 3]) -> [(f64, [f64; 3]); 3] {
    // Rows become eigenvectors.
    let mut vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..MOST_SWEEPS {
        if a[0][1] == 0.0 && a[0][2] == 0.0 && a[1][2] == 0.0 {
            break;
        }
        for (p, q, r) in [(0, 1, 2), (0, 2, 1), (1, 2, 0)] {
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
            let [with_p, with_q] = [(p.min(r), p.max(r)), (q.min(r), q.max(r))];
            let (x, y) = (a[with_p.0][with_p.1], a[with_q.0][with_q.1]);
            a[with_p.0][with_p.1] = cosine * x - sine * y;
            a[with_q.0][with_q.1] = sine * x + cosine * y;
            for k in 0..3 {
                let (x, y) = (vectors[p][k], vectors[q][k]);
                vectors[p][k] = cosine * x - sine * y;
                vectors[q][k] = sine * x + cosine * y;
            }
        }
    }
    let mut all = [0, 1, 2].map(|k| (a[k][k], vectors[k]));
    all.sort_by(|x, y| x.0.total_cmp(&y.0));
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Q diag(values) Qᵀ for a rotation by angles.
    fn matrix(values: [f64; 3], angles: [f64; 3]) -> [[f64; 3]; 3] {
        let mut rows = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for (k, angle) in angles.into_iter().enumerate() {
            let (p, q) = (k, (k + 1) % 3);
            for row in &mut rows {
                let (x, y) = (row[p], row[q]);
                row[p] = angle.cos() * x - angle.sin() * y;
                row[q] = angle.sin() * x + angle.cos() * y;
            }
        }
        std::array::from_fn(|i| {
            std::array::from_fn(|j| (0..3).map(|k| rows[i][k] * values[k] * rows[j][k]).sum())
        })
    }

    proptest! {
        #[test]
        fn eigenvectors_solve_and_are_orthonormal(
            values in prop::array::uniform3(prop_oneof![-1.0..1.0, Just(0.0), Just(1.0), 1e-12..1e-9]),
            angles in prop::array::uniform3(-4.0..4.0),
            exponent in -100..100,
        ) {
            let size = 10_f64.powi(exponent);
            let values: [f64; 3] = values;
            let a = matrix(values.map(|x| size * x), angles);
            let found = symmetric_eigen(a);
            let largest = values.iter().fold(0.0_f64, |m, x| m.max(x.abs())) * size;
            let mut expected = values.map(|x| size * x);
            expected.sort_by(f64::total_cmp);
            for (k, (value, vector)) in found.into_iter().enumerate() {
                prop_assert!((value - expected[k]).abs() <= 1e-14 * largest);
                for row in 0..3 {
                    let image: f64 = (0..3).map(|j| a[row][j] * vector[j]).sum();
                    prop_assert!((image - value * vector[row]).abs() <= 1e-14 * largest);
                }
                for (other, (_, with)) in found.into_iter().enumerate() {
                    let product: f64 = (0..3).map(|j| vector[j] * with[j]).sum();
                    prop_assert!((product - f64::from(u8::from(other == k))).abs() <= 1e-14);
                }
            }
        }
    }
}
