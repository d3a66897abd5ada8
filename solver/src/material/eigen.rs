//! Principal values and axes of a symmetric 3 × 3 matrix.

use diffuse_contact::eigen;
use nalgebra::{Matrix3, Vector3};

/// Eigenvalues, ascending, and as columns the vectors that belong to them. Only the lower triangle is read. With a NaN or an infinity
/// in it the values are not finite either.
#[inline]
pub(crate) fn symmetric_eigen(matrix: &Matrix3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
    // Rows of the transpose: its upper triangle is the lower one.
    let rows = matrix.data.0;
    let pairs = eigen::symmetric_eigen(rows);
    let values = Vector3::from(pairs.map(|(value, _)| value));
    (values, Matrix3::from_columns(&pairs.map(|(_, vector)| Vector3::from(vector))))
}
