//! What can be asked of `surface`.

use std::path::PathBuf;

use clap::Args;

use super::legend;
use crate::contact_mesh::SetArguments;
use crate::contact_options::ElementArguments;
use crate::threads;

/// Arguments of `surface`.
#[derive(Args, Clone, Debug)]
#[command(after_help = legend::help())]
pub struct SurfaceArguments {
    /// Mesh file, Gmsh `.msh` 4.1 or Abaqus `.inp`; `-` reads standard input
    #[arg(value_name = "MESH")]
    pub mesh: PathBuf,
    /// The two sets of the mesh.
    #[command(flatten)]
    pub sets: SetArguments,
    /// VTU file to write: the slave surface with gap, normal, foot and outcome of every node
    #[arg(short, long, visible_alias = "out", value_name = "OUT.vtu")]
    pub output: PathBuf,
    /// The element.
    #[command(flatten)]
    pub element: ElementArguments,
    /// Print a summary as JSON instead of a table
    #[arg(long)]
    pub json: bool,
    /// Number of threads [default: one for each processor]
    #[arg(long, value_name = "K", value_parser = threads::parse)]
    pub threads: Option<usize>,
}
