//! The tangent in a matrix that the caller has.

use std::sync::Arc;

use runtime::assembly::{CsrIndex, CsrMap};

use crate::border::{self, Plain, disjoint, input, sums, target, wanted};
use crate::interface::{call, dc_interface, with};
use crate::law::{self, dc_law};
use crate::pattern::OfEquations;
use crate::registry::Registry;
use crate::status::{Failure, dc_status};
use crate::threads;

/// Where the tangent's entries go in the values of a matrix that the caller has, for a pairing. One thread at a time may use it, any thread.
pub struct dc_map;

static MAPS: Registry<OfEquations<CsrMap>> = Registry::new("map", 6);

/// Finds the places of the tangent's entries in a matrix in compressed sparse rows of the caller's, which has one row and column for each
/// equation. Entries of row i are `row_offsets[i]` to `row_offsets[i + 1]` - 1, counted from 0; columns ascend in a row. It may have any
/// entries besides those of dc_pattern_create, all of which have to be there: else DC_BAD_OPTION, and the message names row and column. The
/// arrays are not kept. It stays valid as long as a pattern would. It needs an evaluation, in any mode.
///
/// On failure the handle is NULL.
///
/// # Safety
/// There are `row_offset_count` offsets, equation_count + 1 of them, and `entry_count` columns; `map` may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_map_create(
    interface: *mut dc_interface,
    row_offsets: *const i32,
    row_offset_count: usize,
    columns: *const i32,
    entry_count: usize,
    map: *mut *mut dc_map,
) -> dc_status {
    border::call(|| unsafe {
        create(interface, (row_offsets, row_offset_count), (columns, entry_count), map)
    })
}

/// As dc_map_create, of a matrix with 64-bit indices.
///
/// # Safety
/// As dc_map_create.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_map_create_64(
    interface: *mut dc_interface,
    row_offsets: *const i64,
    row_offset_count: usize,
    columns: *const i64,
    entry_count: usize,
    map: *mut *mut dc_map,
) -> dc_status {
    border::call(|| unsafe {
        create(interface, (row_offsets, row_offset_count), (columns, entry_count), map)
    })
}

/// # Safety
/// As [`dc_map_create`].
unsafe fn create<I: Plain + CsrIndex>(
    interface: *mut dc_interface,
    (row_offsets, row_offset_count): (*const I, usize),
    (columns, entry_count): (*const I, usize),
    map: *mut *mut dc_map,
) -> Result<(), Failure> {
    disjoint([
        border::read("row_offsets", row_offsets, row_offset_count),
        border::read("columns", columns, entry_count),
        target("map", map, 1)?.span(),
    ])?;
    let make = || {
        with(interface, |state| {
            let contacts = state.contacts()?;
            let (row_offsets, columns) = unsafe {
                (
                    input("row_offsets", row_offsets, row_offset_count)?,
                    input("columns", columns, entry_count)?,
                )
            };
            let places = threads::run(|| CsrMap::within(contacts, &state.dofs, row_offsets, columns))?;
            MAPS.insert(OfEquations { places, dofs: Arc::clone(&state.dofs), what: "map" })
        })
    };
    unsafe { border::hand_out("map", map, make) }
}

/// Destroys a map. NULL is DC_OK. The interface may be gone already.
#[unsafe(no_mangle)]
pub extern "C" fn dc_map_destroy(map: *mut dc_map) -> dc_status {
    MAPS.destroy(map)
}

/// Adds the tangent K = -dR/dx to the `values` of a matrix of that structure, in parallel, as dc_pattern_fill does.
///
/// DC_PATTERN_MISMATCH if the pairing or the equations are not those of the map. DC_OVERFLOW if a sum is not finite: the values then hold
/// anything. With any other failure, but one of memory, they are as they were.
///
/// # Safety
/// `values` has `entry_count` entries; `law` as in dc_add_forces; `active_count` is NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_map_add(
    map: *mut dc_map,
    interface: *mut dc_interface,
    law: *const dc_law,
    values: *mut f64,
    entry_count: usize,
    active_count: *mut usize,
) -> dc_status {
    call(interface, |state| {
        state.contacts()?;
        MAPS.with(map.addr(), |map| {
            map.check_equations(&state.dofs)?;
            let active_count = wanted("active_count", active_count, 1, 1)?;
            let whole = border::written("values", values, entry_count);
            unsafe { law::disjoint(law, [whole, active_count.span()])? };
            // SAFETY: as the caller promises; nothing overlaps.
            let (law, values) = unsafe { (law::read(law)?, sums("values", values, entry_count)?) };
            let law = law.contact()?;
            let active = threads::run(|| map.places.add_from(&state.interface, &law, values))?;
            unsafe { active_count.write([active]) };
            Ok(())
        })
    })
}
