//! What can be said to `demo`.

use std::path::PathBuf;

use clap::Args;

use crate::contact_mesh::SetArguments;
use crate::surface::legend;

/// Arguments of `demo`.
#[derive(Args, Clone, Debug)]
#[command(after_help = format!("The array `outcome` of the points:\n{}", legend::table()))]
pub struct DemoArguments {
    /// Mesh file, Gmsh `.msh` 4.1 or Abaqus `.inp` [default: the plate on a cylinder that comes with the program]
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,
    /// The two sets of the mesh.
    #[command(flatten)]
    pub sets: SetArguments,
    /// VTU file to write
    #[arg(short, long, value_name = "OUT.vtu", default_value = DemoArguments::OUTPUT)]
    pub output: PathBuf,
    /// Picture to write, for any browser [default: OUT.svg]
    #[arg(long, value_name = "OUT.svg")]
    pub picture: Option<PathBuf>,
}

impl DemoArguments {
    const OUTPUT: &str = "diffuse-contact.vtu";

    /// The picture to write: the one named, or else one beside the output. A device has none beside it.
    pub fn picture(&self) -> Option<PathBuf> {
        let is_device = self.output.metadata().is_ok_and(|found| !found.is_file());
        self.picture.clone().or_else(|| (!is_device).then(|| self.output.with_extension("svg")))
    }
}

impl Default for DemoArguments {
    fn default() -> Self {
        Self { mesh: None, sets: SetArguments::default(), output: Self::OUTPUT.into(), picture: None }
    }
}
