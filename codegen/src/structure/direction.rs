//! Derivatives along a direction: forward mode.
//!
//! All symbols move at once, each at a rate of its own. A variable's rate is its entry of the direction. The rate of a bound symbol is
//! that of its definition. The rates are put where the derivative engine looks for derivatives it knows. Its rules then give the rate of
//! any expression, each operation once, however many variables there are.
//!
//! The product of a Hessian with the direction is the rate of the gradient. So it takes a few times the operations of the gradient.

use rustc_hash::FxHashSet;

use crate::expr::{Expr, Sheet};
use crate::graph::{ExprId, Op};

/// Suffix of a rate's name: `J_rate`.
const RATE: &str = "rate";

/// A direction that variables move in.
pub struct Direction<'g> {
    sheet: &'g Sheet,
    /// What everything is differentiated by; no expression contains it.
    rate: Expr<'g>,
    known: FxHashSet<ExprId>,
}

impl<'g> Direction<'g> {
    /// Variables, each with its rate, of the same scope.
    pub fn new(sheet: &'g Sheet, rates: impl IntoIterator<Item = (Expr<'g>, Expr<'g>)>) -> Self {
        let mut direction = Self { sheet, rate: sheet.variable(RATE), known: FxHashSet::default() };
        for (variable, rate) in rates {
            direction.set(variable.id(), rate.id());
        }
        direction
    }

    /// The derivative of an expression along the direction, through all that is bound in it.
    pub fn derivative(&mut self, x: Expr<'g>) -> Expr<'g> {
        for (symbol, definition) in self.bound_in(x) {
            let operation = self.sheet.graph().op(definition);
            let rate = match operation {
                // Of a norm it is 0 where the norm is.
                Op::Sqrt(square) if self.sheet.expr(symbol).is_norm_symbol() => {
                    (0.5 * self.sheet.expr(square).by(self.rate)).div_or_zero(self.sheet.expr(symbol))
                }
                _ => self.sheet.expr(definition).by(self.rate),
            };
            let rate = match rate.value() {
                Some(_) => rate,
                // One quantity, which products with it do not take apart.
                None => {
                    let name = format!("{}_{RATE}", self.sheet.expr(symbol).symbol_name());
                    self.sheet.make(|g| g.bind_unique(&name, rate.id()))
                }
            };
            self.set(symbol, rate.id());
        }
        x.by(self.rate)
    }

    fn set(&mut self, symbol: ExprId, rate: ExprId) {
        let by = self.rate.symbol();
        self.sheet.edit(|g| g.set_derivative(symbol, by, rate));
        self.known.insert(symbol);
    }

    /// Bound symbols without a rate, with their definitions, each after those it depends on.
    fn bound_in(&self, x: Expr<'g>) -> Vec<(ExprId, ExprId)> {
        let graph = self.sheet.graph();
        let (mut order, mut seen) = (Vec::new(), self.known.clone());
        // A symbol is listed when all below it is: it is met a second time then.
        let mut open = vec![(x.id(), false)];
        while let Some((expr, is_done)) = open.pop() {
            if is_done {
                order.extend(graph.varying_dependencies(expr).first().map(|&definition| (expr, definition)));
            } else if seen.insert(expr) {
                if matches!(graph.op(expr), Op::Symbol(_)) {
                    open.push((expr, true));
                }
                open.extend(graph.varying_dependencies(expr).into_iter().map(|x| (x, false)));
            }
        }
        order
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Vector;
    use crate::graph::{Scope, SymmetricSystem};
    use crate::interpret::{Interpreter, NodeInputs};

    /// The rate of f(x, y) in a direction against ∂f/∂x v + ∂f/∂y w, where f is written without bound symbols.
    fn check<'g>(sheet: &'g Sheet, bound: Expr<'g>, plain: Expr<'g>, [x, y, v, w]: [Expr<'g>; 4]) {
        let rate = Direction::new(sheet, [(x, v), (y, w)]).derivative(bound);
        let expected = plain.by(x) * v + plain.by(y) * w;
        let mut inputs = NodeInputs::new(0);
        for (symbol, value) in [x, y, v, w].into_iter().zip([0.7, 1.3, -0.4, 0.9]) {
            inputs.set_element(&symbol.symbol_name(), value);
        }
        let graph = sheet.graph();
        let mut interpreter = Interpreter::new(&graph, &inputs);
        let [rate, expected] = [rate, expected].map(|x| interpreter.element(x.id()));
        assert!((rate - expected).abs() < 1e-14 * expected.abs(), "{rate} {expected}");
    }

    #[test]
    fn rates_go_through_what_is_bound() {
        let sheet = Sheet::new();
        let all = ["x", "y", "v", "w"].map(|name| sheet.input(name, Scope::Element));
        let [x, y, ..] = all;
        let f = |bind: bool| {
            let length = (x * x + y * y).sqrt();
            let length = if bind { length.bind("length") } else { length };
            let angle = (length * y).sin();
            let angle = if bind { angle.bind("angle") } else { angle };
            angle * length.exp() + y.ln() * length
        };
        let plain = f(false);
        check(&sheet, f(true), plain, all);
    }

    #[test]
    fn rates_go_through_systems_and_roots() {
        let sheet = Sheet::new();
        let all = ["x", "y", "v", "w"].map(|name| sheet.input(name, Scope::Element));
        let [x, y, ..] = all;
        // u = 1/(x y²) (…), by Cramer's rule and by a symmetric system with what is bound in it.
        let (a, b, c) = (2.0 + x, y, 3.0 + x * y);
        let plain = (c * x - b * y) / (a * c - b * b);
        let bound = c.bind("c");
        let system = SymmetricSystem::of("system", &[vec![a], vec![b, bound]], vec![0, 1]);
        let solution = sheet.system(system).solve(&[x, y]);
        check(&sheet, solution[0].bind("u") * y, plain * y, all);

        // r = x y − r + 0.2 has the root r = (x y + 0.2)/1.
        let q = (x * y).bind("q");
        let unknowns = sheet.variables(["r", "s"]);
        let (_, root) =
            sheet.root("root", unknowns, Vector([unknowns[0] - q - 0.2, unknowns[1] - unknowns[0] * y]));
        check(&sheet, root[1].exp(), ((x * y + 0.2) * y).exp(), all);
    }

    #[test]
    fn what_does_not_move_has_no_rate() {
        let sheet = Sheet::new();
        let [x, k, v] = ["x", "k", "v"].map(|name| sheet.input(name, Scope::Element));
        let mut direction = Direction::new(&sheet, [(x, v)]);
        let constant = (k * k).bind("constant");
        assert!(direction.derivative(constant.exp()).is_zero());
        assert_eq!(direction.derivative(constant * x), constant * v);
    }
}
