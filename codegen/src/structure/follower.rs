//! Variables that move with a parameter: total derivatives by the implicit function theorem and the chain rule.

use crate::graph::{ExprId, Graph, SymbolId};

/// A parameter and the variables that move with it.
#[derive(Clone, Debug)]
pub struct Follower {
    parameter: SymbolId,
    moves: Vec<(SymbolId, ExprId)>,
}

impl Follower {
    /// A parameter that nothing follows yet.
    #[must_use]
    pub const fn new(parameter: SymbolId) -> Self {
        Self { parameter, moves: Vec::new() }
    }

    /// The parameter α.
    #[must_use]
    pub const fn parameter(&self) -> SymbolId {
        self.parameter
    }

    /// The variables v that follow, with their dv/dα.
    pub(super) fn moves(&self) -> &[(SymbolId, ExprId)] {
        &self.moves
    }

    /// Adds variables v with their dv/dα.
    pub fn follow(&mut self, moves: impl IntoIterator<Item = (SymbolId, ExprId)>) {
        self.moves.extend(moves);
    }

    /// Adds variables v that are the root of r(v, α) = 0, which may also contain what follows already: dv/dα =
    /// −r_v⁻¹ dr/dα. All of it is evaluated where the variables have the values `at`.
    pub fn follow_root(
        &mut self,
        g: &mut Graph,
        variables: &[SymbolId],
        equations: &[ExprId],
        inverse_jacobian: &[Vec<ExprId>],
        at: &[(SymbolId, ExprId)],
    ) {
        let minus_change: Vec<ExprId> = equations
            .iter()
            .map(|&equation| {
                let change = self.total_derivative(g, equation);
                let change = g.substitute(change, at);
                g.neg(change)
            })
            .collect();
        let changes: Vec<ExprId> = inverse_jacobian.iter().map(|row| g.dot(row, &minus_change)).collect();
        self.follow(variables.iter().copied().zip(changes));
    }

    /// d expr/dα = ∂expr/∂α + Σ ∂expr/∂v dv/dα
    pub fn total_derivative(&self, g: &mut Graph, expr: ExprId) -> ExprId {
        let mut total = g.derivative(expr, self.parameter);
        for &(variable, change) in &self.moves {
            let partial = g.derivative(expr, variable);
            let product = g.mul(partial, change);
            total = g.add(total, product);
        }
        total
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Scope;
    use crate::interpret::{Interpreter, NodeInputs};

    #[test]
    fn a_root_follows_and_so_does_what_depends_on_it() {
        // v² = α, q = v³: dq/dα = 3/2 √α
        let mut g = Graph::new();
        let alpha = g.input("alpha", Scope::Element);
        let (v, q) = (g.variable("v"), g.variable("q"));
        let square = g.mul(v, v);
        let equation = g.sub(square, alpha);
        let cube = g.power(v, 3);
        let [alpha, v, q_symbol] = [alpha, v, q].map(|x| g.symbol_of(x));
        let at = [(v, g.constant(1.5))];

        let slope = g.derivative(equation, v);
        let slope = g.substitute(slope, &at);
        let inverse = g.inverse_small(&[vec![slope]]);
        let mut follower = Follower::new(alpha);
        follower.follow_root(&mut g, &[v], &[equation], &inverse, &at);
        let change = follower.total_derivative(&mut g, cube);
        follower.follow([(q_symbol, change)]);
        let total = follower.total_derivative(&mut g, q);
        let total = g.substitute(total, &at);

        let mut inputs = NodeInputs::new(0);
        inputs.set_element("alpha", 2.25);
        assert_eq!(Interpreter::new(&g, &inputs).element(total), 2.25);
    }
}
