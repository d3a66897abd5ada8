//! Weights written as text: a parser, and an evaluator over any kind of number.
//!
//! ```text
//! formula    = sum
//! sum        = product { ("+" | "-") product }
//! product    = signed { ("*" | "/") signed }
//! signed     = "-" signed | power
//! power      = atom [ "^" exponent ]
//! exponent   = [ "-" ] integer | "(" [ "-" ] integer ")"
//! atom       = number | "r" | "(" sum ")" | ("sqrt" | "exp") "(" sum ")" | piecewise
//! piecewise  = "if" sum ("<" | "<=" | ">" | ">=") sum "{" sum "}" "else" ( "{" sum "}" | piecewise )
//! ```
//!
//! A formula becomes a list of steps, each of which refers to earlier ones only. Evaluation is one loop over
//! it, and no length of formula can exhaust the stack; the parser bounds the nesting.
//!
//! The generator has a parser of its own, `diffuse_contact_codegen::formula`, which this crate does without: the generator is a build
//! dependency, and its parser stands on `syn`, which takes as long to compile as this crate. Two parsers also let `check` find a formula
//! that one of them misreads: with one, both witnesses would differentiate the same wrong weight.

mod lexer;
mod parser;

use num_dual::DualNum;

use super::{RadialWeight, WeightError};

/// A weight function w(r) written as text.
///
/// Understood are numbers, `r`, `+ - * / ^` (`^` with an integer exponent, possibly negative, binding tighter
/// than the sign: `-r^2` is −(r²)), parentheses, `sqrt(…)`, `exp(…)`, and
/// `if r < 0.5 { … } else { … }` with `<`, `<=`, `>` or `>=`. A comparison is decided by the values alone: what
/// happens to derivatives where the branches meet is the formula's affair.
///
/// ```
/// use diffuse_contact::ad::{Formula, RadialWeight};
///
/// let weight: Formula = "if r < 0.5 { 1 - 6*r^2 + 6*r^3 } else { 2*(1 - r)^3 }".parse()?;
/// assert_eq!(weight.evaluate(0.75), 2.0 * 0.25f64.powi(3));
/// # Ok::<(), diffuse_contact::ad::FormulaError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    /// The last step is the formula's value.
    steps: Vec<Step>,
}

/// Index of an earlier step.
type StepId = usize;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    Radius,
    Number(f64),
    Negate(StepId),
    Add(StepId, StepId),
    Subtract(StepId, StepId),
    Multiply(StepId, StepId),
    Divide(StepId, StepId),
    Power(StepId, i32),
    Sqrt(StepId),
    Exp(StepId),
    Select { left: StepId, comparison: Comparison, right: StepId, then: StepId, otherwise: StepId },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Comparison {
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
}

/// Why a text is not a weight. Positions are byte offsets from the beginning of the text.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum FormulaError {
    /// A character that belongs to no formula.
    #[error("unexpected character {character:?} at byte {position}")]
    UnexpectedCharacter { character: char, position: usize },
    /// Something understood, in the wrong place.
    #[error("found `{found}` at byte {position}, expected {expected}")]
    Unexpected { found: String, expected: &'static str, position: usize },
    /// The text ends too early.
    #[error("the formula ends at byte {position}, expected {expected}")]
    UnexpectedEnd { expected: &'static str, position: usize },
    /// A name other than `r`, `sqrt`, `exp`, `if` and `else`.
    #[error("unknown name `{name}` at byte {position}; known are r, sqrt, exp, if, else")]
    UnknownName { name: String, position: usize },
    /// A number that is malformed or too large.
    #[error("`{text}` at byte {position} is not a finite number")]
    InvalidNumber { text: String, position: usize },
    /// An exponent that is not an integer literal.
    #[error("the exponent `{text}` at byte {position} is not an integer literal")]
    InvalidExponent { text: String, position: usize },
    /// Parentheses, signs and branches inside one another beyond what the parser takes.
    #[error("nested more than {limit} deep at byte {position}")]
    TooDeep { limit: usize, position: usize },
    /// The formula can be read, but is not flat and finite at r = 0.
    #[error(transparent)]
    Weight(#[from] WeightError),
}

impl std::str::FromStr for Formula {
    type Err = FormulaError;

    fn from_str(text: &str) -> Result<Self, FormulaError> {
        Ok(Self { steps: parser::parse(text)? })
    }
}

impl RadialWeight for Formula {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, r: D) -> D {
        let mut values: Vec<D> = Vec::with_capacity(self.steps.len());
        for step in &self.steps {
            let value = match *step {
                Step::Radius => r,
                Step::Number(number) => D::from(number),
                Step::Negate(x) => -values[x],
                Step::Add(x, y) => values[x] + values[y],
                Step::Subtract(x, y) => values[x] - values[y],
                Step::Multiply(x, y) => values[x] * values[y],
                Step::Divide(x, y) => values[x] / values[y],
                Step::Power(x, exponent) => integer_power(values[x], exponent),
                Step::Sqrt(x) => values[x].sqrt(),
                Step::Exp(x) => values[x].exp(),
                Step::Select { left, comparison, right, then, otherwise } => {
                    let (left, right) = (values[left].re(), values[right].re());
                    values[if comparison.holds(left, right) { then } else { otherwise }]
                }
            };
            values.push(value);
        }
        values[self.steps.len() - 1]
    }
}

impl Comparison {
    fn holds(self, left: f64, right: f64) -> bool {
        match self {
            Self::Less => left < right,
            Self::LessOrEqual => left <= right,
            Self::Greater => left > right,
            Self::GreaterOrEqual => left >= right,
        }
    }
}

/// x^n by repeated squaring: exact derivatives at x = 0 too, and no intermediate n(n − 1)(n − 2).
fn integer_power<D: DualNum<Primitive = f64> + Copy>(x: D, exponent: i32) -> D {
    let mut power = D::one();
    let mut square = x;
    let mut rest = exponent.unsigned_abs();
    while rest > 0 {
        if rest & 1 == 1 {
            power *= square;
        }
        rest >>= 1;
        if rest > 0 {
            square *= square;
        }
    }
    if exponent < 0 { power.recip() } else { power }
}

#[cfg(test)]
mod tests {
    use num_dual::Dual2;

    use super::*;

    fn value(text: &str, r: f64) -> f64 {
        text.parse::<Formula>().unwrap_or_else(|error| panic!("{text}: {error}")).evaluate(r)
    }

    fn error(text: &str) -> FormulaError {
        text.parse::<Formula>().unwrap_err()
    }

    #[test]
    fn precedence_is_that_of_mathematics() {
        assert_eq!(value("-r^2", 3.0), -9.0);
        assert_eq!(value("2 - -r^2", 3.0), 11.0);
        assert_eq!(value("--r", 3.0), 3.0);
        assert_eq!(value("1 - 2 - 3", 0.0), -4.0);
        assert_eq!(value("12 / 2 / 3", 0.0), 2.0);
        assert_eq!(value("2 + 3 * r ^ 2", 2.0), 14.0);
        assert_eq!(value("2 * -r", 2.0), -4.0);
        assert_eq!(value("(1 + r)^-2", 1.0), 0.25);
        assert_eq!(value("(1 + r)^(-2)", 1.0), 0.25);
        assert_eq!(value("r^0", 0.0), 1.0);
        assert_eq!(value("1.5e1 + .5 + 2.", 0.0), 17.5);
        assert_eq!(value("sqrt(exp(r))", 2.0), 2.0f64.exp().sqrt());
    }

    #[test]
    fn branches() {
        let spline = "if r < 0.5 { 1 } else if r <= 0.75 { 2 } else { 3 }";
        assert_eq!([0.4, 0.5, 0.75, 0.8].map(|r| value(spline, r)), [1.0, 2.0, 2.0, 3.0]);
        assert_eq!(value("2 * (if r > 1 { r } else { -r }) + 1", 0.5), 0.0);
        assert_eq!(value("if r >= 2*r - 1 { 1 } else { 0 }", 1.0), 1.0);
        // The branch not taken may be undefined.
        assert_eq!(value("if r < 2 { r } else { sqrt(r - 2) }", 1.0), 1.0);
    }

    #[test]
    fn derivatives_of_a_formula() {
        // w = e^(−4r²)(1 − r²)²: w' = e^(−4r²)(1 − r²)(−8r(1 − r²) − 4r).
        let weight: Formula = "exp(-4*r^2)*(1-r^2)^2".parse().unwrap();
        let r: f64 = 0.3;
        let found = weight.evaluate(Dual2::from_re(r).derivative());
        let q = 1.0 - r * r;
        let expected = (-4.0 * r * r).exp() * q * (-8.0 * r * q - 4.0 * r);
        assert!((found.v1 - expected).abs() < 1e-15);
        let h = 1e-4;
        let second = (weight.evaluate(r + h) - 2.0 * weight.evaluate(r) + weight.evaluate(r - h)) / (h * h);
        assert!((found.v2 - second).abs() < 1e-6);
    }

    #[test]
    fn large_exponents() {
        assert_eq!(value("(1 - r)^2147483647", 0.5), 0.0);
        let x = Dual2::from_re(1.0).derivative();
        assert_eq!(integer_power(x, 5000).v2, 5000.0 * 4999.0);
        assert_eq!(integer_power(x, i32::MIN).v1, f64::from(i32::MIN));
    }

    #[test]
    fn errors_say_where() {
        assert_eq!(error("1 + $"), FormulaError::UnexpectedCharacter { character: '$', position: 4 });
        assert!(matches!(error("(1 - r"), FormulaError::UnexpectedEnd { position: 6, .. }));
        assert!(matches!(error(""), FormulaError::UnexpectedEnd { position: 0, .. }));
        assert!(matches!(error("1 r"), FormulaError::Unexpected { position: 2, .. }));
        assert!(matches!(error("1 + * r"), FormulaError::Unexpected { position: 4, .. }));
        assert!(matches!(error("(1))"), FormulaError::Unexpected { position: 3, .. }));
        assert!(matches!(error("2*s"), FormulaError::UnknownName { position: 2, .. }));
        assert!(matches!(error("1.2.3"), FormulaError::InvalidNumber { position: 0, .. }));
        assert!(matches!(error("1 + 1e999"), FormulaError::InvalidNumber { position: 4, .. }));
        assert!(matches!(error("."), FormulaError::InvalidNumber { position: 0, .. }));
        assert!(matches!(error("r^2.5"), FormulaError::InvalidExponent { position: 2, .. }));
        assert!(matches!(error("r^r"), FormulaError::InvalidExponent { position: 2, .. }));
        assert!(matches!(error("r^99999999999"), FormulaError::InvalidExponent { position: 2, .. }));
        assert!(matches!(error("r^2^3"), FormulaError::Unexpected { position: 3, .. }));
        assert!(matches!(error("if r { 1 } else { 2 }"), FormulaError::Unexpected { position: 5, .. }));
        assert!(matches!(error("if r < 1 { 1 }"), FormulaError::UnexpectedEnd { position: 14, .. }));
        assert!(matches!(error("sqrt r"), FormulaError::Unexpected { position: 5, .. }));
        assert!(matches!(error("r < 1"), FormulaError::Unexpected { position: 2, .. }));
        assert!(matches!(error("1 + é"), FormulaError::UnexpectedCharacter { character: 'é', position: 4 }));
    }

    #[test]
    fn no_text_exhausts_the_stack() {
        assert!(matches!(error(&"(".repeat(100_000)), FormulaError::TooDeep { position: 100, .. }));
        assert!(matches!(error(&"-".repeat(100_000)), FormulaError::TooDeep { .. }));
        assert!(matches!(error(&"if r < ".repeat(10_000)), FormulaError::TooDeep { .. }));
        let chain = "if r < 0 { 0 } else ".repeat(10_000) + "{ 1 }";
        assert!(matches!(error(&chain), FormulaError::TooDeep { .. }));
        assert_eq!(value(&("0".to_owned() + &"+r".repeat(100_000)), 1.0), 100_000.0);
    }
}
