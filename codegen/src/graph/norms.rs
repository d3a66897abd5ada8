//! Norms as symbols, n = √q of the sum of squares q.
//!
//! A function that is smooth where a norm is zero has ∂f/∂n = 0 there, and ∂f/∂q = (∂f/∂n)/(2 n) has a limit, ½ ∂²f/∂n². Rules that look at
//! one operation at a time cannot know it: they have the direction of the norm, which is 0 there. The chain rule through n and q does.

use std::collections::BTreeSet;

use rustc_hash::{FxHashMap, FxHashSet};

use super::{ExprId, Graph, Op, Scope};
use crate::table::Table;

/// Norms that become symbols, and what has been rebuilt with these.
struct Replaced {
    meant: FxHashSet<ExprId>,
    done: Table<ExprId, ExprId>,
}

/// x < y of a choice, and whether it is what stands there if that is so.
type Choice = (ExprId, ExprId, bool);

/// Most copies of norms for the choices that they stand in: each has derivatives of its own.
const MOST_COPIES: usize = 24;

/// Norms that become zero where they are left out.
struct Chosen {
    norms: FxHashSet<ExprId>,
    /// What is made of them.
    above: FxHashSet<ExprId>,
    /// How many norms stand in their place so far.
    copies: usize,
    /// Those around the expression, outermost first.
    choices: Vec<Choice>,
    done: FxHashMap<(ExprId, Vec<Choice>), ExprId>,
}

impl Chosen {
    fn new(graph: &Graph, expr: ExprId, norms: &FxHashSet<ExprId>) -> Self {
        let mut above = norms.clone();
        // Operands come before what is made of them.
        for x in graph.reachable(expr, Graph::operands).into_iter().collect::<BTreeSet<_>>() {
            if graph.operands(x).iter().any(|operand| above.contains(operand)) {
                above.insert(x);
            }
        }
        Self { norms: norms.clone(), above, copies: 0, choices: Vec::new(), done: FxHashMap::default() }
    }
}

impl Graph {
    /// The expression with such symbols in the place of norms of the element that change with one of the variables. Powers of norms, polynomials that
    /// are smooth where the norm is zero, and what is divided by one, stay: they have rules of their own. Definitions and conditions are not
    /// entered.
    pub(crate) fn with_norm_symbols(&mut self, expr: ExprId, variables: &[ExprId]) -> ExprId {
        let is_norm = |g: &Self, x: ExprId| {
            matches!(g.op(x), Op::Hypot(..)) && g.scope(x) == Scope::Element && g.changes_with(x, variables)
        };
        let left_out = self.left_out(&[expr]);
        let mut unsafe_norms: FxHashSet<ExprId> =
            left_out.into_iter().filter(|&x| is_norm(self, x) && !self.is_smooth(x)).collect();
        let mut chosen = Chosen::new(self, expr, &unsafe_norms);
        let replaced = self.norms_chosen(expr, &mut chosen);
        let expr = if chosen.copies > MOST_COPIES {
            // They keep the rules of their operations, by which they have no second derivatives where they are zero.
            expr
        } else {
            unsafe_norms.clear();
            replaced
        };
        let all = self.reachable(expr, Self::operands);
        let meant = all.into_iter().filter(|&x| is_norm(self, x) && !unsafe_norms.contains(&x)).collect();
        self.norms_replaced(expr, &mut Replaced { meant, done: Table::default() })
    }

    /// The expression with norms that are zero where the choices that they stand in leave them out. There they may have infinite
    /// derivatives, which a chain rule through their symbols would multiply by 0.
    fn norms_chosen(&mut self, expr: ExprId, chosen: &mut Chosen) -> ExprId {
        if !chosen.above.contains(&expr) || chosen.copies > MOST_COPIES {
            return expr;
        }
        let key = (expr, chosen.choices.clone());
        if let Some(&known) = chosen.done.get(&key) {
            return known;
        }
        let op = self.op(expr);
        let result = match op {
            Op::Sum(_) => expr,
            Op::Hypot(..) if chosen.norms.contains(&expr) => {
                chosen.copies += 1;
                let zero = self.zero();
                let mut components = self.norm_components(expr);
                for component in &mut components {
                    *component = self.norms_chosen(*component, chosen);
                    // The innermost first.
                    for &(x, y, is_then) in chosen.choices.iter().rev() {
                        let (then, otherwise) = if is_then { (*component, zero) } else { (zero, *component) };
                        *component = self.select_less(x, y, then, otherwise);
                    }
                }
                components.into_iter().reduce(|norm, x| self.hypot(norm, x)).unwrap_or(zero)
            }
            _ => {
                let operands = self.operands(expr);
                let mut rebuilt = operands.clone();
                for (place, operand) in rebuilt.iter_mut().enumerate() {
                    let choice = match op {
                        Op::Select { .. } if place < 2 => continue,
                        Op::Select { x, y, .. } => Some((x, y, place == 2)),
                        _ => None,
                    };
                    chosen.choices.extend(choice);
                    *operand = self.norms_chosen(*operand, chosen);
                    if choice.is_some() {
                        chosen.choices.pop();
                    }
                }
                if rebuilt == operands { expr } else { self.made(op, &rebuilt) }
            }
        };
        if result != expr
            && let Some(name) = self.name_of(expr).map(str::to_owned)
        {
            self.name(result, &name);
        }
        chosen.done.insert(key, result);
        result
    }

    /// Whether an expression changes with one of these symbols, also through what is bound.
    pub(crate) fn changes_with(&self, expr: ExprId, symbols: &[ExprId]) -> bool {
        self.reachable(expr, Self::varying_dependencies).iter().any(|x| symbols.contains(x))
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

    fn norms_replaced(&mut self, expr: ExprId, replaced: &mut Replaced) -> ExprId {
        if let Some(&known) = replaced.done.get(&expr) {
            return known;
        }
        let op = self.op(expr);
        let result = match op {
            Op::Power(base, _) if self.has_norm(base) => expr,
            Op::Polynomial(base, polynomial)
                if self.has_norm(base)
                    && self.polynomial_data(polynomial).derivative().over_x().is_some() =>
            {
                expr
            }
            Op::Hypot(..) => self.hypot_replaced(expr, replaced),
            Op::Sum(_) => expr,
            _ => {
                let operands = self.operands(expr);
                // Of a choice the last two.
                let first = if matches!(op, Op::Select { .. }) { 2 } else { 0 };
                let is_divisor = |place: usize| matches!(op, Op::DivOrZero(..)) && place == 1;
                let rebuilt: Vec<ExprId> = operands
                    .iter()
                    .enumerate()
                    .map(|(place, &x)| match x {
                        _ if place < first || is_divisor(place) => x,
                        _ if replaced.meant.contains(&x) => self.norm_symbol(x, replaced),
                        _ => self.norms_replaced(x, replaced),
                    })
                    .collect();
                if rebuilt == operands { expr } else { self.made(op, &rebuilt) }
            }
        };
        if result != expr
            && let Some(name) = self.name_of(expr).map(str::to_owned)
        {
            self.name(result, &name);
        }
        replaced.done.insert(expr, result);
        result
    }

    /// The norm with such symbols in its components.
    fn hypot_replaced(&mut self, norm: ExprId, replaced: &mut Replaced) -> ExprId {
        let components = self.norm_components(norm);
        let rebuilt: Vec<ExprId> = components.iter().map(|&x| self.norms_replaced(x, replaced)).collect();
        if rebuilt == components {
            return norm;
        }
        let zero = self.zero();
        rebuilt.into_iter().reduce(|norm, x| self.hypot(norm, x)).unwrap_or(zero)
    }

    fn norm_symbol(&mut self, norm: ExprId, replaced: &mut Replaced) -> ExprId {
        if let Some(&known) = self.norm_symbols.get(&norm) {
            return known;
        }
        let name = self.name_of(norm).unwrap_or("norm").to_owned();
        let whole = self.hypot_replaced(norm, replaced);
        let square = self.power(whole, 2);
        let square = self.bind_unique(&format!("{name}_squared"), square);
        let root = self.sqrt(square);
        let symbol = self.bind_unique(&name, root);
        self.norms.insert(self.symbol_of(symbol));
        self.norm_symbols.insert(norm, symbol);
        symbol
    }
}
