//! The examples of Chamoret, Rassineux, Bergheau (2008), with the diffuse and the classic element: every figure of
//! `docs/results/paper.md`.
//!
//! * [`cylinder`]: penetration into a cylinder that is described by facets;
//! * [`pinch`]: Newton iterations of the pinch of a pipe;
//! * [`steps`]: the same in longer increments;
//! * [`sliding`]: iterations where nodes slide over kinks, and with extrapolation;
//! * [`tangents`]: what the exact tangent is worth.

mod case;
mod cylinder;
mod pinch;
mod plot;
mod sliding;
mod steps;
mod tangents;

use std::path::{Path, PathBuf};

use super::arguments::PaperArguments;
use crate::error::CliError;
use crate::output;
use crate::progress::logged;
use crate::threads::with_threads;

use case::{Case, Outcome};

/// File names and contents.
type Pictures = Vec<(&'static str, String)>;

/// A part of the document.
struct Chapter {
    text: String,
    pictures: Pictures,
}

/// Runs decks, and writes them if that is asked for.
struct Decks {
    directory: Option<PathBuf>,
    bar: crate::progress::Progress,
}

impl Decks {
    fn run(&self, case: &Case) -> Result<Outcome, CliError> {
        if let Some(directory) = &self.directory {
            case.write_to(directory)?;
        }
        let outcome = case.run().map_err(CliError::job);
        self.bar.inc(1);
        outcome
    }
}

/// Makes the study.
pub fn run(arguments: &PaperArguments) -> Result<(), CliError> {
    if let Some(path) = &arguments.output {
        output::check_target(path)?;
    }
    let scope = pinch::Scope::new(arguments.quick);
    let count = if arguments.pictures.is_some() {
        cylinder::cases().len() + scope.drawn_runs() + tangents::DRAWN_RUNS
    } else {
        cylinder::cases().len() + scope.runs() + sliding::runs(&scope) + tangents::runs(&scope)
    };
    let decks = Decks { directory: arguments.decks.clone(), bar: logged("runs", count) };
    if let Some(folder) = &arguments.pictures {
        let drawn = with_threads(Some(1), || {
            let (pinch, tangents) = (pinch::pictures(&decks, &scope)?, tangents::pictures(&decks, &scope)?);
            Ok([cylinder::pictures(&decks)?, pinch, tangents].concat())
        })?;
        decks.bar.finish_and_clear();
        return write_to(folder, &drawn);
    }
    let chapters = with_threads(Some(1), || {
        Ok([
            cylinder::chapter(&decks)?,
            pinch::chapter(&decks, &scope)?,
            sliding::chapter(&decks, &scope)?,
            tangents::chapter(&decks, &scope)?,
        ])
    })?;
    decks.bar.finish_and_clear();
    let mut document = introduction(arguments.quick);
    for chapter in &chapters {
        document.push('\n');
        document.push_str(&chapter.text);
    }
    // What the tables say, which a run of a part of them does not.
    if !arguments.quick {
        document.push('\n');
        document.push_str(include_str!("notes.md"));
    }
    let Some(path) = &arguments.output else {
        return output::write_stdout(|writer| writer.write_all(document.as_bytes()));
    };
    let folder = path.parent().unwrap_or(Path::new("")).join("pictures");
    for chapter in &chapters {
        write_to(&folder, &chapter.pictures)?;
    }
    output::write_file(path, |writer| writer.write_all(document.as_bytes()))
}

fn write_to(folder: &Path, pictures: &Pictures) -> Result<(), CliError> {
    std::fs::create_dir_all(folder).map_err(|reason| CliError::Write { path: folder.into(), reason })?;
    for (name, picture) in pictures {
        output::write_file(&folder.join(name), |writer| writer.write_all(picture.as_bytes()))?;
    }
    Ok(())
}

fn introduction(is_quick: bool) -> String {
    let option = if is_quick { " --quick" } else { "" };
    format!(
        "# The examples of the paper\n\n\
         Written by `cargo lab study paper -o docs/results/paper.md{option}`; do not edit.\n\n\
         The diffuse element and the classic one, nodes against facets, in the same code: same meshes, penalties, tolerances, line \
         search and predictor. Both have the same tangent, `tangent = \"adaptive\"`, except where that is the question and in \
         `ring_block`, whose deck has the exact one. Decks are those of `examples/` with the changes \
         named in the tables; `--decks DIR` writes every one of them, and `cargo solve DIR/NAME.toml` runs it. \
         *Iterations* are linear solutions, the predictor's and those of failed increments included. An increment \
         has converged at a residual of 10⁻⁶ of the forces. Runs are on one thread.\n"
    )
}
