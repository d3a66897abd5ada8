//! What a contender is: a way to evaluate an element, behind the same two functions as all others.

use diffuse_contact_kernels::support::Isa;
use serde::Serialize;

use crate::Elements;

/// What a contender computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Output {
    /// g, foot, ν, N: what a residual takes. The frame is held.
    GapGradient,
    /// g, foot, ν, N and the lower triangle of M. The frame is held.
    GapHessian,
    /// The same with the frame moving with the masters.
    GapCoMovingHessian,
    /// f, ∇f, T_1, T_2 and the lower triangle of H_f at a point of the plane. The frame is held.
    SurfaceHessian,
}

impl Output {
    /// Name, as in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::GapGradient => "gap-gradient",
            Self::GapHessian => "gap-hessian",
            Self::GapCoMovingHessian => "gap-co-moving-hessian",
            Self::SurfaceHessian => "surface-hessian",
        }
    }
}

/// A contender gave no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("element {element} has no result")]
pub struct NoResult {
    /// The element.
    pub element: usize,
}

/// What is compared of a result, as far as the output has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// g, or f of a surface, length.
    pub value: f64,
    /// Its derivatives with respect to the 3(n+1) coordinates.
    pub gradient: Vec<f64>,
    /// Packed lower triangle of its second derivatives; empty if the output has none.
    pub hessian: Vec<f64>,
}

/// A contender with its buffers, for one set of elements.
pub trait Run {
    /// Evaluates the next `count` elements, after the last one again the first. Nothing is allocated for a
    /// gap.
    ///
    /// # Errors
    /// [`NoResult`] for the first element that has none.
    fn run(&mut self, count: usize) -> Result<(), NoResult>;

    /// The result of one element.
    ///
    /// # Errors
    /// [`NoResult`] if it has none.
    fn evaluation(&mut self, element: usize) -> Result<Evaluation, NoResult>;
}

/// One way to compute one output.
#[derive(Clone, Copy)]
pub struct Contender {
    /// What computes.
    pub kernel: &'static str,
    /// What is computed.
    pub output: Output,
    /// Makes room for a set of elements and the output; `None` if the contender is not compiled for their number of nodes. The
    /// generated kernels are run with the vector instructions given; the others, and the kernel of the surface, are
    /// compiled for those of the program.
    pub prepare: for<'a> fn(&'a Elements, Output, Isa) -> Option<Box<dyn Run + 'a>>,
    /// Whether [`operations`](crate::operations) counts what it does.
    pub counted: bool,
}

impl std::fmt::Debug for Contender {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.kernel, self.output.name())
    }
}

/// The generated kernels, one element at a time.
pub const GENERATED_SINGLE: &str = "generated-single";

/// The generated kernels, many elements at a time.
pub const GENERATED_BATCH: &str = "generated-batch";
