//! Elements side by side, and the nodes of one element: with all vector instructions of the machine the kernels give what
//! they give number by number, and what an element gets does not depend on its neighbours.
//!
//! Results of different shapes and instructions differ by rounding: sums run in another order, and not all have fused
//! multiply-adds. For well-conditioned elements (relative pivots of the fit, and of the average plane, above 1e-2; the
//! determinant of the foot's equations above 0.1) each block, g and foot over R, ν, α over R, N and M, differs by at most
//! 1e-12 of its largest entry. Neighbours make no difference at all: results are compared bit for bit.

use std::mem::discriminant;
use std::panic::{AssertUnwindSafe, catch_unwind};

use diffuse_contact::{Basis, Mode};
use diffuse_contact_kernels::support::{
    BatchElement, ElementInputs, FrameRule, GapValues, Isa, Masters, Status, Workspace,
};
use diffuse_contact_tests::{
    Case, Found, GAP_KERNELS, GapKernels, Kernel, Quadric, add, assert_same_gap, fixed, instructions,
    output_sizes,
};
use proptest::prelude::*;

/// Largest difference between shapes and instructions, see above.
const TOLERANCE: f64 = 1e-12;

pub(crate) const BASES: [Basis; 2] = [Basis::Quadratic, Basis::Linear];
pub(crate) const FRAMES: [FrameRule; 3] = [FrameRule::Held, FrameRule::CoMoving, FrameRule::Material];
const MODES: [Mode; 3] = [Mode::Value, Mode::Gradient, Mode::Hessian];
/// Around multiples of 2, 4 and 8, and larger ones.
const COUNTS: [usize; 18] = [3, 4, 5, 6, 7, 8, 9, 11, 12, 13, 15, 16, 17, 20, 23, 24, 25, 30];

/// All kernels of all weights.
fn kernels() -> impl Iterator<Item = (GapKernels, Kernel)> {
    let of_modes = |set, basis, frame| MODES.map(|mode| (set, (basis, frame, mode)));
    let of_frames = move |set, basis| FRAMES.into_iter().flat_map(move |frame| of_modes(set, basis, frame));
    GAP_KERNELS
        .into_iter()
        .flat_map(move |set| BASES.into_iter().flat_map(move |basis| of_frames(set, basis)))
}

/// In a frame that the rule allows.
pub(crate) fn with_frame(case: Case, frame: FrameRule) -> Case {
    match frame {
        FrameRule::Held => case,
        FrameRule::CoMoving => case.co_moving(),
        FrameRule::Material => case.material(),
    }
}

/// Whether an element is one for which differences stay within [`TOLERANCE`].
fn is_well_conditioned(values: &GapValues<f64>) -> bool {
    values.status() == Status::Ok
        && values.pivot_ratio > 1e-2
        && values.plane_pivot_ratio > 1e-2
        && values.jacobian_determinant.abs() > 0.1
}

/// The first well-conditioned element from `seed` on.
pub(crate) fn sound(set: &GapKernels, (basis, frame, _): Kernel, n: usize, seed: u64) -> Case {
    let cases = (seed..seed + 500).map(|seed| with_frame(Case::random(n, basis, seed), frame));
    let is_sound = |case: &Case| {
        is_well_conditioned(&set.single(Isa::SCALAR, (basis, frame, Mode::Value), case, 0).values)
    };
    cases.into_iter().find(is_sound).expect("one of many elements")
}

/// The slave at a height over the first master, beside it by `offset`.
fn over_a_node(basis: Basis, frame: FrameRule, n: usize, offset: f64) -> Case {
    let mut case = Case::random(n, basis, 77);
    case.slave = add(case.masters[0], case.global([offset, 0.0, 0.3]));
    with_frame(case, frame)
}

/// An element that goes wrong, and whether a status is one that a held frame gives it.
type Bad = (Case, fn(&Status) -> bool);

fn bad(basis: Basis, n: usize) -> [Bad; 7] {
    let random = |seed| Case::random(n, basis, seed);
    let mut on_a_line = random(4);
    for (k, master) in on_a_line.masters.iter_mut().enumerate() {
        *master = add(on_a_line.slave, [0.1 * (k as f64 - 1.3), 0.2, 0.1]);
    }
    let mut in_one_place = random(3);
    in_one_place.masters = vec![in_one_place.masters[0]; n];
    let mut not_a_number = random(5);
    not_a_number.masters[n - 1][1] = f64::NAN;
    let mut no_slave = random(6);
    no_slave.slave[2] = f64::NAN;
    let mut overflowing = random(8);
    overflowing.masters[2] = add(overflowing.masters[2], overflowing.global([0.0, 0.0, 1e300]));
    // A plane takes such heights: it is upright, and the slave is on it.
    let of_overflow: fn(&Status) -> bool = match basis {
        Basis::Linear => |_| true,
        _ => |status| *status != Status::Ok,
    };
    let mut no_radius = random(9);
    no_radius.support_radius = 0.0;
    let slope = Quadric([0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    let mut outside = Case { basis, ..Case::on_quadric(&slope, [0.0; 2], 0.0, n, 9) };
    outside.slave = add(outside.slave, outside.global([0.0, 0.0, 10.0]));
    [
        (on_a_line, |status| matches!(status, Status::SingularFit { .. })),
        (not_a_number, |status| *status != Status::Ok),
        (overflowing, of_overflow),
        (outside, |status| matches!(status, Status::FootOutside { .. } | Status::SingularFit { .. })),
        (no_slave, |status| *status != Status::Ok),
        (no_radius, |status| *status != Status::Ok),
        (in_one_place, |status| *status != Status::Ok),
    ]
}

/// Sound and bad elements in turn.
fn mixture(set: &GapKernels, kernel: Kernel, n: usize, count: usize) -> Vec<Case> {
    let (basis, frame, _) = kernel;
    let mut bad = bad(basis, n).into_iter().map(|(case, _)| case).cycle();
    let sound = |k| match k % 4 {
        0 => sound(set, kernel, n, 100 * k as u64),
        1 => over_a_node(basis, frame, n, 0.0),
        2 => sound(set, kernel, n, 100 * k as u64).scaled(1e3),
        _ => over_a_node(basis, frame, n, 1e-3),
    };
    (0..count).map(|k| if k % 2 == 0 { sound(k / 2) } else { bad.next().expect("a cycle") }).collect()
}

#[track_caller]
fn assert_agrees(found: &Found, expected: &Found, case: &Case) {
    assert_same_gap(case, &found.gap(case), &expected.gap(case), TOLERANCE);
    let figures = |x: &GapValues<f64>| {
        [x.pivot_ratio, x.plane_pivot_ratio, x.foot_distance, x.jacobian_determinant, x.jacobian_trace]
    };
    for (x, y) in figures(&found.values).into_iter().zip(figures(&expected.values)) {
        assert!((x - y).abs() <= TOLERANCE * y.abs().max(1.0), "{found:?} {expected:?}");
    }
    assert!(found.values.checksum.is_finite());
    assert_eq!(found.status(), Status::Ok);
}

#[test]
fn shapes_and_instructions_agree() {
    let mut workspace = Workspace::default();
    for (set, kernel) in kernels() {
        for n in COUNTS.into_iter().filter(|n| *n >= kernel.0.size()) {
            let cases = [1000, 2000, 3000].map(|seed| sound(&set, kernel, n, seed));
            let expected = cases.each_ref().map(|case| set.single(Isa::SCALAR, kernel, case, 0));
            for isa in instructions() {
                // Slices may be longer than needed.
                let spare = n % 2 * 5;
                let together = set.batch(isa, kernel, &cases.each_ref(), &mut workspace, spare);
                for ((case, in_batch), expected) in cases.iter().zip(&together).zip(&expected) {
                    assert_agrees(in_batch, expected, case);
                    assert_agrees(&set.single(isa, kernel, case, spare), expected, case);
                }
            }
        }
    }
}

#[test]
fn statuses_do_not_depend_on_shape_and_instructions() {
    let mut workspace = Workspace::default();
    for (set, kernel) in kernels() {
        for n in [6, 9, 14] {
            for (case, is_expected) in bad(kernel.0, n) {
                let expected = set.single(Isa::SCALAR, kernel, &case, 0);
                // Not all of these frames are average planes, which a frame that moves has to be.
                let is_expected = kernel.1 != FrameRule::Held || is_expected(&expected.status());
                assert!(is_expected, "{} {kernel:?} {expected:?}", set.weight);
                for isa in instructions() {
                    let single = set.single(isa, kernel, &case, 3);
                    let [in_batch] = &set.batch(isa, kernel, &[&case], &mut workspace, 3)[..] else {
                        panic!("one element")
                    };
                    for found in [&single, in_batch] {
                        assert_eq!(
                            discriminant(&found.status()),
                            discriminant(&expected.status()),
                            "{} {kernel:?} {isa}: {found:?}, number by number {expected:?}",
                            set.weight
                        );
                    }
                }
            }
        }
    }
}

/// A bowl whose centre of curvature the slave is on, or beyond. On it, rounding decides whether the iteration finds the
/// multiple root; a result there is none.
#[test]
fn no_result_on_and_beyond_a_centre_of_curvature() {
    let bowl = Quadric([0.0, 0.0, 0.0, 0.4, 0.0, 0.4]);
    let kernel = (Basis::Quadratic, FrameRule::Held, Mode::Hessian);
    for isa in instructions() {
        for set in GAP_KERNELS {
            for n in [9, 12, 17] {
                let [centre, beyond] = [1.25, 1.6].map(|d| Case::on_quadric(&bowl, [0.0; 2], d, n, 10));
                let in_batch = set.batch(isa, kernel, &[&beyond, &centre], &mut Workspace::default(), 0);
                let single = [&beyond, &centre].map(|case| set.single(isa, kernel, case, 0));
                for found in [&in_batch[..], &single] {
                    let [beyond, centre] = [&found[0], &found[1]].map(Found::status);
                    let place = format!("{} {isa}, {n} nodes: {beyond:?}, {centre:?}", set.weight);
                    assert!(matches!(beyond, Status::BeyondCentreOfCurvature { .. }), "{place}");
                    assert_ne!(centre, Status::Ok, "{place}");
                    if set.weight == "cubic" && n == 9 {
                        assert!(matches!(centre, Status::CentreOfCurvature { .. }), "{place}");
                    }
                }
            }
        }
    }
}

/// Each element of a batch is, bit for bit, what it is alone.
#[track_caller]
fn assert_independent(
    set: &GapKernels,
    isa: Isa,
    kernel: Kernel,
    cases: &[&Case],
    alone: &[&Found],
    workspace: &mut Workspace,
) {
    for (place, (found, alone)) in set.batch(isa, kernel, cases, workspace, 0).iter().zip(alone).enumerate() {
        let count = cases.len();
        assert!(
            found.bits() == alone.bits(),
            "{} {kernel:?} {isa}, element {place} of {count}: {found:?} alone {alone:?}",
            set.weight
        );
    }
}

/// The elements alone, each with memory of its own.
fn alone(set: &GapKernels, isa: Isa, kernel: Kernel, cases: &[Case]) -> Vec<Found> {
    let one = |case: &Case| set.batch(isa, kernel, &[case], &mut Workspace::default(), 0).remove(0);
    cases.iter().map(one).collect()
}

#[test]
fn neighbours_make_no_difference() {
    // Used again and again, with whatever the last kernel left in it.
    let mut workspace = Workspace::default();
    for isa in instructions() {
        for (set, kernel) in kernels() {
            let n = if kernel.2 == Mode::Hessian { 7 } else { 10 };
            let cases = mixture(&set, kernel, n, 2 * isa.width() + 1);
            let alone = alone(&set, isa, kernel, &cases);
            let sound = alone.iter().step_by(2).all(|found| found.status() == Status::Ok);
            assert!(sound, "{} {kernel:?} {isa}", set.weight);
            let (cases, alone): (Vec<&Case>, Vec<&Found>) = cases.iter().zip(&alone).unzip();
            assert_independent(&set, isa, kernel, &cases, &alone, &mut workspace);
        }
    }
}

/// Nodes that carry no weight fill up the lanes of elements with fewer nodes.
#[test]
fn neighbours_with_other_numbers_of_nodes_make_no_difference() {
    let mut workspace = Workspace::default();
    for isa in instructions() {
        for (set, kernel) in kernels().filter(|(_, (_, frame, _))| *frame == FrameRule::Material) {
            // One number of nodes after the other, sound ones and bad ones: every vector has several of both.
            let mixtures = [7, 12, 6, 9].map(|n| mixture(&set, kernel, n, 4));
            let cases: Vec<Case> = (0..16).map(|k| mixtures[k % 4][(k / 4 + k) % 4].clone()).collect();
            let differ =
                |cases: &[Case]| cases.iter().any(|case| case.masters.len() != cases[0].masters.len());
            assert!(isa.width() == 1 || cases.chunks(isa.width()).all(differ), "{isa}");
            let alone = alone(&set, isa, kernel, &cases);
            let (cases, alone): (Vec<&Case>, Vec<&Found>) = cases.iter().zip(&alone).unzip();
            assert_independent(&set, isa, kernel, &cases, &alone, &mut workspace);
        }
    }
}

#[test]
fn batches_of_any_size_are_their_elements_wherever_these_are() {
    let mut workspace = Workspace::default();
    for isa in instructions() {
        for (set, kernel) in [
            (GAP_KERNELS[0], (Basis::Quadratic, FrameRule::Held, Mode::Hessian)),
            (GAP_KERNELS[1], (Basis::Linear, FrameRule::CoMoving, Mode::Gradient)),
        ] {
            let cases = mixture(&set, kernel, 6, 2 * isa.width() + 1);
            let alone = alone(&set, isa, kernel, &cases);
            let (mut cases, mut alone): (Vec<&Case>, Vec<&Found>) = cases.iter().zip(&alone).unzip();
            for size in 0..=cases.len() {
                cases.rotate_left(1);
                alone.rotate_left(1);
                assert_independent(&set, isa, kernel, &cases[..size], &alone, &mut workspace);
            }
        }
    }
}

/// Numbers of Newton iterations differ, and nobody waits for the others or goes on after the end.
#[test]
fn lanes_converge_each_in_its_own_time() {
    let flat = Case::on_quadric(&Quadric([0.0; 6]), [0.0; 2], 0.25, 9, 1);
    let bowl = Quadric([0.1, 0.5, -0.3, 0.5, 0.4, -0.3]);
    let curved = Case::on_quadric(&bowl, [0.2, -0.1], 0.6, 9, 2);
    let cases = [&flat, &Case::random(9, Basis::Quadratic, 1), &curved];
    let kernel = (Basis::Quadratic, FrameRule::Held, Mode::Hessian);
    for isa in instructions() {
        let found = GAP_KERNELS[0].batch(isa, kernel, &cases, &mut Workspace::default(), 0);
        assert!(found.iter().all(|found| found.status() == Status::Ok));
        let iterations: Vec<f64> = found.iter().map(|found| found.values.foot_iterations).collect();
        // On a flat surface the start is the foot, but for rounding.
        assert!(iterations[0] <= 2.0, "{iterations:?}");
        assert!(iterations[0] < iterations[1] && iterations[1] < iterations[2], "{iterations:?}");
        for (case, found) in cases.into_iter().zip(&found) {
            let alone = GAP_KERNELS[0].batch(isa, kernel, &[case], &mut Workspace::default(), 0);
            assert_eq!(found.bits(), alone[0].bits());
        }
    }
}

#[test]
fn masters_may_be_named_by_their_places() {
    let kernel = (Basis::Quadratic, FrameRule::Held, Mode::Hessian);
    let case = Case::random(11, Basis::Quadratic, 3);
    // All positions, backwards and with others in between.
    let elsewhere = [f64::NAN; 3];
    let positions: Vec<[f64; 3]> =
        case.masters.iter().rev().flat_map(|position| [elsewhere, *position]).collect();
    let nodes: Vec<u32> = (0..11).map(|k| 2 * (10 - k) + 1).collect();
    let inputs =
        ElementInputs { masters: Masters::Indexed { positions: &positions, nodes: &nodes }, ..case.inputs() };
    let [freedoms, packed] = output_sizes(Mode::Hessian, &case);
    for isa in instructions() {
        for set in GAP_KERNELS {
            let (mut gradient, mut hessian) = (vec![f64::NAN; freedoms], vec![f64::NAN; packed]);
            let values = set.run_single(isa, kernel, &inputs, &mut gradient, &mut hessian);
            let found = Found { values, gradient, hessian };
            assert_eq!(found.bits(), set.single(isa, kernel, &case, 0).bits(), "{} {isa}", set.weight);

            let (mut gradient, mut hessian) = (vec![f64::NAN; freedoms], vec![f64::NAN; packed]);
            let mut elements = [BatchElement {
                inputs,
                values: GapValues::NONE,
                gradient: &mut gradient,
                hessian: &mut hessian,
                places: &[],
            }];
            let mut workspace = Workspace::default();
            set.run_batch(isa, kernel, &mut elements, &mut workspace);
            let found = Found { values: elements[0].values, gradient, hessian };
            let expected = set.batch(isa, kernel, &[&case], &mut workspace, 0);
            assert_eq!(found.bits(), expected[0].bits(), "{} {isa}", set.weight);
        }
    }
}

/// Numbers a slice is too short by.
const MISSING: [[usize; 2]; 3] = [[1, 0], [0, 1], [1, 1]];

#[test]
fn slices_that_are_too_short_are_a_panic() {
    let panics = |run: &mut dyn FnMut()| catch_unwind(AssertUnwindSafe(run)).is_err();
    let case = Case::random(9, Basis::Quadratic, 1);
    for isa in instructions() {
        for (set, kernel) in kernels().filter(|(_, kernel)| kernel.0 == Basis::Quadratic) {
            let [gradients, hessians] = output_sizes(kernel.2, &case);
            for missing in MISSING {
                if missing[0] > gradients || missing[1] > hessians {
                    continue;
                }
                let mut gradient = vec![0.0; gradients - missing[0]];
                let mut hessian = vec![0.0; hessians - missing[1]];
                assert!(
                    panics(&mut || {
                        set.run_single(isa, kernel, &case.inputs(), &mut gradient, &mut hessian);
                    }),
                    "{} {kernel:?} {isa}",
                    set.weight
                );
                // The short one is neither the first nor the last of its vector.
                let count = 2 * isa.width() + 1;
                let mut room = vec![(vec![0.0; gradients], vec![0.0; hessians]); count];
                let short = isa.width() + isa.width() / 2;
                room[short].0.truncate(gradients - missing[0]);
                room[short].1.truncate(hessians - missing[1]);
                let mut elements: Vec<BatchElement<'_>> = room
                    .iter_mut()
                    .map(|(gradient, hessian)| BatchElement {
                        inputs: case.inputs(),
                        values: GapValues::NONE,
                        gradient,
                        hessian,
                        places: &[],
                    })
                    .collect();
                assert!(
                    panics(&mut || set.run_batch(isa, kernel, &mut elements, &mut Workspace::default())),
                    "{} {kernel:?} {isa}",
                    set.weight
                );
            }
        }
    }
}

#[test]
fn elements_of_different_numbers_of_nodes_are_a_panic() {
    let kernel = (Basis::Quadratic, FrameRule::Held, Mode::Value);
    let cases = [7, 7, 8].map(|n| Case::random(n, Basis::Quadratic, 1));
    for isa in instructions() {
        for order in [[0, 1, 2], [2, 0, 1]] {
            let run = || {
                let cases = order.map(|k| &cases[k]);
                GAP_KERNELS[0].batch(isa, kernel, &cases, &mut Workspace::default(), 0)
            };
            assert!(catch_unwind(run).is_err(), "{isa}");
        }
    }
}

#[test]
fn instructions_have_names_and_widths() {
    let available: Vec<Isa> = Isa::available().collect();
    assert_eq!(available.first(), Some(&Isa::SCALAR));
    // The last one, but where the kernels are compiled without optimisation.
    assert!([available.last(), available.first()].contains(&Some(&Isa::best())));
    assert!(available.is_sorted_by_key(|isa| isa.width()));
    for isa in available {
        assert_eq!(Isa::named(isa.name()), Some(isa));
        assert_eq!(isa.to_string(), isa.name());
        assert!(isa.width().is_power_of_two());
    }
    assert_eq!((Isa::SCALAR.name(), Isa::SCALAR.width()), ("scalar", 1));
    assert_eq!(Isa::default(), Isa::best());
    for name in ["", "avx", "AVX2", "avx2 ", "sve", "best"] {
        assert_eq!(Isa::named(name), None, "{name}");
    }
}

proptest! {
    #![proptest_config(fixed(96))]

    /// Whatever is in a batch, each element is what it is alone; sound ones are what they are number by number.
    #[test]
    fn any_batch_is_its_elements(
        (set, basis, frame, mode) in (0usize..5, 0usize..2, 0usize..3, 0usize..3),
        n in 3usize..=26,
        seeds in prop::collection::vec(any::<u64>(), 1..12),
        what in prop::collection::vec(0usize..10, 12),
    ) {
        let (set, kernel) = (GAP_KERNELS[set], (BASES[basis], FRAMES[frame], MODES[mode]));
        let n = n.max(kernel.0.size());
        let bad = bad(kernel.0, n);
        let cases: Vec<Case> = seeds
            .iter()
            .zip(what)
            .map(|(seed, what)| match bad.get(what) {
                Some((case, _)) => case.clone(),
                None => {
                    let far = [1e3, -1e3, 500.0];
                    let case = with_frame(Case::random(n, kernel.0, *seed), kernel.1);
                    if what == 9 { case.mapped(|x| add(x, far)) } else { case }
                }
            })
            .collect();
        batch_is_its_elements(&set, kernel, &cases);
    }
}

/// Bit for bit what they are alone, and what they are number by number if that is sound.
#[track_caller]
fn batch_is_its_elements(set: &GapKernels, kernel: Kernel, cases: &[Case]) {
    let number_by_number: Vec<Found> =
        cases.iter().map(|case| set.single(Isa::SCALAR, kernel, case, 0)).collect();
    for isa in instructions() {
        let alone = alone(set, isa, kernel, cases);
        let all: Vec<&Case> = cases.iter().collect();
        assert_independent(
            set,
            isa,
            kernel,
            &all,
            &alone.iter().collect::<Vec<_>>(),
            &mut Workspace::default(),
        );
        for ((case, found), expected) in cases.iter().zip(&alone).zip(&number_by_number) {
            // Far away, positions are rounded to the distance from the origin.
            if is_well_conditioned(&expected.values) && case.slave.iter().all(|x| x.abs() < 100.0) {
                assert_agrees(found, expected, case);
                assert_agrees(&set.single(isa, kernel, case, 0), expected, case);
            }
        }
    }
}
