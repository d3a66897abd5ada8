//! What depends on nothing but the numbers of a quadrature point is computed when the code is written: shape functions and their
//! derivatives become columns of the table of points.

use rustc_hash::FxHashMap;

use crate::graph::{ExprId, Graph, Op, Scope};
use crate::interpret::{Interpreter, NodeInputs};
use crate::kernel::{ElementSpec, Kernel, Points};

/// Numbers that a table may have: three quarters of a first-level cache.
const MOST_NUMBERS: usize = 3072;

/// The lowered kernel with such quantities as further numbers of the points, if that saves operations.
pub(super) fn tabulated(kernel: Kernel<ElementSpec>) -> Kernel<ElementSpec> {
    let operations = |kernel: &Kernel<ElementSpec>| {
        let values = kernel.values.iter().flat_map(|value| value.components.iter().copied());
        kernel.graph.operations(&values.collect::<Vec<_>>())
    };
    // Columns with the numbers that products have may hide what these share.
    let ways = [false, true].into_iter().filter_map(|with_single| with_columns(&kernel, with_single));
    let best = ways.min_by_key(operations).filter(|best| operations(best) < operations(&kernel));
    best.unwrap_or(kernel)
}

/// The same in any case. `with_single`: also a single number of the points times a constant.
fn with_columns(kernel: &Kernel<ElementSpec>, with_single: bool) -> Option<Kernel<ElementSpec>> {
    let Points { symbols, rows } = &kernel.spec.signature.points;
    if rows.is_empty() {
        return None;
    }
    let mut found = kernel.clone();
    let mut tabulation = Tabulation {
        with_single,
        alone: alone(&kernel.graph, symbols),
        graph: &mut found.graph,
        columns: Vec::new(),
        most: (MOST_NUMBERS / rows.len()).saturating_sub(symbols.len()),
        taken: names(kernel),
        done: FxHashMap::default(),
    };
    for value in &mut found.values {
        for x in &mut value.components {
            *x = tabulation.rebuilt(*x);
        }
    }
    let columns = tabulation.columns;
    let whole = |row: &Vec<f64>| {
        let mut inputs = NodeInputs::new(0);
        symbols.iter().zip(row).for_each(|(name, &x)| inputs.set_element(name, x));
        let mut interpreter = Interpreter::new(&found.graph, &inputs);
        row.iter().copied().chain(columns.iter().map(|column| interpreter.element(column.expr))).collect()
    };
    let rows: Vec<Vec<f64>> = rows.iter().map(whole).collect();
    // Where one is no number the code says so when it runs.
    if rows.iter().flatten().any(|x| !x.is_finite()) {
        return None;
    }
    let name = |column: &Column| found.graph.symbol_data(found.graph.symbol_of(column.symbol)).name.clone();
    let symbols = symbols.iter().cloned().chain(columns.iter().map(name)).collect();
    found.spec.signature.points = Points { symbols, rows };
    Some(found)
}

/// Names of what a kernel may read.
fn names(kernel: &Kernel<ElementSpec>) -> Vec<String> {
    let ElementSpec { signature, direction, .. } = &kernel.spec;
    let inputs = signature.inputs.iter().chain(&signature.nodes).flat_map(|input| input.symbols.iter());
    let direction = direction.iter().flat_map(|direction| direction.element.iter().chain(&direction.node));
    inputs.chain(direction).chain(&signature.points.symbols).cloned().collect()
}

/// Of each expression whether it depends on these symbols alone; nothing of a constant.
fn alone(graph: &Graph, symbols: &[String]) -> Vec<Option<bool>> {
    let mut alone: Vec<Option<bool>> = Vec::with_capacity(graph.len());
    // Operands come before what is made of them.
    for k in 0..graph.len() {
        let expr = ExprId(k as u32);
        let own = match graph.op(expr) {
            Op::Constant(_) => None,
            Op::Symbol(symbol) => Some(symbols.contains(&graph.symbol_data(symbol).name)),
            Op::RootValue(..) | Op::RootFigure(..) => Some(false),
            _ => graph.operands(expr).into_iter().filter_map(|x| alone[x.index()]).reduce(|x, y| x && y),
        };
        alone.push(own);
    }
    alone
}

/// A quantity of the points, and the symbol in its place.
struct Column {
    expr: ExprId,
    symbol: ExprId,
}

struct Tabulation<'a> {
    with_single: bool,
    graph: &'a mut Graph,
    alone: Vec<Option<bool>>,
    columns: Vec<Column>,
    /// So many there may be.
    most: usize,
    /// Names of inputs, which a kernel need not have.
    taken: Vec<String>,
    done: FxHashMap<ExprId, ExprId>,
}

impl Tabulation<'_> {
    /// Not of what was made since.
    fn is_alone(&self, expr: ExprId) -> bool {
        self.alone.get(expr.index()).is_some_and(|alone| *alone == Some(true))
    }

    fn rebuilt(&mut self, expr: ExprId) -> ExprId {
        if let Some(&known) = self.done.get(&expr) {
            return known;
        }
        let operands = self.graph.operands(expr);
        let result = match self.graph.op(expr) {
            _ if self.is_alone(expr) => self.column(expr),
            _ if operands.is_empty() => expr,
            Op::Mul(..) if self.is_of_points(expr) => self.product(expr),
            op => {
                let rebuilt: Vec<ExprId> = operands.iter().map(|&x| self.rebuilt(x)).collect();
                if rebuilt == operands { expr } else { self.graph.made(op, &rebuilt) }
            }
        };
        if result != expr
            && let Some(name) = self.graph.name_of(expr).map(str::to_owned)
        {
            self.graph.name(result, &name);
        }
        self.done.insert(expr, result);
        result
    }

    /// Whether factors of a product are of points alone, and more than one number of them unless one is enough.
    fn is_of_points(&self, product: ExprId) -> bool {
        let factors = self.graph.coefficient_and_factors(product).1.into_iter();
        let own: Vec<ExprId> = factors.filter(|&x| self.is_alone(x)).collect();
        match own[..] {
            [] => false,
            [one] => self.with_single || !matches!(self.graph.op(one), Op::Symbol(_)),
            _ => true,
        }
    }

    /// A product that has factors of the points, with one of them.
    fn product(&mut self, expr: ExprId) -> ExprId {
        let (coefficient, factors) = self.graph.coefficient_and_factors(expr);
        let (own, others): (Vec<ExprId>, Vec<ExprId>) = factors.into_iter().partition(|&x| self.is_alone(x));
        let (sign, size) = if coefficient < 0.0 { (-1.0, -coefficient) } else { (1.0, coefficient) };
        let number = self.graph.constant(size);
        let of_points = own.iter().fold(number, |product, &x| self.graph.mul(product, x));
        let of_points = self.column(of_points);
        let others: Vec<ExprId> = others.into_iter().map(|x| self.rebuilt(x)).collect();
        let one = self.graph.one();
        let rest = others.into_iter().fold(one, |product, x| self.graph.mul(product, x));
        let product = self.graph.mul(rest, of_points);
        if sign < 0.0 { self.graph.neg(product) } else { product }
    }

    fn column(&mut self, expr: ExprId) -> ExprId {
        match self.graph.op(expr) {
            Op::Symbol(_) | Op::Constant(_) => expr,
            // A sign costs nothing.
            Op::Neg(positive) => {
                let column = self.column(positive);
                self.graph.neg(column)
            }
            _ => {
                if let Some(known) = self.columns.iter().find(|column| column.expr == expr) {
                    return known.symbol;
                }
                if self.columns.len() == self.most {
                    return expr;
                }
                let wanted =
                    self.graph.name_of(expr).filter(|name| !self.taken.iter().any(|taken| taken == name));
                let name = self.graph.unique_name(wanted.unwrap_or("of_point"));
                let symbol = self.graph.input(&name, Scope::Element);
                self.columns.push(Column { expr, symbol });
                symbol
            }
        }
    }
}
