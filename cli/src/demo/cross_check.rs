//! The generated kernels against automatic differentiation, on a sample of the elements.

use std::time::{Duration, Instant};

use diffuse_contact::{Backend, Gap, Mode};

use super::nodes::SlaveNodes;
use crate::progress::progress;

/// Elements compared: this many, evenly spread over those that were evaluated, or all if there are fewer.
const SAMPLE: usize = 20;

/// Worst differences over the sample.
#[derive(Default)]
pub struct CrossCheck {
    /// Elements compared.
    pub elements: usize,
    /// Elements one backend evaluates and the other does not.
    pub disagreements: usize,
    /// |Δg| over the larger of |g| and the support radius: g itself may be zero.
    pub gap: f64,
    /// Largest |ΔN| over the largest |N|.
    pub gradient: f64,
    /// Largest |ΔM| over the largest |M|.
    pub hessian: f64,
    /// Mean time of one evaluation by the reference.
    pub reference_time: Duration,
}

/// Compares two backends in Hessian mode.
pub fn compare(tested: &dyn Backend, reference: &dyn Backend, nodes: &SlaveNodes) -> CrossCheck {
    let evaluated: Vec<_> = nodes
        .nodes
        .iter()
        .filter(|node| node.contact.is_some())
        .filter_map(|node| node.pairing.as_ref().map(|pairing| pairing.element(node.position)))
        .collect();
    let count = SAMPLE.min(evaluated.len());
    let bar = progress("check against AD", count);
    let mut check = CrossCheck { elements: count, ..CrossCheck::default() };
    for element in (0..count).map(|k| &evaluated[k * evaluated.len() / count]) {
        let start = Instant::now();
        let expected = reference.gap(element, Mode::Hessian);
        check.reference_time += start.elapsed();
        match (tested.gap(element, Mode::Hessian), expected) {
            (Ok(found), Ok(expected)) => check.add(&found, &expected, element.support_radius),
            _ => check.disagreements += 1,
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    check.reference_time /= count.max(1) as u32;
    check
}

impl CrossCheck {
    /// The largest of all differences.
    pub fn worst(&self) -> f64 {
        self.gap.max(self.gradient).max(self.hessian)
    }

    fn add(&mut self, found: &Gap, expected: &Gap, support_radius: f64) {
        let gap = (found.gap - expected.gap).abs() / expected.gap.abs().max(support_radius);
        self.gap = self.gap.max(gap);
        self.gradient = self.gradient.max(difference(&found.gradient, &expected.gradient));
        self.hessian = self.hessian.max(difference(found.hessian.packed(), expected.hessian.packed()));
    }
}

/// Largest difference over the largest entry of `expected`.
fn difference(found: &[f64], expected: &[f64]) -> f64 {
    let largest = expected.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let worst = found.iter().zip(expected).fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs()));
    if worst == 0.0 { 0.0 } else { worst / largest }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_relative_to_the_largest_entry() {
        assert_eq!(difference(&[1.0, -4.5], &[1.5, -4.0]), 0.125);
        assert_eq!(difference(&[0.0], &[0.0]), 0.0);
    }
}
