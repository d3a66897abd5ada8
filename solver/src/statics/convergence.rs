//! Whether residuals say that an iteration goes on.

use super::observer::IterationRecord;

/// Residuals of one state, come back to, differ by less than this part.
const SAME: f64 = 1e-3;

/// Whether a round after so many iterations, of `most`, is given up. One that comes closer to equilibrium may have half as many more:
/// its last step was whole and brought the residual down, or each of its last three did so, and together to less than half.
pub fn is_spent(history: &[IterationRecord], iterations: usize, most: usize) -> bool {
    let is_whole =
        matches!(history, [.., before, last] if last.step >= 1.0 && last.residual < before.residual);
    let falls = |steps: &[IterationRecord]| {
        steps.is_sorted_by(|before, after| after.residual < before.residual)
            && steps[3].residual < 0.5 * steps[0].residual
    };
    let comes_closer = is_whole || history.last_chunk::<4>().is_some_and(|steps| falls(steps));
    iterations >= if comes_closer { most + most / 2 } else { most }
}

/// Whether the last five residuals are two in turn.
pub fn comes_back(history: &[IterationRecord]) -> bool {
    let [.., a, b, c, d, e] = history else { return false };
    let is_same = |a: &IterationRecord, b: &IterationRecord| {
        (a.residual - b.residual).abs() <= SAME * a.residual && a.active == b.active
    };
    // Residuals that shrink little by little are one state, not two.
    is_same(a, c) && is_same(c, e) && is_same(b, d) && !is_same(a, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn history(residuals: &[f64], active: &[usize]) -> Vec<IterationRecord> {
        let record = |(&residual, &active): (&f64, &usize)| IterationRecord {
            time: 1.0,
            iteration: 0,
            residual,
            relative: residual,
            excess: residual,
            allowed: 1e-6,
            active,
            step: 1.0,
        };
        residuals.iter().zip(active).map(record).collect()
    }

    #[test]
    fn whole_steps_towards_equilibrium_are_not_cut_off() {
        let mut history = history(&[6.8, 3.7], &[77, 80]);
        assert!(!is_spent(&history, 19, 20));
        assert!(!is_spent(&history, 20, 20));
        assert!(!is_spent(&history, 29, 20));
        assert!(is_spent(&history, 30, 20));
        assert!(is_spent(&history, 1, 1));
        history[1].step = 0.5;
        assert!(is_spent(&history, 20, 20));
        history[1] = IterationRecord { step: 1.0, residual: 6.9, ..history[1] };
        assert!(is_spent(&history, 20, 20));
        assert!(is_spent(&history[1..], 20, 20));
    }

    #[test]
    fn short_steps_that_halve_the_residual_are_not_cut_off() {
        let falling = |residuals: [f64; 4]| {
            let mut history = history(&residuals, &[77; 4]);
            history.iter_mut().for_each(|record| record.step = 0.3);
            history
        };
        assert!(!is_spent(&falling([8.0, 6.0, 5.0, 3.9]), 20, 20));
        assert!(is_spent(&falling([8.0, 6.0, 5.0, 3.9]), 30, 20));
        assert!(is_spent(&falling([8.0, 6.0, 5.0, 4.1]), 20, 20));
        assert!(is_spent(&falling([8.0, 3.0, 3.1, 2.9]), 20, 20));
        assert!(is_spent(&falling([8.0, 6.0, 5.0, 3.9])[1..], 20, 20));
    }

    #[test]
    fn two_rounds_of_two_states_are_a_cycle() {
        let residuals = [7.0, 0.124, 0.899, 0.124, 0.899, 0.124];
        assert!(comes_back(&history(&residuals, &[9, 4, 0, 4, 0, 4])));
        assert!(!comes_back(&history(&residuals[..5], &[9, 4, 0, 4, 0])));
        // Slow, but no cycle.
        let slow: Vec<f64> = (0..6).map(|k| 0.9997_f64.powi(k)).collect();
        assert!(!comes_back(&history(&slow, &[4; 6])));
        // Other contacts, or residuals that shrink.
        assert!(!comes_back(&history(&residuals, &[9, 4, 0, 5, 0, 4])));
        let shrinking: Vec<f64> = residuals.iter().zip(1..).map(|(r, k)| r * 0.999_f64.powi(k)).collect();
        assert!(!comes_back(&history(&shrinking, &[9, 4, 0, 4, 0, 4])));
    }
}
