//! Friction of contact over faces, and its history.

use crate::border::{disjoint, input, wanted};
use crate::choice::Named;
use crate::faces::{call, dc_faces};
use crate::friction::{Accepted, moves_of, write_history, write_slip_errors};
use crate::law::{self, dc_law};
use crate::status::dc_status;
use crate::threads;

/// Friction of all slave nodes, of the last evaluation, one entry each: `states` dc_friction_state; `tractions` on the slave, force per area,
/// 3 numbers each; `slips` as of dc_friction, length. Each may be NULL.
///
/// # Safety
/// The arrays have `slave_count` entries, `tractions` three times as many.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_friction(
    faces: *mut dc_faces,
    states: *mut i32,
    tractions: *mut f64,
    slips: *mut f64,
    slave_count: usize,
) -> dc_status {
    call(faces, |state| {
        state.expect_slaves(slave_count)?;
        let nodes = state.contacts()?.nodes();
        let states = wanted("states", states, slave_count, slave_count)?;
        let three = slave_count.saturating_mul(3);
        let tractions = wanted("tractions", tractions, three, three)?;
        let slips = wanted("slips", slips, slave_count, slave_count)?;
        disjoint([states.span(), tractions.span(), slips.span()])?;
        unsafe {
            states.write(nodes.iter().map(|node| node.friction_state.number()));
            tractions.write(nodes.iter().flat_map(|node| node.friction));
            slips.write(nodes.iter().map(|node| node.slip));
        }
        Ok(())
    })
}

/// As dc_accept, of the positions of the last dc_faces_refresh or dc_faces_update: call it once before the first increment, after
/// dc_faces_refresh, and then after each that has converged. `unanchored_count` gets the number of nodes that carry pressure without
/// friction, as nothing lay over them at the end of the increment before, `dropped_count` that of nodes that carried pressure then and have
/// nothing over them now. Every build of the library has it.
///
/// # Safety
/// `law` as in dc_faces_evaluate; the others are NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_accept(
    faces: *mut dc_faces,
    law: *const dc_law,
    stuck_count: *mut usize,
    sliding_count: *mut usize,
    unanchored_count: *mut usize,
    dropped_count: *mut usize,
    dissipated: *mut f64,
) -> dc_status {
    call(faces, |state| {
        let slave_count = state.interface.slaves().len();
        let contacts = &mut state.interface;
        let accepted = Accepted { stuck_count, sliding_count, unanchored_count, dropped_count, dissipated };
        unsafe { accepted.write(law, slave_count, |law| contacts.accept(law))? };
        state.evaluated &= !state.interface.has_history();
        Ok(())
    })
}

/// As dc_augment, of the nodes of the slave's faces; then dc_faces_evaluate again.
///
/// # Safety
/// As dc_augment.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_augment(
    faces: *mut dc_faces,
    law: *const dc_law,
    moves: *const i32,
    slave_count: usize,
) -> dc_status {
    call(faces, |state| {
        state.expect_slaves(slave_count)?;
        let (law, moves) = unsafe { (law::read(law)?, moves_of(moves, slave_count)?) };
        let law = law.contact()?;
        let contacts = &mut state.interface;
        threads::run(|| contacts.augment(&law, moves))?;
        state.evaluated &= law.friction.is_none();
        Ok(())
    })
}

/// As dc_slip_errors, at the positions of the last dc_faces_update or dc_faces_refresh.
///
/// # Safety
/// As dc_slip_errors.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_slip_errors(
    faces: *mut dc_faces,
    law: *const dc_law,
    errors: *mut f64,
    slave_count: usize,
) -> dc_status {
    call(faces, |state| {
        state.expect_slaves(slave_count)?;
        unsafe { write_slip_errors(law, errors, slave_count, |law| state.interface.slip_errors(law)) }
    })
}

/// As dc_roll_back; if there was anything to forget there is no contact until the next dc_faces_refresh.
#[unsafe(no_mangle)]
pub extern "C" fn dc_faces_roll_back(faces: *mut dc_faces) -> dc_status {
    call(faces, |state| {
        state.interface.roll_back();
        state.evaluated = false;
        Ok(())
    })
}

/// As dc_history.
///
/// # Safety
/// `history` is NULL or has `capacity` entries; `count` may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_history(
    faces: *mut dc_faces,
    history: *mut f64,
    capacity: usize,
    count: *mut usize,
) -> dc_status {
    call(faces, |state| unsafe { write_history(state.interface.history(), history, capacity, count) })
}

/// As dc_augmented_history.
///
/// # Safety
/// `history` is NULL or has `capacity` entries; `count` may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_augmented_history(
    faces: *mut dc_faces,
    history: *mut f64,
    capacity: usize,
    count: *mut usize,
) -> dc_status {
    call(faces, |state| unsafe {
        write_history(state.interface.augmented_history(), history, capacity, count)
    })
}

/// Goes on from numbers that dc_faces_history gave, bit for bit; NULL and 0 for none. If they are others than the present ones there is no
/// contact until the next dc_faces_refresh.
///
/// # Safety
/// `history` has `count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_set_history(
    faces: *mut dc_faces,
    history: *const f64,
    count: usize,
) -> dc_status {
    call(faces, |state| {
        let numbers = unsafe { input("history", history, count)? };
        state.interface.set_history(numbers)?;
        state.evaluated = false;
        Ok(())
    })
}
