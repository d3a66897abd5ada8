//! Tables of increments and iterations.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use super::OutputError;
use crate::statics::{IncrementRecord, IterationRecord, Problem};

/// Columns of `history.csv` before those of interactions and supports.
const COLUMNS: &str = "increment,time,length,iterations,augmentations,active,max_penetration,wall_s";
/// Columns of `iterations.csv`.
pub(super) const ITERATION_COLUMNS: &str = "increment,iteration,time,residual,relative,active,step";

/// A line of `history.csv`.
#[derive(Clone, Debug, PartialEq)]
pub struct HistoryRow {
    /// Number of the increment, from 1.
    pub increment: usize,
    /// All columns in their order, among them the increment.
    pub values: Vec<f64>,
}

/// The line of column names.
pub(super) fn header(problem: &Problem) -> String {
    let mut line = COLUMNS.to_owned();
    let mut vector = |what: &str, name: &str| {
        let name = name.replace([',', '"', '\n'], "_");
        for axis in ["x", "y", "z"] {
            let _ = write!(line, ",{what}_{axis}:{name}");
        }
    };
    for interaction in problem.contacts().interactions() {
        vector("contact_force", &interaction.options().name);
    }
    for group in problem.supports().groups() {
        vector("displacement", &group.name);
        vector("reaction", &group.name);
    }
    line
}

/// The line of an increment.
pub(super) fn row(record: &IncrementRecord, problem: &Problem, wall_s: f64) -> String {
    let mut line = format!(
        "{},{:?},{:?},{},{},{},{:?},{:?}",
        record.number,
        record.time,
        record.length,
        record.iterations,
        record.augmentations,
        record.active,
        record.max_penetration,
        wall_s
    );
    let mut vector = |values: [f64; 3]| {
        for value in values {
            let _ = write!(line, ",{value:?}");
        }
    };
    record.contact_forces.iter().for_each(|&force| vector(force));
    for (group, &reaction) in problem.supports().groups().iter().zip(&record.reactions) {
        vector(group.displacement(record.time, problem.start_positions()));
        vector(reaction);
    }
    line
}

/// The lines of an increment's iterations.
pub(super) fn iteration_rows(number: usize, history: &[IterationRecord]) -> String {
    let mut lines = String::new();
    for record in history {
        let IterationRecord { time, iteration, residual, relative, active, step } = record;
        let _ = writeln!(lines, "{number},{iteration},{time:?},{residual:?},{relative:?},{active},{step:?}");
    }
    lines
}

/// Reads `history.csv`: names of the columns, and the rows.
///
/// # Errors
/// [`OutputError::Read`], [`OutputError::Content`].
pub fn read_history(path: &Path) -> Result<(Vec<String>, Vec<HistoryRow>), OutputError> {
    read_table(path)
}

/// Reads `iterations.csv`: names of the columns, and the rows.
///
/// # Errors
/// [`OutputError::Read`], [`OutputError::Content`].
pub fn read_iterations(path: &Path) -> Result<(Vec<String>, Vec<HistoryRow>), OutputError> {
    read_table(path)
}

fn read_table(path: &Path) -> Result<(Vec<String>, Vec<HistoryRow>), OutputError> {
    let text = fs::read_to_string(path).map_err(OutputError::read(path))?;
    let content =
        |line: usize, problem: String| OutputError::Content { path: path.to_path_buf(), line, problem };
    let mut lines = text.lines().enumerate();
    let Some((_, header)) = lines.next() else { return Err(content(1, "there are no columns".to_owned())) };
    let names: Vec<String> = header.split(',').map(str::to_owned).collect();
    let mut rows = Vec::new();
    for (number, line) in lines {
        let number = number + 1;
        let values = line
            .split(',')
            .map(|word| word.parse().map_err(|_| content(number, format!("`{word}` is no number"))))
            .collect::<Result<Vec<f64>, _>>()?;
        if values.len() != names.len() {
            let problem = format!("{} columns instead of {}", values.len(), names.len());
            return Err(content(number, problem));
        }
        rows.push(HistoryRow { increment: values[0] as usize, values });
    }
    Ok((names, rows))
}

/// The lines of a table up to an increment, its header first.
pub(super) fn up_to(path: &Path, increments: usize) -> Result<String, OutputError> {
    let text = fs::read_to_string(path).map_err(OutputError::read(path))?;
    let keep = |line: &&str| {
        line.split(',').next().is_some_and(|word| word.parse().is_ok_and(|k: usize| k <= increments))
    };
    let mut lines = text.lines();
    let mut kept = lines.next().unwrap_or_default().to_owned();
    kept.push('\n');
    for line in lines.filter(keep) {
        kept.push_str(line);
        kept.push('\n');
    }
    Ok(kept)
}
