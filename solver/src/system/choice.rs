//! Which solver takes a system.

use super::{
    Accuracy, BlockMatrix, DirectSolver, Equations, Geometry, IterativeReport, Operator, Symmetry,
    SystemError, solve_iteratively,
};

/// From so many equations on the choice by size is iterative: of solids with edges of like length the factors are the slower way by then.
const ITERATIVE_FROM: usize = 20_000;
/// Up to so many equations a system that was not solved iteratively is solved directly: its factors fit into a few gigabytes.
const DIRECT_UP_TO: usize = 250_000;

/// What a deck asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LinearSolverChoice {
    /// By the number of equations; factors for a matrix with friction as long as they fit into a few gigabytes. What the factors of do not
    /// fit into memory is solved iteratively.
    #[default]
    Auto,
    /// Sparse factors, exact to rounding: their memory grows faster than the number of equations.
    Direct,
    /// Conjugate gradients or GMRES with algebraic multigrid, to the accuracy that Newton's method has use for.
    Iterative,
}

impl LinearSolverChoice {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Auto, Self::Direct, Self::Iterative];

    /// Name in decks.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Direct => "direct",
            Self::Iterative => "iterative",
        }
    }
}

/// A system to solve.
#[derive(Clone, Copy)]
pub struct LinearSystem<'a> {
    /// The matrix over all nodes.
    pub matrix: &'a BlockMatrix,
    /// What is added to it without being assembled: it has no factors, and such a system is always solved iteratively.
    pub operator: Option<&'a dyn Operator>,
    /// Which of it is free.
    pub equations: &'a Equations,
    /// What is known of the matrix.
    pub symmetry: Symmetry,
    /// Whether friction is in it, where restarted GMRES may stand still.
    pub has_friction: bool,
    /// For the preconditioner.
    pub geometry: Geometry<'a>,
}

/// How a solution went.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum LinearReport {
    /// By factors.
    Direct,
    /// By iteration.
    Iterative {
        /// Iterations.
        iterations: usize,
        /// The size of the right-hand side, see [`Accuracy`].
        size: f64,
        /// Memory of matrix, preconditioner and vectors, bytes.
        bytes: usize,
    },
    /// By factors, since the iterative solution did not converge within so many iterations.
    Instead {
        /// Iterations that were in vain.
        iterations: usize,
    },
}

/// Solves systems directly or iteratively. What it keeps from one to the next is the symbolic factorisation, and whether factors were too
/// large.
#[derive(Default)]
pub struct LinearSolver {
    choice: LinearSolverChoice,
    direct: DirectSolver,
    /// Whether factors were too large for the machine where there is another way: they are not tried again.
    is_too_large: bool,
}

impl LinearSolver {
    /// `threads`: those of factorisations; products use those of the current rayon pool.
    #[must_use]
    pub fn new(choice: LinearSolverChoice, threads: usize) -> Self {
        Self { choice, direct: DirectSolver::new(threads), is_too_large: false }
    }

    /// Takes another choice.
    pub fn choose(&mut self, choice: LinearSolverChoice) {
        (self.choice, self.is_too_large) = (choice, false);
    }

    /// Whether systems of so many equations without friction are solved iteratively.
    #[must_use]
    pub fn is_iterative(&self, equations: &Equations) -> bool {
        self.takes_iterations(equations.len())
    }

    fn takes_iterations(&self, equations: usize) -> bool {
        match self.choice {
            LinearSolverChoice::Auto => equations >= ITERATIVE_FROM || self.is_too_large,
            LinearSolverChoice::Direct => false,
            LinearSolverChoice::Iterative => true,
        }
    }

    /// Treats the next matrix as one of a new structure when it looks for singular ones.
    pub fn forget(&mut self) {
        self.direct.forget();
    }

    #[cfg(test)]
    pub(crate) fn is_probed(&self) -> bool {
        self.direct.is_probed()
    }

    /// Solves K x = b; an iterative solution is as accurate as asked. `rhs` and `solution` are over all nodes;
    /// prescribed ones are not read, and 0 in the solution.
    ///
    /// # Errors
    /// Those of [`DirectSolver`] and [`solve_iteratively`]. Then `solution` is of no use.
    pub fn solve(
        &mut self,
        system: &LinearSystem<'_>,
        rhs: &[[f64; 3]],
        accuracy: Accuracy,
        solution: &mut Vec<[f64; 3]>,
    ) -> Result<LinearReport, SystemError> {
        let &LinearSystem { operator, equations, symmetry, has_friction, .. } = system;
        let may_stand_still = symmetry == Symmetry::General && has_friction;
        if operator.is_none() && self.takes_factors(equations.len(), may_stand_still) {
            match self.solve_directly(system, rhs, solution) {
                Err(SystemError::TooLarge { .. }) if self.choice == LinearSolverChoice::Auto => {
                    self.is_too_large = true;
                }
                solved => return solved.map(|()| LinearReport::Direct),
            }
        }
        let unsolved = match solve_iteratively(system, rhs, accuracy, solution) {
            Ok(IterativeReport { iterations, size, bytes, .. }) => {
                return Ok(LinearReport::Iterative { iterations, size, bytes });
            }
            Err(error) => error,
        };
        let SystemError::NotConverged { iterations, .. } = unsolved else { return Err(unsolved) };
        if operator.is_some() || self.is_too_large || equations.len() > DIRECT_UP_TO {
            return Err(unsolved);
        }
        match self.solve_directly(system, rhs, solution) {
            Ok(()) => Ok(LinearReport::Instead { iterations }),
            // A shorter increment may do with iterations.
            Err(SystemError::TooLarge { .. }) => {
                self.is_too_large = true;
                Err(unsolved)
            }
            Err(error) => Err(error),
        }
    }

    /// Whether factors come first for so many equations of a matrix that has some.
    fn takes_factors(&self, equations: usize, may_stand_still: bool) -> bool {
        let is_better =
            self.choice == LinearSolverChoice::Auto && may_stand_still && equations <= DIRECT_UP_TO;
        !self.is_too_large && is_better || !self.takes_iterations(equations)
    }

    fn solve_directly(
        &mut self,
        system: &LinearSystem<'_>,
        rhs: &[[f64; 3]],
        solution: &mut Vec<[f64; 3]>,
    ) -> Result<(), SystemError> {
        self.direct.factorise(system.matrix, system.equations, system.symmetry)?;
        self.direct.solve(rhs, solution).map(drop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Factors of 144,000 equations take gigabytes and minutes: only friction, where iterations may be in vain, is worth them.
    #[test]
    fn factors_of_large_systems_are_for_friction_alone() {
        let mut solver = LinearSolver::new(LinearSolverChoice::Auto, 1);
        let found = [10_000, 144_000, 300_000].map(|equations| {
            [false, true].map(|may_stand_still| solver.takes_factors(equations, may_stand_still))
        });
        assert_eq!(found, [[true, true], [false, true], [false, false]]);
        solver.is_too_large = true;
        assert!([10_000, 144_000].iter().all(|&equations| !solver.takes_factors(equations, true)));
        // Who asks for factors gets them, or is told.
        solver.choose(LinearSolverChoice::Direct);
        assert!(solver.takes_factors(300_000, false));
        solver.choose(LinearSolverChoice::Iterative);
        assert!(!solver.takes_factors(10_000, true));
    }
}
