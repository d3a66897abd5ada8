//! Mistakes in the formulas of an element.

/// Why there are no kernels of an element.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum ElementError {
    /// A name that is no identifier of Rust, or a keyword.
    #[error("\"{name}\" is no name for Rust: letters, digits and `_`, no digit first, no keyword")]
    Name { name: String },
    /// Two inputs, quantities or outputs, or entries of them, have one name.
    #[error("\"{name}\" is declared twice")]
    Duplicate { name: String },
    /// A name, or that of an entry, that the code has itself.
    #[error("`{name}` is a name that the code of elements with nodes has itself")]
    Reserved { name: String },
    /// An output has the name of derivatives.
    #[error("`{name}` is how derivatives are called; take another name for the output")]
    DerivativeName { name: String },
    /// Gradient and Hessian are wanted of two functions.
    #[error("`{function}` is a second function; there is one `energy` or `function` of an element")]
    TwoFunctions { function: String },
    /// An element of fixed size without an input.
    #[error("there is no input; declare one by `variable` or `parameter`")]
    NoInput,
    /// Limits that no iteration keeps.
    #[error(
        "the limits of `{root}` are steps of at most {longest_step} and {evaluations} evaluations; both are above zero"
    )]
    Limits { root: String, longest_step: String, evaluations: u32 },
    /// Derivatives are asked for, but there is nothing to differentiate by.
    #[error("`{output}` has no variables to be differentiated by; declare them by `variable`")]
    NoVariables { output: String },
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
    Constant { output: String },
    /// An output, or an equation for unknowns, is not one value of the element, but one per node.
    #[error("`{output}` has a value at each node, where the element needs one: add them up with `.sum()`")]
    Scope { output: String },
    /// An output, or an entry of it, contains a symbol that is no declared input.
    #[error("`{output}` contains `{symbol}`, which was not declared by `variable` or `parameter`")]
    Undeclared { output: String, symbol: String },
    /// A sum over nodes in an element that has none.
    #[error(
        "`{output}` is summed over nodes, and the element has none: `node_variable` and `node_parameter` declare what they have"
    )]
    NoNodes { output: String },
    /// Derivatives of how an iteration or a factorisation went.
    #[error(
        "`{output}` is differentiated and contains a residual, a number of iterations or a pivot ratio, which have no derivatives; state these by `value`"
    )]
    Figure { output: String },
    /// A constant that is infinite or no number, or a division by the constant 0.
    #[error(
        "`{output}` is never finite: it contains a constant that is infinite or no number, or a division by 0; only a choice may contain infinity"
    )]
    NeverFinite { output: String },
    /// There is no input or output of this name to be described.
    #[error("there is no input or output `{name}` to describe")]
    Unknown { name: String },
    /// A table of numbers at points that does not fit.
    #[error(
        "the rows of `{name}` have not one finite number for each of its entries, or not as many rows as the points before"
    )]
    Points { name: String },
    /// A quantity or an output depends on the nodes in another way than through sums over them.
    #[error(
        "`{quantity}` depends on two nodes at a time; write it by sums over the nodes, whose terms depend on one node each"
    )]
    NoSum { quantity: String },
    /// A stationary value of something that is not quadratic in its unknowns.
    #[error("what `{unknowns}` makes stationary is not quadratic in them")]
    NotQuadratic { unknowns: String },
    /// A function of which none of the unknowns that make it stationary has a curvature of its own.
    #[error(
        "what `{unknowns}` makes stationary has no curvature by any single one of them; `solve` finds a saddle point"
    )]
    NoCurvature { unknowns: String },
    /// A quantity, or an entry of it, that is defined by the unknowns that are sought, or held: it would not change with them.
    #[error(
        "`{quantity}` has a name and contains `{unknown}`, which is sought; write it in the equations without `define`, `held` or equations of its own"
    )]
    Sought { quantity: String, unknown: String },
    /// Equations whose unknowns stand in sums over the nodes.
    #[error("the unknowns of `{root}` stand in sums over the nodes, where only `stationary` finds them")]
    RootInSum { root: String },
    /// Unknowns whose values are known, in an element with nodes.
    #[error("`{unknowns}` have known values, which elements with nodes of a number that is open do not take")]
    KnownWithNodes { unknowns: String },
    /// An element with nodes and with quadrature points.
    #[error("an element has either nodes of a number that is open or quadrature points")]
    NodesAndPoints,
    /// A root of another number of equations than the kernels can solve.
    #[error(
        "the root `{root}` has {equations} equations; kernels solve one to {}, and find minima of functions of two unknowns",
        crate::graph::Iteration::MOST_EQUATIONS
    )]
    Root { root: String, equations: usize },
    /// Too few or too many numbers for the test of an element. `input` is `inputs` if there are not as many as are declared, and `node` for
    /// the numbers of a node.
    #[error("`{input}` of the test has {found} entries instead of {expected}")]
    TestInputs { input: String, expected: usize, found: usize },
    /// An infinite number, or none, among those for the test of an element. `input` is `node` for the numbers of a node.
    #[error("`{input}` of the test is not finite")]
    TestNumber { input: String },
    /// A value, `gradient`, `hessian` or a Jacobian that is infinite or no number, with the inputs of the test.
    #[error("`{result}` is not finite with the inputs of the test")]
    TestResult { result: String },
    /// A derivative that automatic differentiation of the formulas does not have with the inputs of the test, such as that of a norm at
    /// zero. `result` is `gradient`, `hessian` or a Jacobian.
    #[error(
        "automatic differentiation has no finite `{result}` with the inputs of the test; inputs where no norm or root is zero have one"
    )]
    TestDerivative { result: String },
    /// A function that rustc has no stack for.
    #[error(
        "its function `{function}` would have {statements} statements, at most {} can be compiled",
        crate::emit::MOST_STATEMENTS
    )]
    TooLong { function: String, statements: usize },
}
