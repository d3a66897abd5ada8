//! Memoised symbolic derivatives, one rule per operation.
//!
//! Structured operations have rules of their own: a sum over nodes, the solution of a symmetric positive
//! definite system and the root of a small system. The last two use the implicit function theorem, so that
//! nothing is differentiated through a factorisation or an iteration.

use std::collections::BTreeMap;

use super::{ExprId, Function, Graph, Op, PolynomialId, RootId, Scope, SolveId, SymbolId};
use crate::expr::MOST_BY_CRAMER;

impl Graph {
    /// ∂`expr`/∂`symbol`.
    ///
    /// Bound symbols are variables of their own: the chain through their definitions is for the caller. For a
    /// symbol of node scope, the derivative of a sum is that of the one term that belongs to the node.
    ///
    /// # Panics
    /// If `expr` contains an entry of a factorisation or a figure of an iteration: those are not differentiated.
    pub fn derivative(&mut self, expr: ExprId, symbol: SymbolId) -> ExprId {
        if let Some(&known) = self.derivatives.get(&(expr, symbol)) {
            return known;
        }
        let result = self.differentiate(expr, symbol);
        if let Some(name) = self.name_of(expr).map(str::to_owned)
            && !matches!(self.op(expr), Op::Symbol(_))
        {
            let by = self.symbol_data(symbol).name.clone();
            self.name(result, &format!("{name}_{by}"));
        }
        self.derivatives.insert((expr, symbol), result);
        result
    }

    /// ∂`expr`/∂`symbol` as formulas have it: by the chain rule through the quantities that they define.
    pub(crate) fn derivative_of_formula(&mut self, expr: ExprId, symbol: SymbolId) -> ExprId {
        let expr = self.written_out(&[expr], Some(symbol), &[])[0];
        // By a symbol of a node a sum within a sum changes the terms of all nodes.
        if self.symbol_data(symbol).scope == Scope::Node
            && let Some(inner) = self.sum_within_sum(expr)
        {
            let total = self.variable("inner_total");
            let outer = self.replace(expr, &[(inner, total)]);
            let total_symbol = self.symbol_of(total);
            let direct = self.derivative_of_formula(outer, symbol);
            let [by_total, by_symbol] =
                [(outer, total_symbol), (inner, symbol)].map(|(x, by)| self.derivative_of_formula(x, by));
            let through = self.mul(by_total, by_symbol);
            let derivative = self.add(direct, through);
            return self.substitute(derivative, &[(total_symbol, inner)]);
        }
        let by = self.intern(Op::Symbol(symbol));
        let mut total = self.zero();
        // Quantities come after what they are made of: the last one first.
        let one = self.one();
        let mut open = BTreeMap::from([(expr, (expr, one))]);
        while let Some((_, (x, outer))) = open.pop_last() {
            let inner = self.derivative(x, symbol);
            let product = if x == expr { inner } else { self.mul(outer, inner) };
            total = self.add(total, product);
            for (quantity, definition) in self.quantities_with(x, by) {
                let symbol = self.symbol_of(quantity);
                let inner = self.derivative(x, symbol);
                let product = self.mul(outer, inner);
                let zero = self.zero();
                let (_, sum) = open.get(&quantity).copied().unwrap_or((definition, zero));
                open.insert(quantity, (definition, self.add(sum, product)));
            }
        }
        total
    }

    /// A sum over the nodes within the terms of another one that has none within its own. Definitions are not entered.
    fn sum_within_sum(&self, expr: ExprId) -> Option<ExprId> {
        let is_sum = |x: &ExprId| matches!(self.op(*x), Op::Sum(_));
        let below = |x: ExprId| self.reachable(x, Self::operands).into_iter();
        let within = |x: ExprId| below(x).filter(move |y| *y != x).find(is_sum);
        let mut inner = below(expr).filter(is_sum).find_map(within)?;
        while let Some(x) = within(inner) {
            inner = x;
        }
        Some(inner)
    }

    /// The quantities in an expression that change with a symbol, and their definitions, which are not entered.
    pub(super) fn quantities_with(&self, expr: ExprId, symbol: ExprId) -> Vec<(ExprId, ExprId)> {
        if self.quantities.is_empty() {
            return Vec::new();
        }
        let within = self.reachable(expr, |g, x| match g.op(x) {
            Op::Symbol(_) => Vec::new(),
            _ => g.varying_dependencies(x),
        });
        let quantities = within.into_iter().filter_map(|x| match self.op(x) {
            Op::Symbol(quantity) if x != symbol && self.quantities.contains(&quantity) => {
                Some((x, self.symbol_data(quantity).definition?))
            }
            _ => None,
        });
        let changes = |definition| self.reachable(definition, Self::varying_dependencies).contains(&symbol);
        quantities.filter(|&(_, definition)| changes(definition)).collect()
    }

    /// Makes `derivative` the derivative of a symbol by another one, which is a direction that all symbols move in.
    pub(crate) fn set_derivative(&mut self, symbol: ExprId, by: SymbolId, derivative: ExprId) {
        self.derivatives.insert((symbol, by), derivative);
    }

    /// Makes mixed second derivatives of `expr` by these symbols one expression, whichever symbol comes first.
    pub(crate) fn unite_mixed_derivatives(&mut self, expr: ExprId, symbols: &[SymbolId]) {
        for (k, &later) in symbols.iter().enumerate() {
            for &earlier in &symbols[..k] {
                let by_earlier = self.derivative(expr, earlier);
                let mixed = self.derivative(by_earlier, later);
                let by_later = self.derivative(expr, later);
                self.derivatives.insert((by_later, earlier), mixed);
            }
        }
    }

    fn differentiate(&mut self, expr: ExprId, symbol: SymbolId) -> ExprId {
        match self.op(expr) {
            Op::Constant(_) => self.zero(),
            Op::Symbol(other) if other == symbol => self.one(),
            Op::Symbol(_) => self.zero(),
            // x + y -> x' + y'
            Op::Add(x, y) => {
                let (dx, dy) = (self.derivative(x, symbol), self.derivative(y, symbol));
                self.add(dx, dy)
            }
            // -x -> -x'
            Op::Neg(x) => {
                let dx = self.derivative(x, symbol);
                self.neg(dx)
            }
            // x y -> x' y + x y'
            Op::Mul(x, y) => {
                let (dx, dy) = (self.derivative(x, symbol), self.derivative(y, symbol));
                let (left, right) = (self.mul(dx, y), self.mul(x, dy));
                self.add(left, right)
            }
            // x / y -> (x' - (x / y) y') / y
            Op::Div(x, y) => {
                let (dx, dy) = (self.derivative(x, symbol), self.derivative(y, symbol));
                let correction = self.mul(expr, dy);
                let numerator = self.sub(dx, correction);
                self.div(numerator, y)
            }
            // the same, where y is not 0
            Op::DivOrZero(x, y) => {
                let (dx, dy) = (self.derivative(x, symbol), self.derivative(y, symbol));
                let correction = self.mul(expr, dy);
                let numerator = self.sub(dx, correction);
                self.div_or_zero(numerator, y)
            }
            // sqrt(x) -> x' / (2 sqrt(x))
            Op::Sqrt(x) => {
                let dx = self.derivative(x, symbol);
                let two = self.constant(2.0);
                let twice = self.mul(two, expr);
                self.div(dx, twice)
            }
            // exp(x) -> exp(x) x'
            Op::Exp(x) => {
                let dx = self.derivative(x, symbol);
                self.mul(expr, dx)
            }
            Op::Function(function, x) => self.differentiate_function(expr, function, x, symbol),
            // atan2(y, x) -> (x y' - y x') / (x^2 + y^2)
            Op::Atan2(y, x) => {
                let (dx, dy) = (self.derivative(x, symbol), self.derivative(y, symbol));
                let (left, right) = (self.mul(x, dy), self.mul(y, dx));
                let (numerator, square) = (self.sub(left, right), self.dot(&[x, y], &[x, y]));
                self.div(numerator, square)
            }
            // x^y -> y x^(y-1) x' + x^y ln(x) y'
            Op::RealPower(x, y) => {
                let (dx, dy) = (self.derivative(x, symbol), self.derivative(y, symbol));
                let (one, logarithm) = (self.one(), self.function(Function::Ln, x));
                let lowered = self.sub(y, one);
                let lowered = self.real_power(x, lowered);
                let (slope, growth) = (self.mul(y, lowered), self.mul(expr, logarithm));
                let (left, right) = (self.mul(slope, dx), self.mul(growth, dy));
                self.add(left, right)
            }
            // hypot(x, y) -> (x / hypot) x' + (y / hypot) y', with 0 for the direction at the origin
            Op::Hypot(x, y) => {
                let components = self.norm_components(expr);
                if components.len() > 2 {
                    // One root and one division for all components, and products that squares of the norm have, too.
                    let half_square = self.differentiate_half_square(&components, symbol);
                    return self.div_or_zero(half_square, expr);
                }
                let (dx, dy) = (self.derivative(x, symbol), self.derivative(y, symbol));
                let (cx, cy) = (self.div_or_zero(x, expr), self.div_or_zero(y, expr));
                let (left, right) = (self.mul(cx, dx), self.mul(cy, dy));
                self.add(left, right)
            }
            Op::Power(base, exponent) => self.differentiate_power(base, exponent, symbol),
            Op::Polynomial(base, polynomial) => self.differentiate_polynomial(base, polynomial, symbol),
            // the condition is locally constant
            Op::Select { x, y, then, otherwise } => match self.chain(expr, symbol) {
                Some((outer, inner)) if self.is_finite_factor(inner, symbol) => self.mul(outer, inner),
                _ => {
                    let (then, otherwise) =
                        (self.derivative(then, symbol), self.derivative(otherwise, symbol));
                    self.select_less(x, y, then, otherwise)
                }
            },
            Op::Sum(body) => {
                let derivative = self.derivative(body, symbol);
                match self.symbol_data(symbol).scope {
                    Scope::Node => derivative,
                    _ => self.sum(derivative),
                }
            }
            Op::Solution(solve, component) => self.differentiate_solution(solve, component, symbol),
            Op::RootValue(root, component) => self.differentiate_root(root, component as usize, symbol),
            op @ (Op::InverseFactor { .. } | Op::PivotRatio(_) | Op::RootFigure(..)) => {
                panic!("{op:?} is not differentiated: use the solution or the root it belongs to")
            }
        }
    }

    /// ln -> x' / x, sin -> cos(x) x', cos -> -sin(x) x', cbrt -> x' / (3 cbrt(x)^2)
    fn differentiate_function(
        &mut self,
        expr: ExprId,
        function: Function,
        x: ExprId,
        symbol: SymbolId,
    ) -> ExprId {
        let dx = self.derivative(x, symbol);
        match function {
            Function::Ln => self.div(dx, x),
            Function::Sin => {
                let cos = self.function(Function::Cos, x);
                self.mul(cos, dx)
            }
            Function::Cos => {
                let sin = self.function(Function::Sin, x);
                let slope = self.neg(sin);
                self.mul(slope, dx)
            }
            Function::Cbrt => {
                let (three, square) = (self.constant(3.0), self.mul(expr, expr));
                let divisor = self.mul(three, square);
                self.div(dx, divisor)
            }
        }
    }

    /// The components x, y, … of a norm √(x² + y² + …), made by one [`hypot`](Self::hypot) or by nested ones; none if it is
    /// no norm.
    pub(crate) fn norm_components(&self, norm: ExprId) -> Vec<ExprId> {
        let Op::Hypot(x, y) = self.op(norm) else { return Vec::new() };
        [x, y]
            .into_iter()
            .flat_map(|x| match self.norm_components(x) {
                components if components.is_empty() => vec![x],
                components => components,
            })
            .collect()
    }

    /// Σ x x' over the components of a norm.
    fn differentiate_half_square(&mut self, components: &[ExprId], symbol: SymbolId) -> ExprId {
        let derivatives: Vec<ExprId> = components.iter().map(|&x| self.derivative(x, symbol)).collect();
        self.dot(components, &derivatives)
    }

    /// x^k -> k x^(k-1) x'; for a norm r of (x, y, …) and k >= 2: r^k -> k r^(k-2) (x x' + y y' + …), which is
    /// free of the norm's singular direction at the origin.
    fn differentiate_power(&mut self, base: ExprId, exponent: i32, symbol: SymbolId) -> ExprId {
        let k = self.constant(f64::from(exponent));
        let components = self.norm_components(base);
        let (lowered, inner) = if !components.is_empty() && exponent >= 2 {
            (self.power(base, exponent - 2), self.differentiate_half_square(&components, symbol))
        } else {
            let lowered = match exponent.checked_sub(1) {
                Some(lower) => self.power(base, lower),
                None => {
                    let whole = self.power(base, exponent);
                    self.div(whole, base)
                }
            };
            (lowered, self.derivative(base, symbol))
        };
        let outer = self.mul(k, lowered);
        self.mul(outer, inner)
    }

    /// P(x) -> P'(x) x'; for a norm r of (x, y, …) with P'(0) = 0: P(r) -> (P'(r) / r) (x x' + y y' + …), where P' / r is
    /// a polynomial.
    fn differentiate_polynomial(
        &mut self,
        base: ExprId,
        polynomial: PolynomialId,
        symbol: SymbolId,
    ) -> ExprId {
        let (outer, inner) = self.chain_of_polynomial(base, polynomial, symbol);
        self.mul(outer, inner)
    }

    /// The two factors of that derivative.
    fn chain_of_polynomial(
        &mut self,
        base: ExprId,
        polynomial: PolynomialId,
        symbol: SymbolId,
    ) -> (ExprId, ExprId) {
        let derivative = self.polynomial_data(polynomial).derivative();
        let components = self.norm_components(base);
        match derivative.over_x() {
            Some(over_r) if !components.is_empty() => {
                (self.polynomial(base, over_r), self.differentiate_half_square(&components, symbol))
            }
            // The same of a norm with factors, by its square.
            Some(over_r) if self.has_norm(base) => {
                let square = self.power(base, 2);
                let (half, of_square) = (self.constant(0.5), self.derivative(square, symbol));
                (self.polynomial(base, over_r), self.mul(half, of_square))
            }
            _ => (self.polynomial(base, derivative), self.derivative(base, symbol)),
        }
    }

    /// A derivative as two factors, of which the second is the same for all that a choice among polynomials of one quantity and constants
    /// chooses from: only the first one has to be chosen, once for all symbols. `None` if it is no such choice.
    fn chain(&mut self, expr: ExprId, symbol: SymbolId) -> Option<(ExprId, ExprId)> {
        match self.op(expr) {
            Op::Polynomial(base, polynomial) => Some(self.chain_of_polynomial(base, polynomial, symbol)),
            Op::Select { x, y, then, otherwise } => {
                let [first, second] = [then, otherwise].map(|choice| match self.op(choice) {
                    Op::Constant(_) => Some(None),
                    _ => self.chain(choice, symbol).map(Some),
                });
                let zero = self.zero();
                let (outer, inner) = match (first?, second?) {
                    (Some((then, inner)), Some((otherwise, other))) if inner == other => {
                        ((then, otherwise), inner)
                    }
                    (Some((then, inner)), None) => ((then, zero), inner),
                    (None, Some((otherwise, inner))) => ((zero, otherwise), inner),
                    _ => return None,
                };
                Some((self.select_less(x, y, outer.0, outer.1), inner))
            }
            _ => None,
        }
    }

    /// Whether a derivative by a symbol may be multiplied by zero where a choice leaves it out. Inputs that others are divided by, such as
    /// a radius, are taken for other than zero, unless they are [free](Self::free_divisors).
    fn is_finite_factor(&self, derivative: ExprId, by: SymbolId) -> bool {
        self.is_finite_over(derivative, |divisor| match self.op(divisor) {
            Op::Symbol(symbol) if !self.has_free_divisors => {
                symbol != by && self.symbol_data(symbol).definition.is_none()
            }
            _ => false,
        })
    }

    /// A x = b -> A x' = b' - A' x: one more right-hand side for the same factorisation.
    fn differentiate_solution(&mut self, solve: SolveId, component: u32, symbol: SymbolId) -> ExprId {
        let system = self.solve(solve).system;
        let right_hand_side = self.solve(solve).right_hand_side.clone();
        let solution: Vec<ExprId> =
            (0..right_hand_side.len()).map(|k| self.intern(Op::Solution(solve, k as u32))).collect();
        let mut derived = Vec::with_capacity(right_hand_side.len());
        for (row, b) in right_hand_side.into_iter().enumerate() {
            let mut total = self.derivative(b, symbol);
            for (column, &x) in solution.iter().enumerate() {
                let entry = self.system(system).entry(row, column);
                let entry = self.derivative(entry, symbol);
                let product = self.mul(entry, x);
                total = self.sub(total, product);
            }
            derived.push(total);
        }
        if derived.iter().all(|&b| self.is_zero(b)) {
            return self.zero();
        }
        self.solve_symmetric_once(system, &derived)[component as usize]
    }

    /// r(y, x) = 0 -> y' = -r_y^-1 r_x, for more than three equations with a search for pivots
    fn differentiate_root(&mut self, root: RootId, component: usize, symbol: SymbolId) -> ExprId {
        let data = self.root(root).clone();
        let at_root: Vec<(SymbolId, ExprId)> = data
            .unknowns
            .iter()
            .enumerate()
            .map(|(k, &unknown)| (unknown, self.intern(Op::RootValue(root, k as u32))))
            .collect();
        let minus_partial: Vec<ExprId> = data
            .residuals
            .iter()
            .map(|&residual| {
                let partial = self.derivative(residual, symbol);
                self.neg(partial)
            })
            .collect();
        if data.unknowns.len() <= MOST_BY_CRAMER {
            let derivatives = self.solve_small(&data.jacobian, &minus_partial);
            return self.substitute(derivatives[component], &at_root);
        }
        let minus_partial = self.substitute_all(&minus_partial, &at_root);
        if minus_partial.iter().all(|&x| self.is_zero(x)) {
            return self.zero();
        }
        let jacobian: Vec<Vec<ExprId>> =
            data.jacobian.iter().map(|row| self.substitute_all(row, &at_root)).collect();
        self.solve_general(&format!("{}_derivative", data.name), &jacobian, &minus_partial).1[component]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{Iteration, SymmetricSystem};
    use crate::interpret::{Interpreter, NodeInputs};

    /// Value of an element expression of x.
    fn value(g: &Graph, expr: ExprId, x: f64) -> f64 {
        let mut inputs = NodeInputs::new(0);
        inputs.set_element("x", x);
        Interpreter::new(g, &inputs).element(expr)
    }

    /// Compares the derivative with a central difference; returns the derivative's value.
    fn check(build: impl Fn(&mut Graph, ExprId) -> ExprId, at: f64) -> f64 {
        let mut g = Graph::new();
        let x = g.input("x", Scope::Element);
        let f = build(&mut g, x);
        let symbol = g.symbol_of(x);
        let df = g.derivative(f, symbol);
        let h = 1e-5;
        let difference = (value(&g, f, at + h) - value(&g, f, at - h)) / (2.0 * h);
        let derivative = value(&g, df, at);
        assert!(
            (derivative - difference).abs() < 1e-8 * (1.0 + difference.abs()),
            "{derivative} {difference}"
        );
        derivative
    }

    #[test]
    fn elementary_rules() {
        check(|g, x| g.add(x, x), 0.7);
        check(|g, x| g.neg(x), 0.7);
        check(|g, x| g.mul(x, x), 0.7);
        check(|g, x| g.sqrt(x), 0.7);
        check(|g, x| g.exp(x), 0.7);
        check(|g, x| g.power(x, -3), 0.7);
        for function in [Function::Ln, Function::Sin, Function::Cos, Function::Cbrt] {
            check(|g, x| g.function(function, x), 0.7);
        }
        for at in [0.7, -0.7] {
            check(|g, x| g.function(Function::Cbrt, x), at);
            check(
                |g, x| {
                    let (minus_one, xx) = (g.constant(-1.0), g.mul(x, x));
                    let y = g.add(xx, minus_one);
                    g.atan2(x, y)
                },
                at,
            );
        }
        let exponent = |number: f64| {
            check(
                |g, x| {
                    let number = g.constant(number);
                    g.real_power(x, number)
                },
                0.7,
            )
        };
        assert!((exponent(2.3) - 2.3 * 0.7_f64.powf(1.3)).abs() < 1e-15);
        // (xˣ)' = xˣ (ln x + 1)
        let slope = check(|g, x| g.real_power(x, x), 0.7);
        assert!((slope - 0.7_f64.powf(0.7) * (0.7_f64.ln() + 1.0)).abs() < 1e-15);
        check(
            |g, x| {
                let (one, xx) = (g.one(), g.mul(x, x));
                let denominator = g.add(one, xx);
                g.div(x, denominator)
            },
            0.7,
        );
        check(
            |g, x| {
                let three = g.constant(3.0);
                let r = g.hypot(x, three);
                g.power(r, 3)
            },
            0.7,
        );
        check(
            |g, x| {
                let (half, xx) = (g.constant(0.5), g.mul(x, x));
                g.select_less(x, half, xx, x)
            },
            0.7,
        );
    }

    #[test]
    fn a_power_of_a_norm_has_finite_derivatives_at_the_origin() {
        let mut g = Graph::new();
        let x = g.input("x", Scope::Element);
        let y = g.zero();
        let r = g.hypot(x, y);
        let cube = g.power(r, 3);
        let symbol = g.symbol_of(x);
        let first = g.derivative(cube, symbol);
        let second = g.derivative(first, symbol);
        for (at, expected) in [(0.0, 0.0), (1e-200, 6e-200), (0.5, 3.0)] {
            assert_eq!(value(&g, second, at), expected);
        }
    }

    #[test]
    fn a_polynomial_of_a_norm_has_finite_derivatives_at_the_origin_and_no_lost_digits_at_one() {
        let mut g = Graph::new();
        let x = g.input("x", Scope::Element);
        let y = g.zero();
        let r = g.hypot(x, y);
        let w = g.polynomial(r, crate::graph::Polynomial::new(vec![1.0, 0.0, -3.0, 2.0]));
        let symbol = g.symbol_of(x);
        let first = g.derivative(w, symbol);
        let second = g.derivative(first, symbol);
        for (at, expected) in [(0.0, -6.0), (1e-200, -6.0), (0.25, -3.0)] {
            assert!((value(&g, second, at) - expected).abs() < 1e-15, "{at}");
        }
        let near_one = 1.0 - 1e-8;
        let t = 1.0 - near_one;
        assert!((value(&g, w, near_one) / (t * t * (1.0 + 2.0 * near_one)) - 1.0).abs() < 1e-14);
        assert!((value(&g, first, near_one) / (-6.0 * near_one * t) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn a_norm_of_three_has_one_root_and_no_direction_at_the_origin() {
        let mut g = Graph::new();
        let x = g.input("x", Scope::Element);
        let (y, z) = (g.constant(2.0), g.mul(x, x));
        for (y, at, expected) in [(y, 3.0, 3.0 * (1.0 + 18.0) / 94.0_f64.sqrt()), (g.zero(), 0.0, 0.0)] {
            let norm = g.hypot(x, y);
            let norm = g.hypot(norm, z);
            let symbol = g.symbol_of(x);
            let derivative = g.derivative(norm, symbol);
            assert!((value(&g, derivative, at) - expected).abs() < 1e-14, "{at}");
        }
    }

    /// The choice does not depend on what is differentiated by.
    #[test]
    fn a_choice_among_polynomials_is_made_once_for_all_symbols() {
        let mut g = Graph::new();
        let [x, y] = ["x", "y"].map(|name| g.input(name, Scope::Element));
        let (r, one, zero) = (g.hypot(x, y), g.one(), g.zero());
        let w = g.polynomial(r, crate::graph::Polynomial::new(vec![1.0, 0.0, -3.0, 2.0]));
        let w = g.select_less(r, one, w, zero);
        let [by_x, by_y] = [x, y].map(|s| {
            let symbol = g.symbol_of(s);
            g.derivative(w, symbol)
        });
        let choices = |g: &Graph| {
            let mut reached = vec![by_x, by_y];
            let mut found = std::collections::BTreeSet::new();
            while let Some(expr) = reached.pop() {
                if matches!(g.op(expr), Op::Select { .. }) {
                    found.insert(expr);
                }
                reached.extend(g.operands(expr));
            }
            found.len()
        };
        assert_eq!(choices(&g), 1);
    }

    #[test]
    fn mixed_derivatives_are_one_expression_once_united() {
        let mut g = Graph::new();
        let [x, y] = ["x", "y"].map(|name| g.input(name, Scope::Element));
        let (r, xxx) = (g.hypot(x, y), g.power(x, 3));
        let cube = g.power(r, 3);
        let f = g.mul(cube, xxx);
        let [x, y] = [x, y].map(|s| g.symbol_of(s));
        g.unite_mixed_derivatives(f, &[x, y]);
        let (by_x, by_y) = (g.derivative(f, x), g.derivative(f, y));
        assert_eq!(g.derivative(by_x, y), g.derivative(by_y, x));
    }

    #[test]
    fn a_solution_is_differentiated_by_another_solve() {
        // (2 + x²) y = x
        let twice = |build_second: bool| {
            check(
                |g, x| {
                    let (two, xx) = (g.constant(2.0), g.mul(x, x));
                    let entry = g.add(two, xx);
                    let system = g.add_system(SymmetricSystem::new("test", vec![vec![entry]], vec![0]));
                    let y = g.solve_symmetric(system, vec![x])[0];
                    let symbol = g.symbol_of(x);
                    if build_second { g.derivative(y, symbol) } else { y }
                },
                0.7,
            )
        };
        twice(false);
        let second = twice(true);
        // y = x / (2 + x²): y'' = 2x (x² − 6) / (2 + x²)³
        let x: f64 = 0.7;
        assert!((second - 2.0 * x * (x * x - 6.0) / (2.0 + x * x).powi(3)).abs() < 1e-14);
    }

    #[test]
    fn a_root_is_differentiated_by_the_implicit_function_theorem() {
        // u³ + u + u v = x, v − u² x = 0
        for second in [false, true] {
            check(
                |g, x| {
                    let (u, v) = (g.variable("u"), g.variable("v"));
                    let (u3, uv) = (g.power(u, 3), g.mul(u, v));
                    let left = g.total(&[u3, u, uv]);
                    let first = g.sub(left, x);
                    let uu = g.mul(u, u);
                    let uux = g.mul(uu, x);
                    let other = g.sub(v, uux);
                    let (_, values) = g.add_root("test", &[u, v], vec![first, other], Iteration::Newton);
                    let product = g.mul(values[0], values[1]);
                    let symbol = g.symbol_of(x);
                    if second { g.derivative(product, symbol) } else { product }
                },
                0.7,
            );
        }
    }
}
