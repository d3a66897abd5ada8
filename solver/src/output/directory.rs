//! A directory of results: files that are whole, tables that grow by whole lines.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use diffuse_contact_mesh::file;
use serde::{Deserialize, Serialize};

use super::{OutputError, names, seal};

/// Files of a directory of results besides those in its folders; the deck, which may be the user's own, is not among them.
const FILES: [&str; 8] = [
    names::STATE,
    names::SUMMARY,
    names::HISTORY,
    names::ITERATIONS,
    names::SERIES,
    names::POINT_SERIES,
    names::FAILED,
    names::REPORT,
];

/// Folders of numbered files. That of the points is made when there are some.
const FOLDERS: [&str; 3] = [names::PICTURES, names::POINTS, names::SKINS];

fn extension(folder: &str) -> &'static str {
    if folder == names::SKINS { "json" } else { "vtu" }
}

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
        // Opening anything else may wait: a pipe does, for somebody to write into it.
        if !path.is_dir() {
            return Ok(Self(None));
        }
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
        let is_own = !holds_results || self.is_deck_changed();
        if is_own && path.exists() && !self.holds_deck(deck) {
            // No run wrote it: it is the user's own.
            return Err(OutputError::ForeignDeck { path });
        }
        if holds_results && !self.is_begun(deck) && !overwrite {
            let path = self.0.clone();
            let is_restartable = self.path(names::STATE).exists();
            return Err(if is_restartable {
                OutputError::Occupied { path }
            } else {
                OutputError::Remains { path }
            });
        }
        self.clean()?;
        if holds_results {
            self.refuse_links()?;
            self.remove(FILES.iter().map(|name| self.path(name)))?;
            self.remove(self.numbered(|_| true))?;
        }
        for folder in [self.0.clone(), self.path(names::PICTURES), self.path(names::SKINS)] {
            fs::create_dir_all(&folder).map_err(OutputError::write(&folder))?;
        }
        Ok(())
    }

    /// Whether a run of this deck began here and ended before its first state was whole. It wrote the start alone, which the next
    /// run writes again: there is nothing to protect.
    pub fn is_begun(&self, deck: &str) -> bool {
        let is_empty =
            |table| fs::read_to_string(self.path(table)).map_or(true, |text| text.lines().count() <= 1);
        self.holds_deck(deck)
            && ![names::STATE, names::SUMMARY, names::REPORT].iter().any(|name| self.path(name).exists())
            && [names::HISTORY, names::ITERATIONS].into_iter().all(is_empty)
            && self.numbered(|number| number > 0).is_empty()
    }

    fn holds_deck(&self, deck: &str) -> bool {
        fs::read(self.path(names::DECK)).is_ok_and(|text| text == deck.as_bytes())
    }

    /// Whether the deck is none that the results are of. A state that cannot be read, or that an earlier version wrote, does not say.
    fn is_deck_changed(&self) -> bool {
        #[derive(Deserialize)]
        struct Written {
            deck: Option<String>,
        }
        let written = super::read_json::<Written>(&self.path(names::STATE)).ok().and_then(|state| state.deck);
        let present = fs::read_to_string(self.path(names::DECK)).ok();
        written.zip(present).is_some_and(|(written, present)| written != seal::digest(&present))
    }

    /// A folder that is a link leads to where others may keep their files.
    fn refuse_links(&self) -> Result<(), OutputError> {
        for folder in FOLDERS {
            let path = self.path(folder);
            let is_link = path.symlink_metadata().is_ok_and(|found| found.is_symlink());
            if is_link && !self.numbered_in(folder, |_| true).is_empty() {
                return Err(OutputError::Linked { path });
            }
        }
        Ok(())
    }

    /// Whether a file belongs to the results, the report apart.
    pub fn owns(&self, path: &Path) -> bool {
        let resolved = |path: &Path| {
            let beside = || Some(fs::canonicalize(path.parent()?).ok()?.join(path.file_name()?));
            fs::canonicalize(path).ok().or_else(beside)
        };
        // A bare name has an empty parent, which names no directory.
        let path = if path.is_absolute() { path.to_path_buf() } else { Path::new(".").join(path) };
        let (Some(directory), Some(path)) = (resolved(&self.0), resolved(&path)) else { return false };
        let Ok(name) = path.strip_prefix(&directory) else { return false };
        let is_file = |file: &&str| name == Path::new(file);
        let mut files = FILES.iter().filter(|&&file| file != names::REPORT).chain([&names::DECK]);
        files.any(is_file) || FOLDERS.iter().any(|folder| name.starts_with(folder))
    }

    /// Takes back what was written after increment `last`, and how the run ended: its last picture too, if it was not the turn of
    /// this increment, that is, if `every` does not divide its number.
    pub fn rewind(&self, last: usize, every: usize) -> Result<(), OutputError> {
        self.remove([names::SUMMARY, names::FAILED, names::REPORT].map(|name| self.path(name)))?;
        self.remove(self.numbered(|number| number > last || !number.is_multiple_of(every)))
    }

    /// Length of a table, bytes; `None` if it cannot be read.
    pub fn length(&self, name: &str) -> Option<u64> {
        fs::metadata(self.path(name)).ok().map(|data| data.len())
    }

    /// Takes back what was appended to a table of this length, as far as it can be: shortening a file needs no space.
    pub fn shorten(&self, name: &str, length: Option<u64>) {
        let Some(length) = length else { return };
        let _ = OpenOptions::new().write(true).open(self.path(name)).and_then(|table| table.set_len(length));
    }

    /// Pictures and skins whose number is asked for.
    fn numbered(&self, which: impl Fn(usize) -> bool) -> Vec<PathBuf> {
        FOLDERS.iter().flat_map(|folder| self.numbered_in(folder, &which)).collect()
    }

    /// Those of one folder. Others than the program's own, such as `777.vtu`, have other names: it writes five digits at least.
    fn numbered_in(&self, folder: &str, which: impl Fn(usize) -> bool) -> Vec<PathBuf> {
        let extension = extension(folder);
        let entries = fs::read_dir(self.path(folder)).into_iter().flatten().flatten();
        let is_own = |path: &PathBuf| {
            let number = path.file_stem().and_then(|stem| stem.to_str()?.parse::<usize>().ok());
            number.is_some_and(|number| {
                which(number) && path.file_name() == Some(format!("{number:05}.{extension}").as_ref())
            })
        };
        entries.map(|entry| entry.path()).filter(is_own).collect()
    }

    /// Removes what runs that were killed left of the files they were writing.
    pub fn clean(&self) -> Result<(), OutputError> {
        self.remove(self.leftovers())
    }

    /// Temporary files of results that were being written when their run was killed.
    fn leftovers(&self) -> Vec<PathBuf> {
        let of = |folder: PathBuf, belongs: &dyn Fn(&str) -> bool| -> Vec<PathBuf> {
            let entries = fs::read_dir(folder).into_iter().flatten().flatten();
            let is_leftover = |path: &PathBuf| {
                let name = path.file_name().and_then(|name| name.to_str());
                name.and_then(file::target_of_temporary).is_some_and(belongs)
            };
            entries.map(|entry| entry.path()).filter(is_leftover).collect()
        };
        let mut found = of(self.0.clone(), &|target| FILES.contains(&target) || target == names::DECK);
        for folder in FOLDERS {
            let ending = format!(".{}", extension(folder));
            found.extend(of(self.path(folder), &|target| target.ends_with(&ending)));
        }
        found
    }

    /// Makes one of its folders.
    pub fn make(&self, folder: &str) -> Result<(), OutputError> {
        let path = self.path(folder);
        fs::create_dir_all(&path).map_err(OutputError::write(&path))
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
