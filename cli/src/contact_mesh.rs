//! A mesh and its two sets that touch each other.

use std::path::Path;

use clap::Args;
use diffuse_contact_mesh::{Facet, Mesh, MeshError, PLATE_ON_CYLINDER};

use crate::error::CliError;
use crate::input;

/// The name of the mesh that comes with the program, in messages and in the report.
const SHIPPED_NAME: &str = "plate_on_cylinder.msh (comes with the program)";

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

/// A mesh with master facets and slave nodes, all in the mesh's numbering of the nodes.
pub struct ContactMesh {
    /// File name of the mesh.
    pub name: String,
    /// The mesh.
    pub mesh: Mesh,
    /// Facets of the master set.
    pub facets: Vec<Facet>,
    /// Nodes of the slave set.
    pub slaves: Vec<usize>,
}

impl ContactMesh {
    /// Reads a mesh file, or the mesh that comes with the program, and picks the two sets.
    pub fn read(path: Option<&Path>, sets: &SetArguments) -> Result<Self, CliError> {
        let (name, mesh) = match path {
            Some(path) => {
                let (name, bytes) = input::read(path)?;
                let mesh = Mesh::from_bytes(&bytes, &name);
                (name, mesh)
            }
            None => (SHIPPED_NAME.to_owned(), Mesh::from_gmsh(PLATE_ON_CYLINDER, "plate_on_cylinder.msh")),
        };
        // The reader's own messages begin with the file, those about sets do not.
        let mesh = mesh.map_err(|reason| ContactMeshError::Mesh(reason.into()))?;
        let no_set = |reason: MeshError| ContactMeshError::Set { mesh: name.clone(), reason: reason.into() };
        let facets = mesh.facets(&sets.master).map_err(no_set)?;
        let slaves = mesh.nodes_of(&sets.slave).map_err(no_set)?;
        Ok(Self { name, mesh, facets, slaves })
    }
}
