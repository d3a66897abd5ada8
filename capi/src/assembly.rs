//! Residual and triplets of an interface.

use runtime::assembly::{Triplets, add_forces};

use crate::border::{self, Target, disjoint, sums, target, wanted};
use crate::choice;
use crate::interface::{call, dc_interface};
use crate::law::{self, dc_law};
use crate::status::{DC_TOO_LARGE, Failure, dc_status};
use crate::threads;

/// A number of C.
pub fn index(what: &'static str, value: usize) -> Result<i32, Failure> {
    i32::try_from(value).map_err(|_| {
        let message = format!("too-large: {value} {what} are more than 32-bit indices can name");
        Failure::new(DC_TOO_LARGE, message)
    })
}

/// Adds the contact forces R on the nodes to `forces`, one entry per equation. R is the force: it stands on the side of the
/// external loads; the internal force of contact is -R. `active_count`, the number of slaves that carry force, may be NULL.
///
/// DC_OVERFLOW if a sum is not finite: the forces then hold anything, and have to be made anew. With any other failure it is as it
/// was.
///
/// # Safety
/// `forces` has `equation_count` entries; `law` is a dc_law with its `size` set, its multipliers have their number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_add_forces(
    interface: *mut dc_interface,
    law: *const dc_law,
    forces: *mut f64,
    equation_count: usize,
    active_count: *mut usize,
) -> dc_status {
    call(interface, |state| {
        let contacts = state.contacts()?;
        let active_count = wanted("active_count", active_count, 1, 1)?;
        let whole = border::written("forces", forces, equation_count);
        unsafe { law::disjoint(law, [whole, active_count.span()])? };
        // SAFETY: as the caller promises; nothing overlaps.
        let (law, forces) = unsafe { (law::read(law)?, sums("forces", forces, equation_count)?) };
        let law = law.contact()?;
        let active = threads::run(|| add_forces(contacts, &law, &state.dofs, forces))?;
        unsafe { active_count.write([active]) };
        Ok(())
    })
}

/// The tangent K = -dR/dx as triplets, counted from 0, in the order of the slaves; entries of the same place are to be summed.
/// `triangle` is a dc_triangle. Writes their number to `count`. If the arrays are shorter, or NULL, that is all it does: call it with
/// `capacity` 0 first, or with room for the sum of 9 (n + 1)^2 over all slaves.
///
/// DC_BAD_SIZE if there is not room for all, and `capacity` is not 0; `count` is there even so.
///
/// # Safety
/// The arrays have `capacity` entries each; `law` as in dc_add_forces; `count` may be written.
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
    call(interface, |state| {
        let triangle = choice::read(triangle)?;
        state.contacts()?;
        let count = target("count", count, 1)?;
        let law = unsafe { law::read(law)? };
        let law = law.contact()?;
        let triplets = &mut state.triplets;
        let (contacts, dofs) = (state.interface.contacts(), &*state.dofs);
        let filling = &mut *triplets;
        threads::run(|| filling.fill(contacts, &law, dofs, triangle))?;
        index("equations", state.dofs.equations())?;
        // SAFETY: as the caller promises; the law's multipliers are not looked at any more.
        unsafe { write(triplets, (rows, columns, values), capacity, count) }
    })
}

/// Writes triplets and their number; nothing but the number without capacity.
///
/// # Safety
/// The arrays have `capacity` entries.
pub unsafe fn write(
    triplets: &Triplets,
    (rows, columns, values): (*mut i32, *mut i32, *mut f64),
    capacity: usize,
    count: Target<usize>,
) -> Result<(), Failure> {
    let length = triplets.len();
    disjoint([
        border::written("rows", rows, capacity),
        border::written("columns", columns, capacity),
        border::written("values", values, capacity),
        count.span(),
    ])?;
    unsafe { count.write([length]) };
    if capacity == 0 {
        return Ok(());
    }
    let rows = wanted("rows", rows, capacity, length)?;
    let columns = wanted("columns", columns, capacity, length)?;
    let values = wanted("values", values, capacity, length)?;
    unsafe {
        rows.write(triplets.rows().iter().map(|&row| row as i32));
        columns.write(triplets.columns().iter().map(|&column| column as i32));
        values.write(triplets.values().iter().copied());
    }
    Ok(())
}
