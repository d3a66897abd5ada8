//! Symbols: inputs, variables, and those that are bound to an expression.

use super::{ExprId, Graph, NODE_COUNT, Op, Scope, Symbol, SymbolId};

impl Graph {
    /// A new input symbol.
    pub fn input(&mut self, name: &str, scope: Scope) -> ExprId {
        let symbol = self.add_symbol(name, scope, None);
        self.intern(Op::Symbol(symbol))
    }

    /// The input symbol with this name, a new one where there is none.
    pub(crate) fn input_once(&mut self, name: &str, scope: Scope) -> ExprId {
        match self.symbols.iter().position(|s| s.name == name) {
            Some(k) => self.intern(Op::Symbol(SymbolId(k as u32))),
            None => self.input(name, scope),
        }
    }

    /// Whether there is an input symbol with this name.
    pub(crate) fn has_input(&self, name: &str) -> bool {
        self.symbols.iter().any(|s| s.name == name && s.definition.is_none())
    }

    /// The number of nodes, an input.
    pub fn node_count(&mut self) -> ExprId {
        self.input_once(NODE_COUNT, Scope::Element)
    }

    /// A new symbol bound to `definition`: equal in value, but a variable of its own for differentiation.
    pub fn bind(&mut self, name: &str, definition: ExprId) -> ExprId {
        let symbol = self.add_symbol(name, self.scope(definition), Some(definition));
        self.intern(Op::Symbol(symbol))
    }

    /// A new symbol bound to `definition` that is held: nothing that it depends on changes it while derivatives are taken.
    pub fn bind_held(&mut self, name: &str, definition: ExprId) -> ExprId {
        let symbol = self.add_symbol(name, self.scope(definition), Some(definition));
        self.symbols[symbol.index()].is_held = true;
        self.intern(Op::Symbol(symbol))
    }

    /// As [`bind`](Self::bind), with a name made unique.
    pub(crate) fn bind_unique(&mut self, name: &str, definition: ExprId) -> ExprId {
        let unique = self.unique_name(name);
        self.bind(&unique, definition)
    }

    /// A new free variable of element scope, to be substituted before anything is evaluated. Its name is made
    /// unique.
    pub fn variable(&mut self, name: &str) -> ExprId {
        let unique = self.unique_name(name);
        self.input(&unique, Scope::Element)
    }

    /// Whether there is a symbol with this name.
    pub(crate) fn has_symbol(&self, name: &str) -> bool {
        self.symbols.iter().any(|s| s.name == name)
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
    #[must_use]
    pub fn symbol_of(&self, expr: ExprId) -> SymbolId {
        match self.op(expr) {
            Op::Symbol(symbol) => symbol,
            op => panic!("{op:?} is not a symbol"),
        }
    }

    fn add_symbol(&mut self, name: &str, scope: Scope, definition: Option<ExprId>) -> SymbolId {
        assert!(self.symbols.iter().all(|s| s.name != name), "symbol {name} is declared twice");
        self.symbols.push(Symbol { name: name.to_owned(), scope, definition, is_held: false });
        SymbolId(u32::try_from(self.symbols.len() - 1).expect("fewer than 2³² symbols"))
    }

    /// As [`bind`](Self::bind), but a symbol bound to this expression under this name before is used again.
    pub fn bind_once(&mut self, name: &str, definition: ExprId) -> ExprId {
        let known = self.symbols.iter().position(|s| s.name == name && s.definition == Some(definition));
        match known {
            Some(k) => self.intern(Op::Symbol(SymbolId(k as u32))),
            None => self.bind(name, definition),
        }
    }
}
