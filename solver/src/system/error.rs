//! Why there is no solution.

/// A system that cannot be solved.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum SystemError {
    #[error("{given} {what} given, {expected} expected")]
    WrongCount { what: &'static str, given: usize, expected: usize },
    /// An entry of the matrix or of the right-hand side is NaN or infinite. Its equation is counted among the free ones, its axis is 0, 1
    /// or 2.
    #[error("the entry of equation {equation} (node {node}, axis {axis}) is {value}")]
    NotFinite { equation: usize, node: usize, axis: usize, value: f64 },
    /// A solution was asked for before a matrix was factorised, or after that failed.
    #[error("there are no factors to solve with")]
    NotFactorised,
    /// The matrix is singular to rounding. The residual is ‖b − K x‖ / ‖b‖ of the best attempt, or 1 if there was none. The condition is a
    /// lower bound of ‖K‖ ‖K⁻¹‖ in the maximum norm; it is infinite if a pivot is zero.
    #[error(
        "the matrix of {equations} equations is singular: relative residual {residual:.1e}, condition at least {condition:.1e}"
    )]
    Singular { equations: usize, residual: f64, condition: f64 },
    /// The iterative solution did not get as far as it should. The residual is ‖b − K x‖ over the size of b, see
    /// [`Accuracy`](super::Accuracy).
    #[error(
        "the iterative solution of {equations} equations is at a relative residual of {residual:.1e} after {iterations} iterations, \
         {tolerance:.1e} was asked for"
    )]
    NotConverged { equations: usize, residual: f64, iterations: usize, tolerance: f64 },
    /// The factors do not fit into memory, or their indices into 32 bits.
    #[error("the factors of {equations} equations are too large for this machine")]
    TooLarge { equations: usize },
}
