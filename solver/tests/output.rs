//! What is written means what it says.

use std::collections::BTreeSet;
use std::path::Path;

use diffuse_contact::surface::tributary_areas;
use diffuse_contact_solver::contact::Integration;
use diffuse_contact_solver::deck::{Contact, Deck, Interface};
use diffuse_contact_solver::output::Fields;
use diffuse_contact_solver::verification::trace;

/// The contact pressures of the patch test at the nodes of the lower and of the upper surface, and the areas of those nodes.
fn pressures(contact: Contact, two_pass: bool) -> [Vec<(f64, f64)>; 2] {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/patch_test.toml");
    let mut deck = Deck { contact, ..Deck::read(path).unwrap() };
    deck.interfaces[0].two_pass = two_pass;
    let model = deck.model(Path::new("")).unwrap();
    let sides = deck.sides(&model, &deck.interfaces[0]).unwrap();
    let areas = tributary_areas(&model.nodes, &[sides.slave, sides.master].concat()).unwrap();
    let measure = |snapshot: &diffuse_contact_solver::verification::Snapshot<'_>| {
        let fields = Fields::of(snapshot.problem, snapshot.state);
        let at = |set: &str| {
            let nodes = &model.node_sets[set];
            nodes.iter().map(|&node| (fields.contact_pressure[node], areas[node])).collect::<Vec<_>>()
        };
        Ok(["lower.z+", "upper.z-"].map(at))
    };
    trace(&deck, Path::new(""), 1, measure).unwrap().measures.pop().unwrap()
}

fn force(side: &[(f64, f64)]) -> f64 {
    side.iter().map(|(pressure, area)| pressure * area).sum()
}

/// 100 MPa on 100 mm²: each of the two surfaces carries all of it, not only what its nodes have as slaves.
#[test]
fn two_passes_give_the_pressure_and_not_half_of_it() {
    for (contact, scatter) in [(Contact::NodeToFacet, 0.02), (Contact::Diffuse, 0.21)] {
        for side in pressures(contact, true) {
            assert!((force(&side) / 1e4 - 1.0).abs() < 1e-5, "{contact:?}: {}", force(&side));
            let largest = side.iter().map(|(p, _)| (p / 100.0 - 1.0).abs()).fold(0.0, crate::common::worse);
            println!("{contact:?} {largest}");
            assert!(largest < scatter, "{contact:?}: {largest}");
        }
    }
}

/// One pass: the slaves carry all of it, the masters are no slaves. Normals of the bent surface are not all along the load.
#[test]
fn one_pass_gives_the_pressure_at_the_slaves() {
    for contact in [Contact::NodeToFacet, Contact::Diffuse] {
        let [master, slave] = pressures(contact, false);
        assert!((force(&slave) / 1e4 - 1.0).abs() < 1e-4, "{contact:?}: {}", force(&slave));
        assert_eq!(force(&master), 0.0);
    }
}

/// The pressures at the nodes of these sets at the end of a deck.
fn pressures_at(deck: &Deck, sets: &[&str]) -> Vec<f64> {
    let model = deck.model(Path::new("")).unwrap();
    let measure = |snapshot: &diffuse_contact_solver::verification::Snapshot<'_>| {
        let fields = Fields::of(snapshot.problem, snapshot.state);
        let nodes = sets.iter().flat_map(|&set| &model.node_sets[set]);
        Ok(nodes.map(|&node| fields.contact_pressure[node]).collect::<Vec<_>>())
    };
    trace(deck, Path::new(""), 1, measure).unwrap().measures.pop().unwrap()
}

fn largest_error(pressures: &[f64], exact: f64) -> f64 {
    pressures.iter().map(|pressure| (pressure / exact - 1.0).abs()).fold(0.0, crate::common::worse)
}

/// Degrees of the smooth surface under the slaves of a block on a floor of so many rows of cells, and all others that are not 0.
fn degrees(contact: Contact, rows: usize) -> (Vec<i32>, usize) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/patch_test.toml");
    let mut deck = Deck { contact, ..Deck::read(path).unwrap() };
    let divisions = deck.shape_mut("lower").unwrap().divisions_mut();
    (divisions[0], divisions[1]) = (rows, rows);
    let model = deck.model(Path::new("")).unwrap();
    let slaves: BTreeSet<usize> = {
        let sides = deck.sides(&model, &deck.interfaces[0]).unwrap();
        sides.slave.iter().flat_map(|facet| facet.corners().to_vec()).collect()
    };
    let measure = |snapshot: &diffuse_contact_solver::verification::Snapshot<'_>| {
        let fields = Fields::of(snapshot.problem, snapshot.state);
        let others = (0..model.nodes.len()).filter(|node| !slaves.contains(node));
        let count = others.filter(|&node| fields.contact_basis[node] != 0).count();
        Ok((slaves.iter().map(|&node| fields.contact_basis[node]).collect(), count))
    };
    trace(&deck, Path::new(""), 1, measure).unwrap().measures.pop().unwrap()
}

/// Where the master carries no quadratic surface the picture says so.
#[test]
fn slaves_have_the_degree_of_their_surface() {
    for (contact, rows, degree) in
        [(Contact::Diffuse, 4, 2), (Contact::Diffuse, 1, 1), (Contact::NodeToFacet, 4, 0)]
    {
        let (slaves, others) = degrees(contact, rows);
        assert!(
            slaves.iter().all(|&own| own == degree) && others == 0,
            "{contact:?} {rows}: {slaves:?} {others}"
        );
    }
}

/// Two blocks side by side on a third one, whose nodes are slaves of both: where they meet the pressure is neither of them twice.
#[test]
fn pressures_of_two_interfaces_do_not_add_up_where_they_meet() {
    let mut deck = Deck::parse(include_str!("partial_overlap.toml")).unwrap();
    deck.newton.tolerance = 1e-12;
    deck.interfaces.iter_mut().for_each(|interface| interface.exchange = true);
    let error = largest_error(&pressures_at(&deck, &["lower.z+"]), 10.0);
    assert!(error < 1e-7, "{error:e}");
}

/// One pair of surfaces under two names is one area.
#[test]
fn pressures_of_one_pair_under_two_names_add_up() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/patch_test.toml");
    let mut deck = Deck::read(path).unwrap();
    deck.interfaces[0].integration = Integration::FACES;
    deck.interfaces[0].surface.areas = false;
    let again = Interface { name: "again".to_owned(), ..deck.interfaces[0].clone() };
    deck.interfaces.push(again);
    deck.newton.tolerance = 1e-12;
    let error = largest_error(&pressures_at(&deck, &["upper.z-"]), 100.0);
    assert!(error < 1e-7, "{error:e}");
}

/// Nodes on the edges of the slave have a pressure for each sheet: what is shown and summed is what presses.
#[test]
fn nodes_on_edges_of_the_slave_have_the_pressure_of_the_pressed_face() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/patch_test.toml");
    let mut deck = Deck::parse(&std::fs::read_to_string(path).unwrap().replace(
        "slave = \"upper.z-\"",
        "slave = [\"upper.z-\", \"upper.x-\", \"upper.x+\", \"upper.y-\", \"upper.y+\"]",
    ))
    .unwrap();
    deck.interfaces[0].integration = Integration::FACES;
    deck.interfaces[0].surface.areas = false;
    deck.newton.tolerance = 1e-12;
    let error = largest_error(&pressures_at(&deck, &["upper.z-"]), 100.0);
    assert!(error < 1e-7, "{error:e}");
    let resultant = |snapshot: &diffuse_contact_solver::verification::Snapshot<'_>| {
        let slaves: Vec<usize> = snapshot.slaves().map(|slave| slave.node).collect();
        let repeated = slaves.windows(2).filter(|pair| pair[0] == pair[1]).count();
        Ok((repeated, snapshot.contact_force(), snapshot.record.contacts[0].normal))
    };
    let (repeated, force, normal) =
        trace(&deck, Path::new(""), 1, resultant).unwrap().measures.pop().unwrap();
    // The rim below, four edges upright, and corners in three sheets.
    assert!(repeated > 14, "{repeated}");
    assert!((force[2] / 1e4 - 1.0).abs() < 1e-9 && (normal / 1e4 - 1.0).abs() < 1e-9, "{force:?} {normal}");
}
