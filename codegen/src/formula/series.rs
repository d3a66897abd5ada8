//! Truncated power series of a formula at r = 0.

use super::Formula;

pub(super) fn taylor(formula: &Formula, count: usize) -> Vec<f64> {
    let of = |x: &Formula| taylor(x, count);
    match formula {
        Formula::Number(value) => monomial(*value, 0, count),
        Formula::Radius => monomial(1.0, 1, count),
        Formula::Neg(x) => of(x).into_iter().map(|c| -c).collect(),
        Formula::Add(x, y) => of(x).iter().zip(of(y)).map(|(a, b)| a + b).collect(),
        Formula::Sub(x, y) => of(x).iter().zip(of(y)).map(|(a, b)| a - b).collect(),
        Formula::Mul(x, y) => product(&of(x), &of(y)),
        Formula::Div(x, y) => quotient(&of(x), &of(y)),
        Formula::Power(x, k) => {
            let base = of(x);
            let power = (0..k.unsigned_abs()).fold(monomial(1.0, 0, count), |p, _| product(&p, &base));
            if *k < 0 { quotient(&monomial(1.0, 0, count), &power) } else { power }
        }
        Formula::Exp(x) => exponential(&of(x)),
        Formula::Sqrt(x) => square_root(&of(x)),
        Formula::If { x, y, then, otherwise } => {
            // Just right of the origin: the first coefficients that differ decide.
            let (x, y) = (of(x), of(y));
            let less = x.iter().zip(&y).find(|(a, b)| a != b).is_some_and(|(a, b)| a < b);
            of(if less { then } else { otherwise })
        }
    }
}

fn monomial(coefficient: f64, degree: usize, count: usize) -> Vec<f64> {
    (0..count).map(|k| if k == degree { coefficient } else { 0.0 }).collect()
}

fn product(p: &[f64], q: &[f64]) -> Vec<f64> {
    (0..p.len()).map(|k| (0..=k).map(|j| p[j] * q[k - j]).sum()).collect()
}

/// q c = p
fn quotient(p: &[f64], q: &[f64]) -> Vec<f64> {
    let mut c: Vec<f64> = Vec::with_capacity(p.len());
    for k in 0..p.len() {
        let known: f64 = (0..k).map(|j| c[j] * q[k - j]).sum();
        c.push((p[k] - known) / q[0]);
    }
    c
}

/// c = eᵖ: k c_k = Σ j p_j c_{k−j}
fn exponential(p: &[f64]) -> Vec<f64> {
    let mut c = vec![p[0].exp()];
    for k in 1..p.len() {
        let total: f64 = (1..=k).map(|j| j as f64 * p[j] * c[k - j]).sum();
        c.push(total / k as f64);
    }
    c
}

/// c² = p
fn square_root(p: &[f64]) -> Vec<f64> {
    let mut c = vec![p[0].sqrt()];
    for k in 1..p.len() {
        let known: f64 = (1..k).map(|j| c[j] * c[k - j]).sum();
        c.push((p[k] - known) / (2.0 * c[0]));
    }
    c
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_agree_with_the_formula_near_the_origin() {
        for text in [
            "exp(-4*r^2) * (1 - r^2)^2",
            "exp(-r) * (1 + r)",
            "1 / (1 + r^2)",
            "sqrt(1 + 3*r^2) - r^2/7",
            "(1 + r^2)^-3",
            "if r > 0.5 { 0 } else { 2/3 - 4*r^2 + 4*r^3 }",
        ] {
            let formula = Formula::parse(text).unwrap();
            let r: f64 = 0.01;
            let sum: f64 = taylor(&formula, 14).iter().rev().fold(0.0, |total, c| total * r + c);
            assert!((sum - formula.evaluate(r)).abs() < 1e-15, "{text}: {sum} {}", formula.evaluate(r));
        }
    }
}
