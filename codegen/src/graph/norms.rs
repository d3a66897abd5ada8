//! Norms as symbols, n = √q of the sum of squares q.
//!
//! A function that is smooth where a norm is zero has ∂f/∂n = 0 there, and ∂f/∂q = (∂f/∂n)/(2 n) has a limit, ½ ∂²f/∂n². Rules that look at
//! one operation at a time cannot know it: they have the direction of the norm, which is 0 there. The chain rule through n and q does.

use super::{ExprId, Graph, Op, Scope};
use crate::table::Table;

impl Graph {
    /// The expression with such symbols in the place of norms of the element. Powers and polynomials of norms, and what is divided by one, stay:
    /// they have rules of their own. Definitions and conditions are not entered.
    pub(crate) fn with_norm_symbols(&mut self, expr: ExprId) -> ExprId {
        let mut done = Table::default();
        self.norms_replaced(expr, &mut done)
    }

    /// Whether it is the symbol n of a norm. Its definition is √q with the symbol q.
    pub(crate) fn is_norm_symbol(&self, expr: ExprId) -> bool {
        matches!(self.op(expr), Op::Symbol(symbol) if self.norms.contains(&symbol))
    }

    /// A new symbol of the same name and kind as a bound one.
    pub(crate) fn bind_again(&mut self, symbol: ExprId, definition: ExprId) -> ExprId {
        let name = self.symbol_data(self.symbol_of(symbol)).name.clone();
        let other = self.bind_unique(&name, definition);
        if self.is_norm_symbol(symbol) {
            self.norms.insert(self.symbol_of(other));
        }
        other
    }

    fn norms_replaced(&mut self, expr: ExprId, done: &mut Table<ExprId, ExprId>) -> ExprId {
        if let Some(&known) = done.get(&expr) {
            return known;
        }
        let op = self.op(expr);
        let result = match op {
            Op::Power(base, _) | Op::Polynomial(base, _) if self.has_norm(base) => expr,
            Op::Hypot(..) => self.hypot_replaced(expr, done),
            Op::Sum(_) | Op::Row(_) | Op::Column(_) => expr,
            _ => {
                let operands = self.operands(expr);
                // Of a choice the last two.
                let first = if matches!(op, Op::Select { .. }) { 2 } else { 0 };
                let is_divisor = |place: usize| matches!(op, Op::DivOrZero(..)) && place == 1;
                let replaced: Vec<ExprId> = operands
                    .iter()
                    .enumerate()
                    .map(|(place, &x)| match self.op(x) {
                        _ if place < first || is_divisor(place) => x,
                        Op::Hypot(..) if self.scope(x) == Scope::Element => self.norm_symbol(x, done),
                        _ => self.norms_replaced(x, done),
                    })
                    .collect();
                if replaced == operands { expr } else { self.made(op, &replaced) }
            }
        };
        if result != expr
            && let Some(name) = self.name_of(expr).map(str::to_owned)
        {
            self.name(result, &name);
        }
        done.insert(expr, result);
        result
    }

    /// The norm with such symbols in its components.
    fn hypot_replaced(&mut self, norm: ExprId, done: &mut Table<ExprId, ExprId>) -> ExprId {
        let components = self.norm_components(norm);
        let replaced: Vec<ExprId> = components.iter().map(|&x| self.norms_replaced(x, done)).collect();
        if replaced == components {
            return norm;
        }
        let zero = self.zero();
        replaced.into_iter().reduce(|norm, x| self.hypot(norm, x)).unwrap_or(zero)
    }

    fn norm_symbol(&mut self, norm: ExprId, done: &mut Table<ExprId, ExprId>) -> ExprId {
        if let Some(&known) = self.norm_symbols.get(&norm) {
            return known;
        }
        let name = self.name_of(norm).unwrap_or("norm").to_owned();
        let whole = self.hypot_replaced(norm, done);
        let square = self.power(whole, 2);
        let square = self.bind_unique(&format!("{name}_squared"), square);
        let root = self.sqrt(square);
        let symbol = self.bind_unique(&name, root);
        self.norms.insert(self.symbol_of(symbol));
        self.norm_symbols.insert(norm, symbol);
        symbol
    }
}
