//! Integration points of contact over faces.

use crate::border::{disjoint, wanted};
use crate::faces::{call, dc_faces};
use crate::status::dc_status;
use crate::threads;

/// What contact is at the integration points that lie over the master, face by face, by the pressures of the last dc_faces_evaluate; found
/// anew by each call. `faces_of_points` gets numbers of their faces among the slave's; `positions` places on the slave's own smooth surface,
/// 3 numbers each, length; `areas` what each stands for of its face in the first configuration, length^2; `gaps` length; `normals` the unit
/// normals of the master, 3 numbers each; `pressures` force per area, interpolated between the nodes or their own as dc_faces_set_pressures says; `tractions` friction on the slave, 3 numbers each, force per area.
///
/// Each may be NULL. With all of them NULL `point_count` gets how many points there are. DC_BAD_SIZE where `capacity` is less.
/// DC_NOT_EVALUATED at positions that have no evaluation.
///
/// # Safety
/// The arrays have room for `capacity` points; `point_count` is NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_points(
    faces: *mut dc_faces,
    faces_of_points: *mut i32,
    positions: *mut f64,
    areas: *mut f64,
    gaps: *mut f64,
    normals: *mut f64,
    pressures: *mut f64,
    tractions: *mut f64,
    capacity: usize,
    point_count: *mut usize,
) -> dc_status {
    call(faces, |state| {
        state.contacts()?;
        let points = threads::run(|| state.interface.integration_points())?;
        let (count, three, room) = (points.len(), 3 * points.len(), capacity.saturating_mul(3));
        let faces_of_points = wanted("faces_of_points", faces_of_points, capacity, count)?;
        let [areas, gaps, pressures] = [("areas", areas), ("gaps", gaps), ("pressures", pressures)]
            .map(|(name, array)| wanted(name, array, capacity, count));
        let [positions, normals, tractions] =
            [("positions", positions), ("normals", normals), ("tractions", tractions)]
                .map(|(name, array)| wanted(name, array, room, three));
        let [areas, gaps, pressures] = [areas?, gaps?, pressures?];
        let [positions, normals, tractions] = [positions?, normals?, tractions?];
        let point_count = wanted("point_count", point_count, 1, 1)?;
        disjoint([
            faces_of_points.span(),
            areas.span(),
            gaps.span(),
            pressures.span(),
            positions.span(),
            normals.span(),
            tractions.span(),
            point_count.span(),
        ])?;
        unsafe {
            faces_of_points.write(points.iter().map(|point| point.face as i32));
            areas.write(points.iter().map(|point| point.area));
            gaps.write(points.iter().map(|point| point.gap));
            pressures.write(points.iter().map(|point| point.pressure));
            positions.write(points.iter().flat_map(|point| point.position));
            normals.write(points.iter().flat_map(|point| point.normal));
            tractions.write(points.iter().flat_map(|point| point.friction));
            point_count.write([count]);
        }
        Ok(())
    })
}
