//! Why nothing was assembled.

use crate::Mode;

/// Every reason for which an assembly is refused. Each carries the figures that led to it.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AssemblyError {
    /// The penalty is not a positive finite number.
    #[error("the penalty must be positive and finite, not {value}")]
    InvalidPenalty {
        /// The penalty given.
        value: f64,
    },
    /// There is not one multiplier for each element.
    #[error("{found} multipliers for {elements} elements")]
    MultiplierCount {
        /// Number of multipliers given.
        found: usize,
        /// Number of elements.
        elements: usize,
    },
    /// A multiplier is negative or not finite: contact does not pull.
    #[error("the multiplier of element {element} must be finite and not negative, but is {value}")]
    InvalidMultiplier {
        /// The element, counted from 0.
        element: usize,
        /// Its multiplier.
        value: f64,
    },
    /// A gap is NaN or infinite.
    #[error("the gap of element {element} is {value}")]
    InvalidGap {
        /// The element, counted from 0.
        element: usize,
        /// Its gap.
        value: f64,
    },
    /// An area is negative or not finite.
    #[error("the area of element {element} must be finite and not negative, but is {value}")]
    InvalidArea {
        /// The element, counted from 0.
        element: usize,
        /// Its area.
        value: f64,
    },
    /// ε or λ − ε g of an element is beyond the range of numbers.
    #[error(
        "the contact force of element {element} overflows: penalty {penalty:e}, area {area:e}, gap {gap:e}"
    )]
    ForceOverflow {
        /// The element, counted from 0.
        element: usize,
        /// The penalty.
        penalty: f64,
        /// Its area.
        area: f64,
        /// Its gap.
        gap: f64,
    },
    /// A normal law of the caller's own gave what is no pressure.
    #[error(
        "the normal law gave element {element} at the gap {gap:e} the pressure {pressure}, by the gap {by_gap}: both have to be finite"
    )]
    InvalidPressure {
        /// The element, counted from 0.
        element: usize,
        /// Its gap.
        gap: f64,
        /// p.
        pressure: f64,
        /// ∂p/∂g.
        by_gap: f64,
    },
    /// The gap at which a normal law of one's own says that pressure begins is not finite.
    #[error("the pressure of element {element} begins at a gap of {value}, which has to be finite")]
    InvalidOnset {
        /// The element, counted from 0.
        element: usize,
        /// [`NormalLaw::onset`](super::NormalLaw::onset).
        value: f64,
    },
    /// A normal law of the caller's own and multipliers of the augmented Lagrangian at once.
    #[error("a normal law of one's own takes no multipliers")]
    MultipliersOfOwnLaw,
    /// Numbers that are no table.
    #[error("number {place} of the table is not finite, does not ascend, is missing or too many")]
    InvalidTable {
        /// The place of the first such number, in gaps and pressures one after another.
        place: usize,
    },
    /// An element has contact but no master nodes.
    #[error("element {element} has contact but no master nodes")]
    NoMasters {
        /// The element, counted from 0.
        element: usize,
    },
    /// Contact over faces was evaluated with fewer derivatives than this takes.
    #[error(
        "this takes an evaluation in {needed:?} mode; the last one was in {found:?} mode{}",
        if *needed == Mode::Hessian && *found == Mode::Gradient { ", which is enough for the Gauss-Newton tangent" } else { "" }
    )]
    NotDerived {
        /// The mode that is needed.
        needed: Mode,
        /// That of the evaluation.
        found: Mode,
    },
    /// A gradient or a Hessian does not have the size that follows from the number of nodes.
    #[error("the {what} of element {element} has {found} entries instead of {expected}{}", if *found == 0 { ": it was not evaluated" } else { "" })]
    DerivativeLength {
        /// `"gradient"` or `"Hessian"`, of the gap or `"… of the slip"`.
        what: &'static str,
        /// The element, counted from 0.
        element: usize,
        /// Number of entries given.
        found: usize,
        /// Number of entries needed: 3(n+1), or its packed lower triangle.
        expected: usize,
    },
    /// An element names a node that the map of degrees of freedom does not know.
    #[error("element {element} names node {node}, but there are only {nodes} nodes")]
    UnknownNode {
        /// The element, counted from 0.
        element: usize,
        /// The node it names.
        node: usize,
        /// Number of nodes of the map.
        nodes: usize,
    },
    /// A degree of freedom is mapped to an equation that the system does not have.
    #[error("axis {axis} of node {node} has equation {equation}, but there are only {equations} equations")]
    UnknownEquation {
        /// The node.
        node: usize,
        /// 0, 1 or 2.
        axis: usize,
        /// The equation it is mapped to.
        equation: usize,
        /// Number of equations.
        equations: usize,
    },
    /// Two degrees of freedom are mapped to the same equation.
    #[error("two degrees of freedom have the same equation {equation}")]
    SharedEquation {
        /// The equation.
        equation: usize,
    },
    /// The slice to add to has the wrong length.
    #[error("the {what} have {found} entries instead of {expected}")]
    OutputLength {
        /// `"forces"`, `"values"`, `"row offsets"`, `"entries of v"`, `"products"` or `"diagonal entries"`.
        what: &'static str,
        /// Its length.
        found: usize,
        /// Number of equations, or of entries of the pattern; of row offsets one more than equations.
        expected: usize,
    },
    /// The elements are not those of the pattern: other nodes, or another number of elements.
    #[error("element {element} is not the one of the pattern")]
    PatternMismatch {
        /// The first element that differs, counted from 0.
        element: usize,
    },
    /// The matrix of a host is none: its row offsets do not begin with 0, do not ascend or do not end with the number of its
    /// columns, or the columns of a row do not ascend or are none of its equations.
    #[error(
        "row {row} of the matrix: row offsets have to ascend from 0 to the number of entries, and columns within a row"
    )]
    InvalidRow {
        /// The first such row that was looked at.
        row: usize,
    },
    /// The matrix of a host has no entry where elements have one.
    #[error("the matrix has no entry in row {row}, column {column}, where contact has one")]
    MissingEntry {
        /// The row.
        row: usize,
        /// The column.
        column: usize,
    },
    /// An array cannot be allocated, or its indices do not fit their type.
    #[error("{count} {what} are more than fit into memory or into their index")]
    TooLarge {
        /// What there is too much of.
        what: &'static str,
        /// How many; `usize::MAX` also stands for more.
        count: usize,
    },
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
    /// The law has friction, but the elements come without slips.
    #[error("the law has friction, but element {element} has no slip: call accept before the first step")]
    NoSlip {
        /// The first such element, counted from 0.
        element: usize,
    },
    /// The friction of an element is not finite.
    #[error(
        "the friction of element {element} is not finite: half the square of its slip is {half_square}, it was open by {opening}; a coefficient of one's own has to be finite and not negative"
    )]
    InvalidSlip {
        /// The element, counted from 0.
        element: usize,
        /// q.
        half_square: f64,
        /// How far it was from carrying force when the last step was accepted; 0 if it was closed.
        opening: f64,
    },
    /// One triangle of a tangent that is not symmetric was asked for.
    #[error("the exact tangent of friction is not symmetric: one triangle is not all of it")]
    Unsymmetric,
    /// An entry of a vector that is multiplied is NaN or infinite.
    #[error("entry {equation} of {what} is {value}")]
    NonFiniteEntry {
        /// `"v"`.
        what: &'static str,
        /// The first such equation.
        equation: usize,
        /// The entry.
        value: f64,
    },
    /// A sum left the range of numbers, or was not finite before anything was added.
    #[error("the {what} of equation {equation} are not finite")]
    Overflow {
        /// `"forces"`, `"values"`, `"products"` or `"diagonal entries"`.
        what: &'static str,
        /// The first such equation.
        equation: usize,
    },
}

impl AssemblyError {
    /// Whether all entries of a vector are finite.
    pub(crate) fn check_finite(what: &'static str, v: &[f64]) -> Result<(), Self> {
        let entry = v.iter().position(|x| !x.is_finite());
        entry.map_or(Ok(()), |equation| Err(Self::NonFiniteEntry { what, equation, value: v[equation] }))
    }

    /// Stable machine-readable code.
    #[must_use]
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
            Self::Unsymmetric => "unsymmetric",
        }
    }
}
