//! Symbols: inputs, variables, and those that are bound to an expression.

use rustc_hash::FxHashSet;

use super::{ExprId, Function, Graph, NODE_COUNT, Op, Scope, Symbol, SymbolId};

impl Graph {
    /// A new input symbol.
    pub fn input(&mut self, name: &str, scope: Scope) -> ExprId {
        let symbol = self.add_symbol(name, scope, None);
        self.intern(Op::Symbol(symbol))
    }

    /// The input symbol with this name, a new one where there is none.
    pub(crate) fn input_once(&mut self, name: &str, scope: Scope) -> ExprId {
        match self.symbol_names.get(name) {
            Some(&symbol) => self.intern(Op::Symbol(symbol)),
            None => self.input(name, scope),
        }
    }

    /// Whether an expression is a symbol that is finite, with its derivatives, wherever the inputs are.
    pub(super) fn is_finite_symbol(&self, expr: ExprId) -> bool {
        matches!(self.op(expr), Op::Symbol(symbol) if self.symbol_data(symbol).is_finite)
    }

    /// Whether a definition is finite, with its derivatives, wherever the inputs are, but for overflow: one without divisions, roots and
    /// logarithms.
    fn is_finite(&self, definition: ExprId) -> bool {
        self.is_finite_over(definition, |_| false)
    }

    /// The same, where some expressions may be divided by.
    pub(super) fn is_finite_over(&self, definition: ExprId, is_divisor: impl Fn(ExprId) -> bool) -> bool {
        self.reachable(definition, Self::operands).into_iter().all(|x| match self.op(x) {
            Op::Constant(bits) => f64::from_bits(bits).is_finite(),
            Op::Symbol(symbol) => self.symbol_data(symbol).is_finite,
            Op::Power(_, exponent) => exponent > 0,
            Op::Div(_, divisor) => is_divisor(divisor),
            Op::Function(function, _) => !matches!(function, Function::Ln | Function::Cbrt),
            Op::Add(..) | Op::Neg(_) | Op::Mul(..) | Op::Polynomial(..) | Op::Hypot(..) => true,
            Op::Select { .. } | Op::Sum(_) | Op::DivOrZero(..) => true,
            _ => false,
        })
    }

    /// Whether there is an input symbol with this name.
    pub(crate) fn has_input(&self, name: &str) -> bool {
        self.symbol_names.get(name).is_some_and(|&symbol| self.symbol_data(symbol).definition.is_none())
    }

    /// The symbol with this name, if there is one that an expression was made of.
    pub(crate) fn symbol_named(&self, name: &str) -> Option<ExprId> {
        let symbol = self.symbol_names.get(name)?;
        self.interned.get(&Op::Symbol(*symbol)).copied()
    }

    /// The number of nodes, an input.
    pub fn node_count(&mut self) -> ExprId {
        self.input_once(NODE_COUNT, Scope::Element)
    }

    /// A new symbol bound to `definition`, which is finite: equal in value, but a variable of its own for differentiation.
    pub fn bind(&mut self, name: &str, definition: ExprId) -> ExprId {
        let symbol = self.add_symbol(name, self.scope(definition), Some(definition));
        self.intern(Op::Symbol(symbol))
    }

    /// A new symbol bound to `definition` that is held: nothing that it depends on changes it while derivatives are taken. Its name is made
    /// unique.
    pub fn bind_held(&mut self, name: &str, definition: ExprId) -> ExprId {
        let unique = self.unique_name(name);
        let symbol = self.add_symbol(&unique, self.scope(definition), Some(definition));
        let is_finite = self.is_finite(definition);
        let data = &mut self.symbols[symbol.index()];
        (data.is_held, data.is_finite) = (true, is_finite);
        self.intern(Op::Symbol(symbol))
    }

    /// As [`bind`](Self::bind), with a name made unique, for any definition: it need not be finite.
    pub(crate) fn bind_unique(&mut self, name: &str, definition: ExprId) -> ExprId {
        let unique = self.unique_name(name);
        let is_finite = self.is_finite(definition);
        let symbol = self.bind(&unique, definition);
        let place = self.symbol_of(symbol).index();
        self.symbols[place].is_finite = is_finite;
        symbol
    }

    /// Lets [`derivative_of_formula`](Self::derivative_of_formula) go through a bound symbol.
    pub(crate) fn add_quantity(&mut self, symbol: ExprId) {
        let symbol = self.symbol_of(symbol);
        self.quantities.insert(symbol);
    }

    /// Lets inputs that others are divided by be zero: a choice that leaves a quotient out does so in derivatives, too.
    pub(crate) fn free_divisors(&mut self) {
        self.has_free_divisors = true;
    }

    /// Lets sums and products be as they are written from here on: what is compared with those that are simplified.
    pub(crate) fn keep_as_written(&mut self) {
        self.is_as_written = true;
    }

    /// Whether they are.
    pub(crate) const fn is_as_written(&self) -> bool {
        self.is_as_written
    }

    /// Whether there are any.
    pub(crate) fn has_quantities(&self) -> bool {
        !self.quantities.is_empty()
    }

    /// Makes quantities variables of their own, for the rules that go through definitions one by one.
    pub(crate) fn end_quantities(&mut self) {
        self.quantities.clear();
    }

    /// The first bound symbol in an expression whose definition contains one of these symbols.
    pub(crate) fn definition_with(&self, expr: ExprId, symbols: &[ExprId]) -> Option<(ExprId, ExprId)> {
        let bound = self.reachable(expr, |g, x| match g.op(x) {
            Op::Symbol(_) => Vec::new(),
            _ => g.dependencies(x),
        });
        let bound = bound.into_iter().filter(|&x| matches!(self.op(x), Op::Symbol(_)));
        let mut found = bound.flat_map(|x| {
            let definition = self.dependencies(x).into_iter();
            let below = definition.flat_map(|y| self.reachable(y, Self::dependencies));
            below.filter(|y| symbols.contains(y)).map(move |y| (x, y)).collect::<Vec<_>>()
        });
        found.next()
    }

    /// An expression and what it is made of, each once.
    pub(crate) fn reachable(&self, expr: ExprId, next: impl Fn(&Self, ExprId) -> Vec<ExprId>) -> Vec<ExprId> {
        self.reachable_from(vec![expr], next)
    }

    /// The same of several.
    pub(crate) fn reachable_from(
        &self,
        mut open: Vec<ExprId>,
        next: impl Fn(&Self, ExprId) -> Vec<ExprId>,
    ) -> Vec<ExprId> {
        let (mut seen, mut all) = (FxHashSet::default(), Vec::new());
        while let Some(x) = open.pop() {
            if seen.insert(x) {
                all.push(x);
                open.extend(next(self, x));
            }
        }
        all
    }

    /// A new free variable of element scope, to be substituted before anything is evaluated. Its name is made
    /// unique.
    pub fn variable(&mut self, name: &str) -> ExprId {
        let unique = self.unique_name(name);
        self.input(&unique, Scope::Element)
    }

    /// Whether there is a symbol with this name.
    pub(crate) fn has_symbol(&self, name: &str) -> bool {
        self.symbol_names.contains_key(name)
    }

    /// Gives a symbol another name, so that its own is free.
    pub(crate) fn rename(&mut self, symbol: ExprId) {
        let symbol = self.symbol_of(symbol);
        let unique = self.unique_name(&self.symbol_data(symbol).name);
        let name = std::mem::replace(&mut self.symbols[symbol.index()].name, unique.clone());
        self.symbol_names.remove(&name);
        self.symbol_names.insert(unique, symbol);
    }

    /// The name, with a number where there is a symbol of this name.
    pub(crate) fn unique_name(&self, name: &str) -> String {
        if !self.has_symbol(name) {
            return name.to_owned();
        }
        (2..).map(|k| format!("{name}_{k}")).find(|name| !self.has_symbol(name)).unwrap_or_default()
    }

    /// The symbol behind an expression made by [`input`](Self::input), [`bind`](Self::bind) or
    /// [`variable`](Self::variable).
    ///
    /// # Panics
    /// If the expression is not a symbol.
    #[track_caller]
    pub fn symbol_of(&self, expr: ExprId) -> SymbolId {
        match self.op(expr) {
            Op::Symbol(symbol) => symbol,
            Op::Constant(bits) => {
                panic!("the number {} is no input or unknown, which is needed here", f64::from_bits(bits))
            }
            op => panic!("a formula, {op:?}, is no input or unknown, which is needed here"),
        }
    }

    fn add_symbol(&mut self, name: &str, scope: Scope, definition: Option<ExprId>) -> SymbolId {
        let symbol = SymbolId(u32::try_from(self.symbols.len()).expect("fewer than 2³² symbols"));
        let before = self.symbol_names.insert(name.to_owned(), symbol);
        assert!(before.is_none(), "symbol {name} is declared twice");
        self.symbols.push(Symbol {
            name: name.to_owned(),
            scope,
            definition,
            is_held: false,
            is_finite: true,
        });
        symbol
    }

    /// As [`bind`](Self::bind), but a symbol bound to this expression under this name before is used again.
    pub fn bind_once(&mut self, name: &str, definition: ExprId) -> ExprId {
        match self.symbol_names.get(name) {
            Some(&symbol) if self.symbol_data(symbol).definition == Some(definition) => {
                self.intern(Op::Symbol(symbol))
            }
            _ => self.bind(name, definition),
        }
    }
}
