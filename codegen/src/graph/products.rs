//! Products taken apart: a number, and factors that are none.

use super::{ExprId, Graph, Op, Scope};

/// Products of more factors are not taken apart: x to a power of two that was multiplied out has more than memory holds.
const MOST_COLLECTED: u8 = 64;

impl Graph {
    /// c · core, where core has no numerical coefficient, or is a number itself.
    pub(super) fn scaled(&mut self, coefficient: f64, core: ExprId) -> ExprId {
        if coefficient == 0.0 {
            self.zero()
        } else if let Some(value) = self.constant_value(core) {
            self.constant(coefficient * value)
        } else if coefficient == 1.0 {
            core
        } else if coefficient == -1.0 {
            self.intern(Op::Neg(core))
        } else {
            let number = self.constant(coefficient);
            // c (x y) → (c x) y for x of element scope and y of a wider one: c x is computed once per element
            if let Op::Mul(x, y) = self.op(core) {
                for (once, often) in [(x, y), (y, x)] {
                    if self.scope(once) == Scope::Element && self.scope(often) != Scope::Element {
                        let once = self.scaled(coefficient, once);
                        return self.intern(Op::Mul(once.min(often), once.max(often)));
                    }
                }
            }
            self.intern(Op::Mul(number.min(core), number.max(core)))
        }
    }

    /// Whether a product is not taken apart by products with it: a quantity of its own, computed once per element, or too many factors.
    fn is_whole(&self, x: ExprId) -> bool {
        let is_quantity = self.scope(x) == Scope::Element && self.name_of(x).is_some();
        matches!(self.op(x), Op::Mul(..)) && (is_quantity || self.lengths[x.index()] == 1)
    }

    /// How many factors an operation has; 1 for a product of too many, which is one factor of others.
    pub(super) fn length_of_op(&self, op: Op) -> u8 {
        match op {
            Op::Neg(inner) => self.lengths[inner.index()],
            Op::Mul(left, right) => match self.lengths[left.index()] + self.lengths[right.index()] {
                length if length > MOST_COLLECTED => 1,
                length => length,
            },
            _ => 1,
        }
    }

    /// Splits x into a number and its sorted other factors.
    pub(crate) fn coefficient_and_factors(&self, x: ExprId) -> (f64, Vec<ExprId>) {
        let mut factors = Vec::new();
        let coefficient = self.collect_factors(x, &mut factors);
        factors.sort_unstable();
        (coefficient, factors)
    }

    /// Adds the factors of x, and returns its coefficient.
    fn collect_factors(&self, x: ExprId, factors: &mut Vec<ExprId>) -> f64 {
        match self.op(x) {
            Op::Constant(bits) => return f64::from_bits(bits),
            Op::Neg(inner) => return -self.collect_factors(inner, factors),
            Op::Mul(left, right) if !self.is_whole(x) => {
                return self.collect_factors(left, factors) * self.collect_factors(right, factors);
            }
            _ => factors.push(x),
        }
        1.0
    }

    pub(super) fn merged_factors(&self, x: ExprId, y: ExprId) -> (f64, Vec<ExprId>) {
        let mut factors = Vec::new();
        let coefficient = self.collect_factors(x, &mut factors) * self.collect_factors(y, &mut factors);
        factors.sort_unstable();
        (coefficient, factors)
    }

    /// x of an expression −x, else the expression.
    pub(crate) fn without_sign(&self, x: ExprId) -> ExprId {
        match self.op(x) {
            Op::Neg(inner) => inner,
            _ => x,
        }
    }

    /// x without its numerical coefficient, if that expression exists already.
    pub(super) fn core(&self, x: ExprId) -> Option<ExprId> {
        match self.op(x) {
            _ if self.is_whole(x) => Some(x),
            Op::Neg(inner) => self.core(inner),
            Op::Mul(left, right) if self.constant_value(left).is_some() => Some(right),
            Op::Mul(left, right) if self.constant_value(right).is_some() => Some(left),
            Op::Mul(..) => {
                let (coefficient, factors) = self.coefficient_and_factors(x);
                if coefficient == 1.0 { Some(x) } else { self.products.get(&factors).copied() }
            }
            Op::Constant(_) => None,
            _ => Some(x),
        }
    }

    /// x without its numerical coefficient; 1 for a number.
    pub(super) fn without_coefficient(&mut self, x: ExprId) -> ExprId {
        if let Some(core) = self.core(x) {
            return core;
        }
        let (_, factors) = self.coefficient_and_factors(x);
        let one = self.one();
        factors.into_iter().fold(one, |product, factor| self.mul(product, factor))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn graph() -> (Graph, ExprId, ExprId, ExprId) {
        let mut g = Graph::new();
        let [x, y, z] = ["x", "y", "z"].map(|name| g.input(name, Scope::Element));
        (g, x, y, z)
    }

    #[test]
    fn products_are_equal_however_they_are_associated() {
        let (mut g, x, y, z) = graph();
        let xy = g.mul(x, y);
        let left = g.mul(xy, z);
        let minus_y = g.neg(y);
        let zy = g.mul(z, minus_y);
        let right = g.mul(zy, x);
        assert_eq!(g.neg(right), left);
    }

    #[test]
    fn a_named_product_of_element_scope_is_kept_whole() {
        let (mut g, x, y, z) = graph();
        let half = g.constant(0.5);
        let half_x = g.mul(half, x);
        g.name(half_x, "k");
        let product = g.mul(half_x, y);
        assert_eq!(g.op(product), Op::Mul(half_x.min(y), half_x.max(y)));
        let plain = g.mul(half, z);
        let product = g.mul(plain, y);
        let zy = g.mul(z, y);
        assert_eq!(product, g.mul(half, zy));
    }

    #[test]
    fn a_number_joins_the_factor_that_is_computed_once_per_element() {
        let (mut g, x, ..) = graph();
        let w = g.input("w", Scope::Node);
        let two = g.constant(2.0);
        let (two_x, xw) = (g.mul(two, x), g.mul(x, w));
        let product = g.mul(two, xw);
        assert_eq!(g.op(product), Op::Mul(two_x.min(w), two_x.max(w)));
        // It is still twice x w.
        let difference = g.sub(product, xw);
        assert_eq!(difference, xw);
        let half = g.constant(0.5);
        assert_eq!(g.mul(half, product), xw);
    }

    #[test]
    fn a_number_is_found_in_a_product_whose_factors_got_names_later() {
        let (mut g, x, y, z) = graph();
        let w = g.input("w", Scope::Node);
        let two = g.constant(2.0);
        let xy = g.mul(x, y);
        let plain = g.mul(xy, w);
        let double = g.mul(two, plain);
        g.name(xy, "q");
        let quotient = g.div(double, z);
        let single = g.div(plain, z);
        assert_eq!(quotient, g.mul(two, single));
    }

    #[test]
    fn a_product_of_many_factors_keeps_its_number() {
        let (mut g, x, _, z) = graph();
        let [two, three] = [2.0, 3.0].map(|number| g.constant(number));
        let long = (0..7).fold(x, |product, _| g.mul(product, product));
        let two_z = g.mul(two, z);
        let plain = g.mul(long, z);
        let double = g.mul(long, two_z);
        assert_eq!(double, g.mul(two, plain));
        let quotient = g.div(double, x);
        let single = g.div(plain, x);
        assert_eq!(quotient, g.mul(two, single));
        let triple = g.mul(three, long);
        let sum = g.add(triple, long);
        assert_eq!(g.coefficient_and_factors(sum), (4.0, vec![long]));
    }
}
