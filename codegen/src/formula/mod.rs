//! Weight formulas in one variable `r`, written as text.
//!
//! `"(1 - r)^2 * (1 + 2*r)"` is the cubic weight (Chamoret et al. 2008, eq. 14). Known are numbers, `r`,
//! `+ - * /`, `^` with an integer exponent (binding tighter than a minus sign in front, as in mathematics),
//! parentheses, `exp(…)`, `sqrt(…)` and `if r < 0.5 { … } else { … }`.

mod parse;
mod series;

pub use parse::FormulaError;

/// Polynomials of a higher degree are not multiplied out.
const LARGEST_DEGREE: usize = 1000;

/// A formula in r.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)] // The names say what the fields are.
pub enum Formula {
    /// A number.
    Number(f64),
    /// The variable r.
    Radius,
    /// −x
    Neg(Box<Formula>),
    /// x + y
    Add(Box<Formula>, Box<Formula>),
    /// x − y
    Sub(Box<Formula>, Box<Formula>),
    /// x y
    Mul(Box<Formula>, Box<Formula>),
    /// x / y
    Div(Box<Formula>, Box<Formula>),
    /// xᵏ
    Power(Box<Formula>, i32),
    /// eˣ
    Exp(Box<Formula>),
    /// √x
    Sqrt(Box<Formula>),
    /// if x < y { then } else { otherwise }
    If { x: Box<Formula>, y: Box<Formula>, then: Box<Formula>, otherwise: Box<Formula> },
}

impl Formula {
    /// Reads a formula.
    ///
    /// # Errors
    /// [`FormulaError`], which points at the character.
    pub fn parse(text: &str) -> Result<Self, FormulaError> {
        parse::parse(text)
    }

    /// Value at r.
    pub fn evaluate(&self, r: f64) -> f64 {
        match self {
            Self::Number(value) => *value,
            Self::Radius => r,
            Self::Neg(x) => -x.evaluate(r),
            Self::Add(x, y) => x.evaluate(r) + y.evaluate(r),
            Self::Sub(x, y) => x.evaluate(r) - y.evaluate(r),
            Self::Mul(x, y) => x.evaluate(r) * y.evaluate(r),
            Self::Div(x, y) => x.evaluate(r) / y.evaluate(r),
            Self::Power(x, k) => x.evaluate(r).powi(*k),
            Self::Exp(x) => x.evaluate(r).exp(),
            Self::Sqrt(x) => x.evaluate(r).sqrt(),
            Self::If { x, y, then, otherwise } => {
                if x.evaluate(r) < y.evaluate(r) {
                    then.evaluate(r)
                } else {
                    otherwise.evaluate(r)
                }
            }
        }
    }

    /// Coefficients of 1, r, r², … if the formula is a polynomial.
    pub fn polynomial(&self) -> Option<Vec<f64>> {
        let product = |p: &[f64], q: &[f64]| {
            let mut result = vec![0.0; p.len() + q.len() - 1];
            for (i, a) in p.iter().enumerate() {
                for (j, b) in q.iter().enumerate() {
                    result[i + j] += a * b;
                }
            }
            result
        };
        let combined = |x: &Self, y: &Self, sign: f64| {
            let (p, q) = (x.polynomial()?, y.polynomial()?);
            let at = |p: &[f64], k: usize| p.get(k).copied().unwrap_or(0.0);
            Some((0..p.len().max(q.len())).map(|k| at(&p, k) + sign * at(&q, k)).collect())
        };
        match self {
            Self::Number(value) => Some(vec![*value]),
            Self::Radius => Some(vec![0.0, 1.0]),
            Self::Neg(x) => Some(x.polynomial()?.into_iter().map(|c| -c).collect()),
            Self::Add(x, y) => combined(x, y, 1.0),
            Self::Sub(x, y) => combined(x, y, -1.0),
            Self::Mul(x, y) => Some(product(&x.polynomial()?, &y.polynomial()?)),
            Self::Div(x, y) => match y.polynomial()?.as_slice() {
                [divisor] => Some(x.polynomial()?.into_iter().map(|c| c / divisor).collect()),
                _ => None,
            },
            Self::Power(x, k @ 0..=32) => {
                let base = x.polynomial()?;
                if (base.len() - 1) * *k as usize > LARGEST_DEGREE {
                    return None;
                }
                Some((0..*k).fold(vec![1.0], |p, _| product(&p, &base)))
            }
            Self::Power(..) | Self::Exp(_) | Self::Sqrt(_) | Self::If { .. } => None,
        }
    }

    /// The first `count` Taylor coefficients at r = 0⁺; not finite where there is no expansion.
    pub fn taylor(&self, count: usize) -> Vec<f64> {
        series::taylor(self, count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cubic_weight_is_a_polynomial() {
        let cubic = Formula::parse("(1 - r)^2 * (1 + 2*r)").unwrap();
        assert_eq!(cubic.polynomial(), Some(vec![1.0, 0.0, -3.0, 2.0]));
        assert_eq!(cubic.evaluate(0.5), 0.5);
    }

    #[test]
    fn a_power_binds_tighter_than_a_minus_sign() {
        assert_eq!(Formula::parse("-r^2").unwrap().evaluate(3.0), -9.0);
        assert_eq!(Formula::parse("2 * r^-1").unwrap().evaluate(4.0), 0.5);
        assert_eq!(Formula::parse("1 - 2 - 3 + 8/2/2").unwrap().evaluate(0.0), -2.0);
    }
}
