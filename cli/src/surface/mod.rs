//! The `surface` job: the whole contact interface of a mesh, one refresh and one evaluation with all derivatives.
//!
//! The order of the work is the order of the modules: [`slaves`] picks the two surfaces, [`nodes`] pairs and
//! evaluates every slave node, [`scene`] writes the slave surface for ParaView, [`report`] sums up.

mod arguments;
pub mod legend;
pub mod nodes;
pub mod report;
mod scene;
pub mod slaves;

pub use arguments::SurfaceArguments;

use std::time::Instant;

use crate::error::CliError;
use crate::output;
use crate::threads::with_threads;

use report::Report;
use slaves::Surfaces;

/// Evaluates the interface.
pub fn run(arguments: &SurfaceArguments) -> Result<(), CliError> {
    output::check_target(&arguments.output)?;
    output::check_distinct(&arguments.mesh, &arguments.output)?;
    output::check_grid(&arguments.output)?;
    let options = arguments.element.options()?;
    let sets = &arguments.sets;
    let planes = arguments.element.planes();
    let start = Instant::now();
    let surfaces = Surfaces::read(Some(&arguments.mesh), sets)?;
    let read = start.elapsed();
    let nodes = with_threads(arguments.threads, || nodes::evaluate(&surfaces, sets, options, &planes))?;
    let start = Instant::now();
    scene::write(&arguments.output, &surfaces, &nodes, options.element)?;
    let report = Report {
        surfaces: &surfaces,
        sets,
        nodes: &nodes,
        element: options.element.into(),
        read,
        write: start.elapsed(),
        file: &arguments.output,
    };
    if arguments.json {
        return output::write_json(&report.summary());
    }
    output::write_stdout(|writer| write!(writer, "{report}"))
}
