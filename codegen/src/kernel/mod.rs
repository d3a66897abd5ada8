//! A kernel as expressions: what it reads and returns, and the values, derivatives and results of nodes that it computes.
//!
//! [`ElementModel`] is the sheet that an element's formulas are written on; `outputs` asks for the derivatives of what it states.

mod element;
mod error;
mod outputs;
mod signature;
mod unknowns;

use std::borrow::Cow;

use crate::graph::{ExprId, Graph};
use crate::structure::{Gradient, LowRankForm};

pub use element::ElementModel;
pub use error::ElementError;
pub use outputs::{Defined, ElementKernels, ElementSpec, NodeResult};
pub(crate) use signature::is_identifier;
pub use signature::{Differentiated, DirectionSymbols, Input, Points, Quantity, Returned, Role, Signature};
pub use unknowns::{Root, Stationary};

/// How many derivatives a kernel computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Mode {
    /// Values.
    Value,
    /// Values and first derivatives.
    Gradient,
    /// Values, first and second derivatives.
    Hessian,
}

impl Mode {
    /// All modes, fewest derivatives first.
    pub const ALL: [Self; 3] = [Self::Value, Self::Gradient, Self::Hessian];

    /// Name in emitted code.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Value => "value",
            Self::Gradient => "gradient",
            Self::Hessian => "hessian",
        }
    }
}

/// A formula of the model, for the documentation of emitted kernels.
#[derive(Clone, Copy, Debug)]
pub struct Equation {
    /// The formula, in the paper's symbols.
    pub formula: &'static str,
    /// Where it stands.
    pub source: &'static str,
}

/// A named value of element scope.
#[derive(Clone, Debug)]
pub struct Value {
    /// Field name.
    pub name: Cow<'static, str>,
    /// One line: meaning and unit.
    pub doc: Cow<'static, str>,
    /// Whether the field is an array, even of length one.
    pub is_array: bool,
    /// The components.
    pub components: Vec<ExprId>,
}

/// A kernel as expressions.
#[derive(Clone, Debug)]
pub struct Kernel<S> {
    /// What it is.
    pub spec: S,
    /// The graph all ids refer to.
    pub graph: Graph,
    /// Results of element scope, diagnostics included.
    pub values: Vec<Value>,
    /// Gradients, named.
    pub gradients: Vec<(&'static str, Gradient)>,
    /// Hessians, named.
    pub hessians: Vec<(&'static str, LowRankForm)>,
    /// Results of node scope, named.
    pub node_values: Vec<(&'static str, ExprId)>,
    /// First derivatives that only a caller who asks for them gets, as combinations of rows b of the first Hessian's terms: a coefficient
    /// for each term.
    pub combinations: Vec<(&'static str, Vec<ExprId>)>,
    /// The formulas behind it.
    pub equations: Vec<Equation>,
}

/// The value that says whether all results are finite.
pub(crate) const CHECKSUM: &str = "checksum";
