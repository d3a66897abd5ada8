//! Automatic differentiation: numbers with their first and second derivatives.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::Number;
use crate::graph::Function;

/// A number's expansion to second order in some variables: its value, its gradient, and its Hessian as the packed lower triangle.
///
/// Derivatives that are zero throughout take no room, which most have: parameters have no derivatives, linear functions no second ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Expansion {
    value: f64,
    gradient: Vec<f64>,
    hessian: Vec<f64>,
}

impl Expansion {
    /// Variable number `index` of `count`.
    ///
    /// # Panics
    /// If there are not as many.
    pub fn variable(value: f64, index: usize, count: usize) -> Self {
        let mut gradient = vec![0.0; count];
        gradient[index] = 1.0;
        Self { value, gradient, hessian: Vec::new() }
    }

    /// First derivatives by `count` variables.
    pub fn gradient(&self, count: usize) -> Vec<f64> {
        if self.gradient.is_empty() { vec![0.0; count] } else { self.gradient.clone() }
    }

    /// Second derivatives by `count` variables, as the packed lower triangle.
    pub fn hessian(&self, count: usize) -> Vec<f64> {
        if self.hessian.is_empty() { vec![0.0; count * (count + 1) / 2] } else { self.hessian.clone() }
    }

    /// A function of these arguments with this value, its first derivatives, and its second ones where they are not zero, each pair once.
    fn function_of<const N: usize>(
        value: f64,
        arguments: [&Self; N],
        first: [f64; N],
        second: &[(usize, usize, f64)],
    ) -> Self {
        let mut all = Self { value, gradient: Vec::new(), hessian: Vec::new() };
        for (x, slope) in arguments.into_iter().zip(first) {
            add_scaled(&mut all.gradient, &x.gradient, slope);
            add_scaled(&mut all.hessian, &x.hessian, slope);
        }
        for &(i, j, curvature) in second {
            let (a, b) = (&arguments[i].gradient, &arguments[j].gradient);
            if a.is_empty() || b.is_empty() || curvature == 0.0 {
                continue;
            }
            all.hessian.resize(a.len() * (a.len() + 1) / 2, 0.0);
            let mut rest = &mut all.hessian[..];
            for row in 0..a.len() {
                let (entries, others) = rest.split_at_mut(row + 1);
                rest = others;
                // Of two arguments both products: the pair stands for two equal derivatives.
                let of_a = curvature * a[row];
                let of_b = if i == j { 0.0 } else { curvature * b[row] };
                if of_a == 0.0 && of_b == 0.0 {
                    continue;
                }
                for (entry, (a, b)) in entries.iter_mut().zip(a.iter().zip(b)) {
                    *entry += of_a * b + of_b * a;
                }
            }
        }
        all
    }

    fn function_of_one(&self, [value, first, second]: [f64; 3]) -> Self {
        Self::function_of(value, [self], [first], &[(0, 0, second)])
    }
}

/// sum += factor · x, where nothing is zero.
fn add_scaled(sum: &mut Vec<f64>, x: &[f64], factor: f64) {
    if x.is_empty() || factor == 0.0 {
        return;
    }
    sum.resize(x.len(), 0.0);
    sum.iter_mut().zip(x).for_each(|(sum, x)| *sum += factor * x);
}

/// Coefficients of a polynomial's derivative.
fn derivative(coefficients: &[f64]) -> Vec<f64> {
    coefficients.iter().enumerate().skip(1).map(|(k, c)| k as f64 * c).collect()
}

impl Add for Expansion {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::function_of(self.value + other.value, [&self, &other], [1.0, 1.0], &[])
    }
}

impl Sub for Expansion {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self::function_of(self.value - other.value, [&self, &other], [1.0, -1.0], &[])
    }
}

impl Neg for Expansion {
    type Output = Self;

    fn neg(self) -> Self {
        self.function_of_one([-self.value, -1.0, 0.0])
    }
}

impl Mul for Expansion {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let (x, y) = (self.value, other.value);
        Self::function_of(x * y, [&self, &other], [y, x], &[(0, 1, 1.0)])
    }
}

impl Div for Expansion {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let (x, y) = (self.value, other.value);
        let second = [(0, 1, -1.0 / (y * y)), (1, 1, 2.0 * x / (y * y * y))];
        Self::function_of(x / y, [&self, &other], [1.0 / y, -x / (y * y)], &second)
    }
}

impl Number for Expansion {
    const ORDER: usize = 2;

    fn constant(value: f64) -> Self {
        Self { value, gradient: Vec::new(), hessian: Vec::new() }
    }

    fn value(&self) -> f64 {
        self.value
    }

    fn sqrt(&self) -> Self {
        let root = self.value.sqrt();
        self.function_of_one([root, 0.5 / root, -0.25 / (root * self.value)])
    }

    fn exp(&self) -> Self {
        self.function_of_one([self.value.exp(); 3])
    }

    fn function(&self, function: Function) -> Self {
        let x = self.value;
        let f = function.evaluate(x);
        self.function_of_one(match function {
            Function::Ln => [f, 1.0 / x, -1.0 / (x * x)],
            Function::Sin => [f, x.cos(), -f],
            Function::Cos => [f, -x.sin(), -f],
            Function::Cbrt => [f, f / (3.0 * x), -2.0 * f / (9.0 * x * x)],
        })
    }

    fn atan2(&self, x: &Self) -> Self {
        let (a, b) = (self.value, x.value);
        let square = a * a + b * b;
        let (mixed, own) = ((a * a - b * b) / (square * square), 2.0 * a * b / (square * square));
        let second = [(0, 0, -own), (0, 1, mixed), (1, 1, own)];
        Self::function_of(a.atan2(b), [self, x], [b / square, -a / square], &second)
    }

    fn powf(&self, exponent: &Self) -> Self {
        let (x, y) = (self.value, exponent.value);
        let (f, log) = (x.powf(y), x.ln());
        let second = [
            (0, 0, y * (y - 1.0) * x.powf(y - 2.0)),
            (0, 1, x.powf(y - 1.0) * (1.0 + y * log)),
            (1, 1, f * log * log),
        ];
        Self::function_of(f, [self, exponent], [y * x.powf(y - 1.0), f * log], &second)
    }

    fn norm(count: usize, mut component: impl FnMut(usize) -> Self) -> Option<Self> {
        let squares = (0..count).filter(|_| count > 2).map(|k| component(k).powi(2));
        Some(squares.reduce(|sum, square| sum + square)?.sqrt())
    }

    fn hypot(&self, other: &Self) -> Self {
        let (x, y) = (self.value, other.value);
        let r = x.hypot(y);
        let cube = r * r * r;
        let second = [(0, 0, y * y / cube), (0, 1, -x * y / cube), (1, 1, x * x / cube)];
        Self::function_of(r, [self, other], [x / r, y / r], &second)
    }

    fn powi(&self, exponent: i32) -> Self {
        let (x, k) = (self.value, f64::from(exponent));
        let power = |factor: f64, by: i32| if factor == 0.0 { 0.0 } else { factor * x.powi(exponent - by) };
        self.function_of_one([x.powi(exponent), power(k, 1), power(k * (k - 1.0), 2)])
    }

    fn polynomial(&self, coefficients: &[f64]) -> Self {
        let slope = derivative(coefficients);
        let curvature = derivative(&slope);
        self.function_of_one([coefficients, &slope, &curvature].map(|c| self.value.polynomial(c)))
    }
}

#[cfg(test)]
mod tests {
    use num_dual::{DualNum, HyperDual};

    use super::*;

    /// f(x, y) and its derivatives by x, y, xx, yx, yy.
    fn expanded(f: impl Fn(Expansion, Expansion) -> Expansion) -> Vec<f64> {
        let found = f(Expansion::variable(0.7, 0, 2), Expansion::variable(1.3, 1, 2));
        [vec![found.value()], found.gradient(2), found.hessian(2)].concat()
    }

    fn by_hyper_dual(f: impl Fn(HyperDual<f64>, HyperDual<f64>) -> HyperDual<f64>) -> Vec<f64> {
        let is = |a: usize, b: usize| f64::from(u8::from(a == b));
        let at = |i: usize, j: usize| {
            let [x, y] = [(0.7, 0), (1.3, 1)].map(|(x, k)| HyperDual::new(x, is(k, i), is(k, j), 0.0));
            f(x, y)
        };
        let second = [(0, 0), (1, 0), (1, 1)].map(|(i, j)| at(i, j).eps1eps2);
        [vec![at(0, 0).re, at(0, 0).eps1, at(1, 1).eps1], second.to_vec()].concat()
    }

    #[test]
    fn every_operation_has_the_derivatives_of_hyper_dual_numbers() {
        type Of =
            (fn(Expansion, Expansion) -> Expansion, fn(HyperDual<f64>, HyperDual<f64>) -> HyperDual<f64>);
        let number = Expansion::constant;
        assert_eq!(number(2.0).gradient(2), [0.0; 2]);
        let all: [Of; 14] = [
            (|x, y| x.clone() * y.clone() - x / y, |x, y| x * y - x / y),
            (|x, y| (x.clone() * x + -(-y)).sqrt(), |x, y| (x * x + y).sqrt()),
            (|x, y| (x.clone() * y + x.clone() * x).sqrt(), |x, y| (x * y + x * x).sqrt()),
            (|x, y| (x * y).exp(), |x, y| (x * y).exp()),
            (|x, y| (x * y).function(Function::Ln), |x, y| (x * y).ln()),
            (|x, y| (x * y).function(Function::Sin), |x, y| (x * y).sin()),
            (|x, y| (x * y).function(Function::Cos), |x, y| (x * y).cos()),
            (|x, y| (-(x * y)).function(Function::Cbrt), |x, y| (-(x * y)).cbrt()),
            (|x, y| (x.clone() * y.clone()).atan2(&(x - y)), |x, y| (x * y).atan2(x - y)),
            (|x, y| (x.clone() * y.clone()).powf(&(x - y)), |x, y| ((x * y).ln() * (x - y)).exp()),
            (
                |x, y| (x.clone() * y.clone()).hypot(&(x - y)),
                |x, y| (x * y * x * y + (x - y) * (x - y)).sqrt(),
            ),
            (|x, y| (x * y).powi(-3), |x, y| (x * y).powi(-3)),
            (
                |x, y| (x.clone() * y.clone()).powi(2) + x.powi(1) + y.powi(0),
                |x, y| (x * y).powi(2) + x + 1.0,
            ),
            (
                |x, y| (x * y).polynomial(&[1.0, 0.0, -3.0, 2.0]),
                |x, y| (x * y).powi(3) * 2.0 - (x * y).powi(2) * 3.0 + 1.0,
            ),
        ];
        for (k, (of, expected)) in all.into_iter().enumerate() {
            let (found, expected) = (expanded(of), by_hyper_dual(expected));
            for (found, expected) in found.iter().zip(&expected) {
                assert!(
                    (found - expected).abs() <= 1e-13 * (1.0 + expected.abs()),
                    "{k}: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn linear_functions_have_no_second_derivatives_to_carry() {
        let [x, y] = [0, 1].map(|k| Expansion::variable(0.5, k, 2));
        let linear = Expansion::constant(3.0) * x - y / Expansion::constant(2.0);
        assert_eq!((linear.gradient(2), linear.hessian.len()), (vec![3.0, -0.5], 0));
    }
}
