//! Planes of symmetry that boundary conditions speak of are proposed, with the line for the deck.

use std::path::Path;

use diffuse_contact::surface::SymmetryPlane;
use diffuse_contact_solver::contact::Beginning;
use diffuse_contact_solver::deck::{Contact, Deck};
use diffuse_contact_solver::solve::statics;

/// What is proposed for each interface of a deck.
fn proposed(deck: &Deck) -> Vec<Beginning> {
    let model = deck.model(Path::new("")).unwrap();
    let statics = statics(deck, &model, 1).unwrap();
    let problem = statics.problem();
    problem.contacts().interactions().iter().map(|own| Beginning::of(own, &model, problem)).collect()
}

fn line(deck: &Deck) -> Option<String> {
    proposed(deck).remove(0).symmetry
}

fn example(name: &str) -> Deck {
    Deck::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples").join(name)).unwrap()
}

#[test]
fn planes_that_the_deck_does_not_name_are_proposed() {
    let mut deck = example("pipe_pinch.toml");
    assert_eq!(line(&deck).as_deref(), Some("symmetry = [\"x\", \"y\", \"z\"]"));
    let note = proposed(&deck)[0].notes();
    assert!(
        note.len() == 1 && note[0].contains("add `symmetry = [") && note[0].contains("plate on pipe"),
        "{note:?}"
    );
    // Those that it names are in the line, and of no further note.
    deck.interfaces[0].symmetry = vec![SymmetryPlane::across(1, [0.0; 3])];
    assert_eq!(line(&deck).as_deref(), Some("symmetry = [\"y\", \"x\", \"z\"]"));
    deck.interfaces[0].symmetry = [0, 1, 2].map(|axis| SymmetryPlane::across(axis, [0.0; 3])).to_vec();
    assert_eq!(line(&deck), None);
    // Facets need none.
    deck.interfaces[0].symmetry.clear();
    assert_eq!(line(&Deck { contact: Contact::NodeToFacet, ..deck }), None);
    // A plane beside the origin.
    let ring = line(&example("ring_block.toml"));
    let beside = "symmetry = [\"x\", { point = [0.0, 0.0, -5.0], normal = [0.0, 0.0, 1.0] }]";
    assert_eq!(ring.as_deref(), Some(beside));
}

/// A plane that no border lies in is a mistake, and no line proposes it again.
#[test]
fn a_plane_where_nothing_ends_is_named() {
    let mut deck = example("pipe_pinch.toml");
    let far = SymmetryPlane::across(2, [0.0, 0.0, -3.0]);
    deck.interfaces[0].symmetry = vec![SymmetryPlane::across(1, [0.0; 3]), far];
    let found = proposed(&deck).remove(0);
    assert_eq!(found.symmetry.as_deref(), Some("symmetry = [\"y\", \"x\", \"z\"]"));
    let plane = "{ point = [0.0, 0.0, -3.0], normal = [0.0, 0.0, 1.0] }";
    assert_eq!(found.idle_planes, [plane]);
    let warnings = found.warnings();
    assert!(
        warnings.iter().any(|warning| warning.contains("plate on pipe") && warning.contains(plane)),
        "{warnings:?}"
    );
    deck.interfaces[0].symmetry = [0, 1, 2].map(|axis| SymmetryPlane::across(axis, [0.0; 3])).to_vec();
    let found = proposed(&deck).remove(0);
    assert!(found.idle_planes.is_empty());
    // The slave alone goes on beyond the plane.
    let mut deck = stacked(SOFT, "", -0.5);
    deck.interfaces[0].symmetry = vec![SymmetryPlane::across(0, [0.0; 3])];
    let model = deck.model(Path::new("")).unwrap();
    let error = statics(&deck, &model, 1).err().unwrap().to_string();
    assert!(error.contains("behind symmetry plane 0, seen from the master"), "{error}");
}

/// Mirror images would pull such nodes apart.
#[test]
fn a_plane_that_nodes_may_leave_is_named() {
    let free = |side: &str, axis: usize| {
        let mut deck = stacked(SOFT, side, 0.0);
        deck.interfaces[0].symmetry = vec![SymmetryPlane::across(axis, [0.0; 3])];
        let found = proposed(&deck).remove(0);
        let told =
            found.warnings().iter().filter(|warning| warning.contains("free to move out of it")).count();
        assert_eq!(told, found.free_planes.len());
        found.free_planes
    };
    // Five nodes of the floor's border, three of the block's.
    assert_eq!(free("", 0), [("\"x\"".to_owned(), 8)]);
    assert_eq!(free("[[boundary]]\nnodes = \"block.x-\"\nfix = [\"x\"]\n", 0), [("\"x\"".to_owned(), 5)]);
    let both = "[[boundary]]\nnodes = [\"floor.x-\", \"block.x-\"]\nfix = [\"x\"]\n";
    assert!(free(both, 0).is_empty());
    // Others than those along the axis hold nothing.
    assert_eq!(free(both, 1), [("\"y\"".to_owned(), 7)]);
}

/// Rollers over a half of a tube: over faces the tube's own surface ends in the plane, if they cross it.
#[test]
fn planes_that_a_rigid_master_crosses_are_named_over_faces() {
    let text =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/squeezed_tube.toml"));
    let of = |text: &str| proposed(&Deck::parse(text).unwrap());
    let text = text.unwrap();
    let faces = text.replace("slave = \"tube.outer\"", "slave = \"tube.outer\"\nintegration = \"faces\"");
    assert!(of(&text).iter().all(|own| own.crossed_planes.is_empty()));
    let found = of(&faces);
    // The slice is straight along x: where it ends, the rollers may go on.
    let crossed: Vec<&[String]> = found.iter().map(|own| &own.crossed_planes[..]).collect();
    let y = ["\"y\"".to_owned()];
    assert_eq!(crossed, [&y[..], &y, &[]]);
    let notes = found[0].notes();
    assert!(
        notes.iter().any(|note| note.contains("cut the master at the plane and add `symmetry = [\"y\"]`")),
        "{notes:?}"
    );
    // Rollers that end in it.
    let cut = faces.replace("[0.0, 180.0]", "[0.0, 90.0]").replace("[180.0, 360.0]", "[270.0, 360.0]");
    assert_ne!(cut, faces);
    let found = of(&cut);
    assert!(found.iter().all(|own| own.crossed_planes.is_empty()));
    assert_eq!(found[0].symmetry.as_deref(), Some("symmetry = [\"y\"]"));
}

/// A floor that deforms.
const SOFT: &str = "shape = \"box\"\nsize = [3.0, 2.0, 1.0]\ndivisions = [6, 4, 2]\nmaterial = \"soft\"";

/// A block on a floor, from x = `origin` on. `side`: boundaries.
fn stacked(floor: &str, side: &str, origin: f64) -> Deck {
    let text = format!(
        r#"
[materials.soft]
young = 1000.0
poisson = 0.3
[parts.floor]
{floor}
[parts.block]
shape = "box"
origin = [{origin:?}, 0.5, 1.0]
size = [1.0, 1.0, 1.0]
divisions = [2, 2, 2]
material = "soft"
{side}
[[boundary]]
nodes = "block.z+"
translate = ["free", "free", -0.1]
[[interface]]
name = "floor"
master = "{}"
slave = "block.z-"
penalty = 500.0
[time]
increment = 1.0
"#,
        if floor.contains("rigid") { "floor" } else { "floor.z+" }
    );
    Deck::parse(&text).unwrap()
}

#[test]
fn clamped_edges_and_rigid_floors_are_no_planes_of_symmetry() {
    const RIGID: &str =
        "shape = \"rigid-plane\"\nsize = [3.0, 2.0]\ndivisions = [6, 4]\ntranslate = [0.0, 0.0, 1.0]";
    let held = |nodes: &str, axes: &str| format!("[[boundary]]\nnodes = [{nodes}]\nfix = [{axes}]\n");
    let fixed = held("\"floor\"", "\"x\", \"y\", \"z\"");
    let x = Some("symmetry = [\"x\"]".to_owned());
    for (floor, side, origin, expected) in [
        // The block's nodes in the plane are free to leave it.
        (SOFT, held("\"floor.x-\"", "\"x\""), 0.0, &None),
        (SOFT, held("\"floor.x-\", \"block.x-\"", "\"x\""), 0.0, &x),
        // The block has no nodes in the plane, and does not cross it.
        (SOFT, held("\"floor.x-\"", "\"x\""), 1.0, &x),
        (SOFT, held("\"floor.x-\"", "\"x\""), -0.5, &None),
        (SOFT, held("\"floor.x-\"", "\"x\", \"y\", \"z\""), 1.0, &None),
        (RIGID, fixed.clone(), 1.0, &None),
        (RIGID, fixed.clone() + &held("\"block.x-\"", "\"x\""), 0.0, &x),
        (RIGID, fixed.clone() + &held("\"block.x-\"", "\"x\""), 1.0, &None),
    ] {
        assert_eq!(line(&stacked(floor, &side, origin)), *expected, "{floor} {side} {origin}");
    }
    // A plane at the other end has its normal towards the model.
    let far = line(&stacked(SOFT, &held("\"floor.x+\"", "\"x\""), 1.0));
    assert_eq!(far.as_deref(), Some("symmetry = [{ point = [3.0, 0.0, 0.0], normal = [-1.0, 0.0, 0.0] }]"));
}
