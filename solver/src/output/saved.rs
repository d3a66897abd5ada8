//! The state that a restart goes on from: written with each increment, and checked before it is used.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use diffuse_contact_kernels::support::Isa;
use serde::{Deserialize, Serialize};

use super::directory::Directory;
use super::{OutputError, Recorder, RecorderOptions, Skin, SlaveFields, history, names, seal};
use crate::contact::{Beginning, Fallbacks, Penetration};
use crate::model::Model;
use crate::report;
use crate::statics::{Problem, State};

/// `state.json`: what a restart goes on from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Saved {
    /// Of all the rest, which is written without it and then sealed; `None` in what an earlier version wrote.
    #[serde(default, skip_serializing)]
    checksum: Option<String>,
    /// Digest of the deck's text; `None` in what an earlier version wrote.
    #[serde(default)]
    pub(super) deck: Option<String>,
    /// [`Model::fingerprint`] of the model.
    model: String,
    /// Name of the vector instructions it was made with; empty in what an earlier version wrote.
    #[serde(default)]
    pub(super) instructions: String,
    /// The last state.
    pub state: State,
    /// What the picture of the last increment needs besides, if it was not its turn.
    pub(super) pending: Option<SlaveFields>,
    /// Names of the interfaces that carried force at the end of some increment.
    #[serde(default)]
    pub(super) carried: BTreeSet<String>,
    /// Interfaces whose force vanished under load, with the time of the first such increment.
    #[serde(default)]
    pub(super) vanished: BTreeMap<String, f64>,
    /// Of each interface the most slaves at the end of an increment whose masters do not carry the fit that was asked for.
    #[serde(default)]
    pub(super) fallbacks: BTreeMap<String, Fallbacks>,
    /// Of each interface the most slaves deep below their masters at the end of an increment, and how deep.
    #[serde(default)]
    pub(super) penetrations: BTreeMap<String, Penetration>,
    /// How the interfaces lay at the start.
    pub(super) beginnings: Vec<Beginning>,
}

impl Saved {
    /// Before the first increment of a deck with this text.
    pub(super) fn new(deck: &str, model: &Model, state: State) -> Self {
        Self {
            checksum: None,
            deck: Some(seal::digest(deck)),
            model: model.fingerprint(),
            instructions: instructions().to_owned(),
            state,
            pending: None,
            carried: BTreeSet::new(),
            vanished: BTreeMap::new(),
            fallbacks: BTreeMap::new(),
            penetrations: BTreeMap::new(),
            beginnings: Vec::new(),
        }
    }
}

impl Recorder<'_> {
    /// The last state in a directory of results of the same deck and the same model. Nothing is changed.
    ///
    /// # Errors
    /// [`OutputError::NothingToRestart`], [`OutputError::OtherDeck`], [`OutputError::ChangedDeck`], [`OutputError::OtherModel`],
    /// [`OutputError::Read`], [`OutputError::Content`], [`OutputError::Inconsistent`].
    pub fn last_state(
        options: &RecorderOptions,
        model: &Model,
        problem: &Problem,
    ) -> Result<Saved, OutputError> {
        let directory = Directory::new(&options.directory);
        let path = directory.path(names::STATE);
        if !path.exists() {
            return Err(OutputError::NothingToRestart { path: options.directory.clone() });
        }
        check_deck(&directory.path(names::DECK), options)?;
        let text = fs::read_to_string(&path).map_err(OutputError::read(&path))?;
        let saved: Saved = super::parse_json(&path, &text)?;
        if saved.checksum.is_some()
            && let Some([found, expected]) = seal::broken(&text)
        {
            let problem =
                format!("it is not what was written: its checksum is {found}, that of its text {expected}");
            return Err(OutputError::Inconsistent { path, problem });
        }
        // Where the results are beside the deck, that is its own copy.
        if saved.deck.as_ref().is_some_and(|digest| *digest != seal::digest(&options.deck)) {
            return Err(OutputError::ChangedDeck { path: options.directory.clone() });
        }
        if saved.model != model.fingerprint() {
            return Err(OutputError::OtherModel { path: options.directory.clone() });
        }
        if saved.pending.as_ref().is_some_and(|slaves| !slaves.fits(model.nodes.len())) {
            let problem = "contact at nodes that there are not".to_owned();
            return Err(OutputError::Inconsistent { path, problem });
        }
        check_tables(&directory, &saved.state, problem)?;
        report::check_skins(
            &directory.path(names::SKINS),
            &Skin::of(model, options.shown()),
            saved.state.increments,
        )?;
        Ok(saved)
    }

    pub(super) fn write_state(&self) -> Result<(), OutputError> {
        self.directory.write(names::STATE, |writer| {
            writer.write_all(seal::sealed(&serde_json::to_string(&self.saved)?).as_bytes())
        })
    }
}

/// The vector instructions that contacts are evaluated with.
pub(super) fn instructions() -> &'static str {
    Isa::best().name()
}

/// The lines of both tables up to a state are those of its increments: everything that a report asks of them is asked now, and not
/// after the other increments.
fn check_tables(directory: &Directory, state: &State, problem: &Problem) -> Result<(), OutputError> {
    let inconsistent =
        |table: &str, problem: String| OutputError::Inconsistent { path: directory.path(table), problem };
    let read = |table: &str, header: &str| {
        let path = directory.path(table);
        let text = history::up_to(&path, state.increments)?;
        if text.lines().next() != Some(header) {
            return Err(inconsistent(table, "its columns are not those of the deck".to_owned()));
        }
        history::parse(&path, &text)
    };
    let increments = read(names::HISTORY, &history::header(problem))?;
    let numbers = increments.rows.iter().map(|row| row.increment);
    if !numbers.eq(1..=state.increments) {
        let (rows, expected) = (increments.rows.len(), state.increments);
        let problem =
            format!("its {rows} lines are not those of the {expected} increments of {}", names::STATE);
        return Err(inconsistent(names::HISTORY, problem));
    }
    let time = increments.rows.last().map_or(0.0, |row| increments.value(row, "time"));
    if time != state.time {
        let problem =
            format!("its last increment ends at time {time:?}, the state is of time {:?}", state.time);
        return Err(inconsistent(names::HISTORY, problem));
    }
    let iterations = read(names::ITERATIONS, history::ITERATION_COLUMNS)?;
    let numbers: BTreeSet<usize> = iterations.rows.iter().map(|row| row.increment).collect();
    if !numbers.into_iter().eq(1..=state.increments) || !iterations.rows.is_sorted_by_key(|row| row.increment)
    {
        let problem =
            format!("its lines are not those of the {} increments of {}", state.increments, names::STATE);
        return Err(inconsistent(names::ITERATIONS, problem));
    }
    Ok(())
}

/// Results can only be gone on from with the deck that they are from.
fn check_deck(path: &Path, options: &RecorderOptions) -> Result<(), OutputError> {
    let before = fs::read_to_string(path).map_err(OutputError::read(path))?;
    if before == options.deck {
        return Ok(());
    }
    let same = before.lines().zip(options.deck.lines()).take_while(|(one, other)| one == other).count();
    Err(OutputError::OtherDeck { path: options.directory.clone(), line: same + 1 })
}
