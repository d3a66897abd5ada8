//! A pipe pinched by a plate: contact along the axis, where there is none between bodies that end at planes of symmetry.

use diffuse_contact::surface::SymmetryPlane;
use diffuse_contact_solver::solve::SolveError;
use diffuse_contact_solver::verification::trace;

use super::{Decks, Findings, SURFACES, outcome, row};
use crate::study::markdown::Table;

/// The axis of the pipe, whose end z = 0 stays in its plane.
const AXIS: usize = 2;

pub fn study(decks: &Decks) -> Result<Findings, SolveError> {
    let columns = [
        "element",
        "planes of symmetry",
        "axial force over total at the end",
        "largest of all increments",
        "total at the end, N",
        "iterations",
        "cut-backs",
    ];
    let mut table = Table::new("Pinch of a pipe: axial force of contact", columns);
    for way in SURFACES {
        // Layers of hulls end at the mesh.
        let planes: &[bool] = if way.hull_layers { &[false] } else { &[false, true] };
        for &with_planes in planes {
            let mut deck = decks.by(way)?;
            for interface in &mut deck.interfaces {
                if with_planes {
                    interface.symmetry = (0..3).map(|axis| SymmetryPlane::across(axis, [0.0; 3])).collect();
                }
            }
            let run =
                outcome(trace(&deck, decks.base(), decks.threads, |snapshot| Ok(snapshot.contact_force())))?;
            let figures = run.map(|run| {
                let total = |force: &[f64; 3]| force.iter().map(|f| f * f).sum::<f64>().sqrt();
                let share = |force: &[f64; 3]| force[AXIS].abs() / total(force);
                let last = run.measures.last().copied().unwrap_or([f64::NAN; 3]);
                let largest = run.measures.iter().map(share).fold(0.0, f64::max);
                [
                    format!("{:.3} %", 100.0 * share(&last)),
                    format!("{:.3} %", 100.0 * largest),
                    format!("{:.0}", total(&last)),
                    run.iterations.to_string(),
                    run.cutbacks.to_string(),
                ]
            });
            row(&mut table, [way.name(), if with_planes { "x, y, z" } else { "none" }], figures);
        }
    }
    Ok(Findings { tables: vec![table], charts: Vec::new() })
}
