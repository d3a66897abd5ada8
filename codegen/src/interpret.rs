//! Evaluates expressions of a graph in `f64`, structured nodes included: the second witness of every kernel.
//!
//! [`element_results`] does so for all results of an element of the caller's.
//!
//! It shares nothing with lowering, scheduling and emission: systems are solved here by Gaussian elimination,
//! roots by Newton's iteration, sums by summing.

use std::collections::HashMap;

use crate::graph::{ExprId, Graph, Op, RootFigure, RootId, Scope, SolveId, SymbolId, SystemId};

pub use element::element_results;

mod element;

/// Values of the input symbols.
#[derive(Clone, Debug, Default)]
pub struct NodeInputs {
    count: usize,
    element: HashMap<String, f64>,
    node: HashMap<String, Vec<f64>>,
}

impl NodeInputs {
    /// No values yet, for `count` nodes.
    #[must_use]
    pub fn new(count: usize) -> Self {
        let mut inputs = Self { count, ..Self::default() };
        inputs.set_element(crate::graph::NODE_COUNT, count as f64);
        inputs.set_node(crate::graph::NODE_INDEX, (0..count).map(|k| k as f64).collect());
        inputs
    }

    /// Sets an input of element scope.
    pub fn set_element(&mut self, name: &str, value: f64) {
        self.element.insert(name.to_owned(), value);
    }

    /// Sets an input of node scope.
    ///
    /// # Panics
    /// If there is not one value per node.
    pub fn set_node(&mut self, name: &str, values: Vec<f64>) {
        assert_eq!(values.len(), self.count, "one value of {name} per node");
        self.node.insert(name.to_owned(), values);
    }
}

/// Largest number of Newton iterations for a root.
const MOST_ITERATIONS: usize = 100;

/// Evaluates expressions, each once.
pub struct Interpreter<'a> {
    graph: &'a Graph,
    inputs: &'a NodeInputs,
    element: HashMap<ExprId, f64>,
    node: HashMap<(ExprId, usize), f64>,
    solutions: HashMap<(SolveId, Option<usize>), Vec<f64>>,
    factors: HashMap<SystemId, Factor>,
    roots: HashMap<RootId, RootSolution>,
    /// Values of a root's unknowns while its equations are evaluated.
    trial: Vec<(SymbolId, f64)>,
}

#[derive(Clone)]
struct Factor {
    inverse: Vec<Vec<f64>>,
    pivot_ratio: f64,
}

#[derive(Clone)]
struct RootSolution {
    values: Vec<f64>,
    residual: f64,
    iterations: usize,
}

impl<'a> Interpreter<'a> {
    /// An interpreter for one set of inputs.
    #[must_use]
    pub fn new(graph: &'a Graph, inputs: &'a NodeInputs) -> Self {
        Self {
            graph,
            inputs,
            element: HashMap::new(),
            node: HashMap::new(),
            solutions: HashMap::new(),
            factors: HashMap::new(),
            roots: HashMap::new(),
            trial: Vec::new(),
        }
    }

    /// Value of an expression of element scope.
    ///
    /// # Panics
    /// If an input has no value or the expression has another scope.
    pub fn element(&mut self, expr: ExprId) -> f64 {
        assert_eq!(self.graph.scope(expr), Scope::Element);
        self.value(expr, None)
    }

    /// Value of an expression at a node; expressions of element scope are the same at every node.
    ///
    /// # Panics
    /// As [`element`](Self::element).
    pub fn node(&mut self, expr: ExprId, node: usize) -> f64 {
        self.value(expr, Some(node))
    }

    /// Value of an expression for a pair of nodes.
    ///
    /// # Panics
    /// As [`element`](Self::element).
    pub fn pair(&mut self, expr: ExprId, row: usize, column: usize) -> f64 {
        if self.graph.scope(expr) != Scope::Pair {
            return self.value(expr, None);
        }
        match self.graph.op(expr) {
            Op::Row(x) => self.value(x, Some(row)),
            Op::Column(x) => self.value(x, Some(column)),
            Op::Add(x, y) => self.pair(x, row, column) + self.pair(y, row, column),
            Op::Mul(x, y) => self.pair(x, row, column) * self.pair(y, row, column),
            Op::Neg(x) => -self.pair(x, row, column),
            op => unreachable!("pairs are sums of products, not {op:?}"),
        }
    }

    fn value(&mut self, expr: ExprId, node: Option<usize>) -> f64 {
        let at_node = match (self.graph.scope(expr), node) {
            (Scope::Node, Some(node)) => Some(node),
            (Scope::Element, _) => None,
            (scope, _) => panic!("an expression of {scope:?} scope without a node to evaluate it at"),
        };
        let known = match at_node {
            Some(node) => self.node.get(&(expr, node)),
            None => self.element.get(&expr),
        };
        if let Some(&value) = known {
            return value;
        }
        let value = self.compute(expr, at_node);
        // Inside a root's equations values hold for the trial only.
        if self.trial.is_empty() {
            match at_node {
                Some(node) => self.node.insert((expr, node), value),
                None => self.element.insert(expr, value),
            };
        }
        value
    }

    fn compute(&mut self, expr: ExprId, node: Option<usize>) -> f64 {
        match self.graph.op(expr) {
            Op::Constant(bits) => f64::from_bits(bits),
            Op::Symbol(symbol) => self.symbol(symbol, node),
            Op::Add(x, y) => self.value(x, node) + self.value(y, node),
            Op::Neg(x) => -self.value(x, node),
            Op::Mul(x, y) => self.value(x, node) * self.value(y, node),
            Op::Div(x, y) => self.value(x, node) / self.value(y, node),
            Op::DivOrZero(x, y) => {
                let divisor = self.value(y, node);
                if divisor == 0.0 { 0.0 } else { self.value(x, node) / divisor }
            }
            Op::Sqrt(x) => self.value(x, node).sqrt(),
            Op::Exp(x) => self.value(x, node).exp(),
            Op::Function(function, x) => function.evaluate(self.value(x, node)),
            Op::Atan2(y, x) => self.value(y, node).atan2(self.value(x, node)),
            Op::RealPower(x, y) => self.value(x, node).powf(self.value(y, node)),
            Op::Hypot(x, y) => self.value(x, node).hypot(self.value(y, node)),
            Op::Power(x, exponent) => self.value(x, node).powi(exponent),
            Op::Polynomial(x, polynomial) => {
                expanded_nearby(self.graph.polynomial_data(polynomial).coefficients(), self.value(x, node))
            }
            Op::Select { x, y, then, otherwise } => {
                let taken = if self.value(x, node) < self.value(y, node) { then } else { otherwise };
                self.value(taken, node)
            }
            Op::Sum(x) => (0..self.inputs.count).map(|node| self.value(x, Some(node))).sum(),
            Op::Solution(solve, component) => self.solution(solve, node)[component as usize],
            Op::InverseFactor { system, row, column } => {
                self.factor(system).inverse[row as usize][column as usize]
            }
            Op::PivotRatio(system) => self.factor(system).pivot_ratio,
            Op::RootValue(root, component) => self.root(root).values[component as usize],
            Op::RootFigure(root, RootFigure::Residual) => self.root(root).residual,
            Op::RootFigure(root, RootFigure::Iterations) => self.root(root).iterations as f64,
            op @ (Op::Row(_) | Op::Column(_)) => unreachable!("{op:?} outside a pair"),
        }
    }

    fn symbol(&mut self, symbol: SymbolId, node: Option<usize>) -> f64 {
        if let Some(&(_, value)) = self.trial.iter().find(|(s, _)| *s == symbol) {
            return value;
        }
        let data = self.graph.symbol_data(symbol);
        if let Some(definition) = data.definition {
            return self.value(definition, node);
        }
        let value = match node {
            Some(node) => self.inputs.node.get(&data.name).map(|values| values[node]),
            None => self.inputs.element.get(&data.name).copied(),
        };
        value.unwrap_or_else(|| panic!("the input {} has no value", data.name))
    }

    fn matrix(&mut self, system: SystemId) -> Vec<Vec<f64>> {
        let data = self.graph.system(system);
        (0..data.size())
            .map(|i| (0..data.size()).map(|j| self.value(data.entry(i, j), None)).collect())
            .collect()
    }

    fn solution(&mut self, solve: SolveId, node: Option<usize>) -> Vec<f64> {
        if let Some(known) = self.solutions.get(&(solve, node)) {
            return known.clone();
        }
        let data = self.graph.solve(solve);
        let matrix = self.matrix(data.system);
        let right_hand_side = data.right_hand_side.iter().map(|&b| self.value(b, node)).collect();
        let solution = eliminate(matrix, right_hand_side);
        self.solutions.insert((solve, node), solution.clone());
        solution
    }

    /// L⁻¹ of the matrix L S Lᵀ in elimination order, by the textbook recurrences.
    fn factor(&mut self, system: SystemId) -> Factor {
        if let Some(known) = self.factors.get(&system) {
            return known.clone();
        }
        let matrix = self.matrix(system);
        let data = self.graph.system(system);
        let size = data.size();
        let references: Vec<Option<f64>> = (0..size)
            .map(|i| data.reference(data.eliminated(i)).map(|reference| self.value(reference, None)))
            .collect();
        let sign = |k: usize| if data.is_negative(k) { -1.0 } else { 1.0 };
        let a = |i: usize, j: usize| matrix[data.eliminated(i)][data.eliminated(j)];
        let mut l = vec![vec![0.0; size]; size];
        let mut pivot_ratio = f64::INFINITY;
        for i in 0..size {
            for j in 0..=i {
                let rest = sign(j) * (a(i, j) - (0..j).map(|k| sign(k) * l[i][k] * l[j][k]).sum::<f64>());
                if i == j {
                    if let Some(reference) = references[i] {
                        let ratio = rest / reference;
                        // A NaN stays where it came first, and does not replace a number.
                        pivot_ratio = if i == 0 || ratio < pivot_ratio { ratio } else { pivot_ratio };
                    }
                    l[i][i] = rest.sqrt();
                } else {
                    l[i][j] = rest / l[j][j];
                }
            }
        }
        let inverse_columns: Vec<Vec<f64>> = (0..size)
            .map(|column| {
                let unit = (0..size).map(|row| f64::from(u8::from(row == column))).collect();
                eliminate(l.clone(), unit)
            })
            .collect();
        let inverse = (0..size).map(|i| (0..size).map(|j| inverse_columns[j][i]).collect()).collect();
        let factor = Factor { inverse, pivot_ratio };
        self.factors.insert(system, factor.clone());
        factor
    }

    /// Newton's iteration with halving of steps that do not reduce the residual.
    fn root(&mut self, root: RootId) -> RootSolution {
        if let Some(known) = self.roots.get(&root) {
            return known.clone();
        }
        // Parameters are evaluated before the trial values hide anything.
        for parameter in self.graph.dependencies_of_root(root) {
            self.value(parameter, None);
        }
        let data = self.graph.root(root).clone();
        let mut values = vec![0.0; data.unknowns.len()];
        let (mut residual, mut jacobian) = self.equations(root, &values);
        let norm = |r: &[f64]| r.iter().map(|x| x.abs()).fold(0.0, f64::max);
        let mut iterations = 0;
        while iterations < MOST_ITERATIONS && norm(&residual) > 0.0 {
            let step = eliminate(jacobian.clone(), residual.clone());
            let mut fraction = 1.0;
            let accepted = loop {
                let trial: Vec<f64> = values.iter().zip(&step).map(|(y, d)| y - fraction * d).collect();
                let (r, j) = self.equations(root, &trial);
                if norm(&r) < norm(&residual) {
                    break Some((trial, r, j));
                }
                fraction /= 2.0;
                if fraction < 1e-6 {
                    break None;
                }
            };
            let Some((trial, r, j)) = accepted else { break };
            (values, residual, jacobian) = (trial, r, j);
            iterations += 1;
        }
        let solution = RootSolution { values, residual: norm(&residual), iterations };
        self.roots.insert(root, solution.clone());
        solution
    }

    fn equations(&mut self, root: RootId, values: &[f64]) -> (Vec<f64>, Vec<Vec<f64>>) {
        let data = self.graph.root(root).clone();
        self.trial = data.unknowns.iter().copied().zip(values.iter().copied()).collect();
        let residual = data.residuals.iter().map(|&r| self.value(r, None)).collect();
        let jacobian =
            data.jacobian.iter().map(|row| row.iter().map(|&x| self.value(x, None)).collect()).collect();
        self.trial.clear();
        (residual, jacobian)
    }
}

/// A polynomial by its expansion about 0 or, from x = 1/2 on, about 1, where the leading coefficients of a weight
/// vanish.
fn expanded_nearby(coefficients: &[f64], x: f64) -> f64 {
    let horner = |c: &[f64], x: f64| c.iter().rev().fold(0.0, |value, c| value * x + c);
    if x < 0.5 {
        return horner(coefficients, x);
    }
    // Coefficients about 1 by repeated synthetic division; what is rounding of zero is zero.
    let size: f64 = coefficients.iter().enumerate().map(|(k, c)| c.abs() * 2f64.powi(k as i32)).sum();
    let mut shifted = coefficients.to_vec();
    for start in 0..shifted.len() {
        for k in (start..shifted.len().saturating_sub(1)).rev() {
            shifted[k] += shifted[k + 1];
        }
        if shifted[start].abs() <= 4.0 * f64::EPSILON * size {
            shifted[start] = 0.0;
        }
    }
    horner(&shifted, x - 1.0)
}

/// Gaussian elimination with partial pivoting.
fn eliminate(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let size = b.len();
    for k in 0..size {
        let pivot = (k..size).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs())).unwrap_or(k);
        a.swap(k, pivot);
        b.swap(k, pivot);
        for i in k + 1..size {
            let factor = a[i][k] / a[k][k];
            let (upper, lower) = a.split_at_mut(i);
            for (x, y) in lower[0][k..].iter_mut().zip(&upper[k][k..]) {
                *x -= factor * y;
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..size).rev() {
        let known: f64 = (k + 1..size).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - known) / a[k][k];
    }
    b
}
