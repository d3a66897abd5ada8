//! The two sets of a mesh that touch each other.

use clap::Args;
use diffuse_contact_mesh::MeshError;

use crate::error::CliError;

/// The two sets of a mesh that touch each other.
#[derive(Args, Clone, Debug)]
pub struct SetArguments {
    /// Facet set that carries the smooth surface
    #[arg(long, value_name = "SET", default_value = SetArguments::MASTER)]
    pub master: String,
    /// Set whose nodes touch it
    #[arg(long, value_name = "SET", default_value = SetArguments::SLAVE)]
    pub slave: String,
}

impl SetArguments {
    const MASTER: &str = "master";
    const SLAVE: &str = "slave";
}

impl Default for SetArguments {
    fn default() -> Self {
        Self { master: Self::MASTER.into(), slave: Self::SLAVE.into() }
    }
}

/// Why a mesh has no two surfaces that can touch. `mesh` is the file, or the name of the shipped mesh.
#[derive(Debug, thiserror::Error)]
pub enum ContactMeshError {
    /// The mesh file cannot be read or is not a mesh this program knows.
    #[error(transparent)]
    Mesh(Box<MeshError>),
    #[error("{mesh}: {reason}")]
    Set { mesh: String, reason: Box<MeshError> },
    /// A set of the mesh cannot serve in a contact interface. The reason names facets and nodes as the file does.
    #[error("{mesh}: set \"{set}\": {reason}")]
    Interface { mesh: String, set: String, reason: String },
    /// Options do not go together.
    #[error("{0}")]
    Options(&'static str),
}

impl From<ContactMeshError> for CliError {
    fn from(error: ContactMeshError) -> Self {
        Self::job(error)
    }
}
