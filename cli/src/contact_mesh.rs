//! A mesh and its two sets that touch each other.

use std::path::Path;

use diffuse_contact_mesh::{Facet, Mesh, MeshError};

use crate::args::SetArguments;
use crate::error::CliError;
use crate::json;

/// The mesh that comes with the program.
const SHIPPED: &[u8] = include_bytes!("../../meshes/plate_on_cylinder.msh");
/// Its name in messages and in the report.
const SHIPPED_NAME: &str = "plate_on_cylinder.msh (comes with the program)";

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
                let (name, bytes) = json::read(path)?;
                let mesh = Mesh::from_bytes(&bytes, &name);
                (name, mesh)
            }
            None => (SHIPPED_NAME.to_owned(), Mesh::from_gmsh(SHIPPED, "plate_on_cylinder.msh")),
        };
        // The reader's own messages begin with the file, those about sets do not.
        let mesh = mesh.map_err(|reason| CliError::Mesh(reason.into()))?;
        let no_set = |reason: MeshError| CliError::Set { mesh: name.clone(), reason: reason.into() };
        let facets = mesh.facets(&sets.master).map_err(no_set)?;
        let slaves = mesh.nodes_of(&sets.slave).map_err(no_set)?;
        Ok(Self { name, mesh, facets, slaves })
    }
}
