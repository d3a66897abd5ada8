//! How much a quantity varies that ought to be constant.

/// Mean and range of a quantity over the increments of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillation {
    /// Mean of the values.
    pub mean: f64,
    /// The smallest.
    pub smallest: f64,
    /// The largest.
    pub largest: f64,
}

impl Oscillation {
    /// That of some values; `None` without any.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let (mut sum, mut count) = (0.0, 0.0);
        let (mut smallest, mut largest) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values {
            sum += value;
            count += 1.0;
            // One that is no number stays in both.
            if value.is_nan() || value < smallest {
                smallest = value;
            }
            if value.is_nan() || value > largest {
                largest = value;
            }
        }
        (count > 0.0).then(|| Self { mean: sum / count, smallest, largest })
    }

    /// The largest less the smallest value.
    pub fn peak_to_peak(&self) -> f64 {
        self.largest - self.smallest
    }

    /// The largest magnitude.
    pub fn amplitude(&self) -> f64 {
        self.largest.abs().max(self.smallest.abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_few_values() {
        let oscillation = Oscillation::of([1.0, -3.0, 5.0]).unwrap();
        assert_eq!(oscillation, Oscillation { mean: 1.0, smallest: -3.0, largest: 5.0 });
        assert_eq!((oscillation.peak_to_peak(), oscillation.amplitude()), (8.0, 5.0));
        assert_eq!(Oscillation::of([]), None);
        for values in [[f64::NAN, 1.0, -1.0], [1.0, f64::NAN, -1.0]] {
            let oscillation = Oscillation::of(values).unwrap();
            assert!(oscillation.amplitude().is_nan() && oscillation.peak_to_peak().is_nan());
        }
    }
}
