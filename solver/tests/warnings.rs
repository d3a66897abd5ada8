//! What a run warns of.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::PathBuf;

use diffuse_contact_solver::contact::{Beginning, Fallbacks};
use diffuse_contact_solver::output::{Summary, Watcher, names, read_history};
use diffuse_contact_solver::report::SurfaceSample;
use diffuse_contact_solver::solve::{SolveOptions, solve};
use diffuse_contact_solver::statics::{Control, Failure, IncrementRecord, IterationRecord};

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
pub(crate) struct Scratch(pub PathBuf);

impl Scratch {
    pub fn new(name: &str) -> Self {
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
pub(crate) struct Notes {
    beginnings: Vec<Beginning>,
    /// Interfaces of a run that goes on.
    resumed: Vec<String>,
    stop_after: Option<usize>,
}

impl Watcher for Notes {
    fn start(&mut self, interfaces: &[Beginning]) {
        self.beginnings.extend_from_slice(interfaces);
    }

    fn resume(&mut self, interfaces: &[Beginning], _: &BTreeMap<String, Fallbacks>) {
        self.resumed.extend(interfaces.iter().map(|beginning| beginning.interface.clone()));
    }

    fn iteration(&mut self, _: &IterationRecord) {}

    fn cut_back(&mut self, _: f64, _: f64, _: &Failure) -> Control {
        Control::Continue
    }

    fn increment(&mut self, record: &IncrementRecord) -> Control {
        if self.stop_after == Some(record.number) { Control::Stop } else { Control::Continue }
    }
}

pub(crate) fn run(
    scratch: &Scratch,
    deck: &str,
    restart: bool,
    stop_after: Option<usize>,
) -> (Notes, Summary) {
    let path = scratch.0.join("block.toml");
    fs::write(&path, deck).unwrap();
    let out = scratch.0.join("out");
    let options = SolveOptions::new(&out).with_restart(restart).with_overwrite(!restart);
    let mut notes = Notes { stop_after, ..Notes::default() };
    let summary = solve(&path, &options, &mut notes).unwrap();
    let written = fs::read_to_string(out.join(names::SUMMARY)).unwrap();
    assert_eq!(serde_json::from_str::<Summary>(&written).unwrap(), summary);
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
    assert_eq!(notes.resumed, ["floor", "cellar"]);
    assert_eq!((whole.increments, whole.interfaces_without_force), (4, vec!["cellar".to_owned()]));
    let (_, none) = run(&scratch, &format!("contact = \"none\"\n{PRESSED}"), false, None);
    assert!(none.interfaces_without_force.is_empty(), "there is none");
}

/// Nothing holds the plate along z: where the ball touches it there is noise.
#[test]
fn forces_of_noise_are_none() {
    let deck = r#"
[materials.steel]
young = 210000.0
poisson = 0.3

[parts.ball]
shape = "sphere"
radius = 5.0
keep = ["z-"]
divisions = [2, 2]
material = "steel"
translate = [0.0, 0.0, 5.0]

[parts.plate]
shape = "plate"
origin = [-8.0, -8.0, -3.0]
size = [16.0, 16.0, 3.0]
divisions = [8, 8, 1]
material = "steel"

[[boundary]]
nodes = "plate"
fix = ["x", "y"]

[[boundary]]
nodes = "ball.z0"
translate = [0.0, 0.0, -0.1]

[[interface]]
name = "ball on plate"
master = "plate.z+"
slave = "ball.outer"

[time]
increment = 0.25
"#;
    let scratch = Scratch::new("noise");
    let (_, summary) = run(&scratch, deck, false, None);
    assert_eq!(summary.interfaces_without_force, ["ball on plate"], "{:?}", summary.contact_force);
    assert!(summary.warnings.iter().any(|warning| warning.contains("never carried force")));
}

/// A sheet between two planes. In series with it the springs of a soft penalty take a known part of the energy.
#[test]
fn a_penalty_that_gives_way_beside_the_bodies_is_told() {
    let deck = |penalty: f64| {
        format!(
            r#"
materials.steel = {{ young = 200000.0, poisson = 0.0 }}
parts.sheet = {{ shape = "box", size = [4.0, 4.0, 0.5], divisions = [2, 2, 1], material = "steel" }}
parts.floor = {{ shape = "rigid-plane", size = [6.0, 6.0], divisions = [2, 2], translate = [-1.0, -1.0, 0.0] }}

[[boundary]]
nodes = "floor"
fix = ["x", "y", "z"]

[[boundary]]
nodes = "sheet.z+"
translate = [0.0, 0.0, -0.001]

[[interface]]
name = "floor"
master = "floor"
slave = "sheet.z-"
penalty = {penalty:?}
areas = true

[time]
increment = 1.0
"#
        )
    };
    let scratch = Scratch::new("soft");
    let (_, summary) = run(&scratch, &deck(1e6), false, None);
    // h/E of the sheet is 2.5e-6, 1/penalty of the springs 1e-6.
    let contact = summary.contacts["floor"];
    assert!((contact.penalty_share - 1.0 / 3.5).abs() < 1e-3, "{}", contact.penalty_share);
    assert!((contact.force[2] - contact.normal_force).abs() < 1e-9 * contact.normal_force, "{contact:?}");
    assert!((contact.normal_force - 16.0 * 1e-3 / 3.5e-6).abs() < 0.01 * contact.normal_force, "{contact:?}");
    assert!((contact.area - 16.0).abs() < 1e-12);
    let is_soft = |summary: &Summary| {
        summary
            .warnings
            .iter()
            .any(|warning| warning.contains("29 % of the elastic energy, by penetration at `floor`"))
    };
    assert!(is_soft(&summary), "{:?}", summary.warnings);
    // Over faces it is the same energy, and so it is after the load is gone.
    let (_, over_faces) =
        run(&scratch, &deck(1e6).replace("areas = true", "integration = \"faces\""), false, None);
    assert!((over_faces.contacts["floor"].penalty_share - 1.0 / 3.5).abs() < 1e-3 && is_soft(&over_faces));
    let back = "translate = [0.0, 0.0, -0.001]\namplitude = [[0.0, 0.0], [0.5, 1.0], [1.0, 0.0]]";
    let (_, unloaded) =
        run(&scratch, &deck(1e6).replace("translate = [0.0, 0.0, -0.001]", back), false, None);
    assert!(unloaded.contacts["floor"].normal_force < 1e-3 * contact.normal_force && is_soft(&unloaded));
    // Augmented, nothing penetrates.
    let augmented = deck(1e6).replace(
        "areas = true",
        "areas = true\nmethod = \"augmented-lagrangian\"\naugmentation = { tolerance = 1e-8 }",
    );
    let (_, augmented) = run(&scratch, &augmented, false, None);
    assert!(
        augmented.contacts["floor"].penalty_share < 0.01 && augmented.warnings.is_empty(),
        "{:?}",
        augmented.warnings
    );
    // Where the sheet yields, its strength makes the force.
    let (_, plastic) = run(
        &scratch,
        &deck(1e6).replace("poisson = 0.0", "poisson = 0.0, yield_stress = 100.0"),
        false,
        None,
    );
    assert!(
        !plastic.warnings.iter().any(|warning| warning.contains("elastic energy")),
        "{:?}",
        plastic.warnings
    );
    let (_, summary) = run(&scratch, &deck(1e8), false, None);
    assert!(summary.contacts["floor"].penalty_share < 0.01 && summary.warnings.is_empty());
    let (_, summary) = run(&scratch, &deck(1e15), false, None);
    assert!(
        summary.warnings.len() == 1 && summary.warnings[0].contains("1.0e10 times as stiff"),
        "{:?}",
        summary.warnings
    );
    // Over nodes the corners of faces with 8 nodes would have to pull.
    let curved = deck(1e8).replace("material =", "element = \"hex20\", material =");
    let (_, summary) = run(&scratch, &curved, false, None);
    assert!(summary.warnings.iter().any(|warning| warning.contains("4 faces of the slave have 8 nodes")));
    let over_faces = curved.replace("areas = true", "integration = \"faces\"");
    let (_, summary) = run(&scratch, &over_faces, false, None);
    assert!(summary.warnings.is_empty(), "{:?}", summary.warnings);
}

/// Incompatible modes leave no more in the forces than other elements do.
#[test]
fn bodies_that_are_only_moved_converge_without_a_warning() {
    for element in ["hex8", "hex8i", "tet10", "hex20"] {
        let deck = format!(
            r#"
materials.steel = {{ young = 200000.0, poisson = 0.3 }}

[parts.bar]
shape = "box"
size = [20.0, 4.0, 2.0]
divisions = [40, 1, 2]
element = "{element}"
material = "steel"

[[boundary]]
nodes = "bar.x-"
translate = [0.0, 0.0, -1.0]

[time]
increment = 0.25
"#
        );
        let scratch = Scratch::new(&format!("moved-{element}"));
        let (_, summary) = run(&scratch, &deck, false, None);
        assert!(summary.warnings.is_empty() && summary.cutbacks == 0, "{element}: {:?}", summary.warnings);
        let most = if element == "tet10" { 3 } else { 1 };
        assert!(
            summary.newton_iterations <= most * summary.increments,
            "{element}: {}",
            summary.newton_iterations
        );
    }
}

/// The report shows each master once, in two passes both sides, and none where there is no contact.
#[test]
fn every_master_has_a_sampled_surface() {
    let scratch = Scratch::new("surfaces");
    let floor = "shape = \"rigid-plane\"\nsize = [3.0, 2.0]\ndivisions = [6, 4]\n\n[parts.cellar]";
    let box_ = floor.replace("rigid-plane\"\nsize = [3.0, 2.0]\ndivisions = [6, 4]", 
        "box\"\nsize = [3.0, 2.0, 0.5]\ndivisions = [6, 4, 1]\ntranslate = [0.0, 0.0, -0.5]\nmaterial = \"soft\"");
    let two =
        PRESSED.replace(floor, &box_).replace("master = \"floor\"", "master = \"floor.z+\"\ntwo_pass = true");
    let none = format!("contact = \"none\"\n{PRESSED}");
    for (deck, expected) in [
        (PRESSED, &["floor", "cellar"][..]),
        (&two, &["floor", "floor, the other side", "cellar"]),
        (&none, &[]),
    ] {
        run(&scratch, deck, false, Some(1));
        let text = fs::read_to_string(scratch.0.join("out/skins/surfaces.json")).unwrap();
        let found: Vec<SurfaceSample> = serde_json::from_str(&text).unwrap();
        let names: Vec<&str> = found.iter().map(|sample| sample.name.as_str()).collect();
        assert_eq!(names, expected);
    }
}

/// Makes the state a directory once two increments are done: the next one cannot be written.
struct Obstructs(PathBuf);

impl Watcher for Obstructs {
    fn iteration(&mut self, _: &IterationRecord) {}

    fn cut_back(&mut self, _: f64, _: f64, _: &Failure) -> Control {
        Control::Continue
    }

    fn increment(&mut self, record: &IncrementRecord) -> Control {
        if record.number == 2 {
            let state = self.0.join(names::STATE);
            fs::remove_file(&state).unwrap();
            fs::create_dir(&state).unwrap();
        }
        Control::Continue
    }
}

/// Rows and pictures that are written before the state go with it: all files are of the last state.
#[test]
fn an_increment_whose_state_cannot_be_written_leaves_nothing() {
    let scratch = Scratch::new("obstructed");
    let (path, out) = (scratch.0.join("block.toml"), scratch.0.join("out"));
    fs::write(&path, PRESSED).unwrap();
    let error = solve(&path, &SolveOptions::new(&out), &mut Obstructs(out.clone())).unwrap_err().to_string();
    assert!(error.contains("state.json"), "{error}");
    let summary: Summary =
        serde_json::from_str(&fs::read_to_string(out.join(names::SUMMARY)).unwrap()).unwrap();
    assert_eq!((summary.converged, summary.increments, summary.time), (false, 2, 0.5));
    let history = read_history(&out.join(names::HISTORY)).unwrap();
    assert_eq!(history.rows.len(), 2);
    assert_eq!(read_history(&out.join(names::ITERATIONS)).unwrap().rows.last().unwrap().increment, 2);
    assert!(out.join("skins/00002.json").exists() && !out.join("skins/00003.json").exists());
    let series = fs::read_to_string(out.join(names::SERIES)).unwrap();
    assert!(series.contains("00002.vtu") && !series.contains("00003.vtu"), "{series}");
    assert!(!out.join(names::FAILED).exists());
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
    // A tenth of the facets' size is 0.058, also at corners, whose tributary area is a quarter.
    for (height, overlap, deep) in
        [("0.5, 0.05]", 0.0, 0), ("0.5, -0.05]", 0.05, 0), ("0.5, -0.06]", 0.06, 12), ("0.5, -0.2]", 0.2, 12)]
    {
        let found = &beginnings(height)[0];
        assert_eq!((found.slaves, found.paired, found.deep), (12, 12, deep), "{found:?}");
        assert!((found.overlap - overlap).abs() < 1e-12, "{found:?}");
    }
    // Over faces nothing is looked for so deep, and nothing touches.
    let faces = PRESSED.replacen("penalty = 500.0", "penalty = 500.0\nintegration = \"faces\"", 1);
    let (notes, summary) = run(&scratch, &faces.replace("0.5, 0.05]", "0.5, -3.0]"), false, Some(1));
    assert_eq!((notes.beginnings[0].paired, notes.beginnings[0].behind), (0, 12));
    assert!(
        summary.warnings.iter().any(|warning| warning.contains("behind it and deeper")),
        "{:?}",
        summary.warnings
    );
    let (notes, _) = run(&scratch, &faces, false, Some(1));
    assert!(notes.beginnings.iter().all(|one| one.behind == 0), "{:?}", notes.beginnings);
    // A part of the block is beside the floor.
    let beside = beginnings("1.3, 0.05]");
    assert_eq!((beside[0].slaves, beside[0].paired), (12, 8), "{beside:?}");
}

/// The floor is one facet, and out of reach until the second increment: nothing is known of it at the start, nor where it is
/// out of reach again.
#[test]
fn slaves_that_lose_the_quadratic_basis_on_the_way_are_told() {
    let scratch = Scratch::new("fallbacks");
    let deck = PRESSED
        .replacen("divisions = [6, 4]", "divisions = [1, 1]", 1)
        .replacen("penalty = 500.0", "penalty = 500.0\ndistance_limit = 0.02", 1)
        .replace("-0.1]", "-0.06]")
        .replace(
            "[[0.0, 0.0], [0.5, 1.0], [1.0, 0.0]]",
            "[[0.0, 0.0], [0.25, 0.7], [0.5, 1.0], [0.75, 0.0]]",
        );
    let (notes, stopped) = run(&scratch, &deck, false, Some(3));
    let start = &notes.beginnings[0];
    assert_eq!((start.paired, start.fallbacks), (0, Fallbacks::default()));
    let expected = Fallbacks { linear: 12, extended: 0 };
    assert_eq!(stopped.fallbacks.iter().collect::<Vec<_>>(), [(&"floor".to_owned(), &expected)]);
    // A restart knows of what was before it: in the last increment the floor is out of reach.
    let (_, whole) = run(&scratch, &deck, true, None);
    assert_eq!((whole.increments, &whole.fallbacks), (4, &stopped.fallbacks));
    let told = |summary: &Summary| {
        let warnings = summary.warnings.iter();
        warnings.filter(|warning| warning.contains("12 of 12 slaves have the linear basis")).count()
    };
    assert_eq!((told(&stopped), told(&whole)), (1, 1), "{:?}", whole.warnings);
    // Where it is so from the start on, that is said once.
    let near = deck.replacen("distance_limit = 0.02", "distance_limit = 0.2", 1);
    let (notes, all) = run(&scratch, &near, false, None);
    assert_eq!((notes.beginnings[0].fallbacks, told(&all)), (expected, 1), "{:?}", all.warnings);
}

/// A ring of hull layers that lies on a conic takes another.
#[test]
fn slaves_with_more_layers_than_asked_for_are_told() {
    let scratch = Scratch::new("extended");
    let rule = "penalty = 500.0\nneighbours = { rule = \"hull-layers\", count = 1 }";
    let (notes, summary) = run(&scratch, &PRESSED.replacen("penalty = 500.0", rule, 1), false, Some(1));
    let Fallbacks { linear, extended } = notes.beginnings[0].fallbacks;
    assert!(linear == 0 && (1..12).contains(&extended), "{extended}");
    let sentence = format!("interface `floor`: {extended} of 12 slaves have more layers");
    assert!(summary.warnings.iter().any(|warning| warning.starts_with(&sentence)), "{:?}", summary.warnings);
}

/// Then both press, and whoever meant one has twice its stiffness.
#[test]
fn one_pair_of_surfaces_under_two_names_is_told() {
    let scratch = Scratch::new("repeated");
    let twice = PRESSED.replace("master = \"cellar\"", "master = \"floor\"");
    for deck in [&twice, &twice.replacen("penalty = 500.0", "penalty = 500.0\nexchange = true", 1)] {
        let (notes, summary) = run(&scratch, deck, false, Some(1));
        let sentence = "interface `cellar`: its two surfaces are those of the interface `floor`";
        let told = |warnings: &[String]| warnings.iter().filter(|one| one.starts_with(sentence)).count();
        assert_eq!(told(&summary.warnings), 1, "{:?}", summary.warnings);
        let at_start: Vec<String> = notes.beginnings.iter().flat_map(Beginning::warnings).collect();
        assert_eq!(told(&at_start), 1, "{at_start:?}");
    }
    let (_, summary) = run(&scratch, PRESSED, false, Some(1));
    assert!(!summary.warnings.iter().any(|one| one.contains("two surfaces")), "{:?}", summary.warnings);
}

/// A penalty that lets slaves in by more than a twentieth of their facets' size is told, also of an increment before a restart. The default one
/// lets them in by less.
#[test]
fn penetration_beside_the_mesh_is_told() {
    let scratch = Scratch::new("deep");
    let told = |summary: &Summary| -> Vec<String> {
        summary.warnings.iter().filter(|one| one.contains("5 % of the size")).cloned().collect()
    };
    let soft = PRESSED.replace("penalty = 500.0", "penalty = 60.0");
    let (_, stopped) = run(&scratch, &soft, false, Some(2));
    let found = stopped.penetrations["floor"];
    // All slaves have facets of one size here.
    let size = (2.0_f64 / 3.0 * 0.5).sqrt();
    assert!((found.part * size - stopped.max_penetration).abs() < 1e-12 && found.slaves > 0, "{found:?}");
    let sentences = told(&stopped);
    assert!(
        sentences.len() == 1 && sentences[0].contains("`floor`") && sentences[0].contains("penalty 6.000e1"),
        "{sentences:?}"
    );
    let (_, whole) = run(&scratch, &soft, true, None);
    assert_eq!((whole.max_penetration, told(&whole)), (0.0, sentences));
    let (_, default) = run(&scratch, &PRESSED.replace("penalty = 500.0", ""), false, None);
    assert!(default.penetrations.is_empty() && told(&default).is_empty(), "{:?}", default.warnings);
}

/// A thin roller goes into a coarse block between its nodes, which carry nothing. With a finer block, or with faces, it is held.
#[test]
fn nodes_of_the_master_between_slaves_are_told() {
    let scratch = Scratch::new("between");
    let roller = PRESSED
        .replace("shape = \"rigid-plane\"\nsize = [3.0, 2.0]\ndivisions = [6, 4]\n\n[parts.cellar]", "shape = \"rigid-cylinder\"\naxis = \"y\"\nradius = 0.2\nlength = 2.0\ndivisions = [24, 4]\ntranslate = [1.5, 0.0, -0.15]\n\n[parts.cellar]");
    let told = |deck: &str| -> Vec<String> {
        let (_, summary) = run(&scratch, deck, false, None);
        summary.warnings.into_iter().filter(|one| one.contains("between its nodes")).collect()
    };
    let sentences = told(&roller);
    assert!(sentences.len() == 1 && sentences[0].contains("`floor`"), "{sentences:?}");
    let fine = roller.replace("divisions = [3, 2, 2]", "divisions = [24, 2, 2]");
    let faces =
        roller.replacen("slave = \"block.z-\"\n", "slave = \"block.z-\"\nintegration = \"faces\"\n", 1);
    assert_eq!((told(&fine), told(&faces)), (Vec::new(), Vec::new()));
}

/// One face over a whole mesh: roles the other way round are told, and those the right way are not.
#[test]
fn faces_over_a_hundred_facets_are_told() {
    let scratch = Scratch::new("coarse");
    let coarse =
        PRESSED.replace("divisions = [6, 4]", "divisions = [1, 1]").replace("[3, 2, 2]", "[12, 6, 1]");
    let faces = coarse.replace("slave = \"block.z-\"", "slave = \"block.z-\"\nintegration = \"faces\"");
    let told = |deck: &str| -> usize {
        let (_, summary) = run(&scratch, deck, false, Some(1));
        summary.warnings.iter().filter(|one| one.contains("the area of some 216 facets")).count()
    };
    let exchanged = faces.replace("integration = \"faces\"", "integration = \"faces\"\nexchange = true");
    assert_eq!((told(&faces), told(&exchanged)), (0, 2));
}

/// A comma in a name is an underscore in those of columns, where another interface may have one.
#[test]
fn interfaces_of_like_names_have_columns_of_their_own() {
    let scratch = Scratch::new("columns");
    let deck = PRESSED
        .replace("name = \"floor\"", "name = \"a,b\"")
        .replace("name = \"cellar\"", "name = \"a_b\"")
        .replace("penalty = 500.0", "penalty = 500.0\nintegration = \"faces\"\nfriction = 0.2");
    let (_, summary) = run(&scratch, &deck, false, Some(2));
    let history = read_history(&scratch.0.join("out").join(names::HISTORY)).unwrap();
    let distinct: BTreeSet<&String> = history.columns.iter().collect();
    assert_eq!(distinct.len(), history.columns.len(), "{:?}", history.columns);
    let held = |name: &str| summary.friction[name].stuck + summary.friction[name].sliding;
    assert!(held("a,b") > 0 && held("a_b") == 0, "{:?}", summary.friction);
}

/// Forces of a stiff body far around are rounded by more than is allowed.
#[test]
fn equilibrium_by_the_rounding_of_positions_is_told() {
    let scratch = Scratch::new("rounded");
    let stiff = format!(
        "{PRESSED}\n{}",
        r#"
[newton]
tolerance = 1e-14
absolute = 1e-6

[materials.hard]
young = 1e13
poisson = 0.3

[parts.tool]
shape = "box"
origin = [10.0, 0.0, 0.0]
size = [1.0, 1.0, 1.0]
divisions = [2, 2, 2]
material = "hard"

[[boundary]]
nodes = "tool.z-"
rotate = { axis = [1.0, 0.2, 0.3], point = [10.0, 0.0, 0.0], degrees = 40.0 }
"#
    );
    let (_, summary) = run(&scratch, &stiff, false, Some(2));
    let table = |name: &str| read_history(&scratch.0.join("out").join(name)).unwrap();
    let (history, iterations) = (table(names::HISTORY), table(names::ITERATIONS));
    for row in &history.rows {
        assert_eq!(history.value(row, "rounded"), 1.0, "{row:?}");
        let last = iterations.rows.iter().rfind(|other| other.increment == row.increment).unwrap();
        let [residual, allowed, excess] =
            ["residual", "allowed", "excess"].map(|column| iterations.value(last, column));
        assert!(residual > allowed && allowed >= excess && allowed > 0.0, "{last:?}");
    }
    let told =
        |summary: &Summary| summary.warnings.iter().any(|one| one.contains("rounding of the positions"));
    assert!(told(&summary), "{:?}", summary.warnings);
    let (_, soft) = run(&scratch, PRESSED, false, Some(2));
    assert!(!told(&soft), "{:?}", soft.warnings);
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

/// In a container each process has the number of the one before it: the files that a killed one left have the names of this one's.
#[test]
fn what_a_killed_run_left_keeps_no_other_from_starting() {
    let scratch = Scratch::new("locked");
    let out = scratch.0.join("out");
    fs::create_dir_all(&out).unwrap();
    let leave = || {
        for name in [names::DECK, names::HISTORY, names::ITERATIONS, names::STATE, names::REPORT] {
            let left = |count| out.join(format!(".{name}.{}-{count}.tmp", std::process::id()));
            (0..500).for_each(|count| fs::write(left(count), "half").unwrap());
        }
    };
    let left = || {
        let names =
            fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        names.filter(|name| name.ends_with(".tmp")).count()
    };
    let path = scratch.0.join("block.toml");
    fs::write(&path, PRESSED).unwrap();
    let options =
        |restart, overwrite| SolveOptions::new(&out).with_restart(restart).with_overwrite(overwrite);
    for (restart, overwrite) in [(false, false), (false, true), (true, false)] {
        leave();
        let mut notes = Notes { stop_after: Some(1), ..Notes::default() };
        solve(&path, &options(restart, overwrite), &mut notes).unwrap();
        assert_eq!(left(), 0, "restart {restart}, overwrite {overwrite}");
    }
}

/// Killed, or the disk full, before the first state: there is nothing to protect, whichever way one goes on.
#[test]
fn a_run_that_ended_before_its_first_state_begins_anew() {
    let scratch = Scratch::new("stillborn");
    let out = scratch.0.join("out");
    let path = scratch.0.join("block.toml");
    let begin = || {
        run(&scratch, PRESSED, false, Some(1));
        for name in [names::STATE, names::SUMMARY, names::REPORT, "results/00001.vtu", "skins/00001.json"] {
            fs::remove_file(out.join(name)).unwrap();
        }
        for table in [names::HISTORY, names::ITERATIONS] {
            let text = fs::read_to_string(out.join(table)).unwrap();
            fs::write(out.join(table), &text[..=text.find('\n').unwrap()]).unwrap();
        }
    };
    let again = |restart| {
        let options = SolveOptions::new(&out).with_restart(restart);
        solve(&path, &options, &mut Notes { stop_after: Some(2), ..Notes::default() })
    };
    for restart in [false, true] {
        begin();
        assert_eq!(again(restart).unwrap().increments, 2, "restart {restart}");
    }
    // What has an increment is protected, and no way points at one that is closed.
    begin();
    fs::write(out.join("results/00001.vtu"), "a picture").unwrap();
    for (restart, hint) in [(false, "--overwrite"), (true, "begin without --restart")] {
        let refused = again(restart).unwrap_err().to_string();
        assert!(refused.contains(hint) && !refused.contains("with --restart"), "{refused}");
    }
    fs::remove_file(out.join("results/00001.vtu")).unwrap();
    fs::write(out.join(names::DECK), "another deck").unwrap();
    assert!(again(false).unwrap_err().to_string().contains("--overwrite"));
}

/// Results are replaced file by file: others stay, here and where a link leads.
#[cfg(unix)]
#[test]
fn only_what_a_run_wrote_is_removed() {
    let scratch = Scratch::new("mine");
    let out = scratch.0.join("out");
    run(&scratch, PRESSED, false, Some(1));
    fs::write(out.join("results/777.vtu"), "mine").unwrap();
    run(&scratch, PRESSED, false, Some(1));
    assert_eq!(fs::read(out.join("results/777.vtu")).unwrap(), b"mine");
    let elsewhere = scratch.0.join("elsewhere");
    fs::rename(out.join("results"), &elsewhere).unwrap();
    std::os::unix::fs::symlink(&elsewhere, out.join("results")).unwrap();
    let options = SolveOptions::new(&out).with_overwrite(true);
    let path = scratch.0.join("block.toml");
    let refused = solve(&path, &options, &mut Notes::default()).unwrap_err().to_string();
    assert!(refused.contains("results is a link"), "{refused}");
    assert!(elsewhere.join("00000.vtu").exists() && out.join(names::STATE).exists(), "nothing was removed");
    fs::remove_dir_all(&elsewhere).unwrap();
    fs::create_dir(&elsewhere).unwrap();
    solve(&path, &options, &mut Notes { stop_after: Some(1), ..Notes::default() }).unwrap();
    assert!(elsewhere.join("00001.vtu").exists(), "a place of one's own for pictures");
}
