//! The expression graph: a hash-consed arena of scalar expressions with `u32` ids.
//!
//! Promises:
//! * Equal expressions have equal ids, also when products of up to 16 factors are associated differently (see [`Graph::mul`]).
//! * Ids grow from operands to results, so ascending order is a topological order.
//! * Every expression knows its [`Scope`]: one value per element or per node. A
//!   [`Op::Sum`] over the nodes turns a node expression into an element expression.
//! * Symbols may be *bound* to a defining expression. A bound symbol is opaque to differentiation: it is a
//!   variable of its own, which is what the implicit rules of [`crate::structure`] need.
//! * Nothing here iterates over a hash map, so results depend on the order of construction only.

mod choice;
mod cost;
mod derivative;
mod norms;
mod polynomial;
mod products;
mod roots;
mod simplify;
mod structured;
mod substitute;
mod symbols;
mod written_out;

use rustc_hash::{FxHashMap, FxHashSet};

use crate::table::Table;

pub use polynomial::Polynomial;
pub use structured::{Iteration, Limits, Root, Solve, SymmetricSystem};

macro_rules! ids {
    ($($(#[$doc:meta])* $name:ident,)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub struct $name(pub(crate) u32);

        impl $name {
            /// Position in its arena.
            pub const fn index(self) -> usize {
                self.0 as usize
            }
        }
    )*};
}

ids! {
    /// An expression of a [`Graph`].
    ExprId,
    /// A symbol of a [`Graph`].
    SymbolId,
    /// A symmetric system of a [`Graph`].
    SystemId,
    /// A right-hand side solved with a system of a [`Graph`].
    SolveId,
    /// A polynomial of a [`Graph`].
    PolynomialId,
    /// A small system of equations of a [`Graph`], solved by iteration.
    RootId,
}

/// How many values an expression stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Scope {
    /// One value.
    Element,
    /// One value for each master node.
    Node,
}

/// Figures that tell how an iteration for a [`Root`] went.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RootFigure {
    /// Largest residual component at the last iterate.
    Residual,
    /// Iterations made.
    Iterations,
}

/// An elementary function of one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Function {
    /// ln x
    Ln,
    /// sin x
    Sin,
    /// cos x
    Cos,
    /// ∛x
    Cbrt,
}

impl Function {
    /// Value at x.
    pub fn evaluate(self, x: f64) -> f64 {
        match self {
            Self::Ln => x.ln(),
            Self::Sin => x.sin(),
            Self::Cos => x.cos(),
            Self::Cbrt => x.cbrt(),
        }
    }

    /// Name of the method in emitted code.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ln => "ln",
            Self::Sin => "sin",
            Self::Cos => "cos",
            Self::Cbrt => "cbrt",
        }
    }
}

/// An operation and its operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // The names say what the fields are.
pub enum Op {
    /// A number, by its bits.
    Constant(u64),
    /// An input or a bound symbol.
    Symbol(SymbolId),
    /// x + y
    Add(ExprId, ExprId),
    /// −x
    Neg(ExprId),
    /// x y
    Mul(ExprId, ExprId),
    /// x / y
    Div(ExprId, ExprId),
    /// x / y, and 0 where y = 0
    DivOrZero(ExprId, ExprId),
    /// √x
    Sqrt(ExprId),
    /// eˣ
    Exp(ExprId),
    /// f(x)
    Function(Function, ExprId),
    /// Angle of the point (x, y), given as (y, x)
    Atan2(ExprId, ExprId),
    /// xʸ for x > 0
    RealPower(ExprId, ExprId),
    /// √(x² + y²), whose direction at the origin is 0
    Hypot(ExprId, ExprId),
    /// xᵏ with an exact integer k
    Power(ExprId, i32),
    /// P(x)
    Polynomial(ExprId, PolynomialId),
    /// if x < y { then } else { otherwise }
    Select { x: ExprId, y: ExprId, then: ExprId, otherwise: ExprId },
    /// Sum over the nodes.
    Sum(ExprId),
    /// Component of the solution of a symmetric system.
    Solution(SolveId, u32),
    /// Entry (row, column ≤ row) of L⁻¹, where L S Lᵀ is the system's matrix in its elimination order. `column`
    /// counts in that order too.
    InverseFactor { system: SystemId, row: u32, column: u32 },
    /// Smallest pivot of a system's factorisation, relative to its reference.
    PivotRatio(SystemId),
    /// Unknown of a small system of equations at its root.
    RootValue(RootId, u32),
    /// How the iteration for a root went.
    RootFigure(RootId, RootFigure),
}

impl Op {
    /// Whether it is a value of a system or of equations.
    const fn is_unknown(self) -> bool {
        matches!(
            self,
            Self::RootValue(..)
                | Self::RootFigure(..)
                | Self::Solution(..)
                | Self::InverseFactor { .. }
                | Self::PivotRatio(_)
        )
    }

    fn operands(self) -> Vec<ExprId> {
        match self {
            Self::Add(x, y) | Self::Mul(x, y) | Self::Div(x, y) | Self::DivOrZero(x, y) => vec![x, y],
            Self::Atan2(x, y) | Self::RealPower(x, y) | Self::Hypot(x, y) => vec![x, y],
            Self::Neg(x) | Self::Sqrt(x) | Self::Exp(x) | Self::Function(_, x) => vec![x],
            Self::Power(x, _) | Self::Polynomial(x, _) | Self::Sum(x) => vec![x],
            Self::Select { x, y, then, otherwise } => vec![x, y, then, otherwise],
            Self::Constant(_)
            | Self::Symbol(_)
            | Self::Solution(..)
            | Self::InverseFactor { .. }
            | Self::PivotRatio(_)
            | Self::RootValue(..)
            | Self::RootFigure(..) => Vec::new(),
        }
    }
}

/// A named leaf.
#[derive(Clone, Debug)]
pub struct Symbol {
    /// Name, unique in its graph.
    pub name: String,
    /// Scope of the values it takes.
    pub scope: Scope,
    /// What it is bound to; `None` for an input.
    pub definition: Option<ExprId>,
    /// Whether it has its definition's value, but is a constant for all derivatives.
    pub is_held: bool,
    /// Whether its value is finite wherever the inputs are.
    pub(crate) is_finite: bool,
}

/// Name of the input that holds the number of nodes.
pub(crate) const NODE_COUNT: &str = "node_count";
/// Name of the input that holds a node's index.
pub(crate) const NODE_INDEX: &str = "node_index";

/// An arena of expressions; see the module's promises.
#[derive(Clone, Debug, Default)]
pub struct Graph {
    ops: Vec<Op>,
    scopes: Vec<Scope>,
    /// How many factors each expression has, see [`length_of_op`](Self::length_of_op).
    lengths: Vec<u8>,
    interned: Table<Op, ExprId>,
    /// Products by their sorted factors, so that (w a) b and w (a b) are one expression.
    products: Table<Vec<ExprId>, ExprId>,
    /// Of each expression, if it has one.
    names: Vec<Option<String>>,
    symbols: Vec<Symbol>,
    symbol_names: FxHashMap<String, SymbolId>,
    /// Bound symbols that formulas are differentiated through while they are written.
    quantities: FxHashSet<SymbolId>,
    /// Symbols that stand for norms, by norm; and these with the ones that were made in their place.
    norm_symbols: FxHashMap<ExprId, ExprId>,
    norms: FxHashSet<SymbolId>,
    /// Whether inputs that others are divided by may be zero.
    has_free_divisors: bool,
    /// Whether sums and products stay as they are written, but for numbers alone, 0 and 1.
    is_as_written: bool,
    derivatives: Table<(ExprId, SymbolId), ExprId>,
    polynomials: Vec<Polynomial>,
    systems: Vec<SymmetricSystem>,
    solves: Vec<Solve>,
    roots: Vec<Root>,
    /// What each root depends on.
    parameters: Vec<Vec<ExprId>>,
    /// Linear equations that are roots, by their matrix and right-hand side.
    linear: FxHashMap<(Vec<Vec<ExprId>>, Vec<ExprId>), RootId>,
}

impl Graph {
    /// An empty graph.
    pub fn new() -> Self {
        Self::default()
    }

    /// The operation of an expression.
    pub fn op(&self, expr: ExprId) -> Op {
        self.ops[expr.index()]
    }

    /// The scope of an expression.
    pub fn scope(&self, expr: ExprId) -> Scope {
        self.scopes[expr.index()]
    }

    /// Number of expressions made so far.
    pub fn len(&self) -> usize {
        self.ops.len()
    }

    /// Whether no expression was made yet.
    pub fn is_empty(&self) -> bool {
        self.ops.is_empty()
    }

    /// The operands of an expression. Symbols, systems and roots have dependencies of another kind:
    /// [`dependencies`](Self::dependencies) follows those too.
    pub fn operands(&self, expr: ExprId) -> Vec<ExprId> {
        self.op(expr).operands()
    }

    /// Everything an expression's value depends on directly: operands, a bound symbol's definition, the
    /// entries of a system and its right-hand side, the parameters of a root, or its value where that is known.
    pub fn dependencies(&self, expr: ExprId) -> Vec<ExprId> {
        match self.op(expr) {
            Op::Symbol(symbol) => self.symbols[symbol.index()].definition.into_iter().collect(),
            Op::Solution(solve, _) => {
                let solve = &self.solves[solve.index()];
                let mut all = self.system(solve.system).entries();
                all.extend(&solve.right_hand_side);
                all
            }
            Op::InverseFactor { system, .. } => self.system(system).entries(),
            Op::PivotRatio(system) => {
                let system = self.system(system);
                let mut all = system.entries();
                all.extend((0..system.size()).filter_map(|row| system.reference(row)));
                all
            }
            Op::RootValue(root, component) if self.root(root).is_known() => {
                vec![self.root(root).known[component as usize]]
            }
            Op::RootValue(root, _) | Op::RootFigure(root, _) => self.dependencies_of_root(root).to_vec(),
            _ => self.operands(expr),
        }
    }

    /// What an expression changes with, directly: its [`dependencies`](Self::dependencies), but nothing of a held symbol, and of a root
    /// that is known the parameters of its equations.
    pub fn varying_dependencies(&self, expr: ExprId) -> Vec<ExprId> {
        match self.op(expr) {
            Op::Symbol(symbol) if self.symbols[symbol.index()].is_held => Vec::new(),
            Op::RootValue(root, _) => self.dependencies_of_root(root).to_vec(),
            _ => self.dependencies(expr),
        }
    }

    /// A symbol's data.
    pub fn symbol_data(&self, symbol: SymbolId) -> &Symbol {
        &self.symbols[symbol.index()]
    }

    /// The polynomial with this id.
    pub fn polynomial_data(&self, polynomial: PolynomialId) -> &Polynomial {
        &self.polynomials[polynomial.index()]
    }

    /// The system with this id.
    pub fn system(&self, system: SystemId) -> &SymmetricSystem {
        &self.systems[system.index()]
    }

    /// The solve with this id.
    pub fn solve(&self, solve: SolveId) -> &Solve {
        &self.solves[solve.index()]
    }

    /// The root with this id.
    pub fn root(&self, root: RootId) -> &Root {
        &self.roots[root.index()]
    }

    /// Gives an expression the name that the emitted code will show. The first name stays. Of a negative, the
    /// positive is named: signs are written where they are used.
    pub fn name(&mut self, expr: ExprId, name: &str) -> ExprId {
        match self.op(expr) {
            Op::Constant(_) | Op::Symbol(_) => {}
            Op::Neg(positive) => {
                if self.name_of(positive).is_none() {
                    self.names[positive.index()] = Some(format!("minus_{name}"));
                }
            }
            _ => {
                self.names[expr.index()].get_or_insert_with(|| name.to_owned());
            }
        }
        expr
    }

    /// The name of an expression or symbol.
    pub fn name_of(&self, expr: ExprId) -> Option<&str> {
        match self.op(expr) {
            Op::Symbol(symbol) => Some(&self.symbols[symbol.index()].name),
            _ => self.names[expr.index()].as_deref(),
        }
    }

    /// Adds a symmetric system.
    pub fn add_system(&mut self, system: SymmetricSystem) -> SystemId {
        self.systems.push(system);
        SystemId(u32::try_from(self.systems.len() - 1).expect("fewer than 2³² systems"))
    }

    /// Solves a system for a right-hand side; returns the components of the solution.
    ///
    /// # Panics
    /// If the right-hand side has another size than the system.
    pub fn solve_symmetric(&mut self, system: SystemId, right_hand_side: Vec<ExprId>) -> Vec<ExprId> {
        let size = self.system(system).size();
        assert_eq!(right_hand_side.len(), size, "right-hand side of system {}", self.system(system).name);
        self.solves.push(Solve { system, right_hand_side });
        let solve = SolveId(u32::try_from(self.solves.len() - 1).expect("fewer than 2³² solves"));
        (0..size).map(|k| self.intern(Op::Solution(solve, k as u32))).collect()
    }

    /// As [`solve_symmetric`](Self::solve_symmetric), but a right-hand side that was solved before is not solved again.
    pub fn solve_symmetric_once(&mut self, system: SystemId, right_hand_side: &[ExprId]) -> Vec<ExprId> {
        let known =
            self.solves.iter().position(|s| s.system == system && s.right_hand_side == right_hand_side);
        match known {
            Some(k) => (0..right_hand_side.len())
                .map(|j| self.intern(Op::Solution(SolveId(k as u32), j as u32)))
                .collect(),
            None => self.solve_symmetric(system, right_hand_side.to_vec()),
        }
    }

    /// The expression with this operation, made if there is none yet.
    pub(crate) fn intern(&mut self, op: Op) -> ExprId {
        if let Some(&id) = self.interned.get(&op) {
            return id;
        }
        let id = ExprId(u32::try_from(self.ops.len()).expect("fewer than 2³² expressions"));
        self.scopes.push(self.scope_of_op(op));
        self.lengths.push(self.length_of_op(op));
        self.ops.push(op);
        self.names.push(None);
        self.interned.insert(op, id);
        id
    }

    fn scope_of_op(&self, op: Op) -> Scope {
        let widest = |exprs: &[ExprId]| exprs.iter().map(|&x| self.scope(x)).max().unwrap_or(Scope::Element);
        match op {
            Op::Symbol(symbol) => self.symbols[symbol.index()].scope,
            Op::Solution(solve, _) => widest(&self.solves[solve.index()].right_hand_side),
            Op::Sum(_) => Scope::Element,
            _ => widest(&op.operands()),
        }
    }
}

/// A graph with inputs x, y and z.
#[cfg(test)]
fn three_inputs() -> (Graph, ExprId, ExprId, ExprId) {
    let mut g = Graph::new();
    let [x, y, z] = ["x", "y", "z"].map(|name| g.input(name, Scope::Element));
    (g, x, y, z)
}
