//! Writing results so that a reader never meets half of them.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use diffuse_contact_mesh::{VtuError, VtuFile, file};
use serde::Serialize;

use crate::error::CliError;

/// Refuses early what [`write_file`] would refuse after the computation: a missing directory, a directory.
pub fn check_target(path: &Path) -> Result<(), CliError> {
    let failed = |kind: ErrorKind| CliError::Write { path: path.into(), reason: kind.into() };
    if path.is_dir() {
        return Err(failed(ErrorKind::IsADirectory));
    }
    if path.file_name().is_none() {
        return Err(failed(ErrorKind::NotFound));
    }
    let directory = directory_of(path);
    match fs::metadata(&directory) {
        Ok(found) if found.is_dir() => Ok(()),
        Ok(_) => Err(failed(ErrorKind::NotADirectory)),
        Err(reason) if reason.kind() == ErrorKind::NotFound => {
            Err(CliError::NoDirectory { path: path.into(), directory })
        }
        Err(reason) => Err(CliError::Write { path: path.into(), reason }),
    }
}

/// Refuses the name of another kind of file for a VTU file.
pub fn check_grid(path: &Path) -> Result<(), CliError> {
    const OTHERS: [&str; 13] =
        ["svg", "png", "pdf", "html", "json", "csv", "txt", "vtk", "vtp", "stl", "inp", "msh", "toml"];
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if OTHERS.contains(&extension.as_str()) {
        return Err(CliError::NoGrid { path: path.into() });
    }
    Ok(())
}

/// Refuses to replace an input file by its results.
pub fn check_distinct(input: &Path, output: &Path) -> Result<(), CliError> {
    match (fs::canonicalize(input), fs::canonicalize(output)) {
        (Ok(input), Ok(existing)) if input == existing => {
            Err(CliError::OutputIsInput { path: output.into() })
        }
        _ => Ok(()),
    }
}

/// Refuses to replace a file by a page unless it is one, or empty: a name that is forgotten before `-o` leaves that of an input.
pub fn check_page(path: &Path) -> Result<(), CliError> {
    const BEGIN: &[u8] = b"<!DOCTYPE html>";
    if !path.is_file() {
        return Ok(());
    }
    let mut begin = Vec::new();
    let read = File::open(path).and_then(|file| file.take(BEGIN.len() as u64).read_to_end(&mut begin));
    match read {
        Ok(_) if begin.is_empty() || begin == BEGIN => Ok(()),
        Ok(_) => Err(CliError::NoPage { path: path.into() }),
        Err(reason) => Err(CliError::Write { path: path.into(), reason }),
    }
}

/// Refuses to write two results to one file, which need not exist yet. A pipe or device takes both.
pub fn check_apart(one: &Path, other: &Path) -> Result<(), CliError> {
    let place = |path: &Path| {
        let in_directory =
            |_| Ok(fs::canonicalize(directory_of(path))?.join(path.file_name().unwrap_or_default()));
        fs::canonicalize(path).or_else(in_directory)
    };
    let is_device = fs::metadata(one).is_ok_and(|found| !found.is_file());
    let places: io::Result<_> = place(one).and_then(|one| Ok((one, place(other)?)));
    match places {
        Ok((one, also)) if one == also && !is_device => Err(CliError::OutputIsOutput { path: other.into() }),
        _ => Ok(()),
    }
}

/// Writes a file by filling a temporary one in the same directory and renaming it when it is complete. A pipe or
/// device that exists under this name is written to, not replaced.
pub fn write_file(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), CliError> {
    check_target(path)?;
    replace(path, fill).map_err(|reason| CliError::Write { path: path.into(), reason })
}

/// Writes a picture for ParaView, as [`write_file`] does.
pub fn write_vtu(path: &Path, grid: &VtuFile<'_>) -> Result<(), CliError> {
    write_file(path, |mut writer| {
        grid.write_to(&mut writer).map_err(|error| match error {
            VtuError::Output { cause } => cause,
            unsound => io::Error::other(unsound),
        })
    })
}

/// Writes to standard output.
pub fn write_stdout(fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), CliError> {
    let mut writer = BufWriter::new(io::stdout().lock());
    fill(&mut writer).and_then(|()| writer.flush()).map_err(CliError::Stdout)
}

/// Writes a document to standard output, indented, with a line's end.
pub fn write_json(document: &impl Serialize) -> Result<(), CliError> {
    write_stdout(|writer| {
        serde_json::to_writer_pretty(&mut *writer, document)?;
        writeln!(writer)
    })
}

fn replace(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    // A link keeps pointing to the file that is replaced.
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.into());
    let existing = fs::metadata(&path).ok();
    if existing.is_some_and(|found| !found.is_file()) {
        let mut writer = BufWriter::new(OpenOptions::new().write(true).open(&path)?);
        return fill(&mut writer).and_then(|()| writer.flush());
    }
    file::replace(&path, |writer| fill(writer))
}

/// Directory part of a path, `.` for a bare file name.
fn directory_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.into(),
        _ => PathBuf::from("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An empty directory of this test alone.
    fn directory(name: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("diffuse-contact-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        path
    }

    #[test]
    fn a_failure_leaves_the_old_file_and_nothing_else() {
        let directory = directory("failure");
        let path = directory.join("out.json");
        fs::write(&path, "old").unwrap();
        let error = write_file(&path, |writer| {
            writer.write_all(b"half")?;
            Err(ErrorKind::StorageFull.into())
        })
        .unwrap_err();
        assert!(error.to_string().contains("out.json: cannot be written"), "{error}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(&directory).unwrap().count(), 1);
        fs::remove_dir_all(&directory).unwrap();
    }

    #[test]
    fn a_complete_file_replaces_the_old_one() {
        let directory = directory("success");
        let path = directory.join("out.json");
        fs::write(&path, "old").unwrap();
        write_file(&path, |writer| writer.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(&directory).unwrap().count(), 1);
        fs::remove_dir_all(&directory).unwrap();
    }

    #[test]
    fn a_target_that_cannot_be_is_refused_at_once() {
        let directory = directory("target");
        assert!(matches!(check_target(&directory), Err(CliError::Write { .. })));
        let missing = directory.join("missing").join("out.json");
        assert!(matches!(check_target(&missing), Err(CliError::NoDirectory { .. })));
        assert!(check_target(Path::new("out.json")).is_ok());
        fs::remove_dir_all(&directory).unwrap();
    }

    #[test]
    fn two_results_are_not_one_file() {
        let directory = directory("apart");
        let path = directory.join("out.vtu");
        let roundabout = directory.join(".").join("out.vtu");
        assert!(check_apart(&path, &directory.join("out.svg")).is_ok());
        let refused = |one: &Path, other: &Path| matches!(check_apart(one, other), Err(CliError::OutputIsOutput { path }) if path == other);
        // Before there is such a file, and then.
        assert!(refused(&path, &path) && refused(&path, &roundabout));
        fs::write(&path, "old").unwrap();
        assert!(refused(&path, &path) && refused(&roundabout, &path));
        fs::remove_dir_all(&directory).unwrap();
        if cfg!(unix) {
            assert!(check_apart(Path::new("/dev/null"), Path::new("/dev/null")).is_ok());
        }
    }
}
