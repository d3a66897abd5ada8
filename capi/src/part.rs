//! Parts of a surface, where nobody holds the whole: what windows are cut from.

use runtime::interface::{PartDemands, PartFacets, SurfacePart, split_history};
use runtime::surface::window::{Box3, Extents, Window, boxes_around};

use crate::border::{self, disjoint, input, reserve, roomy, wanted};
use crate::choice::flag;
use crate::mesh::{check_nodes, facet_rows, facets_of, points, symmetry_planes};
use crate::options::dc_options;
use crate::registry::Registry;
use crate::status::{DC_BAD_OPTION, DC_BAD_POINTER, DC_BAD_SIZE, DC_OUT_OF_RANGE, Failure, dc_status};
use crate::threads;
use crate::window::{WINDOWS, boxes_of, dc_window};

/// The facets of a master surface that a rank owns and those around them. One thread at a time may use it, any thread.
pub struct dc_part;

static PARTS: Registry<SurfacePart> = Registry::new("part", 7);

/// Lowest x, y, z, highest x, y, z, the longest edge of a facet.
const EXTENTS: usize = 7;

/// Numbers in the whole surface.
///
/// # Safety
/// As [`input`].
unsafe fn names_of(name: &str, names: *const i64, count: usize) -> Result<Vec<u64>, Failure> {
    let numbers = unsafe { input(name, names, count)? };
    let mut made = reserve(name, count)?;
    for (k, &number) in numbers.iter().enumerate() {
        let negative = |_| Failure::new(DC_OUT_OF_RANGE, format!("negative-number: {name}[{k}] is {number}"));
        made.push(u64::try_from(number).map_err(negative)?);
    }
    Ok(made)
}

/// The `count` numbers of an array that cannot be NULL.
///
/// # Safety
/// As [`input`].
unsafe fn of_length<const N: usize>(name: &str, numbers: *const f64) -> Result<[f64; N], Failure> {
    let numbers = unsafe { input(name, numbers, N)? };
    numbers.try_into().map_err(|_| Failure::new(DC_BAD_POINTER, format!("bad-pointer: {name} is NULL")))
}

/// Lowest x, y, z, highest x, y, z of facets, then the longest edge of one, 7 numbers. Those of the whole surface, for dc_part_create,
/// are the least of the first three of all ranks, and the greatest of the others. Without facets they are infinite, and 0. Facets are
/// checked as in dc_create, each by itself.
///
/// # Safety
/// `positions` has 3 `node_count` entries, `facets` 4 `facet_count`; `extents` has room for 7.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_extents(
    positions: *const f64,
    node_count: usize,
    facets: *const i32,
    facet_count: usize,
    extents: *mut f64,
) -> dc_status {
    border::call(|| {
        let (positions, rows) =
            unsafe { (points(positions, node_count)?, facet_rows("facets", facets, facet_count)?) };
        let target = roomy("extents", extents, EXTENTS, EXTENTS)?;
        disjoint([
            border::read("positions", positions.as_ptr(), positions.len()),
            border::read("facets", rows.as_ptr(), rows.len()),
            target.span(),
        ])?;
        let facets = facets_of(rows)?;
        let part = PartFacets {
            positions,
            node_numbers: &[],
            facets: &facets,
            facet_numbers: &[],
            owned: &vec![true; facets.len()],
            known: [[0.0; 3]; 2],
            extents: Extents::NONE,
        };
        let Extents { low: [a, b, c], high: [d, e, f], facet } = part.own_extents()?;
        unsafe { target.write([a, b, c, d, e, f, facet]) };
        Ok(())
    })
}

/// Boxes around groups of points, for windows: at most `most`, 6 numbers each as in dc_window_create, reaching `reach` beyond each point,
/// finite and at least 0. `box_count` gets how many there are. Points that are not finite belong to no box.
///
/// # Safety
/// `positions` has 3 `point_count` entries, `boxes` room for 6 `most`; `box_count` may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_boxes_around(
    positions: *const f64,
    point_count: usize,
    reach: f64,
    most: usize,
    boxes: *mut f64,
    box_count: *mut usize,
) -> dc_status {
    border::call(|| {
        let around = unsafe { points(positions, point_count)? };
        if !(reach >= 0.0 && reach.is_finite()) {
            let message = format!("invalid-option: reach has to be finite and at least 0, not {reach}");
            return Err(Failure::new(DC_BAD_OPTION, message));
        }
        let found = boxes_around(around, reach, most);
        let numbers = found.as_flattened().as_flattened();
        let boxes = roomy("boxes", boxes, most.saturating_mul(6), numbers.len())?;
        let count = roomy("box_count", box_count, 1, 1)?;
        disjoint([border::read("positions", positions, 3 * point_count), boxes.span(), count.span()])?;
        unsafe {
            boxes.write(numbers.iter().copied());
            count.write([found.len()]);
        }
        Ok(())
    })
}

/// Makes a part of a master surface where no rank holds the whole, in the first positions. `facets` are those that the rank owns and
/// those around them, as in dc_create; each facet of the whole surface is owned by one rank. `node_names` and `facet_names` are their
/// numbers in the whole surface. `owned` is 1 for the own facets and 0 for the others. `known`, lowest and highest x, y, z, is a box:
/// every facet that meets it is here. `extents` are those of the whole surface, see dc_extents: finite, and around the own facets, else
/// DC_BAD_OPTION with the message "invalid-extents", if there are facets. `planes` as in dc_set_symmetry. Of `options` weight, basis and
/// feature angle count.
///
/// Then ranks exchange dc_part_demands and call dc_part_settle, twice, and cut windows with dc_part_window. DC_BAD_OPTION with the
/// message "part-too-narrow" asks for more facets around the own ones and a larger box. On failure the handle is NULL.
///
/// # Safety
/// The arrays have the given lengths, `known` has 6 entries, `extents` 7, `planes` 6 `plane_count`; `part` may be written.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)]
pub unsafe extern "C" fn dc_part_create(
    positions: *const f64,
    node_names: *const i64,
    node_count: usize,
    facets: *const i32,
    facet_names: *const i64,
    owned: *const i32,
    facet_count: usize,
    known: *const f64,
    extents: *const f64,
    planes: *const f64,
    plane_count: usize,
    options: *const dc_options,
    part: *mut *mut dc_part,
) -> dc_status {
    border::call(|| {
        let make = || {
            let (positions, rows, owned, options, planes) = unsafe {
                (
                    points(positions, node_count)?,
                    facet_rows("facets", facets, facet_count)?,
                    input("owned", owned, facet_count)?,
                    dc_options::read(options)?,
                    symmetry_planes(planes, plane_count)?,
                )
            };
            let (node_numbers, facet_numbers) = unsafe {
                (
                    names_of("node_names", node_names, node_count)?,
                    names_of("facet_names", facet_names, facet_count)?,
                )
            };
            let ([x, y, z, u, v, w], [a, b, c, d, e, f, facet]) =
                unsafe { (of_length::<6>("known", known)?, of_length::<EXTENTS>("extents", extents)?) };
            check_nodes(positions.len())?;
            let (facets, options) = (facets_of(rows)?, options.interface()?);
            let owned = owned.iter().map(|&is| flag("owned", is));
            let owned = owned.collect::<Result<Vec<bool>, Failure>>()?;
            let facets = PartFacets {
                positions,
                node_numbers: &node_numbers,
                facets: &facets,
                facet_numbers: &facet_numbers,
                owned: &owned,
                known: [[x, y, z], [u, v, w]],
                extents: Extents { low: [a, b, c], high: [d, e, f], facet },
            };
            PARTS.insert(threads::run(|| SurfacePart::new(&facets, &options, &planes))?)
        };
        unsafe { border::hand_out("part", part, make) }
    })
}

/// Destroys a part. NULL is DC_OK. Windows cut from it stay.
#[unsafe(no_mangle)]
pub extern "C" fn dc_part_destroy(part: *mut dc_part) -> dc_status {
    PARTS.destroy(part)
}

/// What other ranks have to know in this round, those whose known boxes meet that of this part, as plain numbers. The counts get how
/// many there are; each may be NULL. So may both arrays be.
///
/// # Safety
/// Each array is NULL or has room for as many entries as said; each count is NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_part_demands(
    part: *mut dc_part,
    integers: *mut i64,
    integer_capacity: usize,
    integer_count: *mut usize,
    reals: *mut f64,
    real_capacity: usize,
    real_count: *mut usize,
) -> dc_status {
    PARTS.call(part, |part| {
        let (whole, real) = part.demands().to_numbers();
        let integers = wanted("integers", integers, integer_capacity, whole.len())?;
        let reals = wanted("reals", reals, real_capacity, real.len())?;
        let integer_count = wanted("integer_count", integer_count, 1, 1)?;
        let real_count = wanted("real_count", real_count, 1, 1)?;
        disjoint([integers.span(), reals.span(), integer_count.span(), real_count.span()])?;
        unsafe {
            integer_count.write([whole.len()]);
            real_count.write([real.len()]);
            integers.write(whole);
            reals.write(real);
        }
        Ok(())
    })
}

/// Takes over what other ranks ask for: the numbers of dc_part_demands of all of them, one after another. `is_settled` gets 1 when
/// windows can be cut, and 0 when there is another round; all ranks take the same number. DC_BAD_OPTION with the message
/// "part-too-narrow" as in dc_part_create. Nothing has changed then.
///
/// # Safety
/// The arrays have the given lengths, `is_settled` may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_part_settle(
    part: *mut dc_part,
    integers: *const i64,
    integer_count: usize,
    reals: *const f64,
    real_count: usize,
    is_settled: *mut i32,
) -> dc_status {
    PARTS.call(part, |part| {
        let (integers, reals) =
            unsafe { (input("integers", integers, integer_count)?, input("reals", reals, real_count)?) };
        let target = roomy("is_settled", is_settled, 1, 1)?;
        disjoint([
            border::read("integers", integers.as_ptr(), integers.len()),
            border::read("reals", reals.as_ptr(), reals.len()),
            target.span(),
        ])?;
        let others = PartDemands::from_numbers(integers, reals)?;
        let settled = threads::run(|| part.settle(&others))?;
        unsafe { target.write([i32::from(settled)]) };
        Ok(())
    })
}

/// As dc_window_create, of the own facets. `positions` are those of the moment, of the nodes of dc_part_create in their order; only the
/// corners of own facets are looked at. DC_BAD_OPTION before dc_part_settle has said that domains are settled.
///
/// # Safety
/// `positions` has 3 `node_count` entries, `boxes` 6 `box_count`; `window` may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_part_window(
    part: *mut dc_part,
    positions: *const f64,
    node_count: usize,
    boxes: *const f64,
    box_count: usize,
    skin: f64,
    window: *mut *mut dc_window,
) -> dc_status {
    border::call(|| {
        let make = || {
            let (positions, boxes): (_, Vec<Box3>) =
                unsafe { (points(positions, node_count)?, boxes_of(boxes, box_count)?) };
            let cut = |part: &mut SurfacePart| Ok(threads::run(|| part.window(positions, &boxes, skin))?);
            WINDOWS.insert(PARTS.with(part.addr(), cut)?)
        };
        unsafe { border::hand_out("window", window, make) }
    })
}

/// Makes one window of those of the same boxes from several ranks. DC_BAD_OPTION for those of different surfaces, options, boxes or
/// skins, and for none. The windows stay. On failure the handle is NULL.
///
/// # Safety
/// `windows` has `window_count` entries, `joined` may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_window_joined(
    windows: *const *mut dc_window,
    window_count: usize,
    joined: *mut *mut dc_window,
) -> dc_status {
    border::call(|| {
        let make = || {
            let handles = unsafe { input("windows", windows, window_count)? };
            let mut all: Vec<Window> = reserve("windows", window_count)?;
            for handle in handles {
                all.push(WINDOWS.with(handle.addr(), |window| Ok(window.clone()))?);
            }
            WINDOWS.insert(threads::run(|| Window::joined(&all))?)
        };
        // Writing to a handle that is still to be read would lose its window.
        disjoint([border::read("windows", windows, window_count), border::written("joined", joined, 1)])?;
        unsafe { border::hand_out("joined", joined, make) }
    })
}

/// First positions of the nodes of a window, x, y, z each, in the order of dc_window_names.
///
/// # Safety
/// `positions` has 3 `node_count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_window_first_positions(
    window: *mut dc_window,
    positions: *mut f64,
    node_count: usize,
) -> dc_status {
    WINDOWS.call(window, |window| {
        let (expected, found) = (window.nodes().len(), node_count);
        if found != expected {
            let message = format!("bad-size: positions of {found} nodes, but the window has {expected}");
            return Err(Failure::new(DC_BAD_SIZE, message));
        }
        let positions = roomy("positions", positions, 3 * expected, 3 * expected)?;
        unsafe { positions.write(window.first_positions().flatten()) };
        Ok(())
    })
}

/// How many numbers of a history each slave has, so that histories go with slaves to another rank: one after another they are a history
/// again. One of dc_faces_history has two parts for each slave. `part_count` gets the number of parts; `lengths` is NULL to ask for it.
///
/// # Safety
/// `history` has `count` entries; `lengths` is NULL or has `capacity`; `part_count` may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_history_lengths(
    history: *const f64,
    count: usize,
    lengths: *mut usize,
    capacity: usize,
    part_count: *mut usize,
) -> dc_status {
    border::call(|| {
        let numbers = unsafe { input("history", history, count)? };
        let parts = split_history(numbers)?;
        let target = roomy("part_count", part_count, 1, 1)?;
        let lengths = wanted("lengths", lengths, capacity, parts.len())?;
        disjoint([border::read("history", history, count), lengths.span(), target.span()])?;
        unsafe {
            lengths.write(parts.iter().map(|part| part.len()));
            target.write([parts.len()]);
        }
        Ok(())
    })
}
