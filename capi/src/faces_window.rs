//! Contact over faces of a rank that knows windows of both surfaces only.

use runtime::faces::FaceInterface;

use crate::border;
use crate::faces::{dc_faces, face_options, insert};
use crate::mesh::{check_nodes, points};
use crate::options::dc_options;
use crate::status::dc_status;
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
/// known. The history of friction names nodes by their numbers in the whole surfaces, as dc_window_names: two points of each node.
///
/// DC_BAD_OPTION without a `distance_limit`, and for windows of other options or planes of symmetry. dc_faces_set_symmetry and
/// dc_faces_add_quadratic are DC_BAD_OPTION, too, with the message "in-window". On failure the handle is NULL.
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
            // SAFETY: as the caller promises.
            let (positions, options) =
                unsafe { (points(positions, node_count)?, dc_options::read(options)?) };
            check_nodes(positions.len())?;
            let options = face_options(&options, degree)?;
            let interface = WINDOWS.with(master.addr(), |master| {
                WINDOWS.with(slave.addr(), |slave| {
                    Ok(threads::run(|| FaceInterface::in_window(master, slave, positions, options))??)
                })
            })?;
            insert(interface, positions.len())
        };
        // SAFETY: as the caller promises.
        unsafe { border::hand_out("faces", faces, make) }
    })
}
