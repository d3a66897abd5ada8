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
    /// By the number of equations; factors for a matrix that is not symmetric as long as they fit into a few gigabytes.
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

/// Solves systems directly or iteratively. What it keeps from one to the next is the symbolic factorisation alone.
#[derive(Default)]
pub struct LinearSolver {
    choice: LinearSolverChoice,
    direct: DirectSolver,
}

impl LinearSolver {
    /// `threads`: those of factorisations; products use those of the current rayon pool.
    #[must_use]
    pub fn new(choice: LinearSolverChoice, threads: usize) -> Self {
        Self { choice, direct: DirectSolver::new(threads) }
    }

    /// Takes another choice.
    pub fn choose(&mut self, choice: LinearSolverChoice) {
        self.choice = choice;
    }

    /// Whether symmetric systems of so many equations are solved iteratively.
    #[must_use]
    pub fn is_iterative(&self, equations: &Equations) -> bool {
        match self.choice {
            LinearSolverChoice::Auto => equations.len() >= ITERATIVE_FROM,
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
        let &LinearSystem { operator, equations, symmetry, .. } = system;
        let may_be_direct = operator.is_none() && equations.len() <= DIRECT_UP_TO;
        // Restarted GMRES may stand still where contact is stiff and has friction.
        let is_better_direct =
            self.choice == LinearSolverChoice::Auto && symmetry == Symmetry::General && may_be_direct;
        if is_better_direct || operator.is_none() && !self.is_iterative(equations) {
            return self.solve_directly(system, rhs, solution).map(|()| LinearReport::Direct);
        }
        match solve_iteratively(system, rhs, accuracy, solution) {
            Ok(IterativeReport { iterations, size, bytes, .. }) => {
                Ok(LinearReport::Iterative { iterations, size, bytes })
            }
            Err(SystemError::NotConverged { iterations, .. }) if may_be_direct => {
                self.solve_directly(system, rhs, solution)?;
                Ok(LinearReport::Instead { iterations })
            }
            Err(error) => Err(error),
        }
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
