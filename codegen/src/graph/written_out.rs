//! Formulas in the place of quantities through which the chain rule loses derivatives that the formulas have:
//!
//! * a choice that leaves a quantity out leaves out its derivatives; by the chain rule an infinite one of them is multiplied by 0;
//! * a function may be smooth where a norm is zero, such as its square; of a symbol that is made of the norm it is not.

use std::collections::BTreeSet;

use rustc_hash::FxHashSet;

use super::{ExprId, Function, Graph, Op, SymbolId};

impl Graph {
    /// Expressions with formulas in the place of such quantities, for all of them together. Formulas keep the names. Unknowns of equations
    /// stay symbols, and so does `kept`. `variables`: what second derivatives will be taken by, if any
    /// will, so that norms matter.
    pub(crate) fn written_out(
        &mut self,
        exprs: &[ExprId],
        kept: Option<SymbolId>,
        variables: &[ExprId],
    ) -> Vec<ExprId> {
        if !self.has_quantities() {
            return exprs.to_vec();
        }
        let left_out = self.left_out(exprs);
        let symbol = |g: &Self, x: ExprId| match g.op(x) {
            Op::Symbol(symbol) if g.quantities.contains(&symbol) && kept != Some(symbol) => Some(symbol),
            _ => None,
        };
        // Quantities come after what they are made of.
        let all = self.reachable_from(exprs.to_vec(), Self::dependencies).into_iter();
        let quantities: BTreeSet<ExprId> = all.filter(|&x| symbol(self, x).is_some()).collect();
        let mut replacements = Vec::new();
        for quantity in quantities {
            let symbol = self.symbol_of(quantity);
            let Some(before) = self.symbol_data(symbol).definition else { continue };
            let definition = self.substitute(before, &replacements);
            let is_lost = self.is_made_of_a_norm(definition, variables)
                || self.has_norm(definition)
                || left_out.contains(&quantity) && !self.is_smooth(definition);
            if definition == before && !is_lost {
                continue;
            }
            let name = self.symbol_data(symbol).name.clone();
            match self.op(definition) {
                Op::Sum(_) if definition == before => {}
                Op::Sum(_) => {
                    let other = self.bind_unique(&name, definition);
                    self.add_quantity(other);
                    replacements.push((symbol, other));
                }
                _ if self.is_formula(definition) => {
                    replacements.push((symbol, self.name(definition, &name)));
                }
                _ => {}
            }
        }
        self.substitute_all(exprs, &replacements)
    }

    /// What expressions are made of that stands in choices only, which may leave it out. What stands elsewhere, too, has to have
    /// derivatives anyway.
    pub(crate) fn left_out(&self, exprs: &[ExprId]) -> FxHashSet<ExprId> {
        let openly = self.reachable_from(exprs.to_vec(), |g, x| match g.op(x) {
            Op::Select { .. } => Vec::new(),
            _ => g.dependencies(x),
        });
        let chosen = openly.iter().flat_map(|&x| match self.op(x) {
            Op::Select { then, otherwise, .. } => vec![then, otherwise],
            _ => Vec::new(),
        });
        let within = self.reachable_from(chosen.collect(), Self::dependencies);
        let openly: FxHashSet<ExprId> = openly.into_iter().collect();
        within.into_iter().filter(|x| !openly.contains(x)).collect()
    }

    /// Whether the derivatives are finite wherever the symbols are, but for overflow: without divisions, roots and logarithms. Definitions
    /// are not entered.
    pub(crate) fn is_smooth(&self, expr: ExprId) -> bool {
        self.reachable(expr, Self::operands).into_iter().all(|x| match self.op(x) {
            Op::Power(_, exponent) => exponent > 0,
            Op::Function(function, _) => matches!(function, Function::Sin | Function::Cos),
            Op::Div(..) | Op::Sqrt(_) | Op::RealPower(..) | Op::Atan2(..) => false,
            _ => true,
        })
    }

    fn is_made_of_a_norm(&self, expr: ExprId, variables: &[ExprId]) -> bool {
        let norms =
            self.reachable(expr, Self::operands).into_iter().filter(|&x| matches!(self.op(x), Op::Hypot(..)));
        norms.into_iter().any(|norm| self.changes_with(norm, variables))
    }

    /// Whether it is made of operations alone, and of no unknowns of equations.
    fn is_formula(&self, expr: ExprId) -> bool {
        !self.reachable(expr, Self::operands).into_iter().any(|x| self.op(x).is_unknown())
    }
}
