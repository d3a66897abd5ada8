//! Residual and triplets of an interface.

use runtime::assembly::add_residual;

use crate::border::{self, output, single, wanted};
use crate::choice;
use crate::interface::{dc_interface, with};
use crate::law::{self, dc_law};
use crate::status::{DC_TOO_LARGE, Failure, dc_status};

/// A number of C.
pub fn index(what: &'static str, value: usize) -> Result<i32, Failure> {
    i32::try_from(value).map_err(|_| {
        let message = format!("too-large: {value} {what} are more than 32-bit indices can name");
        Failure::new(DC_TOO_LARGE, message)
    })
}

/// Adds the contact forces R on the nodes to `residual`, one entry per equation. R is the force: it stands on the side of the
/// external loads; the internal force of contact is -R. `active_count`, the number of slaves that carry force, may be NULL.
///
/// DC_OVERFLOW if a sum is not finite: the residual then holds anything, and has to be made anew.
///
/// # Safety
/// `residual` has `equation_count` entries; `law` is a dc_law with its `size` set, its multipliers have their number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_residual(
    interface: *mut dc_interface,
    law: *const dc_law,
    residual: *mut f64,
    equation_count: usize,
    active_count: *mut usize,
) -> dc_status {
    border::call(|| {
        with(interface, |state| {
            let contacts = state.contacts()?;
            // SAFETY: as the caller promises.
            let (law, residual) = unsafe { (law::read(law)?, output("residual", residual, equation_count)?) };
            let active = add_residual(contacts, &law, &state.dofs, residual)?;
            if !active_count.is_null() {
                // SAFETY: as the caller promises.
                *unsafe { single("active_count", active_count)? } = active;
            }
            Ok(())
        })
    })
}

/// The tangent K = -dR/dx as triplets, counted from 0, in the order of the slaves; entries of the same place are to be summed.
/// `triangle` is a dc_triangle. Writes their number to `count`. If the arrays are shorter, or NULL, that is all it does: call it with
/// `capacity` 0 first, or with room for the sum of 9 (n + 1)^2 over all slaves.
///
/// DC_BAD_SIZE if there is not room for all, and `capacity` is not 0.
///
/// # Safety
/// The arrays have `capacity` entries each; `law` as in dc_residual; `count` may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_triplets(
    interface: *mut dc_interface,
    law: *const dc_law,
    triangle: i32,
    rows: *mut i32,
    columns: *mut i32,
    values: *mut f64,
    capacity: usize,
    count: *mut usize,
) -> dc_status {
    border::call(|| {
        with(interface, |state| {
            let triangle = choice::triangle(triangle)?;
            state.contacts()?;
            // SAFETY: as the caller promises.
            let (law, count) = unsafe { (law::read(law)?, single("count", count)?) };
            let triplets = &mut state.triplets;
            triplets.fill(state.interface.contacts(), &law, &state.dofs, triangle)?;
            index("equations", state.dofs.equations())?;
            let length = triplets.len();
            *count = length;
            if capacity == 0 {
                return Ok(());
            }
            // SAFETY: as the caller promises.
            let (rows, columns, values) = unsafe {
                (
                    wanted("rows", rows, capacity, length)?,
                    wanted("columns", columns, capacity, length)?,
                    wanted("values", values, capacity, length)?,
                )
            };
            for (target, source) in [(rows, triplets.rows()), (columns, triplets.columns())] {
                let entries = target.into_iter().flatten().zip(source);
                entries.for_each(|(target, &source)| *target = source as i32);
            }
            if let Some(values) = values {
                values.copy_from_slice(triplets.values());
            }
            Ok(())
        })
    })
}
