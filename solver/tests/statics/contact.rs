//! What contact promises over increments: augmentation, two passes, pairing, losses.

use super::*;

#[test]
fn the_augmented_lagrangian_reduces_penetration_and_keeps_the_force() {
    let time = "[time]\nincrement = 0.5";
    let (penalty, ..) = run(LOADED, time);
    let augmented = LOADED.replace(
        "penalty = 500.0",
        "penalty = 500.0\nmethod = \"augmented-lagrangian\"\naugmentation = { tolerance = 1e-5, max = 30 }",
    );
    let (augmented, state, _) = run(&augmented, time);
    for (plain, augmented) in penalty.increments.iter().zip(&augmented.increments) {
        assert!(plain.max_penetration > 1e-3 && plain.augmentations == 0);
        assert!(augmented.max_penetration <= 1e-5, "{}", augmented.max_penetration);
        assert!((1..30).contains(&augmented.augmentations) && !augmented.is_short);
        // Half of p A, then all of it.
        let load = 40.0 * augmented.time;
        for record in [plain, augmented] {
            let force = record.contacts[0].force;
            assert!((force[2] - load).abs() < 1e-4 * load, "{force:?} {load}");
        }
    }
    let sum: f64 = state.multipliers[0].iter().sum();
    assert!((sum - 40.0).abs() < 0.05 * 40.0, "{sum}");
}

/// Far from equilibrium −f M of a stiff penalty leads nowhere: the same increments fail with it in every iteration.
#[test]
fn the_adaptive_tangent_gets_through_with_a_stiff_penalty() {
    let base = PRESSED.replace("2000.0", "2e4");
    let more = "[time]\nincrement = 0.5\nfixed = true";
    let (notes, state, _) = run(&base, more);
    assert_eq!((state.cutbacks, state.increments), (0, 2));
    for record in &notes.increments {
        assert!(record.iterations <= 8, "{record:?}");
        // With all of the tangent at the end: quadratic.
        let [.., before, last] = &record.history[..] else { panic!("{record:?}") };
        assert!(last.relative < 1e-2 * before.relative, "{record:?}");
    }
}

const AUGMENTED: &str =
    "penalty = 500.0\nmethod = \"augmented-lagrangian\"\naugmentation = { tolerance = 1e-5, max = 60 }";

/// Multipliers of a larger load hold contacts together that have opened: they have to come down.
#[test]
fn the_augmented_lagrangian_closes_gaps_after_unloading() {
    let unloaded = LOADED
        .replace("penalty = 500.0", AUGMENTED)
        .replace("value = 20.0", "value = 20.0\namplitude = [[0.0, 0.0], [0.5, 1.0], [1.0, 0.05]]");
    let (notes, _, statics) = run(&unloaded, "[time]\nincrement = 0.5");
    let last = notes.increments.last().unwrap();
    assert!(!last.is_short && last.augmentations > 0);
    assert!((last.contacts[0].force[2] - 2.0).abs() < 1e-3, "{:?}", last.contacts);
    let interaction = &statics.problem().contacts().interactions()[0];
    let loaded: Vec<_> = interaction.slaves().filter(|slave| slave.force > 0.0).collect();
    assert!(loaded.len() > 4 && loaded.iter().all(|slave| slave.gap.unwrap().abs() <= 1e-5), "{loaded:?}");
}

/// A round is measured by what its multipliers put out of balance, and is easy or hard by its own iterations.
#[test]
fn rounds_of_augmentation_are_judged_one_by_one() {
    let held = LOADED
        .replace("penalty = 500.0", &AUGMENTED.replace("60", "4"))
        .replace("value = 20.0", "value = 20.0\namplitude = [[0.0, 0.0], [0.625, 1.0], [1.0, 1.0]]");
    let more = "[time]\nincrement = 0.25\nmaximum = 0.4\ngrowth = 1.5\n[newton]\ntolerance = 1e-12";
    let (notes, state, _) = run(&held, more);
    assert_eq!(state.cutbacks, 0);
    for record in &notes.increments {
        assert_eq!(record.history.len(), record.iterations + 1 + record.augmentations);
        assert!(record.longest_round <= 6 && record.augmentations > 0, "{record:?}");
    }
    assert!(notes.increments[0].iterations > 6);
    assert!(notes.increments[1].length > notes.increments[0].length);
    // Nothing has changed when the last one begins: its first residuals say nothing about the rounds, also not after a step.
    let last = notes.increments.last().unwrap();
    let first = last.history[..2].iter().map(|record| record.residual).fold(0.0, f64::max);
    assert!(last.history.iter().any(|record| record.step > 0.0 && record.residual > 1e6 * first));
}

#[test]
fn rounds_of_augmentation_end_at_their_number() {
    let augmented = LOADED.replace(
        "penalty = 500.0",
        "penalty = 500.0\nmethod = \"augmented-lagrangian\"\naugmentation = { tolerance = 1e-13, max = 2 }",
    );
    let (notes, ..) = run(&augmented, "[time]\nincrement = 1.0");
    assert_eq!(notes.increments[0].augmentations, 2);
    assert!(notes.increments[0].is_short);
    assert!(notes.increments[0].max_penetration > 1e-13);
}

#[test]
fn two_passes_share_the_force_and_lose_none_of_it() {
    let deformable = LOADED
        .replace("shape = \"rigid-plane\"\nsize = [3.0, 2.0]\ndivisions = [6, 4]", 
            "shape = \"box\"\nsize = [3.0, 2.0, 0.5]\ndivisions = [5, 4, 1]\nmaterial = \"soft\"\ntranslate = [0.0, 0.0, -0.5]")
        .replace("nodes = \"floor\"\nfix", "nodes = \"floor.z-\"\nfix")
        .replace("master = \"floor\"", "master = \"floor.z+\"");
    let time = "[time]\nincrement = 0.5";
    let (one, ..) = run(&deformable, time);
    let (two, state, statics) = run(&deformable.replace("penalty =", "two_pass = true\npenalty ="), time);
    for notes in [&one, &two] {
        let force = notes.increments.last().unwrap().contacts[0].force;
        assert!((force[2] - 40.0).abs() < 1e-3 && force[0].abs() < 1e-2, "{force:?}");
    }
    assert_eq!(state.multipliers.len(), 2);
    let interaction = &statics.problem().contacts().interactions()[0];
    let nodes_of_block = 4 * 3 * 3;
    let share = |of_block: bool| -> f64 {
        let own = interaction.slaves().filter(|slave| (slave.node < nodes_of_block) == of_block);
        own.map(|slave| slave.force).sum()
    };
    let (own, others) = (share(true), share(false));
    assert!(own > 4.0 && others > 4.0 && (own + others - 40.0).abs() < 0.1, "{own} {others}");
    assert!(two.increments[1].active > one.increments[1].active);
}

/// Paired anew in every iteration, an increment ends with the pairing of where it ends.
#[test]
fn a_pairing_per_iteration_belongs_to_the_end_of_the_increment() {
    let more = "[time]\nincrement = 0.5\n[newton]\ntolerance = 1e-9";
    let at_end = |refresh: &str| {
        let base = PRESSED.replace(
            "penalty = 2000.0",
            &format!("penalty = 2000.0\n{HULL_LAYERS}\nrefresh = \"{refresh}\""),
        );
        let (_, state, mut statics) = run(&base, more);
        let forces = statics.problem().contacts().resultants(&state.positions);
        statics.look_at_contacts(&state).unwrap();
        (forces, statics.problem().contacts().resultants(&state.positions))
    };
    let (before, after) = at_end("iteration");
    assert_eq!(before, after);
    let (before, after) = at_end("increment");
    assert_ne!(before, after, "the block slides by 0.2 in an increment");
}

/// Seen from what an increment was solved with, rounds of augmentation included, its end has the forces it was found with.
#[test]
fn an_increment_begins_from_what_the_last_one_was_solved_with() {
    let friction =
        "friction = { coefficient = 0.6, stiffness = 200.0, augmentation = { tolerance = 1e-6, max = 60 } }";
    let base = PRESSED
        .replace("penalty = 2000.0", &format!("penalty = 2000.0\nintegration = \"faces\"\n{friction}"))
        .replace("translate = [0.3, 0.0, -0.2]", "translate = [0.03, 0.0, -0.2]");
    let (notes, state, mut statics) = run(&base, "[time]\nincrement = 0.5\n[newton]\ntolerance = 1e-9");
    assert!(notes.increments.iter().all(|record| record.augmentations > 0));
    let forces = |statics: &Statics| statics.problem().contacts().resultants(&state.positions)[0].force;
    let found = notes.increments.last().unwrap().contacts[0].force;
    let mut before = state.clone();
    before.friction[0].anchors = before.friction[0].anchors_before.clone();
    statics.look_at_contacts(&before).unwrap();
    let again = forces(&statics);
    let error = size([0, 1, 2].map(|axis| again[axis] - found[axis]));
    assert!(error < 1e-6 * size(found), "{again:?} {found:?}");
}

/// Pairings that change at refreshes, and end where their nodes do.
const HULL_LAYERS: &str = "neighbours = { rule = \"hull-layers\" }";

/// Pressed at first, then slid: at once it is too far for the fits.
fn slid(minimum: &str) -> (String, String) {
    let base = PRESSED.replace(
        "translate = [0.3, 0.0, -0.2]",
        "translate = [0.0, 0.0, -0.2]\namplitude = [[0.0, 0.0], [0.4, 1.0]]",
    );
    let base = base.replace(
        "nodes = \"wave\"\nfix = [\"x\", \"y\", \"z\"]",
        "nodes = \"wave\"\ntranslate = [-2.4, 0.0, 0.0]\namplitude = [[0.0, 0.0], [0.4, 0.0], [1.0, 1.0]]",
    );
    let base = base.replace("penalty = 2000.0", &format!("penalty = 2000.0\n{HULL_LAYERS}"));
    (base, format!("[time]\nincrement = 0.2\nmaximum = 0.6\ngrowth = 3.0\n{minimum}"))
}

/// A slender beam that a rigid nose bends aside. When the step to the nose's next place opens all contacts nothing but the nose is in
/// the beam's way back, and beyond its middle no slave has an element.
const BENT_ASIDE: &str = r#"
[materials.abs]
young = 2300.0
poisson = 0.38

[parts.beam]
shape = "box"
size = [20.0, 1.0, 2.0]
divisions = [20, 1, 2]
material = "abs"

[parts.nose]
shape = "rigid-cylinder"
axis = "z"
radius = 1.0
length = 6.0
divisions = [36, 6]
translate = [14.0, 2.05, -2.0]

[[boundary]]
nodes = "beam.x-"
fix = ["x", "y", "z"]

[[boundary]]
nodes = "nose"
translate = [1.0, -4.0, 0.0]

[[interface]]
name = "nose"
master = "nose"
slave = "beam.y+"
penalty = 1000.0
"#;

#[test]
fn a_slender_body_does_not_spring_through_a_rigid_one() {
    for (increment, count) in [("0.1", 10), ("0.2", 5)] {
        let (notes, state, _) = run(BENT_ASIDE, &format!("[time]\nincrement = {increment}\nfixed = true"));
        assert_eq!((state.cutbacks, state.increments), (0, count), "{:?}", notes.reasons);
        for record in &notes.increments {
            let is_held = record.active > 0 && record.lost == 0 && record.max_penetration < 1e-3;
            assert!(is_held, "{increment} {record:?}");
        }
    }
}

#[test]
fn an_increment_that_loses_contacts_under_load_is_cut() {
    let (base, time) = slid("");
    let (notes, ..) = run(&base, &time);
    assert!(notes.reasons.iter().any(|reason| reason.starts_with("Lost")), "{:?}", notes.reasons);
    assert!(notes.increments.iter().all(|record| record.lost == 0 && record.active > 0));
}

/// Where no shorter increment is allowed the run goes on without them, and says how many there were.
#[test]
fn contacts_lost_in_the_shortest_increment_are_counted() {
    let (base, time) = slid("minimum = 0.2\ncutback = 0.3");
    let (notes, end, _) = attempt(&base, &time, Notes { stop_after: Some(3), ..Notes::default() });
    end.unwrap();
    assert!(notes.reasons.iter().all(|reason| !reason.starts_with("Lost")), "{:?}", notes.reasons);
    let lost: Vec<usize> = notes.increments.iter().map(|record| record.lost).collect();
    assert!(lost[..2] == [0, 0] && lost[2] > 0, "{lost:?} {:?}", notes.reasons);
}

/// What has no element as soon as it is paired is lost whatever the length of the increment, also if that is extrapolated.
#[test]
fn contacts_lost_at_pairing_cut_no_increment() {
    // Hardly a fit is as regular as that: slaves have no element.
    const NEVER: &str = r#"
[[interface]]
name = "never"
master = "floor"
slave = "block.z-"
penalty = 500.0
neighbours = { rule = "hull-layers", regularity = 0.99 }

[time]
increment = 0.25
"#;
    for extrapolation in ["none", "linear"] {
        let more = format!("{NEVER}\n[newton]\nextrapolation = \"{extrapolation}\"");
        let notes = Notes { stop_after: Some(2), ..Notes::default() };
        let (_, state, mut statics) = attempt(LOADED, &more, notes);
        let mut state = state.unwrap();
        assert_eq!(state.past.is_some(), extrapolation == "linear");
        let slaves = statics.problem().contacts().interactions()[1].slaves();
        let failed = slaves.zip(0..).filter(|(slave, _)| slave.has_failed);
        state.loaded[1] = failed.map(|(_, place)| place).collect();
        let lost = state.loaded[1].len();
        let mut notes = Notes { stop_after: Some(3), ..Notes::default() };
        let end = statics.run(state, &mut notes).unwrap();
        assert!(lost > 1, "{lost}");
        assert_eq!(
            (end.cutbacks, notes.increments[0].lost),
            (0, lost),
            "{extrapolation}: {:?}",
            notes.reasons
        );
    }
}
