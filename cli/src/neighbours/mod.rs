//! The `neighbours` job: which master nodes surround a slave, from a JSON file to JSON.
//!
//! [`schema`] says what a file may contain, [`result`] what comes back. As in `evaluate`, a file that does not follow
//! the schema is refused as a whole; a search that follows it but finds no neighbourhood gets an error entry.

mod arguments;
mod result;
mod schema;

use std::io::{self, Write};
use std::process::ExitCode;

use diffuse_contact::Basis;

use crate::content::ContentError;
use crate::error::CliError;
use crate::json::Object;
use crate::outcome::{Failures, answer};

pub use arguments::NeighboursArguments;

use result::search;
use schema::{Document, Layout, Rule, SearchInput};

/// Searches the neighbours of all slaves of the input file.
pub fn run(arguments: &NeighboursArguments) -> Result<ExitCode, CliError> {
    answer(
        (&arguments.input, arguments.output.as_deref()),
        parse,
        write_results,
        (|document: &Document| document.searches.len(), "searches"),
    )
}

/// Reads the document; masters that no basis can fit and fields without meaning are bad input.
fn parse(file: &str, text: &[u8]) -> Result<Document, CliError> {
    let document = schema::parse(file, text)?;
    for (index, Object(input)) in document.searches.iter().enumerate() {
        let place = |field: &str| document.layout.place(index) + field;
        let found = input.masters().len();
        if found < Basis::Linear.size() {
            let (file, place) = (file.to_owned(), place("masters"));
            return Err(ContentError::TooFewMasters { file, place, found }.into());
        }
        let of_element = input.field_of_element().filter(|_| document.layout != Layout::Elements);
        let of_element = of_element.map(|field| (field, "for a search: it is a field of `evaluate`"));
        if let Some((field, beside)) = of_element.or_else(|| meaningless(input)) {
            let (file, place) = (file.to_owned(), place(field));
            return Err(ContentError::MeaninglessField { file, place, beside }.into());
        }
    }
    Ok(document)
}

/// A field that is given although nothing looks at it, and because of what.
fn meaningless(input: &SearchInput) -> Option<(&'static str, &'static str)> {
    let SearchInput { rule, layers, count, basis, .. } = input;
    match rule {
        Rule::Nearest if layers.is_some() => Some(("layers", "for the rule \"nearest\"")),
        Rule::HullLayers if count.is_some() => Some(("count", "for the rule \"hull-layers\"")),
        Rule::HullRadius if count.is_some() => Some(("count", "for the rule \"hull-radius\"")),
        Rule::HullLayers if layers.is_some() && basis.is_some() => {
            Some(("basis", "for a number of hull layers, which are taken whatever fit they carry"))
        }
        _ => None,
    }
}

/// One line per search, laid out as the input is; counts the codes of those without a result.
fn write_results(writer: &mut dyn Write, document: &Document, failures: &mut Failures) -> io::Result<()> {
    let (begin, end): (&[u8], &[u8]) = match document.layout {
        Layout::One => (b"", b"\n"),
        Layout::List => (b"[", b"\n]\n"),
        Layout::Elements => (b"{\"elements\":[", b"\n]}\n"),
    };
    writer.write_all(begin)?;
    for (index, Object(input)) in document.searches.iter().enumerate() {
        let outcome = search(input);
        failures.count(&outcome);
        if document.layout != Layout::One {
            writer.write_all(if index == 0 { b"\n" } else { b",\n" })?;
        }
        serde_json::to_writer(&mut *writer, &outcome)?;
    }
    writer.write_all(end)
}
