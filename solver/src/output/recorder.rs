//! Writes every increment as it converges.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use diffuse_contact_mesh::{ElementKind, VtuFile, file};
use serde::Serialize;

use super::{Fields, OutputError, Skin, Summary, history, names};
use crate::model::Model;
use crate::report::{SURFACES, SurfaceSample};
use crate::statics::{Control, Failure, IncrementRecord, IterationRecord, Observer, Problem, State};

/// What is written.
#[derive(Clone, Debug, PartialEq)]
pub struct RecorderOptions {
    /// Pictures and skins of every so many increments, ≥ 1; the last increment has them in any case.
    pub every: usize,
    /// End of pseudo-time.
    pub end: f64,
}

/// Someone who watches a run and may stop it.
pub trait Watcher: Send {
    /// A residual.
    fn iteration(&mut self, record: &IterationRecord);
    /// A failed increment.
    fn cut_back(&mut self, end: f64, length: f64, reason: &Failure);
    /// A converged increment, which is on disk.
    fn increment(&mut self, record: &IncrementRecord) -> Control;
}

/// Writes results to a directory.
pub struct Recorder<'a> {
    directory: PathBuf,
    options: RecorderOptions,
    model: &'a Model,
    skin: Skin,
    areas: Vec<f64>,
    /// Number and time of each increment with a picture.
    series: Vec<(usize, f64)>,
    begin: Instant,
    /// Seconds of earlier runs.
    earlier_s: f64,
    max_penetration_ever: f64,
    last: Option<(IncrementRecord, State)>,
    watcher: &'a mut dyn Watcher,
}

impl<'a> Recorder<'a> {
    /// Makes the directory, which must not hold results unless `overwrite`, and writes the start.
    ///
    /// # Errors
    /// [`OutputError::Occupied`], [`OutputError::Write`].
    #[allow(clippy::too_many_arguments)]
    pub fn create(
        directory: &Path,
        deck: &str,
        options: RecorderOptions,
        model: &'a Model,
        areas: Vec<f64>,
        problem: &Problem,
        overwrite: bool,
        watcher: &'a mut dyn Watcher,
    ) -> Result<Self, OutputError> {
        if directory.join(names::HISTORY).exists() {
            if !overwrite {
                return Err(OutputError::Occupied { path: directory.to_path_buf() });
            }
            clear(directory)?;
        }
        for folder in [directory.to_path_buf(), directory.join(names::PICTURES), directory.join(names::SKINS)]
        {
            fs::create_dir_all(&folder).map_err(OutputError::write(&folder))?;
        }
        let mut recorder = Self {
            directory: directory.to_path_buf(),
            options,
            model,
            skin: Skin::of(model),
            areas,
            series: Vec::new(),
            begin: Instant::now(),
            earlier_s: 0.0,
            max_penetration_ever: 0.0,
            last: None,
            watcher,
        };
        recorder.write(names::DECK, |writer| writer.write_all(deck.as_bytes()))?;
        recorder.write(names::HISTORY, |writer| writeln!(writer, "{}", history::header(problem)))?;
        recorder.write(names::ITERATIONS, |writer| writeln!(writer, "{}", history::ITERATION_COLUMNS))?;
        recorder.write(&format!("{}/skin.json", names::SKINS), |writer| json(writer, &recorder.skin))?;
        recorder.picture(0, problem, &problem.start())?;
        Ok(recorder)
    }

    /// Goes on in a directory of results of the same deck, from the state that it returns.
    ///
    /// # Errors
    /// [`OutputError::NothingToRestart`], [`OutputError::OtherDeck`], [`OutputError::Read`], [`OutputError::Content`],
    /// [`OutputError::Write`].
    pub fn reopen(
        directory: &Path,
        deck: &str,
        options: RecorderOptions,
        model: &'a Model,
        areas: Vec<f64>,
        watcher: &'a mut dyn Watcher,
    ) -> Result<(Self, State), OutputError> {
        let path = directory.join(names::STATE);
        if !path.exists() {
            return Err(OutputError::NothingToRestart { path: directory.to_path_buf() });
        }
        let written = directory.join(names::DECK);
        let before = fs::read_to_string(&written).map_err(OutputError::read(&written))?;
        if before != deck {
            let same = before.lines().zip(deck.lines()).take_while(|(one, other)| one == other).count();
            return Err(OutputError::OtherDeck { path: directory.to_path_buf(), line: same + 1 });
        }
        let text = fs::read_to_string(&path).map_err(OutputError::read(&path))?;
        let state: State = serde_json::from_str(&text).map_err(|error| OutputError::Content {
            path: path.clone(),
            line: error.line(),
            problem: error.to_string(),
        })?;
        // What was written after this state is taken back.
        for table in [names::HISTORY, names::ITERATIONS] {
            let table = directory.join(table);
            let kept = history::up_to(&table, state.increments)?;
            file::replace(&table, |writer| writer.write_all(kept.as_bytes()))
                .map_err(OutputError::write(&table))?;
        }
        let (columns, rows) = super::read_history(&directory.join(names::HISTORY))?;
        let column = |name: &str| columns.iter().position(|column| column == name);
        let of = |row: &super::HistoryRow, name| column(name).map_or(0.0, |k| row.values[k]);
        let has_picture = |number: usize| picture_path(directory, number).exists();
        let series = std::iter::once((0, 0.0))
            .chain(rows.iter().map(|row| (row.increment, of(row, "time"))))
            .filter(|&(number, _)| has_picture(number))
            .collect();
        let recorder = Self {
            directory: directory.to_path_buf(),
            options,
            model,
            skin: Skin::of(model),
            areas,
            series,
            begin: Instant::now(),
            earlier_s: rows.last().map_or(0.0, |row| of(row, "wall_s")),
            max_penetration_ever: rows.iter().map(|row| of(row, "max_penetration")).fold(0.0, f64::max),
            last: None,
            watcher,
        };
        Ok((recorder, state))
    }

    /// Seconds of this run and those before it.
    #[must_use]
    pub fn wall_s(&self) -> f64 {
        self.earlier_s + self.begin.elapsed().as_secs_f64()
    }

    /// The last state that is on disk, if it was reached in this run.
    #[must_use]
    pub fn last_state(&self) -> Option<&State> {
        self.last.as_ref().map(|(_, state)| state)
    }

    /// Writes the sampled master surfaces for the report.
    ///
    /// # Errors
    /// [`OutputError::Write`].
    pub fn write_surfaces(&self, surfaces: &[SurfaceSample]) -> Result<(), OutputError> {
        self.write(&format!("{}/{SURFACES}", names::SKINS), |writer| json(writer, &surfaces))
    }

    /// Writes how the run ended.
    ///
    /// # Errors
    /// [`OutputError::Write`].
    pub fn finish(&self, mut summary: Summary) -> Result<Summary, OutputError> {
        summary.wall_s = self.wall_s();
        summary.max_penetration_ever = self.max_penetration_ever;
        if let Some((last, _)) = &self.last {
            summary.max_penetration = last.max_penetration;
            for force in &last.contact_forces {
                for axis in 0..3 {
                    summary.contact_force[axis] += force[axis];
                }
            }
            let run = self.begin.elapsed().as_secs_f64();
            let share = |time: std::time::Duration| time.as_secs_f64() / run;
            summary.contact_share = share(last.timing.contact);
            summary.pairing_share = share(last.timing.pairing);
            summary.linear_share = share(last.timing.linear);
        }
        self.write(names::SUMMARY, |writer| {
            serde_json::to_writer_pretty(&mut *writer, &summary)?;
            writeln!(writer)
        })?;
        Ok(summary)
    }

    /// Writes a whole file.
    fn write(
        &self,
        name: &str,
        fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
    ) -> Result<(), OutputError> {
        let path = self.directory.join(name);
        file::replace(&path, |writer| fill(writer)).map_err(OutputError::write(&path))
    }

    /// Appends to a table.
    fn append(&self, name: &str, lines: &str) -> Result<(), OutputError> {
        let path = self.directory.join(name);
        let append = || {
            let mut table = OpenOptions::new().append(true).open(&path)?;
            table.write_all(lines.as_bytes())?;
            table.sync_data()
        };
        append().map_err(OutputError::write(&path))
    }

    /// A picture and a skin.
    fn picture(&mut self, number: usize, problem: &Problem, state: &State) -> Result<(), OutputError> {
        let path = picture_path(&self.directory, number);
        let unsound =
            |error: String| OutputError::Write { path: path.clone(), source: std::io::Error::other(error) };
        let fields = Fields::of(problem, state, &self.areas).map_err(|error| unsound(error.to_string()))?;
        let mut parts = Vec::new();
        let mut picture = VtuFile::new().points(problem.start_positions());
        for (k, body) in self.model.bodies.iter().enumerate() {
            for element in &body.elements {
                picture = picture.cell(ElementKind::Hexahedron8, element);
                parts.push(k as i32);
            }
        }
        for facet in self.model.rigid_facets() {
            let kind = match facet.corners().len() {
                3 => ElementKind::Triangle3,
                _ => ElementKind::Quadrilateral4,
            };
            picture = picture.cell(kind, facet.corners());
            parts.push(self.model.bodies.len() as i32);
        }
        picture
            .point_vectors("displacement", &fields.displacement[..])
            .point_tensors("stress", &fields.stress[..])
            .point_scalars("von_mises", &fields.von_mises[..])
            .point_scalars("plastic_strain", &fields.plastic_strain[..])
            .point_scalars("contact_gap", &fields.contact_gap[..])
            .point_scalars("contact_pressure", &fields.contact_pressure[..])
            .point_i32("contact_status", &fields.contact_status[..])
            .cell_i32("part", &parts[..])
            .write(&path)
            .map_err(|error| unsound(error.to_string()))?;
        let frame = self.skin.frame(number, state.time, &state.positions, &fields);
        self.write(&format!("{}/{number:05}.json", names::SKINS), |writer| json(writer, &frame))?;
        self.series.retain(|&(known, _)| known < number);
        self.series.push((number, state.time));
        let series = self.series.clone();
        self.write(names::SERIES, |writer| {
            writeln!(writer, "<?xml version=\"1.0\"?>")?;
            writeln!(writer, "<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">")?;
            writeln!(writer, "  <Collection>")?;
            for (number, time) in series {
                let file = format!("{}/{number:05}.vtu", names::PICTURES);
                writeln!(writer, "    <DataSet timestep=\"{time:?}\" part=\"0\" file=\"{file}\"/>")?;
            }
            writeln!(writer, "  </Collection>\n</VTKFile>")
        })
    }

    fn save(
        &mut self,
        record: &IncrementRecord,
        state: &State,
        problem: &Problem,
    ) -> Result<(), OutputError> {
        let last = state.time >= self.options.end;
        if record.number.is_multiple_of(self.options.every) || last {
            self.picture(record.number, problem, state)?;
        }
        self.append(names::HISTORY, &format!("{}\n", history::row(record, problem, self.wall_s())))?;
        self.append(names::ITERATIONS, &history::iteration_rows(record.number, &record.history))?;
        self.write(names::STATE, |writer| json(writer, state))
    }
}

impl Observer for Recorder<'_> {
    fn iteration(&mut self, record: &IterationRecord) {
        self.watcher.iteration(record);
    }

    fn cut_back(&mut self, end: f64, length: f64, reason: &Failure) {
        self.watcher.cut_back(end, length, reason);
    }

    fn increment(
        &mut self,
        record: &IncrementRecord,
        state: &State,
        problem: &Problem,
    ) -> Result<Control, Box<dyn std::error::Error + Send + Sync>> {
        self.save(record, state, problem)?;
        self.max_penetration_ever = self.max_penetration_ever.max(record.max_penetration);
        self.last = Some((record.clone(), state.clone()));
        Ok(self.watcher.increment(record))
    }
}

/// Writes a document; what cannot be written as JSON is an error like a full disk.
fn json(writer: &mut dyn Write, document: &impl Serialize) -> std::io::Result<()> {
    Ok(serde_json::to_writer(writer, document)?)
}

fn picture_path(directory: &Path, number: usize) -> PathBuf {
    directory.join(names::PICTURES).join(format!("{number:05}.vtu"))
}

/// Removes the files of earlier results, and nothing else.
fn clear(directory: &Path) -> Result<(), OutputError> {
    let mut files: Vec<PathBuf> =
        [names::STATE, names::SUMMARY, names::HISTORY, names::ITERATIONS, names::SERIES, names::REPORT]
            .map(|name| directory.join(name))
            .to_vec();
    for folder in [names::PICTURES, names::SKINS] {
        let entries = fs::read_dir(directory.join(folder)).into_iter().flatten().flatten();
        let own = |path: &PathBuf| path.extension().is_some_and(|ext| ext == "vtu" || ext == "json");
        files.extend(entries.map(|entry| entry.path()).filter(own));
    }
    for path in files.into_iter().filter(|path| path.exists()) {
        fs::remove_file(&path).map_err(OutputError::write(&path))?;
    }
    Ok(())
}
