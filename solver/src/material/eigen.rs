//! Eigenvalues and eigenvectors of a symmetric 3 × 3 matrix by Jacobi's rotations.
//!
//! Unlike closed forms the rotations lose no digits where eigenvalues are equal or nearly so, and the vectors are orthogonal
//! to rounding always.

use nalgebra::{Matrix3, Vector3};

/// Rotations converge quadratically: four sweeps are the rule, and no matrix is known to need ten.
const MAX_SWEEPS: usize = 16;

/// Eigenvalues, in no particular order, and as columns the vectors that belong to them. Only the lower triangle is read. With
/// a NaN or an infinity in it the values are not finite either; squares of the entries must neither overflow nor
/// underflow.
#[inline]
pub(crate) fn symmetric_eigen(matrix: &Matrix3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
    let mut diagonal = [matrix[(0, 0)], matrix[(1, 1)], matrix[(2, 2)]];
    // The entry of the pair that leaves out axis k.
    let mut off = [matrix[(2, 1)], matrix[(2, 0)], matrix[(1, 0)]];
    let mut vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..MAX_SWEEPS {
        let mut rotated = false;
        for (p, q, k) in [(0, 1, 2), (0, 2, 1), (1, 2, 0)] {
            let entry: f64 = off[k];
            // Below this the rotation does not change the values.
            let negligible = 0.1 * f64::EPSILON * diagonal[p].abs().min(diagonal[q].abs());
            if entry.abs() <= negligible || entry == 0.0 {
                continue;
            }
            rotated = true;
            // t = tan φ, the smaller root of t² + 2 t cot 2φ − 1 = 0 with cot 2φ = difference / 2 entry.
            let difference = diagonal[q] - diagonal[p];
            let hypotenuse = (difference * difference + 4.0 * entry * entry).sqrt();
            let t = 2.0 * entry / (difference + hypotenuse.copysign(difference));
            let cosine = 1.0 / (1.0 + t * t).sqrt();
            let sine = t * cosine;
            diagonal[p] -= t * entry;
            diagonal[q] += t * entry;
            off[k] = 0.0;
            // Pair (p, k) leaves out q, pair (q, k) leaves out p.
            let (pk, qk) = (off[q], off[p]);
            off[q] = cosine * pk - sine * qk;
            off[p] = sine * pk + cosine * qk;
            for i in 0..3 {
                let (vp, vq) = (vectors[p][i], vectors[q][i]);
                vectors[p][i] = cosine * vp - sine * vq;
                vectors[q][i] = sine * vp + cosine * vq;
            }
        }
        if !rotated {
            break;
        }
    }
    let vectors = Matrix3::from_fn(|i, j| vectors[j][i]);
    (Vector3::from(diagonal), vectors)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Deterministic numbers in [−1, 1).
    fn numbers(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }
    }

    #[test]
    fn accurate_for_apart_near_and_equal_values() {
        let mut next = numbers(7);
        for spread in [1.0, 1e-4, 1e-8, 1e-12, 1e-15, 0.0] {
            for _ in 0..200 {
                let half = Matrix3::from_fn(|_, _| next());
                let matrix = Matrix3::identity() * 1.5 + (half + half.transpose()) * (0.2 * spread);
                let (values, vectors) = symmetric_eigen(&matrix);
                let product = vectors * Matrix3::from_diagonal(&values) * vectors.transpose();
                assert!((product - matrix).amax() < 3e-15, "{spread}: {:e}", (product - matrix).amax());
                let gram = vectors.transpose() * vectors;
                assert!((gram - Matrix3::identity()).amax() < 3e-15);
            }
        }
    }

    /// Values of very different size: each keeps its own digits as far as the matrix determines them.
    #[test]
    fn small_values_beside_large_ones() {
        let matrix = Matrix3::new(1e8, 1.0, 0.0, 1.0, 1.0, 1e-5, 0.0, 1e-5, 1e-8);
        let (values, _) = symmetric_eigen(&matrix);
        // det = 1e8 (1e-8 − 1e-10) − 1e-8, and the largest is 1e8 + 1e-8.
        let determinant = 1e8 * (1e-8 - 1e-10) - 1e-8;
        assert!((values.product() - determinant).abs() < 1e-13 * determinant, "{values}");
    }

    #[test]
    fn what_is_not_finite_stays_so() {
        for bad in [f64::NAN, f64::INFINITY] {
            let mut matrix = Matrix3::identity();
            matrix[(1, 0)] = bad;
            let (values, _) = symmetric_eigen(&matrix);
            assert!(values.iter().any(|v| !v.is_finite()), "{values}");
        }
    }
}
