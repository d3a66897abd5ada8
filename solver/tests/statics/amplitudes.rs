//! Increments end at the points of amplitudes.

use super::*;

/// `LOADED` with an amplitude of its pressure.
fn pressed(amplitude: &str) -> String {
    LOADED.replace("value = 20.0", &format!("value = 20.0\namplitude = {amplitude}"))
}

fn times(notes: &Notes) -> Vec<f64> {
    notes.increments.iter().map(|record| record.time).collect()
}

fn assert_close(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    let far = found.iter().zip(expected).find(|(found, expected)| (*found - *expected).abs() > 1e-12);
    assert!(far.is_none(), "{found:?}");
}

/// A load that comes and goes within one increment is there.
#[test]
fn no_point_is_stepped_over() {
    for fixed in ["", "\nfixed = true"] {
        let base = pressed("[[0, 0], [0.05, 1], [0.1, 0]]");
        let (notes, _, _) = run(&base, &format!("[time]\nend = 0.3\nincrement = 0.1{fixed}"));
        assert_close(&times(&notes), &[0.05, 0.1, 0.2, 0.3]);
        let forces: Vec<f64> = notes.increments.iter().map(|record| record.contacts[0].force[2]).collect();
        // Pressure 20 on an area of 2.
        assert!((forces[0] - 40.0).abs() < 1e-3, "{forces:?}");
        assert!(forces[1..].iter().all(|force| force.abs() < 1e-3), "{forces:?}");
    }
}

/// Those of motions and of their rotations, too, and they are met exactly.
#[test]
fn motions_stop_increments_as_well() {
    let moved = "translate = [0.3, 0.0, -0.2]";
    let rotation = "rotate = { axis = [0.0, 0.0, 1.0], point = [2.0, 1.0, 0.0], degrees = 2.0, \
                    amplitude = [[0.0, 0.0], [0.17, 1.0]] }";
    let turned = format!("{moved}\n{rotation}\namplitude = [[0.0, 0.0], [0.33, 0.2], [7.0, 1.0]]");
    let base = PRESSED.replace(moved, &turned);
    let (notes, _, _) = run(&base, "[time]\nend = 0.5\nincrement = 0.1");
    let times = times(&notes);
    assert_close(&times, &[0.1, 0.17, 0.27, 0.33, 0.43, 0.5]);
    assert!(times.contains(&0.17) && times.contains(&0.33) && times.last() == Some(&0.5), "{times:?}");
}

/// What was planned before a point is planned again after it, and an easy increment that was shortened does not count as one of its
/// planned length.
#[test]
fn a_shortened_increment_is_no_reason_to_stay_short() {
    let lengths = |amplitude: &str, time: &str| -> Vec<f64> {
        let (notes, _, _) = run(&pressed(amplitude), time);
        notes.increments.iter().map(|record| record.length).collect()
    };
    let growing = "[time]\nincrement = 0.1\nmaximum = 0.4\ngrowth = 2.0";
    assert_close(&lengths("[[0, 0], [1, 1]]", growing), &[0.1, 0.2, 0.4, 0.3]);
    assert_close(&lengths("[[0, 0], [0.11, 0.1], [1, 1]]", growing), &[0.1, 0.01, 0.2, 0.4, 0.29]);
    // More than half as long as it was planned: twice that is more than was planned.
    assert_close(&lengths("[[0, 0], [0.25, 0.2], [1, 1]]", growing), &[0.1, 0.15, 0.3, 0.4, 0.05]);
    // Points that are met anyway change nothing, to rounding: 0.1 + 0.2 is not 0.3.
    assert_close(&lengths("[[0, 0], [0.1, 0.1], [0.3, 0.3], [1, 1]]", growing), &[0.1, 0.2, 0.4, 0.3]);
    let tenths = "[[0, 0], [0.3, 1], [0.7000000000001, 0.5], [0.9999999999, 1]]";
    assert_close(&lengths(tenths, "[time]\nincrement = 0.1"), &[0.1; 10]);
}

/// A line through the piece before a point says nothing of what comes after it.
#[test]
fn nothing_is_extrapolated_from_a_shortened_increment() {
    let base = pressed("[[0, 0], [0.2001, 1], [1, 0.5]]");
    let newton = "[newton]\nextrapolation = \"linear\"";
    let (notes, _, _) = run(&base, &format!("[time]\nincrement = 0.1\n{newton}"));
    let with_past = notes.states.iter().map(|state| state.past.is_some());
    let short: Vec<f64> =
        notes.states.iter().zip(with_past).filter(|(_, has)| !has).map(|(state, _)| state.time).collect();
    assert_eq!(short, [0.2001]);
}

/// A restart between points leads to the same end: what was planned is in the state.
#[test]
fn a_run_goes_on_between_points_as_if_it_had_not_stopped() {
    let base = pressed("[[0, 0], [0.13, 1], [0.52, 0.2], [0.6, 1]]");
    let time = "[time]\nincrement = 0.1\nmaximum = 0.3\n[newton]\nextrapolation = \"linear\"";
    let (deck, model) = deck(&base, time);
    let (notes, end, _) = run(&base, time);
    assert!([0.13, 0.52, 0.6].iter().all(|point| times(&notes).contains(point)), "{:?}", times(&notes));
    for state in &notes.states {
        let read: State = serde_json::from_str(&serde_json::to_string(state).unwrap()).unwrap();
        assert_eq!(statics(&deck, &model).run(read, &mut Notes::default()).unwrap(), end);
    }
}
