//! From text to tokens.

use super::FormulaError;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Number(f64),
    Name,
    /// One of `+ - * / ^ ( ) { } <  <= > >=`.
    Symbol,
    End,
}

/// A piece of the text.
#[derive(Clone, Copy, Debug)]
pub(super) struct Token<'t> {
    pub(super) kind: Kind,
    pub(super) text: &'t str,
    /// Byte offset from the beginning.
    pub(super) position: usize,
}

impl Token<'_> {
    pub(super) fn is_symbol(&self, symbol: &str) -> bool {
        self.kind == Kind::Symbol && self.text == symbol
    }

    pub(super) fn is_name(&self, name: &str) -> bool {
        self.kind == Kind::Name && self.text == name
    }
}

/// All tokens of a text; the last is [`Kind::End`].
pub(super) fn tokens(text: &str) -> Result<Vec<Token<'_>>, FormulaError> {
    let mut tokens = Vec::new();
    let mut position = 0;
    while let Some(character) = text[position..].chars().next() {
        let rest = &text[position..];
        if character.is_whitespace() {
            position += character.len_utf8();
            continue;
        }
        let token = if character.is_ascii_digit() || character == '.' {
            let text = &rest[..number_length(rest)];
            let number = text.parse().ok().filter(|x: &f64| x.is_finite());
            let number =
                number.ok_or_else(|| FormulaError::InvalidNumber { text: text.to_owned(), position })?;
            Token { kind: Kind::Number(number), text, position }
        } else if character.is_ascii_alphabetic() || character == '_' {
            let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
            let length = rest.find(|c| !is_part(c)).unwrap_or(rest.len());
            Token { kind: Kind::Name, text: &rest[..length], position }
        } else if "+-*/^(){}<>".contains(character) {
            let length = if rest.starts_with("<=") || rest.starts_with(">=") { 2 } else { 1 };
            Token { kind: Kind::Symbol, text: &rest[..length], position }
        } else {
            return Err(FormulaError::UnexpectedCharacter { character, position });
        };
        position += token.text.len();
        tokens.push(token);
    }
    tokens.push(Token { kind: Kind::End, text: "", position });
    Ok(tokens)
}

/// Length of the number at the beginning: digits and points, and an exponent if digits follow the e.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let run = |from: usize, belongs: fn(u8) -> bool| {
        from + bytes[from..].iter().take_while(|byte| belongs(**byte)).count()
    };
    let mantissa = run(0, |byte| byte.is_ascii_digit() || byte == b'.');
    if !matches!(bytes.get(mantissa), Some(b'e' | b'E')) {
        return mantissa;
    }
    let sign = usize::from(matches!(bytes.get(mantissa + 1), Some(b'+' | b'-')));
    let digits = mantissa + 1 + sign;
    let end = run(digits, |byte| byte.is_ascii_digit());
    if end > digits { end } else { mantissa }
}
