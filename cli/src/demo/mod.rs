//! The `demo` job: the contact of two surfaces of a mesh, from the file to a table and a picture.
//!
//! It takes the route that a solver takes: one contact interface of the whole surface, as the job `surface` does, whose modules
//! read the mesh and evaluate every slave node. Then [`sampling`] lays the smooth surface over the facets, [`picture`] draws it,
//! [`scene`] writes all of it for ParaView, [`report`] says it in words.

mod arguments;
mod picture;
mod report;
mod sampling;
mod scene;

pub use arguments::DemoArguments;

use std::time::Instant;

use diffuse_contact::interface::InterfaceOptions;

use crate::error::CliError;
use crate::output;
use crate::surface::nodes;
use crate::surface::report::Report;
use crate::surface::slaves::Surfaces;

/// Runs the demonstration.
pub fn run(arguments: &DemoArguments) -> Result<(), CliError> {
    let picture = arguments.picture();
    for target in std::iter::once(&arguments.output).chain(&picture) {
        output::check_target(target)?;
        if let Some(mesh) = &arguments.mesh {
            output::check_distinct(mesh, target)?;
        }
    }
    output::check_grid(&arguments.output)?;
    if let Some(picture) = &picture {
        output::check_apart(&arguments.output, picture)?;
    }
    let sets = &arguments.sets;
    let options = InterfaceOptions::default();
    let start = Instant::now();
    let surfaces = Surfaces::read(arguments.mesh.as_deref(), sets)?;
    let read = start.elapsed();
    let nodes = nodes::evaluate(&surfaces, sets, options, &[])?;
    let smooth = sampling::sample(&surfaces, sets, options)?;
    let start = Instant::now();
    scene::write(&arguments.output, &surfaces, &nodes, &smooth)?;
    if let Some(path) = &picture {
        picture::write(path, &surfaces, &nodes, &smooth)?;
    }
    let contact = Report {
        surfaces: &surfaces,
        sets,
        nodes: &nodes,
        element: options.element.into(),
        read,
        write: start.elapsed(),
        file: &arguments.output,
    };
    let report = report::Report { contact: &contact, smooth: &smooth, picture: picture.as_deref() };
    output::write_stdout(|writer| write!(writer, "{report}"))
}
