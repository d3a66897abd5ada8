//! Decks as they are written, and as they are miswritten.

use diffuse_contact::faces::{FacePressures, FaceRule};
use diffuse_contact::interface::ContactElement;
use diffuse_contact::neighbourhood::NeighbourRule;
use diffuse_contact::pairing::MAX_NEIGHBOURS;
use diffuse_contact::{FrameDerivative, Weight};

use diffuse_contact_solver::contact::{Augmentation, Integration, RefreshRule, TangentRule};
use diffuse_contact_solver::deck::*;
use diffuse_contact_solver::statics::{Extrapolation, NewtonSettings, TimeSettings};
use diffuse_contact_solver::system::LinearSolverChoice;

mod files;
mod pages;
mod refusals;

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

/// End, first increment, shortest, longest, growth, cut-back.
fn times(time: &TimeSettings) -> [f64; 6] {
    [time.end, time.increment, time.minimum, time.maximum, time.growth, time.cutback]
}

/// Line search, extrapolation, stabilisation, solver.
fn choices(newton: &NewtonSettings) -> (bool, Extrapolation, f64, LinearSolverChoice) {
    (newton.line_search, newton.extrapolation, newton.stabilisation, newton.linear_solver)
}

#[test]
fn a_deck_is_read_with_its_defaults() {
    let deck = Deck::parse(DECK).unwrap();
    assert_eq!((deck.title.as_str(), deck.contact), ("Block on a floor", Contact::Diffuse));
    let plasticity = deck.materials["steel"].plasticity().unwrap();
    assert_eq!((plasticity.yield_stress, plasticity.hardening), (400.0, 3450.0));
    assert_eq!(deck.parts.iter().map(|part| part.name.as_str()).collect::<Vec<_>>(), ["block", "floor"]);
    assert_eq!(deck.boundaries[1].axes, [true, false, true]);
    assert_eq!(deck.boundaries[1].motion.position(0.5, [0.0; 3]), [0.0, 0.0, -0.1]);
    assert_eq!(deck.pressures[0].amplitude.at(0.25), 0.25);
    assert_eq!(times(&deck.time), [1.0, 0.25, 0.25 / 1024.0, 0.25, 1.5, 0.5]);
    let NewtonSettings { tolerance, absolute, max_iterations, few_iterations, .. } = deck.newton;
    assert_eq!((tolerance, absolute, max_iterations, few_iterations), (1e-6, None, 20, 6));
    assert_eq!(choices(&deck.newton), (true, Extrapolation::None, 0.0, LinearSolverChoice::Auto));
    let fixed = Deck::parse(&changed("increment = 0.25", "increment = 0.25\nfixed = true")).unwrap().time;
    assert_eq!(times(&fixed), [1.0, 0.25, 0.25, 0.25, 1.0, 0.5]);
    assert_eq!(deck.output, Output::default());
    assert_eq!((deck.output.every, deck.output.stress, deck.output.colour), (1, true, Colour::VonMises));
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
    assert_eq!(supports.prescribed().into_iter().flatten().filter(|&axis| axis).count(), 16 * 3 + 9 * 2);
    let sides = deck.sides(&model, interface).unwrap();
    assert_eq!((sides.master.len(), sides.slave.len()), (9, 4));
    assert_eq!(deck.loads(&model).unwrap()[0].faces.len(), 4);
}

#[test]
fn contact_is_integrated_over_nodes_or_faces() {
    for (value, expected) in [
        ("\"nodes\"", Integration::Nodes),
        ("\"faces\"", Integration::FACES),
        ("{ over = \"nodes\" }", Integration::Nodes),
        ("{ over = \"faces\" }", Integration::FACES),
        (
            "{ over = \"faces\", degree = 4 }",
            Integration::Faces { rule: FaceRule::Fourth, pressures: FacePressures::Nodes },
        ),
        (
            "{ over = \"faces\", pressures = \"points\" }",
            Integration::Faces { rule: FaceRule::Second, pressures: FacePressures::Points },
        ),
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
    let points = "penalty = 1e5\nintegration = { over = \"faces\", pressures = \"points\" }";
    refused("penalty = 1e5", &points.replace("\"points\"", "\"faces\""), "nodes");
    refused("penalty = 1e5", &points.replace("faces", "nodes"), "over = \"nodes\"");
    let augmented = "\nmethod = \"augmented-lagrangian\"\naugmentation = { tolerance = 1e-3 }";
    refused("penalty = 1e5", &format!("{points}{augmented}"), "multipliers belong to nodes");
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
        frame = "held"
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
    assert_eq!(interface.augmentation, Some(Augmentation::new(1e-3).with_max_rounds(7)));
    let ContactElement::Diffuse { weight, frame, search, .. } = options.element else {
        panic!("not diffuse")
    };
    assert_eq!((weight, frame), (Weight::WendlandC2, FrameDerivative::Held));
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
    assert_eq!(times(&deck.time), [4.0, 0.5, 0.125, 1.0, 2.0, 0.25]);
    let NewtonSettings { tolerance, absolute, max_iterations, few_iterations, .. } = deck.newton;
    assert_eq!((tolerance, absolute, max_iterations, few_iterations), (1e-8, Some(0.0), 11, 6));
    assert_eq!(choices(&deck.newton), (false, Extrapolation::Linear, 0.0, LinearSolverChoice::Auto));
    assert_eq!((deck.output.every, deck.output.stress, deck.output.colour), (3, false, Colour::Gap));
    assert_eq!(deck.pressures[0].amplitude.at(2.5), 2.5);
    // Without an amplitude a motion lasts to the end.
    assert_eq!(deck.boundaries[1].motion.position(2.0, [0.0; 3]), [0.0, 0.0, -0.1]);

    let model = deck.model(".").unwrap();
    let sides = deck.sides(&model, interface).unwrap();
    assert_eq!((sides.master.len(), sides.slave.len()), (4, 9), "exchanged");
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
