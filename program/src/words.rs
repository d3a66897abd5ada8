//! How tables and sentences are worded.

use std::fmt;
use std::time::Duration;

/// Width of the left column of a table.
const LABEL: usize = 22;

/// One line of the table.
pub fn row(f: &mut fmt::Formatter<'_>, label: &str, value: &str) -> fmt::Result {
    writeln!(f, "{label:<LABEL$}{value}")
}

/// A number of things, in the plural unless it is one.
pub fn counted(count: usize, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
}

/// A time with three digits and a fitting unit.
pub fn duration(time: Duration) -> String {
    let seconds = time.as_secs_f64();
    let (value, unit) = match seconds {
        s if s < 1e-3 => (s * 1e6, "µs"),
        s if s < 1.0 => (s * 1e3, "ms"),
        s => (s, "s"),
    };
    let digits = if value < 10.0 { 2 } else { usize::from(value < 100.0) };
    format!("{value:.digits$} {unit}")
}

/// A number with at most so many significant digits, none of them a zero at the end. Lengths may be in any unit: those of a mesh in
/// metres are small.
pub fn number(value: f64, digits: usize) -> String {
    let rounded: f64 = format!("{value:.*e}", digits - 1).parse().unwrap_or(value);
    let is_short = rounded == 0.0 || (1e-4..1e6).contains(&rounded.abs());
    if is_short { format!("{rounded}") } else { format!("{rounded:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_three_digits_and_a_unit() {
        assert_eq!(duration(Duration::from_nanos(4_321)), "4.32 µs");
        assert_eq!(duration(Duration::from_micros(12_345)), "12.3 ms");
        assert_eq!(duration(Duration::from_millis(123_000)), "123 s");
    }

    #[test]
    fn numbers_keep_their_digits_in_any_unit() {
        for (value, shown) in [
            (0.0, "0"),
            (-0.522_812_34, "-0.522812"),
            (6.633_571_2, "6.63357"),
            (5.228e-7, "5.228e-7"),
            (1.0 / 3e-9, "3.33333e8"),
        ] {
            assert_eq!(number(value, 6), shown);
        }
        assert_eq!(number(-5.2281e-4, 3), "-0.000523");
    }

    #[test]
    fn one_thing_is_singular() {
        assert_eq!((counted(1, "node"), counted(2, "node")), ("1 node".into(), "2 nodes".into()));
    }
}
