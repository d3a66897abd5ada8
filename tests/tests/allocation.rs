//! The kernels for the gap do not allocate: one element by itself once its thread had a larger one, a batch once its
//! workspace has the size.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use diffuse_contact::{Basis, Mode};
use diffuse_contact_kernels::support::{BatchElement, FrameRule, GapValues, Isa, Workspace};
use diffuse_contact_tests::{Case, GAP_KERNELS, GapKernels, Kernel, instructions, output_sizes};

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

/// How often `run` allocates.
fn allocations(run: impl FnOnce()) -> usize {
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    run();
    ALLOCATIONS.load(Ordering::Relaxed) - before
}

fn of_single(set: &GapKernels, isa: Isa, kernel: Kernel, case: &Case) -> usize {
    let [mut gradient, mut hessian] = output_sizes(kernel.2, case).map(|size| vec![0.0; size]);
    let inputs = case.inputs();
    allocations(|| {
        set.run_single(isa, kernel, &inputs, &mut gradient, &mut hessian);
    })
}

fn of_batch(set: &GapKernels, isa: Isa, kernel: Kernel, case: &Case, workspace: &mut Workspace) -> usize {
    let mut room = vec![output_sizes(kernel.2, case).map(|size| vec![0.0; size]); isa.width() + 1];
    let inputs = case.inputs();
    let mut elements: Vec<BatchElement<'_>> = room
        .iter_mut()
        .map(|[gradient, hessian]| BatchElement {
            inputs,
            values: GapValues::NONE,
            gradient,
            hessian,
            places: &[],
        })
        .collect();
    allocations(|| set.run_batch(isa, kernel, &mut elements, workspace))
}

/// The only test of its program: others would be counted, too.
#[test]
fn kernels_do_not_allocate() {
    // That allocations are seen at all. The first element is the largest.
    let (cubic, isa) = (&GAP_KERNELS[0], instructions().last().unwrap());
    let full = (Basis::Quadratic, FrameRule::Held, Mode::Hessian);
    assert!(of_single(cubic, isa, full, &Case::random(100, Basis::Quadratic, 1)) > 0);
    // Number by number a batch takes the memory of single elements.
    let first = of_batch(cubic, isa, full, &Case::random(9, Basis::Quadratic, 1), &mut Workspace::default());
    assert!(first > 0 || isa == Isa::SCALAR);

    for isa in instructions() {
        // Its size is that of the first batch, which is the largest.
        let mut workspace = Workspace::default();
        // (Not all kernels are compiled for all vectors: of each weight one.)
        for set in &GAP_KERNELS {
            let kernel = (Basis::Quadratic, FrameRule::CoMoving, Mode::Hessian);
            of_batch(set, isa, kernel, &Case::random(24, Basis::Quadratic, 1).co_moving(), &mut workspace);
        }
        for set in &GAP_KERNELS {
            for basis in [Basis::Quadratic, Basis::Linear] {
                for n in basis.size()..=24 {
                    let case = Case::random(n, basis, n as u64).co_moving();
                    for frame in [FrameRule::Held, FrameRule::CoMoving] {
                        for mode in [Mode::Value, Mode::Gradient, Mode::Hessian] {
                            let kernel = (basis, frame, mode);
                            let single = of_single(set, isa, kernel, &case);
                            assert_eq!(single, 0, "{} {kernel:?} {isa}, {n} nodes", set.weight);
                            let batch = of_batch(set, isa, kernel, &case, &mut workspace);
                            assert_eq!(batch, 0, "{} {kernel:?} {isa}, {n} nodes", set.weight);
                        }
                    }
                }
            }
        }
    }
}
