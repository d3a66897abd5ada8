//! The outputs of an element with their derivatives: from formulas to kernels.

use rustc_hash::FxHashSet;

use super::element::ElementModel;
use super::error::ElementError;
use super::signature::{Differentiated, DirectionSymbols, Input, Returned, Role, Signature};
use super::{Kernel, Mode, Value};
use crate::expr::{Expr, Sheet, ids};
use crate::graph::{ExprId, Graph, NODE_COUNT, NODE_INDEX, Op, RootId, Scope};
use crate::structure::{
    Asked, Derivatives, Direction, Implicit, NoSum, NodeDerivatives, NodeVectors, hessian_product,
    node_derivatives, total_derivatives,
};

/// What identifies a kernel of an element.
#[derive(Clone, Debug, PartialEq)]
pub struct ElementSpec {
    /// What it reads and returns.
    pub signature: Signature,
    /// With how many derivatives.
    pub mode: Mode,
    /// The quantities that the caller defined.
    pub quantities: Vec<Defined>,
    /// What the kernel's values of nodes are; none of an element of fixed size.
    pub node_results: Vec<NodeResult>,
    /// Of a kernel whose results are products of derivatives with a vector: the vector.
    pub direction: Option<DirectionSymbols>,
}

/// What a number is that a kernel has for each node. With V variables of the element, variable a of node i is number V + p i + a of
/// all, p being the variables of a node.
#[derive(Clone, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // The names say what the fields are.
pub enum NodeResult {
    /// A first derivative by a variable, the `component`, of the node. `argument` is what it is written to: `gradient`, a Jacobian, or the
    /// Hessian's product with a vector. `row` is that of the Jacobian.
    First { argument: String, row: usize, component: usize },
    /// A second derivative by a variable of the node, the `component`, and one of the element.
    Mixed { component: usize, variable: usize },
    /// A row b or c of the Hessian's products: d²E/dxᵢdxⱼ = δᵢⱼ D + Σ bᵢᵀ cⱼ + cᵢᵀ bⱼ. Of the first product b is `row` 0 and c is 1, b of
    /// the second is 2, ….
    Row { row: usize, component: usize },
    /// D, the packed lower triangle, by the place there.
    Own { place: usize },
}

/// Name of a node's values in the kernel, which [`ElementSpec::node_results`] tell apart.
const NODE_VALUE: &str = "of_node";

/// The kernels of an element as expressions.
#[derive(Clone, Debug)]
pub struct ElementKernels {
    /// What they read and return.
    pub signature: Signature,
    /// By mode, fewest derivatives first, as far as there are derivatives.
    pub kernels: Vec<Kernel<ElementSpec>>,
    /// Products of the derivatives with a vector, if they were asked for.
    pub product: Option<Kernel<ElementSpec>>,
    /// The values, of sums and products as they are written: the witness of what constructors simplify. A fit has none.
    pub(crate) written: Option<Kernel<ElementSpec>>,
}

/// An intermediate quantity.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Defined {
    /// Its name.
    pub name: String,
    /// Its documentation, one line.
    pub doc: String,
}

/// Outputs as expressions.
pub(super) struct Outputs<'g> {
    pub sheet: &'g Sheet,
    pub outputs: Vec<(Returned, Vec<Expr<'g>>)>,
    /// Unknowns of equations that depend on the nodes.
    pub implicit: Vec<Implicit<'g>>,
}

/// Results of the kernels by ids.
pub(super) struct Finished {
    signature: Signature,
    quantities: Vec<Defined>,
    by_mode: Vec<Results>,
    product: Option<Product>,
}

/// Results of the products' kernel, and the graph without them, which the other kernels have.
struct Product {
    results: Results,
    direction: DirectionSymbols,
    before: Graph,
}

/// Those of a kernel.
struct Results {
    mode: Mode,
    values: Vec<Value>,
    node_values: Vec<(NodeResult, ExprId)>,
}

/// What derivatives are taken by.
struct Variables<'g> {
    sheet: &'g Sheet,
    symbols: Vec<Expr<'g>>,
    /// Vectors among the symbols.
    vectors: Vec<NodeVectors>,
    /// Those of each node; none for an element of fixed size.
    of_node: Option<Vec<Expr<'g>>>,
}

impl<'g> Outputs<'g> {
    pub fn finish(
        self,
        signature: Signature,
        quantities: Vec<Defined>,
        with_product: bool,
    ) -> Result<Finished, ElementError> {
        let inputs = signature.inputs.iter().chain(&signature.nodes);
        let mut declared: Vec<&str> = inputs.flat_map(|input| &input.symbols).map(String::as_str).collect();
        declared.extend(signature.points.symbols.iter().map(String::as_str));
        if !signature.nodes.is_empty() {
            declared.extend([NODE_COUNT, NODE_INDEX]);
        }
        for (value, entries) in &self.outputs {
            entries.iter().try_for_each(|&x| check_output(&value.name, x, &declared))?;
            if value.differentiated != Differentiated::Not
                && entries.iter().any(|&x| differentiates_figure(x))
            {
                return Err(ElementError::Figure { output: value.name.clone() });
            }
        }
        let variables = Variables::new(self.sheet, &signature);
        let is_written = self.sheet.graph().is_as_written();
        let with_product = with_product && !is_written;
        let most = self.outputs.iter().map(|(value, _)| value.differentiated as usize).max().unwrap_or(0);
        let most = if is_written { 0 } else { most };
        let by_mode = Mode::ALL[..=most]
            .iter()
            .map(|&mode| self.results(&variables, mode))
            .collect::<Result<_, _>>()?;
        let product = with_product.then(|| self.product(&variables)).transpose()?;
        Ok(Finished { signature, quantities, by_mode, product })
    }

    /// Products of derivatives with a vector.
    fn product(&self, variables: &Variables<'g>) -> Result<Product, ElementError> {
        let before = self.sheet.graph().clone();
        let direction = DirectionSymbols {
            element: self.unique("direction", variables.symbols.len()),
            node: self.unique("node_direction", variables.of_node.as_ref().map_or(0, Vec::len)),
        };
        let entries = |names: &[String], scope| -> Vec<Expr<'g>> {
            names.iter().map(|name| self.sheet.input(name, scope)).collect()
        };
        let along = entries(&direction.element, Scope::Element);
        let along_of_node = entries(&direction.node, Scope::Node);
        let rates = variables.symbols.iter().chain(variables.of_node.iter().flatten()).copied();
        let rates = || rates.clone().zip(along.iter().chain(&along_of_node).copied());

        let mut results = Results { mode: Mode::Value, values: Vec::new(), node_values: Vec::new() };
        for (returned, outputs) in &self.outputs {
            let Some(name) = returned.product() else { continue };
            if self.outputs.iter().any(|(other, _)| other.name == name) {
                return Err(ElementError::Duplicate { name });
            }
            match (returned.differentiated, &variables.of_node) {
                (Differentiated::Twice, None) => {
                    let (sheet, by) = (self.sheet, &variables.symbols);
                    let product = hessian_product(sheet, outputs[0], by, &along, &variables.vectors);
                    results.values.push(value(&name, true, &product));
                }
                (Differentiated::Twice, Some(_)) => {
                    let of = self.by_nodes(returned, outputs[0], variables, Asked::Differentiated)?;
                    let mut direction = Direction::new(self.sheet, rates());
                    let mut rate = |x: &Expr<'g>| direction.derivative(*x);
                    let of_element: Vec<Expr<'g>> = of.element.iter().map(&mut rate).collect();
                    results.values.push(value(&name, true, &of_element));
                    for (component, x) in of.node.iter().enumerate() {
                        let result = NodeResult::First { argument: name.clone(), row: 0, component };
                        results.node_values.push((result, rate(x).id()));
                    }
                }
                _ => {
                    let mut direction = Direction::new(self.sheet, rates());
                    let product: Vec<Expr<'g>> = outputs.iter().map(|&x| direction.derivative(x)).collect();
                    results.values.push(value(&name, true, &product));
                }
            }
        }
        if results.values.is_empty() {
            return Err(ElementError::NoProduct);
        }
        Ok(Product { results, direction, before })
    }

    /// Names of new symbols.
    fn unique(&self, name: &str, count: usize) -> Vec<String> {
        let graph = self.sheet.graph();
        (1..=count).map(|k| graph.unique_name(&format!("{name}_{k}"))).collect()
    }

    fn by_nodes(
        &self,
        returned: &Returned,
        x: Expr<'g>,
        variables: &Variables<'g>,
        asked: Asked,
    ) -> Result<NodeDerivatives<'g>, ElementError> {
        let of_node = variables.of_node.as_deref().unwrap_or_default();
        let by = (&variables.symbols[..], of_node);
        let derivatives = node_derivatives(x, by, &self.implicit, asked);
        derivatives.map_err(|NoSum { symbol }| ElementError::NoSum {
            quantity: symbol.unwrap_or_else(|| returned.name.clone()),
        })
    }

    /// Results of a mode: values, and the derivatives that belong to it.
    fn results(&self, variables: &Variables<'g>, mode: Mode) -> Result<Results, ElementError> {
        let value = |(returned, entries): &(Returned, Vec<Expr<'_>>)| {
            value(&returned.name, !returned.dimensions.is_empty(), entries)
        };
        let mut results =
            Results { mode, values: self.outputs.iter().map(value).collect(), node_values: Vec::new() };
        let differentiated = |(returned, _): &&(Returned, _)| {
            returned.differentiated != Differentiated::Not && mode > Mode::Value
        };
        for (returned, entries) in self.outputs.iter().filter(differentiated) {
            let with_hessian = returned.differentiated == Differentiated::Twice && mode == Mode::Hessian;
            match &variables.of_node {
                None => results.add_fixed(returned, entries, variables, with_hessian)?,
                Some(_) => {
                    let asked = if with_hessian { Asked::Second } else { Asked::First };
                    let derivatives = entries.iter().map(|&x| self.by_nodes(returned, x, variables, asked));
                    results.add_with_nodes(
                        returned,
                        &derivatives.collect::<Result<Vec<_>, _>>()?,
                        variables,
                    )?;
                }
            }
        }
        Ok(results)
    }
}

fn value(name: &str, is_array: bool, components: &[Expr<'_>]) -> Value {
    Value { name: name.to_owned().into(), doc: "".into(), is_array, components: ids(components) }
}

impl Results {
    /// Adds the derivatives of an output of an element of fixed size.
    fn add_fixed<'g>(
        &mut self,
        returned: &Returned,
        entries: &[Expr<'g>],
        variables: &Variables<'g>,
        with_hessian: bool,
    ) -> Result<(), ElementError> {
        let name = &returned.name;
        let Variables { sheet, symbols, vectors, .. } = variables;
        if symbols.is_empty() && !entries.is_empty() {
            return Err(ElementError::NoVariables { output: name.clone() });
        }
        let derivatives = |&entry: &Expr<'g>| total_derivatives(sheet, entry, symbols, vectors, with_hessian);
        let of_entries: Vec<Derivatives<'g>> = entries.iter().map(derivatives).collect();
        if !of_entries.is_empty() && of_entries.iter().all(|of| of.gradient.iter().all(|x| x.is_zero())) {
            return Err(ElementError::Constant { output: name.clone() });
        }
        match (returned.differentiated, &of_entries[..]) {
            (Differentiated::Twice, [of]) => {
                self.values.push(value("gradient", true, &of.gradient));
                if with_hessian {
                    self.values.push(value("hessian", true, &of.hessian));
                }
            }
            (_, of_entries) => {
                let rows: Vec<Expr<'g>> = of_entries.iter().flat_map(|of| of.gradient.clone()).collect();
                self.values.push(value(&format!("{name}_jacobian"), true, &rows));
            }
        }
        Ok(())
    }

    /// Adds the derivatives of an output's entries, those by variables of the element as values.
    fn add_with_nodes<'g>(
        &mut self,
        returned: &Returned,
        of_entries: &[NodeDerivatives<'g>],
        variables: &Variables<'g>,
    ) -> Result<(), ElementError> {
        let name = &returned.name;
        if variables.symbols.is_empty() && variables.of_node.iter().all(Vec::is_empty) {
            return Err(ElementError::NoVariables { output: name.clone() });
        }
        let first = |of: &NodeDerivatives<'g>| of.element.iter().chain(&of.node).all(|x| x.is_zero());
        if of_entries.iter().all(first) {
            return Err(ElementError::Constant { output: name.clone() });
        }
        let argument = match returned.differentiated {
            Differentiated::Twice => "gradient".to_owned(),
            _ => format!("{name}_jacobian"),
        };
        let rows: Vec<Expr<'g>> = of_entries.iter().flat_map(|of| of.element.clone()).collect();
        self.values.push(value(&argument, true, &rows));
        for (row, of) in of_entries.iter().enumerate() {
            for (component, x) in of.node.iter().enumerate() {
                let result = NodeResult::First { argument: argument.clone(), row, component };
                self.node_values.push((result, x.id()));
            }
        }
        let Some(second) = of_entries.iter().find_map(|of| of.second.as_ref()) else { return Ok(()) };
        self.values.push(value("hessian", true, &second.element));
        for (component, row) in second.mixed.iter().enumerate() {
            for (variable, x) in row.iter().enumerate() {
                self.node_values.push((NodeResult::Mixed { component, variable }, x.id()));
            }
        }
        for (row, x) in second.rows.iter().flatten().enumerate() {
            for (component, x) in x.iter().enumerate() {
                self.node_values.push((NodeResult::Row { row, component }, x.id()));
            }
        }
        for (place, x) in second.own.iter().enumerate() {
            self.node_values.push((NodeResult::Own { place }, x.id()));
        }
        Ok(())
    }
}

impl<'g> Variables<'g> {
    fn new(sheet: &'g Sheet, signature: &Signature) -> Self {
        let is_variable = |input: &&Input| input.role == Role::Variable;
        let (mut symbols, mut vectors) = (Vec::new(), Vec::new());
        for input in signature.inputs.iter().filter(is_variable) {
            let nodes = match input.dimensions[..] {
                [components] => Some((1, components)),
                [nodes, components] => Some((nodes, components)),
                _ => None,
            };
            let first = symbols.len();
            vectors.extend(nodes.map(|(nodes, components)| NodeVectors { first, nodes, components }));
            symbols.extend(input.symbols.iter().map(|name| sheet.input_once(name, Scope::Element)));
        }
        let of_node = signature.nodes.iter().filter(is_variable).flat_map(|input| &input.symbols);
        let of_node = of_node.map(|name| sheet.input_once(name, Scope::Node)).collect();
        let of_node = (!signature.nodes.is_empty()).then_some(of_node);
        Self { sheet, symbols, vectors, of_node }
    }
}

/// Whether an output is one value of the element made of declared inputs.
fn check_output(output: &str, x: Expr<'_>, declared: &[&str]) -> Result<(), ElementError> {
    if x.scope() != Scope::Element {
        return Err(ElementError::Scope { output: output.to_owned() });
    }
    let graph = x.sheet().graph();
    for expr in graph.reachable(x.id(), Graph::dependencies) {
        if is_never_finite(&graph, expr, x.id()) {
            return Err(ElementError::NeverFinite { output: output.to_owned() });
        }
        let Op::Symbol(symbol) = graph.op(expr) else { continue };
        let symbol = graph.symbol_data(symbol);
        if symbol.definition.is_none() && !declared.contains(&symbol.name.as_str()) {
            let (output, symbol) = (output.to_owned(), symbol.name.clone());
            if symbol == NODE_COUNT {
                return Err(ElementError::NoNodes { output });
            }
            return Err(ElementError::Undeclared { output, symbol });
        }
    }
    Ok(())
}

/// Whether it is no number whatever the inputs are, or would be in all but a choice, which may begin at infinity.
fn is_never_finite(graph: &Graph, expr: ExprId, output: ExprId) -> bool {
    let constant = |x: ExprId| match graph.op(x) {
        Op::Constant(bits) => Some(f64::from_bits(bits)),
        _ => None,
    };
    let is_infinite = |x: ExprId| constant(x).is_some_and(f64::is_infinite);
    match graph.op(expr) {
        Op::Constant(bits) => f64::from_bits(bits).is_nan() || expr == output && is_infinite(expr),
        // The angle of what is infinite is finite.
        Op::Select { .. } | Op::Atan2(..) => false,
        Op::Div(x, y) => is_infinite(x) || constant(y) == Some(0.0),
        Op::Sqrt(x) => constant(x).is_some_and(|x| !x.sqrt().is_finite()),
        Op::Polynomial(_, polynomial) => {
            !graph.polynomial_data(polynomial).coefficients().iter().all(|c| c.is_finite())
        }
        Op::RealPower(x, y) => constant(x).zip(constant(y)).is_some_and(|(x, y)| !x.powf(y).is_finite()),
        _ => graph.operands(expr).into_iter().any(is_infinite),
    }
}

/// Whether derivatives of an output are also those of how an iteration or a factorisation went. Conditions are not differentiated, but
/// definitions in them are.
fn differentiates_figure(x: Expr<'_>) -> bool {
    let graph = x.sheet().graph();
    let (mut seen, mut open) = (FxHashSet::default(), vec![(x.id(), false)]);
    while let Some((expr, is_condition)) = open.pop() {
        if !seen.insert((expr, is_condition)) {
            continue;
        }
        match graph.op(expr) {
            Op::RootFigure(..) | Op::PivotRatio(_) if !is_condition => return true,
            Op::Select { x, y, then, otherwise } => {
                open.extend([x, y].map(|x| (x, true)));
                open.extend([then, otherwise].map(|x| (x, is_condition)));
            }
            Op::Symbol(_) => open.extend(graph.varying_dependencies(expr).into_iter().map(|x| (x, false))),
            _ => open.extend(graph.varying_dependencies(expr).into_iter().map(|x| (x, is_condition))),
        }
    }
    false
}

impl Kernel<ElementSpec> {
    /// A kernel of these values and of these of each node; `spec` says which they are.
    pub(crate) fn of_element(
        spec: ElementSpec,
        graph: Graph,
        values: Vec<Value>,
        of_nodes: Vec<ExprId>,
    ) -> Self {
        Self {
            spec,
            graph,
            values,
            gradients: Vec::new(),
            hessians: Vec::new(),
            node_values: of_nodes.into_iter().map(|x| (NODE_VALUE, x)).collect(),
            combinations: Vec::new(),
            equations: Vec::new(),
        }
    }

    /// The results and what they are made of, each once.
    pub(crate) fn reachable(&self) -> Vec<ExprId> {
        let mut results: Vec<ExprId> =
            self.values.iter().flat_map(|value| value.components.clone()).collect();
        results.extend(self.node_values.iter().map(|(_, x)| *x));
        self.graph.reachable_from(results, Graph::dependencies)
    }

    /// Roots among what the results are made of, but for those that are known.
    pub(crate) fn roots(&self) -> Vec<RootId> {
        let mut roots = Vec::new();
        for expr in self.reachable() {
            if let Op::RootValue(root, _) | Op::RootFigure(root, _) = self.graph.op(expr)
                && !self.graph.root(root).is_known()
                && !roots.contains(&root)
            {
                roots.push(root);
            }
        }
        roots
    }
}

impl ElementKernels {
    /// The kernels of an element from its formulas.
    ///
    /// # Errors
    /// [`ElementError`], but for its functions' length, which shows when they are written.
    pub fn new(name: &str, formulas: impl Fn(&ElementModel<'_>)) -> Result<Self, ElementError> {
        let mut element = Self::of_graph(Graph::new(), name, &formulas)?;
        let mut graph = Graph::new();
        graph.keep_as_written();
        // Where a choice of formulas looks at what they are simplified to, there may be none.
        element.written = Self::of_graph(graph, name, &formulas)
            .ok()
            .filter(|written| written.signature == element.signature)
            .and_then(|written| written.kernels.into_iter().next());
        Ok(element)
    }

    /// Names of the inputs that no output depends on.
    pub fn unused_inputs(&self) -> Vec<&str> {
        let Some(kernel) = self.kernels.first() else { return Vec::new() };
        let symbols = kernel.reachable().into_iter().filter_map(|expr| match kernel.graph.op(expr) {
            Op::Symbol(symbol) => Some(kernel.graph.symbol_data(symbol).name.as_str()),
            _ => None,
        });
        let used: FxHashSet<&str> = symbols.collect();
        let inputs = self.signature.inputs.iter().chain(&self.signature.nodes);
        let unused = inputs.filter(|input| input.symbols.iter().all(|name| !used.contains(name.as_str())));
        unused.map(|input| input.name.as_str()).collect()
    }

    fn of_graph(
        mut graph: Graph,
        name: &str,
        formulas: impl FnOnce(&ElementModel<'_>),
    ) -> Result<Self, ElementError> {
        graph.free_divisors();
        let finished = graph.write(|sheet| {
            let model = ElementModel::new(sheet);
            model.check_name(name);
            formulas(&model);
            model.finish(name)
        });
        let Finished { signature, quantities, by_mode, product } = finished?;
        let kernel = |Results { mode, values, node_values }, direction, graph: Graph| {
            let (signature, quantities) = (signature.clone(), quantities.clone());
            let (node_results, of_nodes) = node_values.into_iter().unzip();
            let spec = ElementSpec { signature, mode, quantities, node_results, direction };
            Kernel::of_element(spec, graph, values, of_nodes)
        };
        let (product, graph) = match product {
            Some(Product { results, direction, before }) => {
                (Some(kernel(results, Some(direction), graph)), before)
            }
            None => (None, graph),
        };
        let kernels: Vec<Kernel<ElementSpec>> =
            by_mode.into_iter().map(|results| kernel(results, None, graph.clone())).collect();
        let roots = kernels.iter().chain(&product).flat_map(|kernel| {
            kernel.roots().into_iter().map(|root| kernel.graph.root(root)).collect::<Vec<_>>()
        });
        for root in roots {
            if !root.iteration.takes(root.unknowns.len()) {
                let (root, equations) = (root.name.clone(), root.unknowns.len());
                return Err(ElementError::Root { root, equations });
            }
        }
        Ok(Self { signature, kernels, product, written: None })
    }
}
