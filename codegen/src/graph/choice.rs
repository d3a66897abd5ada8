//! Choices between two expressions, and the rules that simplify them, admitted as those of [`simplify`](super::simplify).

use super::{ExprId, Graph, Op};

impl Graph {
    /// if x < y { then } else { otherwise }
    pub fn select_less(&mut self, x: ExprId, y: ExprId, then: ExprId, otherwise: ExprId) -> ExprId {
        if then == otherwise {
            return then; // both branches agree
        }
        self.pull_out_of_choice(x, y, then, otherwise)
            .or_else(|| self.pull_out_of_both(x, y, then, otherwise))
            .or_else(|| self.split_choice(x, y, then, otherwise))
            .unwrap_or_else(|| self.intern(Op::Select { x, y, then, otherwise }))
    }

    /// if x < y { s u } else { 0 } → s (if x < y { u } else { 0 }), and the other way round, for symbols s whose
    /// values are finite: those of other factors and symbols perhaps are so only where they are chosen.
    fn pull_out_of_choice(
        &mut self,
        x: ExprId,
        y: ExprId,
        then: ExprId,
        otherwise: ExprId,
    ) -> Option<ExprId> {
        let zero = self.zero();
        let chosen = match (self.is_zero(then), self.is_zero(otherwise)) {
            (false, true) => then,
            (true, false) => otherwise,
            _ => return None,
        };
        let (coefficient, factors) = self.coefficient_and_factors(chosen);
        let (symbols, others): (Vec<ExprId>, Vec<ExprId>) =
            factors.into_iter().partition(|&factor| self.is_finite_symbol(factor));
        if symbols.is_empty() {
            return None;
        }
        let number = self.constant(coefficient);
        let rest = others.into_iter().fold(number, |product, factor| self.mul(product, factor));
        let choice = if chosen == then {
            self.select_less(x, y, rest, zero)
        } else {
            self.select_less(x, y, zero, rest)
        };
        Some(symbols.into_iter().fold(choice, |product, symbol| self.mul(product, symbol)))
    }

    /// if x < y { f u } else { f v } → f (if x < y { u } else { v })
    fn pull_out_of_both(&mut self, x: ExprId, y: ExprId, then: ExprId, otherwise: ExprId) -> Option<ExprId> {
        let ((c, mut factors), (d, others)) =
            (self.coefficient_and_factors(then), self.coefficient_and_factors(otherwise));
        let (mut common, mut rest) = (Vec::new(), Vec::new());
        for factor in others {
            match factors.iter().position(|&other| other == factor) {
                Some(position) => common.push(factors.remove(position)),
                None => rest.push(factor),
            }
        }
        if common.is_empty() {
            return None;
        }
        let mut product = |coefficient: f64, factors: Vec<ExprId>| {
            let number = self.constant(coefficient);
            factors.into_iter().fold(number, |product, factor| self.mul(product, factor))
        };
        let (then, otherwise) = (product(c, factors), product(d, rest));
        let choice = self.select_less(x, y, then, otherwise);
        Some(common.into_iter().fold(choice, |product, factor| self.mul(product, factor)))
    }

    /// if x < y { f u + p } else { f v + q } → f (if x < y { u } else { v }) + if x < y { p } else { q }
    fn split_choice(&mut self, x: ExprId, y: ExprId, then: ExprId, otherwise: ExprId) -> Option<ExprId> {
        let summands = |x: ExprId| match self.op(x) {
            Op::Add(left, right) if self.name_of(x).is_none() => Some((left, right)),
            _ => None,
        };
        let ((p, q), (u, v)) = (summands(then)?, summands(otherwise)?);
        let share = |x: ExprId, y: ExprId| {
            let others = self.coefficient_and_factors(y).1;
            self.coefficient_and_factors(x).1.iter().any(|factor| others.contains(factor))
        };
        let (u, v) = if share(p, u) || share(q, v) {
            (u, v)
        } else if share(p, v) || share(q, u) {
            (v, u)
        } else {
            return None;
        };
        let (left, right) = (self.select_less(x, y, p, u), self.select_less(x, y, q, v));
        Some(self.add(left, right))
    }
}

#[cfg(test)]
mod tests {
    use super::super::three_inputs as graph;
    use super::*;

    #[test]
    fn a_symbol_is_pulled_out_of_a_choice() {
        let (mut g, x, y, z) = graph();
        let (zero, power) = (g.zero(), g.power(z, -1));
        let product = g.mul(x, power);
        let choice = g.select_less(y, z, product, zero);
        let inner = g.select_less(y, z, power, zero);
        assert_eq!(choice, g.mul(x, inner));
        let choice = g.select_less(y, z, zero, product);
        let inner = g.select_less(y, z, zero, power);
        assert_eq!(choice, g.mul(x, inner));
        // What may be infinite stays where it is chosen.
        assert!(matches!(g.op(inner), Op::Select { .. }));
    }

    #[test]
    fn what_both_branches_have_is_pulled_out_of_a_choice() {
        let (mut g, x, y, z) = graph();
        let [two, three] = [2.0, 3.0].map(|number| g.constant(number));
        let power = g.power(z, -1);
        let (then, otherwise) = (g.mul(two, power), g.mul(three, power));
        let choice = g.select_less(x, y, then, otherwise);
        let number = g.select_less(x, y, two, three);
        assert_eq!(choice, g.mul(number, power));
    }

    #[test]
    fn a_choice_of_sums_is_a_sum_of_choices_with_common_factors() {
        let (mut g, x, y, z) = graph();
        let [two, three] = [2.0, 3.0].map(|number| g.constant(number));
        let (left, right) = (g.mul(two, z), g.mul(three, z));
        let (then, otherwise) = (g.add(left, x), g.add(y, right));
        let choice = g.select_less(x, y, then, otherwise);
        let (number, rest) = (g.select_less(x, y, two, three), g.select_less(x, y, x, y));
        let product = g.mul(number, z);
        assert_eq!(choice, g.add(product, rest));
        // Without a common factor it stays whole.
        let (square, root) = (g.mul(y, y), g.sqrt(z));
        let (then, otherwise) = (g.add(x, square), g.add(z, root));
        let choice = g.select_less(x, y, then, otherwise);
        assert!(matches!(g.op(choice), Op::Select { .. }));
    }

    #[test]
    fn equal_branches_need_no_choice() {
        let (mut g, x, y, z) = graph();
        assert_eq!(g.select_less(x, y, z, z), z);
    }
}
