//! An element of the caller's, from formulas: inputs, quantities, outputs.

use std::cell::{Cell, RefCell};

pub use super::element_error::ElementError;
pub use super::element_outputs::{Defined, ElementKernels, ElementSpec, NodeResult};
use super::element_outputs::{Finished, Outputs};
use super::signature::{Differentiated, Input, Points, Quantity, Returned, Role, Signature};
use crate::expr::{Expr, Matrix, Sheet, Vector, total};
use crate::graph::{ExprId, Iteration, Limits, Op, RootFigure, Scope, SymmetricSystem};
use crate::structure::{Implicit, Jacobian, contains_sum};

/// Name of the value that [`ElementModel::energy`] states.
const ENERGY: &str = "energy";

/// Name of the field with the nodes.
const NODES: &str = "nodes";

/// The sheet that an element's formulas are written on, with its inputs and outputs.
///
/// Mistakes are kept until the end, where the first of them is the error.
pub struct ElementModel<'g> {
    sheet: &'g Sheet,
    doc: RefCell<String>,
    inputs: RefCell<Vec<Input>>,
    /// Inputs of which each node has its own.
    nodes: RefCell<Vec<Input>>,
    /// Sums over the nodes, and the symbols that stand for them.
    sums: RefCell<Vec<(ExprId, ExprId)>>,
    /// Unknowns of equations that depend on the nodes.
    implicit: RefCell<Vec<Implicit<'g>>>,
    outputs: RefCell<Vec<(Returned, Vec<Expr<'g>>)>>,
    quantities: RefCell<Vec<Defined>>,
    points: RefCell<Points>,
    /// Whether products are wanted.
    product: Cell<bool>,
    /// Unknowns whose values are known, the first of them.
    known: RefCell<Option<String>>,
    error: RefCell<Option<ElementError>>,
}

/// Where equations are solved, see [`ElementModel::root`], [`ElementModel::root_from`], [`ElementModel::minimum`],
/// [`ElementModel::stationary_from`] and [`ElementModel::solve`].
#[derive(Clone, Copy, Debug)]
pub struct Root<'g, const N: usize> {
    /// The unknowns.
    pub unknowns: Vector<'g, N>,
    /// Largest residual relative to the starting one or to the unknowns, whichever is larger; below 10⁻¹², or there is no root near
    /// the start.
    pub residual: Expr<'g>,
    /// Evaluations of the equations.
    pub iterations: Expr<'g>,
}

/// Where a quadratic function is stationary, see [`ElementModel::stationary`].
#[derive(Clone, Copy, Debug)]
pub struct Stationary<'g, const N: usize> {
    /// The unknowns.
    pub unknowns: Vector<'g, N>,
    /// Smallest pivot of the function's second derivative relative to its diagonal: 0 where there is no single such place.
    pub pivot_ratio: Expr<'g>,
}

impl<'g> ElementModel<'g> {
    pub(super) const fn new(sheet: &'g Sheet) -> Self {
        Self {
            sheet,
            doc: RefCell::new(String::new()),
            inputs: RefCell::new(Vec::new()),
            nodes: RefCell::new(Vec::new()),
            sums: RefCell::new(Vec::new()),
            implicit: RefCell::new(Vec::new()),
            outputs: RefCell::new(Vec::new()),
            quantities: RefCell::new(Vec::new()),
            points: RefCell::new(Points { symbols: Vec::new(), rows: Vec::new() }),
            product: Cell::new(false),
            known: RefCell::new(None),
            error: RefCell::new(None),
        }
    }

    /// The sheet, for numbers and roots.
    #[must_use]
    pub const fn sheet(&self) -> &'g Sheet {
        self.sheet
    }

    /// What the element is, in one line: the first line of its documentation.
    pub fn title(&self, text: &str) {
        text.clone_into(&mut self.doc.borrow_mut());
    }

    /// An input that derivatives are taken by, such as `[Vec3; 4]`: the positions of four nodes. Variables are numbered in the
    /// order of their declaration, the last dimension fastest.
    #[must_use]
    pub fn variable<Q: Quantity<'g>>(&self, name: &str) -> Q {
        self.input(name, Role::Variable)
    }

    /// An input of which each node has its own and that derivatives are taken by, such as a position. The number of nodes is open
    /// until a kernel runs. What is made of it is a value of a node; [`Expr::sum`] leads back to the element. Variables of nodes are
    /// numbered after those of the element, node by node.
    #[must_use]
    pub fn node_variable<Q: Quantity<'g>>(&self, name: &str) -> Q {
        self.node_input(name, Role::Variable)
    }

    /// An input of which each node has its own and that derivatives are not taken by, such as a radius.
    #[must_use]
    pub fn node_parameter<Q: Quantity<'g>>(&self, name: &str) -> Q {
        self.node_input(name, Role::Parameter)
    }

    /// An input that derivatives are not taken by: a material constant, reference positions, a state before.
    #[must_use]
    pub fn parameter<Q: Quantity<'g>>(&self, name: &str) -> Q {
        self.input(name, Role::Parameter)
    }

    /// Several numbers that derivatives are not taken by.
    #[must_use]
    pub fn parameters<const N: usize>(&self, names: [&str; N]) -> [Expr<'g>; N] {
        names.map(|name| self.parameter(name))
    }

    /// Numbers at quadrature points, such as `Vec3` for natural coordinates: at each point those of a row. All outputs are then sums
    /// over the points, in a loop that stays one in the code. Several tables have as many rows.
    #[must_use]
    pub fn points<Q: Quantity<'g>>(&self, name: &str, rows: &[impl AsRef<[f64]>]) -> Q {
        let (quantity, symbols) = self.declared::<Q>(name, Scope::Element);
        let mut points = self.points.borrow_mut();
        if points.symbols.is_empty() {
            points.rows = vec![Vec::new(); rows.len()];
        }
        let is_whole = rows.iter().all(|row| row.as_ref().len() == symbols.len());
        if rows.is_empty() || points.rows.len() != rows.len() || !is_whole {
            self.fail(ElementError::Points { name: name.to_owned() });
        }
        points.symbols.extend(symbols);
        points.rows.iter_mut().zip(rows).for_each(|(all, row)| all.extend(row.as_ref()));
        quantity
    }

    /// Documents an input, a quantity or an output: meaning, formula, unit, in one line.
    pub fn describe(&self, name: &str, text: &str) {
        let (mut inputs, mut nodes) = (self.inputs.borrow_mut(), self.nodes.borrow_mut());
        if let Some(input) = inputs.iter_mut().chain(nodes.iter_mut()).find(|input| input.name == name) {
            text.clone_into(&mut input.doc);
        } else if let Some((value, _)) =
            self.outputs.borrow_mut().iter_mut().find(|(value, _)| value.name == name)
        {
            text.clone_into(&mut value.doc);
        } else if let Some(quantity) =
            self.quantities.borrow_mut().iter_mut().find(|quantity| quantity.name == name)
        {
            text.clone_into(&mut quantity.doc);
        } else {
            self.fail(ElementError::Unknown { name: name.to_owned() });
        }
    }

    /// An intermediate quantity, such as a deformation gradient: its name appears in the code, and derivatives go through it by the
    /// chain rule. Values are the same without; operations may be fewer with it. A quantity of a node gets its name only.
    #[must_use]
    pub fn define<Q: Quantity<'g>>(&self, name: &str, quantity: Q) -> Q {
        self.check_name(name);
        self.quantities.borrow_mut().push(Defined { name: name.to_owned(), doc: String::new() });
        quantity.changed(name, &mut |entry, x| {
            let x = self.with_bound_terms(x);
            if x.value().is_some() {
                return x;
            }
            if x.scope() == Scope::Node {
                return x.named(entry);
            }
            self.check_symbol(entry);
            let symbol = self.sheet.make(|g| g.bind_unique(entry, x.id()));
            if matches!(x.operation(), Op::Sum(_)) {
                self.sums.borrow_mut().push((x.id(), symbol.id()));
            }
            symbol
        })
    }

    /// A quantity that is held while derivatives are taken: it has its value, and changes with nothing. A length that others are divided
    /// by is one where it cancels; so is the place an iteration has found, where [`stationary_at`](Self::stationary_at) says how it
    /// moves.
    #[must_use]
    pub fn held<Q: Quantity<'g>>(&self, name: &str, quantity: Q) -> Q {
        self.check_name(name);
        quantity.changed(name, &mut |entry, x| {
            if x.value().is_some() {
                return x;
            }
            self.check_symbol(entry);
            self.sheet.make(|g| g.bind_held(entry, x.id()))
        })
    }

    /// Unknowns u, one to eight, that have known values, such as the foot of a distance, and in which the function is stationary that
    /// derivatives are taken of: it does not change to first order while u follows the equations r(u) = 0, which hold at the values.
    /// Its gradient is then that at fixed u, and its Hessian needs du/dx = −r_u⁻¹ r_x only. Values are held. Equations may contain unknowns
    /// that were made before.
    ///
    /// Nothing checks the claims but a test: `Config::test` compares with automatic differentiation, which moves u by the equations.
    #[must_use]
    pub fn stationary_at<const N: usize>(
        &self,
        name: &str,
        values: Vector<'g, N>,
        equations: impl FnOnce(Vector<'g, N>) -> Vector<'g, N>,
    ) -> Vector<'g, N> {
        self.check_name(name);
        if N == 0 || N > Iteration::MOST_EQUATIONS {
            self.fail(ElementError::Root { root: name.to_owned(), equations: N });
            return values;
        }
        self.known.borrow_mut().get_or_insert_with(|| name.to_owned());
        let values = self.held(&format!("{name}_value"), values);
        let unknowns = self.unknowns(name);
        let equations = equations(unknowns);
        let (_, at) = self
            .sheet
            .edit(|g| g.add_known_root(name, &unknowns.ids(), equations.ids().to_vec(), &values.ids()));
        self.define(name, Vector::from_fn(|k| self.sheet.expr(at[k])))
    }

    /// Unknowns at the root of as many equations r(u) = 0, one to eight, such as the natural coordinates of a foot point: by a damped
    /// Newton iteration from u = 0, with steps of at most ½. Derivatives are those of the implicit function theorem.
    ///
    /// Whoever uses the kernels has to know whether there is a root: state [`Root::residual`] as a value.
    #[must_use]
    pub fn root<const N: usize>(
        &self,
        name: &str,
        equations: impl FnOnce(Vector<'g, N>) -> Vector<'g, N>,
    ) -> Root<'g, N> {
        let iteration = if N == 2 { Iteration::Newton } else { Iteration::Within(Limits::default()) };
        self.root_by(iteration, name, equations)
    }

    /// The same from a start, within chosen limits: for unknowns that are not of order one, such as those of a state before.
    #[must_use]
    pub fn root_from<const N: usize>(
        &self,
        name: &str,
        start: Vector<'g, N>,
        limits: Limits,
        equations: impl FnOnce(Vector<'g, N>) -> Vector<'g, N>,
    ) -> Root<'g, N> {
        // The iteration starts at zero: it finds the way from the start.
        let way = self.root_by(Iteration::Within(limits), &format!("{name}_way"), |way| {
            equations(Vector::from_fn(|k| start[k] + way[k]))
        });
        let unknowns = self.define(name, Vector::from_fn(|k| start[k] + way.unknowns[k]));
        Root { unknowns, ..way }
    }

    /// Unknowns, one to eight, at which any smooth function is stationary, by a damped Newton iteration from a start that is near. What
    /// is quadratic has [`stationary`](Self::stationary).
    #[must_use]
    pub fn stationary_from<const N: usize>(
        &self,
        name: &str,
        start: Vector<'g, N>,
        limits: Limits,
        function: impl FnOnce(Vector<'g, N>) -> Expr<'g>,
    ) -> Root<'g, N> {
        let way = self.root_by(Iteration::Within(limits), &format!("{name}_way"), |way| {
            let function = function(Vector::from_fn(|k| start[k] + way[k]));
            let function = self.with_bound_sums(function, &way.0);
            way.map(|u| function.by(u))
        });
        let unknowns = self.define(name, Vector::from_fn(|k| start[k] + way.unknowns[k]));
        Root { unknowns, ..way }
    }

    /// Unknowns u of linear equations A u = b, one to eight, without symmetry. Pivots are searched for in the kernel, in each lane by
    /// itself. [`Root::residual`] stays above 10⁻¹² where A is singular.
    #[must_use]
    pub fn solve<const N: usize>(
        &self,
        name: &str,
        matrix: Matrix<'g, N, N>,
        right_hand_side: Vector<'g, N>,
    ) -> Root<'g, N> {
        self.root_by(Iteration::Within(Limits::LINEAR), name, |u| {
            Vector::from_fn(|i| total((0..N).map(|j| matrix[i][j] * u[j])) - right_hand_side[i])
        })
    }

    /// Unknowns at a minimum of a function, such as half a squared distance: from u = 0 by steps down to it, Newton's where the function
    /// is convex, each of at most ½ and half of the way already made. [`Root::residual`] is that of the function's derivatives.
    #[must_use]
    pub fn minimum<const N: usize>(
        &self,
        name: &str,
        function: impl FnOnce(Vector<'g, N>) -> Expr<'g>,
    ) -> Root<'g, N> {
        self.root_by(Iteration::Descent, name, |unknowns| {
            let function = self.with_bound_sums(function(unknowns), &unknowns.0);
            unknowns.map(|u| -function.by(u))
        })
    }

    fn root_by<const N: usize>(
        &self,
        iteration: Iteration,
        name: &str,
        equations: impl FnOnce(Vector<'g, N>) -> Vector<'g, N>,
    ) -> Root<'g, N> {
        self.check_name(name);
        if !iteration.takes(N) {
            self.fail(ElementError::Root { root: name.to_owned(), equations: N });
            let zero = self.sheet.zero();
            return Root { unknowns: Vector::zero(self.sheet), residual: zero, iterations: zero };
        }
        let unknowns = self.unknowns(name);
        let equations = equations(unknowns).map(|equation| self.with_bound_sums(equation, &unknowns.0));
        if equations.iter().any(|&equation| contains_sum(equation)) {
            self.fail(ElementError::RootInSum { root: name.to_owned() });
        }
        let (root, values) = self.sheet.root_by(iteration, name, unknowns, equations);
        let values = self.define(name, values);
        if self.has_nodes() {
            let at = unknowns.set_to(values);
            let equations = equations.at(&at);
            let jacobian: Vec<Vec<Expr<'g>>> =
                equations.iter().map(|r| values.iter().map(|&u| r.by(u)).collect()).collect();
            self.implicit.borrow_mut().push(Implicit {
                unknowns: values.to_vec(),
                equations: equations.to_vec(),
                jacobian: Jacobian::Inverse(
                    self.sheet.inverse_general(&format!("{name}_inverse"), &jacobian),
                ),
            });
        }
        let figure = |figure| self.sheet.root_figure(root, figure);
        Root {
            unknowns: values,
            residual: figure(RootFigure::Residual),
            iterations: figure(RootFigure::Iterations),
        }
    }

    /// Unknowns at which a function is stationary that is quadratic in them, such as the coefficients of a least squares fit: where
    /// ½ Σ w e² is least for errors e that are linear in the coefficients. A function with a value for each node is summed over them. With
    /// multipliers for conditions, linear in the unknowns, it is stationary under these: multipliers come last.
    ///
    /// Derivatives are those of the implicit function theorem, with one row for each unknown however many sums there are in the system.
    #[must_use]
    pub fn stationary<const N: usize>(
        &self,
        name: &str,
        function: impl FnOnce(Vector<'g, N>) -> Expr<'g>,
    ) -> Stationary<'g, N> {
        self.check_name(name);
        let unknowns: Vector<'g, N> = self.unknowns(name);
        let function = function(unknowns);
        let function = if function.scope() == Scope::Node { function.sum() } else { function };
        let function = self.with_bound_sums(function, &unknowns.0);
        let equations = unknowns.map(|u| function.by(u));
        let lower: Vec<Vec<Expr<'g>>> =
            (0..N).map(|i| (0..=i).map(|j| equations[i].by(unknowns[j])).collect()).collect();
        let is_multiplier = |row: &usize| lower[*row][*row].is_zero();
        let is_quadratic = !lower.iter().flatten().any(|x| unknowns.iter().any(|&u| x.contains(u)));
        let (multipliers, others): (Vec<usize>, Vec<usize>) = (0..N).partition(is_multiplier);
        if !is_quadratic || others.is_empty() {
            self.fail(ElementError::NotQuadratic { unknowns: name.to_owned() });
            return Stationary { unknowns: Vector::zero(self.sheet), pivot_ratio: self.sheet.zero() };
        }
        let order = others.into_iter().chain(multipliers.iter().copied()).collect();
        let system = SymmetricSystem::of(&format!("{name}_system"), &lower, order);
        let system = self.sheet.system(system.with_multipliers(multipliers));
        let at_zero = equations.at(&unknowns.set_to(Vector::zero(self.sheet)));
        let solution = system.solve(&at_zero.map(|x| -x).0);
        let values = self.define(name, Vector::from_fn(|k| solution[k]));
        if self.has_nodes() {
            self.implicit.borrow_mut().push(Implicit {
                unknowns: values.to_vec(),
                equations: equations.at(&unknowns.set_to(values)).to_vec(),
                jacobian: Jacobian::Symmetric(system),
            });
        }
        Stationary { unknowns: values, pivot_ratio: system.pivot_ratio() }
    }

    /// Variables for the unknowns of equations.
    fn unknowns<const N: usize>(&self, name: &str) -> Vector<'g, N> {
        Vector::from_fn(|k| self.sheet.variable(&format!("{name}_unknown_{}", k + 1)))
    }

    fn has_nodes(&self) -> bool {
        !self.nodes.borrow().is_empty()
    }

    /// The expression with symbols in the place of the sums over the nodes that contain no unknowns: derivatives go through a sum as
    /// through any quantity.
    fn with_bound_sums(&self, x: Expr<'g>, unknowns: &[Expr<'g>]) -> Expr<'g> {
        if !self.has_nodes() {
            return x;
        }
        let mut x = x;
        loop {
            let sums = innermost_sums(x);
            let free = |sum: &Expr<'g>| !unknowns.iter().any(|&u| sum.contains(u));
            let sums: Vec<Expr<'g>> = sums.into_iter().filter(free).collect();
            if sums.is_empty() {
                return x;
            }
            let replacements: Vec<(ExprId, ExprId)> =
                sums.into_iter().map(|sum| (sum.id(), self.symbol_of_sum(sum))).collect();
            x = self.sheet.make(|g| g.replace(x.id(), &replacements));
        }
    }

    /// The same of what is a sum itself, but for itself.
    fn with_bound_terms(&self, x: Expr<'g>) -> Expr<'g> {
        match x.operation() {
            Op::Sum(term) if self.has_nodes() => {
                let sum = self.with_bound_sums(self.sheet.expr(term), &[]).sum();
                match self.sums.borrow().iter().find(|(known, _)| *known == sum.id()) {
                    Some(&(_, symbol)) => self.sheet.expr(symbol),
                    None => sum,
                }
            }
            _ => self.with_bound_sums(x, &[]),
        }
    }

    fn symbol_of_sum(&self, sum: Expr<'g>) -> ExprId {
        if let Some(&(_, symbol)) = self.sums.borrow().iter().find(|(known, _)| *known == sum.id()) {
            return symbol;
        }
        let name = self.sheet.graph().name_of(sum.id()).map_or_else(|| "total".to_owned(), str::to_owned);
        let symbol = self.sheet.make(|g| g.bind_unique(&name, sum.id())).id();
        self.sums.borrow_mut().push((sum.id(), symbol));
        symbol
    }

    /// States the energy. Gradient and Hessian are those of it, its value is the output `energy`.
    pub fn energy(&self, energy: Expr<'g>) {
        self.function(ENERGY, energy);
    }

    /// States a number of another name that gradient and Hessian are wanted of, in the place of an energy.
    pub fn function(&self, name: &str, function: Expr<'g>) {
        let is_twice =
            |(value, _): &(Returned, _)| value.name != name && value.differentiated == Differentiated::Twice;
        if self.outputs.borrow().iter().any(is_twice) {
            self.fail(ElementError::Duplicate { name: "gradient".to_owned() });
        }
        self.output(name, function, Differentiated::Twice);
    }

    /// States a quantity that the Jacobian is wanted of too, such as forces that have no energy.
    pub fn residual<Q: Quantity<'g>>(&self, name: &str, residual: Q) {
        self.output(name, residual, Differentiated::Once);
    }

    /// States a quantity that no derivatives are wanted of: a stress, a new state.
    pub fn value<Q: Quantity<'g>>(&self, name: &str, value: Q) {
        self.output(name, value, Differentiated::Not);
    }

    /// Asks for products with a vector too: of the energy's Hessian, and of each residual's Jacobian. A kernel of its own has them, in a
    /// few times the operations of the gradient, and never has the matrices. Solvers without matrices need nothing else.
    pub fn product(&self) {
        self.product.set(true);
    }

    fn input<Q: Quantity<'g>>(&self, name: &str, role: Role) -> Q {
        let (quantity, symbols) = self.declared(name, Scope::Element);
        let (name, doc, dimensions) = (name.to_owned(), String::new(), Q::dimensions());
        self.inputs.borrow_mut().push(Input { name, doc, role, dimensions, symbols });
        quantity
    }

    fn node_input<Q: Quantity<'g>>(&self, name: &str, role: Role) -> Q {
        let (quantity, symbols) = self.declared(name, Scope::Node);
        let (name, doc, dimensions) = (name.to_owned(), String::new(), Q::dimensions());
        self.nodes.borrow_mut().push(Input { name, doc, role, dimensions, symbols });
        quantity
    }

    /// A quantity of new symbols, and their names.
    fn declared<Q: Quantity<'g>>(&self, name: &str, scope: Scope) -> (Q, Vec<String>) {
        self.check_name(name);
        let mut symbols = Vec::new();
        let quantity = Q::declare(name, &mut |entry| {
            self.check_symbol(entry);
            let symbol = match scope {
                Scope::Node => self.sheet.input_once(entry, scope),
                _ => self.sheet.variable(entry),
            };
            symbols.push(symbol.symbol_name());
            symbol
        });
        (quantity, symbols)
    }

    fn output<Q: Quantity<'g>>(&self, name: &str, quantity: Q, differentiated: Differentiated) {
        self.check_name(name);
        let mut outputs = self.outputs.borrow_mut();
        let is_derivative = ["gradient", "hessian"].contains(&name) || name.ends_with("_jacobian");
        if is_derivative || outputs.iter().any(|(value, _)| value.name == name) {
            self.fail(ElementError::Duplicate { name: name.to_owned() });
        }
        let (name, doc, dimensions) = (name.to_owned(), String::new(), Q::dimensions());
        let entries = quantity.entries().into_iter().map(|x| self.with_bound_sums(x, &[])).collect();
        outputs.push((Returned { name, doc, dimensions, differentiated }, entries));
    }

    pub(super) fn check_name(&self, name: &str) {
        if syn::parse_str::<proc_macro2::Ident>(name).is_err() {
            self.fail(ElementError::Name { name: name.to_owned() });
        }
    }

    fn check_symbol(&self, name: &str) {
        if self.sheet.graph().has_symbol(name) {
            self.fail(ElementError::Duplicate { name: name.to_owned() });
        }
    }

    /// Keeps the first error.
    fn fail(&self, error: ElementError) {
        self.error.borrow_mut().get_or_insert(error);
    }

    pub(super) fn finish(self, name: &str) -> Result<Finished, ElementError> {
        let (inputs, nodes, outputs) =
            (self.inputs.into_inner(), self.nodes.into_inner(), self.outputs.into_inner());
        if let Some(error) = self.error.into_inner() {
            return Err(error);
        }
        if outputs.is_empty() {
            return Err(ElementError::NoOutput);
        }
        let points = self.points.into_inner();
        if !nodes.is_empty() {
            if let Some(unknowns) = self.known.into_inner() {
                return Err(ElementError::KnownWithNodes { unknowns });
            }
            if !points.rows.is_empty() {
                return Err(ElementError::NodesAndPoints);
            }
            if inputs.iter().any(|input| input.name == NODES) {
                return Err(ElementError::Duplicate { name: NODES.to_owned() });
            }
        }
        let values = outputs.iter().map(|(value, _)| value.clone()).collect();
        let (name, doc) = (name.to_owned(), self.doc.into_inner());
        let signature = Signature { name, doc, inputs, nodes, values, points };
        let outputs = Outputs { sheet: self.sheet, outputs, implicit: self.implicit.into_inner() };
        outputs.finish(signature, self.quantities.into_inner(), self.product.get())
    }
}

/// Sums over the nodes that contain no other one.
fn innermost_sums(x: Expr<'_>) -> Vec<Expr<'_>> {
    let sheet = x.sheet();
    let sums: Vec<ExprId> = {
        let graph = sheet.graph();
        let (mut seen, mut open, mut sums) = (rustc_hash::FxHashSet::default(), vec![x.id()], Vec::new());
        while let Some(expr) = open.pop() {
            if !seen.insert(expr) {
                continue;
            }
            if matches!(graph.op(expr), Op::Sum(_)) {
                sums.push(expr);
            }
            open.extend(graph.operands(expr));
        }
        sums.sort_unstable();
        sums
    };
    let is_innermost = |&sum: &ExprId| match sheet.expr(sum).operation() {
        Op::Sum(term) => !contains_sum(sheet.expr(term)),
        _ => false,
    };
    sheet.exprs(sums.into_iter().filter(is_innermost))
}
