//! Reads numbers and lines from the bytes of an MSH file, whether they are written as text or as binary.

use crate::error::{Fault, Problem};

/// How the numbers of a file are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The bytes of a file and how far they have been read.
pub(super) struct Source<'a> {
    bytes: &'a [u8],
    at: usize,
    pub encoding: Encoding,
}

impl<'a> Source<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, encoding: Encoding::Ascii }
    }

    /// The position of the next number, for messages.
    pub fn at(&mut self) -> usize {
        if self.encoding == Encoding::Ascii {
            self.skip_whitespace();
        }
        self.at
    }

    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    fn skip_whitespace(&mut self) {
        self.at = self.bytes.len() - self.rest().trim_ascii_start().len();
    }

    /// The next line that is not blank, trimmed, with its position.
    pub fn line(&mut self) -> Option<(usize, &'a [u8])> {
        self.skip_whitespace();
        let start = self.at;
        let rest = self.rest();
        if rest.is_empty() {
            return None;
        }
        let length = rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len());
        self.at = (start + length + 1).min(self.bytes.len());
        Some((start, rest[..length].trim_ascii()))
    }

    /// Like [`line`](Self::line), where the end of the file is an error.
    pub fn expected_line(&mut self, expected: &str) -> Result<(usize, &'a [u8]), Fault> {
        let end = self.bytes.len();
        self.line().ok_or_else(|| Fault::truncated(end, expected))
    }

    /// Reads the line that ends a section.
    pub fn end_of(&mut self, section: &str) -> Result<(), Fault> {
        let end = format!("$End{section}");
        let (at, line) = self.expected_line(&end)?;
        if line == end.as_bytes() { Ok(()) } else { Err(Fault::unexpected(at, end, line)) }
    }

    /// Jumps behind the end of a section whose content is of no interest.
    pub fn skip_section(&mut self, section: &str) -> Result<(), Fault> {
        let end = format!("\n$End{section}");
        let found = self.bytes[self.at.saturating_sub(1)..]
            .windows(end.len())
            .position(|window| window == end.as_bytes())
            .ok_or_else(|| Fault::truncated(self.bytes.len(), end.trim_start()))?;
        self.at = self.at.saturating_sub(1) + found + 1;
        self.end_of(section)
    }

    /// Fails unless `count` items of at least `size` bytes can follow: what a header announces is not trusted.
    pub fn check_announced(&mut self, count: u64, size: u64, what: &'static str) -> Result<(), Fault> {
        // As text, an item is at least one digit and a separator, which may be missing at the end of the file.
        let least = if self.encoding == Encoding::Ascii { 2 } else { size };
        if count.saturating_mul(least) > self.rest().len() as u64 + 1 {
            return Err(Fault::new(self.at, Problem::CountTooLarge { what, declared: count }));
        }
        Ok(())
    }

    /// A `size_t`: a count or a tag.
    pub fn size(&mut self, what: &str) -> Result<u64, Fault> {
        match self.encoding {
            Encoding::Ascii => self.parsed(what),
            Encoding::LittleEndian => self.raw(what).map(u64::from_le_bytes),
            Encoding::BigEndian => self.raw(what).map(u64::from_be_bytes),
        }
    }

    /// An `int`.
    pub fn int(&mut self, what: &str) -> Result<i32, Fault> {
        match self.encoding {
            Encoding::Ascii => self.parsed(what),
            Encoding::LittleEndian => self.raw(what).map(i32::from_le_bytes),
            Encoding::BigEndian => self.raw(what).map(i32::from_be_bytes),
        }
    }

    /// A `double`.
    pub fn real(&mut self, what: &str) -> Result<f64, Fault> {
        match self.encoding {
            Encoding::Ascii => self.parsed(what),
            Encoding::LittleEndian => self.raw(what).map(f64::from_le_bytes),
            Encoding::BigEndian => self.raw(what).map(f64::from_be_bytes),
        }
    }

    fn parsed<T: std::str::FromStr>(&mut self, what: &str) -> Result<T, Fault> {
        self.skip_whitespace();
        let rest = self.rest();
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let token = &rest[..length];
        if token.is_empty() {
            return Err(Fault::truncated(self.at, what));
        }
        let number = std::str::from_utf8(token).ok().and_then(|text| text.parse().ok());
        let number = number.ok_or_else(|| Fault::unexpected(self.at, what, token))?;
        self.at += length;
        Ok(number)
    }

    fn raw<const N: usize>(&mut self, what: &str) -> Result<[u8; N], Fault> {
        let (number, _) = self
            .rest()
            .split_first_chunk::<N>()
            .ok_or_else(|| Fault::new(self.bytes.len(), Problem::Truncated { expected: what.to_string() }))?;
        self.at += N;
        Ok(*number)
    }

    /// Reads the `int` 1 that tells how a binary file orders its bytes.
    pub fn byte_order(&mut self) -> Result<(), Fault> {
        let at = self.at;
        let one: [u8; 4] = self.raw("the number 1 that tells the byte order")?;
        self.encoding = match (i32::from_le_bytes(one), i32::from_be_bytes(one)) {
            (1, _) => Encoding::LittleEndian,
            (_, 1) => Encoding::BigEndian,
            _ => {
                return Err(Fault::unexpected(
                    at,
                    "the number 1 that tells the byte order",
                    format!("the bytes {one:02x?}"),
                ));
            }
        };
        Ok(())
    }
}
