//! From a deck to results.

use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::contact::ContactSet;
use crate::deck::{Contact, Deck, DeckError, Sides};
use crate::model::Model;
use crate::output::{Claim, OutputError, Recorder, RecorderOptions, Summary, Watcher, names, read_json};
use crate::report::{self, Master, sample_surfaces};
use crate::solid::Solid;
use crate::statics::{Problem, Settings, ShownTime, State, Statics, StaticsError};

/// What to do with a deck.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SolveOptions {
    /// Directory of results.
    pub out: PathBuf,
    /// Go on from the last finished increment in `out`.
    pub restart: bool,
    /// Replace results in `out`.
    pub overwrite: bool,
    /// Threads of the linear solver; elements and contacts use those of the current rayon pool.
    pub threads: usize,
}

impl SolveOptions {
    /// Results go to a directory that holds none, one thread solves linear systems.
    pub fn new(out: impl Into<PathBuf>) -> Self {
        Self { out: out.into(), restart: false, overwrite: false, threads: 1 }
    }

    /// Goes on from the last finished increment, or begins anew.
    #[must_use]
    pub fn with_restart(self, restart: bool) -> Self {
        Self { restart, ..self }
    }

    /// Replaces results, or refuses to.
    #[must_use]
    pub fn with_overwrite(self, overwrite: bool) -> Self {
        Self { overwrite, ..self }
    }

    /// With so many threads of the linear solver.
    #[must_use]
    pub fn with_threads(self, threads: usize) -> Self {
        Self { threads, ..self }
    }
}

/// Why there are no results, or none to the end.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum SolveError {
    #[error(transparent)]
    Deck(#[from] DeckError),
    /// Elements or materials.
    #[error(transparent)]
    Solid(#[from] crate::solid::SolidError),
    /// Settings, or the state of a restart.
    #[error(transparent)]
    Statics(#[from] StaticsError),
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The run ended before the end of time; all increments before are on disk.
    #[error("{reason}; finished increments: {increments}, up to time {}, in {}", ShownTime(*time), out.display())]
    EndedEarly { reason: String, out: PathBuf, increments: usize, time: f64 },
}

/// Why a run that was stopped has not reached the end of time.
const STOPPED: &str = "it was stopped";

/// Solves a deck and writes everything. The summary of a run that was stopped says so.
///
/// # Errors
/// [`SolveError`]; after [`SolveError::EndedEarly`] summary and report are there as after success, unless it was the disk that
/// kept them from being written.
pub fn solve(
    deck_path: &Path,
    options: &SolveOptions,
    watcher: &mut dyn Watcher,
) -> Result<Summary, SolveError> {
    let text = std::fs::read_to_string(deck_path)
        .map_err(|cause| DeckError::Read { path: deck_path.into(), cause })?;
    solve_text(text, deck_path, options, watcher)
}

/// Solves the text of a deck; `deck_path` is for messages, and meshes are sought beside it.
///
/// # Errors
/// Those of [`solve`].
pub fn solve_text(
    text: String,
    deck_path: &Path,
    options: &SolveOptions,
    watcher: &mut dyn Watcher,
) -> Result<Summary, SolveError> {
    let deck = Deck::parse_named(&text, deck_path)?;
    let base = deck_path.parent().unwrap_or(Path::new(""));
    let model = deck.model(base)?;
    watcher.model(&model.warnings);
    let mut statics = statics(&deck, &model, options.threads)?;
    let recorded = RecorderOptions::new(&options.out, text).with_output(deck.output);
    if options.out.is_file() {
        return Err(OutputError::NoDirectory { path: options.out.clone() }.into());
    }
    if !options.restart {
        std::fs::create_dir_all(&options.out).map_err(OutputError::write(&options.out))?;
    }
    let _claim = Claim::of(&options.out)?;
    let (mut recorder, state) = if options.restart && !Recorder::is_begun(&recorded) {
        let saved = Recorder::last_state(&recorded, &model, statics.problem())?;
        let state = saved.state.clone();
        statics.check_state(&state)?;
        if let Some(summary) = finished(&state, &deck, &options.out)? {
            return Ok(summary);
        }
        (Recorder::reopen(recorded, &model, saved, watcher)?, state)
    } else {
        let start = statics.problem().start();
        statics.look_at_contacts(&start)?;
        (Recorder::create(recorded, &model, statics.problem(), options.overwrite, watcher)?, start)
    };
    let outcome = statics.run(state, &mut recorder);
    let reason = match &outcome {
        Ok(state) if state.time < deck.time.end => STOPPED.to_owned(),
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    };
    let mut summary = Summary::new(&deck, &model);
    summary.take(statics.effort());
    summary.converged = reason.is_empty();
    summary.reason.clone_from(&reason);
    let surfaces = master_surfaces(&deck, &model, recorder.state());
    let written = recorder.finish(summary, &surfaces, statics.problem()).and_then(|summary| {
        write_report(&[&options.out], &options.out.join(names::REPORT))?;
        Ok(summary)
    });
    let reason = match (reason, written) {
        (reason, Ok(summary)) if reason.is_empty() || reason == STOPPED => return Ok(summary),
        (reason, Err(error)) if reason.is_empty() || reason == STOPPED => error.to_string(),
        (reason, Err(error)) if error.to_string() != reason => format!("{reason}; and then {error}"),
        (reason, _) => reason,
    };
    let &State { increments, time, .. } = recorder.state();
    Err(SolveError::EndedEarly { reason, out: options.out.clone(), increments, time })
}

/// How the run ended whose last state is at the end of time; `None` if there is something left to do or to write.
fn finished(state: &State, deck: &Deck, out: &Path) -> Result<Option<Summary>, OutputError> {
    let path = out.join(names::SUMMARY);
    if state.time < deck.time.end || !path.exists() || !out.join(names::REPORT).exists() {
        return Ok(None);
    }
    let summary: Summary = read_json(&path)?;
    Ok(summary.converged.then_some(summary))
}

/// Writes the page for directories of results.
pub fn write_report(directories: &[&Path], target: &Path) -> Result<(), OutputError> {
    let page = report::report(directories)?;
    diffuse_contact_mesh::file::replace(target, |writer| std::io::Write::write_all(writer, page.as_bytes()))
        .map_err(OutputError::write(target))
}

/// A deck's problem and how it is led through time: increments end at the points of all amplitudes. `threads`: those of the linear
/// solver.
///
/// # Errors
/// [`SolveError::Solid`], [`SolveError::Deck`], [`SolveError::Statics`].
pub fn statics(deck: &Deck, model: &Model, threads: usize) -> Result<Statics, SolveError> {
    let problem = problem(deck, model, threads)?;
    Ok(Statics::new(problem, settings(deck))?.stopping_at(deck.amplitude_times()))
}

/// What a deck's problem is made of.
///
/// # Errors
/// [`SolveError::Solid`], [`SolveError::Deck`].
pub fn problem(deck: &Deck, model: &Model, threads: usize) -> Result<Problem, SolveError> {
    let solid = Solid::new(&model.nodes, &model.bodies)?;
    let supports = deck.supports(model)?;
    Ok(Problem::new(
        model.nodes.clone(),
        solid,
        supports,
        deck.loads(model)?,
        ContactSet::new(deck.interactions(model)?),
        threads,
    ))
}

/// How a deck's problem is solved.
pub fn settings(deck: &Deck) -> Settings {
    Settings::new(deck.time, deck.newton)
}

/// The smooth surfaces of all masters; in two passes both sides are masters.
fn master_surfaces(deck: &Deck, model: &Model, state: &State) -> Vec<report::SurfaceSample> {
    let mut masters = Vec::new();
    for interface in deck.interfaces.iter().filter(|_| deck.contact != Contact::None) {
        let Ok(Sides { master, slave }) = deck.sides(model, interface) else { continue };
        let (name, symmetry) = (&interface.name, &interface.symmetry[..]);
        let of =
            |name, facets| Master { name, facets, options: interface.options(Contact::Diffuse), symmetry };
        masters.push(of(name.clone(), master));
        if interface.two_pass {
            masters.push(of(format!("{name}, the other side"), slave));
        }
    }
    sample_surfaces(&masters, &model.nodes, &state.positions)
}
