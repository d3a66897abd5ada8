//! Detection of vectors that are a common scalar times a simpler vector.

use crate::graph::{ExprId, Graph, Op};

/// `vector[k] = scale · direction[k]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ScaledVector {
    pub scale: ExprId,
    pub direction: Vec<ExprId>,
}

impl Graph {
    /// Takes the largest common factor out of a vector. The scale is 1 where there is none.
    pub(super) fn common_factor(&mut self, vector: &[ExprId]) -> ScaledVector {
        let split: Vec<(f64, Vec<ExprId>)> = vector.iter().map(|&x| self.factored(x)).collect();
        let mut nonzero = split.iter().filter(|(c, _)| *c != 0.0);
        let Some((first_coefficient, first)) = nonzero.next() else {
            return ScaledVector { scale: self.one(), direction: vector.to_vec() };
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
        let direction = split
            .iter()
            .map(|(c, factors)| {
                if *c == 0.0 {
                    return self.zero();
                }
                let number = self.constant(c / coefficient);
                difference(factors, &common).into_iter().fold(number, |product, x| self.mul(product, x))
            })
            .collect();
        let number = self.constant(coefficient);
        let scale = common.into_iter().fold(number, |product, x| self.mul(product, x));
        ScaledVector { scale, direction }
    }

    /// A number and the factors of an expression; of a sum, what all its terms have in common and the rest:
    /// x y + x z → x, (y + z).
    fn factored(&mut self, x: ExprId) -> (f64, Vec<ExprId>) {
        let mut terms = Vec::new();
        self.collect_terms(x, 1.0, &mut terms);
        let common = terms
            .iter()
            .map(|(_, factors)| factors.clone())
            .reduce(|common, factors| intersection(&common, &factors))
            .unwrap_or_default();
        if terms.len() < 2 || common.is_empty() {
            return self.coefficient_and_factors(x);
        }
        let mut rest = self.zero();
        for (coefficient, factors) in &terms {
            let number = self.constant(*coefficient);
            let term =
                difference(factors, &common).into_iter().fold(number, |product, x| self.mul(product, x));
            rest = self.add(rest, term);
        }
        let (coefficient, others) = self.coefficient_and_factors(rest);
        let mut factors = common;
        factors.extend(others);
        factors.sort_unstable();
        (coefficient, factors)
    }

    fn collect_terms(&self, x: ExprId, sign: f64, terms: &mut Vec<(f64, Vec<ExprId>)>) {
        match self.op(x) {
            Op::Add(left, right) if self.name_of(x).is_none() => {
                self.collect_terms(left, sign, terms);
                self.collect_terms(right, sign, terms);
            }
            Op::Neg(inner) => self.collect_terms(inner, -sign, terms),
            _ => {
                let (coefficient, factors) = self.coefficient_and_factors(x);
                terms.push((sign * coefficient, factors));
            }
        }
    }
}

/// Intersection of two sorted multisets.
fn intersection(x: &[ExprId], y: &[ExprId]) -> Vec<ExprId> {
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
fn difference(x: &[ExprId], y: &[ExprId]) -> Vec<ExprId> {
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

    #[test]
    fn the_common_factor_of_weighted_monomials_is_found() {
        let mut g = Graph::new();
        let [w, a, b] = ["w", "a", "b"].map(|name| g.input(name, Scope::Node));
        let (wa, wb) = (g.mul(w, a), g.mul(w, b));
        let wab = g.mul(wa, b);
        let minus: Vec<ExprId> = [w, wa, wb, wab].iter().map(|&x| g.neg(x)).collect();
        let one = g.one();
        let ab = g.mul(a, b);
        let scaled = g.common_factor(&minus);
        assert_eq!(scaled.scale, g.neg(w));
        assert_eq!(scaled.direction, [one, a, b, ab]);
    }

    #[test]
    fn the_common_factor_of_sums_is_found() {
        let mut g = Graph::new();
        let [w, s, t, a] = ["w", "s", "t", "a"].map(|name| g.input(name, Scope::Node));
        let ws = g.mul(w, s);
        let sum = g.sub(t, ws);
        let (left, right) = (g.mul(t, a), g.mul(ws, a));
        let times_a = g.sub(left, right);
        let scaled = g.common_factor(&[sum, times_a]);
        assert_eq!(scaled.scale, sum);
        assert_eq!(scaled.direction, [g.one(), a]);
    }

    #[test]
    fn a_vector_without_common_factor_is_kept() {
        let mut g = Graph::new();
        let [a, b] = ["a", "b"].map(|name| g.input(name, Scope::Node));
        let scaled = g.common_factor(&[a, b]);
        assert!(g.is_one(scaled.scale));
        assert_eq!(scaled.direction, [a, b]);
    }
}
