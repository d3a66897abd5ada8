//! The tangent in a matrix of the caller's, as an operator, and without holding M.

use std::ptr::{null, null_mut};

use super::misuse::LAW;
use super::{Mesh, message};
use crate::interface::{dc_destroy, dc_evaluate, dc_interface, dc_refresh, dc_set_equations};
use crate::law::dc_law;
use crate::map::{dc_map, dc_map_add, dc_map_create, dc_map_create_64, dc_map_destroy};
use crate::operator::{
    dc_operator, dc_operator_create, dc_operator_destroy, dc_operator_diagonal, dc_operator_product,
    dc_operator_transposed_product,
};
use crate::pattern::{dc_pattern_create, dc_pattern_destroy, dc_pattern_fill, dc_pattern_structure};
use crate::status::{
    DC_BAD_HANDLE, DC_BAD_OPTION, DC_BAD_POINTER, DC_BAD_SIZE, DC_NOT_EVALUATED, DC_OK, DC_PATTERN_MISMATCH,
};

const EQUATIONS: usize = 120;

/// Row offsets, columns and values of the tangent.
fn matrix(handle: *mut dc_interface) -> (Vec<i32>, Vec<i32>, Vec<f64>) {
    let (mut pattern, mut count) = (null_mut(), 0);
    // SAFETY: the arrays have the lengths given.
    unsafe {
        assert_eq!(dc_pattern_create(handle, &mut pattern, &mut count), DC_OK);
        let (mut offsets, mut columns) = (vec![0; EQUATIONS + 1], vec![0; count]);
        let rows = (offsets.as_mut_ptr(), columns.as_mut_ptr());
        assert_eq!(dc_pattern_structure(pattern, rows.0, EQUATIONS + 1, rows.1, count), DC_OK);
        let (mut values, mut active) = (vec![0.0; count], 0);
        assert_eq!(
            dc_pattern_fill(pattern, handle, &LAW, values.as_mut_ptr(), count, &mut active),
            DC_OK,
            "{}",
            message()
        );
        assert_eq!(active, 4);
        assert_eq!(dc_pattern_destroy(pattern), DC_OK);
        (offsets, columns, values)
    }
}

fn refreshed(mesh: &Mesh, mode: i32) -> *mut dc_interface {
    let handle = mesh.interface();
    // SAFETY: the array has the length given.
    assert_eq!(unsafe { dc_refresh(handle, mesh.positions.as_ptr(), mesh.nodes(), null_mut()) }, DC_OK);
    assert_eq!(dc_evaluate(handle, mode), DC_OK);
    handle
}

#[test]
fn no_hessian_is_held_for_a_tangent() {
    let mesh = Mesh::new();
    let [held, passing] = [2, 1].map(|mode| refreshed(&mesh, mode));
    assert_eq!(matrix(held), matrix(passing));
    let (mut pattern, mut count) = (null_mut(), 0);
    assert_eq!(dc_evaluate(passing, 0), DC_OK);
    // SAFETY: the arrays have the lengths given.
    unsafe {
        assert_eq!(dc_pattern_create(passing, &mut pattern, &mut count), DC_OK);
        let mut values = vec![0.0; count];
        let status = dc_pattern_fill(pattern, passing, &LAW, values.as_mut_ptr(), count, null_mut());
        assert_eq!(status, DC_NOT_EVALUATED, "{}", message());
    }
    assert_eq!(dc_pattern_destroy(pattern), DC_OK);
    assert_eq!(dc_destroy(held), DC_OK);
    assert_eq!(dc_destroy(passing), DC_OK);
}

#[test]
fn the_tangent_is_added_to_a_matrix_of_the_caller() {
    let mesh = Mesh::new();
    let handle = refreshed(&mesh, 1);
    let (offsets, columns, expected) = matrix(handle);
    // The caller's matrix is full.
    let full: Vec<i64> = (0..=EQUATIONS as i64).map(|row| row * EQUATIONS as i64).collect();
    let all: Vec<i64> = (0..EQUATIONS * EQUATIONS).map(|k| (k % EQUATIONS) as i64).collect();
    let (mut own, mut dense) = (null_mut::<dc_map>(), null_mut::<dc_map>());
    let (rows, count) = (EQUATIONS + 1, columns.len());
    let wide = (full.as_ptr(), all.as_ptr(), all.len());
    // SAFETY: the arrays have the lengths given.
    unsafe {
        let create = |offsets: &[i32], columns: &[i32], map: &mut *mut dc_map| {
            dc_map_create(handle, offsets.as_ptr(), offsets.len(), columns.as_ptr(), columns.len(), map)
        };
        assert_eq!(create(&offsets, &columns, &mut own), DC_OK);
        assert_eq!(dc_map_create_64(handle, wide.0, rows, wide.1, wide.2, &mut dense), DC_OK);
        let add = |map, values: &mut [f64]| {
            let mut active = 9;
            let status = dc_map_add(map, handle, &LAW, values.as_mut_ptr(), values.len(), &mut active);
            assert!(status != DC_OK || active == 4);
            status
        };
        let mut values = vec![0.0; count];
        assert_eq!(add(own, &mut values), DC_OK);
        assert_eq!(values, expected);
        let mut square = vec![1.0; all.len()];
        assert_eq!(add(dense, &mut square), DC_OK);
        let ones = square.iter().filter(|value| **value == 1.0).count();
        assert!(ones >= all.len() - count);
        for row in 0..EQUATIONS {
            for k in offsets[row] as usize..offsets[row + 1] as usize {
                let found = square[row * EQUATIONS + columns[k] as usize];
                assert!((found - 1.0 - expected[k]).abs() <= 1e-12, "{row} {k}");
            }
        }
        // What is refused changes nothing, and says where.
        let mut none = std::ptr::dangling_mut();
        assert_eq!(create(&offsets, &columns[..count - 1], &mut none), DC_BAD_OPTION);
        assert!(none.is_null() && message().starts_with("invalid-row: "), "{}", message());
        let diagonal: Vec<i32> = (0..=EQUATIONS as i32).collect();
        assert_eq!(create(&diagonal, &diagonal[..EQUATIONS], &mut none), DC_BAD_OPTION);
        assert!(message().starts_with("missing-entry: "), "{}", message());
        assert_eq!(create(&offsets[1..], &columns, &mut none), DC_BAD_SIZE);
        assert_eq!(dc_map_create(handle, null(), rows, columns.as_ptr(), count, &mut none), DC_BAD_POINTER);
        assert_eq!(add(own, &mut values[1..]), DC_BAD_SIZE);
        assert_eq!(add(handle.cast(), &mut values), DC_BAD_HANDLE);
        let law = dc_law { multipliers: values.as_ptr(), multiplier_count: 4, ..LAW };
        let status = dc_map_add(own, handle, &law, values.as_mut_ptr(), count, null_mut());
        assert_eq!(status, DC_BAD_POINTER, "{}", message());
        let backwards: Vec<i32> = (0..EQUATIONS as i32).rev().collect();
        assert_eq!(dc_set_equations(handle, backwards.as_ptr(), 40, EQUATIONS), DC_OK);
        assert_eq!(add(own, &mut values), DC_PATTERN_MISMATCH);
        assert_eq!(message(), "pattern-mismatch: node 0 has had other equations when the map was made");
        assert_eq!(values, expected);
    }
    assert_eq!(dc_destroy(handle), DC_OK);
    assert_eq!(dc_map_destroy(own), DC_OK);
    assert_eq!(dc_map_destroy(dense), DC_OK);
    assert_eq!(dc_map_destroy(own), DC_BAD_HANDLE);
    assert_eq!(dc_map_destroy(null_mut()), DC_OK);
}

#[test]
fn the_operator_is_the_matrix() {
    let mesh = Mesh::new();
    let handle = refreshed(&mesh, 2);
    let (offsets, columns, values) = matrix(handle);
    let v: Vec<f64> = (0..EQUATIONS).map(|k| (0.7 * k as f64).sin()).collect();
    let (mut expected, mut diagonal) = (vec![1.0; EQUATIONS], vec![0.0; EQUATIONS]);
    for row in 0..EQUATIONS {
        for k in offsets[row] as usize..offsets[row + 1] as usize {
            expected[row] += values[k] * v[columns[k] as usize];
            if columns[k] as usize == row {
                diagonal[row] = values[k];
            }
        }
    }
    let largest = values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let close = |one: &[f64], other: &[f64]| {
        one.iter().zip(other).all(|(one, other)| (one - other).abs() <= 1e-13 * largest)
    };
    let (mut tangent, mut active) = (null_mut::<dc_operator>(), 0);
    // SAFETY: the arrays have the lengths given.
    unsafe {
        let friction = dc_law { friction: 0.2, ..LAW };
        // Nothing was accepted; without kernels there is nothing that could be.
        let (status, code) = if cfg!(feature = "friction") {
            (DC_NOT_EVALUATED, "no-slip: ")
        } else {
            (DC_BAD_OPTION, "no-friction-kernels: ")
        };
        assert_eq!(dc_operator_create(handle, &friction, &mut tangent, null_mut()), status);
        assert!(tangent.is_null() && message().starts_with(code), "{}", message());
        assert_eq!(dc_operator_create(handle, &LAW, &mut tangent, &mut active), DC_OK);
        assert_eq!(active, 4);
        // It outlives the interface.
        assert_eq!(dc_destroy(handle), DC_OK);
        let mut product = vec![1.0; EQUATIONS];
        assert_eq!(dc_operator_product(tangent, v.as_ptr(), product.as_mut_ptr(), EQUATIONS), DC_OK);
        assert!(close(&product, &expected));
        // Without friction K is symmetric.
        let mut transposed = vec![1.0; EQUATIONS];
        let into = transposed.as_mut_ptr();
        assert_eq!(dc_operator_transposed_product(tangent, v.as_ptr(), into, EQUATIONS), DC_OK);
        assert!(close(&transposed, &expected));
        assert_eq!(dc_operator_transposed_product(tangent, into, into, EQUATIONS), DC_BAD_POINTER);
        let mut own = vec![0.0; EQUATIONS];
        assert_eq!(dc_operator_diagonal(tangent, own.as_mut_ptr(), EQUATIONS), DC_OK);
        assert!(close(&own, &diagonal));
        let before = product.clone();
        let place = product.as_mut_ptr();
        assert_eq!(dc_operator_product(tangent, v.as_ptr(), place, EQUATIONS - 1), DC_BAD_SIZE);
        assert_eq!(dc_operator_product(tangent, place, place, EQUATIONS), DC_BAD_POINTER);
        assert_eq!(dc_operator_diagonal(tangent, null_mut(), EQUATIONS), DC_BAD_POINTER);
        assert_eq!(product, before);
        assert_eq!(dc_operator_destroy(tangent), DC_OK);
        assert_eq!(dc_operator_destroy(tangent), DC_BAD_HANDLE);
        assert_eq!(dc_operator_product(tangent, v.as_ptr(), place, EQUATIONS), DC_BAD_HANDLE);
    }
}
