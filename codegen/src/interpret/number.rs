//! What the interpreter computes with.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::graph::Function;

/// Numbers that expressions of a graph are evaluated in.
///
/// Operators take numbers by value, for an `f64` is one; what is larger is cloned by those who need it twice.
pub trait Number:
    Clone + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// Derivatives that it carries: of none, the first or the second order.
    const ORDER: usize;

    /// A number that is the same whatever the variables are.
    fn constant(x: f64) -> Self;

    /// Its value.
    fn value(&self) -> f64;

    /// √x
    fn sqrt(&self) -> Self;

    /// eˣ
    fn exp(&self) -> Self;

    /// A function of one number.
    fn function(&self, function: Function) -> Self;

    /// Angle of the point (x, `self`).
    fn atan2(&self, x: &Self) -> Self;

    /// xʸ for x > 0
    fn powf(&self, exponent: &Self) -> Self;

    /// √(x² + y²)
    fn hypot(&self, other: &Self) -> Self;

    /// √(x² + y² + z² + …), where nested [`hypot`](Self::hypot)s would lack derivatives.
    fn norm(_count: usize, _component: impl FnMut(usize) -> Self) -> Option<Self>
    where
        Self: Sized,
    {
        None
    }

    /// xᵏ for an integer k
    fn powi(&self, exponent: i32) -> Self;

    /// c₀ + c₁ x + c₂ x² + …
    fn polynomial(&self, coefficients: &[f64]) -> Self;
}

impl Number for f64 {
    const ORDER: usize = 0;

    fn constant(x: f64) -> Self {
        x
    }

    fn value(&self) -> f64 {
        *self
    }

    fn sqrt(&self) -> Self {
        Self::sqrt(*self)
    }

    fn exp(&self) -> Self {
        Self::exp(*self)
    }

    fn function(&self, function: Function) -> Self {
        function.evaluate(*self)
    }

    fn atan2(&self, x: &Self) -> Self {
        Self::atan2(*self, *x)
    }

    fn powf(&self, exponent: &Self) -> Self {
        Self::powf(*self, *exponent)
    }

    fn hypot(&self, other: &Self) -> Self {
        Self::hypot(*self, *other)
    }

    fn powi(&self, exponent: i32) -> Self {
        Self::powi(*self, exponent)
    }

    fn polynomial(&self, coefficients: &[f64]) -> Self {
        expanded_nearby(coefficients, *self)
    }
}

/// A polynomial by its expansion about 0 or, from x = 1/2 on, about 1, where the leading coefficients of a weight
/// vanish.
fn expanded_nearby(coefficients: &[f64], x: f64) -> f64 {
    let horner = |c: &[f64], x: f64| c.iter().rev().fold(0.0, |value, c| value * x + c);
    if x < 0.5 {
        return horner(coefficients, x);
    }
    // Coefficients about 1 by repeated synthetic division; what is rounding of zero is zero.
    let size: f64 = coefficients.iter().enumerate().map(|(k, c)| c.abs() * 2f64.powi(k as i32)).sum();
    let mut shifted = coefficients.to_vec();
    for start in 0..shifted.len() {
        for k in (start..shifted.len().saturating_sub(1)).rev() {
            shifted[k] += shifted[k + 1];
        }
        if shifted[start].abs() <= 4.0 * f64::EPSILON * size {
            shifted[start] = 0.0;
        }
    }
    horner(&shifted, x - 1.0)
}
