//! What residuals are measured by.

use super::*;

/// A second body, all of it held, deep in a rigid floor: its own or that of the block.
fn with_anvil(base: &str, floor: &str, more: &str) -> String {
    format!(
        r#"{base}
[parts.anvil]
shape = "box"
origin = [2.6, 0.6, -0.01]
size = [0.3, 0.8, 0.5]
divisions = [1, 1, 1]
material = "soft"

[parts.base]
shape = "rigid-plane"
size = [3.0, 2.0]
divisions = [6, 4]

[[boundary]]
nodes = "base"
fix = ["x", "y", "z"]

[[boundary]]
nodes = "anvil"
{more}

[[interface]]
name = "anvil"
master = "{floor}"
slave = "anvil.z-"
penalty = 1e6
"#
    )
}

const FIXED: &str = "fix = [\"x\", \"y\", \"z\"]";

/// Forces between nodes that are all prescribed are the deck's, as large as it likes: they excuse no residual. They are told all the same.
#[test]
fn contact_that_moves_nothing_is_no_scale() {
    let time = "[time]\nincrement = 0.5";
    let over_faces = LOADED.replace("penalty = 500.0", "penalty = 500.0\nintegration = \"faces\"");
    let (nodes, faces) = (with_anvil(LOADED, "floor", FIXED), with_anvil(&over_faces, "base", FIXED));
    let faces = faces.replace("penalty = 1e6", "penalty = 1e6\nintegration = \"faces\"");
    for (alone, both, force) in [(LOADED, nodes, 4e4), (&over_faces, faces, 2.4e3)] {
        let ((alone, ..), (both, ..)) = (run(alone, time), run(&both, time));
        for (alone, both) in alone.increments.iter().zip(&both.increments) {
            assert_eq!(alone.iterations, both.iterations);
            for (alone, both) in alone.history.iter().zip(&both.history) {
                assert!((both.allowed / alone.allowed - 1.0).abs() < 1e-6, "{alone:?} {both:?}");
                assert!((both.relative - alone.relative).abs() < 1e-6 * alone.relative.max(1e-6), "{both:?}");
            }
            let found = both.contacts[1].force[2];
            assert!((found / force - 1.0).abs() < 1e-6, "{found} {force}");
            assert!((both.contacts[0].force[2] / alone.contacts[0].force[2] - 1.0).abs() < 1e-9);
        }
    }
}

/// What acts on prescribed degrees of freedom, from outside or from elements without a free one, moves nothing either.
#[test]
fn loads_and_strains_that_move_nothing_are_no_scale() {
    let time = "[time]\nincrement = 0.5";
    let loaded =
        format!("{}[[pressure]]\nsurface = \"anvil.z+\"\nvalue = 1e6\n", with_anvil(LOADED, "base", FIXED));
    let halves = format!("{FIXED}\n[[boundary]]\nnodes = \"anvil.z+\"\ntranslate = [0.0, 0.0, 2.0]");
    let strained = with_anvil(LOADED, "base", &halves).replace("nodes = \"anvil\"", "nodes = \"anvil.z-\"");
    let (alone, ..) = run(LOADED, time);
    for deck in [loaded, strained] {
        let (both, ..) = run(&deck, time);
        for (alone, both) in alone.increments.iter().zip(&both.increments) {
            for (alone, both) in alone.history[1..].iter().zip(&both.history[1..]) {
                assert!((both.allowed / alone.allowed - 1.0).abs() < 1e-6, "{alone:?} {both:?}");
            }
        }
    }
}

/// A body that the deck takes through its floor, all nodes of both prescribed, loses nothing that a shorter increment would keep.
#[test]
fn prescribed_bodies_lose_no_contact() {
    let moved = "translate = [0.0, 0.0, -4.0]\namplitude = [[0.0, 0.0], [0.5, 0.01], [1.0, 1.0]]";
    let deck = with_anvil(LOADED, "base", moved);
    let deck = deck.replace("penalty = 1e6", "penalty = 1e6\ndistance_limit = 0.3");
    let (notes, state, _) = run(&deck, "[time]\nincrement = 0.5");
    assert_eq!((state.cutbacks, state.increments), (0, 2), "{:?}", notes.reasons);
    let [touching, through] = &notes.increments[..] else { panic!("two increments") };
    assert!(touching.contacts[1].force[2] > 0.0 && through.contacts[1].force[2] == 0.0);
    assert!(notes.increments.iter().all(|record| record.lost == 0 && record.vanished.is_empty()));
}

/// The same in other units: residuals that count as none are those of the model, not of newtons.
#[test]
fn small_forces_are_solved_as_well_as_large_ones() {
    let in_units_of = |unit: f64| {
        let scaled = |text: &str, name: &str, value: f64| {
            text.replace(&format!("{name} = {value:?}"), &format!("{name} = {:e}", value * unit))
        };
        let text = scaled(LOADED, "young", 1000.0);
        let text = scaled(&scaled(&text, "value", 20.0), "penalty", 500.0);
        run(&text, "[time]\nincrement = 0.5")
    };
    let (newtons, ..) = in_units_of(1.0);
    for unit in [1e-12, 1e12] {
        let (notes, ..) = in_units_of(unit);
        for (record, expected) in notes.increments.iter().zip(&newtons.increments) {
            assert_eq!(record.iterations, expected.iterations, "{unit:e}");
            let force = record.contacts[0].force[2] / unit;
            assert!((force / expected.contacts[0].force[2] - 1.0).abs() < 1e-9, "{unit:e}: {force}");
        }
    }
    // 1e-8 where E = 2e5, and the model is 100 long in elements of 1.
    let large = LOADED.replace("young = 1000.0", "young = 2e5").replace(
        "size = [2.0, 1.0, 1.0]\ndivisions = [3, 2, 2]",
        "size = [100.0, 2.0, 2.0]\ndivisions = [100, 2, 2]",
    );
    let (deck, model) = deck(&large, "[time]\nincrement = 0.5");
    let problem = solve::problem(&deck, &model, 1).unwrap();
    let rounding = problem.solid().rounding_of_forces(problem.start_positions());
    assert!((rounding / 1e-8 - 1.0).abs() < 1e-9, "{rounding:e}");
}

/// A soft strip that bends far beside a stiff block whose forces are a hundred million times its own.
#[test]
fn a_part_is_in_equilibrium_by_itself() {
    let alone = r#"
[materials.soft]
young = 1000.0
poisson = 0.0

[parts.arm]
shape = "box"
size = [10.0, 1.0, 0.5]
divisions = [10, 1, 1]
material = "soft"

[[boundary]]
nodes = "arm.x-"
fix = ["x", "y", "z"]

[[pressure]]
surface = "arm.z+"
value = 0.02
"#;
    let both = format!(
        r#"{alone}
[materials.stiff]
young = 2e9
poisson = 0.3

[parts.block]
shape = "box"
origin = [20.0, 0.0, 0.0]
size = [1.0, 1.0, 1.0]
divisions = [2, 2, 2]
material = "stiff"

[[boundary]]
nodes = "block.z-"
fix = ["x", "y", "z"]

[[boundary]]
nodes = "block.z+"
translate = [0.0, 0.0, -0.01]
"#
    );
    let time = "[time]\nincrement = 1.0";
    let (_, alone, _) = run(alone, time);
    let deflection = alone.positions.iter().map(|x| x[2]).fold(f64::INFINITY, f64::min);
    assert!(deflection < -0.5, "{deflection}");
    for solver in ["direct", "iterative"] {
        let (notes, both, _) = run(&both, &format!("{time}\n[newton]\nlinear_solver = \"{solver}\""));
        let last = notes.increments[0].history.last().unwrap();
        assert!(last.allowed > 1.0, "more than the load of the arm: {last:?}");
        for (alone, both) in alone.positions.iter().zip(&both.positions) {
            let is_near = (0..3).all(|axis| (alone[axis] - both[axis]).abs() < 2e-3);
            assert!(is_near, "{solver}: {alone:?} {both:?}");
        }
    }
}
