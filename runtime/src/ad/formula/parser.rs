//! From tokens to steps: one function per rule of the grammar.

use super::lexer::{Kind, Token, tokens};
use super::{Comparison, FormulaError, Step, StepId};

/// Parentheses, signs and branches may stand this deep inside one another.
const DEPTH_LIMIT: usize = 100;

/// The steps of a formula.
pub(super) fn parse(text: &str) -> Result<Vec<Step>, FormulaError> {
    let mut parser = Parser { tokens: tokens(text)?, next: 0, depth: 0, steps: Vec::new() };
    let value = parser.sum()?;
    if parser.peek().kind != Kind::End {
        return Err(parser.unexpected("an operator or the end of the formula"));
    }
    assert_eq!(value, parser.steps.len() - 1, "the value is the last step");
    Ok(parser.steps)
}

struct Parser<'t> {
    tokens: Vec<Token<'t>>,
    next: usize,
    depth: usize,
    steps: Vec<Step>,
}

impl<'t> Parser<'t> {
    fn sum(&mut self) -> Result<StepId, FormulaError> {
        let mut left = self.product()?;
        loop {
            left = if self.take_symbol("+") {
                let right = self.product()?;
                self.push(Step::Add(left, right))
            } else if self.take_symbol("-") {
                let right = self.product()?;
                self.push(Step::Subtract(left, right))
            } else {
                return Ok(left);
            };
        }
    }

    fn product(&mut self) -> Result<StepId, FormulaError> {
        let mut left = self.signed()?;
        loop {
            left = if self.take_symbol("*") {
                let right = self.signed()?;
                self.push(Step::Multiply(left, right))
            } else if self.take_symbol("/") {
                let right = self.signed()?;
                self.push(Step::Divide(left, right))
            } else {
                return Ok(left);
            };
        }
    }

    fn signed(&mut self) -> Result<StepId, FormulaError> {
        if !self.take_symbol("-") {
            return self.power();
        }
        let operand = self.nested(Self::signed)?;
        Ok(self.push(Step::Negate(operand)))
    }

    fn power(&mut self) -> Result<StepId, FormulaError> {
        let base = self.atom()?;
        if !self.take_symbol("^") {
            return Ok(base);
        }
        let parenthesised = self.take_symbol("(");
        let exponent = self.exponent()?;
        if parenthesised {
            self.expect(")", "`)`")?;
        }
        Ok(self.push(Step::Power(base, exponent)))
    }

    fn exponent(&mut self) -> Result<i32, FormulaError> {
        let start = self.peek().position;
        let sign = if self.take_symbol("-") { "-" } else { "" };
        let token = self.advance();
        if token.kind == Kind::End {
            let expected = "an integer exponent";
            return Err(FormulaError::UnexpectedEnd { expected, position: token.position });
        }
        let text = format!("{sign}{}", token.text);
        text.parse().map_err(|_| FormulaError::InvalidExponent { text, position: start })
    }

    fn atom(&mut self) -> Result<StepId, FormulaError> {
        let token = self.peek();
        if let Kind::Number(number) = token.kind {
            self.advance();
            return Ok(self.push(Step::Number(number)));
        }
        if token.is_symbol("(") {
            return self.enclosed("(", ")", "`)`");
        }
        if token.kind != Kind::Name {
            return Err(self.unexpected("a number, `r`, a function or `(`"));
        }
        match token.text {
            "r" => {
                self.advance();
                Ok(self.push(Step::Radius))
            }
            function @ ("sqrt" | "exp") => {
                self.advance();
                let argument = self.enclosed("(", ")", "`)`")?;
                let step = if function == "sqrt" { Step::Sqrt(argument) } else { Step::Exp(argument) };
                Ok(self.push(step))
            }
            "if" => self.nested(Self::piecewise),
            "else" => Err(self.unexpected("a number, `r`, a function or `(`")),
            name => Err(FormulaError::UnknownName { name: name.to_owned(), position: token.position }),
        }
    }

    fn piecewise(&mut self) -> Result<StepId, FormulaError> {
        self.advance();
        let left = self.sum()?;
        let comparison = match self.peek().text {
            "<" => Comparison::Less,
            "<=" => Comparison::LessOrEqual,
            ">" => Comparison::Greater,
            ">=" => Comparison::GreaterOrEqual,
            _ => return Err(self.unexpected("a comparison")),
        };
        self.advance();
        let right = self.sum()?;
        let then = self.enclosed("{", "}", "`}`")?;
        if !self.peek().is_name("else") {
            return Err(self.unexpected("`else`"));
        }
        self.advance();
        let otherwise = if self.peek().is_name("if") {
            self.nested(Self::piecewise)?
        } else {
            self.enclosed("{", "}", "`}`")?
        };
        Ok(self.push(Step::Select { left, comparison, right, then, otherwise }))
    }

    /// A sum between two brackets.
    fn enclosed(
        &mut self,
        open: &'static str,
        close: &'static str,
        expected: &'static str,
    ) -> Result<StepId, FormulaError> {
        self.expect(open, if open == "(" { "`(`" } else { "`{`" })?;
        let inside = self.nested(Self::sum)?;
        self.expect(close, expected)?;
        Ok(inside)
    }

    /// One rule inside another, within the depth allowed.
    fn nested(
        &mut self,
        rule: fn(&mut Self) -> Result<StepId, FormulaError>,
    ) -> Result<StepId, FormulaError> {
        if self.depth == DEPTH_LIMIT {
            // The bracket, sign or `if` that goes too deep is the last token taken or the next one.
            let position = self.tokens[self.next.saturating_sub(1)].position;
            return Err(FormulaError::TooDeep { limit: DEPTH_LIMIT, position });
        }
        self.depth += 1;
        let result = rule(self);
        self.depth -= 1;
        result
    }

    fn push(&mut self, step: Step) -> StepId {
        self.steps.push(step);
        self.steps.len() - 1
    }

    fn peek(&self) -> Token<'t> {
        self.tokens[self.next]
    }

    /// Takes the next token; the end is never passed.
    fn advance(&mut self) -> Token<'t> {
        let token = self.peek();
        if token.kind != Kind::End {
            self.next += 1;
        }
        token
    }

    fn take_symbol(&mut self, symbol: &str) -> bool {
        let found = self.peek().is_symbol(symbol);
        if found {
            self.advance();
        }
        found
    }

    fn expect(&mut self, symbol: &str, expected: &'static str) -> Result<(), FormulaError> {
        if self.take_symbol(symbol) { Ok(()) } else { Err(self.unexpected(expected)) }
    }

    fn unexpected(&self, expected: &'static str) -> FormulaError {
        let token = self.peek();
        match token.kind {
            Kind::End => FormulaError::UnexpectedEnd { expected, position: token.position },
            _ => {
                FormulaError::Unexpected { found: token.text.to_owned(), expected, position: token.position }
            }
        }
    }
}
