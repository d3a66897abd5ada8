//! The C library of the diffuse contact element.
//!
//! A thin layer over the crate `diffuse-contact`: pointers become slices, errors a status, panics stop here. It computes nothing. Its
//! documentation for users is the header `include/diffuse_contact.h`, which cbindgen makes of the doc comments in this
//! crate, and `docs/how-to/c.md`.
//!
//! ```c
//! dc_interface *interface;
//! dc_create(positions, nodes, facets, facet_count, slaves, slave_count, NULL, 0, NULL, &interface);
//! dc_refresh(interface, positions, nodes, NULL);      /* once an increment */
//! dc_follow(interface, positions, nodes, NULL);       /* each iteration */
//! dc_evaluate(interface, DC_HESSIAN);
//! dc_add_forces(interface, &law, force, equations, NULL);
//! ```
//!
//! | module | what it holds |
//! | --- | --- |
//! | `border` | pointers to slices, panics to a status: the unsafe code |
//! | `status`, `message`, `outcome` | what a call says |
//! | `registry` | which handles are live |
//! | `version` | version, vector instructions |
//! | `threads` | where evaluations run, also after a fork |
//! | `options`, `law` | structures the caller fills |
//! | `interface` | create and destroy, update, refresh, freeze, evaluate |
//! | `contacts` | results of an evaluation, the cut-back hint |
//! | `assembly`, `pattern`, `map`, `operator` | contact forces, triplets, compressed rows, the caller's matrix, products |
//! | `window`, `part`, `faces_window` | windows of a surface, the parts they are cut from, and what knows them only |
//! | `faces` | contact over the slave's faces, an object of its own |
//! | `element`, `batch`, `neighbours` | without interface: gap, force and stiffness, pairing |
//!
//! * **Ownership.** The library keeps copies of its input and fills arrays of the caller. No pointer into the library is handed out, except
//!   for texts, which are constant, and `dc_message`, which holds until the thread's next call.
//! * **Handles** are opaque ids passed as pointers and never dereferenced. They are numbers that no address has (bits 48 to 63), and that
//!   are not given out again. A handle that was destroyed, or is garbage, is `DC_BAD_HANDLE`.
//! * **Threads.** Calls without handle are free of shared state. A handle serves one thread at a time; a second one gets `DC_BUSY` at once.
//!   Evaluation is parallel inside. rayon's threads stay with the parent of a fork: another process gets a pool.
//! * **Panics** stop at the border (`catch_unwind`): `DC_INTERNAL`. An interface that was at work then can only be destroyed.
//! * **Growth.** Structures whose first field is `size` are given with `sizeof`. A caller compiled against an older header gets the
//!   defaults for the fields it does not know.
//! * **Results are of the last evaluation.** After a refresh or an update they are `DC_NOT_EVALUATED` until the next `dc_evaluate`.
//! * **Arrays of the caller** are checked first (NULL, alignment, size, no overlap with one that is written) and touched only when nothing
//!   more can be refused. `border::Target` is a place that has been checked and is neither read nor written yet.
//! * **Patterns** keep the equations they were made with, shared with the interface. A fill compares addresses, and numbers where they
//!   differ.
//! * **Safety.** An `unsafe` block without a comment rests on what the caller promises under `# Safety`.
//!
//! Tests: `src/tests` calls as C does: misuse, agreement with the runtime, and calls in no order with odd arguments
//! (`DC_FUZZ_SECONDS=600` goes on with new seeds). `tests/installed` installs and links the library as users do, and compares its numbers
//! with the runtime's bit for bit. `src/tests/fortran_module.rs` compares every declaration of the Fortran module with the header.
//!
//! The crate has no `rlib`: two libraries of one name would collide, and tests link what users link.
// The names are those of the C interface.
#![allow(non_camel_case_types)]

mod assembly;
mod batch;
mod border;
mod choice;
mod contacts;
mod element;
mod faces;
mod faces_assembly;
mod faces_friction;
mod faces_points;
mod faces_window;
mod feet;
mod friction;
mod interface;
mod law;
mod map;
mod mesh;
mod message;
mod neighbours;
mod operator;
mod options;
mod outcome;
mod part;
mod pattern;
mod registry;
mod status;
mod threads;
mod version;
mod window;

#[cfg(test)]
mod tests;
