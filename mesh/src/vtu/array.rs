//! Arrays of numbers, as text and as bytes.

use std::borrow::Cow;
use std::io::{self, Write};

/// Bytes before an appended array: its length, as `UInt64`.
pub(super) const HEADER_BYTES: u64 = 8;

/// The values of a field.
#[derive(Clone, Debug)]
pub(super) enum Values<'a> {
    Scalars(Cow<'a, [f64]>),
    Vectors(Cow<'a, [[f64; 3]]>),
    /// xx, yy, zz, xy, yz, xz
    Tensors(Cow<'a, [[f64; 6]]>),
    I32(Cow<'a, [i32]>),
    I64(Cow<'a, [i64]>),
}

impl Values<'_> {
    pub fn array(&self) -> Array<'_> {
        match self {
            Values::Scalars(values) => Array::Scalars(values),
            Values::Vectors(values) => Array::Vectors(values),
            Values::Tensors(values) => Array::Tensors(values),
            Values::I32(values) => Array::I32(values),
            Values::I64(values) => Array::I64(values),
        }
    }

    /// The number of points or cells the values are for.
    pub fn len(&self) -> usize {
        self.array().len()
    }

    /// The first point or cell whose value is not finite.
    pub fn first_non_finite(&self) -> Option<usize> {
        match self {
            Values::Scalars(values) => values.iter().position(|value| !value.is_finite()),
            Values::Vectors(values) => values.iter().position(|value| value.iter().any(|x| !x.is_finite())),
            Values::Tensors(values) => values.iter().position(|value| value.iter().any(|x| !x.is_finite())),
            Values::I32(_) | Values::I64(_) => None,
        }
    }
}

/// Borrowed values of any type a file has.
#[derive(Clone, Copy)]
pub(super) enum Array<'a> {
    Scalars(&'a [f64]),
    Vectors(&'a [[f64; 3]]),
    Tensors(&'a [[f64; 6]]),
    I32(&'a [i32]),
    I64(&'a [i64]),
    Indices(&'a [usize]),
    U8(&'a [u8]),
}

impl Array<'_> {
    fn len(self) -> usize {
        match self {
            Array::Scalars(values) => values.len(),
            Array::Vectors(values) => values.len(),
            Array::Tensors(values) => values.len(),
            Array::I32(values) => values.len(),
            Array::I64(values) => values.len(),
            Array::Indices(values) => values.len(),
            Array::U8(values) => values.len(),
        }
    }

    pub fn components(self) -> usize {
        match self {
            Array::Vectors(_) => 3,
            Array::Tensors(_) => 6,
            _ => 1,
        }
    }

    pub fn vtk_type(self) -> &'static str {
        match self {
            Array::Scalars(_) | Array::Vectors(_) | Array::Tensors(_) => "Float64",
            Array::I32(_) => "Int32",
            Array::I64(_) | Array::Indices(_) => "Int64",
            Array::U8(_) => "UInt8",
        }
    }

    pub fn byte_count(self) -> u64 {
        let size = match self {
            Array::Scalars(_) | Array::I64(_) | Array::Indices(_) => 8,
            Array::Vectors(_) => 24,
            Array::Tensors(_) => 48,
            Array::I32(_) => 4,
            Array::U8(_) => 1,
        };
        size * self.len() as u64
    }

    /// One point or cell per line; numbers as short as they can be without losing a bit.
    pub fn write_text(self, writer: &mut impl Write) -> io::Result<()> {
        match self {
            Array::Scalars(values) => values.iter().try_for_each(|value| writeln!(writer, "{value:?}")),
            Array::Vectors(values) => {
                values.iter().try_for_each(|[x, y, z]| writeln!(writer, "{x:?} {y:?} {z:?}"))
            }
            Array::Tensors(values) => values.iter().try_for_each(|[xx, yy, zz, xy, yz, xz]| {
                writeln!(writer, "{xx:?} {yy:?} {zz:?} {xy:?} {yz:?} {xz:?}")
            }),
            Array::I32(values) => values.iter().try_for_each(|value| writeln!(writer, "{value}")),
            Array::I64(values) => values.iter().try_for_each(|value| writeln!(writer, "{value}")),
            Array::Indices(values) => values.iter().try_for_each(|value| writeln!(writer, "{value}")),
            Array::U8(values) => values.iter().try_for_each(|value| writeln!(writer, "{value}")),
        }
    }

    /// The header and the values, little-endian.
    pub fn write_binary(self, writer: &mut impl Write) -> io::Result<()> {
        writer.write_all(&self.byte_count().to_le_bytes())?;
        match self {
            Array::Scalars(values) => values.iter().try_for_each(|x| writer.write_all(&x.to_le_bytes())),
            Array::Vectors(values) => {
                values.as_flattened().iter().try_for_each(|x| writer.write_all(&x.to_le_bytes()))
            }
            Array::Tensors(values) => {
                values.as_flattened().iter().try_for_each(|x| writer.write_all(&x.to_le_bytes()))
            }
            Array::I32(values) => values.iter().try_for_each(|i| writer.write_all(&i.to_le_bytes())),
            Array::I64(values) => values.iter().try_for_each(|i| writer.write_all(&i.to_le_bytes())),
            Array::Indices(values) => {
                values.iter().try_for_each(|&index| writer.write_all(&(index as u64).to_le_bytes()))
            }
            Array::U8(values) => writer.write_all(values),
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
    fn binary_arrays_are_as_long_as_announced() {
        let arrays = [
            Array::Scalars(&[1.0, 2.0]),
            Array::Vectors(&[[1.0; 3]; 2]),
            Array::I32(&[1, -2]),
            Array::I64(&[1, -2, 3]),
            Array::Indices(&[7]),
            Array::U8(&[1, 2, 3]),
        ];
        for array in arrays {
            let mut bytes = Vec::new();
            array.write_binary(&mut bytes).unwrap();
            assert_eq!(bytes.len() as u64, HEADER_BYTES + array.byte_count());
        }
    }
}
