//! `solve`: what it leaves on disk, and how it ends.

use std::fs;
use std::path::Path;

use crate::decks::{BLOCK, assert_same_results, block_in, contents, failing, files, summary, timeless};
use crate::runs::{Scratch, run, run_in, run_with_input, run_with_instructions};

#[test]
fn a_deck_becomes_results() {
    let scratch = Scratch::new("solve");
    let (deck, out) = (scratch.file("block.toml", BLOCK), scratch.path("out"));
    let solved = run(&["solve", &deck, "--out", &out, "--verbose"]);
    assert_eq!((solved.code, solved.stdout.as_str()), (0, ""), "{solved:?}");
    assert!(
        solved.stderr.contains("increment    1  time 0.125     ")
            && solved.stderr.contains("converged at time 1: 8 increments, 0 cut-backs")
    );
    let out = Path::new(&out);
    let numbers = (0..=8).map(|k| format!("{k:05}"));
    let mut expected: Vec<String> = numbers.clone().map(|k| format!("results/{k}.vtu")).collect();
    expected.extend(numbers.map(|k| format!("skins/{k}.json")));
    let single = ["deck.toml", "history.csv", "iterations.csv", "report.html", "results.pvd", "state.json"];
    expected.extend(single.map(String::from));
    expected.extend(["skins/skin.json", "skins/surfaces.json", "summary.json"].map(String::from));
    expected.sort();
    let mut found: Vec<_> = files(out).iter().map(|path| path.to_str().unwrap().to_owned()).collect();
    found.sort();
    assert_eq!(found, expected);
    assert_eq!(fs::read_to_string(out.join("deck.toml")).unwrap(), BLOCK);

    let summary = summary(out);
    assert_eq!(summary["converged"], true);
    assert_eq!(summary["reason"], "");
    assert_eq!((&summary["increments"], &summary["cutbacks"]), (&8.into(), &0.into()));
    assert_eq!(summary["element"], "diffuse");
    assert!(summary["wall_s"].as_f64().unwrap() > 0.0);

    let history = timeless(&out.join("history.csv"));
    let names: Vec<&str> = history[0].split(',').collect();
    let column = |name: &str| {
        let k =
            names.iter().position(|other| *other == name).unwrap_or_else(|| panic!("{name} in {names:?}"));
        history[1..]
            .iter()
            .map(|row| row.split(',').nth(k).unwrap().parse::<f64>().unwrap())
            .collect::<Vec<_>>()
    };
    assert_eq!(history.len(), 9);
    assert_eq!(column("time")[7], 1.0);
    assert!((column("displacement_z:block.z+")[7] + 0.2).abs() < 1e-12);
    let last = |name| *column(name).last().unwrap();
    assert_eq!(Some(last("max_penetration")), summary["max_penetration"].as_f64());
    assert_eq!(Some(last("contact_force_z:floor")), summary["contact_force"][2].as_f64());
    assert!(last("contact_force_z:floor") > 10.0);
    assert!((last("reaction_z:block.z+") + last("contact_force_z:floor")).abs() < 1e-2);
    let iterations = timeless(&out.join("iterations.csv"));
    let total: f64 = column("iterations").iter().sum();
    assert_eq!(iterations[0], "increment,iteration,time,residual,relative,excess,allowed,active,step");
    // A residual before the first iteration, and one after each.
    assert_eq!(iterations.len() - 1, total as usize + 8);
    assert_eq!(summary["newton_iterations"], total as usize);

    let series = fs::read_to_string(out.join("results.pvd")).unwrap();
    assert_eq!(series.matches("<DataSet ").count(), 9);
    assert!(series.contains("timestep=\"0.125\" part=\"0\" file=\"results/00001.vtu\""), "{series}");
    let picture = fs::read(out.join("results/00008.vtu")).unwrap();
    let text = String::from_utf8_lossy(&picture);
    for name in [
        "displacement",
        "stress",
        "von_mises",
        "plastic_strain",
        "contact_gap",
        "contact_pressure",
        "contact_status",
        "contact_basis",
        "part",
    ] {
        assert!(text.contains(&format!("Name=\"{name}\"")), "{name}");
    }
}

#[test]
fn pictures_of_every_third_increment_and_the_last_and_no_stresses_if_so_wished() {
    let scratch = Scratch::new("solve-every");
    let wish = "[output]\nevery = 3\nstress = false\ncolour = \"pressure\"";
    let deck = scratch.file("block.toml", &format!("{BLOCK}\n{wish}"));
    let out = scratch.path("out");
    assert_eq!(run(&["solve", &deck, "--out", &out]).code, 0);
    let out = Path::new(&out);
    let pictures: Vec<_> = files(&out.join("results"));
    assert_eq!(pictures, ["00000.vtu", "00003.vtu", "00006.vtu", "00008.vtu"].map(std::path::PathBuf::from));
    let picture = fs::read(out.join("results/00008.vtu")).unwrap();
    let text = String::from_utf8_lossy(&picture);
    assert!(!text.contains("stress") && !text.contains("von_mises") && !text.contains("plastic_strain"));
    assert!(text.contains("contact_pressure"));
    let skin = fs::read_to_string(out.join("skins/skin.json")).unwrap();
    assert!(skin.ends_with("\"shown\":\"contact_pressure\"}"), "{skin}");
    let frame = fs::read_to_string(out.join("skins/00008.json")).unwrap();
    assert!(!frame.contains("von_mises") && frame.contains("contact_pressure"));
    // Without stresses there is no colour by them.
    let deck = scratch.file("block.toml", &format!("{BLOCK}\n[output]\nstress = false"));
    assert_eq!(run(&["solve", &deck, "--out", out.to_str().unwrap(), "--overwrite"]).code, 0);
    let skin = fs::read_to_string(out.join("skins/skin.json")).unwrap();
    assert!(skin.ends_with("\"shown\":\"displacement\"}"), "{skin}");
    assert_eq!(files(&out.join("results")).len(), 9);
}

#[test]
fn results_are_not_replaced_unasked() {
    let scratch = Scratch::new("solve-occupied");
    let (deck, out) = (scratch.file("block.toml", &block_in(2)), scratch.path("out"));
    assert_eq!(run(&["solve", &deck, "--out", &out]).code, 0);
    let before = contents(Path::new(&out));
    run(&["solve", &deck, "--out", &out]).assert_refused(&[
        &out,
        "holds results already",
        "--restart",
        "--overwrite",
    ]);
    run(&["solve", &deck, "--out", &out, "--restart", "--overwrite"])
        .assert_refused(&["--restart", "--overwrite"]);
    let other = scratch.file("other.toml", &block_in(3));
    run(&["solve", &other, "--out", &out, "--restart"]).assert_refused(&[&out, "another deck"]);
    assert_eq!(contents(Path::new(&out)), before, "nothing changed");
    // Files of the user's own are no results, and stay.
    fs::write(Path::new(&out).join("results/notes.txt"), "mine").unwrap();
    assert_eq!(run(&["solve", &other, "--out", &out, "--overwrite"]).code, 0);
    assert_eq!(summary(Path::new(&out))["increments"], 3);
    assert!(Path::new(&out).join("results/notes.txt").exists());
    // Nor is a file a place for results.
    let file = scratch.file("out.csv", "mine");
    run(&["solve", &deck, "--out", &file]).assert_refused(&[&file, "is a file", "out.csv.results"]);
    run(&["solve", &deck, "--out", &file, "--restart"]).assert_refused(&[&file, "is a file"]);
    // A deck that would be replaced by another is no place for results either.
    fs::create_dir(scratch.path("mine")).unwrap();
    fs::write(scratch.path("mine/deck.toml"), "precious").unwrap();
    for how in [None, Some("--overwrite")] {
        let arguments = ["solve", &deck, "--out", &scratch.path("mine")];
        run(&[&arguments[..], how.as_slice()].concat()).assert_refused(&["mine", "deck.toml"]);
        assert_eq!(fs::read_to_string(scratch.path("mine/deck.toml")).unwrap(), "precious");
    }
    // Nor is one that has results beside it and was changed since.
    fs::create_dir(scratch.path("beside")).unwrap();
    let (own, beside) = (scratch.file("beside/deck.toml", &block_in(2)), scratch.path("beside"));
    assert_eq!(run(&["solve", &own, "--out", &beside]).code, 0);
    let changed = format!("{}# precious\n", block_in(2));
    fs::write(&own, &changed).unwrap();
    run(&["solve", &other, "--out", &beside, "--overwrite"]).assert_refused(&["beside", "deck.toml"]);
    assert_eq!(fs::read_to_string(&own).unwrap(), changed);
    assert_eq!(run(&["solve", &own, "--out", &beside, "--overwrite"]).code, 0);
    assert_eq!(run(&["solve", &other, "--out", &beside, "--overwrite"]).code, 0, "a copy of what was solved");
}

#[test]
fn a_run_that_does_not_converge_says_so_and_keeps_what_there_is() {
    let scratch = Scratch::new("solve-diverged");
    // At rest up to half of the time.
    let deck = scratch.file(
        "fails.toml",
        &failing("[[0.0, 0.0], [0.5, 0.0], [1.0, 1.0]]").replace("0.5, 0.1]", "0.5, 0.11]"),
    );
    let out = scratch.path("out");
    let failed = run(&["solve", &deck, "--out", &out]);
    assert_eq!((failed.code, failed.stdout.as_str()), (1, ""), "{failed:?}");
    let sentence = failed.stderr.lines().last().unwrap();
    assert!(sentence.starts_with("error: no convergence after time 0.5: the residual is"), "{sentence}");
    assert!(sentence.contains("finished increments: 4, up to time 0.5"), "{sentence}");
    let out = Path::new(&out);
    let summary = summary(out);
    assert_eq!(summary["converged"], false);
    assert!(summary["reason"].as_str().unwrap().contains("no convergence after time 0.5"));
    assert_eq!((&summary["increments"], &summary["cutbacks"]), (&4.into(), &0.into()));
    // One linear solution for each increment at rest, and for the one that failed.
    assert_eq!(summary["newton_iterations"], 5);
    assert_eq!(timeless(&out.join("history.csv")).len(), 5);
    assert!(out.join("results/00004.vtu").exists() && !out.join("results/00005.vtu").exists());
    assert!(fs::read_to_string(out.join("report.html")).unwrap().contains("no convergence after time 0.5"));
    // A restart tries the same again.
    let again = run(&["solve", &deck, "--out", out.to_str().unwrap(), "--restart"]);
    assert_eq!(again.code, 1, "{again:?}");
    assert_eq!(self::summary(out)["newton_iterations"], 5);
}

#[test]
fn what_cannot_be_used_is_refused_in_a_sentence() {
    let scratch = Scratch::new("solve-refused");
    let (out, absent) = (scratch.path("out"), scratch.path("absent.toml"));
    let refused = |text: &str, parts: &[&str]| {
        let deck = scratch.file("deck.toml", text);
        run(&["solve", &deck, "--out", &out]).assert_refused(parts);
        assert!(!Path::new(&out).exists(), "nothing was written");
    };
    run(&["solve", &absent, "--out", &out]).assert_refused(&["absent.toml"]);
    refused(&BLOCK.replace("penalty", "penality"), &["penality", "penalty", "line"]);
    refused(&BLOCK.replace("poisson = 0.3", "poisson = 0.5"), &["poisson"]);
    refused(&BLOCK.replace("young = 1000.0", "young = nan"), &["young"]);
    refused(&BLOCK.replace("increment = 0.125", "increment = 2.0"), &["increment"]);
    refused(&BLOCK.replace("[4, 2, 2]", "[4, 2]"), &["divisions"]);
    refused(&BLOCK.replace("\"block.z-\"", "\"block.top\""), &["block.top"]);
    let shape = "shape = \"box\"\norigin = [1.0, 0.5, 0.1]\nsize = [2.0, 1.0, 1.0]\ndivisions = [4, 2, 2]";
    assert!(BLOCK.contains(shape));
    refused(&BLOCK.replace(shape, "file = \"absent.inp\""), &["absent.inp"]);
    refused("title = ", &["deck.toml"]);
    refused("", &["deck.toml", "nothing in the deck"]);
    refused("# later\n\n", &["deck.toml", "nothing in the deck"]);
    let deck = scratch.file("block.toml", BLOCK);
    run(&["solve", &deck, "--out", &out, "--restart"]).assert_refused(&[&out, "no results"]);
    run(&["solve", &deck, "--threads", "0"]).assert_refused(&["--threads"]);
    run(&["solve"]).assert_refused(&["DECK"]);
    let file = scratch.file("file", "");
    run(&["solve", &deck, "--out", &file]).assert_refused(&[&file]);
}

#[test]
fn damaged_results_are_not_gone_on_from() {
    let scratch = Scratch::new("solve-damaged");
    let (deck, out) = (scratch.file("block.toml", &block_in(2)), scratch.path("out"));
    assert_eq!(run(&["solve", &deck, "--out", &out]).code, 0);
    let state = Path::new(&out).join("state.json");
    let whole = fs::read_to_string(&state).unwrap();
    let no_number = whole.replacen("\"time\":1.0", "\"time\":null", 1);
    for damaged in [&whole[..whole.len() / 2], "", "{}", &no_number] {
        fs::write(&state, damaged).unwrap();
        run(&["solve", &deck, "--out", &out, "--restart"]).assert_refused(&["state.json", "line"]);
    }
    // A state of another model: sound, but not of this one.
    let restart_with = |change: &dyn Fn(&mut serde_json::Value)| {
        let mut other: serde_json::Value = serde_json::from_str(&whole).unwrap();
        // As an earlier version wrote it.
        assert!(other.as_object_mut().unwrap().remove("checksum").is_some());
        change(&mut other);
        fs::write(&state, other.to_string()).unwrap();
        run(&["solve", &deck, "--out", &out, "--restart"])
    };
    for (list, what) in [("positions", "nodes"), ("multipliers", "passes")] {
        let cut = restart_with(&|other| drop(other["state"][list].as_array_mut().unwrap().pop()));
        cut.assert_refused(&[what]);
    }
    restart_with(&|other| other["state"]["points"]["count"] = 127.into())
        .assert_refused(&["integration points"]);
    restart_with(&|other| other["state"]["points"]["count"] = u64::MAX.into())
        .assert_refused(&["state.json", "points"]);
    let nowhere =
        serde_json::json!({"nodes": [1000], "gap": [0.0], "pressure": [0.0], "status": [3], "basis": [2]});
    restart_with(&|other| other["pending"] = nowhere.clone()).assert_refused(&["state.json", "nodes"]);
    restart_with(&|other| other["model"] = "0".into()).assert_refused(&["another mesh"]);
    restart_with(&|other| other["more"] = 0.into()).assert_refused(&["state.json", "unknown field `more`"]);
    for (field, value, what) in [
        ("time", serde_json::json!(-1.0), "time"),
        ("time", 2.0.into(), "time"),
        ("time", 0.75.into(), "time"),
        ("length", (-1.0).into(), "length of an increment"),
        ("increments", 1_000_000_000.into(), "history.csv"),
        ("cutbacks", u64::MAX.into(), "number of cut-backs"),
        ("iterations", u64::MAX.into(), "number of iterations"),
    ] {
        restart_with(&|other| other["state"][field] = value.clone()).assert_refused(&[what]);
    }
    assert!(Path::new(&out).join("summary.json").exists(), "nothing else was touched");
}

#[test]
fn the_directory_is_named_after_the_deck_by_default() {
    let scratch = Scratch::new("solve-default");
    scratch.file("block.toml", &block_in(2));
    let solved = run_in(&scratch, &["solve", "block.toml"]);
    assert_eq!(solved.code, 0, "{solved:?}");
    assert_eq!(scratch.names(), ["block.results", "block.toml"]);
}

#[test]
fn one_word_changes_the_element_and_the_number_of_threads_changes_nothing_here() {
    let scratch = Scratch::new("solve-element");
    let deck = scratch.file("classic.toml", &format!("contact = \"node-to-facet\"\n{}", block_in(4)));
    let (one, two) = (scratch.path("one"), scratch.path("two"));
    assert_eq!(run(&["solve", &deck, "--out", &one, "--threads", "1"]).code, 0);
    assert_eq!(run(&["solve", &deck, "--out", &two, "--threads", "2"]).code, 0);
    assert_eq!(summary(Path::new(&one))["element"], "node-to-facet");
    assert_same_results(Path::new(&one), Path::new(&two));
}

#[test]
fn a_deck_comes_from_standard_input_too() {
    let scratch = Scratch::new("solve-stdin");
    let (named, piped) = (scratch.path("named"), scratch.path("piped"));
    let deck = scratch.file("block.toml", &block_in(2));
    assert_eq!(run(&["solve", &deck, "--out", &named]).code, 0);
    let solved = run_with_input(&["solve", "-", "--out", &piped], &block_in(2));
    assert_eq!(solved.code, 0, "{solved:?}");
    assert_same_results(Path::new(&named), Path::new(&piped));
    run_with_input(&["solve", "-", "--out", &piped], "tilte = 1")
        .assert_refused(&["standard input, line 1: "]);
}

#[test]
fn a_directory_is_no_deck() {
    let scratch = Scratch::new("solve-directory");
    run(&["solve", &scratch.path("")]).assert_refused(&["cannot be read: it is a directory"]);
}

/// Names of interfaces are printed as a run begins.
#[test]
fn names_of_interfaces_do_not_speak_to_the_terminal() {
    let scratch = Scratch::new("solve-names");
    let hostile = "\\u001B[2J\\nerror: forged";
    let deck = scratch.file("block.toml", &block_in(2).replace("\"floor\"", &format!("\"{hostile}\"")));
    let solved = run(&["solve", &deck, "--out", &scratch.path("out")]);
    assert_eq!(solved.code, 0, "{solved:?}");
    assert!(solved.stderr.contains("forged"), "{solved:?}");
    assert!(
        !solved.stderr.contains('\u{1b}') && !solved.stderr.lines().any(|line| line.starts_with("error"))
    );
}

/// A digit is another one: the text is sound JSON, and another state.
#[test]
fn a_state_that_is_not_what_was_written_is_not_gone_on_from() {
    let scratch = Scratch::new("solve-checksum");
    let (deck, out) = (scratch.file("block.toml", &block_in(2)), scratch.path("out"));
    assert_eq!(run(&["solve", &deck, "--out", &out]).code, 0);
    let state = Path::new(&out).join("state.json");
    let whole = fs::read_to_string(&state).unwrap();
    let at = whole.find("\"positions\":[[").unwrap() + 17;
    let digit = at + whole[at..].find(|letter: char| ('1'..='8').contains(&letter)).unwrap();
    let mut other = whole.clone().into_bytes();
    other[digit] += 1;
    fs::write(&state, &other).unwrap();
    fs::remove_file(Path::new(&out).join("report.html")).unwrap();
    run(&["solve", &deck, "--out", &out, "--restart"]).assert_refused(&["state.json", "checksum"]);
    assert_eq!(fs::read(&state).unwrap(), other, "nothing was touched");
}

/// What the report would find in the end is found before the increments are solved.
#[test]
fn damaged_tables_and_skins_are_found_before_a_restart() {
    let scratch = Scratch::new("solve-tables");
    let out = scratch.path("out");
    let deck = scratch.file("failing.toml", &failing("[[0.0, 0.0], [0.5, 0.0], [1.0, 1.0]]"));
    assert_eq!(run(&["solve", &deck, "--out", &out]).code, 1);
    let restart = || run(&["solve", &deck, "--out", &out, "--restart"]);
    fn last_number(text: &str, by: &str) -> String {
        let end = text.trim_end().rfind(',').unwrap() + 1;
        format!("{}{by}\n", &text[..end])
    }
    type Damage = fn(&str) -> String;
    let damages: [(&str, Damage, &str); 8] = [
        ("history.csv", |text| last_number(text, "nan"), "`nan` is no finite number"),
        ("history.csv", |text| last_number(text, "inf"), "`inf` is no finite number"),
        ("history.csv", |text| last_number(text, "1.0,2.0"), "columns"),
        ("history.csv", |text| text.replacen("\n2,", "\nx,", 1), "increments of state.json"),
        ("iterations.csv", |text| last_number(text, "?"), "`?` is no finite number"),
        ("iterations.csv", |text| text.replacen("\n4,", "\n3,", 9), "increments of state.json"),
        ("skins/00002.json", |text| text.replacen("[[", "[[[", 1), "line 1"),
        (
            "skins/skin.json",
            |text| text.replacen("\"faces\":[[0", "\"faces\":[[1", 1),
            "skin of the deck's model",
        ),
    ];
    for (name, damage, expected) in damages {
        let path = Path::new(&out).join(name);
        let whole = fs::read_to_string(&path).unwrap();
        fs::write(&path, damage(&whole)).unwrap();
        let before = contents(Path::new(&out));
        let refused = restart();
        refused.assert_refused(&[name, expected]);
        assert!(contents(Path::new(&out)) == before, "{name}: nothing was touched");
        fs::write(&path, whole).unwrap();
    }
    assert_eq!(restart().code, 1);
}

#[test]
fn other_vector_instructions_are_told() {
    let scratch = Scratch::new("solve-isa");
    let out = scratch.path("out");
    let deck = scratch.file("failing.toml", &failing("[[0.0, 0.0], [0.5, 0.0], [1.0, 1.0]]"));
    assert_eq!(run(&["solve", &deck, "--out", &out]).code, 1);
    let state = Path::new(&out).join("state.json");
    let mut saved: serde_json::Value = serde_json::from_str(&fs::read_to_string(&state).unwrap()).unwrap();
    let restart = || run(&["solve", &deck, "--out", &out, "--restart"]).stderr;
    assert!(!restart().contains("instructions"));
    saved.as_object_mut().unwrap().remove("checksum");
    saved["instructions"] = "another machine's".into();
    fs::write(&state, saved.to_string()).unwrap();
    let said = restart();
    assert!(said.contains("note: the run was made with another machine's instructions so far"), "{said}");
}

#[test]
fn unknown_vector_instructions_are_refused() {
    run_with_instructions("nonsense", &["solve", "no.toml"]).assert_refused(&[
        "DIFFUSE_CONTACT_ISA",
        "\"nonsense\"",
        "scalar",
    ]);
}

/// A facet carries no quadratic surface by itself, and the run says so. One layer of them does, and with its images in two planes.
#[test]
fn a_facet_alone_has_the_linear_basis() {
    let scratch = Scratch::new("solve-symmetry");
    let layer = BLOCK
        .replace("divisions = [10, 3]", "divisions = [10, 1]")
        .replace("increment = 0.125", "increment = 1.0");
    let planes = r#"symmetry = ["y", { point = [0, 2, 0], normal = [0, -1, 0] }]"#;
    let mirrored = layer.replace("refresh = \"increment\"", planes);
    let said = |name: &str, deck: &str| {
        let (deck, out) = (scratch.file(&format!("{name}.toml"), deck), scratch.path(name));
        let solved = run(&["solve", &deck, "--out", &out]);
        assert_eq!(solved.code, 0, "{solved:?}");
        solved.stderr
    };
    let one = layer.replace("divisions = [10, 1]", "divisions = [1, 1]");
    assert!(said("one", &one).contains("15 of 15 slaves have the linear basis"));
    assert!(!said("layer", &layer).contains("linear basis"));
    assert!(!said("mirrored", &mirrored).contains("linear basis"));
    let crossed = layer.replace("refresh = \"increment\"", r#"symmetry = ["w"]"#);
    let refused = run(&["solve", &scratch.file("crossed.toml", &crossed), "--out", &scratch.path("crossed")]);
    assert!(refused.code == 2 && refused.stderr.contains("\"x\""), "{refused:?}");
}
