//! Whether a matrix is singular, by how its factors answer a load without order.

/// A load without order: it finds the modes of rigid bodies, which loads in equilibrium leave alone.
pub(super) fn probe(equations: usize) -> Vec<f64> {
    (0..equations).map(irregular).collect()
}

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

/// The largest sum of the moduli of a row, of entries by their rows: the norm that belongs to [`largest`].
pub(super) fn row_norm(rows: &[u32], values: &[f64], size: usize) -> f64 {
    let mut sums = vec![0.0; size];
    for (&row, value) in rows.iter().zip(values) {
        sums[row as usize] += value.abs();
    }
    largest(&sums)
}

/// ‖K‖ ‖x‖ / ‖b‖, a lower bound of the condition if K x = b.
pub(super) fn growth(norm: f64, x: &[f64], b: &[f64]) -> f64 {
    let growth = norm * largest(x) / largest(b);
    if growth.is_nan() { f64::INFINITY } else { growth }
}
