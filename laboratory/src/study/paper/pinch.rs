//! The paper's second example: a pipe pinched between plates.

use std::fmt::Write as _;

use super::case::{Case, Outcome, saving};
use super::plot::{Axes, Body, Face, figure, shapes};
use super::{Chapter, Decks, Pictures, steps};
use crate::error::CliError;
use crate::study::StudyError;
use crate::study::markdown::Table;
use crate::study::plot::{COLOURS, Curve, Mark, Scale};

const ELASTIC: &str = include_str!("../../../../examples/pipe_pinch.toml");
const PLASTIC: &str = include_str!("../../../../examples/pipe_pinch_plastic.toml");

/// Cells of a mesh: around the pipe, along the plate, along z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mesh {
    name: &'static str,
    pipe: i64,
    plate: i64,
    along: i64,
}

const MESHES: [Mesh; 3] = [
    Mesh { name: "coarse", pipe: 16, plate: 12, along: 2 },
    Mesh { name: "medium", pipe: 24, plate: 18, along: 3 },
    Mesh { name: "fine", pipe: 32, plate: 24, along: 4 },
];
/// Force per length.
pub const PENALTIES: [f64; 3] = [2e5, 2e6, 2e7];

/// What is also run with facets found anew in every iteration.
const REFRESHED: [Pipe; 2] = [Pipe::Elastic, Pipe::Plastic];

/// Elastic or elastoplastic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pipe {
    Elastic,
    Plastic,
}

/// Whose surface is the master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Master {
    Pipe,
    Plate,
}

impl Master {
    pub const ALL: [Self; 2] = [Self::Pipe, Self::Plate];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Pipe => "pipe",
            Self::Plate => "plate",
        }
    }
}

/// What is run.
pub struct Scope {
    /// The coarsest first.
    pub meshes: &'static [Mesh],
    /// The softest first.
    pub penalties: &'static [f64],
    /// Increments of each run, all of them if there is no limit.
    pub limit: Option<usize>,
}

impl Scope {
    /// All, or a part of it that shows that everything works.
    pub fn new(is_quick: bool) -> Self {
        if is_quick {
            let meshes = &MESHES[..1];
            return Self { meshes, penalties: &PENALTIES[1..2], limit: Some(4) };
        }
        Self { meshes: &MESHES, penalties: &PENALTIES, limit: None }
    }

    /// Number of runs.
    pub fn runs(&self) -> usize {
        2 * self.meshes.len() * self.penalties.len() * 4 + 2 * REFRESHED.len() + steps::runs(self)
    }

    /// Number of runs of the figures.
    pub const fn drawn_runs(&self) -> usize {
        2 * (2 + self.meshes.len())
    }

    /// The finest mesh.
    pub fn finest(&self) -> Mesh {
        self.meshes[self.meshes.len() - 1]
    }

    /// The coarsest mesh.
    pub fn coarsest(&self) -> Mesh {
        self.meshes[0]
    }

    /// The stiffest penalty.
    pub fn stiffest(&self) -> f64 {
        self.penalties[self.penalties.len() - 1]
    }
}

/// A deck with the diffuse element.
pub fn case(pipe: Pipe, mesh: Mesh, penalty: f64, master: Master, limit: Option<usize>) -> Case {
    let (name, text) = match pipe {
        Pipe::Elastic => ("pipe_pinch", ELASTIC),
        Pipe::Plastic => ("pipe_pinch_plastic", PLASTIC),
    };
    let Mesh { name: cells, pipe, plate, along } = mesh;
    Case::new(name, text)
        .with("parts.pipe.divisions", vec![pipe, 2, along])
        .with("parts.plate.divisions", vec![plate, 2, along])
        .with("interface.penalty", penalty)
        .with("interface.exchange", master == Master::Plate)
        .named(&format!("{cells}-{penalty:.0e}-{}", master.name()))
        .up_to(limit)
}

/// Both elements on the same deck.
struct Pair {
    mesh: Mesh,
    penalty: f64,
    master: Master,
    diffuse: Outcome,
    classic: Outcome,
}

/// Runs them all.
pub fn chapter(decks: &Decks, scope: &Scope) -> Result<Chapter, CliError> {
    let elastic = pairs(decks, scope, Pipe::Elastic, scope.meshes)?;
    let plastic = pairs(decks, scope, Pipe::Plastic, scope.meshes)?;
    let refreshed = refreshed(decks, scope)?;
    let longer = steps::table(decks, scope)?;
    let stiffest = scope.stiffest();
    let is_shown = |pair: &&Pair| pair.master == Master::Pipe && pair.penalty == stiffest;
    let softest = [&elastic[..], &plastic].map(|pairs| pairs.first());
    let pictures = drawn(scope, elastic.iter().filter(is_shown), softest)?;
    Ok(Chapter { text: text(&elastic, &plastic, &refreshed, &longer), pictures })
}

/// The figures alone.
pub fn pictures(decks: &Decks, scope: &Scope) -> Result<Pictures, CliError> {
    let run = |pipe, mesh, penalty| pair(decks, scope, pipe, (mesh, penalty, Master::Pipe));
    let mut stiff = Vec::new();
    for &mesh in scope.meshes {
        stiff.push(run(Pipe::Elastic, mesh, scope.stiffest())?);
    }
    let soft = |pipe| run(pipe, scope.coarsest(), scope.penalties[0]);
    let (elastic, plastic) = (soft(Pipe::Elastic)?, soft(Pipe::Plastic)?);
    Ok(drawn(scope, stiff.iter(), [Some(&elastic), Some(&plastic)])?)
}

/// `stiff`: with the stiffest penalty, by mesh. `soft`: on the coarsest mesh with the softest one, elastic and elastoplastic.
fn drawn<'a>(
    scope: &Scope,
    stiff: impl Iterator<Item = &'a Pair>,
    soft: [Option<&Pair>; 2],
) -> Result<Pictures, StudyError> {
    let mut pictures = vec![("paper-iterations.svg", iterations(scope.stiffest(), stiff)?)];
    let kinds =
        [("paper-pinch-elastic.svg", "Elastic", 80.0), ("paper-pinch-plastic.svg", "Elastoplastic", 100.0)];
    for ((name, kind, end), pair) in kinds.into_iter().zip(soft) {
        if let Some(Pair { mesh, penalty, diffuse, .. }) = pair {
            let title = format!(
                "{kind} pinch, {} mesh, penalty {penalty:.0e} N/mm, smooth surface: the side z = 0",
                mesh.name
            );
            pictures.push((name, deformed(&title, diffuse, end)?));
        }
    }
    Ok(pictures)
}

/// How many iterations fewer the smooth surface has taken so far, by mesh.
fn iterations<'a>(penalty: f64, pairs: impl Iterator<Item = &'a Pair>) -> Result<String, StudyError> {
    let marks = [Mark::PointsDotted, Mark::PointsDashed, Mark::Points];
    let curves = pairs.zip(marks).map(|(pair, mark)| {
        let (smooth, facets) = (cumulated(&pair.diffuse), cumulated(&pair.classic));
        let total = |points: &[(f64, f64)]| points.last().map_or(0.0, |point| point.1);
        let label = format!("{} mesh:\n{}, facets {}", pair.mesh.name, total(&smooth), total(&facets));
        let points = smooth.iter().zip(&facets).map(|(smooth, facets)| (smooth.0, facets.1 - smooth.1));
        Curve::new(label, COLOURS.other, mark, points)
    });
    let axes = Axes {
        names: ["displacement of the plate, mm", "iterations saved so far"],
        x: |[_, end]| Scale::Linear(0.0..end),
        y: |[low, high]| Scale::Counts(low.min(0.0) - 1.0..high + 1.0),
    };
    let title = format!(
        "Iterations that the smooth surface saves beside facets: elastic pinch, pipe as master, {penalty:.0e} N/mm"
    );
    figure(&title, &axes, curves.collect())
}

/// Start, middle and end of a run whose plate moves by `end`.
fn deformed(title: &str, outcome: &Outcome, end: f64) -> Result<String, StudyError> {
    let last = outcome.positions.len().saturating_sub(1);
    let mut parts = vec![("start".to_owned(), faces(outcome, &outcome.start))];
    parts.extend([last / 2, last].map(|k| {
        let reached = end * outcome.increments[k].time;
        (format!("plate's upper face {reached:.0} mm down"), faces(outcome, &outcome.positions[k]))
    }));
    let note = [
        "Only nodes of the plate are kept out of the pipe, whose smooth surface is not drawn.",
        "Nodes of the pipe may enter the plate.",
    ];
    shapes(title, &parts, note)
}

fn pairs(decks: &Decks, scope: &Scope, pipe: Pipe, meshes: &[Mesh]) -> Result<Vec<Pair>, CliError> {
    let mut pairs = Vec::new();
    for &mesh in meshes {
        for master in Master::ALL {
            for &penalty in scope.penalties {
                pairs.push(pair(decks, scope, pipe, (mesh, penalty, master))?);
            }
        }
    }
    Ok(pairs)
}

fn pair(
    decks: &Decks,
    scope: &Scope,
    pipe: Pipe,
    (mesh, penalty, master): (Mesh, f64, Master),
) -> Result<Pair, CliError> {
    let case = case(pipe, mesh, penalty, master, scope.limit);
    let diffuse = decks.run(&case)?;
    let classic = decks.run(&case.classic())?;
    Ok(Pair { mesh, penalty, master, diffuse, classic })
}

/// Pairs on the finest meshes, their facets found anew in every iteration, as lists of the diffuse element follow.
fn refreshed(decks: &Decks, scope: &Scope) -> Result<Vec<(Pipe, Pair)>, CliError> {
    let mut pairs = Vec::new();
    for pipe in REFRESHED {
        let (mesh, penalty, master) = (scope.finest(), PENALTIES[1], Master::Pipe);
        let case = case(pipe, mesh, penalty, master, scope.limit).named("anew");
        let diffuse = decks.run(&case)?;
        let classic = decks.run(&case.classic().with("interface.refresh", "iteration"))?;
        pairs.push((pipe, Pair { mesh, penalty, master, diffuse, classic }));
    }
    Ok(pairs)
}

/// Displacement of the plate, iterations so far.
fn cumulated(outcome: &Outcome) -> Vec<(f64, f64)> {
    let mut sum = 0;
    let points = outcome.increments.iter().map(|record| {
        sum += record.iterations;
        (80.0 * record.time, sum as f64)
    });
    points.collect()
}

/// The faces of pipe and plate on the side z = 0, seen along z.
fn faces(outcome: &Outcome, positions: &[[f64; 3]]) -> Vec<Face> {
    let faces = [(Body::Pipe, "pipe.bottom"), (Body::Plate, "plate.z-")].into_iter();
    faces
        .flat_map(|(body, name)| outcome.surfaces[name].iter().map(move |face| (body, face)))
        .map(|(body, face)| {
            let corners = face.corners();
            let ring = corners.iter().chain(corners.first());
            (body, ring.map(|&node| (positions[node][0], positions[node][1])).collect())
        })
        .collect()
}

const COLUMNS: &str = "mesh | master | penalty, N/mm | diffuse | facets | fewer | time, diffuse over facets | \
                       penetration, mm";

impl Pair {
    fn row(&self, label: &str) -> String {
        let Self { mesh: Mesh { name, pipe, plate, along }, penalty, master, diffuse, classic } = self;
        let ratio = diffuse.wall.as_secs_f64() / classic.wall.as_secs_f64();
        let has_both = diffuse.converged() && classic.converged();
        let cells = [
            format!("{label}{name}, {pipe} × 2 × {along} on {plate} × 2 × {along}"),
            master.name().to_owned(),
            format!("{penalty:.0e}"),
            diffuse.count(),
            classic.count(),
            saving(diffuse, classic),
            if has_both { format!("{ratio:.2}") } else { "–".into() },
            format!("{:.3}, {:.3}", diffuse.penetration(), classic.penetration()),
        ];
        cells.join(" | ")
    }
}

/// Iterations of all that converged with both elements, and how many fewer.
fn total(pairs: &[Pair], master: Master) -> String {
    let both: Vec<&Pair> = pairs
        .iter()
        .filter(|pair| pair.master == master && pair.diffuse.converged() && pair.classic.converged())
        .collect();
    let sum =
        |outcome: fn(&Pair) -> &Outcome| both.iter().map(|pair| outcome(pair).iterations).sum::<usize>();
    let (diffuse, classic) = (sum(|pair| &pair.diffuse), sum(|pair| &pair.classic));
    let fewer = 100.0 * (1.0 - diffuse as f64 / classic.max(1) as f64);
    let word = if fewer < 0.0 { "more" } else { "fewer" };
    format!("{diffuse} against {classic} over {} decks, {:.1} % {word}", both.len(), fewer.abs())
}

fn text(elastic: &[Pair], plastic: &[Pair], refreshed: &[(Pipe, Pair)], longer: &Table) -> String {
    let tables =
        [("Elastic: 80 mm in 32 increments", elastic), ("Elastoplastic: 100 mm in 100 increments", plastic)];
    let mut text = "## A pipe pinched between plates\n\n\
         `examples/pipe_pinch.toml` and `examples/pipe_pinch_plastic.toml`: a quarter of a pipe and half of a plate, both deformable; \
         the plate's upper face moves down. The paper prints no dimensions. Elastic: radius 100 mm, thickness 10. A pipe \
         of this size cannot be pinched by 100 mm: its inner surface is at the plane of symmetry after 90. The elastoplastic one is half as \
         large again in all directions.\n\n\
         The curved pipe is the master, whose facets have kinks; with the plate as master both elements see a nearly plane surface.\n"
        .to_owned();
    for (heading, pairs) in tables {
        let mut table = Table::new(format!("### {heading}"), COLUMNS);
        pairs.iter().for_each(|pair| table.row(pair.row("")));
        let (pipe, plate) = (total(pairs, Master::Pipe), total(pairs, Master::Plate));
        let _ = write!(text, "\n{table}\nTogether, pipe as master: {pipe}. Plate as master: {plate}.\n");
    }
    let mut table =
        Table::new("### Facets found anew in every iteration instead of every increment", COLUMNS);
    for (pipe, pair) in refreshed {
        let label = if *pipe == Pipe::Elastic { "elastic, " } else { "elastoplastic, " };
        table.row(pair.row(label));
    }
    let _ = write!(
        text,
        "\n{table}\n{longer}\n\
         ![Iterations that the smooth surface has saved beside facets while the plate moves, by mesh: at most three in \
         the end, or three more](pictures/paper-iterations.svg)\n\n\
         ![The elastic pipe under the plate at three times: round, then flat along the plate, then clear of it in the \
         middle](pictures/paper-pinch-elastic.svg)\n\n\
         ![The elastoplastic pipe under the plate at three times: round, then dented in the middle, then more so](pictures/paper-pinch-plastic.svg)\n"
    );
    if let Some(pair) = elastic.iter().find(|pair| pair.master == Master::Pipe) {
        let _ = write!(text, "\n{}", shares(pair));
    }
    text
}

/// Where the time of a pair of runs goes.
fn shares(pair: &Pair) -> String {
    let title = format!("### Where the time goes, {} mesh, pipe as master, in % of the run", pair.mesh.name);
    let mut table = Table::new(title, "element | solid | contact evaluation | pairing | linear solver");
    for (name, outcome) in [("diffuse", &pair.diffuse), ("facets", &pair.classic)] {
        let timing = outcome.timing;
        let parts = [timing.solid, timing.contact, timing.pairing, timing.linear];
        let share = |part: std::time::Duration| {
            format!("{:.1}", 100.0 * part.as_secs_f64() / outcome.wall.as_secs_f64())
        };
        table.row(format!("{name} | {}", parts.map(share).join(" | ")));
    }
    table.to_string()
}
