//! Problems with known answers, solved with both elements: how far off each is.
//!
//! Every problem is a deck, `examples/NAME.toml`, run as it is and with one thing changed at a time: the element, the mesh, which side is
//! the master. Increments and tolerance are those of the deck for both elements, and so is the penalty, but for faces beside a deck whose
//! penalty is per node: there it is the automatic one.

mod elastic;
mod folding;
mod hertz;
mod mindlin;
mod patch;
mod pinch;
mod plot;
mod ring;
mod sliding;
mod turning;

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use diffuse_contact::interface::ContactElement;
use diffuse_contact::neighbourhood::{NeighbourRule, SearchOptions};
use diffuse_contact_solver::contact::Integration;
use diffuse_contact_solver::deck::{Contact, Deck, DeckError};
use diffuse_contact_solver::solid::SolidError;
use diffuse_contact_solver::solve::SolveError;
use diffuse_contact_solver::statics::StaticsError;
use diffuse_contact_solver::verification::{Snapshot, Trace, trace};

use crate::error::CliError;
use crate::output;
use crate::study::StudyError;
use crate::study::arguments::{VerificationArguments, VerificationProblem, name};
use crate::study::error::of_deck;
use crate::study::markdown::Table;
use crate::study::plot::{COLOURS, Chart, Colour, Curve, Mark};
use crate::threads::with_threads;

/// The descriptions of a master, the classic one first, and the smooth one over faces beside nodes with the same penalty.
const SURFACES: [Way; 5] =
    [Way::FACETS, Way::DIFFUSE, Way::HULL_LAYERS, Way::DIFFUSE_BY_AREA, Way::DIFFUSE_OVER_FACES];

/// An element, which nodes it takes, and what contact is integrated over.
#[derive(Clone, Copy)]
struct Way {
    element: Contact,
    over_faces: bool,
    /// Layers of hulls in place of nodal domains.
    hull_layers: bool,
    /// The penalty is the automatic one, per area, as over faces it is in place of one per node.
    by_area: bool,
}

impl Way {
    const FACETS: Self =
        Self { element: Contact::NodeToFacet, over_faces: false, hull_layers: false, by_area: false };
    const DIFFUSE: Self = Self { element: Contact::Diffuse, ..Self::FACETS };
    const HULL_LAYERS: Self = Self { hull_layers: true, ..Self::DIFFUSE };
    const DIFFUSE_BY_AREA: Self = Self { by_area: true, ..Self::DIFFUSE };
    const FACETS_OVER_FACES: Self = Self { over_faces: true, ..Self::FACETS };
    const DIFFUSE_OVER_FACES: Self = Self { over_faces: true, ..Self::DIFFUSE };

    const fn name(self) -> &'static str {
        match (self.element, self.over_faces) {
            _ if self.hull_layers => "diffuse, hull layers",
            _ if self.by_area => "diffuse, automatic penalty",
            (element, false) => element.name(),
            (Contact::NodeToFacet, true) => "facets over faces",
            (Contact::Diffuse | Contact::None, true) => "diffuse over faces",
        }
    }

    fn colour(self) -> Colour {
        match (self.element, self.over_faces) {
            (_, true) => COLOURS.faces,
            _ if self.hull_layers => COLOURS.hull_layers,
            _ if self.by_area => COLOURS.automatic_penalty,
            (Contact::NodeToFacet, false) => COLOURS.facets,
            (Contact::Diffuse | Contact::None, false) => COLOURS.smooth,
        }
    }

    fn curve(self, points: impl Iterator<Item = (f64, f64)>) -> Curve {
        Curve::new(self.name(), self.colour(), Mark::Points, points)
    }
}

/// What a problem gave.
struct Findings {
    table: Table,
    /// Charts, one above the other.
    charts: Vec<Chart>,
}

/// Solves the problems and prints their tables.
pub fn run(arguments: &VerificationArguments) -> Result<(), CliError> {
    let all = VerificationProblem::value_variants().iter().copied();
    let problems: Vec<VerificationProblem> = match &arguments.problems[..] {
        [] if arguments.fine => all.filter(|problem| problem.has_fine_meshes()).collect(),
        [] => all.collect(),
        some => some.to_vec(),
    };
    if let Some(&problem) = problems.iter().find(|problem| arguments.fine && !problem.has_fine_meshes()) {
        return Err(StudyError::NoFineMeshes { problem: name(problem) }.into());
    }
    let picture = |problem: VerificationProblem| {
        arguments.pictures.as_ref().map(|directory| directory.join(format!("{}.svg", name(problem))))
    };
    for path in problems.iter().filter_map(|&problem| picture(problem)).filter(|_| !arguments.fine) {
        output::check_target(&path)?;
    }
    with_threads(arguments.threads, || {
        for &problem in &problems {
            let decks = Decks {
                path: arguments.decks.join(format!("{}.toml", name(problem))),
                threads: arguments.threads.unwrap_or(1),
                fine: arguments.fine,
            };
            let findings = match problem {
                VerificationProblem::PatchTest => patch::study(&decks),
                VerificationProblem::HertzCylinder => hertz::cylinder(&decks),
                VerificationProblem::HertzSphere => hertz::ball(&decks),
                VerificationProblem::ElasticCylinder => elastic::study(&decks),
                VerificationProblem::CoaxialCylinders => turning::study(&decks),
                VerificationProblem::SlidingBlock => sliding::study(&decks),
                VerificationProblem::RingBlock => ring::study(&decks),
                VerificationProblem::PipePinch => pinch::study(&decks),
                VerificationProblem::CattaneoMindlin => mindlin::study(&decks),
                VerificationProblem::SqueezedTube => folding::study(&decks, "Squeezed tube"),
                VerificationProblem::CrushedSerpentine => folding::study(&decks, "Crushed serpentine"),
                VerificationProblem::CoilSpring => folding::study(&decks, "Coil spring"),
            };
            let Findings { table, charts } = findings.map_err(of_deck)?;
            if let (Some(path), false) = (picture(problem), charts.is_empty()) {
                let svg = plot::draw(&charts)?;
                output::write_file(&path, |writer| writer.write_all(svg.as_bytes()))?;
            }
            output::write_stdout(|writer| writeln!(writer, "{table}"))?;
        }
        Ok(())
    })
}

/// The deck of a problem.
struct Decks {
    path: PathBuf,
    threads: usize,
    /// Whether the meshes that take minutes are asked for, in place of the others.
    fine: bool,
}

impl Decks {
    /// The deck as it is, but with this element.
    fn with(&self, element: Contact) -> Result<Deck, DeckError> {
        Ok(Deck { contact: element, ..Deck::read(&self.path)? })
    }

    /// The deck as it is, but with this element and these neighbours over nodes or faces. A penalty per node is none per area: the
    /// automatic one takes its place.
    fn by(&self, way: Way) -> Result<Deck, DeckError> {
        let mut deck = self.with(way.element)?;
        for interface in &mut deck.interfaces {
            let is_by_area = interface.surface.areas || interface.integration != Integration::Nodes;
            if !is_by_area && (way.over_faces || way.by_area) {
                interface.penalty = None;
            }
            if way.over_faces {
                interface.integration = Integration::FACES;
            } else {
                interface.integration = Integration::Nodes;
                interface.surface.areas = is_by_area;
            }
            if way.hull_layers {
                let search = SearchOptions::default().with_rule(NeighbourRule::hull_layers(None));
                interface.surface.element = ContactElement::diffuse(search);
            }
        }
        Ok(deck)
    }

    /// What its file names are relative to.
    fn base(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }

    /// Runs a deck. That it finds no equilibrium is a result like others: the reason stands in the place of the numbers.
    fn trace<T>(
        &self,
        deck: &Deck,
        measure: impl FnMut(&Snapshot<'_>) -> Result<T, SolidError>,
    ) -> Result<Result<Trace<T>, String>, SolveError> {
        match trace(deck, self.base(), self.threads, measure) {
            Ok(run) => Ok(Ok(run)),
            Err(SolveError::Statics(StaticsError::NoConvergence { time, .. })) => {
                Ok(Err(format!("no equilibrium beyond t = {time:.3}")))
            }
            Err(error) => Err(error),
        }
    }
}

/// A row of a run: its names and either its figures or the reason, which takes the place of the first figure.
fn row<const N: usize>(table: &mut Table, names: &[&str], figures: Result<[String; N], String>) {
    let figures = figures.map_or_else(|reason| reason + &" | –".repeat(N - 1), |figures| figures.join(" | "));
    table.row(format!("{} | {figures}", names.join(" | ")));
}

/// How many times larger a figure is with facets, which come first: `classic` is theirs, once it is known.
fn classic_over(classic: &mut Option<f64>, way: Way, own: f64) -> String {
    match (way.element, *classic) {
        (Contact::NodeToFacet, _) => {
            *classic = Some(own);
            String::new()
        }
        (_, Some(classic)) => format!("{:.1}", classic / own),
        (_, None) => "–".to_owned(),
    }
}

/// Sets the numbers of cells of a part of a shipped deck.
fn divide(deck: &mut Deck, part: &str, divisions: &[usize]) {
    if let Some(shape) = deck.shape_mut(part) {
        let own = shape.divisions_mut();
        for (own, &new) in own.iter_mut().zip(divisions) {
            *own = new;
        }
    }
}

/// Of a hundred, with a sign.
fn percent(ratio: f64) -> String {
    format!("{:+.2} %", 100.0 * ratio)
}
