//! The `evaluate` job: elements from a JSON file, results as JSON.
//!
//! `schema` says what a file may contain, `result` what comes back. A file that does not follow the schema is
//! refused as a whole; an element that follows it but has no result gets an error entry and the others are still
//! evaluated.

mod arguments;
mod result;
pub(crate) mod schema;

use std::io::{self, Write};
use std::process::ExitCode;

use diffuse_contact::{Backend, Basis, Generated};

use crate::content::ContentError;
use crate::elsewhere;
use crate::error::CliError;
use crate::json::Object;
use crate::outcome::{Failures, answer};

pub use arguments::{BackendKind, EvaluateArguments};

use result::evaluate;
use schema::{Document, ElementInput};

/// Evaluates the elements of the input file, or has the laboratory do it by automatic differentiation.
pub(crate) fn run(arguments: &EvaluateArguments) -> Result<ExitCode, CliError> {
    match arguments.backend {
        BackendKind::Generated => run_with(arguments, &Generated),
        BackendKind::Ad => elsewhere::run_for(elsewhere::LABORATORY, "evaluate --backend ad".to_owned()),
    }
}

/// Evaluates the elements of the input file.
///
/// # Errors
/// Files that cannot be read or written, and a document that does not follow the schema.
pub fn run_with(arguments: &EvaluateArguments, backend: &dyn Backend) -> Result<ExitCode, CliError> {
    answer(
        (&arguments.input, arguments.output.as_deref()),
        parse,
        |writer, document, failures| write_results(writer, &document.elements, backend, failures),
        (|document: &Document| document.elements.len(), "elements"),
    )
}

/// Reads the document; an element that no basis can fit is bad input, not a result.
fn parse(file: &str, text: &[u8]) -> Result<Document, CliError> {
    let document = schema::parse(file, text)?;
    for (element, Object(input)) in document.elements.iter().enumerate() {
        let found = input.masters().len();
        if found < Basis::Linear.size() {
            let place = format!("elements[{element}].masters");
            return Err(ContentError::TooFewMasters { file: file.to_owned(), place, found }.into());
        }
    }
    Ok(document)
}

/// One line per element; counts the codes of those without a result.
fn write_results(
    writer: &mut dyn Write,
    elements: &[Object<ElementInput>],
    backend: &dyn Backend,
    failures: &mut Failures,
) -> io::Result<()> {
    writer.write_all(b"{\"elements\":[")?;
    for (index, Object(element)) in elements.iter().enumerate() {
        let outcome = evaluate(element, backend);
        failures.count(&outcome);
        writer.write_all(if index == 0 { b"\n" } else { b",\n" })?;
        serde_json::to_writer(&mut *writer, &outcome)?;
    }
    writer.write_all(b"\n]}\n")
}
