//! Writes every increment as it converges.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use super::directory::Directory;
use super::failed::FailedTry;
use super::saved::{Saved, instructions};
use super::{
    Fields, OutputError, Skin, SkinFrame, SlaveFields, Summary, history, names, picture, points, seal,
};
use crate::contact::{Beginning, Fallbacks};
use crate::deck::{Colour, Output};
use crate::model::Model;
use crate::report::{SURFACES, SurfaceSample};
use crate::statics::{
    Control, FailedIncrement, Failure, IncrementRecord, IterationRecord, Observer, Problem, State, Timing,
};

/// What is written, and where.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RecorderOptions {
    /// Directory of results.
    pub directory: PathBuf,
    /// Text of the deck.
    pub deck: String,
    /// Which increments have pictures and skins, and what these show.
    pub output: Output,
}

impl RecorderOptions {
    /// Into a directory, with the text of the deck; the default output.
    pub fn new(directory: impl Into<PathBuf>, deck: String) -> Self {
        Self { directory: directory.into(), deck, output: Output::default() }
    }

    /// With this output.
    #[must_use]
    pub fn with_output(self, output: Output) -> Self {
        Self { output, ..self }
    }
}

/// The tables that grow with each increment.
const TABLES: [&str; 2] = [names::HISTORY, names::ITERATIONS];

/// Someone who watches a run and may stop it.
pub trait Watcher: Send {
    /// Where nodes that a mesh file joins are not joined in the model, in sentences; told of a run that goes on, too.
    fn model(&mut self, warnings: &[String]) {
        let _ = warnings;
    }
    /// How the slaves of each interface lie at the start; not told again of a run that goes on.
    fn start(&mut self, interfaces: &[Beginning]) {
        let _ = interfaces;
    }
    /// A run goes on: how the slaves of each interface lay at its start, and the most fallbacks since.
    fn resume(&mut self, interfaces: &[Beginning], fallbacks: &BTreeMap<String, Fallbacks>) {
        let _ = (interfaces, fallbacks);
    }
    /// A run goes on that began with other vector instructions: the end differs by rounding from that of a run that was not interrupted.
    fn other_instructions(&mut self, before: &str, now: &str) {
        let _ = (before, now);
    }
    /// Something of the results that is not as it was asked for, in a sentence.
    fn warning(&mut self, warning: &str) {
        let _ = warning;
    }
    /// A residual.
    fn iteration(&mut self, record: &IterationRecord);
    /// A failed increment.
    fn cut_back(&mut self, end: f64, length: f64, reason: &Failure) -> Control;
    /// A converged increment, which is on disk.
    fn increment(&mut self, record: &IncrementRecord) -> Control;
}

/// Writes results to a directory.
pub struct Recorder<'a> {
    pub(super) directory: Directory,
    pub(super) options: RecorderOptions,
    model: &'a Model,
    skin: Skin,
    /// Number and time of each increment with a picture.
    series: Vec<(usize, f64)>,
    /// Those with a picture of the integration points.
    point_series: Vec<(usize, f64)>,
    begin: Instant,
    /// Seconds of earlier runs.
    earlier_s: f64,
    /// The last try, if it failed.
    failed: Option<FailedTry>,
    /// The first picture without stresses, and why; of this run.
    without_stress: Option<String>,
    timing: Timing,
    /// The most memory of an iterative linear solution of this run, bytes.
    linear_bytes: usize,
    /// What is on disk of the last increment, and what a restart needs of those before it.
    pub(super) saved: Saved,
    watcher: &'a mut dyn Watcher,
}

impl<'a> Recorder<'a> {
    /// Makes the directory, which must not hold results unless `overwrite`, and writes the start.
    ///
    /// # Errors
    /// [`OutputError::ForeignDeck`], [`OutputError::Occupied`], [`OutputError::Remains`], [`OutputError::Linked`],
    /// [`OutputError::Write`].
    pub fn create(
        options: RecorderOptions,
        model: &'a Model,
        problem: &Problem,
        overwrite: bool,
        watcher: &'a mut dyn Watcher,
    ) -> Result<Self, OutputError> {
        let directory = Directory::new(&options.directory);
        directory.prepare(&options.deck, overwrite)?;
        let saved = Saved::new(&options.deck, model, problem.start());
        let mut recorder = Self::new(directory, options, model, saved, watcher);
        let Self { directory, options, saved, skin, .. } = &recorder;
        directory.write(names::DECK, |writer| writer.write_all(options.deck.as_bytes()))?;
        directory.write(names::HISTORY, |writer| writeln!(writer, "{}", history::header(problem)))?;
        directory.write(names::ITERATIONS, |writer| writeln!(writer, "{}", history::ITERATION_COLUMNS))?;
        directory.write_json(&format!("{}/{SKIN}", names::SKINS), skin)?;
        let fields = Fields::of(problem, &saved.state);
        recorder.show(fields, problem)?;
        let interactions = problem.contacts().interactions().iter();
        recorder.saved.beginnings = interactions.map(|own| Beginning::of(own, model, problem)).collect();
        recorder.write_state()?;
        recorder.watcher.start(&recorder.saved.beginnings);
        Ok(recorder)
    }

    /// Whether a run of this deck began in the directory and ended before its first state: it begins anew.
    pub fn is_begun(options: &RecorderOptions) -> bool {
        Directory::new(&options.directory).is_begun(&options.deck)
    }

    /// Goes on in a directory of results from its [`last_state`](Self::last_state).
    ///
    /// # Errors
    /// [`OutputError::Read`], [`OutputError::Content`], [`OutputError::Write`].
    pub fn reopen(
        options: RecorderOptions,
        model: &'a Model,
        mut saved: Saved,
        watcher: &'a mut dyn Watcher,
    ) -> Result<Self, OutputError> {
        if !saved.instructions.is_empty() && saved.instructions != instructions() {
            watcher.other_instructions(&saved.instructions, instructions());
        }
        // An earlier version did not write them.
        (saved.deck, saved.instructions) = (Some(seal::digest(&options.deck)), instructions().to_owned());
        let directory = Directory::new(&options.directory);
        directory.clean()?;
        // What was written after this state is taken back.
        for table in TABLES {
            let kept = history::up_to(&directory.path(table), saved.state.increments)?;
            directory.write(table, |writer| writer.write_all(kept.as_bytes()))?;
        }
        directory.rewind(saved.state.increments, options.output.every)?;
        let history = super::read_history(&directory.path(names::HISTORY))?;
        let times = history.rows.iter().map(|row| (row.increment, history.value(row, "time")));
        let times: Vec<(usize, f64)> = std::iter::once((0, 0.0)).chain(times).collect();
        let with_file = |name: fn(usize) -> String| {
            times.iter().copied().filter(|&(number, _)| directory.path(&name(number)).exists()).collect()
        };
        let (series, point_series) = (with_file(picture::name), with_file(points::name));
        let mut recorder = Self::new(directory, options, model, saved, watcher);
        (recorder.series, recorder.point_series) = (series, point_series);
        recorder.watcher.resume(&recorder.saved.beginnings, &recorder.saved.fallbacks);
        picture::write_series(&recorder.directory, &recorder.series)?;
        if recorder.directory.path(names::POINTS).exists() {
            recorder.write_point_series()?;
        }
        recorder.earlier_s = history.rows.last().map_or(0.0, |last| history.value(last, "wall_s"));
        Ok(recorder)
    }

    fn new(
        directory: Directory,
        options: RecorderOptions,
        model: &'a Model,
        saved: Saved,
        watcher: &'a mut dyn Watcher,
    ) -> Self {
        Self {
            directory,
            skin: Skin::of(model, options.shown()),
            options,
            model,
            series: Vec::new(),
            point_series: Vec::new(),
            begin: Instant::now(),
            earlier_s: 0.0,
            failed: None,
            without_stress: None,
            timing: Timing::default(),
            linear_bytes: 0,
            saved,
            watcher,
        }
    }

    /// Seconds of this run and those before it.
    pub fn wall_s(&self) -> f64 {
        self.earlier_s + self.begin.elapsed().as_secs_f64()
    }

    /// The last state that is on disk.
    pub fn state(&self) -> &State {
        &self.saved.state
    }

    /// Writes what is left to write at the end of a run: the last picture, the sampled master surfaces and how it ended. Where the last
    /// increment failed, `problem` has to be as that increment left it.
    ///
    /// # Errors
    /// [`OutputError::Write`]; those of reading the history that was written.
    pub fn finish(
        &mut self,
        mut summary: Summary,
        surfaces: &[SurfaceSample],
        problem: &Problem,
    ) -> Result<Summary, OutputError> {
        if let Some(slaves) = self.saved.pending.take() {
            self.show(slaves.at(problem.start_positions(), &self.saved.state), problem)?;
        }
        self.directory.write_json(&format!("{}/{SURFACES}", names::SKINS), &surfaces)?;
        if let Some(failed) = self.failed.take() {
            let Self { model, skin, options, saved, .. } = self;
            let failed = failed.written(problem, model, skin, options, &saved.state);
            self.directory.write_json(names::FAILED, &failed)?;
        }
        let run = self.begin.elapsed().as_secs_f64();
        let share = |time: Duration| time.as_secs_f64() / run.max(f64::MIN_POSITIVE);
        summary.time = self.saved.state.time;
        summary.increments = self.saved.state.increments;
        summary.wall_s = self.wall_s();
        let history = super::read_history(&self.directory.path(names::HISTORY))?;
        let sum = |column: &str| history.rows.iter().map(|row| history.value(row, column) as usize).sum();
        summary.augmentations_short = sum("short");
        summary.contacts_lost = sum("lost");
        summary.points_missed = sum("missed");
        summary.slaves_unanchored = sum("unanchored");
        summary.solutions_supposed = sum("supposed");
        summary.increments_softened = sum("softened");
        summary.increments_unstable = sum("unstable");
        summary.solutions_stabilised = sum("stabilised");
        summary.linear_iterations = sum("linear_iterations");
        summary.solutions_direct_instead = sum("direct_instead");
        let penetrations = history.rows.iter().map(|row| history.value(row, "max_penetration"));
        summary.max_penetration_ever = penetrations.fold(0.0, f64::max);
        if let Some(last) = history.rows.last() {
            summary.max_penetration = history.value(last, "max_penetration");
            summary.contact_force = history.contact_force(last);
        }
        let is_begun = summary.increments > 0;
        let interfaces =
            problem.contacts().interactions().iter().map(|interaction| &interaction.options().name);
        summary.interfaces_without_force =
            interfaces.filter(|&name| is_begun && !self.saved.carried.contains(name)).cloned().collect();
        summary.interfaces_vanished.clone_from(&self.saved.vanished);
        summary.interfaces.clone_from(&self.saved.beginnings);
        summary.contacts = history::contacts(&history, problem);
        summary.friction = history::last_friction(&history, problem);
        let iterations = super::read_history(&self.directory.path(names::ITERATIONS))?;
        summary.increments_rounded = history::rounded(&history, &iterations);
        summary.fallbacks.clone_from(&self.saved.fallbacks);
        summary.penetrations.clone_from(&self.saved.penetrations);
        let at_start = self.saved.beginnings.iter().flat_map(Beginning::warnings);
        let of_model = self.model.warnings.iter().cloned();
        let of_output = self.without_stress.clone();
        summary.warnings = of_model.chain(at_start).chain(summary.shortcomings()).chain(of_output).collect();
        summary.linear_bytes = self.linear_bytes;
        summary.contact_share = share(self.timing.contact);
        summary.pairing_share = share(self.timing.pairing);
        summary.linear_share = share(self.timing.linear);
        self.directory.write(names::SUMMARY, |writer| {
            serde_json::to_writer_pretty(&mut *writer, &summary)?;
            writeln!(writer)
        })?;
        Ok(summary)
    }

    /// Writes picture and skin of the last state, with its stresses if they are asked for.
    fn show(&mut self, mut fields: Fields, problem: &Problem) -> Result<(), OutputError> {
        let (number, time) = (self.saved.state.increments, self.saved.state.time);
        if self.options.output.stress
            && let Err(error) = fields.recover(problem, &self.saved.state)
        {
            let warning = format!("increment {number} has no stresses: {error}");
            self.watcher.warning(&warning);
            self.without_stress.get_or_insert(warning);
        }
        picture::write(&self.directory, number, self.model, &self.model.nodes, &fields)?;
        let frame: SkinFrame = self.skin.frame(number, time, &self.saved.state.positions, &fields);
        self.directory.write_json(&format!("{}/{number:05}.json", names::SKINS), &frame)?;
        self.series.retain(|&(known, _)| known < number);
        self.series.push((number, time));
        picture::write_series(&self.directory, &self.series)
    }

    /// Pictures and tables first: the increment counts when its state is there.
    fn save(
        &mut self,
        record: &IncrementRecord,
        state: &State,
        problem: &Problem,
    ) -> Result<(), OutputError> {
        let fields = Fields::of(problem, state);
        let is_shown = record.number.is_multiple_of(self.options.output.every);
        let pending = (!is_shown).then(|| SlaveFields::of(&fields));
        let saved = &mut self.saved;
        let before = (
            std::mem::replace(&mut saved.state, state.clone()),
            std::mem::replace(&mut saved.pending, pending),
            saved.carried.clone(),
            saved.vanished.clone(),
            saved.fallbacks.clone(),
            saved.penetrations.clone(),
        );
        saved.carried.extend(carrying(record, problem));
        for (interface, _) in &record.vanished {
            saved.vanished.entry(interface.clone()).or_insert(record.time);
        }
        for (interface, found) in &record.fallbacks {
            let most = saved.fallbacks.entry(interface.clone()).or_default();
            *most = most.max(*found);
        }
        // Of a motion the end counts.
        saved.penetrations.values_mut().for_each(|most| most.part_of_motion = 0.0);
        for (interface, found) in &record.penetrations {
            let most = saved.penetrations.entry(interface.clone()).or_default();
            *most = most.max(*found);
        }
        saved.penetrations.retain(|_, most| !most.is_none());
        let lengths = TABLES.map(|table| self.directory.length(table));
        let written = self.write_increment(record, problem, is_shown.then_some(fields));
        if let Err(error) = written {
            let saved = &mut self.saved;
            (
                saved.state,
                saved.pending,
                saved.carried,
                saved.vanished,
                saved.fallbacks,
                saved.penetrations,
            ) = before;
            for series in [&mut self.series, &mut self.point_series] {
                series.retain(|&(known, _)| known <= self.saved.state.increments);
            }
            // So does what was written of the increment: the files are those of the last state.
            TABLES.iter().zip(lengths).for_each(|(table, length)| self.directory.shorten(table, length));
            let _ = self.directory.rewind(self.saved.state.increments, self.options.output.every);
            let _ = picture::write_series(&self.directory, &self.series);
            if self.directory.path(names::POINTS).exists() {
                let _ = self.write_point_series();
            }
            return Err(error);
        }
        self.timing = record.timing;
        self.linear_bytes = self.linear_bytes.max(record.linear.bytes);
        Ok(())
    }

    /// Writes the integration points of an increment, if there are interfaces over faces.
    fn show_points(&mut self, record: &IncrementRecord, problem: &Problem) -> Result<(), OutputError> {
        if points::write(&self.directory, record.number, problem)? {
            self.point_series.retain(|&(known, _)| known < record.number);
            self.point_series.push((record.number, record.time));
            self.write_point_series()?;
        }
        Ok(())
    }

    fn write_point_series(&self) -> Result<(), OutputError> {
        picture::write_list(&self.directory, names::POINT_SERIES, &self.point_series, points::name)
    }

    fn write_increment(
        &mut self,
        record: &IncrementRecord,
        problem: &Problem,
        shown: Option<Fields>,
    ) -> Result<(), OutputError> {
        if let Some(fields) = shown {
            self.show(fields, problem)?;
            self.show_points(record, problem)?;
        }
        let row = history::row(record, problem, self.wall_s());
        self.directory.append(names::HISTORY, &format!("{row}\n"))?;
        self.directory.append(names::ITERATIONS, &history::iteration_rows(record.number, &record.history))?;
        self.write_state()
    }
}

/// Names of the interfaces with a contact that carries force at the last evaluation.
fn carrying(record: &IncrementRecord, problem: &Problem) -> impl Iterator<Item = String> {
    // Forces below what equilibrium is known to are none: a body that nothing holds has such ones where it touches.
    let known = record.history.last().map_or(0.0, |last| last.residual.max(last.allowed));
    let noise = known * (record.active.max(1) as f64).sqrt();
    let interactions = problem.contacts().interactions().iter().zip(&record.contacts);
    let loaded = interactions.filter(move |(_, exerted)| exerted.normal + exerted.friction > noise);
    loaded.map(|(interaction, _)| interaction.options().name.clone())
}

/// Name of the file of the skin, in the folder of skins.
pub const SKIN: &str = "skin.json";

impl RecorderOptions {
    /// The field that the report shows first: the deck's, unless it is not written.
    pub(super) fn shown(&self) -> &'static str {
        match self.output.colour {
            Colour::VonMises | Colour::PlasticStrain if !self.output.stress => "displacement",
            Colour::Displacement => "displacement",
            Colour::VonMises => "von_mises",
            Colour::PlasticStrain => "plastic_strain",
            Colour::Gap => "contact_gap",
            Colour::Pressure => "contact_pressure",
        }
    }
}

impl Observer for Recorder<'_> {
    fn iteration(&mut self, record: &IterationRecord) {
        self.watcher.iteration(record);
    }

    fn failed(&mut self, failed: &FailedIncrement<'_>) {
        self.failed = Some(FailedTry::of(failed));
    }

    fn cut_back(&mut self, end: f64, length: f64, reason: &Failure) -> Control {
        self.watcher.cut_back(end, length, reason)
    }

    fn increment(
        &mut self,
        record: &IncrementRecord,
        state: &State,
        problem: &Problem,
    ) -> Result<Control, Box<dyn std::error::Error + Send + Sync>> {
        self.failed = None;
        self.save(record, state, problem)?;
        Ok(self.watcher.increment(record))
    }
}
