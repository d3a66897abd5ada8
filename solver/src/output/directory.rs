//! A directory of results: files that are whole, tables that grow by whole lines.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use diffuse_contact_mesh::file;
use serde::Serialize;

use super::{OutputError, names};

/// Files of a directory of results besides those in its folders; the deck, which may be the user's own, is not among them.
const FILES: [&str; 6] =
    [names::STATE, names::SUMMARY, names::HISTORY, names::ITERATIONS, names::SERIES, names::REPORT];

/// Where results are written.
#[derive(Clone, Debug)]
pub struct Directory(PathBuf);

/// The right to write to a directory, as long as it lives. It is the system's lock of the directory, which ends with the
/// process however that ends; where directories cannot be locked, such as on Windows, nothing is kept away.
#[derive(Debug)]
pub struct Claim(#[allow(dead_code)] Option<File>);

impl Claim {
    /// Claims a directory that exists; one that does not is left to whoever needs it.
    ///
    /// # Errors
    /// [`OutputError::Busy`] if somebody else has it.
    pub fn of(path: &Path) -> Result<Self, OutputError> {
        let Ok(directory) = File::open(path) else { return Ok(Self(None)) };
        match directory.try_lock() {
            Err(TryLockError::WouldBlock) => Err(OutputError::Busy { path: path.to_path_buf() }),
            Ok(()) | Err(TryLockError::Error(_)) => Ok(Self(Some(directory))),
        }
    }
}

impl Directory {
    /// Results are there or will be.
    pub fn new(path: &Path) -> Self {
        Self(path.to_path_buf())
    }

    /// A file in it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Makes it and its folders. Results that are there are removed if they may be replaced, the state first: what is left of
    /// them if this is interrupted does not pass for a run.
    pub fn prepare(&self, deck: &str, overwrite: bool) -> Result<(), OutputError> {
        let holds_results = FILES.iter().any(|name| self.path(name).exists());
        let path = self.path(names::DECK);
        let holds_other_deck =
            !holds_results && path.exists() && fs::read(&path).ok().as_deref() != Some(deck.as_bytes());
        if (holds_results || holds_other_deck) && !overwrite {
            return Err(OutputError::Occupied { path: self.0.clone() });
        }
        if holds_results {
            self.remove(FILES.iter().map(|name| self.path(name)))?;
            self.remove(self.numbered(|_| true))?;
            self.remove(self.leftovers())?;
        }
        for folder in [self.0.clone(), self.path(names::PICTURES), self.path(names::SKINS)] {
            fs::create_dir_all(&folder).map_err(OutputError::write(&folder))?;
        }
        Ok(())
    }

    /// Takes back what was written after increment `last`, and how the run ended: its last picture too, if it was not the turn of
    /// this increment, that is, if `every` does not divide its number; and what a run that was killed left of the file it was writing.
    pub fn rewind(&self, last: usize, every: usize) -> Result<(), OutputError> {
        self.remove([names::SUMMARY, names::REPORT].map(|name| self.path(name)))?;
        self.remove(self.leftovers())?;
        self.remove(self.numbered(|number| number > last || !number.is_multiple_of(every)))
    }

    /// Pictures and skins whose number is asked for.
    fn numbered(&self, which: impl Fn(usize) -> bool) -> Vec<PathBuf> {
        let mut found = Vec::new();
        for (folder, extension) in [(names::PICTURES, "vtu"), (names::SKINS, "json")] {
            let entries = fs::read_dir(self.path(folder)).into_iter().flatten().flatten();
            let number = |path: &Path| path.file_stem()?.to_str()?.parse::<usize>().ok();
            let own = |path: &PathBuf| {
                path.extension().is_some_and(|found| found == extension) && number(path).is_some_and(&which)
            };
            found.extend(entries.map(|entry| entry.path()).filter(own));
        }
        found
    }

    /// Temporary files of results that were being written when their run was killed.
    fn leftovers(&self) -> Vec<PathBuf> {
        let is_own: fn(&str) -> bool = |target| FILES.contains(&target) || target == names::DECK;
        let folders = [
            (self.0.clone(), is_own),
            (self.path(names::PICTURES), |target| target.ends_with(".vtu")),
            (self.path(names::SKINS), |target| target.ends_with(".json")),
        ];
        let mut found = Vec::new();
        for (folder, belongs) in folders {
            let entries = fs::read_dir(folder).into_iter().flatten().flatten();
            let is_leftover = |path: &PathBuf| {
                let name = path.file_name().and_then(|name| name.to_str());
                name.and_then(file::target_of_temporary).is_some_and(belongs)
            };
            found.extend(entries.map(|entry| entry.path()).filter(is_leftover));
        }
        found
    }

    fn remove(&self, paths: impl IntoIterator<Item = PathBuf>) -> Result<(), OutputError> {
        let mut present = paths.into_iter().filter(|path| path.exists());
        present.try_for_each(|path| fs::remove_file(&path).map_err(OutputError::write(&path)))
    }

    /// Writes a whole file, or leaves what there was.
    pub fn write(
        &self,
        name: &str,
        fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        let path = self.path(name);
        file::replace(&path, |writer| fill(writer)).map_err(OutputError::write(&path))
    }

    /// Writes a document. What cannot be written as JSON is an error like a full disk.
    pub fn write_json(&self, name: &str, document: &impl Serialize) -> Result<(), OutputError> {
        self.write(name, |writer| Ok(serde_json::to_writer(writer, document)?))
    }

    /// Appends whole lines to a table, or nothing.
    pub fn append(&self, name: &str, lines: &str) -> Result<(), OutputError> {
        let path = self.path(name);
        let append = || {
            let mut table = OpenOptions::new().append(true).open(&path)?;
            let before = table.metadata()?.len();
            let written = table.write_all(lines.as_bytes()).and_then(|()| table.sync_data());
            if written.is_err() {
                // Shortening a file needs no space.
                let _ = table.set_len(before);
            }
            written
        };
        append().map_err(OutputError::write(&path))
    }
}
