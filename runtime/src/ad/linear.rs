//! Numbers of any kind, and the solution of small systems over them.

use num_dual::DualNum;

use crate::{Basis, ElementError};

/// A real, dual or hyper-dual number.
pub(super) trait Scalar: DualNum<Primitive = f64> + Copy {}
impl<D: DualNum<Primitive = f64> + Copy> Scalar for D {}

/// A pivot of the Cholesky factorisation has to exceed this fraction of the diagonal entry it came from.
///
/// Layouts on a conic leave rounding here, up to about 1e-8.
const PIVOT_TOLERANCE: f64 = 1e-7;
/// Where all nodes are on a line or two along the axes, a diagonal entry is rounding itself: a pivot is compared with at
/// least this fraction, to the power of its degree, of the diagonal's sum over its degree.
const SMALLEST_PART: f64 = 1e-4;

/// Coefficients, one per basis function; beyond the basis they are zero.
pub(super) type Coefficients<D> = [D; Basis::MOST_COEFFICIENTS];

/// Lower triangle of a matrix over the basis functions.
pub(super) type Matrix<D> = [Coefficients<D>; Basis::MOST_COEFFICIENTS];

/// Solves A x = b for these basis functions by A = L Lᵀ; `matrix` holds the lower triangle, entries beyond the functions
/// stay zero. `diagonals` are what the pivots are compared with.
pub(super) fn solve_cholesky<D: Scalar>(
    monomials: &[(u8, u8)],
    diagonals: [f64; Basis::MOST_COEFFICIENTS],
    mut matrix: Matrix<D>,
    mut vector: Coefficients<D>,
) -> Result<Coefficients<D>, ElementError> {
    let size = monomials.len();
    let degree = |j: usize| i32::from(monomials[j].0 + monomials[j].1);
    for j in 0..size {
        super::finite("moment", [diagonals[j]])?;
        let same: f64 = (0..size).filter(|&k| degree(k) == degree(j)).map(|k| diagonals[k]).sum();
        let diagonal = diagonals[j].max(SMALLEST_PART.powi(degree(j)) * same);
        let mut pivot = matrix[j][j];
        for entry in &matrix[j][..j] {
            pivot -= *entry * *entry;
        }
        super::finite("pivot", [pivot.re()])?;
        let pivot_ratio = if diagonal > 0.0 { pivot.re() / diagonal } else { 0.0 };
        if pivot_ratio <= PIVOT_TOLERANCE {
            return Err(ElementError::SingularFit { pivot_ratio, tolerance: PIVOT_TOLERANCE });
        }
        let root = pivot.sqrt();
        matrix[j][j] = root;
        for i in j + 1..size {
            let products = (0..j).map(|k| matrix[i][k] * matrix[j][k]);
            let entry = products.fold(matrix[i][j], |entry, product| entry - product);
            matrix[i][j] = entry / root;
        }
    }
    for i in 0..size {
        for k in 0..i {
            let known = vector[k];
            vector[i] -= matrix[i][k] * known;
        }
        vector[i] /= matrix[i][i];
    }
    for i in (0..size).rev() {
        for k in i + 1..size {
            let known = vector[k];
            vector[i] -= matrix[k][i] * known;
        }
        vector[i] /= matrix[i][i];
    }
    Ok(vector)
}

pub(super) fn dot<D: Scalar>(x: [D; 3], y: [D; 3]) -> D {
    x[0] * y[0] + x[1] * y[1] + x[2] * y[2]
}

pub(super) fn determinant([[a, b], [c, d]]: &[[f64; 2]; 2]) -> f64 {
    a * d - b * c
}

/// The inverse; infinite or NaN for a singular matrix.
pub(super) fn inverse(matrix: &[[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let [[a, b], [c, d]] = *matrix;
    let determinant = determinant(matrix);
    [[d / determinant, -b / determinant], [-c / determinant, a / determinant]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cholesky_solves_a_known_system() {
        // A = L Lᵀ with L = [[2], [1, 3], [-1, 2, 1]], x = (1, -2, 3).
        let mut matrix = [[0.0; 15]; 15];
        matrix[0][0] = 4.0;
        matrix[1][..2].copy_from_slice(&[2.0, 10.0]);
        matrix[2][..3].copy_from_slice(&[-2.0, 5.0, 6.0]);
        let (mut vector, mut diagonals) = ([0.0; 15], [0.0; 15]);
        vector[..3].copy_from_slice(&[4.0 - 4.0 - 6.0, 2.0 - 20.0 + 15.0, -2.0 - 10.0 + 18.0]);
        diagonals[..3].copy_from_slice(&[4.0, 10.0, 6.0]);
        let x: [f64; 15] = solve_cholesky(Basis::Linear.monomials(), diagonals, matrix, vector).unwrap();
        for (found, expected) in x.iter().zip([1.0, -2.0, 3.0, 0.0, 0.0, 0.0]) {
            assert!((found - expected).abs() < 1e-14, "{x:?}");
        }
    }

    #[test]
    fn an_indefinite_matrix_is_singular() {
        let mut matrix = [[0.0; 15]; 15];
        matrix[0][0] = 1.0;
        matrix[1][..2].copy_from_slice(&[1.0, 1.0]);
        let error = solve_cholesky(&[(1, 0), (0, 1)], [1.0; 15], matrix, [1.0; 15]).unwrap_err();
        assert_eq!(error, ElementError::SingularFit { pivot_ratio: 0.0, tolerance: PIVOT_TOLERANCE });
    }
}
