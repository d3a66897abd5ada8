//! An estimate of what expressions cost to evaluate.

use rustc_hash::FxHashSet;

use super::{ExprId, Graph, Op};

impl Graph {
    /// Whether a symbol is among what an expression is made of, and changes with; definitions are not entered.
    pub(crate) fn contains(&self, expr: ExprId, symbol: ExprId) -> bool {
        let (mut seen, mut open) = (FxHashSet::default(), vec![expr]);
        while let Some(x) = open.pop() {
            if x == symbol {
                return true;
            }
            if seen.insert(x) && !matches!(self.op(x), Op::Symbol(_)) {
                open.extend(self.varying_dependencies(x));
            }
        }
        false
    }

    /// About how many operations the expressions take together. A product that all its users add to something is free there.
    pub(crate) fn operations(&self, exprs: &[ExprId]) -> usize {
        let (mut reachable, mut is_reached) = (Vec::new(), vec![false; self.len()]);
        let mut open = exprs.to_vec();
        while let Some(x) = open.pop() {
            if !std::mem::replace(&mut is_reached[x.index()], true) {
                reachable.push(x);
                open.extend(self.dependencies(x));
            }
        }
        // Uses of a product, and how many of them are additions that take no other product in.
        let (mut uses, mut fused) = (vec![0_u32; self.len()], vec![0_u32; self.len()]);
        for &x in reachable.iter().filter(|&&x| !matches!(self.op(x), Op::Neg(_))) {
            let operands: Vec<ExprId> =
                self.dependencies(x).into_iter().map(|y| self.without_sign(y)).collect();
            operands.iter().for_each(|&y| uses[y.index()] += 1);
            if let (Op::Add(..), Some(&product)) =
                (self.op(x), operands.iter().filter(|&&y| matches!(self.op(y), Op::Mul(..))).max())
            {
                fused[product.index()] += 1;
            }
        }
        let cost = |x: ExprId| match self.op(x) {
            Op::Constant(_) | Op::Symbol(_) | Op::Neg(_) => 0,
            Op::Mul(..) => usize::from(uses[x.index()] != fused[x.index()] || exprs.contains(&x)),
            Op::Power(_, exponent) => exponent.unsigned_abs().ilog2() as usize + usize::from(exponent < 0),
            _ => 1,
        };
        reachable.into_iter().map(cost).sum()
    }
}

#[cfg(test)]
mod tests {
    use crate::expr::Sheet;
    use crate::graph::Scope;

    #[test]
    fn a_product_that_is_added_only_is_free() {
        let sheet = Sheet::new();
        let [x, y, z] = ["x", "y", "z"].map(|name| sheet.input(name, Scope::Element));
        let count = |exprs: &[crate::expr::Expr<'_>]| {
            sheet.graph().operations(&exprs.iter().map(|x| x.id()).collect::<Vec<_>>())
        };
        assert_eq!(count(&[x * y + z]), 1);
        assert_eq!(count(&[x * y + z, x * y]), 2);
        assert_eq!(count(&[(x * y).bind("p").sqrt() - z]), 3);
        let root = (x + y).sqrt();
        assert!(root.contains(x) && !root.contains(z));
    }
}
