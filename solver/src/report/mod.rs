//! `report.html`: what a run did, in one page that needs nothing else.
//!
//! The page holds its data as JSON, the script that draws it (`report.js`) and plotly.js. It shows force over displacement,
//! iterations per increment, the convergence of each increment, contact over time, where a run failed, the deformed shape in
//! three dimensions, and the smooth master surface over its facets. With several directories of results they are drawn
//! together. Shapes and surfaces take up to about 8 MB of it; what is left out for that is said in the page.

mod shown;
mod surface;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use diffuse_contact_mesh::names::shown;
use serde::Serialize;

pub use surface::{Master, SurfaceSample, sample_surfaces};

use shown::Surface;

use crate::deck::Deck;
use crate::output::{
    Failed, History, OutputError, SKIN, Skin, SkinFrame, Summary, names, read_history, read_json,
};

/// What the page is made of.
const PAGE: &str = include_str!("page.html");
/// What draws it.
const SCRIPT: &str = include_str!("report.js");

/// Everything about one run.
#[derive(Clone, Debug, Serialize)]
struct Run {
    /// What it is called in the page.
    label: String,
    summary: Summary,
    /// Columns of `history.csv`, by name.
    history: BTreeMap<String, Vec<f64>>,
    /// Per increment the residuals that are shown: linear solutions so far, and the residual over what is allowed.
    residuals: BTreeMap<usize, Vec<(f64, f64)>>,
    skin: Skin,
    frames: Vec<SkinFrame>,
    surfaces: Vec<Surface>,
    /// The increment that it ended with, if that failed.
    failed: Option<Failed>,
    /// What is not shown.
    notes: Vec<String>,
}

/// The page for one or several directories of results.
///
/// # Errors
/// [`OutputError::Read`], [`OutputError::Content`].
pub fn report(directories: &[&Path]) -> Result<String, OutputError> {
    let mut runs = directories
        .iter()
        .map(|directory| read_run(directory, directories.len()))
        .collect::<Result<Vec<_>, _>>()?;
    name_apart(&mut runs, directories);
    let title = runs.first().map_or_else(String::new, |run| run.summary.title.clone());
    // Within a script element a "<" could end it early or open a comment. In JSON it occurs within strings only.
    let data =
        serde_json::to_string(&BTreeMap::from([("runs", runs)])).unwrap_or_default().replace('<', "\\u003c");
    Ok(fill(&[
        ("@TITLE@", &escaped(&title)),
        ("@PLOTLY@", &plotly_script()),
        ("@DATA@", &data),
        ("@SCRIPT@", SCRIPT),
    ]))
}

/// The page with its marks, which it holds in this order, replaced. What replaces them is not searched for marks.
fn fill(marks: &[(&str, &str)]) -> String {
    let mut rest = PAGE;
    let mut page = String::new();
    for (mark, text) in marks {
        let (before, after) = rest.split_once(mark).unwrap_or((rest, ""));
        page.push_str(before);
        page.push_str(text);
        rest = after;
    }
    page + rest
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
    let mut alike: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (k, run) in runs.iter().enumerate() {
        alike.entry(run.summary.element.clone()).or_default().push(k);
    }
    for (element, places) in alike {
        let own: Vec<&Path> = places.iter().map(|&k| directories[k]).collect();
        for (&k, end) in places.iter().zip(distinct_ends(&own)) {
            runs[k].label = if own.len() > 1 { format!("{element} ({end})") } else { element.clone() };
        }
    }
}

/// The shortest ends of these paths by which they differ, with as many names each. What is there several times gets a number.
fn distinct_ends(directories: &[&Path]) -> Vec<String> {
    // The name of `.` is that of the directory it stands for.
    let whole = |path: &&Path| path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let paths: Vec<PathBuf> = directories.iter().map(whole).collect();
    let end = |path: &PathBuf, length: usize| {
        let names: Vec<_> = path.components().collect();
        let end: PathBuf = names[names.len().saturating_sub(length)..].iter().collect();
        end.display().to_string()
    };
    let ends = |length: usize| paths.iter().map(|path| end(path, length)).collect::<Vec<_>>();
    let count = |ends: &[String]| ends.iter().collect::<BTreeSet<_>>().len();
    let longest = paths.iter().map(|path| path.components().count()).max().unwrap_or_default();
    let most = count(&ends(longest));
    let shortest = (1..longest).find(|&length| count(&ends(length)) == most).unwrap_or(longest);
    let mut known: BTreeMap<String, usize> = BTreeMap::new();
    let numbered = ends(shortest).into_iter().map(|end| {
        let number = known.entry(end.clone()).or_default();
        *number += 1;
        if *number > 1 { format!("{end}, {number}") } else { end }
    });
    numbered.collect()
}

/// One of `runs` runs in a page.
fn read_run(directory: &Path, runs: usize) -> Result<Run, OutputError> {
    let increments = read_history(&directory.join(names::HISTORY))?;
    let column = |k: usize| increments.rows.iter().map(|row| row.values[k]).collect();
    let history = increments.columns.iter().enumerate().map(|(k, name)| (name.clone(), column(k))).collect();
    let iterations = read_history(&directory.join(names::ITERATIONS))?;
    let mut residuals: BTreeMap<usize, Vec<(f64, f64)>> = BTreeMap::new();
    for row in &iterations.rows {
        let [iteration, residual, allowed, step] =
            ["iteration", "residual", "allowed", "step"].map(|column| iterations.value(row, column));
        let known = residuals.entry(row.increment).or_default();
        // The first is that before the prescribed nodes move, unless it is that of an extrapolation.
        if iteration > 0.0 || step > 0.0 || !known.is_empty() {
            known.push((iteration, residual / allowed));
        }
    }
    let skins = directory.join(names::SKINS);
    let mut notes = Vec::new();
    let summary = directory.join(names::SUMMARY);
    let (summary, surfaces) = if summary.exists() {
        (read_json(&summary)?, read_surfaces(&skins.join(SURFACES))?)
    } else {
        (unfinished(directory, &increments), Vec::new())
    };
    let surfaces = shown::surfaces(&surfaces, runs, &mut notes);
    let (skin, frames) = read_frames(&skins, read_skin(&skins.join(SKIN))?, runs, &mut notes)?;
    let failed = directory.join(names::FAILED);
    let failed = if failed.exists() { Some(read_failed(&failed, &skin)?) } else { None };
    Ok(Run { failed, label: String::new(), summary, history, residuals, frames, skin, surfaces, notes })
}

/// Of a run that goes on, or was killed: its increments so far.
fn unfinished(directory: &Path, increments: &History) -> Summary {
    let deck = fs::read_to_string(directory.join(names::DECK)).ok().and_then(|text| Deck::parse(&text).ok());
    let last = |column| increments.rows.last().map_or(0.0, |row| increments.value(row, column));
    Summary {
        title: deck.map_or_else(String::new, |deck| deck.title),
        reason: "the run has not ended".to_owned(),
        time: last("time"),
        increments: increments.rows.len(),
        newton_iterations: increments
            .rows
            .iter()
            .map(|row| increments.value(row, "iterations") as usize)
            .sum(),
        max_penetration: last("max_penetration"),
        wall_s: last("wall_s"),
        ..Summary::default()
    }
}

/// The shape is left out where that of the run is.
fn read_failed(path: &Path, skin: &Skin) -> Result<Failed, OutputError> {
    let mut failed: Failed = read_json(path)?;
    let fits = |frame: &SkinFrame| misfit(frame, skin.nodes.len()).is_none();
    failed.frame = failed.frame.filter(fits).map(shown::short);
    Ok(failed)
}

/// Name of the file of sampled surfaces, in the folder of skins.
pub const SURFACES: &str = "surfaces.json";

/// A file that does not fit the others.
fn inconsistent(path: &Path, problem: impl Into<String>) -> OutputError {
    OutputError::Inconsistent { path: path.to_path_buf(), problem: problem.into() }
}

fn read_skin(path: &Path) -> Result<Skin, OutputError> {
    let skin: Skin = read_json(path)?;
    if skin.faces.iter().flatten().any(|&corner| corner >= skin.nodes.len()) {
        return Err(inconsistent(
            path,
            format!("a face has a corner that is none of the {} nodes", skin.nodes.len()),
        ));
    }
    if skin.faces.len() != skin.parts.len() {
        let (faces, parts) = (skin.faces.len(), skin.parts.len());
        return Err(inconsistent(path, format!("{faces} faces, but {parts} numbers of their parts")));
    }
    Ok(skin)
}

/// Looks at all skins up to an increment as a report would, one at a time: they are those of this skin.
pub(crate) fn check_skins(skins: &Path, expected: &Skin, increments: usize) -> Result<(), OutputError> {
    let path = skins.join(SKIN);
    if read_skin(&path)? != *expected {
        return Err(inconsistent(&path, "it is not the skin of the deck's model"));
    }
    for (_, path) in numbered(skins)?.into_iter().filter(|&(number, _)| number <= increments) {
        read_frame(&path, expected.nodes.len())?;
    }
    Ok(())
}

/// The skins by their numbers.
fn numbered(skins: &Path) -> Result<Vec<(usize, PathBuf)>, OutputError> {
    let entries = fs::read_dir(skins).map_err(OutputError::read(skins))?;
    let number = |path: &Path| path.file_stem()?.to_str()?.parse::<usize>().ok();
    let mut paths: Vec<_> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "json"))
        .filter_map(|path| Some((number(&path)?, path)))
        .collect();
    paths.sort();
    Ok(paths)
}

/// The samples of the master surfaces; none if the run was interrupted before they were made.
fn read_surfaces(path: &Path) -> Result<Vec<SurfaceSample>, OutputError> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let surfaces: Vec<SurfaceSample> = read_json(path)?;
    match surfaces.iter().find(|surface| !surface.is_sound()) {
        Some(surface) => Err(inconsistent(
            path,
            format!("the sample `{}` refers to points it does not have", shown(&surface.name)),
        )),
        None => Ok(surfaces),
    }
}

/// The skin and the frames of it that are shown.
fn read_frames(
    skins: &Path,
    skin: Skin,
    runs: usize,
    notes: &mut Vec<String>,
) -> Result<(Skin, Vec<SkinFrame>), OutputError> {
    let paths = numbered(skins)?;
    if paths.is_empty() {
        return Err(inconsistent(skins, "there is no shape, not even that of the start"));
    }
    let nodes = skin.nodes.len();
    shown::frames(skin, paths.len(), runs, |k| read_frame(&paths[k].1, nodes), notes)
}

fn read_frame(path: &Path, expected: usize) -> Result<SkinFrame, OutputError> {
    let frame: SkinFrame = read_json(path)?;
    match misfit(&frame, expected) {
        Some(found) => {
            Err(inconsistent(path, format!("{found} values for the {expected} nodes of the skin")))
        }
        None => Ok(frame),
    }
}

/// The number of some values of a frame that is not that of the skin's nodes.
fn misfit(frame: &SkinFrame, nodes: usize) -> Option<usize> {
    let mut lengths = frame.fields.values().map(Vec::len).chain([frame.positions.len()]);
    lengths.find(|&length| length != nodes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directories_are_told_apart_by_their_ends() {
        let here = std::env::current_dir().unwrap();
        let here = here.file_name().unwrap().to_string_lossy().into_owned();
        for (directories, expected) in [
            (&["a/one", "a/two"][..], &["one", "two"][..]),
            (&["a/out", "b/out"], &["a/out", "b/out"]),
            (&["a/x/out", "b/x/out", "b/y/out"], &["a/x/out", "b/x/out", "b/y/out"]),
            (&["a/out", "out"], &["a/out", "out"]),
            (&["a/out", "a/out", "b"], &["out", "out, 2", "b"]),
            (&[".", "a"], &[&here, "a"]),
        ] {
            let paths: Vec<&Path> = directories.iter().map(Path::new).collect();
            assert_eq!(distinct_ends(&paths), expected, "{directories:?}");
        }
    }
}
