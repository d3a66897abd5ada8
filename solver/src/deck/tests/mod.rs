//! Decks as they are written, and as they are miswritten.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use diffuse_contact::faces::FaceRule;
use diffuse_contact::interface::ContactElement;
use diffuse_contact::neighbourhood::NeighbourRule;
use diffuse_contact::pairing::MAX_NEIGHBOURS;
use diffuse_contact::{FrameDerivative, Weight};

use super::*;
use crate::contact::{Augmentation, Integration, RefreshRule, TangentRule};
use crate::statics::{Extrapolation, NewtonSettings, TimeSettings};
use crate::system::LinearSolverChoice;

/// A deck that is right: a block on a rigid floor.
const DECK: &str = r#"
title = "Block on a floor"

[materials.steel]
young = 200_000
poisson = 0.3
yield_stress = 400.0
hardening = 3450.0

[parts.block]
shape = "box"
size = [1.0, 1.0, 1.0]
divisions = [2, 2, 2]
material = "steel"

[parts.floor]
shape = "rigid-plane"
size = [3.0, 3.0]
divisions = [3, 3]
translate = [-1.0, -1.0, -0.1]

[[boundary]]
nodes = "floor"
fix = ["x", "y", "z"]

[[boundary]]
nodes = ["block.z+"]
translate = [0.0, "free", -0.2]

[[pressure]]
surface = "block.x+"
value = 10.0

[[interface]]
name = "joint"
master = "floor"
slave = "block.z-"
penalty = 1e5

[time]
increment = 0.25
"#;

/// The deck with one piece of text in the place of another, which is there once.
fn changed(from: &str, to: &str) -> String {
    assert_eq!(DECK.matches(from).count(), 1, "{from}");
    DECK.replace(from, to)
}

/// The message of a deck that is wrong in its text or in its names.
fn message(text: &str) -> String {
    match Deck::parse(text) {
        Err(error) => error.to_string(),
        Ok(deck) => deck.model(".").map(drop).expect_err("the deck is right").to_string(),
    }
}

#[track_caller]
fn refused(from: &str, to: &str, expected: &str) {
    let message = message(&changed(from, to));
    assert!(message.contains(expected), "{message}\ndoes not contain\n{expected}");
}

#[test]
fn a_deck_is_read_with_its_defaults() {
    let deck = Deck::parse(DECK).unwrap();
    assert_eq!((deck.title.as_str(), deck.contact), ("Block on a floor", Contact::Diffuse));
    let plasticity = deck.materials["steel"].plasticity.unwrap();
    assert_eq!((plasticity.yield_stress, plasticity.hardening), (400.0, 3450.0));
    assert_eq!(deck.parts.iter().map(|part| part.name.as_str()).collect::<Vec<_>>(), ["block", "floor"]);
    assert_eq!(deck.boundaries[1].axes, [true, false, true]);
    assert_eq!(deck.boundaries[1].motion.position(0.5, [0.0; 3]), [0.0, 0.0, -0.1]);
    assert_eq!(deck.pressures[0].amplitude.at(0.25), 0.25);
    assert_eq!(
        deck.time,
        TimeSettings {
            end: 1.0,
            increment: 0.25,
            minimum: 0.25 / 1024.0,
            maximum: 0.25,
            growth: 1.5,
            cutback: 0.5
        }
    );
    assert_eq!(
        deck.newton,
        NewtonSettings {
            tolerance: 1e-6,
            absolute: 1e-8,
            max_iterations: 20,
            few_iterations: 6,
            line_search: true,
            extrapolation: Extrapolation::None,
            stabilisation: 0.0,
            linear_solver: LinearSolverChoice::Auto
        }
    );
    let fixed = Deck::parse(&changed("increment = 0.25", "increment = 0.25\nfixed = true")).unwrap().time;
    assert_eq!(fixed, TimeSettings { minimum: 0.25, growth: 1.0, ..deck.time });
    assert_eq!(deck.output, Output { every: 1, stress: true, colour: Colour::VonMises });
    let interface = &deck.interfaces[0];
    assert_eq!(interface.options(Contact::Diffuse), Default::default());
    assert_eq!(interface.options(Contact::NodeToFacet).element, ContactElement::NodeToFacet);
    assert_eq!(
        (interface.augmentation, interface.refresh, interface.tangent),
        (None, RefreshRule::Increment, TangentRule::Adaptive)
    );

    let model = deck.model(".").unwrap();
    assert_eq!((model.nodes.len(), model.bodies.len()), (27 + 16, 1));
    assert_eq!(model.nodes[27], [-1.0, -1.0, -0.1]);
    let supports = deck.supports(&model).unwrap();
    assert_eq!(supports.prescribed().count(), 16 * 3 + 9 * 2);
    let sides = deck.sides(&model, interface).unwrap();
    assert_eq!((sides.master.len(), sides.slave.len(), sides.slave_nodes().len()), (9, 4, 9));
    assert_eq!(deck.loads(&model).unwrap()[0].facets.len(), 4);
}

#[test]
fn contact_is_integrated_over_nodes_or_faces() {
    for (value, expected) in [
        ("\"nodes\"", Integration::Nodes),
        ("\"faces\"", Integration::Faces(FaceRule::Second)),
        ("{ over = \"nodes\" }", Integration::Nodes),
        ("{ over = \"faces\" }", Integration::Faces(FaceRule::Second)),
        ("{ over = \"faces\", degree = 4 }", Integration::Faces(FaceRule::Fourth)),
    ] {
        let text = changed("penalty = 1e5", &format!("penalty = 1e5\nintegration = {value}"));
        assert_eq!(Deck::parse(&text).unwrap().interfaces[0].integration, expected);
    }
    refused(
        "penalty = 1e5",
        "areas = false",
        "interface[1].areas has no meaning without penalty, which is per area then",
    );
    refused("penalty = 1e5", "adjust = 0.0", "interface[1].adjust must be positive, not 0");
    refused("penalty = 1e5", "penalty = 1e5\nintegration = { over = \"faces\", degree = 3 }", "2 or 4");
}

#[test]
fn every_field_is_taken() {
    let deck = changed(
        "penalty = 1e5",
        r#"penalty = 1e5
        areas = true
        method = "augmented-lagrangian"
        augmentation = { max = 7, tolerance = 1e-3 }
        two_pass = true
        exchange = true
        weight = "wendland-c2"
        frame = "frozen"
        neighbours = { rule = "nearest", count = 14, regularity = 0.1 }
        refresh = "iteration"
        tangent = "gauss-newton"
        feature_angle = 30
        border_tolerance = 0.5
        distance_limit = 2"#,
    )
    .replace(
        "increment = 0.25",
        r#"
        end = 4.0
        increment = 0.5
        minimum = 0.125
        maximum = 1.0
        growth = 2
        cutback = 0.25
        [newton]
        tolerance = 1e-8
        absolute = 0
        max_iterations = 11
        line_search = false
        extrapolation = "linear"
        [output]
        every = 3
        stress = false
        colour = "gap""#,
    )
    .replace("value = 10.0", "value = 10.0\nfollower = true\namplitude = [[0, 0], [1, 5], [4, 0]]")
    .replace("title =", "contact = \"node-to-facet\"\ntitle =");
    let deck = Deck::parse(&deck).unwrap();
    let interface = &deck.interfaces[0];
    let options = interface.options(Contact::Diffuse);
    assert!(options.areas && interface.two_pass && interface.exchange && deck.pressures[0].follower);
    assert_eq!(interface.augmentation, Some(Augmentation { max_rounds: 7, tolerance: 1e-3 }));
    let ContactElement::Diffuse { weight, frame, search, .. } = options.element else {
        panic!("not diffuse")
    };
    assert_eq!((weight, frame), (Weight::WendlandC2, FrameDerivative::Frozen));
    assert_eq!((search.rule, search.smallest_regularity), (NeighbourRule::nearest(14), 0.1));
    assert_eq!(
        (options.feature_angle_degrees, options.border_tolerance, options.distance_limit),
        (30.0, 0.5, Some(2.0))
    );
    options.check().unwrap();
    assert_eq!(
        (interface.refresh, interface.tangent, deck.contact),
        (RefreshRule::Iteration, TangentRule::GaussNewton, Contact::NodeToFacet)
    );
    assert_eq!(
        deck.time,
        TimeSettings { end: 4.0, increment: 0.5, minimum: 0.125, maximum: 1.0, growth: 2.0, cutback: 0.25 }
    );
    assert_eq!(
        deck.newton,
        NewtonSettings {
            tolerance: 1e-8,
            absolute: 0.0,
            max_iterations: 11,
            few_iterations: 6,
            line_search: false,
            extrapolation: Extrapolation::Linear,
            stabilisation: 0.0,
            linear_solver: LinearSolverChoice::Auto
        }
    );
    assert_eq!(deck.output, Output { every: 3, stress: false, colour: Colour::Gap });
    assert_eq!(deck.pressures[0].amplitude.at(2.5), 2.5);
    // Without an amplitude a motion lasts to the end.
    assert_eq!(deck.boundaries[1].motion.position(2.0, [0.0; 3]), [0.0, 0.0, -0.1]);

    let model = deck.model(".").unwrap();
    let sides = deck.sides(&model, interface).unwrap();
    assert_eq!((sides.master.len(), sides.slave.len()), (4, 9), "exchanged");
}

#[test]
fn misspelt_fields_name_the_nearest() {
    refused(
        "poisson = 0.3",
        "poison = 0.3",
        "deck, line 6: [materials.steel] has no field \"poison\" (did you mean \"poisson\"?); it has young, poisson, yield_stress, hardening",
    );
    refused("title =", "tilte =", "line 2: the deck has no field \"tilte\" (did you mean \"title\"?)");
    refused(
        "divisions = [2, 2, 2]",
        "division = [2, 2, 2]",
        "line 13: [parts.block] has no field \"division\" (did you mean \"divisions\"?)",
    );
    refused("penalty", "penaltY", "[interface[1]] has no field \"penaltY\" (did you mean \"penalty\"?)");
    refused(
        "shape = \"box\"",
        "shap = \"box\"",
        "line 11: [parts.block] has no field \"shap\" (did you mean \"shape\"?)",
    );
    refused(
        "increment = 0.25",
        "increment = 0.25\nxyzzy = 1",
        "[time] has no field \"xyzzy\"; it has end, increment",
    );
    refused(
        "size = [3.0, 3.0]",
        "size = [3.0, 3.0]\norigin = [0, 0, 0]",
        "[parts.floor] has no field \"origin\"",
    );
}

#[test]
fn misspelt_words_and_names_name_the_nearest() {
    refused(
        "title =",
        "contact = \"difuse\"\ntitle =",
        "contact cannot be \"difuse\" (did you mean \"diffuse\"?); it can be \"diffuse\", \"node-to-facet\", \"none\"",
    );
    refused(
        "shape = \"box\"",
        "shape = \"bax\"",
        "parts.block.shape cannot be \"bax\" (did you mean \"box\"?)",
    );
    refused(
        "material = \"steel\"",
        "material = \"stel\"",
        "line 14: no material is named \"stel\" (did you mean \"steel\"?)",
    );
    refused(
        "\"block.z+\"",
        "\"blok.z+\"",
        "line 27: no node set is named \"blok.z+\" (did you mean \"block.z+\"?)",
    );
    refused(
        "surface = \"block.x+\"",
        "surface = \"block.crown\"",
        "line 31: no surface is named \"block.crown\"; there are block, block.x+",
    );
    refused(
        "slave = \"block.z-\"",
        "slave = [\"block.z-\", \"flor\"]",
        "no surface is named \"flor\" (did you mean \"floor\"?)",
    );
    refused("fix = [\"x\", \"y\", \"z\"]", "fix = [\"x\", \"w\"]", "boundary[1].fix[2] cannot be \"w\"");
}

#[test]
fn wrong_types_and_ranges_say_what_was_found() {
    refused(
        "young = 200_000",
        "young = \"hard\"",
        "line 5: materials.steel.young must be a number, not the text \"hard\"",
    );
    refused(
        "young = 200_000",
        "young = -1.5",
        "materials.steel.young must be positive (1e-50 to 1e50), not -1.5",
    );
    refused("young = 200_000", "young = nan", "materials.steel.young must be finite, not NaN");
    refused("young = 200_000", "young = inf", "materials.steel.young must be finite, not inf");
    refused(
        "poisson = 0.3",
        "poisson = 0.5",
        "materials.steel.poisson must be above -1 and below 0.5, not 0.5",
    );
    refused(
        "size = [1.0, 1.0, 1.0]",
        "size = [1.0, 1.0]",
        "line 12: parts.block.size must be a list of three numbers, not a list of 2",
    );
    refused(
        "size = [1.0, 1.0, 1.0]",
        "size = [1.0, 0.0, 1.0]",
        "line 12: parts.block: size must be a positive length (1e-50 to 1e50), not 0",
    );
    refused(
        "divisions = [2, 2, 2]",
        "divisions = [2, 2.5, 2]",
        "parts.block.divisions[2] must be a whole number, not 2.5",
    );
    refused(
        "divisions = [2, 2, 2]",
        "divisions = [2, -2, 2]",
        "parts.block.divisions[2] must be at least 1, not -2",
    );
    refused(
        "divisions = [2, 2, 2]",
        "divisions = [999, 999, 99]",
        "line 13: parts.block: these divisions make 100000000 nodes; at most 20000000 are possible",
    );
    refused(
        "value = 10.0",
        "value = 10.0\nfollower = 1",
        "pressure[1].follower must be true or false, not 1",
    );
    refused(
        "value = 10.0",
        "value = 10.0\namplitude = [[0, 0], [2, 1], [1, 0]]",
        "pressure[1].amplitude: times must ascend, but point 3 is not later",
    );
    refused(
        "increment = 0.25",
        "increment = 2.0",
        "time.increment must be from 1e-9 times end to end, not 2",
    );
    refused(
        "increment = 0.25",
        "increment = 0.25\nmaximum = 0.1",
        "time.maximum must be from increment to end, not 0.1",
    );
    refused(
        "translate = [0.0, \"free\", -0.2]",
        "translate = [0.0, \"fre\", -0.2]",
        "boundary[2].translate[2] must be a number or \"free\", not the text \"fre\"",
    );
    refused("nodes = \"floor\"", "nodes = []", "boundary[1].nodes must be a list of at least one name");
    refused(
        "penalty = 1e5",
        "penalty = 1e5\nneighbours = { rule = \"nearest\", count = 25 }",
        "interface[1].neighbours.count must be from 1 to 24, not 25",
    );
    refused(
        "penalty = 1e5",
        "penalty = 1e5\nneighbours = { rule = \"hull-layers\", regularity = 1.0 }",
        "interface[1].neighbours.regularity must be at least 0 and below 1, not 1",
    );
    assert_eq!(MAX_NEIGHBOURS, 24);
}

#[test]
fn fields_that_do_not_go_together_are_refused() {
    refused(
        "yield_stress = 400.0\n",
        "",
        "line 7: materials.steel.hardening has no meaning without yield_stress",
    );
    refused(
        "fix = [\"x\", \"y\", \"z\"]",
        "fix = [\"x\"]\namplitude = [[0, 0]]",
        "boundary[1].amplitude has no meaning beside fix",
    );
    refused("fix = [\"x\", \"y\", \"z\"]", "", "[boundary[1]] needs fix, translate or rotate");
    refused(
        "translate = [0.0, \"free\", -0.2]",
        "translate = [0.0, \"free\", -0.2]\nrotate = { axis = [0, 0, 1], degrees = 9 }",
        "has no meaning beside rotate",
    );
    refused(
        "penalty = 1e5",
        "penalty = 1e5\naugmentation = { tolerance = 1.0 }",
        "interface[1].augmentation has no meaning without method",
    );
    refused(
        "penalty = 1e5",
        "penalty = 1e5\nmethod = \"augmented-lagrangian\"",
        "[interface[1]] needs a field \"augmentation\"",
    );
    let over_faces = |fields: &str| format!("penalty = 1e5\nintegration = \"faces\"\n{fields}");
    refused(
        "penalty = 1e5",
        &over_faces("friction = { coefficient = 0.3, symmetric = true }"),
        "interface[1].friction.symmetric has no meaning with integration over faces",
    );
    refused(
        "penalty = 1e5",
        &over_faces("areas = true"),
        "interface[1].areas has no meaning with integration over faces",
    );
    refused(
        "penalty = 1e5",
        &over_faces("refresh = \"iteration\""),
        "interface[1].refresh has no meaning with integration over faces",
    );
    refused(
        "penalty = 1e5",
        &over_faces("neighbours = { rule = \"nearest\" }"),
        "interface[1].neighbours has no meaning with integration over faces",
    );
    refused(
        "penalty = 1e5",
        "penalty = 1e5\nintegration = { over = \"nodes\", degree = 2 }",
        "degree has no meaning with over = \"nodes\"",
    );
    refused(
        "increment = 0.25",
        "increment = 0.25\nfixed = true\ngrowth = 2.0",
        "time.growth has no meaning beside fixed = true",
    );
    refused(
        "divisions = [3, 3]",
        "divisions = [3, 3]\nmaterial = \"steel\"",
        "parts.floor.material has no meaning for a rigid part",
    );
    refused(
        "shape = \"box\"",
        "shape = \"box\"\nfile = \"box.msh\"",
        "parts.block.shape has no meaning beside file",
    );
    refused(
        "shape = \"box\"\nsize = [1.0, 1.0, 1.0]\ndivisions = [2, 2, 2]",
        "",
        "[parts.block] needs either a shape or a file",
    );
    refused("material = \"steel\"\n", "", "[parts.block] needs a field \"material\"");
    refused("[time]\nincrement = 0.25", "", "the deck needs a field \"time\"");
    let second =
        "[[interface]]\nname = \"joint\"\nmaster = \"floor\"\nslave = \"block.x-\"\npenalty = 1\n[time]";
    refused("[time]", second, "two interfaces are named \"joint\"; the other is in line 35");
}

#[test]
fn contradictions_in_space_are_refused() {
    let twice = "[[boundary]]\nnodes = \"block.x+\"\nfix = [\"z\"]\n[[pressure]]";
    refused(
        "[[pressure]]",
        twice,
        "is moved along z by this boundary condition and, differently, by that in line 26",
    );
    // Along x both say that nothing moves, along y one of them says nothing.
    let alike =
        changed("[[pressure]]", "[[boundary]]\nnodes = \"block.x+\"\nfix = [\"x\", \"y\"]\n[[pressure]]");
    Deck::parse(&alike).unwrap().model(".").unwrap();

    refused(
        "fix = [\"x\", \"y\", \"z\"]",
        "fix = [\"x\", \"z\"]",
        "line 16: the part \"floor\" is rigid, but its node at (-1, -1, -0.1) is free along y",
    );
    refused("surface = \"block.x+\"", "surface = \"floor\"", "the surface \"floor\" is rigid");
    refused("slave = \"block.z-\"", "slave = \"floor\"", "on both sides of the interface \"joint\"");
    let floor = "[parts.lid]\nshape = \"rigid-plane\"\nsize = [1, 1]\ndivisions = [1, 1]\n[parts.floor]";
    let rigid = changed("[parts.floor]", floor)
        .replace("slave = \"block.z-\"", "slave = \"lid\"")
        .replace("nodes = \"floor\"", "nodes = [\"floor\", \"lid\"]");
    assert!(message(&rigid).contains("both sides of the interface \"joint\" are rigid"));
    let nothing =
        "[parts.floor]\nshape = \"rigid-plane\"\nsize = [1, 1]\ndivisions = [1, 1]\n[time]\nincrement = 1";
    assert!(message(nothing).contains("the deck has no deformable part"));
}

#[test]
fn broken_texts_and_files_are_errors() {
    let text = message("title = \"a\nb\"");
    assert!(text.starts_with("deck, line 1: not valid TOML"), "{text}");
    assert!(message("[time]\nincrement = 0.1\nincrement = 0.2").starts_with("deck, line 3: not valid TOML"));
    assert!(message("\n# nothing yet\n").contains("nothing in the deck"));
    assert!(message("title = \"\"").contains("the deck needs a field \"time\""));
    assert!(
        message("boundary = 3\n[time]\nincrement = 1")
            .contains("boundary must be a list of tables: write [[boundary]], not 3")
    );
    assert!(message("parts = 3\n[time]\nincrement = 1").contains("parts must be a table, not 3"));
    let missing = Deck::read("/nowhere/deck.toml").unwrap_err();
    assert!(missing.to_string().starts_with("/nowhere/deck.toml: cannot be read"));
    let text =
        changed("shape = \"box\"\nsize = [1.0, 1.0, 1.0]\ndivisions = [2, 2, 2]", "file = \"nowhere.msh\"");
    assert!(
        message(&text).contains("line 10: parts.block: ./nowhere.msh: cannot be read"),
        "{}",
        message(&text)
    );
    // Whatever is cut off, there is an answer.
    for end in 0..DECK.len() {
        if let Ok(deck) = Deck::parse(&DECK[..end]) {
            let _ = deck.model(".");
        }
    }
}

#[test]
fn parts_come_from_mesh_files() {
    let meshes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../mesh/meshes");
    let text = changed(
        "shape = \"rigid-plane\"\nsize = [3.0, 3.0]\ndivisions = [3, 3]",
        "file = \"plate_on_cylinder.msh\"\nsurface = \"master\"",
    );
    let model = Deck::parse(&text).unwrap().model(&meshes).unwrap();
    assert_eq!(model.surfaces["floor"], model.surfaces["floor.master"]);
    assert!(!model.surfaces.contains_key("floor.slave"));
    let solid = changed(
        "shape = \"box\"\nsize = [1.0, 1.0, 1.0]\ndivisions = [2, 2, 2]",
        "file = \"plate_on_cylinder.msh\"",
    );
    let error = Deck::parse(&solid).unwrap().model(&meshes).unwrap_err().to_string();
    assert!(error.contains("parts.block: the mesh file has no solid elements"), "{error}");
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

#[test]
fn the_example_decks_build() {
    let expected: BTreeMap<&str, (usize, usize, usize)> = BTreeMap::from([
        // Elements, master facets and slave facets.
        ("coaxial_cylinders", (36 * 4 + 40 * 4, 80, 72)),
        ("hertz_cylinder", (20 * 20 + 40 * 16, 40, 40)),
        ("hertz_sphere", (9 * 9 * 9 + 3 * 81 * 8, 64, 3 * 81)),
        ("patch_test", (50 + 24, 25, 12)),
        ("pipe_pinch", (64 + 48, 32, 24)),
        ("pipe_pinch_plastic", (64 + 48, 32, 24)),
        ("plate_cylinder", (100, 32, 100)),
        ("ring_block", (128 + 360, 60, 64)),
        ("shrink_fit", (24 * 6 * 4 + 20 * 8 * 4, 80, 96)),
        ("sliding_block", (108, 150, 36)),
        ("inclined_block", (64, 65, 16)),
        ("belt", (144, 60, 144)),
        ("cattaneo_mindlin", (6400 + 5472, 160, 144)),
        ("press_fit", (24 * 6 * 2 + 20 * 8 * 2, 40, 48)),
        ("shaft_in_bush", (120, 160, 60)),
        ("shallow_ironing", (60 * 12 + 12 * 6, 60, 12 + 2 * 6)),
        ("squeezed_tube", (48, 72, 24)),
        ("crushed_serpentine", (128, 132, 132)),
        ("coil_spring", (320, 320, 320)),
        ("two_blocks", (14 * 14 * 7 + 10 * 10 * 5, 196, 100)),
    ]);
    let mut found = BTreeSet::new();
    for entry in std::fs::read_dir(root().join("examples")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let name = path.file_stem().unwrap().to_str().unwrap().to_string();
        let deck = Deck::read(&path).unwrap_or_else(|error| panic!("{error}"));
        let model = deck.model(path.parent().unwrap()).unwrap_or_else(|error| panic!("{error}"));
        assert!(!deck.title.is_empty() && deck.contact == Contact::Diffuse);
        let sides = deck.sides(&model, &deck.interfaces[0]).unwrap();
        let elements = model.bodies.iter().map(|body| body.elements.len()).sum::<usize>();
        assert_eq!((elements, sides.master.len(), sides.slave.len()), expected[name.as_str()], "{name}");
        found.insert(name);
    }
    assert!(expected.keys().all(|name| found.contains(*name)), "{found:?}");
}

/// A surface in contact with itself has no roles.
#[test]
fn self_stands_in_place_of_master_and_slave() {
    let text = std::fs::read_to_string(root().join("examples/squeezed_tube.toml")).unwrap();
    let own = "self = [\"tube.inner\", \"tube.outer\"]\n";
    let deck = Deck::parse(&text).unwrap();
    let (model, walls) = (deck.model(root()).unwrap(), &deck.interfaces[2]);
    let sides = deck.sides(&model, walls).unwrap();
    assert!(walls.self_contact && sides.master == sides.slave && sides.master.len() == 48);
    for more in
        ["master = \"below\"", "slave = \"tube.outer\"", "two_pass = true", "exchange = true", "adjust = 0.1"]
    {
        let error = Deck::parse(&text.replace(own, &format!("{own}{more}\n"))).unwrap_err().to_string();
        assert!(error.contains("with self"), "{error}");
    }
    let over_faces =
        text.replace("areas = true\n", "").replace(own, &format!("{own}integration = \"faces\"\n"));
    let faces = Deck::parse(&over_faces).unwrap();
    assert!(faces.interfaces[2].self_contact && faces.interfaces[2].integration != Integration::Nodes);
}

/// The fields in the first columns of the tables below each heading of docs/how-to/decks.md.
fn documented() -> BTreeMap<String, BTreeSet<String>> {
    let page = std::fs::read_to_string(root().join("docs/how-to/decks.md")).unwrap();
    let (mut heading, mut fields) = (String::new(), BTreeMap::new());
    for line in page.lines() {
        if line.starts_with('#') {
            heading = line.trim_start_matches('#').trim().to_string();
        } else if let Some((field, _)) = line.strip_prefix("| `").and_then(|row| row.split_once("` |")) {
            let fresh = fields.entry(heading.clone()).or_insert_with(BTreeSet::new).insert(field.to_string());
            assert!(fresh, "{field} is documented twice under {heading}");
        }
    }
    fields
}

#[test]
fn every_field_is_documented_and_every_documented_field_exists() {
    let mut fields: BTreeMap<String, &[&str]> = BTreeMap::from([
        ("The deck", schema::DECK),
        ("`[materials.NAME]`", schema::MATERIAL),
        ("`[parts.NAME]`", schema::PART),
        ("`rotate`", schema::ROTATION),
        ("`path` of a strip", schema::PIECE),
        ("`file`", schema::FILE),
        ("`[[boundary]]`", schema::BOUNDARY),
        ("`rotate` of a boundary", schema::BOUNDARY_ROTATION),
        ("`[[pressure]]`", schema::PRESSURE),
        ("`[[interface]]`", schema::INTERFACE),
        ("`augmentation`", schema::AUGMENTATION),
        ("`friction`", schema::FRICTION),
        ("`coefficient`", schema::COEFFICIENT),
        ("`integration`", schema::INTEGRATION),
        ("`neighbours`", schema::NEIGHBOURS),
        ("`[time]`", schema::TIME),
        ("`[newton]`", schema::NEWTON),
        ("`[output]`", schema::OUTPUT),
    ])
    .into_iter()
    .map(|(heading, fields)| (heading.to_string(), fields))
    .collect();
    // A plate is a box by another name.
    let shapes = schema::SHAPES.iter().filter(|(name, _)| *name != "plate");
    fields.extend(shapes.map(|&(name, fields)| (format!("`shape = \"{name}\"`"), fields)));
    let mut known: BTreeMap<String, BTreeSet<String>> = fields
        .into_iter()
        .map(|(heading, fields)| (heading, fields.iter().map(|f| f.to_string()).collect()))
        .collect();
    let of_parts = known.get_mut("`[parts.NAME]`").unwrap();
    of_parts.extend(schema::SOLID_SHAPE.iter().map(|field| field.to_string()));
    assert_eq!(documented(), known);
}

/// The kind of element of a shape is one word; what has no elements of its own has none.
#[test]
fn shapes_are_made_of_the_kind_of_element_that_a_deck_names() {
    let shape = |kind: &str| changed("shape = \"box\"", &format!("shape = \"box\"\nelement = \"{kind}\""));
    let count = |kind: &str| {
        let model = Deck::parse(&shape(kind)).unwrap().model(".").unwrap();
        (model.bodies[0].elements.len(), model.nodes.len())
    };
    let (cells, nodes) = count("hex8");
    assert_eq!((cells, nodes), {
        let model = Deck::parse(DECK).unwrap().model(".").unwrap();
        (model.bodies[0].elements.len(), model.nodes.len())
    });
    assert_eq!((count("hex20").0, count("tet10").0), (cells, 6 * cells));
    assert_eq!(count("tet4"), (6 * cells, nodes));
    assert!(count("hex27").1 > count("hex20").1 && count("hex27").1 == count("tet10").1);
    refused("shape = \"box\"", "shape = \"box\"\nelement = \"hex21\"", "parts.block.element");
    let rigid = changed("shape = \"rigid-plane\"", "shape = \"rigid-plane\"\nelement = \"hex8\"");
    assert!(Deck::parse(&rigid).unwrap_err().to_string().contains("element"));
}

/// Squares of stresses overflow long before the moduli do.
#[test]
fn moduli_are_bounded_as_lengths_are() {
    for value in ["1e51", "1e300", "1e-60"] {
        let range = "must be positive (1e-50 to 1e50), not";
        refused("young = 200_000", &format!("young = {value}"), &format!("materials.steel.young {range}"));
        let yields = format!("materials.steel.yield_stress {range}");
        refused("yield_stress = 400.0", &format!("yield_stress = {value}"), &yields);
    }
    refused("hardening = 3450.0", "hardening = 1e51", "hardening must be at least 0 and at most 1e50");
}

/// A deck can forge no message of its own, nor speak to the terminal, whichever of its names is wrong.
#[test]
fn names_of_a_deck_are_shown_in_one_line_of_limited_length() {
    let long = "x".repeat(5000);
    let hostile = |text: &str| text.replace('!', &format!("\\u001B]0;t\\u0007\\nerror: forged {long}"));
    for (from, to) in [
        ("poisson = 0.3", "\"!\" = 0.3"),
        ("[parts.block]", "[parts.\"!.\"]"),
        ("material = \"steel\"", "material = \"!\""),
        ("surface = \"block.x+\"", "surface = \"!\""),
        ("shape = \"box\"", "shape = \"!\""),
        ("young = 200_000", "young = \"!\""),
    ] {
        let error =
            Deck::parse(&changed(from, &hostile(to))).and_then(|deck| deck.model(".").map(drop)).unwrap_err();
        let said = error.to_string();
        assert!(!said.contains(char::is_control), "{from}: {said:?}");
        assert!(said.contains("forged") && said.len() < 1000, "{from}: {said}");
    }
    let many: String = (0..3000).map(|k| format!("[materials.m{k}]\nyoung = 1.0\npoisson = 0.3\n")).collect();
    let text = changed("material = \"steel\"", "material = \"gold\"") + &many;
    let said = Deck::parse(&text).unwrap().model(".").unwrap_err().to_string();
    assert!(said.len() < 500 && said.ends_with(" more"), "{said}");
}

/// Abaqus does not tell case apart in the names of sets.
#[test]
fn sets_are_found_in_other_letter_case() {
    let deck = Deck::parse(&changed("nodes = [\"block.z+\"]", "nodes = [\"block.Z+\"]")).unwrap();
    let model = deck.model(".").unwrap();
    assert_eq!(deck.supports(&model).unwrap(), Deck::parse(DECK).unwrap().supports(&model).unwrap());
    refused("\"block.z+\"", "\"Block.z+\"", "no node set is named \"Block.z+\"");
}

/// What a mesh file counts to a surface although it lies inside the part would carry neither contact nor pressure.
#[test]
fn surfaces_with_facets_inside_their_part_are_refused() {
    const MESH: &str = "\
*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
5, 0, 0, 1
6, 1, 0, 1
7, 1, 1, 1
8, 0, 1, 1
9, 2, 0, 0
10, 2, 1, 0
11, 2, 0, 1
12, 2, 1, 1
*ELEMENT, TYPE=C3D8, ELSET=ALL
1, 1, 2, 3, 4, 5, 6, 7, 8
2, 2, 9, 10, 3, 6, 11, 12, 7
*SURFACE, NAME=BOTH, TYPE=ELEMENT
1, S2
1, S4
*SURFACE, NAME=WITHIN, TYPE=ELEMENT
1, S4
";
    let directory = std::env::temp_dir().join(format!("diffuse-contact-deck-{}", std::process::id()));
    std::fs::create_dir_all(&directory).unwrap();
    std::fs::write(directory.join("two.inp"), MESH).unwrap();
    let deck = |surface: &str| {
        let text = format!(
            "[materials.m]\nyoung = 1.0\npoisson = 0.3\n[parts.two]\nfile = \"two.inp\"\nmaterial = \"m\"\n[[boundary]]\n\
             nodes = \"two\"\nfix = [\"x\"]\n[[pressure]]\nsurface = \"two.{surface}\"\nvalue = 1.0\n[time]\nincrement = 1.0\n"
        );
        Deck::parse(&text).unwrap().model(&directory).map(drop).unwrap_err().to_string()
    };
    assert!(
        deck("BOTH").contains("line 11: 1 of the 2 facets of the surface \"two.BOTH\" are not on the skin"),
        "{}",
        deck("BOTH")
    );
    assert!(deck("WITHIN").contains("1 of the 1 facets of the surface"), "{}", deck("WITHIN"));
    std::fs::remove_dir_all(&directory).unwrap();
}

/// Abaqus' C3D8I has incompatible modes, and `element` of a part says otherwise or the same of what has none.
#[test]
fn incompatible_modes_come_from_the_file_or_the_deck() {
    const MESH: &str = "\
*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
5, 0, 0, 1
6, 1, 0, 1
7, 1, 1, 1
8, 0, 1, 1
9, 2, 0, 0
10, 2, 1, 0
11, 2, 0, 1
12, 2, 1, 1
*ELEMENT, TYPE=C3D8I
1, 1, 2, 3, 4, 5, 6, 7, 8
*ELEMENT, TYPE=C3D8
2, 2, 9, 10, 3, 6, 11, 12, 7
";
    let directory = std::env::temp_dir().join(format!("diffuse-contact-modes-{}", std::process::id()));
    std::fs::create_dir_all(&directory).unwrap();
    std::fs::write(directory.join("two.inp"), MESH).unwrap();
    let text = |part: &str| {
        format!(
            "[materials.m]\nyoung = 1.0\npoisson = 0.3\n[parts.two]\n{part}\nmaterial = \"m\"\n[[boundary]]\n\
             nodes = \"two\"\nfix = [\"x\"]\n[time]\nincrement = 1.0\n"
        )
    };
    let model = |part: &str| Deck::parse(&text(part)).unwrap().model(&directory).unwrap();
    let modes = |part: &str| -> Vec<bool> {
        model(part).bodies[0].elements.iter().map(|cell| cell.incompatible_modes).collect()
    };
    assert_eq!(modes("file = \"two.inp\""), [true, false]);
    assert_eq!(modes("file = \"two.inp\"\nelement = \"hex8i\""), [true, true]);
    assert_eq!(modes("file = \"two.inp\"\nelement = \"hex8\""), [false, false]);
    let shape = "shape = \"box\"\nsize = [1.0, 1.0, 1.0]\ndivisions = [2, 1, 1]";
    assert_eq!(modes(shape), [false, false]);
    assert_eq!(modes(&format!("{shape}\nelement = \"hex8i\"")), [true, true]);
    // A run goes on with the elements it began with.
    let fingerprint = |part: &str| model(part).fingerprint();
    assert_ne!(fingerprint("file = \"two.inp\""), fingerprint("file = \"two.inp\"\nelement = \"hex8\""));
    let error = Deck::parse(&text("file = \"two.inp\"\nelement = \"hex20\"")).unwrap_err().to_string();
    assert!(error.contains("hex8i"), "{error}");
    std::fs::remove_dir_all(&directory).unwrap();
}
