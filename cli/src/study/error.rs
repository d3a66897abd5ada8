//! Why a study ends without figures.

use diffuse_contact::interface::{InterfaceError, NoContact};
use diffuse_contact::surface::SurfaceError;

/// The mesh of a study is no surface, or a node of it has no contact: no figures are better than some.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The mesh is none.
    #[error("the mesh of the study: {0}")]
    Surface(#[from] SurfaceError),
    /// The interface refuses its input.
    #[error("the interface of the study: {0}")]
    Interface(#[from] InterfaceError),
    /// A node without contact.
    #[error("{case}: slave {slave} has no contact: {reason}")]
    NoContact {
        /// Which part of the study.
        case: String,
        /// Number of the slave in it.
        slave: usize,
        /// Why not.
        reason: NoContact,
    },
    /// The plot cannot be drawn.
    #[error("the plot cannot be drawn: {reason}")]
    Plot {
        /// What the plotting library says.
        reason: String,
    },
}
