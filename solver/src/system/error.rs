//! Why there is no solution.

/// A system that cannot be solved.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SystemError {
    /// A list does not fit the number of nodes.
    #[error("{given} {what} given, {expected} expected")]
    WrongCount {
        /// What was counted.
        what: &'static str,
        /// How many there are.
        given: usize,
        /// How many there should be.
        expected: usize,
    },
    /// An entry of the matrix or of the right-hand side is NaN or infinite.
    #[error("the entry of equation {equation} (node {node}, axis {axis}) is {value}")]
    NotFinite {
        /// Number of the equation among the free ones.
        equation: usize,
        /// Its node.
        node: usize,
        /// Its axis, 0 to 2.
        axis: usize,
        /// The entry.
        value: f64,
    },
    /// A solution was asked for before a matrix was factorised, or after that failed.
    #[error("there are no factors to solve with")]
    NotFactorised,
    /// The matrix is singular to rounding.
    #[error(
        "the matrix of {equations} equations is singular: relative residual {residual:e}, condition at least {condition:e}"
    )]
    Singular {
        /// Number of equations.
        equations: usize,
        /// ‖b − K x‖ / ‖b‖ of the best attempt; 1 if there was none.
        residual: f64,
        /// A lower bound of ‖K‖ ‖K⁻¹‖ in the maximum norm; infinite if a pivot is zero.
        condition: f64,
    },
    /// The iterative solution did not get as far as it should.
    #[error(
        "the iterative solution of {equations} equations is at a relative residual of {residual:.1e} after {iterations} iterations, \
         {tolerance:.1e} was asked for"
    )]
    NotConverged {
        /// Number of equations.
        equations: usize,
        /// ‖b − K x‖ / ‖b‖
        residual: f64,
        /// Iterations made.
        iterations: usize,
        /// The residual asked for.
        tolerance: f64,
    },
    /// The factors do not fit into memory, or their indices into 32 bits.
    #[error("the factors of {equations} equations are too large for this machine")]
    TooLarge {
        /// Number of equations.
        equations: usize,
    },
}
