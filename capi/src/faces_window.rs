//! Contact over faces of a rank that knows windows of both surfaces only.

use runtime::faces::FaceInterface;
use runtime::surface::window::Window;

use crate::border;
use crate::faces::{call, dc_faces, face_options, insert, joined, quadratic_faces};
use crate::mesh::{check_nodes, points};
use crate::options::dc_options;
use crate::status::{DC_BAD_OPTION, Failure, dc_status};
use crate::threads;
use crate::window::{WINDOWS, dc_window};

/// Makes an object for contact over faces that knows a window of either surface only, two handles. Nodes are those of `master` in the
/// order of dc_window_names, then those of `slave`; `positions` are where they were when the window of the master was made. The faces are
/// those that meet the boxes of `slave`, which is made once, in the first positions, of an interface whose master surface are the faces
/// of the slave. The boxes of `master` hold these faces and what is within the limit of the distance; it is made anew as for
/// dc_create_in_window.
///
/// Gaps, pressures and areas after a dc_faces_refresh are those of the whole surfaces, bit for bit, or the node has the outcome
/// DC_BEYOND_WINDOW and no pressure. Rows of forces and tangent are those of the whole where all nodes of the faces at their node are
/// known. The history of friction names nodes by their numbers in the whole surfaces, as dc_window_names: two points of each slave.
///
/// DC_BAD_OPTION without a `distance_limit`, and for windows of other options or planes of symmetry. dc_faces_set_symmetry and
/// dc_faces_add_quadratic are DC_BAD_OPTION, too, with the message "in-window"; dc_faces_add_quadratic_by_number is for windows.
/// On failure the handle is NULL.
///
/// # Safety
/// `positions` has 3 `node_count` entries, `options` as many bytes as its field `size` says; `faces` may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_create_in_window(
    master: *mut dc_window,
    slave: *mut dc_window,
    positions: *const f64,
    node_count: usize,
    options: *const dc_options,
    degree: i32,
    faces: *mut *mut dc_faces,
) -> dc_status {
    border::call(|| {
        let make = || {
            let (positions, options) =
                unsafe { (points(positions, node_count)?, dc_options::read(options)?) };
            check_nodes(positions.len())?;
            let options = face_options(&options, degree)?;
            let make = |master: &Window, slave: &Window| {
                Ok(threads::run(|| FaceInterface::in_window(master, slave, positions, options))?)
            };
            let interface = WINDOWS.with(master.addr(), |of_master| {
                if master == slave {
                    return make(of_master, of_master);
                }
                WINDOWS.with(slave.addr(), |of_slave| make(of_master, of_slave))
            })?;
            insert(interface, positions.len())
        };
        unsafe { border::hand_out("faces", faces, make) }
    })
}

/// As dc_faces_add_quadratic, for windows too: nodes are numbers in the whole surface, as dc_window_names. `side`: 0 for faces of the
/// master, 1 for faces of the slave. Hand over all faces that have a node in the window; more do no harm. Where forces would act on a node
/// that the window does not have, the outcome is DC_BEYOND_WINDOW.
///
/// # Safety
/// `quadratic` has `face_count` times `nodes_per_face` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_add_quadratic_by_number(
    faces: *mut dc_faces,
    side: i32,
    quadratic: *const i64,
    face_count: usize,
    nodes_per_face: usize,
) -> dc_status {
    call(faces, |state| {
        let more = unsafe { quadratic_faces(quadratic, face_count, nodes_per_face)? };
        let Some(place) = usize::try_from(side).ok().filter(|&side| side < 2) else {
            let message = format!("invalid-option: side has to be 0 or 1, not {side}");
            return Err(Failure::new(DC_BAD_OPTION, message));
        };
        if !state.interface.is_in_window() {
            return state.add_quadratic(more);
        }
        let all = joined(&state.by_number[place], more)?;
        let [master, slave] = &state.by_number;
        let (master, slave) = if place == 0 { (&all, slave) } else { (master, &all) };
        state.interface.set_quadratic_faces_by_number(master, slave)?;
        state.by_number[place] = all;
        state.evaluated = false;
        Ok(())
    })
}
