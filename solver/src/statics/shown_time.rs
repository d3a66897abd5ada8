//! Times in messages.

use std::fmt::{self, Display, Formatter};

/// A time as a message shows it: at most six significant digits, none of them a zero at the end. What sums of increments leave behind the
/// last digit of a time is of no use to a reader; files hold all digits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShownTime(pub f64);

impl Display for ShownTime {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let rounded: f64 = format!("{:.5e}", self.0).parse().unwrap_or(self.0);
        let is_short = rounded == 0.0 || (1e-4..1e6).contains(&rounded.abs());
        f.pad(&if is_short { format!("{rounded}") } else { format!("{rounded:e}") })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_digits_are_left() {
        for (time, shown) in [
            (0.0, "0"),
            (1.0, "1"),
            (0.1 + 0.2, "0.3"),
            (-0.1 - 0.2, "-0.3"),
            (1.0 / 3.0, "0.333333"),
            (200.0 / 3.0, "66.6667"),
            (0.99999999, "1"),
            (123456.0, "123456"),
            (999999.9, "1e6"),
            (1234567.0, "1.23457e6"),
            (1e-4, "0.0001"),
            (1e-9 / 3.0, "3.33333e-10"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(ShownTime(time).to_string(), shown, "{time}");
        }
        assert!(ShownTime(f64::NAN).to_string().contains("NaN"));
        assert_eq!(format!("{:<8}|", ShownTime(0.5)), "0.5     |");
    }
}
