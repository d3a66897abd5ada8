//! Detection of vectors that are a common scalar times a simpler vector.

use crate::expr::{Expr, Sheet};
use crate::graph::Op;

/// `vector[k] = scale · direction[k]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ScaledVector<'g> {
    pub scale: Expr<'g>,
    pub direction: Vec<Expr<'g>>,
}

/// Takes the largest common factor out of a vector. The scale is 1 where there is none.
pub(super) fn common_factor<'g>(vector: &[Expr<'g>]) -> ScaledVector<'g> {
    let sheet = vector[0].sheet();
    let split: Vec<(f64, Vec<Expr<'g>>)> = vector.iter().map(|&x| factored(x)).collect();
    let mut nonzero = split.iter().filter(|(c, _)| *c != 0.0);
    let Some((first_coefficient, first)) = nonzero.next() else {
        return ScaledVector { scale: sheet.one(), direction: vector.to_vec() };
    };
    let mut common = first.clone();
    // A sign or number is common only if all components have it.
    let mut coefficient = *first_coefficient;
    for (c, factors) in nonzero {
        common = intersection(&common, factors);
        if *c != coefficient {
            coefficient = 1.0;
        }
    }
    let direction = split.iter().map(|(c, factors)| match *c {
        0.0 => sheet.zero(),
        c => product(sheet, c / coefficient, difference(factors, &common)),
    });
    let direction = direction.collect();
    ScaledVector { scale: product(sheet, coefficient, common), direction }
}

/// A number and the factors of an expression; of a sum, what all its terms have in common and the rest:
/// x y + x z → x, (y + z).
fn factored(x: Expr<'_>) -> (f64, Vec<Expr<'_>>) {
    let mut terms = Vec::new();
    collect_terms(x, 1.0, &mut terms);
    let factors = terms.iter().map(|(_, factors)| factors.clone());
    let common = factors.reduce(|common, factors| intersection(&common, &factors)).unwrap_or_default();
    if terms.len() < 2 || common.is_empty() {
        return x.factors();
    }
    let sheet = x.sheet();
    let rest = terms.iter().fold(sheet.zero(), |rest, (coefficient, factors)| {
        rest + product(sheet, *coefficient, difference(factors, &common))
    });
    let (coefficient, others) = rest.factors();
    let mut factors = [common, others].concat();
    factors.sort_unstable_by_key(|x| x.id());
    (coefficient, factors)
}

fn collect_terms<'g>(x: Expr<'g>, sign: f64, terms: &mut Vec<(f64, Vec<Expr<'g>>)>) {
    match x.operation() {
        Op::Add(left, right) if !x.has_name() => {
            for term in [left, right] {
                collect_terms(x.sheet().expr(term), sign, terms);
            }
        }
        Op::Neg(inner) => collect_terms(x.sheet().expr(inner), -sign, terms),
        _ => {
            let (coefficient, factors) = x.factors();
            terms.push((sign * coefficient, factors));
        }
    }
}

fn product<'g>(sheet: &'g Sheet, number: f64, factors: Vec<Expr<'g>>) -> Expr<'g> {
    factors.into_iter().fold(sheet.number(number), |product, x| product * x)
}

/// Intersection of two sorted multisets.
fn intersection<'g>(x: &[Expr<'g>], y: &[Expr<'g>]) -> Vec<Expr<'g>> {
    let mut rest = y.to_vec();
    x.iter()
        .filter(|factor| match rest.iter().position(|other| other == *factor) {
            Some(position) => {
                rest.remove(position);
                true
            }
            None => false,
        })
        .copied()
        .collect()
}

/// Multiset difference x − y of sorted multisets, y ⊆ x.
fn difference<'g>(x: &[Expr<'g>], y: &[Expr<'g>]) -> Vec<Expr<'g>> {
    let mut rest = x.to_vec();
    for factor in y {
        if let Some(position) = rest.iter().position(|other| other == factor) {
            rest.remove(position);
        }
    }
    rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Scope;

    fn node_values<'g, const N: usize>(sheet: &'g Sheet, names: [&str; N]) -> [Expr<'g>; N] {
        names.map(|name| sheet.input(name, Scope::Node))
    }

    #[test]
    fn the_common_factor_of_weighted_monomials_is_found() {
        let sheet = Sheet::new();
        let [w, a, b] = node_values(&sheet, ["w", "a", "b"]);
        let scaled = common_factor(&[w, w * a, w * b, w * a * b].map(|x| -x));
        assert_eq!(scaled.scale, -w);
        assert_eq!(scaled.direction, [sheet.one(), a, b, a * b]);
    }

    #[test]
    fn the_common_factor_of_sums_is_found() {
        let sheet = Sheet::new();
        let [w, s, t, a] = node_values(&sheet, ["w", "s", "t", "a"]);
        let sum = t - w * s;
        let scaled = common_factor(&[sum, t * a - w * s * a]);
        assert_eq!(scaled.scale, sum);
        assert_eq!(scaled.direction, [sheet.one(), a]);
    }

    #[test]
    fn a_vector_without_common_factor_is_kept() {
        let sheet = Sheet::new();
        let [a, b] = node_values(&sheet, ["a", "b"]);
        let scaled = common_factor(&[a, b]);
        assert_eq!(scaled.scale, sheet.one());
        assert_eq!(scaled.direction, [a, b]);
    }
}
