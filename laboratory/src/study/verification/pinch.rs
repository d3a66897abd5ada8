//! A pipe pinched by a plate: contact along the axis, where there is none between bodies that end at planes of symmetry.

use diffuse_contact::surface::SymmetryPlane;
use diffuse_contact_solver::deck::{Deck, DeckError, Reference};
use diffuse_contact_solver::material::Material;
use diffuse_contact_solver::solve::SolveError;

use super::{Decks, Findings, SURFACES, Way, divide, row};
use crate::study::markdown::Table;

/// The axis of the pipe, whose end z = 0 stays in its plane.
const AXIS: usize = 2;

pub fn study(decks: &Decks) -> Result<Findings, SolveError> {
    if decks.fine { refined(decks) } else { descriptions(decks) }
}

/// By description of the master, on the mesh of the deck.
fn descriptions(decks: &Decks) -> Result<Findings, SolveError> {
    let columns = "element | planes of symmetry | axial force over total at the end | \
                   largest of all increments | total at the end, N | iterations | cut-backs";
    let mut table = Table::new("Pinch of a pipe: axial force of contact", columns);
    for way in SURFACES {
        // Layers of hulls end at the mesh.
        let planes: &[bool] = if way.hull_layers { &[false] } else { &[false, true] };
        for &with_planes in planes {
            let mut deck = decks.by(way)?;
            if with_planes {
                name_planes(&mut deck);
            }
            let run = decks.trace(&deck, |snapshot| Ok(snapshot.contact_force()))?;
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
            row(&mut table, &[way.name(), if with_planes { "x, y, z" } else { "none" }], figures);
        }
    }
    Ok(Findings { table, charts: Vec::new() })
}

fn name_planes(deck: &mut Deck) {
    for interface in &mut deck.interfaces {
        interface.symmetry = (0..3).map(|axis| SymmetryPlane::across(axis, [0.0; 3])).collect();
    }
}

/// One way to refine the pinch.
#[derive(Clone, Copy)]
struct Refined {
    /// Cells of the pipe around, through and along; the plate has three quarters of those around.
    cells: [usize; 3],
    /// Penalty per area, over that of the deck.
    penalty: f64,
    is_stiff: bool,
    is_plate_master: bool,
}

impl Refined {
    /// Of the deck.
    const CELLS: [usize; 3] = [16, 2, 2];

    fn plate(cells: [usize; 3]) -> [usize; 3] {
        [cells[0] / 4 * 3, cells[1], cells[2]]
    }

    fn deck(&self, decks: &Decks) -> Result<Deck, DeckError> {
        let mut deck = decks.by(Way::DIFFUSE)?;
        name_planes(&mut deck);
        divide(&mut deck, "pipe", &self.cells);
        divide(&mut deck, "plate", &Self::plate(self.cells));
        let slaves = |[around, _, along]: [usize; 3]| (around * along) as f64;
        for interface in &mut deck.interfaces {
            interface.exchange = self.is_plate_master;
            let factor = self.penalty * slaves(Self::CELLS) / slaves(self.cells);
            interface.penalty = interface.penalty.map(|penalty| penalty * factor);
        }
        if self.is_stiff {
            let steel = deck.materials.values().next().copied();
            let stiff = steel.map(|steel| Material { young: STIFF * steel.young, poisson: 0.0, ..steel });
            deck.materials.extend(stiff.map(|stiff| ("stiff".to_owned(), stiff)));
            for plate in deck.parts.iter_mut().filter(|part| part.name == "plate") {
                plate.materials = vec![(None, Reference { name: "stiff".into(), line: plate.line })];
            }
        }
        Ok(deck)
    }
}

/// Stiffness of a plate that hardly deforms, over that of the pipe.
const STIFF: f64 = 1e4;

/// What is left of the axial force on finer meshes, with a stiffer penalty, from either side.
fn refined(decks: &Decks) -> Result<Findings, SolveError> {
    let mut table = Table::new(
        "Pinch of a pipe: axial force of contact on the pipe over the total, planes named",
        "plate | pipe's cells | penalty | master | at 25 % | at 50 % | at 75 % | at the end | largest",
    );
    for is_stiff in [false, true] {
        // The normals of a flat plate that hardly deforms have no axial part.
        for is_plate_master in [false, true].into_iter().take(if is_stiff { 1 } else { 2 }) {
            for (cells, penalty) in
                [(Refined::CELLS, 1.0), ([32, 2, 4], 1.0), ([32, 2, 8], 1.0), ([32, 2, 8], 10.0)]
            {
                let way = Refined { cells, penalty, is_stiff, is_plate_master };
                let deck = way.deck(decks)?;
                let run =
                    decks.trace(&deck, |snapshot| Ok((snapshot.record.time, snapshot.contact_force())))?;
                let figures = run.map(|run| {
                    // Forces are those on the slave.
                    let sign = if is_plate_master { 100.0 } else { -100.0 };
                    let share = |(time, force): &(f64, [f64; 3])| {
                        (*time, sign * force[AXIS] / force.iter().map(|f| f * f).sum::<f64>().sqrt())
                    };
                    let all: Vec<(f64, f64)> = run.measures.iter().map(share).collect();
                    let at = |part| share_at(&all, part);
                    // There is none without a force.
                    let shares = all.iter().map(|(_, share)| share.abs()).filter(|share| share.is_finite());
                    let largest = shares.fold(0.0, f64::max);
                    [at(0.25), at(0.5), at(0.75), at(1.0), format!("{largest:.3} %")]
                });
                let stiffness = if is_stiff { "10⁴ times as stiff" } else { "as stiff as the pipe" };
                let cells = cells.map(|cells| cells.to_string()).join(" × ");
                let master = if is_plate_master { "plate" } else { "pipe" };
                row(&mut table, &[stiffness, &cells, &format!("{penalty} ×"), master], figures);
            }
        }
    }
    Ok(Findings { table, charts: Vec::new() })
}

/// The share when this part of the time has passed, however long the increments were; nothing without a force.
fn share_at(shares: &[(f64, f64)], part: f64) -> String {
    let end = shares.last().map_or(0.0, |(time, _)| *time);
    let passed = shares.iter().find(|(time, _)| *time >= part * end * (1.0 - 1e-9));
    match passed {
        Some((_, share)) if share.is_finite() => format!("{share:+.3} %"),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_belong_to_times() {
        // Without a force first, and with increments cut back in the middle.
        let shares =
            [(0.1, f64::NAN), (0.25, 1.0), (0.5, 2.0), (0.55, 3.0), (0.6, 4.0), (0.8, 5.0), (1.0, 6.0)];
        let at = |part| share_at(&shares, part);
        assert_eq!([0.25, 0.5, 0.75, 1.0].map(at), ["+1.000 %", "+2.000 %", "+5.000 %", "+6.000 %"]);
        assert_eq!([at(0.1), share_at(&[], 0.5)], ["", ""]);
    }
}
