//! `solve --restart`: what it goes on from, and what it refuses.

use std::fs;
use std::path::Path;

use crate::decks::{BLOCK, assert_same_results, block_in, contents, failing, forget_deck};
use crate::runs::{Scratch, run};

/// Beside its deck a run has that for its copy: a change is found by what the state says of the text.
#[test]
fn a_changed_deck_is_not_gone_on_from_in_its_own_directory() {
    let scratch = Scratch::new("solve-beside");
    let (deck, out) = (scratch.file("deck.toml", &block_in(2)), scratch.path(""));
    assert_eq!(run(&["solve", &deck, "--out", &out]).code, 0);
    let restart = || run(&["solve", &deck, "--out", &out, "--restart"]);
    assert_eq!(restart().code, 0, "there is nothing left to do");
    scratch.file("deck.toml", &block_in(3));
    restart().assert_refused(&[&out, "changed"]);
    // An earlier version said nothing of the text.
    forget_deck(Path::new(&out));
    assert_eq!(restart().code, 0);
}

#[test]
fn a_finished_run_is_restarted_to_what_it_is() {
    let scratch = Scratch::new("solve-finished");
    let deck = scratch.file("block.toml", &block_in(3));
    let (one, other) = (scratch.path("one"), scratch.path("other"));
    assert_eq!(run(&["solve", &deck, "--out", &one]).code, 0);
    assert_eq!(run(&["solve", &deck, "--out", &other]).code, 0);
    let before = contents(Path::new(&other));
    let again = run(&["solve", &deck, "--out", &other, "--restart"]);
    assert_eq!(again.code, 0, "{again:?}");
    assert_eq!(contents(Path::new(&other)), before, "there is nothing left to do");
    assert_same_results(Path::new(&one), Path::new(&other));
}

/// Whatever was written after the last state is taken back: tables, half a line, pictures.
#[test]
fn a_restart_takes_back_what_came_after_the_state() {
    let scratch = Scratch::new("solve-torn");
    let deck = scratch.file("block.toml", &block_in(5));
    let (whole, torn) = (scratch.path("whole"), scratch.path("torn"));
    assert_eq!(run(&["solve", &deck, "--out", &whole]).code, 0);
    assert_eq!(run(&["solve", &deck, "--out", &torn]).code, 0);
    // Back to the start, as it was before the first increment; the tables are ahead of it.
    let other = scratch.path("start");
    let nothing_done = scratch.file("failing.toml", &failing("[[0.0, 0.0], [1.0, 1.0]]"));
    assert_eq!(run(&["solve", &nothing_done, "--out", &other]).code, 1);
    let start = fs::read(Path::new(&other).join("state.json")).unwrap();
    fs::write(Path::new(&torn).join("state.json"), start).unwrap();
    forget_deck(Path::new(&torn));
    let history = Path::new(&torn).join("history.csv");
    let mut text = fs::read_to_string(&history).unwrap();
    text.push_str("0,0.1");
    fs::write(&history, text).unwrap();
    let again = run(&["solve", &deck, "--out", &torn, "--restart"]);
    assert_eq!(again.code, 0, "{again:?}");
    assert_same_results(Path::new(&whole), Path::new(&torn));
}

/// Two cubes one above the other, `width` wide along x.
fn tower(width: f64) -> String {
    let layer = |k: usize| {
        let corners = [[0.0, 0.0], [width, 0.0], [width, 1.0], [0.0, 1.0]].into_iter().enumerate();
        corners.map(move |(i, [x, y])| format!("{}, {x}, {y}, {k}.0\n", 4 * k + i + 1)).collect::<String>()
    };
    let nodes: String = (0..3).map(layer).collect();
    let elements = "1, 1, 2, 3, 4, 5, 6, 7, 8\n2, 5, 6, 7, 8, 9, 10, 11, 12\n";
    let sets = "*NSET, NSET=bottom\n1, 2, 3, 4\n*NSET, NSET=top\n9, 10, 11, 12\n";
    format!("*NODE\n{nodes}*ELEMENT, TYPE=C3D8\n{elements}{sets}")
}

const TOWER: &str = r#"
[materials.soft]
young = 1000.0
poisson = 0.3

[parts.tower]
file = "tower.inp"
material = "soft"

[[boundary]]
nodes = "tower.bottom"
fix = ["x", "y", "z"]

[[boundary]]
nodes = "tower.top"
translate = [0.0, 0.0, -0.2]

[time]
increment = 0.5
"#;

#[test]
fn a_restart_needs_the_mesh_it_began_with() {
    let scratch = Scratch::new("solve-mesh");
    let (deck, out) = (scratch.file("tower.toml", TOWER), scratch.path("out"));
    scratch.file("tower.inp", &tower(1.0));
    let restart = || run(&["solve", &deck, "--out", &out, "--restart"]);
    assert_eq!(run(&["solve", &deck, "--out", &out]).code, 0);
    assert_eq!(restart().code, 0);
    // As many nodes and elements, hardly elsewhere.
    scratch.file("tower.inp", &tower(1.0 + 1e-12));
    restart().assert_refused(&[&out, "another mesh"]);
    scratch.file("tower.inp", &tower(1.0).replace("top\n9, 10", "top\n10, 9"));
    assert_eq!(restart().code, 0, "the same set");
    scratch.file("tower.inp", &tower(1.0).replace("top\n9, 10, 11, 12", "top\n9, 10, 11"));
    let before = contents(Path::new(&out));
    restart().assert_refused(&[&out, "another mesh"]);
    assert_eq!(contents(Path::new(&out)), before, "nothing changed");
    // Nothing of an elastic body is written point by point.
    let state = fs::read_to_string(Path::new(&out).join("state.json")).unwrap();
    assert!(state.contains(r#""points":{"count":16,"yielded":[],"states":[]}"#), "{state}");
}

/// Where pictures are not of every increment, those of a run that was stopped, or killed, and went on are those of one that was not.
#[test]
fn a_restart_goes_on_with_the_series_of_pictures() {
    let scratch = Scratch::new("solve-series");
    // Half the time of the deck is a deck of its own, whose results are those of a run that ended there.
    let wish = "[output]\nevery = 3";
    let deck = scratch.file("block.toml", &format!("{BLOCK}\n{wish}"));
    let (whole, out) = (scratch.path("whole"), scratch.path("out"));
    assert_eq!(run(&["solve", &deck, "--out", &whole]).code, 0);
    let half =
        format!("{BLOCK}end = 0.5\n{wish}").replace("-0.2]", "-0.2]\namplitude = [[0.0, 0.0], [1.0, 1.0]]");
    let half = scratch.file("half.toml", &half);
    assert_eq!(run(&["solve", &half, "--out", &out]).code, 0);
    let directory = Path::new(&out);
    let picture = directory.join("results/00004.vtu");
    assert!(picture.exists(), "that of the end");
    fs::copy(&deck, directory.join("deck.toml")).unwrap();
    forget_deck(directory);
    assert_eq!(run(&["solve", &deck, "--out", &out, "--restart"]).code, 0);
    assert_same_results(Path::new(&whole), directory);

    // Killed after the last increment and before anything was made of it.
    for name in
        ["results/00008.vtu", "skins/00008.json", "skins/surfaces.json", "summary.json", "report.html"]
    {
        fs::remove_file(directory.join(name)).unwrap();
    }
    assert_eq!(run(&["solve", &deck, "--out", &out, "--restart"]).code, 0);
    assert_same_results(Path::new(&whole), directory);
}
