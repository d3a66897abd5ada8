//! The tangent in compressed sparse rows.

use std::sync::Arc;

use runtime::assembly::{CsrPattern, DofMap};

use crate::assembly::index;
use crate::border::{self, disjoint, roomy, target, wanted};
use crate::interface::{call, dc_interface, with};
use crate::law::{self, dc_law};
use crate::registry::Registry;
use crate::status::{DC_BAD_SIZE, DC_PATTERN_MISMATCH, Failure, dc_status};
use crate::threads;

/// The places of the tangent's entries, for a pairing. One thread at a time may use it, any thread.
pub struct dc_pattern;

/// Places of entries, and the equations that they are of.
#[derive(Debug)]
pub struct OfEquations<T> {
    pub places: T,
    pub dofs: Arc<DofMap>,
    /// "pattern" or "map".
    pub what: &'static str,
}

static PATTERNS: Registry<OfEquations<CsrPattern>> = Registry::new("pattern", 2);

impl<T> OfEquations<T> {
    /// Refuses equations that are not those of the places: the entries would land elsewhere.
    pub fn check_equations(&self, dofs: &Arc<DofMap>) -> Result<(), Failure> {
        if Arc::ptr_eq(&self.dofs, dofs) {
            return Ok(());
        }
        let what = self.what;
        let [own, others] = [self.dofs.equations(), dofs.equations()];
        let differs =
            |&node: &usize| (0..3).any(|axis| self.dofs.equation(node, axis) != dofs.equation(node, axis));
        let message = if own != others {
            format!("pattern-mismatch: the {what} is of {own} equations, the interface has {others}")
        } else if self.dofs.nodes() != dofs.nodes() {
            let [own, others] = [self.dofs.nodes(), dofs.nodes()];
            format!("pattern-mismatch: the {what} is of {own} nodes, the interface has {others}")
        } else if let Some(node) = (0..dofs.nodes()).find(differs) {
            format!("pattern-mismatch: node {node} has had other equations when the {what} was made")
        } else {
            return Ok(());
        };
        Err(Failure::new(DC_PATTERN_MISMATCH, message))
    }
}

/// Makes the union pattern of the pairing: an entry wherever any slave can have one, whether it carries force or not. So it
/// stays valid until a dc_refresh (dc_report: changed, gained or lost is not 0) or a dc_follow (its last argument) changes the lists of nodes, or dc_set_equations the equations, and
/// a solver can keep its symbolic factorisation as long. Both triangles are there; columns ascend in a row. It needs an evaluation, in any mode.
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
        let entry_count = wanted("entry_count", entry_count, 1, 1)?;
        disjoint([target("pattern", pattern, 1)?.span(), entry_count.span()])?;
        let make = || {
            with(interface, |state| {
                let contacts = state.contacts()?;
                let places = threads::run(|| CsrPattern::union(contacts, &state.dofs))?;
                index("equations", places.equations())?;
                let entries = index("entries", places.entries())? as usize;
                let made = OfEquations { places, dofs: Arc::clone(&state.dofs), what: "pattern" };
                let made = PATTERNS.insert(made)?;
                unsafe { entry_count.write([entries]) };
                Ok(made)
            })
        };
        unsafe { border::hand_out("pattern", pattern, make) }
    })
}

/// Destroys a pattern. NULL is DC_OK. The interface may be gone already.
#[unsafe(no_mangle)]
pub extern "C" fn dc_pattern_destroy(pattern: *mut dc_pattern) -> dc_status {
    PATTERNS.destroy(pattern)
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
    PATTERNS.call(pattern, |pattern| {
        let (offsets, entries) = (pattern.places.row_offsets(), pattern.places.columns());
        let row_offsets = wanted("row_offsets", row_offsets, row_offset_count, offsets.len())?;
        let columns = wanted("columns", columns, column_count, entries.len())?;
        disjoint([row_offsets.span(), columns.span()])?;
        unsafe {
            row_offsets.write(offsets.iter().map(|&offset| offset as i32));
            columns.write(entries.iter().map(|&column| column as i32));
        }
        Ok(())
    })
}

/// Writes the tangent K = -dR/dx into `values`, one number for each entry of the pattern, zeros where nothing touches. In
/// parallel; the result does not depend on the number of threads. `active_count` may be NULL.
///
/// After dc_evaluate with DC_GRADIENT M of the slaves that carry force is evaluated some hundred at a time, added and forgotten: the values are
/// those after DC_HESSIAN, bit for bit, and the memory for all M is saved.
///
/// DC_PATTERN_MISMATCH if the pairing or the equations are not those of the pattern. DC_OVERFLOW if a sum is not finite. After
/// a failure the values hold anything.
///
/// # Safety
/// `values` has `entry_count` entries; `law` as in dc_add_forces; `active_count` is NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_pattern_fill(
    pattern: *mut dc_pattern,
    interface: *mut dc_interface,
    law: *const dc_law,
    values: *mut f64,
    entry_count: usize,
    active_count: *mut usize,
) -> dc_status {
    call(interface, |state| {
        state.contacts()?;
        PATTERNS.with(pattern.addr(), |pattern| {
            pattern.check_equations(&state.dofs)?;
            let active_count = wanted("active_count", active_count, 1, 1)?;
            let entries = pattern.places.entries();
            if entry_count != entries {
                let message = format!("bad-size: values has {entry_count} entries, the pattern {entries}");
                return Err(Failure::new(DC_BAD_SIZE, message));
            }
            let values = roomy("values", values, entry_count, entries)?;
            unsafe { law::disjoint(law, [values.span(), active_count.span()])? };
            // SAFETY: as the caller promises; nothing overlaps.
            let law = unsafe { law::read(law)? };
            let law = law.contact()?;
            // SAFETY: as the caller promises; nothing overlaps.
            let values = unsafe { values.unspecified() };
            let map = pattern.places.map();
            let active = threads::run(|| map.fill_from(&state.interface, &law, values))?;
            unsafe { active_count.write([active]) };
            Ok(())
        })
    })
}
