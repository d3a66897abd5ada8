//! Arrays of numbers as bytes.

use std::borrow::Cow;
use std::io::{self, Write};

/// Bytes before an array: its length, as `UInt64`.
const HEADER_BYTES: usize = 8;

/// An array of any type a file has, with an entry for each point or cell.
#[derive(Clone, Debug)]
pub(super) enum Values<'a> {
    Scalars(Cow<'a, [f64]>),
    Vectors(Cow<'a, [[f64; 3]]>),
    /// xx, yy, zz, xy, yz, xz
    Tensors(Cow<'a, [[f64; 6]]>),
    I32(Cow<'a, [i32]>),
    Indices(Cow<'a, [usize]>),
    U8(Cow<'a, [u8]>),
}

/// How the entries of an array lie in a file.
pub(super) struct Layout {
    /// VTK's name of the numbers' type.
    pub kind: &'static str,
    /// Numbers of an entry.
    pub components: usize,
    /// Bytes of a number.
    size: usize,
    /// Number of entries.
    pub count: usize,
}

impl Layout {
    fn bytes(&self) -> usize {
        self.count * self.components * self.size
    }

    /// With the header.
    pub fn appended_bytes(&self) -> usize {
        HEADER_BYTES + self.bytes()
    }
}

impl Values<'_> {
    pub fn layout(&self) -> Layout {
        let (kind, components, size, count) = match self {
            Self::Scalars(values) => ("Float64", 1, 8, values.len()),
            Self::Vectors(values) => ("Float64", 3, 8, values.len()),
            Self::Tensors(values) => ("Float64", 6, 8, values.len()),
            Self::I32(values) => ("Int32", 1, 4, values.len()),
            Self::Indices(values) => ("Int64", 1, 8, values.len()),
            Self::U8(values) => ("UInt8", 1, 1, values.len()),
        };
        Layout { kind, components, size, count }
    }

    /// The header and the values, little-endian.
    pub fn write(&self, writer: &mut impl Write) -> io::Result<()> {
        writer.write_all(&(self.layout().bytes() as u64).to_le_bytes())?;
        let reals = |writer: &mut _, values: &[f64]| -> io::Result<()> {
            values.iter().try_for_each(|x| Write::write_all(writer, &x.to_le_bytes()))
        };
        match self {
            Self::Scalars(values) => reals(writer, values),
            Self::Vectors(values) => reals(writer, values.as_flattened()),
            Self::Tensors(values) => reals(writer, values.as_flattened()),
            Self::I32(values) => values.iter().try_for_each(|i| writer.write_all(&i.to_le_bytes())),
            Self::Indices(values) => {
                values.iter().try_for_each(|&index| writer.write_all(&(index as u64).to_le_bytes()))
            }
            Self::U8(values) => writer.write_all(values),
        }
    }
}

/// Text as it may stand in an XML attribute.
pub(super) fn escaped(text: &str) -> String {
    let mut result = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => result.push_str("&amp;"),
            '<' => result.push_str("&lt;"),
            '>' => result.push_str("&gt;"),
            '"' => result.push_str("&quot;"),
            '\'' => result.push_str("&apos;"),
            other => result.push(other),
        }
    }
    result
}

/// Whether XML attributes can hold the text unchanged: no control characters and no noncharacters.
pub(super) fn is_xml_text(text: &str) -> bool {
    !text.chars().any(|c| c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn special_characters_are_escaped() {
        assert_eq!(escaped("a<b & \"c\" > 'd' µ"), "a&lt;b &amp; &quot;c&quot; &gt; &apos;d&apos; µ");
        assert!(is_xml_text("λ < 1"));
        assert!(!is_xml_text("a\u{0}b"));
    }

    #[test]
    fn arrays_are_as_long_as_announced() {
        let arrays = [
            Values::Scalars(Cow::from(&[1.0, 2.0])),
            Values::Vectors(Cow::from(&[[1.0; 3]; 2])),
            Values::Tensors(Cow::from(&[[1.0; 6]; 3])),
            Values::I32(Cow::from(&[1, -2])),
            Values::Indices(Cow::from(&[7])),
            Values::U8(Cow::from(&[1, 2, 3])),
        ];
        for array in arrays {
            let mut bytes = Vec::new();
            array.write(&mut bytes).unwrap();
            assert_eq!(bytes.len(), array.layout().appended_bytes());
        }
    }
}
