//! Polynomials of one variable, with exact calculus on their coefficients.
//!
//! Weights are polynomials of a norm r. As sums of powers they would lose digits near r = 1, where a smooth weight has a
//! zero of high order, and their derivatives by position would divide by r. Kept as polynomials they do neither:
//! derivatives are taken on the coefficients, and zeros at r = 1 are factored out before anything is evaluated.

use super::{ExprId, Graph, Op, PolynomialId};

/// Coefficients of 1, x, x², …; no trailing zeros.
#[derive(Clone, Debug, PartialEq)]
pub struct Polynomial {
    coefficients: Vec<f64>,
}

impl Polynomial {
    /// A polynomial from the coefficients of 1, x, x², ….
    pub fn new(mut coefficients: Vec<f64>) -> Self {
        while coefficients.last() == Some(&0.0) {
            coefficients.pop();
        }
        Self { coefficients }
    }

    /// Coefficients of 1, x, x², ….
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// P'
    pub fn derivative(&self) -> Self {
        Self::new(self.coefficients.iter().enumerate().skip(1).map(|(k, c)| k as f64 * c).collect())
    }

    /// P / x, if P(0) = 0.
    pub fn over_x(&self) -> Option<Self> {
        match self.coefficients.split_first() {
            None => Some(self.clone()),
            Some((&0.0, rest)) => Some(Self::new(rest.to_vec())),
            Some(_) => None,
        }
    }

    /// (m, Q) with P = (1 − x)ᵐ Q and m as large as the coefficients tell: a remainder counts as zero if it is within the
    /// rounding of the coefficients.
    pub fn without_zeros_at_one(&self) -> (u32, Self) {
        let mut order = 0;
        let mut quotient = self.coefficients.clone();
        loop {
            let size: f64 = quotient.iter().map(|c| c.abs()).sum();
            let value: f64 = quotient.iter().sum();
            if quotient.len() < 2 || value.abs() > 16.0 * f64::EPSILON * size {
                return (order, Self::new(quotient));
            }
            // P = (1 − x) Q: q_k = Σ_{j ≤ k} p_j.
            let mut partial = 0.0;
            quotient.pop();
            for c in &mut quotient {
                partial += *c;
                *c = partial;
            }
            order += 1;
        }
    }
}

impl Graph {
    /// P(x)
    pub fn polynomial(&mut self, x: ExprId, polynomial: Polynomial) -> ExprId {
        if let Some(x) = self.constant_value(x) {
            return self.constant(polynomial.coefficients.iter().rev().fold(0.0, |value, c| value * x + c));
        }
        match polynomial.coefficients[..] {
            [] => return self.zero(),
            [c] => return self.constant(c),
            _ => {}
        }
        let known = self.polynomials.iter().position(|p| *p == polynomial);
        let id = known.unwrap_or_else(|| {
            self.polynomials.push(polynomial);
            self.polynomials.len() - 1
        });
        self.intern(Op::Polynomial(x, PolynomialId(u32::try_from(id).expect("fewer than 2³² polynomials"))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_at_one_are_factored_out() {
        // (1 − x)² (1 + 2x)
        let cubic = Polynomial::new(vec![1.0, 0.0, -3.0, 2.0]);
        assert_eq!(cubic.without_zeros_at_one(), (2, Polynomial::new(vec![1.0, 2.0])));
        let slope = cubic.derivative().over_x().unwrap();
        assert_eq!(slope.without_zeros_at_one(), (1, Polynomial::new(vec![-6.0])));
        assert_eq!(slope.over_x(), None);
    }

    #[test]
    fn a_zero_whose_coefficients_are_rounded_is_found() {
        // (1 − x)⁶ (35x² + 18x + 3)/3 of Wendland, C⁴
        let third = 1.0 / 3.0;
        let expanded: Vec<f64> =
            [3.0, 0.0, -28.0, 0.0, 210.0, -448.0, 420.0, -192.0, 35.0].iter().map(|c| c * third).collect();
        let (order, quotient) = Polynomial::new(expanded).without_zeros_at_one();
        assert_eq!(order, 6);
        for (c, expected) in quotient.coefficients().iter().zip([1.0, 6.0, 35.0 / 3.0]) {
            assert!((c - expected).abs() < 1e-12, "{c} {expected}");
        }
    }
}
