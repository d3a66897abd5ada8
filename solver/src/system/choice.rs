//! Which solver takes a system.

use super::work::multiplications_per_entry;
use super::{
    Accuracy, BlockMatrix, BlockPattern, DirectSolver, Equations, Geometry, IterativeReport, Operator,
    SolveReport, Symmetry, SystemError, solve_iteratively,
};
use crate::named::named;

/// Below so many equations factors take milliseconds, however many they are.
const FACTORS_BELOW: usize = 3_000;
/// Up to so many multiplications for an entry of the matrix factors are the quicker way: docs/solver.md.
const MULTIPLICATIONS: f64 = 800.0;
/// Up to so many equations a system that was not solved iteratively is solved directly: its factors fit into a few gigabytes.
const DIRECT_UP_TO: usize = 250_000;

/// What a deck asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LinearSolverChoice {
    /// By the work that the factors take; factors for a matrix with friction as long as they fit into a few gigabytes. What the factors of
    /// do not fit into memory is solved iteratively.
    #[default]
    Auto,
    /// Sparse factors, exact to rounding: their memory grows faster than the number of equations.
    Direct,
    /// Conjugate gradients or GMRES with algebraic multigrid, to the accuracy that Newton's method has use for.
    Iterative,
}

named!(LinearSolverChoice { Auto => "auto", Direct => "direct", Iterative => "iterative" });

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
#[allow(missing_docs)] // The names say what the fields are.
pub enum LinearReport {
    /// By factors, as [`SolveReport`] tells.
    Direct { rounded: Option<f64>, negative: Option<usize> },
    /// By iteration. `size` is that of the right-hand side, see [`Accuracy`]; `bytes` is the memory of matrix, preconditioner and vectors.
    Iterative { iterations: usize, size: f64, bytes: usize },
    /// By factors, since the iterative solution did not converge within so many iterations.
    Instead { iterations: usize, rounded: Option<f64> },
}

/// Solves systems directly or iteratively. What it keeps from one to the next is the symbolic factorisation, and whether factors were too
/// large.
pub struct LinearSolver {
    choice: LinearSolverChoice,
    /// Whether iterations are quicker than the factors of a symmetric matrix.
    is_quicker_iteratively: bool,
    direct: DirectSolver,
    /// Whether factors were too large for the machine where there is another way: they are not tried again.
    is_too_large: bool,
}

impl LinearSolver {
    /// By factors. `threads`: those of factorisations; products use those of the current rayon pool.
    pub fn new(threads: usize) -> Self {
        Self {
            choice: LinearSolverChoice::Direct,
            is_quicker_iteratively: false,
            direct: DirectSolver::new(threads),
            is_too_large: false,
        }
    }

    /// Takes a choice, for systems with these equations. `links` are the pairs of nodes that elements join: contacts that come and go are to
    /// make no difference.
    pub fn choose(&mut self, choice: LinearSolverChoice, links: &BlockPattern, equations: &Equations) {
        (self.choice, self.is_too_large) = (choice, false);
        self.is_quicker_iteratively = choice == LinearSolverChoice::Auto
            && match equations.len() {
                0..FACTORS_BELOW => false,
                FACTORS_BELOW..=DIRECT_UP_TO => multiplications_per_entry(links, equations) > MULTIPLICATIONS,
                _ => true,
            };
    }

    /// Whether systems without friction are solved iteratively.
    pub fn is_iterative(&self) -> bool {
        match self.choice {
            LinearSolverChoice::Auto => self.is_quicker_iteratively || self.is_too_large,
            LinearSolverChoice::Direct => false,
            LinearSolverChoice::Iterative => true,
        }
    }

    /// Whether a system may be solved iteratively, if only because its factors turn out to be too large.
    pub fn may_iterate(&self) -> bool {
        self.choice != LinearSolverChoice::Direct
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
                solved => {
                    return solved.map(|report| LinearReport::Direct {
                        rounded: report.rounded(),
                        negative: report.negative,
                    });
                }
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
            Ok(report) => Ok(LinearReport::Instead { iterations, rounded: report.rounded() }),
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
        !self.is_too_large && is_better || !self.is_iterative()
    }

    fn solve_directly(
        &mut self,
        system: &LinearSystem<'_>,
        rhs: &[[f64; 3]],
        solution: &mut Vec<[f64; 3]>,
    ) -> Result<SolveReport, SystemError> {
        self.direct.factorise(system.matrix, system.equations, system.symmetry)?;
        self.direct.solve(rhs, solution)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hexahedra in a box whose face x = 0 is held, so many along each axis.
    fn boxed(cells: [usize; 3]) -> (BlockPattern, Equations) {
        let [x, y, z] = cells.map(|count| count + 1);
        let node = |i: usize, j: usize, k: usize| i + x * (j + y * k);
        let mut cliques = Vec::new();
        for cell in 0..cells.iter().product() {
            let [i, j, k] = [cell % cells[0], cell / cells[0] % cells[1], cell / (cells[0] * cells[1])];
            cliques.push((0..8).map(|c| node(i + c % 2, j + c / 2 % 2, k + c / 4)).collect::<Vec<_>>());
        }
        let held: Vec<[bool; 3]> = (0..x * y * z).map(|node| [node % x == 0; 3]).collect();
        (BlockPattern::new(x * y * z, cliques.iter()), Equations::new(&held))
    }

    fn chosen(choice: LinearSolverChoice, cells: [usize; 3]) -> LinearSolver {
        let (links, equations) = boxed(cells);
        let mut solver = LinearSolver::new(1);
        solver.choose(choice, &links, &equations);
        solver
    }

    /// A cube of 13,005 equations has costly factors; one of 3,267 and a bar of 22,500 have not.
    #[test]
    fn bodies_with_cheap_factors_are_solved_with_them() {
        assert!(!chosen(LinearSolverChoice::Auto, [9, 10, 10]).is_iterative());
        assert!(chosen(LinearSolverChoice::Auto, [15, 16, 16]).is_iterative());
        assert!(!chosen(LinearSolverChoice::Auto, [300, 4, 4]).is_iterative());
        assert!(!chosen(LinearSolverChoice::Direct, [15, 16, 16]).is_iterative());
        assert!(chosen(LinearSolverChoice::Iterative, [2, 2, 2]).is_iterative());
    }

    /// Factors of 144,000 equations take gigabytes and minutes: only friction, where iterations may be in vain, is worth them.
    #[test]
    fn factors_of_large_systems_are_for_friction_alone() {
        let mut solver = chosen(LinearSolverChoice::Auto, [15, 16, 16]);
        let takes_factors = |solver: &LinearSolver, equations| {
            [false, true].map(|friction| solver.takes_factors(equations, friction))
        };
        assert_eq!(takes_factors(&solver, 144_000), [false, true]);
        assert_eq!(takes_factors(&solver, 300_000), [false, false]);
        solver.is_too_large = true;
        assert_eq!(takes_factors(&solver, 10_000), [false, false]);
        // Who asks for factors gets them, or is told.
        let solver = chosen(LinearSolverChoice::Direct, [2, 2, 2]);
        assert_eq!(takes_factors(&solver, 300_000), [true, true]);
        let solver = chosen(LinearSolverChoice::Iterative, [2, 2, 2]);
        assert_eq!(takes_factors(&solver, 10_000), [false, false]);
    }
}
