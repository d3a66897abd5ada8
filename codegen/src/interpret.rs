//! Evaluates expressions of a graph, structured nodes included: the second witness of every kernel, in `f64`, and the third, in
//! [`Expansion`]s, which are automatic differentiation of the formulas before any was differentiated.
//!
//! [`element_results`] evaluates all results of an element of the caller's, [`element_products`] its products with a vector,
//! [`element_derivatives`] has its derivatives without those of the graph.
//!
//! It shares nothing with lowering, scheduling and emission: systems are solved here by Gaussian elimination,
//! roots by Newton's iteration, sums by summing.

use rustc_hash::FxHashMap;

use crate::graph::{
    ExprId, Graph, Iteration, Limits, Op, RootFigure, RootId, Scope, SolveId, SymbolId, SystemId,
};

pub(crate) use derivatives::differentiated_products;
pub use derivatives::element_derivatives;
pub use element::{element_products, element_results};
pub use expansion::Expansion;
pub use number::Number;

mod derivatives;
mod element;
mod expansion;
mod number;

/// Values of the input symbols.
#[derive(Clone, Debug, Default)]
pub struct NodeInputs<N = f64> {
    count: usize,
    element: FxHashMap<String, N>,
    node: FxHashMap<String, Vec<N>>,
}

impl NodeInputs {
    /// No values yet, for `count` nodes.
    pub fn new(count: usize) -> Self {
        Self::with_nodes(count)
    }
}

impl<N: Number> NodeInputs<N> {
    /// No values yet, of any kind of number, for `count` nodes.
    pub fn with_nodes(count: usize) -> Self {
        let mut inputs = Self { count, element: FxHashMap::default(), node: FxHashMap::default() };
        inputs.set_element(crate::graph::NODE_COUNT, N::constant(count as f64));
        inputs.set_node(crate::graph::NODE_INDEX, (0..count).map(|k| N::constant(k as f64)).collect());
        inputs
    }

    /// Sets an input of element scope.
    pub fn set_element(&mut self, name: &str, value: N) {
        self.element.insert(name.to_owned(), value);
    }

    /// Sets an input of node scope.
    ///
    /// # Panics
    /// If there is not one value per node.
    pub fn set_node(&mut self, name: &str, values: Vec<N>) {
        assert_eq!(values.len(), self.count, "one value of {name} per node");
        self.node.insert(name.to_owned(), values);
    }
}

/// Largest number of Newton iterations for a root.
const MOST_ITERATIONS: usize = 100;

/// Evaluates expressions, each once.
pub struct Interpreter<'a, N = f64> {
    graph: &'a Graph,
    inputs: &'a NodeInputs<N>,
    element: FxHashMap<ExprId, N>,
    node: FxHashMap<(ExprId, usize), N>,
    solutions: FxHashMap<(SolveId, Option<usize>), Vec<N>>,
    factors: FxHashMap<SystemId, Factor<N>>,
    roots: FxHashMap<RootId, RootSolution<N>>,
    /// Values of a root's unknowns while its equations are evaluated.
    trial: Vec<(SymbolId, N)>,
    /// Values that hold for the trial only.
    of_trial: FxHashMap<ExprId, N>,
}

#[derive(Clone)]
struct Factor<N> {
    inverse: Vec<Vec<N>>,
    pivot_ratio: N,
}

#[derive(Clone)]
struct RootSolution<N> {
    values: Vec<N>,
    residual: f64,
    iterations: usize,
}

impl<'a, N: Number> Interpreter<'a, N> {
    /// An interpreter for one set of inputs.
    pub fn new(graph: &'a Graph, inputs: &'a NodeInputs<N>) -> Self {
        Self {
            graph,
            inputs,
            element: FxHashMap::default(),
            node: FxHashMap::default(),
            solutions: FxHashMap::default(),
            factors: FxHashMap::default(),
            roots: FxHashMap::default(),
            trial: Vec::new(),
            of_trial: FxHashMap::default(),
        }
    }

    /// Value of an expression of element scope.
    ///
    /// # Panics
    /// If an input has no value or the expression has another scope.
    pub fn element(&mut self, expr: ExprId) -> N {
        assert_eq!(self.graph.scope(expr), Scope::Element);
        self.value(expr, None)
    }

    /// Value of an expression at a node; expressions of element scope are the same at every node.
    ///
    /// # Panics
    /// As [`element`](Self::element).
    pub fn node(&mut self, expr: ExprId, node: usize) -> N {
        self.value(expr, Some(node))
    }

    fn value(&mut self, expr: ExprId, node: Option<usize>) -> N {
        let at_node = match (self.graph.scope(expr), node) {
            (Scope::Node, Some(node)) => Some(node),
            (Scope::Element, _) => None,
            (Scope::Node, None) => panic!("an expression of node scope without a node to evaluate it at"),
        };
        let known = match at_node {
            Some(node) => self.node.get(&(expr, node)),
            None => self.of_trial.get(&expr).or_else(|| self.element.get(&expr)),
        };
        if let Some(value) = known {
            return value.clone();
        }
        let value = self.compute(expr, at_node);
        match at_node {
            // Inside a root's equations values hold for the trial only.
            None if !self.trial.is_empty() => self.of_trial.insert(expr, value.clone()),
            None => self.element.insert(expr, value.clone()),
            Some(_) if !self.trial.is_empty() => None,
            Some(node) => self.node.insert((expr, node), value.clone()),
        };
        value
    }

    fn compute(&mut self, expr: ExprId, node: Option<usize>) -> N {
        match self.graph.op(expr) {
            Op::Constant(bits) => N::constant(f64::from_bits(bits)),
            Op::Symbol(symbol) => self.symbol(symbol, node),
            Op::Add(x, y) => self.value(x, node) + self.value(y, node),
            Op::Neg(x) => -self.value(x, node),
            Op::Mul(x, y) => self.value(x, node) * self.value(y, node),
            Op::Div(x, y) => self.value(x, node) / self.value(y, node),
            Op::DivOrZero(x, y) => {
                let divisor = self.value(y, node);
                if divisor.value() == 0.0 { N::constant(0.0) } else { self.value(x, node) / divisor }
            }
            Op::Sqrt(x) => self.value(x, node).sqrt(),
            Op::Exp(x) => self.value(x, node).exp(),
            Op::Function(function, x) => self.value(x, node).function(function),
            Op::Atan2(y, x) => self.value(y, node).atan2(&self.value(x, node)),
            Op::RealPower(x, y) => self.value(x, node).powf(&self.value(y, node)),
            Op::Hypot(x, y) => {
                // A norm of more than two components has derivatives where the first two are zero.
                let components = self.graph.norm_components(expr);
                match N::norm(components.len(), |k| self.value(components[k], node)) {
                    Some(norm) => norm,
                    None => self.value(x, node).hypot(&self.value(y, node)),
                }
            }
            Op::Power(x, exponent) => self.value(x, node).powi(exponent),
            Op::Polynomial(x, polynomial) => {
                self.value(x, node).polynomial(self.graph.polynomial_data(polynomial).coefficients())
            }
            Op::Select { x, y, then, otherwise } => {
                let is_less = self.value(x, node).value() < self.value(y, node).value();
                self.value(if is_less { then } else { otherwise }, node)
            }
            Op::Sum(x) => {
                let terms = (0..self.inputs.count).map(|node| self.value(x, Some(node)));
                terms.reduce(|sum, term| sum + term).unwrap_or_else(|| N::constant(0.0))
            }
            Op::Solution(solve, component) => self.solution(solve, node)[component as usize].clone(),
            Op::InverseFactor { system, row, column } => {
                self.factor(system).inverse[row as usize][column as usize].clone()
            }
            Op::PivotRatio(system) => self.factor(system).pivot_ratio,
            Op::RootValue(root, component) => self.root(root).values[component as usize].clone(),
            Op::RootFigure(root, RootFigure::Residual) => N::constant(self.root(root).residual),
            Op::RootFigure(root, RootFigure::Iterations) => N::constant(self.root(root).iterations as f64),
        }
    }

    fn symbol(&mut self, symbol: SymbolId, node: Option<usize>) -> N {
        if let Some((_, value)) = self.trial.iter().find(|(s, _)| *s == symbol) {
            return value.clone();
        }
        let data = self.graph.symbol_data(symbol);
        if let Some(definition) = data.definition {
            let value = self.value(definition, node);
            return if data.is_held { N::constant(value.value()) } else { value };
        }
        let value = match node {
            Some(node) => self.inputs.node.get(&data.name).map(|values| &values[node]),
            None => self.inputs.element.get(&data.name),
        };
        value.cloned().unwrap_or_else(|| panic!("the input {} has no value", data.name))
    }

    fn matrix(&mut self, system: SystemId) -> Vec<Vec<N>> {
        let data = self.graph.system(system);
        (0..data.size())
            .map(|i| (0..data.size()).map(|j| self.value(data.entry(i, j), None)).collect())
            .collect()
    }

    fn solution(&mut self, solve: SolveId, node: Option<usize>) -> Vec<N> {
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
    fn factor(&mut self, system: SystemId) -> Factor<N> {
        if let Some(known) = self.factors.get(&system) {
            return known.clone();
        }
        let matrix = self.matrix(system);
        let data = self.graph.system(system);
        let size = data.size();
        let references: Vec<Option<N>> = (0..size)
            .map(|i| data.reference(data.eliminated(i)).map(|reference| self.value(reference, None)))
            .collect();
        let signed = |k: usize, x: N| if data.is_negative(k) { -x } else { x };
        let a = |i: usize, j: usize| matrix[data.eliminated(i)][data.eliminated(j)].clone();
        let mut l = vec![vec![N::constant(0.0); size]; size];
        let mut pivot_ratio = N::constant(f64::INFINITY);
        for i in 0..size {
            for j in 0..=i {
                let known = (0..j).map(|k| signed(k, l[i][k].clone() * l[j][k].clone()));
                let rest = match known.reduce(|sum, term| sum + term) {
                    Some(known) => signed(j, a(i, j) - known),
                    None => signed(j, a(i, j)),
                };
                if i == j {
                    let of_multiplier = data.is_compared(data.eliminated(i)).then(|| {
                        let others = (0..i).filter(|&k| !data.is_negative(k));
                        let squares = others.map(|k| l[i][k].clone() * l[i][k].clone());
                        squares.fold(N::constant(f64::MIN_POSITIVE), |sum, square| sum + square)
                    });
                    let reference = of_multiplier.as_ref().or(references[i].as_ref());
                    if let Some(reference) = reference {
                        let ratio = rest.clone() / reference.clone();
                        // A NaN stays where it came first, and does not replace a number.
                        if i == 0 || ratio.value() < pivot_ratio.value() {
                            pivot_ratio = ratio;
                        }
                    }
                    l[i][i] = rest.sqrt();
                } else {
                    l[i][j] = rest / l[j][j].clone();
                }
            }
        }
        let inverse_columns: Vec<Vec<N>> = (0..size)
            .map(|column| {
                let unit = (0..size).map(|row| N::constant(f64::from(u8::from(row == column)))).collect();
                eliminate(l.clone(), unit)
            })
            .collect();
        let inverse = (0..size).map(|i| (0..size).map(|j| inverse_columns[j][i].clone()).collect()).collect();
        let factor = Factor { inverse, pivot_ratio };
        self.factors.insert(system, factor.clone());
        factor
    }

    /// Newton's iteration, by values: steps of no more than the root's limit are halved until they reduce the residual; towards a minimum,
    /// until they do not overshoot. There is none from values that are known.
    /// Steps with the Jacobian that the last values have then give the derivatives of the unknowns, each step those of one more order.
    fn root(&mut self, root: RootId) -> RootSolution<N> {
        if let Some(known) = self.roots.get(&root) {
            return known.clone();
        }
        // Parameters are evaluated before the trial values hide anything.
        for &parameter in self.graph.dependencies_of_root(root) {
            self.value(parameter, None);
        }
        let data = self.graph.root(root).clone();
        let mut values: Vec<N> = match data.is_known() {
            true => data.known.iter().map(|&x| N::constant(self.value(x, None).value())).collect(),
            false => vec![N::constant(0.0); data.unknowns.len()],
        };
        let (mut residual, mut jacobian) = self.equations(root, &values);
        // A NaN is larger than anything: no step leads out of where the equations are defined.
        let larger = |x: f64, y: f64| if x.is_nan() || y <= x { x } else { y };
        let norm = |r: &[N]| r.iter().map(|x| x.value().abs()).fold(0.0, larger);
        let is_descent = data.iteration == Iteration::Descent;
        let limit = match data.iteration {
            Iteration::Within(limits) => limits.longest_step,
            Iteration::Newton | Iteration::Descent => Limits::default().longest_step,
        };
        let mut iterations = 0;
        while !data.is_known() && iterations < MOST_ITERATIONS && norm(&residual) > 0.0 {
            let now: Vec<f64> = residual.iter().map(Number::value).collect();
            let step =
                if is_descent { downhill(&jacobian, &now) } else { eliminate(jacobian.clone(), now.clone()) };
            let length = step.iter().map(|d| d.abs()).fold(0.0, larger);
            let way = norm(&values);
            if is_descent && length <= f64::EPSILON * (1.0 + way) {
                break;
            }
            // As far as a minimum is away, the unknowns are not of order one.
            let longest = if is_descent { limit * (1.0 + way) } else { limit };
            let mut fraction = if length > longest { longest / length } else { 1.0 };
            // More than 0, also where a step has no end.
            let shortest = (1e-6 * fraction).max(f64::MIN_POSITIVE);
            // The slope along a step: r is that down the function.
            let slope = |r: &[N]| -> f64 { r.iter().zip(&step).map(|(r, d)| -d * r.value()).sum() };
            let accepted = loop {
                let trial: Vec<N> =
                    values.iter().zip(&step).map(|(y, d)| N::constant(y.value() - fraction * d)).collect();
                let (r, j) = self.equations(root, &trial);
                let is_better =
                    if is_descent { slope(&r) > -0.5 * slope(&residual) } else { norm(&r) < norm(&residual) };
                if is_better {
                    break Some((trial, r, j));
                }
                fraction /= 2.0;
                if fraction < shortest {
                    break None;
                }
            };
            let Some((trial, r, j)) = accepted else { break };
            (values, residual, jacobian) = (trial, r, j);
            iterations += 1;
        }
        // Infinite for a NaN, as kernels have it.
        let largest = norm(&residual).min(f64::INFINITY);
        let of_values: Vec<Vec<N>> =
            jacobian.iter().map(|row| row.iter().map(|&x| N::constant(x)).collect()).collect();
        for _ in 0..N::ORDER {
            let step = eliminate(of_values.clone(), residual);
            values = values.into_iter().zip(step).map(|(y, d)| y - d).collect();
            (residual, _) = self.equations(root, &values);
        }
        let solution = RootSolution { values, residual: largest, iterations };
        self.roots.insert(root, solution.clone());
        solution
    }

    /// The equations, and the values of their Jacobian.
    fn equations(&mut self, root: RootId, values: &[N]) -> (Vec<N>, Vec<Vec<f64>>) {
        let data = self.graph.root(root).clone();
        self.trial = data.unknowns.iter().copied().zip(values.iter().cloned()).collect();
        let residual = data.residuals.iter().map(|&r| self.value(r, None)).collect();
        let jacobian = data
            .jacobian
            .iter()
            .map(|row| row.iter().map(|&x| self.value(x, None).value()).collect())
            .collect();
        self.trial.clear();
        self.of_trial.clear();
        (residual, jacobian)
    }
}

/// The step from the negative derivatives r of a function of two unknowns and their Jacobian, to be subtracted: Newton's where the function
/// is convex, else down along both principal directions by the absolute values of the curvatures.
fn downhill(jacobian: &[Vec<f64>], r: &[f64]) -> Vec<f64> {
    let [a, b, c] = [-jacobian[0][0], -0.5 * (jacobian[0][1] + jacobian[1][0]), -jacobian[1][1]];
    let (middle, radius) = (0.5 * (a + c), (0.5 * (a - c)).hypot(b));
    if middle > radius {
        return eliminate(jacobian.to_vec(), r.to_vec());
    }
    let least = 1e-3 * (middle + radius).abs();
    let (sin, cos) = (0.5 * (2.0 * b).atan2(a - c)).sin_cos();
    let along = |direction: [f64; 2], curvature: f64| {
        let rate = (direction[0] * r[0] + direction[1] * r[1]) / curvature.abs().max(least);
        direction.map(|x| -rate * x)
    };
    let (first, second) = (along([cos, sin], middle + radius), along([-sin, cos], middle - radius));
    vec![first[0] + second[0], first[1] + second[1]]
}

/// Gaussian elimination with partial pivoting.
fn eliminate<N: Number>(mut a: Vec<Vec<N>>, mut b: Vec<N>) -> Vec<N> {
    let size = b.len();
    for k in 0..size {
        let size_of = |x: &N| x.value().abs();
        let pivot = (k..size).max_by(|&i, &j| size_of(&a[i][k]).total_cmp(&size_of(&a[j][k]))).unwrap_or(k);
        a.swap(k, pivot);
        b.swap(k, pivot);
        for i in k + 1..size {
            let factor = a[i][k].clone() / a[k][k].clone();
            let (upper, lower) = a.split_at_mut(i);
            for (x, y) in lower[0][k..].iter_mut().zip(&upper[k][k..]) {
                *x = x.clone() - factor.clone() * y.clone();
            }
            b[i] = b[i].clone() - factor * b[k].clone();
        }
    }
    for k in (0..size).rev() {
        let known = (k + 1..size).map(|j| a[k][j].clone() * b[j].clone()).reduce(|sum, term| sum + term);
        let rest = match known {
            Some(known) => b[k].clone() - known,
            None => b[k].clone(),
        };
        b[k] = rest / a[k][k].clone();
    }
    b
}
