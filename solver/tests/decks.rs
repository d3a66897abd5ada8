//! Small decks, and results of theirs.

use std::fs;
use std::path::{Path, PathBuf};

/// A plastic block that is pressed into a rigid wave and pushed along it: a deck that takes about a second.
pub const BLOCK: &str = concat!(
    "title = \"Block & <wave>\"\n",
    include_str!("block_on_wave.toml"),
    "refresh = \"increment\"\n[time]\nincrement = 0.125\n"
);

/// The same in other increments.
pub fn block_in(increments: usize) -> String {
    BLOCK.replace("increment = 0.125", &format!("increment = {:?}", 1.0 / increments as f64))
}

/// Many increments of a smaller block, for runs that are interrupted.
pub fn small_block_in(increments: usize) -> String {
    block_in(increments).replace("divisions = [4, 2, 2]", "divisions = [2, 1, 1]")
}

/// A run that fails: one iteration is not enough.
pub fn failing(amplitude: &str) -> String {
    let moved = "translate = [0.3, 0.0, -0.2]";
    let minimum = "increment = 0.125\nminimum = 0.1\n[newton]\nmax_iterations = 1";
    BLOCK.replace(moved, &format!("{moved}\namplitude = {amplitude}")).replace("increment = 0.125", minimum)
}

/// Every file below a directory, by its path relative to it, sorted.
pub fn files(directory: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![directory.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                found.push(path.strip_prefix(directory).unwrap().to_path_buf());
            }
        }
    }
    found.sort();
    found
}

/// Bytes of every file, in the order of [`files`].
pub fn contents(directory: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    files(directory).into_iter().map(|name| (name.clone(), fs::read(directory.join(name)).unwrap())).collect()
}

/// A table without the column of wall time.
pub fn timeless(table: &Path) -> Vec<String> {
    let text = fs::read_to_string(table).unwrap();
    let skipped = text.lines().next().unwrap().split(',').position(|name| name == "wall_s");
    let line = |line: &str| {
        let words = line.split(',').enumerate().filter(|(k, _)| Some(*k) != skipped);
        words.map(|(_, word)| word).collect::<Vec<_>>().join(",")
    };
    text.lines().map(line).collect()
}

/// Asserts that two directories hold the same results, bit for bit; times of the clock and the report, which shows them, apart.
#[track_caller]
pub fn assert_same_results(one: &Path, other: &Path) {
    assert_eq!(files(one), files(other));
    assert_eq!(timeless(&one.join("history.csv")), timeless(&other.join("history.csv")));
    for name in files(one) {
        let timed =
            ["history.csv", "summary.json", "report.html"].iter().any(|timed| name == Path::new(timed));
        if !timed {
            assert!(
                fs::read(one.join(&name)).unwrap() == fs::read(other.join(&name)).unwrap(),
                "{name:?} differs"
            );
        }
    }
    let summaries = [one, other].map(|directory| {
        let mut summary = summary(directory);
        for timed in ["wall_s", "contact_share", "pairing_share", "linear_share"] {
            assert!(summary.as_object_mut().unwrap().remove(timed).unwrap().as_f64().unwrap() >= 0.0);
        }
        summary
    });
    assert_eq!(summaries[0], summaries[1]);
}

/// Makes a state one of an earlier version, which says nothing of its deck.
pub fn forget_deck(directory: &Path) {
    let path = directory.join("state.json");
    let mut state: serde_json::Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    let fields = state.as_object_mut().unwrap();
    fields.remove("checksum");
    fields.remove("deck");
    fs::write(&path, state.to_string()).unwrap();
}

pub fn summary(directory: &Path) -> serde_json::Value {
    serde_json::from_str(&fs::read_to_string(directory.join("summary.json")).unwrap()).unwrap()
}
