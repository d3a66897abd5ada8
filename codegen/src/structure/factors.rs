//! Detection of vectors that are a common scalar times a simpler vector.

use crate::graph::{ExprId, Graph};

/// `vector[k] = scale · direction[k]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ScaledVector {
    pub scale: ExprId,
    pub direction: Vec<ExprId>,
}

impl Graph {
    /// Takes the largest common factor out of a vector. The scale is 1 where there is none.
    pub(super) fn common_factor(&mut self, vector: &[ExprId]) -> ScaledVector {
        let split: Vec<(f64, Vec<ExprId>)> =
            vector.iter().map(|&x| self.coefficient_and_factors(x)).collect();
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
    fn a_vector_without_common_factor_is_kept() {
        let mut g = Graph::new();
        let [a, b] = ["a", "b"].map(|name| g.input(name, Scope::Node));
        let scaled = g.common_factor(&[a, b]);
        assert!(g.is_one(scaled.scale));
        assert_eq!(scaled.direction, [a, b]);
    }
}
