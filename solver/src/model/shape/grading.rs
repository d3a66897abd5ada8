//! Sizes of cells in geometric progression.

/// The ends of `count` cells over [0, 1], whose sizes grow geometrically from the first to `ratio` times as much in the last:
/// `count` + 1 numbers that begin with 0 and end with 1. With one cell the ratio has no meaning.
pub(super) fn graded(count: usize, ratio: f64) -> Vec<f64> {
    if ratio == 1.0 || count < 2 {
        return (0..=count).map(|k| k as f64 / count as f64).collect();
    }
    // (qᵏ − 1)/(qⁿ − 1) with qⁿ⁻¹ = ratio; without cancellation where q is close to 1.
    let log = ratio.ln() / (count - 1) as f64;
    let whole = (log * count as f64).exp_m1();
    let mut ends: Vec<f64> = (0..=count).map(|k| (log * k as f64).exp_m1() / whole).collect();
    ends[count] = 1.0;
    ends
}

/// The same with points in the middle of the cells, if there are two steps to a cell.
pub(super) fn graded_steps(count: usize, ratio: f64, steps: usize) -> Vec<f64> {
    let ends = graded(count, ratio);
    let middle =
        |k: usize| if k.is_multiple_of(2) { ends[k / 2] } else { 0.5 * (ends[k / 2] + ends[k / 2 + 1]) };
    if steps == 1 { ends } else { (0..=2 * count).map(middle).collect() }
}

/// The same to both sides of 0: a lattice coordinate from −count to count becomes a number from −1 to 1.
pub(super) fn mirrored(graded: &[f64], k: i64) -> f64 {
    let size = graded[k.unsigned_abs() as usize];
    if k < 0 { -size } else { size }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_a_geometric_progression() {
        for (count, ratio) in [(2, 3.0), (7, 20.0), (10, 0.05), (30, 1.0 + 1e-9), (1, 5.0), (4, 1.0)] {
            let ends = graded(count, ratio);
            let sizes: Vec<f64> = ends.windows(2).map(|pair| pair[1] - pair[0]).collect();
            assert_eq!((ends[0], ends[count], sizes.len()), (0.0, 1.0, count));
            if count > 1 {
                assert!((sizes[count - 1] / sizes[0] / ratio - 1.0).abs() < 1e-12, "{count} {ratio}");
            }
            for triple in sizes.windows(3) {
                assert!((triple[1] * triple[1] / (triple[0] * triple[2]) - 1.0).abs() < 1e-11);
            }
        }
        assert_eq!(mirrored(&[0.0, 0.5, 1.0], -1), -0.5);
    }
}
