//! Whole problems, small: what the increments and iterations promise.

mod amplitudes;
mod contact;
mod linear;
mod scale;
mod second_order;
mod slender;
mod start;

use std::path::Path;

use diffuse_contact_solver::contact::FrictionHistory;
use diffuse_contact_solver::deck::Deck;
use diffuse_contact_solver::model::Model;
use diffuse_contact_solver::solve;
use diffuse_contact_solver::statics::*;

/// Notes everything.
#[derive(Default)]
struct Notes {
    iterations: Vec<IterationRecord>,
    increments: Vec<IncrementRecord>,
    states: Vec<State>,
    cuts: Vec<(f64, f64)>,
    /// Why there were cuts.
    reasons: Vec<String>,
    stop_at_cut: bool,
    stop_after: Option<usize>,
}

impl Observer for Notes {
    fn iteration(&mut self, record: &IterationRecord) {
        self.iterations.push(*record);
    }

    fn cut_back(&mut self, end: f64, length: f64, reason: &Failure) -> Control {
        self.cuts.push((end, length));
        self.reasons.push(format!("{reason:?}"));
        if self.stop_at_cut { Control::Stop } else { Control::Continue }
    }

    fn increment(
        &mut self,
        record: &IncrementRecord,
        state: &State,
        _: &Problem,
    ) -> Result<Control, Box<dyn std::error::Error + Send + Sync>> {
        self.increments.push(record.clone());
        self.states.push(state.clone());
        Ok(if self.stop_after == Some(record.number) { Control::Stop } else { Control::Continue })
    }
}

/// A plastic block on a rigid wave: pressed into it, then pushed along.
const PRESSED: &str = include_str!("../block_on_wave.toml");

/// The same with the exact tangent in every iteration: large increments fail.
fn pressed_hard() -> String {
    PRESSED.replace("penalty = 2000.0", "penalty = 2000.0\ntangent = \"exact\"")
}

fn deck(base: &str, more: &str) -> (Deck, Model) {
    let deck = Deck::parse_named(&format!("{base}\n{more}"), Path::new("deck")).unwrap();
    let model = deck.model(Path::new("")).unwrap();
    (deck, model)
}

fn statics(deck: &Deck, model: &Model) -> Statics {
    solve::statics(deck, model, 1).unwrap()
}

/// Runs until it ends, one way or another.
fn attempt(base: &str, more: &str, mut notes: Notes) -> (Notes, Result<State, StaticsError>, Statics) {
    let (deck, model) = deck(base, more);
    let mut statics = statics(&deck, &model);
    let start = statics.problem().start();
    let end = statics.run(start, &mut notes);
    (notes, end, statics)
}

/// Runs to the end of time.
fn run(base: &str, more: &str) -> (Notes, State, Statics) {
    let (notes, end, statics) = attempt(base, more, Notes::default());
    (notes, end.unwrap(), statics)
}

/// Runs in vain.
fn fail(base: &str, more: &str) -> (Notes, StaticsError, Statics) {
    let (notes, end, statics) = attempt(base, more, Notes::default());
    (notes, end.unwrap_err(), statics)
}

fn size(vector: [f64; 3]) -> f64 {
    vector.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[test]
fn time_reaches_its_end_exactly() {
    for (end, increment, count) in [("0.3", "0.1", 3), ("0.7", "0.1", 7), ("1.0", "0.3", 4)] {
        let time = format!("[time]\nend = {end}\nincrement = {increment}\nfixed = true");
        let (notes, state, _) = run(LOADED, &time);
        assert_eq!((state.time, state.increments), (end.parse().unwrap(), count));
        let times: Vec<f64> = notes.increments.iter().map(|record| record.time).collect();
        assert!(times.is_sorted_by(|one, next| one < next), "{times:?}");
        let lengths: f64 = notes.increments.iter().map(|record| record.length).sum();
        assert!((lengths - state.time).abs() < 1e-12);
    }
}

/// An increment that fails is repeated with half the length and leaves nothing behind: from then on all is as if it had never been tried.
#[test]
fn nothing_of_a_failed_increment_stays() {
    let augmented = "method = \"augmented-lagrangian\"\naugmentation = { tolerance = 1e-3, max = 3 }";
    let faces = format!("integration = \"faces\"\nfriction = 0.2\n{augmented}");
    // With the most iterations and rounds of an increment.
    let layers = "neighbours = { rule = \"hull-layers\" }\nrefresh = \"iteration\"";
    for (fields, most, rounds) in [("", 5, 1), (layers, 5, 1), (&faces, 3, 4)] {
        let base = pressed_hard().replace("penalty = 2000.0", &format!("penalty = 2000.0\n{fields}"));
        let newton = format!("[newton]\nmax_iterations = {most}\ntolerance = 1e-8");
        // The run to the end of its first increment.
        let first_increment = |time: &str| {
            let notes = Notes { stop_after: Some(1), ..Notes::default() };
            let (notes, end, statics) = attempt(&base, &format!("{newton}\n[time]\n{time}"), notes);
            (notes, end.unwrap(), statics.effort())
        };
        let (cut, after_cut, effort) = first_increment("increment = 0.5\ngrowth = 1.0\nminimum = 0.01");
        assert!(!cut.cuts.is_empty() && after_cut.cutbacks == cut.cuts.len());
        assert_eq!(cut.cuts[0], (0.5, 0.5));
        let first = cut.increments[0].length;
        assert_eq!(first, 0.5_f64.powi(1 + cut.cuts.len() as i32));
        // The same lengths without a failure.
        let (notes, state, _) = first_increment(&format!("increment = {first}\nfixed = true"));
        let known = &cut.states[0];
        assert_eq!(state.positions, known.positions);
        assert_eq!(state.points, known.points);
        assert_eq!(state.loaded, known.loaded);
        assert_eq!(state.multipliers, known.multipliers);
        assert_eq!(state.friction, known.friction);
        let has_history = rounds > 1;
        assert_eq!(state.multipliers.concat().iter().any(|&own| own > 0.0), has_history);
        assert_eq!(state.friction[0].dissipated > 0.0, has_history);
        assert_eq!(notes.increments[0].history, cut.increments[0].history);
        // The price is known: as many iterations in each round, and half as many more of whole steps.
        let in_vain = known.iterations - state.iterations;
        let most = (most + most / 2) * rounds * known.cutbacks;
        assert!(in_vain >= known.cutbacks && in_vain <= most, "{in_vain} {}", known.cutbacks);
        assert_eq!(effort, Effort { iterations: known.iterations, cutbacks: known.cutbacks });
    }
}

#[test]
fn easy_increments_let_the_next_ones_grow_to_the_largest() {
    let time = "[time]\nincrement = 0.02\nmaximum = 0.1\ngrowth = 2.0\n[newton]\ntolerance = 1e-4";
    let (notes, state, _) = run(PRESSED, time);
    let lengths: Vec<f64> = notes.increments.iter().map(|record| record.length).collect();
    assert_eq!(state.cutbacks, 0);
    for (record, next) in notes.increments.iter().zip(&lengths[1..]) {
        let planned = if record.iterations <= 6 { 2.0 } else { 1.0 } * record.length;
        let last = state.time - record.time;
        assert!((next - planned.min(0.1).min(last)).abs() < 1e-12, "{lengths:?}");
    }
    assert!(lengths.iter().any(|&length| (length - 0.1).abs() < 1e-12), "{lengths:?}");
}

#[test]
fn the_smallest_increment_that_fails_ends_the_run_and_keeps_what_there_is() {
    // The first half is easy: nothing moves. Then one iteration is not enough for any length.
    let base = PRESSED.replace(
        "translate = [0.3, 0.0, -0.2]",
        "translate = [0.3, 0.0, -0.2]\namplitude = [[0.0, 0.0], [0.5, 0.0], [1.0, 1.0]]",
    );
    let (notes, error, statics) = fail(
        &base.replace("0.5, 0.1]", "0.5, 0.11]"),
        "[newton]\nmax_iterations = 1\nline_search = false\n[time]\nincrement = 0.25\nminimum = 0.05\ngrowth = 1.0",
    );
    let StaticsError::NoConvergence { time, length, minimum, reason } = &error else { panic!("{error}") };
    assert_eq!((*time, *length, *minimum), (0.5, 0.0625, 0.05));
    assert!(matches!(**reason, Failure::Iterations { iterations: 1, .. }), "{reason:?}");
    // The last one is not tried again.
    assert_eq!(notes.cuts, [(0.75, 0.25), (0.625, 0.125)]);
    assert_eq!(notes.states.len(), 2);
    assert_eq!(notes.states[1].time, 0.5);
    assert_eq!(statics.effort(), Effort { iterations: 5, cutbacks: 2 });
    assert!(error.to_string().contains("after time 0.5"), "{error}");
    // Sums of increments leave digits behind that say nothing.
    let StaticsError::NoConvergence { length, minimum, reason, .. } = error else { unreachable!() };
    let summed = StaticsError::NoConvergence { time: 0.1 + 0.2, length, minimum, reason };
    assert!(summed.to_string().starts_with("no convergence after time 0.3: "), "{summed}");
}

#[test]
fn contact_that_cannot_be_evaluated_is_a_failed_increment() {
    let base = PRESSED
        .replace("fix = [\"x\", \"y\", \"z\"]", "translate = [0.0, 0.0, -1e80]")
        .replace("translate = [0.3, 0.0, -0.2]", "fix = [\"x\", \"y\", \"z\"]");
    let (notes, error, ..) = fail(&base, "[time]\nincrement = 0.5");
    let StaticsError::NoConvergence { reason, .. } = error else { panic!("{error}") };
    assert!(matches!(*reason, Failure::Contact(_)), "{reason}");
    assert!(notes.cuts.len() > 3 && notes.increments.is_empty());
}

#[test]
fn the_last_increment_is_cut_by_its_own_length() {
    // Planned 0.4, the last one is 0.2 long: half of it is 0.1.
    let base = PRESSED
        .replace("[0.3, 0.0, -0.2]", "[0.3, 0.0, -0.2]\namplitude = [[0.0, 0.0], [0.8, 0.0], [1.0, 1.0]]");
    let (notes, error, ..) = fail(
        &base.replace("0.5, 0.1]", "0.5, 0.11]"),
        "[newton]\nmax_iterations = 1\n[time]\nincrement = 0.4\nminimum = 0.08\ngrowth = 1.0",
    );
    let StaticsError::NoConvergence { length, .. } = error else { panic!("{error}") };
    let [(_, first)] = notes.cuts[..] else { panic!("{:?}", notes.cuts) };
    assert!((first - 0.2).abs() < 1e-12 && (length - 0.1).abs() < 1e-12, "{first} {length}");
}

#[test]
fn an_increment_has_converged_when_the_rule_says_so() {
    let (deck, model) = deck(PRESSED, "[newton]\ntolerance = 1e-5\n[time]\nincrement = 0.25");
    let mut statics = statics(&deck, &model);
    let mut notes = Notes::default();
    let start = statics.problem().start();
    statics.run(start, &mut notes).unwrap();
    let problem = statics.problem();
    let absolute = problem.solid().rounding_of_forces(problem.start_positions());
    let converged = |record: &IterationRecord| {
        let scale = record.residual / record.relative.max(f64::MIN_POSITIVE);
        assert!((record.allowed - (1e-5 * scale + absolute)).abs() < 1e-12 * record.allowed);
        // Rounding is far below here.
        assert!(record.excess <= record.residual && record.excess > 0.999 * record.residual - 1e-9);
        record.excess <= record.allowed
    };
    for record in &notes.increments {
        let [before @ .., last] = &record.history[..] else { panic!("no residual") };
        assert!(converged(last), "{last:?}");
        // All but the first, which is of no iteration.
        assert!(before[1..].iter().all(|record| !converged(record)), "{before:?}");
        assert_eq!(last.iteration, record.iterations);
    }
    let record = notes.increments.last().unwrap();
    // Reactions and contact forces are in equilibrium.
    let sum: [f64; 3] = [0, 1, 2].map(|axis| record.reactions.iter().map(|reaction| reaction[axis]).sum());
    assert!(size(sum) < 1e-4 * size(record.reactions[0]), "{sum:?} {:?}", record.reactions);
    let apart: [f64; 3] = [0, 1, 2].map(|axis| record.contacts[0].force[axis] + record.reactions[1][axis]);
    assert!(size(apart) < 1e-4 * size(record.reactions[1]), "{record:?}");
}

/// The exact tangent of solid and contact: the digits double.
#[test]
fn newton_converges_quadratically_in_contact() {
    for (contact, weight) in [
        ("diffuse", "cubic"),
        ("diffuse", "cubic-interpolating"),
        ("diffuse", "wendland-c2"),
        ("node-to-facet", "cubic"),
    ] {
        let base = PRESSED
            .replace("yield_stress = 60.0\nhardening = 100.0\n", "")
            .replace("penalty = 2000.0", &format!("penalty = 2000.0\nweight = \"{weight}\""));
        let more =
            "[newton]\ntolerance = 1e-12\nabsolute = 0.0\nmax_iterations = 40\n[time]\nincrement = 0.25";
        let (notes, ..) = run(&format!("contact = \"{contact}\"\n{base}"), more);
        let mut pairs = 0;
        for record in &notes.increments {
            let history = &record.history[1..];
            for k in 1..history.len() {
                let [before, after] = [&history[k - 1], &history[k]];
                // Where Newton's method is in its last steps and rounding is not: the set of contacts stays.
                let is_late = before.relative < 1e-3 && before.relative > 1e-6;
                if is_late && before.active == after.active && after.step == 1.0 {
                    pairs += 1;
                    let order = after.relative.max(1e-14).ln() / before.relative.ln();
                    assert!(order > 1.6, "{contact} {weight}: {:?}", history);
                }
            }
        }
        assert!(pairs >= 2, "{contact} {weight}: {pairs}");
    }
}

#[test]
fn a_rotation_is_exact_and_carries_the_body_along() {
    let base = r#"
[materials.steel]
young = 200000.0
poisson = 0.3

[parts.bar]
shape = "box"
size = [4.0, 1.0, 1.0]
divisions = [4, 2, 2]
material = "steel"

[[boundary]]
nodes = ["bar.x-", "bar.x+"]
rotate = { axis = [0.0, 0.3, 1.0], point = [1.0, 2.0, 0.5], degrees = 110.0 }
"#;
    // Steps of 22 degrees: free nodes are predicted along tangents and have to be pulled back.
    let (deck, model) = deck(base, "[newton]\ntolerance = 1e-10\nabsolute = 1e-6\n[time]\nincrement = 0.2");
    let mut statics = statics(&deck, &model);
    let mut notes = Notes::default();
    let start = statics.problem().start();
    statics.run(start, &mut notes).unwrap();
    let motion = &deck.boundaries[0].motion;
    for state in &notes.states {
        for (node, (&x, &reference)) in state.positions.iter().zip(&model.nodes).enumerate() {
            let expected = motion.position(state.time, reference);
            if !statics.problem().supports().is_free(3 * node) {
                assert_eq!(x, expected);
            }
            assert!((0..3).all(|axis| (x[axis] - expected[axis]).abs() < 1e-9), "{x:?} {expected:?}");
        }
    }
    assert_eq!(notes.states.len(), 5);
    let reaction = notes.increments.last().unwrap().reactions[0];
    assert!(size(reaction) < 1e-6, "{reaction:?}");
}

/// A block with a pressure on top, on a rigid floor of quadrilaterals.
const LOADED: &str = r#"
[materials.soft]
young = 1000.0
poisson = 0.2

[parts.block]
shape = "box"
origin = [0.5, 0.5, -1e-6]
size = [2.0, 1.0, 1.0]
divisions = [3, 2, 2]
material = "soft"

[parts.floor]
shape = "rigid-plane"
size = [3.0, 2.0]
divisions = [6, 4]

[[boundary]]
nodes = "floor"
fix = ["x", "y", "z"]

[[boundary]]
nodes = "block.x-"
fix = ["x"]

[[boundary]]
nodes = "block.y-"
fix = ["y"]

[[pressure]]
surface = "block.z+"
value = 20.0

[[interface]]
name = "floor"
master = "floor"
slave = "block.z-"
penalty = 500.0
"#;

#[test]
fn a_run_goes_on_from_any_state_to_the_same_end() {
    let augmented = "method = \"augmented-lagrangian\"\naugmentation = { tolerance = 1e-3, max = 3 }";
    for (more, newton) in [
        ("refresh = \"increment\"", ""),
        ("refresh = \"increment\"", "extrapolation = \"linear\""),
        ("refresh = \"iteration\"\nneighbours = { rule = \"hull-layers\" }", ""),
        ("frame = \"held\"\nneighbours = { rule = \"hull-layers\" }", ""),
        (augmented, ""),
    ] {
        let base = PRESSED.replace("penalty = 2000.0", &format!("penalty = 2000.0\n{more}"));
        let newton =
            format!("[time]\nincrement = 0.1\nmaximum = 0.3\n[newton]\nmax_iterations = 12\n{newton}");
        let (deck, model) = deck(&base, &newton);
        let mut whole = Notes::default();
        let mut statics = self::statics(&deck, &model);
        let start = statics.problem().start();
        let end = statics.run(start, &mut whole).unwrap();
        assert!(end.points.iter().any(|point| point.equivalent_plastic_strain > 0.0), "it yields");
        for state in &whole.states {
            // Through the text of a restart, into a problem that knows of nothing.
            let text = serde_json::to_string(state).unwrap();
            let read: State = serde_json::from_str(&text).unwrap();
            assert_eq!(read, *state);
            let mut fresh = self::statics(&deck, &model);
            fresh.check_state(&read).unwrap();
            assert_eq!(fresh.run(read, &mut Notes::default()).unwrap(), end, "{more}");
            assert_eq!(fresh.effort(), statics.effort());
        }
    }
}

#[test]
fn extrapolation_saves_linear_solutions_and_changes_nothing_else() {
    let run = |rule: &str| {
        let more =
            format!("[time]\nincrement = 0.05\n[newton]\ntolerance = 1e-10\nextrapolation = \"{rule}\"");
        run(PRESSED, &more)
    };
    let (none, by_step, _) = run("none");
    let (linear, extrapolated, _) = run("linear");
    assert!(by_step.past.is_none() && extrapolated.past.is_some());
    // There is nothing to go on from in the first increment.
    assert_eq!(linear.increments[0].iterations, none.increments[0].iterations);
    assert!(extrapolated.iterations + 10 < by_step.iterations);
    for (one, other) in extrapolated.positions.iter().zip(&by_step.positions) {
        for (a, b) in one.iter().zip(other) {
            assert!((a - b).abs() < 1e-8, "{a} {b}");
        }
    }
}

/// The direction turns in a corner there: the next increment begins with the linear step.
#[test]
fn after_a_failure_nothing_is_extrapolated() {
    let more =
        "[time]\nincrement = 0.5\nmaximum = 0.5\n[newton]\nmax_iterations = 5\nextrapolation = \"linear\"";
    let (notes, state, _) = run(&pressed_hard(), more);
    assert!(!notes.cuts.is_empty() && state.cutbacks == notes.cuts.len());
    for &(end, _) in &notes.cuts {
        let again = notes.increments.iter().find(|record| record.time > end - 0.5).unwrap();
        assert!(again.time < end);
        // The residual at its beginning is the first of its records.
        assert_eq!(again.history.len(), again.iterations + 1);
    }
}

#[test]
fn a_run_is_stopped_at_a_cut() {
    let (deck, model) = deck(&pressed_hard(), "[newton]\nmax_iterations = 5\n[time]\nincrement = 0.5");
    let mut statics = statics(&deck, &model);
    let start = statics.problem().start();
    let mut notes = Notes { stop_at_cut: true, ..Notes::default() };
    let state = statics.run(start.clone(), &mut notes).unwrap();
    assert!(notes.cuts.len() == 1 && state.time < 1.0);
    // It goes on as if it had not been stopped.
    let mut whole = Notes::default();
    let end = statics.run(start, &mut whole).unwrap();
    assert_eq!(statics.run(state, &mut Notes::default()).unwrap(), end);
}

/// Forces of a stiff body are rounded by more than all there is in a soft one: it is solved all the same.
#[test]
fn a_stiff_part_does_not_excuse_a_soft_one() {
    let with_tool = format!(
        "{LOADED}\n{}",
        r#"
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
    let (notes, ..) =
        run(&with_tool, "[time]\nincrement = 0.5\n[newton]\ntolerance = 1e-14\nabsolute = 1e-6");
    for record in &notes.increments {
        let (force, load) = (record.contacts[0].force[2], 40.0 * record.time);
        assert!((force - load).abs() < 1e-5, "{force} {load}");
        let last = record.history.last().unwrap();
        // Without the tool's rounding nothing would be left.
        assert!(last.residual > 1e-3 && last.excess < 2e-6, "{last:?}");
    }
}

#[test]
fn a_state_of_another_problem_is_refused() {
    let (one, model) = deck(PRESSED, "[time]\nincrement = 0.5");
    let mut statics = self::statics(&one, &model);
    let mut state = statics.problem().start();
    state.positions.pop();
    let error = statics.check_state(&state).unwrap_err();
    assert!(
        matches!(error, StaticsError::ForeignState { what: "nodes", found: 88, expected: 89 }),
        "{error}"
    );
    let mut state = statics.problem().start();
    state.multipliers.clear();
    assert!(matches!(statics.check_state(&state), Err(StaticsError::Contact(_))));
    // A law that asks for the speed of sliding would divide by it.
    let mut state = statics.problem().start();
    state.friction = vec![FrictionHistory { anchors_before: vec![0.0], ..FrictionHistory::default() }];
    let error = statics.check_state(&state).unwrap_err();
    let what = "length of the last increment";
    assert!(matches!(error, StaticsError::StateOutOfRange { what: found, .. } if found == what), "{error}");
}

#[test]
fn a_setting_out_of_range_is_named() {
    let (deck, model) = deck(PRESSED, "[time]\nincrement = 0.5");
    let problem = || solve::problem(&deck, &model, 1).unwrap();
    let good = solve::settings(&deck);
    type Spoil = fn(&mut Settings);
    let spoilt: [(Spoil, &str); 7] = [
        (|settings| settings.time.end = f64::NAN, "time.end"),
        (|settings| settings.time.minimum = 0.0, "time.minimum"),
        (|settings| settings.time.minimum = 1e-10 * settings.time.end, "time.minimum"),
        (|settings| settings.time.cutback = 1.0, "time.cutback"),
        (|settings| settings.time.growth = 0.5, "time.growth"),
        (|settings| settings.newton.tolerance = -1.0, "newton.tolerance"),
        (|settings| settings.newton.max_iterations = 0, "newton.max_iterations"),
    ];
    for (spoil, expected) in spoilt {
        let mut settings = good;
        spoil(&mut settings);
        let Err(StaticsError::Setting { name, .. }) = Statics::new(problem(), settings) else {
            panic!("{expected}")
        };
        assert_eq!(name, expected);
    }
}

#[test]
fn a_body_that_nothing_holds_fails_and_says_why() {
    let loose = LOADED.replace("nodes = \"block.y-\"\nfix = [\"y\"]", "nodes = \"block.x-\"\nfix = [\"x\"]");
    let (_, error, ..) = fail(&loose, "[time]\nincrement = 0.5\nminimum = 0.3");
    // A contact carries force: the increment was tried again, in vain.
    let StaticsError::NoConvergence { reason, .. } = &error else { panic!("{error}") };
    let Failure::Singular { loose, .. } = &**reason else { panic!("{error}") };
    let motions = vec![RigidMotion::Translation([0.0, 1.0, 0.0])];
    assert_eq!(
        loose[..],
        [Loose { parts: vec!["block".to_owned()], motions, averaged: Vec::new() }],
        "{error}"
    );
}
