//! The sheet that formulas are written on.

use std::borrow::Borrow;
use std::cell::{Ref, RefCell};

use super::small::{MOST_BY_CRAMER, solve};
use super::{AXES, Expr, Vec3, Vector, ids};
use crate::graph::{ExprId, Graph, Iteration, Op, RootFigure, RootId, Scope, SymbolId};

/// A graph while formulas are written into it.
///
/// ```
/// use diffuse_contact_codegen::expr::{Mat3, Sheet};
/// use diffuse_contact_codegen::graph::Scope;
/// use diffuse_contact_codegen::interpret::{Interpreter, NodeInputs};
///
/// // The energy density of a compressible neo-Hooke material, and a component of its stress.
/// let sheet = Sheet::new();
/// let [lambda, mu] = ["lambda", "mu"].map(|name| sheet.input(name, Scope::Element));
/// let F = Mat3::from_fn(|i, j| sheet.input(&format!("F_{i}{j}"), Scope::Element));
/// let J = F.determinant().named("J");
/// let psi = 0.5 * mu * (F.double_dot(F) - 3.0 - 2.0 * J.ln()) + 0.5 * lambda * J.ln().powi(2);
/// let p_00 = psi.by(F[0][0]).id();
///
/// let mut inputs = NodeInputs::new(0);
/// for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
///     inputs.set_element(&format!("F_{i}{j}"), if i == j { 2.0 } else { 0.0 });
/// }
/// inputs.set_element("lambda", 1.0);
/// inputs.set_element("mu", 1.0);
/// let graph = sheet.into_graph();
/// let stress = Interpreter::new(&graph, &inputs).element(p_00);
/// assert!((stress - (1.5 + 0.5 * 8_f64.ln())).abs() < 1e-15);
/// ```
#[derive(Debug, Default)]
pub struct Sheet(RefCell<Graph>);

impl Graph {
    /// Lets formulas be written into this graph. What is returned refers to it by ids.
    pub fn write<R>(&mut self, formulas: impl FnOnce(&Sheet) -> R) -> R {
        let sheet = Sheet(RefCell::new(std::mem::take(self)));
        let result = formulas(&sheet);
        *self = sheet.into_graph();
        result
    }
}

impl Sheet {
    /// An empty sheet.
    pub fn new() -> Self {
        Self::default()
    }

    /// The graph with all that was written.
    pub fn into_graph(self) -> Graph {
        self.0.into_inner()
    }

    /// The graph, to look something up. Nothing can be written while it is looked at.
    pub fn graph(&self) -> Ref<'_, Graph> {
        self.0.borrow()
    }

    /// What the engine does with the graph itself.
    pub(crate) fn edit<R>(&self, change: impl FnOnce(&mut Graph) -> R) -> R {
        change(&mut self.0.borrow_mut())
    }

    /// The expression that the engine makes.
    pub(crate) fn make(&self, make: impl FnOnce(&mut Graph) -> ExprId) -> Expr<'_> {
        self.expr(self.edit(make))
    }

    /// The expression with this id.
    pub const fn expr(&self, id: ExprId) -> Expr<'_> {
        Expr { sheet: self, id }
    }

    /// The expressions with these ids.
    pub fn exprs<I: Borrow<ExprId>>(&self, ids: impl IntoIterator<Item = I>) -> Vec<Expr<'_>> {
        ids.into_iter().map(|id| self.expr(*id.borrow())).collect()
    }

    /// A new input.
    pub fn input(&self, name: &str, scope: Scope) -> Expr<'_> {
        self.make(|g| g.input(name, scope))
    }

    /// The input of this name, a new one where there is none.
    pub(crate) fn input_once(&self, name: &str, scope: Scope) -> Expr<'_> {
        self.make(|g| g.input_once(name, scope))
    }

    /// New inputs `name_x`, `name_y`, `name_z`: a vector in global axes.
    pub fn vector(&self, name: &str, scope: Scope) -> Vec3<'_> {
        Vector(AXES.map(|axis| self.input(&format!("{name}_{axis}"), scope)))
    }

    /// A new free variable, see [`Graph::variable`].
    pub fn variable(&self, name: &str) -> Expr<'_> {
        self.make(|g| g.variable(name))
    }

    /// The expression of a symbol.
    pub fn symbol(&self, symbol: SymbolId) -> Expr<'_> {
        self.make(|g| g.intern(Op::Symbol(symbol)))
    }

    /// New free variables.
    pub fn variables<const N: usize>(&self, names: [&str; N]) -> Vector<'_, N> {
        Vector(names.map(|name| self.variable(name)))
    }

    /// A number.
    pub fn number(&self, value: f64) -> Expr<'_> {
        self.make(|g| g.constant(value))
    }

    /// 0
    pub fn zero(&self) -> Expr<'_> {
        self.number(0.0)
    }

    /// 1
    pub fn one(&self) -> Expr<'_> {
        self.number(1.0)
    }

    /// Adds a small system of equations, see [`Graph::add_root`]; returns its unknowns at the root.
    pub fn root<'g, const N: usize>(
        &'g self,
        name: &str,
        unknowns: Vector<'g, N>,
        residuals: Vector<'g, N>,
    ) -> (RootId, Vector<'g, N>) {
        self.root_by(Iteration::Newton, name, unknowns, residuals)
    }

    /// The same by a chosen iteration.
    pub fn root_by<'g, const N: usize>(
        &'g self,
        iteration: Iteration,
        name: &str,
        unknowns: Vector<'g, N>,
        residuals: Vector<'g, N>,
    ) -> (RootId, Vector<'g, N>) {
        let residuals = residuals.0.map(Expr::id).to_vec();
        let (root, values) = self.edit(|g| g.add_root(name, &unknowns.0.map(Expr::id), residuals, iteration));
        (root, Vector::from_fn(|k| self.expr(values[k])))
    }

    /// A⁻¹ b: of up to three unknowns by Cramer's rule, of more with a search for pivots in the kernel.
    pub(crate) fn solve_general<'g>(
        &'g self,
        name: &str,
        matrix: &[Vec<Expr<'g>>],
        right_hand_side: &[Expr<'g>],
    ) -> Vec<Expr<'g>> {
        if matrix.len() <= MOST_BY_CRAMER {
            return solve(matrix, right_hand_side);
        }
        let rows: Vec<Vec<ExprId>> = matrix.iter().map(|row| ids(row)).collect();
        self.exprs(self.edit(|g| g.solve_general(name, &rows, &ids(right_hand_side)).1))
    }

    /// The inverse of a matrix of the element, by rows: a column at a time, each as by [`solve_general`](Self::solve_general).
    pub(crate) fn inverse_general<'g>(&'g self, name: &str, matrix: &[Vec<Expr<'g>>]) -> Vec<Vec<Expr<'g>>> {
        let size = matrix.len();
        let unit = |k: usize| (0..size).map(move |row| if row == k { self.one() } else { self.zero() });
        let columns: Vec<Vec<Expr<'g>>> =
            (0..size).map(|k| self.solve_general(name, matrix, &unit(k).collect::<Vec<_>>())).collect();
        (0..size).map(|row| columns.iter().map(|column| column[row]).collect()).collect()
    }

    /// A figure of a root's iteration.
    pub fn root_figure(&self, root: RootId, figure: RootFigure) -> Expr<'_> {
        self.make(|g| g.root_figure(root, figure))
    }
}
