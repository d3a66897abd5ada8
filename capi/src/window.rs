//! Windows of a surface: what some slaves can need of it, where nobody holds the whole.

use runtime::interface::ContactInterface;
use runtime::surface::window::{Box3, Window};

use crate::border::{self, disjoint, input, reserve, roomy, wanted};
use crate::interface::{State, dc_interface, insert, with};
use crate::mesh::{check_nodes, facet_rows, facets_of, points, slaves_of};
use crate::options::dc_options;
use crate::registry::Registry;
use crate::status::{DC_BAD_SIZE, Failure, dc_status};
use crate::threads;

/// What some slaves can need of a master surface, by the numbers of the whole. One thread at a time may use it, any thread.
pub struct dc_window;

pub(super) static WINDOWS: Registry<Window> = Registry::new("window", 4);

/// Boxes, 6 numbers each.
///
/// # Safety
/// As [`input`].
pub unsafe fn boxes_of(boxes: *const f64, box_count: usize) -> Result<Vec<Box3>, Failure> {
    let too_many = || Failure::new(DC_BAD_SIZE, format!("bad-size: there cannot be {box_count} boxes"));
    let count = box_count.checked_mul(6).ok_or_else(too_many)?;
    let (rows, _) = unsafe { input("boxes", boxes, count)? }.as_chunks::<6>();
    let mut made = reserve("boxes", rows.len())?;
    made.extend(rows.iter().map(|&[x, y, z, a, b, c]| [[x, y, z], [a, b, c]]));
    Ok(made)
}

/// Cuts a window out of the master surface of an interface, at the positions of its last dc_update, dc_follow or dc_refresh: what slaves in
/// `box_count` boxes can need of it, 6 numbers each: lowest and highest x, y, z. The window holds while no node of the master has moved by more than
/// `skin`. It needs DC_DOMAINS, else DC_BAD_OPTION; so it is for boxes that are none and for an interface that has a window only.
///
/// Boxes reach beyond the slaves by distance_limit, and by what slaves move until the next window. On failure the handle is NULL.
///
/// # Safety
/// `boxes` has 6 `box_count` entries, `window` may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_window_create(
    interface: *mut dc_interface,
    boxes: *const f64,
    box_count: usize,
    skin: f64,
    window: *mut *mut dc_window,
) -> dc_status {
    border::call(|| {
        let make = || {
            let boxes = unsafe { boxes_of(boxes, box_count)? };
            with(interface, |state| WINDOWS.insert(threads::run(|| state.interface.window(&boxes, skin))?))
        };
        unsafe { border::hand_out("window", window, make) }
    })
}

/// Destroys a window. NULL is DC_OK. Interfaces made of it stay.
#[unsafe(no_mangle)]
pub extern "C" fn dc_window_destroy(window: *mut dc_window) -> dc_status {
    WINDOWS.destroy(window)
}

/// Numbers of nodes and facets of a window, and of the integers and floating-point numbers of dc_window_numbers. Each may be NULL.
///
/// # Safety
/// Each is NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_window_counts(
    window: *mut dc_window,
    node_count: *mut usize,
    facet_count: *mut usize,
    integer_count: *mut usize,
    real_count: *mut usize,
) -> dc_status {
    WINDOWS.call(window, |window| {
        let nodes = wanted("node_count", node_count, 1, 1)?;
        let facets = wanted("facet_count", facet_count, 1, 1)?;
        let integers = wanted("integer_count", integer_count, 1, 1)?;
        let reals = wanted("real_count", real_count, 1, 1)?;
        disjoint([nodes.span(), facets.span(), integers.span(), reals.span()])?;
        let (integer_count, real_count) = window.count_numbers();
        unsafe {
            nodes.write([window.nodes().len()]);
            facets.write([window.facets().len()]);
            integers.write([integer_count]);
            reals.write([real_count]);
        }
        Ok(())
    })
}

/// Numbers of its nodes and of its facets in the whole surface, ascending. Either may be NULL.
///
/// # Safety
/// The arrays have the given lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_window_names(
    window: *mut dc_window,
    nodes: *mut i64,
    node_count: usize,
    facets: *mut i64,
    facet_count: usize,
) -> dc_status {
    WINDOWS.call(window, |window| {
        let nodes = wanted("nodes", nodes, node_count, window.nodes().len())?;
        let facets = wanted("facets", facets, facet_count, window.facets().len())?;
        disjoint([nodes.span(), facets.span()])?;
        unsafe {
            nodes.write(window.nodes().map(|number| number as i64));
            facets.write(window.facets().map(|number| number as i64));
        }
        Ok(())
    })
}

/// The window as plain numbers, to be sent: dc_window_from_numbers makes the same one of them. dc_window_counts tells how many they are.
///
/// # Safety
/// The arrays have the given lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_window_numbers(
    window: *mut dc_window,
    integers: *mut i64,
    integer_count: usize,
    reals: *mut f64,
    real_count: usize,
) -> dc_status {
    WINDOWS.call(window, |window| {
        let numbers = window.to_numbers();
        let integers = roomy("integers", integers, integer_count, numbers.0.len())?;
        let reals = roomy("reals", reals, real_count, numbers.1.len())?;
        disjoint([integers.span(), reals.span()])?;
        unsafe {
            integers.write(numbers.0);
            reals.write(numbers.1);
        }
        Ok(())
    })
}

/// Makes a window of the numbers of dc_window_numbers; DC_BAD_OPTION for others. On failure the handle is NULL.
///
/// # Safety
/// The arrays have the given lengths, `window` may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_window_from_numbers(
    integers: *const i64,
    integer_count: usize,
    reals: *const f64,
    real_count: usize,
    window: *mut *mut dc_window,
) -> dc_status {
    border::call(|| {
        let make = || {
            let (integers, reals) =
                unsafe { (input("integers", integers, integer_count)?, input("reals", reals, real_count)?) };
            WINDOWS.insert(Window::from_numbers(integers, reals)?)
        };
        unsafe { border::hand_out("window", window, make) }
    })
}

/// Makes an interface of slaves that know a window of the master only. As dc_create, but the first nodes are those of the window, in the order
/// of dc_window_names, where they were when it was made; slaves come after them. Planes of symmetry come with the window. Weight, basis and
/// feature angle have to be those that it was made with, else DC_BAD_OPTION.
///
/// With `areas` of `options` slaves and all other nodes of `slave_facets` have to be in their first positions here, also in a later
/// increment: areas are those at these positions. `slave_facets` are all facets at the slaves, in the order of the whole.
///
/// Results are those of an interface with the whole surface, bit for bit, or the outcome DC_BEYOND_WINDOW. dc_set_symmetry is refused.
///
/// # Safety
/// As dc_create.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_create_in_window(
    window: *mut dc_window,
    positions: *const f64,
    node_count: usize,
    slaves: *const i32,
    slave_count: usize,
    slave_facets: *const i32,
    slave_facet_count: usize,
    options: *const dc_options,
    interface: *mut *mut dc_interface,
) -> dc_status {
    border::call(|| {
        let make = || {
            let (positions, slaves, facets, options) = unsafe {
                (
                    points(positions, node_count)?,
                    input("slaves", slaves, slave_count)?,
                    facet_rows("slave_facets", slave_facets, slave_facet_count)?,
                    dc_options::read(options)?,
                )
            };
            check_nodes(positions.len())?;
            let slaves = slaves_of(slaves)?;
            let limit = options.cutback_limit()?;
            let facets = facets_of(facets)?;
            let options = options.interface_beside(&facets)?;
            let contact = WINDOWS.with(window.addr(), |window| {
                Ok(threads::run(|| ContactInterface::in_window(window, slaves, &facets, positions, options))?)
            })?;
            insert(State::new(contact, positions.len(), limit))
        };
        unsafe { border::hand_out("interface", interface, make) }
    })
}
