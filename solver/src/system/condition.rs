//! Whether a matrix is singular: the least that it makes of any direction.

use faer::sparse::SparseColMatRef;

/// Above this a first solution is enough: errors of factors do not hide a direction that costs nothing behind so much.
const SOUND: f64 = 1e-7;
/// Solutions that look for the weakest direction.
const MOST_SOLUTIONS: usize = 3;
/// Rounds of scaling. What rows and columns differ by is its root after each.
const SWEEPS: usize = 3;

/// A number in [−1, 1) without visible order, always the same for the same index.
pub(super) fn irregular(index: usize) -> f64 {
    let mut bits = (index as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// The maximum norm; NaN if an entry is.
pub(super) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, value| {
        let modulus = value.abs();
        if modulus > largest || modulus.is_nan() { modulus } else { largest }
    })
}

/// Euclidean, of numbers of any size.
pub(super) fn norm(values: &[f64]) -> f64 {
    let scale = largest(values);
    if scale == 0.0 || !scale.is_finite() {
        return scale;
    }
    scale * values.iter().map(|value| (value / scale).powi(2)).sum::<f64>().sqrt()
}

/// The least ‖K z‖ / (‖z‖ max |K_ij|) found, a bound from above of the smallest singular value over the largest entry. A body that nothing
/// holds leaves the rounding of K.
///
/// `solve` replaces a vector by K⁻¹ times it, with factors that need not be good: inverse iteration, of which the products with K are
/// judged. NaN or infinite if a solution is not finite.
pub(super) fn weakness<E>(
    matrix: SparseColMatRef<'_, u32, f64>,
    mut solve: impl FnMut(&mut [f64]) -> Result<(), E>,
) -> Result<f64, E> {
    let mut z: Vec<f64> = (0..matrix.ncols()).map(irregular).collect();
    let mut product = vec![0.0; z.len()];
    let mut least = f64::INFINITY;
    for _ in 0..MOST_SOLUTIONS {
        solve(&mut z)?;
        let size = largest(&z);
        z.iter_mut().for_each(|z| *z /= size);
        product.fill(0.0);
        for_each_entry(matrix, |row, column, value| product[row] += value * z[column]);
        let found = norm(&product) / norm(&z) / largest(matrix.val());
        if !found.is_finite() {
            return Ok(found);
        }
        let is_worth_more = found < 0.5 * least;
        least = least.min(found);
        if least > SOUND || !is_worth_more {
            break;
        }
    }
    Ok(least)
}

/// D, powers of two, with which rows and columns of D K D have a largest entry of about 1; 1 for a row and column of zeros. Neither a stiff
/// contact on a slender body nor soft springs beside stiff ones then make K look singular.
pub(super) fn scale(matrix: SparseColMatRef<'_, u32, f64>) -> Vec<f64> {
    let mut scale = vec![1.0; matrix.ncols()];
    let mut largest = vec![0.0_f64; scale.len()];
    for _ in 0..SWEEPS {
        largest.fill(0.0);
        for_each_entry(matrix, |row, column, value| {
            let modulus = (value * scale[row] * scale[column]).abs();
            largest[row] = largest[row].max(modulus);
            largest[column] = largest[column].max(modulus);
        });
        for (scale, largest) in scale.iter_mut().zip(&largest).filter(|(_, largest)| **largest > 0.0) {
            *scale *= (-0.5 * largest.log2()).round().exp2();
        }
    }
    scale
}

fn for_each_entry(matrix: SparseColMatRef<'_, u32, f64>, mut f: impl FnMut(usize, usize, f64)) {
    for (column, ends) in matrix.col_ptr().windows(2).enumerate() {
        let entries = ends[0] as usize..ends[1] as usize;
        for (&row, &value) in matrix.row_idx()[entries.clone()].iter().zip(&matrix.val()[entries]) {
            f(row as usize, column, value);
        }
    }
}
