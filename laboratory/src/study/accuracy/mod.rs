//! The error of gap and normal on surfaces of known shape.
//!
//! Slave nodes sit on the exact surface, 20 × 20 of them all over one cell of the mesh, the nodes' corner, the middles of
//! edges and the middle of the facet among them. Their gap ought to be zero and their normal the exact one.

mod bodies;
mod measure;
mod shapes;

use serde::Serialize;

use crate::error::CliError;
use crate::output;
use crate::study::arguments::AccuracyArguments;
use crate::study::markdown::{Table, cells};

pub use measure::angle;

use bodies::{BodyMeasurement, measure_bodies};
use measure::{Measurement, SIZES, elements, measure, order};
use shapes::Shape;

/// Reference figures for the cylinder of radius 100, from an independent trial of fits to two hull layers: cell in degrees, cubic
/// weight, interpolating weight, facets (the sagitta). The places of the cell they belong to are not known.
const REFERENCE: [(f64, [f64; 3]); 2] = [(22.5, [0.441, 0.112, 1.92]), (10.0, [0.0176, 0.0055, 0.381])];
/// The same elements by their names here.
const REFERENCE_ELEMENTS: [&str; 3] = ["cubic", "cubic-interpolating", "facets"];
/// Places of the cell, (around the axis, along it), whose errors stand beside the reference ones.
const PLACES: [[f64; 2]; 3] = [[0.2, 0.5], [0.5, 0.2], [0.5, 0.5]];

/// What `--json` prints.
#[derive(Serialize)]
struct Measurements<'a> {
    patches: &'a [Measurement],
    bodies: &'a [BodyMeasurement],
}

/// On plane faces errors are below this.
const PLANE: f64 = 1e-12;

/// Measures and prints.
pub fn run(arguments: &AccuracyArguments) -> Result<(), CliError> {
    let elements = elements();
    let mut all = Vec::new();
    for shape in Shape::ALL {
        for size in SIZES {
            for &element in &elements {
                all.push(measure(shape, size, element)?);
            }
        }
    }
    let bodies = measure_bodies()?;
    if arguments.json {
        return output::write_json(&Measurements { patches: &all, bodies: &bodies });
    }
    let names: Vec<&str> = elements.iter().map(|(name, _)| *name).collect();
    output::write_stdout(|writer| {
        for shape in Shape::ALL {
            let found: Vec<&Measurement> = all.iter().filter(|found| found.shape == shape).collect();
            let gap = errors(&found, &names, "gap error", |m| [m.gap_max, m.gap_mean]);
            writeln!(writer, "{gap}")?;
            let of = |m: &Measurement| [m.normal_max_degrees, m.normal_mean_degrees];
            writeln!(writer, "{}", errors(&found, &names, "error of the normal in degrees", of))?;
        }
        writeln!(writer, "{}", masters(&all, &names))?;
        writeln!(writer, "{}", beside_reference(&all))?;
        write!(writer, "{}", on_bodies(&bodies))
    })
}

/// One row for each size, one column for each element: largest and mean error, and the order of the largest.
fn errors(
    found: &[&Measurement],
    names: &[&'static str],
    what: &str,
    of: impl Fn(&Measurement) -> [f64; 2],
) -> Table {
    let description = found.first().map(|first| first.shape.description()).unwrap_or_default();
    let heading = format!("{description}: {what}, largest / mean (order of the largest)");
    let mut table = Table::new(heading, &format!("cell | {}", names.join(" | ")));
    let mut coarser: Option<(f64, Vec<[f64; 2]>)> = None;
    for size in SIZES {
        let row: Vec<[f64; 2]> =
            found.iter().filter(|found| found.cell_degrees == size).map(|found| of(found)).collect();
        let errors = row.iter().enumerate().map(|(k, [largest, mean])| {
            let before = coarser.as_ref().and_then(|(size, row)| Some((*size, row.get(k)?[0])));
            let order = before.and_then(|(before, error)| order([error, *largest], [before, size]));
            let order = order.map(|order| format!(" ({order:.1})")).unwrap_or_default();
            format!("{} / {}{order}", digits(*largest), digits(*mean))
        });
        table.row(format!("{size}° | {}", cells(errors)));
        coarser = Some((size, row));
    }
    table
}

/// Masters of a slave, one row for each surface and size, one column for each weight.
fn masters(all: &[Measurement], names: &[&'static str]) -> Table {
    let smooth: Vec<&str> = names.iter().copied().filter(|name| *name != "facets").collect();
    let columns = format!("surface | cell | {}", smooth.join(" | "));
    let mut table = Table::new("Masters of a slave that have a weight, mean / largest", &columns);
    for shape in Shape::ALL {
        for size in SIZES {
            let found = all.iter().filter(|found| found.shape == shape && found.cell_degrees == size);
            let counts = found.filter_map(|found| Some((found.masters_mean?, found.masters_max?)));
            let counts = counts.map(|(mean, largest)| format!("{mean:.1} / {largest}"));
            table.row(format!("{} | {size}° | {}", shape.description(), cells(counts)));
        }
    }
    table
}

/// The cylinder's errors beside the reference figures.
fn beside_reference(all: &[Measurement]) -> Table {
    let places = PLACES.map(|[s, t]| format!("at ({s}, {t})")).join(" | ");
    let columns = format!("cell | element | reference | largest | mean | {places}");
    let heading = "Cylinder: gap error beside reference figures; (s, t) is a place of the cell, \
                   s around the axis";
    let mut table = Table::new(heading, &columns);
    for (size, reference) in REFERENCE {
        for (name, figure) in REFERENCE_ELEMENTS.into_iter().zip(reference) {
            let found = all.iter().find(|found| {
                found.shape == Shape::Cylinder && found.cell_degrees == size && found.element == name
            });
            let Some(found) = found else { continue };
            let places = PLACES.map(|place| digits(found.gap_at(place))).join(" | ");
            let [largest, mean] = [found.gap_max, found.gap_mean].map(digits);
            table.row(format!("{size}° | {name} | {figure} | {largest} | {mean} | {places}"));
        }
    }
    table
}

/// Gap errors on whole bodies, a row for each face that is not plane.
fn on_bodies(all: &[BodyMeasurement]) -> Table {
    let heading = "Whole bodies: largest gap error in % of the face's mean edge (slaves without contact)";
    let columns = "body | face | facets | smooth | triangles: facets | triangles: smooth";
    let mut table = Table::new(heading, columns);
    for of_body in all.chunk_by(|one, other| one.body == other.body) {
        // Faces come in the same order for both kinds of cells and both elements.
        for first in &of_body[..of_body.len() / 4] {
            let own: Vec<&BodyMeasurement> =
                of_body.iter().filter(|found| found.face == first.face).collect();
            if own.iter().all(|found| found.gap_max < PLANE) {
                continue;
            }
            let errors = own.iter().map(|found| {
                let without = if found.without > 0 { format!(" ({})", found.without) } else { String::new() };
                format!("{}{without}", digits(100.0 * found.gap_max))
            });
            table.row(format!("{} | {} | {}", first.body, first.face, cells(errors)));
        }
    }
    table
}

/// Three digits.
fn digits(value: f64) -> String {
    match value {
        0.0 => "0".into(),
        v if v.abs() < 1e-4 => format!("{v:.2e}"),
        v => {
            let decimals = (2.0 - v.abs().log10().floor()).max(0.0) as usize;
            format!("{v:.decimals$}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        assert_eq!([1.918, 0.01562, 0.381, 3.2e-5].map(digits), ["1.92", "0.0156", "0.381", "3.20e-5"]);
    }
}
