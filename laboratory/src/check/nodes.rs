//! Ranges of node counts as they are written on the command line.

use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// Largest node count that is compared: beyond, automatic differentiation takes minutes per element.
const MOST: usize = 500;

/// Numbers of master nodes: `9`, `6..=12`, or `6..12` without its end as in Rust.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeCounts {
    text: String,
    range: RangeInclusive<usize>,
}

impl NodeCounts {
    /// First and last count.
    pub const fn range(&self) -> &RangeInclusive<usize> {
        &self.range
    }
}

impl fmt::Display for NodeCounts {
    /// As it was written.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// Why a text is no range of node counts.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NodeCountsError {
    #[error("neither a number of master nodes such as 9 nor a range such as 6..=12 or 6..12")]
    Form,
    #[error("the range is empty")]
    Empty,
    #[error("at most {MOST} master nodes can be checked")]
    TooMany,
}

impl FromStr for NodeCounts {
    type Err = NodeCountsError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let number = |text: &str| text.trim().parse::<usize>().map_err(|_| NodeCountsError::Form);
        let range = if let Some((first, last)) = text.split_once("..=") {
            number(first)?..=number(last)?
        } else if let Some((first, end)) = text.split_once("..") {
            let (first, end) = (number(first)?, number(end)?);
            first..=end.checked_sub(1).ok_or(NodeCountsError::Empty)?
        } else {
            let count = number(text)?;
            count..=count
        };
        if range.is_empty() {
            return Err(NodeCountsError::Empty);
        }
        if *range.end() > MOST {
            return Err(NodeCountsError::TooMany);
        }
        Ok(Self { text: text.trim().to_owned(), range })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<RangeInclusive<usize>, NodeCountsError> {
        text.parse::<NodeCounts>().map(|counts| counts.range)
    }

    #[test]
    fn one_number_or_a_range_of_either_kind() {
        assert_eq!(parse("9"), Ok(9..=9));
        assert_eq!(parse("6..=12"), Ok(6..=12));
        assert_eq!(parse("6..12"), Ok(6..=11));
        assert_eq!(parse(" 6 .. 7 "), Ok(6..=6));
    }

    #[test]
    fn what_is_no_range_is_refused() {
        for text in ["", "nine", "6..", "..=9", "6...9", "6-9", "-3", "6.5"] {
            assert_eq!(parse(text), Err(NodeCountsError::Form), "{text}");
        }
        for text in ["9..9", "9..=8", "0..0"] {
            assert_eq!(parse(text), Err(NodeCountsError::Empty), "{text}");
        }
        assert_eq!(parse("6..=501"), Err(NodeCountsError::TooMany));
    }
}
