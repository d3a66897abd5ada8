//! `solve` under interrupts and on a full disk.
#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::PROGRAM;
use crate::decks::{assert_same_results, block_in, failing, files, small_block_in, summary, timeless};
use crate::runs::{Run, Scratch, run, run_limited, run_without_threads};

/// Increments of a run that is interrupted: enough that the interrupt comes before the end.
const MANY: usize = 150;

fn start(deck: &str, out: &str) -> Child {
    let mut command = Command::new(PROGRAM);
    command.args(["solve", deck, "--out", out]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Waits until so many increments are in the table.
fn wait_for(out: &str, increments: usize, child: &mut Child) {
    let table = Path::new(out).join("history.csv");
    let begin = Instant::now();
    loop {
        let lines = fs::read_to_string(&table).map_or(0, |text| text.lines().count());
        if lines > increments {
            return;
        }
        assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        assert!(begin.elapsed() < Duration::from_secs(300), "it does nothing");
        sleep(Duration::from_millis(2));
    }
}

fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
}

#[test]
fn an_interrupted_run_is_whole_and_goes_on_to_the_same_end() {
    interrupt("solve-interrupt", &format!("{}\n[output]\nevery = 40", small_block_in(MANY)));
}

/// Where the faces are cut follows from positions: there is nothing to save.
#[test]
fn an_interrupted_run_over_faces_goes_on_to_the_same_end() {
    let deck = small_block_in(MANY).replace("refresh = \"increment\"", "integration = \"faces\"");
    assert!(deck.contains("faces"));
    interrupt("solve-interrupt-faces", &format!("{deck}\n[output]\nevery = 40"));
}

/// The history of friction, too, is that of the last increment that was saved.
#[test]
fn an_interrupted_run_with_friction_goes_on_to_the_same_end() {
    let deck = include_str!("../../examples/inclined_block.toml");
    let increment = format!("increment = {}\nfixed = true", 1.0 / MANY as f64);
    let faces = deck
        .replace("increment = 0.05", &increment)
        .replace("divisions = [8, 2, 4]", "divisions = [4, 1, 2]");
    interrupt("solve-interrupt-friction", &faces);
    #[cfg(feature = "friction")]
    interrupt("solve-interrupt-friction-nodes", &faces.replace("integration = \"faces\"", "areas = true"));
}

fn interrupt(name: &str, text: &str) {
    let scratch = Scratch::new(name);
    let deck = scratch.file("block.toml", text);
    let (whole, out) = (scratch.path("whole"), scratch.path("out"));
    assert_eq!(run(&["solve", &deck, "--out", &whole]).code, 0);

    let mut child = start(&deck, &out);
    wait_for(&out, 3, &mut child);
    for how in ["--restart", "--overwrite"] {
        run(&["solve", &deck, "--out", &out, how]).assert_refused(&[&out, "another run is writing there"]);
    }
    signal(&child, "-INT");
    let stopped: Run = child.wait_with_output().unwrap().into();
    assert_eq!(stopped.code, 130, "{stopped:?}");
    assert!(
        stopped.stderr.contains("ending after this increment") && stopped.stderr.contains("stopped at time")
    );
    let directory = Path::new(&out);
    let summary = summary(directory);
    let increments = summary["increments"].as_u64().unwrap() as usize;
    assert!((3..MANY).contains(&increments));
    assert_eq!((&summary["converged"], &summary["reason"]), (&false.into(), &"it was stopped".into()));
    assert_eq!(timeless(&directory.join("history.csv")).len(), increments + 1);
    // The increment it ended with is there to look at.
    assert!(directory.join(format!("results/{increments:05}.vtu")).exists());
    assert!(directory.join("report.html").exists());
    assert!(files(directory).iter().all(|name| name.extension().is_none_or(|end| end != "tmp")));

    // Go on, and be killed this time.
    let mut command = Command::new(PROGRAM);
    let mut child =
        command.args(["solve", &deck, "--out", &out, "--restart"]).stderr(Stdio::null()).spawn().unwrap();
    wait_for(&out, increments + 3, &mut child);
    signal(&child, "-KILL");
    child.wait().unwrap();
    assert!(!directory.join("summary.json").exists(), "nobody is told of an end that was not reached");
    let end = run(&["solve", &deck, "--out", &out, "--restart"]);
    assert_eq!(end.code, 0, "{end:?}");
    // But for what a killed writer may have left half done.
    let unfinished =
        |name: &Path| name.file_name().is_some_and(|name| name.to_string_lossy().ends_with(".tmp"));
    for name in files(directory).iter().filter(|name| unfinished(name)) {
        fs::remove_file(directory.join(name)).unwrap();
    }
    assert_same_results(Path::new(&whole), directory);
}

#[test]
fn a_second_interrupt_ends_at_once() {
    let scratch = Scratch::new("solve-interrupt-twice");
    let (deck, out) = (scratch.file("block.toml", &small_block_in(MANY)), scratch.path("out"));
    let mut child = start(&deck, &out);
    wait_for(&out, 1, &mut child);
    signal(&child, "-INT");
    signal(&child, "-INT");
    let stopped: Run = child.wait_with_output().unwrap().into();
    assert_eq!(stopped.code, 130, "{stopped:?}");
    let end = run(&["solve", &deck, "--out", &out, "--restart"]);
    assert_eq!(end.code, 0, "{end:?}");
    assert_eq!(summary(Path::new(&out))["increments"], MANY);
}

/// Of a million nodes the machine may or may not be capable; within 4 GB it is not.
#[cfg(target_os = "linux")]
#[test]
fn a_deck_that_is_too_large_for_the_memory_is_refused() {
    let scratch = Scratch::new("solve-memory");
    let deck = scratch.file("block.toml", &block_in(8).replace("[4, 2, 2]", "[100, 100, 100]"));
    let out = scratch.path("out");
    let script = format!("ulimit -v 4000000; exec '{PROGRAM}' solve '{deck}' --out '{out}' --threads 1");
    let refused: Run = Command::new("sh").args(["-c", &script]).output().unwrap().into();
    refused.assert_refused(&["divisions make 1030301 nodes", "about 19 GB of memory"]);
    assert!(!Path::new(&out).exists(), "nothing was written");
}

/// A rigid part of half a million nodes fits: only the name is wrong.
#[cfg(target_os = "linux")]
#[test]
fn rigid_parts_need_less_memory_than_deformable_ones() {
    let scratch = Scratch::new("solve-rigid-memory");
    let deck = block_in(8).replace("[10, 3]", "[700, 700]").replace("\"block.z-\"", "\"block.top\"");
    let (deck, out) = (scratch.file("block.toml", &deck), scratch.path("out"));
    let script = format!("ulimit -v 3000000; exec '{PROGRAM}' solve '{deck}' --out '{out}' --threads 1");
    let refused: Run = Command::new("sh").args(["-c", &script]).output().unwrap().into();
    refused.assert_refused(&["no surface is named \"block.top\""]);
}

#[test]
fn a_full_disk_ends_the_run_with_what_there_is_whole() {
    let scratch = Scratch::new("solve-full");
    let deck = scratch.file("block.toml", &block_in(8));
    let (whole, out) = (scratch.path("whole"), scratch.path("out"));
    assert_eq!(run(&["solve", &deck, "--out", &whole]).code, 0);
    // State and pictures find room; the table of iterations grows beyond it. The report is too large in any case.
    let sizes = files(Path::new(&whole));
    let size = |name: &Path| fs::metadata(Path::new(&whole).join(name)).unwrap().len();
    let others = sizes.iter().filter(|name| name.as_path() != Path::new("report.html"));
    let largest = others.map(|name| size(name)).max().unwrap();
    let full = run_limited(largest as usize / 512 + 3, &format!("solve '{deck}' --out '{out}'"));
    assert_eq!(full.code, 1, "{full:?}");
    let sentence = full.stderr.lines().last().unwrap();
    assert!(
        sentence.contains("report.html: cannot be written: ") && !sentence.contains("os error"),
        "{sentence}"
    );
    assert_eq!(summary(Path::new(&out))["converged"], true);
    assert!(!Path::new(&out).join("report.html").exists());

    // Too little for the state of the first increment.
    let tight = scratch.path("tight");
    let full = run_limited(8, &format!("solve '{deck}' --out '{tight}'"));
    assert_eq!(full.code, 1, "{full:?}");
    assert_eq!(full.stderr.lines().last().unwrap().matches("cannot be written").count(), 1, "{full:?}");
    assert!(full.stderr.contains(&tight), "{full:?}");
    for name in files(Path::new(&tight)) {
        assert!(name.extension().is_none_or(|end| end != "tmp"), "{name:?}");
    }
    let again = run(&["solve", &deck, "--out", &tight, "--overwrite"]);
    assert_eq!(again.code, 0, "{again:?}");
    assert_same_results(Path::new(&whole), Path::new(&tight));
}

/// The table of iterations is the first to find no room, in the middle of the run.
#[test]
fn a_disk_that_fills_up_on_the_way_keeps_the_increments_before() {
    let scratch = Scratch::new("solve-filling");
    let deck = scratch.file("block.toml", &format!("{}\n[output]\nevery = 1000", small_block_in(MANY)));
    let (whole, out) = (scratch.path("whole"), scratch.path("out"));
    assert_eq!(run(&["solve", &deck, "--out", &whole]).code, 0);
    let size = |name: &str| fs::metadata(Path::new(&whole).join(name)).unwrap().len();
    let fixed = ["state.json", "results/00000.vtu", "skins/00000.json", "skins/skin.json"].map(size);
    let room = 1024 * (fixed.iter().max().unwrap() / 1024 + 1);
    assert!(size("iterations.csv") > 2 * room || size("history.csv") > 2 * room, "{fixed:?}");
    let full = run_limited(room as usize / 512, &format!("solve '{deck}' --out '{out}'"));
    assert_eq!(full.code, 1, "{full:?}");
    let sentence = full.stderr.lines().last().unwrap();
    assert!(sentence.contains(".csv: cannot be written: "), "{sentence}");
    let history = timeless(&Path::new(&out).join("history.csv"));
    let known = timeless(&Path::new(&whole).join("history.csv"));
    assert!(history.len() > 3 && history.len() < known.len());
    // Whole lines only, and those of an undisturbed run.
    assert_eq!(history, known[..history.len()]);
    let end = run(&["solve", &deck, "--out", &out, "--restart"]);
    assert_eq!(end.code, 0, "{end:?}");
    assert_eq!(timeless(&Path::new(&out).join("history.csv")), known);
    let states = [&whole, &out].map(|directory| fs::read(Path::new(directory).join("state.json")).unwrap());
    assert!(states[0] == states[1]);
}

/// A pipe would wait for somebody to write into it.
#[test]
fn a_restart_in_what_is_no_directory_is_refused_at_once() {
    let scratch = Scratch::new("restart-pipe");
    let (deck, pipe) = (scratch.file("block.toml", &block_in(2)), scratch.path("pipe"));
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let mut child = Command::new(PROGRAM)
        .args(["solve", &deck, "--out", &pipe, "--restart"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begin = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begin.elapsed() > Duration::from_secs(60) {
            child.kill().unwrap();
            panic!("it waits");
        }
        sleep(Duration::from_millis(5));
    }
    let refused: Run = child.wait_with_output().unwrap().into();
    refused.assert_refused(&[&pipe, "no results to go on from"]);
}

/// Where no thread can be started the calling one does the work.
#[cfg(target_os = "linux")]
#[test]
fn without_threads_one_does_the_work() {
    let scratch = Scratch::new("threadless");
    let deck = scratch.file("block.toml", &block_in(2));
    let (whole, out) = (scratch.path("whole"), scratch.path("out"));
    assert_eq!(run(&["solve", &deck, "--out", &whole, "--threads", "1"]).code, 0);
    let solved = run_without_threads(&["solve", &deck, "--out", &out]);
    assert_eq!(solved.code, 0, "{solved:?}");
    assert!(solved.stderr.contains("note: no threads can be started"), "{solved:?}");
    assert_same_results(Path::new(&whole), Path::new(&out));
    let solved = run_without_threads(&["solve", &deck, "--out", &out, "--overwrite", "--threads", "1"]);
    assert_eq!(solved.code, 0, "{solved:?}");
    let refused = run_without_threads(&["solve", &deck, "--out", &out, "--overwrite", "--threads", "2"]);
    refused.assert_refused(&["--threads 2"]);
    assert!(!refused.stderr.contains("os error"), "{refused:?}");
}

/// A run that fails and then finds no room for its report says both.
#[test]
fn the_second_reason_is_said_too() {
    let scratch = Scratch::new("solve-twice");
    let deck = scratch.file("fails.toml", &failing("[[0.0, 0.0], [0.5, 0.0], [1.0, 1.0]]"));
    let (whole, out) = (scratch.path("whole"), scratch.path("out"));
    assert_eq!(run(&["solve", &deck, "--out", &whole]).code, 1);
    let others = files(Path::new(&whole)).into_iter().filter(|name| name != Path::new("report.html"));
    let largest = others.map(|name| fs::metadata(Path::new(&whole).join(name)).unwrap().len()).max().unwrap();
    let failed = run_limited(largest as usize / 512 + 3, &format!("solve '{deck}' --out '{out}'"));
    assert_eq!(failed.code, 1, "{failed:?}");
    let sentence = failed.stderr.lines().last().unwrap();
    assert!(sentence.contains("no convergence after time 0.5"), "{sentence}");
    assert!(
        sentence.contains("; and then ") && sentence.contains("report.html: cannot be written"),
        "{sentence}"
    );
}
