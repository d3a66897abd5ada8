//! Faces in windows from C: the bits of the whole surfaces, or an outcome that says that they cannot be known.

use std::ptr::{null, null_mut};

use super::faces::law;
use super::{message, options};
use crate::faces::*;
use crate::faces_friction::{dc_faces_accept, dc_faces_friction};
use crate::faces_window::{dc_faces_add_quadratic_by_number, dc_faces_create_in_window};
use crate::interface::{dc_create, dc_destroy, dc_interface};
use crate::law::dc_law;
use crate::options::dc_options;
use crate::outcome::dc_outcome;
use crate::status::{DC_BAD_HANDLE, DC_BAD_OPTION, DC_BAD_SIZE, DC_OK, DC_OUT_OF_RANGE, dc_status};
use crate::window::{dc_window, dc_window_counts, dc_window_create, dc_window_destroy, dc_window_names};

const LIMIT: f64 = 0.4;
/// Nodes along a side of the master and of the slave.
const SIDES: [usize; 2] = [15, 13];

/// Two wavy surfaces, the second one just in the first and seen from below.
struct Pair {
    positions: Vec<f64>,
    facets: [Vec<i32>; 2],
}

impl Pair {
    fn new() -> Self {
        let height = |x: f64, y: f64| 0.1 * (0.7 * x).sin() * (0.9 * y).cos();
        let mut positions = Vec::new();
        let mut facets = [Vec::new(), Vec::new()];
        for (which, side) in SIDES.into_iter().enumerate() {
            let first = (positions.len() / 3) as i32;
            for k in 0..side * side {
                let [i, j] = [(k % side) as f64, (k / side) as f64];
                let [x, y] = if which == 0 { [0.5 * i, 0.5 * j] } else { [0.45 + 0.51 * i, 0.4 + 0.52 * j] };
                positions.extend([x, y, height(x, y) - 0.02 * which as f64]);
            }
            let n = side as i32;
            for corner in (0..(n - 1) * (n - 1)).map(|k| first + k % (n - 1) + n * (k / (n - 1))) {
                let [a, b, c, d] = [corner, corner + 1, corner + n + 1, corner + n];
                facets[which].extend(if which == 0 { [a, b, c, d] } else { [a, d, c, b] });
            }
        }
        Self { positions, facets }
    }

    fn nodes(&self) -> usize {
        self.positions.len() / 3
    }

    /// An interface without slaves, to cut windows of one side from.
    fn side(&self, which: usize) -> *mut dc_interface {
        let (facets, mut handle) = (&self.facets[which], null_mut());
        let (options, positions) = (limited(), self.positions.as_ptr());
        // SAFETY: the arrays have the lengths given.
        let status = unsafe {
            let (own, count) = (facets.as_ptr(), facets.len() / 4);
            dc_create(positions, self.nodes(), own, count, null(), 0, null(), 0, &options, &mut handle)
        };
        assert_eq!(status, DC_OK, "{}", message());
        handle
    }
}

fn limited() -> dc_options {
    dc_options { distance_limit: LIMIT, ..options() }
}

/// What a node has: outcome, stick or slip, and gap, pressure, area and traction in bits.
type Node = ([i32; 2], [u64; 6]);

fn rubbing() -> dc_law {
    dc_law { friction: 0.3, ..law(&[]) }
}

/// Nodes by their place, after the slave, which begins with the node `first`, was accepted and has slid.
fn nodes(faces: *mut dc_faces, positions: &[f64], first: usize) -> Vec<(i32, Node)> {
    let mut count = 0;
    let slide = |(k, x): (usize, &f64)| {
        let way = if k % 3 == 0 { 0.006 + 0.004 * x.sin() } else { 0.0 };
        if k < 3 * first { *x } else { x + way }
    };
    let slid: Vec<f64> = positions.iter().enumerate().map(slide).collect();
    // SAFETY: the arrays have the lengths given.
    unsafe {
        assert_eq!(dc_faces_counts(faces, null_mut(), &mut count), DC_OK);
        let [mut slaves, mut outcomes, mut states] = [0, 9, 9].map(|blank| vec![blank; count]);
        let mut tractions = vec![0.0; 3 * count];
        let [mut gaps, mut pressures, mut areas] = [(); 3].map(|()| vec![0.0; count]);
        let number = positions.len() / 3;
        assert_eq!(dc_faces_slaves(faces, slaves.as_mut_ptr(), count), DC_OK);
        assert_eq!(dc_faces_refresh(faces, positions.as_ptr(), number, null_mut()), DC_OK, "{}", message());
        let accepted =
            dc_faces_accept(faces, &rubbing(), null_mut(), null_mut(), null_mut(), null_mut(), null_mut());
        assert_eq!(accepted, DC_OK, "{}", message());
        assert_eq!(dc_faces_refresh(faces, slid.as_ptr(), number, null_mut()), DC_OK, "{}", message());
        assert_eq!(dc_faces_evaluate(faces, &rubbing(), 0), DC_OK, "{}", message());
        let [of_gaps, of_pressures, of_areas] =
            [&mut gaps, &mut pressures, &mut areas].map(|x| x.as_mut_ptr());
        let of_outcomes = outcomes.as_mut_ptr();
        let status =
            dc_faces_contacts(faces, of_outcomes, of_gaps, of_pressures, of_areas, null_mut(), count);
        assert_eq!(status, DC_OK);
        let (of_states, of_tractions) = (states.as_mut_ptr(), tractions.as_mut_ptr());
        assert_eq!(dc_faces_friction(faces, of_states, of_tractions, null_mut(), count), DC_OK);
        let bits = |k: usize| {
            let [x, y, z] = [0, 1, 2].map(|axis| tractions[3 * k + axis]);
            [gaps[k], pressures[k], areas[k], x, y, z].map(f64::to_bits)
        };
        (0..count).map(|k| (slaves[k], ([outcomes[k], states[k]], bits(k)))).collect()
    }
}

/// A window of these boxes with the numbers of its nodes.
fn window(whole: *mut dc_interface, boxes: &[f64]) -> (*mut dc_window, Vec<i64>) {
    let (mut window, mut count) = (null_mut(), 0);
    // SAFETY: the arrays have the lengths given.
    unsafe {
        let status = dc_window_create(whole, boxes.as_ptr(), boxes.len() / 6, 0.0, &mut window);
        assert_eq!(status, DC_OK, "{}", message());
        assert_eq!(dc_window_counts(window, &mut count, null_mut(), null_mut(), null_mut()), DC_OK);
        let mut names = vec![0; count];
        assert_eq!(dc_window_names(window, names.as_mut_ptr(), count, null_mut(), 0), DC_OK);
        (window, names)
    }
}

fn make(windows: [*mut dc_window; 2], positions: &[f64], options: &dc_options) -> (dc_status, *mut dc_faces) {
    let mut faces = std::ptr::dangling_mut();
    let ([master, slave], number) = (windows, positions.len() / 3);
    // SAFETY: the array has the length given.
    let status = unsafe {
        dc_faces_create_in_window(master, slave, positions.as_ptr(), number, options, 2, &mut faces)
    };
    assert_eq!(status == DC_OK, !faces.is_null());
    (status, faces)
}

/// Windows of both sides around a box in the plane, which reaches farther in the master, and the positions of their nodes.
fn windows(pair: &Pair, sides: [*mut dc_interface; 2], [low, high]: [[f64; 2]; 2]) -> (Part, Vec<i64>) {
    let reach = |reach: f64| [low[0] - reach, low[1] - reach, -2.0, high[0] + reach, high[1] + reach, 2.0];
    let (master, mut names) = window(sides[0], &reach(1.5));
    let (slave, more) = window(sides[1], &reach(0.6));
    names.extend(more);
    let own = |&node: &i64| pair.positions[3 * node as usize..][..3].to_vec();
    (([master, slave], names.iter().flat_map(own).collect()), names)
}

type Part = ([*mut dc_window; 2], Vec<f64>);

fn destroy(windows: [*mut dc_window; 2]) {
    for window in windows {
        assert_eq!(dc_window_destroy(window), DC_OK);
    }
}

/// Faces of nine nodes over the cells of either side, by the numbers of their nodes.
fn quadratic() -> [Vec<i64>; 2] {
    [0, 1].map(|which| {
        let (n, first) = (SIDES[which] as i64, if which == 0 { 0 } else { (SIDES[0] * SIDES[0]) as i64 });
        let steps = [[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1], [1, 1]];
        let turned = |[a, b]: [i64; 2]| if which == 0 { a + n * b } else { b + n * a };
        let corners = (0..(n / 2) * (n / 2)).map(|k| first + 2 * (k % (n / 2)) + 2 * n * (k / (n / 2)));
        corners.flat_map(|corner| steps.map(|step| corner + turned(step))).collect()
    })
}

fn add(faces: *mut dc_faces, side: i32, rows: &[i64]) -> dc_status {
    // SAFETY: the array has the length given.
    unsafe { dc_faces_add_quadratic_by_number(faces, side, rows.as_ptr(), rows.len() / 9, 9) }
}

#[test]
fn faces_in_windows_have_the_bits_of_the_whole_or_none() {
    assert_bits(&[Vec::new(), Vec::new()]);
    assert_bits(&quadratic());
}

fn assert_bits(quadratic: &[Vec<i64>; 2]) {
    let add_all = |faces: *mut dc_faces| {
        for (rows, side) in quadratic.iter().zip([0, 1]).filter(|(rows, _)| !rows.is_empty()) {
            // In two calls: the second adds to the first.
            let (some, more) = rows.split_at(18);
            assert!(add(faces, side, some) == DC_OK && add(faces, side, more) == DC_OK, "{}", message());
        }
    };
    let pair = Pair::new();
    let (mut whole, options) = (null_mut(), limited());
    let [master, slave] = &pair.facets;
    // SAFETY: the arrays have the lengths given.
    let status = unsafe {
        let (positions, number) = (pair.positions.as_ptr(), pair.nodes());
        let (m, s) = (master.as_ptr(), slave.as_ptr());
        dc_faces_create(positions, number, m, master.len() / 4, s, slave.len() / 4, &options, 2, &mut whole)
    };
    assert_eq!(status, DC_OK, "{}", message());
    add_all(whole);
    let first = SIDES[0] * SIDES[0];
    let all = nodes(whole, &pair.positions, first);
    let count = |state| all.iter().filter(|(_, (of, _))| of[1] == state).count();
    assert!(count(1) > 10 && count(2) > 10, "{} {}", count(1), count(2));
    let expected: std::collections::HashMap<i32, Node> = all.into_iter().collect();
    let sides = [pair.side(0), pair.side(1)];
    let mut seen = [0; 2];
    for [i, j] in [[0, 0], [1, 0], [0, 1], [1, 1]] {
        let low = [f64::from(i), f64::from(j)].map(|x: f64| 0.4 + 3.2 * x);
        let ((windows, positions), names) = windows(&pair, sides, [low, low.map(|x| x + 3.2)]);
        let (status, part) = make(windows, &positions, &options);
        assert_eq!(status, DC_OK, "{}", message());
        destroy(windows);
        add_all(part);
        let first = names.iter().take_while(|&&name| (name as usize) < first).count();
        for (node, found) in nodes(part, &positions, first) {
            let name = names[node as usize];
            let place = &pair.positions[3 * name as usize..][..2];
            let is_own = (0..2).all(|k| low[k] <= place[k] && place[k] <= low[k] + 3.2);
            if found.0[0] == dc_outcome::DC_BEYOND_WINDOW as i32 {
                assert!(!is_own, "{place:?}");
                assert_eq!(found.1, [0; 6]);
                seen[1] += 1;
            } else {
                assert_eq!(found, expected[&(name as i32)]);
                seen[0] += usize::from(is_own && f64::from_bits(found.1[1]) > 0.0);
            }
        }
        assert_eq!(dc_faces_destroy(part), DC_OK);
    }
    assert!(seen[0] > 100 && seen[1] > 20, "{seen:?}");
    assert_eq!(dc_faces_destroy(whole), DC_OK);
    assert!(sides.into_iter().all(|side| dc_destroy(side) == DC_OK));
}

#[test]
fn faces_in_windows_refuse_what_takes_the_whole() {
    let pair = Pair::new();
    let sides = [pair.side(0), pair.side(1)];
    let ((both, positions), _) = windows(&pair, sides, [[1.0; 2], [3.0; 2]]);
    let refused = |made: (dc_status, *mut dc_faces), status, code: &str| {
        assert!(made.0 == status && message().starts_with(code), "{}", message());
    };
    refused(make(both, &positions, &options()), DC_BAD_OPTION, "invalid-option: ");
    refused(make(both, &positions[3..], &limited()), DC_BAD_SIZE, "wrong-number-of-positions: ");
    // No other thread is in a call with it.
    refused(make([both[0]; 2], &positions, &limited()), DC_BAD_SIZE, "wrong-number-of-positions: ");
    refused(make([both[0], null_mut()], &positions, &limited()), DC_BAD_HANDLE, "bad-handle: ");
    let (_, part) = make(both, &positions, &limited());
    // SAFETY: the arrays have the lengths given.
    unsafe {
        let in_window = |status| {
            assert!(status == DC_BAD_OPTION && message().starts_with("in-window: "), "{}", message());
        };
        in_window(dc_faces_set_symmetry(part, null(), 0));
        let faces = [0, 1, 2, 3, 4, 5];
        in_window(dc_faces_add_quadratic(part, faces.as_ptr(), 1, 6));
    }
    let status = add(part, 2, &quadratic()[0]);
    assert!(status == DC_BAD_OPTION && message().contains("side has to be 0 or 1, not 2"), "{}", message());
    let status = add(part, 1, &[0, 1, 2, 3, 4, 5, 6, 7, 0]);
    assert!(message().starts_with("repeated-node: ") && status != DC_OK, "{}", message());
    let status = add(part, 1, &[0, 1, 2, 3, 4, 5, 6, 7, -1]);
    assert!(status == DC_OUT_OF_RANGE && message().starts_with("node-out-of-range: "), "{}", message());
    assert_eq!(dc_faces_destroy(part), DC_OK);
    destroy(both);
    assert!(sides.into_iter().all(|side| dc_destroy(side) == DC_OK));
}
