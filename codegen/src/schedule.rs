//! Turns a lowered kernel into a program: straight-line segments and loops over nodes.
//!
//! An expression of element scope can be computed once all sums it needs are known. Its *level* counts the loops
//! over nodes that have to run before. A program is: for every level, a straight-line segment, then one loop over
//! the nodes. Hessians leave it as rows of low rank; their products are not part of the program. Node values that a
//! later loop needs are stored with the node; what is not needed is not computed.

mod layout;
mod reads;

pub(crate) use reads::Solved;

use rustc_hash::{FxHashMap, FxHashSet};

use crate::graph::{ExprId, Graph, Op, RootId, Scope};
use crate::kernel::Kernel;
use crate::model::KernelSpec;
use crate::structure::{LowRankForm, LowRankTerm, PointForm};

/// Deepest nesting of an expression that is written without an intermediate `let`.
const MOST_DEPTH: usize = 14;

/// What results of node scope are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // The names say what the fields are.
pub enum NodeTarget {
    /// A node's part of a gradient, x, y and z.
    Gradient { gradient: usize },
    /// A node's part of a row of a Hessian's form, x, y and z.
    Row { hessian: usize, row: usize },
    /// A node's own block of a Hessian's form, lower triangle.
    Own { hessian: usize },
    /// A number of the node.
    Value { value: usize },
}

/// The rows of a Hessian's form in the order in which they are multiplied: b and c of each term.
#[derive(Clone, Debug, Default)]
pub struct FormRows {
    /// Those of a node.
    pub rows: Vec<[ExprId; 3]>,
    /// The part of a point: its rows c, those of b being zero, and the lower triangle of its own block.
    pub point: Option<(Vec<[ExprId; 3]>, [ExprId; 6])>,
}

impl FormRows {
    fn new(graph: &Graph, form: &LowRankForm) -> Self {
        let point = form.point.as_ref().map(|PointForm { own, c }| {
            let [xx, yx, yy, zx, zy, zz] =
                [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)].map(|(i, j): (usize, usize)| own[i][j]);
            (c.clone(), [xx, yx, yy, zx, zy, zz])
        });
        // Nodes that fill up a vector have rows of zeros, which rows that are the same for all nodes would not be.
        let is_same =
            |term: &LowRankTerm| term.b.iter().chain(&term.c).all(|&x| graph.scope(x) == Scope::Element);
        assert!(form.point.is_some() || !form.terms.iter().any(is_same), "rows are the same for all nodes");
        let rows = form.terms.iter().flat_map(|term| [term.b, term.c]).collect();
        Self { rows, point }
    }

    /// Whether this form has the rows b of another one, and a point besides.
    pub fn extends(&self, other: &Self) -> bool {
        let b = |form: &Self| -> Vec<[ExprId; 3]> { form.rows.iter().step_by(2).copied().collect() };
        self.point.is_some() && other.point.is_none() && b(self) == b(other)
    }
}

/// One statement of a straight-line piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Statement {
    /// `let` the expression's name be its value.
    Let(ExprId),
    /// Solve a root's equations.
    Solve(RootId),
}

/// A loop over the nodes.
#[derive(Clone, Debug, Default)]
pub struct NodeLoop {
    /// Stored values of earlier loops that are read.
    pub loads: Vec<ExprId>,
    /// The body.
    pub statements: Vec<Statement>,
    /// Sums accumulated: [`Op::Sum`] expressions.
    pub sums: Vec<ExprId>,
    /// Values stored with the node.
    pub stores: Vec<ExprId>,
    /// Results written.
    pub outputs: Vec<(NodeTarget, Vec<ExprId>)>,
}

impl NodeLoop {
    /// Whether nothing comes of it.
    pub(crate) fn is_empty(&self) -> bool {
        self.sums.is_empty() && self.stores.is_empty() && self.outputs.is_empty()
    }
}

/// One straight-line segment and the loop after it.
#[derive(Clone, Debug, Default)]
pub struct Phase {
    /// Element values.
    pub statements: Vec<Statement>,
    /// The loop over nodes that follows.
    pub nodes: NodeLoop,
}

/// How the expressions of one piece of code are written.
#[derive(Clone, Debug, Default)]
pub struct Layout {
    /// Expressions that have a name in the emitted code; all others are written where they are used.
    pub bound: FxHashSet<ExprId>,
    /// For an addition, the operand whose product is fused with it.
    pub fused: FxHashMap<ExprId, ExprId>,
}

/// A scheduled kernel.
#[derive(Clone, Debug)]
pub struct Program<S = KernelSpec> {
    /// The lowered kernel.
    pub kernel: Kernel<S>,
    /// Segments and node loops in order.
    pub phases: Vec<Phase>,
    /// Rows of the Hessians' forms.
    pub forms: Vec<FormRows>,
    /// Coefficients of the kernel's combinations for the terms in the order of the rows, and what is computed for them only: a segment of
    /// its own.
    pub combinations: (Vec<Statement>, Vec<Vec<ExprId>>),
    /// Bodies of the roots' equations: statements for residuals and Jacobian.
    pub roots: FxHashMap<RootId, Vec<Statement>>,
    /// How expressions are written.
    pub layout: Layout,
}

impl<S: Clone> Program<S> {
    /// Schedules a lowered kernel.
    pub fn new(kernel: Kernel<S>) -> Self {
        Scheduler::new(&kernel).run()
    }

    /// Whether the Hessians are two, of which the second's form [extends](FormRows::extends) the first's.
    pub fn has_pair(&self) -> bool {
        matches!(&self.forms[..], [first, second] if second.extends(first))
    }
}

struct Scheduler<'a, S> {
    kernel: &'a Kernel<S>,
    graph: &'a Graph,
    forms: Vec<FormRows>,
    levels: FxHashMap<ExprId, usize>,
    /// Everything the results depend on, operands first.
    reachable: Vec<ExprId>,
}

impl<'a, S: Clone> Scheduler<'a, S> {
    fn new(kernel: &'a Kernel<S>) -> Self {
        let graph = &kernel.graph;
        let forms = kernel.hessians.iter().map(|(_, hessian)| FormRows::new(graph, hessian)).collect();
        let mut scheduler =
            Self { kernel, graph, forms, levels: FxHashMap::default(), reachable: Vec::new() };
        let mut seen = FxHashSet::default();
        for root in scheduler.results() {
            scheduler.reach(root, &mut seen);
        }
        for k in 0..scheduler.reachable.len() {
            let expr = scheduler.reachable[k];
            let level =
                scheduler.graph.dependencies(expr).iter().map(|x| scheduler.levels[x]).max().unwrap_or(0);
            let after_loop = usize::from(matches!(scheduler.graph.op(expr), Op::Sum(_)));
            scheduler.levels.insert(expr, level + after_loop);
        }
        scheduler
    }

    fn element_results(&self) -> Vec<ExprId> {
        let mut all: Vec<ExprId> = self.kernel.values.iter().flat_map(|v| v.components.clone()).collect();
        for (_, gradient) in &self.kernel.gradients {
            all.extend(gradient.slave.into_iter().chain(gradient.point.into_iter().flatten()));
        }
        for form in &self.forms {
            if let Some((rows, own)) = &form.point {
                all.extend(rows.iter().flatten().chain(own));
            }
        }
        all
    }

    fn node_results(&self) -> Vec<(NodeTarget, Vec<ExprId>)> {
        let mut all = Vec::new();
        for (gradient, (_, data)) in self.kernel.gradients.iter().enumerate() {
            all.push((NodeTarget::Gradient { gradient }, data.node.to_vec()));
        }
        for (hessian, ((_, data), form)) in self.kernel.hessians.iter().zip(&self.forms).enumerate() {
            for (row, node) in form.rows.iter().enumerate() {
                all.push((NodeTarget::Row { hessian, row }, node.to_vec()));
            }
            let own = (0..3).flat_map(|row| data.own[row][..=row].to_vec());
            all.push((NodeTarget::Own { hessian }, own.collect()));
        }
        for (value, &(_, x)) in self.kernel.node_values.iter().enumerate() {
            all.push((NodeTarget::Value { value }, vec![x]));
        }
        all
    }

    fn results(&self) -> Vec<ExprId> {
        let mut all = self.element_results();
        all.extend(self.node_results().into_iter().flat_map(|(_, x)| x));
        all
    }

    fn reach(&mut self, expr: ExprId, seen: &mut FxHashSet<ExprId>) {
        if !seen.insert(expr) {
            return;
        }
        for operand in self.graph.dependencies(expr) {
            self.reach(operand, seen);
        }
        self.reachable.push(expr);
    }

    fn run(self) -> Program<S> {
        let last = self.levels.values().copied().max().unwrap_or(0);
        let mut phases: Vec<Phase> = (0..=last).map(|_| Phase::default()).collect();
        let mut layout = Layout::default();

        self.schedule_nodes(&mut phases, &mut layout);
        let combinations = self.combinations();
        let of_combinations = self.only_of_combinations(&combinations);
        let roots = self.schedule_elements(&mut phases, (&combinations, &of_combinations), &mut layout);
        let results = combinations.concat();
        let own = self.lay_out(&of_combinations, &results, &FxHashSet::default(), &mut layout);
        let combinations = (own, combinations);
        while phases.last().is_some_and(|p| p.statements.is_empty() && p.nodes.is_empty()) {
            phases.pop();
        }
        Program { kernel: self.kernel.clone(), phases, forms: self.forms, combinations, roots, layout }
    }

    /// Coefficients of the combinations.
    fn combinations(&self) -> Vec<Vec<ExprId>> {
        self.kernel.combinations.iter().map(|(_, all)| all.clone()).collect()
    }

    /// What is needed for combinations only, operands first.
    fn only_of_combinations(&self, combinations: &[Vec<ExprId>]) -> Vec<ExprId> {
        let of_results: FxHashSet<ExprId> = self.reachable.iter().copied().collect();
        let members = self.members(&combinations.concat(), |x| !of_results.contains(&x));
        for &x in &members {
            let is_straight =
                !matches!(self.graph.op(x), Op::Sum(_) | Op::RootValue(..) | Op::RootFigure(..));
            assert!(
                is_straight && self.graph.scope(x) == Scope::Element,
                "a combination needs a loop or a root of its own"
            );
        }
        members
    }

    fn schedule_nodes(&self, phases: &mut [Phase], layout: &mut Layout) {
        let mut computed_in: FxHashMap<ExprId, usize> = FxHashMap::default();
        let mut stores: Vec<FxHashSet<ExprId>> = vec![FxHashSet::default(); phases.len()];
        let mut loop_members: Vec<(Vec<ExprId>, Vec<ExprId>)> = Vec::new();
        for (level, phase) in phases.iter_mut().enumerate() {
            let at_level = |x: &ExprId| self.levels[x] == level;
            let nodes = &mut phase.nodes;
            nodes.sums = self
                .reachable
                .iter()
                .filter(|&&x| matches!(self.graph.op(x), Op::Sum(body) if at_level(&body)))
                .copied()
                .collect();
            // All components at once.
            let outputs = self.node_results().into_iter();
            nodes.outputs = outputs
                .filter(|(_, values)| values.iter().map(|x| self.levels[x]).max() == Some(level))
                .collect();
            let mut roots: Vec<ExprId> = nodes.sums.iter().map(|&sum| self.graph.operands(sum)[0]).collect();
            let is_node = |x: &ExprId| self.graph.scope(*x) == Scope::Node;
            roots.extend(nodes.outputs.iter().flat_map(|(_, values)| values).copied().filter(is_node));

            let mut loads = Vec::new();
            let members = {
                let computed_in = &computed_in;
                let graph = self.graph;
                // An earlier loop's value is loaded, unless it is an input or just a changed sign.
                let is_loaded = |x: ExprId| {
                    computed_in.contains_key(&x) && !matches!(graph.op(x), Op::Symbol(_) | Op::Neg(_))
                };
                let members = self.members(&roots, |x| graph.scope(x) == Scope::Node && !is_loaded(x));
                let operands = members.iter().flat_map(|&x| graph.operands(x)).chain(roots.iter().copied());
                for x in operands {
                    if graph.scope(x) == Scope::Node && is_loaded(x) && !loads.contains(&x) {
                        loads.push(x);
                    }
                }
                members
            };
            for &load in &loads {
                stores[computed_in[&load]].insert(load);
            }
            for &x in &members {
                computed_in.entry(x).or_insert(level);
            }
            nodes.loads = loads;
            loop_members.push((members, roots));
        }
        for (level, phase) in phases.iter_mut().enumerate() {
            let nodes = &mut phase.nodes;
            let (members, roots) = &loop_members[level];
            nodes.stores = members.iter().filter(|x| stores[level].contains(x)).copied().collect();
            nodes.statements = self.lay_out(members, roots, &stores[level], layout);
            layout.bound.extend(nodes.loads.iter().copied());
        }
    }

    fn schedule_elements(
        &self,
        phases: &mut [Phase],
        (combinations, of_combinations): (&[Vec<ExprId>], &[ExprId]),
        layout: &mut Layout,
    ) -> FxHashMap<RootId, Vec<Statement>> {
        let is_element = |x: ExprId| self.graph.scope(x) == Scope::Element;
        let mut members: Vec<Vec<ExprId>> = vec![Vec::new(); phases.len()];
        for &x in self.reachable.iter().filter(|&&x| is_element(x)) {
            members[self.levels[&x]].push(x);
        }
        // What another piece of code uses needs a name.
        let mut external: FxHashSet<ExprId> = FxHashSet::default();
        let node_results = self.node_results().into_iter().flat_map(|(_, values)| values);
        external.extend(node_results.filter(|&x| is_element(x)).map(|x| self.graph.without_sign(x)));
        for &x in &self.reachable {
            for operand in self.graph.dependencies(x) {
                let other_piece = !is_element(x)
                    || matches!(self.graph.op(x), Op::RootValue(..) | Op::RootFigure(..))
                    || self.levels[&operand] != self.levels[&x];
                if is_element(operand) && other_piece {
                    // A changed sign is written where it is used.
                    external.insert(self.graph.without_sign(operand));
                }
            }
        }
        let own: FxHashSet<ExprId> = of_combinations.iter().copied().collect();
        let of_own = of_combinations.iter().flat_map(|&x| self.graph.operands(x));
        let used = of_own.chain(combinations.concat()).filter(|x| !own.contains(x));
        external.extend(used.map(|x| self.graph.without_sign(x)));
        let mut roots = FxHashMap::default();
        let results = self.element_results();
        for (phase, members) in phases.iter_mut().zip(&members) {
            phase.statements = self.lay_out(members, &results, &external, layout);
        }
        for &x in &self.reachable {
            let (Op::RootValue(root, _) | Op::RootFigure(root, _)) = self.graph.op(x) else { continue };
            if roots.contains_key(&root) {
                continue;
            }
            let data = self.graph.root(root);
            let parameters: FxHashSet<ExprId> =
                self.graph.dependencies_of_root(root).iter().copied().collect();
            let results: Vec<ExprId> =
                data.residuals.iter().chain(data.jacobian.iter().flatten()).copied().collect();
            // Values computed outside stay names here too.
            let inner = self.members(&results, |x| !parameters.contains(&x) && !layout.bound.contains(&x));
            let statements = self.lay_out(&inner, &results, &FxHashSet::default(), layout);
            roots.insert(root, statements);
        }
        roots
    }

    /// Expressions reachable from `roots` through members, operands first.
    fn members(&self, roots: &[ExprId], is_member: impl Fn(ExprId) -> bool) -> Vec<ExprId> {
        let mut seen = FxHashSet::default();
        let mut order = Vec::new();
        for &root in roots {
            self.visit(root, &is_member, &mut seen, &mut order);
        }
        order
    }

    fn visit(
        &self,
        expr: ExprId,
        is_member: &impl Fn(ExprId) -> bool,
        seen: &mut FxHashSet<ExprId>,
        order: &mut Vec<ExprId>,
    ) {
        if !is_member(expr) || !seen.insert(expr) {
            return;
        }
        // The operand made last first: its operands die soonest, which keeps live ranges short.
        let mut operands = self.graph.operands(expr);
        if matches!(self.graph.op(expr), Op::Sum(_)) {
            operands.clear();
        }
        operands.sort_unstable_by(|x, y| y.cmp(x));
        for operand in operands {
            self.visit(operand, is_member, seen, order);
        }
        order.push(expr);
    }
}
