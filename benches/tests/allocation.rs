//! No contender for the gap allocates while it is timed. The surface's kernel takes memory for its nodes.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use diffuse_contact_benches::{CONTENDERS, Elements, Output};
use diffuse_contact_kernels::support::Isa;

/// The system's allocator, counting.
struct Counting;

thread_local! {
    /// Of this thread: the one that runs the test allocates when it pleases.
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: everything is passed on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // There is none where a thread ends.
        let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's promises are those of `System`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the pointer came from `System`.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn runs_do_not_allocate() {
    let elements = Elements::new(9, 4).unwrap();
    for contender in CONTENDERS.into_iter().filter(|contender| contender.output != Output::SurfaceHessian) {
        let mut run = (contender.prepare)(&elements, contender.output, Isa::best()).unwrap();
        // The first element of a thread makes room for those after it.
        run.run(1).unwrap();
        let before = ALLOCATIONS.get();
        run.run(6).unwrap();
        assert_eq!(ALLOCATIONS.get() - before, 0, "{contender:?}");
    }
}
