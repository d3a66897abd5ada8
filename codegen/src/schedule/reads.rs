//! What loops over the nodes read.

use super::{NodeLoop, Program, Statement};
use crate::graph::{ExprId, Op, Scope};

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
        (0..self.kernel.graph.len()).map(|k| ExprId(k as u32)).find(|&x| self.is_node_input(x, name))
    }

    /// What is kept of a node between the loops, in the order of the loops.
    pub(crate) fn kept(&self) -> Vec<ExprId> {
        let mut seen = rustc_hash::FxHashSet::default();
        let stores = self.phases.iter().flat_map(|phase| phase.nodes.stores.clone());
        stores.filter(|x| seen.insert(*x)).collect()
    }
}
