//! Which implementation of the element computes.

use clap::ValueEnum;
use diffuse_contact::{Backend, Generated, ad::Ad};

/// The implementations of [`Backend`] that can be asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BackendKind {
    /// The generated kernels.
    Generated,
    /// Forward-mode automatic differentiation of an independent model: slow, for comparison.
    Ad,
}

/// The backend of that kind.
pub fn backend(kind: BackendKind) -> &'static dyn Backend {
    match kind {
        BackendKind::Generated => &Generated,
        BackendKind::Ad => &Ad,
    }
}
