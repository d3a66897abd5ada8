//! Reading what a program is given.

use std::fs;
use std::io::{self, Read};
use std::path::Path;

use crate::error::CliError;

/// The text of a file, or of standard input for `-`, and its name for messages.
///
/// # Errors
/// [`CliError::Read`] if it cannot be read.
pub fn read(path: &Path) -> Result<(String, Vec<u8>), CliError> {
    let failed = |reason| CliError::Read { path: path.into(), reason };
    if path == Path::new("-") {
        let mut text = Vec::new();
        io::stdin().read_to_end(&mut text).map_err(failed)?;
        return Ok(("standard input".to_owned(), text));
    }
    let text = fs::read(path).map_err(failed)?;
    Ok((path.display().to_string(), text))
}
