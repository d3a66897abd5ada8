//! Tables of increments and iterations.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use diffuse_contact_mesh::names::shown;

use diffuse_contact::interface::FrictionReport;

use super::{ContactSummary, FrictionSummary, OutputError};
use crate::contact::Interaction;
use crate::distinct::distinct;
use crate::statics::{IncrementRecord, IterationRecord, Problem};

/// Columns of `history.csv` before those of interactions and supports.
const COLUMNS: &str = "increment,time,length,iterations,augmentations,short,rounded,active,lost,missed,unanchored,supposed,softened,unstable,stabilised,linear_iterations,direct_instead,max_penetration,strain_energy,wall_s";
/// Columns of `iterations.csv`.
pub(super) const ITERATION_COLUMNS: &str =
    "increment,iteration,time,residual,relative,excess,allowed,active,step";

/// A table that was read: `history.csv` or `iterations.csv`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct History {
    /// Names of the columns.
    pub columns: Vec<String>,
    /// The lines.
    pub rows: Vec<HistoryRow>,
}

impl History {
    /// A row's value in a column; 0 if there is none of this name.
    pub fn value(&self, row: &HistoryRow, column: &str) -> f64 {
        self.columns.iter().position(|name| name == column).map_or(0.0, |k| row.values[k])
    }

    /// Sum of the contact forces of all interfaces.
    pub fn contact_force(&self, row: &HistoryRow) -> [f64; 3] {
        ["x", "y", "z"].map(|axis| {
            let prefix = format!("contact_force_{axis}:");
            let values = self.columns.iter().zip(&row.values);
            values.filter(|(name, _)| name.starts_with(&prefix)).map(|(_, value)| value).sum()
        })
    }
}

/// A line of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct HistoryRow {
    /// Number of the increment, from 1.
    pub increment: usize,
    /// All columns in their order, among them the increment.
    pub values: Vec<f64>,
}

/// The names of interfaces, or of supports, in those of columns.
fn column_names<'a>(names: impl Iterator<Item = &'a String>) -> Vec<String> {
    let is_left_out = |letter: char| letter == ',' || letter == '"' || letter.is_control();
    distinct(names.map(|name| name.replace(is_left_out, "_")))
}

/// Those of the interfaces.
fn interface_columns(problem: &Problem) -> Vec<String> {
    column_names(problem.contacts().interactions().iter().map(|interaction| &interaction.options().name))
}

/// The line of column names.
pub(super) fn header(problem: &Problem) -> String {
    let mut line = COLUMNS.to_owned();
    let interfaces = interface_columns(problem);
    for (_, name) in with_friction(problem, &interfaces) {
        let _ = write!(
            line,
            ",stuck:{name},sliding:{name},unanchored:{name},friction_force:{name},dissipated:{name},friction_short:{name}"
        );
    }
    for name in &interfaces {
        let _ = write!(line, ",contact_area:{name},contact_normal_force:{name},penalty_energy:{name}");
    }
    let mut vector = |what: &str, name: &str| {
        for axis in ["x", "y", "z"] {
            let _ = write!(line, ",{what}_{axis}:{name}");
        }
    };
    for name in &interfaces {
        ["contact_force", "contact_moment", "contact_centre"].iter().for_each(|what| vector(what, name));
    }
    for name in column_names(problem.supports().groups().iter().map(|group| &group.name)) {
        ["displacement", "reaction"].iter().for_each(|what| vector(what, &name));
    }
    line
}

/// The line of an increment.
pub(super) fn row(record: &IncrementRecord, problem: &Problem, wall_s: f64) -> String {
    let mut line = format!(
        "{},{:?},{:?},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{:?},{:?},{:?}",
        record.number,
        record.time,
        record.length,
        record.iterations,
        record.augmentations,
        u8::from(record.is_short),
        u8::from(record.is_rounded()),
        record.active,
        record.lost,
        record.missed,
        record.unanchored(),
        record.supposed,
        u8::from(record.softened),
        u8::from(record.is_unstable()),
        record.stabilised,
        record.linear.iterations,
        record.linear.direct_instead,
        record.max_penetration,
        record.strain_energy,
        wall_s
    );
    let interactions = problem.contacts().interactions().iter();
    for ((interaction, contact), friction) in interactions.zip(&record.contacts).zip(&record.friction) {
        let Some(FrictionReport { stuck, sliding, unanchored, limit, short, .. }) = friction else {
            continue;
        };
        let (force, dissipated) = (contact.friction, interaction.dissipated());
        let short = if *limit > 0.0 { short / limit } else { 0.0 };
        let _ = write!(line, ",{stuck},{sliding},{unanchored},{force:?},{dissipated:?},{short:?}");
    }
    for contact in &record.contacts {
        let _ = write!(line, ",{:?},{:?},{:?}", contact.area, contact.normal, contact.penalty_energy);
    }
    let mut vector = |values: [f64; 3]| {
        for value in values {
            let _ = write!(line, ",{value:?}");
        }
    };
    for contact in &record.contacts {
        [contact.force, contact.moment, contact.centre].into_iter().for_each(&mut vector);
    }
    for (group, &reaction) in problem.supports().groups().iter().zip(&record.reactions) {
        vector(group.displacement(record.time, problem.start_positions()));
        vector(reaction);
    }
    line
}

/// The interactions that have columns of friction, with their names there: numbers of slaves that stick, slide and have no anchor
/// yet, and the work of friction so far.
fn with_friction<'a>(
    problem: &'a Problem,
    columns: &'a [String],
) -> impl Iterator<Item = (&'a Interaction, &'a String)> {
    let all = problem.contacts().interactions().iter().zip(columns);
    all.filter(|(interaction, _)| interaction.options().friction.is_some())
}

/// Forces of less than so many times what is allowed are rounding themselves.
const UNLOADED: f64 = 50.0;

/// Increments that ended with a residual above what the tolerances allow in any of them, which rounding of the positions explains. Those
/// without a load do not count.
pub(super) fn rounded(history: &History, iterations: &History) -> usize {
    let of = |row: &HistoryRow, column: &str| iterations.value(row, column);
    let allowed = iterations.rows.iter().map(|row| of(row, "allowed")).fold(0.0, f64::max);
    // The last line of an increment is the one that counts.
    let ends: BTreeMap<usize, &HistoryRow> = iterations.rows.iter().map(|row| (row.increment, row)).collect();
    let is_rounded = |row: &&HistoryRow| history.value(row, "rounded") > 0.0;
    let above = |row: &&HistoryRow| {
        ends.get(&row.increment).is_some_and(|end| {
            let (residual, relative) = (of(end, "residual"), of(end, "relative"));
            residual > allowed && residual > relative * UNLOADED * of(end, "allowed")
        })
    };
    history.rows.iter().filter(is_rounded).filter(above).count()
}

/// Contact at the end of the last line, and how soft penalties were where the energy was largest.
pub(super) fn contacts(history: &History, problem: &Problem) -> BTreeMap<String, ContactSummary> {
    let columns = interface_columns(problem);
    let last = |column: &str| history.rows.last().map_or(0.0, |row| history.value(row, column));
    let energy = |row: &HistoryRow, column: &String| history.value(row, &format!("penalty_energy:{column}"));
    let strain = |row: &HistoryRow| history.value(row, "strain_energy");
    let whole =
        |row: &HistoryRow| strain(row) + columns.iter().map(|column| energy(row, column)).sum::<f64>();
    let loaded = history.rows.iter().filter(|row| strain(row) > 0.0);
    let most = loaded.max_by(|one, other| whole(one).total_cmp(&whole(other)));
    let of = |(interaction, column): (&Interaction, &String)| {
        let summary = ContactSummary {
            force: ["x", "y", "z"].map(|axis| last(&format!("contact_force_{axis}:{column}"))),
            normal_force: last(&format!("contact_normal_force:{column}")),
            area: last(&format!("contact_area:{column}")),
            penalty_share: most.map_or(0.0, |row| energy(row, column) / whole(row)),
        };
        (interaction.options().name.clone(), summary)
    };
    problem.contacts().interactions().iter().zip(&columns).map(of).collect()
}

/// Friction at the end of the last line, of each interaction that has any.
pub(super) fn last_friction(history: &History, problem: &Problem) -> BTreeMap<String, FrictionSummary> {
    let columns = interface_columns(problem);
    let of = |(interaction, column): (&Interaction, &String)| {
        let name = interaction.options().name.clone();
        let value = |what: &str| {
            history.rows.last().map_or(0.0, |row| history.value(row, &format!("{what}:{column}")))
        };
        let area = value("contact_area");
        let summary = FrictionSummary {
            stuck: value("stuck") as usize,
            sliding: value("sliding") as usize,
            traction: if area > 0.0 { value("friction_force") / area } else { 0.0 },
            dissipated: value("dissipated"),
            short: history
                .rows
                .iter()
                .map(|row| history.value(row, &format!("friction_short:{column}")))
                .fold(0.0, f64::max),
        };
        (name, summary)
    };
    with_friction(problem, &columns).map(of).collect()
}

/// The lines of an increment's iterations.
pub(super) fn iteration_rows(number: usize, history: &[IterationRecord]) -> String {
    let mut lines = String::new();
    for record in history {
        let IterationRecord { time, iteration, residual, relative, excess, allowed, active, step } = record;
        let _ = writeln!(
            lines,
            "{number},{iteration},{time:?},{residual:?},{relative:?},{excess:?},{allowed:?},{active},{step:?}"
        );
    }
    lines
}

/// Reads `history.csv` or `iterations.csv`. A last line without an end was being written when the run was interrupted, and is
/// left out.
///
/// # Errors
/// [`OutputError::Read`], [`OutputError::Content`].
pub fn read_history(path: &Path) -> Result<History, OutputError> {
    let text = fs::read_to_string(path).map_err(OutputError::read(path))?;
    parse(path, whole_lines(&text))
}

/// Whether a column may hold it: a residual without any force is infinite relative to them.
fn is_possible(value: f64, column: &str) -> bool {
    value.is_finite() || value == f64::INFINITY && column == "relative"
}

/// Reads the text of one, whole lines.
pub(super) fn parse(path: &Path, text: &str) -> Result<History, OutputError> {
    let content =
        |line: usize, problem: String| OutputError::Content { path: path.to_path_buf(), line, problem };
    let mut lines = text.lines().enumerate();
    let Some((_, header)) = lines.next() else { return Err(content(1, "there are no columns".to_owned())) };
    let columns: Vec<String> = header.split(',').map(str::to_owned).collect();
    let mut rows = Vec::new();
    for (number, line) in lines {
        let number = number + 1;
        let values = line
            .split(',')
            .zip(columns.iter().map(Some).chain(std::iter::repeat(None)))
            .map(|(word, column)| {
                let value = word.parse().ok();
                value
                    .filter(|&value| is_possible(value, column.map_or("", String::as_str)))
                    .ok_or_else(|| content(number, format!("`{}` is no finite number", shown(word))))
            })
            .collect::<Result<Vec<f64>, _>>()?;
        if values.len() != columns.len() {
            let problem = format!("{} columns instead of {}", values.len(), columns.len());
            return Err(content(number, problem));
        }
        rows.push(HistoryRow { increment: values[0] as usize, values });
    }
    Ok(History { columns, rows })
}

fn whole_lines(text: &str) -> &str {
    text.rfind('\n').map_or("", |end| &text[..=end])
}

/// The lines of a table up to an increment, its header first.
pub(super) fn up_to(path: &Path, increments: usize) -> Result<String, OutputError> {
    let text = fs::read_to_string(path).map_err(OutputError::read(path))?;
    let keep = |line: &&str| {
        line.split(',').next().is_some_and(|word| word.parse().is_ok_and(|k: usize| k <= increments))
    };
    let mut lines = whole_lines(&text).lines();
    let mut kept = lines.next().unwrap_or_default().to_owned();
    kept.push('\n');
    for line in lines.filter(keep) {
        kept.push_str(line);
        kept.push('\n');
    }
    Ok(kept)
}
