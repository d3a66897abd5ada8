//! Variables that move with a parameter: total derivatives by the implicit function theorem and the chain rule.

use crate::expr::{Expr, Matrix, Values, Vector};

/// A parameter and the variables that move with it.
#[derive(Clone, Debug)]
pub struct Follower<'g> {
    parameter: Expr<'g>,
    moves: Values<'g>,
}

impl<'g> Follower<'g> {
    /// A parameter that nothing follows yet.
    pub const fn new(parameter: Expr<'g>) -> Self {
        Self { parameter, moves: Vec::new() }
    }

    /// The parameter α.
    pub const fn parameter(&self) -> Expr<'g> {
        self.parameter
    }

    /// The variables v that follow, with their dv/dα.
    pub(super) fn moves(&self) -> &[(Expr<'g>, Expr<'g>)] {
        &self.moves
    }

    /// Adds variables v with their dv/dα.
    pub fn follow(&mut self, moves: impl IntoIterator<Item = (Expr<'g>, Expr<'g>)>) {
        self.moves.extend(moves);
    }

    /// Adds variables v that are the root of r(v, α) = 0, which may also contain what follows already: dv/dα =
    /// −r_v⁻¹ dr/dα. All of it is evaluated where the variables have the values `at`.
    pub fn follow_root<const N: usize>(
        &mut self,
        variables: Vector<'g, N>,
        equations: Vector<'g, N>,
        inverse_jacobian: Matrix<'g, N, N>,
        at: &[(Expr<'g>, Expr<'g>)],
    ) {
        let minus_change = equations.map(|r| -self.total_derivative(r).at(at));
        self.follow(variables.set_to(inverse_jacobian * minus_change));
    }

    /// df/dα = ∂f/∂α + Σ ∂f/∂v dv/dα
    pub fn total_derivative(&self, f: Expr<'g>) -> Expr<'g> {
        self.moves.iter().fold(f.by(self.parameter), |total, &(v, change)| total + f.by(v) * change)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Sheet;
    use crate::graph::Scope;
    use crate::interpret::{Interpreter, NodeInputs};

    #[test]
    fn a_root_follows_and_so_does_what_depends_on_it() {
        // v² = α, q = v³: dq/dα = 3/2 √α
        let sheet = Sheet::new();
        let alpha = sheet.input("alpha", Scope::Element);
        let (v, q) = (sheet.variable("v"), sheet.variable("q"));
        let equation = Vector([v * v - alpha]);
        let at = [(v, sheet.number(1.5))];

        let inverse = equation.jacobian(Vector([v])).at(&at).inverse();
        let mut follower = Follower::new(alpha);
        follower.follow_root(Vector([v]), equation, inverse, &at);
        follower.follow([(q, follower.total_derivative(v.powi(3)))]);
        let total = follower.total_derivative(q).at(&at).id();

        let mut inputs = NodeInputs::new(0);
        inputs.set_element("alpha", 2.25);
        assert_eq!(Interpreter::new(&sheet.into_graph(), &inputs).element(total), 2.25);
    }
}
