//! Laws by table, coefficients by pressure and rate, rounds of augmentation: the numbers of the runtime bit for bit.

use std::ffi::c_void;
use std::ptr::{from_mut, null, null_mut};

use runtime::Mode;
use runtime::assembly::{ContactLaw, DofMap, NormalLaw, NormalPressure, TabulatedPressure};
use runtime::faces::FaceInterface;
use runtime::friction::{
    CoefficientValue, Coulomb, DecayingCoefficient, FrictionCoefficient, TabulatedCoefficient,
};

use super::faces::{Pair, law};
use super::misuse::LAW;
use super::{Mesh, message};
use crate::assembly::dc_add_forces;
use crate::choice::dc_coefficient::{DC_DECAYING, DC_FUNCTION, DC_TABULATED};
use crate::contacts::dc_forces;
use crate::faces::*;
use crate::faces_assembly::*;
use crate::faces_friction::*;
use crate::friction::{dc_augment, dc_augmented_history, dc_roll_back, dc_slip_errors};
use crate::interface::{dc_destroy, dc_evaluate, dc_refresh};
use crate::law::dc_law;
use crate::status::{DC_BAD_OPTION, DC_BAD_POINTER, DC_BAD_SIZE, DC_NOT_EVALUATED, DC_OK, dc_status};

const GAPS: [f64; 3] = [-0.1, -0.02, 0.0];
const PRESSURES: [f64; 3] = [41.0, 1.0, 0.0];
const LEVELS: [f64; 2] = [0.0, 20.0];
const RATES: [f64; 2] = [0.0, 1.0];
const COEFFICIENTS: [f64; 4] = [0.5, 0.4, 0.3, 0.2];

/// With a table of pressures.
fn tabulated(law: dc_law) -> dc_law {
    dc_law { normal_gaps: GAPS.as_ptr(), normal_pressures: PRESSURES.as_ptr(), normal_count: 3, ..law }
}

/// With a coefficient that is a law.
fn sliding(coefficient: i32) -> dc_law {
    let law = dc_law { coefficient, duration: 0.5, augmented: 1, ..law(&[]) };
    if coefficient == DC_DECAYING as i32 {
        return dc_law { friction: 0.5, friction_in_motion: 0.2, friction_decay: 2.0, ..law };
    }
    dc_law {
        friction_pressures: LEVELS.as_ptr(),
        friction_pressure_count: 2,
        friction_rates: RATES.as_ptr(),
        friction_rate_count: 2,
        friction_table: COEFFICIENTS.as_ptr(),
        ..law
    }
}

/// Laws as functions of the caller's: those of objects that the context has.
struct Laws {
    normal: TabulatedPressure,
    friction: DecayingCoefficient,
}

unsafe extern "C" fn pressure(context: *mut c_void, slave: usize, gap: f64, found: *mut f64) {
    // SAFETY: of `as_functions`; there is room for two numbers.
    let (laws, found) = unsafe { (&*context.cast::<Laws>(), &mut *found.cast::<[f64; 2]>()) };
    let NormalPressure { pressure, by_gap } = laws.normal.pressure(slave, gap);
    *found = [pressure, by_gap];
}

unsafe extern "C" fn coefficient(context: *mut c_void, pressure: f64, rate: f64, found: *mut f64) {
    // SAFETY: of `as_functions`; there is room for three numbers.
    let (laws, found) = unsafe { (&*context.cast::<Laws>(), &mut *found.cast::<[f64; 3]>()) };
    let CoefficientValue { value, by_pressure, by_rate } = laws.friction.coefficient(pressure, rate);
    *found = [value, by_pressure, by_rate];
}

unsafe extern "C" fn no_coefficient(_: *mut c_void, _: f64, _: f64, found: *mut f64) {
    // SAFETY: there is room for three numbers.
    unsafe { *found = f64::NAN };
}

unsafe extern "C" fn nothing(_: *mut c_void, _: usize, _: f64, _: *mut f64) {}

fn as_functions(laws: &mut Laws) -> dc_law {
    dc_law {
        coefficient: DC_FUNCTION as i32,
        duration: 0.5,
        augmented: 1,
        normal_law: Some(pressure),
        friction_law: Some(coefficient),
        context: from_mut(laws).cast(),
        ..law(&[])
    }
}

#[test]
fn functions_of_the_caller_have_the_numbers_of_tables() {
    let pair = Pair::new();
    let moved: Vec<f64> = (0..)
        .zip(&pair.positions)
        .map(|(k, x)| if k >= 243 && k % 3 == 0 { x + 0.004 } else { *x })
        .collect();
    let mut laws = Laws {
        normal: TabulatedPressure::new(&GAPS, &PRESSURES).unwrap(),
        friction: DecayingCoefficient::new(0.5, 0.2, 2.0).unwrap(),
    };
    let own = as_functions(&mut laws);
    let expected = by_calls(&pair, &moved, &tabulated(sliding(DC_DECAYING as i32)));
    assert_eq!(by_calls(&pair, &moved, &own), expected);

    // What is refused has a reason.
    let mesh = Mesh::new();
    let handle = mesh.interface();
    let mut sum = vec![0.0; 120];
    // SAFETY: the arrays have the lengths given, or are refused.
    unsafe {
        assert_eq!(dc_refresh(handle, mesh.positions.as_ptr(), 40, null_mut()), DC_OK);
        assert_eq!(dc_evaluate(handle, 2), DC_OK);
        let mut refused = |law: dc_law, code: &str| {
            let status = dc_add_forces(handle, &law, sum.as_mut_ptr(), 120, null_mut());
            assert_ne!(status, DC_OK, "{code}");
            assert!(message().starts_with(code), "{code}: {}", message());
            assert!(sum.iter().all(|x| *x == 0.0));
            let forces = dc_forces(handle, &law, null_mut(), sum.as_mut_ptr(), null_mut(), 4);
            assert_ne!(forces, DC_OK, "{code}");
            assert!(message().starts_with(code), "{code}: {}", message());
        };
        refused(tabulated(own), "invalid-option: normal_law");
        refused(dc_law { friction: 0.1, ..own }, "invalid-option: with DC_FUNCTION");
        refused(dc_law { friction_law: None, ..own }, "invalid-option: DC_FUNCTION");
        refused(dc_law { penalty: -5.0, friction: 0.3, ..LAW }, "invalid-penalty");
        // It writes nothing.
        refused(dc_law { normal_law: Some(nothing), ..LAW }, "invalid-pressure");
    }
    assert_eq!(dc_destroy(handle), DC_OK);
}

/// A coefficient that is none is a mistake of the caller's own function, not of a state to cut back from.
#[test]
fn a_coefficient_that_is_none_is_a_bad_option() {
    let pair = Pair::new();
    let mut laws = Laws {
        normal: TabulatedPressure::new(&GAPS, &PRESSURES).unwrap(),
        friction: DecayingCoefficient::new(0.5, 0.2, 2.0).unwrap(),
    };
    let own = as_functions(&mut laws);
    let bad = dc_law { friction_law: Some(no_coefficient), ..own };
    let (_, handle) = pair.make(2);
    // SAFETY: the arrays have the lengths given.
    unsafe {
        assert_eq!(dc_faces_refresh(handle, pair.positions.as_ptr(), pair.nodes(), null_mut()), DC_OK);
        let accepted =
            dc_faces_accept(handle, &own, null_mut(), null_mut(), null_mut(), null_mut(), null_mut());
        assert_eq!(accepted, DC_OK, "{}", message());
        assert_eq!(dc_faces_evaluate(handle, &bad, 2), DC_BAD_OPTION, "{}", message());
        assert!(
            message().starts_with("invalid-coefficient: the coefficient of friction of element "),
            "{}",
            message()
        );
        assert!(message().contains(" is NaN at the pressure "), "{}", message());
    }
    assert_eq!(dc_faces_destroy(handle), DC_OK);
}

/// Residual and slip errors after a step, after a round for every second node, and after it was rolled back.
fn by_runtime(mut faces: FaceInterface, pair: &Pair, moved: &[f64], law: &ContactLaw<'_>) -> Vec<Vec<f64>> {
    let [first, moved] = [&pair.positions[..], moved].map(|positions| positions.as_chunks::<3>().0);
    let dofs = DofMap::standard(pair.nodes());
    faces.refresh(first).unwrap();
    faces.accept(law).unwrap();
    faces.refresh(moved).unwrap();
    let mut found = Vec::new();
    for round in 0..3 {
        match round {
            0 => {}
            1 => faces.augment(law, |k| k % 2 == 0).unwrap(),
            _ => {
                faces.roll_back();
                faces.refresh(moved).unwrap();
            }
        }
        let mut residual = vec![0.0; dofs.equations()];
        faces.evaluate(law, Mode::Hessian).unwrap().add_forces(&dofs, &mut residual).unwrap();
        found.extend([residual, faces.slip_errors(law).unwrap()]);
    }
    found
}

/// The same by calls of C.
fn by_calls(pair: &Pair, moved: &[f64], law: &dc_law) -> Vec<Vec<f64>> {
    let (_, handle) = pair.make(2);
    let done = |status: dc_status| assert_eq!(status, DC_OK, "{}", message());
    let refresh = |positions: &[f64]| {
        // SAFETY: the array has the length given.
        done(unsafe { dc_faces_refresh(handle, positions.as_ptr(), pair.nodes(), null_mut()) });
    };
    let every_second: Vec<i32> = (0..25).map(|k| 1 - k % 2).collect();
    let mut found = Vec::new();
    // SAFETY: the arrays have the lengths given.
    unsafe {
        refresh(&pair.positions);
        done(dc_faces_accept(handle, law, null_mut(), null_mut(), null_mut(), null_mut(), null_mut()));
        refresh(moved);
        for round in 0..3 {
            let mut residual = vec![0.0; moved.len()];
            match round {
                0 => {}
                1 => {
                    done(dc_faces_augment(handle, law, every_second.as_ptr(), 25));
                    let target = residual.as_mut_ptr();
                    let status = dc_faces_add_forces(handle, target, moved.len(), null_mut(), null_mut());
                    assert_eq!(status, DC_NOT_EVALUATED);
                }
                _ => {
                    done(dc_faces_roll_back(handle));
                    refresh(moved);
                }
            }
            type Read = unsafe extern "C" fn(*mut dc_faces, *mut f64, usize, *mut usize) -> dc_status;
            let histories = [dc_faces_history as Read, dc_faces_augmented_history].map(|read| {
                let (mut numbers, mut count) = (vec![0.0; 4000], 0);
                done(read(handle, numbers.as_mut_ptr(), numbers.len(), &mut count));
                numbers.truncate(count);
                numbers
            });
            // The round is in the one, and in the other from the next accepted step on.
            assert_eq!(histories[0] == histories[1], round != 1);
            assert!(histories[0].len() > 25);
            done(dc_faces_evaluate(handle, law, 2));
            done(dc_faces_add_forces(handle, residual.as_mut_ptr(), moved.len(), null_mut(), null_mut()));
            let mut errors = vec![0.0; 25];
            done(dc_faces_slip_errors(handle, law, errors.as_mut_ptr(), 25));
            found.extend([residual, errors]);
        }
    }
    assert_eq!(dc_faces_destroy(handle), DC_OK);
    found
}

#[test]
fn laws_over_faces_have_the_numbers_of_the_runtime() {
    let pair = Pair::new();
    let moved: Vec<f64> = (0..)
        .zip(&pair.positions)
        .map(|(k, x)| if k >= 243 && k % 3 == 0 { x + 0.004 } else { *x })
        .collect();
    let table = TabulatedPressure::new(&GAPS, &PRESSURES).unwrap();
    let decaying = DecayingCoefficient::new(0.5, 0.2, 2.0).unwrap();
    let bilinear = TabulatedCoefficient::new(&LEVELS, &RATES, &COEFFICIENTS).unwrap();
    let coefficients: [(i32, &dyn FrictionCoefficient); 2] =
        [(DC_DECAYING as i32, &decaying), (DC_TABULATED as i32, &bilinear)];
    for (kind, coefficient) in coefficients {
        let friction = Coulomb::variable(coefficient, 0.5, 300.0).unwrap().with_augmentation(true);
        let own = ContactLaw::penalty(300.0).with_friction(Some(friction));
        for (own, law) in [(own, sliding(kind)), (own.with_normal(Some(&table)), tabulated(sliding(kind)))] {
            let expected = by_runtime(pair.runtime(), &pair, &moved, &own);
            assert_eq!(by_calls(&pair, &moved, &law), expected);
            // Rounds change the forces, and are forgotten.
            assert!(expected[0] != expected[2] && expected[0] == expected[4]);
            assert!(expected[1].iter().any(|error| *error > 0.0));
        }
    }
}

#[test]
fn nodes_have_pressures_by_table() {
    let mesh = Mesh::new();
    let handle = mesh.interface();
    let law = tabulated(LAW);
    // SAFETY: the arrays have the lengths given, or are refused.
    unsafe {
        assert_eq!(dc_refresh(handle, mesh.positions.as_ptr(), 40, null_mut()), DC_OK);
        assert_eq!(dc_evaluate(handle, 2), DC_OK);
        let (mut depths, mut forces, mut pressures) = ([0.0; 4], [0.0; 4], [0.0; 4]);
        let (depth, force, pressure) = (depths.as_mut_ptr(), forces.as_mut_ptr(), pressures.as_mut_ptr());
        assert_eq!(dc_forces(handle, &law, depth, force, pressure, 4), DC_OK, "{}", message());
        for (depth, pressure) in depths.iter().zip(pressures) {
            let expected = if *depth > 0.02 { 1.0 + 500.0 * (depth - 0.02) } else { 50.0 * depth };
            assert!((pressure - expected).abs() < 1e-12, "{depth} {pressure} {expected}");
        }
        let mut residual = vec![0.0; 120];
        assert_eq!(dc_add_forces(handle, &law, residual.as_mut_ptr(), 120, null_mut()), DC_OK);
        let up: f64 = (36..40).map(|node| residual[3 * node + 2]).sum();
        assert!(up > 0.9 * forces.iter().sum::<f64>());

        // What is refused changes nothing.
        let before = residual.clone();
        let target = residual.as_mut_ptr();
        let refused = |law: dc_law, status, code: &str| {
            assert_eq!(dc_add_forces(handle, &law, target, 120, null_mut()), status, "{code}: {}", message());
            assert!(message().starts_with(code), "{}", message());
        };
        let multipliers = [0.0; 4];
        // Counts that were forgotten.
        refused(dc_law { multipliers: multipliers.as_ptr(), ..LAW }, DC_BAD_SIZE, "multiplier-count");
        refused(dc_law { normal_count: 0, ..law }, DC_BAD_SIZE, "bad-size");
        refused(dc_law { normal_gaps: null(), normal_count: 0, ..law }, DC_BAD_SIZE, "bad-size");
        refused(dc_law { friction_pressure_count: 0, ..sliding(2) }, DC_BAD_SIZE, "bad-size");
        refused(dc_law { friction_rate_count: 0, ..sliding(2) }, DC_BAD_SIZE, "bad-size");
        refused(dc_law { normal_count: 1, ..law }, DC_BAD_OPTION, "invalid-table");
        refused(dc_law { normal_gaps: null(), ..law }, DC_BAD_POINTER, "bad-pointer");
        refused(dc_law { normal_pressures: target, ..law }, DC_BAD_POINTER, "bad-pointer");
        refused(dc_law { normal_gaps: PRESSURES.as_ptr(), ..law }, DC_BAD_OPTION, "invalid-table");
        let both = dc_law { multipliers: multipliers.as_ptr(), multiplier_count: 4, ..law };
        refused(both, DC_BAD_OPTION, "multipliers-of-own-law");
        refused(dc_law { coefficient: 4, ..LAW }, DC_BAD_OPTION, "invalid-option");
        refused(dc_law { augmented: 2, ..LAW }, DC_BAD_OPTION, "invalid-option");
        refused(dc_law { duration: 0.0, ..sliding(1) }, DC_BAD_OPTION, "invalid-duration");
        refused(dc_law { friction_decay: -1.0, ..sliding(1) }, DC_BAD_OPTION, "invalid-decay");
        refused(dc_law { friction: 0.1, ..sliding(2) }, DC_BAD_OPTION, "invalid-option");
        refused(dc_law { friction_rates: null(), ..sliding(2) }, DC_BAD_POINTER, "bad-pointer");
        let huge = dc_law { friction_pressure_count: usize::MAX, ..sliding(2) };
        refused(huge, DC_BAD_SIZE, "bad-size");
        refused(dc_law { friction_rates: PRESSURES.as_ptr(), ..sliding(2) }, DC_BAD_OPTION, "invalid-table");
        // Fields of another coefficient than the law's.
        for (kind, own) in [("DC_CONSTANT", LAW), ("DC_TABULATED", sliding(2))] {
            let of =
                format!("invalid-option: friction_decay belongs to DC_DECAYING, and coefficient is {kind}");
            refused(dc_law { friction_decay: 1.0, ..own }, DC_BAD_OPTION, &of);
            refused(dc_law { friction_in_motion: 0.2, ..own }, DC_BAD_OPTION, "invalid-option");
            refused(dc_law { friction_law: Some(coefficient), ..own }, DC_BAD_OPTION, "invalid-option");
        }
        for kind in [0, 1, 3] {
            let own = dc_law { coefficient: kind, ..sliding(2) };
            refused(own, DC_BAD_OPTION, "invalid-option: friction_pressures belongs to DC_TABULATED");
            let own = dc_law { friction_pressures: null(), friction_pressure_count: 0, ..own };
            refused(own, DC_BAD_OPTION, "invalid-option: friction_rates belongs to DC_TABULATED");
        }
        refused(dc_law { friction_law: Some(coefficient), ..sliding(1) }, DC_BAD_OPTION, "invalid-option");
        let rough = dc_law { friction: 0.3, ..LAW };
        let mut errors = [9.0; 4];
        assert_eq!(dc_slip_errors(handle, &rough, errors.as_mut_ptr(), 4), DC_BAD_OPTION);
        assert!(message().starts_with("no-augmentation: "), "{}", message());
        assert_eq!(dc_slip_errors(handle, &LAW, errors.as_mut_ptr(), 3), DC_BAD_SIZE);
        assert_eq!(dc_augment(handle, &rough, null(), 4), DC_BAD_OPTION);
        assert_eq!(dc_augment(handle, &sliding(1), [0, 1, 2, 0].as_ptr(), 4), DC_BAD_OPTION);
        assert!(message().starts_with("invalid-option: moves is 2"), "{}", message());
        assert_eq!((errors, residual), ([9.0; 4], before));
        // Without friction there is nothing to take over, and the evaluation stays.
        assert_eq!(dc_augment(handle, &LAW, null(), 4), DC_OK, "{}", message());
        assert_eq!(dc_slip_errors(handle, &LAW, errors.as_mut_ptr(), 4), DC_OK, "{}", message());
        assert_eq!(errors, [0.0; 4]);
        let mut count = 9;
        assert_eq!(dc_augmented_history(handle, null_mut(), 0, &mut count), DC_OK, "{}", message());
        assert_eq!(count, 0);
        let mut residual = vec![0.0; 120];
        assert_eq!(dc_add_forces(handle, &LAW, residual.as_mut_ptr(), 120, null_mut()), DC_OK);
        // Nothing was augmented, so that pairings stay.
        assert_eq!(dc_roll_back(handle), DC_OK);
        assert_eq!(dc_evaluate(handle, 2), DC_OK);
    }
    assert_eq!(dc_destroy(handle), DC_OK);
}
