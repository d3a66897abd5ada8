//! How smooth a curve over time is.

/// The largest change of slope of a curve through points of time and value, from one increment to the next: what the value misses the
/// straight line by, over the largest value. Times ascend. 0 for fewer than three points, or if all values are 0.
pub fn largest_kink(curve: &[[f64; 2]]) -> f64 {
    let largest = curve.iter().map(|[_, value]| value.abs()).fold(0.0, f64::max);
    if largest == 0.0 {
        return 0.0;
    }
    let slope = |[from, to]: [[f64; 2]; 2]| (to[1] - from[1]) / (to[0] - from[0]);
    let kinks = curve.windows(3).map(|points| {
        let change = slope([points[1], points[2]]) - slope([points[0], points[1]]);
        (change * 0.5 * (points[2][0] - points[0][0])).abs() / largest
    });
    kinks.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_lines_and_of_a_corner() {
        assert_eq!(largest_kink(&[[0.0, 0.0], [1.0, 2.0], [3.0, 6.0]]), 0.0);
        assert_eq!(largest_kink(&[[0.0, 0.0], [1.0, 0.0], [2.0, 4.0]]), 1.0);
        assert_eq!(largest_kink(&[[0.0, 4.0], [1.0, 4.0], [2.0, 3.0], [3.0, 2.0]]), 0.25);
        assert_eq!((largest_kink(&[]), largest_kink(&[[0.0, 0.0]; 4])), (0.0, 0.0));
    }
}
