//! A document with a checksum: a damaged one is not taken for what was written.

use std::hash::Hasher;

use siphasher::sip128::{Hasher128, SipHasher13};

/// What a sealed document begins with.
const BEGIN: &str = "{\"checksum\":\"";
/// Hexadecimal digits of the checksum.
const DIGITS: usize = 32;

/// The document, a JSON object with fields, with its checksum as the first of them.
pub fn sealed(document: &str) -> String {
    format!("{BEGIN}{}\",{}", digest(document), &document[1..])
}

/// What the checksum of a sealed document is, and what it should be, unless they are the same.
pub fn broken(text: &str) -> Option<[String; 2]> {
    let parts = text.strip_prefix(BEGIN).and_then(|rest| rest.split_at_checked(DIGITS));
    let Some((found, rest)) = parts else {
        return Some(["none at its beginning".to_owned(), digest(text)]);
    };
    let document = format!("{{{}", rest.strip_prefix("\",").unwrap_or(rest));
    let expected = digest(&document);
    (found != expected).then(|| [found.to_owned(), expected])
}

/// A number of a text, as 32 hexadecimal digits, the same on every machine.
pub fn digest(text: &str) -> String {
    let mut hasher = SipHasher13::new();
    hasher.write(text.as_bytes());
    format!("{:032x}", hasher.finish128().as_u128())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_other_byte_breaks_a_seal() {
        let text = sealed(r#"{"time":0.25,"positions":[[1.0,2.0,3.0]]}"#);
        assert_eq!(broken(&text), None);
        assert!(serde_json::from_str::<serde_json::Value>(&text).is_ok());
        for k in 0..text.len() {
            let mut bytes = text.clone().into_bytes();
            bytes[k] ^= 1;
            assert!(broken(std::str::from_utf8(&bytes).unwrap()).is_some(), "byte {k}");
        }
        assert!(broken("").is_some());
    }
}
