//! The work of contact around a closed path: a rigid pad is carried around over waves, with its nodes or its faces as slaves.
//!
//! Over nodes the force on the pad is the gradient of an energy, over faces it is none: what that costs is the work of a closed loop.

use diffuse_contact::assembly::{ContactLaw, DofMap};
use diffuse_contact::faces::{FaceInterface, FaceOptions};
use diffuse_contact::interface::{ContactInterface, InterfaceOptions};
use diffuse_contact::surface::{Facet, MasterSurface};
use diffuse_contact::{Mode, Point};
use rayon::prelude::*;

use super::arguments::ClosedPathArguments;
use super::markdown::Table;
use super::patch::Patch;
use super::sweep::scene::{self, Cells};
use super::{StudyError, dot, extremes, norm};
use crate::error::CliError;
use crate::output;

/// Cells of the pad along each side.
const PAD: usize = 14;
/// Side of its cells.
const SIZE: f64 = 0.41;

/// A column of the table.
struct Loop {
    /// ∮ F·dx over ∮ ‖F‖ ‖dx‖ with all steps and with every other one.
    work: [f64; 2],
    /// The least and the largest ‖F‖.
    force: [f64; 2],
}

/// Goes around in all ways and prints the table.
pub fn run(arguments: &ClosedPathArguments) -> Result<(), CliError> {
    let [smooth, facets] = [InterfaceOptions::default(), InterfaceOptions::node_to_facet()];
    let ways = [
        ("smooth, nodes", smooth, false),
        ("smooth, faces", smooth, true),
        ("facets, nodes", facets, false),
        ("facets, faces", facets, true),
    ];
    // An even number: every other step is a loop, too.
    let steps = 2 * arguments.steps.div_ceil(2) as usize;
    let loops = ways
        .into_par_iter()
        .map(|(name, options, over_faces)| Ok((name, around(options, over_faces, steps)?)))
        .collect::<Result<Vec<_>, StudyError>>()?;
    let heading = format!("∮ F·dx over ∮ ‖F‖ ‖dx‖ of a pad around a closed path over waves, {steps} steps");
    let mut table = Table::new(heading, "way | ‖F‖ | work | with half of the steps");
    for (name, Loop { work: [work, coarse], force: [least, largest] }) in loops {
        table.row(format!("{name} | {least:.3} to {largest:.3} | {work:+.1e} | {coarse:+.1e}"));
    }
    output::write_stdout(|writer| write!(writer, "{table}"))
}

/// The pad's lowest point, 0.05 straight below the exact surface.
fn path(turn: f64) -> Point {
    let ([x, y, z], _) = scene::figure(turn);
    [x, y, z - 0.05]
}

/// The facets of a patch, every third one cut in two triangles.
fn facets(patch: Patch) -> Vec<Facet> {
    let cut = |(cell, facet)| match facet {
        Facet::Quadrilateral([a, b, c, d]) if cell % 3 == 0 => {
            vec![Facet::Triangle([a, b, c]), Facet::Triangle([a, c, d])]
        }
        facet => vec![facet],
    };
    patch.facets.into_iter().enumerate().flat_map(cut).collect()
}

/// The pad's lower side is z = r²/2.
fn pad() -> Patch {
    Patch::new([PAD; 2], |i, j| {
        let [x, y] = [i, j].map(|k| SIZE * (k - 0.5 * PAD as f64));
        [x, y, 0.5 * (x * x + y * y)]
    })
}

enum Contact {
    Nodes(Box<ContactInterface>),
    Faces(Box<FaceInterface>),
}

impl Contact {
    /// Forces on all nodes.
    fn forces(&mut self, positions: &[Point]) -> Result<Vec<f64>, StudyError> {
        let (law, dofs) = (ContactLaw::penalty(1.0), DofMap::standard(positions.len()));
        let mut forces = vec![0.0; dofs.equations()];
        match self {
            Self::Nodes(interface) => {
                interface.renew_pairing(positions)?;
                let contacts = interface.evaluate(Mode::Gradient)?;
                diffuse_contact::add_forces(contacts, &law, &dofs, &mut forces)?;
            }
            Self::Faces(interface) => {
                interface.refresh(positions)?;
                interface.evaluate(&law, Mode::Gradient)?.add_forces(&dofs, &mut forces)?;
            }
        }
        Ok(forces)
    }
}

fn around(options: InterfaceOptions, over_faces: bool, steps: usize) -> Result<Loop, StudyError> {
    let waves = Cells { refine: 1, moved: 0.0 }.mesh();
    let nodes = waves.positions.clone();
    let (first, own) = (nodes.len(), pad().positions);
    let at = |place: Point| -> Vec<Point> {
        let moved = own.iter().map(|x| [0, 1, 2].map(|axis| x[axis] + place[axis]));
        nodes.iter().copied().chain(moved).collect()
    };
    let below = facets(pad()).into_iter().map(|facet| match facet {
        Facet::Triangle(corners) => Facet::Triangle(corners.map(|k| k + first)).flipped(),
        Facet::Quadrilateral(corners) => Facet::Quadrilateral(corners.map(|k| k + first)).flipped(),
    });
    let below: Vec<Facet> = below.collect();
    let (start, surface) = (at(path(0.0)), MasterSurface::new(&nodes, facets(waves))?);
    let mut contact = if over_faces {
        let options = FaceOptions::new(options);
        Contact::Faces(Box::new(FaceInterface::new(surface, &below, &start, options)?))
    } else {
        let (slaves, options) = ((first..start.len()).collect(), options.with_areas(true));
        Contact::Nodes(Box::new(ContactInterface::new(surface, slaves, &below, &start, options)?))
    };
    let places: Vec<Point> = (0..steps).map(|step| path(step as f64 / steps as f64)).collect();
    let forces = places.iter().map(|&place| {
        let forces = contact.forces(&at(place))?;
        let of_pad = forces[3 * first..].as_chunks::<3>().0;
        Ok([0, 1, 2].map(|axis| of_pad.iter().map(|force| force[axis]).sum()))
    });
    let forces = forces.collect::<Result<Vec<Point>, StudyError>>()?;
    let sizes = forces.iter().copied().map(norm);
    Ok(Loop { work: [1, 2].map(|every| work(&places, &forces, every)), force: extremes(sizes) })
}

/// ∮ F·dx over ∮ ‖F‖ ‖dx‖ by the trapezoidal rule with every so many steps.
fn work(places: &[Point], forces: &[Point], every: usize) -> f64 {
    let (mut work, mut effort) = (0.0, 0.0);
    for from in (0..places.len()).step_by(every) {
        let to = (from + every) % places.len();
        let along = [0, 1, 2].map(|axis| places[to][axis] - places[from][axis]);
        work += 0.5 * (dot(forces[from], along) + dot(forces[to], along));
        effort += 0.5 * (norm(forces[from]) + norm(forces[to])) * norm(along);
    }
    work / effort
}
