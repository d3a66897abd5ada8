//! How smooth the contact is along a path: a slave node is swept around a closed loop over a wavy mesh, at a constant depth
//! below the exact surface, and paired anew at every step.
//!
//! A frictionless surface does no work around a closed loop. What work there is comes from the jumps of the gap where the
//! pairing changes.

mod plot;
mod run;
pub mod scene;

use std::io::{self, Write};

use diffuse_contact::Weight;
use diffuse_contact::interface::ContactElement;
use diffuse_contact::neighbourhood::NeighbourRule;
use rayon::prelude::*;

use super::StudyError;
use super::arguments::SweepArguments;
use super::markdown::Table;
use super::plot::COLOURS;
use crate::error::CliError;
use crate::output;
use crate::progress::logged;

use run::{Curve, elements, names, sweep};
use scene::Cells;

/// Sweeps all elements, writes the files and prints the table.
pub fn run(arguments: &SweepArguments) -> Result<(), CliError> {
    for path in arguments.output.iter().chain(&arguments.csv) {
        output::check_target(path)?;
    }
    let elements = elements();
    let cells = Cells { refine: arguments.refine, moved: arguments.moved };
    let bar = logged("steps", elements.len() * arguments.steps as usize);
    let curves: Result<Vec<Curve>, StudyError> = elements
        .into_par_iter()
        .map(|element| sweep(element, cells, arguments.steps, || bar.inc(1)))
        .collect();
    bar.finish_and_clear();
    let curves = curves?;
    if let Some(path) = &arguments.output {
        let picture = plot::draw(&shown(&curves))?;
        output::write_file(path, |writer| writer.write_all(picture.as_bytes()))?;
    }
    if let Some(path) = &arguments.csv {
        output::write_file(path, |writer| write_csv(writer, &curves))?;
    }
    output::write_stdout(|writer| write!(writer, "{}", table(&curves, arguments)))
}

/// The facets, hull layers, and the default rule with two weights, which is drawn last.
fn shown(curves: &[Curve]) -> Vec<plot::Named<'_>> {
    let layers = NeighbourRule::hull_layers(None);
    let kinds = [
        ("facets", COLOURS.facets, None),
        ("hull layers, cubic weight", COLOURS.hull_layers, Some((layers, Weight::Cubic))),
        (
            "nodal domains,\ninterpolating weight",
            COLOURS.interpolating,
            Some((NeighbourRule::Domains, Weight::CubicInterpolating)),
        ),
        ("nodal domains, cubic weight", COLOURS.smooth, Some((NeighbourRule::Domains, Weight::Cubic))),
    ];
    let is_kind = |curve: &Curve, kind: Option<(NeighbourRule, Weight)>| match curve.element {
        ContactElement::Diffuse { weight, search, .. } => kind == Some((search.rule, weight)),
        ContactElement::NodeToFacet => kind.is_none(),
    };
    let found = |(label, colour, kind)| {
        let curve = curves.iter().find(|curve| is_kind(curve, kind));
        curve.map(|curve| (label, colour, curve))
    };
    kinds.into_iter().filter_map(found).collect()
}

fn table(curves: &[Curve], arguments: &SweepArguments) -> Table {
    let SweepArguments { refine, moved, steps, .. } = arguments;
    let moved = if *moved > 0.0 {
        format!(", nodes moved by {} %", (1e3 * moved).round() / 10.0)
    } else {
        String::new()
    };
    let heading = format!(
        "Waves 1 high and {} long, cells of side 1/{refine}{moved}, a loop of {steps} steps at depth {}",
        scene::WAVELENGTH,
        scene::DEPTH
    );
    let columns = "neighbours | weight | changes | steps lost | gap, smallest to largest | \
                   largest gap jump | in % of the gap's range | largest kink of the normal | \
                   work ∮F·dx over ∮‖F‖‖dx‖";
    let mut table = Table::new(heading, columns);
    for curve in curves {
        let Curve { element, changes, lost, gap_jump, kink_degrees, .. } = curve;
        let ([rule, weight], [smallest, largest]) = (names(element), curve.gaps());
        let (percent, work) = (100.0 * gap_jump / (largest - smallest), curve.work / curve.effort);
        table.row(format!(
            "{rule} | {weight} | {changes} | {lost} | {smallest:.4} to {largest:.4} | {gap_jump:.1e} | \
             {percent:.1} | {kink_degrees:.3}° | {work:+.1e}"
        ));
    }
    table
}

/// One line for each step of each element.
fn write_csv(writer: &mut dyn Write, curves: &[Curve]) -> io::Result<()> {
    writeln!(writer, "neighbours,weight,step,x,y,z,gap,force_x,force_y,force_z,normal_x,normal_y,normal_z")?;
    for curve in curves {
        let case = names(&curve.element).map(|name| if name == "–" { String::new() } else { name }).join(",");
        for (step, state) in curve.states.iter().enumerate() {
            let [x, y, z] = state.position;
            let ([f, g, h], [a, b, c]) = (state.force, state.normal);
            writeln!(writer, "{case},{step},{x},{y},{z},{},{f},{g},{h},{a},{b},{c}", state.gap)?;
        }
    }
    Ok(())
}
