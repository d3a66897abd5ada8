//! Surfaces in contact with themselves and with one another, without roles.

use std::path::Path;

use diffuse_contact::surface::tributary_areas;
use diffuse_contact_solver::contact::Integration;
use diffuse_contact_solver::deck::{Contact, Deck};
use diffuse_contact_solver::verification::{largest_kink, trace};

/// Runs a deck; increment by increment the normal force of its last interface, the deepest penetration, and where that interface
/// carries force.
fn run(deck: &Deck) -> Vec<(f64, f64, Vec<usize>)> {
    let run = trace(deck, Path::new(""), 1, |snapshot| {
        let contact = snapshot.record.contacts.last().unwrap();
        let force = contact.normal;
        // No plane of symmetry carries anything along the last two axes.
        assert!(contact.force[1..].iter().all(|x| x.abs() <= 1e-9 * (1.0 + force)), "{contact:?}");
        let interaction = snapshot.problem.contacts().interactions().last().unwrap();
        let loaded = interaction.slaves().filter(|slave| slave.force > 0.0).map(|slave| slave.node);
        Ok((force, snapshot.record.max_penetration, loaded.collect()))
    });
    let run = run.unwrap();
    println!("{} increments, {} iterations, {} cut-backs", run.measures.len(), run.iterations, run.cutbacks);
    run.measures
}

/// The walls of a tube meet, push one another apart, and penetrate by less than a hundredth of an element.
#[test]
fn walls_of_a_squeezed_tube_touch_one_another() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/squeezed_tube.toml");
    let cell = std::f64::consts::PI * 9.0 / 24.0;
    let ways = [
        (Contact::Diffuse, Integration::Nodes),
        (Contact::NodeToFacet, Integration::Nodes),
        (Contact::Diffuse, Integration::FACES),
    ];
    for (contact, integration) in ways {
        let mut deck = Deck { contact, ..Deck::read(&path).unwrap() };
        deck.interfaces.last_mut().unwrap().integration = integration;
        let run = run(&deck);
        let last = run.last().unwrap();
        let forces: Vec<f64> = run.iter().map(|(force, ..)| *force).collect();
        assert!(last.0 > 1.0 && forces[..10].iter().all(|&force| force == 0.0), "{forces:?}");
        assert!(forces.windows(2).all(|pair| pair[1] >= pair[0]), "{forces:?}");
        assert!(run.iter().all(|(_, depth, _)| *depth < 0.01 * cell), "{run:?}");
        let model = deck.model(Path::new("")).unwrap();
        let inner = |&node: &usize| {
            let [_, y, z] = model.nodes[node];
            (y.hypot(z) - 9.0).abs() < 1e-9
        };
        assert!(last.2.iter().all(inner), "{last:?}");
    }
}

/// Three rings with cores that are moved: one list of surfaces, each of which meets the other two.
#[test]
fn three_bodies_meet_without_roles() {
    let ring = |name: &str, y: f64, z: f64| {
        format!(
            "[parts.{name}]\nshape = \"pipe\"\naxis = \"x\"\ninner_radius = 3.0\nouter_radius = 4.0\nlength = 1.0\n\
             divisions = [24, 1, 1]\nmaterial = \"rubber\"\ntranslate = [0.0, {y}, {z}]\n"
        )
    };
    // Gaps of 0.02 between all of them.
    let height = 8.02 * 60f64.to_radians().sin();
    let rings = [ring("left", -4.01, 0.0), ring("right", 4.01, 0.0), ring("top", 0.0, height)].concat();
    let deck = format!(
        "[materials.rubber]\nyoung = 1000.0\npoisson = 0.3\n{rings}\
         [[boundary]]\nnodes = [\"left.bottom\", \"left.top\", \"right.bottom\", \"right.top\", \"top.bottom\", \"top.top\"]\nfix = [\"x\"]\n\
         [[boundary]]\nnodes = [\"left.inner\", \"right.inner\"]\nfix = [\"y\", \"z\"]\n\
         [[boundary]]\nnodes = \"top.inner\"\ntranslate = [\"free\", 0.0, -0.1]\n\
         [[interface]]\nname = \"rings\"\nself = [\"left.outer\", \"right.outer\", \"top.outer\"]\n\
         symmetry = [{{ point = [0, 0, 0], normal = [1, 0, 0] }}, {{ point = [1, 0, 0], normal = [-1, 0, 0] }}]\n\
         [time]\nincrement = 0.25\n"
    );
    let mut deck = Deck::parse_named(&deck, Path::new("rings")).unwrap();
    for integration in [Integration::Nodes, Integration::FACES] {
        deck.interfaces[0].integration = integration;
        let run = run(&deck);
        let (force, depth, loaded) = run.last().unwrap();
        let cell = std::f64::consts::TAU * 4.0 / 24.0;
        assert!(*force > 1.0 && *depth < 0.01 * cell, "{integration:?} {force} {depth}");
        let model = deck.model(Path::new("")).unwrap();
        for part in ["left", "right", "top"] {
            let own = loaded.iter().filter(|node| model.node_sets[part].contains(node)).count();
            assert!(own > 0, "{integration:?} {part} {loaded:?}");
        }
    }
}

/// A shipped deck with these divisions of its part, its own interface over faces: it runs to its end and penetrates by less than a
/// hundredth of an element, and what the surface exerts on itself is nothing. Its curve of force over time.
fn pressed(name: &str, part: &str, divisions: [usize; 3], increment: f64, contact: Contact) -> Vec<[f64; 2]> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples").join(name);
    let mut deck = Deck { contact, ..Deck::read(path).unwrap() };
    deck.shape_mut(part).unwrap().divisions_mut().copy_from_slice(&divisions);
    (deck.time.increment, deck.time.maximum) = (increment, increment);
    let own = deck.interfaces.iter().position(|interface| interface.self_contact).unwrap();
    let model = deck.model(Path::new("")).unwrap();
    let facets = deck.sides(&model, &deck.interfaces[own]).unwrap().master;
    let areas = tributary_areas(&model.nodes, &facets).unwrap();
    let size = (areas.iter().sum::<f64>() / facets.len() as f64).sqrt();
    let run = trace(&deck, Path::new(""), 1, |snapshot| {
        let contact = snapshot.record.contacts[own];
        assert!(contact.force.iter().all(|x| x.abs() <= 1e-12 * (1.0 + contact.normal)), "{contact:?}");
        let depth = snapshot.problem.contacts().interactions()[own].max_penetration();
        assert!(depth < 0.01 * size, "{depth} of {size} at {}", snapshot.record.time);
        Ok([snapshot.record.time, contact.normal])
    })
    .unwrap();
    println!("{name} {contact:?}: {} iterations, {} cut-backs", run.iterations, run.cutbacks);
    run.measures
}

/// The largest kink is that of the first touch, and smaller than over facets.
#[test]
fn legs_of_a_crushed_serpentine_touch_one_another() {
    let [smooth, facets] = [Contact::Diffuse, Contact::NodeToFacet].map(|contact| {
        let curve = pressed("crushed_serpentine.toml", "beam", [64, 2, 1], 0.04, contact);
        assert!(curve.last().unwrap()[1] > 0.5 && curve[10][1] == 0.0, "{curve:?}");
        largest_kink(&curve)
    });
    println!("{smooth} {facets}");
    assert!(smooth < facets, "{smooth} {facets}");
}

#[test]
fn coils_of_a_spring_touch_one_another() {
    let curve = pressed("coil_spring.toml", "spring", [48, 1, 2], 0.1, Contact::Diffuse);
    assert!(curve.last().unwrap()[1] > 10.0 && curve[3][1] == 0.0, "{curve:?}");
}

/// A clip that opens touches nothing, however far its walls look: facets far aside of a node are no place for it.
#[test]
fn a_clip_that_opens_touches_nothing() {
    for contact in ["diffuse", "node-to-facet"] {
        let deck = format!(
            r#"
contact = "{contact}"
[materials.m]
young = 1000.0
poisson = 0.0
[parts.u]
shape = "strip"
path = [{{ length = 20.0 }}, {{ radius = 3.0, degrees = 180.0 }}, {{ length = 20.0 }}]
thickness = 0.5
width = 1.0
divisions = [50, 1, 1]
element = "hex8i"
material = "m"
[[boundary]]
nodes = ["u.bottom", "u.top"]
fix = ["z"]
[[boundary]]
nodes = "u.start"
fix = ["x", "y"]
[[boundary]]
nodes = "u.end"
translate = ["free", 8.0, 0.0]
[[interface]]
name = "walls"
self = ["u.left", "u.right"]
symmetry = ["z", {{ point = [0, 0, 1], normal = [0, 0, -1] }}]
distance_limit = 30.0
[time]
increment = 0.1
"#
        );
        let run = run(&Deck::parse(&deck).unwrap());
        assert!(
            run.iter().all(|(force, depth, loaded)| *force == 0.0 && *depth == 0.0 && loaded.is_empty()),
            "{run:?}"
        );
    }
}
