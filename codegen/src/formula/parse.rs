//! The parser, on syn's token stream.

use syn::parse::{ParseStream, Parser};
use syn::spanned::Spanned;
use syn::{Ident, Lit, Token, braced, parenthesized, token};

use super::Formula;

/// Why a formula could not be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("in formula \"{formula}\", character {}: {message}\n    {formula}\n    {}^", .column + 1, " ".repeat(*.column))]
pub struct FormulaError {
    /// The formula, on one line.
    pub formula: String,
    /// What is wrong.
    pub message: String,
    /// The character it is about, counted from 0.
    pub column: usize,
}

pub(super) fn parse(text: &str) -> Result<Formula, FormulaError> {
    // One line, so that a column is a position in the formula.
    let line: String = text.chars().map(|c| if c.is_whitespace() { ' ' } else { c }).collect();
    let error = |message: String, column| FormulaError { formula: line.clone(), message, column };
    if line.trim().is_empty() {
        return Err(error("the formula is empty".to_owned(), 0));
    }
    if let Some((message, column)) = too_large(&line) {
        return Err(error(message, column));
    }
    let whole = |input: ParseStream<'_>| {
        let formula = sum(input)?;
        if input.is_empty() { Ok(formula) } else { Err(input.error("expected an operator or the end")) }
    };
    whole.parse_str(&line).map_err(|e| {
        let column = e.span().start().column;
        // At the end of the input syn points nowhere in particular.
        let message = e.to_string();
        if message.contains("cannot parse string into token stream") {
            return error(
                "the brackets do not match, or a character is not allowed".to_owned(),
                misplaced(&line),
            );
        }
        let at_end = message.contains("unexpected end of input");
        error(message, if at_end { line.trim_end().chars().count() } else { column })
    })
}

/// The first character no formula has, or the first bracket without a partner.
fn misplaced(line: &str) -> usize {
    let known = |c: char| c.is_ascii_alphanumeric() || " +-*/^().<>={}_,".contains(c);
    let unknown = line.chars().position(|c| !known(c));
    let mut open: Vec<(usize, char)> = Vec::new();
    let mut unmatched = None;
    for (column, c) in line.chars().enumerate() {
        match c {
            '(' | '{' => open.push((column, c)),
            ')' | '}' => {
                let partner = if c == ')' { '(' } else { '{' };
                if open.pop().is_none_or(|(_, opened)| opened != partner) && unmatched.is_none() {
                    unmatched = Some(column);
                }
            }
            _ => {}
        }
    }
    unknown.or(unmatched).or(open.last().map(|&(column, _)| column)).unwrap_or(0)
}

/// Most characters of a formula, and most brackets open at once: recursion goes no deeper than they let it.
const MOST_CHARACTERS: usize = 1_000;
const MOST_BRACKETS: usize = 100;

fn too_large(line: &str) -> Option<(String, usize)> {
    if line.chars().count() > MOST_CHARACTERS {
        return Some((format!("the formula is longer than {MOST_CHARACTERS} characters"), MOST_CHARACTERS));
    }
    if let Some(byte) = line.find("//").or_else(|| line.find("/*")) {
        return Some(("a formula has no comments".to_owned(), line[..byte].chars().count()));
    }
    let mut open = 0_usize;
    line.chars().enumerate().find_map(|(column, c)| {
        match c {
            '(' | '{' | '[' => open += 1,
            ')' | '}' | ']' => open = open.saturating_sub(1),
            _ => {}
        }
        (open > MOST_BRACKETS).then(|| (format!("more than {MOST_BRACKETS} brackets are open"), column))
    })
}

/// sum = product { ("+" | "-") product }
fn sum(input: ParseStream<'_>) -> syn::Result<Formula> {
    let mut left = product(input)?;
    loop {
        if input.parse::<Option<Token![+]>>()?.is_some() {
            left = Formula::Add(Box::new(left), Box::new(product(input)?));
        } else if input.parse::<Option<Token![-]>>()?.is_some() {
            left = Formula::Sub(Box::new(left), Box::new(product(input)?));
        } else {
            return Ok(left);
        }
    }
}

/// product = signed { ("*" | "/") signed }
fn product(input: ParseStream<'_>) -> syn::Result<Formula> {
    let mut left = signed(input)?;
    loop {
        if input.parse::<Option<Token![*]>>()?.is_some() {
            left = Formula::Mul(Box::new(left), Box::new(signed(input)?));
        } else if input.parse::<Option<Token![/]>>()?.is_some() {
            left = Formula::Div(Box::new(left), Box::new(signed(input)?));
        } else {
            return Ok(left);
        }
    }
}

/// signed = { "-" } power
fn signed(input: ParseStream<'_>) -> syn::Result<Formula> {
    let mut negative = false;
    while input.parse::<Option<Token![-]>>()?.is_some() {
        negative = !negative;
    }
    let value = power(input)?;
    Ok(if negative { Formula::Neg(Box::new(value)) } else { value })
}

/// power = atom [ "^" ["-"] integer ]
fn power(input: ParseStream<'_>) -> syn::Result<Formula> {
    let base = atom(input)?;
    let Some(caret) = input.parse::<Option<Token![^]>>()? else { return Ok(base) };
    let negative = input.parse::<Option<Token![-]>>()?.is_some();
    let literal: Lit =
        input.parse().map_err(|_| syn::Error::new(caret.span(), "an exponent must be an integer"))?;
    let Lit::Int(literal) = literal else {
        return Err(syn::Error::new(literal.span(), "an exponent must be an integer"));
    };
    let magnitude: i32 = literal.base10_parse()?;
    if !(0..=64).contains(&magnitude) {
        return Err(syn::Error::new(literal.span(), "an exponent must lie between -64 and 64"));
    }
    if input.peek(Token![^]) {
        return Err(input.error("powers of powers need parentheses"));
    }
    Ok(Formula::Power(Box::new(base), if negative { -magnitude } else { magnitude }))
}

/// atom = number | "r" | ("exp" | "sqrt") "(" sum ")" | "(" sum ")" | choice
fn atom(input: ParseStream<'_>) -> syn::Result<Formula> {
    if input.peek(token::Paren) {
        let inner;
        parenthesized!(inner in input);
        return finished(&inner);
    }
    if input.peek(Token![if]) {
        return choice(input);
    }
    if input.peek(Lit) {
        let literal: Lit = input.parse()?;
        let text = literal.span().source_text().unwrap_or_default();
        // Rust reads `2r` as the number 2 with a suffix, and knows `0x10` and `1_000`.
        if let Some(letter) = text.char_indices().find(|&(k, c)| !is_of_number(&text, k, c)) {
            let message = format!(
                "`{text}` is no number: write a product as `{} * {}`",
                &text[..letter.0],
                &text[letter.0..]
            );
            return Err(syn::Error::new(literal.span(), message));
        }
        let value: f64 = match &literal {
            Lit::Int(int) => int.base10_parse()?,
            Lit::Float(float) => float.base10_parse()?,
            other => return Err(syn::Error::new(other.span(), "expected a number")),
        };
        if !value.is_finite() {
            return Err(syn::Error::new(literal.span(), "the number is too large"));
        }
        return Ok(Formula::Number(value));
    }
    let name: Ident = input
        .parse()
        .map_err(|e| syn::Error::new(e.span(), at_end_or(&e, "expected a number, `r`, a function or `(`")))?;
    let function: fn(Box<Formula>) -> Formula = match name.to_string().as_str() {
        "r" => return Ok(Formula::Radius),
        "exp" => Formula::Exp,
        "sqrt" => Formula::Sqrt,
        other => {
            let message = format!("`{other}` is unknown: a weight is a formula in `r` with `exp` and `sqrt`");
            return Err(syn::Error::new(name.span(), message));
        }
    };
    if !input.peek(token::Paren) {
        return Err(syn::Error::new(name.span(), format!("`{name}` needs an argument in parentheses")));
    }
    let argument;
    parenthesized!(argument in input);
    Ok(function(Box::new(finished(&argument)?)))
}

/// Whether a character belongs to a decimal number with an optional exponent.
fn is_of_number(text: &str, position: usize, c: char) -> bool {
    let before = text[..position].chars().next_back();
    let exponent_follows = text[position + c.len_utf8()..]
        .trim_start_matches(['+', '-'])
        .starts_with(|next: char| next.is_ascii_digit());
    c.is_ascii_digit()
        || c == '.'
        || (matches!(c, 'e' | 'E') && exponent_follows)
        || (matches!(c, '+' | '-') && matches!(before, Some('e' | 'E')))
}

/// choice = "if" sum ("<" | "<=" | ">" | ">=") sum "{" sum "}" "else" ( "{" sum "}" | choice )
fn choice(input: ParseStream<'_>) -> syn::Result<Formula> {
    input.parse::<Token![if]>()?;
    let x = Box::new(sum(input)?);
    // On a set of measure zero the two kinds of comparison differ; there both branches have to agree anyway.
    let swapped = if input.parse::<Option<Token![<=]>>()?.is_some()
        || input.parse::<Option<Token![<]>>()?.is_some()
    {
        false
    } else if input.parse::<Option<Token![>=]>>()?.is_some() || input.parse::<Option<Token![>]>>()?.is_some()
    {
        true
    } else {
        return Err(input.error("expected a comparison with <, <=, > or >="));
    };
    let y = Box::new(sum(input)?);
    let (x, y) = if swapped { (y, x) } else { (x, y) };
    let block;
    braced!(block in input);
    let then = Box::new(finished(&block)?);
    input.parse::<Token![else]>()?;
    let otherwise = if input.peek(Token![if]) {
        choice(input)?
    } else {
        let block;
        braced!(block in input);
        finished(&block)?
    };
    Ok(Formula::If { x, y, then, otherwise: Box::new(otherwise) })
}

/// A sum that fills the whole group.
fn finished(input: ParseStream<'_>) -> syn::Result<Formula> {
    let formula = sum(input)?;
    if input.is_empty() { Ok(formula) } else { Err(input.error("expected an operator or a closing bracket")) }
}

fn at_end_or(error: &syn::Error, message: &str) -> String {
    let text = error.to_string();
    if text.contains("unexpected end of input") { format!("{text}, {message}") } else { message.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> (String, usize) {
        let error = parse(text).unwrap_err();
        (error.message, error.column)
    }

    #[test]
    fn errors_point_at_the_character() {
        assert_eq!(error("(1 - q)^2").1, 5);
        assert!(error("(1 - q)^2").0.contains("`q` is unknown"));
        assert_eq!(error("1 - r^0.5").1, 6);
        assert_eq!(error("1 + ").1, 3);
        assert_eq!(error("1 - r r").1, 6);
        assert_eq!(error("exp 3").1, 0);
        assert_eq!(error("").1, 0);
        assert_eq!(error("(1 - r").1, 0);
        assert_eq!(error("exp(r^2))").1, 8);
        assert_eq!(error("(1 − r)^2").1, 3);
        assert_eq!(error("1 - r // no").1, 6);
        assert_eq!(error("r^2^2").1, 3);
        assert_eq!(error("1 + \"a\"").1, 4);
    }

    #[test]
    fn a_number_is_a_decimal_number() {
        for (text, column) in
            [("(1 + 2r)", 5), ("0x10", 0), ("1f32 + r", 0), ("1_0 - r", 0), ("1e-3r", 0), ("2.5r", 0)]
        {
            let (message, at) = error(text);
            assert!(message.contains("is no number"), "{text}: {message}");
            assert_eq!(at, column, "{text}");
        }
        let value = |text: &str| parse(text).unwrap().evaluate(1.0);
        assert_eq!(["1e-3", "2.5E+2", "1.", "10"].map(value), [1e-3, 250.0, 1.0, 10.0]);
    }

    #[test]
    fn a_choice_takes_either_comparison() {
        let less = parse("if r < 0.5 { 1 - r } else if r < 0.75 { 2 } else { 0 }").unwrap();
        let greater = parse("if 0.5 >= r { 1 - r } else if 0.75 > r { 2 } else { 0 }").unwrap();
        assert_eq!(less, greater);
        assert_eq!([0.25, 0.6, 0.8].map(|r| less.evaluate(r)), [0.75, 2.0, 0.0]);
    }

    #[test]
    fn the_message_shows_the_formula_with_a_mark() {
        let shown = parse("1 - q").unwrap_err().to_string();
        assert!(shown.ends_with("    1 - q\n        ^"), "{shown}");
    }
}
