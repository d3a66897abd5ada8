//! Substitution of expressions for symbols.

use std::collections::BTreeMap;

use rustc_hash::FxHashSet;

use super::{ExprId, Graph, Op, SymbolId};
use crate::table::Table;

impl Graph {
    /// `expr` with every listed symbol replaced. Expressions are rebuilt with all simplifications, so a symbol
    /// replaced by a number takes its consequences with it. Definitions of bound symbols, systems and roots are
    /// not entered: they are other variables.
    pub fn substitute(&mut self, expr: ExprId, replacements: &[(SymbolId, ExprId)]) -> ExprId {
        self.substitute_all(&[expr], replacements)[0]
    }

    /// [`substitute`](Self::substitute) in several expressions.
    pub fn substitute_all(&mut self, exprs: &[ExprId], replacements: &[(SymbolId, ExprId)]) -> Vec<ExprId> {
        if replacements.is_empty() {
            return exprs.to_vec();
        }
        let mut done = Table::default();
        exprs.iter().map(|&expr| self.substituted(expr, replacements, &mut done)).collect()
    }

    /// `exprs` with every listed symbol replaced as formulas have it: also in what they define, in whose place then stand formulas.
    ///
    /// # Panics
    /// If unknowns of equations change with a symbol that is replaced.
    pub(crate) fn substitute_in_formulas(
        &mut self,
        exprs: &[ExprId],
        replacements: &[(SymbolId, ExprId)],
    ) -> Vec<ExprId> {
        if !self.has_quantities() {
            return self.substitute_all(exprs, replacements);
        }
        let replaced: Vec<ExprId> =
            replacements.iter().map(|&(symbol, _)| self.intern(Op::Symbol(symbol))).collect();
        let mut all = replacements.to_vec();
        let (mut open, mut definitions) = (exprs.to_vec(), BTreeMap::new());
        while let Some(x) = open.pop() {
            self.refuse_unknowns(x, &replaced);
            for &symbol in &replaced {
                for (quantity, definition) in self.quantities_with(x, symbol) {
                    if !replaced.contains(&quantity) && definitions.insert(quantity, definition).is_none() {
                        open.push(definition);
                    }
                }
            }
        }
        // Quantities come after what they are made of.
        for (quantity, definition) in definitions {
            let definition = self.substitute(definition, &all);
            all.push((self.symbol_of(quantity), definition));
        }
        self.substitute_all(exprs, &all)
    }

    /// Refuses unknowns of equations that change with one of these symbols. Definitions are not entered.
    fn refuse_unknowns(&self, expr: ExprId, symbols: &[ExprId]) {
        let within = self.reachable(expr, Self::operands);
        let changes = |x: &ExprId| {
            let all = self.reachable(*x, Self::dependencies);
            symbols.iter().find(|symbol| all.contains(symbol)).copied()
        };
        if let Some(symbol) = within.iter().filter(|x| self.op(**x).is_unknown()).find_map(changes) {
            let name = &self.symbol_data(self.symbol_of(symbol)).name;
            panic!("unknowns of equations change with `{name}`: they have no other values with another one");
        }
    }

    /// `expr` with every listed expression replaced where it stands as it is. Definitions are not entered.
    pub(crate) fn replace(&mut self, expr: ExprId, replacements: &[(ExprId, ExprId)]) -> ExprId {
        let mut done = replacements.iter().copied().collect();
        self.substituted(expr, &[], &mut done)
    }

    /// The entries and right-hand sides of systems and the residuals of roots that the value follows from: substitution leaves them as
    /// they are. Definitions are not entered.
    pub(crate) fn equations(&self, expr: ExprId) -> Vec<ExprId> {
        let (mut seen, mut open, mut equations) = (FxHashSet::default(), vec![expr], Vec::new());
        while let Some(x) = open.pop() {
            if !seen.insert(x) || matches!(self.op(x), Op::Symbol(_)) {
                continue;
            }
            let own = match self.op(x) {
                Op::RootValue(root, _) | Op::RootFigure(root, _) => self.root(root).residuals.clone(),
                Op::Solution(..) | Op::InverseFactor { .. } | Op::PivotRatio(_) => self.dependencies(x),
                _ => Vec::new(),
            };
            open.extend(self.operands(x).iter().chain(&own));
            equations.extend(own);
        }
        equations
    }

    fn substituted(
        &mut self,
        expr: ExprId,
        replacements: &[(SymbolId, ExprId)],
        done: &mut Table<ExprId, ExprId>,
    ) -> ExprId {
        if let Some(&known) = done.get(&expr) {
            return known;
        }
        let operands = self.operands(expr);
        let result = match self.op(expr) {
            Op::Symbol(symbol) => {
                replacements.iter().find(|(s, _)| *s == symbol).map_or(expr, |&(_, replacement)| replacement)
            }
            _ if operands.is_empty() => expr,
            op => {
                let operands: Vec<ExprId> =
                    operands.into_iter().map(|x| self.substituted(x, replacements, done)).collect();
                self.made(op, &operands)
            }
        };
        // The value is the same quantity under other circumstances.
        if result != expr
            && let Some(name) = self.name_of(expr).map(str::to_owned)
            && !matches!(self.op(expr), Op::Symbol(_))
        {
            self.name(result, &name);
        }
        done.insert(expr, result);
        result
    }
}

#[cfg(test)]
mod tests {
    use super::super::Scope;
    use super::*;

    #[test]
    fn a_number_takes_its_consequences_with_it() {
        let mut g = Graph::new();
        let [x, y, z] = ["x", "y", "z"].map(|name| g.input(name, Scope::Element));
        let xy = g.mul(x, y);
        let sum = g.add(xy, z);
        let zero = g.zero();
        let symbol = g.symbol_of(x);
        assert_eq!(g.substitute(sum, &[(symbol, zero)]), z);
    }

    #[test]
    fn an_expression_is_replaced_where_it_stands() {
        let mut g = Graph::new();
        let [x, y, z] = ["x", "y", "z"].map(|name| g.input(name, Scope::Element));
        let (sum, root) = (g.add(x, y), g.sqrt(x));
        let product = g.mul(sum, root);
        let expected = g.mul(z, root);
        assert_eq!(g.replace(product, &[(sum, z)]), expected);
    }
}
