//! What pieces of code read: inputs, figures of roots, and what earlier loops keep.

use super::{NodeLoop, Program, Statement};
use crate::graph::{ExprId, Op, RootFigure, RootId, Scope};

/// What is read of a root's solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Solved {
    /// An unknown.
    Unknown(u32),
    /// How the iteration went.
    Figure(RootFigure),
}

impl<S> Program<S> {
    /// Whether a loop reads the input of node scope with this name: in a statement, a sum or a result.
    pub(crate) fn loop_reads(&self, nodes: &NodeLoop, name: &str) -> bool {
        let in_statements = nodes.statements.iter().any(|statement| match statement {
            Statement::Let(x) => self.operands_read(*x, name),
            Statement::Solve(_) => false,
        });
        let terms = nodes.sums.iter().flat_map(|&sum| self.kernel.graph.operands(sum));
        let mut results = terms.chain(nodes.outputs.iter().flat_map(|(_, values)| values.clone()));
        in_statements || results.any(|x| self.reads(x, name))
    }

    /// Whether an expression, where it is written, reads an input of node scope.
    fn reads(&self, expr: ExprId, name: &str) -> bool {
        match self.kernel.graph.op(expr) {
            Op::Symbol(_) => self.is_node_input(expr, name),
            _ => !self.layout.bound.contains(&expr) && self.operands_read(expr, name),
        }
    }

    fn operands_read(&self, expr: ExprId, name: &str) -> bool {
        self.kernel.graph.operands(expr).into_iter().any(|x| self.reads(x, name))
    }

    fn is_node_input(&self, expr: ExprId, name: &str) -> bool {
        let graph = &self.kernel.graph;
        let Op::Symbol(symbol) = graph.op(expr) else { return false };
        graph.scope(expr) == Scope::Node && graph.symbol_data(symbol).name == name
    }

    /// The expression of an input of node scope.
    pub(crate) fn node_input(&self, name: &str) -> Option<ExprId> {
        self.kernel.graph.symbol_named(name).filter(|&x| self.kernel.graph.scope(x) == Scope::Node)
    }

    /// The symbol with this name, if the code uses it.
    pub(crate) fn symbol(&self, name: &str) -> Option<ExprId> {
        self.kernel.graph.symbol_named(name).filter(|x| self.layout.bound.contains(x))
    }

    /// What the code uses of a root's solution.
    pub(crate) fn solved(&self, root: RootId) -> Vec<(ExprId, Solved)> {
        let graph = &self.kernel.graph;
        let all = (0..graph.len()).map(|k| ExprId(k as u32)).filter(|x| self.layout.bound.contains(x));
        all.filter_map(|x| match graph.op(x) {
            Op::RootValue(of, component) if of == root => Some((x, Solved::Unknown(component))),
            Op::RootFigure(of, figure) if of == root => Some((x, Solved::Figure(figure))),
            _ => None,
        })
        .collect()
    }

    /// What is kept of a node between the loops, in the order of the loops.
    pub(crate) fn kept(&self) -> Vec<ExprId> {
        let mut seen = rustc_hash::FxHashSet::default();
        let stores = self.phases.iter().flat_map(|phase| phase.nodes.stores.clone());
        stores.filter(|x| seen.insert(*x)).collect()
    }

    /// The place among [`kept`](Self::kept) of a value that a loop loads or stores.
    pub(crate) fn place(&self, expr: ExprId) -> usize {
        self.kept().iter().position(|&x| x == expr).expect("what is loaded was stored")
    }
}
