//! An element of the caller's, from formulas: inputs, quantities, outputs.

use std::cell::{Cell, RefCell};

use super::error::ElementError;
use super::outputs::{Defined, Finished, Outputs};
use super::signature::{Differentiated, Input, Points, Quantity, Returned, Role, Signature, is_identifier};
use crate::expr::{Expr, Sheet, ids};
use crate::graph::{ExprId, Graph, NODE_COUNT, NODE_INDEX, Op, Scope};
use crate::structure::{Implicit, has_within, sums_in};

/// Name of the value that [`ElementModel::energy`] states.
const ENERGY: &str = "energy";

/// Name of the field with the nodes.
const NODES: &str = "nodes";

/// The sheet that an element's formulas are written on, with its inputs and outputs.
///
/// Mistakes are kept until the end, where the first of them is the error.
pub struct ElementModel<'g> {
    pub(super) sheet: &'g Sheet,
    doc: RefCell<String>,
    inputs: RefCell<Vec<Input>>,
    /// Inputs of which each node has its own.
    nodes: RefCell<Vec<Input>>,
    /// Sums over the nodes, and the symbols that stand for them.
    sums: RefCell<Vec<(ExprId, ExprId)>>,
    /// Those of the symbols that the caller gave no name.
    unnamed: RefCell<Vec<ExprId>>,
    /// Unknowns of equations that depend on the nodes.
    pub(super) implicit: RefCell<Vec<Implicit<'g>>>,
    outputs: RefCell<Vec<(Returned, Vec<Expr<'g>>)>>,
    quantities: RefCell<Vec<Defined>>,
    points: RefCell<Points>,
    /// Whether products are wanted.
    product: Cell<bool>,
    /// Unknowns whose values are known, the first of them.
    pub(super) known: RefCell<Option<String>>,
    error: RefCell<Option<ElementError>>,
}

impl<'g> ElementModel<'g> {
    pub(super) const fn new(sheet: &'g Sheet) -> Self {
        Self {
            sheet,
            doc: RefCell::new(String::new()),
            inputs: RefCell::new(Vec::new()),
            nodes: RefCell::new(Vec::new()),
            sums: RefCell::new(Vec::new()),
            unnamed: RefCell::new(Vec::new()),
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
        self.input(name, Role::Variable, Scope::Element)
    }

    /// An input of which each node has its own and that derivatives are taken by, such as a position. The number of nodes is open
    /// until a kernel runs. What is made of it is a value of a node; [`Expr::sum`] leads back to the element. Variables of nodes are
    /// numbered after those of the element, node by node.
    #[must_use]
    pub fn node_variable<Q: Quantity<'g>>(&self, name: &str) -> Q {
        self.input(name, Role::Variable, Scope::Node)
    }

    /// An input of which each node has its own and that derivatives are not taken by, such as a radius.
    #[must_use]
    pub fn node_parameter<Q: Quantity<'g>>(&self, name: &str) -> Q {
        self.input(name, Role::Parameter, Scope::Node)
    }

    /// An input that derivatives are not taken by: a material constant, reference positions, a state before.
    #[must_use]
    pub fn parameter<Q: Quantity<'g>>(&self, name: &str) -> Q {
        self.input(name, Role::Parameter, Scope::Element)
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
        let is_row = |row: &[f64]| row.len() == symbols.len() && row.iter().all(|x| x.is_finite());
        let is_whole = rows.iter().all(|row| is_row(row.as_ref()));
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
    /// chain rule. Values are the same without; operations may be fewer with it. A quantity of a node gets its name only, and so do those
    /// through which derivatives would be lost: what is made of norms, in an energy, and what a choice leaves out where it has infinite
    /// derivatives.
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
            self.sheet.edit(|g| g.add_quantity(symbol.id()));
            if matches!(x.operation(), Op::Sum(_)) {
                self.sums.borrow_mut().push((x.id(), symbol.id()));
            }
            symbol
        })
    }

    pub(super) fn has_nodes(&self) -> bool {
        !self.nodes.borrow().is_empty()
    }

    /// The expression with symbols in the place of the sums over the nodes that contain no unknowns: derivatives go through a sum as
    /// through any quantity.
    pub(super) fn with_bound_sums(&self, x: Expr<'g>, unknowns: &[Expr<'g>]) -> Expr<'g> {
        if !self.has_nodes() {
            return x;
        }
        let mut x = x;
        loop {
            // The innermost ones first.
            let is_next =
                |sum: &Expr<'g>| !has_within(*sum, |_| true) && !unknowns.iter().any(|&u| sum.contains(u));
            let sums: Vec<Expr<'g>> = sums_in(x).into_iter().filter(is_next).collect();
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

    /// Expressions with formulas in the place of quantities through which they would lose derivatives.
    pub(super) fn written_out(&self, exprs: Vec<Expr<'g>>, variables: &[ExprId]) -> Vec<Expr<'g>> {
        self.sheet.exprs(self.sheet.edit(|g| g.written_out(&ids(&exprs), None, variables)))
    }

    /// What derivatives are taken by, so far.
    fn variables(&self) -> Vec<ExprId> {
        let (inputs, nodes) = (self.inputs.borrow(), self.nodes.borrow());
        let variables = inputs.iter().chain(nodes.iter()).filter(|input| input.role == Role::Variable);
        let symbol = |name: &String| self.sheet.input_once(name, Scope::Element).id();
        variables.flat_map(|input| &input.symbols).map(symbol).collect()
    }

    fn symbol_of_sum(&self, sum: Expr<'g>) -> ExprId {
        if let Some(&(_, symbol)) = self.sums.borrow().iter().find(|(known, _)| *known == sum.id()) {
            return symbol;
        }
        let name = self.sheet.graph().name_of(sum.id()).map(str::to_owned);
        let is_unnamed = name.is_none();
        let name = name.unwrap_or_else(|| "total".to_owned());
        let symbol = self.sheet.make(|g| g.bind_unique(&name, sum.id())).id();
        self.unnamed.borrow_mut().extend(is_unnamed.then_some(symbol));
        self.sheet.edit(|g| g.add_quantity(symbol));
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
            self.fail(ElementError::TwoFunctions { function: name.to_owned() });
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

    /// An input of the element, or of each node.
    fn input<Q: Quantity<'g>>(&self, name: &str, role: Role, scope: Scope) -> Q {
        let mut fields = if scope == Scope::Node { &self.nodes } else { &self.inputs }.borrow_mut();
        // Before the names of its entries are met twice.
        if fields.iter().any(|other| other.name == name) {
            self.fail(ElementError::Duplicate { name: name.to_owned() });
        }
        let (quantity, symbols) = self.declared(name, scope);
        let (name, doc, dimensions) = (name.to_owned(), String::new(), Q::dimensions());
        fields.push(Input { name, doc, role, dimensions, symbols });
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
        if is_derivative {
            self.fail(ElementError::DerivativeName { name: name.to_owned() });
        }
        if outputs.iter().any(|(value, _)| value.name == name) {
            self.fail(ElementError::Duplicate { name: name.to_owned() });
        }
        let (name, doc, dimensions) = (name.to_owned(), String::new(), Q::dimensions());
        let entries = quantity.entries().into_iter().map(|x| self.with_bound_sums(x, &[])).collect();
        let entries = match differentiated {
            Differentiated::Not => entries,
            Differentiated::Once => self.written_out(entries, &[]),
            Differentiated::Twice => self.written_out(entries, &self.variables()),
        };
        outputs.push((Returned { name, doc, dimensions, differentiated }, entries));
    }

    pub(super) fn check_name(&self, name: &str) {
        if !is_identifier(name) {
            self.fail(ElementError::Name { name: name.to_owned() });
        }
    }

    pub(super) fn check_symbol(&self, name: &str) {
        if !self.sheet.graph().has_symbol(name) {
            return;
        }
        // The name of a sum that the caller gave none makes way.
        let is_own = |symbol: &&ExprId| self.sheet.expr(**symbol).symbol_name() == name;
        match self.unnamed.borrow().iter().find(is_own) {
            Some(&symbol) => self.sheet.edit(|g| g.rename(symbol)),
            None => self.fail(ElementError::Duplicate { name: name.to_owned() }),
        }
    }

    pub(super) fn has_failed(&self) -> bool {
        self.error.borrow().is_some()
    }

    /// Keeps the first error.
    pub(super) fn fail(&self, error: ElementError) {
        self.error.borrow_mut().get_or_insert(error);
    }

    pub(super) fn finish(self, name: &str) -> Result<Finished, ElementError> {
        let (inputs, nodes, outputs) =
            (self.inputs.into_inner(), self.nodes.into_inner(), self.outputs.into_inner());
        self.sheet.edit(Graph::end_quantities);
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
            let symbols = inputs.iter().chain(&nodes).flat_map(|input| &input.symbols);
            let fields = inputs.iter().map(|input| &input.name).filter(|name| *name == NODES);
            let taken = symbols.filter(|name| [NODE_COUNT, NODE_INDEX].contains(&name.as_str()));
            let is_bound = |name: &&str| {
                let graph = self.sheet.graph();
                graph.has_symbol(name) && !graph.has_input(name)
            };
            let bound = [NODE_COUNT, NODE_INDEX].into_iter().find(is_bound).map(str::to_owned);
            if let Some(name) = fields.chain(taken).next().cloned().or(bound) {
                return Err(ElementError::Reserved { name });
            }
        }
        let values = outputs.iter().map(|(value, _)| value.clone()).collect();
        let (name, doc) = (name.to_owned(), self.doc.into_inner());
        let signature = Signature { name, doc, inputs, nodes, values, points };
        let outputs = Outputs { sheet: self.sheet, outputs, implicit: self.implicit.into_inner() };
        let has_inputs = !signature.inputs.is_empty() || !signature.nodes.is_empty();
        let finished = outputs.finish(signature, self.quantities.into_inner(), self.product.get())?;
        if has_inputs { Ok(finished) } else { Err(ElementError::NoInput) }
    }
}
