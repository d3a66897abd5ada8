//! How far to go along a step.

/// Slope after a step, relative to that before, that is good enough.
const GOOD: f64 = 0.8;
/// Shortest step, relative to the full one.
const SHORTEST: f64 = 0.005;
/// Slopes that differ by less than this part are one: until a loose body touches something, no step changes it.
const LEVEL: f64 = 1e-3;
/// Most evaluations besides that of the full step.
const TRIES: usize = 8;

/// Finds s in (0, 1] so that the slope, Δx·r at x + s Δx, is small against `start`, that at x; `full` is that at x + Δx. A root is
/// sought only if the slope has changed its sign. Of all steps tried, the full one among them, that with the smallest slope is
/// taken, of those with the same one the longest.
pub fn line_search<E>(start: f64, full: f64, mut slope: impl FnMut(f64) -> Result<f64, E>) -> Result<f64, E> {
    let good = |slope: f64| slope.abs() <= GOOD * start.abs();
    if good(full) || !start.is_finite() || !(start * full < 0.0) {
        return Ok(1.0);
    }
    // A root lies between.
    let (mut low, mut low_slope) = (0.0, start);
    let (mut high, mut high_slope) = (1.0, full);
    let mut best = (1.0, full.abs());
    let mut has_level = false;
    for _ in 0..TRIES {
        let secant = (low - low_slope * (high - low) / (high_slope - low_slope)).max(SHORTEST);
        let s = if has_level { 0.5 * (low + high) } else { secant };
        let found = slope(s)?;
        // There is no state there.
        if !found.is_finite() {
            break;
        }
        let is_level = (found - start).abs() <= LEVEL * start.abs();
        has_level |= is_level;
        if found.abs() < best.1
            || is_level && (best.1 - start.abs()).abs() <= LEVEL * start.abs() && s > best.0
        {
            best = (s, found.abs());
        }
        // Where even the shortest step is too far there is nothing to look for.
        if good(found) || (s <= SHORTEST && found * start < 0.0) {
            break;
        }
        // Illinois: the end that stays counts half.
        if found * low_slope > 0.0 {
            (low, low_slope) = (s, found);
            high_slope *= 0.5;
        } else {
            (high, high_slope) = (s, found);
            low_slope *= 0.5;
        }
    }
    Ok(best.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn search(slope: impl Fn(f64) -> f64) -> (f64, usize) {
        let mut count = 0;
        let found = line_search(slope(0.0), slope(1.0), |s| {
            count += 1;
            Ok::<_, ()>(slope(s))
        });
        (found.unwrap(), count)
    }

    #[test]
    fn a_step_that_does_well_is_taken_whole() {
        assert_eq!(search(|s| 1.0 - 0.9 * s), (1.0, 0));
        // Still descending: no shorter step is better.
        assert_eq!(search(|s| 1.0 + s), (1.0, 0));
    }

    #[test]
    fn a_step_too_far_is_shortened_to_where_the_slope_is_small() {
        let (s, _) = search(|s| 1.0 - 4.0 * s);
        assert!((s - 0.25).abs() < 0.2 * 0.25);
        let (s, count) = search(|s| 1.0 - 50.0 * s * s * s);
        assert!((1.0 - 50.0 * s * s * s).abs() <= GOOD && count <= TRIES);
        // The root is nearer than the shortest step.
        assert_eq!(search(|s| 1.0 - 1e4 * s).0, SHORTEST);
    }

    #[test]
    fn a_loose_body_goes_as_far_as_what_it_touches() {
        for (touches, stiffness) in [(0.9, 1e3), (0.5, 1e6), (0.99, 1e9), (0.05, 1e4)] {
            let (s, count) = search(|s| if s < touches { 1.0 } else { 1.0 - stiffness * (s - touches) });
            assert!((s - touches).abs() <= 0.02 && count <= TRIES, "{touches} {stiffness}: {s}");
        }
    }

    #[test]
    fn the_best_step_tried_is_taken() {
        // Worse at the shortest step than at the full one.
        assert_eq!(search(|s| if s == 0.0 { 1.0 } else { -30.0 + 28.0 * s }), (1.0, 3));
        // Jumps: no step is good enough, and the last one tried is not the best.
        let mut tried = Vec::new();
        let slopes = [-1.5, 1.2, -1.1, 1.9, -1.3, 1.7, -1.4, 1.6];
        let found = line_search(1.0, -2.0, |s| {
            tried.push(s);
            Ok::<_, ()>(slopes[tried.len() - 1])
        });
        assert_eq!((tried.len(), found), (TRIES, Ok(tried[2])));
        // What is no number is never the best.
        assert_eq!(line_search(1.0, -2.0, |_| Ok::<_, ()>(f64::NAN)), Ok(1.0));
    }
}
