//! Integration points of contact over faces.

use std::ptr::null_mut;

use runtime::faces::IntegrationPoint;

use super::message;
use crate::faces::dc_faces;
use crate::faces_points::dc_faces_points;
use crate::status::{DC_BAD_POINTER, DC_BAD_SIZE, DC_OK};

/// They are those of the runtime, bit for bit.
pub fn assert_points(handle: *mut dc_faces, expected: &[IntegrationPoint]) {
    let mut count = 0;
    let [no, none] = [(); 2].map(|()| null_mut());
    // SAFETY: the arrays have the lengths given.
    unsafe {
        let ask = dc_faces_points(handle, null_mut(), no, no, no, no, none, none, 0, &mut count);
        assert_eq!((ask, count), (DC_OK, expected.len()), "{}", message());
        assert!(count > 20);
        let mut faces = vec![-1; count];
        let [mut areas, mut gaps, mut pressures] = [(); 3].map(|()| vec![0.0; count]);
        let [mut positions, mut normals, mut tractions] = [(); 3].map(|()| vec![0.0; 3 * count]);
        let mut read = |room: usize, tractions: *mut f64| {
            dc_faces_points(
                handle,
                faces.as_mut_ptr(),
                positions.as_mut_ptr(),
                areas.as_mut_ptr(),
                gaps.as_mut_ptr(),
                normals.as_mut_ptr(),
                pressures.as_mut_ptr(),
                tractions,
                room,
                null_mut(),
            )
        };
        assert_eq!(read(count - 1, tractions.as_mut_ptr()), DC_BAD_SIZE);
        assert_eq!(read(count, tractions.as_mut_ptr()), DC_OK, "{}", message());
        let same = areas.as_mut_ptr();
        let twice = dc_faces_points(handle, null_mut(), no, same, same, no, none, none, count, null_mut());
        assert_eq!(twice, DC_BAD_POINTER);
        for (k, point) in expected.iter().enumerate() {
            assert_eq!(faces[k] as usize, point.face);
            assert_eq!([areas[k], gaps[k], pressures[k]], [point.area, point.gap, point.pressure]);
            let of_point = [&positions, &normals, &tractions].map(|all| &all[3 * k..3 * k + 3]);
            assert_eq!(of_point, [&point.position[..], &point.normal, &point.friction]);
        }
    }
}
