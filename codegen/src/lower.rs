//! Lowers structured nodes to plain arithmetic: a kernel in, the same kernel over a new graph out.
//!
//! After lowering only these operations are left: constants, inputs, + − × ÷, elementary functions, choice, sums over
//! nodes, and roots, whose equations are lowered too. Symmetric systems become an unrolled
//! factorisation, Cholesky's without his square roots, and unrolled substitutions.

use rustc_hash::FxHashMap;

use crate::graph::{ExprId, Graph, Op, PolynomialId, RootId, Scope, SolveId, SymbolId, SystemId};
use crate::kernel::Kernel;
use crate::structure::Gradient;
use crate::table::Table;

/// The kernel over a graph without structured nodes other than sums and roots.
pub fn lower<S: Clone>(kernel: &Kernel<S>) -> Kernel<S> {
    let mut lowering = Lowering::new(kernel);
    let values = kernel
        .values
        .iter()
        .map(|value| {
            let components = value.components.iter().map(|&x| lowering.lower(x)).collect();
            crate::kernel::Value { components, ..value.clone() }
        })
        .collect();
    let gradients = kernel
        .gradients
        .iter()
        .map(|(name, gradient)| {
            let slave = gradient.slave.map(|x| lowering.lower(x));
            let node = gradient.node.map(|x| lowering.lower(x));
            let point = gradient.point.map(|point| point.map(|x| lowering.lower(x)));
            (*name, Gradient { slave, node, point })
        })
        .collect();
    let hessians = kernel
        .hessians
        .iter()
        .map(|(name, form)| {
            for x in form.in_order_of_products() {
                lowering.lower(x);
            }
            (*name, form.map(|x| lowering.lower(x)))
        })
        .collect();
    let node_values = kernel.node_values.iter().map(|&(name, x)| (name, lowering.lower(x))).collect();
    let combinations = kernel
        .combinations
        .iter()
        .map(|(name, all)| (*name, all.iter().map(|&x| lowering.lower(x)).collect()))
        .collect();
    Kernel {
        spec: kernel.spec.clone(),
        graph: lowering.target,
        values,
        gradients,
        hessians,
        node_values,
        combinations,
        equations: kernel.equations.clone(),
    }
}

struct Lowering<'a> {
    source: &'a Graph,
    target: Graph,
    done: Table<ExprId, ExprId>,
    symbols: FxHashMap<SymbolId, ExprId>,
    factors: FxHashMap<SystemId, Factor>,
    inverses: FxHashMap<(SystemId, usize, usize), ExprId>,
    solutions: FxHashMap<SolveId, Vec<ExprId>>,
    roots: FxHashMap<RootId, (RootId, Vec<ExprId>)>,
    /// How many quotients divide by an expression: from two on, a reciprocal is shared.
    divisors: FxHashMap<ExprId, usize>,
}

/// A = U D Uᵀ in elimination order, U with ones on its diagonal. L = U |D|^½, but no square root is waited for: it is
/// drawn where L⁻¹ is asked for, of 1/D.
#[derive(Clone)]
struct Factor {
    /// U below its diagonal.
    lower: Vec<Vec<ExprId>>,
    /// D, with its sign.
    pivots: Vec<ExprId>,
    /// 1/D
    reciprocal: Vec<ExprId>,
}

impl<'a> Lowering<'a> {
    fn new<S>(kernel: &'a Kernel<S>) -> Self {
        let mut divisors = FxHashMap::default();
        for index in 0..kernel.graph.len() {
            if let Op::Div(_, y) = kernel.graph.op(ExprId(index as u32)) {
                *divisors.entry(y).or_insert(0) += 1;
            }
        }
        Self {
            source: &kernel.graph,
            target: Graph::new(),
            done: Table::default(),
            symbols: FxHashMap::default(),
            factors: FxHashMap::default(),
            inverses: FxHashMap::default(),
            solutions: FxHashMap::default(),
            roots: FxHashMap::default(),
            divisors,
        }
    }

    fn lower(&mut self, expr: ExprId) -> ExprId {
        if let Some(&known) = self.done.get(&expr) {
            return known;
        }
        let lowered = self.lower_op(expr);
        if let Some(name) = self.source.name_of(expr) {
            self.target.name(lowered, name);
        }
        self.done.insert(expr, lowered);
        lowered
    }

    fn lower_op(&mut self, expr: ExprId) -> ExprId {
        match self.source.op(expr) {
            Op::Constant(bits) => self.target.constant(f64::from_bits(bits)),
            Op::Symbol(symbol) => self.lower_symbol(symbol),
            Op::Div(x, y) => {
                let shared = self.divisors.get(&y).is_some_and(|&count| count > 1);
                let (x, y) = (self.lower(x), self.lower(y));
                if !shared {
                    return self.target.div(x, y);
                }
                let one = self.target.one();
                let reciprocal = self.target.div(one, y);
                self.target.mul(x, reciprocal)
            }
            Op::DivOrZero(x, y) => {
                let (x, y) = (self.lower(x), self.lower(y));
                let one = self.target.one();
                let reciprocal = self.target.div_or_zero(one, y);
                self.target.mul(x, reciprocal)
            }
            Op::Hypot(x, y) => {
                let square = self.square_of_hypot(x, y);
                self.target.sqrt(square)
            }
            Op::Power(base, exponent) => self.lower_power(base, exponent),
            Op::Polynomial(base, polynomial) => self.lower_polynomial(base, polynomial),
            Op::Solution(solve, component) => self.lower_solve(solve)[component as usize],
            Op::InverseFactor { system, row, column } => {
                self.inverse_factor(system, row as usize, column as usize)
            }
            Op::PivotRatio(system) => self.pivot_ratio(system),
            Op::RootValue(root, component) => match self.source.root(root).known.get(component as usize) {
                Some(&known) => self.lower(known),
                None => self.lower_root(root).1[component as usize],
            },
            Op::RootFigure(root, figure) => {
                let root = self.lower_root(root).0;
                self.target.root_figure(root, figure)
            }
            Op::RealPower(x, y) => {
                let (base, exponent) = (self.lower(x), self.lower(y));
                // Lowered, an exponent may have become a number.
                match self.target.integer_exponent(exponent) {
                    Some(exponent) => self.power_of(base, exponent),
                    None => self.target.real_power(base, exponent),
                }
            }
            op => {
                let operands =
                    self.source.operands(expr).into_iter().map(|x| self.lower(x)).collect::<Vec<_>>();
                self.target.made(op, &operands)
            }
        }
    }

    fn lower_symbol(&mut self, symbol: SymbolId) -> ExprId {
        let data = self.source.symbol_data(symbol);
        if let Some(definition) = data.definition {
            return self.lower(definition);
        }
        if let Some(&known) = self.symbols.get(&symbol) {
            return known;
        }
        if data.name == crate::graph::NODE_COUNT {
            return self.target.node_count();
        }
        let input = self.target.input(&data.name, data.scope);
        self.symbols.insert(symbol, input);
        input
    }

    /// x² + y², without the root of a norm that is nested.
    fn square_of_hypot(&mut self, x: ExprId, y: ExprId) -> ExprId {
        match self.source.op(x) {
            Op::Hypot(u, v) => {
                let (square, y) = (self.square_of_hypot(u, v), self.lower(y));
                let last = self.target.mul(y, y);
                self.target.add(square, last)
            }
            _ => {
                let (x, y) = (self.lower(x), self.lower(y));
                self.target.dot(&[x, y], &[x, y])
            }
        }
    }

    /// Repeated squaring; powers of a norm use its square, which is there before the root is drawn.
    fn lower_power(&mut self, base: ExprId, exponent: i32) -> ExprId {
        let magnitude = exponent.unsigned_abs();
        let power = match self.source.op(base) {
            Op::Hypot(x, y) => {
                let square = self.square_of_hypot(x, y);
                let even = self.repeated_square(square, magnitude / 2);
                if magnitude % 2 == 1 {
                    let norm = self.lower(base);
                    self.target.mul(even, norm)
                } else {
                    even
                }
            }
            _ => {
                let base = self.lower(base);
                return self.power_of(base, exponent);
            }
        };
        self.inverted_if(exponent < 0, power)
    }

    /// A power of what is lowered, by products.
    fn power_of(&mut self, base: ExprId, exponent: i32) -> ExprId {
        let power = self.repeated_square(base, exponent.unsigned_abs());
        self.inverted_if(exponent < 0, power)
    }

    fn inverted_if(&mut self, is_inverted: bool, x: ExprId) -> ExprId {
        if !is_inverted {
            return x;
        }
        let one = self.target.one();
        self.target.div(one, x)
    }

    /// (1 − x)ᵐ Q(x), Q by Horner's rule.
    fn lower_polynomial(&mut self, base: ExprId, polynomial: PolynomialId) -> ExprId {
        let (zeros, quotient) = self.source.polynomial_data(polynomial).without_zeros_at_one();
        let base = self.lower(base);
        let mut value = self.target.zero();
        for &c in quotient.coefficients().iter().rev() {
            let product = self.target.mul(value, base);
            let c = self.target.constant(c);
            value = self.target.add(c, product);
        }
        let one = self.target.one();
        let complement = self.target.sub(one, base);
        if let Some(name) = self.target.name_of(base).map(str::to_owned) {
            self.target.name(complement, &format!("one_minus_{name}"));
        }
        let zeros = self.repeated_square(complement, zeros);
        self.target.mul(value, zeros)
    }

    fn repeated_square(&mut self, base: ExprId, exponent: u32) -> ExprId {
        match exponent {
            0 => self.target.one(),
            1 => base,
            _ => {
                let half = self.repeated_square(base, exponent / 2);
                let square = self.target.mul(half, half);
                if exponent % 2 == 1 { self.target.mul(square, base) } else { square }
            }
        }
    }

    /// A = U D Uᵀ
    fn factor(&mut self, system: SystemId) -> Factor {
        if let Some(known) = self.factors.get(&system) {
            return known.clone();
        }
        let data = self.source.system(system).clone();
        let name = &data.name;
        let mut factor = Factor { lower: Vec::new(), pivots: Vec::new(), reciprocal: Vec::new() };
        for i in 0..data.size() {
            // Of U D, and of U.
            let mut scaled: Vec<ExprId> = Vec::with_capacity(i);
            let mut row: Vec<ExprId> = Vec::with_capacity(i);
            for j in 0..=i {
                let mut rest = self.lower(data.entry(data.eliminated(i), data.eliminated(j)));
                for k in 0..j {
                    let left = if i == j { row[k] } else { factor.lower[j][k] };
                    let product = self.target.mul(left, scaled[k]);
                    rest = self.target.sub(rest, product);
                }
                if i == j {
                    self.target.name(rest, &format!("{name}_pivot_{i}"));
                    let one = self.target.one();
                    let reciprocal = self.target.div(one, rest);
                    self.target.name(reciprocal, &format!("{name}_reciprocal_{i}"));
                    factor.pivots.push(rest);
                    factor.reciprocal.push(reciprocal);
                } else {
                    let entry = self.target.mul(rest, factor.reciprocal[j]);
                    self.target.name(rest, &format!("{name}_scaled_{i}_{j}"));
                    self.target.name(entry, &format!("{name}_{i}_{j}"));
                    scaled.push(rest);
                    row.push(entry);
                }
            }
            factor.lower.push(row);
        }
        self.factors.insert(system, factor.clone());
        factor
    }

    /// Entry of L⁻¹ = |D|^−½ U⁻¹.
    fn inverse_factor(&mut self, system: SystemId, row: usize, column: usize) -> ExprId {
        let reciprocal = self.factor(system).reciprocal[row];
        let is_negative = self.source.system(system).is_negative(row);
        let magnitude = if is_negative { self.target.neg(reciprocal) } else { reciprocal };
        let root = self.target.sqrt(magnitude);
        let name = self.source.system(system).name.clone();
        self.target.name(root, &format!("{name}_inverse_{row}_{row}"));
        if row == column {
            return root;
        }
        let entry = self.unit_inverse(system, row, column);
        let entry = self.target.mul(entry, root);
        self.target.name(entry, &format!("{name}_inverse_{row}_{column}"))
    }

    /// Entry of U⁻¹ below the diagonal: U⁻¹_ij = −U_ij − Σ_{k=j+1}^{i−1} U_ik U⁻¹_kj.
    fn unit_inverse(&mut self, system: SystemId, row: usize, column: usize) -> ExprId {
        if let Some(&known) = self.inverses.get(&(system, row, column)) {
            return known;
        }
        let factor = self.factor(system);
        let mut total = factor.lower[row][column];
        for k in column + 1..row {
            let inverse = self.unit_inverse(system, k, column);
            let product = self.target.mul(factor.lower[row][k], inverse);
            total = self.target.add(total, product);
        }
        let entry = self.target.neg(total);
        self.inverses.insert((system, row, column), entry);
        entry
    }

    /// U y = b, Uᵀ x = D⁻¹ y
    fn lower_solve(&mut self, solve: SolveId) -> Vec<ExprId> {
        if let Some(known) = self.solutions.get(&solve) {
            return known.clone();
        }
        let data = self.source.solve(solve).clone();
        let factor = self.factor(data.system);
        let order: Vec<usize> =
            (0..data.right_hand_side.len()).map(|k| self.source.system(data.system).eliminated(k)).collect();
        let size = order.len();
        let mut y: Vec<ExprId> = Vec::with_capacity(size);
        for i in 0..size {
            let mut rest = self.lower(data.right_hand_side[order[i]]);
            for k in 0..i {
                let product = self.target.mul(factor.lower[i][k], y[k]);
                rest = self.target.sub(rest, product);
            }
            let name = &self.source.system(data.system).name;
            y.push(self.target.name(rest, &format!("{name}_forward_{i}")));
        }
        let mut x: Vec<ExprId> = y
            .iter()
            .zip(&factor.reciprocal)
            .map(|(&y, &reciprocal)| self.target.mul(y, reciprocal))
            .collect();
        for i in (0..size).rev() {
            // The unknown found last comes last: nothing else waits for it.
            for k in (i + 1..size).rev() {
                let product = self.target.mul(factor.lower[k][i], x[k]);
                x[i] = self.target.sub(x[i], product);
            }
        }
        let mut solution = x.clone();
        for (position, row) in order.into_iter().enumerate() {
            solution[row] = x[position];
        }
        self.solutions.insert(solve, solution.clone());
        solution
    }

    fn pivot_ratio(&mut self, system: SystemId) -> ExprId {
        let factor = self.factor(system);
        let data = self.source.system(system).clone();
        let ratios: Vec<ExprId> = (0..data.size())
            .filter_map(|k| {
                let (row, pivot) = (data.eliminated(k), factor.pivots[k]);
                if data.is_compared(row) {
                    // A condition without unknowns takes nothing: its ratio is 0.
                    let mut taken = self.target.constant(f64::MIN_POSITIVE);
                    for j in (0..k).filter(|&j| !data.is_negative(j)) {
                        let square = self.target.mul(factor.lower[k][j], factor.lower[k][j]);
                        let term = self.target.mul(square, factor.pivots[j]);
                        taken = self.target.add(taken, term);
                    }
                    let pivot = self.target.neg(pivot);
                    return Some(self.target.div(pivot, taken));
                }
                let reference = self.lower(data.reference(row)?);
                Some(self.target.div(pivot, reference))
            })
            .collect();
        // Pivots after one that is not positive mean nothing, but the smallest is not above that one. A NaN after it is
        // not smaller; if all are NaN, so is the result.
        let mut smallest = ratios[0];
        for &ratio in &ratios[1..] {
            smallest = self.target.select_less(ratio, smallest, ratio, smallest);
        }
        smallest
    }

    fn lower_root(&mut self, root: RootId) -> (RootId, Vec<ExprId>) {
        if let Some(known) = self.roots.get(&root) {
            return known.clone();
        }
        let data = self.source.root(root).clone();
        let unknowns: Vec<ExprId> = data.unknowns.iter().map(|&u| self.lower_symbol(u)).collect();
        let residuals: Vec<ExprId> = data.residuals.iter().map(|&r| self.lower(r)).collect();
        let jacobian = data.jacobian.iter().map(|row| row.iter().map(|&x| self.lower(x)).collect()).collect();
        let lowered =
            self.target.add_root_with_jacobian(&data.name, &unknowns, residuals, jacobian, data.iteration);
        self.roots.insert(root, lowered.clone());
        assert!(lowered.1.iter().all(|&x| self.target.scope(x) == Scope::Element));
        lowered
    }
}
