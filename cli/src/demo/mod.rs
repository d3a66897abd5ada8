//! The `demo` job: the contact of two surfaces of a mesh, from the file to a table and a picture.
//!
//! The order of the work is the order of the modules: [`surfaces`] reads the mesh, [`nodes`] pairs and evaluates
//! every slave node, [`cross_check`] compares a sample with automatic differentiation, [`sampling`] lays the smooth
//! surface over the facets, [`scene`] writes all of it for ParaView, [`report`] says it in words.

mod cross_check;
mod nodes;
mod report;
mod sampling;
mod scene;
pub mod status;
mod surfaces;

use diffuse_contact::pairing::{MAX_NEIGHBOURS, PairingRule};

use crate::args::DemoArguments;
use crate::backend::{BackendKind, backend};
use crate::error::CliError;
use crate::output;

/// Runs the demonstration.
pub fn run(arguments: &DemoArguments) -> Result<(), CliError> {
    output::check_target(&arguments.output)?;
    if let Some(mesh) = &arguments.mesh {
        output::check_distinct(mesh, &arguments.output)?;
    }
    let surfaces = surfaces::read(arguments)?;
    let generated = backend(BackendKind::Generated);
    let rule = PairingRule {
        neighbours: arguments.neighbours,
        max_neighbours: MAX_NEIGHBOURS,
        ..PairingRule::default()
    };
    let nodes = nodes::evaluate(generated, &surfaces, &rule);
    let check = cross_check::compare(generated, backend(BackendKind::Ad), &nodes);
    let smooth = sampling::sample(generated, &surfaces, &rule);
    scene::write(&arguments.output, &surfaces, &nodes, &smooth)?;
    let report = report::Report {
        surfaces: &surfaces,
        nodes: &nodes,
        check: &check,
        smooth: &smooth,
        file: &arguments.output,
    };
    output::write_stdout(|writer| write!(writer, "{report}"))
}
