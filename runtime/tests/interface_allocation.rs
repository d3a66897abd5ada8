//! Evaluation reuses its memory: after the first call nothing is allocated per element.

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use common::{Mesh, Scene, Uniform};
use diffuse_contact::interface::InterfaceOptions;
use diffuse_contact::{Mode, Point};

/// The system's allocator, counting.
struct Counting;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

// SAFETY: everything is passed on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
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

fn allocations(mut work: impl FnMut()) -> usize {
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    work();
    ALLOCATIONS.load(Ordering::Relaxed) - before
}

#[test]
fn a_second_evaluation_allocates_nothing_per_element() {
    let mesh = Mesh::grid([40, 40], [false; 2], |s, t| {
        let [x, y] = [10.0 * s, 10.0 * t];
        [x, y, (0.4 * x).sin() * (0.3 * y).cos()]
    });
    // Up to the border, so that its test runs, too.
    let mut random = Uniform(3);
    let slaves: Vec<Point> =
        (0..2000).map(|_| [10.0 * random.next(), 10.0 * random.next(), 0.4 * random.signed()]).collect();
    // One thread: the thread pool's own bookkeeping allocates now and then.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    for options in [InterfaceOptions::default(), InterfaceOptions::node_to_facet()] {
        pool.install(|| evaluate_twice(mesh.paired(&slaves, options)));
    }
}

fn evaluate_twice(mut scene: Scene) {
    for mode in [Mode::Hessian, Mode::Gradient, Mode::Value, Mode::Hessian] {
        scene.interface.evaluate(mode).unwrap();
        scene.update();
        let again = allocations(|| {
            let contacts = scene.interface.evaluate(mode).unwrap();
            assert_eq!(contacts.len(), 2000);
        });
        assert!(again <= 4, "{again} allocations for 2000 elements with {mode:?}");
        let chosen = allocations(|| {
            scene.interface.evaluate_where(mode, |_, gap, _| gap < 0.0).unwrap();
        });
        assert!(chosen <= 5, "{chosen} allocations for 2000 elements, half of them derived, with {mode:?}");
        let streamed = allocations(|| scene.interface.for_each(mode, |_| {}).unwrap());
        assert!(streamed <= 12, "{streamed} allocations for 2000 streamed elements with {mode:?}");
    }
    let contacts = scene.interface.evaluate(Mode::Value).unwrap();
    assert!(contacts.iter().filter(|contact| contact.outcome.is_contact()).count() > 1900);
    // Lists hold more nodes than are within reach; their derivatives are spread without memory of their own.
    assert!(contacts.iter().all(|contact| contact.nodes.len() <= 48));
}
