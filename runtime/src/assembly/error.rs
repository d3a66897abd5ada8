//! Why nothing was assembled.

use crate::Mode;

/// Every reason for which an assembly is refused. Each carries the figures that led to it. Elements count from 0.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum AssemblyError {
    /// The penalty is not a positive finite number.
    #[error("the penalty must be positive and finite, not {value:?}")]
    InvalidPenalty { value: f64 },
    /// There is not one multiplier for each element.
    #[error("{found} multipliers for {elements} elements")]
    MultiplierCount { found: usize, elements: usize },
    /// A multiplier is negative or not finite: contact does not pull.
    #[error("the multiplier of element {element} must be finite and not negative, but is {value:?}")]
    InvalidMultiplier { element: usize, value: f64 },
    /// A gap is NaN or infinite.
    #[error("the gap of element {element} is {value:?}")]
    InvalidGap { element: usize, value: f64 },
    /// An area is negative or not finite.
    #[error("the area of element {element} must be finite and not negative, but is {value:?}")]
    InvalidArea { element: usize, value: f64 },
    /// ε or λ − ε g of an element is beyond the range of numbers.
    #[error(
        "the contact force of element {element} overflows: penalty {penalty:e}, area {area:e}, gap {gap:e}"
    )]
    ForceOverflow { element: usize, penalty: f64, area: f64, gap: f64 },
    /// A normal law of the caller's own gave what is no pressure p, or no ∂p/∂g.
    #[error(
        "the normal law gave element {element} at the gap {gap:e} the pressure {pressure:?}, by the gap {by_gap:?}: both have to be finite"
    )]
    InvalidPressure { element: usize, gap: f64, pressure: f64, by_gap: f64 },
    /// The gap at which a normal law of one's own says that pressure begins, its [`onset`](super::NormalLaw::onset), is not finite.
    #[error("the pressure of element {element} begins at a gap of {value:?}, which has to be finite")]
    InvalidOnset { element: usize, value: f64 },
    /// A normal law of the caller's own and multipliers of the augmented Lagrangian at once.
    #[error("a normal law of one's own takes no multipliers")]
    MultipliersOfOwnLaw,
    /// Numbers that are no table. `place` is that of the first such number, in gaps and pressures one after another.
    #[error("number {place} of the table is not finite, does not ascend, is missing or too many")]
    InvalidTable { place: usize },
    /// An element has contact but no master nodes.
    #[error("element {element} has contact but no master nodes")]
    NoMasters { element: usize },
    /// Contact over faces was evaluated with fewer derivatives than this takes.
    #[error(
        "this takes an evaluation in {needed:?} mode; the last one was in {found:?} mode{}",
        if *needed == Mode::Hessian && *found == Mode::Gradient { ", which is enough for the Gauss-Newton tangent" } else { "" }
    )]
    NotDerived { needed: Mode, found: Mode },
    /// A gradient or a Hessian, of the gap or of the slip, has the wrong length. With n nodes a gradient takes 3(n+1) entries, a Hessian
    /// its packed lower triangle.
    #[error("the {what} of element {element} has {found} entries instead of {expected}{}", if *found == 0 { ": not evaluated, or in a mode with fewer derivatives" } else { "" })]
    DerivativeLength { what: &'static str, element: usize, found: usize, expected: usize },
    /// An element names a node that the map of degrees of freedom does not know.
    #[error("element {element} names node {node}, but there are only {nodes} nodes")]
    UnknownNode { element: usize, node: usize, nodes: usize },
    /// A degree of freedom is mapped to an equation that the system does not have. `axis` is 0, 1 or 2.
    #[error("axis {axis} of node {node} has equation {equation}, but there are only {equations} equations")]
    UnknownEquation { node: usize, axis: usize, equation: usize, equations: usize },
    /// Two degrees of freedom are mapped to the same equation.
    #[error("two degrees of freedom have the same equation {equation}")]
    SharedEquation { equation: usize },
    /// The slice to add to has the wrong length. It takes as many entries as there are equations, or entries of the pattern; row offsets
    /// are one more than equations. `what` is `"forces"`, `"values"`, `"row offsets"`, `"entries of v"`, `"products"` or
    /// `"diagonal entries"`.
    #[error("the {what} have {found} entries instead of {expected}")]
    OutputLength { what: &'static str, found: usize, expected: usize },
    /// The elements are not those of the pattern: other nodes, or another number of elements. `element` is the first one that differs.
    #[error("element {element} is not the one of the pattern")]
    PatternMismatch { element: usize },
    /// The matrix of a host is none: its row offsets do not begin with 0, do not ascend or do not end with the number of its columns, or
    /// the columns of a row do not ascend or are none of its equations. `row` is the first such row that was looked at.
    #[error(
        "row {row} of the matrix: row offsets have to ascend from 0 to the number of entries, and columns within a row"
    )]
    InvalidRow { row: usize },
    /// The matrix of a host has no entry where elements have one.
    #[error("the matrix has no entry in row {row}, column {column}, where contact has one")]
    MissingEntry { row: usize, column: usize },
    /// An array cannot be allocated, or its indices do not fit their type. A `count` of `usize::MAX` also stands for more.
    #[error("{count} {what} are more than fit into memory or into their index")]
    TooLarge { what: &'static str, count: usize },
    /// A round of augmentation by a law whose friction has none.
    #[error("the law has no augmentation of friction")]
    NoAugmentation,
    /// The law has friction, which masters that were found by another rule than domains of influence do not have.
    #[error(
        "friction needs facets, or the diffuse element with the neighbour rule \"domains\", not with another one"
    )]
    NoAnchors,
    /// The law has friction, whose kernels were not compiled in.
    #[error(
        "this build has no kernels of friction over nodes: integrate contact over faces, or build it with the feature \"friction\", see docs/how-to/friction.md"
    )]
    NoFrictionKernels,
    /// The law has friction, but the elements come without slips. `element` is the first such.
    #[error("the law has friction, but element {element} has no slip: call accept before the first step")]
    NoSlip { element: usize },
    /// The friction of an element is not finite. `opening` says how far it was from carrying force when the last step was accepted; it is 0
    /// if it was closed.
    #[error(
        "the friction of element {element} is not finite: half the square of its slip is {half_square:?}, it was open by {opening:?}"
    )]
    InvalidSlip { element: usize, half_square: f64, opening: f64 },
    /// A coefficient of friction of the caller's own gave what is no μ ≥ 0, ∂μ/∂p or ∂μ/∂v.
    #[error(
        "the coefficient of friction of element {element} is {value:?} at the pressure {pressure:e} and the slip rate {rate:e}, by the pressure {by_pressure:?}, by the rate {by_rate:?}: it has to be finite and not negative, its derivatives finite"
    )]
    InvalidCoefficient {
        element: usize,
        pressure: f64,
        rate: f64,
        value: f64,
        by_pressure: f64,
        by_rate: f64,
    },
    /// One triangle of a tangent that is not symmetric was asked for.
    #[error("the exact tangent of friction is not symmetric: one triangle is not all of it")]
    Unsymmetric,
    /// An entry of a vector that is multiplied is NaN or infinite. `equation` is the first such.
    #[error("entry {equation} of {what} is {value:?}")]
    NonFiniteEntry { what: &'static str, equation: usize, value: f64 },
    /// A sum left the range of numbers, or was not finite before anything was added. `equation` is the first such; `what` is `"forces"`,
    /// `"values"`, `"products"` or `"diagonal entries"`.
    #[error("the {what} of equation {equation} are not finite")]
    Overflow { what: &'static str, equation: usize },
}

impl AssemblyError {
    /// Whether a slice of the caller's has as many entries as it takes.
    pub(crate) fn check_length(what: &'static str, found: usize, expected: usize) -> Result<(), Self> {
        if found == expected { Ok(()) } else { Err(Self::OutputLength { what, found, expected }) }
    }

    /// Whether all entries of a vector are finite.
    pub(crate) fn check_finite(what: &'static str, v: &[f64]) -> Result<(), Self> {
        let entry = v.iter().position(|x| !x.is_finite());
        entry.map_or(Ok(()), |equation| Err(Self::NonFiniteEntry { what, equation, value: v[equation] }))
    }

    /// Stable machine-readable code.
    pub const fn code(&self) -> &'static str {
        match self {
            Self::InvalidPenalty { .. } => "invalid-penalty",
            Self::MultiplierCount { .. } => "multiplier-count",
            Self::InvalidMultiplier { .. } => "invalid-multiplier",
            Self::InvalidGap { .. } => "invalid-gap",
            Self::InvalidArea { .. } => "invalid-area",
            Self::ForceOverflow { .. } | Self::Overflow { .. } => "overflow",
            Self::NonFiniteEntry { .. } => "non-finite-input",
            Self::InvalidPressure { .. } => "invalid-pressure",
            Self::InvalidOnset { .. } => "invalid-onset",
            Self::MultipliersOfOwnLaw => "multipliers-of-own-law",
            Self::InvalidTable { .. } => "invalid-table",
            Self::NoMasters { .. } => "no-masters",
            Self::DerivativeLength { .. } => "derivative-length",
            Self::NotDerived { .. } => "not-derived",
            Self::UnknownNode { .. } => "unknown-node",
            Self::UnknownEquation { .. } => "unknown-equation",
            Self::SharedEquation { .. } => "shared-equation",
            Self::OutputLength { .. } => "output-length",
            Self::PatternMismatch { .. } => "pattern-mismatch",
            Self::InvalidRow { .. } => "invalid-row",
            Self::MissingEntry { .. } => "missing-entry",
            Self::TooLarge { .. } => "too-large",
            Self::NoAugmentation => "no-augmentation",
            Self::NoAnchors => "no-anchors",
            Self::NoFrictionKernels => "no-friction-kernels",
            Self::NoSlip { .. } => "no-slip",
            Self::InvalidSlip { .. } => "invalid-slip",
            Self::InvalidCoefficient { .. } => "invalid-coefficient",
            Self::Unsymmetric => "unsymmetric",
        }
    }
}
