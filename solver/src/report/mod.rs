//! `report.html`: what a run did, in one page that needs nothing else.
//!
//! The page holds its data as JSON, the script that draws it (`report.js`) and plotly.js. It shows force over displacement,
//! iterations per increment, the convergence of each increment, the deformed shape in three dimensions, and the smooth master
//! surface over its facets. With several directories of results, such as those of both elements on one mesh, they are drawn
//! together.

mod surface;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};

pub use surface::{SurfaceSample, sample_surfaces};

use crate::output::{OutputError, Skin, SkinFrame, Summary, names, read_history, read_iterations};

/// What the page is made of.
const PAGE: &str = include_str!("page.html");
/// What draws it.
const SCRIPT: &str = include_str!("report.js");
/// Most frames of a run that a page holds; of more, evenly spaced ones are taken.
const MOST_FRAMES: usize = 41;

/// Everything about one run.
#[derive(Clone, Debug, Serialize)]
struct Run {
    /// What it is called in the page.
    label: String,
    summary: Summary,
    /// Columns of `history.csv`, by name.
    history: BTreeMap<String, Vec<f64>>,
    /// Per increment the relative residuals.
    residuals: BTreeMap<usize, Vec<f64>>,
    skin: Skin,
    frames: Vec<SkinFrame>,
    surfaces: Vec<SurfaceSample>,
}

/// Data of the page.
#[derive(Clone, Debug, Serialize)]
struct Data {
    runs: Vec<Run>,
}

/// The page for one or several directories of results.
///
/// # Errors
/// [`OutputError::Read`], [`OutputError::Content`].
pub fn report(directories: &[&Path]) -> Result<String, OutputError> {
    let mut runs = directories.iter().map(|directory| read_run(directory)).collect::<Result<Vec<_>, _>>()?;
    name_apart(&mut runs, directories);
    let title = runs.first().map_or_else(String::new, |run| run.summary.title.clone());
    // Within a script element only "</" could end it early.
    let data = serde_json::to_string(&Data { runs }).unwrap_or_default().replace("</", "<\\/");
    Ok(PAGE
        .replace("@TITLE@", &escaped(&title))
        .replace("@DATA@", &data)
        .replace("@SCRIPT@", SCRIPT)
        .replace("@PLOTLY@", &plotly_script()))
}

/// plotly.js as a script element; without the typesetting of formulas that the library would bring along.
fn plotly_script() -> String {
    let all = plotly::Plot::offline_js_sources();
    let end = "</script>";
    let plotly = all.split_inclusive(end).find(|script| script.contains("plotly.js"));
    plotly.map_or_else(|| all.clone(), str::to_owned)
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// Runs of the same element are told apart by their directories.
fn name_apart(runs: &mut [Run], directories: &[&Path]) {
    let elements: Vec<String> = runs.iter().map(|run| run.summary.element.clone()).collect();
    for ((run, element), directory) in runs.iter_mut().zip(&elements).zip(directories) {
        let repeated = elements.iter().filter(|other| *other == element).count() > 1;
        let directory =
            directory.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        run.label = if repeated { format!("{element} ({directory})") } else { element.clone() };
    }
}

fn read_run(directory: &Path) -> Result<Run, OutputError> {
    let (columns, rows) = read_history(&directory.join(names::HISTORY))?;
    let column = |k: usize| rows.iter().map(|row| row.values[k]).collect();
    let history = columns.iter().enumerate().map(|(k, name)| (name.clone(), column(k))).collect();
    let (columns, rows) = read_iterations(&directory.join(names::ITERATIONS))?;
    let relative = columns.iter().position(|name| name == "relative").unwrap_or(0);
    let mut residuals: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for row in rows {
        residuals.entry(row.increment).or_default().push(row.values[relative]);
    }
    let skins = directory.join(names::SKINS);
    let surfaces = skins.join(SURFACES);
    let surfaces = if surfaces.exists() { read_json(&surfaces)? } else { Vec::new() };
    Ok(Run {
        label: String::new(),
        summary: read_json(&directory.join(names::SUMMARY))?,
        history,
        residuals,
        skin: read_json(&skins.join("skin.json"))?,
        frames: read_frames(&skins)?,
        surfaces,
    })
}

/// Name of the file of sampled surfaces, in the folder of skins.
pub const SURFACES: &str = "surfaces.json";

fn read_frames(skins: &Path) -> Result<Vec<SkinFrame>, OutputError> {
    let entries = fs::read_dir(skins).map_err(OutputError::read(skins))?;
    let number = |path: &Path| path.file_stem()?.to_str()?.parse::<usize>().ok();
    let mut paths: Vec<_> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "json"))
        .filter_map(|path| Some((number(&path)?, path)))
        .collect();
    paths.sort();
    let (count, most) = (paths.len(), MOST_FRAMES.min(paths.len()));
    // The first and the last are among them.
    let chosen = (0..most).map(|k| if most > 1 { k * (count - 1) / (most - 1) } else { 0 });
    chosen.map(|k| read_json(&paths[k].1)).collect()
}

fn read_json<T: for<'a> Deserialize<'a>>(path: &Path) -> Result<T, OutputError> {
    let text = fs::read_to_string(path).map_err(OutputError::read(path))?;
    serde_json::from_str(&text).map_err(|error| OutputError::Content {
        path: path.to_path_buf(),
        line: error.line(),
        problem: error.to_string(),
    })
}
