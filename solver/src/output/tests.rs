//! What a run warns of.

use std::fs;
use std::path::PathBuf;

use super::{Summary, Watcher, names, read_json};
use crate::contact::Beginning;
use crate::solve::{SolveOptions, solve};
use crate::statics::{Control, Failure, IncrementRecord, IterationRecord};

/// A block that is pressed onto a floor and comes back; a second floor is far below.
const PRESSED: &str = r#"
[materials.soft]
young = 1000.0
poisson = 0.3

[parts.block]
shape = "box"
origin = [0.5, 0.5, 0.05]
size = [2.0, 1.0, 1.0]
divisions = [3, 2, 2]
material = "soft"

[parts.floor]
shape = "rigid-plane"
size = [3.0, 2.0]
divisions = [6, 4]

[parts.cellar]
shape = "rigid-plane"
size = [3.0, 2.0]
divisions = [6, 4]
translate = [0.0, 0.0, -4.0]

[[boundary]]
nodes = ["floor", "cellar"]
fix = ["x", "y", "z"]

[[boundary]]
nodes = "block.z+"
translate = [0.0, 0.0, -0.1]
amplitude = [[0.0, 0.0], [0.5, 1.0], [1.0, 0.0]]

[[interface]]
name = "floor"
master = "floor"
slave = "block.z-"
penalty = 500.0

[[interface]]
name = "cellar"
master = "cellar"
slave = "block.z-"
penalty = 500.0

[time]
increment = 0.25
"#;

/// A directory that is removed in the end.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("diffuse-contact-{}-{name}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Notes how it begins, and may stop.
#[derive(Default)]
struct Notes {
    beginnings: Vec<Beginning>,
    stop_after: Option<usize>,
}

impl Watcher for Notes {
    fn start(&mut self, interfaces: &[Beginning]) {
        self.beginnings.extend_from_slice(interfaces);
    }

    fn iteration(&mut self, _: &IterationRecord) {}

    fn cut_back(&mut self, _: f64, _: f64, _: &Failure) -> Control {
        Control::Continue
    }

    fn increment(&mut self, record: &IncrementRecord) -> Control {
        if self.stop_after == Some(record.number) { Control::Stop } else { Control::Continue }
    }
}

fn run(scratch: &Scratch, deck: &str, restart: bool, stop_after: Option<usize>) -> (Notes, Summary) {
    let path = scratch.0.join("block.toml");
    fs::write(&path, deck).unwrap();
    let out = scratch.0.join("out");
    let options = SolveOptions { out: out.clone(), restart, overwrite: !restart, threads: 1 };
    let mut notes = Notes { stop_after, ..Notes::default() };
    let summary = solve(&path, &options, &mut notes).unwrap();
    assert_eq!(read_json::<Summary>(&out.join(names::SUMMARY)).unwrap(), summary);
    (notes, summary)
}

#[test]
fn an_interface_that_never_carries_force_is_named() {
    let scratch = Scratch::new("idle");
    let (_, whole) = run(&scratch, PRESSED, false, None);
    assert_eq!(whole.contact_force, [0.0; 3], "it has come back");
    assert_eq!(whole.interfaces_without_force, ["cellar"]);
    // A restart knows of what was before it: here the contact is over.
    let (_, stopped) = run(&scratch, PRESSED, false, Some(3));
    assert_eq!((stopped.increments, stopped.interfaces_without_force), (3, vec!["cellar".to_owned()]));
    let (notes, whole) = run(&scratch, PRESSED, true, None);
    assert!(notes.beginnings.is_empty(), "it had begun");
    assert_eq!((whole.increments, whole.interfaces_without_force), (4, vec!["cellar".to_owned()]));
    let (_, none) = run(&scratch, &format!("contact = \"none\"\n{PRESSED}"), false, None);
    assert!(none.interfaces_without_force.is_empty(), "there is none");
}

#[test]
fn overlap_at_the_start_is_told() {
    let scratch = Scratch::new("overlap");
    let beginnings = |height: &str| {
        let (notes, _) = run(&scratch, &PRESSED.replace("0.5, 0.05]", height), false, Some(1));
        notes.beginnings
    };
    let names: Vec<String> = beginnings("0.5, 0.05]").into_iter().map(|one| one.interface).collect();
    assert_eq!(names, ["floor", "cellar"]);
    for (height, overlap, deep) in [("0.5, 0.05]", 0.0, 0), ("0.5, -0.02]", 0.02, 0), ("0.5, -0.2]", 0.2, 12)]
    {
        let found = &beginnings(height)[0];
        assert_eq!((found.slaves, found.paired, found.deep), (12, 12, deep), "{found:?}");
        assert!((found.overlap - overlap).abs() < 1e-12, "{found:?}");
    }
    // A part of the block is beside the floor.
    let beside = beginnings("1.3, 0.05]");
    assert_eq!((beside[0].slaves, beside[0].paired), (12, 8), "{beside:?}");
}

/// A run that was killed while it wrote leaves files behind that belong to nobody.
#[test]
fn a_restart_removes_what_a_killed_run_left() {
    let scratch = Scratch::new("leftovers");
    run(&scratch, PRESSED, false, Some(1));
    let out = scratch.0.join("out");
    let of_the_run = [".state.json.123-4.tmp", "results/.00002.vtu.123-5.tmp", "skins/.00002.json.123-6.tmp"];
    let others = [".notes.txt.123-4.tmp", "results/.mine.tmp", ".state.json.swp"];
    of_the_run.iter().chain(&others).for_each(|name| fs::write(out.join(name), "half").unwrap());
    run(&scratch, PRESSED, true, None);
    assert!(of_the_run.iter().all(|name| !out.join(name).exists()));
    assert!(others.iter().all(|name| out.join(name).exists()), "they are the user's");
}
