//! Mistakes in the formulas of an element.

use crate::graph::Scope;

/// Why there are no kernels of an element.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ElementError {
    /// A name that is no identifier of Rust, or a keyword.
    #[error("\"{name}\" is no name for Rust: letters, digits and `_`, no digit first, no keyword")]
    Name {
        /// The name.
        name: String,
    },
    /// Two inputs, quantities or outputs have one name.
    #[error("\"{name}\" is declared twice")]
    Duplicate {
        /// The name, or that of an entry.
        name: String,
    },
    /// A name that the code has itself.
    #[error("`{name}` is a name that the code of elements with nodes has itself")]
    Reserved {
        /// The name, or that of an entry.
        name: String,
    },
    /// An output has the name of derivatives.
    #[error("`{name}` is how derivatives are called; take another name for the output")]
    DerivativeName {
        /// The name.
        name: String,
    },
    /// Gradient and Hessian are wanted of two functions.
    #[error("`{function}` is a second function; there is one `energy` or `function` of an element")]
    TwoFunctions {
        /// The second one.
        function: String,
    },
    /// An element of fixed size without an input.
    #[error("there is no input; declare one by `variable` or `parameter`")]
    NoInput,
    /// Limits that no iteration keeps.
    #[error(
        "the limits of `{root}` are steps of at most {longest_step} and {evaluations} evaluations; both are above zero"
    )]
    Limits {
        /// The root.
        root: String,
        /// The longest step, as text.
        longest_step: String,
        /// The evaluations.
        evaluations: u32,
    },
    /// Derivatives are asked for, but there is nothing to differentiate by.
    #[error("`{output}` has no variables to be differentiated by; declare them by `variable`")]
    NoVariables {
        /// What was to be differentiated.
        output: String,
    },
    /// Nothing is computed.
    #[error("there is no output; state one by `energy`, `function`, `residual` or `value`")]
    NoOutput,
    /// Products are asked for, but nothing is differentiated.
    #[error(
        "there are no derivatives to be multiplied; state an output by `energy`, `function` or `residual`"
    )]
    NoProduct,
    /// A differentiated output is the same whatever the variables are.
    #[error("`{output}` does not depend on any variable")]
    Constant {
        /// The output.
        output: String,
    },
    /// An output, or an equation for unknowns, is not one value of the element, but one per node.
    #[error("`{output}` is a value of {scope:?} scope; outputs and equations are of element scope")]
    Scope {
        /// The output, or the unknowns.
        output: String,
        /// Its scope.
        scope: Scope,
    },
    /// An output contains a symbol that is no declared input.
    #[error("`{output}` contains `{symbol}`, which was not declared by `variable` or `parameter`")]
    Undeclared {
        /// The output, or its entry.
        output: String,
        /// The symbol.
        symbol: String,
    },
    /// Derivatives of how an iteration or a factorisation went.
    #[error(
        "`{output}` is differentiated and contains a residual, a number of iterations or a pivot ratio, which have no derivatives; state these by `value`"
    )]
    Figure {
        /// The output.
        output: String,
    },
    /// There is no input or output of this name to be described.
    #[error("there is no input or output `{name}` to describe")]
    Unknown {
        /// The name.
        name: String,
    },
    /// A table of numbers at points that does not fit.
    #[error(
        "the rows of `{name}` have not one finite number for each of its entries, or not as many rows as the points before"
    )]
    Points {
        /// The table.
        name: String,
    },
    /// A quantity depends on the nodes in another way than through sums over them.
    #[error(
        "`{quantity}` depends on two nodes at a time; write it by sums over the nodes, whose terms depend on one node each"
    )]
    NoSum {
        /// The output, or the quantity.
        quantity: String,
    },
    /// A stationary value of something that is not quadratic in its unknowns.
    #[error("what `{unknowns}` makes stationary is not quadratic in them")]
    NotQuadratic {
        /// The unknowns.
        unknowns: String,
    },
    /// A quantity that is defined by the unknowns that are sought, or held: it would not change with them.
    #[error(
        "`{quantity}` has a name and contains `{unknown}`, which is sought; write it in the equations without `define`, `held` or equations of its own"
    )]
    Sought {
        /// The quantity, or its entry.
        quantity: String,
        /// The unknown.
        unknown: String,
    },
    /// Equations whose unknowns stand in sums over the nodes.
    #[error("the unknowns of `{root}` stand in sums over the nodes, where only `stationary` finds them")]
    RootInSum {
        /// The root.
        root: String,
    },
    /// Unknowns whose values are known, in an element with nodes.
    #[error("`{unknowns}` have known values, which elements with nodes of a number that is open do not take")]
    KnownWithNodes {
        /// The unknowns.
        unknowns: String,
    },
    /// An element with nodes and with quadrature points.
    #[error("an element has either nodes of a number that is open or quadrature points")]
    NodesAndPoints,
    /// A root of another number of equations than the kernels can solve.
    #[error(
        "the root `{root}` has {equations} equations; kernels solve one to {}, and find minima of functions of two unknowns",
        crate::graph::Iteration::MOST_EQUATIONS
    )]
    Root {
        /// The root.
        root: String,
        /// Its equations.
        equations: usize,
    },
    /// Too few or too many numbers for the test of an element.
    #[error("`{input}` of the test has {found} entries instead of {expected}")]
    TestInputs {
        /// The input; `inputs` if there are not as many as are declared, `node` for the numbers of a node.
        input: String,
        /// As many as are declared.
        expected: usize,
        /// As many as were given.
        found: usize,
    },
    /// An infinite number, or none, among those for the test of an element.
    #[error("`{input}` of the test is not finite")]
    TestNumber {
        /// The input; `node` for the numbers of a node.
        input: String,
    },
    /// A result that is infinite or no number, with the inputs of the test.
    #[error("`{result}` is not finite with the inputs of the test")]
    TestResult {
        /// A value, `gradient`, `hessian`, or a Jacobian.
        result: String,
    },
    /// A derivative that automatic differentiation of the formulas does not have with the inputs of the test, such as that of a norm at
    /// zero.
    #[error(
        "automatic differentiation has no finite `{result}` with the inputs of the test; inputs where no norm or root is zero have one"
    )]
    TestDerivative {
        /// `gradient`, `hessian`, or a Jacobian.
        result: String,
    },
    /// A function that rustc has no stack for.
    #[error(
        "its function `{function}` would have {statements} statements, at most {} can be compiled",
        crate::emit::MOST_STATEMENTS
    )]
    TooLong {
        /// The function.
        function: String,
        /// Its statements.
        statements: usize,
    },
}
