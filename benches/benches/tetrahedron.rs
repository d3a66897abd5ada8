//! Times of a neo-Hooke tetrahedron, energy, gradient and Hessian: `cargo bench -p diffuse-contact-benches --bench tetrahedron`.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use diffuse_contact_benches::tetrahedron::{by_hand, elements, tet4};
use diffuse_contact_kernels::support::{Isa, Mode};
use tet4::{Results, batch, evaluate};

/// Different elements, which stay in the cache with their results.
const ELEMENTS: usize = 256;

fn tetrahedron(criterion: &mut Criterion) {
    let elements = elements(ELEMENTS);
    let mut results = vec![Results::ZERO; ELEMENTS];
    let mut group = criterion.benchmark_group("tet4-hessian");
    group.throughput(Throughput::Elements(ELEMENTS as u64));
    group.bench_function("by hand, nalgebra", |bencher| {
        bencher.iter(|| {
            for (element, result) in black_box(&elements).iter().zip(&mut results) {
                *result = by_hand(element);
            }
            black_box(&results);
        });
    });
    group.bench_function("generated, one by one", |bencher| {
        bencher.iter(|| {
            for (element, result) in black_box(&elements).iter().zip(&mut results) {
                *result = evaluate(Mode::Hessian, element);
            }
            black_box(&results);
        });
    });
    for isa in Isa::available() {
        group.bench_function(BenchmarkId::new("generated, batch", isa), |bencher| {
            bencher.iter(|| batch(isa, Mode::Hessian, black_box(&elements), black_box(&mut results)));
        });
    }
    group.finish();
}

criterion_group!(benches, tetrahedron);
criterion_main!(benches);
