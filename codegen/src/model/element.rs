//! An element of the caller's, from formulas: inputs, quantities, outputs.

use std::cell::RefCell;

use super::kernel::{Kernel, Mode, Value};
use super::signature::{Differentiated, Input, Points, Quantity, Returned, Role, Signature};
use crate::expr::{Expr, Sheet, Vector, ids};
use crate::graph::{ExprId, Graph, Op, RootFigure, RootId, Scope};
use crate::structure::{Derivatives, NodeVectors, total_derivatives};

/// Name of the value that [`ElementModel::energy`] states.
const ENERGY: &str = "energy";

/// Unknowns of the roots that kernels can find.
const UNKNOWNS: usize = 2;

/// Why there are no kernels of an element.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ElementError {
    /// A name that Rust does not take as one.
    #[error("\"{name}\" is not an identifier in lower or upper case")]
    Name {
        /// The name.
        name: String,
    },
    /// Two inputs, quantities or outputs have one name.
    #[error("\"{name}\" is declared twice")]
    Duplicate {
        /// The name, or that of an entry.
        name: String,
    },
    /// Derivatives are asked for, but there is nothing to differentiate by.
    #[error("`{output}` has no variables to be differentiated by; declare them by `variable`")]
    NoVariables {
        /// What was to be differentiated.
        output: String,
    },
    /// Nothing is computed.
    #[error("there is no output; state one by `energy`, `residual` or `value`")]
    NoOutput,
    /// A differentiated output is the same whatever the variables are.
    #[error("`{output}` does not depend on any variable")]
    Constant {
        /// The output.
        output: String,
    },
    /// An output is not one value of the element, but one per node.
    #[error("`{output}` is a value of {scope:?} scope; outputs are of element scope")]
    Scope {
        /// The output, or its entry.
        output: String,
        /// Its scope.
        scope: Scope,
    },
    /// An output contains a symbol that is no declared input.
    #[error("`{output}` contains `{symbol}`, which was not declared by `variable` or `parameter`")]
    Undeclared {
        /// The output, or its entry.
        output: String,
        /// The symbol.
        symbol: String,
    },
    /// There is no input or output of this name to be described.
    #[error("there is no input or output `{name}` to describe")]
    Unknown {
        /// The name.
        name: String,
    },
    /// A table of numbers at points that does not fit.
    #[error(
        "the rows of `{name}` have not one number for each of its entries, or not as many rows as the points before"
    )]
    Points {
        /// The table.
        name: String,
    },
    /// A root of another number of equations than the kernels can solve.
    #[error("the root `{root}` has {equations} equations; kernels solve two")]
    Root {
        /// The root.
        root: String,
        /// Its equations.
        equations: usize,
    },
    /// A function that rustc has no stack for.
    #[error(
        "its function `{function}` would have {statements} statements, at most {} can be compiled",
        crate::emit::MOST_STATEMENTS
    )]
    TooLong {
        /// The function.
        function: String,
        /// Its statements.
        statements: usize,
    },
}

/// The sheet that an element's formulas are written on, with its inputs and outputs.
///
/// Mistakes are kept until the end, where the first of them is the error.
pub struct ElementModel<'g> {
    sheet: &'g Sheet,
    doc: RefCell<String>,
    inputs: RefCell<Vec<Input>>,
    outputs: RefCell<Vec<(Returned, Vec<Expr<'g>>)>>,
    quantities: RefCell<Vec<String>>,
    points: RefCell<Points>,
    error: RefCell<Option<ElementError>>,
}

/// Where equations are solved, see [`ElementModel::root`].
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

/// What identifies a kernel of an element.
#[derive(Clone, Debug, PartialEq)]
pub struct ElementSpec {
    /// What it reads and returns.
    pub signature: Signature,
    /// With how many derivatives.
    pub mode: Mode,
    /// Names of the quantities that the caller defined.
    pub quantities: Vec<String>,
}

/// The kernels of an element as expressions.
#[derive(Clone, Debug)]
pub struct ElementKernels {
    /// What they read and return.
    pub signature: Signature,
    /// By mode, fewest derivatives first, as far as there are derivatives.
    pub kernels: Vec<Kernel<ElementSpec>>,
}

impl<'g> ElementModel<'g> {
    const fn new(sheet: &'g Sheet) -> Self {
        Self {
            sheet,
            doc: RefCell::new(String::new()),
            inputs: RefCell::new(Vec::new()),
            outputs: RefCell::new(Vec::new()),
            quantities: RefCell::new(Vec::new()),
            points: RefCell::new(Points { symbols: Vec::new(), rows: Vec::new() }),
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
        let (quantity, symbols) = self.declared::<Q>(name);
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

    /// Documents an input or an output: meaning and unit, in one line.
    pub fn describe(&self, name: &str, text: &str) {
        if let Some(input) = self.inputs.borrow_mut().iter_mut().find(|input| input.name == name) {
            text.clone_into(&mut input.doc);
        } else if let Some((value, _)) =
            self.outputs.borrow_mut().iter_mut().find(|(value, _)| value.name == name)
        {
            text.clone_into(&mut value.doc);
        } else {
            self.fail(ElementError::Unknown { name: name.to_owned() });
        }
    }

    /// An intermediate quantity, such as a deformation gradient: its name appears in the code, and derivatives go through it by the
    /// chain rule. Values are the same without; operations may be fewer with it.
    #[must_use]
    pub fn define<Q: Quantity<'g>>(&self, name: &str, quantity: Q) -> Q {
        self.check_name(name);
        self.quantities.borrow_mut().push(name.to_owned());
        quantity.changed(name, &mut |entry, x| {
            if x.value().is_some() {
                return x;
            }
            self.check_symbol(entry);
            self.sheet.make(|g| g.bind_unique(entry, x.id()))
        })
    }

    /// Unknowns at the root of as many equations r(u) = 0, such as the natural coordinates of a foot point: by a damped Newton
    /// iteration from u = 0, with steps of at most ½. Derivatives are those of the implicit function theorem.
    ///
    /// Whoever uses the kernels has to know whether there is a root: state [`Root::residual`] as a value.
    #[must_use]
    pub fn root<const N: usize>(
        &self,
        name: &str,
        equations: impl FnOnce(Vector<'g, N>) -> Vector<'g, N>,
    ) -> Root<'g, N> {
        self.check_name(name);
        if N != UNKNOWNS {
            self.fail(ElementError::Root { root: name.to_owned(), equations: N });
            let zero = self.sheet.zero();
            return Root { unknowns: Vector::zero(self.sheet), residual: zero, iterations: zero };
        }
        let unknowns = Vector::from_fn(|k| self.sheet.variable(&format!("{name}_unknown_{}", k + 1)));
        let (root, values) = self.sheet.root(name, unknowns, equations(unknowns));
        let figure = |figure| self.sheet.root_figure(root, figure);
        Root {
            unknowns: self.define(name, values),
            residual: figure(RootFigure::Residual),
            iterations: figure(RootFigure::Iterations),
        }
    }

    /// States the energy, or any other number that gradient and Hessian are wanted of. Its value is the output `energy`.
    pub fn energy(&self, energy: Expr<'g>) {
        self.output(ENERGY, energy, Differentiated::Twice);
    }

    /// States a quantity that the Jacobian is wanted of too, such as forces that have no energy.
    pub fn residual<Q: Quantity<'g>>(&self, name: &str, residual: Q) {
        self.output(name, residual, Differentiated::Once);
    }

    /// States a quantity that no derivatives are wanted of: a stress, a new state.
    pub fn value<Q: Quantity<'g>>(&self, name: &str, value: Q) {
        self.output(name, value, Differentiated::Not);
    }

    fn input<Q: Quantity<'g>>(&self, name: &str, role: Role) -> Q {
        let (quantity, symbols) = self.declared(name);
        let (name, doc, dimensions) = (name.to_owned(), String::new(), Q::dimensions());
        self.inputs.borrow_mut().push(Input { name, doc, role, dimensions, symbols });
        quantity
    }

    /// A quantity of new symbols, and their names.
    fn declared<Q: Quantity<'g>>(&self, name: &str) -> (Q, Vec<String>) {
        self.check_name(name);
        let mut symbols = Vec::new();
        let quantity = Q::declare(name, &mut |entry| {
            self.check_symbol(entry);
            let symbol = self.sheet.variable(entry);
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
        outputs.push((Returned { name, doc, dimensions, differentiated }, quantity.entries()));
    }

    fn check_name(&self, name: &str) {
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

    fn finish(self, name: &str) -> Result<Finished, ElementError> {
        let (inputs, outputs) = (self.inputs.into_inner(), self.outputs.into_inner());
        if let Some(error) = self.error.into_inner() {
            return Err(error);
        }
        if outputs.is_empty() {
            return Err(ElementError::NoOutput);
        }
        let points = self.points.into_inner();
        let declared: Vec<&String> =
            inputs.iter().flat_map(|input| &input.symbols).chain(&points.symbols).collect();
        for (value, entries) in &outputs {
            entries.iter().try_for_each(|&x| check_output(&value.name, x, &declared))?;
        }
        let variables = Variables::new(self.sheet, &inputs);
        let values = outputs.iter().map(|(value, _)| value.clone()).collect();
        let (name, doc) = (name.to_owned(), self.doc.into_inner());
        let signature = Signature { name, doc, inputs, values, points };
        let most = outputs.iter().map(|(value, _)| value.differentiated as usize).max().unwrap_or(0);
        let by_mode = Mode::ALL[..=most]
            .iter()
            .map(|&mode| Ok((mode, values_of(&outputs, &variables, mode)?)))
            .collect::<Result<_, ElementError>>()?;
        Ok(Finished { signature, quantities: self.quantities.into_inner(), by_mode })
    }
}

/// An element's outputs by ids.
struct Finished {
    signature: Signature,
    quantities: Vec<String>,
    by_mode: Vec<(Mode, Vec<Value>)>,
}

/// What derivatives are taken by.
struct Variables<'g> {
    sheet: &'g Sheet,
    symbols: Vec<Expr<'g>>,
    nodes: Vec<NodeVectors>,
}

impl<'g> Variables<'g> {
    fn new(sheet: &'g Sheet, inputs: &[Input]) -> Self {
        let (mut symbols, mut nodes) = (Vec::new(), Vec::new());
        for input in inputs.iter().filter(|input| input.role == Role::Variable) {
            if let [count, components] = input.dimensions[..] {
                nodes.push(NodeVectors { first: symbols.len(), nodes: count, components });
            }
            symbols.extend(input.symbols.iter().map(|name| sheet.input_once(name, Scope::Element)));
        }
        Self { sheet, symbols, nodes }
    }

    fn derivatives(
        &self,
        output: &str,
        x: Expr<'g>,
        with_hessian: bool,
    ) -> Result<Derivatives<'g>, ElementError> {
        if self.symbols.is_empty() {
            return Err(ElementError::NoVariables { output: output.to_owned() });
        }
        Ok(total_derivatives(self.sheet, x, &self.symbols, &self.nodes, with_hessian))
    }
}

/// Values of a mode, and the derivatives that belong to it.
fn values_of<'g>(
    outputs: &[(Returned, Vec<Expr<'g>>)],
    variables: &Variables<'g>,
    mode: Mode,
) -> Result<Vec<Value>, ElementError> {
    let value = |name: String, is_array: bool, components: &[Expr<'g>]| Value {
        name: name.into(),
        doc: "".into(),
        is_array,
        components: ids(components),
    };
    let mut values: Vec<Value> = outputs
        .iter()
        .map(|(returned, entries)| value(returned.name.clone(), !returned.dimensions.is_empty(), entries))
        .collect();
    for (returned, entries) in outputs.iter().filter(|_| mode > Mode::Value) {
        let name = &returned.name;
        let mut of_entries = Vec::new();
        for &entry in entries.iter().filter(|_| returned.differentiated != Differentiated::Not) {
            let with_hessian = returned.differentiated == Differentiated::Twice && mode == Mode::Hessian;
            of_entries.push(variables.derivatives(name, entry, with_hessian)?);
        }
        if !of_entries.is_empty() && of_entries.iter().all(|of| of.gradient.iter().all(|x| x.is_zero())) {
            return Err(ElementError::Constant { output: name.clone() });
        }
        match (returned.differentiated, &of_entries[..]) {
            (Differentiated::Twice, [of]) => {
                values.push(value("gradient".to_owned(), true, &of.gradient));
                if mode == Mode::Hessian {
                    values.push(value("hessian".to_owned(), true, &of.hessian));
                }
            }
            (Differentiated::Once, of_entries) => {
                let rows: Vec<Expr<'g>> = of_entries.iter().flat_map(|of| of.gradient.clone()).collect();
                values.push(value(format!("{name}_jacobian"), true, &rows));
            }
            _ => {}
        }
    }
    Ok(values)
}

/// Whether an output is one value of the element made of declared inputs.
fn check_output(output: &str, x: Expr<'_>, declared: &[&String]) -> Result<(), ElementError> {
    if x.scope() != Scope::Element {
        return Err(ElementError::Scope { output: output.to_owned(), scope: x.scope() });
    }
    let graph = x.sheet().graph();
    let (mut seen, mut open) = (std::collections::HashSet::new(), vec![x.id()]);
    while let Some(expr) = open.pop() {
        if !seen.insert(expr) {
            continue;
        }
        open.extend(graph.dependencies(expr));
        let Op::Symbol(symbol) = graph.op(expr) else { continue };
        let symbol = graph.symbol_data(symbol);
        if symbol.definition.is_none() && !declared.contains(&&symbol.name) {
            let (output, symbol) = (output.to_owned(), symbol.name.clone());
            return Err(ElementError::Undeclared { output, symbol });
        }
    }
    Ok(())
}

impl Kernel<ElementSpec> {
    /// Roots among what the results are made of.
    pub(crate) fn roots(&self) -> Vec<RootId> {
        let (mut seen, mut roots) = (std::collections::HashSet::new(), Vec::new());
        let mut open: Vec<ExprId> = self.values.iter().flat_map(|value| value.components.clone()).collect();
        while let Some(expr) = open.pop() {
            if !seen.insert(expr) {
                continue;
            }
            if let Op::RootValue(root, _) | Op::RootFigure(root, _) = self.graph.op(expr)
                && !roots.contains(&root)
            {
                roots.push(root);
            }
            open.extend(self.graph.dependencies(expr));
        }
        roots
    }
}

impl ElementKernels {
    /// The kernels of an element from its formulas.
    ///
    /// # Errors
    /// [`ElementError`], but for its functions' length, which shows when they are written.
    pub fn new(name: &str, formulas: impl FnOnce(&ElementModel<'_>)) -> Result<Self, ElementError> {
        let mut graph = Graph::new();
        let finished = graph.write(|sheet| {
            let model = ElementModel::new(sheet);
            model.check_name(name);
            formulas(&model);
            model.finish(name)
        });
        let Finished { signature, quantities, by_mode } = finished?;
        let kernel = |(mode, values)| Kernel {
            spec: ElementSpec { signature: signature.clone(), mode, quantities: quantities.clone() },
            graph: graph.clone(),
            values,
            gradients: Vec::new(),
            hessians: Vec::new(),
            node_values: Vec::new(),
            combinations: Vec::new(),
            equations: Vec::new(),
        };
        let kernels: Vec<Kernel<ElementSpec>> = by_mode.into_iter().map(kernel).collect();
        for root in kernels.iter().flat_map(Kernel::roots) {
            let root = graph.root(root);
            if root.unknowns.len() != UNKNOWNS {
                let (root, equations) = (root.name.clone(), root.unknowns.len());
                return Err(ElementError::Root { root, equations });
            }
        }
        Ok(Self { signature, kernels })
    }
}
