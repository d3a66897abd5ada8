//! Once the buffers have their size, assembly does not allocate: counted by the allocator of this program, which holds
//! this one test.

mod assembly_cases;
mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use assembly_cases::Case;
use diffuse_contact::assembly::{ContactLaw, CsrPattern, DofMap, Triangle, Triplets, add_forces};

/// The system's allocator, with a count of its calls from all threads.
struct Counting;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

#[global_allocator]
static ALLOCATOR: Counting = Counting;

// SAFETY: every call is passed on unchanged to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        unsafe { System.realloc(pointer, layout, size) }
    }
}

/// Allocations during `work`.
fn count(work: impl FnOnce()) -> usize {
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    work();
    ALLOCATIONS.load(Ordering::Relaxed) - before
}

#[test]
fn assembly_allocates_nothing_after_the_first_time() {
    let case = Case::random(2000, 3000, 10, 1);
    let views = case.views();
    let elements = views.as_slice();
    let dofs = DofMap::standard(case.nodes);
    let law = ContactLaw::penalty(10.0);
    let mut residual = vec![0.0; dofs.equations()];
    let mut triplets = Triplets::new();
    let pattern = CsrPattern::union(elements, &dofs).unwrap();
    let mut values = vec![0.0; pattern.entries()];
    let mut active = 0;
    let mut assemble = || {
        active = add_forces(elements, &law, &dofs, &mut residual).unwrap();
        assert_eq!(triplets.fill(elements, &law, &dofs, Triangle::Full), Ok(active));
        active
    };
    let first = count(|| assert!(assemble() > 1000));
    assert!(first > 0, "the triplets need room");
    assert_eq!(count(|| assert!(assemble() > 1000)), 0);

    let fill = |values: &mut [f64]| assert_eq!(pattern.fill(elements, &law, values), Ok(active));
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build().unwrap();
    one_thread.install(|| {
        fill(&mut values);
        assert_eq!(count(|| fill(&mut values)), 0);
    });
    // Where threads share the work, the thread pool may allocate a block of its queue now and then, however many
    // elements there are.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    pool.install(|| fill(&mut values));
    let shared = count(|| (0..10).for_each(|_| pool.install(|| fill(&mut values))));
    assert!(shared <= 10, "{shared} allocations in ten assemblies of {} elements", views.len());
}
