//! Forces and tangent of contact over faces.

use crate::assembly::{index, write};
use crate::border::{self, disjoint, sums, target, wanted};
use crate::choice;
use crate::faces::{call, dc_faces};
use crate::operator::factors;
use crate::status::dc_status;
use crate::threads;

/// Adds the contact forces R on the nodes to `forces`, one entry per equation, as dc_add_forces does. `active_count`, the number of
/// slave nodes that carry pressure, and `missed_count` may be NULL. Of loaded faces, points are missed that carry no force although
/// they should: those below their facet whose element has no result, those without a place on their own face or the facet, those whose line
/// of force meets no place of the facet, and those whose derivatives overflow.
///
/// DC_OVERFLOW if a sum is not finite: the forces then hold anything, and have to be made anew.
///
/// # Safety
/// `forces` has `equation_count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_add_forces(
    faces: *mut dc_faces,
    forces: *mut f64,
    equation_count: usize,
    active_count: *mut usize,
    missed_count: *mut usize,
) -> dc_status {
    call(faces, |state| {
        let contacts = state.contacts()?;
        let active_count = wanted("active_count", active_count, 1, 1)?;
        let missed_count = wanted("missed_count", missed_count, 1, 1)?;
        let whole = border::written("forces", forces, equation_count);
        disjoint([whole, active_count.span(), missed_count.span()])?;
        // SAFETY: as the caller promises; nothing overlaps.
        let forces = unsafe { sums("forces", forces, equation_count)? };
        let active = threads::run(|| contacts.add_forces(&state.dofs, forces))?;
        unsafe {
            active_count.write([active]);
            missed_count.write([contacts.missed()]);
        }
        Ok(())
    })
}

/// Adds K v to `product`, one entry per equation, without a matrix, with the K of dc_faces_triplets, of friction, too. It differs from the
/// product of the assembled matrix by rounding, and does not depend on the number of threads, bit for bit.
///
/// DC_OVERFLOW if a sum is not finite: the product then holds anything. With any other failure it is as it was.
///
/// # Safety
/// The arrays have `equation_count` entries each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_product(
    faces: *mut dc_faces,
    tangent: i32,
    v: *const f64,
    product: *mut f64,
    equation_count: usize,
) -> dc_status {
    call(faces, |state| {
        let tangent = choice::read(tangent)?;
        let contacts = state.contacts()?;
        let (v, product) = unsafe { factors(v, product, equation_count)? };
        threads::run(|| contacts.add_product(tangent, &state.dofs, v, product))?;
        Ok(())
    })
}

/// The tangent K = -dR/dx as triplets, counted from 0, all of it, for it is not symmetric; entries of the same place are to be summed.
/// Entries that are exactly zero are left out, so that their number may change from one evaluation to the next.
/// `tangent` is a dc_tangent: DC_GAUSS_NEWTON leaves out what the directions of the forces add. Writes their number to `count`. If the
/// arrays are shorter, or NULL, that is all it does: call it with `capacity` 0 first.
///
/// DC_BAD_SIZE if there is not room for all, and `capacity` is not 0; `count` is there even so.
///
/// # Safety
/// The arrays have `capacity` entries each; `count` may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_triplets(
    faces: *mut dc_faces,
    tangent: i32,
    rows: *mut i32,
    columns: *mut i32,
    values: *mut f64,
    capacity: usize,
    count: *mut usize,
) -> dc_status {
    call(faces, |state| {
        let tangent = choice::read(tangent)?;
        let contacts = state.contacts()?;
        let count = target("count", count, 1)?;
        let triplets = threads::run(|| contacts.triplets(tangent, &state.dofs))?;
        index("equations", state.dofs.equations())?;
        unsafe { write(&triplets, (rows, columns, values), capacity, count) }
    })
}

/// Which nodes couple with one another, for the pattern of a host's matrix: cliques, one for each slave node with points around it. The nodes
/// of clique k are `nodes[offsets[k]]` to `nodes[offsets[k + 1] - 1]`, ascending. An entry of the tangent is in the rows and columns of two
/// nodes of one clique, whatever evaluation follows. They hold all that has coupled since the last dc_faces_refresh: where
/// dc_faces_update says `grown` they are more than before, and after a dc_faces_refresh other ones. They need no evaluation.
///
/// `clique_count` gets their number, `entry_count` that of all their nodes; there is an offset more than cliques. Each may be NULL: call it
/// without arrays first. DC_BAD_SIZE if there is not room for all. Before the first dc_faces_refresh there are none.
///
/// # Safety
/// `offsets` has `offset_capacity` entries, `nodes` has `node_capacity`, or they are NULL; the others are NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_cliques(
    faces: *mut dc_faces,
    offsets: *mut i32,
    offset_capacity: usize,
    nodes: *mut i32,
    node_capacity: usize,
    clique_count: *mut usize,
    entry_count: *mut usize,
) -> dc_status {
    call(faces, |state| {
        let cliques = || state.interface.cliques();
        let (count, entries) = cliques().fold((0, 0), |(count, all), clique| (count + 1, all + clique.len()));
        index("entries", entries)?;
        let offsets = wanted("offsets", offsets, offset_capacity, count + 1)?;
        let nodes = wanted("nodes", nodes, node_capacity, entries)?;
        let clique_count = wanted("clique_count", clique_count, 1, 1)?;
        let entry_count = wanted("entry_count", entry_count, 1, 1)?;
        disjoint([offsets.span(), nodes.span(), clique_count.span(), entry_count.span()])?;
        let ends = cliques().scan(0, |end, clique| {
            *end += clique.len() as i32;
            Some(*end)
        });
        unsafe {
            offsets.write(std::iter::once(0).chain(ends));
            nodes.write(cliques().flatten().map(|&node| node as i32));
            clique_count.write([count]);
            entry_count.write([entries]);
        }
        Ok(())
    })
}
