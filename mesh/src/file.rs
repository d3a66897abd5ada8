//! Files that appear whole or not at all.

use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Lets `write` fill a temporary file beside `path`, then gives it that name. On failure it is removed, and what was there
/// before stays.
///
/// # Errors
/// Those of `write`, and of making, syncing and renaming the file.
pub fn replace(path: &Path, write: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>) -> io::Result<()> {
    let name = name_beside(path)?;
    let file = OpenOptions::new().write(true).create_new(true).open(&name)?;
    let temporary = Temporary(name);
    let mut writer = BufWriter::new(&file);
    write(&mut writer)?;
    writer.flush()?;
    drop(writer);
    file.sync_all()?;
    drop(file);
    std::fs::rename(&temporary.0, path)
}

/// A file that is removed when this goes out of scope, unless it has been renamed.
struct Temporary(PathBuf);

impl Drop for Temporary {
    fn drop(&mut self) {
        // After a successful rename there is nothing to remove, and a failure cannot be reported from here.
        let _ = std::fs::remove_file(&self.0);
    }
}

/// The name of the file that a temporary one of [`replace`] was to become, if `name` is that of such a one. It is left behind where a
/// process was killed.
#[must_use]
pub fn target_of_temporary(name: &str) -> Option<&str> {
    let (target, writer) = name.strip_prefix('.')?.strip_suffix(".tmp")?.rsplit_once('.')?;
    let (process, count) = writer.split_once('-')?;
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    (!target.is_empty() && is_number(process) && is_number(count)).then_some(target)
}

/// A name in the same directory which no other writer uses, in this process or another.
fn name_beside(path: &Path) -> io::Result<PathBuf> {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    let name = path
        .file_name()
        .ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "the path does not end in a file name"))?;
    let mut temporary = std::ffi::OsString::from(".");
    temporary.push(name);
    let count = COUNTER.fetch_add(1, Ordering::Relaxed);
    temporary.push(format!(".{}-{count}.tmp", std::process::id()));
    Ok(path.with_file_name(temporary))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn temporary_files_tell_what_they_were_to_become() {
        let temporary = name_beside(Path::new("out/state.json")).unwrap();
        assert_eq!(temporary.parent(), Some(Path::new("out")));
        assert_eq!(target_of_temporary(temporary.file_name().unwrap().to_str().unwrap()), Some("state.json"));
        for other in
            ["state.json", ".state.json.12.tmp", ".state.json.12-a.tmp", "state.json.1-2.tmp", "..1-2.tmp"]
        {
            assert_eq!(target_of_temporary(other), None, "{other}");
        }
    }
}
