//! The history of friction, of interfaces and of contact over faces.

use runtime::assembly::{ContactLaw, slave_friction};
use runtime::interface::{FrictionReport, InterfaceError};

use crate::border::{self, disjoint, input, target, wanted};
use crate::choice::{self, Named};
use crate::interface::{call, dc_interface};
use crate::law::{self, dc_law};
use crate::status::{Failure, dc_status};
use crate::threads;

/// What accepting a state writes; each may be NULL.
pub struct Accepted {
    pub stuck_count: *mut usize,
    pub sliding_count: *mut usize,
    pub unanchored_count: *mut usize,
    pub dropped_count: *mut usize,
    pub dissipated: *mut f64,
}

impl Accepted {
    /// Accepts a state of `slave_count` slaves and writes what came of it.
    ///
    /// # Safety
    /// `law` as in [`law::read`]; the others are NULL or may be written.
    pub unsafe fn write(
        self,
        law: *const dc_law,
        slave_count: usize,
        accept: impl FnOnce(&ContactLaw<'_>) -> Result<FrictionReport, InterfaceError> + Send,
    ) -> Result<(), Failure> {
        let stuck_count = wanted("stuck_count", self.stuck_count, 1, 1)?;
        let sliding_count = wanted("sliding_count", self.sliding_count, 1, 1)?;
        let unanchored_count = wanted("unanchored_count", self.unanchored_count, 1, 1)?;
        let dropped_count = wanted("dropped_count", self.dropped_count, 1, 1)?;
        let dissipated = wanted("dissipated", self.dissipated, 1, 1)?;
        let counts = [
            stuck_count.span(),
            sliding_count.span(),
            unanchored_count.span(),
            dropped_count.span(),
            dissipated.span(),
        ];
        unsafe { law::disjoint(law, counts)? };
        // SAFETY: as the caller promises; nothing overlaps.
        let law = unsafe { law::read(law)? };
        let law = law.contact()?;
        law.validate(slave_count)?;
        let report = threads::run(|| accept(&law))?;
        unsafe {
            stuck_count.write([report.stuck]);
            sliding_count.write([report.sliding]);
            unanchored_count.write([report.unanchored]);
            dropped_count.write([report.dropped]);
            dissipated.write([report.dissipated]);
        }
        Ok(())
    }
}

/// Writes how many numbers a history has and, where there is room, the numbers.
///
/// # Safety
/// `history` is NULL or has `capacity` entries; `count` may be written.
pub unsafe fn write_history(
    numbers: Vec<f64>,
    history: *mut f64,
    capacity: usize,
    count: *mut usize,
) -> Result<(), Failure> {
    let count = target("count", count, 1)?;
    disjoint([border::written("history", history, capacity), count.span()])?;
    unsafe { count.write([numbers.len()]) };
    let history = wanted("history", history, capacity, numbers.len())?;
    unsafe { history.write(numbers) };
    Ok(())
}

/// Which slaves a round of augmentation moves: those of 1, or all of them.
///
/// # Safety
/// As [`input`].
pub unsafe fn moves_of<'a>(
    moves: *const i32,
    slave_count: usize,
) -> Result<impl Fn(usize) -> bool + Sync + 'a, Failure> {
    let moves = if moves.is_null() { None } else { Some(unsafe { input("moves", moves, slave_count)? }) };
    for &flag in moves.unwrap_or_default() {
        choice::flag("moves", flag)?;
    }
    Ok(move |slave: usize| moves.is_none_or(|moves: &[i32]| moves[slave] == 1))
}

/// Errors of slips, one for each slave.
///
/// # Safety
/// `law` as in [`law::read`]; `errors` has `slave_count` entries.
pub unsafe fn write_slip_errors(
    law: *const dc_law,
    errors: *mut f64,
    slave_count: usize,
    find: impl FnOnce(&ContactLaw<'_>) -> Result<Vec<f64>, InterfaceError> + Send,
) -> Result<(), Failure> {
    let errors = target("errors", errors, slave_count)?;
    let law = unsafe {
        law::disjoint(law, [errors.span()])?;
        law::read(law)?
    };
    let law = law.contact()?;
    let found = threads::run(|| find(&law))?;
    unsafe { errors.write(found) };
    Ok(())
}

/// A round of Uzawa's iteration for friction: the traction of each slave that carries force becomes its multiplier, so that the next
/// equilibrium slips less where it sticks. Call it in an equilibrium whose dc_slip_errors are too large, with the law that it was solved
/// with, whose `augmented` is 1; then dc_evaluate again. The rounds are part of the increment on its way: dc_accept takes them over,
/// dc_roll_back forgets them.
///
/// `moves`: 1 for each slave that takes part, 0 for others, where other bodies hold them and no multiplier can help; NULL for all.
///
/// Without friction in the law nothing happens. DC_BAD_OPTION for friction without `augmented`, and as of dc_accept.
///
/// # Safety
/// `law` as in dc_add_forces; `moves` is NULL or has `slave_count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_augment(
    interface: *mut dc_interface,
    law: *const dc_law,
    moves: *const i32,
    slave_count: usize,
) -> dc_status {
    call(interface, |state| {
        state.expect_slaves(slave_count)?;
        let (law, moves) = unsafe { (law::read(law)?, moves_of(moves, slave_count)?) };
        let law = law.contact()?;
        let contacts = &mut state.interface;
        threads::run(|| contacts.augment(&law, moves))?;
        if law.friction.is_some() {
            state.evaluated = false;
        }
        Ok(())
    })
}

/// How far each slave is from Coulomb's law without tangential stiffness, length: its slip since it stuck where it sticks, and what of it is
/// not along the traction where it slides; 0 without force, history or friction. At the positions of the last dc_update, dc_follow or dc_refresh.
///
/// # Safety
/// `law` as in dc_augment; `errors` has `slave_count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_slip_errors(
    interface: *mut dc_interface,
    law: *const dc_law,
    errors: *mut f64,
    slave_count: usize,
) -> dc_status {
    call(interface, |state| {
        state.expect_slaves(slave_count)?;
        unsafe { write_slip_errors(law, errors, slave_count, |law| state.interface.slip_errors(law)) }
    })
}

/// Forgets what dc_augment did since the last dc_accept, and ends the evaluation. If that is anything no slave is paired until the next
/// dc_refresh.
#[unsafe(no_mangle)]
pub extern "C" fn dc_roll_back(interface: *mut dc_interface) -> dc_status {
    call(interface, |state| {
        state.interface.roll_back();
        state.evaluated = false;
        Ok(())
    })
}

/// Accepts the positions of the last dc_update, dc_follow or dc_refresh as the end of an increment: friction of the next one is measured
/// from there. Call it once before the first increment, after dc_refresh, and then after each that has converged, with the multipliers it
/// was solved with. Until then nothing of the history changes, so that an increment may be tried again.
/// It ends the evaluation: call dc_evaluate again.
///
/// If the law has no friction all slaves slide freely: where there is a history it goes on from their feet, and all counts are 0. Without a
/// history nothing happens then. A slave whose outcome is DC_BEYOND_WINDOW keeps its history.
///
/// `stuck_count` and `sliding_count` get the numbers of slaves that stick and that slide, `unanchored_count` that of slaves that carry
/// force without friction, as they had no gap at the end of the increment before; `dropped_count` that of slaves that were closed then
/// and have lost their contact element; `dissipated` the work of friction in the increment, energy. Each may be NULL.
///
/// DC_BAD_OPTION for a law with friction if there can be none: for DC_DIFFUSE without DC_DOMAINS, or in a library built without its
/// feature `friction`. DC_NODE_TO_FACET has friction in every build.
///
/// # Safety
/// `law` as in dc_add_forces; the others are NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_accept(
    interface: *mut dc_interface,
    law: *const dc_law,
    stuck_count: *mut usize,
    sliding_count: *mut usize,
    unanchored_count: *mut usize,
    dropped_count: *mut usize,
    dissipated: *mut f64,
) -> dc_status {
    call(interface, |state| {
        let slave_count = state.interface.slaves().len();
        let contacts = &mut state.interface;
        let accepted = Accepted { stuck_count, sliding_count, unanchored_count, dropped_count, dissipated };
        unsafe { accepted.write(law, slave_count, |law| contacts.accept(law))? };
        if state.interface.has_history() {
            state.evaluated = false;
        }
        Ok(())
    })
}

/// Friction of all slaves at the positions of the last dc_evaluate, in DC_GRADIENT or DC_HESSIAN, one entry each: `states`
/// dc_friction_state; `tractions` on the slave, 3 numbers each, force per area, a force where the interface has no areas; `slips` from
/// the anchor, or of a slave that was open from its place of touch, length: the elastic slip, and where it slides what it has slid in the
/// increment besides. With `augmented` they are from where it stuck, without its multiplier. 0 where a slave is DC_OPEN, as all are if the law has no friction. Each may be
/// NULL. Call it before dc_accept, which ends the evaluation, with the law of the forces.
///
/// DC_NOT_EVALUATED for slaves that carry force before the first dc_accept.
///
/// # Safety
/// `law` as in dc_add_forces; the arrays have `slave_count` entries, `tractions` three times as many.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_friction(
    interface: *mut dc_interface,
    law: *const dc_law,
    states: *mut i32,
    tractions: *mut f64,
    slips: *mut f64,
    slave_count: usize,
) -> dc_status {
    call(interface, |state| {
        state.expect_slaves(slave_count)?;
        let contacts = state.contacts()?;
        let states = wanted("states", states, slave_count, slave_count)?;
        let three = slave_count.saturating_mul(3);
        let tractions = wanted("tractions", tractions, three, three)?;
        let slips = wanted("slips", slips, slave_count, slave_count)?;
        let law = unsafe {
            law::disjoint(law, [states.span(), tractions.span(), slips.span()])?;
            law::read(law)?
        };
        let law = law.contact()?;
        let found = threads::run(|| slave_friction(contacts, &law))?;
        unsafe {
            states.write(found.iter().map(|slave| slave.state.number()));
            tractions.write(found.iter().flat_map(|slave| slave.traction));
            slips.write(found.iter().map(|slave| slave.slip));
        }
        Ok(())
    })
}

/// The history of friction as plain numbers, for a restart: `count` gets how many there are, 0 without a history. `history` is NULL to
/// learn that, or has room for `capacity` numbers: DC_BAD_SIZE if that is too little, and `count` is written all the same.
///
/// # Safety
/// `history` is NULL or has `capacity` entries; `count` may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_history(
    interface: *mut dc_interface,
    history: *mut f64,
    capacity: usize,
    count: *mut usize,
) -> dc_status {
    call(interface, |state| unsafe { write_history(state.interface.history(), history, capacity, count) })
}

/// As dc_history, of what friction is measured from at the moment: with the rounds of dc_augment since the last accepted step. Another
/// interface, such as one in a window made anew, goes on from it within the step.
///
/// # Safety
/// `history` is NULL or has `capacity` entries; `count` may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_augmented_history(
    interface: *mut dc_interface,
    history: *mut f64,
    capacity: usize,
    count: *mut usize,
) -> dc_status {
    call(interface, |state| unsafe {
        write_history(state.interface.augmented_history(), history, capacity, count)
    })
}

/// Goes on from numbers that dc_history gave, bit for bit; NULL and 0 for none. If they are others than the present ones no slave is paired
/// until the next dc_refresh; one of a frozen interface does not pair.
///
/// # Safety
/// `history` has `count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_set_history(
    interface: *mut dc_interface,
    history: *const f64,
    count: usize,
) -> dc_status {
    call(interface, |state| {
        let numbers = unsafe { input("history", history, count)? };
        state.interface.set_history(numbers)?;
        state.evaluated = false;
        Ok(())
    })
}
