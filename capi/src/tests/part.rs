//! Parts of a surface from C: ranks that own some facets each cut the windows of the whole, bit for bit.

use std::ptr::{null, null_mut};

use super::{message, options};
use crate::interface::{dc_create, dc_destroy};
use crate::part::*;
use crate::status::{DC_BAD_HANDLE, DC_BAD_OPTION, DC_BAD_POINTER, DC_BAD_SIZE, DC_OK, DC_OUT_OF_RANGE};
use crate::window::{
    dc_window, dc_window_counts, dc_window_create, dc_window_destroy, dc_window_from_numbers,
    dc_window_names, dc_window_numbers,
};

/// Cells along a side, and the ranks that own strips of them.
const CELLS: usize = 16;
const RANKS: usize = 4;
/// How far a rank knows the surface around its own facets.
const REACH: f64 = 8.0;
const SKIN: f64 = 0.1;

struct Whole {
    positions: Vec<f64>,
    facets: Vec<i32>,
}

impl Whole {
    fn new() -> Self {
        let side = CELLS + 1;
        let node = |k: usize| {
            let [x, y] = [(k % side) as f64, (k / side) as f64];
            [x + 0.1 * (3.0 * y).sin(), y + 0.1 * (2.0 * x).cos(), 0.2 * (0.5 * x).sin() * (0.6 * y).cos()]
        };
        let corner = |k: usize| (k % CELLS + side * (k / CELLS)) as i32;
        let facet =
            |k: usize| [corner(k), corner(k) + 1, corner(k) + 1 + side as i32, corner(k) + side as i32];
        Self {
            positions: (0..side * side).flat_map(node).collect(),
            facets: (0..CELLS * CELLS).flat_map(facet).collect(),
        }
    }

    fn nodes(&self) -> usize {
        self.positions.len() / 3
    }

    fn extents(&self) -> [f64; 7] {
        let mut extents = [0.0; 7];
        let (positions, facets) = (self.positions.as_ptr(), self.facets.as_ptr());
        // SAFETY: the arrays have the lengths given.
        let status = unsafe {
            dc_extents(positions, self.nodes(), facets, self.facets.len() / 4, extents.as_mut_ptr())
        };
        assert_eq!(status, DC_OK, "{}", message());
        extents
    }

    /// The rank that owns a facet: strips of cells.
    fn owner(facet: usize) -> usize {
        facet / CELLS * RANKS / CELLS
    }
}

/// What a rank hands over.
struct Part {
    positions: Vec<f64>,
    node_names: Vec<i64>,
    facets: Vec<i32>,
    facet_names: Vec<i64>,
    owned: Vec<i32>,
    known: [f64; 6],
}

impl Part {
    fn new(whole: &Whole, rank: usize, reach: f64) -> Self {
        let rows: Vec<(usize, &[i32])> = whole.facets.chunks(4).enumerate().collect();
        let y = |row: &[i32]| row.iter().map(|&k| whole.positions[3 * k as usize + 1]).collect::<Vec<_>>();
        let own = rows.iter().filter(|(k, _)| Whole::owner(*k) == rank).flat_map(|(_, row)| y(row));
        let (low, high) = own.fold((f64::MAX, f64::MIN), |(low, high), y| (low.min(y), high.max(y)));
        let (low, high) = (low - reach, high + reach);
        let near = |row: &[i32]| y(row).iter().any(|&y| y >= low) && y(row).iter().any(|&y| y <= high);
        // From the last to the first: the order is the rank's own.
        let here: Vec<&(usize, &[i32])> = rows.iter().rev().filter(|(_, row)| near(row)).collect();
        let mut node_names: Vec<i64> =
            here.iter().flat_map(|(_, row)| row.iter().map(|&k| i64::from(k))).collect();
        node_names.sort_unstable_by_key(|&name| (name % 7, name));
        node_names.dedup();
        let place = |&name: &i32| node_names.iter().position(|&own| own == i64::from(name)).unwrap() as i32;
        Self {
            positions: node_names
                .iter()
                .flat_map(|&k| whole.positions[3 * k as usize..][..3].to_vec())
                .collect(),
            facets: here.iter().flat_map(|(_, row)| row.iter().map(place)).collect(),
            facet_names: here.iter().map(|(k, _)| *k as i64).collect(),
            owned: here.iter().map(|(k, _)| i32::from(Whole::owner(*k) == rank)).collect(),
            known: [-1e3, low, -1e3, 1e3, high, 1e3],
            node_names,
        }
    }

    fn make(&self, extents: &[f64; 7]) -> (crate::status::dc_status, *mut dc_part) {
        let mut part = std::ptr::dangling_mut();
        let options = options();
        // SAFETY: the arrays have the lengths given.
        let status = unsafe {
            dc_part_create(
                self.positions.as_ptr(),
                self.node_names.as_ptr(),
                self.node_names.len(),
                self.facets.as_ptr(),
                self.facet_names.as_ptr(),
                self.owned.as_ptr(),
                self.facet_names.len(),
                self.known.as_ptr(),
                extents.as_ptr(),
                null(),
                0,
                &options,
                &mut part,
            )
        };
        assert_eq!(status == DC_OK, !part.is_null());
        (status, part)
    }
}

fn demands(part: *mut dc_part) -> (Vec<i64>, Vec<f64>) {
    let [mut integer_count, mut real_count] = [9; 2];
    // SAFETY: the arrays have the lengths given.
    unsafe {
        let status = dc_part_demands(part, null_mut(), 0, &mut integer_count, null_mut(), 0, &mut real_count);
        assert_eq!(status, DC_OK, "{}", message());
        let (mut integers, mut reals) = (vec![0; integer_count], vec![0.0; real_count]);
        let (i, r) = (integers.as_mut_ptr(), reals.as_mut_ptr());
        assert_eq!(dc_part_demands(part, i, integer_count, null_mut(), r, real_count, null_mut()), DC_OK);
        let short = dc_part_demands(part, i, integer_count - 1, null_mut(), r, real_count, null_mut());
        assert_eq!(short, DC_BAD_SIZE);
        (integers, reals)
    }
}

fn numbers(window: *mut dc_window) -> (Vec<i64>, Vec<u64>) {
    let [mut integers, mut reals] = [0; 2];
    // SAFETY: the arrays have the lengths given.
    unsafe {
        assert_eq!(dc_window_counts(window, null_mut(), null_mut(), &mut integers, &mut reals), DC_OK);
        let (mut whole, mut real) = (vec![0; integers], vec![0.0; reals]);
        assert_eq!(dc_window_numbers(window, whole.as_mut_ptr(), integers, real.as_mut_ptr(), reals), DC_OK);
        (whole, real.iter().map(|x: &f64| x.to_bits()).collect())
    }
}

/// The parts of all ranks, settled in two rounds of demands.
fn settled(whole: &Whole) -> Vec<(Part, *mut dc_part)> {
    let extents = whole.extents();
    let make = |rank| {
        let own = Part::new(whole, rank, REACH);
        let (status, part) = own.make(&extents);
        assert_eq!(status, DC_OK, "{}", message());
        assert!(own.facet_names.len() < CELLS * CELLS || rank == 1 || rank == 2);
        (own, part)
    };
    let parts: Vec<_> = (0..RANKS).map(make).collect();
    for round in 0..2 {
        let all: Vec<_> = parts.iter().map(|&(_, part)| demands(part)).collect();
        for (rank, &(_, part)) in parts.iter().enumerate() {
            let others = || all.iter().enumerate().filter(|(other, _)| *other != rank).map(|(_, own)| own);
            let integers: Vec<i64> = others().flat_map(|own| own.0.clone()).collect();
            let reals: Vec<f64> = others().flat_map(|own| own.1.clone()).collect();
            let (mut is_settled, (i, r)) = (9, (integers.as_ptr(), reals.as_ptr()));
            // SAFETY: the arrays have the lengths given.
            unsafe {
                let short = dc_part_settle(part, i, integers.len() - 1, r, reals.len(), &mut is_settled);
                assert!(short == DC_BAD_OPTION && is_settled == 9, "{}", message());
                assert!(message().starts_with("invalid-window: "), "{}", message());
                let status = dc_part_settle(part, i, integers.len(), r, reals.len(), &mut is_settled);
                assert_eq!(status, DC_OK, "{}", message());
            }
            assert_eq!(is_settled, round);
        }
    }
    parts
}

#[test]
fn windows_cut_from_parts_are_those_of_the_whole() {
    let whole = Whole::new();
    let (mut interface, options) = (null_mut(), options());
    let (x, f) = (whole.positions.as_ptr(), whole.facets.as_ptr());
    // SAFETY: the arrays have the lengths given.
    let status = unsafe {
        let count = whole.facets.len() / 4;
        dc_create(x, whole.nodes(), f, count, null(), 0, null(), 0, &options, &mut interface)
    };
    assert_eq!(status, DC_OK, "{}", message());
    let parts = settled(&whole);
    let slaves = [[2.1, 3.4, 0.1], [9.3, 4.2, 0.0], [8.2, 11.9, 0.1]].as_flattened().to_vec();
    let (mut boxes, mut count) = (vec![0.0; 6 * 4], 9);
    // SAFETY: the arrays have the lengths given.
    unsafe {
        let status = dc_boxes_around(slaves.as_ptr(), 3, 0.8, 4, boxes.as_mut_ptr(), &mut count);
        assert!(status == DC_OK && (1..4).contains(&count), "{}", message());
        let mut expected = null_mut();
        let status = dc_window_create(interface, boxes.as_ptr(), count, SKIN, &mut expected);
        assert_eq!(status, DC_OK, "{}", message());
        let cut = |(own, part): &(Part, *mut dc_part)| {
            let (mut window, mut sent, nodes) = (null_mut(), null_mut(), own.node_names.len());
            let (x, b) = (own.positions.as_ptr(), boxes.as_ptr());
            assert_eq!(dc_part_window(*part, x, nodes - 1, b, count, SKIN, &mut window), DC_BAD_SIZE);
            let status = dc_part_window(*part, x, nodes, b, count, SKIN, &mut window);
            assert_eq!(status, DC_OK, "{}", message());
            let (integers, bits) = numbers(window);
            assert_eq!(dc_window_destroy(window), DC_OK);
            let reals: Vec<f64> = bits.into_iter().map(f64::from_bits).collect();
            let (i, r) = (integers.as_ptr(), reals.as_ptr());
            assert_eq!(dc_window_from_numbers(i, integers.len(), r, reals.len(), &mut sent), DC_OK);
            sent
        };
        let windows: Vec<*mut dc_window> = parts.iter().map(cut).collect();
        let mut joined = null_mut();
        assert_eq!(dc_window_joined(windows.as_ptr(), RANKS, &mut joined), DC_OK, "{}", message());
        assert_eq!(numbers(joined), numbers(expected));

        let mut nodes = 0;
        assert_eq!(dc_window_counts(joined, &mut nodes, null_mut(), null_mut(), null_mut()), DC_OK);
        assert!((20..whole.nodes()).contains(&nodes), "{nodes}");
        let (mut names, mut first) = (vec![0; nodes], vec![0.0; 3 * nodes]);
        assert_eq!(dc_window_names(joined, names.as_mut_ptr(), nodes, null_mut(), 0), DC_OK);
        assert_eq!(dc_window_first_positions(joined, first.as_mut_ptr(), nodes), DC_OK);
        assert_eq!(dc_window_first_positions(joined, first.as_mut_ptr(), nodes - 1), DC_BAD_SIZE);
        for (&name, x) in names.iter().zip(first.chunks(3)) {
            assert_eq!(x, &whole.positions[3 * name as usize..][..3]);
        }

        let mut none = null_mut();
        assert_eq!(dc_window_joined(null(), 0, &mut none), DC_BAD_OPTION);
        let mut both = [joined, expected];
        let first = both.as_mut_ptr();
        assert_eq!(dc_window_joined(first, 2, first), DC_BAD_POINTER);
        assert_eq!(both, [joined, expected], "handles that would be overwritten are kept");
        let gone = [joined, expected];
        assert_eq!(dc_window_destroy(expected), DC_OK);
        assert_eq!(dc_window_joined(gone.as_ptr(), 2, &mut none), DC_BAD_HANDLE);
        assert_eq!(dc_window_destroy(joined), DC_OK);
        windows.into_iter().for_each(|window| assert_eq!(dc_window_destroy(window), DC_OK));
    }
    parts.into_iter().for_each(|(_, part)| assert_eq!(dc_part_destroy(part), DC_OK));
    assert_eq!(dc_destroy(interface), DC_OK);
}

#[test]
fn parts_refuse_what_is_none() {
    let whole = Whole::new();
    let extents = whole.extents();
    let refused = |own: &Part, status, code: &str| {
        assert!(own.make(&extents).0 == status && message().starts_with(code), "{}", message());
    };
    refused(&Part::new(&whole, 1, 0.5), DC_BAD_OPTION, "part-too-narrow: ");
    let mut own = Part::new(&whole, 0, REACH);
    own.facet_names[3] = -4;
    refused(&own, DC_OUT_OF_RANGE, "negative-number: facet_names[3] is -4");
    own.facet_names[3] = own.facet_names[4];
    refused(&own, DC_BAD_OPTION, "invalid-window: ");
    let mut own = Part::new(&whole, 0, REACH);
    own.owned[2] = 256;
    refused(&own, DC_BAD_OPTION, "invalid-option: owned");
    let own = Part::new(&whole, 0, REACH);
    let nothing =
        [f64::INFINITY, f64::INFINITY, f64::INFINITY, -f64::INFINITY, -f64::INFINITY, -f64::INFINITY, 0.0];
    for wrong in [nothing, [f64::NAN; 7], extents.map(|x| 0.9 * x)] {
        let (status, _) = own.make(&wrong);
        assert!(status == DC_BAD_OPTION && message().starts_with("invalid-extents: "), "{}", message());
    }
    let own = Part::new(&whole, 0, REACH);
    let (_, part) = own.make(&extents);
    let boxes = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    // SAFETY: the arrays have the lengths given.
    unsafe {
        let (mut window, x) = (std::ptr::dangling_mut(), own.positions.as_ptr());
        let early = dc_part_window(part, x, own.node_names.len(), boxes.as_ptr(), 1, 0.0, &mut window);
        assert!(early == DC_BAD_OPTION && window.is_null(), "{}", message());
        assert_eq!(dc_boxes_around(x, 3, 0.1, 2, null_mut(), null_mut()), DC_BAD_POINTER);
        let (mut boxes, mut count) = ([7.0; 6], 7);
        for reach in [f64::NAN, f64::INFINITY, -0.1] {
            let status = dc_boxes_around(x, 3, reach, 1, boxes.as_mut_ptr(), &mut count);
            assert!(status == DC_BAD_OPTION && (boxes, count) == ([7.0; 6], 7), "{reach}: {}", message());
        }
        assert_eq!(dc_extents(x, 3, null(), 0, null_mut()), DC_BAD_POINTER);
        let (corners, mut extents) = ([0, 1, 3, -1], [7.0; 7]);
        let status = dc_extents(x, 3, corners.as_ptr(), 1, extents.as_mut_ptr());
        assert!(status == DC_OUT_OF_RANGE && extents == [7.0; 7], "{}", message());
    }
    assert_eq!(dc_part_destroy(part), DC_OK);
    assert_eq!(dc_part_destroy(part), DC_BAD_HANDLE);
}

#[test]
fn a_history_is_split_by_slaves() {
    let history = [1.0, 0.0, 7.0, -1.0, 1.0, -1.0, 2.0, 0.5, 3.0, -1.0, 0.25, 4.0, -1.0, 0.75];
    let (mut lengths, mut count) = ([9; 4], 9);
    // SAFETY: the arrays have the lengths given.
    unsafe {
        let (own, length) = (history.as_ptr(), history.len());
        assert_eq!(dc_history_lengths(own, length, null_mut(), 0, &mut count), DC_OK, "{}", message());
        assert_eq!(count, 3);
        assert_eq!(dc_history_lengths(own, length, lengths.as_mut_ptr(), 2, &mut count), DC_BAD_SIZE);
        assert_eq!(dc_history_lengths(own, length, lengths.as_mut_ptr(), 4, &mut count), DC_OK);
        assert_eq!(lengths, [5, 1, 8, 9]);
        assert_eq!(dc_history_lengths(own, length - 1, null_mut(), 0, &mut count), DC_BAD_OPTION);
        assert!(message().starts_with("invalid-history: "), "{}", message());
    }
}
