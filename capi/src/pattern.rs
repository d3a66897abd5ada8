//! The tangent in compressed sparse rows.

use runtime::assembly::CsrPattern;

use crate::assembly::index;
use crate::border::{self, output, single, wanted};
use crate::interface::{dc_interface, with};
use crate::law::{self, dc_law};
use crate::registry::Registry;
use crate::status::dc_status;

/// The places of the tangent's entries, for a pairing. One thread at a time may use it, any thread.
pub struct dc_pattern;

static PATTERNS: Registry<CsrPattern> = Registry::new("pattern", 2);

/// Makes the union pattern of the pairing: an entry wherever any slave can have one, whether it carries force or not. So it
/// stays valid until a refresh changes the pairing (dc_report: changed, gained or lost is not 0), and a solver can keep its
/// symbolic factorisation as long. Both triangles are there; columns ascend in a row. It needs an evaluation, in any mode.
///
/// Writes the handle and the number of entries, which may be NULL. On failure the handle is NULL.
///
/// # Safety
/// `pattern` may be written, `entry_count` is NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_pattern_create(
    interface: *mut dc_interface,
    pattern: *mut *mut dc_pattern,
    entry_count: *mut usize,
) -> dc_status {
    border::call(|| {
        // SAFETY: as the caller promises.
        let handle = unsafe { single("pattern", pattern)? };
        *handle = std::ptr::null_mut();
        with(interface, |state| {
            let made = CsrPattern::union(state.contacts()?, &state.dofs)?;
            index("equations", made.equations())?;
            let entries = index("entries", made.entries())? as usize;
            if !entry_count.is_null() {
                // SAFETY: as the caller promises.
                *unsafe { single("entry_count", entry_count)? } = entries;
            }
            *handle = std::ptr::without_provenance_mut(PATTERNS.insert(made)?);
            Ok(())
        })
    })
}

/// Destroys a pattern. NULL is DC_OK. The interface may be gone already.
#[unsafe(no_mangle)]
pub extern "C" fn dc_pattern_destroy(pattern: *mut dc_pattern) -> dc_status {
    border::call(|| if pattern.is_null() { Ok(()) } else { PATTERNS.remove(pattern.addr()) })
}

/// Copies out where the entries are, counted from 0: those of row i are `row_offsets[i]` to `row_offsets[i + 1]` - 1, in
/// `columns`. There are equation_count + 1 offsets and entry_count columns. Either may be NULL.
///
/// # Safety
/// The arrays have the given lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_pattern_structure(
    pattern: *mut dc_pattern,
    row_offsets: *mut i32,
    row_offset_count: usize,
    columns: *mut i32,
    column_count: usize,
) -> dc_status {
    border::call(|| {
        PATTERNS.with(pattern.addr(), |pattern| {
            let (offsets, entries) = (pattern.row_offsets(), pattern.columns());
            // SAFETY: as the caller promises.
            let (row_offsets, columns) = unsafe {
                (
                    wanted("row_offsets", row_offsets, row_offset_count, offsets.len())?,
                    wanted("columns", columns, column_count, entries.len())?,
                )
            };
            for (target, source) in [(row_offsets, offsets), (columns, entries)] {
                let numbers = target.into_iter().flatten().zip(source);
                numbers.for_each(|(target, &source)| *target = source as i32);
            }
            Ok(())
        })
    })
}

/// Writes the tangent K = -dR/dx into `values`, one number for each entry of the pattern, zeros where nothing touches. In
/// parallel; the result does not depend on the number of threads. `active_count` may be NULL.
///
/// DC_PATTERN_MISMATCH if the pairing is not the one of the pattern. DC_OVERFLOW if a sum is not finite: the values then hold
/// anything.
///
/// # Safety
/// `values` has `entry_count` entries; `law` as in dc_residual; `active_count` is NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_pattern_fill(
    pattern: *mut dc_pattern,
    interface: *mut dc_interface,
    law: *const dc_law,
    values: *mut f64,
    entry_count: usize,
    active_count: *mut usize,
) -> dc_status {
    border::call(|| {
        with(interface, |state| {
            let contacts = state.contacts()?;
            PATTERNS.with(pattern.addr(), |pattern| {
                // SAFETY: as the caller promises.
                let (law, values) = unsafe { (law::read(law)?, output("values", values, entry_count)?) };
                let active = pattern.fill(contacts, &law, values)?;
                if !active_count.is_null() {
                    // SAFETY: as the caller promises.
                    *unsafe { single("active_count", active_count)? } = active;
                }
                Ok(())
            })
        })
    })
}
