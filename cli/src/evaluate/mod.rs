//! The `evaluate` job: elements from a JSON file, results as JSON.
//!
//! [`schema`] says what a file may contain, [`result`] what comes back. A file that does not follow the schema is
//! refused as a whole; an element that follows it but has no result gets an error entry and the others are still
//! evaluated.

mod result;
mod schema;

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Read, Write};
use std::path::Path;

use diffuse_contact::{Backend, Basis};

use crate::args::EvaluateArguments;
use crate::backend::backend;
use crate::error::CliError;
use crate::output;

use result::{Outcome, evaluate};
use schema::{Document, ElementInput, Object};

/// Evaluates the elements of the input file.
pub fn run(arguments: &EvaluateArguments) -> Result<(), CliError> {
    if let Some(path) = &arguments.output {
        output::check_target(path)?;
        output::check_distinct(&arguments.input, path)?;
    }
    let document = read(&arguments.input)?;
    let backend = backend(arguments.backend);
    let mut failures = BTreeMap::new();
    let write = |writer: &mut dyn Write| write_results(writer, &document.elements, backend, &mut failures);
    match &arguments.output {
        Some(path) => output::write_file(path, write)?,
        None => output::write_stdout(write)?,
    }
    report_failures(&failures, document.elements.len());
    Ok(())
}

fn read(path: &Path) -> Result<Document, CliError> {
    let failed = |reason| CliError::Read { path: path.into(), reason };
    if path == Path::new("-") {
        let mut text = Vec::new();
        io::stdin().read_to_end(&mut text).map_err(failed)?;
        return parse("standard input", &text);
    }
    let text = fs::read(path).map_err(failed)?;
    parse(&path.display().to_string(), &text)
}

/// Reads the document; an element that no basis can fit is bad input, not a result.
fn parse(file: &str, text: &[u8]) -> Result<Document, CliError> {
    let document = schema::parse(file, text)?;
    for (element, Object(input)) in document.elements.iter().enumerate() {
        let found = input.masters().len();
        if found < Basis::Linear.size() {
            return Err(CliError::TooFewMasters { file: file.to_owned(), element, found });
        }
    }
    Ok(document)
}

/// One line per element; counts the codes of those without a result.
fn write_results(
    writer: &mut dyn Write,
    elements: &[Object<ElementInput>],
    backend: &dyn Backend,
    failures: &mut BTreeMap<&'static str, usize>,
) -> io::Result<()> {
    writer.write_all(b"{\"elements\":[")?;
    for (index, Object(element)) in elements.iter().enumerate() {
        let outcome = evaluate(element, backend);
        if let Outcome::Error { code, .. } = &outcome {
            *failures.entry(code).or_default() += 1;
        }
        writer.write_all(if index == 0 { b"\n" } else { b",\n" })?;
        serde_json::to_writer(&mut *writer, &outcome)?;
    }
    writer.write_all(b"\n]}\n")
}

fn report_failures(failures: &BTreeMap<&'static str, usize>, total: usize) {
    if failures.is_empty() {
        return;
    }
    let codes: Vec<String> = failures.iter().map(|(code, count)| format!("{code}: {count}")).collect();
    let failed: usize = failures.values().sum();
    let _ =
        writeln!(io::stderr(), "note: {failed} of {total} elements have no result ({})", codes.join(", "));
}
