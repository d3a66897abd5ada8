//! Files that appear whole or not at all.

use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Lets `write` fill a temporary file beside `path`, then gives it that name, with the permissions of the file that it replaces.
/// On failure it is removed, and what was there before stays.
///
/// # Errors
/// Those of `write`, and of making, syncing and renaming the file.
pub fn replace(path: &Path, write: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>) -> io::Result<()> {
    let existing = std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file);
    let (temporary, file) = temporary_beside(path)?;
    let mut writer = BufWriter::new(&file);
    write(&mut writer)?;
    writer.flush()?;
    drop(writer);
    if let Some(existing) = existing {
        file.set_permissions(existing.permissions())?;
    }
    file.sync_all()?;
    drop(file);
    std::fs::rename(&temporary.0, path)
}

/// What the system says, in words and without its numbers.
pub fn reason(error: &io::Error) -> String {
    use io::ErrorKind::{IsADirectory, NotADirectory, NotFound, PermissionDenied, StorageFull};
    match error.kind() {
        NotFound => "there is no such file".into(),
        PermissionDenied => "permission denied".into(),
        IsADirectory => "it is a directory".into(),
        NotADirectory => "part of its path is not a directory".into(),
        StorageFull => "the disk is full".into(),
        _ => {
            let text = error.to_string();
            text.split(" (os error").next().unwrap_or(&text).to_lowercase()
        }
    }
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
pub fn target_of_temporary(name: &str) -> Option<&str> {
    let (target, writer) = name.strip_prefix('.')?.strip_suffix(".tmp")?.rsplit_once('.')?;
    let (process, count) = writer.split_once('-')?;
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    (!target.is_empty() && is_number(process) && is_number(count)).then_some(target)
}

/// A new file in the same directory, under a name that no other writer uses.
///
/// A name may be taken all the same: where processes have the same number each time they start, as in containers, a killed one leaves
/// the very name that the next would choose.
fn temporary_beside(path: &Path) -> io::Result<(Temporary, File)> {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    let target = path
        .file_name()
        .ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "the path does not end in a file name"))?;
    loop {
        let count = COUNTER.fetch_add(1, Ordering::Relaxed);
        let mut name = std::ffi::OsString::from(".");
        name.push(target);
        name.push(format!(".{}-{count}.tmp", std::process::id()));
        let name = path.with_file_name(name);
        match OpenOptions::new().write(true).create_new(true).open(&name) {
            // Files are left behind one by one, so there is a free name before long.
            Err(taken) if taken.kind() == io::ErrorKind::AlreadyExists => {}
            opened => return opened.map(|file| (Temporary(name), file)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn temporary_files_tell_what_they_were_to_become() {
        let directory = std::env::temp_dir();
        let (temporary, _) = temporary_beside(&directory.join("state.json")).unwrap();
        let path = temporary.0.clone();
        assert_eq!(path.parent(), Some(&*directory));
        assert_eq!(target_of_temporary(path.file_name().unwrap().to_str().unwrap()), Some("state.json"));
        drop(temporary);
        assert!(!path.exists());
        for other in
            ["state.json", ".state.json.12.tmp", ".state.json.12-a.tmp", "state.json.1-2.tmp", "..1-2.tmp"]
        {
            assert_eq!(target_of_temporary(other), None, "{other}");
        }
    }

    /// In a container the process has the number of the one before, which was killed while it wrote.
    #[test]
    fn left_over_files_of_a_process_with_the_same_number_are_passed_over() {
        let directory =
            std::env::temp_dir().join(format!("diffuse-contact-left-over-{}", std::process::id()));
        std::fs::create_dir_all(&directory).unwrap();
        let left = |count| directory.join(format!(".out.json.{}-{count}.tmp", std::process::id()));
        (0..1000).for_each(|count| std::fs::write(left(count), "half").unwrap());
        let path = directory.join("out.json");
        replace(&path, |writer| writer.write_all(b"whole")).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"whole");
        assert!(
            (0..1000).all(|count| std::fs::read(left(count)).unwrap() == b"half"),
            "nobody else's are touched"
        );
        std::fs::remove_dir_all(&directory).unwrap();
    }
}
